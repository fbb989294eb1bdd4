"""Gains, torque limit and torque-speed line: the fields of the drive itself."""

from __future__ import annotations

import math

from actspec.targets.approximation import lined, static_error
from actspec.targets.mjlab.context import Field, Joint, number
from actspec.targets.python_text import py

NO_LINE = 1e9
"""Stall torque and no-load speed that leave only effort_limit [N*m, rad/s], where a class must have a line."""


def gain_fields(joint: Joint, *, always: bool = False) -> list[Field]:
    """Stiffness and damping, mjlab's names of kp and kd; `always`: 0 where the law has none."""
    found = []
    for name, quantity in (("stiffness", joint.actuator.kp), ("damping", joint.actuator.kd)):
        if quantity is not None and quantity.known:
            found.append(number(name, quantity))
        elif always:
            found.append(Field(name, "0.0"))
    return found


def limit_fields(joint: Joint, limit: float, *, required: bool = False) -> list[Field]:
    """`effort_limit`; left out where nobody knows it and the class takes that."""
    asked = joint.actuator.effort_limit
    if math.isfinite(limit):
        if asked.value == limit:
            return [number("effort_limit", asked)]
        return [Field("effort_limit", py(limit), f"{joint.unit}, the curve's")]
    if required:
        joint.collector.error(
            "MJL002",
            "effort_limit is unknown, and the class that mjlab has for it needs a number",
            where=f"{joint.where}.effort_limit",
            span=asked.span or joint.actuator.span,
            help="state effort_limit, or peak_torque of the motor",
        )
    return []


def line_fields(joint: Joint) -> list[Field]:
    """Limit and torque-speed line."""
    actuator, law = joint.actuator, joint.law
    if law.curve is not None:
        return _curve_fields(joint, law.curve)
    limit = limit_fields(joint, law.effort_limit, required=True)
    if law.stall_torque is None:
        why = "no torque-speed line: effort_limit alone"
        names = ("saturation_effort", "velocity_limit")
        return [*limit, *(Field(name, py(NO_LINE), why) for name in names)]
    assert actuator.stall_torque is not None and actuator.no_load_speed is not None
    return [
        *limit,
        number("saturation_effort", actuator.stall_torque, "at standstill"),
        number("velocity_limit", actuator.no_load_speed, "no-load speed"),
    ]


def _curve_fields(joint: Joint, curve: tuple[float, float, float, float]) -> list[Field]:
    """The drive side of an asymmetric curve, as a line through knee and no-load speed."""
    drive, brake, knee, no_load = curve
    line = lined(joint.law)
    assert line.stall_torque is not None
    speed = joint.actuator.velocity_limit.unit
    joint.approximate(
        "torque_speed_curve",
        f"curve: drive {joint.torque(drive)}, brake {joint.torque(brake)}, knee {knee:g}, no load {no_load:g}",
        f"line from {line.stall_torque:g} to {no_load:g}, cut at {line.effort_limit:g}",
        "mjlab has one line for driving and braking",
        static_error(joint.law, line.torque),
    )
    return [
        *limit_fields(joint, line.effort_limit),
        Field(
            "saturation_effort",
            py(line.stall_torque),
            f"{joint.unit}, of the line through the curve's knee",
        ),
        Field("velocity_limit", py(no_load), f"{speed}, no-load speed"),
    ]
