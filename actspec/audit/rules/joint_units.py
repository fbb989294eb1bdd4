"""Units of a row's figures, by the kind of its joint."""

from __future__ import annotations

from actspec.audit.ledger import LedgerRow
from actspec.ir import JointKind
from actspec.units import Kind, format_quantity

_KINDS = {
    "kp": Kind.STIFFNESS,
    "kd": Kind.VELOCITY_GAIN,
    "joint_damping": Kind.VELOCITY_GAIN,
    "actuator_damping": Kind.VELOCITY_GAIN,
    "back_emf": Kind.VELOCITY_GAIN,
    "total_damping": Kind.VELOCITY_GAIN,
    "frictionloss": Kind.TORQUE,
    "effort_limit": Kind.TORQUE,
    "stall_torque": Kind.TORQUE,
    "velocity_limit": Kind.SPEED,
    "no_load_speed": Kind.SPEED,
    "armature": Kind.INERTIA,
    "inertia_min": Kind.INERTIA,
    "inertia_max": Kind.INERTIA,
    "inertia_free_min": Kind.INERTIA,
    "default_position": Kind.POSITION,
    "action_scale": Kind.POSITION,
}


def unit(row: LedgerRow, field: str) -> str:
    """SI unit of a field; a joint of unknown kind is taken for a hinge, as nearly all are."""
    if field == "delay":
        return "s"
    kind = _KINDS[field]
    return kind.linear_unit if row.kind is JointKind.SLIDE else kind.rotary_unit


def shown(row: LedgerRow, field: str, value: float | None, digits: int = 3) -> str:
    """A figure for a message, with its unit: three digits, so that equal joints read the same.

    Args:
        row: Whose joint it is of.
        field: Field of the row that it is a value of, or compares with.
        value: The figure; None reads `unknown`.
        digits: More, for figures that a file states and that grow large.
    """
    return format_quantity(value, unit(row, field), digits)
