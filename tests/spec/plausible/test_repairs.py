"""One wrong number of a datasheet: it is blamed itself, once, whatever figures it contradicts."""

from __future__ import annotations

import pytest

from actspec.diagnostics import ActspecError, Diagnostic
from tests.fitting import fit, spec_of

# 0.04 N*m/A x 15 A = 0.6 N*m, 0.04 V*s/rad x 502.7 rad/s = 20.1 of 24 V; 30 N*m and 10.05 rad/s behind the gear.
SHEET = {
    "side": "motor",
    "peak_torque": "0.6",
    "continuous_torque": "0.2",
    "stall_torque": "0.6",
    "no_load_speed": "4800 rpm",
    "torque_constant": "0.04",
    "peak_current": "15 A",
    "nominal_voltage": "24 V",
    "gear_ratio": "50",
    "rotor_inertia": "60 g*cm^2",
}


SOUND = {
    "mini cheetah": "side: joint, peak_torque: 17, continuous_torque: 6.9, no_load_speed: 40 rad/s, gear_ratio: 6, "
    "rotor_inertia: 6e-5, nominal_voltage: 24 V, torque_constant: 0.57, peak_current: 30 A",
    "AK80-64": "side: joint, peak_torque: 120, continuous_torque: 48, no_load_speed: 57 rpm, gear_ratio: 64, "
    "rotor_inertia: 564 g*cm^2, nominal_voltage: 48 V, peak_current: 19 A",
    "EC-i 40 with a gear of 111": "side: motor, stall_torque: 1.81, continuous_torque: 0.2, no_load_speed: 5000 rpm, "
    "gear_ratio: 111, efficiency: 0.7, rotor_inertia: 24.2 g*cm^2, nominal_voltage: 24 V, torque_constant: 0.045, "
    "nominal_current: 4.5 A",
    "XM430": "side: joint, stall_torque: 4.1, no_load_speed: 46 rpm, gear_ratio: 353.5, nominal_voltage: 12 V, "
    "torque_constant: 1.78, peak_current: 2.3 A, reflected_inertia: 0.012",
    "UR10": "side: joint, peak_torque: 330, no_load_speed: 120 deg/s, gear_ratio: 101, rotor_inertia: 3.5 kg*cm^2",
    "U8, no gear": "side: motor, gear_ratio: 1, peak_torque: 2.5, continuous_torque: 0.9, no_load_speed: 4800 rpm, "
    "rotor_inertia: 1.2e-4, nominal_voltage: 48 V, torque_constant: 0.095, peak_current: 30 A",
    "ODRI": "side: motor, gear_ratio: 9, peak_torque: 0.3, no_load_speed: 8000 rpm, rotor_inertia: 5.1e-6, "
    "nominal_voltage: 24 V, torque_constant: 0.025, peak_current: 12 A",
    "hub of a wheel": "side: joint, gear_ratio: 1, peak_torque: 16, no_load_speed: 40 rad/s, nominal_voltage: 36 V, "
    "torque_constant: 0.85, peak_current: 20 A",
}
"""About what datasheets of such motors say, rounded."""


def said(limits: str = "", sheet: str | None = None, **wrong: str) -> list[Diagnostic]:
    """What is said of the sheet with other figures, and with limits of the joint."""
    motor = (
        ", ".join(f"{key}: {value}" for key, value in {**SHEET, **wrong}.items()) if sheet is None else sheet
    )
    groups = f"legs: {{joints: [hip], motor: m, level: ideal_pd, kp: 60, kd: 2{limits}}}"
    try:
        return [
            *fit(
                spec_of(
                    f"{groups}, rest: {{joints: [calf, slide], level: ideal_pd, kp: 1, kd: 1}}",
                    motors=f"{{m: {{{motor}}}}}",
                )
            ).diagnostics
        ]
    except ActspecError as err:
        return [*err.diagnostics]


@pytest.mark.parametrize("name", SOUND)
def test_sheets_of_motors_are_sound(name: str) -> None:
    assert said(sheet=SOUND[name]) == []


@pytest.mark.parametrize(
    ("name", "right", "wrong", "place"),
    [
        ("EC-i 40 with a gear of 111", "stall_torque: 1.81", "stall_torque: 1810", "stall_torque"),
        (
            "EC-i 40 with a gear of 111",
            "continuous_torque: 0.2",
            "continuous_torque: 200",
            "continuous_torque",
        ),
        ("XM430", "nominal_voltage: 12 V", "nominal_voltage: 120 V", "nominal_voltage"),
        ("XM430", "peak_current: 2.3 A", "peak_current: 2300 A", "peak_current"),
        ("UR10", "peak_torque: 330", "peak_torque: 330000", "peak_torque"),
        ("UR10", "gear_ratio: 101", "gear_ratio: 10100", "gear_ratio"),
        # 4800 rpm is 502.7 rad/s.
        ("U8, no gear", "no_load_speed: 4800 rpm", "no_load_speed: 502.7 rpm", "no_load_speed"),
        ("ODRI", "side: motor", "side: joint", "side"),
        ("AK80-64", "side: joint", "side: motor", "side"),
    ],
)
def test_a_slip_in_a_sheet(name: str, right: str, wrong: str, place: str) -> None:
    assert [found.where for found in said(sheet=SOUND[name].replace(right, wrong))] == [f"motors.m.{place}"]


def test_the_sheet_is_sound() -> None:
    assert said() == []
    # 30 N*m and 10.05 rad/s at the joint.
    assert said(", effort_limit: 30, velocity_limit: 10 rad/s") == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("wrong", "code", "place", "help"),
    [
        ({"stall_torque": "600"}, "SPEC183", "stall_torque", "is it in mN*m? 600 mN*m is 0.6 N*m"),
        ({"peak_torque": "600"}, "SPEC180", "peak_torque", "is it in mN*m? 600 mN*m is 0.6 N*m"),
        ({"continuous_torque": "200"}, "SPEC135", "continuous_torque", "is it in mN*m? 200 mN*m is 0.2 N*m"),
        (
            {"stall_torque": "600", "peak_torque": "600", "continuous_torque": "200"},
            "SPEC183",
            "stall_torque",
            "are stall_torque, peak_torque, continuous_torque in mN*m? 600 mN*m is 0.6 N*m",
        ),
        ({"no_load_speed": "4800 rad/s"}, "SPEC181", "no_load_speed", "is it in rpm? 4800 rpm is 503 rad/s"),
        # 96 rpm x 50 = 4800 rpm.
        (
            {"no_load_speed": "96 rpm"},
            "SPEC184",
            "no_load_speed",
            "is it quoted at the gearbox output? At the rotor it is 502.7 rad/s",
        ),
        ({"peak_current": "15000 A"}, "SPEC181", "peak_current", "is it in mA? 15000 mA is 15 A"),
        ({"nominal_voltage": "240 V"}, "SPEC181", "nominal_voltage", "did you mean 24 V?"),
        ({"torque_constant": "40"}, "SPEC181", "torque_constant", "is it in mN*m/A? 40 mN*m/A is 0.04 N*m/A"),
        # 0.04 x 50 = 2 N*m/A at the output.
        (
            {"torque_constant": "2"},
            "SPEC181",
            "torque_constant",
            "is it quoted at the gearbox output? At the rotor it is about 0.04 N*m/A",
        ),
        # 0.6 x 50 and 0.2 x 50 N*m, of the output.
        (
            {"stall_torque": "30", "peak_torque": "30", "continuous_torque": "10"},
            "SPEC181",
            "peak_torque",
            "is it quoted at the gearbox output (stall_torque, peak_torque, continuous_torque)? At the rotor 30 N*m is "
            "about 0.6 N*m",
        ),
        # 0.85 x 50 x 0.6 = 25.5 N*m: with the efficiency the number is known.
        (
            {"efficiency": "0.85", "peak_torque": "25.5"},
            "SPEC180",
            "peak_torque",
            "is it quoted at the gearbox output? At the rotor it is 0.6 N*m",
        ),
        # 0.04 x 0.85 x 50.
        (
            {"efficiency": "0.85", "torque_constant": "1.7"},
            "SPEC181",
            "torque_constant",
            "is it quoted at the gearbox output? At the rotor it is 0.04 N*m/A",
        ),
        (
            {"peak_torque": "0.2", "continuous_torque": "0.6"},
            "SPEC135",
            "continuous_torque",
            "are peak_torque and continuous_torque swapped?",
        ),
        (
            {"side": "joint"},
            "SPEC184",
            "side",
            "are the figures those of the rotor? Then write `side: motor`",
        ),
        (
            {"gear_ratio": "0.02"},
            "SPEC182",
            "gear_ratio",
            "did you mean 50? gear_ratio is rotor turns in one output turn",
        ),
        ({"gear_ratio": "5000"}, "SPEC183", "gear_ratio", "did you mean 50?"),
        (
            {"rotor_inertia": "60 kg*cm^2"},
            "SPEC185",
            "rotor_inertia",
            "is it in g*cm^2? 60 g*cm^2 is 6e-06 kg*m^2",
        ),
        # 6e-9 kg*m^2: a help that could only make it smaller would be wrong.
        (
            {"rotor_inertia": "0.06 g*cm^2"},
            "SPEC185",
            "rotor_inertia",
            "is it in kg*cm^2? 0.06 kg*cm^2 is 6e-06 kg*m^2",
        ),
        # 6e-6 or 6e-5 kg*m^2: 100000 or 10000 rad/s^2.
        ({"rotor_inertia": "6e-9 kg*m^2"}, "SPEC185", "rotor_inertia", "is the point in the wrong place?"),
    ],
)
def test_the_wrong_number_is_blamed(wrong: dict[str, str], code: str, place: str, help: str) -> None:
    (found,) = said(**wrong)
    keep = "`sure: true` beside it keeps a number that is right"
    said_help = (found.help or "").removesuffix(keep).rstrip("; ")
    assert (found.code == "SPEC183") == (found.help or "").endswith(keep)
    assert (found.code, found.where, said_help) == (code, f"motors.m.{place}", help)


@pytest.mark.parametrize(
    ("limits", "wrong", "place"),
    [
        # 30 N*m at the joint.
        (", effort_limit: 30000", {}, "actuators.legs.effort_limit"),
        (", effort_limit: 3", {"continuous_torque": "unknown"}, "actuators.legs.effort_limit"),
        # 96 rpm at the joint, in rpm.
        (", velocity_limit: 96 rad/s", {}, "actuators.legs.velocity_limit"),
        # The limit agrees with the sheet, had the sheet its own side.
        (
            ", effort_limit: 30",
            {"side": "joint", "no_load_speed": "unknown", "nominal_voltage": "unknown"},
            "motors.m.side",
        ),
        # The torques alone are the output's.
        (
            ", effort_limit: 30",
            {
                "stall_torque": "30",
                "peak_torque": "30",
                "continuous_torque": "10",
                "torque_constant": "unknown",
            },
            "motors.m.peak_torque",
        ),
        (", effort_limit: 30", {"stall_torque": "600"}, "motors.m.stall_torque"),
    ],
)
def test_limits_of_the_joint_are_evidence(limits: str, wrong: dict[str, str], place: str) -> None:
    assert [found.where for found in said(limits, **wrong)] == [place]


@pytest.mark.parametrize(
    ("sheet", "right", "wrong", "place", "help"),
    [
        # 41.8 x 0.0980665 = 4.099, and 1.78 x 2.3 = 4.09 N*m.
        (
            "stall_torque: 4.1, peak_torque: 4.1",
            "4.1",
            "41.8",
            "stall_torque",
            "are stall_torque, peak_torque in kgf*cm?",
        ),
        # 19.5 x 0.0980665 = 1.912 N*m.
        (
            "stall_torque: 3.25, peak_torque: 1.91",
            "1.91",
            "19.5",
            "peak_torque",
            "is it in kgf*cm? 19.5 kgf*cm is 1.912 N*m; or did you mean 1.95 N*m?",
        ),
        (
            "stall_torque: 4.1, peak_torque: 4.1",
            "peak_torque: 4.1",
            "peak_torque: 0.41",
            "peak_torque",
            "did you mean 4.1",
        ),
    ],
)
def test_torques_of_a_servo(sheet: str, right: str, wrong: str, place: str, help: str) -> None:
    servo = (
        "side: joint, no_load_speed: 46 rpm, gear_ratio: 353.5, torque_constant: 1.78, peak_current: 2.3 A"
    )
    if "3.25" in sheet:
        servo = servo.replace("2.3 A", "1.4 A")
    assert said(sheet=f"{servo}, {sheet}") == []
    (found,) = said(sheet=f"{servo}, {sheet.replace(right, wrong)}")
    assert found.where == f"motors.m.{place}"
    assert (found.help or "").startswith(help)


def test_one_digit_and_an_exchange() -> None:
    """48 and 18 N*m of 55: a peak of 4.8 is told, and an exchange as such."""
    sheet = "side: joint, stall_torque: 55, peak_torque: {}, continuous_torque: {}"
    assert said(sheet=sheet.format(48, 18)) == []
    (found,) = said(sheet=sheet.format(4.8, 18))
    assert (found.where, found.help) == ("motors.m.peak_torque", "did you mean 48 N*m?")
    (found,) = said(sheet=sheet.format(18, 48))
    assert found.help == "are peak_torque and continuous_torque swapped?"


@pytest.mark.parametrize(
    ("wrong", "help"),
    [
        # 0.2 mN*m of 0.6 N*m.
        ({"continuous_torque": "0.2 mN*m"}, "did you mean 0.2 N*m?"),
        ({"efficiency": "0.07"}, "did you mean 0.7?"),
    ],
)
def test_a_figure_far_too_small(wrong: dict[str, str], help: str) -> None:
    (found,) = said(**wrong)
    assert (found.where, found.help) == (f"motors.m.{next(iter(wrong))}", help)


def test_what_no_single_correction_explains_is_told_where_it_is_seen() -> None:
    """0.04 x 200 of 0.6 N*m is 13, and a gear of 0.02 is told beside it."""
    found = said(peak_current="200 A", gear_ratio="0.02", no_load_speed="unknown", rotor_inertia="unknown")
    assert [item.where for item in found] == ["motors.m.torque_constant", "motors.m.gear_ratio"]


def test_a_correction_that_leaves_a_doubt_is_none() -> None:
    """0.1 x 33 is 0.33 of 10 N*m, and ten times that 3.3, above 2.5."""
    (found,) = said(sheet="side: joint, peak_torque: 10, torque_constant: 0.1, peak_current: 33 A")
    assert found.where == "motors.m.torque_constant"
    assert found.help == "torque = torque constant x current, voltage = torque constant x speed"


def test_the_rotors_own_as_reflected() -> None:
    """1.2e-4 x 6^2 = 0.00432 kg*m^2: 24 N*m x 6 / 1.2e-4 = 1.2e6 rad/s^2 at a rotor of 4 N*m, which has 33333."""
    sheet = "side: joint, peak_torque: 24, no_load_speed: 30 rad/s, gear_ratio: 6, reflected_inertia: {}"
    assert said(sheet=sheet.format("0.00432")) == []
    (found,) = said(sheet=sheet.format("1.2e-4"))
    assert (found.code, found.where) == ("SPEC185", "motors.m.reflected_inertia")
    assert found.help == "is it the rotor's own, before the gear? Then write `rotor_inertia`"
    assert "with 200000 rad/s^2 there, 1200000 rad/s^2 at the rotor" in found.message


def test_no_power_of_ten_is_offered_where_two_are_usual() -> None:
    """19.12 and 1.912 rad/s are both usual; so is a motor of 3.35 N*m with 191.2 rad/s."""
    (found,) = said(sheet="side: joint, peak_torque: 33.5, no_load_speed: 1826 rpm")
    assert found.where == "motors.m.no_load_speed"
    assert (found.help or "").startswith(
        "one of 2 numbers is wrong. no_load_speed: is the point in the wrong place? Or peak_torque (s.yaml:3:40): is "
        "it in kgf*cm? 33.5"
    )


def test_the_rotors_own_as_reflected_of_an_unknown_gear() -> None:
    """0.16 / 24^2 = 2.78e-4 kg*m^2: 300 N*m would turn it with 1.08e6 rad/s^2; 0.0278, 0.278, 2.78 are usual."""
    sheet = "side: joint, peak_torque: 300, gear_ratio: unknown, reflected_inertia: {}"
    assert said(", effort_limit: 300", sheet=sheet.format("0.16")) == []
    (found,) = said(", effort_limit: 300", sheet=sheet.format("2.78e-4"))
    assert (found.code, found.where) == ("SPEC185", "motors.m.reflected_inertia")
    assert found.help == (
        "is it the rotor's own, on the other side of the gear? At the output it is that times the gear ratio squared; "
        "or look for a wrong unit"
    )
    # 300 / 1e-9 = 3e11 rad/s^2: a gear of 350 would leave 2.4e6.
    (found,) = said(", effort_limit: 300", sheet=sheet.format("1e-9"))
    assert "gear" not in (found.help or "")


def test_sure_at_one_of_the_figures_keeps_them() -> None:
    assert said(no_load_speed="{value: 4800 rad/s, sure: true}") == []
    assert said(no_load_speed="{value: 4800 rad/s, sure: false}") != []


def test_a_constant_that_its_currents_prove() -> None:
    """0.68 x 13.2 = 8.98 and 0.68 x 4.4 = 2.99 N*m; at the rotor 68 mN*m/A would give 4.8 N*m of the peak's 9."""
    sheet = (
        "side: joint, stall_torque: 14, no_load_speed: 370 rpm, peak_torque: 9, continuous_torque: 3, gear_ratio: 6, "
        "efficiency: 0.9, nominal_current: 4.4 A, peak_current: 13.2 A, nominal_voltage: 24 V"
    )
    (found,) = said(sheet=f"{sheet}, torque_constant: 68 mN*m/A")
    assert (found.where, found.help) == ("motors.m.torque_constant", "did you mean 0.68 N*m/A?")


def test_a_constant_of_a_servo_in_kgf_cm() -> None:
    """1.21 / 0.0980665 = 12.34; x 5.92 = 73.0 of 7.4 V, and x 0.62 rad/s, 5.92 rpm, 7.65: two units of two lines."""
    sheet = (
        "side: joint, stall_torque: 3.25, peak_torque: 1.91, no_load_speed: 5.92 rad/s, torque_constant: {}, "
        "nominal_voltage: 7.4 V, gear_ratio: 345"
    )
    assert said(sheet=sheet.format("1.21")) == []
    (found,) = said(sheet=sheet.format("12.34"))
    assert found.where == "motors.m.torque_constant"
    assert found.help == (
        "one of 2 numbers is wrong. torque_constant: is it in kgf*cm/A? 12.34 kgf*cm/A is 1.21 N*m/A; or did you mean "
        "1.234 N*m/A? Or no_load_speed (s.yaml:3:81): is it in rpm? 5.92 rpm is 0.62 rad/s"
    )


def test_side_or_the_only_torque() -> None:
    """0.88 x 51 = 44.88 N*m; x 51 again 2289: `side` or the number. A speed beside it, which fits, tells which.

    The limit of 45 N*m leaves no mN*m.
    """
    sheet = "side: motor, peak_torque: {}, gear_ratio: 51"
    assert said(", effort_limit: 45", sheet=sheet.format("0.88")) == []
    (found,) = said(", effort_limit: 45", sheet=sheet.format("44.88"))
    assert (found.code, found.where) == ("SPEC187", "motors.m.side")
    assert found.help == (
        "one of 2 values is wrong. side: are the figures those of the gearbox output? Then write `side: joint`. Or "
        "peak_torque (s.yaml:3:40): is it quoted at the gearbox output? At the rotor 44.88 N*m is about 0.88 N*m"
    )
    (found,) = said(", effort_limit: 45", sheet=f"{sheet.format('44.88')}, no_load_speed: 17 rad/s")
    assert found.where == "motors.m.side"
    assert (found.help or "").startswith("are the figures those of the gearbox output?")


@pytest.mark.parametrize(
    ("right", "wrong", "place", "help"),
    [
        # 306 x 0.0980665 = 30.01 N*m, which 0.25 N*m/A x 120 A give; exchanged for the 33 N*m it is 10 % off.
        ("peak_torque: 30", "peak_torque: 306", "peak_torque", "is it in kgf*cm? 306 kgf*cm is 30.01 N*m"),
        ("peak_torque: 30", "peak_torque: 300", "peak_torque", "did you mean 30 N*m?"),
        ("peak_torque: 30", "peak_torque: 45", "peak_torque", "torque_constant and peak_current give 30 N*m"),
        # At the rotor 34 / 6.6 = 5.152 N*m would be less than half of 0.25 x 44 = 11; 112 kgf*cm are 10.98.
        (
            "_torque: 11",
            "_torque: 34",
            "continuous_torque",
            "torque_constant and nominal_current give 11 N*m",
        ),
        ("_torque: 11", "_torque: 112", "continuous_torque", "is it in kgf*cm? 112 kgf*cm is 10.98 N*m"),
        # Exchanged indeed: 30 N*m are what the current gives.
        (
            "stall_torque: 33, peak_torque: 30",
            "stall_torque: 30, peak_torque: 33",
            "peak_torque",
            "are stall_torque and peak_torque swapped?",
        ),
    ],
)
def test_what_the_current_refutes_is_not_offered(right: str, wrong: str, place: str, help: str) -> None:
    sheet = (
        "side: motor, stall_torque: 33, peak_torque: 30, continuous_torque: 11, no_load_speed: 1452 rpm, "
        "gear_ratio: 6.6, torque_constant: 0.25, peak_current: 120 A, nominal_current: 44 A"
    )
    assert said(sheet=sheet) == []
    assert right in sheet
    (found,) = said(sheet=sheet.replace(right, wrong))
    assert (found.where, found.help) == (f"motors.m.{place}", help)


def test_a_speed_that_the_voltage_refutes_is_not_offered() -> None:
    """At the rotor of a gear of 20 they would be 628 rad/s: 34.6 V by 0.055 V*s/rad, of 24 V; 3000 rpm are 17.3 V."""
    sheet = (
        "side: motor, gear_ratio: 20, torque_constant: 0.055, nominal_voltage: {} V, no_load_speed: 300 rpm"
    )
    (found,) = said(sheet=sheet.format(24))
    assert found.help == "did you mean 3000 rpm (314.2 rad/s)? Or did you mean 300 rad/s?"
    (found,) = said(sheet=sheet.format(48))
    assert "quoted at the gearbox output? At the rotor it is 628.3 rad/s" in (found.help or "")


OUTPUT = "is it the inertia at the output? Then write `reflected_inertia`"


@pytest.mark.parametrize(
    ("gear", "peak", "inertia", "help"),
    [
        # The rotor's 4.96e-5, 2.4e-4, 7.2e-5 and 1e-4 kg*m^2, times the gear squared.
        ("22.5", "139", "0.0251", OUTPUT),
        ("9", "40", "0.0194", OUTPUT),
        ("6", "17", "0.00259", OUTPUT),
        ("10", "48", "0.01", OUTPUT),
        # 1.15e-4 and 3.3e-4: behind gears of 51 and 100 that many kg*cm^2 are a rotor's, too.
        ("51", "150", "0.3", f"{OUTPUT}; or is it in kg*cm^2? 0.3 kg*cm^2 is 3e-05 kg*m^2"),
        ("100", "230", "3.3", f"{OUTPUT}; or is it in kg*cm^2? 3.3 kg*cm^2 is 0.00033 kg*m^2"),
        # Behind a gear of 9 2.4 kg*m^2 are 0.03 at the rotor, which its torque turns with 150 rad/s^2.
        ("9", "40", "2.4", "is it in kg*cm^2? 2.4 kg*cm^2 is 0.00024 kg*m^2"),
        # Two powers of ten fit: 2.4e-5 and 2.4e-4.
        ("9", "40", "2.4e-7", "is the point in the wrong place?"),
    ],
)
def test_the_inertia_at_the_output(gear: str, peak: str, inertia: str, help: str) -> None:
    sheet = (
        f"side: joint, gear_ratio: {gear}, peak_torque: {peak}, continuous_torque: {float(peak) / 2.2:.3g}, "
    )
    (found,) = said(sheet=f"{sheet}no_load_speed: {4000 / float(gear):.3g} rpm, rotor_inertia: {inertia}")
    assert (found.code, found.where, found.help) == ("SPEC185", "motors.m.rotor_inertia", help)


def test_an_inertia_of_a_slow_rotor() -> None:
    """1.4 N*m / 3.06e-4 kg*m^2 are 4575 rad/s^2 of an EC 90 flat: 3060 g*cm^2, whose kg*mm^2 would be a hundredth."""
    sheet = (
        "side: motor, gear_ratio: 26, efficiency: 0.83, no_load_speed: 3190 rpm, stall_torque: 4.67, peak_torque: 1.4, "
        "continuous_torque: 0.444, torque_constant: 0.0705, nominal_current: 6.06 A, nominal_voltage: 24 V"
    )
    assert said(sheet=f"{sheet}, rotor_inertia: 3060 g*cm^2") == []
    (found,) = said(sheet=f"{sheet}, rotor_inertia: 3.06")
    assert "is it in kg*cm^2? 3.06 kg*cm^2 is 0.000306 kg*m^2" in (found.help or "")


FLAT = "side: motor, no_load_speed: 2080 rpm, {}"
"""maxon's EC 90 flat: 0.444 N*m turn its 3060 g*cm^2 with 1451 rad/s^2, to 2080 rpm (217.8 rad/s) in 0.15 s."""


@pytest.mark.parametrize(
    ("gear", "torque", "inertia", "where", "help"),
    [
        # 0.306 kg*m^2 would be 1.18e-4 at the rotor; 3060 g*cm^2 are what the sheet has.
        (
            "51",
            "continuous_torque: 444 mN*m",
            "3060 kg*cm^2",
            "rotor_inertia",
            "is it in g*cm^2? 3060 g*cm^2 is",
        ),
        ("51", "peak_torque: 1.4 N*m", "3060 kg*cm^2", "rotor_inertia", "is it in g*cm^2? 3060 g*cm^2 is"),
        # 444 N*m x 217.8 rad/s^2 are 97 kW; 4.44 N*m would be more usual by the rotor, and nobody's unit.
        (
            "1",
            "continuous_torque: 444",
            "3060 g*cm^2",
            "continuous_torque",
            "is it in mN*m? 444 mN*m is 0.444 N*m",
        ),
        (
            "6",
            "continuous_torque: 444",
            "3060 g*cm^2",
            "continuous_torque",
            "is it in mN*m? 444 mN*m is 0.444 N*m",
        ),
        # 0.444 N*m are no peak torque of such a rotor: 1451 rad/s^2.
        ("6", "peak_torque: 444", "3060 g*cm^2", "peak_torque", "did you mean 4.44 N*m?"),
    ],
)
def test_a_continuous_torque_alone_turns_its_rotor_slowly(
    gear: str, torque: str, inertia: str, where: str, help: str
) -> None:
    (found,) = said(sheet=FLAT.format(f"gear_ratio: {gear}, {torque}, rotor_inertia: {inertia}"))
    assert found.where == f"motors.m.{where}"
    assert (found.help or "").startswith(help)
    assert "`reflected_inertia`" not in (found.help or "")


@pytest.mark.parametrize(
    ("gear", "limit", "help"),
    [
        # 0.444 x 51 = 22.64.
        (
            "51",
            "226.4",
            "effort_limit: did you mean 22.64 N*m? Or continuous_torque (s.yaml:3:87): did you mean 4.44 N*m?",
        ),
        (
            "1",
            "4.44",
            "continuous_torque: did you mean 4.44 N*m? Or effort_limit (s.yaml:4:91): did you mean 0.444 N*m?",
        ),
    ],
)
def test_a_limit_ten_times_above_the_motor_is_as_likely_the_wrong_one(
    gear: str, limit: str, help: str
) -> None:
    sheet = FLAT.format(f"gear_ratio: {gear}, continuous_torque: 0.444 N*m, rotor_inertia: 3060 g*cm^2")
    assert said(sheet=sheet) == []
    (found,) = said(f", effort_limit: {limit} N*m", sheet=sheet)
    assert (found.code, found.help) == ("SPEC187", f"one of 2 numbers is wrong. {help}")


def test_a_limit_a_hundred_times_above_the_motor_is_the_wrong_one() -> None:
    """0.444 x 51 = 22.64 N*m; 44.4 N*m would turn the rotor with 145098 rad/s^2 and give 9.7 kW."""
    sheet = FLAT.format("gear_ratio: 51, continuous_torque: 0.444 N*m, rotor_inertia: 3060 g*cm^2")
    (found,) = said(", effort_limit: 2264 N*m", sheet=sheet)
    assert (found.where, found.help) == ("actuators.legs.effort_limit", "did you mean 22.64 N*m?")
