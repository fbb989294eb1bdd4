"""Each check of numbers just inside and just outside of its bounds, and what keeps a number."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from actspec import api
from actspec.cli.main import main
from actspec.diagnostics import ActspecError, Diagnostic, Severity
from actspec.robot.load import joints_of_text, load_robot
from actspec.spec.document import document_from_text
from actspec.spec.plausible import BY_CODE, CHECKS
from actspec.spec.validate import validate
from tests.fitting import fit, spec_of

ROBOTS = Path(__file__).resolve().parents[3] / "robots"
REST = "rest: {joints: [calf, slide], level: ideal_pd, kp: 1, kd: 1}"


def said(text: str, model: str | None = None) -> list[Diagnostic]:
    """What the checks of numbers report of a spec, errors or not."""
    try:
        found = fit(text, model).diagnostics
    except ActspecError as err:
        found = err.diagnostics
    return [item for item in found if item.code in BY_CODE]


def codes(text: str, model: str | None = None) -> list[str]:
    """Code, with `!` for an error."""
    return [item.code + "!" * (item.severity is Severity.ERROR) for item in said(text, model)]


@pytest.mark.parametrize(
    ("motor", "expected"),
    [
        # 1.02 and 3 times the stall torque; any continuous torque above it.
        ("side: joint, stall_torque: 10, peak_torque: 10.2", []),
        ("side: joint, stall_torque: 10, peak_torque: 10.3", ["SPEC180"]),
        ("side: joint, stall_torque: 10, peak_torque: 31", ["SPEC180!"]),
        ("side: joint, stall_torque: 10, continuous_torque: 11", ["SPEC180!"]),
        # One swap explains both that it is above the peak and above the stall torque.
        ("side: joint, stall_torque: 10, peak_torque: 10, continuous_torque: 11", ["SPEC135!"]),
        ("side: joint, peak_torque: 10, continuous_torque: 10", []),
        ("side: joint, stall_torque: unknown, peak_torque: 31", []),
        (
            "side: joint, peak_torque: 13, curve: {drive_torque: 12, brake_torque: 20, knee_speed: 1 rad/s, "
            "no_load_speed: 9 rad/s}",
            ["SPEC180"],
        ),
        # 0.1 x 40 = 4 N*m of 10 is 0.4; 0.1 x 39 is below.
        ("side: joint, peak_torque: 10, torque_constant: 0.1, peak_current: 40", []),
        ("side: joint, peak_torque: 10, torque_constant: 0.1, peak_current: 39", ["SPEC181"]),
        # 1 V*s/rad x 24 rad/s is 24 of 24 V; of 120 V it is 0.2.
        ("side: joint, no_load_speed: 24 rad/s, torque_constant: 1, nominal_voltage: 24", []),
        ("side: joint, no_load_speed: 24 rad/s, torque_constant: 1, nominal_voltage: 121", ["SPEC181"]),
        ("gear_ratio: 1", []),
        ("gear_ratio: 0.99", ["SPEC182"]),
        ("gear_ratio: 0.04", ["SPEC182!"]),
        # 60 x 219 x 0.85 = 11169 N*m of a KR 210; 500 x 200 = 100 kN*m, 501 x 200, x 0.9 with an efficiency; 408 kN*m
        # of an excavator; 1.01e6 N*m.
        ("side: motor, gear_ratio: 219, efficiency: 0.85, peak_torque: 60", []),
        ("side: motor, gear_ratio: 200, peak_torque: 500", []),
        ("side: motor, gear_ratio: 200, peak_torque: 501", ["SPEC183"]),
        ("side: motor, gear_ratio: 200, efficiency: 0.9, peak_torque: 501", []),
        # 0.98 x 1010 = 990 and 1 x 1010 = 1010 N*m behind more than 1000 turns; 1100 behind just as many.
        ("side: motor, gear_ratio: 1010, peak_torque: 0.98", []),
        ("side: motor, gear_ratio: 1010, peak_torque: 1", ["SPEC183"]),
        ("side: motor, gear_ratio: 1000, peak_torque: 1.1", []),
        ("side: motor, gearbox: [{ratio: 40}, {ratio: 25}], peak_torque: 408", ["SPEC183"]),
        ("side: motor, gearbox: [{ratio: 100}, {ratio: 100}], peak_torque: 101", ["SPEC183!"]),
        # A direct drive of 38 rad/s: 15 / 0.012 = 1250 rad/s^2, 0.03 s. At 0.04 kg*m^2 375 rad/s^2, 0.101 s.
        ("side: joint, gear_ratio: 1, peak_torque: 15, no_load_speed: 38 rad/s, rotor_inertia: 0.012", []),
        (
            "side: joint, gear_ratio: 1, peak_torque: 15, no_load_speed: 38 rad/s, rotor_inertia: 0.04",
            ["SPEC185"],
        ),
        # 120 N*m at the output, 13.3 N*m at the rotor: 120 x 9 / 1.08e-3 is 1e6 rad/s^2. Of less than 1 N*m 5e6.
        ("side: joint, gear_ratio: 9, peak_torque: 120, reflected_inertia: 1.09e-3", []),
        ("side: joint, gear_ratio: 9, peak_torque: 120, reflected_inertia: 1.07e-3", ["SPEC185"]),
        ("side: joint, gear_ratio: 10, peak_torque: 9.9, reflected_inertia: 2e-5", []),
        # 2500 rad/s^2 at the rotor behind a gear are 250 at the output of a gear of 10.
        ("side: joint, gear_ratio: 10, peak_torque: 10, reflected_inertia: 0.039", []),
        ("side: joint, gear_ratio: 10, peak_torque: 10, reflected_inertia: 0.041", ["SPEC185"]),
        # 150000 rpm are 15708 rad/s, of a micro motor below 1 mN*m.
        ("side: motor, gear_ratio: 1, peak_torque: 0.9e-3, no_load_speed: 149000 rpm", []),
        ("side: motor, gear_ratio: 1, peak_torque: 0.9e-3, no_load_speed: 151000 rpm", ["SPEC184"]),
        ("side: motor, gear_ratio: 1, peak_torque: 1.1e-3, no_load_speed: 100000 rpm", ["SPEC184"]),
        # Three times, either way.
        (
            "side: joint, curve: {drive_torque: 20, brake_torque: 60, knee_speed: 1 rad/s, no_load_speed: 9 rad/s}",
            [],
        ),
        (
            "side: joint, curve: {drive_torque: 20, brake_torque: 61, knee_speed: 1 rad/s, no_load_speed: 9 rad/s}",
            ["SPEC180"],
        ),
        (
            "side: joint, curve: {drive_torque: 20, brake_torque: 6.6, knee_speed: 1 rad/s, no_load_speed: 9 rad/s}",
            ["SPEC180"],
        ),
        # 900 x 23 = 20.7 kW (and 23 x sqrt(900) = 690), too much for 48 V; 900 x 22 = 19.8 kW. 50000 x 4.1 = 205 kW.
        ("side: joint, stall_torque: 900, no_load_speed: 23 rad/s", []),
        ("side: joint, stall_torque: 900, no_load_speed: 23 rad/s, nominal_voltage: 48", ["SPEC183"]),
        ("side: joint, stall_torque: 900, no_load_speed: 22 rad/s, nominal_voltage: 48", []),
        ("side: joint, stall_torque: 900, no_load_speed: 23 rad/s, nominal_voltage: 400", []),
        ("side: joint, stall_torque: 50000, no_load_speed: 4.1 rad/s", ["SPEC183"]),
        ("side: joint, stall_torque: 50000, no_load_speed: 3.9 rad/s", []),
        # A rotor of 60 rad/s or 12 times the gear behind a gear of 3 or more; an output of up to 120 rad/s.
        ("side: motor, gear_ratio: 5, no_load_speed: 59 rad/s", ["SPEC184"]),
        ("side: motor, gear_ratio: 5, no_load_speed: 60 rad/s", []),
        ("side: motor, gear_ratio: 3, no_load_speed: 35 rad/s", ["SPEC184"]),
        ("side: motor, gear_ratio: 3, no_load_speed: 36 rad/s", []),
        ("side: motor, gear_ratio: 2.9, no_load_speed: 35 rad/s", []),
        # A fiftieth of the peak torque, 0.004 of the stall torque, a tenth of what goes in.
        ("side: joint, peak_torque: 10, continuous_torque: 0.2", []),
        ("side: joint, peak_torque: 10, continuous_torque: 0.19", ["SPEC135"]),
        ("side: joint, stall_torque: 10, continuous_torque: 0.04", []),
        ("side: joint, stall_torque: 10, continuous_torque: 0.039", ["SPEC180"]),
        ("gear_ratio: 10, efficiency: 0.1", []),
        ("gear_ratio: 10, efficiency: 0.09", ["SPEC189"]),
        ("gearbox: [{ratio: 10, efficiency: 0.9}, {ratio: 2, efficiency: 0.09}]", ["SPEC189"]),
        ("side: joint, gear_ratio: 3, no_load_speed: 120 rad/s", []),
        ("side: joint, gear_ratio: 3, no_load_speed: 121 rad/s", ["SPEC184"]),
        ("side: joint, gear_ratio: 2.9, no_load_speed: 121 rad/s", []),
        ("side: joint, gear_ratio: 100, no_load_speed: 81 rad/s", ["SPEC184"]),
        ("side: joint, gear_ratio: 100, no_load_speed: 80 rad/s", []),
        # 200 x sqrt(25) = 1000.
        ("side: joint, stall_torque: 25, no_load_speed: 200 rad/s", []),
        ("side: joint, stall_torque: 25, no_load_speed: 201 rad/s", ["SPEC184"]),
        # 3 N*m / 2e-3 kg*m^2 = 1500 rad/s^2 at the rotor; at the output of 10 it is 30 N*m.
        ("side: joint, gear_ratio: 10, stall_torque: 30, rotor_inertia: 2e-3", []),
        ("side: joint, gear_ratio: 10, stall_torque: 30, rotor_inertia: 2.1e-3", ["SPEC185"]),
        ("side: joint, gear_ratio: 10, stall_torque: 30, rotor_inertia: 0.21", ["SPEC185!"]),
        ("side: joint, gear_ratio: 10, stall_torque: 30, rotor_inertia: 5e-7", ["SPEC185"]),
        ("side: joint, stall_torque: 30, reflected_inertia: 29", []),
        ("side: joint, stall_torque: 30, reflected_inertia: 31", ["SPEC185"]),
        # By the peak torque, whatever the winding has: 3 N*m / 1.2e-3 kg*m^2 = 2500 rad/s^2 at the rotor.
        ("side: joint, gear_ratio: 10, stall_torque: 300, peak_torque: 30, rotor_inertia: 1.2e-3", []),
        (
            "side: joint, gear_ratio: 10, stall_torque: 300, peak_torque: 30, rotor_inertia: 1.21e-3",
            ["SPEC185"],
        ),
        ("side: joint, gear_ratio: 2.9, stall_torque: 300, peak_torque: 30, rotor_inertia: 6.8e-3", []),
        # A continuous torque alone may be a tenth of the stall torque: 0.444 / 3.06e-4 = 1451 rad/s^2 (EC 90 flat),
        # 0.444 / 8.9e-4 = 499; by a stall torque alone 1451 is too slow.
        ("side: motor, gear_ratio: 51, continuous_torque: 0.444, rotor_inertia: 3.06e-4", []),
        ("side: motor, gear_ratio: 51, continuous_torque: 0.444, rotor_inertia: 8.9e-4", ["SPEC185"]),
        ("side: motor, gear_ratio: 51, stall_torque: 0.444, rotor_inertia: 3.06e-4", ["SPEC185"]),
        # With 0.0705 N*m/A x 70 A the drive gives 4.935 N*m: 4.935 / 8.9e-4 = 5545 rad/s^2. 4.935 / 3.4e-3 = 1451.
        (
            "side: motor, gear_ratio: 51, continuous_torque: 0.444, torque_constant: 0.0705, peak_current: 70, "
            "rotor_inertia: 8.9e-4",
            [],
        ),
        (
            "side: motor, gear_ratio: 51, continuous_torque: 0.444, torque_constant: 0.0705, peak_current: 70, "
            "rotor_inertia: 3.4e-3",
            ["SPEC185"],
        ),
        # 70.5 N*m/A x 70 A x 51 = 252 kN*m.
        (
            "side: motor, gear_ratio: 51, continuous_torque: 0.444, torque_constant: 70.5, peak_current: 70",
            ["SPEC183"],
        ),
        # 10 N*m bring 0.5 kg*m^2 to 10 rad/s in 0.5 s; a continuous torque may take 1 s.
        ("side: joint, peak_torque: 10, no_load_speed: 10 rad/s, reflected_inertia: 0.5", []),
        ("side: joint, peak_torque: 10, no_load_speed: 10 rad/s, reflected_inertia: 0.51", ["SPEC185"]),
        ("side: joint, continuous_torque: 10, no_load_speed: 10 rad/s, reflected_inertia: 1", []),
        ("side: joint, continuous_torque: 10, no_load_speed: 10 rad/s, reflected_inertia: 1.01", ["SPEC185"]),
        # 1 N*m / 4e-4 kg*m^2 = 2500 rad/s^2 at the rotor: its 50 rad/s take 20 ms.
        ("side: joint, gear_ratio: 10, peak_torque: 10, no_load_speed: 5 rad/s, rotor_inertia: 4e-4", []),
        # 3000 rad/s of 1 N*m and 1.7e-4 kg*m^2: 5882 rad/s^2, 0.51 s.
        (
            "side: joint, gear_ratio: 100, peak_torque: 100, no_load_speed: 30 rad/s, rotor_inertia: 1.7e-4",
            ["SPEC185"],
        ),
        # Voltage over resistance times the torque constant, beside what the drive gives: an AK80-64 has 2146 N*m.
        ("side: joint, stall_torque: 2146, peak_torque: 120, no_load_speed: 6 rad/s", []),
        ("side: joint, stall_torque: 10100, peak_torque: 160", ["SPEC183"]),
        # Ten times a large peak torque.
        ("side: joint, stall_torque: 19900, peak_torque: 2000", []),
        ("side: joint, stall_torque: 20100, peak_torque: 2000", ["SPEC183"]),
        ("side: joint, stall_torque: 10, peak_torque: 0.15", []),
        ("side: joint, stall_torque: 10, peak_torque: 0.149", ["SPEC180"]),
        ("nominal_voltage: 1", []),
        ("nominal_voltage: 0.9", ["SPEC181"]),
        ("nominal_voltage: 1001", ["SPEC181"]),
        ("nominal_current: 0.005, peak_current: 2000", []),
        ("peak_current: 2001", ["SPEC181"]),
        ("nominal_current: 4 mA", ["SPEC181"]),
        ("nominal_current: 10.2, peak_current: 10", []),
        ("nominal_current: 10.3, peak_current: 10", ["SPEC181"]),
        # 40 rad/s at the rotor, or 12 times the gear.
        ("side: joint, gear_ratio: 10, no_load_speed: 4 rad/s", []),
        ("side: joint, gear_ratio: 10, no_load_speed: 3.9 rad/s", ["SPEC184"]),
        ("side: joint, gear_ratio: 3, no_load_speed: 12 rad/s", []),
        ("side: joint, gear_ratio: 3, no_load_speed: 11.9 rad/s", ["SPEC184"]),
        ("gearbox: [{ratio: 0.5}, {ratio: 2}]", []),
        ("gearbox: [{ratio: 0.5}, {ratio: 1.9}]", ["SPEC182"]),
        ("gearbox: [{teeth: {driving: 40, driven: 1}}, {ratio: 1.9}]", ["SPEC182!"]),
    ],
)
def test_motors(motor: str, expected: list[str]) -> None:
    assert (
        codes(
            spec_of(
                REST + ", legs: {joints: [hip], level: ideal_pd, command: effort}",
                motors=f"{{m: {{{motor}}}}}",
            )
        )
        == expected
    )


@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        ("effort_limit: 20, friction: {coulomb: 9.9}", []),
        ("effort_limit: 20, friction: {coulomb: 10}", ["FRC101"]),
        ("effort_limit: 20, friction: {coulomb: 40}", ["FRC101!"]),
        ("friction: {coulomb: 200}", []),
        # At a velocity limit, where no motor's speed is known, all of it: 1 x 20 of 20 N*m. 100 rad/s is a placeholder.
        ("effort_limit: 20, friction: {viscous: 1}, velocity_limit: 20 rad/s", ["FRC106"]),
        ("effort_limit: 20, friction: {viscous: 0.99}, velocity_limit: 20 rad/s", []),
        ("effort_limit: 20, friction: {viscous: 200}, velocity_limit: 100 rad/s", []),
        ("effort_limit: 20, friction: {viscous: 200}", []),
        # The motor's 20 N*m are the limit where none is stated.
        ("motor: m, friction: {coulomb: 10}", ["FRC101"]),
        # 1 x 10 rad/s of 20 N*m.
        ("motor: m, level: dc_motor, friction: {viscous: 1}", ["FRC106"]),
        ("motor: m, level: dc_motor, friction: {viscous: 0.99}", []),
        # Where no line acts three times the limit, 6 x 10 of 20 N*m; at a velocity limit all of it, 4 x 5.
        ("motor: m, friction: {viscous: 6}", ["FRC106"]),
        ("motor: m, friction: {viscous: 5.9}", []),
        ("motor: m, friction: {viscous: 4}, velocity_limit: 5 rad/s", ["FRC106"]),
        ("motor: m, friction: {viscous: 3.9}, velocity_limit: 5 rad/s", []),
        # 0.5 x 20 rad/s of 10 N*m, both by a reduction that is doubted itself.
        ("motor: m, level: dc_motor, friction: {viscous: 0.5}, reduction: 0.5", ["SPEC182"]),
        # 20 N*m x 0.04 = 0.8 N*m.
        ("motor: m, reduction: 0.04", ["SPEC182!"]),
        ("motor: m, reduction: 1", []),
        # An eighth of the peak torque, 2.5 N*m; of the stall torque alone, above, a fiftieth.
        ("motor: peaked, effort_limit: 2.5", []),
        ("motor: peaked, effort_limit: 2.4", ["SPEC187"]),
        # Three times the motor's 10 rad/s, and of its 5 behind a reduction of 2.
        ("motor: m, velocity_limit: 30 rad/s", []),
        ("motor: m, velocity_limit: 31 rad/s", ["SPEC184"]),
        ("motor: m, velocity_limit: 16 rad/s, reduction: 2", ["SPEC184"]),
        # Twice what it has at standstill, which is the most, though no line acts.
        ("motor: m, effort_limit: 40", []),
        ("motor: m, effort_limit: 41", ["SPEC187"]),
        ("motor: m, effort_limit: 61", ["SPEC187"]),
        # Three times its peak of 20 N*m, though the winding has 200.
        ("motor: wound, effort_limit: 60", []),
        ("motor: wound, effort_limit: 61", ["SPEC187"]),
        # A hinge behind a belt of 2: 80 N*m and 15 rad/s, twice and three times what the motor gives there.
        ("motor: m, transmission: [{ratio: 2}], effort_limit: 80, velocity_limit: 15 rad/s", []),
        ("motor: m, transmission: [{ratio: 2}], effort_limit: 81", ["SPEC187"]),
        ("motor: m, transmission: [{ratio: 2; efficiency: 0.9}], effort_limit: 109", ["SPEC187"]),
        ("motor: m, transmission: [{ratio: 2}], motors_per_joint: 2, effort_limit: 121", []),
        ("motor: m, transmission: [{ratio: 2}], velocity_limit: 15.1 rad/s", ["SPEC184"]),
        ("motor: m, transmission: [{ratio: 0.5}, {ratio: 1.9}]", ["SPEC182"]),
        ("motor: m, transmission: [{ratio: 2; efficiency: 0.09}]", ["SPEC189"]),
        ("motor: m, effort_limit: 61, reduction: 2", []),
        ("motor: m, effort_limit: 61, motors_per_joint: 2", []),
        ("motor: m, effort_limit: 601", ["SPEC187!"]),
        ("motor: m, effort_limit: 0.39", ["SPEC187"]),
        # 3 / 2 is 1.5 s, and more than 1 s; of a damping ratio of 4 by the armature alone it is 2 x 4 x sqrt(I / 2),
        # 1.507 s of 0.071 kg*m^2 and 1.486 s of 0.069.
        ("kp: 2, kd: 3, armature: 0.071", []),
        ("kp: 2, kd: 3, armature: 0.069", ["SPEC192"]),
        # kd / kp is a time, of 1 s at most, and of joints with a motor 0.5 ms at least.
        ("motor: m, kp: 100, kd: 0.051", []),
        ("motor: m, kp: 100, kd: 0.049", ["SPEC192"]),
        ("motor: m, kp: 100, kd: 0.049, friction: {viscous: 0.01}", []),
        ("motor: m, kp: 100, kd: 0", []),
        ("kp: 100, kd: 0.049", []),
        # 0.3 ms of kd alone.
        ("motor: m, kp: 100, kd: 0.031, friction: {viscous: 0.05}", []),
        ("motor: m, kp: 100, kd: 0.029, friction: {viscous: 0.05}", ["SPEC192"]),
        # 20 N*m at 0.015 rad, with a kd of 2 ms.
        ("motor: m, kp: 1330, kd: 2.6", []),
        ("motor: m, kp: 1340, kd: 2.7", []),
        ("motor: m, kp: 1340, kd: 2.6", ["SPEC192"]),
        ("kp: 1340, kd: 2.6, effort_limit: 20", []),
        # Without a motor with a kd of 0.1 ms: 0.0603 of 603, friction included; 9 N*m / 603 N*m/rad is 0.0149 rad, and
        # / 599 0.01503; a power of ten is a placeholder.
        ("kp: 603, kd: 0.06, effort_limit: 9", ["SPEC192"]),
        ("kp: 603, kd: 0.061, effort_limit: 9", []),
        ("kp: 603, kd: 0.045, effort_limit: 9, friction: {viscous: 0.016}", []),
        ("kp: 599, kd: 0.059, effort_limit: 9", []),
        # From 10 N*m on 0.03 rad and 0.8 ms: 20 / 667 is 0.02999 rad, / 666 0.03003; 0.0008 x 667 is 0.534.
        ("kp: 667, kd: 0.53, effort_limit: 20", ["SPEC192"]),
        ("kp: 667, kd: 0.54, effort_limit: 20", []),
        ("kp: 667, kd: 0.4, effort_limit: 20, friction: {viscous: 0.14}", []),
        ("kp: 666, kd: 0.53, effort_limit: 20", []),
        ("kp: 331, kd: 0.2, effort_limit: 9.9", []),
        ("motor: m, kp: 667, kd: 0.53", ["SPEC192"]),
        # And from 0.3 rad on 1 ms of kd, 5 ms with friction: 20 / 66 is 0.303 rad, / 67 0.299; 0.005 x 66 is 0.33.
        ("kp: 66, kd: 0.065, effort_limit: 20", ["SPEC192"]),
        ("kp: 66, kd: 0.067, effort_limit: 20", []),
        ("kp: 66, kd: 0.065, effort_limit: 20, friction: {viscous: 0.26}", ["SPEC192"]),
        ("kp: 66, kd: 0.065, effort_limit: 20, friction: {viscous: 0.27}", []),
        ("kp: 67, kd: 0.065, effort_limit: 20", []),
        ("kp: 33, kd: 0.03, effort_limit: 9.9", []),
        ("kp: 66, kd: 0, effort_limit: 20", []),
        ("motor: m, kp: 66, kd: 0.065", ["SPEC192"]),
        ("kp: 10000, kd: 0.5, effort_limit: 20", []),
        ("kp: 1340, kd: 0, effort_limit: 20", []),
        # 20 N*m / 0.4 N*m/rad = 50 rad.
        ("motor: m, kp: 0.41, kd: 0.1", []),
        ("motor: m, kp: 0.39, kd: 0.1", ["SPEC192"]),
        # The same without a motor where friction is stated; else 1000 rad: a published finger has 250.
        ("effort_limit: 20, kp: 0.41, kd: 0.1, friction: {coulomb: 0.1}", []),
        ("effort_limit: 20, kp: 0.39, kd: 0.1, friction: {coulomb: 0.1}", ["SPEC192"]),
        ("effort_limit: 20, kp: 0.0201, kd: 0.01", []),
        ("effort_limit: 20, kp: 0.0199, kd: 0.01", ["SPEC192"]),
        ("effort_limit: 1000, kp: 0.0199, kd: 0.01", []),
        ("kp: {derive: natural_frequency; frequency: 100 Hz; inertia: 0.1}", []),
        ("kp: {derive: natural_frequency; frequency: 101 Hz; inertia: 0.1}", ["SPEC192"]),
        ("kd: {derive: damping_ratio; ratio: 60; inertia: 0.0001}", []),
        ("kd: {derive: damping_ratio; ratio: 61; inertia: 0.0001}", ["SPEC192"]),
        ("kp: 2, kd: 2", []),
        ("kp: 2, kd: 2.1", ["SPEC192"]),
        ("kp: 0, kd: 2.1", []),
        ("kp: 20, kd: 2.1, overrides: {hip: {kp: 2}}", ["SPEC192"]),
        # 5.1 and 4.9 rad/s^2 of 20 N*m; the motor's 0.1 kg*m^2 times 3 and 0.3.
        ("effort_limit: 20, armature: 3.9", []),
        ("effort_limit: 20, armature: 4.1", ["SPEC191"]),
        # Of 20 N*m and more 3e5 rad/s^2, whatever the links are: 20 / 7e-5 = 2.9e5, 20 / 6e-5 = 3.3e5, as 19.9 / 6e-5.
        ("effort_limit: 20, armature: 7e-5", []),
        ("effort_limit: 20, armature: 6e-5", ["SPEC191"]),
        ("effort_limit: 19.9, armature: 6e-5", []),
        ("motor: m, armature: 0.299", []),
        # Without a model, in which links would be, what is coupled to the rotor may be meant.
        ("motor: m, armature: 0.301", []),
        ("motor: m, armature: 0.029", ["SPEC191"]),
        ("delay: 250 ms", []),
        ("delay: 251 ms", ["SPEC186"]),
        ("delay: 2.6 s", ["SPEC186!"]),
        ("delay: 0 s", []),
        ("delay: 20 us", []),
        ("delay: 19 us", ["SPEC186"]),
        ("delay: 1 us", ["SPEC186"]),
        ("delay: {nominal: 5 ms, range: [0, 0.3 s]}", ["SPEC186"]),
        ("delay: {nominal: 5 ms, range: [4 us, 8 ms]}", []),
        ("delay: {nominal: 4 us, range: [2 us, 8 us]}", ["SPEC186"]),
        ("command_filter: {cutoff: 0.1 Hz}", ["SPEC186"]),
        ("randomize: {kd: {scale: [0.3, 10]}}", []),
        ("randomize: {kd: {scale: [0.9, 11]}}", ["SPEC188"]),
        ("randomize: {kd: {scale: [21, 22]}}", ["SPEC188"]),
        ("randomize: {encoder_bias: {add: [-0.25 rad, 0.25 rad]}}", []),
        ("randomize: {encoder_bias: {abs: [-0.26 rad, 0 rad]}}", ["SPEC188"]),
        ("encoder_bias: -0.25 rad", []),
        ("encoder_bias: -0.26 rad", ["SPEC188"]),
        ("randomize: {effort_limit: {add: [0, 100]}}", []),
        # All of it above ten times the nominal value, or below a tenth; the limit of 20 N*m.
        ("motor: m, friction: {coulomb: 1}, randomize: {friction.coulomb: {abs: [9.9, 12]}}", []),
        ("motor: m, friction: {coulomb: 1}, randomize: {friction.coulomb: {abs: [10.1, 12]}}", ["SPEC188"]),
        ("motor: m, friction: {coulomb: 1}, randomize: {friction.coulomb: {abs: [0.05, 0.1]}}", []),
        ("motor: m, friction: {coulomb: 1}, randomize: {friction.coulomb: {abs: [0.05, 0.09]}}", ["SPEC188"]),
        ("motor: m, randomize: {friction.coulomb: {abs: [1, 19]}}", []),
        ("motor: m, randomize: {friction.coulomb: {abs: [1, 20]}}", ["SPEC188"]),
        # The limit again from a range that begins at 0, from 1 + 19 and 1 x 20 N*m, from the mean of a gaussian.
        ("motor: m, randomize: {friction.coulomb: {abs: [0, 20]}}", ["SPEC188"]),
        ("motor: m, friction: {coulomb: 1}, randomize: {friction.coulomb: {add: [0, 18.9]}}", []),
        ("motor: m, friction: {coulomb: 1}, randomize: {friction.coulomb: {add: [0, 19]}}", ["SPEC188"]),
        ("motor: m, friction: {coulomb: 1}, randomize: {friction.static: {add: [0, 19]}}", ["SPEC188"]),
        ("motor: m, friction: {coulomb: 4}, randomize: {friction.coulomb: {scale: [0.5, 4.9]}}", []),
        ("motor: m, friction: {coulomb: 4}, randomize: {friction.coulomb: {scale: [0.5, 5]}}", ["SPEC188"]),
        (
            "motor: m, friction: {coulomb: 4}, randomize: {friction.coulomb: {abs: [20, 1], distribution: gaussian}}",
            ["SPEC188"],
        ),
        ("motor: m, friction: {coulomb: 4}, randomize: {friction.viscous: {abs: [0, 20]}}", []),
        # The friction is told itself.
        ("motor: m, friction: {coulomb: 40}, randomize: {friction.coulomb: {abs: [0.1, 0.2]}}", ["FRC101!"]),
        ("effort_limit: 20, kd: 1, randomize: {kd: {abs: [11, 12]}}", ["SPEC188"]),
        # Without a range the joint turns once: 4 pi = 12.57.
        ("action_scale: 12.5", []),
        ("action_scale: 12.6", ["SPEC193"]),
        ("action_scale: 12.6, kp: 3, effort_limit: 19", []),
        ("command: velocity, action_scale: 101, velocity_limit: 10 rad/s", ["SPEC193"]),
        ("command: effort, action_scale: 200, effort_limit: 20", []),
        ("command: effort, action_scale: 4001, effort_limit: 20", ["SPEC193!"]),
    ],
)
def test_groups(fields: str, expected: list[str]) -> None:
    """What needs no inertia and no range."""
    given = {part.split(":")[0].strip() for part in fields.split(",")}
    command = (
        "velocity"
        if "command: velocity" in fields
        else "effort"
        if "command: effort" in fields
        else "position"
    )
    own = {"level": "level: ideal_pd", "kp": "kp: 9", "kd": "kd: 1"}
    if command != "position":
        own.pop("kp")
    if command == "effort":
        own.pop("kd")
    rest = "".join(f", {text}" for key, text in own.items() if key not in given)
    text = spec_of(
        f"legs: {{joints: [hip]{rest}, {fields.replace(';', ',')}}}, {REST}",
        motors="{m: {side: joint, stall_torque: 20, no_load_speed: 10 rad/s, reflected_inertia: 0.1}, "
        "peaked: {side: joint, peak_torque: 20}, "
        "wound: {side: joint, stall_torque: 200, peak_torque: 20, no_load_speed: 10 rad/s}}",
    )
    assert codes(text) == expected


MODEL = """<mujoco><compiler angle="radian"/><worldbody><body>
<joint name="hip" axis="0 1 0" range="-1 0.5"/><inertial pos="0 0 0" mass="1" diaginertia="1 0.1 1"/></body>
</worldbody></mujoco>"""
"""A link of 0.1 kg*m^2 about its joint."""


@pytest.mark.parametrize(
    ("fields", "pose", "expected"),
    [
        ("kp: 10, kd: 0.2", "hip: 0.54 rad", []),
        ("kp: 10, kd: 0.2", "hip: -1.06 rad", ["SPEC190"]),
        ("kp: 10, kd: 0.2", "hip: 3.7 rad", ["SPEC190!"]),
        # sqrt(3.6 / 0.1) = 6 rad/s; 36.1 / 3.61 = 10 rad.
        ("kp: 3.61, kd: 0.1, effort_limit: 37", "", []),
        ("kp: 3.59, kd: 0.1, effort_limit: 35.8", "", []),
        ("kp: 3.59, kd: 0.1, effort_limit: 36", "", ["SPEC192"]),
        ("kp: 0.09, kd: 0.01", "", ["SPEC192"]),
        # sqrt(2250 / 0.1) = 150 rad/s; 135 / 2250 = 0.06 rad.
        ("kp: 2251, kd: 3, effort_limit: 136", "", []),
        ("kp: 2251, kd: 3, effort_limit: 135", "", ["SPEC192"]),
        ("kp: 2249, kd: 3, effort_limit: 134", "", []),
        # Machines: to 500 rad/s, with two digits, and 19 or 110, but not 18 or 120, / 2 sqrt(3600 x 0.1): 0.5 to 2.9.
        ("kp: 4000, kd: 40, effort_limit: 113", "", []),
        ("kp: 25000, kd: 300, effort_limit: 400", "", []),
        ("kp: 26000, kd: 300, effort_limit: 400", "", ["SPEC192"]),
        ("kp: 4010, kd: 40, effort_limit: 113", "", ["SPEC192"]),
        ("kp: 4000, kd: 40.1, effort_limit: 113", "", ["SPEC192"]),
        ("kp: 3600, kd: 19, effort_limit: 113", "", []),
        ("kp: 3600, kd: 18, effort_limit: 113", "", ["SPEC192"]),
        ("kp: 3600, kd: 120, effort_limit: 113", "", ["SPEC192"]),
        # 2 sqrt(10 x 0.1) = 2: a damping ratio of 0.015 is 0.03.
        ("kp: 10, kd: 0.031", "", []),
        ("kp: 10, kd: 0.029", "", ["SPEC192"]),
        ("kp: 10, kd: 0.029, friction: {viscous: 0.01}", "", []),
        ("kp: 10, kd: 0", "", []),
        # 50 x 0.1 = 5 kg*m^2, and 150 / 5.01 = 29.9 rad/s^2 below 30; 300 x 0.1.
        ("kp: 900, kd: 9, effort_limit: 150, armature: 5.01", "", ["SPEC191"]),
        ("kp: 900, kd: 9, effort_limit: 151, armature: 5.01", "", []),
        ("kp: 900, kd: 9, effort_limit: 145, armature: 4.9", "", []),
        ("kp: 900, kd: 30, effort_limit: 2000, armature: 30.1", "", ["SPEC191"]),
        # The range is 1.5 rad: twice that; 8 x 3.1 of 12 N*m.
        ("kp: 8, kd: 0.2, effort_limit: 12, action_scale: 2.9", "", []),
        ("kp: 8, kd: 0.2, effort_limit: 12, action_scale: 3.1", "", ["SPEC193"]),
        # Twelve times the range; a power of ten is a placeholder; the joint's range in the other unit.
        ("kp: 8, kd: 0.2, command_range: [-9 rad, 9 rad]", "", []),
        ("kp: 8, kd: 0.2, command_range: [-9 rad, 9.1 rad]", "", ["SPEC190"]),
        ("kp: 8, kd: 0.2, command_range: [-100 rad, 100 rad]", "", []),
        ("kp: 8, kd: 0.2, command_range: [-57 rad, 29 rad]", "", ["SPEC190"]),
        ("kp: 8, kd: 0.2, command_range: [-1 deg, 0.5 deg]", "", ["SPEC190"]),
        ("kp: 8, kd: 0.2, command_range: [-0.02 rad, 0.3 rad]", "", []),
        ("kp: 8, kd: 0.2, command_range: [0.01 rad, 0.02 rad]", "", []),
        # 0.05 rad beyond the range of -1 to 0.5 rad, and beside the default position.
        ("kp: 8, kd: 0.2, command_range: [0.54 rad, 0.8 rad]", "", []),
        ("kp: 8, kd: 0.2, command_range: [0.56 rad, 0.8 rad]", "", ["SPEC190"]),
        ("kp: 8, kd: 0.2, command_range: [-1.5 rad, -1.06 rad]", "", ["SPEC190"]),
        ("kp: 8, kd: 0.2, command_range: [-1 rad, 0.36 rad]", "hip: 0.4 rad", []),
        ("kp: 8, kd: 0.2, command_range: [-1 rad, 0.34 rad]", "hip: 0.4 rad", ["SPEC190"]),
        ("kp: 8, kd: 0.2, command_range: [-0.3 rad, 0.5 rad]", "hip: -0.4 rad", ["SPEC190"]),
    ],
)
def test_joints_of_a_model(fields: str, pose: str, expected: list[str]) -> None:
    robot = f"name: leg, model: robot.xml, default_pose: {{{pose}}}"
    text = spec_of(
        f"legs: {{joints: [hip], level: ideal_pd, motor: m, {fields}}}",
        robot=robot,
        motors="{m: {gear_ratio: 9}}",
    )
    assert codes(text, MODEL) == expected


@pytest.mark.parametrize(
    ("joint", "fields", "pose", "expected"),
    [
        # A full turn is 6.283 rad, and 12 of them 75.4 rad.
        ("hip", "", "6.28 rad", []),
        ("hip", "", "-6.28 rad", []),
        ("hip", "", "6.4 rad", ["is it in degrees? Then write 6.4 deg, 0.1117 rad"]),
        ("hip", "", "-91.7 rad", ["is it in degrees? Then write -91.7 deg, -1.6 rad"]),
        ("{name: hip, kind: slide}", "", "8 m", []),
        ("hip", "command_range: [-90 rad, 90 rad]", "", ["is it in degrees? Then write [-90 deg, 90 deg]"]),
        ("hip", "command_range: [0 rad, 75.3 rad]", "", []),
        ("hip", "command_range: [0 rad, 75.5 rad]", "", ["is it in degrees? Then write [0 deg, 75.5 deg]"]),
        # More than a turn in degrees, and a placeholder.
        ("hip", "command_range: [-361 rad, 361 rad]", "", []),
        ("hip", "command_range: [-100 rad, 100 rad]", "", []),
    ],
)
def test_a_joint_without_a_range(joint: str, fields: str, pose: str, expected: list[str]) -> None:
    units = ("N/m", "N*s/m") if "slide" in joint else ("N*m/rad", "N*m*s/rad")
    text = spec_of(
        f"legs: {{joints: [hip], level: ideal_pd, kp: 8 {units[0]}, kd: 0.2 {units[1]}, {fields}}}",
        robot=f"name: leg, model: none, joints: [{joint}], default_pose: {{hip: {pose or 0}}}",
    )
    found = said(text)
    assert [(item.code, item.severity) for item in found] == [("SPEC190", Severity.WARNING)] * len(expected)
    assert [item.help for item in found] == expected


def robot_of(count: int, body: str) -> str:
    """A model of so many hinges, one behind the other, each with a link of `body`."""
    text = "".join(f'<body><joint name="j{index}"/>{body}' for index in range(count))
    return f"<mujoco><worldbody>{text}{'</body>' * count}</worldbody></mujoco>"


KILO = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'


@pytest.mark.parametrize(
    ("count", "limit", "expected"),
    [
        # 6 kg x 9.81 m/s^2 x 4 m = 235.4 N*m; ten times that.
        (6, 235, []),
        (6, 236, ["SPEC183"]),
        (6, 2355, ["SPEC183!"]),
        # A test stand.
        (5, 236, []),
    ],
)
def test_an_effort_limit_against_the_weight_of_the_robot(
    count: int, limit: float, expected: list[str]
) -> None:
    for motor, found in ((", motor: m", expected), ("", [])):
        text = spec_of(
            f"legs: {{joints: ['j.*'], level: ideal_pd, kp: 100, kd: 10, effort_limit: {limit}{motor}}}",
            robot="name: leg, model: robot.xml",
            motors="{m: {gear_ratio: 9}}",
        )
        assert codes(text, robot_of(count, KILO)) == found


@pytest.mark.parametrize(
    ("count", "mass", "limit", "expected"),
    [
        # 4 slides of 1.5 kg: 6 kg x 9.81 m/s^2 x 75 = 4414.5 N; ten times that.
        (4, 1.5, 4410, []),
        (4, 1.5, 4420, ["SPEC183"]),
        (4, 1.5, 44200, ["SPEC183!"]),
        # Linear axes alone, and a gripper of 4.9 kg.
        (3, 2.0, 4500, []),
        (4, 1.225, 4500, []),
    ],
)
def test_a_slide_against_the_weight_of_the_robot(
    count: int, mass: float, limit: float, expected: list[str]
) -> None:
    link = f'<inertial pos="0 0 0" mass="{mass}" diaginertia="1 1 1"/>'
    model = robot_of(count, link).replace("<joint ", '<joint type="slide" ')
    for motor, found in ((", motor: m", expected), ("", [])):
        text = spec_of(
            f"rods: {{joints: ['j.*'], level: ideal_pd, kp: 1e5 N/m, kd: 3e3 N*s/m, effort_limit: {limit} N{motor}}}",
            robot="name: leg, model: robot.xml",
            motors="{m: {side: joint, peak_torque: 50000 N, no_load_speed: 0.2 m/s}}",
        )
        assert codes(text, model) == found


def test_a_reduction_that_makes_a_limit_too_strong() -> None:
    """10 N*m behind 155 are 1550 N*m, on 6 kg 26 m; the same motor is sound without it. kp is not blamed for it."""
    group = "motor: m, level: ideal_pd, kp: 10, kd: 1, effort_limit: peak"
    text = spec_of(
        f"hips: {{joints: ['j[0-2]'], {group}}}, knees: {{joints: ['j[3-5]'], {group}, reduction: 155}}",
        robot="name: leg, model: robot.xml",
        motors="{m: {side: joint, peak_torque: 10, gear_ratio: 6}}",
    )
    (found,) = said(text, robot_of(6, KILO))
    assert (found.code, found.where) == ("SPEC183", "actuators.knees.reduction")
    assert found.span is not None and "reduction" in text.splitlines()[found.span.line - 1]


@pytest.mark.parametrize(
    ("armature", "model", "expected"),
    [
        # A propeller on a rotor of 2.5e-5 kg*m^2, which has 6.4 times that; 0.8 / 1.6e-4 = 5000 rad/s^2.
        ("1.6e-4", None, []),
        # 300 times; 3 times where the links are known.
        ("7.4e-3", None, []),
        ("7.6e-3", None, ["SPEC191"]),
        ("7.4e-5", MODEL, []),
        ("7.6e-5", MODEL, ["SPEC191"]),
    ],
)
def test_what_is_coupled_to_a_rotor(armature: str, model: str | None, expected: list[str]) -> None:
    text = spec_of(
        f"a: {{joints: [hip], motor: m, level: ideal_pd, kp: 1, kd: 0.02, effort_limit: peak, armature: {armature}}}",
        robot="name: a, model: none, joints: [hip]" if model is None else "name: a, model: robot.xml",
        motors="{m: {side: joint, peak_torque: 0.8, gear_ratio: 1, rotor_inertia: 2.5e-5}}",
    )
    assert [code for code in codes(text, model) if code == "SPEC191"] == expected


@pytest.mark.parametrize(
    ("motor", "fields", "expected"),
    [
        (
            "peak_torque: 3.2 kN, no_load_speed: 0.6 m/s, reflected_inertia: 0.2 kg",
            "transmission: [{lever_arm: 45 mm}], ",
            [],
        ),
        ("peak_torque: 144, reflected_inertia: 4.05e-4", "", ["SPEC191"]),
    ],
)
def test_a_cylinder_has_no_rotor(motor: str, fields: str, expected: list[str]) -> None:
    """3.2 kN x 45 mm = 144 N*m on 0.2 kg x (45 mm)^2 = 4.05e-4 kg*m^2 are 3.6e5 rad/s^2; as of a shaft."""
    text = spec_of(
        f"a: {{joints: [hip], motor: m, {fields}level: ideal_pd, kp: 300, kd: 8, effort_limit: peak}}",
        robot="name: a, model: robot.xml",
        motors=f"{{m: {{side: joint, {motor}}}}}",
    )
    assert codes(text, MODEL) == expected


def test_a_command_range_without_the_default_position() -> None:
    """It is told at its own line; a position outside of the joint's range, -1 to 0.5 rad, is told alone."""
    group = "legs: {joints: [hip], level: ideal_pd, kp: 8, kd: 0.2, command_range: [-0.3 rad, 0.2 rad]}"
    robot = "name: leg, model: robot.xml, default_pose: {hip: POSE rad}"
    (found,) = said(spec_of(group, robot=robot.replace("POSE", "0.4")), MODEL)
    assert (found.where, found.message, found.help) == (
        "actuators.legs.command_range",
        "hip: a command range of -0.3 rad to 0.2 rad keeps the joint from its default position, 0.4 rad",
        "it clamps the command itself, not its difference from the default position; `command_range: joint` is the "
        "joint's own range",
    )
    (found,) = said(spec_of(group, robot=robot.replace("POSE", "0.6")), MODEL)
    assert found.where == "robot.default_pose"


@pytest.mark.parametrize(
    ("pose", "fields", "message"),
    [
        ("hip: 0.1 rad", "", "calf: no default position is stated, so that it is 0 rad, outside of the joint's range, "
         "-2.2 rad to -0.4 rad"),
        # Stated, as far beyond as that, and of no joint at all.
        ("hip: 0.1 rad, calf: -0.36 rad", "", None),
        ("", "", None),
        # What is commanded is no position, or it is clamped to another one.
        ("hip: 0.1 rad", "command: velocity", None),
        ("hip: 0.1 rad", "command_range: joint", "calf: no default position is stated, so that it is 0 rad, outside of "
         "the joint's range, -2.2 rad to -0.4 rad"),
    ],
)  # fmt: skip
def test_a_joint_that_the_default_pose_leaves_out(pose: str, fields: str, message: str | None) -> None:
    gains = "kd: 0.2" if "velocity" in fields else "kp: 8, kd: 0.2"
    calf = ", ".join(filter(None, ("joints: [calf], level: ideal_pd", gains, fields)))
    text = spec_of(
        f"hips: {{joints: [hip], level: ideal_pd, kp: 8, kd: 0.2}}, calves: {{{calf}}}",
        robot=f"name: leg, model: robot.xml, default_pose: {{{pose}}}",
    )
    link = '<joint name="calf" axis="0 1 0" range="-2.2 -0.4"/><geom size="0.1" mass="1"/>'
    found = said(text, MODEL.replace("</body>", f"<body>{link}</body></body>"))
    assert [item.message for item in found] == ([] if message is None else [message])
    for item in found:
        assert (item.code, item.severity, item.where) == ("SPEC190", Severity.WARNING, "robot.default_pose")
        assert item.help == (
            "name it here with the position of zero action; `calf: -1.3 rad` is the middle of its range"
        )


def test_two_joints_that_the_default_pose_leaves_out() -> None:
    """Each has a range and a middle of its own: (-2.2 - 0.4) / 2 and (0.3 + 2.5) / 2."""
    text = spec_of(
        "hips: {joints: [hip], level: ideal_pd, kp: 8, kd: 0.2}, "
        "rest: {joints: [calf, toe], level: ideal_pd, kp: 8, kd: 0.2}",
        robot="name: leg, model: robot.xml, default_pose: {hip: 0.1 rad}",
    )
    links = "".join(
        f'<body><joint name="{name}" axis="0 1 0" range="{ends}"/><geom size="0.1" mass="1"/>'
        for name, ends in (("calf", "-2.2 -0.4"), ("toe", "0.3 2.5"))
    )
    (found,) = said(text, MODEL.replace("</body>", f"{links}</body></body></body>"))
    zero = "no default position is stated, so that it is 0 rad, outside of the joint's range"
    assert found.message == f"calf: {zero}, -2.2 rad to -0.4 rad; toe: {zero}, 0.3 rad to 2.5 rad"
    assert found.help == (
        "name it here with the position of zero action; `calf: -1.3 rad` is the middle of its range; "
        "`toe: 1.4 rad` is the middle of its range"
    )


THREE = "".join(
    f'<body><joint name="{name}" axis="0 1 0" range="{ends}"/><geom size="0.1" mass="1"/>'
    for name, ends in (("calf", "0.1 2.6"), ("toe", "-3 3"))
)


@pytest.mark.parametrize(
    ("hip", "calf", "expected"),
    [
        # Ranges: -1 to 0.5 and 0.1 to 2.6 rad. Each is outside of its own, and inside of the other's.
        (
            "1.4 rad",
            "-0.6 rad",
            [
                (
                    "hip: the default position 1.4 rad is outside of the joint's range, -1 rad to 0.5 rad; and "
                    "-0.6 rad of calf outside of 0.1 rad to 2.6 rad",
                    "are the two exchanged (s.yaml:2:COLUMN)? Each is inside of the other's range",
                )
            ],
        ),
        # The hip's 0.7 would be inside, and the calf's -1.2 is in neither.
        (
            "0.7 rad",
            "-1.2 rad",
            [
                (
                    "hip: the default position 0.7 rad is outside of the joint's range, -1 rad to 0.5 rad",
                    "is the sign wrong? -0.7 rad is inside, -40.11 deg",
                ),
                (
                    "calf: the default position -1.2 rad is outside of the joint's range, 0.1 rad to 2.6 rad",
                    "is the sign wrong? 1.2 rad is inside, 68.75 deg",
                ),
            ],
        ),
        # Of one of them the author is sure: the other alone is wrong.
        (
            "{value: 1.4 rad, sure: true}",
            "-0.6 rad",
            [
                (
                    "calf: the default position -0.6 rad is outside of the joint's range, 0.1 rad to 2.6 rad",
                    "is the sign wrong? 0.6 rad is inside, 34.38 deg",
                )
            ],
        ),
        ("-0.6 rad", "1.4 rad", []),
    ],
)
def test_two_default_positions_that_are_exchanged(
    hip: str, calf: str, expected: list[tuple[str, str]]
) -> None:
    text = spec_of(
        "legs: {joints: [hip, calf, toe], level: ideal_pd, kp: 8, kd: 0.2}",
        robot=f"name: leg, model: robot.xml, default_pose: {{hip: {hip}, calf: {calf}, toe: 2 rad}}",
    )
    column = str(text.splitlines()[1].index(f"{calf}, toe") + 1)
    found = said(text, MODEL.replace("</body>", f"{THREE}</body></body></body>"))
    assert [(item.message, item.help) for item in found] == [
        (message, help.replace("COLUMN", column)) for message, help in expected
    ]
    assert {(item.code, item.severity) for item in found} <= {("SPEC190", Severity.WARNING)}


POSED = (
    "legs: {joints: [hip, calf, toe], level: ideal_pd, kp: 8, kd: 0.2}, "
    "rails: {joints: [rail], level: ideal_pd, kp: 800 N/m, kd: 20 N*s/m}"
)


def posed(qpos: str) -> str:
    """A leg on a rail, with that keyframe; empty: without one."""
    text = MODEL.replace("</body>", f"{CALVES}</body></body></body>{RAIL}", 1)
    key = f'<keyframe><key name="home" qpos="{qpos}"/></keyframe>' if qpos else ""
    return text.replace("</mujoco>", f"{key}</mujoco>")


LEFT_OUT = "name it here with the position of zero action; "
CALVES = "".join(
    f'<body><joint name="{name}" axis="0 1 0" range="-2.2 -0.4"/><geom size="0.1" mass="1"/>'
    for name in ("calf", "toe")
)
RAIL = '<body><joint name="rail" type="slide" range="0.1 0.5"/><geom size="0.1" mass="1"/></body>'


@pytest.mark.parametrize(
    ("pose", "qpos", "help"),
    [
        # -1.57 rad x 180 / pi = -89.95 deg; (-2.2 - 0.4) / 2 = -1.3 rad are -74.48 deg, (0.1 + 0.5) / 2 m 300 mm.
        (
            "hip: 0.1 rad, rail: 0.2 m",
            "0.1 -1.57 -1.57 0.2",
            "`calf: -1.57 rad` is that of the first keyframe",
        ),
        (
            "hip: 5 deg, rail: 0.2 m",
            "0.1 -1.57 -1.57 0.2",
            "`calf: -89.95 deg` is that of the first keyframe",
        ),
        # One for each figure that the keyframe has.
        (
            "hip: 0.1 rad, rail: 0.2 m",
            "0.1 -1.57 -1 0.2",
            "`calf: -1.57 rad`, `toe: -1 rad` are those of the first keyframe",
        ),
        ("hip: 5 deg, rail: 0.2 m", "", "`calf: -74.48 deg` is the middle of its range"),
        # A 0 has no unit; 5 deg beside 0.1 rad are of no one.
        ("hip: 0, calf: -60 deg, rail: 0.2 m", "", "`toe: -74.48 deg` is the middle of its range"),
        ("hip: 0.1 rad, calf: -60 deg, rail: 0.2 m", "", "`toe: -1.3 rad` is the middle of its range"),
        # What the keyframe has is outside of the range, too.
        ("hip: 0.1 rad, rail: 0.2 m", "0.1 0 0 0.2", "`calf: -1.3 rad` is the middle of its range"),
        (
            "hip: 0.1 rad, calf: -1 rad, toe: -1 rad",
            "0.1 -1 -1 0.25",
            "`rail: 0.25 m` is that of the first keyframe",
        ),
        ("hip: 0.1 rad, calf: -1 rad, toe: -1 rad", "", "`rail: 0.3 m` is the middle of its range"),
    ],
)
def test_what_is_offered_for_a_joint_that_the_default_pose_leaves_out(
    pose: str, qpos: str, help: str
) -> None:
    (found,) = said(
        spec_of(POSED, robot=f"name: leg, model: robot.xml, default_pose: {{{pose}}}"), posed(qpos)
    )
    assert (found.code, found.where, found.help) == ("SPEC190", "robot.default_pose", LEFT_OUT + help)


@pytest.mark.parametrize(
    ("pose", "qpos", "message", "help"),
    [
        ("calf: 0", "0 -1.57 -1 0.2", "0 rad is outside of the joint's range, -2.2 rad to -0.4 rad",
         "did you mean -1.57 rad, as in the first keyframe?"),
        ("hip: 5 deg, calf: 0", "0 -1.57 -1 0.2", "0 deg is outside of the joint's range, -126.1 deg to -22.92 deg",
         "did you mean -89.95 deg, as in the first keyframe?"),
        ("calf: 1 rad", "0 -1.57 -1 0.2", "1 rad is outside of the joint's range, -2.2 rad to -0.4 rad",
         "is the sign wrong? -1 rad is inside, -57.3 deg. Or did you mean -1.57 rad, as in the first keyframe?"),
        # The keyframe says the same, nothing, or what is as wrong.
        ("calf: 1 rad", "0 -1 -1 0.2", "1 rad is outside of the joint's range, -2.2 rad to -0.4 rad",
         "is the sign wrong? -1 rad is inside, -57.3 deg"),
        ("calf: 0 rad", "", "0 rad is outside of the joint's range, -2.2 rad to -0.4 rad", None),
        ("calf: 0 rad", "0 0 -1 0.2", "0 rad is outside of the joint's range, -2.2 rad to -0.4 rad", None),
    ],
)  # fmt: skip
def test_what_is_offered_for_a_pose_outside_of_the_range(
    pose: str, qpos: str, message: str, help: str | None
) -> None:
    text = spec_of(
        POSED, robot=f"name: leg, model: robot.xml, default_pose: {{{pose}, toe: -1 rad, rail: 0.2 m}}"
    ).replace("toe: -1 rad", "toe: -60 deg" if "deg" in pose else "toe: -1 rad")
    (found,) = said(text, posed(qpos))
    assert (found.message, found.help) == (f"calf: the default position {message}", help)


def test_a_number_of_several_joints_is_offered_no_joints_keyframe() -> None:
    """The calf's -1.57 rad is not the toe's, and the one number is both joints'."""
    text = spec_of(POSED, robot='name: leg, model: robot.xml, default_pose: {"calf|toe": 0 rad, rail: 0.2 m}')
    (found,) = said(text, posed("0 -1.57 -1 0.2"))
    assert (found.message.partition(":")[0], found.help) == ("calf, toe", None)


@pytest.mark.parametrize(("pose", "told"), [("", False), ("calf: 0.1 rad", True)])
def test_a_command_range_without_the_zero_of_a_joint_that_has_no_pose(pose: str, told: bool) -> None:
    """-1 to 0.5 rad have 0, and the command cannot: a joint that `default_pose` leaves out is there at zero action."""
    legs = "joints: [hip], level: ideal_pd, kp: 8, kd: 0.2, command_range: [-0.9 rad, -0.1 rad]"
    text = spec_of(
        f"legs: {{{legs}}}, calves: {{joints: [calf], level: ideal_pd, kp: 8, kd: 0.2}}",
        robot=f"name: leg, model: robot.xml, default_pose: {{{pose}}}",
    )
    link = '<joint name="calf" axis="0 1 0" range="-1 1"/><geom size="0.1" mass="1"/>'
    found = said(text, MODEL.replace("</body>", f"<body>{link}</body></body>"))
    assert [item.message for item in found] == [
        "hip: a command range of -0.9 rad to -0.1 rad keeps the joint from its default position, 0 rad, which no "
        "default_pose states"
    ][: int(told)]


def test_a_gear_that_makes_a_joint_slow() -> None:
    """5e-5 x 6^2 x 50^2 = 4.5 kg*m^2 beside links of 0.1: kp 20 makes 2.09 rad/s, and 14.1 with the links alone."""
    text = spec_of(
        "legs: {joints: [hip], motor: m, reduction: 50, level: ideal_pd, kp: 20, kd: 2, effort_limit: peak}",
        robot="name: leg, model: robot.xml",
        motors="{m: {side: joint, peak_torque: 5, gear_ratio: 6, rotor_inertia: 5e-5}}",
    )
    (found,) = said(text, MODEL)
    assert (found.code, found.where) == ("SPEC192", "actuators.legs.kp")
    assert found.help == (
        "is a gear too large (s.yaml:3:55, s.yaml:4:56)? 4.5 kg*m^2 of the inertia is the armature: 5e-05 kg*m^2 x 36 "
        "(gear_ratio^2) x 2500 (reduction^2). Or is it per degree? Per radian it is 1146 N*m/rad, and kd 57.3 "
        "times as well"
    )


@pytest.mark.parametrize(
    ("body", "compiler", "mass"),
    [
        (KILO, "", 3.0),
        (KILO + '<geom size="1" mass="5"/>', "", 3.0),
        # The text does not weigh geoms, nor scale.
        ('<geom size="1" mass="5"/>', "", None),
        (KILO, '<compiler settotalmass="9"/>', None),
        (KILO + '<geom size="1" mass="5"/>', '<compiler inertiafromgeom="true"/>', None),
    ],
)
def test_the_mass_of_a_text(body: str, compiler: str, mass: float | None, tmp_path: Path) -> None:
    """What is told is what MuJoCo has."""
    path = tmp_path / "robot.xml"
    path.write_text(robot_of(3, body).replace("<worldbody>", f"{compiler}<worldbody>"), encoding="utf-8")
    assert joints_of_text(str(path)).mass == mass
    if mass is not None:
        assert load_robot(str(path)).mass == mass


def test_the_mass_of_a_urdf(tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    link = '<link name="{}"><inertial><mass value="1.5"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    joint = '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>'
    links = "".join(f"{link.format(name)}</inertial></link>" for name in "ab")
    path.write_text(f'<robot name="r">{links}<link name="c"/>{joint}</robot>', encoding="utf-8")
    assert joints_of_text(str(path)).mass == load_robot(str(path)).mass == 3.0


def test_servos_without_a_motor_may_be_of_any_stiffness() -> None:
    """Above, with a motor, the same gains are 150 rad/s, and a damping ratio of 0.0145."""
    for fields in ("kp: 2251, kd: 3, effort_limit: 135", "kp: 10, kd: 0.029"):
        text = spec_of(
            f"legs: {{joints: [hip], level: ideal_pd, {fields}}}", robot="name: leg, model: robot.xml"
        )
        assert codes(text, MODEL) == []


@pytest.mark.parametrize(
    ("viscous", "expected"),
    # 2 sqrt(10 x 0.1) = 2: with kd 0.2, 119.8 makes a damping ratio of 60.
    [("119", []), ("121", ["SPEC192"])],
)
def test_friction_that_holds_a_servo(viscous: str, expected: list[str]) -> None:
    """Friction is no simulator's servo's, and is told at its own place."""
    fields = f"kp: 10, kd: 0.2, friction: {{viscous: {viscous}}}"
    text = spec_of(f"legs: {{joints: [hip], level: ideal_pd, {fields}}}", robot="name: leg, model: robot.xml")
    assert codes(text, MODEL) == expected


@pytest.mark.parametrize(
    ("timing", "expected"),
    [
        ("physics_dt: 20 us", []),
        ("physics_dt: 19 us", ["SPEC186"]),
        ("physics_dt: 40 ms", []),
        ("physics_dt: 41 ms", ["SPEC186"]),
        ("physics_dt: 0.6 s", ["SPEC186!"]),
        ("physics_dt: 5 ms, decimation: 100", []),
        ("physics_dt: 5 ms, decimation: 101", ["SPEC186"]),
    ],
)
def test_timing(timing: str, expected: list[str]) -> None:
    assert (
        codes(
            spec_of(
                "arm: {joints: [hip], level: ideal_pd, kp: 9, kd: 1}, " + REST.replace("calf", "elbow"),
                robot="name: arm, model: none, joints: [hip, elbow, {name: slide, kind: slide}]",
                more=f"timing: {{{timing}}}",
            )
        )
        == expected
    )


@pytest.mark.parametrize(
    ("step", "help"),
    [
        ("50 ms", "did you mean 5 ms?"),
        ("5 s", "did you mean 5 ms?"),
        ("0.3 s", "did you mean 30 ms?"),
        ("5 us", "did you mean 5 ms?"),
    ],
)
def test_what_a_step_was_meant_to_be(step: str, help: str | None) -> None:
    """A tenth below a second, a thousandth from there on."""
    legs = f"legs: {{joints: [hip], level: ideal_pd, kp: 9, kd: 1}}, {REST}"
    (found,) = said(spec_of(legs, more=f"timing: {{physics_dt: {step}}}"))
    assert found.help == help


def test_a_control_period_has_its_bound_and_a_help() -> None:
    """400 x 5 ms are 2 s; a bandwidth of 30 kHz is above 20 kHz."""
    text = "actspec: 1\nrobot: {name: leg, model: none, joints: [hip]}\n"
    text += "timing: {physics_dt: 5 ms, decimation: 400}\nmotors: {m: {bandwidth: 30 kHz}}\n"
    text += "actuators: {a: {joints: [hip], motor: m, level: ideal_pd, kp: 9, kd: 1}}\n"
    period, band = validate(document_from_text(text, "s.yaml")).diagnostics
    assert period.message == "400 steps of 5 ms are a control period of 2 s: 500 ms at most"
    assert (period.help or "").startswith("decimation is the number of simulation steps in one control step")
    assert band.help == "look for a wrong unit, or the point in the wrong place"


@pytest.mark.parametrize(
    ("armature", "help"),
    [
        # The motor has 1e-4 x 6^2 = 0.0036 kg*m^2. A Go2's hips were fitted with 5.7 times their motor's.
        ("0.0205", None),
        ("0.0359", None),
        ("0.0004", None),
        (
            "0.0361",
            "look for a wrong power of ten in the results, or a wrong rotor inertia or gear of the motor",
        ),
        (
            "0.00035",
            "look for a wrong power of ten in the results, or a wrong rotor inertia or gear of the motor",
        ),
    ],
)
def test_an_identified_armature_may_be_more_than_the_motors(armature: str, help: str | None) -> None:
    text = spec_of(
        f"legs: {{joints: [hip], motor: m, level: ideal_pd, kp: 9, kd: 1, identified: r.yaml}}, {REST}",
        motors="{m: {side: motor, gear_ratio: 6, peak_torque: 4, rotor_inertia: 1e-4}}",
    )
    found = fit(text, results=f"{{hip: {{armature: {armature}}}}}").diagnostics
    assert [(item.code, item.help) for item in found] == [("SPEC191", help)] * (help is not None)
    assert all(item.span is not None and item.span.path == "r.yaml" for item in found)


def test_friction_in_the_unit_that_the_other_joints_tell() -> None:
    """20 N*cm are the 0.2 N*m of the others; nothing tells of 30, which is told in mN*m as without them."""
    legs = "joints: [hip, calf], motor: m, level: ideal_pd, kp: 9, kd: 1"
    slide = "rest: {joints: [slide], level: ideal_pd, kp: 1, kd: 1}"
    for own, unit in (("20", "N*cm (0.2 N*m)"), ("30", "mN*m (0.03 N*m)")):
        friction = f"friction: {{coulomb: {own}}}, overrides: {{calf: {{friction: {{coulomb: 0.2}}}}}}"
        (found,) = said(
            spec_of(f"legs: {{{legs}, {friction}}}, {slide}", motors="{m: {peak_torque: 20, side: joint}}")
        )
        assert (found.help or "").startswith(f"is it in {unit}, or a dimensionless coefficient?")


def test_the_message_of_friction_has_the_milli_reading() -> None:
    """30 N*m may be 30 mN*m: the help says 0.03 N*m."""
    (found,) = said(
        spec_of(
            "legs: {joints: [hip], level: ideal_pd, kp: 9, kd: 1, effort_limit: 20, friction: {coulomb: 30}}, "
            + REST
        )
    )
    assert found.where == "actuators.legs.friction.coulomb"
    assert (
        found.message
        == "the dry friction of 30 N*m is not below the effort limit of 20 N*m: the drive cannot move the joint"
    )
    assert found.help == (
        "is it in mN*m (0.03 N*m), or a dimensionless coefficient? Or is the limit wrong (s.yaml:4:80)?"
    )


@pytest.mark.parametrize(
    ("ratio", "more"),
    [
        ("{value: 0.5, sure: true}", ""),
        ("{value: 0.04, sure: true}", ""),
        ("0.5", "accept: {spec.SPEC182: a belt that gears up}"),
    ],
)
def test_a_number_is_kept(ratio: str, more: str) -> None:
    """By `sure: true` beside it, an error too, or by the check's code in `accept`."""
    text = spec_of(
        f"legs: {{joints: [hip], level: ideal_pd, kp: 9, kd: 1}}, {REST}",
        motors=f"{{m: {{gear_ratio: {ratio}}}}}",
        more=more,
    )
    assert codes(text) == []


def test_sure_keeps_the_number_that_is_told() -> None:
    """A number that somebody vouches for is a witness against the other, no reason for silence."""
    text = f"legs: {{joints: [hip], level: ideal_pd, kp: {{value: 1, KP}}, kd: {{value: 2, KD}}}}, {REST}"
    for at_kp, at_kd, expected in (
        ("sure: true", "sure: false", []),
        ("sure: false", "sure: true", ["SPEC192"]),
        ("sure: false", "sure: false", ["SPEC192"]),
        ("sure: true", "sure: true", []),
    ):
        assert codes(spec_of(text.replace("KP", at_kp).replace("KD", at_kd))) == expected


LIMITED = (
    "legs: {joints: [hip], motor: m, level: dc_motor, kp: 40, kd: 1, effort_limit: LIMIT, friction: FRICTION}"
)
OF_20 = "side: joint, stall_torque: 20, peak_torque: {value: 20, sure: true}, no_load_speed: SPEED"


@pytest.mark.parametrize("limit", ["{value: 20, sure: true}", "peak"])
@pytest.mark.parametrize(
    ("friction", "where"),
    [
        # 200 of 20 N*m; 1 x 30 = 30 of 20 N*m at the motor's speed.
        ("{coulomb: 200}", "coulomb"),
        ("{viscous: 1}", "viscous"),
        ("{coulomb: {value: 200, sure: true}}", None),
        ("{viscous: {value: 1, sure: true}}", None),
    ],
)
def test_a_number_is_held_to_one_that_is_sure(limit: str, friction: str, where: str | None) -> None:
    text = f"{LIMITED.replace('LIMIT', limit).replace('FRICTION', friction)}, {REST}"
    motor = f"{{m: {{{OF_20.replace('SPEED', '{value: 30 rad/s, sure: true}')}}}}}"
    found = said(spec_of(text, motors=motor))
    assert [item.where for item in found] == ([f"actuators.legs.friction.{where}"] if where else [])
    # Of the two the limit is right.
    assert not any(
        "limit wrong" in (item.help or "") or "no_load_speed" in (item.help or "") for item in found
    )


ARM = "side: motor, peak_torque: TORQUE, no_load_speed: 4500 rpm, gear_ratio: 2000, rotor_inertia: ROTOR"
"""60 x 2000 = 120 kN*m, which is more than any arm has; 60 / 0.0068 = 8824 rad/s^2; 0.236 rad/s."""
AXIS = "axis: {joints: [hip], motor: m, level: ideal_pd, kp: 1e6, kd: 4e4, effort_limit: peak"


@pytest.mark.parametrize("kept", ["sure", "accept"])
@pytest.mark.parametrize(
    ("rotor", "fields", "expected"),
    [
        ("0.0068", "", []),
        # 60 / 68 = 0.88 rad/s^2.
        ("68", "", ["motors.m.rotor_inertia"]),
        ("0.0068", "friction: {coulomb: 4e5}", ["actuators.axis.friction.coulomb"]),
        # 4e6 x 0.236 = 943 kN*m.
        ("0.0068", "friction: {viscous: 4e6}", ["actuators.axis.friction.viscous"]),
        ("0.0068", "velocity_limit: 115 rad/s", ["actuators.axis.velocity_limit"]),
    ],
)
def test_a_kept_size_hides_nothing(kept: str, rotor: str, fields: str, expected: list[str]) -> None:
    torque = "{value: 60, sure: true}" if kept == "sure" else "60"
    group = AXIS.replace("ideal_pd", "dc_motor").replace(
        "effort_limit: peak", "effort_limit: peak, " + fields
    )
    motor = ARM.replace("TORQUE", f"{torque}, stall_torque: {torque}").replace("ROTOR", rotor)
    text = spec_of(
        f"{group}}}, {REST}",
        motors=f"{{m: {{{motor}}}}}",
        more="accept: {spec.SPEC183: a slewing drive}" if kept == "accept" else "",
    )
    assert [item.where for item in said(text)] == expected


@pytest.mark.parametrize(
    ("reason", "kept"),
    [
        ("a wheel", True),
        # A tenth more is 209 rad/s.
        ("up to 190 rad/s at this wheel", True),
        ("up to 180 rad/s at this wheel", False),
        ("at most 20 N*m", False),
        ("at most 30 N*m, and up to 250 rad/s", True),
        ("up to 3 kg", True),
    ],
)
def test_a_bound_in_the_reason_holds_for_a_check(reason: str, kept: bool) -> None:
    """SPEC184 finds 201 rad/s of a motor of 25 N*m."""
    text = spec_of(
        f"legs: {{joints: [hip], motor: m, level: ideal_pd, kp: 9, kd: 1}}, {REST}",
        motors="{m: {side: joint, stall_torque: 25, no_load_speed: 201 rad/s}}",
        more=f'accept: {{spec.SPEC184: "{reason}"}}',
    )
    assert codes(text) == ([] if kept else ["SPEC184"])


def test_beside_a_size_that_is_told_only_what_follows_from_it_is_not() -> None:
    """The velocity limit is held to speed and gear, the dry friction to the torque that is told."""
    text = f"{AXIS}, velocity_limit: 115 rad/s, friction: {{coulomb: 4e5}}}}, {REST}"
    motor = f"{{m: {{{ARM.replace('TORQUE', '{value: 60, sure: false}').replace('ROTOR', '0.0068')}}}}}"
    found = said(spec_of(text, motors=motor))
    assert sorted(item.where for item in found) == ["actuators.axis.velocity_limit", "motors.m.peak_torque"]


def test_sure_is_true_or_false() -> None:
    with pytest.raises(ActspecError, match=r"legs\.kp\.sure: must be true or false, got yes"):
        fit(spec_of(f"legs: {{joints: [hip], level: ideal_pd, kp: {{value: 9, sure: yes}}, kd: 1}}, {REST}"))


def test_what_follows_from_a_wrong_number_is_not_reported_as_well() -> None:
    """The armature of a gear of 1/6 is 1300 times too small: one message, at the gear."""
    text = spec_of(
        f"legs: {{joints: [hip], level: ideal_pd, motor: m, kp: 9, kd: 1}}, {REST}",
        motors="{m: {side: joint, stall_torque: 20, gear_ratio: 0.1667, rotor_inertia: 1e-4}}",
    )
    assert codes(text) == ["SPEC182"]


@pytest.mark.parametrize(
    ("ratio", "more", "expected"),
    [
        ("0.8", "", ["SPEC182"]),
        ("{value: 0.8, sure: true}", "", []),
        ("0.8", "accept: {spec.SPEC182: a belt that gears up}", []),
        # A number that does not follow from the gear is judged as ever: 0.5 s of delay.
        ("{value: 0.8, sure: true}", "DELAY", ["SPEC186"]),
    ],
)
def test_what_follows_from_a_kept_number_is_kept(ratio: str, more: str, expected: list[str]) -> None:
    """90 N*m over 0.64 x 4e-5 = 2.56e-5 kg*m^2 are 3.5e6 rad/s^2, beyond 3e6 (SPEC191): what the gear makes of it."""
    delay = ", delay: 0.5 s" if more == "DELAY" else ""
    group = "level: ideal_pd, motor: m, kp: 400, kd: 25, effort_limit: 90"
    text = spec_of(
        f"legs: {{joints: [hip], {group}{delay}}}, {REST}",
        motors=f"{{m: {{side: joint, peak_torque: 90, gear_ratio: {ratio}, rotor_inertia: 4e-5}}}}",
        more="" if more == "DELAY" else more,
    )
    assert codes(text) == expected


def test_one_number_of_two_groups_is_one_message() -> None:
    """A motor of 2e-5 kg*m^2: 90 N*m would turn it with 4.5e6 rad/s^2, at hip and calf."""
    group = "level: ideal_pd, motor: m, kp: 400, kd: 25, effort_limit: 90"
    text = spec_of(
        f"a: {{joints: [hip], {group}}}, b: {{joints: [calf], {group}}}, "
        "rest: {joints: [slide], level: ideal_pd, kp: 1, kd: 1}",
        motors="{m: {gear_ratio: 1, rotor_inertia: 2e-5}}",
    )
    assert [(item.code, item.message[:11]) for item in said(text)] == [("SPEC191", "hip, calf: ")]


@pytest.mark.parametrize(
    ("others", "own", "odd"),
    [
        # 0.11 is 11 times 0.01, 0.00099 is 10.1 times below it.
        (("0.01", "0.011", "0.009"), "0.11", True),
        (("0.01", "0.011", "0.009"), "0.09", False),
        (("0.01", "0.011", "0.009"), "0.00099", True),
        (("0.01", "0.011", "0.009"), "0.0011", False),
        # They are not alike, or too few.
        (("0.01", "0.011", "0.0009"), "0.11", False),
        (("0.01", "0.011"), "0.11", False),
    ],
)
def test_an_armature_that_no_other_joint_of_its_group_has(
    others: tuple[str, ...], own: str, odd: bool, tmp_path: Path
) -> None:
    """Results of a log give one joint another power of ten; 20 N*m would turn 0.11 kg*m^2 with 182 rad/s^2."""
    joints = [f"j{n}" for n in range(len(others) + 1)]
    figures = zip(joints, (*others, own), strict=True)
    overrides = ", ".join(f"{joint}: {{armature: {value}}}" for joint, value in figures)
    names = ", ".join(f"{{name: {joint}}}" for joint in joints)
    spec = tmp_path / "s.yaml"
    spec.write_text(
        f"actspec: 1\nrobot: {{name: r, model: none, joints: [{names}]}}\nactuators:\n  legs:\n    joints: ['.*']\n"
        f"    level: ideal_pd\n    kp: 20\n    kd: 1\n    effort_limit: 20\n    overrides: {{{overrides}}}\n"
    )
    found = [item for item in api.resolve(spec).diagnostics if item.code in BY_CODE]
    assert [(item.code, item.message.partition(":")[0]) for item in found] == [("SPEC191", joints[-1])] * odd


@pytest.mark.parametrize("spec", sorted(path.name for path in ROBOTS.glob("*.yaml")))
def test_the_robot_library_is_sound(spec: str) -> None:
    assert [str(item) for item in api.resolve(ROBOTS / spec).diagnostics if item.code in BY_CODE] == []


def test_strict_refuses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """compile writes nothing and exits 1, validate exits 1; without --strict both warn."""
    spec = tmp_path / "s.yaml"
    spec.write_text(
        spec_of(
            f"legs: {{joints: [hip], level: ideal_pd, kp: 9, kd: 1}}, {REST}", motors="{m: {gear_ratio: 0.5}}"
        ),
        encoding="utf-8",
    )
    assert main(["validate", str(spec)]) == 0
    assert "s.yaml:3:26: SPEC182 [warning] motors.m.gear_ratio: 0.5 rotor turns" in capsys.readouterr().err
    assert main(["validate", "--strict", str(spec)]) == 1
    assert "--strict: 1 number that can hardly be right" in capsys.readouterr().err
    arguments = ["compile", str(spec), "-t", "mujoco", "-o", str(tmp_path / "out")]
    assert main([*arguments, "--strict"]) == 1
    assert 'accept: {spec.SPEC182: "the reason"}' in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    assert main(arguments) == 0


@pytest.mark.parametrize(("speed", "expected"), [("0.29 rad/s", []), ("0.31 rad/s", ["SPEC191"])])
def test_a_slow_drive_may_be_heavy(speed: str, expected: list[str]) -> None:
    """45 N*m of 30 kg*m^2 are 1.5 rad/s^2, and 0.3 rad/s after 0.2 s."""
    motor = f"side: joint, stall_torque: 45, no_load_speed: {speed}, reflected_inertia: 30"
    text = spec_of(
        f"legs: {{joints: [hip], motor: m, level: ideal_pd, kp: 30, kd: 3}}, {REST}",
        motors=f"{{m: {{{motor}}}}}",
    )
    assert codes(text) == expected


@pytest.mark.parametrize(
    ("fields", "help"),
    [
        ("randomize: {kd: {scale: [0.9, 11]}}", "did you mean 1.1?"),
        # 8 and 1.2 were the wrong way round.
        ("randomize: {kd: {scale: [8, 12]}}", "did you mean 0.8 and 1.2?"),
        ("randomize: {kd: {scale: [90, 110]}}", "is it in %? Then write 0.9 and 1.1"),
        ("encoder_bias: 1 rad", "is it in degrees? Then write 1 deg"),
        # 15 deg are no encoder's error either, 15 arcmin are 0.25 deg.
        ("encoder_bias: 15 rad", "is it in arcmin? Then write 15 arcmin"),
        ("encoder_bias: 60 deg", None),
        # 14.3 x 0.0174533 = 0.249582.
        ("action_scale: 14.3", "is it in degrees? Then write 0.249582"),
        # 70 of 4 pi: 5.6 times.
        ("action_scale: 70", "is it in degrees? Then write 1.22173; or is it in %? Then write 0.7"),
        # 9 x 0.7 = 6.3 of 25.2 N*m is a quarter, which mjlab's scales are; 9 x 1.222 = 11 is 0.44.
        (
            "action_scale: 70, effort_limit: 25.2",
            "is it in %? Then write 0.7; or is it in degrees? Then write 1.22173",
        ),
    ],
)
def test_what_was_meant(fields: str, help: str | None) -> None:
    (found,) = said(spec_of(f"legs: {{joints: [hip], level: ideal_pd, kp: 9, kd: 1, {fields}}}, {REST}"))
    assert found.help == help


def test_the_page_lists_every_check() -> None:
    """docs/checks.md has a row a check, in the words of the table."""
    page = (ROBOTS.parent / "docs" / "checks.md").read_text(encoding="utf-8")
    for check in CHECKS:
        assert re.search(rf"\| \[?{check.code}(\]\(.*\))? \| {re.escape(check.judges)} \|", page)


def test_every_check_is_explained(capsys: pytest.CaptureFixture[str]) -> None:
    """`actspec rule` prints a check by its code or name, and the rule of the same code as well."""
    assert main(["rule", *(check.code for check in CHECKS)]) == 0
    text = capsys.readouterr().out
    for check in CHECKS:
        assert f"# {check.code} {check.name}\n" in text and check.because in text
    assert main(["rule", "rotor-inertia"]) == 0
    assert capsys.readouterr().out.startswith("# SPEC185 rotor-inertia\n")


@pytest.mark.parametrize(
    ("joint", "told", "help"),
    [
        # 180 / 6.283 = 28.6 turns; 50 rad are 7.96 of them, 25 rad 3.98.
        (
            "{name: hip, range: [-90 rad, 90 rad]}",
            "-90 rad to 90 rad is 28.6 turns wide",
            "[-90 deg, 90 deg]",
        ),
        ("{name: hip, range: [-20 rad, 30 rad]}", "is 7.96 turns wide", "[-20 deg, 30 deg]"),
        ("{name: hip, range: [-12.5 rad, 12.5 rad]}", None, None),
        ("{name: hip, range: [-90 deg, 90 deg]}", None, None),
        # More than a turn in degrees, too, as of a winch; a placeholder; what is in degrees already.
        ("{name: hip, range: [0 rad, 400 rad]}", None, None),
        ("{name: hip, range: [-100 rad, 100 rad]}", None, None),
        ("{name: hip, range: [0 deg, 3600 deg]}", None, None),
        ("{name: hip, kind: slide, range: [0 m, 400 m]}", "0 m to 400 m is 400 m wide", "[0 mm, 400 mm]"),
        ("{name: hip, kind: slide, range: [0 m, 20 m]}", None, None),
        ("{name: hip, kind: slide, range: [0 mm, 30000 mm]}", None, None),
    ],
)
def test_a_range_of_a_listed_joint(joint: str, told: str | None, help: str | None) -> None:
    slides = "slide" in joint
    text = (
        f"actspec: 1\nrobot: {{name: leg, model: none, joints: [{joint}]}}\n"
        f"actuators: {{a: {{joints: [hip], level: ideal_pd, kp: {'9 N/m' if slides else 9}, "
        f"kd: {'1 N*s/m' if slides else 1}}}}}\n"
    )
    found = [
        item for item in validate(document_from_text(text, "s.yaml")).diagnostics if item.code in BY_CODE
    ]
    if told is None:
        assert found == []
        return
    (one,) = found
    assert (one.code, one.where) == ("SPEC190", "robot.joints[0].range")
    assert one.message.endswith(told)
    assert one.help == f"is it in {'mm' if slides else 'degrees'}? Then write {help}"
