"""The ranges of a spec: of which fields, their nominal values, and which values a drawn number gives.

Also whether they can be drawn from, and which are probably slips.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from actspec import fields
from actspec.diagnostics import Collector, listed
from actspec.ir import ActuatorSet, JointActuator, Level, Quantity, Randomization
from actspec.units import format_number, format_quantity

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Numbers = NDArray[np.float64]


Number = TypeVar("Number", float, "Numbers")

FIELDS = tuple(one.spec for one in sorted(fields.FIELDS.values(), key=lambda one: one.drawn) if one.drawn)
"""Fields that have a value of their own, in the order of drawing."""

FACTORS = {"gains": ("kp", "kd"), "strength": ("kp", "kd", "effort_limit")}
"""Factors, in the order in which they are applied, and what each multiplies."""

SPREAD = 3.0
"""Half-width of a gaussian where ends are needed [std]. Chosen: 99.7 % of the draws are inside."""


def quantity_of(actuator: JointActuator, field: str) -> Quantity | None:
    """The nominal quantity of a field; None where the joint has no such thing."""
    if field == "friction.static" and actuator.friction_static is None:
        return actuator.friction_coulomb
    if field == "delay":
        return None if actuator.delay is None else actuator.delay.nominal
    found: Quantity | None = getattr(actuator, fields.BY_SPEC[field].ir)
    return found


def nominal_of(actuator: JointActuator, field: str) -> float | None:
    """The nominal value of a field, SI; a joint without delay has 0 s. None: unknown, or no such thing."""
    quantity = quantity_of(actuator, field)
    if quantity is None:
        return 0.0 if field == "delay" else None
    return quantity.value


def unit_of(actuator: JointActuator, field: str) -> str:
    """SI unit of a field at a joint; `1` for a factor."""
    if field in FACTORS:
        return "1"
    quantity = quantity_of(actuator, field)
    if quantity is not None:
        return quantity.unit
    return fields.BY_SPEC[field].unit(actuator.kind)


def drawn_ends(entry: Randomization) -> tuple[float, float]:
    """Least and largest number that is drawn: the range, or the mean ∓ 3 std of a gaussian."""
    if entry.distribution == "gaussian":
        return entry.low - SPREAD * entry.high, entry.low + SPREAD * entry.high
    return entry.low, entry.high


def applied(entry: Randomization, number: Number, nominal: float | None) -> Number:
    """The value of a field for a drawn number, or an array of them.

    Raises: ValueError: a factor or an offset on an unknown nominal.
    """
    if entry.operation == "abs":
        return number
    if nominal is None:
        raise ValueError(f"{entry.field}: {entry.operation} of an unknown nominal")
    return nominal * number if entry.operation == "scale" else nominal + number


def ends_of(entry: Randomization, nominal: float | None) -> tuple[float, float]:
    """Least and largest value of a field; all but `encoder_bias` cut at 0."""
    low, high = (applied(entry, number, nominal) for number in drawn_ends(entry))
    if entry.field == "encoder_bias":
        return low, high
    return max(0.0, low), max(0.0, high)


def own_ranges(actuator: JointActuator) -> dict[str, Randomization]:
    """A joint's ranges by field, in the order of `FIELDS` and then `FACTORS`."""
    stated = {entry.field: entry for entry in actuator.randomize}
    return {field: stated[field] for field in (*FIELDS, *FACTORS) if field in stated}


@dataclass(frozen=True, slots=True)
class _Fault:
    code: str
    message: str
    help: str
    is_error: bool = True


def check_ranges(actuators: ActuatorSet, collector: Collector) -> None:
    """Report ranges that cannot be drawn from, and those that are probably slips; joints are named together.

    Errors: a factor or an offset on an unknown nominal (RND001); a field that the joint does not have (RND002);
    a factor on 0 (RND003); values below 0 (RND004). Warnings: a gaussian that reaches below 0 (RND005); a nominal
    outside of the range (RND006); kinetic friction above static friction (RND007); gains of a network (RND008).
    """
    found: dict[tuple[str, str, _Fault], list[JointActuator]] = {}
    # A number that is told itself is not told by its range again.
    told = [item.where for item in actuators.diagnostics]
    for actuator in actuators.joints:
        outside = False
        for field, entry in own_ranges(actuator).items():
            for fault in _faults(actuator, entry):
                found.setdefault((actuator.group, field, fault), []).append(actuator)
                outside |= fault.code == "RND006" and field.startswith("friction.")
        # A range that leaves the nominal out is the wrong one, whatever it meets.
        for fault in () if outside else _friction_fault(actuator):
            found.setdefault((actuator.group, "friction.coulomb", fault), []).append(actuator)
    for (group, field, fault), joints in found.items():
        entry_of = own_ranges(joints[0])
        entry_at = entry_of.get(field) or entry_of.get("friction.static")
        where = f"actuators.{group}.randomize.{field}"
        if not fault.is_error and any(item.startswith(f"{where}.") for item in told):
            continue
        (collector.error if fault.is_error else collector.warning)(
            fault.code,
            f"{listed(joint.joint for joint in joints)}: {fault.message}",
            where=where,
            span=None if entry_at is None else entry_at.span,
            help=fault.help,
        )


def _faults(actuator: JointActuator, entry: Randomization) -> Iterator[_Fault]:
    field = entry.field
    if field in FACTORS:
        if (idle := _idle(actuator, entry)) is not None:
            yield idle
            if idle.code != "RND003":
                return
        elif field == "gains" and None in [one.value for one in _parts(actuator, field)]:
            yield _Fault("RND001", f"{field}: kp or kd is unknown", "state kp and kd")
        yield from _outside(entry, 1.0, "1", None)
        return
    if (idle := _idle(actuator, entry)) is not None:
        yield idle
        return
    nominal, unit = nominal_of(actuator, field), unit_of(actuator, field)
    if entry.operation != "abs" and nominal is None:
        yield _Fault(
            "RND001",
            f"{field} is unknown, and the range is {_WORDS[entry.operation]} it",
            f"state {field}, or give the range as abs",
        )
        return
    if field != "encoder_bias":
        least = applied(entry, drawn_ends(entry)[0], nominal)
        if least < 0.0 and entry.distribution == "gaussian":
            # Mean and standard deviation in the order of two ends.
            rises = entry.high >= entry.low > 0.0
            asked = "is it a range? `gaussian` takes mean and standard deviation. Else " if rises else ""
            yield _Fault(
                "RND005",
                f"{field} is drawn below 0 within {format_number(SPREAD)} std: {format_quantity(least, unit)}",
                asked + "choose a smaller standard deviation, or log_uniform; "
                "actspec cuts such draws to 0, simulators may not",
                False,
            )
        elif least < 0.0:
            yield _Fault(
                "RND004",
                f"{field} is drawn below 0: {format_quantity(least, unit)}",
                f"the nominal is {format_quantity(nominal, unit)}: raise the low end",
            )
    if nominal is not None:
        neutral = {"scale": 1.0, "add": 0.0, "abs": nominal}[entry.operation]
        text = (
            f"the nominal {format_quantity(nominal, unit)}"
            if entry.operation == "abs"
            else format_number(neutral)
        )
        yield from _outside(entry, neutral, text, nominal)


_WORDS = {"scale": "a factor on", "add": "an offset on"}


def without_effect(actuator: JointActuator, entry: Randomization) -> str | None:
    """Why a range changes nothing in a joint, which has no such number, or 0 to multiply; None where it may."""
    idle = _idle(actuator, entry)
    return None if idle is None else idle.message


def _idle(actuator: JointActuator, entry: Randomization) -> _Fault | None:
    field = entry.field
    if actuator.level is Level.ACTUATOR_NET and field in ("kp", "kd", "gains"):
        return _Fault("RND008", f"a network has no {field} to draw", "remove it, or draw strength", False)
    parts = _parts(actuator, field)
    if not parts and field not in ("delay", "strength"):
        return _absent(actuator, field)
    if field in FACTORS:
        if not parts or any(part.value != 0.0 for part in parts):
            return None
        return _Fault("RND003", f"{field} scales nothing but zeros", f"state {' and '.join(FACTORS[field])}")
    if entry.operation != "scale" or nominal_of(actuator, field) != 0.0:
        return None
    unit = unit_of(actuator, field)
    return _Fault(
        "RND003", f"{field} is 0 {unit}, and 0 times a factor stays 0", "give the range as add or abs"
    )


def _parts(actuator: JointActuator, field: str) -> list[Quantity]:
    """The numbers of a joint that a field draws, each if the joint has it."""
    there = [quantity_of(actuator, part) for part in FACTORS.get(field, (field,))]
    return [quantity for quantity in there if quantity is not None]


def _absent(actuator: JointActuator, field: str) -> _Fault:
    if field == "friction.stribeck_velocity":
        return _Fault(
            "RND002", "the joint has no Stribeck velocity to draw", "state friction.stribeck_velocity"
        )
    return _Fault(
        "RND002",
        f"a drive of level {actuator.level.value} and command {actuator.command.value} has no {field}",
        "remove the range",
    )


def _outside(entry: Randomization, neutral: float, text: str, nominal: float | None) -> Iterator[_Fault]:
    """A range without its neutral value: a nominal, or a factor or offset on that, which changes nothing."""
    low, high = drawn_ends(entry)
    # Ends come from decimal text and the nominal from a formula: a rounding apart is not outside.
    slack = 1e-9 * max(abs(low), abs(high), abs(neutral))
    if not low - slack <= neutral <= high + slack:
        help = "widen the range" + ", or correct the nominal" * (entry.operation == "abs")
        factors = not entry.has_unit and high <= fields.largest_factor(entry.field)
        readings = [("scale", "factors", 1.0 if factors else None), ("abs", "values", nominal)]
        meant = [
            f"are they {what}? Then write `{other}: [{format_number(entry.low)}, {format_number(entry.high)}]`"
            for other, what, own in readings
            if other != entry.operation and own and low < own < high and entry.field != "encoder_bias"
        ]
        help = "; or ".join(meant) or help
        yield _Fault(
            "RND006",
            f"{text} is outside of the range of {entry.field}, {format_number(low)} to {format_number(high)}: "
            "the nominal robot is never drawn",
            help,
            False,
        )


def _friction_fault(actuator: JointActuator) -> Iterator[_Fault]:
    """Kinetic friction can be drawn above static friction."""
    ranges = own_ranges(actuator)
    coulomb, static = ranges.get("friction.coulomb"), ranges.get("friction.static")
    if static is None and (coulomb is None or actuator.friction_static is None):
        return
    most = _end(actuator, "friction.coulomb", coulomb, 1)
    least = _end(actuator, "friction.static", static, 0)
    if most is not None and least is not None and most > least * (1.0 + 1e-9):
        unit = actuator.friction_coulomb.unit
        yield _Fault(
            "RND007",
            f"coulomb friction up to {format_quantity(most, unit)} meets static friction from "
            f"{format_quantity(least, unit)}: it is cut to the static one",
            "draw both so that static stays above",
            False,
        )


def _end(actuator: JointActuator, field: str, entry: Randomization | None, which: int) -> float | None:
    nominal = nominal_of(actuator, field)
    if entry is None:
        return nominal
    if entry.operation != "abs" and nominal is None:
        return None
    return ends_of(entry, nominal)[which]
