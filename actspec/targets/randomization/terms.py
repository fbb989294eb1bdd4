"""An event term, as Isaac Lab and mjlab both have them, and names for terms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from actspec.patterns import match_names
from actspec.targets.kit.python_text import comment_lines, identifier, joint_patterns
from actspec.targets.randomization.draws import Draw


@dataclass(frozen=True, slots=True)
class EventTerm:
    """One event term.

    Attributes:
        name: Attribute or key; an identifier.
        func: Function, as the text calls it.
        mode: `startup`, `reset` or `interval`.
        every: Interval [s].
        joints: Patterns of its joints; None: it takes no names.
        actuators: Indices of actuator groups (mjlab); None: all, or by joints.
        params: The other parameters, name and value.
        comments: Lines above it, `#` included.
    """

    name: str
    func: str
    mode: str
    every: tuple[float, float] | None
    joints: tuple[str, ...] | None
    actuators: tuple[int, ...] | None
    params: tuple[tuple[str, Any], ...]
    comments: tuple[str, ...] = ()


@dataclass(slots=True)
class Namer:
    """Gives out identifiers, each once."""

    taken: set[str] = field(default_factory=set)

    def name(self, draws: Sequence[Draw], what: str) -> str:
        """`legs_<what>` for one group, `<what>` for joints of several."""
        groups = dict.fromkeys(draw.actuator.group for draw in draws)
        found = f"{identifier(next(iter(groups)), fallback='group')}_{what}" if len(groups) == 1 else what
        found = found.lower()
        count, name = 1, found
        while name in self.taken:
            count += 1
            name = f"{found}_{count}"
        self.taken.add(name)
        return name


def patterns_of(draws: Sequence[Draw], names: Sequence[str]) -> tuple[str, ...]:
    """Patterns of the draws' joints; one for all where they are all of the robot's."""
    if {draw.actuator.joint for draw in draws} == set(names) == set(match_names(".*", names)):
        return (".*",)
    return joint_patterns([draw.actuator for draw in draws], names)


def comments(*texts: str, indent: str) -> tuple[str, ...]:
    """Comment lines of several remarks."""
    return tuple(line for text in texts if text for line in comment_lines(text, indent=indent))
