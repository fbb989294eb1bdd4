"""Gains, torque limit and torque-speed line: what a NewtonActuator's own attributes hold.

Units of a NewtonActuator are radians and metres, other than those of the joint's prim.
Source: newton-usd-schemas 0.6.0, generatedSchema.usda; read back from Newton 1.8.0.
"""

from __future__ import annotations

import math

from actspec.targets.approximation import lined, static_error
from actspec.targets.newton.context import Joint, given, number
from actspec.targets.newton.usda import Attribute


def gain_attributes(joint: Joint) -> list[Attribute]:
    """`newton:kp`, `newton:kd` and the encoder bias, which is a constant torque of -kp * bias before the clamp."""
    actuator = joint.actuator
    found = []
    for name, quantity in (("newton:kp", actuator.kp), ("newton:kd", actuator.kd)):
        if quantity is not None and quantity.known:
            found.append(number(name, quantity))
        else:
            found.append(Attribute("float", name, "0.0"))
    bias = joint.law.encoder_bias
    if bias and joint.law.kp:
        note = f"-kp times the encoder's bias of {bias:g} {actuator.encoder_bias.unit}"
        found.append(given("newton:constEffort", -joint.law.kp * bias, joint.unit, note))
    return found


def clamps(joint: Joint) -> tuple[tuple[str, ...], list[Attribute]]:
    """API schemas and attributes of the clamp: a torque-speed line, or the effort limit alone."""
    law = joint.law
    if law.stall_torque is not None or law.curve is not None:
        return ("NewtonDCMotorClampingAPI",), _line(joint)
    if not math.isfinite(law.effort_limit):
        return (), []
    return ("NewtonMaxEffortClampingAPI",), [number("newton:maxEffort", joint.actuator.effort_limit)]


def _line(joint: Joint) -> list[Attribute]:
    actuator, law = joint.actuator, joint.law
    speed = actuator.velocity_limit.unit
    if law.curve is None:
        assert actuator.stall_torque is not None and actuator.no_load_speed is not None
        found = [
            number("newton:saturationEffort", actuator.stall_torque, "at standstill"),
            number("newton:velocityLimit", actuator.no_load_speed, "no-load speed"),
        ]
    else:
        line = _drive_side(joint)
        found = [
            given("newton:saturationEffort", line[0], joint.unit, "of the line through the curve's knee"),
            given("newton:velocityLimit", line[1], speed, "no-load speed"),
        ]
    limit = lined(law).effort_limit
    if actuator.effort_limit.value == limit:
        return [*found, number("newton:maxMotorEffort", actuator.effort_limit)]
    why = "the curve's" if math.isfinite(limit) else "no effort_limit is known"
    return [*found, given("newton:maxMotorEffort", limit, joint.unit, why)]


def _drive_side(joint: Joint) -> tuple[float, float]:
    """The drive side of an asymmetric curve, as a line through knee and no-load speed."""
    assert joint.law.curve is not None
    drive, brake, knee, no_load = joint.law.curve
    line = lined(joint.law)
    assert line.stall_torque is not None
    joint.approximate(
        "torque_speed_curve",
        f"curve: drive {joint.torque(drive)}, brake {joint.torque(brake)}, knee {knee:g}, no load {no_load:g}",
        f"line from {line.stall_torque:g} to {no_load:g}, cut at {line.effort_limit:g}",
        "Newton has one line for driving and braking",
        static_error(joint.law, line.torque),
    )
    return line.stall_torque, no_load
