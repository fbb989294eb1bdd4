"""What a URDF has no place for.

A URDF describes joints and no drives. Of most of a drive nothing is written at all, so there is no torque that
could differ: such an entry has no size. Two things are sized, because the file says something else in their
place: the torque-speed curve, of which the effort limit is left, and static friction, of which the sliding one is.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace

from actspec.ir import ActuatorSet, JointActuator, Level
from actspec.laws import law_of
from actspec.targets.approximation import static_error
from actspec.targets.base import Approximation
from actspec.units import format_quantity

Loss = tuple[str, str, str, str, float | None]
"""Field, what is asked for, what is emitted, why, and the largest difference in torque."""

_NO_DRIVE = "a URDF describes joints, not their drives"


def format_losses(actuators: ActuatorSet, target: str) -> Iterator[Approximation]:
    """What of the actuators is not in this format, joint by joint.

    Args:
        actuators: What the spec asks for.
        target: Name of the target.
    """
    for actuator in actuators.joints:
        for loss in (*_drive(actuator), *_passive(actuator)):
            yield Approximation(target, actuator.joint, *loss, actuator.effort_limit.unit)
    if actuators.delta_action is not None:
        file = os.path.basename(actuators.delta_action.network)
        yield Approximation(target, "", "delta_action", file, "none", _NO_DRIVE, None)


def _drive(actuator: JointActuator) -> Iterator[Loss]:
    for field in ("kp", "kd"):
        gain = getattr(actuator, field)
        if gain is not None and gain.known:
            yield field, format_quantity(gain.value, gain.unit), "none", _NO_DRIVE, None
    if actuator.level is Level.DC_MOTOR:
        yield _curve(actuator)
    if actuator.network is not None:
        yield "network", os.path.basename(actuator.network.file), "none", _NO_DRIVE, None
    if actuator.filter_cutoff is not None and actuator.filter_cutoff.known:
        cutoff = format_quantity(actuator.filter_cutoff.value, actuator.filter_cutoff.unit)
        yield "command_filter", cutoff, "none", _NO_DRIVE, None
    if actuator.command_range is not None:
        low, high = (format_quantity(end.value, end.unit) for end in actuator.command_range)
        yield "command_range", f"{low} to {high}", "none", _NO_DRIVE, None
    delay = actuator.delay
    if delay is not None:
        nominal = delay.nominal.value
        said = "unknown" if nominal is None else f"{nominal * 1e3:g} ms"
        if delay.low != delay.high:
            said += f", range {delay.low * 1e3:g} to {delay.high * 1e3:g} ms"
        yield "delay", said, "none", _NO_DRIVE, None
    if actuator.encoder_bias.value:
        bias = format_quantity(actuator.encoder_bias.value, actuator.encoder_bias.unit)
        yield "encoder_bias", bias, "none", _NO_DRIVE, None


def _curve(actuator: JointActuator) -> Loss:
    """The torque-speed line or curve, against a drive with the same gains and the effort limit alone."""
    torque, speed = actuator.effort_limit.unit, actuator.velocity_limit.unit
    stall, no_load, kind = actuator.stall_torque, actuator.no_load_speed, "line"
    if actuator.curve is not None:
        stall, no_load, kind = actuator.curve.drive_torque, actuator.curve.no_load_speed, "curve"
    ends = [
        "unknown" if end is None else format_quantity(end.value, unit)
        for end, unit in ((stall, torque), (no_load, speed))
    ]
    try:
        law = law_of(actuator)
        size = static_error(law, replace(law, stall_torque=None, no_load_speed=None, curve=None).torque)
    except ValueError:
        # The law lacks a number.
        size = None
    return (
        "torque_speed_curve",
        f"{kind} from {ends[0]} to {ends[1]}",
        f"effort {format_quantity(actuator.effort_limit.value, torque)}",
        "a URDF has one effort limit for all speeds",
        size,
    )


def _passive(actuator: JointActuator) -> Iterator[Loss]:
    armature, static = actuator.armature, actuator.friction_static
    if armature.value:
        asked = format_quantity(armature.value, armature.unit)
        yield "armature", asked, "none", "a URDF has no armature of a joint", None
    coulomb = actuator.friction_coulomb.value
    if static is None or static.value is None or coulomb is None or static.value <= coulomb:
        return
    yield (
        "friction.static",
        format_quantity(static.value, static.unit),
        format_quantity(coulomb, static.unit),
        "friction is one number for sticking and sliding",
        static.value - coulomb,
    )
    stribeck = actuator.stribeck_velocity
    if stribeck is not None and stribeck.known:
        yield (
            "friction.stribeck_velocity",
            format_quantity(stribeck.value, stribeck.unit),
            "none",
            "a URDF has no Stribeck effect",
            static.value - coulomb,
        )
