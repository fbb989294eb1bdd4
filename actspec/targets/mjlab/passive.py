"""Armature and friction of the joint: what mjlab writes into the model, and what it cannot."""

from __future__ import annotations

from actspec.targets.approximation import viscous_error
from actspec.targets.mjlab.context import Field, Joint, number
from actspec.targets.python_text import py, stated
from actspec.units import format_quantity


def passive_fields(joint: Joint) -> list[Field]:
    """Armature and friction of the joint; what the spec does not state keeps the model's."""
    actuator, view = joint.actuator, joint.view
    fields = []
    for name, quantity, own in (
        ("armature", actuator.armature, None if view is None else view.armature),
        ("frictionloss", actuator.friction_coulomb, None if view is None else view.frictionloss),
    ):
        if stated(quantity):
            fields.append(number(name, quantity))
        elif not joint.dialect.keeps_model and own:
            fields.append(Field(name, py(own), f"{quantity.unit}, the model's own, else it would be 0"))
    viscous = actuator.friction_viscous
    if stated(viscous):
        own_viscous = 0.0 if view is None else view.damping
        if joint.dialect.viscous_damping:
            fields.append(number("viscous_damping", viscous))
        elif view is None or viscous.require() != own_viscous:
            difference = viscous.require() - own_viscous
            joint.approximate(
                "friction.viscous",
                format_quantity(viscous.value, viscous.unit),
                "the model's own" if view is None else format_quantity(own_viscous, viscous.unit),
                f"mjlab {joint.dialect.text} has no viscous_damping (1.3 and later have)",
                None if view is None else viscous_error(joint.law, difference, actuator.velocity_limit.value),
            )
    coulomb = actuator.friction_coulomb.value
    static = actuator.friction_static.value if actuator.friction_static is not None else None
    stribeck = actuator.stribeck_velocity
    if static is not None and static > (coulomb or 0.0):
        joint.approximate(
            "friction.static",
            joint.torque(static),
            "the model's own" if coulomb is None else joint.torque(coulomb),
            "frictionloss is one number for sticking and sliding",
            static - (coulomb or 0.0),
        )
        if stribeck is not None and stribeck.known:
            joint.approximate(
                "friction.stribeck_velocity",
                format_quantity(stribeck.value, stribeck.unit),
                "none",
                "MuJoCo has no Stribeck effect",
                static - (coulomb or 0.0),
            )
    if actuator.velocity_limit.known:
        limit = actuator.velocity_limit
        joint.approximate(
            "velocity_limit",
            format_quantity(limit.value, limit.unit),
            "none",
            "mjlab has no speed limit of a joint; its velocity_limit is the no-load speed",
            None,
        )
    return fields
