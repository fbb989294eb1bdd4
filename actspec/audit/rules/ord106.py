from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from os.path import basename

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.axes import are_parallel
from actspec.audit.rules.misnamed import is_misspelt, is_swapped, misnamed, selects
from actspec.audit.rules.sided import other_side
from actspec.diagnostics import Span, listed, shortened
from actspec.joints import JointKind, other_word
from actspec.readings.artifact import Artifact, Robot
from actspec.readings.called import stem_of, telling
from actspec.readings.joint_names import joint_names, renaming
from actspec.robot.view import JointView

_FEW = 2
"""Joints that two models must share. Chosen: as ORD104 asks for."""

_ALIKE = 0.02
"""Largest difference of an end of the range of one joint in two files [rad or m]. Chosen."""


class JointCalledOtherwise(RuleOver[tuple[int, Robot]]):
    code = "ORD106"
    name = "joint-called-otherwise"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    needs = "no two models of one robot among the files that were named"

    def subjects(self, case: Case) -> Iterator[tuple[int, Robot]]:
        for number, robot in enumerate(case.robots):
            if len(_models(case, robot)) > 1:
                yield number, robot

    def judge(self, case: Case, subject: tuple[int, Robot]) -> Iterator[Finding]:
        """Find joints of two models that are one, and have two names."""
        _, robot = subject
        told = {(one.model, one.joint.name) for one in case.once(misnamed)}
        found: dict[tuple[Span, str, str], dict[str, _There]] = {}
        for one, other in combinations(_models(case, robot), 2):
            for mine, its in _pairs(case.artifacts[one], case.artifacts[other]):
                if not is_misspelt(mine.name, its.name) and _are_variants(case, robot, one, other, mine, its):
                    continue
                sides = [(other, its, mine), (one, mine, its)]
                # The name that most files have is right, and of two the one that has its like on the other side.
                departing, joint, meant = min(sides, key=lambda side: _having(case, robot, side[1].name))
                if (departing, joint.name) in told:
                    continue
                beside = one if departing == other else other
                wrong = _is_wrong(case, robot, [(joint, meant)])
                at = joint.span, joint.name, meant.name
                found.setdefault(at, {})[case.artifacts[beside].path] = _There(meant.span, wrong)
        words = {key: other_word(key[1], key[2]) for key in found}
        many = Counter((key[0].path, pair) for key, pair in words.items() if pair is not None)
        yield from _limbs_told(case, robot)
        for (place, called, name), others in found.items():
            files = listed(dict.fromkeys(map(basename, others)))
            pair = words[place, called, name]
            if pair is not None and many[place.path, pair] > 1:
                # One word for another in several names is said once.
                here, there = map(shortened, pair)
                message = f"{here} in the name of this joint is {there} in {files}"
                help = f"write {there} for {here} in these names here, or {here} for {there} there"
            else:
                message = f"this joint is called {shortened(name)} in {files}"
                help = f"call it {shortened(name)} here, or {shortened(called)} there"
            yield Finding(
                self.code,
                f"{message}, and nothing of it is compared with it there",
                place,
                called,
                help=help,
                related=_places_of(others),
                about=f"{called} {name}",
                severity=_severity(others),
            )


@dataclass(frozen=True, slots=True)
class _There:
    """A joint of the other file.

    Attributes:
        place: Where it is.
        wrong: As `_is_wrong` has it.
    """

    place: Span
    wrong: bool


def _severity(others: Mapping[str, _There]) -> Severity | None:
    """That of the rule where one of several files shows that a name is wrong."""
    return None if any(there.wrong for there in others.values()) else Severity.INFO


def _places_of(others: Mapping[str, _There]) -> tuple[Span, ...]:
    return tuple(dict.fromkeys(there.place for there in others.values()))


def _is_wrong(case: Case, robot: Robot, pairs: Sequence[tuple[JointView, JointView]]) -> bool:
    """Whether one of two names of a joint is itself wrong: misspelt, or not the one that a deploy file, spec or list of
    joints has.
    """
    # Patterns are for the model that their configuration loads, of which CFG101 and CFG102 tell.
    lists = [
        frozenset(joint_names(case.artifacts[index]) or ())
        for index in robot.artifacts
        if case.artifacts[index].robot is None
    ]
    return any(
        _is_a_slip(mine, its) or any((mine.name in names) is not (its.name in names) for names in lists)
        for mine, its in pairs
    )


def _models(case: Case, robot: Robot) -> list[int]:
    """The models of a robot that somebody named: in a folder there are those of its versions."""
    return [i for i in robot.artifacts if case.artifacts[i].robot is not None and not case.is_met(i)]


def _pairs(one: Artifact, other: Artifact) -> Iterator[tuple[JointView, JointView]]:
    """Joints that each of two models has alone, and that hang and turn alike; none of which two may be meant."""
    names = [frozenset(joint_names(artifact) or ()) for artifact in (one, other)]
    if len(names[0] & names[1]) < _FEW:
        return
    alone = [
        [joint for joint in artifact.robot.scalar_joints if joint.name not in theirs]
        if artifact.robot
        else []
        for artifact, theirs in zip((one, other), reversed(names), strict=True)
    ]
    places = [
        {joint.name: _places(artifact, joint) for joint in joints}
        for artifact, joints in zip((one, other), alone, strict=True)
    ]

    def are_left_over(mine: JointView, its: JointView) -> bool:
        here, there = (list(each.values()) for each in places)
        place = places[0][mine.name]
        return here.count(place) == there.count(place) == 1

    meant = [
        (mine, its)
        for mine in alone[0]
        for its in alone[1]
        if places[0][mine.name] == places[1][its.name]
        and (is_misspelt(mine.name, its.name) or (are_left_over(mine, its) and _turn_alike(mine, its)))
    ]
    for mine, its in meant:
        if sum(mine is a or its is b for a, b in meant) == 1:
            yield mine, its


def _limbs_told(case: Case, robot: Robot) -> Iterator[Finding]:
    """One finding for each file in which joints that hang on each other are called otherwise."""
    found: dict[tuple[Span, tuple[str, ...], tuple[str, ...]], dict[str, _There]] = {}
    for one, other in combinations(_models(case, robot), 2):
        limb = _limb(case.artifacts[one], case.artifacts[other])
        if limb and (_is_a_slip(*limb[0]) or not _are_called_apart(case, one, other)):
            mine, its = zip(*limb, strict=True)
            sides = [(other, its, mine), (one, mine, its)]
            departing, joints, meant = min(sides, key=lambda side: _having(case, robot, side[1][0].name))
            beside = one if departing == other else other
            names = tuple(tuple(joint.name for joint in side) for side in (joints, meant))
            wrong = _is_wrong(case, robot, [*zip(joints, meant, strict=True)])
            at = joints[0].span, *names
            found.setdefault(at, {})[case.artifacts[beside].path] = _There(meant[0].span, wrong)
    for (place, called, wanted), others in found.items():
        files = listed(dict.fromkeys(map(basename, others)))
        yield Finding(
            "ORD106",
            f"this joint is called {shortened(wanted[0])} in {files}, {len(called) - 1} more likewise, and nothing of "
            "them is compared with it there",
            place,
            called[0],
            joints=called,
            help=f"call it {shortened(wanted[0])} here, or {shortened(called[0])} there, and likewise "
            f"{listed(called[1:])}",
            related=_places_of(others),
            about=f"{called[0]} {wanted[0]}",
            severity=_severity(others),
        )


def _limb(one: Artifact, other: Artifact) -> list[tuple[JointView, JointView]]:
    """Joints that one word for another makes those of the other model, in the first one's order, where some hang on
    each other; none where they hang or turn otherwise, or are those of the other side.
    """
    names = renaming(*(frozenset(joint_names(artifact) or ()) for artifact in (one, other)))
    theirs = {joint.name: joint for joint in other.robot.scalar_joints} if other.robot else {}
    pairs = [
        (joint, theirs[names[joint.name]])
        for joint in (one.robot.scalar_joints if one.robot else ())
        if joint.name in names
    ]

    def hang_alike(mine: JointView, its: JointView) -> bool:
        kind, parent, carried = _places(one, mine)
        called = kind, names.get(parent, parent), frozenset(names.get(name, name) for name in carried)
        return called == _places(other, its)

    hang = any(mine.parent in names for mine, _ in pairs)
    sides = any(other_side(mine.name, (its.name,)) for mine, its in pairs)
    alike = all(hang_alike(mine, its) and _turn_alike(mine, its) for mine, its in pairs)
    return pairs if hang and alike and not sides else []


def _places(artifact: Artifact, joint: JointView) -> tuple[JointKind, str, frozenset[str]]:
    """What a joint is, and between which it is."""
    joints = artifact.robot.scalar_joints if artifact.robot is not None else ()
    parent = joint.parent if any(one.name == joint.parent for one in joints) else ""
    return joint.kind, parent, frozenset(one.name for one in joints if one.parent == joint.name)


def _turn_alike(one: JointView, other: JointView) -> bool:
    """Whether two joints have one range, and one axis as far as both are known, whichever way it points."""
    if one.range is None or other.range is None:
        return False
    if one.axis and other.axis and not are_parallel(one.axis, other.axis):
        return False
    return all(math.isclose(a, b, abs_tol=_ALIKE) for a, b in zip(one.range, other.range, strict=True))


def _is_a_slip(mine: JointView, its: JointView) -> bool:
    """Whether one of two names is the other one misspelt: `rigth_arm_j1`."""
    word = other_word(mine.name, its.name)
    return is_misspelt(mine.name, its.name) or (word is not None and is_swapped(*word))


def _are_called_apart(case: Case, one: int, other: int) -> bool:
    """Whether two files' names differ in a word, as a base robot's and a variant's: each may have a limb of its own."""
    words = [telling(stem_of(case.artifacts[index].path)) for index in (one, other)]
    return words[0] != words[1]


def _are_variants(case: Case, robot: Robot, one: int, other: int, mine: JointView, its: JointView) -> bool:
    """Whether two models are of variants that carry another device in one place, by what files and joints are called.

    A joint with the word of its file alone is that variant's (`lidar_pan` of `dingo_lidar.urdf`); and a rename that
    was forgotten in one of two files leaves no two of one kind, each under a name of its own.
    """
    files = [case.artifacts[index].path for index in (one, other)]
    stems = [stem_of(file) for file in files]
    words = [_words(stem) for stem in stems]
    if (words[0] - words[1]) & _words(mine.name) or (words[1] - words[0]) & _words(its.name):
        return True
    told = [telling(stem) for stem in stems]
    if not (told[0] - told[1] and told[1] - told[0]):
        return False
    kinds = [
        {
            case.artifacts[index].kind
            for index in _models(case, robot)
            if stem_of(case.artifacts[index].path) == stem
        }
        for stem in stems
    ]
    return bool(kinds[0] & kinds[1])


def _words(name: str) -> frozenset[str]:
    return frozenset(re.findall(r"[^\W_]+", name.lower()))


def _having(case: Case, robot: Robot, name: str) -> tuple[int, bool, int]:
    """How many files of a robot have a joint's name, or select it, and whether it has its like on the other side.

    Of names that are even in both the one of a later file departs, in every two of the files alike.
    """
    members = [case.artifacts[index] for index in robot.artifacts]
    names = [joint_names(one) or () for one in members]
    having = [name in own or selects(one, name) for one, own in zip(members, names, strict=True)]
    return sum(having), any(other_side(name, own) is not None for own in names), -having.index(True)
