"""What the stacks of randomisation share: their draws, an event term, and the file of one stack."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from actspec.diagnostics import Collector
from actspec.ir import ActuatorSet, JointKind
from actspec.patterns import match_names
from actspec.robot.view import RobotView
from actspec.simulators import DEFAULT_VERSIONS
from actspec.targets.base import EmittedFile, TargetOptions
from actspec.targets.kit.draws import Draw, Losses, draws_of
from actspec.targets.kit.provenance import loss_lines, written_by
from actspec.targets.kit.python_text import (
    WIDTH,
    comment_lines,
    environment,
    free_name,
    identifier,
    joint_patterns,
    section_lines,
)


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
        draws: Joint to field to its draw.
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
        self.draws = {actuator.joint: draws_of(actuator) for actuator in actuators.joints}
        self._taken: set[str] = set()

    def each(self, field: str) -> Iterator[Draw]:
        """The draws of one field, joint by joint."""
        return (of_joint[field] for of_joint in self.draws.values() if field in of_joint)

    def drop(self, reasons: Mapping[str, str]) -> None:
        """Report the draws of fields that the stack cannot hold; field to why."""
        for field, why in reasons.items():
            for draw in self.each(field):
                self.losses.dropped(draw, why)

    def patterns(self, draws: Sequence[Draw]) -> tuple[str, ...]:
        """Patterns of the draws' joints; one for all where they are all of the robot's."""
        names = self.names
        if {draw.actuator.joint for draw in draws} == set(names) == set(match_names(".*", names)):
            return (".*",)
        return joint_patterns([draw.actuator for draw in draws], names)

    def term(
        self,
        what: str,
        func: str,
        draws: Sequence[Draw],
        params: Iterable[tuple[str, Any]],
        *,
        joints: tuple[str, ...] | None = None,
        actuators: tuple[int, ...] | None = None,
        comments: Sequence[str] = (),
    ) -> EventTerm:
        """A term for draws of the same numbers, named `legs_<what>` for one group, `<what>` for joints of several.

        Args: as the attributes of `EventTerm`.
        """
        groups = dict.fromkeys(draw.actuator.group for draw in draws)
        stem = f"{identifier(next(iter(groups)), fallback='group')}_{what}" if len(groups) == 1 else what
        name = free_name(stem.lower(), self._taken)
        self._taken.add(name)
        first = draws[0]
        return EventTerm(
            name, func, first.when, first.every, joints, actuators, tuple(params), tuple(comments)
        )

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
        # In a stack's own file its name is not said again.
        own = (replace(loss, field=loss.field.partition(".")[2]) for loss in self.losses.items)
        said = list(loss_lines(own, all_joints=len(self.actuators.joints)))
        if said:
            below = [("What it cannot do:", said)]
            header += section_lines(below, bullet="- ", hang="  ", width=width)
        text = environment("randomization").get_template(template).render(header=header, **values)
        return EmittedFile(f"{self.stem}_{name}", text.encode("utf-8"))
