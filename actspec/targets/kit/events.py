"""What the stacks of randomisation share: an event term, names for terms, and the file of one stack."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from actspec.diagnostics import Collector
from actspec.ir import ActuatorSet, Approximation, JointKind
from actspec.patterns import match_names
from actspec.robot.view import RobotView
from actspec.simulators import DEFAULT_VERSIONS
from actspec.targets.base import EmittedFile, TargetOptions
from actspec.targets.kit.draw_losses import Losses
from actspec.targets.kit.draws import Draw
from actspec.targets.kit.provenance import written_by
from actspec.targets.kit.python_text import (
    WIDTH,
    comment_lines,
    environment,
    grouped,
    identifier,
    joint_patterns,
    section_lines,
)
from actspec.units import format_quantity


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


class StackWriter:
    """What the file of one stack is made from.

    Attributes:
        actuators: What is drawn.
        robot: The robot.
        options: The target.
        collector: Takes errors.
        losses: Takes what the stack cannot do.
        stem: First part of the file's name.
        names: All that a simulator matches a pattern against: followers and balls too, a floating base not.
    """

    def __init__(
        self,
        stack: str,
        actuators: ActuatorSet,
        robot: RobotView,
        options: TargetOptions,
        collector: Collector,
    ) -> None:
        self.actuators = actuators
        self.robot = robot
        self.options = options
        self.collector = collector
        self.losses = Losses(options.name, stack)
        self.stem = identifier(actuators.robot)
        self.names = tuple(joint.name for joint in robot.joints if joint.kind is not JointKind.FREE)

    def version(self, simulator: str) -> str:
        """The version that is asked for, else the simulator's default."""
        return self.options.version or DEFAULT_VERSIONS[simulator]

    def file(
        self, template: str, name: str, title: str, notes: Iterable[str], *, width: int = WIDTH, **values: Any
    ) -> EmittedFile:
        """The file of a template in `templates/randomization`, under its head.

        Args:
            template: Its name.
            name: Name of the file, behind the robot's.
            title: What it is for.
            notes: More lines of the head; an empty one is left out.
            width: Columns.
            values: Of the template.
        """
        lines = [
            written_by(f" for {title}"),
            *self.actuators.spec_lines,
            *(note for note in notes if note),
        ]
        header = [line for text in lines for line in comment_lines(text, hang="  ", width=width)]
        said = _losses(self.losses.items, len(self.actuators.joints))
        if said:
            below = [("What it cannot do:", said)]
            header += section_lines(below, bullet="- ", hang="  ", width=width)
        text = environment("randomization").get_template(template).render(header=header, **values)
        return EmittedFile(f"{self.stem}_{name}", text.encode("utf-8"))


def _losses(items: list[Approximation], joints: int) -> list[str]:
    """One line for the joints that lose the same."""
    found = []
    for _, members in grouped(
        items, lambda x: (x.field, x.asked, x.emitted, x.why, x.max_torque_error, x.unit)
    ):
        first = members[0]
        error = first.max_torque_error
        size = "" if error is None else f", at most {format_quantity(error, first.unit)}"
        field = first.field.partition(".")[2]
        who = "" if len(members) == joints else ": " + ", ".join(member.joint for member in members)
        found.append(f"{field}: {first.asked} -> {first.emitted}{size} ({first.why}){who}")
    return found
