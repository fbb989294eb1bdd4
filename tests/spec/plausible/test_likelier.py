"""Remedies that would leave a spec valid and wrong: what is likelier, or as likely, is told."""

from __future__ import annotations

import pytest

from actspec.diagnostics import ActspecError, Diagnostic
from actspec.spec.plausible import BY_CODE
from tests.fitting import fit, spec_of

REST = "rest: {joints: [calf, slide], level: ideal_pd, kp: 1, kd: 1}"


def told(group: str, motor: str | None = None) -> list[Diagnostic]:
    """What the checks report of the group of a hip, and of its motor `m`."""
    motors = "{}" if motor is None else f"{{m: {{{motor}}}}}"
    driven = "" if motor is None else "motor: m, "
    text = spec_of(f"own: {{joints: [hip], {driven}level: ideal_pd, {group}}}, {REST}", motors=motors)
    try:
        found = fit(text).diagnostics
    except ActspecError as err:
        found = err.diagnostics
    return [item for item in found if item.code in BY_CODE]


DIRECT = (
    "side: joint, peak_torque: {} N*m, continuous_torque: {} N*m, no_load_speed: 25 rad/s, torque_constant: {} N*m/A, "
    "peak_current: {} A, reflected_inertia: 0.012"
)
TABLE = "effort_limit: peak, kp: 3000, kd: 30"
OF_2 = "one of 2 numbers is wrong. "
TWO = OF_2 + "torque_constant: did you mean {} N*m/A? Or peak_current (s.yaml:3:143): did you mean {} A?"


@pytest.mark.parametrize(
    ("sheet", "where", "help"),
    [
        # 0.45 x 10 is just a tenth of 45 N*m, and 45 kgf*cm are 4.413.
        (("45", "15", "0.45", "10"), "torque_constant", TWO.format("4.5", "100")),
        (("45", "15", "4.5", "1"), "torque_constant", TWO.format("45", "10").replace(":143", ":142")),
        # 459 and 153 kgf*cm are 45.01 and 15 N*m.
        (
            ("459", "153", "4.5", "10"),
            "peak_torque",
            "are peak_torque, continuous_torque in kgf*cm? 459 kgf*cm is",
        ),
    ],
)
def test_ten_to_the_digit_is_a_point(sheet: tuple[str, ...], where: str, help: str) -> None:
    (found,) = told(TABLE, DIRECT.format(*sheet))
    assert (found.code, found.where) == ("SPEC181", f"motors.m.{where}")
    assert (found.help or "").startswith(help)


EXCHANGED = "are the two exchanged? kp is the stiffness, kd the velocity gain"
MULTIPLIED = "is kd multiplied by 57.3? Without that it is {} N*m*s/rad"


@pytest.mark.parametrize(
    ("kp", "kd", "limits", "where", "help"),
    [
        # A Panda's 250 and 20: 12 N*m at 0.6 rad/s by kd alone, which is 0.23 of the joint's own speed.
        ("20", "250", "effort_limit: 12, velocity_limit: 2.61 rad/s", "kp", f"{OF_2}kp: {EXCHANGED}. Or"),
        ("80", "400", "effort_limit: 87, velocity_limit: 2.175 rad/s", "kp", EXCHANGED),
        # Of a joint whose speed nobody states kd may be any: both are told.
        ("17.3", "212.7", "effort_limit: 12", "kd", f"{OF_2}kd: {MULTIPLIED.format('3.712')}. Or kp"),
        ("80", "400", "effort_limit: 87", "kd", f"{OF_2}kd: is the point in the wrong place? Or kp"),
        # 20 and 50 times 57.3, of which 1146 and 2865 are no short numbers.
        ("250", "1146", "effort_limit: 12, velocity_limit: 2.61 rad/s", "kd", MULTIPLIED.format("20")),
        ("600", "2865", "effort_limit: 87", "kd", MULTIPLIED.format("50")),
        # Exchanged a kp of 20000 would take the 12 N*m at 0.6 mrad.
        (
            "250",
            "20000",
            "effort_limit: 12, velocity_limit: 2.61 rad/s",
            "kd",
            "is the point in the wrong place?",
        ),
    ],
)
def test_gains_of_a_heavily_damped_joint(kp: str, kd: str, limits: str, where: str, help: str) -> None:
    (found,) = told(f"{limits}, kp: {kp} N*m/rad, kd: {kd} N*m*s/rad")
    assert (found.code, found.where) == ("SPEC192", f"actuators.own.{where}")
    assert (found.help or "").startswith(help)
    if help.startswith("one of"):
        assert EXCHANGED in (found.help or "")
    else:
        assert found.help == help


SIGN = "is the sign wrong? 100 deg is inside. Or the same angle inside is 260 deg, 4.538 rad"
DEGREES = (
    "is it in degrees? Then write 5 deg, 0.08727 rad. Or the same angle inside is -1.283 rad, -73.52 deg"
)


@pytest.mark.parametrize(
    ("pose", "ends", "message", "help"),
    [
        # 270 - 360 and 450 - 360 deg; whoever wrote degrees is not asked for them.
        (
            "270 deg",
            "-180 deg, 180 deg",
            "270 deg is outside",
            "the same angle inside is -90 deg, -1.571 rad",
        ),
        ("450 deg", "-180 deg, 180 deg", "450 deg is outside", "the same angle inside is 90 deg, 1.571 rad"),
        # The range's own turn: -100 + 360.
        ("-100 deg", "0 deg, 350 deg", "-100 deg is", SIGN),
        # 90 x 57.3 = 5157 deg.
        (
            "5156 deg",
            "-180 deg, 180 deg",
            "5156 deg is",
            "is it turned into degrees twice? Then write 89.99 deg",
        ),
        # 300 - 360 = -60 deg is outside, too, and 300 deg are no 5.2.
        ("300 deg", "-5 deg, 160 deg", "300 deg is outside of the joint's range, -5 deg to 160 deg", None),
        # Three quarters of a turn in rad are no 4.712 deg; 5 may be degrees.
        (
            "4.712 rad",
            "-3.14 rad, 3.14 rad",
            "4.712 rad is",
            "the same angle inside is -1.571 rad, -90.02 deg",
        ),
        ("5 rad", "-3.14 rad, 3.14 rad", "5 rad is", DEGREES),
        ("20 rad", "-3.14 rad, 3.14 rad", "20 rad is", "is it in degrees? Then write 20 deg, 0.3491 rad"),
        # Without a range.
        (
            "450 deg",
            None,
            "450 deg is 1.25 turns from",
            "the same angle within half a turn is 90 deg, 1.571 rad",
        ),
        ("90 rad", None, "90 rad is 14.3 turns from", "is it in degrees? Then write 90 deg, 1.571 rad"),
    ],
)
def test_a_pose_in_degrees(pose: str, ends: str | None, message: str, help: str | None) -> None:
    joint = "hip" if ends is None else f"{{name: hip, kind: hinge, range: [{ends}]}}"
    robot = f"name: arm, model: none, joints: [{joint}], default_pose: {{hip: {pose}}}"
    text = spec_of("own: {joints: [hip], level: ideal_pd, kp: 10, kd: 0.2}", robot=robot)
    try:
        found = fit(text).diagnostics
    except ActspecError as err:
        found = err.diagnostics
    (one,) = (item for item in found if item.code == "SPEC190")
    assert one.message.startswith(f"hip: the default position {message}")
    assert one.help == help


@pytest.mark.parametrize(
    ("gear", "limit", "where", "help"),
    [
        # A UR5e's 101: 180 deg/s are 317 rad/s at the rotor, behind 10.1 turns 31.7 of the 40 that rotors have.
        ("10.1", "180 deg/s", "gear_ratio", "did you mean 101?"),
        # Without the same number beside it the speed may be in rpm.
        ("10.1", "unknown", "no_load_speed", "is it in rpm? 180 rpm is 18.8 rad/s"),
    ],
)
def test_a_speed_that_a_limit_has_too(gear: str, limit: str, where: str, help: str) -> None:
    (found,) = told(
        f"effort_limit: peak, velocity_limit: {limit}, kp: 4000, kd: 200, friction: {{coulomb: 8, viscous: 10}}",
        f"side: joint, gear_ratio: {gear}, peak_torque: 150, no_load_speed: 180 deg/s, rotor_inertia: 0.8e-4",
    )
    assert (found.code, found.where, found.help) == ("SPEC184", f"motors.m.{where}", help)


SOLO = (
    "side: motor, gear_ratio: 9, peak_torque: 0.3, torque_constant: 25 mN*m/A, peak_current: 12 A, stall_torque: {}, "
    "no_load_speed: {}, nominal_voltage: 24 V, rotor_inertia: 4.5e-6, bandwidth: {}"
)
TENFOLD = "did you mean 9000 rpm (942.5 rad/s)? Or did you mean 900 rad/s?"
SWAPPED = "are stall_torque and peak_torque swapped?"


@pytest.mark.parametrize(
    ("stall", "speed", "bandwidth", "where", "help"),
    [
        ("0.53", "9000 rpm", "4.5 kHz", None, None),
        # 0.025 x 942.5 = 23.6 V; 900 rpm at the output are 848 rad/s.
        ("0.53", "900 rpm", "4.5 kHz", "no_load_speed", TENFOLD),
        ("0.53", "9000 rpm", "4.5 mHz", "bandwidth", "did you mean 4.5 kHz? Or did you mean 4.5 Hz?"),
        # 2 Hz to 20 kHz are usual.
        ("0.53", "9000 rpm", "1.5 mHz", "bandwidth", "did you mean 1.5 kHz?"),
    ],
)
def test_one_line_of_a_motor(
    stall: str, speed: str, bandwidth: str, where: str | None, help: str | None
) -> None:
    found = told("effort_limit: peak, kp: 3, kd: 0.1", SOLO.format(stall, speed, bandwidth))
    assert [(item.where, item.help) for item in found] == (
        [] if where is None else [(f"motors.m.{where}", help)]
    )


@pytest.mark.parametrize(
    ("stall", "help"),
    [
        # 0.13 N*m is 2.3 times 0.056, and 1.3 times 0.1.
        ("0.056", f"{SWAPPED} Or stall_torque: did you mean 0.56 N*m?"),
        ("0.1", SWAPPED),
    ],
)
def test_a_stall_torque_with_its_point_in_the_wrong_place(stall: str, help: str) -> None:
    motor = f"side: motor, gear_ratio: 14, stall_torque: {stall}, no_load_speed: 9560 rpm, continuous_torque: 0.044, "
    (found,) = told(
        "effort_limit: peak, kp: 20, kd: 0.2", f"{motor}peak_torque: 0.13, rotor_inertia: 24.2 g*cm^2"
    )
    assert (found.code, found.help) == ("SPEC180", help)


def test_a_large_machine_in_rpm() -> None:
    """1900 rad/s behind 160 turns: 11.9 rad/s at 80.6 kN*m; 1900 rpm are 1.24 rad/s there."""
    motor = "side: motor, gear_ratio: 160, efficiency: 0.9, peak_torque: 560, no_load_speed: 1900 rad/s, "
    (found,) = told("effort_limit: peak, command: velocity, kd: 5e4", f"{motor}rotor_inertia: 0.02")
    assert (found.where, found.help) == ("motors.m.no_load_speed", "is it in rpm? 1900 rpm is 199 rad/s")


@pytest.mark.parametrize(("inertia", "odd"), [("6e-4", False), ("6e-3", True)])
def test_a_spindle(inertia: str, odd: bool) -> None:
    """1.4 N*m bring 6e-4 kg*m^2 to 24000 rpm in 1.08 s."""
    motor = f"side: joint, peak_torque: 1.4, no_load_speed: 24000 rpm, reflected_inertia: {inertia}"
    found = told("effort_limit: peak, command: velocity, kd: 0.05", motor)
    assert [item.code for item in found] == ["SPEC185"] * odd
