"""What people mistype: a number in another unit, with another power of ten or the wrong way round; what it would be."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import replace

from actspec.spec.gears import Stage
from actspec.spec.plausible.relations import ALIKE, DEGREE, KGF_CM, RARE, RPM
from actspec.spec.values import SpecValue
from actspec.units import format_quantity

SERVO = 10.0
"""Below it torques are quoted in kgf*cm [N*m]. Chosen: the largest of hobby servos have 8."""
SERVO_TIMES = (0.03, 0.3)
"""Of servos [s per 60 deg]."""
PER_AMPERE = 0.05
"""So much likelier than a torque a torque constant is in kgf*cm: sheets of servos have kgf*cm/A."""
OZ_IN = 0.00706155
"""[N*m]."""
INERTIAS = ((1e-7, "g*cm^2"), (1e-6, "kg*mm^2"), (1e-4, "kg*cm^2"))
"""Units of datasheets [kg*m^2]."""
SPEEDS = {"rpm": RPM, "rad/s": 1.0, "deg/s": DEGREE}
"""Units of speeds [rad/s]."""

_WRITTEN = re.compile(r"([-+]?[0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]+)?) *([A-Za-z].*)")


def stage_slips(stage: Stage) -> Iterator[tuple[Stage, str, float]]:
    """A stage the wrong way round, or with its number in another unit."""
    if stage.teeth is not None:
        driving, driven = stage.teeth.driving, stage.teeth.driven
        teeth = stage.teeth.model_copy(update={"driving": driven, "driven": driving})
        yield stage.model_copy(update={"teeth": teeth}), "are driving and driven swapped?", 0.0
    for key in ("ratio", "lead", "radius", "lever_arm"):
        value: SpecValue | None = getattr(stage, key)
        if value is None or not value.value:
            continue
        if key == "ratio" and value.value < 1.0:
            inverse = replace(value, value=1.0 / value.value)
            help = f"did you mean {format_quantity(inverse.value, '', 3)}? A stage has turns at its input in one turn "
            yield stage.model_copy(update={key: inverse}), f"{help}at its output", 0.0
        if key == "lead" and not value.written.endswith("/rev"):
            # Sheets have it per turn.
            meant = multiplied(value, 0.5 / math.pi)
            help = f"is it per turn? Then write {format_quantity((value.value or 0.0) * 1e3, 'mm/rev', 4)}"
            yield stage.model_copy(update={key: meant}), help, 0.0
        for factor, help, rare in tens(value) if key == "ratio" else lengths(value):
            yield stage.model_copy(update={key: multiplied(value, factor)}), help, rare


def lengths(value: SpecValue) -> Iterator[tuple[float, str, float]]:
    """A length, or a length per turn, in another unit."""
    amount, _, unit = value.written.partition(" ")
    if unit.startswith("m"):
        yield (
            (1e-3, f"did you mean {amount} m{unit}?", 0.0)
            if unit[:2] in ("m", "m/")
            else (
                1e3,
                f"did you mean {amount} {unit[1:]}?",
                0.0,
            )
        )
    if unit.startswith("in"):
        yield 1.0 / 25.4, f"did you mean {amount} mm{unit[2:]}?", 0.0
    for factor, help, rare in tens(value):
        # In the unit that it is written in: m/rad is nobody's.
        own = f"did you mean {float(amount) * factor:.4g} {unit}?" if unit else help
        yield factor, own, rare


def inertias(value: SpecValue) -> Iterator[tuple[float, str, float]]:
    """An inertia in another unit: one with g in place of kg, or one of datasheets."""
    size = value.value or 0.0
    amount, _, unit = value.written.partition(" ")
    sheets = {other: factor for factor, other in INERTIAS}
    pair = {unit.removeprefix("k"): 1e-3, f"k{unit}": 1e3}
    pair.pop(unit, None)
    if unit in ("", "kg*m^2"):
        amount, units = f"{size:g}", sheets
    elif size and (unit not in sheets or sheets.keys().isdisjoint(pair)):
        # Nobody's sheet has g*mm^2.
        units = {other: float(amount) * factor / size for other, factor in sheets.items()}
    else:
        units = pair
    for other, factor in units.items():
        if other != unit and other.startswith(("g*", "kg*")):
            meant = format_quantity(size * factor, "kg*m^2", 4)
            yield factor, f"is it in {other}? {amount} {other} is {meant}", 0.0
    yield from tens(value)


def slips_of(value: SpecValue, speed: bool = False) -> Iterator[tuple[float, str, float]]:
    """Factor, help and cost of the slips in one number."""
    size = value.value or 0.0
    if speed and not value.linear:
        yield from _speeds(value)
    else:
        yield 1e-3, _of_milli(value), 0.0
        yield 1e3, f"did you mean {in_unit(multiplied(value, 1e3))}?", 0.0
    amount, unit = amount_of(value)
    if unit.startswith("kgf"):
        meant = replace(value, value=amount)
        yield amount / (size or 1.0), f"did you mean {in_unit(meant)}?", 0.0
    servo = value.unit in ("N*m", "N*m/A") and "kgf" not in value.written and size * KGF_CM < SERVO
    if servo:
        # A point in the wrong place is so near that nobody can tell.
        tenth = f"or did you mean {in_unit(multiplied(value, 0.1))}?"
        yield KGF_CM, f"{kgf_cm(value)}; {tenth}", RARE if value.unit == "N*m" else RARE - PER_AMPERE
    yield from tens(value)


def in_si(value: SpecValue | None) -> SpecValue | None:
    """A number of another unit as it would be in the SI unit, which may be what was meant; None: it is in that."""
    amount, unit = (0.0, "") if value is None else amount_of(value)
    if value is None or not unit or unit == value.unit:
        return None
    return replace(value, value=amount, written=format_quantity(amount, value.unit))


def thousandth(unit: str) -> str:
    """The unit of a thousandth: mN*m, and g for kg."""
    return unit[1:] if unit.startswith("kg") else f"m{unit}"


def amount_of(value: SpecValue) -> tuple[float, str]:
    """Number and unit as written; without a unit the number in SI."""
    written = _WRITTEN.fullmatch(value.written)
    return (value.value or 0.0, "") if written is None else (float(written[1]), written[2])


def _speeds(value: SpecValue) -> Iterator[tuple[float, str, float]]:
    """A speed whose amount is right and whose unit is another."""
    amount, unit = amount_of(value)
    own = SPEEDS.get(unit or "rad/s")
    if own is None:
        return
    for other, size in SPEEDS.items():
        if size == own:
            continue
        meant = (value.value or 0.0) * size / own
        if other == "rad/s":
            yield size / own, f"did you mean {format_quantity(meant, 'rad/s')}?", 0.0
        else:
            # Sheets that have rpm hardly have degrees.
            rare = 0.0 if other == "rpm" else ALIKE if own == 1.0 else 2.0 * RARE
            shown = f"{amount:g} {other} is {format_quantity(meant, 'rad/s', 3)}"
            yield size / own, f"is it in {other}? {shown}", rare


def servo_time(speed: float) -> tuple[float, str] | None:
    """A speed [rad/s] that is a servo's time for 60 degrees: what is meant, and in words; None: it is none."""
    if not SERVO_TIMES[0] <= speed <= SERVO_TIMES[1]:
        return None
    meant = 60.0 * DEGREE / speed
    shown = format_quantity(meant, "rad/s", 3)
    return meant, f"is it in s per 60 deg, as sheets of servos have it? Then it is {shown}"


def kgf_cm(value: SpecValue) -> str:
    """A torque of a servo's sheet."""
    size = value.value or 0.0
    unit = value.unit.replace("N*m", "kgf*cm")
    return f"is it in {unit}? {size:g} {unit} is {format_quantity(size * KGF_CM, value.unit, 4)}"


def small_units(value: SpecValue, names: str) -> Iterator[tuple[float, str]]:
    """Factors of torques in other units of servos' sheets; of a size all are usual, so that other figures have to tell.

    Args:
        value: The first of them [N*m].
        names: Of all.
    """
    for unit, factor in (("N*cm", 0.01), ("oz*in", OZ_IN)):
        meant = in_unit(multiplied(value, factor))
        yield factor, f"are {names} in {unit}? {value.value or 0.0:g} {unit} is {meant}"


def tens(value: SpecValue) -> Iterator[tuple[float, str, float]]:
    """A number whose point is in the wrong place."""
    for power in (-1, 1, -2, 2, -3, 3, -4, 4):
        factor = 10.0**power
        yield factor, f"did you mean {in_unit(multiplied(value, factor))}?", RARE


def transposed(value: SpecValue) -> Iterator[float]:
    """A number with two neighbouring digits exchanged, in SI."""
    amount, unit = amount_of(value)
    text = value.written.partition(" ")[0] if unit else value.written
    for index in range(len(text) - 1):
        one, two = text[index], text[index + 1]
        # 080 is 800 with its point in another place.
        leads = two == "0" and not text[:index].strip("+-")
        if one.isdigit() and two.isdigit() and one != two and not leads and amount and value.value:
            yield value.value * float(text[:index] + two + one + text[index + 2 :]) / amount


def _of_milli(value: SpecValue) -> str:
    """A number in thousandths, or one whose thousands are too many."""
    amount, _, unit = value.written.partition(" ")
    if unit.startswith("k") and not unit.startswith("kg"):
        return f"did you mean {amount} {unit[1:]}?"
    return f"is it in {thousandth(value.unit)}? {milli(value)}"


def milli(value: SpecValue) -> str:
    size = value.value or 0.0
    return f"{size:g} {thousandth(value.unit)} is {format_quantity(size / 1000, value.unit, 3)}"


def in_unit(value: SpecValue) -> str:
    return format_quantity(value.value, value.unit, 4)


def multiplied(value: SpecValue | None, factor: float) -> SpecValue:
    """A number as it would be with another factor, as one would write it."""
    assert value is not None and value.value is not None
    size = value.value * factor
    return replace(value, value=size, written=format_quantity(size, value.unit, 4))
