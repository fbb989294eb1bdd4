"""Units of a row's figures, by the kind of its joint."""

from __future__ import annotations

from actspec.readings.fields import unit_of
from actspec.readings.ledger import LedgerRow
from actspec.readings.versions import Versions, friction_unit_of
from actspec.units import format_quantity

SPEEDS = ("velocity_limit", "no_load_speed")


def unit(row: LedgerRow, field: str) -> str:
    """SI unit of a field; a joint of unknown kind is taken for a hinge, as nearly all are."""
    return unit_of(field, row.kind)


def shown(row: LedgerRow, field: str, value: float | None, digits: int = 3) -> str:
    """A figure for a message, with its unit: three digits, so that equal joints read the same.

    Args:
        row: Whose joint it is of.
        field: Field of the row that it is a value of, or compares with.
        value: The figure; None reads `unknown`.
        digits: More, for figures that a file states and that grow large.
    """
    return format_quantity(value, unit(row, field), digits)


def friction_unit(row: LedgerRow, versions: Versions) -> str:
    found = friction_unit_of(versions)
    return "1" if found is not None and found.coefficient else unit(row, "frictionloss")
