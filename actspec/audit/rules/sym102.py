from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from operator import attrgetter

from actspec.audit.case import MODELS
from actspec.audit.difference import axis_text
from actspec.audit.known import GRIPS
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.sided import of_its_leg
from actspec.audit.rules.sym101 import pairs
from actspec.diagnostics import listed
from actspec.ir import JointKind
from actspec.readings.ledger import LedgerRow
from actspec.robot.view import ActuatorView, JointView
from actspec.units import format_number, format_quantity

_OTHERS = 3
"""Other pairs that must mirror. Chosen: one or two may do so by accident, or be the ones that are turned."""

_LOPSIDED = 0.2
"""Sum of a range's ends from which it tells which way the joint turns [rad]. Chosen: files round and soften ranges."""

_SAME = 0.05
"""Largest difference of the ends of ranges that are one [rad]. Chosen: as above."""

_ALONG = math.cos(math.radians(5.0))
"""Cosine from which two axes are parallel. Chosen: wider than what rounded angles turn, narrower than a tilted hip."""

_PLANES = ((1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0))
"""What a mirror across x, y or z makes of an axis: what turns about its normal turns on as before."""


@dataclass(frozen=True, slots=True)
class _Pair:
    """A joint of a model on the left, and its like on the right.

    Attributes:
        left: Its rows; `right` likewise.
        joints: The left and the right joint, whose axes are known.
        turns: For each plane whether the right axis is the left's mirror image (1), its opposite (-1) or neither (0).
    """

    left: Sequence[LedgerRow]
    right: Sequence[LedgerRow]
    joints: tuple[JointView, JointView]
    turns: tuple[int, ...]


class TurnedSide(RuleOver[tuple[Sequence[_Pair], Sequence[ActuatorView]]]):
    code = "SYM102"
    name = "side-turned-round"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    noted_in_folders = True
    needs = "no model with joints whose names mirror each other and whose axes are known among the files"

    def subjects(self, case: Case) -> Iterator[tuple[Sequence[_Pair], Sequence[ActuatorView]]]:
        """The pairs of each model, with its actuators."""
        of_models: dict[int, list[_Pair]] = {}
        for left, right in case.once(pairs):
            index = left[0].artifact
            if index == right[0].artifact and case.artifacts[index].kind in MODELS:
                joints = [_joint(case, rows[0]) for rows in (left, right)]
                pair = _pair(left, right, *joints)
                # Each pair is met from both of its sides.
                if pair is not None and left[0].joint < right[0].joint:
                    of_models.setdefault(index, []).append(pair)
        for index, found in of_models.items():
            robot = case.artifacts[index].robot
            yield found, robot.actuators if robot is not None else ()

    def judge(self, case: Case, subject: tuple[Sequence[_Pair], Sequence[ActuatorView]]) -> Iterator[Finding]:
        """Find the one pair that is turned where the others mirror."""
        found, actuators = subject
        planes = _planes(found)
        pair, others = _odd(found, planes, _range_mirrors)
        # Two equal grippers mirror nothing: what opens them may turn alike.
        if pair is not None and not GRIPS.search(pair.left[0].joint):
            yield self._range(pair, others)
        views = {(view.target, view.span): view for view in actuators if "gear" not in view.unknown}

        def view(rows: Sequence[LedgerRow]) -> ActuatorView | None:
            return views.get((rows[0].joint, rows[0].span)) if len(rows) == 1 else None

        def gears_mirror(pair: _Pair, plane: int) -> int:
            one, other = view(pair.left), view(pair.right)
            if one is None or other is None or not one.gear or not other.gear:
                return 0
            if (one.gear > 0.0) is (other.gear > 0.0):
                return 1
            # A motor may turn back what the axis turns round.
            return -1 if pair.turns[plane] == 1 else 0

        pair, others = _odd(found, planes, gears_mirror)
        if pair is not None:
            one, other = view(pair.left), view(pair.right)
            assert one is not None and other is not None
            odd, other = sorted((one, other), key=attrgetter("gear"))
            yield self._gear(odd, other, others)
        for alike in _of_equal_legs(found):
            for way in (1, -1):
                turned = [leg for leg in alike if way * _along(leg[1], alike[0][1]) < 0.0]
                rest = [leg for leg in alike if way * _along(leg[1], alike[0][1]) > 0.0]
                if len(turned) == 1 and not (
                    _is_turned(view(turned[0][0])) and not _is_turned(view(rest[0][0]))
                ):
                    yield self._axis(turned[0][1], [joint for _, joint in rest])

    def _gear(self, odd: ActuatorView, other: ActuatorView, others: int) -> Finding:
        return Finding(
            self.code,
            f"the gear is {format_number(odd.gear)} here and {format_number(other.gear)} at {other.target}, and the "
            "axes mirror each other: one command turns the two sides opposite ways; "
            f"{others} other pairs of this model have gears of one sign",
            odd.places.get("gear", odd.span),
            odd.target,
            odd.gear,
            help="give both gears one sign; where the robot's own motor is turned, a comment can say so",
            related=(other.places.get("gear", other.span),),
        )

    def _axis(self, odd: JointView, others: Sequence[JointView]) -> Finding:
        assert odd.axis is not None and others[0].axis is not None
        mine, its = (axis_text([round(part, 2) for part in axis]) for axis in (odd.axis, others[0].axis))
        return Finding(
            self.code,
            f"the axis is {mine} in the base's frame, and {its} at {listed([one.name for one in others], 3)}: what "
            "turns those one way turns this the other",
            odd.places.get("axis", odd.span),
            odd.name,
            help="the sides are equal or mirror each other, in front as behind: turn this axis round, or those of the "
            "other side; where the robot's own motor is turned, a comment can say so",
            related=(others[0].places.get("axis", others[0].span),),
            about=f"axis {mine}",
        )

    def _range(self, pair: _Pair, others: int) -> Finding:
        field, odd = _departs(pair)
        places = [one.places.get(field, one.span) for one in pair.joints]
        if places[0] == places[1]:
            # Both are a class's: what differs is how the bodies are turned.
            places = [one.span for one in pair.joints]
        axes, ranges = [], []
        for joint in pair.joints:
            assert joint.axis is not None and joint.range is not None
            axes.append(axis_text([round(part, 2) for part in joint.axis]))
            low, high = joint.range
            ranges.append(f"{format_quantity(low, '', 3)} to {format_quantity(high, 'rad', 3)}")
        other = pair.joints[1 - odd].name
        return Finding(
            self.code,
            f"this is no mirror image of {other}: about {axes[odd]} in the base's frame it goes from {ranges[odd]}, "
            f"and {other} about {axes[1 - odd]} from {ranges[1 - odd]}, the other way; "
            f"{others} other pairs of this model mirror",
            places[odd],
            pair.joints[odd].name,
            help="of one of the two the axis or the range is turned round: turn it back, and see which way it bends",
            related=(places[1 - odd],),
            about=" ".join(ranges),
        )


def _of_equal_legs(found: Sequence[_Pair]) -> Iterator[Sequence[tuple[Sequence[LedgerRow], JointView]]]:
    """Joints of legs or wheels, four or more, with one symmetrical range, or none, about parallel axes.

    Their ranges do not tell which way they turn, and all front and rear legs of a robot are alike.
    """
    legs: dict[str, list[tuple[Sequence[LedgerRow], JointView]]] = {}
    for pair in found:
        sides = zip((pair.left, pair.right), pair.joints, strict=True)
        legs.setdefault(of_its_leg(pair.joints[0].name), []).extend(sides)
    for alike in legs.values():
        first = alike[0][1]
        if len(alike) > _OTHERS and all(_is_like(joint, first) for _, joint in alike):
            yield alike


def _is_like(one: JointView, first: JointView) -> bool:
    """Whether a joint has the symmetrical range of another, and an axis along its."""
    if one.tree != first.tree or abs(_along(one, first)) <= _ALONG:
        return False
    if one.range is None or first.range is None:
        return one.range is first.range
    same = all(abs(a - b) <= _SAME for a, b in zip(one.range, first.range, strict=True))
    return same and abs(sum(one.range)) < _LOPSIDED


def _along(one: JointView, other: JointView) -> float:
    """Cosine between two axes."""
    return sum(a * b for a, b in zip(one.axis or (), other.axis or (), strict=True))


def _is_turned(view: ActuatorView | None) -> bool:
    """Whether a motor turns its command round."""
    return view is not None and view.gear < 0.0


def _departs(pair: _Pair) -> tuple[str, int]:
    """Which of range and axis departs, and at which side (0: left): what one class states of both is no slip.

    Where nothing tells, it is the right one's range.
    """
    for field in ("axis", "range"):
        own = [one.places.get(field, one.span) == one.span for one in pair.joints]
        if own[0] is not own[1]:
            return field, own.index(True)
    range_of = [one.places.get("range") for one in pair.joints]
    return ("axis" if range_of[0] is not None and range_of[0] == range_of[1] else "range"), 1


def _joint(case: Case, row: LedgerRow) -> JointView | None:
    robot = case.artifacts[row.artifact].robot
    return None if robot is None else robot.joint(row.joint)


def _pair(
    left: Sequence[LedgerRow],
    right: Sequence[LedgerRow],
    one: JointView | None,
    other: JointView | None,
) -> _Pair | None:
    """Two hinges in one frame; None where an axis is not known."""
    if one is None or other is None or one.axis is None or other.axis is None:
        return None
    if one.tree != other.tree or {one.kind, other.kind} != {JointKind.HINGE}:
        return None
    turns = []
    for plane in _PLANES:
        along = sum(a * b * sign for a, b, sign in zip(one.axis, other.axis, plane, strict=True))
        turns.append((along > _ALONG) - (along < -_ALONG))
    return _Pair(left, right, (one, other), tuple(turns))


def _planes(found: Sequence[_Pair]) -> tuple[int, ...]:
    """Across which most pairs mirror, by their ranges: one plane, or several that nothing tells apart; none by few."""
    counts = [sum(_range_mirrors(pair, plane) == 1 for pair in found) for plane in range(len(_PLANES))]
    most = max(counts)
    return tuple(plane for plane, count in enumerate(counts) if count == most >= _OTHERS)


def _odd(
    found: Sequence[_Pair], planes: Sequence[int], mirrors: Callable[[_Pair, int], int]
) -> tuple[_Pair | None, int]:
    """The one pair that does not mirror while others do, whichever the plane is, and how many these are.

    Args:
        found: Pairs of one model.
        planes: That it may mirror across.
        mirrors: Of a pair and a plane: 1 where it mirrors, -1 where one side is turned round, 0 where nobody can tell.
    """
    told = {tuple(mirrors(pair, plane) for pair in found) for plane in planes}
    signs = told.pop() if len(told) == 1 else ()
    if signs.count(-1) != 1 or signs.count(1) < _OTHERS:
        return None, 0
    return found[signs.index(-1)], signs.count(1)


def _range_mirrors(pair: _Pair, plane: int) -> int:
    """Whether the ranges of a pair are mirror images, as its axes are or are not."""
    one, other = pair.left[0].position_range, pair.right[0].position_range
    turn = pair.turns[plane]
    if one is None or other is None or not turn or one[1] - one[0] > math.tau or abs(sum(one)) < _LOPSIDED:
        return 0
    turned = (-one[1], -one[0])
    for ends, told in ((one, turn), (turned, -turn)):
        if all(abs(a - b) <= _SAME for a, b in zip(ends, other, strict=True)):
            return told
    return 0
