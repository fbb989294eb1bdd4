"""One target that is verified, and the joints that are told together."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

from actspec.diagnostics import ActspecError
from actspec.ir import ActuatorSet, JointActuator, Quantity
from actspec.targets.base import Approximation, TargetOptions


class VerifyError(ActspecError):
    """A verification cannot start: a file is missing, or an engine cannot be had."""


@dataclass(frozen=True, slots=True)
class Target:
    """A target's files, those that are verified and those that actspec writes today.

    Attributes:
        options: Which target.
        folder: Where the files lie that are verified.
        fresh: Where what actspec writes lies; the same unless another folder was named.
        files: Their paths below either, the main one first.
        losses: What the target is known to lose.
    """

    options: TargetOptions
    folder: str
    fresh: str
    files: tuple[str, ...]
    losses: tuple[Approximation, ...]

    @property
    def name(self) -> str:
        """Its name in the spec."""
        return self.options.name

    def path(self, file: str) -> str:
        """Where a file lies that is verified."""
        return os.path.join(self.folder, file)

    def losses_of(self, joint: str, fields: Sequence[str]) -> tuple[Approximation, ...]:
        """What it loses of fields of a joint, by the names of `Approximation.field`."""
        return tuple(loss for loss in self.losses if loss.joint in (joint, "") and loss.field in fields)


def alike(actuators: ActuatorSet) -> tuple[tuple[JointActuator, ...], ...]:
    """The joints of each group that have the same numbers, in the robot's order; their pose may differ."""
    found: dict[object, list[JointActuator]] = {}
    for actuator in actuators.joints:
        found.setdefault(_numbers(actuator), []).append(actuator)
    return tuple(tuple(members) for members in found.values())


def _numbers(actuator: JointActuator) -> object:
    def value(quantity: Quantity) -> float | None:
        return quantity.value

    delay = actuator.delay
    return (
        actuator.group,
        actuator.kind,
        actuator.level,
        actuator.command,
        tuple((name, value(q)) for name, q in actuator.quantities() if name != "default_position"),
        None if delay is None else (delay.low, delay.high, delay.sampling),
        actuator.network,
    )
