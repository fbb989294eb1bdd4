"""A class of Isaac Lab with an asymmetric torque-speed curve and a friction of its own: its limit, its curve, and what
is to be remarked on them.

Source: as `readings.isaaclab.take_curve`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from actspec.diagnostics import listed
from actspec.fields import FIELDS
from actspec.ir import AsymmetricCurve, JointKind, Quantity, unknown
from actspec.lift.figures import NONE_FROM, quantity_of, real_limit
from actspec.readings.artifact import ActuatorGroup
from actspec.readings.dict_keys import Found
from actspec.readings.isaaclab import BESIDE, CURVE, CURVED, FRICTIONS
from actspec.units import format_quantity

Figures = Mapping[str, Found]

_TORQUES = ("curve.drive_torque", "curve.brake_torque")
_SPEEDS = ("curve.knee_speed", "no_load_speed")


def curve_of(figures: Figures, torque: str, speed: str) -> AsymmetricCurve | None:
    """The curve, whatever its points are; None without one.

    Args:
        figures: Of the joint.
        torque: Unit.
        speed: Unit.
    """
    if _TORQUES[0] not in figures:
        return None
    return AsymmetricCurve(
        *(_part(figures, n, torque) for n in _TORQUES), *(_part(figures, n, speed) for n in _SPEEDS)
    )


def no_curve(curve: AsymmetricCurve) -> str | None:
    """Why its speeds limit nothing, or in a way for which a spec has no words; "" where nothing is lost; else None."""
    drive, brake, knee, end = curve.drive_torque, curve.brake_torque, curve.knee_speed, curve.no_load_speed
    both = f"it has {drive.value} {drive.unit} driving and {brake.value} {brake.unit} braking"
    if end.known and end.require() >= NONE_FROM:
        return "" if drive.value == brake.value else f"its curve ends at no speed, and is left out: {both}"
    if end.value is None and end.note and None not in (drive.value, brake.value, knee.value):
        return f"its torque-speed line is left out: {end.note}; {both}"
    if end.known and knee.value == end.value:
        at = format_quantity(end.require(), end.unit)
        return f"its torque-speed line is left out: X1 and X2 are both {at}, and a torque that ends at once is no curve"
    return None


def limit_of(figures: Figures, solvers: str, unit: str) -> tuple[Quantity, str | None]:
    """The larger torque of the curve, or what the solver clips at below it, with what is to be remarked.

    Args:
        figures: Of the joint.
        solvers: What the group calls the solver's limit.
        unit: Of torques.
    """
    ends = [_part(figures, name, unit) for name in _TORQUES]
    unread = next((end for end in ends if end.value is None), None)
    if unread is not None:
        return unread, None
    largest = real_limit(max(ends, key=lambda end: end.require()))
    solver, most = figures.get("solver_effort_limit"), largest.value
    clip = None if solver is None else solver.value
    shown = "" if clip is None else format_quantity(clip, unit)
    curves = "" if most is None else format_quantity(most, unit)
    if solver is not None and clip is not None and 0.0 < clip < min(most or NONE_FROM, NONE_FROM):
        below = f", below the {curves} of its curve" if curves else ""
        return quantity_of(solver, unit), f"effort_limit is {solvers}, {shown}, where the solver clips{below}"
    if most is None:
        return largest, None
    higher = clip is not None and most <= clip < NONE_FROM
    other = f"the solver's, {shown} ({solvers}), is no lower" if higher else "it has no other limit"
    return largest, f"effort_limit is the larger torque of its curve, {curves}: {other}"


def remarks(group: ActuatorGroup, figures: Figures, joint: JointKind) -> Iterator[str]:
    """What the class is read as, and what is not known of it.

    Args:
        group: Its group.
        figures: Of the joint.
        joint: Its kind.
    """
    friction = ""
    settings = [group.settings[name] for name in FRICTIONS.values() if name in group.settings]
    if any(setting.number != 0.0 for setting in settings):
        names = ", ".join(FRICTIONS.values())
        friction = f", and friction ({names}) of its own, which it rounds off near standstill (tanh, Va)"
    yield (
        f"{group.cls} is read as unitree_rl_lab's UnitreeActuator: a torque-speed curve ({', '.join(CURVE)})"
        f"{friction}{_other(group)}"
    )
    for figure, name in FRICTIONS.items():
        beside = figures.get(BESIDE.format(figure))
        if beside is not None:
            field = FIELDS[figure]
            own = format_quantity(figures[figure].value or 0.0, field.unit(joint))
            yield f"{field.spec} is {name} alone, {own}: what the joint has beside it is not known ({beside.why})"


def _other(group: ActuatorGroup) -> str:
    """What is not known of a class that is made of the one with the curve; "" of that one itself."""
    made = group.settings.get("class_type")
    more = [name for name in group.own if name not in (*CURVE, *FRICTIONS.values(), "Va")]
    if (made is None or f"{made.value}Cfg" == CURVED) and not more:
        return ""
    with_them = f" with {listed(more)}" if more else ""
    return f"; what else {CURVED[:-3] if made is None else made.value} does{with_them} is not known here"


def _part(figures: Figures, name: str, unit: str) -> Quantity:
    found = figures.get(name)
    return unknown(unit) if found is None else quantity_of(found, unit)
