"""The kinds of quantity, and what a text of one is read to."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache

_GIVEN = 6
"""Digits up to which a number is taken as written. Chosen: robot files that people write have three to five."""


class Kind(Enum):
    """What a number is: decides its units and whether it may come without one.

    Attributes:
        noun: Plain-English name, e.g. "torque"; also what `str()` gives.
        rotary_unit: SI unit at a hinge.
        linear_unit: SI unit at a slide; the same where there is only one.
        bare: Whether a number without a unit is taken as SI. 0 always is.
    """

    TORQUE = "torque", "N*m", "N", True
    STIFFNESS = "stiffness", "N*m/rad", "N/m", True
    VELOCITY_GAIN = "velocity gain", "N*m*s/rad", "N*s/m", True
    INERTIA = "inertia", "kg*m^2", "kg", True
    SPEED = "speed", "rad/s", "m/s", False
    POSITION = "position", "rad", "m", False
    ANGLE = "angle", "rad", "rad", False
    LENGTH = "length", "m", "m", False
    LEAD = "lead", "m/rad", "m/rad", False
    TIME = "time", "s", "s", False
    FREQUENCY = "frequency", "Hz", "Hz", False
    RATIO = "ratio", "1", "1", True
    VOLTAGE = "voltage", "V", "V", True
    CURRENT = "current", "A", "A", True
    TORQUE_CONSTANT = "torque constant", "N*m/A", "N/A", True
    RESISTANCE = "resistance", "Ohm", "Ohm", True

    def __init__(self, noun: str, rotary_unit: str, linear_unit: str, bare: bool) -> None:
        self.noun = noun
        self.rotary_unit = rotary_unit
        self.linear_unit = linear_unit
        self.bare = bare

    def __str__(self) -> str:
        return self.noun


@dataclass(frozen=True, slots=True)
class Parsed:
    """A quantity as read.

    Attributes:
        value: The number in SI.
        unit: SI unit as text, e.g. `N*m/rad`; the rotary one where `linear` is None.
        linear: Whether the unit given was that of a slide joint; None where it cannot tell
            (a bare number, or a kind with one unit only).
    """

    value: float
    unit: str
    linear: bool | None


class UnitError(ValueError):
    """A text is not a quantity of the kind that was asked for.

    Attributes:
        message: What is wrong, with the value, its unit and the kind.
        help: The nearest right answer; None when there is none.
    """

    def __init__(self, message: str, help: str | None = None) -> None:
        super().__init__(message)
        self.message = message
        self.help = help


def format_quantity(value: float | None, unit: str, digits: int = 6) -> str:
    """Write a quantity as the spec would have it.

    Args:
        value: Number in `unit`; None is unknown.
        unit: Unit text; `1` or empty for a dimensionless number.
        digits: Significant digits of a computed number; see `format_number`.

    Returns:
        `33.5 N*m`, or `unknown`.
    """
    if value is None:
        return "unknown"
    number = format_number(value, digits)
    return number if unit in ("", "1") else f"{number} {unit}"


@lru_cache(maxsize=4096)
def format_number(value: float, digits: int = 6) -> str:
    """Write a number with the digits that it was given with.

    What six digits give is taken for a number that somebody wrote, and keeps its digits: `35.55`, `1000`. Any other
    is computed, and is rounded. No whole digit is lost and no exponent stands below 1e9: `1235`, not `1.23e+03`.

    Args:
        value: Any float.
        digits: Significant digits of a computed number.
    """
    value += 0.0  # no "-0"
    if math.isclose(value, float(f"{value:.{_GIVEN}g}"), rel_tol=1e-9):
        digits = max(digits, _GIVEN)
    text = f"{value:.{digits}g}"
    if "e+" not in text:
        return text
    return f"{value:.0f}" if abs(value) < 1e9 else text.replace("e+0", "e").replace("e+", "e")


def in_units(kind: Kind) -> str:
    """The units of a kind, as a sentence."""
    if kind is Kind.RATIO:
        return "a ratio is a bare number or in %"
    if kind.rotary_unit == kind.linear_unit:
        return f"{an(kind.noun)} is in {kind.rotary_unit}"
    return f"{an(kind.noun)} is in {kind.rotary_unit} (hinge) or {kind.linear_unit} (slide)"


def an(noun: str) -> str:
    """A noun with its article."""
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"
