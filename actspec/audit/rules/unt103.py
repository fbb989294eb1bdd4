from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.joints import SPEEDS, joint_pairs, shared_joints, shown, unit
from actspec.audit.rules.source_blame import SAME
from actspec.audit.rules.unt101 import ranges_told, read_as_degrees
from actspec.diagnostics import Span
from actspec.ir import JointKind
from actspec.readings.artifact import Artifact
from actspec.readings.compare import DEGREES
from actspec.readings.ledger import LedgerRow

_ONE_FILE = "no two files of one robot with the same joint"


class Factor57(RuleInParts):
    code = "UNT103"
    name = "off-by-degrees-per-radian"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    noted_in_folders = True
    paired = True
    needs = _ONE_FILE
    options: ClassVar[dict[str, float]] = {"relative": 0.005}

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        if next(shared_joints(case), None) is not None:
            yield self._compared(case)

    def _compared(self, case: Case) -> Iterator[Finding]:
        relative = self.option(case, "relative")
        ranges: dict[tuple[int, int], list[Finding]] = {}
        found_at: set[tuple[Span, str, str]] = set()

        for sides in _departures(case, relative):
            severity = Severity.ERROR if len({pair.place for _, _, pair, _ in sides}) > 1 else self.severity
            for wrong, right, pair, is_known in sides:
                found = self._finding(wrong, right, pair, severity, is_known)
                at = (found.span, found.joint, pair.place)
                if pair.place == "position_range":
                    ranges.setdefault((wrong.artifact, right.artifact), []).append(found)
                elif at not in found_at:
                    # One figure may differ from those of several files.
                    found_at.add(at)
                    yield found
        locked, told = case.once(read_as_degrees), case.once(ranges_told)
        for (index, reference), several in ranges.items():
            # UNT101 has the file already, whose angle is one; and a part has it from what includes it.
            if index in locked or any(told.intersection((one.span, *one.related)) for one in several):
                continue
            if case.artifacts[index].is_part or case.has_angle_of_another(index):
                continue
            # Where most ranges differ by something else, a few meet the factor by chance.
            if 2 * len({one.joint for one in several}) >= _ranges_that_differ(case, index, reference):
                yield from self._of_files(several)

    def _of_files(self, found: list[Finding]) -> Iterator[Finding]:
        """Ranges of many joints are one finding: it is the file's angle that is wrong."""
        # Both ends of a range are one figure.
        joints = {one.joint: one for one in reversed(found)}
        first = found[0]
        if len(joints) < _MANY:
            # One or two ends that somebody chose are 57.3 times another file's by chance; beyond a turn they are not.
            yield from (
                one
                if abs(one.value or 0.0) > _TURN
                else replace(one, severity=Severity.INFO, confidence=Confidence.LOW)
                for one in reversed(joints.values())
            )
            return
        yield replace(
            first,
            message=f"{first.joint} and {len(joints) - 1} more joints: {first.message}",
            joint="",
            joints=tuple(joints),
            help="check <compiler angle> of both files",
        )

    def _finding(
        self, one: LedgerRow, other: LedgerRow, pair: _Pair, severity: Severity, is_known: bool
    ) -> Finding:
        first, second = pair.values
        smaller = abs(first) < abs(second)
        factor = "1/57.3 of" if smaller else "57.3 times"
        what = "radians, taken for degrees" if smaller else "a figure in degrees, taken for radians"
        if pair.place in _PER_ANGLE:
            what = (
                "a figure per degree, taken per radian"
                if smaller
                else "a figure per radian, taken per degree"
            )
        if not is_known:
            what = "one of the two is wrong, by the degrees of a radian"
        return Finding(
            self.code,
            f"the {pair.name} of {shown(one, pair.unit, first, 4)} is {factor} the "
            f"{shown(one, pair.unit, second, 4)} in {other.place(pair.its_place).path}: {what}",
            one.place(pair.place),
            one.joint,
            first,
            unit(one, pair.unit),
            second if is_known else None,
            "1 rad is 57.3 degrees: convert the figure, or correct the other file",
            (other.place(pair.its_place),),
            severity=severity,
            # An end of a range is no figure of the joint by itself.
            fields=() if pair.place == "position_range" else (pair.place,),
        )


@dataclass(frozen=True, slots=True)
class _Pair:
    """A figure of one joint in two files.

    Attributes:
        place: Field of the one row that tells where it is written.
        its_place: The same of the other row: the end of a torque-speed line is a speed limit too.
        unit: Field of the row that has its unit.
        name: For messages.
        values: In the one file and in the other.
    """

    place: str
    its_place: str
    unit: str
    name: str
    values: tuple[float, float]

    @property
    def turned(self) -> _Pair:
        """The same, with the other row first."""
        return replace(
            self, place=self.its_place, its_place=self.place, values=(self.values[1], self.values[0])
        )


_MANY = 3

_TURN = 2.0 * math.pi * 1.01
"""Chosen: an end of a range beyond a full turn, as files round it, is in degrees; where both are below, it is the
smaller that is wrong."""

_PER_ANGLE = ("kp", "kd", "joint_damping")

_SLOWEST = 0.3
"""[rad/s]. Chosen: half of the slowest that is published (0.63, a Jaco's wrist)."""

_ALIKE = 10.0
"""Within this factor of a figure all others of its file must be, so that it is one of them. Chosen: above the spread
of one robot's motors, and far below 57.3."""

_OTHERS = 2
"""Other joints of a file from which it speaks. Chosen: one may be the wrong one."""


_Sides = tuple[LedgerRow, LedgerRow, "_Pair", bool]
"""Two rows of a joint, first the one whose figure deviates, the pair in that order, and whether that is known."""


def _departures(case: Case, relative: float) -> Iterator[list[_Sides]]:
    """For each joint of two files, the figures that differ by the degrees of a radian.

    A pose is in one unit: of three joints or more that tell it, the others of the two files, which may be rounded to
    less, as 0.1 rad to 5.7 degrees, are taken the same way.
    """

    def off_pairs(one: LedgerRow, other: LedgerRow) -> list[_Pair]:
        if JointKind.SLIDE in (one.kind, other.kind):
            return []
        return [pair for pair in _angular(one, other) if is_exact(pair) or _is_rounded_pose(pair)]

    def is_exact(pair: _Pair) -> bool:
        return _off_by(*pair.values, DEGREES, relative)

    joints = [
        [_sides(case, one, other, pair) for pair in off_pairs(one, other)]
        for one, other in joint_pairs(case, _figures, lambda one, other: bool(off_pairs(one, other)))
    ]
    known: dict[frozenset[int], Counter[int]] = {}
    for wrong, right, pair, is_known in (sides for joint in joints for sides in joint):
        if is_known and pair.place == "default_position" and is_exact(pair):
            known.setdefault(frozenset((wrong.artifact, right.artifact)), Counter())[wrong.artifact] += 1
    for joint in joints:
        told = []
        for wrong, right, pair, is_known in joint:
            of_pose = known.get(frozenset((wrong.artifact, right.artifact)), Counter())
            if pair.place == "default_position" and len(of_pose) == 1 and sum(of_pose.values()) >= _MANY:
                if wrong.artifact not in of_pose:
                    wrong, right, pair = right, wrong, pair.turned
                is_known = True
            elif not is_exact(pair):
                continue
            told.append((wrong, right, pair, is_known))
        if told:
            yield told


def _sides(case: Case, one: LedgerRow, other: LedgerRow, pair: _Pair) -> _Sides:
    """The two rows, first the one whose figure deviates, and whether that is known.

    What joints, motors and gains are decides; then the other joints of each file; then how many kinds of file have
    either figure. Where nothing does, the first is the one that fewer files agree with.
    """
    second_first = other, one, pair.turned
    for doubts in (
        (_is_unlikely(one, pair, 0), _is_unlikely(other, pair, 1)),
        (_stands_out(case, one, pair.place), _stands_out(case, other, pair.its_place)),
        _is_outnumbered(case, one, pair, lambda artifact: artifact.kind),
    ):
        if doubts[0] != doubts[1]:
            return (one, other, pair, True) if doubts[0] else (*second_first, True)
    if _is_outnumbered(case, one, pair, lambda artifact: artifact.path)[1]:
        return *second_first, False
    return one, other, pair, False


def _is_unlikely(row: LedgerRow, pair: _Pair, side: int) -> bool:
    """Whether a figure is none of a joint, by itself or by what its file has beside it.

    Of ranges one always is: beyond a full turn the larger, else the smaller.
    """
    # The models of a spec take time to build, and few files differ so.
    from actspec.spec.plausible.driven import FASTEST_OUTPUT
    from actspec.spec.plausible.gains import USUAL_ERROR, USUAL_RETURN

    mine, its = abs(pair.values[side]), abs(pair.values[1 - side])
    if pair.place == "position_range":
        return (mine < its) == (max(mine, its) <= _TURN)
    if pair.place == "default_position":
        return mine > _TURN
    if pair.place in SPEEDS:
        return not _SLOWEST <= mine <= FASTEST_OUTPUT
    if pair.place == "joint_damping" or not row.kp:
        return False
    kd = row.kd if "kd" in row.stated else None
    effort = row.effort_limit if "effort_limit" in row.stated else None
    lag = pair.place == "kd" or bool(kd)
    if lag and not USUAL_RETURN[0] <= (kd or 0.0) / row.kp <= USUAL_RETURN[1]:
        return True
    return (
        pair.place == "kp"
        and bool(effort)
        and not USUAL_ERROR[0] <= (effort or 0.0) / row.kp <= USUAL_ERROR[1]
    )


def _stands_out(case: Case, row: LedgerRow, field: str) -> bool:
    """Whether no other joint of the file has a figure near this one, and the others are near each other."""

    def figure_of(one: LedgerRow) -> float | None:
        value = getattr(one, field) if field in one.stated else None
        # A kd is by its kp.
        return value / one.kp if field == "kd" and value and one.kp else value

    if field in ("default_position", "position_range"):
        return False
    mine = figure_of(row)
    rows = (rows[0] for rows in case.joints_by_artifact.get(row.artifact, {}).values())
    others = [value for one in rows if one.joint != row.joint and (value := figure_of(one)) and value > 0.0]
    if not mine or len(others) < _OTHERS:
        return False
    near = max(others) <= _ALIKE * min(others)
    return near and not min(others) / _ALIKE <= mine <= max(others) * _ALIKE


def _is_outnumbered(
    case: Case, row: LedgerRow, pair: _Pair, of: Callable[[Artifact], object]
) -> tuple[bool, bool]:
    """Whether fewer files of the robot, counted by `of`, have the one figure, and whether fewer have the other."""
    have: tuple[set[object], set[object]] = (set(), set())
    for index in case.robot_of(row.artifact).artifacts:
        for found in case.joints.get((index, row.joint), ())[:1]:
            values = [getattr(found, name) for name in {pair.place, pair.its_place}]
            for figure, counted in zip(pair.values, have, strict=True):
                if any(isinstance(one, float) and math.isclose(one, figure, rel_tol=SAME) for one in values):
                    counted.add(of(case.artifacts[index]))
    return len(have[0]) < len(have[1]), len(have[1]) < len(have[0])


def _ranges_that_differ(case: Case, one: int, other: int) -> int:
    """How many joints have other ranges in two files."""
    mine, its = (case.joints_by_artifact.get(index, {}) for index in (one, other))
    pairs = [
        (rows[0].position_range, its[joint][0].position_range) for joint, rows in mine.items() if joint in its
    ]
    return sum(
        a is not None
        and b is not None
        and any(not math.isclose(x, y, abs_tol=1e-6) for x, y in zip(a, b, strict=True))
        for a, b in pairs
    )


def _figures(row: LedgerRow) -> tuple[object, ...]:
    """What is compared of a row."""
    stated = (*_PER_ANGLE, *SPEEDS, "position_range")
    return (
        row.kind,
        row.default_position,
        *(getattr(row, name) if name in row.stated else None for name in stated),
    )


def _angular(one: LedgerRow, other: LedgerRow) -> Iterator[_Pair]:
    """Figures that have an angle in their unit and that both files state."""
    for field in _PER_ANGLE:
        yield from _both(one, other, field)
    yield from _speeds(one, other)
    pose = one.default_position, other.default_position
    if pose[0] is not None and pose[1] is not None and pose[0] != pose[1]:
        name = "default_position"
        yield _Pair(name, name, name, "default position", (pose[0], pose[1]))
    mine, its = one.position_range, other.position_range
    if mine is None or its is None or mine == its:
        return
    if "position_range" not in one.stated or "position_range" not in other.stated:
        return
    for end, name in enumerate(("lower", "upper")):
        place, ends = "position_range", (mine[end], its[end])
        yield _Pair(place, place, "default_position", f"{name} end of the range", ends)


def _both(one: LedgerRow, other: LedgerRow, field: str) -> Iterator[_Pair]:
    mine, its = getattr(one, field), getattr(other, field)
    if mine is not None and its is not None and mine != its and field in one.stated and field in other.stated:
        yield _Pair(field, field, field, field.replace("_", " "), (mine, its))


def _speeds(one: LedgerRow, other: LedgerRow) -> Iterator[_Pair]:
    """Speed limits and no-load speeds, each with its like; where two files state no speed alike, those that they do."""
    pairs = [pair for field in SPEEDS for pair in _both(one, other, field)]
    yield from pairs
    mine, its = ([name for name in SPEEDS if name in row.stated] for row in (one, other))
    if set(mine).isdisjoint(its):
        for place, its_place in product(mine, its):
            speed, its_speed = getattr(one, place), getattr(other, its_place)
            if speed is not None and its_speed is not None:
                yield _Pair(place, its_place, place, place.replace("_", " "), (speed, its_speed))


def _is_rounded_pose(pair: _Pair) -> bool:
    """Whether a default position is another one in degrees, to the digits that it is written with."""
    large, small = sorted(map(abs, pair.values), reverse=True)
    if pair.place != "default_position" or not small or pair.values[0] * pair.values[1] < 0.0:
        return False
    digits = len(repr(large).partition(".")[2].strip("0"))
    return abs(large - small * DEGREES) <= 0.5 * 10.0**-digits


def _off_by(one: float, other: float, factor: float, relative: float) -> bool:
    """Whether two figures differ by a factor, either way."""
    if one == 0.0 or other == 0.0 or not (math.isfinite(one) and math.isfinite(other)):
        return False
    ratio = one / other
    return math.isclose(max(ratio, 1.0 / ratio), factor, rel_tol=relative)
