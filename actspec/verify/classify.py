"""What is wrong with a figure that is another one: the code, and the reason in words."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

SAME = 1e-3
"""Relative difference up to which a figure is what a mistake would make of it. Chosen: coarser than the tolerance,
because people round what they copy; far finer than any two mistakes are apart."""

LOST = 1e3
"""Times the spec's limit from which on a limit limits nothing. Chosen: stand-ins are 1e6 to 1e9 [N*m]."""

DEGREES = 180.0 / math.pi
RPM = 30.0 / math.pi
TURN = 2.0 * math.pi

LIMITS = (
    "effort_limit",
    "velocity_limit",
    "stall_torque",
    "no_load_speed",
    "solver_effort_limit",
    "curve.drive_torque",
    "curve.brake_torque",
    "curve.knee_speed",
)
DELAYS = ("delay", "delay_nominal", "delay_low", "delay_high")
FRICTIONS = ("frictionloss", "friction_static", "friction_setting", "dynamic_friction_setting")
_SPEEDS = ("velocity_limit", "no_load_speed", "curve.knee_speed")
_PER_ANGLE = ("kp", "kd", "joint_damping")
_GEARED = ("effort_limit", "velocity_limit", "stall_torque", "no_load_speed", "armature", "kp", "kd")

Values = Mapping[str, float | None]


@dataclass(frozen=True, slots=True)
class Difference:
    """One figure of one joint that is another one.

    Attributes:
        field: The field.
        expected: What it should be; None: unknown.
        got: What it is; None: the file does not say.
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


def classify(one: Difference) -> tuple[str, str]:
    """The code of a difference and its reason, which follows a colon.

    The first that fits is told, the surest first.
    """
    field, expected, got = one.field, one.expected, one.got
    if one.forgotten:
        return "VFY109", "a mapping leaves the joint out, and what it gives then is 0"
    if _permuted(one):
        return "VFY109", "it is another joint's: two joints are swapped, or the order is another one"
    if field in DELAYS:
        return "VFY108", "the delay counts steps of another length, or another number of steps"
    if expected is not None and got is not None and expected and _near(got, -expected):
        return "VFY106", "the sign is wrong"
    if _lost(one):
        return "VFY104", "the limit is lost"
    if one.geared and field in (*_GEARED, "joint_damping", "frictionloss"):
        return "VFY103", "the file has a gear at the joint, and the numbers are the joint's already"
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
        return "VFY107", "the armature is another one"
    return "VFY110", "the file says something else" if got is not None else "the file does not say it"


def _lost(one: Difference) -> bool:
    expected, got = one.expected, one.got
    if one.field not in LIMITS or expected is None or not 0.0 < expected < math.inf:
        return False
    return got is None or got == 0.0 or got >= LOST * expected


def _near(one: float | None, other: float | None) -> bool:
    if one is None or other is None or not (math.isfinite(one) and math.isfinite(other)):
        return False
    return math.isclose(one, other, rel_tol=SAME)


def _permuted(one: Difference) -> bool:
    """Whether the joints with wrong figures have each other's right ones."""
    wrong = [pair for pair in one.everywhere.values() if not _same(*pair)]
    if len(wrong) < 2:
        return False
    stated = sum(bool(expected) for expected, _ in one.everywhere.values())
    turned = sum(expected is not None and _near(got, -expected) for expected, got in wrong)
    if turned == len(wrong) == stated:
        # Every sign is wrong: no two joints were swapped for that.
        return False
    asked, found = (sorted(values, key=_by_value) for values in zip(*wrong, strict=True))
    return all(_same(a, b) for a, b in zip(asked, found, strict=True))


def _by_value(value: float | None) -> float:
    return -math.inf if value is None else value


def _same(one: float | None, other: float | None) -> bool:
    return one == other or _near(one, other)


def _swapped(one: Difference) -> bool:
    if one.field not in ("kp", "kd"):
        return False
    asked, found = one.asked, one.found
    return _near(found.get("kp"), asked.get("kd")) and _near(found.get("kd"), asked.get("kp"))


def _twice(one: Difference) -> bool:
    if one.field not in ("kd", "joint_damping") or one.got is None:
        return False
    kd, viscous = one.asked.get("kd") or 0.0, one.asked.get("joint_damping") or 0.0
    own = one.expected or 0.0
    parts = [own + other for other in (kd, viscous, own) if other]
    if one.field == "joint_damping" and kd:
        parts.append(kd)
    return any(_near(one.got, part) for part in parts if part != own)


def _friction(one: Difference) -> str | None:
    """What is wrong with a friction, if it is its unit or its place."""
    asked, got = one.asked, one.got
    if got is None or not got:
        return None
    if one.field.endswith("_setting"):
        return (
            "in this version the field has no unit, it is a factor on the joint's load, and this is a torque"
        )
    coulomb, viscous = asked.get("frictionloss"), asked.get("joint_damping")
    if one.field == "joint_damping" and _near(got, coulomb):
        return "the dry friction stands where the viscous one belongs"
    if one.field not in FRICTIONS:
        return None
    if _near(got, viscous):
        return "the viscous friction stands where the dry one belongs"
    if one.versioned:
        return "the field is a torque in this version, and a factor without unit in others"
    limit, expected = asked.get("effort_limit"), one.expected
    if not expected:
        return None
    factors = {
        "a share of the effort limit, without unit": None if not limit else 1.0 / limit,
        "in mN*m": 1e3,
        "in kN*m": 1e-3,
        "in kgf*cm": 100.0 / 9.80665,
        "in kgf*m": 1.0 / 9.80665,
        "per degree": 1.0 / DEGREES,
        "per radian of degrees": DEGREES,
    }
    return next(
        (f"it is {words}" for words, factor in factors.items() if factor and _near(got / expected, factor)),
        None,
    )


def _other_unit(field: str, expected: float | None, got: float | None) -> str | None:
    if not expected or not got or not (math.isfinite(expected) and math.isfinite(got)):
        return None
    ratio = got / expected
    if field == "filter_cutoff":
        return next(
            (
                f"{words} is read in Hz"
                for words, r in (("rad/s", TURN), ("a time", 1 / TURN))
                if _near(ratio, r)
            ),
            None,
        )
    if field in _SPEEDS and (_near(ratio, RPM) or _near(ratio, 1.0 / RPM)):
        return "rpm is read in rad/s" if ratio > 1.0 else "rad/s is taken for rpm"
    per_angle = field in _PER_ANGLE
    if _near(ratio, 1.0 / DEGREES if per_angle else DEGREES):
        return "it is per degree, and per radian is read" if per_angle else "it is in degrees"
    if _near(ratio, DEGREES if per_angle else 1.0 / DEGREES):
        return "it is converted from degrees, and was in radians already"
    return None


def _gear(one: Difference) -> str | None:
    if one.field not in _GEARED or not one.expected or one.got is None:
        return None
    ratio = one.got / one.expected
    for factor in one.factors:
        for power, words in (
            (1, "once too often"),
            (-1, "left out"),
            (2, "squared too often"),
            (-2, "left out"),
        ):
            if factor != 1.0 and _near(ratio, factor**power):
                if one.field == "armature" and power in (1, -1):
                    words = "taken to the first power, and it goes with its square"
                return f"the gear of {factor:g} is {words}"
    return None
