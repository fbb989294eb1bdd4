"""Default positions against the range of their joint: those of a spec, and those of a configuration."""

from __future__ import annotations

import math

from actspec.fields import units_of
from actspec.joints import JointKind
from actspec.units import format_quantity

POSE_TOLERANCE = {JointKind.HINGE: 0.05, JointKind.SLIDE: 0.005}
"""A default position may be this far beyond the range [rad or m]."""


def outside_words(
    kind: JointKind, limits: tuple[float, float], pose: float, tolerance: float
) -> tuple[float, str, str | None] | None:
    """How far a default position is beyond the joint's range, a message and a help; None where it is not.

    Args:
        kind: Of the joint.
        limits: Its range [rad or m].
        pose: The default position [rad or m].
        tolerance: How far it may be beyond [rad or m].
    """
    low, high = limits
    beyond = max(low - pose, pose - high)
    if beyond <= tolerance:
        return None
    help, near = None, POSE_TOLERANCE[kind]
    unit = units_of(kind).position
    # No joint but a wheel turns further, so that it may be the sign.
    turned = kind is JointKind.HINGE and abs(pose) > math.pi
    if low <= -pose <= high and not turned:
        help = f"is the sign wrong? {format_quantity(-pose, unit)} is inside"
        if kind is JointKind.HINGE:
            help += f", {math.degrees(-pose):.4g} deg"
    elif kind is JointKind.HINGE and low - near <= math.radians(pose) <= high + near:
        help = f"is it in degrees? Then write {pose:g} deg, {format_quantity(math.radians(pose), unit, 4)}"
    elif kind is JointKind.SLIDE and low - near <= pose * 1e-3 <= high + near:
        help = f"is {'the point wrong, or is ' * (low <= 0.1 * pose <= high)}it in mm? Then write {pose:g} mm"
    message = (
        f"the default position {format_quantity(pose, unit, 4)} is outside of the joint's range, "
        f"{format_quantity(low, unit, 4)} to {format_quantity(high, unit, 4)}"
    )
    return beyond, message, help


def far_words(pose: float) -> tuple[str, str] | None:
    """Message and help of a hinge's default position that is more than a turn from its zero; None where it is not.

    Args:
        pose: The default position [rad].
    """
    turn = 2.0 * math.pi
    if abs(pose) <= turn + POSE_TOLERANCE[JointKind.HINGE]:
        return None
    turns = format_quantity(abs(pose) / turn, "turns", 3)
    message = f"the default position {format_quantity(pose, 'rad', 4)} is {turns} from the joint's zero"
    return (
        message,
        f"is it in degrees? Then write {pose:g} deg, {format_quantity(math.radians(pose), 'rad', 4)}",
    )
