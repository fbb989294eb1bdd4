"""Quantities as a spec writes them: number, unit, source."""

from __future__ import annotations

from actspec.draft.text import scalar
from actspec.ir import Quantity
from actspec.resolution.quantities import tidy
from actspec.robot.xml_edit import format_number
from actspec.units import Kind, UnitError, parse_quantity

_WRITTEN_DIGITS = 14
"""Chosen: a number of more significant digits is nobody's handwriting, but the result of a product or a sum."""


def figure(value: float, unit: str, *, computed: bool = False) -> str:
    """A number with its unit: all digits that a file has written, 12 of what it has computed.

    Args:
        value: Finite.
        unit: SI; "" for none.
        computed: It is the result of a formula.
    """
    number = format_number(value + 0.0)
    digits = number.partition("e")[0].replace(".", "").lstrip("-0")
    if computed or len(digits) > _WRITTEN_DIGITS:
        number = format_number(tidy(value) + 0.0)
    return f"{number} {unit}" if unit not in ("", "1") else number


def time_text(seconds: float, *, computed: bool = False) -> str:
    """`2 ms` where that reads back as the same double, else in seconds."""
    text = figure(seconds * 1e3, "ms", computed=True)
    try:
        same = parse_quantity(text, Kind.TIME).value == seconds
    except UnitError:
        same = False
    # A step that is not that of the file changes every delay that is counted in steps.
    return text if same or computed else f"{format_number(seconds)} s"


def quantity_text(quantity: Quantity) -> str:
    """A known quantity without its source: `25 N*m/rad`, `5 ms`."""
    computed = quantity.formula is not None
    if quantity.unit == "s":
        return time_text(quantity.require(), computed=computed)
    return figure(quantity.require(), quantity.unit, computed=computed)


def sourced(quantity: Quantity) -> str:
    """A known quantity as a flow mapping with source and standard deviation; plain where it has neither."""
    text = quantity_text(quantity)
    parts = []
    if quantity.std is not None:
        parts.append(f"std: {figure(quantity.std, quantity.unit)}")
    if quantity.source is not None:
        parts.append(f"source: {scalar(quantity.source)}")
    return f"{{value: {text}, {', '.join(parts)}}}" if parts else text
