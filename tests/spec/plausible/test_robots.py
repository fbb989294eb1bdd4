"""Limits by those of the robot's other joints, a servo's time for its speed, and a gear that makes a leg slow."""

from __future__ import annotations

import pytest

from actspec.diagnostics import ActspecError
from actspec.spec.plausible import BY_CODE
from tests.fitting import fit, spec_of


def told(text: str, model: str | None = None) -> list[tuple[str, str, str, str]]:
    """Code, place, message and help of what the checks report."""
    try:
        found = fit(text, model).diagnostics
    except ActspecError as err:
        found = err.diagnostics
    return [(item.code, item.where, item.message, item.help or "") for item in found if item.code in BY_CODE]


def two(hip: str, calf: str = "effort_limit: 245, kp: 700, kd: 15", motors: str = "{}") -> str:
    """Two hinges, each of a group of its own."""
    return spec_of(
        f"hips: {{joints: [hip], level: ideal_pd, {hip}}}, calves: {{joints: [calf], level: ideal_pd, {calf}}}, "
        "rest: {joints: [slide], level: ideal_pd, kp: 1, kd: 1}",
        motors=motors,
    )


@pytest.mark.parametrize(
    ("hip", "calf", "odd"),
    [
        ("effort_limit: 245, kp: 700, kd: 15", "effort_limit: 245, kp: 700, kd: 15", False),
        ("effort_limit: 2450, kp: 700, kd: 15", "effort_limit: 245, kp: 700, kd: 15", True),
        # 8 x 245 = 1960 N*m, and 1960 / 3 = 653 N*m/rad.
        ("effort_limit: 1960, kp: 653, kd: 15", "effort_limit: 245, kp: 700, kd: 15", True),
        ("effort_limit: 1955, kp: 651, kd: 15", "effort_limit: 245, kp: 700, kd: 15", False),
        ("effort_limit: 1960, kp: 654, kd: 15", "effort_limit: 245, kp: 700, kd: 15", False),
        # 700 N*m are published; powers of ten are placeholders; of one joint alone nothing is said.
        ("effort_limit: 699, kp: 200, kd: 5", "effort_limit: 40, kp: 20, kd: 1", False),
        ("effort_limit: 701, kp: 200, kd: 5", "effort_limit: 40, kp: 20, kd: 1", True),
        ("effort_limit: 1000, kp: 200, kd: 5", "effort_limit: 40, kp: 20, kd: 1", False),
        ("effort_limit: 2450, kp: 700, kd: 15", "kp: 700, kd: 15", False),
    ],
)
def test_an_effort_limit_far_above_those_of_the_robot(hip: str, calf: str, odd: bool) -> None:
    assert [item[:2] for item in told(two(hip, calf))] == [("SPEC183", "actuators.hips.effort_limit")] * odd


def test_what_is_said_of_such_a_limit() -> None:
    ((_, _, message, help),) = told(two("effort_limit: 2450, kp: 700, kd: 15"))
    assert message == (
        "hip: an effort limit of 2450 N*m is 10 times that of every other hinge, at most 245 N*m, and kp 700 N*m/rad "
        "asks for it at an error of 3.5 rad"
    )
    assert help == "did you mean 245 N*m?"
    assert told(two("effort_limit: {value: 2450, sure: true}, kp: 700, kd: 15")) == []


def test_of_a_cylinder_the_lever_arm_is_named() -> None:
    """5000 N x 50 mm = 250 N*m, and x 500 mm 2500."""
    cylinder = "{m: {side: joint, peak_torque: 5000 N, reflected_inertia: 0.8 kg}}"
    hip = "motor: m, transmission: [{lever_arm: ARM}], effort_limit: peak, kp: 700, kd: 15"
    assert told(two(hip.replace("ARM", "50 mm"), motors=cylinder)) == []
    ((code, where, _, help),) = told(two(hip.replace("ARM", "500 mm"), motors=cylinder))
    assert (code, where) == ("SPEC183", "actuators.hips.transmission[0].lever_arm")
    assert help == (
        "one of 2 numbers is wrong. lever_arm: did you mean 50 mm? Or the motor's torque (s.yaml:3:40): look for a "
        "wrong unit or power of ten"
    )


@pytest.mark.parametrize(
    ("hip", "calf", "help"),
    [
        ("12 rad/s", "12 rad/s", None),
        # 0.209 rad/s.
        ("12 deg/s", "12 rad/s", "did you mean 12 rad/s?"),
        ("12 deg/s", "11 rad/s", None),
        ("12 deg/s", "12 deg/s", None),
        # 60 deg/s are 1.05 rad/s.
        ("60 deg/s", "60 rad/s", None),
        ("9 rpm", "9 rad/s", "did you mean 9 rad/s?"),
        ("10 rpm", "10 rad/s", None),
        ("{value: 12 deg/s, sure: true}", "12 rad/s", None),
        # About the other's, in three digits that nobody chooses; 2.61 rpm are 0.273 rad/s, 8 times below it.
        ("2.61 deg/s", "2.175 rad/s", "did you mean 2.61 rad/s?"),
        ("2.61 rpm", "2.175 rad/s", "did you mean 2.61 rad/s?"),
        ("2.6 deg/s", "2.175 rad/s", None),
        ("2.61 deg/s", "125 deg/s", None),
        ("2.61 deg/s", "3.5 rad/s", None),
    ],
)
def test_a_velocity_limit_by_the_number_of_another_joint(hip: str, calf: str, help: str | None) -> None:
    own = "effort_limit: 245, kp: 700, kd: 15, velocity_limit: {}"
    found = told(two(own.format(hip), own.format(calf)))
    assert [(item[0], item[1], item[3]) for item in found] == (
        [("SPEC184", "actuators.hips.velocity_limit", help)] if help else []
    )


@pytest.mark.parametrize(
    ("speed", "limit", "odd"),
    [
        # 180 deg/s are 3.142 rad/s; 3 deg/s may be a choice.
        ("180 deg/s", "3.14 deg/s", True),
        ("180 deg/s", "180 deg/s", False),
        ("180 deg/s", "3 deg/s", False),
        ("9 rad/s", "9 rpm", True),
        ("9 rad/s", "{value: 9 rpm, sure: true}", False),
    ],
)
def test_a_velocity_limit_by_the_number_of_its_motor(speed: str, limit: str, odd: bool) -> None:
    own = f"motor: m, effort_limit: peak, kp: 700, kd: 15, velocity_limit: {limit}"
    motors = f"{{m: {{side: joint, peak_torque: 245, no_load_speed: {speed}, gear_ratio: 100}}}}"
    found = told(two(own, motors=motors))
    assert [item[:2] for item in found] == [("SPEC184", "actuators.hips.velocity_limit")] * odd
    assert all("the motor 'm' ends at" in item[2] for item in found)


AX12 = (
    "side: joint, stall_torque: 1.5, no_load_speed: SPEED, gear_ratio: 254, nominal_voltage: 12 V, "
    "rotor_inertia: 4e-8"
)


@pytest.mark.parametrize(
    ("old", "new", "odd"),
    [
        # 4e-8 x 254^2 = 2.58e-3 kg*m^2: 10.6 ms to 59 rpm.
        ("SPEED", "59 rpm", False),
        # 0.34 ms to 0.196 rad/s; 0.52 ms with 6.2e-8, and not of 24 V.
        ("SPEED", "0.196 rad/s", True),
        ("4e-8", "5.8e-8", True),
        ("4e-8", "6.2e-8", False),
        ("12 V", "24 V", False),
        ("12 V", "14.8 V", True),
        (", rotor_inertia: 4e-8", "", False),
    ],
)
def test_a_servos_time_for_60_degrees_beside_its_gear(old: str, new: str, odd: bool) -> None:
    motor = AX12.replace(old, new).replace("SPEED", "0.196 rad/s")
    found = told(two("motor: m, kp: 15, kd: 0.3", motors=f"{{m: {{{motor}}}}}"))
    assert [item[:2] for item in found] == [("SPEC184", "motors.m.no_load_speed")] * odd
    assert all(
        "in s per 60 deg, as sheets of servos have it? Then it is 5.34 rad/s" in item[3] for item in found
    )


LEG = """<mujoco><compiler angle="radian"/><worldbody><body>
<joint name="hip" axis="0 1 0" range="-1 0.5"/><inertial pos="0 0 0" mass="1" diaginertia="1 0.1 1"/></body>
</worldbody></mujoco>"""


@pytest.mark.parametrize(
    ("gear", "gains", "odd"),
    [
        # 1e-4 x 110^2 = 1.21 kg*m^2, 12 times the links; 99 N*m / 20 = 4.95 rad; sqrt(20 / 1.31) = 3.9 rad/s.
        (110, "kp: 20, kd: 1", True),
        # 4.0 rad; 0.1 s; 6 rad/s are 47 N*m/rad; 0.98 kg*m^2.
        (110, "kp: 25, kd: 1", False),
        (110, "kp: 20, kd: 2.1", False),
        (99, "kp: 20, kd: 1", False),
    ],
)
def test_a_gear_that_is_hardly_the_links(gear: int, gains: str, odd: bool) -> None:
    text = spec_of(
        f"legs: {{joints: [hip], motor: m, level: ideal_pd, effort_limit: peak, {gains}}}",
        robot="name: leg, model: leg.xml",
        motors=f"{{m: {{side: motor, gear_ratio: {gear}, peak_torque: 0.9, rotor_inertia: 1e-4}}}}",
    )
    found = told(text, LEG)
    assert [item[:2] for item in found] == [("SPEC192", "actuators.legs.kp")] * odd
    assert all(
        item[3].startswith("is a gear too large (s.yaml:3:39)? 1.21 kg*m^2 of the inertia is")
        for item in found
    )


SHANK = """<mujoco><compiler angle="radian"/><worldbody><body>
<joint name="hip" axis="0 1 0" range="-1 0.5"LIMIT/><inertial pos="0 0 0" mass="0.1" diaginertia="1 27e-5 1"/></body>
</worldbody></mujoco>"""


@pytest.mark.parametrize(
    ("gear", "limit", "odd"),
    [
        # Of a Solo's 9: 4.5e-6 x 90^2 = 0.03645 kg*m^2 beside 0.00027, 27 N*m / 3 = 9 rad; sqrt(3 / 0.0367) = 9 rad/s.
        (90, "", True),
        # 3.9 rad at 20 rad/s; and what the robot's file has as well.
        (39, "", False),
        (90, ' actuatorfrcrange="-27 27"', False),
    ],
)
def test_a_leg_that_is_hardly_more_than_its_rotor(gear: int, limit: str, odd: bool) -> None:
    text = spec_of(
        "legs: {joints: [hip], motor: m, level: ideal_pd, effort_limit: peak, kp: 3, kd: 0.1}",
        robot="name: leg, model: leg.xml",
        motors=f"{{m: {{side: motor, gear_ratio: {gear}, peak_torque: 0.3, rotor_inertia: 4.5e-6}}}}",
    )
    found = told(text, SHANK.replace("LIMIT", limit))
    assert [item[:2] for item in found] == [("SPEC192", "actuators.legs.kp")] * odd
    assert all(item[3].startswith("is a gear too large (s.yaml:3:39)? 0.03645 kg*m^2 of") for item in found)
