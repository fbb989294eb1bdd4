"""Joints that a deploy file, or a configuration's list of joints, calls otherwise than the robot's models do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from actspec.audit.case import Case
from actspec.audit.rules.configs import FRAMEWORKS, is_whole_robot
from actspec.audit.rules.joints import names_undriven
from actspec.audit.rules.ord101 import scalar_joints, stated_order
from actspec.audit.rules.sided import across
from actspec.diagnostics import Span, nearest
from actspec.joints import ARM_WORDS, LEG_WORDS, LETTERS, begin_alike, other_word, plain_words, respelt
from actspec.patterns import is_slip
from actspec.readings.artifact import Artifact, FileKind, Framework
from actspec.readings.joint_names import matching
from actspec.robot.view import JointView

_FEW = 2
"""Names that a list and a model must share. Chosen: as ORD102 asks for, to hold an order to a model."""


@dataclass(frozen=True, slots=True)
class Misnamed:
    """One name.

    Attributes:
        list: Index of the artifact that has it.
        name: As the list has it.
        place: Where.
        joint: The joint of the model that stands for it, which the list leaves out.
        model: Index of that model.
        patterns: The configuration that selects the name and not the joint: the model departs then; None: there is
            none.
    """

    list: int
    name: str
    place: Span
    joint: JointView
    model: int
    patterns: Artifact | None


def misnamed(case: Case) -> tuple[Misnamed, ...]:
    """Names in lists of joints that stand nowhere in the robot's files, each with the joint that it stands for.

    A name without such a joint is that of a part which the model lacks, a hand or an arm, and none is said to be wrong.
    """
    return tuple(found for index in range(len(case.artifacts)) for found in _of_list(case, index))


def _of_list(case: Case, index: int) -> Iterator[Misnamed]:
    names = _names(case.artifacts[index])
    others = [other for other in case.robot_of(index).artifacts if other != index]
    joints = {
        other: frozenset(scalar_joints(robot))
        for other in others
        if (robot := case.artifacts[other].robot) is not None
    }
    if len(names) <= _FEW or not joints:
        return
    model = max(joints, key=lambda other: len(names.keys() & joints[other]))
    robot = case.artifacts[model].robot
    assert robot is not None
    if len(names.keys() & joints[model]) < _FEW:
        return
    members = [case.artifacts[other] for other in others]
    # Where no list names the joints a key may be a part of their names, as in legged_gym.
    keys = stated_order(case.artifacts[index]) is None
    lost = [
        name
        for name in names
        if not any(_has(member, name) for member in members)
        and not (keys and any(name in joint for joint in joints[model]))
    ]
    # What follows another joint, or is called a part without a drive, is left out of lists.
    free = {
        joint.name: joint
        for joint in robot.joints
        if joint.name in joints[model] - names.keys()
        and joint.mimic is None
        and joint.name not in robot.coupled
        and not names_undriven(joint.name)
    }
    near = _meant(lost, tuple(free))
    rest = (
        [name for name in lost if name not in near],
        [joint for joint in free if joint not in near.values()],
    )
    for name, meant in {**near, **_of_its_side(*rest, [*names])}.items():
        patterns = next((one for one in members if selects(one, name) and not selects(one, meant)), None)
        yield Misnamed(index, name, names[name], free[meant], model, patterns)


def drivers_beside(case: Case, index: int) -> list[Artifact]:
    """The configurations beside a deploy file that have a group for one of its joints, where no other file is."""
    members = [case.artifacts[other] for other in case.robot_of(index).artifacts if other != index]
    if case.artifacts[index].kind is not FileKind.DEPLOY or any(one.config is None for one in members):
        return []
    names = _names(case.artifacts[index])
    return [one for one in members if any(selects(one, name) for name in names)]


def beside_patterns(case: Case, index: int) -> Iterator[tuple[str, Span, str, Artifact]]:
    """Names in a deploy file that no group of the robot's configuration has, where no other file names its joints.

    Each with its place, the name that is meant, and the configuration: that name has another name's or pattern's word
    in the place of one that is nearly it, or is the like of a joint on the other side, is in a group, and is left out
    of the file. Joints without such a name are of a part that the configuration leaves to others.
    """
    drivers = drivers_beside(case, index)
    names = _names(case.artifacts[index])
    lost = [name for name in names if not any(selects(one, name) for one in drivers)]
    if 2 * len(lost) > len(names):
        return
    patterns = [
        pattern
        for one in drivers
        for group in (one.config.groups if one.config is not None else ())
        for pattern in group.joints or ()
    ]
    words = dict.fromkeys(
        word for text in (*(names.keys() - {*lost}), *patterns) for word in LETTERS.findall(text)
    )
    free = {
        other: one
        for name in names.keys() - {*lost}
        for other in across(name)
        for one in drivers
        if other not in names and selects(one, other)
    }
    sided = _of_its_side(lost, [*free], [*names])

    def near(own: str) -> list[str]:
        return [
            word
            for word in sorted(words)
            if word != own and nearest(own, [word]) and not are_two_parts(own, word)
        ]

    for name in lost:
        meant = {
            text: one
            for text in respelt(name, near)
            for one in drivers
            if text not in names and selects(one, text)
        }
        if len(meant) == 1:
            yield name, names[name], *meant.popitem()
        elif not meant and name in sided:
            yield name, names[name], sided[name], free[sided[name]]


def _names(artifact: Artifact) -> Mapping[str, Span]:
    """The joints that an artifact's list names, or the keys of its values by joint; each with its place."""
    order = stated_order(artifact)
    config = artifact.config
    found: dict[str, Span] = {}
    if order is not None:
        found = {name: order[1].place(name) for name in order[0] if name}
    elif config is not None and config.framework is Framework.DEPLOY:
        found = {name: group.span for group in config.groups for name in group.joints or ()}
    return {name: place for name, place in found.items() if not names_undriven(name)}


def _has(member: Artifact, name: str) -> bool:
    """Whether a file has a joint with a name, or anything else that is called so: a fixed joint, or an actuator."""
    if member.spec is not None:
        return any(joint.joint == name for joint in member.spec.joints)
    robot = member.robot
    if robot is None:
        return False
    quoted = (mark + name.encode() + mark for mark in (b'"', b"'"))
    return any(joint.name == name for joint in robot.joints) or any(map(member.states, quoted))


def selects(member: Artifact, name: str) -> bool:
    """Whether a configuration of a whole robot has a group for a joint."""
    config = member.config
    if config is None or config.framework not in FRAMEWORKS or not is_whole_robot(config):
        return False
    patterns = (pattern for group in config.groups for pattern in group.joints or ())
    return any(matching(config.framework, pattern, (name,)) for pattern in patterns)


def _meant(lost: Sequence[str], free: Sequence[str]) -> dict[str, str]:
    """Names that no joint has, each to the one joint without a name that it stands for.

    Where one of both is left over, they are each other's if they are near at all. Of several a joint is one's whose
    name has its words, or is misspelt.
    """
    if len(lost) == 1 == len(free):
        near = nearest(lost[0], [other for other in free if _are_near_by_word(lost[0], other)])
        return {lost[0]: near} if near is not None else {}
    near_ones = {
        name: [other for other in free if begin_alike(name, other) or is_misspelt(name, other)]
        for name in lost
    }
    meant = {name: near[0] for name, near in near_ones.items() if len(near) == 1}
    taken = list(meant.values())
    return {name: joint for name, joint in meant.items() if taken.count(joint) == 1}


def _of_its_side(lost: Sequence[str], free: Sequence[str], names: Sequence[str]) -> dict[str, str]:
    """The name that no joint has, to the joint of its side that a list leaves out: `right_foot` beside `left_ankle`.

    There is one of each: a lost name that has no like on the other side, and a joint that has its like there. Only a
    word for a part of a leg stands for another one, and likewise of an arm: a gripper, a tool or a camera is carried
    on one side as often, in a file that leaves out the joint there.

    Args:
        lost: Names of the list that no joint has.
        free: Joints that it leaves out.
        names: All of its names.
    """
    odd = [name for name in lost if across(name) and not {*across(name)} & {*names}]
    left_out = [joint for joint in free if {*across(joint)} & ({*names} - {*lost})]
    if len(odd) != 1 or len(left_out) != 1:
        return {}
    words = {*map(str.lower, other_word(odd[0], left_out[0]) or ("",))}
    return {odd[0]: left_out[0]} if any(words <= limb for limb in (LEG_WORDS, ARM_WORDS)) else {}


def _are_near_by_word(one: str, other: str) -> bool:
    """Whether each word of a name is nearly the other's: a tool or a gripper is no ankle of its side."""
    mine, its = plain_words(one), plain_words(other)
    pairs = [pair for pair in zip(mine, its, strict=False) if pair[0] != pair[1]]
    near = all(nearest(a, [b]) and not are_two_parts(a, b) for a, b in pairs)
    return near or "".join(mine) == "".join(its)


def is_misspelt(one: str, other: str) -> bool:
    """Whether two names differ by a letter inside a word. Sides, axes and numbers tell joints from each other, and are
    shorter than the four letters of a word here, or differ in the first one; an axis may end a word (`slidex`).
    """
    if are_two_parts(one, other) or not is_slip(one, [other]):
        return False
    mine, its = other_word(one, other) or ("", "")
    of_axes = mine.rstrip("xyzXYZ") == its.rstrip("xyzXYZ")
    return max(len(mine), len(its)) >= 4 and mine[0] == its[0] and not of_axes


def are_two_parts(one: str, other: str) -> bool:
    """Whether two names are of a wrist and of a waist: of the words in known robots' joints the only two parts whose
    words a slip would make of each other.
    """
    mine, its = one.lower(), other.lower()
    return mine != its and mine.replace("wrist", "waist") == its.replace("wrist", "waist")


def is_swapped(one: str, other: str) -> bool:
    """Whether two neighbouring letters of one word are the other way round in another: `hef` and `hfe`."""
    at = [index for index, pair in enumerate(zip(one, other, strict=False)) if pair[0] != pair[1]]
    return (
        len(one) == len(other)
        and len(at) == 2
        and at[1] == at[0] + 1
        and (one[at[0]], one[at[1]]) == (other[at[1]], other[at[0]])
    )
