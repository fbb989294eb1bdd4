"""Quantities: from text or number to SI, and back to another unit."""

from __future__ import annotations

import math
import re

from actspec.diagnostics import shortened
from actspec.units.explain import decimal_comma, mismatch, not_a_number, too_long, unreadable
from actspec.units.kinds import Kind, Parsed, UnitError, an, format_number, in_units
from actspec.units.reader import DIMS_OF, BadUnit, Unit, in_ascii, read_unit

MAX_LENGTH = 200
"""Longest text that is read as a quantity or unit; the files are strangers'. Chosen."""

LEAST, MOST = 1e-50, 1e50
"""Between which magnitudes of a quantity that is not 0 [SI]. Chosen: no machine has others, and what is computed of a
few of them stays a float."""

_NUMBER = re.compile(r"\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(.*?)\s*\Z", re.DOTALL)
_DECIMAL_COMMA = re.compile(r",[0-9]")
_NONZERO = re.compile(r"[^eE]*[1-9]")
_EXAMPLES = {
    Kind.SPEED: ("rad/s", "rpm", "m/s"),
    Kind.POSITION: ("deg", "rad", "m"),
    Kind.ANGLE: ("deg", "rad"),
    Kind.LENGTH: ("mm", "m"),
    Kind.LEAD: ("mm/rev",),
    Kind.TIME: ("ms", "s"),
}
_LARGE = 25.0
"""A position of more is no joint's in rad, four turns, nor in m."""


def parse_quantity(given: str | int | float, kind: Kind) -> Parsed:
    """Read a number with its unit, or a bare number where `kind` allows one.

    Args:
        given: `33.5 N*m`, `-.5 rad`, `8ms`; or a number, or the text of one.
        kind: What the quantity must be.

    Returns:
        The quantity in SI.

    Raises:
        UnitError: not a finite number, an unknown unit, a unit of another kind, or no unit
            where one is needed.
    """
    if not isinstance(given, str):
        number = _finite(given, kind)
        return _bare(number, format_number(number), kind)
    if len(given) > MAX_LENGTH:
        raise too_long(given, kind)
    text = in_ascii(given)
    match = _NUMBER.match(text)
    if match is None:
        raise not_a_number(given, kind)
    digits, rest = match.group(1), match.group(2)
    if _DECIMAL_COMMA.match(rest):
        raise decimal_comma(given, kind)
    number = float(digits)
    if not math.isfinite(number) or (number == 0 and _NONZERO.match(digits)):
        raise UnitError(f"{shortened(digits)} is out of range for {an(kind.noun)}")
    if not rest:
        return _bare(number, digits, kind)
    # The author's own text is shown, not its plain form.
    return _with_unit(number, digits, rest, given.strip(), kind)


def parse_with_unit(number: int | float, unit_text: str, kind: Kind) -> Parsed:
    """Read a number whose unit stands apart, as in `{value: 33.5, unit: N*m}`.

    Args:
        number: Value in `unit_text`.
        unit_text: Unit; `1` for a dimensionless number.
        kind: What the quantity must be.

    Returns:
        The quantity in SI.

    Raises:
        UnitError: as `parse_quantity`; also for an empty unit.
    """
    value = _finite(number, kind)
    text, shown = _unit_text(unit_text, kind), format_number(value)
    whole = shown if unit_text.strip() == "1" else f"{shown} {unit_text.strip()}"
    return _with_unit(value, shown, text, whole, kind)


def convert(value_si: float, unit_text: str, kind: Kind) -> float:
    """Express an SI value in another unit of the same kind.

    Args:
        value_si: Value in the kind's rotary or linear SI unit, whichever `unit_text` belongs to.
        unit_text: The unit wanted.
        kind: What the quantity is.

    Returns:
        The value in `unit_text`; infinite if it is too large for a float.

    Raises:
        UnitError: unknown unit, or a unit of another kind.
    """
    text = _unit_text(unit_text, kind)
    unit = _unit(text, f"1 {unit_text.strip()}", "1", kind)
    if unit.dims not in DIMS_OF[kind]:
        raise mismatch(1.0, f"1 {unit_text.strip()}", unit, kind)
    if not math.isfinite(value_si):
        return float(value_si)
    return unit.power(-1).in_si(float(value_si))


def _finite(given: object, kind: Kind) -> float:
    if isinstance(given, bool) or not isinstance(given, int | float):
        shown = str(given).lower() if isinstance(given, bool) else f"{type(given).__name__} value"
        raise UnitError(f"{shown} is not a number, {an(kind.noun)} is needed", in_units(kind))
    try:
        number = float(given)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise UnitError(f"{format_number(number)} is not a finite number, {an(kind.noun)} is needed")
    return number


def _possible(number: float) -> bool:
    return number == 0.0 or LEAST <= abs(number) <= MOST


def _bare(number: float, shown: str, kind: Kind) -> Parsed:
    if not kind.bare and number != 0:
        units = _EXAMPLES.get(kind, (kind.rotary_unit,))
        if kind is Kind.POSITION and abs(number) > _LARGE:
            units = ("deg", "mm")
        examples = [f"`{shortened(shown)} {unit}`" for unit in units]
        text = " or ".join([", ".join(examples[:-1]), examples[-1]] if len(examples) > 1 else examples)
        raise UnitError(f"{shortened(shown)} has no unit, and {an(kind.noun)} needs one", f"write {text}")
    if not _possible(number):
        raise UnitError(f"{shortened(shown)} is out of range for {an(kind.noun)}")
    return Parsed(number + 0.0, kind.rotary_unit, None)


def _unit_text(text: object, kind: Kind) -> str:
    if not isinstance(text, str):
        got = type(text).__name__
        raise UnitError(f"the unit of {an(kind.noun)} must be text, got {got}", in_units(kind))
    if len(text) > MAX_LENGTH:
        raise too_long(text, kind)
    spelled = in_ascii(text)
    if not spelled:
        raise UnitError(f"the unit of {an(kind.noun)} is empty", in_units(kind))
    return spelled


def _unit(text: str, whole: str, shown: str, kind: Kind) -> Unit:
    try:
        return read_unit(text)
    except BadUnit as bad:
        raise unreadable(bad, text, whole, shown, kind) from None


def _with_unit(number: float, shown: str, text: str, whole: str, kind: Kind) -> Parsed:
    unit = _unit(text, whole, shown, kind)
    rotary, linear = DIMS_OF[kind]
    if unit.dims not in (rotary, linear):
        raise mismatch(number, whole, unit, kind)
    value = unit.in_si(number)
    if not _possible(value) or (value == 0 and number != 0):
        raise UnitError(f"{shortened(whole)} is out of range for {an(kind.noun)}")
    if rotary == linear:
        return Parsed(value + 0.0, kind.rotary_unit, None)
    is_linear = unit.dims == linear
    return Parsed(value + 0.0, kind.linear_unit if is_linear else kind.rotary_unit, is_linear)
