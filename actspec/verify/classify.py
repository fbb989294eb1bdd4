"""What is wrong with a figure: the code, and the reason in words."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from actspec.fields import FIELDS
from actspec.readings.compare import (
    DEGREES,
    RPM,
    TURN,
    gear_power,
    is_lost,
    near,
    ratio_of,
    torque_slip,
    twice_damped,
)
from actspec.units import Kind, format_number

DELAYS = frozenset(name for name in FIELDS if name.startswith("delay"))
DAMPINGS = ("kd", "joint_damping")
FRICTIONS = ("frictionloss", "friction_static", "friction_setting", "dynamic_friction_setting")
_PER_ANGLE = frozenset(
    name for name, field in FIELDS.items() if field.kind in (Kind.STIFFNESS, Kind.VELOCITY_GAIN)
)
_GEARED = ("effort_limit", "velocity_limit", "stall_torque", "no_load_speed", "armature", "kp", "kd")

Values = Mapping[str, float | None]


@dataclass(frozen=True, slots=True)
class WrongFigure:
    """One figure of one joint that is not as it should be.

    Attributes:
        field: The field.
        expected: What it should be; None: unknown.
        got: What it is; None: the file does not state it.
        asked: All figures of the joint that there should be.
        found: All figures of the joint that there are.
        everywhere: Of the field: joint to (expected, got), for every joint.
        factors: Gears and reductions between the motor and the joint.
        forgotten: Whether a mapping of the file leaves the joint out.
        geared: Whether the file has a gear at the joint that actspec does not write.
        versioned: Whether the unit of friction depends on the simulator's version.
    """

    field: str
    expected: float | None
    got: float | None
    asked: Values
    found: Values
    everywhere: Mapping[str, tuple[float | None, float | None]]
    factors: Sequence[float] = ()
    forgotten: bool = False
    geared: bool = False
    versioned: bool = False


def classify(one: WrongFigure) -> tuple[str, str]:
    """The code of a difference and its reason, which follows a colon.

    The first that fits, the surest first.
    """
    field, expected, got = one.field, one.expected, one.got
    if one.forgotten:
        return "VFY109", "a mapping leaves the joint out, which gives 0"
    if _permuted(one):
        return "VFY109", "it is another joint's number: two joints are swapped, or the order differs"
    if field in DELAYS:
        return "VFY108", "the delay counts steps of another length, or another number of steps"
    if expected and near(got, -expected):
        return "VFY106", "the sign is wrong"
    if is_lost(field, got, expected):
        return "VFY104", "the limit is lost"
    if one.geared and field in (*_GEARED, "joint_damping", "frictionloss"):
        return "VFY103", "the file has a gear at the joint, and the numbers are on the joint side already"
    if _swapped(one):
        return "VFY110", "kp and kd are swapped"
    if _twice(one):
        return "VFY101", "damping is counted twice, as the drive's gain and as the joint's friction"
    unit = _other_unit(field, expected, got)
    wrong_friction = _friction(one)
    if wrong_friction is not None:
        return "VFY102", wrong_friction
    if unit is not None:
        return "VFY105", unit
    gear = _gear(one)
    if gear is not None:
        return "VFY103", gear
    if field == "armature":
        return "VFY107", "the armature differs"
    return "VFY110", "the file has another number" if got is not None else "the file does not state it"


def _permuted(one: WrongFigure) -> bool:
    """Whether the joints with wrong figures have each other's right ones."""
    wrong = [pair for pair in one.everywhere.values() if not _same(*pair)]
    if len(wrong) < 2:
        return False
    stated = sum(bool(expected) for expected, _ in one.everywhere.values())
    turned = sum(expected is not None and near(got, -expected) for expected, got in wrong)
    if turned == len(wrong) == stated:
        # Every sign is wrong: no two joints were swapped for that.
        return False
    asked, found = (sorted(values, key=_by_value) for values in zip(*wrong, strict=True))
    return all(_same(a, b) for a, b in zip(asked, found, strict=True))


def _by_value(value: float | None) -> float:
    return -math.inf if value is None else value


def _same(one: float | None, other: float | None) -> bool:
    return one == other or near(one, other)


def _swapped(one: WrongFigure) -> bool:
    if one.field not in ("kp", "kd"):
        return False
    asked, found = one.asked, one.found
    return near(found.get("kp"), asked.get("kd")) and near(found.get("kd"), asked.get("kp"))


def _twice(one: WrongFigure) -> bool:
    if one.field not in DAMPINGS:
        return False
    beside = [one.asked.get(name) for name in DAMPINGS]
    # The gain may also stand in place of the friction.
    moved = one.field == "joint_damping" and bool(beside[0]) and near(one.got, beside[0])
    return moved or any(twice_damped(one.got, one.expected, other) for other in beside)


def _friction(one: WrongFigure) -> str | None:
    """What is wrong with a friction, if it is its unit or its place."""
    asked, got = one.asked, one.got
    if got is None or not got:
        return None
    if one.field.endswith("_setting"):
        return (
            "in this version the field has no unit, it is a factor on the joint's load, and this is a torque"
        )
    coulomb, viscous = asked.get("frictionloss"), asked.get("joint_damping")
    if one.field == "joint_damping" and near(got, coulomb):
        return "the dry friction stands where the viscous one belongs"
    if one.field not in FRICTIONS:
        return None
    if near(got, viscous):
        return "the viscous friction stands where the dry one belongs"
    if one.versioned:
        return "the field is a torque in this version, and a factor without unit in others"
    limit, ratio = asked.get("effort_limit"), ratio_of(got, one.expected)
    if limit and near(ratio, 1.0 / limit):
        return "it is a share of the effort limit, without unit"
    slips = {1.0 / DEGREES: "it is per degree", DEGREES: "it is per radian of degrees"}
    unit = torque_slip(ratio, "N*m")
    return f"it is in {unit}" if unit else next((t for f, t in slips.items() if near(ratio, f)), None)


def _other_unit(field: str, expected: float | None, got: float | None) -> str | None:
    ratio = ratio_of(got, expected)
    if ratio is None:
        return None
    if field == "filter_cutoff":
        if near(ratio, TURN):
            return "rad/s is read in Hz"
        return "a time is read in Hz" if near(ratio, 1.0 / TURN) else None
    if field in FIELDS and FIELDS[field].kind is Kind.SPEED and (near(ratio, RPM) or near(ratio, 1.0 / RPM)):
        return "rpm is read in rad/s" if ratio > 1.0 else "rad/s is read as rpm"
    per_angle = field in _PER_ANGLE
    if near(ratio, 1.0 / DEGREES if per_angle else DEGREES):
        return "it is per degree, and per radian is read" if per_angle else "it is in degrees"
    if near(ratio, DEGREES if per_angle else 1.0 / DEGREES):
        return "it is converted from degrees, and was in radians already"
    return None


_POWERS = {1: "once too often", -1: "left out", 2: "squared too often", -2: "left out"}


def _gear(one: WrongFigure) -> str | None:
    if one.field not in _GEARED:
        return None
    ratio = ratio_of(one.got, one.expected)
    for factor in one.factors:
        power = gear_power(ratio, factor)
        if power is not None:
            words = _POWERS[power]
            if one.field == "armature" and power in (1, -1):
                words = "taken to the first power, and it goes with its square"
            return f"the gear of {format_number(factor)} is {words}"
    return None
