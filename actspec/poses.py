"""Default positions against the range of their joint: those of a spec, and those of a configuration."""

from __future__ import annotations

import math

from actspec.fields import units_of
from actspec.joints import JointKind
from actspec.units import format_quantity

POSE_TOLERANCE = {JointKind.HINGE: 0.05, JointKind.SLIDE: 0.005}
"""A default position may be this far beyond the range [rad or m]."""
MOST_TURNED = 4.0 * math.pi
"""An angle of two turns or less may be meant as one within half a turn [rad]."""
ROUNDED_ANGLE = 2e-3
"""Round angles in rad, pi/12 apart, are typed to this [rad]."""

_SIZES = {"deg": math.pi / 180.0, "mm": 1e-3}
"""Other units that positions are written in [rad, m]."""


def is_round_angle(angle: float) -> bool:
    """Whether an angle [rad] is a multiple of 15 degrees, as one types it in rad: 1.57, 0.785."""
    return abs(math.remainder(angle, math.pi / 12.0)) <= ROUNDED_ANGLE


def outside_words(
    kind: JointKind, limits: tuple[float, float], pose: float, tolerance: float, own: str = ""
) -> tuple[float, str, str | None] | None:
    """How far a default position is beyond the joint's range, a message and a help; None where it is not.

    Args:
        kind: Of the joint.
        limits: Its range [rad or m].
        pose: The default position [rad or m].
        tolerance: How far it may be beyond [rad or m].
        own: The unit that it is written in, as `deg` or `mm`; empty: rad or m.
    """
    low, high = limits
    beyond = max(low - pose, pose - high)
    if beyond <= tolerance:
        return None
    near, hinge, unit = POSE_TOLERANCE[kind], kind is JointKind.HINGE, units_of(kind).position
    same = _turned(pose, (low + high) / 2.0)
    inside = hinge and low <= same <= high and abs(pose) <= MOST_TURNED
    help = f"the same angle inside is {_angle(same, own)}" if inside else None
    meant = None
    # No joint but a wheel turns further, so that it may be the sign.
    if low <= -pose <= high and not (hinge and abs(pose) > math.pi):
        meant = f"is the sign wrong? {shown_in(-pose, unit, own, 6)} is inside"
        if hinge and own != "deg":
            meant += f", {math.degrees(-pose):.4g} deg"
    elif hinge and low - near <= math.radians(pose) <= high + near:
        if own != "deg" and not (inside and is_round_angle(pose)):
            meant = _in_degrees(pose)
        elif own == "deg" and abs(pose) > MOST_TURNED:
            meant = f"is it turned into degrees twice? Then write {pose:.4g} deg"
    elif kind is JointKind.SLIDE and own != "mm" and low - near <= pose * 1e-3 <= high + near:
        meant = (
            f"is {'the point wrong, or is ' * (low <= 0.1 * pose <= high)}it in mm? Then write {pose:g} mm"
        )
    help = ". Or ".join(filter(None, (meant, help))) or None
    ends = " to ".join(shown_in(end, unit, own) for end in limits)
    message = f"the default position {shown_in(pose, unit, own)} is outside of the joint's range, {ends}"
    return beyond, message, help


def far_words(pose: float, own: str = "") -> tuple[str, str] | None:
    """Message and help of a hinge's default position that is more than a turn from its zero; None where it is not.

    Args:
        pose: The default position [rad].
        own: As in `outside_words`.
    """
    turn = 2.0 * math.pi
    if abs(pose) <= turn + POSE_TOLERANCE[JointKind.HINGE]:
        return None
    turns = format_quantity(abs(pose) / turn, "turns", 3)
    message = f"the default position {shown_in(pose, 'rad', own)} is {turns} from the joint's zero"
    if own == "deg":
        return message, f"the same angle within half a turn is {_angle(_turned(pose, 0.0), own)}"
    return message, _in_degrees(pose)


def _in_degrees(pose: float) -> str:
    """What is meant by degrees that were read as rad."""
    return f"is it in degrees? Then write {pose:g} deg, {format_quantity(math.radians(pose), 'rad', 4)}"


def _turned(pose: float, middle: float) -> float:
    """The same angle nearest to the middle of a range [rad]."""
    return middle + math.remainder(pose - middle, 2.0 * math.pi)


def _angle(pose: float, own: str) -> str:
    """An angle [rad] as one writes it, first in the unit of who asks."""
    both = [shown_in(pose, "rad", ""), shown_in(pose, "rad", "deg")]
    return ", ".join(reversed(both) if own == "deg" else both)


def shown_in(position: float, unit: str, own: str, digits: int = 4) -> str:
    """A position [rad or m] in the unit that it is written in."""
    if own not in _SIZES:
        return format_quantity(position, unit, digits)
    return f"{position / _SIZES[own]:.4g} {own}"
