"""Armature, friction and limits of the joint's own prim, and what it cannot hold.

A joint's prim counts in degrees where a NewtonActuator counts in radians: viscous friction is N*m*s/deg, a speed
limit deg/s. Armature and dry friction have no angle in them.
Source: newton-usd-schemas 0.6.0, NewtonJointAPI; read back from Newton 1.4.0 to 1.8.0, where 1 N*m*s/deg is 57.3
N*m*s/rad, and a slide's numbers stay.
"""

from __future__ import annotations

import math

from actspec.ir import Quantity
from actspec.targets.approximation import viscous_error
from actspec.targets.newton.context import Joint, given, number
from actspec.targets.newton.usda import Attribute
from actspec.targets.python_text import provenance, stated
from actspec.units import format_quantity

DEGREE = math.pi / 180.0
"""One degree [rad]."""


def joint_prim(joint: Joint) -> tuple[tuple[str, ...], list[Attribute]]:
    """API schemas and attributes of the joint's prim; what the spec does not state keeps the stage's."""
    return ("NewtonJointAPI", f"PhysicsDriveAPI:{_axis(joint)}"), [*_no_drive(joint), *_passive(joint)]


def _axis(joint: Joint) -> str:
    return "angular" if joint.hinge else "linear"


def _no_drive(joint: Joint) -> list[Attribute]:
    """The stage's own drive, which would act beside the actuator, without gains; its force limit does not cut it."""
    head = f"drive:{_axis(joint)}:physics:"
    found = [
        Attribute("float", f"{head}stiffness", "0.0", "the NewtonActuator is the drive"),
        Attribute("float", f"{head}damping", "0.0"),
    ]
    if joint.actuator.effort_limit.known:
        found.append(number(f"{head}maxForce", joint.actuator.effort_limit))
    return found


def _passive(joint: Joint) -> list[Attribute]:
    actuator = joint.actuator
    found = []
    for name, quantity in (
        ("newton:armature", actuator.armature),
        ("newton:friction", actuator.friction_coulomb),
    ):
        if stated(quantity):
            found.append(number(name, quantity))
    viscous = actuator.friction_viscous
    if stated(viscous):
        if joint.dialect.joint_damping:
            found.append(_in_degrees(joint, "newton:damping", viscous, DEGREE))
        else:
            joint.approximate(
                "friction.viscous",
                format_quantity(viscous.value, viscous.unit),
                "none",
                f"Newton {joint.dialect.text} reads no joint damping from USD (1.4 and later do)",
                viscous_error(joint.law, viscous.require(), actuator.velocity_limit.value),
            )
    limit = actuator.velocity_limit
    if limit.known:
        asked = format_quantity(limit.value, limit.unit)
        if joint.dialect.joint_damping:
            found.append(_in_degrees(joint, "newton:velocityLimit", limit, 1.0 / DEGREE))
            why = "Newton's MuJoCo solver, which Isaac Lab has, takes no speed limit of a joint"
            joint.approximate(
                "velocity_limit", asked, "newton:velocityLimit, which not all solvers take", why, None
            )
        else:
            why = f"Newton {joint.dialect.text} reads no speed limit of a joint from USD (1.4 and later do)"
            joint.approximate("velocity_limit", asked, "none", why, None)
    joint.no_break_away(
        "the stage's own",
        "newton:friction is one number for sticking and sliding",
        "Newton has no Stribeck effect",
    )
    return found


def _in_degrees(joint: Joint, name: str, quantity: Quantity, factor: float) -> Attribute:
    """A number that USD has per degree or in degrees, of a hinge."""
    if not joint.hinge:
        return number(name, quantity)
    unit = quantity.unit.replace("rad", "deg")
    said = format_quantity(quantity.value, quantity.unit)
    return given(name, quantity.require() * factor, f"{unit}: {said}", provenance(quantity))
