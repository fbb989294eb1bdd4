from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass

from actspec.audit.case import MODELS
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.axes import are_opposite, are_parallel
from actspec.audit.rules.joints import is_called_undriven, shown, unit
from actspec.audit.rules.same_joint import are_of_two_products, is_one_joint
from actspec.audit.rules.sided import robots_of_one_side
from actspec.audit.rules.source_pairs import is_one_machine
from actspec.audit.rules.source_rule import revision
from actspec.audit.rules.unt101 import ranges_in_doubt
from actspec.fields import is_power_of_ten
from actspec.ir import JointKind
from actspec.poses import POSE_TOLERANCE
from actspec.readings.artifact import FileKind, Robot
from actspec.readings.body import LIKENESS
from actspec.readings.compare import DEGREES
from actspec.readings.ledger import LedgerRow

_Range = tuple[float, float]

_LOPSIDED = {JointKind.HINGE: 0.2, JointKind.SLIDE: 0.005}
"""What a range's ends add up to where its mirror image is another one [rad or m]. Chosen: as SYM102's."""

_WHEEL = re.compile(r"^(?!.*(?:steer|susp|swivel|cast|shock|arm)).*wheel", re.IGNORECASE)
"""Names of joints that roll. Chosen: what steers a wheel, or carries it, is called after it too, and has a range."""

_LONGEST = 20.0
"""Longest slide [m], as SPEC190 has it: rails have 10 m."""


@dataclass(frozen=True, slots=True)
class _Stated:
    """One range of a joint, of a robot.

    Attributes:
        rows: The joint in the models that have it, in the files' order.
        poses: Default positions that are inside of it.
        kinds: What files have it.
    """

    rows: tuple[LedgerRow, ...]
    poses: int
    kinds: frozenset[FileKind]

    @property
    def range(self) -> _Range:
        """Its ends [rad or m]."""
        found = self.rows[0].position_range
        assert found is not None
        return found


class RangeDisagrees(RuleOver[tuple[Robot, str]]):
    code = "SRC109"
    name = "position-range-disagrees"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    noted_in_folders = True
    paired = True
    needs = "no two models of one robot give a joint a range"

    def subjects(self, case: Case) -> Iterator[tuple[Robot, str]]:
        """Joints with a range in two models of a robot."""
        for robot in case.once(robots_of_one_side):
            models = [index for index in robot.artifacts if case.artifacts[index].kind in MODELS]
            joints: dict[str, int] = {}
            for index in models if len(models) > 1 else ():
                for joint, rows in case.joints_by_artifact.get(index, {}).items():
                    found = _has_range(case, rows[0]) or _is_free_wheel(case, rows[0])
                    joints[joint] = joints.get(joint, 0) + found
            yield from ((robot, joint) for joint, count in joints.items() if count > 1)

    def judge(self, case: Case, subject: tuple[Robot, str]) -> Iterator[Finding]:
        """Hold each range of a joint to the one for which most speaks."""
        yield from self._stopped(case, *subject)
        ranges = _ranges(case, *subject)
        if len(ranges) < 2:
            return
        right = max(ranges, key=lambda one: _worth(case, one))
        for wrong in ranges:
            for row in wrong.rows if wrong is not right else ():
                yield from self._compare(case, wrong, row, right)

    def _stopped(self, case: Case, robot: Robot, joint: str) -> Iterator[Finding]:
        """A wheel that has stops in one file and none in another."""
        rows = [case.joints[index, joint][0] for index in robot.artifacts if (index, joint) in case.joints]
        free = [row for row in rows if _is_free_wheel(case, row)]
        for row in rows if free else ():
            other = next((one for one in free if is_one_joint(case, row.artifact, one.artifact, joint)), None)
            if other is None or other.kind is not row.kind or not _has_range(case, row):
                continue
            low, high = (shown(row, "default_position", end, 4) for end in row.position_range or ())
            apart = _are_apart(case, row, other)
            yield Finding(
                self.code,
                f"this wheel turns from {low} to {high} here and without end in {other.file}: it runs into a stop here",
                row.place("position_range"),
                joint,
                unit=unit(row, "default_position"),
                help="take the range away here (URDF: continuous), or give the joint one there if it does not roll",
                related=(other.span,),
                severity=Severity.INFO if apart else None,
                confidence=Confidence.LOW if apart else None,
                fields=("position_range",),
            )

    def _compare(self, case: Case, wrong: _Stated, row: LedgerRow, right: _Stated) -> Iterator[Finding]:
        other = next(
            (one for one in right.rows if is_one_joint(case, row.artifact, one.artifact, row.joint)), None
        )
        if other is None or other.kind is not row.kind:
            return
        contrary = _contrary(row.kind or JointKind.HINGE, wrong.range, right.range)
        if not contrary or _is_turned(case, row, other):
            return
        low, high, its_low, its_high = (
            shown(row, "default_position", end, 4) for end in (*wrong.range, *right.range)
        )
        said = f"the joint's range is {low} to {high} here and {its_low} to {its_high} in {other.file}, {contrary}"
        if right.poses and not wrong.poses:
            said += "; the robot's default position is in that one alone"
        apart = _are_apart(case, row, other)
        yield Finding(
            self.code,
            said,
            row.place("position_range"),
            row.joint,
            unit=unit(row, "default_position"),
            help=_help(row.kind, wrong.range, right.range),
            related=(other.place("position_range"),),
            severity=Severity.INFO if apart else None,
            confidence=Confidence.LOW if apart else None,
            fields=("position_range",),
        )


def _help(kind: JointKind | None, wrong: _Range, right: _Range) -> str:
    if kind is JointKind.SLIDE and _are_in_mm(wrong, right):
        return "ranges of slides are in m: find out which file has the joint as the robot has it"
    return "find out which file has the joint as the robot has it, and correct range or axis in the other"


def _are_apart(case: Case, row: LedgerRow, other: LedgerRow) -> bool:
    """Whether files may be of two machines, or nothing drives the joint."""
    return bool(
        revision(case, row.artifact) ^ revision(case, other.artifact)
        or not is_one_machine(case, row.artifact, other.artifact, LIKENESS)
        or are_of_two_products(case, row.artifact, other.artifact, row.joint)
        or is_called_undriven(row)
    )


def _is_free_wheel(case: Case, row: LedgerRow) -> bool:
    """Whether a model's hinge is called a wheel, none that steers or is sprung, and turns without end."""
    robot = case.artifacts[row.artifact].robot
    joint = None if robot is None else robot.joint(row.joint)
    if (
        joint is None
        or joint.range is not None
        or "range" in joint.unknown
        or row.kind is not JointKind.HINGE
    ):
        return False
    return bool(_WHEEL.search(row.joint)) and not case.is_idle(row.span)


def _has_range(case: Case, row: LedgerRow) -> bool:
    """Whether a model states a range of a joint, whose unit is not in doubt (UNT101)."""
    ends = row.position_range
    if ends is None or "position_range" not in row.stated or row.kind not in POSE_TOLERANCE:
        return False
    if not ends[0] < ends[1] or not all(map(math.isfinite, ends)) or case.is_idle(row.span):
        return False
    return (row.place("position_range").path, row.joint) not in case.once(ranges_in_doubt)


def _ranges(case: Case, robot: Robot, joint: str) -> list[_Stated]:
    """The ranges that models give a joint, each once; ends that files round are one."""
    found: list[list[LedgerRow]] = []
    poses = []
    for index in robot.artifacts:
        rows = case.joints.get((index, joint), ())
        if not rows:
            continue
        if case.artifacts[index].kind in (FileKind.CFG, FileKind.DEPLOY):
            poses += [row.default_position for row in rows[:1] if "default_position" in row.stated]
        elif case.artifacts[index].kind in MODELS and _has_range(case, rows[0]):
            home = next((each for each in found if _is_same(each[0], rows[0])), None)
            if home is None:
                found.append([rows[0]])
            elif all(one.place("position_range") != rows[0].place("position_range") for one in home):
                # A scene and the model that it includes have one range.
                home.append(rows[0])
    return [
        _Stated(
            tuple(rows),
            sum(pose is not None and _is_inside(rows[0], pose) for pose in poses),
            frozenset(case.artifacts[row.artifact].kind for row in rows),
        )
        for rows in found
    ]


def _is_inside(row: LedgerRow, pose: float) -> bool:
    low, high = row.position_range or (-math.inf, math.inf)
    most = POSE_TOLERANCE[row.kind or JointKind.HINGE]
    return low - most <= pose <= high + most


def _is_same(one: LedgerRow, other: LedgerRow) -> bool:
    if one.kind is not other.kind:
        return False
    most = POSE_TOLERANCE[one.kind or JointKind.HINGE]
    ends = zip(one.position_range or (), other.position_range or (), strict=True)
    return all(math.isclose(a, b, abs_tol=most) for a, b in ends)


def _worth(case: Case, one: _Stated) -> tuple[int, bool, int, bool, tuple[int, ...]]:
    """How much speaks for a range: poses, a length that slides have, kinds of file, a URDF; of as much the first path,
    in whatever order.
    """
    paths = min(os.path.abspath(case.artifacts[row.artifact].path) for row in one.rows)
    low, high = one.range
    rail = one.rows[0].kind is not JointKind.SLIDE or high - low <= _LONGEST
    return (
        one.poses,
        rail,
        len(one.kinds),
        FileKind.URDF in one.kinds,
        tuple(-ord(letter) for letter in paths),
    )


def _contrary(kind: JointKind, one: _Range, other: _Range) -> str:
    """In which way two ranges cannot both be the joint's; "": one may be narrower on purpose, or UNT103 has it."""
    if any(
        b and math.isclose(max(a / b, b / a, key=abs), DEGREES, rel_tol=0.005)
        for a, b in zip(one, other, strict=True)
        if a
    ):
        return ""
    if kind is JointKind.SLIDE and _are_in_mm(one, other):
        return "1000 times apart: one of them is in mm"
    most = POSE_TOLERANCE[kind]
    mirrored = math.isclose(one[0], -other[1], abs_tol=most) and math.isclose(one[1], -other[0], abs_tol=most)
    if mirrored and abs(sum(one)) >= _LOPSIDED[kind]:
        return (
            "its mirror image: positions have the other sign in one of the files, or count from another zero"
        )
    if max(one[0], other[0]) >= min(one[1], other[1]):
        return "which have no position in common: one of them has the wrong sign, or counts from another zero"
    return ""


def _are_in_mm(one: _Range, other: _Range) -> bool:
    """Whether two ranges of a slide [m] differ by the mm of a metre; a power of ten for both ends is a placeholder."""
    wide, narrow = sorted((one, other), key=lambda ends: ends[1] - ends[0], reverse=True)
    is_open = -wide[0] == wide[1] and is_power_of_ten(wide[1])
    return not is_open and all(
        math.isclose(a, 1e3 * b, rel_tol=0.005) for a, b in zip(wide, narrow, strict=True)
    )


def _is_turned(case: Case, one: LedgerRow, other: LedgerRow) -> bool:
    """Whether the axes point against each other, so that the range is to be mirrored: SRC108 has it; or lie otherwise,
    as those of two things that scenes call alike.
    """
    views = [case.artifacts[row.artifact].robot for row in (one, other)]
    axes = [
        joint.axis if view is not None and (joint := view.joint(row.joint)) is not None else None
        for view, row in zip(views, (one, other), strict=True)
    ]
    mine, its = axes
    return mine is not None and its is not None and (are_opposite(mine, its) or not are_parallel(mine, its))
