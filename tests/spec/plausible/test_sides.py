"""Direct drives of wheels, torques of the other side of the gear, and motors that travel."""

from __future__ import annotations

import pytest

from actspec.diagnostics import ActspecError
from actspec.spec.plausible import BY_CODE
from tests.fitting import fit, spec_of

REST = "rest: {joints: [calf, slide], level: ideal_pd, kp: 1, kd: 1}"


def told(motor: str, group: str = "kp: 60, kd: 2", joints: str = "hip") -> list[tuple[str, str, str, str]]:
    """Code, place, message and help of what the checks report of a motor."""
    rest = REST if joints == "hip" else REST.replace("calf, slide", "hip, calf")
    text = spec_of(
        f"legs: {{joints: [{joints}], motor: m, level: ideal_pd, {group}}}, {rest}",
        motors=f"{{m: {{{motor}}}}}",
    )
    try:
        found = fit(text).diagnostics
    except ActspecError as err:
        found = err.diagnostics
    return [(item.code, item.where, item.message, item.help or "") for item in found if item.code in BY_CODE]


WHEEL = "command: velocity, kd: 0.1"
MJ5208 = (
    "side: joint, peak_torque: 1.7, stall_torque: 1.7, no_load_speed: 829 rad/s, reflected_inertia: 9e-5, "
    "torque_constant: 0.0251, nominal_voltage: 24 V"
)


@pytest.mark.parametrize(
    "motor",
    [
        # 829 x root of 1.7 is 1081; 603 x 1.96 is 1185; 586 x 1.95 is 1143 rad/s.
        MJ5208,
        "side: joint, peak_torque: 3.86, no_load_speed: 5760 rpm, torque_constant: 0.0551, nominal_voltage: 38 V",
        "side: motor, gear_ratio: 1, peak_torque: 3.8, no_load_speed: 5600 rpm, torque_constant: 0.083, "
        "nominal_voltage: 48 V",
    ],
)
@pytest.mark.parametrize("group", [WHEEL, "kp: 60, kd: 2"])
def test_a_direct_drive_as_fast_as_its_constant_and_voltage_say_is_no_doubt(motor: str, group: str) -> None:
    assert told(motor, group) == []


def test_what_tells_a_direct_drive_from_a_leg() -> None:
    """At 8290 rad/s it is 10809; without constant or voltage a wheel is told from a leg by its command."""
    bare = MJ5208.partition(", torque_constant")[0]
    assert told(bare, WHEEL) == []
    for motor, group in (
        (bare, "kp: 60, kd: 2"),
        (MJ5208.replace("829", "8290"), WHEEL),
        (f"{bare}, gear_ratio: 9".replace("reflected_inertia: 9e-5, ", ""), WHEEL),
    ):
        ((code, where, *_),) = told(motor, group)
        assert (code, where) == ("SPEC184", "motors.m.no_load_speed")


def test_sure_ends_a_doubt_of_speed_by_torque() -> None:
    """17 N*m and 829 rad/s, 3418: sure of the torque, of which it is told, nothing else is a slip."""
    motor = MJ5208.replace("1.7", "17")
    ((code, where, _, help),) = told(motor)
    assert (code, where) == ("SPEC184", "motors.m.peak_torque")
    assert help.startswith("are stall_torque, peak_torque in kgf*cm?")
    assert told(motor.replace("peak_torque: 17", "peak_torque: {value: 17, sure: true}")) == []
    # What is a slip of the speed is told there all the same: 7916 rpm are 829 rad/s.
    rpm = MJ5208.replace("829", "7916").replace("peak_torque: 1.7", "peak_torque: {value: 1.7, sure: true}")
    ((_, where, _, help),) = told(rpm)
    assert (where, help) == ("motors.m.no_load_speed", "is it in rpm? 7916 rpm is 829 rad/s")


CASSIE = (
    "side: motor, gear_ratio: 25, peak_torque: PEAK, stall_torque: STALL, no_load_speed: 2900 rpm, "
    "rotor_inertia: 6.1e-5"
)


@pytest.mark.parametrize(
    ("peak", "stall", "more", "where", "help"),
    [
        ("4.5", "4.5", "", None, ""),
        # 112.5 / 4.5 is the gear, 25; with an efficiency of 0.9 101.25.
        (
            "112.5",
            "4.5",
            "",
            "peak_torque",
            "is it quoted at the gearbox output? At the rotor it is 4.5 N*m",
        ),
        (
            "101.25",
            "4.5",
            ", efficiency: 0.9",
            "peak_torque",
            "is it quoted at the gearbox output? At the rotor it is 4.5 N*m",
        ),
        (
            "4.5",
            "112.5",
            "",
            "stall_torque",
            "is it quoted at the gearbox output? At the rotor it is 4.5 N*m",
        ),
        (
            "4.5",
            "101.25",
            ", efficiency: 0.9",
            "stall_torque",
            "is it quoted at the gearbox output? At the rotor it is 4.5 N*m",
        ),
        # A winding's.
        ("4.5", "100", "", None, ""),
        ("4.5", "90", "", None, ""),
    ],
)
def test_a_torque_of_the_other_side_is_just_the_gear_apart(
    peak: str, stall: str, more: str, where: str | None, help: str
) -> None:
    found = told(CASSIE.replace("PEAK", peak).replace("STALL", stall) + more)
    assert [(item[1], item[3]) for item in found] == ([(f"motors.m.{where}", help)] if where else [])


def test_the_gear_to_the_digit_is_likelier_than_a_unit() -> None:
    """45 / 0.9 is the gear, 50; 45 mN*m are a usual peak torque beside 0.9 N*m, too."""
    toe = "side: motor, gear_ratio: 50, peak_torque: 45, stall_torque: 0.9, no_load_speed: 5500 rpm"
    ((_, where, _, help),) = told(f"{toe}, rotor_inertia: 4.9e-6")
    assert (where, help) == (
        "motors.m.peak_torque",
        "is it quoted at the gearbox output? At the rotor it is 0.9 N*m",
    )


def test_of_a_small_gear_only_an_odd_torque_is_told() -> None:
    """2 x 10 = 20 N*m may be a winding's; 1.23 x 10 = 12.3 hardly."""
    sheet = "side: motor, gear_ratio: 10, peak_torque: {}, stall_torque: {}, no_load_speed: 2900 rpm"
    assert told(sheet.format(2, 20)) == []
    ((code, where, message, _),) = told(sheet.format(1.23, 12.3))
    assert (code, where) == ("SPEC180", "motors.m.stall_torque")
    assert message == "stall_torque 12.3 is 10 times peak_torque 1.23, which is just the gear"
    # At the joint's side it is the peak torque that is the rotor's.
    joint = "side: joint, gear_ratio: 25, peak_torque: 4.44, stall_torque: 111, no_load_speed: 116 rpm"
    ((_, where, _, help),) = told(joint)
    assert where == "motors.m.peak_torque"
    assert help == "is it quoted at the rotor? At the gearbox output it is 111 N*m"


LINEAR = (
    "side: joint, peak_torque: 180 N, stall_torque: 180 N, continuous_torque: 60 N, no_load_speed: 5 m/s, "
    "reflected_inertia: 0.5 kg, torque_constant: 30 N/A, peak_current: 6 A"
)
AXIS = "kp: 1e4 N/m, kd: 300 N*s/m"


@pytest.mark.parametrize(
    ("old", "new", "code", "where", "help"),
    [
        (
            "30 N/A",
            "3 N/A",
            "SPEC181",
            "torque_constant",
            "one of 2 numbers is wrong. torque_constant: did you mean 30 N/A? Or peak_current (s.yaml:3:180): "
            "did you mean 60 A?",
        ),
        ("6 A", "6 mA", "SPEC181", "peak_current", "did you mean 6 A?"),
        (
            "6 A",
            "6 A, nominal_voltage: 600 V, nominal_current: 2 A",
            None,
            "",
            "",
        ),
        # 30 V*s/m x 5 m/s = 150 V.
        (
            "6 A",
            "6 A, nominal_voltage: 15 V, nominal_current: 2 A",
            "SPEC181",
            "no_load_speed",
            "one of 2 numbers is wrong. no_load_speed: did you mean 0.5 m/s? Or nominal_voltage (s.yaml:3:203): did "
            "you mean 150 V?",
        ),
        ("peak_torque: 180 N", "peak_torque: 180 kgf", "SPEC180", "peak_torque", "did you mean 180 N?"),
        ("peak_torque: 180 N", "peak_torque: 180 mN", "SPEC180", "peak_torque", "did you mean 180 N?"),
    ],
)
def test_a_linear_motor_is_held_to_its_constant(
    old: str, new: str, code: str | None, where: str, help: str
) -> None:
    assert told(LINEAR, AXIS, "slide") == []
    found = told(LINEAR.replace(old, new), AXIS, "slide")
    assert [(item[0], item[1], item[3]) for item in found] == (
        [(code, f"motors.m.{where}", help)] if code else []
    )


def test_what_is_said_of_a_linear_motor() -> None:
    ((_, _, message, _),) = told(LINEAR.replace("30 N/A", "300 N/A"), AXIS, "slide")
    assert message == "a force constant of 300 N/A gives 1800 N at peak_current 6 A, and peak_torque is 180 N"


def test_what_the_actuator_gives_at_its_output_beside_the_line_of_its_winding() -> None:
    """4.38 and 1.25 N*m at the rotor, as 0.125 N*m/A x 35 and 10 A are, times 100 x 0.75: 328 and 93.8 N*m."""
    sheet = (
        "side: motor, stall_torque: 30, no_load_speed: 3670 rpm, peak_torque: {}, continuous_torque: {}, "
        "gear_ratio: 100, efficiency: 75 %, torque_constant: 0.125 N*m/A, nominal_current: 10 A, peak_current: 35 A, "
        "nominal_voltage: 48 V, rotor_inertia: 340 g*cm^2"
    )
    gains = "kp: 900, kd: 60"
    assert told(sheet.format(4.38, 1.25), gains) == []
    ((_, where, _, help),) = told(sheet.format(328, 93.8), gains)
    assert where == "motors.m.peak_torque"
    assert help == (
        "is it quoted at the gearbox output (peak_torque, continuous_torque)? At the rotor 328 N*m is 4.373 N*m"
    )
    # One of the two alone.
    ((_, where, _, help),) = told(sheet.format(4.38, 93.8), gains)
    assert (where, help) == (
        "motors.m.continuous_torque",
        "is it quoted at the gearbox output? At the rotor it is 1.251 N*m",
    )


@pytest.mark.parametrize(("share", "meant"), [("0.0085", "0.85"), ("0.085", "0.85"), ("0.03", "0.3")])
def test_an_efficiency_with_its_point_in_the_wrong_place(share: str, meant: str) -> None:
    """What is offered is none that would be told again."""
    found = told(f"side: motor, peak_torque: 1, gear_ratio: 10, efficiency: {share}")
    assert [help for code, _, _, help in found if code == "SPEC189"] == [f"did you mean {meant}?"]
