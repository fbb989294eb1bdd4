"""Gains, armature and friction, in the fields and units of a version."""

from __future__ import annotations

from dataclasses import replace

from actspec.ir import Command, JointActuator, Level, Quantity
from actspec.simulators.isaaclab import FrictionUnit, IsaacLabDialect
from actspec.targets.approximation import viscous_error
from actspec.targets.isaaclab.context import Field, Joint
from actspec.targets.isaaclab.losses import summed_viscous_error
from actspec.targets.python_text import stated
from actspec.units import format_quantity


def gain_fields(joint: Joint) -> list[Field]:
    """Stiffness and damping; passive viscous friction is in the latter where it has no field of its own."""
    actuator = joint.actuator
    stiffness = _gain(joint, "stiffness", actuator.kp, "no position command")
    damping = _gain(joint, "damping", actuator.kd, "no gain on the speed")
    viscous = actuator.friction_viscous
    if joint.dialect.viscous or not stated(viscous) or not viscous.require():
        return [stiffness, damping]
    value, asked = viscous.require(), format_quantity(viscous.value, viscous.unit)
    why = _no_field(joint, "viscous")
    if not viscous_in_damping(actuator, joint.dialect):
        error = viscous_error(joint.law, value, joint.speed_limit)
        joint.approximate("friction.viscous", asked, "none", why, error)
        return [stiffness, damping]
    assert isinstance(damping.value, float)
    total = damping.value + value
    joint.approximate(
        "friction.viscous",
        asked,
        f"in damping, {total:g} in all, inside the torque limit",
        why,
        summed_viscous_error(joint.law, value, joint.speed_limit),
    )
    note = f"{viscous.unit}; kd {damping.value:g} + passive viscous {value:g}"
    return [stiffness, replace(damping, value=total, note=note)]


def viscous_in_damping(actuator: JointActuator, dialect: IsaacLabDialect) -> float:
    """The passive viscous friction that is written as a part of `damping` [N*m*s/rad or N*s/m]."""
    viscous = actuator.friction_viscous
    if dialect.viscous or not stated(viscous) or actuator.level is Level.ACTUATOR_NET:
        return 0.0
    # With a speed command the sum would follow the command too.
    if actuator.command is Command.VELOCITY or (actuator.kd is not None and not actuator.kd.known):
        return 0.0
    return viscous.require()


def _gain(joint: Joint, name: str, quantity: Quantity | None, absent: str) -> Field:
    if quantity is None:
        return Field(name, 0.0, absent)
    if quantity.value is None:
        return Field(name, None, "unknown: the USD's own", scalar=True)
    return Field(name, quantity.value, joint.note(quantity))


def joint_fields(joint: Joint, *, summed: bool = True) -> list[Field]:
    """Armature and friction of the joint, in the units of the solver.

    Args:
        summed: Whether `gain_fields` takes a viscous friction that has no field; a network's class has none.
    """
    actuator = joint.actuator
    fields = []
    if stated(actuator.armature):
        fields.append(Field("armature", actuator.armature.require(), joint.note(actuator.armature)))
    fields += _dry_friction(joint)
    viscous = actuator.friction_viscous
    if stated(viscous):
        if joint.dialect.viscous:
            fields.append(Field("viscous_friction", viscous.require(), joint.note(viscous)))
        elif not summed and viscous.require():
            joint.approximate(
                "friction.viscous",
                format_quantity(viscous.value, viscous.unit),
                "none",
                _no_field(joint, "viscous"),
                viscous_error(joint.law, viscous.require(), joint.speed_limit),
            )
    return fields


def _dry_friction(joint: Joint) -> list[Field]:
    coulomb, static = joint.actuator.friction_coulomb, joint.actuator.friction_static
    kinetic = coulomb.require() if stated(coulomb) else None
    sticking = static.require() if static is not None and static.known else None
    if kinetic is None and sticking is None:
        return []
    unit = joint.dialect.friction
    stuck = static if sticking is not None else None
    _no_stribeck(joint, sticking, kinetic)
    if unit is FrictionUnit.EFFORT:
        return _effort_friction(joint, coulomb, stuck, kinetic)
    if unit is FrictionUnit.EFFORT_ONE:
        named = stuck if kinetic is None and stuck is not None else coulomb
        value = named.require()
        if sticking is not None and sticking != value:
            joint.approximate(
                "friction.static",
                format_quantity(sticking, joint.unit),
                format_quantity(value, joint.unit),
                "the Newton backend has one dry friction for sticking and sliding",
                sticking - value,
            )
        return [Field("friction", value, joint.note(named))]
    largest = max(kinetic or 0.0, sticking or 0.0)
    if largest == 0.0 and unit is not FrictionUnit.DEAD:
        # No friction is none in every unit.
        both = ["friction"] + ["dynamic_friction"] * (unit is FrictionUnit.COEFFICIENT_VISCOUS)
        return [Field(name, 0.0, "none, in every unit") for name in both]
    if largest > 0.0:
        asked = format_quantity(largest, joint.unit)
        why = _no_field(joint, "dry")
        for name, torque in (("coulomb", kinetic), ("static", sticking)):
            if torque and not (name == "static" and torque == kinetic):
                joint.approximate(
                    f"friction.{name}", format_quantity(torque, joint.unit), "left out", why, torque
                )
        cure = (
            f"raise `friction` until the joint starts to move at {asked}"
            if unit is not FrictionUnit.DEAD
            else "update Isaac Lab, or set it through the PhysX view after the start"
        )
        joint.remarks.append(f"friction is left out, {asked} asked for: {why}. To calibrate: {cure}.")
    return []


def _effort_friction(
    joint: Joint, coulomb: Quantity, static: Quantity | None, kinetic: float | None
) -> list[Field]:
    """Static and dynamic friction as torques; PhysX needs dynamic <= static."""
    first = static if static is not None else coulomb
    fields = [Field("friction", first.require(), f"static, {joint.note(first)}")]
    if kinetic is not None:
        fields.append(Field("dynamic_friction", kinetic, f"sliding, {joint.note(coulomb)}"))
    else:
        joint.remarks.append("Nobody states the sliding friction: the USD's own.")
    return fields


def _no_stribeck(joint: Joint, sticking: float | None, kinetic: float | None) -> None:
    """Report the Stribeck effect as lost, if there is one; no solver has it."""
    stribeck = joint.actuator.stribeck_velocity
    if sticking is None or stribeck is None or not stribeck.known or sticking <= (kinetic or 0.0):
        return
    joint.approximate(
        "friction.stribeck_velocity",
        format_quantity(stribeck.value, stribeck.unit),
        "none",
        "the solver goes from static to sliding friction at once"
        if joint.dialect.friction is FrictionUnit.EFFORT
        else "no solver has a Stribeck effect",
        sticking - (kinetic or 0.0),
    )


def _no_field(joint: Joint, kind: str) -> str:
    """Why a friction cannot be written."""
    where = f"Isaac Lab {joint.dialect.text} on Isaac Sim {joint.dialect.sim_text}"
    unit = joint.dialect.friction
    if unit is FrictionUnit.DEAD:
        return f"{where} never writes friction to the solver"
    if kind == "viscous":
        return f"{where} has no viscous friction of a joint"
    return f"in {where} ({joint.dialect.backend_text}) it is a factor on the joint's load, not a torque"
