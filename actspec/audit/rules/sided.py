"""Which joints, and which files, are the left and right of one, by the words of their names."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from functools import lru_cache

from actspec.audit.case import Case
from actspec.joints import END_WORDS, SIDE_WORDS, SIDES, WORD
from actspec.readings.artifact import Artifact, Robot

_RIGHT = {form(left): form(right) for left, right in SIDES for form in (str.lower, str.upper, str.capitalize)}

_LEFT = {right: left for left, right in _RIGHT.items()}

_OF_A_LEG = SIDE_WORDS | END_WORDS | {"middle", "mid"}
"""Words that tell a leg or a wheel from the others."""

_OF_FILES = {"left": {"left", "l", "lh"}, "right": {"right", "r", "rh"}}
"""Words for the side that a file is of. Chosen: others are names of folders and robots (`rl`, `ml`, `fr3`, `rm65`)."""

_MIRROR = "mirrored"
_MIRRORED = frozenset({"mirror", _MIRROR})
"""Words for a file that is of the other side than the one that it was made of, whichever that is."""

_FOLDERS = 3
"""Folders above a file that may tell its side. Chosen: `hand_left/urdf/hand.urdf` and one more."""


def other_side(name: str, names: Collection[str]) -> str | None:
    """Which of the names is the other side's of a joint, if one is."""
    return next((other for other in across(name) if other in names), None)


@lru_cache(maxsize=4096)
def mirrors(name: str) -> tuple[str, ...]:
    """What a left joint's name may be on the right: one of its words changed, or all of them."""
    return _with_others(name, _RIGHT)


@lru_cache(maxsize=4096)
def across(name: str) -> tuple[str, ...]:
    """What a joint's name may be on the other side, whichever that is; none of a joint in the middle."""
    return (*mirrors(name), *_with_others(name, _LEFT))


def _with_others(name: str, sides: Mapping[str, str]) -> tuple[str, ...]:
    """A name with one of its words for a side changed, or all of them."""
    words = WORD.findall(name)
    at = [index for index, word in enumerate(words) if word in sides]
    return tuple(
        "".join(sides[word] if index in chosen else word for index, word in enumerate(words))
        for chosen in (*([index] for index in at), at)
        if chosen
    )


def of_its_leg(name: str) -> str:
    """A joint's name without what tells its leg or wheel from the others: that of `FL_hip` and of `RR_hip`."""
    words = WORD.findall(name)
    return "".join("-" if word.lower() in _OF_A_LEG else word for word in words)


def robots_of_one_side(case: Case) -> tuple[Robot, ...]:
    """The robots of a case; one of which files say left and others right, or some mirrored, is two.

    A left and a right hand have joints of one name, whose axes and ranges are mirror images as they should be.
    """
    return tuple(part for robot in case.robots for part in _of_one_side(case, robot))


def are_of_two_sides(case: Case, one: int, other: int) -> bool:
    """Whether of two artifacts one says left and the other right, or one of them mirrored."""
    sides = case.once(_sides)
    return _are_two({sides[one], sides[other]})


def _are_two(sides: set[str]) -> bool:
    """Whether files that say this are of two sides."""
    return {"left", "right"} <= sides or (_MIRROR in sides and len(sides) > 1)


def _sides(case: Case) -> tuple[str, ...]:
    """The side of each artifact."""
    return tuple(map(_side_of, case.artifacts))


def _of_one_side(case: Case, robot: Robot) -> Iterable[Robot]:
    sides = {index: case.once(_sides)[index] for index in robot.artifacts}
    if not _are_two(set(sides.values())):
        return (robot,)
    # A file that says neither may be of either: it is held to others that say neither.
    return (
        replace(robot, artifacts=tuple(index for index, its in sides.items() if its == side))
        for side in dict.fromkeys(sides.values())
    )


def _side_of(artifact: Artifact) -> str:
    """`left`, `right` or `mirrored`, by the names of its file, of what that includes, of the model and of the folders;
    else "".
    """
    path = os.path.abspath(artifact.path)
    included = () if artifact.robot is None else artifact.robot.files[1:]
    stems = [" ".join(os.path.splitext(os.path.basename(file.path))[0] for file in included)]
    folders = os.path.dirname(path).split(os.sep)[: -_FOLDERS - 1 : -1]
    for text in (os.path.splitext(os.path.basename(path))[0], *stems, artifact.name, *folders):
        words = {word.lower() for word in WORD.findall(text)}
        if words & _MIRRORED:
            return _MIRROR
        sides = [side for side, said in _OF_FILES.items() if words & said]
        if len(sides) == 1:
            return sides[0]
    return ""
