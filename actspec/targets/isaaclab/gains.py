"""Gains, armature and friction, in the fields and units of a version."""

from __future__ import annotations

from dataclasses import replace

from actspec.ir import Command, Quantity
from actspec.targets.approximation import lined
from actspec.targets.isaaclab.context import Field, Joint
from actspec.targets.isaaclab.losses import lost_viscous, summed_viscous_error
from actspec.targets.isaaclab.versions import FrictionUnit
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
    # With a speed command the sum would follow the command too.
    if actuator.command is Command.VELOCITY or damping.value is None:
        joint.approximate("friction.viscous", asked, "none", why, lost_viscous(joint.law, value))
        return [stiffness, damping]
    assert isinstance(damping.value, float)
    total = damping.value + value
    joint.approximate(
        "friction.viscous",
        asked,
        f"in damping, {total:g} in all, inside the torque limit",
        why,
        summed_viscous_error(joint.law, value),
    )
    note = f"{viscous.unit}; kd {damping.value:g} + passive viscous {value:g}"
    return [stiffness, replace(damping, value=total, note=note)]


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
                lost_viscous(lined(joint.law), viscous.require()),
            )
    return fields


def _dry_friction(joint: Joint) -> list[Field]:
    coulomb, static = joint.actuator.friction_coulomb, joint.actuator.friction_static
    kinetic = coulomb.require() if stated(coulomb) else None
    sticking = static.require() if static is not None and static.known else None
    if kinetic is None and sticking is None:
        return []
    largest = max(kinetic or 0.0, sticking or 0.0)
    unit = joint.dialect.friction
    if unit is FrictionUnit.EFFORT:
        return _effort_friction(joint, coulomb, static if sticking is not None else None, kinetic)
    if unit is FrictionUnit.EFFORT_ONE:
        named = coulomb if kinetic is not None or static is None else static
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
    if largest == 0.0 and unit is not FrictionUnit.DEAD:
        # No friction is none in every unit.
        both = ["friction"] + ["dynamic_friction"] * (unit is FrictionUnit.COEFFICIENT_VISCOUS)
        return [Field(name, 0.0, "none, in every unit") for name in both]
    if largest > 0.0:
        asked = format_quantity(largest, joint.unit)
        why = _no_field(joint, "dry")
        joint.approximate("friction.coulomb", asked, "left out", why, largest)
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
    stribeck = joint.actuator.stribeck_velocity
    if static is not None and stribeck is not None and stribeck.known and static.require() > (kinetic or 0.0):
        joint.approximate(
            "friction.stribeck_velocity",
            format_quantity(stribeck.value, stribeck.unit),
            "none",
            "PhysX goes from static to dynamic friction at once",
            static.require() - (kinetic or 0.0),
        )
    return fields


def _no_field(joint: Joint, kind: str) -> str:
    """Why a friction cannot be written."""
    where = f"Isaac Lab {joint.dialect.text} on Isaac Sim {joint.dialect.sim_text}"
    unit = joint.dialect.friction
    if unit is FrictionUnit.DEAD:
        return f"{where} never writes friction to the solver"
    if kind == "viscous":
        return f"{where} has no viscous friction of a joint"
    return f"in {where} ({joint.dialect.backend_text}) it is a factor on the joint's load, not a torque"
