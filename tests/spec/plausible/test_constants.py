"""Torque constants of another side, of a phase, or a Kv in their place: currents and voltage tell which."""

from __future__ import annotations

import pytest

from tests.spec.plausible.test_sheets import AK80, said

EC90 = """actspec: 1
robot: {name: leg, model: none, joints: [hip, knee]}
motors:
  m:
    side: motor
    gearbox: [{planetary: {sun: 18, ring: 90}, efficiency: 0.9}]
    stall_torque: 4940 mN*m
    continuous_torque: 444 mN*m
    peak_torque: 1.4 N*m
    no_load_speed: 3190 rpm
    torque_constant: 70.5 mN*m/A
    nominal_voltage: 24 V
    nominal_current: 6.06 A
    peak_current: 20 A
    rotor_inertia: 3060 g*cm^2
actuators:
  legs: {joints: [hip, knee], motor: m, level: dc_motor, kp: 20, kd: 0.6}
"""
TORQUES = [("    continuous_torque: 444 mN*m\n", ""), ("    peak_torque: 1.4 N*m\n", "")]
OUTPUT = "is it quoted at the gearbox output? At the rotor it is 0.0705 N*m/A"
TENTH = "is it in kgf*cm/A? 0.705 kgf*cm/A is 0.06914 N*m/A; or did you mean 0.0705 N*m/A?"
PHASE = "is it that of a phase, and the currents and voltage of two terminals, or the other way round? "
PHASE += "With those it is "


@pytest.mark.parametrize(
    ("constant", "torques", "help"),
    [
        ("70.5 mN*m/A", True, None),
        ("70.5 mN*m/A", False, None),
        # 70.5 x 6; 24 V over 334 rad/s are 0.0718 N*m/A.
        ("423 mN*m/A", True, OUTPUT),
        ("423 mN*m/A", False, OUTPUT),
        # Ten times as much through the gear would be 0.1175.
        ("705 mN*m/A", True, TENTH),
        ("705 mN*m/A", False, TENTH),
        # 1 / 0.0705 rad/s/V; a hundred times 1.41 is twice what all of them make.
        ("14.1 mN*m/A", True, "is it Kv, in rad/s/V? Then the constant is 1 / Kv, 0.0709 N*m/A"),
        ("14.1 mN*m/A", False, "is it Kv, in rad/s/V? Then the constant is 1 / Kv, 0.0709 N*m/A"),
        # The root of three: 1.67, 1.74 and 1.70 of the three pairs, which two of them alone do not tell.
        ("122 mN*m/A", True, f"{PHASE}0.0704 N*m/A"),
        ("40.7 mN*m/A", True, f"{PHASE}0.0705 N*m/A"),
        ("122 mN*m/A", False, None),
        # 1.5 either way, and 2.2, are no phase's.
        ("106 mN*m/A", True, None),
        ("47 mN*m/A", True, None),
        ("160 mN*m/A", True, None),
    ],
)
def test_what_a_torque_constant_is_by_currents_and_voltage(
    constant: str, torques: bool, help: str | None
) -> None:
    changes = [("torque_constant: 70.5 mN*m/A", f"torque_constant: {constant}")]
    found = said(EC90, *changes, *([] if torques else TORQUES))
    assert [(item.code, item.where) for item in found] == [("SPEC181", "motors.m.torque_constant")] * bool(
        help
    )
    assert all(item.help == help for item in found)


def test_an_inertia_of_a_sheet_in_square_millimetres() -> None:
    """607 g*cm^2 of 2 N*m at the rotor; in g*mm^2 it is a hundredth, which three torques in kgf*cm would explain."""
    (found,) = said(AK80, ("607 g*cm^2", "607 g*mm^2"))
    assert (found.code, found.where) == ("SPEC185", "motors.ak80_9.rotor_inertia")
    assert found.help == "is it in g*cm^2? 607 g*cm^2 is 6.07e-05 kg*m^2"
