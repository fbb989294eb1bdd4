"""Two figures of one thing: are they the same, and if not, which known slip makes the one of the other.

Rules, verify, `diff`, import and the compiler's read-back all ask here; they differ in the tolerance, in who is
right, and in the words.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from actspec.diagnostics import Span
from actspec.fields import FIELDS, LIMITS
from actspec.units import format_number

EXACT = 1e-9
"""Relative difference up to which two figures are the same number after units and sums. Chosen: what is left of a
float."""

COPIED = 1e-3
"""Relative difference up to which a figure is a copy of another, or what a slip makes of it. Chosen: people round what
they copy: 0.7854 and pi/4 are one number, 23.5 and 23.7 N*m are two; no two slips are nearly so close."""

NOTHING = 1e-12
"""Absolute difference that is none, in any unit. Chosen: far below every figure of a joint."""

SAME_POWER = 0.02
"""Relative difference up to which two products of torque and speed are one motor's behind two gears. Source: published
pairs of one motor behind two gears (Unitree A2, Aliengo, Go1, Go2, G1 and H2) are within 1.3 %; B2 and H1, whose knees
are other motors, 2.6 % and 8.7 % apart."""

LEAST_REDUCTION = 1.1
"""Ratio from which a reduction is distinguished from rounding. Chosen: the least published one is 1.26 (Aliengo)."""

DEGREES = 180.0 / math.pi
RPM = 30.0 / math.pi
TURN = 2.0 * math.pi


@dataclass(frozen=True, slots=True)
class Figure:
    """One number of one joint as one file has it.

    Attributes:
        value: In `unit`; None is unknown, inf no limit.
        unit: SI unit; "" where it has none, or nobody says.
        place: Where it is written.
        stated: Whether the file states it itself; else it is an engine's default or computed.
        made: What it is made of where the file has others, as `LedgerRow.made`.
    """

    value: float | None
    unit: str
    place: Span
    stated: bool
    made: str = ""


@dataclass(frozen=True, slots=True)
class Deviation:
    """A field in which two readings of one joint are not the same.

    Attributes:
        field: Name in `FIELDS`.
        figure: The one; None: the reading has no such figure.
        reference: What it is held to; None likewise.
    """

    field: str
    figure: Figure | None
    reference: Figure | None

    @property
    def value(self) -> float | None:
        """The figure's number; None: unknown or none."""
        return None if self.figure is None else self.figure.value

    @property
    def expected(self) -> float | None:
        """The reference's number; None: unknown or none."""
        return None if self.reference is None else self.reference.value

    @property
    def ratio(self) -> float | None:
        """How many times the reference; None where that says nothing."""
        return ratio_of(self.value, self.expected)


def same(one: float | None, other: float | None, tolerance: float = EXACT, absolute: float = NOTHING) -> bool:
    """Whether two numbers are one. Unknown is only unknown, no limit (inf) only no limit.

    Args:
        one: A number; None is unknown.
        other: Another.
        tolerance: Largest relative difference.
        absolute: Largest absolute difference.
    """
    if one is None or other is None:
        return one is other
    return math.isclose(one, other, rel_tol=tolerance, abs_tol=absolute)


def near(one: float | None, other: float | None, tolerance: float = COPIED) -> bool:
    """Whether two known finite numbers are a copy of each other; never for 0 beside another number."""
    if one is None or other is None or not (math.isfinite(one) and math.isfinite(other)):
        return False
    return math.isclose(one, other, rel_tol=tolerance)


def ratio_of(one: float | None, other: float | None) -> float | None:
    """One over the other; None beside 0, unknown and no limit."""
    if not one or not other or not (math.isfinite(one) and math.isfinite(other)):
        return None
    return one / other


def times(one: float | None, other: float | None) -> str:
    """The ratio for a message: ` (x0.517)`, or nothing; of the other sign only where that is the whole difference."""
    ratio = ratio_of(one, other)
    return (
        ""
        if ratio is None or (ratio < 0.0 and not math.isclose(ratio, -1.0, rel_tol=0.01))
        else f" (x{format_number(ratio, 3)})"
    )


def compare(
    figures: Mapping[str, Figure],
    references: Mapping[str, Figure],
    fields: Iterable[str] = tuple(FIELDS),
    tolerance: float = EXACT,
    absolute: float = NOTHING,
) -> Iterator[Deviation]:
    """Every field in which two readings of one joint differ; an unknown number differs from a known one.

    Args:
        figures: Name of a field to the figure.
        references: What they are held to.
        fields: Which.
        tolerance: Largest relative difference of equal figures.
        absolute: Largest absolute difference of equal figures.
    """
    for name in fields:
        found = Deviation(name, figures.get(name), references.get(name))
        if not same(found.value, found.expected, tolerance, absolute):
            yield found


def is_lost(name: str, value: float | None, expected: float | None, factor: float = 1e3) -> bool:
    """Whether a limit is no limit any more: missing, 0, infinite or a stand-in.

    Args:
        name: Of the field.
        value: What there is; None: nothing.
        expected: What there should be.
        factor: Times the limit from which on a limit limits nothing. Chosen: stand-ins are 1e6 to 1e9 [N*m].
    """
    if name not in LIMITS or expected is None or not 0.0 < expected < math.inf:
        return False
    return value is None or value == 0.0 or value >= factor * expected


def angle_slip(ratio: float | None, tolerance: float = COPIED) -> bool:
    """Whether a ratio is that of degrees to radians or of rpm to rad/s, one way or the other."""
    if ratio is None:
        return False
    return any(near(abs(ratio), slip, tolerance) for slip in (DEGREES, 1 / DEGREES, RPM, 1 / RPM))


_TORQUES = {
    1e3: "m{}",
    1e-3: "k{}",
    100.0 / 9.80665: "kgf*cm",
    1.0 / 9.80665: "kgf*m",
}
"""How many of another unit are one N*m, and that unit; `{}` is the SI unit."""


def torque_slip(ratio: float | None, unit: str, tolerance: float = COPIED) -> str | None:
    """The unit in which a torque was written where `unit` is read: `mN*m`, `kgf*cm`; None: none of them.

    Args:
        ratio: What is written over what should be.
        unit: SI unit that is read.
        tolerance: Largest relative difference.
    """
    return next(
        (name.format(unit) for factor, name in _TORQUES.items() if near(ratio, factor, tolerance)), None
    )


def gear_power(ratio: float | None, factor: float, tolerance: float = COPIED) -> int | None:
    """The power of a gear by which a figure is off: 1 once too often, -1 left out, 2 and -2 its square; None.

    Args:
        ratio: What is written over what should be.
        factor: The gear.
        tolerance: Largest relative difference.
    """
    if ratio is None or factor in (0.0, 1.0):
        return None
    return next((power for power in (1, -1, 2, -2) if near(ratio, factor**power, tolerance)), None)


def twice_damped(
    value: float | None, own: float | None, other: float | None, tolerance: float = COPIED
) -> bool:
    """Whether a damping is its own figure with the other origin's, or itself, on top.

    Args:
        value: What there is.
        own: What there should be.
        other: The damping of the other origin: the friction beside a gain, the gain beside a friction.
        tolerance: Largest relative difference.
    """
    first = own or 0.0
    return any(near(value, first + extra, tolerance) for extra in (other or 0.0, first) if extra)
