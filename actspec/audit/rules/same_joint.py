"""Which joints of one name in two files of a robot are one: two arms of one base have `joint3` each."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

from actspec.audit.case import Case
from actspec.audit.rules.sided import are_of_two_sides
from actspec.joints import plain_words
from actspec.readings.artifact import Artifact
from actspec.readings.body import are_two_limbs, figures_of
from actspec.readings.called import stem_of
from actspec.readings.joint_names import last_numbers, series
from actspec.robot.view import NAMELESS

_LEAST = 4
"""Joints that a limb has. Chosen: fingers and a wrist are of the arm that has them, and told with it."""


_ELSEWHERE = 0.005
"""From this distance on joints stand in two places [m]. Chosen: drawings of one robot agree to a millimetre; half the
difference of the tracks of two rovers is 8 mm."""


def is_one_joint(case: Case, one: int, other: int, joint: str) -> bool:
    """Whether a joint of two files may be one: its series goes as far, and the limb that has it is one machine's.

    The rest of the robot says nothing of it: two arms on one kind of quadruped have the figures of its legs in common.

    Args:
        case: The case.
        one: An artifact.
        other: Another one; of a file that is no model only the series is known.
        joint: Name of the joint in both.
    """
    return _counts_alike(case, one, other, joint) and not case.once(_limbs)(one, other, joint)


def are_of_two_products(case: Case, one: int, other: int, joint: str) -> bool:
    """Whether two files of one format may be of two machines of one maker, with an arm in common, say, as to a joint.

    Each is called by a word that the other has not, by its file's where the model has no name, and the joint stands
    elsewhere: a rover with mecanum wheels and one with plain ones, on another track. What is only added to a name, or
    only a number, is a version's.
    """
    artifacts = case.artifacts[one], case.artifacts[other]
    if artifacts[0].kind is not artifacts[1].kind:
        return False
    names = [stem_of(each.path) if each.name == NAMELESS else each.name for each in artifacts]
    words = [{word for word in plain_words(name) if word.isalpha()} for name in names]
    views = [artifact.robot.joint(joint) if artifact.robot is not None else None for artifact in artifacts]
    points = [view.point for view in views if view is not None and view.point is not None]
    apart = len(points) == 2 and math.dist(*points) > _ELSEWHERE
    return apart and bool(words[0] - words[1]) and bool(words[1] - words[0])


def _counts_alike(case: Case, one: int, other: int, joint: str) -> bool:
    """Whether the series of a numbered joint goes as far in both files: the 4th of 6 is not the 4th of 7."""
    key = series(joint)
    last = case.once(_last_numbers)
    ends = {last[index].get(key) for index in (one, other)} if key is not None else {None}
    return len(ends - {None}) < 2


def _last_numbers(case: Case) -> list[dict[tuple[str, str], int]]:
    """How far the numbered joints of each artifact go."""
    return [
        last_numbers(joint for joint in case.joints_by_artifact.get(index, {}) if artifact.robot is not None)
        for index, artifact in enumerate(case.artifacts)
    ]


def _limbs(case: Case) -> Callable[[int, int, str], bool]:
    """Tells of two artifacts and a joint whether they are models whose limbs that have it are of two machines."""
    figures = cache(lambda index: figures_of(case.artifacts[index].robot))
    limbs = cache(lambda index: _limbs_of(case.artifacts[index]))

    @cache
    def differ(one: int, other: int, limb: frozenset[str]) -> bool:
        mirrored = are_of_two_sides(case, one, other)
        return are_two_limbs(figures(one), figures(other), limb, mirrored=mirrored)

    def are_two(one: int, other: int, joint: str) -> bool:
        shared = limbs(one).of(joint) & limbs(other).of(joint)
        return bool(shared) and differ(one, other, shared)

    return are_two


@dataclass(frozen=True, slots=True)
class _Limbs:
    """The limbs of a model: what hangs, joint by joint, on the base, or on a body that carries several.

    Attributes:
        order: The joints, each followed by all that hang on it.
        spans: Joint to the part of `order` that is its limb.
    """

    order: tuple[str, ...]
    spans: Mapping[str, tuple[int, int]]

    def of(self, joint: str) -> frozenset[str]:
        """The joints of a joint's limb; none where that is the whole robot."""
        start, end = self.spans.get(joint, (0, len(self.order)))
        return frozenset(self.order[start:end] if end - start < len(self.order) else ())


def _limbs_of(artifact: Artifact) -> _Limbs:
    """The limbs of an artifact's model; without any of what is none."""
    parents = {joint.name: joint.parent for joint in artifact.robot.scalar_joints} if artifact.robot else {}
    below: dict[str, list[str]] = {}
    for name, parent in parents.items():
        below.setdefault(parent if parent in parents else "", []).append(name)
    order: list[str] = []
    waiting = below.get("", [])[::-1]
    while waiting:
        order.append(waiting.pop())
        waiting += reversed(below.get(order[-1], ()))
    size: dict[str, int] = {}
    for name in reversed(order):
        size[name] = 1 + sum(size[each] for each in below.get(name, ()))
    spans: dict[str, tuple[int, int]] = {}
    for start, name in enumerate(order):
        above = spans.get(parents[name])
        is_part = above is not None and (len(below[parents[name]]) == 1 or size[name] < _LEAST)
        spans[name] = above if above is not None and is_part else (start, start + size[name])
    return _Limbs(tuple(order), spans)
