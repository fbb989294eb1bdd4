"""Columns of the ledger with their units."""

from __future__ import annotations

import math
from dataclasses import dataclass

from actspec.audit.ledger import LedgerRow
from actspec.ir import JointKind


@dataclass(frozen=True, slots=True)
class Column:
    """One field of the ledger.

    Attributes:
        field: Of `LedgerRow`.
        title: For people.
        hinge: Unit for a hinge; "" without.
        slide: Unit for a slide.
    """

    field: str
    title: str
    hinge: str
    slide: str

    def unit(self, kind: JointKind | None) -> str:
        """Its unit for joints of a kind; unknown kinds are taken for hinges."""
        return self.slide if kind is JointKind.SLIDE else self.hinge


_DAMPING = ("N*m*s/rad", "N*s/m")
_TORQUE = ("N*m", "N")
_SPEED = ("rad/s", "m/s")
_INERTIA = ("kg*m^2", "kg")

COLUMNS = (
    Column("kp", "kp", "N*m/rad", "N/m"),
    Column("kd", "kd", *_DAMPING),
    Column("joint_damping", "joint damping", *_DAMPING),
    Column("actuator_damping", "actuator damping", *_DAMPING),
    Column("back_emf", "back-EMF", *_DAMPING),
    Column("total_damping", "total damping", *_DAMPING),
    Column("frictionloss", "frictionloss", *_TORQUE),
    Column("effort_limit", "effort limit", *_TORQUE),
    Column("velocity_limit", "velocity limit", *_SPEED),
    Column("stall_torque", "stall torque", *_TORQUE),
    Column("no_load_speed", "no-load speed", *_SPEED),
    Column("armature", "armature", *_INERTIA),
    Column("inertia_min", "inertia min", *_INERTIA),
    Column("inertia_max", "inertia max", *_INERTIA),
    Column("inertia_free_min", "free inertia min", *_INERTIA),
    Column("natural_frequency", "natural frequency", "rad/s", "rad/s"),
    Column("damping_ratio", "damping ratio", "", ""),
    Column("stability", "h kd/I", "", ""),
    Column("delay", "delay", "s", "s"),
    Column("action_scale", "action scale", "", ""),
    Column("default_position", "default pose", "rad", "m"),
)
"""In the order in which reports show them."""

JSON_FIELDS = tuple(
    column.field
    for column in COLUMNS
    if column.field not in ("stall_torque", "no_load_speed", "action_scale", "default_position")
)
"""Figures of a ledger entry of `actspec-report/1`. Source: the design, §9."""


def number(row: LedgerRow, column: Column) -> float | None:
    """A row's figure; None is unknown."""
    value: float | None = getattr(row, column.field)
    return None if value is None or math.isnan(value) else float(value)


def cell(value: float | None) -> str:
    """A figure for people: `-` is unknown, `inf` no limit."""
    if value is None:
        return "-"
    return f"{value:.0f}" if 1e4 <= abs(value) < 1e7 else f"{value + 0.0:.4g}"
