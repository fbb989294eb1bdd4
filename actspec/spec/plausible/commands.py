"""Checks of what commands are clamped to, and of what one unit of action asks for."""

from __future__ import annotations

import math
from collections.abc import Iterator

from actspec.diagnostics import Span
from actspec.ir import Command, JointActuator, JointKind, Origin, Quantity, tidy
from actspec.poses import POSE_TOLERANCE
from actspec.spec.plausible.clamps import PART, WIDE, clamp_words, is_open, is_posed, turned_words
from actspec.spec.plausible.relations import DEGREE, RPM
from actspec.spec.plausible.swing import SOFT_ERROR, is_held
from actspec.spec.plausible.table import Found, found_at, is_stated, shown
from actspec.units import format_quantity

SCALE = 2.0
"""One unit of action over the joint's range and, by kp, over the effort limit."""
USUAL_SHARE = 0.25
"""Of the effort limit that one unit of action asks for by kp: mjlab computes scales so."""
RATE_SCALE = 10.0
"""One unit of action over the fastest speed or the effort limit."""
RANGE_SPEED = 5.0
"""Ends of a range of speeds over the fastest speed, where another unit brings them below it. Chosen: rpm are 9.5."""
HOPELESS_SCALE = 20.0
"""An error from this many times the bound on."""


def own_speed(joint: JointActuator) -> Quantity | None:
    """Speed at the joint [rad/s or m/s] at which its motor has no torque left, at whichever level; None: unknown."""
    line = joint.motor_line
    return None if line is None else line.no_load_speed if line.curve is None else line.curve.no_load_speed


def command_range_found(joint: JointActuator, poses: Span | None) -> Iterator[Found]:
    """A clamp of commands that is many times as wide as what the joint has, in another unit, or elsewhere.

    Args:
        joint: The joint.
        poses: As in `is_posed`.
    """
    clamp, own, hinge = joint.command_range, joint.position_range, joint.kind is JointKind.HINGE
    if clamp is None or not is_stated(clamp[0]):
        return
    low, high = clamp[0].value, clamp[1].value
    if low is None or high is None:
        return
    if joint.command is not Command.POSITION:
        yield from _rate_range(joint, clamp[0], low, high)
        return
    words = None
    if own is not None:
        words = clamp_words((low, high), own, hinge)
    elif hinge:
        words = turned_words((low, high))
    unit = clamp[0].unit
    message = f"a command range of {format_quantity(low, unit, 4)} to {format_quantity(high, unit, 4)}"
    ends = "" if own is None else " to ".join(format_quantity(end, unit, 4) for end in own)
    where = f"actuators.{joint.group}.command_range"
    if words is None:
        yield from _elsewhere(joint, poses, (low, high), message, ends, where)
        return
    ratio, help = words
    far = format_quantity(ratio, "", 3)
    message += f" is {far} " + (
        "turns wide" if own is None else f"times as wide as the joint's range, {ends}"
    )
    yield found_at(joint, "SPEC190", where, max(ratio, 1.0 / ratio), message, help, clamp[0])


def _elsewhere(
    joint: JointActuator, poses: Span | None, clamp: tuple[float, float], message: str, ends: str, where: str
) -> Iterator[Found]:
    """A clamp that lies outside of the joint's range, or keeps the command from the default position.

    Published: of 4549 servos with both ranges one is apart, by 0.016 rad; of 1942 with a pose it is 0.012 rad off.
    A pose outside of the joint's own range is told itself.
    """
    pose, own, tolerance = joint.default_position, joint.position_range, POSE_TOLERANCE[joint.kind]
    assert joint.command_range is not None
    (low, high), (least, most), number = clamp, own or (-math.inf, math.inf), joint.command_range[0]
    help = "it clamps the command itself, not its difference from the default position"
    help += "" if own is None else "; `command_range: joint` is the joint's own range"
    apart = max(low - most, least - high)
    if apart > tolerance:
        message += f" has nothing in common with the joint's range, {ends}"
        yield found_at(joint, "SPEC190", where, apart, message, help, number)
        return
    if pose.value is None or not is_posed(joint, poses):
        return
    beyond = max(low - pose.value, pose.value - high)
    if beyond > tolerance and least - tolerance <= pose.value <= most + tolerance:
        message += f" keeps the joint from its default position, {shown(pose)}"
        message += ", which no default_pose states" if pose.origin is Origin.DEFAULT else ""
        yield found_at(joint, "SPEC190", where, beyond, message, help, number, pose)


def _most(joint: JointActuator) -> Quantity:
    """Fastest speed of a joint whose command is one, else its effort limit."""
    if joint.command is not Command.VELOCITY:
        return joint.effort_limit
    speed = own_speed(joint)
    return speed if speed is not None and speed.value else joint.velocity_limit


def _slips(joint: JointActuator) -> list[tuple[float, str]]:
    """Units that a command is typed in without them, and their sizes."""
    if joint.command is not Command.VELOCITY:
        return [(1e-3, f"m{joint.effort_limit.unit}")]
    return [(RPM, "rpm"), (DEGREE, "deg/s")] if joint.kind is JointKind.HINGE else [(1e-3, "mm/s")]


def _rate_range(joint: JointActuator, end: Quantity, low: float, high: float) -> Iterator[Found]:
    """A range of speeds or torques far beyond what the joint has; powers of ten for both ends are placeholders."""
    most = _most(joint)
    reach = max(abs(low), abs(high))
    if not reach or not most.value or is_open(low, high):
        return
    ratio = reach / most.value
    units = [(size, name) for size, name in _slips(joint) if PART <= size * ratio <= 1.0]
    if ratio <= WIDE and not (ratio > RANGE_SPEED and units):
        return
    help = "; or ".join(f"is it in {name}? Then write [{low:g} {name}, {high:g} {name}]" for _, name in units)
    message = (
        f"a command range of {format_quantity(low, end.unit, 4)} to {format_quantity(high, end.unit, 4)}, "
        f"{format_quantity(ratio, '', 3)} times the {shown(most)} that the joint has"
    )
    where = f"actuators.{joint.group}.command_range"
    yield found_at(joint, "SPEC190", where, ratio, message, help or "look for a wrong unit", end, most)


def _span(joint: JointActuator) -> float | None:
    """How far the joint goes [rad or m]; None: that is unknown."""
    if joint.position_range is not None:
        return joint.position_range[1] - joint.position_range[0]
    return 2.0 * math.pi if joint.kind is JointKind.HINGE else None


def scale_found(joint: JointActuator) -> Iterator[Found]:
    """One unit of action against range, speed and effort limit; published: 0.41 of the range, 0.75 of the limit."""
    scale, limit = joint.action_scale, joint.effort_limit
    if scale is None or not scale.value:
        return
    reach = abs(scale.value)
    if joint.command is Command.POSITION:
        span = _span(joint)
        torque = None if joint.kp is None or not joint.kp.value else joint.kp.value * reach
        if torque is not None and torque < (joint.friction_coulomb.value or 0.0) and is_stated(scale):
            yield _unmoved(joint, scale, reach, torque)
            return
        if not span or reach <= SCALE * span:
            return
        if torque is not None and limit.value and torque <= SCALE * limit.value:
            return
        most, size, unit = limit, reach / span / SCALE, joint.default_position.unit
        words = (
            f"one unit of action is {format_quantity(reach, unit, 4)} of command, "
            f"{format_quantity(reach / span, '', 3)} times the joint's whole range"
        )
        if torque is not None and limit.value:
            words += f", and asks for {format_quantity(torque, limit.unit, 3)} of {shown(limit)}"
        readings = [(DEGREE, "degrees") if joint.kind is JointKind.HINGE else (1e-3, "mm")]
    else:
        most = _most(joint)
        if not most.value or reach <= RATE_SCALE * most.value:
            return
        span, size = most.value, reach / most.value / RATE_SCALE
        words = f"one unit of action is {format_quantity(reach, most.unit, 4)} of command, the joint has {shown(most)}"
        readings = _slips(joint) if joint.command is Command.VELOCITY else []
    readings += [(0.01, "%")] if size >= 5.0 else []
    # What would be beyond the joint again is not meant.
    readings = [reading for reading in readings if tidy(reading[0] * reach) <= span]
    if joint.command is Command.POSITION and joint.kp is not None and joint.kp.value and limit.value:
        share = joint.kp.value * reach / limit.value
        readings.sort(key=lambda reading: abs(math.log(share * reading[0] / USUAL_SHARE)))
    help = "; or ".join(
        f"is it in {unit}? Then write {scale.value * factor:.6g}" for factor, unit in readings
    )
    yield found_at(
        joint,
        "SPEC193",
        f"actuators.{joint.group}.action_scale",
        size,
        words,
        help or None,
        scale,
        joint.kp,
        most,
        error=size >= HOPELESS_SCALE,
    )


def _unmoved(joint: JointActuator, scale: Quantity, reach: float, torque: float) -> Found:
    """One unit of action that the joint's dry friction holds; policies give about one."""
    friction, unit = joint.friction_coulomb, joint.default_position.unit
    held = f"{format_quantity(torque, friction.unit, 3)}: the joint's own dry friction of {shown(friction)} holds it"
    kp, limit, viscous = joint.kp, joint.effort_limit, joint.friction_viscous
    kd = None if joint.kd is None else joint.kd.value
    if (
        kp is not None
        and joint.motor is not None
        and joint.kind is JointKind.HINGE
        and is_stated(kp)
        and limit.value
        and torque / DEGREE >= (friction.value or 0.0)
        and (
            limit.value > SOFT_ERROR * kp.require()
            or is_held(kp.require(), kd, friction.require(), viscous.value or 0.0)
        )
    ):
        # As by the joint's inertia, which only a compiled model tells.
        error = format_quantity((limit.value or 0.0) / kp.require(), "rad", 3)
        message = (
            f"kp {shown(kp)} needs an error of {error} for the effort limit, and one unit of action, "
            f"{format_quantity(reach, unit, 4)}, asks for {held}"
        )
        help = f"is it per degree? Per radian it is {format_quantity(kp.require() / DEGREE, kp.unit, 4)}, and kd 57.3 "
        where, size = f"actuators.{joint.group}.kp", (limit.value or 0.0) / kp.require()
        return found_at(
            joint,
            "SPEC192",
            where,
            size,
            message,
            f"{help}times as well",
            kp,
            joint.kd,
            limit,
            scale,
            friction,
        )
    words = f"one unit of action is {format_quantity(reach, unit, 4)} of command, and asks for {held}"
    help = "look for the point in the wrong place"
    if joint.kind is JointKind.HINGE and reach / DEGREE <= SCALE * (_span(joint) or 0.0):
        twice = format_quantity(reach / DEGREE, "", 4)
        help = f"is it turned from degrees into rad twice? Once it is {twice}. Or {help}"
    where, size = f"actuators.{joint.group}.action_scale", (friction.value or 0.0) / torque
    return found_at(joint, "SPEC193", where, size, words, help, scale, joint.kp, friction)
