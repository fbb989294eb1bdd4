"""What lifting gives: the actuators that a file describes, and what a spec has no word for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from actspec.diagnostics import Span
from actspec.ir import ActuatorSet


@dataclass(frozen=True, slots=True)
class LeftAlone:
    """A joint that no spec could describe as the file has it.

    Attributes:
        joint: Its name; a pattern where a configuration names no joint and no robot file is beside it.
        why: The reason.
        span: Where the joint or its actuator is written.
        undriven: Whether all that it lacks is a drive, which another file may have.
        kind: The reason without the names in it, for joints that each follow another one; "" for the same words.
    """

    joint: str
    why: str
    span: Span | None = None
    undriven: bool = False
    kind: str = ""


@dataclass(frozen=True, slots=True)
class Lifted:
    """The actuators of one robot as one file has them.

    Every stated number is of origin `model`, with its place and the file as `source`. What an engine puts
    where the file is silent is of origin `default`, and says so in `note`; anything else is unknown.
    `group` is the name of the actuator or of the cfg's group, "" for a bare joint; `pattern` is the
    configuration's own, else the joint's name, escaped.

    Attributes:
        actuators: One entry a joint that a spec can describe, in the robot's order.
        left_alone: Hinges and slides that are not in `actuators`.
        notes: Joint to remarks: what of the file a spec cannot hold or says otherwise (a gear that goes, a limit
            that is not symmetric). Key "": remarks on the whole file.
    """

    actuators: ActuatorSet
    left_alone: tuple[LeftAlone, ...] = ()
    notes: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
