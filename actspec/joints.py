"""What is known of a joint without its actuator; apart from the `ir`, of which a reader of models needs no more."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

SIDES = (
    ("left", "right"), ("l", "r"), ("fl", "fr"), ("rl", "rr"), ("hl", "hr"), ("bl", "br"), ("ml", "mr"),
    ("lf", "rf"), ("lh", "rh"), ("lb", "rb"), ("lm", "rm"),
)  # fmt: skip
"""Words for the sides, in lower case. Chosen: from the joint names in the surveyed repositories."""

SIDE_WORDS = frozenset(word for sides in SIDES for word in sides)

# fmt: off
LEG_WORDS = frozenset((
    "hip", "thigh", "calf", "knee", "ankle", "leg", "foot", "shank", "shin", "toe", "toes", "abduct", "abduction",
    "coxa", "femur", "tibia", "tarsus",
))
# fmt: on
"""Words for parts of a leg in joints' names, in lower case."""

ARM_WORDS = frozenset(["shoulder", "elbow", "wrist", "arm", "forearm", "clavicle", "humerus", "radius"])
"""Words for parts of an arm, likewise; a hand is a device as often, and not here."""


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
