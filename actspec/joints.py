"""What is known of a joint without its actuator; apart from the `ir`, of which a reader of models needs no more."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from enum import Enum

SIDES = (
    ("left", "right"), ("l", "r"), ("fl", "fr"), ("rl", "rr"), ("hl", "hr"), ("bl", "br"), ("ml", "mr"),
    ("lf", "rf"), ("lh", "rh"), ("lb", "rb"), ("lm", "rm"),
)  # fmt: skip
"""Words for the sides, in lower case. Chosen: from the joint names in the surveyed repositories."""

SIDE_WORDS = frozenset(word for sides in SIDES for word in sides)

END_WORDS = frozenset({"front", "fore", "rear", "back", "hind"})
"""Words for the ends of a robot on legs or wheels, likewise; `middle` is a finger too, and not here."""

WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[0-9]+|[^A-Za-z0-9]+")
"""A word or number of a joint's name, or what stands between two: `LHipPitch` has three words, and so has `l_hip1`."""

LETTERS = re.compile(r"[^\W\d_]{3,}")
"""Words of a name, or of a pattern, that a slip may have changed: sides and axes are shorter."""

# fmt: off
LEG_WORDS = frozenset((
    "hip", "thigh", "calf", "knee", "ankle", "leg", "foot", "shank", "shin", "toe", "toes", "abduct", "abduction",
    "coxa", "femur", "tibia", "tarsus",
))
# fmt: on
"""Words for parts of a leg in joints' names, in lower case."""

ARM_WORDS = frozenset(["shoulder", "elbow", "wrist", "arm", "forearm", "clavicle", "humerus", "radius"])
"""Words for parts of an arm, likewise; a hand is a device as often, and not here."""


def other_word(one: str, other: str) -> tuple[str, str] | None:
    """The word that one name has, wherever it differs, in the place of another one's; None where there are several."""
    mine, its = WORD.findall(one), WORD.findall(other)
    if len(mine) != len(its):
        return None
    apart = {pair for pair in zip(mine, its, strict=True) if pair[0] != pair[1]}
    return apart.pop() if len(apart) == 1 else None


def respelt(name: str, near: Callable[[str], Iterable[str]]) -> Iterator[str]:
    """What a name, or a pattern, may have been: with one of its words as others have it.

    Args:
        name: As it is written.
        near: The words that may stand in the place of one.
    """
    for found in LETTERS.finditer(name):
        for word in near(found[0]):
            yield f"{name[: found.start()]}{word}{name[found.end() :]}"


def plain_words(name: str) -> list[str]:
    """The words and numbers of a name in lower case, whatever divides them; a capital letter begins none."""
    return re.findall(r"[a-z]+|\d+", name.lower())


def begin_alike(one: str, other: str) -> bool:
    """Whether two names have the same words and numbers, in letters of any size, as far as the shorter one goes."""
    mine, its = plain_words(one), plain_words(other)
    least = min(len(mine), len(its))
    return least > 0 and mine[:least] == its[:least]


class JointKind(str, Enum):
    """Kind of a joint; only hinge and slide can have an actuator here."""

    HINGE = "hinge"
    SLIDE = "slide"
    BALL = "ball"
    FREE = "free"

    @property
    def is_scalar(self) -> bool:
        """Whether the joint has one coordinate."""
        return self in (JointKind.HINGE, JointKind.SLIDE)


@dataclass(frozen=True, slots=True)
class InertiaRange:
    """Inertia at a joint, armature included [kg*m^2 or kg].

    Attributes:
        reference: At the reference pose.
        low: Least over the poses.
        high: Largest over the poses.
    """

    reference: float
    low: float
    high: float
