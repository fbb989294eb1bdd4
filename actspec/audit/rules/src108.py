from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from actspec.audit.case import MODELS
from actspec.audit.difference import axis_text
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.axes import angle, are_parallel
from actspec.audit.rules.same_joint import are_of_two_products, is_one_joint
from actspec.audit.rules.sided import robots_of_one_side
from actspec.audit.rules.source_pairs import is_one_machine
from actspec.ir import JointKind
from actspec.readings.artifact import Artifact, FileKind, Robot
from actspec.robot.view import JointView, RobotView

_Axis = tuple[float, float, float]

_SAME_ZERO = 0.1
"""Largest difference of a range's ends of joints with one zero [rad or m]. Chosen: files round, and soften, ranges; a
joint that is drawn half a turn off is pi off."""


@dataclass(frozen=True, slots=True)
class _Pair:
    """Two models of a robot, drawn in one frame of the base.

    Attributes:
        here: The one.
        there: The other.
        opposite: Joints whose axes point against each other.
        agree: Joints whose axes point the same way.
    """

    here: int
    there: int
    opposite: frozenset[str]
    agree: frozenset[str]


class AxisDisagrees(RuleOver[Robot]):
    code = "SRC108"
    name = "axis-disagrees"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    noted_in_folders = True
    paired = True
    needs = "no two models of one robot among the files"
    options: ClassVar[dict[str, float]] = {"degrees": 5.0}

    def subjects(self, case: Case) -> Iterator[Robot]:
        for robot in case.once(robots_of_one_side):
            if sum(case.artifacts[index].kind in MODELS for index in robot.artifacts) > 1:
                yield robot

    def judge(self, case: Case, robot: Robot) -> Iterator[Finding]:
        """Compare the axes of each joint in the models of a robot."""
        groups = _alike(case, robot)
        firsts = list(groups)
        pairs: dict[int, list[_Pair]] = {index: [] for index in firsts}
        for at, one in enumerate(firsts):
            for other in firsts[:at]:
                found = self._pair(case, one, other)
                if found is not None:
                    pairs[one].append(found)
                    pairs[other].append(_Pair(other, one, found.opposite, found.agree))
        for first, own in pairs.items():
            for joint in _joints(case.artifacts[first]):
                against = [pair.there for pair in own if joint in pair.opposite]
                beside = sum(joint in pair.agree for pair in own)
                if against and _departs(case, first, against, beside):
                    yield from (self._finding(case, index, against[0], joint) for index in groups[first])

    def _pair(self, case: Case, one: int, other: int) -> _Pair | None:
        """What two models have in common, and not; None: they may be drawn in two frames."""
        here, there = (_joints(case.artifacts[index]) for index in (one, other))
        angles = {
            name: angle(mine, its)
            for name, joint in here.items()
            if name in there
            and joint.kind is there[name].kind
            and (mine := joint.axis) is not None
            and (its := there[name].axis) is not None
        }
        most = math.radians(self.option(case, "degrees"))
        agree = frozenset(name for name, apart in angles.items() if apart <= most)
        opposite = frozenset(name for name, apart in angles.items() if apart >= math.pi - most)
        frames: dict[tuple[int | None, int | None], list[JointView]] = {}
        for name in agree:
            frames.setdefault(_frames(name, here, there), []).append(here[name])
        if 2 * len(agree) <= len(angles):
            return None
        told = frozenset(
            name
            for name in opposite
            if is_one_joint(case, one, other, name)
            and _fix(frames.get(_frames(name, here, there), ()), here[name])
            and _is_drawn_alike(name, here, there, agree, opposite, most)
        )
        return _Pair(one, other, told, agree)

    def _finding(self, case: Case, index: int, other: int, joint: str) -> Finding:
        joints = [_joints(case.artifacts[each]) for each in (index, other)]
        mine, theirs = (own[joint] for own in joints)
        assert mine.axis is not None and theirs.axis is not None
        path = case.artifacts[other].path
        apart = (
            _are_variants(*joints)
            or not is_one_machine(case, index, other)
            or are_of_two_products(case, index, other, joint)
        )
        return Finding(
            self.code,
            f"the axis points the other way than in {path}: in the base's frame it is {_text(mine.axis)} here and "
            f"{_text(theirs.axis)} there, so that positions, speeds and torques of this joint have the other sign",
            mine.span,
            joint,
            help=_help(mine, theirs),
            related=(theirs.span,),
            severity=Severity.INFO if apart else None,
            confidence=Confidence.LOW if apart else None,
            about=_text(mine.axis),
        )


def _text(axis: _Axis) -> str:
    """Two decimals: half a degree."""
    return axis_text([round(part, 2) for part in axis])


def _joints(artifact: Artifact) -> Mapping[str, JointView]:
    """The joints of a model, by name."""
    robot: RobotView | None = artifact.robot
    return {joint.name: joint for joint in robot.joints} if robot is not None else {}


def _alike(case: Case, robot: Robot) -> dict[int, list[int]]:
    """Models of a robot, each the first of those that have the same axes, with all of these: copies, and scenes.

    A scene with the model that it includes is that model.
    """
    found: dict[frozenset[tuple[str, str]], list[int]] = {}
    for index in robot.artifacts:
        if case.artifacts[index].kind in MODELS:
            joints = _joints(case.artifacts[index])
            key = frozenset(
                (name, _text(joint.axis)) for name, joint in joints.items() if joint.axis is not None
            )
            if key:
                found.setdefault(key, []).append(index)
    places = set()
    groups = {}
    for indices in found.values():
        own = []
        for index in indices:
            place = frozenset(joint.span for joint in _joints(case.artifacts[index]).values())
            if place not in places:
                own.append(index)
            places.add(place)
        if own:
            groups[own[0]] = own
    return groups


def _departs(case: Case, index: int, against: Sequence[int], beside: int) -> bool:
    """Whether a model is the odd one: most of the others are against it, or as many, and a URDF or an earlier file."""
    if len(against) != beside + 1:
        return len(against) > beside + 1
    kind = case.artifacts[index].kind
    kinds = {case.artifacts[other].kind for other in against}
    if kind is FileKind.MJCF and FileKind.URDF in kinds:
        return True
    return kinds == {kind} and min(against) < index


def _frames(
    name: str, here: Mapping[str, JointView], there: Mapping[str, JointView]
) -> tuple[int | None, int | None]:
    """The trees that a joint is in: an MJCF with several has a frame for each."""
    return here[name].tree, there[name].tree


def _fix(agreeing: Sequence[JointView], joint: JointView) -> bool:
    """Whether axes that agree leave no frame of the base in which this joint's would agree too.

    A base that is turned about them all turns round what stands across them, and nothing that is parallel to them.
    """
    axes = [one.axis for one in agreeing if one.axis is not None]
    if not axes or joint.axis is None:
        return False
    return are_parallel(axes[0], joint.axis) or not all(are_parallel(axes[0], axis) for axis in axes[1:])


def _is_drawn_alike(
    name: str,
    here: Mapping[str, JointView],
    there: Mapping[str, JointView],
    agree: frozenset[str],
    opposite: frozenset[str],
    most: float,
) -> bool:
    """Whether no joint before this one, drawn elsewhere, turns its axis round.

    A joint that is drawn half a turn on turns round what hangs on it, where that stands across it.
    """
    chains = _above(name, here), _above(name, there)
    mine, its = ([each for each in chain if each in here and each in there] for chain in chains)
    if mine != its or not agree | opposite >= set(mine):
        return False

    def may_turn(before: str) -> bool:
        # A joint that one file has alone, as those of a planar base, stands still in the other one, drawn anyhow.
        joints = here if before in here else there
        behind = _behind(before, joints) & (agree | opposite)
        turned = all(_is_turned(joints[before], here[each], there[each], most) for each in behind)
        return turned and not (before in mine and _has_one_zero(here[before], there[before]))

    return not any(map(may_turn, {*chains[0], *chains[1]}))


def _above(name: str, joints: Mapping[str, JointView]) -> list[str]:
    """The joints between one and the base, from it on."""
    chain: list[str] = []
    while (parent := joints[chain[-1] if chain else name].parent) and parent not in chain:
        chain.append(parent)
    return chain


def _are_variants(here: Mapping[str, JointView], there: Mapping[str, JointView]) -> bool:
    """Whether one of two models has a joint alone that does not carry all the rest, as those of a base do.

    On a free joint hangs all that it has, though no joint has it for a parent.
    """
    shared = here.keys() & there.keys()
    return any(
        joint.kind is not JointKind.FREE and not shared <= _behind(name, joints)
        for joints in (here, there)
        for name, joint in joints.items()
        if name not in shared
    )


def _behind(name: str, joints: Mapping[str, JointView]) -> set[str]:
    """The joints that hang on one."""
    found: set[str] = set()
    more = {name}
    while more:
        more = {each for each, joint in joints.items() if joint.parent in more} - found
        found |= more
    return found


def _is_turned(before: JointView, here: JointView, there: JointView, most: float) -> bool:
    """Whether half a turn about one joint makes another's axis that of the other file."""
    about, axis = before.axis, here.axis
    if about is None or axis is None or there.axis is None:
        return True
    along = 2.0 * sum(a * b for a, b in zip(about, axis, strict=True))
    x, y, z = (along * a - b for a, b in zip(about, axis, strict=True))
    return angle((x, y, z), there.axis) <= most


def _has_one_zero(one: JointView, other: JointView) -> bool:
    """Whether two ranges, of which neither is a turn, say that a joint is drawn at the same place."""
    if one.range is None or other.range is None or {"range"} & (one.unknown | other.unknown):
        return False
    if max(high - low for low, high in (one.range, other.range)) >= math.pi:
        return False
    turned = (-other.range[1], -other.range[0])
    return any(
        all(math.isclose(a, b, abs_tol=_SAME_ZERO) for a, b in zip(one.range, ends, strict=True))
        for ends in (other.range, turned)
    )


def _help(mine: JointView, theirs: JointView) -> str:
    """What to do, by what the ranges say."""
    if mine.range is None or theirs.range is None or {"range"} & (mine.unknown | theirs.unknown):
        return "write one axis in both files, or change signs where the one is used in place of the other"
    mirrored = (-theirs.range[1], -theirs.range[0])

    def is_mine(ends: tuple[float, float]) -> bool:
        return all(
            math.isclose(a, b, abs_tol=_SAME_ZERO) for a, b in zip(mine.range or (), ends, strict=True)
        )

    if is_mine(mirrored) and not is_mine(theirs.range):
        return "the ranges are mirrored, too: change signs where the one file is used in place of the other"
    if is_mine(theirs.range):
        return "the ranges are the same: write one axis in both files, and see that poses and signs fit it"
    return "write one axis in both files, or change signs where the one is used in place of the other"
