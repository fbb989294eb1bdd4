"""Of two files that state different figures of one joint, which one is wrong."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from actspec.audit.case import Case
from actspec.audit.causes import PUBLISHED
from actspec.audit.known import KnownRobot, likenesses, same
from actspec.audit.rules.joints import SLOW, acceleration, limit_of, partner_rows, top_speed
from actspec.diagnostics import Span
from actspec.ir import tidy
from actspec.readings.artifact import FileKind, Robot
from actspec.readings.compare import Figure, times
from actspec.readings.ledger import LedgerRow

SAME = 0.01
"""Chosen: figures of two motors that agree so far are one, as `tolerance` of the rules."""

GRAVE = 2.0
"""From here a limit that differs is an error. Chosen: revisions and safety margins of one motor stay below."""

_FAST = 1e6
"""Largest acceleration that a motor gives its rotor [rad/s^2]. Chosen: those without iron and gear reach a tenth."""

POSE = 0.01
"""Chosen: rad or m up to which two default positions are one, half a degree."""

_PUBLISHED = ("effort_limit", "velocity_limit", "no_load_speed", "armature")
"""Figures of which the table of known robots has what is published."""


@dataclass(frozen=True, slots=True)
class Disagreement:
    """One figure of one joint in two files.

    Attributes:
        rows: The joint's rows in the file that departs.
        others: In the file that it is held to.
        field: Name of the figure in `rows`.
        other_field: In `others`: a speed limit may stand beside a no-load speed.
        mine: The figure that departs.
        theirs: The other.
        variant: Whether the files describe variants: of the same kind, or with other joints.
        one_machine: Whether links and ranges speak of one machine, or do not speak.
        published: The known robot whose figure the other file has; "" where no such robot tells who is right.
        both_published: Whether both figures are published.
        beyond_published: Whether the figure that departs is a limit above all that is published, and the other is not.
        copy: Whether an earlier file departs in the same way.
        also: The same beside the other files that have the other figure, where this one is the odd one of them all.
        more: Where the other figure is written, too.
    """

    rows: Sequence[LedgerRow]
    others: Sequence[LedgerRow]
    field: str
    other_field: str
    mine: Figure
    theirs: Figure
    variant: bool
    one_machine: bool
    published: str = ""
    both_published: bool = False
    beyond_published: bool = False
    copy: bool = False
    also: tuple[Disagreement, ...] = ()
    more: tuple[Span, ...] = ()

    @property
    def ratio(self) -> float | None:
        """How many times the other figure; None beside 0."""
        if not self.mine.value or not self.theirs.value:
            return None
        return self.mine.value / self.theirs.value

    @property
    def times(self) -> str:
        """The ratio for a message: ` (x0.517)`, or nothing."""
        return times(self.mine.value, self.theirs.value)

    @property
    def turned(self) -> Disagreement:
        """The same, with the other file as the one that departs."""
        return replace(
            self,
            rows=self.others,
            others=self.rows,
            field=self.other_field,
            other_field=self.field,
            mine=self.theirs,
            theirs=self.mine,
        )


def is_of_spec(case: Case, robot: Robot, found: Disagreement) -> bool:
    """Whether a spec has the figure of one of the files, and another than the other one's: SPC101 tells that."""
    joint = found.rows[0].joint
    specs = (
        row
        for index in robot.artifacts
        if case.artifacts[index].kind is FileKind.SPEC
        for row in case.joints.get((index, joint), ())
        if {found.field, found.other_field} <= row.stated
    )
    return any(
        _is_near(found.mine, getattr(row, found.field))
        is not _is_near(found.theirs, getattr(row, found.other_field))
        for row in specs
    )


def _is_near(figure: Figure, value: float | None) -> bool:
    """Whether a figure is one that a spec has."""
    return figure.value is not None and value is not None and math.isclose(figure.value, value, rel_tol=SAME)


def by_what_is_published(case: Case, found: Disagreement) -> Disagreement:
    """Turned where the departing file has the figure that is published of the robot, and the other one has not; or
    where the other one's limit is above all that is published, which KNW101 tells of it.
    """
    fields = found.field, found.other_field
    if not set(fields) <= set(_PUBLISHED) or found.other_field not in found.others[0].stated:
        return found
    sides = found.rows[0], found.others[0]
    told = {
        (
            known.robot.name,
            _published_of(known.robot, name, fields[0]),
            _published_of(known.robot, name, fields[1]),
        )
        for known in case.once(likenesses)
        for row, names in known.joints
        for mine, field in zip(sides, fields, strict=True)
        # A task's configuration has the name of its task, and its robot's figures where the robot has them.
        if row.joint == mine.joint and (known.index == mine.artifact or row.place(field) == mine.place(field))
        for name in names
    }
    # The same for all joints that the row may be: else nobody is right or wrong by it.
    if len(told) != 1:
        return found
    ((robot, own, other),) = told
    here, there = _is_one_of(found.mine.value, own.figures), _is_one_of(found.theirs.value, other.figures)
    if here and there:
        return replace(found, both_published=True)
    above = own.is_below(found.mine.value), other.is_below(found.theirs.value)
    if above[0] is not above[1]:
        wrong, right = (found, other) if above[0] else (found.turned, own)
        # Of several motors the one that the other file has may be another variant's than this one's.
        sure = (here or there) and right.is_one_motor
        return replace(wrong, published=robot if sure else "", beyond_published=True)
    if here is there or own.of_others:
        return found
    wrong, right = (found.turned, own) if here else (found, other)
    larger = (wrong.mine.value or 0.0) > (wrong.theirs.value or 0.0)
    if right.is_one_motor and (larger or not right.is_top):
        return replace(wrong, published=robot)
    # A limit or speed may be that of a variant that is not known; an armature that is published is no departure.
    return wrong if found.field == "armature" else found


def by_sense(case: Case, found: Disagreement) -> Disagreement | None:
    """Turned where only the other file's figure is one that the joint cannot have; None: that tells nobody.

    Only in files that are named: what is found in folders is as it was judged (docs/survey.md).
    """
    is_absurd = _ABSURD.get(found.field)
    if is_absurd is None or is_met(case, found):
        return None
    mine, theirs = (
        is_absurd(case, rows[0], side.value or 0.0)
        for rows, side in ((found.rows, found.mine), (found.others, found.theirs))
    )
    if mine == theirs:
        return None
    return found if mine else found.turned


def _is_out_of_range(case: Case, row: LedgerRow, position: float) -> bool:
    ranges = {
        one.position_range
        for index in case.robot_of(row.artifact).artifacts
        for one in case.joints.get((index, row.joint), ())
        if one.position_range is not None
    }
    return bool(ranges) and all(not low - POSE <= position <= high + POSE for low, high in ranges)


def _is_no_rotor(case: Case, row: LedgerRow, armature: float) -> bool:
    """Whether a hinge's armature is so large that its torque turns nothing, or so small that no motor has it."""
    found = acceleration(row, limit_of(case, row), armature)
    # 20 N*m turn 4 kg*m^2 with 5 rad/s^2, as 0.7 do 0.14, whose quotient is a rounding less.
    return found is not None and not SLOW < tidy(found) <= _FAST


def _stops(case: Case, row: LedgerRow, damping: float) -> bool:
    """Whether the damping alone takes the joint's whole torque or force before its top speed."""
    limit = limit_of(case, row)
    speeds = [speed for one in (row, *partner_rows(case, row)) if (speed := top_speed(one)) is not None]
    return limit is not None and bool(speeds) and damping * min(speeds) >= limit


def _holds(case: Case, row: LedgerRow, friction: float) -> bool:
    """Whether dry friction takes the joint's whole torque or force."""
    limit = limit_of(case, row)
    return limit is not None and friction >= limit


_ABSURD: Mapping[str, Callable[[Case, LedgerRow, float], bool]] = {
    "default_position": _is_out_of_range,
    "armature": _is_no_rotor,
    "joint_damping": _stops,
    "frictionloss": _holds,
}
"""Figures of which one that the joint cannot have tells who is wrong."""


def by_kinds(
    case: Case, found: Disagreement, stated: Mapping[str, Mapping[FileKind, set[float]]]
) -> Disagreement:
    """Turned where files of more kinds have the figure of the departing one than the other's; or where no
    kind has either, but more are near it: of 52, 60 and 520 the last is the odd one.

    Files of one kind are not counted: copies of a URDF are as old as the first.
    """
    kinds = stated.get(found.rows[0].joint, {}).values()

    def count(near: Callable[[float, float], bool]) -> tuple[int, int]:
        mine, theirs = (
            sum(any(near(each, side.value or 0.0) for each in values) for values in kinds)
            for side in (found.mine, found.theirs)
        )
        return mine, theirs

    mine, theirs = count(lambda one, other: math.isclose(one, other, rel_tol=SAME))
    if mine != theirs:
        return found.turned if mine > theirs else found
    if found.ratio is None:
        # Nothing is near 0.
        return found
    mine, theirs = count(
        lambda one, other: one * other > 0.0 and max(abs(one), abs(other)) < GRAVE * min(abs(one), abs(other))
    )
    return found.turned if mine > theirs else found


@dataclass(frozen=True, slots=True)
class _Published:
    """What is published of a figure of one joint, of all variants of the robot.

    Attributes:
        figures: All of it: the figure may be all that tells variants apart.
        first: Without what is stated elsewhere than of this motor.
        is_top: Whether it is a speed that no source exceeds, beside which a lower one may be chosen.
        is_limit: Whether it is an effort limit.
        of_others: Whether it is an effort limit of others than the maker: that one above it is wrong is all that tells.
    """

    figures: frozenset[float]
    first: frozenset[float]
    is_top: bool = False
    is_limit: bool = False
    of_others: bool = False

    @property
    def is_one_motor(self) -> bool:
        """Whether all variants have one motor: else another figure may be of a variant that is not known."""
        return len(self.first) == 1

    def is_below(self, value: float | None) -> bool:
        """Whether all that is published is well below an effort limit."""
        return self.is_limit and (value or 0.0) >= PUBLISHED * max(self.figures, default=math.inf)


def _published_of(robot: KnownRobot, name: str, field: str) -> _Published:
    """Torques and speeds are the maker's; where it states no limit of speed, the largest that any source gives."""
    joints = [variant[name] for variant in robot.variants.values()]
    by_maker = [joint for joint in joints if joint.maker]
    if field == "effort_limit":
        efforts = frozenset(joint.effort for joint in by_maker or joints)
        figures = efforts.union(*(joint.also for joint in joints))
        return _Published(figures, efforts, is_limit=True, of_others=not by_maker)
    if field == "armature":
        armatures = _stated(joint.armature for joint in joints)
        return _Published(armatures | frozenset(robot.armatures), armatures)
    limits = _stated(joint.velocity for joint in by_maker)
    tops = _stated(joint.top_speed for joint in by_maker)
    if limits:
        return _Published(limits, limits)
    # Who has a smaller one has it of another source.
    return _Published(tops.union(*(joint.slower for joint in by_maker)), tops, is_top=True)


def _stated(figures: Iterable[float | None]) -> frozenset[float]:
    return frozenset(figure for figure in figures if figure is not None)


def _is_one_of(value: float | None, figures: frozenset[float]) -> bool:
    return any(same(value, figure) for figure in figures)


def is_met(case: Case, found: Disagreement) -> bool:
    """Whether one of the two files was met in a folder."""
    return any(case.is_met(rows[0].artifact) for rows in (found.rows, found.others))
