"""What a range is of: the fields, their nominal values, and which values a drawn number gives."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from actspec.ir import JointActuator, Quantity, Randomization

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Numbers = NDArray[np.float64]

Number = TypeVar("Number", float, "Numbers")

FIELDS = (
    "kp",
    "kd",
    "effort_limit",
    "armature",
    "friction.coulomb",
    "friction.static",
    "friction.viscous",
    "friction.stribeck_velocity",
    "encoder_bias",
    "delay",
)
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
    name = {"friction.stribeck_velocity": "stribeck_velocity"}.get(field, field.replace(".", "_"))
    found: Quantity | None = getattr(actuator, name)
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
    if field == "delay":
        return "s"
    slide = actuator.effort_limit.unit == "N"
    units = {"kp": ("N*m/rad", "N/m"), "kd": ("N*m*s/rad", "N*s/m")}
    return units.get(field, ("rad/s", "m/s"))[slide]


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
