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
    joint.no_break_away(
        "the model's own",
        "frictionloss is one number for sticking and sliding",
        "MuJoCo has no Stribeck effect",
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
