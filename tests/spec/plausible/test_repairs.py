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


def said(limits: str = "", **wrong: str) -> list[Diagnostic]:
    """What is said of the sheet with other figures, and with limits of the joint."""
    motor = ", ".join(f"{key}: {value}" for key, value in {**SHEET, **wrong}.items())
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


def test_the_sheet_is_sound() -> None:
    assert said() == []
    # 30 N*m and 10.05 rad/s at the joint.
    assert said(", effort_limit: 30, velocity_limit: 10 rad/s") == []


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
            "is it quoted at the gearbox output? At the rotor it is 0.04 N*m/A",
        ),
        # 0.6 x 50 and 0.2 x 50 N*m, of the output.
        (
            {"stall_torque": "30", "peak_torque": "30", "continuous_torque": "10"},
            "SPEC183",
            "stall_torque",
            "is it quoted at the gearbox output (stall_torque, peak_torque, continuous_torque)? At the rotor 30 N*m is "
            "0.6 N*m",
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
        ({"rotor_inertia": "6e-9 kg*m^2"}, "SPEC185", "rotor_inertia", "did you mean 6e-06 kg*m^2?"),
    ],
)
def test_the_wrong_number_is_blamed(wrong: dict[str, str], code: str, place: str, help: str) -> None:
    (found,) = said(**wrong)
    assert (found.code, found.where, found.help) == (code, f"motors.m.{place}", help)


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
            "motors.m.stall_torque",
        ),
        (", effort_limit: 30", {"stall_torque": "600"}, "motors.m.stall_torque"),
    ],
)
def test_limits_of_the_joint_are_evidence(limits: str, wrong: dict[str, str], place: str) -> None:
    assert [found.where for found in said(limits, **wrong)] == [place]


def test_what_no_single_correction_explains_is_told_where_it_is_seen() -> None:
    """0.04 x 200 of 0.6 N*m is 13, and a gear of 0.02 is told beside it."""
    found = said(peak_current="200 A", gear_ratio="0.02", no_load_speed="unknown", rotor_inertia="unknown")
    assert [item.where for item in found] == ["motors.m.torque_constant", "motors.m.gear_ratio"]


def test_sure_at_one_of_the_figures_keeps_them() -> None:
    assert said(no_load_speed="{value: 4800 rad/s, sure: true}") == []
    assert said(no_load_speed="{value: 4800 rad/s, sure: false}") != []
