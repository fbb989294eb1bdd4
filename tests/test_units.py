"""Units by hand values, and what is said about a wrong one."""

from __future__ import annotations

import math
import pickle
import re

import pytest

from actspec.units import (
    MAX_LENGTH,
    Kind,
    UnitError,
    convert,
    format_quantity,
    parse_quantity,
    parse_with_unit,
)

# Only products with pi and three-factor imperial units are rounded more than once.
ROUNDING = 1e-15

RPM_570 = "1/min of a shaft is rpm: write `570 rpm`, which is 59.6903 rad/s"
PER_SECOND_60 = "1/s of a shaft is rad/s or rev/s: write `60 rad/s`, or `60 rev/s`, which is 376.991 rad/s"
SERVO_TIME = "sheets of servos have the time for 60 deg: for 0.17 s write `6.16 rad/s`"
SPEED_CONSTANT = "a speed constant times the voltage is the speed without load: at 24 V write `7200 rpm`"
OZ_IN = 0.45359237 / 16 * 9.80665 * 0.0254  # 0.00706155181422604


@pytest.mark.parametrize(
    ("given", "kind", "value", "unit", "linear"),
    [
        ("33.5 N*m", Kind.TORQUE, 33.5, "N*m", False),
        ("33.5 N", Kind.TORQUE, 33.5, "N", True),
        ("100 N*m/rad", Kind.STIFFNESS, 100.0, "N*m/rad", False),
        ("100 N/m", Kind.STIFFNESS, 100.0, "N/m", True),
        ("0.5 N*m*s/rad", Kind.VELOCITY_GAIN, 0.5, "N*m*s/rad", False),
        ("0.5 N*s/m", Kind.VELOCITY_GAIN, 0.5, "N*s/m", True),
        ("0.01 kg*m^2", Kind.INERTIA, 0.01, "kg*m^2", False),
        ("12 g", Kind.INERTIA, 0.012, "kg", True),
        ("21 rad/s", Kind.SPEED, 21.0, "rad/s", False),
        ("250 mm/s", Kind.SPEED, 0.25, "m/s", True),
        ("-0.5 rad", Kind.POSITION, -0.5, "rad", False),
        ("15 cm", Kind.POSITION, 0.15, "m", True),
        ("90 deg", Kind.ANGLE, math.pi / 2, "rad", None),
        ("15 arcmin", Kind.ANGLE, math.pi / 720, "rad", None),
        ("8 ms", Kind.TIME, 0.008, "s", None),
        ("30 Hz", Kind.FREQUENCY, 30.0, "Hz", None),
        ("20 %", Kind.RATIO, 0.2, "1", None),
        ("0.2", Kind.RATIO, 0.2, "1", None),
        ("24 V", Kind.VOLTAGE, 24.0, "V", None),
        ("500 mA", Kind.CURRENT, 0.5, "A", None),
        ("0.1 N*m/A", Kind.TORQUE_CONSTANT, 0.1, "N*m/A", False),
        ("40 N/A", Kind.TORQUE_CONSTANT, 40.0, "N/A", True),
        ("0.3 Ohm", Kind.RESISTANCE, 0.3, "Ohm", None),
    ],
    ids=lambda v: str(v) if isinstance(v, str) else "",
)
def test_each_kind(given: str, kind: Kind, value: float, unit: str, linear: bool | None) -> None:
    """Each kind in its own units, rotary and linear; a kind with one unit cannot tell the joint."""
    parsed = parse_quantity(given, kind)
    assert (parsed.value, parsed.unit, parsed.linear) == (value, unit, linear)


# Hand values: 1 kgf = 9.80665 N, 1 lbf = 0.45359237 * 9.80665 N, 1 in = 0.0254 m.
@pytest.mark.parametrize(
    ("given", "kind", "value"),
    [
        ("1 kgf*cm", Kind.TORQUE, 0.0980665),
        ("1000 gf*cm", Kind.TORQUE, 0.0980665),
        ("1 oz*in", Kind.TORQUE, 0.00706155181422604),
        ("1 ozf*in", Kind.TORQUE, OZ_IN),
        ("1 lbf*ft", Kind.TORQUE, 1.3558179483314004),
        ("1 lbf*in", Kind.TORQUE, 16 * OZ_IN),
        ("5 mN*m", Kind.TORQUE, 0.005),
        ("2 kN", Kind.TORQUE, 2000.0),
        ("5 N*mm", Kind.TORQUE, 0.005),
        ("7 uN*m", Kind.TORQUE, 7e-6),
        ("1 g*cm^2", Kind.INERTIA, 1e-7),
        ("1 kg*mm^2", Kind.INERTIA, 1e-6),
        ("200 rpm", Kind.SPEED, 20.943951023931955),
        ("2 krpm", Kind.SPEED, 209.43951023931953),
        ("200 rev/min", Kind.SPEED, 20.943951023931955),
        ("1 turn/s", Kind.SPEED, 2 * math.pi),
        ("180 deg/s", Kind.SPEED, math.pi),
        ("36 km/h", Kind.SPEED, 10.0),
        ("1 ft/s", Kind.SPEED, 0.3048),
        ("1 N*m/deg", Kind.STIFFNESS, 57.29577951308232),
        ("1 N*m/rev", Kind.STIFFNESS, 0.15915494309189535),
        ("1 N/mm", Kind.STIFFNESS, 1000.0),
        ("1 N*m/rpm", Kind.VELOCITY_GAIN, 9.549296585513721),  # 30/pi
        ("1 N*m*s/deg", Kind.VELOCITY_GAIN, 57.29577951308232),
        ("2 mrad", Kind.POSITION, 0.002),
        ("1 rev", Kind.ANGLE, 2 * math.pi),
        ("2 in", Kind.POSITION, 0.0508),
        ("250 us", Kind.TIME, 0.00025),
        ("2 min", Kind.TIME, 120.0),
        ("1 h", Kind.TIME, 3600.0),
        ("0.2 kHz", Kind.FREQUENCY, 200.0),
        ("8 MHz", Kind.FREQUENCY, 8e6),
        ("8 mHz", Kind.FREQUENCY, 0.008),
        ("3 kV", Kind.VOLTAGE, 3000.0),
        ("3 mV", Kind.VOLTAGE, 0.003),
        ("90 mOhm", Kind.RESISTANCE, 0.09),
        ("24 V/A", Kind.RESISTANCE, 24.0),
        ("14 oz*in/A", Kind.TORQUE_CONSTANT, 14 * OZ_IN),
    ],
    ids=lambda v: v if isinstance(v, str) else "",
)
def test_hand_values(given: str, kind: Kind, value: float) -> None:
    """Every unit of the table against its definition."""
    assert parse_quantity(given, kind).value == pytest.approx(value, rel=ROUNDING)


def test_decimal_prefixes_round_once() -> None:
    """A prefix gives the float nearest to the decimal: 0.9 mm is 0.0009, and 0.9 * 0.001 is not."""
    assert 0.9 * 0.001 != 0.0009
    assert parse_quantity("0.9 mm", Kind.POSITION).value == 0.0009
    assert parse_quantity("180 deg", Kind.ANGLE).value == math.pi


@pytest.mark.parametrize(
    "unit",
    [
        "N*m*s/rad", "N·m·s/rad", "N⋅m⋅s/rad", "N∙m∙s/rad", "N×m×s/rad", "N m s/rad", "N m s / rad",
        "Nm*s/rad", "Nm s/rad", "N*m/(rad/s)", "Nm/(rad/s)", "N*m/rad*s", "(N*m)*(s/rad)", "N*m*s*rad^-1",
        "N*m*s*rad**-1", "N·m·s·rad⁻¹", "kg*m^2/(s*rad)", "kg m²/s/rad", "kg*m**2*s^(-1)/rad",
        "1/(rad/(N*m*s))", "N*m*s/rad*1",
    ],
)  # fmt: skip
def test_spellings(unit: str) -> None:
    """Every spelling of one unit is that unit; `a/b/c` is a/(b*c)."""
    assert parse_quantity(f"3 {unit}", Kind.VELOCITY_GAIN).value == 3.0


@pytest.mark.parametrize(
    ("given", "kind", "value"),
    [
        ("90°", Kind.ANGLE, math.pi / 2),
        ("180 °/s", Kind.SPEED, math.pi),
        ("3 \N{OHM SIGN}", Kind.RESISTANCE, 3.0),
        ("3 k\N{GREEK CAPITAL LETTER OMEGA}", Kind.RESISTANCE, 3000.0),
        ("3 ohm", Kind.RESISTANCE, 3.0),
        ("3 \N{MICRO SIGN}s", Kind.TIME, 3e-6),
        ("3 \N{GREEK SMALL LETTER MU}s", Kind.TIME, 3e-6),
        ("\N{MINUS SIGN}3 rad", Kind.POSITION, -3.0),
        ("3\N{NO-BREAK SPACE}N*m", Kind.TORQUE, 3.0),
    ],
    ids=["degree", "degree-per-s", "ohm-sign", "omega", "ohm", "micro", "mu", "minus", "nbsp"],
)
def test_characters_of_datasheets(given: str, kind: Kind, value: float) -> None:
    """Text pasted from a datasheet keeps its typographic characters."""
    assert parse_quantity(given, kind).value == value


@pytest.mark.parametrize(
    ("given", "value"),
    [
        ("1e-3 N*m", 0.001), ("1E3N*m", 1000.0), ("-.5 N*m", -0.5), ("+3", 3.0), ("3.", 3.0),
        ("  7 N*m ", 7.0), ("010", 10.0), (7, 7.0), (-0.25, -0.25), ("0 N", 0.0),
    ],
)  # fmt: skip
def test_numbers(given: str | float, value: float) -> None:
    """Signs, exponents, bare dots and numbers that are no text."""
    assert parse_quantity(given, Kind.TORQUE).value == value


@pytest.mark.parametrize("kind", list(Kind), ids=str)
def test_bare_numbers(kind: Kind) -> None:
    """0 is always fine and tells nothing of the joint; another bare number only where the kind says so."""
    zero = parse_quantity(0, kind)
    assert (zero.value, zero.unit, zero.linear) == (0.0, kind.rotary_unit, None)
    refused = {Kind.TIME, Kind.FREQUENCY, Kind.ANGLE, Kind.POSITION, Kind.LENGTH, Kind.LEAD, Kind.SPEED}
    assert kind.bare is (kind not in refused)
    if kind.bare:
        assert parse_quantity(10, kind) == parse_quantity("10", kind)
        assert parse_quantity(10, kind).value == 10.0
    else:
        for given in (10, 10.0, "10", "-1e1"):
            with pytest.raises(UnitError, match="has no unit"):
                parse_quantity(given, kind)


def explain(given: str | float, kind: Kind) -> tuple[str, str | None]:
    with pytest.raises(UnitError) as error:
        parse_quantity(given, kind)
    assert str(error.value) == error.value.message
    return error.value.message, error.value.help


COEFFICIENT = (
    "a dimensionless friction coefficient cannot be converted to N*m without the joint load; "
    "give the friction torque in N*m (N for a slide)"
)
TORQUES = "a torque is in N*m (hinge) or N (slide)"
ANGLE = "angle is a dimension of its own: write `{}` if that is meant"


@pytest.mark.parametrize(
    ("given", "kind", "message", "help"),
    [
        # 0.000301 x 0.45359237 kg x (0.0254 m)^2.
        (
            "0.000301 lb*in^2", Kind.INERTIA, "0.000301 lb*in^2 is not an inertia: unknown unit `lb`",
            "oz, lbf, kgf and gf are forces; as a mass 0.000301 lbf*in^2 is 8.80845e-08 kg*m^2",
        ),
        # 30 * 2 pi = 188.496
        ("30 Hz", Kind.SPEED, "30 Hz is a frequency, not a speed", "30 Hz as angular speed is 188.496 rad/s"),
        (
            "200 rad/s", Kind.FREQUENCY,
            "200 rad/s is a speed, not a frequency", "200 rad/s as frequency is 31.831 Hz",
        ),
        (
            "1800 rpm", Kind.FREQUENCY,
            "1800 rpm is a speed, not a frequency", "1800 rpm as frequency is 30 Hz",
        ),
        (
            "5 ms", Kind.FREQUENCY, "5 ms is a time, not a frequency",
            # 1/0.005 = 200; 200/(2 pi) = 31.831
            "a period of 5 ms is 200 Hz; a first-order lag with a time constant of 5 ms "
            "has its cutoff at 31.831 Hz",
        ),
        (
            "30 Hz", Kind.TIME, "30 Hz is a frequency, not a time",
            "the period of 30 Hz is 0.0333333 s; a first-order low-pass with its cutoff at 30 Hz "
            "has a time constant of 0.00530516 s",
        ),
        ("0 Hz", Kind.TIME, "0 Hz is a frequency, not a time", "a time is in s"),
        (
            "30 1/s", Kind.FREQUENCY, "30 1/s is not a frequency",
            "a frequency counts cycles: write `30 Hz` if cycles are meant",
        ),
        ("30 /s", Kind.SPEED, "30 /s is not a speed",
         "1/s of a shaft is rad/s or rev/s: write `30 rad/s`, or `30 rev/s`, which is 188.496 rad/s"),
        (10, Kind.TIME, "10 has no unit, and a time needs one", "write `10 ms` or `10 s`"),
        ("10", Kind.FREQUENCY, "10 has no unit, and a frequency needs one", "write `10 Hz`"),
        (
            10.5, Kind.SPEED, "10.5 has no unit, and a speed needs one",
            "write `10.5 rad/s`, `10.5 rpm` or `10.5 m/s`",
        ),
        ("0.5 N*m*s", Kind.VELOCITY_GAIN, "0.5 N*m*s is not a velocity gain", ANGLE.format("0.5 N*m*s/rad")),
        ("25 N*m", Kind.STIFFNESS, "25 N*m is a torque, not a stiffness", ANGLE.format("25 N*m/rad")),
        # 20 * 0.0980665 = 1.96133
        (
            "20 kgf*cm", Kind.STIFFNESS,
            "20 kgf*cm is a torque, not a stiffness", ANGLE.format("1.96133 N*m/rad"),
        ),
        (
            "25 N*m*s/rad", Kind.STIFFNESS, "25 N*m*s/rad is a velocity gain, not a stiffness",
            "a stiffness is in N*m/rad (hinge) or N/m (slide)",
        ),
        ("0.2 N*m*s/rad", Kind.TORQUE, "0.2 N*m*s/rad is a velocity gain, not a torque", TORQUES),
        (
            "5 N*m/rad/s", Kind.VELOCITY_GAIN, "5 N*m/rad/s is not a velocity gain",
            "`a/b/c` is a/(b*c): write `5 N*m*s/rad` if that is meant",
        ),
        (
            "5 N*m/rad s", Kind.VELOCITY_GAIN,
            "5 N*m/rad s is not a velocity gain: a space after `/` can be read two ways, "
            "use `*` and parentheses",
            "did you mean `5 N*m*s/rad`?",
        ),
        ("0.2 1", Kind.TORQUE, "0.2 1 is dimensionless, not a torque", COEFFICIENT),
        ("20 %", Kind.TORQUE, "20 % is dimensionless, not a torque", COEFFICIENT),
        ("3 rad", Kind.RATIO, "3 rad is an angle, not a ratio", "a ratio is a bare number or in %"),
        # 20 * 9.80665 * 0.01 = 1.96133
        (
            "20 kg*cm", Kind.TORQUE, "20 kg*cm is not a torque",
            "kg and g are masses; as a force (kgf, gf) 20 kg*cm is 1.96133 N*m",
        ),
        # 0.028349523125 * 0.0254^2 = 1.82900e-5
        (
            "1 oz*in^2", Kind.INERTIA, "1 oz*in^2 is not an inertia",
            "oz, lbf, kgf and gf are forces; as a mass 1 oz*in^2 is 1.829e-05 kg*m^2",
        ),
        # 60/(2 pi 100) = 0.0954930
        (
            "100 rpm/V", Kind.TORQUE_CONSTANT, "100 rpm/V is not a torque constant",
            "a speed constant of 100 rpm/V is a torque constant of 0.095493 N*m/A",
        ),
        ("10 mm", Kind.ANGLE, "10 mm is a length, not an angle", "an angle is in rad"),
        # 0.01 m/rad would be 2 pi times the lead.
        (
            "10 mm", Kind.LEAD, "10 mm is a length, not a lead",
            "a lead is the travel in one turn: write `10 mm/rev`",
        ),
        ("20", Kind.LENGTH, "20 has no unit, and a length needs one", "write `20 mm` or `20 m`"),
        (800, Kind.POSITION, "800 has no unit, and a position needs one", "write `800 deg` or `800 mm`"),
        (-25, Kind.POSITION, "-25 has no unit, and a position needs one", "write `-25 deg`, `-25 rad` or `-25 m`"),
        # Unknown units: the nearest that is of the kind asked for.
        (
            "5 Nmm", Kind.TORQUE, "5 Nmm is not a torque: unknown unit `Nmm`",
            "did you mean `5 N*mm`? That is 0.005 N*m",
        ),
        (
            "5 Nms/rad", Kind.VELOCITY_GAIN, "5 Nms/rad is not a velocity gain: unknown unit `Nms`",
            "did you mean `5 Nm*s/rad`? That is 5 N*m*s/rad",
        ),
        (
            "20 kgcm", Kind.TORQUE, "20 kgcm is not a torque: unknown unit `kgcm`",
            "did you mean `20 kgf*cm`? That is 1.96133 N*m",
        ),
        ("3 rps", Kind.SPEED, "3 rps is not a speed: unknown unit `rps`",
         "did you mean `3 rev/s`? That is 18.8496 rad/s"),
        # 570 x 2 pi / 60 = 59.6903.
        ("570 min^-1", Kind.SPEED, "570 min^-1 is not a speed", RPM_570),
        ("570 1/min", Kind.SPEED, "570 1/min is not a speed", RPM_570),
        ("570/min", Kind.SPEED, "570/min is not a speed", RPM_570),
        ("570 min⁻¹", Kind.SPEED, "570 min⁻¹ is not a speed", RPM_570),
        ("570 min-1", Kind.SPEED, "570 min-1 is not a speed: unexpected `-`", f"did you mean `min^-1`? {RPM_570}"),
        ("570 U/min", Kind.SPEED, "570 U/min is not a speed: unknown unit `U`",
         "did you mean `570 rev/min`? That is 59.6903 rad/s"),
        # 60 x 2 pi = 376.991.
        ("60 1/s", Kind.SPEED, "60 1/s is not a speed", PER_SECOND_60),
        ("60 s^-1", Kind.SPEED, "60 s^-1 is not a speed", PER_SECOND_60),
        # 0.002 x 60 / (2 pi); 60 / (2 pi 135).
        ("0.002 N*m*min", Kind.VELOCITY_GAIN, "0.002 N*m*min is not a velocity gain",
         "1/min of a shaft is rpm: write `0.0190986 N*m*s/rad`"),
        ("135 min^-1/V", Kind.TORQUE_CONSTANT, "135 min^-1/V is not a torque constant",
         "1/min of a shaft is rpm: a speed constant of 135 min^-1/V is a torque constant of 0.0707355 N*m/A"),
        ("3 N*m/rps", Kind.VELOCITY_GAIN, "3 N*m/rps is not a velocity gain: unknown unit `rps`",
         "did you mean `3 N*m/(rev/s)`? That is 0.477465 N*m*s/rad"),  # 3/(2 pi)
        ("5 Radd", Kind.POSITION, "5 Radd is not a position: unknown unit `Radd`", "did you mean `5 rad`?"),
        ("5 kg*m2", Kind.INERTIA, "5 kg*m2 is not an inertia: unexpected `2`", "did you mean `5 kg*m^2`?"),
        # 382 x 2 pi / 60; 150 x 0.0254 m x 4.4482216 N; 20 x 9.80665 N x 0.01 m.
        ("382 r/min", Kind.SPEED, "382 r/min is not a speed: unknown unit `r`",
         "did you mean `382 rev/min`? That is 40.0029 rad/s"),
        ("40 rads", Kind.SPEED, "40 rads is not a speed: unknown unit `rads`", "did you mean `40 rad/s`?"),
        ("40 rads", Kind.POSITION, "40 rads is not a position: unknown unit `rads`", "did you mean `40 rad`?"),
        ("150 in-lb", Kind.TORQUE, "150 in-lb is not a torque: unexpected `-`",
         "did you mean `150 in*lbf`? That is 16.9477 N*m"),
        ("20 kg-cm", Kind.TORQUE, "20 kg-cm is not a torque: unexpected `-`",
         "did you mean `20 kgf*cm`? That is 1.96133 N*m"),
        ("5 oz-in", Kind.TORQUE, "5 oz-in is not a torque: unexpected `-`",
         "did you mean `5 oz*in`? That is 0.0353078 N*m"),
        ("5 sec", Kind.SPEED, "5 sec is not a speed: unknown unit `sec`",
         "did you mean `s`? a speed is in rad/s (hinge) or m/s (slide)"),
        # pi/3 / 0.17; a weight has a mass in it, and 103 s are no servo's.
        ("0.17 s", Kind.SPEED, "0.17 s is a time, not a speed", SERVO_TIME),
        ("0.17 s/60 deg", Kind.SPEED, "0.17 s/60 deg is not a speed: unexpected `60`", SERVO_TIME),
        ("0.17sec/60°", Kind.SPEED, "0.17sec/60° is not a speed: unknown unit `sec`", SERVO_TIME),
        ("103 s", Kind.SPEED, "103 s is a time, not a speed", "a speed is in rad/s (hinge) or m/s (slide)"),
        # 9.4 x 0.0980665; 300 x 24.
        ("9.4 kg/cm", Kind.TORQUE, "9.4 kg/cm is not a torque",
         "sheets of servos write kg/cm for kgf*cm: `9.4 kgf*cm` is 0.921825 N*m"),
        ("300 rpm/V", Kind.SPEED, "300 rpm/V is not a speed", SPEED_CONSTANT),
        ("300 KV", Kind.SPEED, "300 KV is not a speed: unknown unit `KV`", SPEED_CONSTANT),
        ("300 kV", Kind.SPEED, "300 kV is a voltage, not a speed", SPEED_CONSTANT),
        ("100 KV", Kind.TORQUE_CONSTANT, "100 KV is not a torque constant: unknown unit `KV`",
         "a speed constant of 100 rpm/V is a torque constant of 0.095493 N*m/A"),
        ("9 N.m", Kind.TORQUE, "9 N.m is not a torque: units are multiplied by `*`, not by `.`",
         "did you mean `9 N*m`?"),
        (
            "25 N.m.s/rad", Kind.VELOCITY_GAIN,
            "25 N.m.s/rad is not a velocity gain: units are multiplied by `*`, not by `.`",
            "did you mean `25 N*m*s/rad`?",
        ),
        # x sqrt(2) = 6.22254; / sqrt(2): 63.6396 and 1.48492.
        ("4.4 Arms", Kind.CURRENT, "4.4 Arms is not a current: unknown unit `Arms`",
         "write `4.4 A` beside a torque constant per A rms, `6.22254 A` beside one per A peak"),
        ("90 A_pk", Kind.CURRENT, "90 A_pk is not a current: unexpected `_`",
         "write `90 A` beside a torque constant per A peak, `63.6396 A` beside one per A rms"),
        ("90 App", Kind.CURRENT, "90 App is not a current: unknown unit `App`",
         "write `45 A` beside a torque constant per A peak, `31.8198 A` beside one per A rms"),
        ("90 mA (rms)", Kind.CURRENT, "90 mA (rms) is not a current: unknown unit `rms`",
         "write `90 mA` beside a torque constant per A rms, `127.279 mA` beside one per A peak"),
        ("2.1 Nm/Arms", Kind.TORQUE_CONSTANT, "2.1 Nm/Arms is not a torque constant: unknown unit `Arms`",
         "write `2.1 Nm/A` where the motor's currents are A rms, `1.48492 Nm/A` where they are A peak"),
        ("2.1 Nm/Apk", Kind.TORQUE_CONSTANT, "2.1 Nm/Apk is not a torque constant: unknown unit `Apk`",
         "write `2.1 Nm/A` where the motor's currents are A peak, `2.96985 Nm/A` where they are A rms"),
        # What says which figure it is, and changes none.
        ("4.4 Adc", Kind.CURRENT, "4.4 Adc is not a current: unknown unit `Adc`", "did you mean `4.4 A`?"),
        (
            "9 Newton meter", Kind.TORQUE, "9 Newton meter is not a torque: unknown unit `Newton`",
            "did you mean `9 N*m`?",
        ),
        ("5.000,5 N", Kind.TORQUE, "5.000,5 N is not a torque: a comma inside a number",
         "decimals have a point (`5000.5 N`), thousands no mark"),
        ("5 zzzzz", Kind.TIME, "5 zzzzz is not a time: unknown unit `zzzzz`", "a time is in s"),
        ("0x10 s", Kind.TIME, "0x10 s is not a time: unknown unit `x`", "a time is in s"),
        ("33,5 N*m", Kind.TORQUE, "33,5 N*m is not a torque: a comma inside a number",
         "decimals have a point (`33.5 N*m`), thousands no mark"),
        ("", Kind.TORQUE, "the text is empty, a torque is needed", TORQUES),
        ("nan N*m", Kind.TORQUE, "nan N*m is not a finite number, a torque is needed", None),
        ("-.inf", Kind.RATIO, "-.inf is not a finite number, a ratio is needed", None),
        (math.nan, Kind.TORQUE, "nan is not a finite number, a torque is needed", None),
        (10**400, Kind.TORQUE, "inf is not a finite number, a torque is needed", None),
        (True, Kind.TORQUE, "true is not a number, a torque is needed", TORQUES),
        ("fast", Kind.SPEED, "`fast` does not start with a number, a speed is needed",
         "write a number and its unit, e.g. `1 rad/s`"),
        ("1e999 N*m", Kind.TORQUE, "1e999 is out of range for a torque", None),
        ("1e-999 s", Kind.TIME, "1e-999 is out of range for a time", None),  # not the 0 that is always fine
        ("1e308 kN", Kind.TORQUE, "1e308 kN is out of range for a torque", None),
        ("1e48 kN*m", Kind.TORQUE, "1e48 kN*m is out of range for a torque", None),
        ("-1e200", Kind.RATIO, "-1e200 is out of range for a ratio", None),
        (1e-60, Kind.RATIO, "1e-60 is out of range for a ratio", None),
        ("5e-324 ms", Kind.TIME, "5e-324 ms is out of range for a time", None),
        ("5 N\x1b[31m", Kind.TORQUE, "5 N\\x1b[31m is not a torque: unexpected `\\x1b`", TORQUES),
    ],
    ids=lambda v: repr(v)[:24] if not isinstance(v, Kind) else str(v),
)  # fmt: skip
def test_messages(given: str | float, kind: Kind, message: str, help: str | None) -> None:
    """The message names value, unit and kind; the help is the nearest right answer with its number."""
    assert explain(given, kind) == (message, help)


@pytest.mark.parametrize(
    "given",
    [
        "1 " + "(" * 150, "1 " + "m^6*" * 40 + "m", "1 ((((%^6)^6)^6)^6)^6", "1 m^99999999999999",
        "1 N*", "1 *N", "1 N**", "1 N^", "1 N^m", "1 (N*m", "1 N*m)", "1 N^(2", "1 2*N", "1 N^2.5", "1 N;m",
        "1 ()", "1 //s", "1 N m2m", "1 \N{LATIN SMALL LETTER E WITH ACUTE}", "1" * 190 + "e" + "9" * 8,
        "1 " + "z" * 190, "1e5e5 N", "\N{ARABIC-INDIC DIGIT THREE} N", "1 N\x00", "- 5 N", "--5 N",
        "1_000 N", "{}", "5 N*m N*m",
    ],
    ids=range(29),
)  # fmt: skip
def test_hostile_text(given: str) -> None:
    """Malformed text is a short UnitError, never another exception."""
    message, _ = explain(given, Kind.TORQUE)
    assert len(message) < 300


def test_long_text_is_refused_unread() -> None:
    """A text over the limit is not parsed, and not quoted."""
    message, _ = explain("1 " + "N*" * 5_000_000 + "m", Kind.TORQUE)
    assert message == "a text of 10000003 characters is not a torque"
    assert parse_quantity("1 N".ljust(MAX_LENGTH), Kind.TORQUE).value == 1.0
    with pytest.raises(UnitError):
        parse_quantity("1 N".ljust(MAX_LENGTH + 1), Kind.TORQUE)
    with pytest.raises(UnitError, match="a text of 201 characters"):
        parse_with_unit(1, "N".ljust(MAX_LENGTH + 1), Kind.TORQUE)


@pytest.mark.parametrize(
    ("given", "kind", "reason"),
    [
        ("1 " + "(" * 9 + "N" + ")" * 9, Kind.TORQUE, "too many parentheses"),
        ("1 ((((%^6)^6)^6)^6)^6", Kind.RATIO, "too complicated"),  # 100^7776
        ("1 m^6*m^6*m", Kind.TORQUE, "too complicated"),
    ],
    ids=["depth", "scale", "power"],
)
def test_limits_of_a_unit(given: str, kind: Kind, reason: str) -> None:
    """Work and memory for one unit are bounded, by limits that no honest unit meets."""
    message, _ = explain(given, kind)
    assert message.endswith(f": {reason}")
    assert parse_quantity("1 " + "(" * 8 + "N" + ")" * 8, Kind.TORQUE).value == 1.0


def test_value_and_unit_apart() -> None:
    """`{value: 1, unit: kgf*cm}` is `1 kgf*cm`."""
    assert parse_with_unit(1, "kgf*cm", Kind.TORQUE) == parse_quantity("1 kgf*cm", Kind.TORQUE)
    assert parse_with_unit(0.5, "1", Kind.RATIO).value == 0.5


@pytest.mark.parametrize(
    ("number", "unit", "message"),
    [
        (0.2, "1", "0.2 is dimensionless, not a torque"),
        (3, " ", "the unit of a torque is empty"),
        (3, 5, "the unit of a torque must be text, got int"),
        (3, None, "the unit of a torque must be text, got NoneType"),
        ("3", "N", "str value is not a number, a torque is needed"),
        (True, "N", "true is not a number, a torque is needed"),
        (3, "Hz", "3 Hz is a frequency, not a torque"),
        (math.inf, "N", "inf is not a finite number, a torque is needed"),
    ],
    ids=["coefficient", "empty", "number", "none", "text", "bool", "kind", "inf"],
)
def test_value_and_unit_apart_refused(number: float, unit: str, message: str) -> None:
    """What YAML may hold in either place, and the wrong kind."""
    with pytest.raises(UnitError) as error:
        parse_with_unit(number, unit, Kind.TORQUE)
    assert error.value.message == message


def test_angle_is_a_dimension() -> None:
    """N*m, N*m/rad, N*m*s/rad and N*m*s are four things: each fits one kind or none."""
    fits = {
        unit: [k for k in Kind if fits_kind(unit, k)]
        for unit in ("N*m", "N*m/rad", "N*m*s/rad", "N*m*s", "Hz")
    }
    assert fits == {
        "N*m": [Kind.TORQUE],
        "N*m/rad": [Kind.STIFFNESS],
        "N*m*s/rad": [Kind.VELOCITY_GAIN],
        "N*m*s": [],
        "Hz": [Kind.FREQUENCY],
    }


def fits_kind(unit: str, kind: Kind) -> bool:
    try:
        parse_with_unit(1, unit, kind)
    except UnitError:
        return False
    return True


def test_convert() -> None:
    """33.5/0.0980665 = 341.605 kgf*cm; pi rad = 180 deg; the linear unit of a kind likewise."""
    assert convert(33.5, "kgf*cm", Kind.TORQUE) == pytest.approx(341.60493134760594, rel=ROUNDING)
    assert convert(math.pi, "deg", Kind.ANGLE) == 180.0
    assert convert(0.0007, "mm", Kind.POSITION) == 0.7
    assert convert(math.inf, "mN*m", Kind.TORQUE) == math.inf
    assert convert(-1e308, "uN", Kind.TORQUE) == -math.inf


def test_convert_refuses() -> None:
    """Another kind's unit and no unit are errors."""
    with pytest.raises(UnitError, match="is a frequency, not a speed"):
        convert(1.0, "Hz", Kind.SPEED)
    with pytest.raises(UnitError, match="unknown unit `zz`"):
        convert(1.0, "zz", Kind.SPEED)


@pytest.mark.parametrize(
    ("value", "unit", "digits", "text"),
    [
        (33.5, "N*m", 6, "33.5 N*m"),
        (1 / 3, "s", 3, "0.333 s"),
        (1e-7, "kg*m^2", 6, "1e-07 kg*m^2"),
        (-0.0, "N*m", 6, "0 N*m"),
        (0.25, "1", 6, "0.25"),
        (0.25, "", 6, "0.25"),
        (None, "N*m", 6, "unknown"),
        (math.inf, "N*m", 6, "inf N*m"),
        (35.55, "N*m", 3, "35.55 N*m"),
        (1000.0, "", 3, "1000"),
        (0.1 + 0.2, "s", 3, "0.3 s"),
        (1234.5678, "", 3, "1235"),
        (999.99951, "", 3, "1000"),
        (2e6, "N*m", 6, "2000000 N*m"),
        (14.250623, "", 3, "14.3"),
    ],
    ids=[
        "plain",
        "digits",
        "small",
        "minus-zero",
        "ratio",
        "no-unit",
        "unknown",
        "inf",
        "written",
        "thousand",
        "noise",
        "whole",
        "rounded-up",
        "million",
        "computed",
    ],
)
def test_format_quantity(value: float | None, unit: str, digits: int, text: str) -> None:
    """Unknown is a word, never 0; what was written keeps its digits, what was computed is rounded."""
    assert format_quantity(value, unit, digits) == text


def test_kind_names() -> None:
    """A kind reads as plain English, and one with a single unit has it twice."""
    assert str(Kind.VELOCITY_GAIN) == Kind.VELOCITY_GAIN.noun == "velocity gain"
    assert (Kind.TORQUE.rotary_unit, Kind.TORQUE.linear_unit) == ("N*m", "N")
    assert (Kind.TIME.rotary_unit, Kind.TIME.linear_unit) == ("s", "s")
    assert len({k.noun for k in Kind}) == len(Kind)


def test_error_crosses_processes() -> None:
    """The audit uses all cores: the error and its help survive pickling."""
    copy = pickle.loads(pickle.dumps(UnitError("wrong", "right")))
    assert isinstance(copy, UnitError)
    assert (copy.message, copy.help) == ("wrong", "right")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("unit", "kind"),
    [
        ("kgf*cm", Kind.TORQUE), ("ozf*in", Kind.TORQUE), ("lbf*ft", Kind.TORQUE), ("mN*m", Kind.TORQUE),
        ("g*cm^2", Kind.INERTIA), ("rpm", Kind.SPEED), ("deg/s", Kind.SPEED), ("turn/min", Kind.SPEED),
        ("N*m/deg", Kind.STIFFNESS), ("lbf/in", Kind.STIFFNESS), ("N*m/rpm", Kind.VELOCITY_GAIN),
        ("km/h", Kind.SPEED), ("ft", Kind.POSITION), ("us", Kind.TIME), ("mV", Kind.VOLTAGE),
        ("kOhm", Kind.RESISTANCE), ("mm/turn", Kind.LEAD), ("in", Kind.LENGTH),
    ],
    ids=lambda v: v if isinstance(v, str) else "",
)  # fmt: skip
def test_agrees_with_pint(unit: str, kind: Kind) -> None:
    """A second implementation has the same factors; its radian is 1, so only factors are compared."""
    pint = pytest.importorskip("pint")
    names = {
        "kgf": "kilogram_force",
        "ozf": "ounce_force",
        "lbf": "pound_force",
        "in": "inch",
        "ft": "foot",
        "kOhm": "kohm",
    }
    spelled = "".join(names.get(part, part) for part in re.split(r"([*/^])", unit))
    theirs = pint.UnitRegistry().Quantity(1.0, spelled).to_base_units().magnitude
    # pint's base units of mass, length and time are kg, m and s.
    assert parse_with_unit(1, unit, kind).value == pytest.approx(theirs, rel=1e-12)
