"""Columns of the ledger with their units."""

from __future__ import annotations

import math
from collections.abc import Iterable
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

    @property
    def part(self) -> bool:
        """Whether it is a part of the damping, of which the ledger tells how it is clamped and integrated."""
        return self.field in DAMPING_PARTS

    def unit(self, kind: JointKind | None) -> str:
        """Its unit for joints of a kind; unknown kinds are taken for hinges."""
        return self.slide if kind is JointKind.SLIDE else self.hinge


DAMPING_PARTS = ("kd", "joint_damping", "actuator_damping")
"""Origins of damping. Source: the design, §7."""

MARKS = {
    ("clamped", True): ("c", "clamped by the effort limit"),
    ("clamped", False): ("u", "not clamped by the effort limit"),
    ("implicit", True): ("i", "integrated implicitly"),
    ("implicit", False): ("e", "integrated explicitly"),
}
"""What is known of a part of the damping, to its mark and the mark in words. What is unknown has no mark."""

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

JSON_FLAGS = tuple(f"{field}_{name}" for field in DAMPING_PARTS for name in ("clamped", "implicit"))
"""Its properties of the damping. Source: the design, §7."""


def number(row: LedgerRow, column: Column) -> float | None:
    """A row's figure; None is unknown."""
    value: float | None = getattr(row, column.field)
    return None if value is None or math.isnan(value) else float(value)


def marked(row: LedgerRow, column: Column) -> str:
    """A row's figure for people; a part of the damping with its marks: `0.5 ui`."""
    value = number(row, column)
    if not column.part or not value:
        return cell(value)
    known = ((name, getattr(row, f"{column.field}_{name}")) for name in ("clamped", "implicit"))
    marks = "".join(MARKS[item][0] for item in known if item in MARKS)
    return f"{cell(value)} {marks}".rstrip()


def legend(texts: Iterable[str]) -> str:
    """The marks that stand in cells, in words; "" without any."""
    used = {mark for text in texts for mark in text.partition(" ")[2]}
    told = [f"{mark} {words}" for mark, words in MARKS.values() if mark in used]
    return f"damping: {', '.join(told)}" if told else ""


def cell(value: float | None) -> str:
    """A figure for people: `-` is unknown, `inf` no limit."""
    if value is None:
        return "-"
    return f"{value:.0f}" if 1e4 <= abs(value) < 1e7 else f"{value + 0.0:.4g}"
