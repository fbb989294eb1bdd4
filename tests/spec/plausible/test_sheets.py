"""Datasheets of motors as people retype them, one slip in each: told once, at its line, with a figure that is right."""

from __future__ import annotations

import re

import pytest

from actspec.diagnostics import ActspecError, Diagnostic
from actspec.spec.plausible import BY_CODE
from tests.fitting import faults_of, fit

LEGS = [f"{side}_{part}" for side in ("fl", "fr", "hl", "hr") for part in ("abad", "hip", "knee")]

AK80 = """actspec: 1
robot: {name: dog, ROBOT}
motors:
  ak80_9:
    side: joint
    gear_ratio: 9
    peak_torque: 18 N*m
    continuous_torque: 9 N*m
    no_load_speed: 570 rpm
    stall_torque: 28.5 N*m
    torque_constant: 0.945 N*m/A
    nominal_current: 12 A
    peak_current: 24 A
    nominal_voltage: 48 V
    rotor_inertia: 607 g*cm^2
actuators:
  legs:
    joints: [".*"]
    motor: ak80_9
    level: dc_motor
    kp: 30 N*m/rad
    kd: 0.8 N*m*s/rad
    effort_limit: peak
""".replace("ROBOT", f"model: none, joints: {LEGS}")
"""Its stall torque is that of the line through 9 N*m at 390 rpm."""

MAXON = """actspec: 1
robot: {name: leg, model: none, joints: [hip, knee]}
motors:
  m:
    side: motor
    nominal_voltage: 24 V
    no_load_speed: 3190 rpm
    continuous_torque: 444 mN*m
    nominal_current: 6.06 A
    stall_torque: 4940 mN*m
    peak_torque: 1500 mN*m
    peak_current: 21 A
    torque_constant: 70.5 mN*m/A
    rotor_inertia: 3060 g*cm^2
    gear_ratio: 26
    efficiency: 0.83
actuators:
  legs: {joints: [hip, knee], motor: m, level: dc_motor, kp: 40, kd: 1, effort_limit: peak}
"""

SERVO = """actspec: 1
robot: {name: leg, model: none, joints: [hip, knee]}
motors:
  m: {side: joint, no_load_speed: 9.5 rad/s, stall_torque: 35 kgf*cm, reflected_inertia: unknown}
actuators:
  legs: {joints: [hip, knee], motor: m, level: dc_motor, kp: 10, kd: 0.2}
"""
"""3.43 N*m, which kp asks for at 0.343 rad."""

SLIDES = """actspec: 1
robot: {name: lift, model: none, joints: [{name: lift, kind: slide}, {name: reach, kind: slide}, roll]}
motors:
  screw:
    side: motor
    no_load_speed: 3500 rpm
    stall_torque: 3.9 N*m
    continuous_torque: 1.27 N*m
    rotor_inertia: 0.6 kg*cm^2
    gearbox: [{lead: 10 mm/rev, efficiency: 0.9}]
  belt:
    side: motor
    no_load_speed: 3500 rpm
    stall_torque: 1.2 N*m
    continuous_torque: 0.4 N*m
    rotor_inertia: 0.2 kg*cm^2
    gearbox: [{planetary: {sun: 18, ring: 54}}, {radius: 20 mm, efficiency: 0.95}]
  roll:
    side: motor
    no_load_speed: 3000 rpm
    stall_torque: 0.3 N*m
    rotor_inertia: 60 g*cm^2
    gearbox: [{teeth: {driving: 15, driven: 60}}, {ratio: 10, efficiency: 0.8}]
actuators:
  lift: {joints: [lift], motor: screw, level: dc_motor, kp: 20000 N/m, kd: 800 N*s/m, friction: {viscous: 40 N*s/m}}
  reach: {joints: [reach], motor: belt, level: dc_motor, kp: 3000 N/m, kd: 120 N*s/m, friction: {viscous: 10 N*s/m}}
  roll: {joints: [roll], motor: roll, level: dc_motor, kp: 10, kd: 0.3, friction: {viscous: 0.01 N*m*s/rad}}
"""
"""3.9 N*m x 2 pi / 10 mm x 0.9 = 2205 N; 1.2 N*m x 4 / 20 mm x 0.95 = 228 N, at 1.83 m/s."""


def said(text: str, *changes: tuple[str, str], model: str | None = None) -> list[Diagnostic]:
    """What the checks of numbers report of a spec with these changes, each of which occurs in it."""
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    try:
        found = fit(text, model).diagnostics
    except ActspecError as err:
        found = err.diagnostics
    return [item for item in found if item.code in BY_CODE]


def dog(effort: float) -> tuple[str, str]:
    """The AK80's robot as an MJCF whose joints have an effort limit: the spec and the model."""
    joints = "".join(
        f'<body><joint name="{name}" actuatorfrcrange="-{effort} {effort}"/><geom size="0.1" mass="1"/></body>'
        for name in LEGS
    )
    text = AK80.replace(f"model: none, joints: {LEGS}", "model: robot.xml")
    return text, f"<mujoco><worldbody>{joints}</worldbody></mujoco>"


def test_sound_sheets() -> None:
    for text in (AK80, MAXON, SERVO, SLIDES):
        assert said(text) == []
    spec, model = dog(18)
    assert said(spec, model=model) == []


LIMIT = "    effort_limit: peak\n"
TWICE = (
    "is the gear counted twice? Then remove this: reduction is turns of the motor's output in one of the joint, "
    "behind its own gear"
)
STAGES = (
    "is the gear counted twice? Then remove this: transmission is the stages from the motor's output to the joint, "
    "behind its own gear"
)
ONE = "did you mean 1? motors_per_joint is how many motors drive one joint together"


@pytest.mark.parametrize("effort", [None, 18])
@pytest.mark.parametrize(
    ("line", "help"),
    [
        ("reduction: 9", TWICE),
        ("reduction: 9.05", TWICE),
        ("transmission: [{ratio: 9}]", STAGES),
        ("transmission: [{ratio: 3}, {ratio: 3}]", STAGES),
        ("motors_per_joint: 12", ONE),
    ],
)
def test_what_multiplies_the_motor(line: str, help: str, effort: float | None) -> None:
    """12 motors of the robot's 12 joints; with a limit in the robot's file that one is beside it."""
    spec, model = (AK80, None) if effort is None else dog(effort)
    (found,) = said(spec, (LIMIT, f"{LIMIT}    {line}\n"), model=model)
    assert found.where == f"actuators.legs.{line.partition(':')[0]}"
    assert found.help == help


@pytest.mark.parametrize(
    "line",
    [
        *("reduction: 1.5", "reduction: 8", "motors_per_joint: 2", "motors_per_joint: 4"),
        *("transmission: [{ratio: 1.5}]", "transmission: [{planetary: {sun: 10, ring: 80}}]"),
    ],
)
def test_what_may_multiply_it(line: str) -> None:
    """A reduction of another size, and as many motors as no group has joints."""
    assert said(AK80, (LIMIT, f"{LIMIT}    {line}\n")) == []


def test_more_motors_than_any_joint_has() -> None:
    (found,) = said(AK80, (LIMIT, f"{LIMIT}    motors_per_joint: 50\n"))
    assert (found.code, found.where) == ("SPEC182", "actuators.legs.motors_per_joint")
    assert found.message == "50 motors 'ak80_9' drive one joint, and 600 the 12 joints of legs"


def test_the_file_says_that_the_gear_stands_twice() -> None:
    """18 x 9 = 162 N*m, which the robot's file has."""
    spec, model = dog(162)
    assert said(spec, (LIMIT, f"{LIMIT}    reduction: 9\n"), model=model) == []


def test_a_reduction_before_gains_that_are_sound() -> None:
    """18 N*m x 90 = 1620 N*m, 54 rad by kp; without the reduction 0.6 rad."""
    (found,) = said(AK80, (LIMIT, f"{LIMIT}    reduction: 90\n"))
    assert (found.code, found.where) == ("SPEC192", "actuators.legs.reduction")
    assert found.message.endswith("for the effort limit of 1620 N*m, 90 times what the motor gives")
    assert "Or kp (" in (found.help or "")


@pytest.mark.parametrize(
    ("group", "changes", "help"),
    [
        (
            "lift",
            [("20000 N/m", "20 N/m"), ("800 N*s/m", "0.8 N*s/m")],
            "are kp and kd per mm? Per metre they are 20000 N/m and 800 N*s/m",
        ),
        (
            "reach",
            [("3000 N/m", "3 N/m"), ("120 N*s/m", "0.12 N*s/m")],
            "are kp and kd per mm? Per metre they are 3000 N/m and 120 N*s/m",
        ),
    ],
)
@pytest.mark.parametrize("limit", ["", "effort_limit: peak, ", "effort_limit: continuous, "])
def test_gains_per_mm_beside_a_motor(
    group: str, changes: list[tuple[str, str]], help: str, limit: str
) -> None:
    """By the force that the motor gives behind its screw or belt, without a limit that is written."""
    stated = (f"{group}: {{joints", f"{group}: {{{limit}joints")
    assert said(SLIDES, stated) == []
    (found,) = said(SLIDES, stated, *changes)
    assert (found.code, found.where, found.help) == ("SPEC192", f"actuators.{group}.kp", help)


@pytest.mark.parametrize("viscous", [True, False])
@pytest.mark.parametrize(
    ("change", "code", "where", "help"),
    [
        (
            ("driving: 15, driven: 60", "driving: 60, driven: 15"),
            "SPEC182",
            "motors.roll.gearbox[0].teeth",
            "are driving and driven swapped?",
        ),
        # 3500 rpm x 0.1 m: 5.83 m/s, of 2.5 that fast screws reach.
        (("10 mm/rev", "100 mm/rev"), "SPEC184", "motors.screw.gearbox[0].lead", "did you mean 10 mm/rev?"),
    ],
)
def test_a_stage_and_not_the_friction(
    change: tuple[str, str], code: str, where: str, help: str, viscous: bool
) -> None:
    """With such a stage right friction takes the limit: it is not what is told."""
    rub = [(f", friction: {{viscous: {size}}}", "") for size in ("40 N*s/m", "10 N*s/m", "0.01 N*m*s/rad")]
    (found,) = said(SLIDES, change, *([] if viscous else rub))
    assert (found.code, found.where, found.help) == (code, where, help)


def test_a_stage_and_not_the_friction_by_a_stated_limit() -> None:
    """0.04 N*m*s/rad x 125.7 rad/s = 5 N*m, more than three times 1.5 N*m."""
    limit = ("roll, level: dc_motor", "roll, level: ideal_pd, effort_limit: 1.5 N*m")
    stated = limit, ("0.01 N*m*s", "0.04 N*m*s")
    assert said(SLIDES, *stated) == []
    (found,) = said(SLIDES, *stated, ("driving: 15, driven: 60", "driving: 60, driven: 15"))
    assert found.where == "motors.roll.gearbox[0].teeth"


def test_a_stage_of_about_one() -> None:
    assert said(SLIDES, ("driving: 15, driven: 60", "driving: 20, driven: 17")) == []


def test_friction_names_the_pulley() -> None:
    """10 N*s/m x 18.33 m/s = 183 N of 22.8 N; behind 2 cm 18.3 of 228 N."""
    (found,) = said(SLIDES, ("20 mm", "20 cm"))
    assert (found.code, found.where) == ("FRC106", "motors.belt.gearbox[1].radius")
    assert (found.help or "").startswith("one of 2 numbers is wrong. radius: did you mean 2 cm? Or viscous (")


@pytest.mark.parametrize(
    ("text", "changes", "code", "where", "help"),
    [
        # 70.5 mN*m/A x 70 A = 4.935 N*m; 1500 mN*m is 21.28 A.
        (
            MAXON,
            [("peak_current: 21 A", "peak_current: 70 A")],
            "SPEC181",
            "motors.m.peak_current",
            "is it the stall current? It gives stall_torque by torque_constant, and peak_torque is that of 21.28 A",
        ),
        (
            AK80,
            [("12 A", "120 A"), ("24 A", "240 A")],
            "SPEC181",
            "motors.ak80_9.nominal_current",
            "are nominal_current and peak_current 10 times too large? Then peak_current is 24 A",
        ),
        # 0.444 N*m / 0.0705 N*m/A = 6.298 A, and 5.38 A, ten times it, is not that.
        (
            MAXON,
            [("6.06 A", "0.538 A")],
            "SPEC181",
            "motors.m.nominal_current",
            "torque_constant and continuous_torque give 6.298 A: is it the current without load?",
        ),
        (MAXON, [("6.06 A", "60.6 A")], "SPEC181", "motors.m.nominal_current", "did you mean 6.06 A?"),
        # 60 / (2 pi 135) = 0.0707; by each of three pairs 0.135 is 1.9 times too much.
        (
            MAXON,
            [("70.5 mN*m/A", "135 mN*m/A")],
            "SPEC181",
            "motors.m.torque_constant",
            "is it Kv, in rpm/V? Then the constant is 60 / (2 pi Kv), 0.0707 N*m/A",
        ),
        (
            MAXON,
            [("mN*m", "N*m")],
            "SPEC183",
            "motors.m.peak_torque",
            "are stall_torque, peak_torque, continuous_torque, torque_constant in mN*m? 4940 mN*m is 4.94 N*m; "
            "`sure: true` beside it keeps a number that is right",
        ),
        (
            MAXON,
            [("3060 g*cm^2", "3060 kg*mm^2")],
            "SPEC185",
            "motors.m.rotor_inertia",
            "is it in g*cm^2? 3060 g*cm^2 is 0.000306 kg*m^2",
        ),
        # 18 N*m x 9.
        (
            AK80,
            [("effort_limit: peak", "effort_limit: 162 N*m")],
            "SPEC187",
            "actuators.legs.effort_limit",
            "is the gear counted twice? Once it is 18 N*m",
        ),
        # 0.945 N*m/A x 9: a tenth and a ninth do as well.
        (
            AK80,
            [("0.945 N*m/A", "8.505 N*m/A")],
            "SPEC181",
            "motors.ak80_9.torque_constant",
            "is it in kgf*cm/A? 8.505 kgf*cm/A is 0.8341 N*m/A; or did you mean 0.8505 N*m/A? Or is the gear in it "
            "twice? Then it is 0.945 N*m/A",
        ),
        (
            AK80,
            [("gear_ratio: 9", "gear_ratio: 80")],
            "SPEC185",
            "motors.ak80_9.gear_ratio",
            "did you mean 9, the other number of 'ak80_9'?",
        ),
    ],
)
def test_one_line_of_a_sheet(
    text: str, changes: list[tuple[str, str]], code: str, where: str, help: str
) -> None:
    (found,) = said(text, *changes)
    assert (found.code, found.where, found.help) == (code, where, help)


REACTION = """
actspec: 1
robot: {name: wheel, model: none, joints: [hip]}
motors: {m: {SHEET}}
actuators: {legs: {joints: [hip], motor: m, level: dc_motor, command: effort}}
"""
EC45 = (
    "side: motor, gear_ratio: 1, nominal_voltage: 24 V, no_load_speed: 6110 rpm, stall_torque: 1460 mN*m, "
    "continuous_torque: 128 mN*m, torque_constant: 36.9 mN*m/A, nominal_current: 3.21 A, rotor_inertia: 181 g*cm^2"
)
"""Of a maxon EC 45 flat: its speed constant is 259 rpm/V, its current without load 0.234 A."""
HUB = (
    "side: joint, gear_ratio: 1, stall_torque: 16 N*m, peak_torque: 9 N*m, no_load_speed: 560 rpm, "
    "nominal_voltage: 36 V, torque_constant: 0.61 N*m/A, peak_current: 15 A"
)
T4004 = (
    "side: motor, gear_ratio: 9, torque_constant: 0.025 N*m/A, peak_current: 12 A, nominal_current: 4 A, "
    "no_load_speed: 7200 rpm, nominal_voltage: 24 V, rotor_inertia: 4.1e-6 kg*m^2"
)
"""Of a motor of 300 rpm/V."""


@pytest.mark.parametrize("sheet", [EC45, HUB, T4004])
def test_sheets_with_a_voltage_are_sound(sheet: str) -> None:
    assert said(REACTION.replace("SHEET", sheet)) == []


@pytest.mark.parametrize(
    ("sheet", "change", "where", "help"),
    [
        # 0.0369 N*m/A x 259 rpm/V are 1.0008 of a volt a volt.
        (
            EC45,
            ("6110 rpm", "259 rpm"),
            "no_load_speed",
            "is it Kv? 259 rpm/V x 24 V is 6216 rpm (650.9 rad/s)",
        ),
        (
            HUB,
            ("560 rpm", "15.6 rpm"),
            "no_load_speed",
            "is it Kv? 15.6 rpm/V x 36 V is 561.6 rpm (58.81 rad/s)",
        ),
        # By `side: joint` 0.225 N*m/A x 31.4 rad/s would be 7.1 V of 24.
        (
            T4004,
            ("7200 rpm", "300 rpm"),
            "no_load_speed",
            "is it Kv? 300 rpm/V x 24 V is 7200 rpm (754 rad/s)",
        ),
        # 0.61 x 58.64 = 35.8 V of 36, and x 56 34.2 V.
        (
            HUB,
            ("560 rpm", "56 rpm"),
            "no_load_speed",
            "did you mean 560 rpm (58.64 rad/s)? Or did you mean 56 rad/s?",
        ),
        (
            EC45,
            ("6110 rpm", "611 rpm"),
            "no_load_speed",
            "did you mean 6110 rpm (639.8 rad/s)? Or did you mean 611 rad/s?",
        ),
        # Of speed and voltage only the product with the constant is known.
        (
            EC45,
            ("6110 rpm", "64 rad/s"),
            "nominal_voltage",
            "one of 2 numbers is wrong. nominal_voltage: did you mean 2.4 V? Or no_load_speed (PLACE): did you mean "
            "640 rad/s?",
        ),
        # 128 / 36.9 = 3.469 A, and ten times 0.234 is 33 % off.
        (
            EC45,
            ("3.21 A", "0.234 A"),
            "nominal_current",
            "torque_constant and continuous_torque give 3.469 A: is it the current without load? Or did you mean "
            "2.34 A?",
        ),
        # Ten times the torque would fit as well.
        (
            EC45,
            ("3.21 A", "32.1 A"),
            "nominal_current",
            "one of 2 numbers is wrong. nominal_current: did you mean 3.21 A? Or continuous_torque (PLACE): did you "
            "mean 1.28 N*m?",
        ),
    ],
)
def test_speed_voltage_and_current(sheet: str, change: tuple[str, str], where: str, help: str) -> None:
    (found,) = said(REACTION.replace("SHEET", sheet), change)
    assert found.where == f"motors.m.{where}"
    assert re.sub(r"\(\S+:[0-9]+:[0-9]+\)", "(PLACE)", found.help or "") == help


@pytest.mark.parametrize("constant", ["100 mN*m/A", "50 mN*m/A"])
def test_a_constant_that_is_no_kv(constant: str) -> None:
    """By amplitudes a constant is 1.41 times another, either way."""
    assert said(MAXON, ("70.5 mN*m/A", constant)) == []


@pytest.mark.parametrize("constant", ["122 mN*m/A", "41 mN*m/A"])
def test_a_constant_of_a_phase(constant: str) -> None:
    """By phases it is 1.73 times another; 9.549 / 0.122 is 78 and not 70.5 mN*m/A."""
    (found,) = said(MAXON, ("70.5 mN*m/A", constant))
    assert (found.code, (found.help or "")[:25]) == ("SPEC181", "is it that of a phase, an")


def test_a_stall_current_is_no_peak_current() -> None:
    (fault,) = faults_of(MAXON.replace("peak_current: 21 A", "stall_current: 70 A"))
    assert fault.startswith("SPEC101 motors.m.stall_current: unknown key")


@pytest.mark.parametrize(
    ("speed", "message"),
    [
        # 0.343 rad / 0.11 rad/s.
        (
            "0.11 rad/s",
            "the joint takes 3.12 s for the 0.343 rad at which kp 10 N*m/rad asks for the effort limit",
        ),
        ("0.01 rad/s", "one turn takes 628 s"),
        ("0.001 rad/s", "one turn takes 6283 s"),
    ],
)
def test_a_speed_that_does_not_move(speed: str, message: str) -> None:
    (found,) = said(SERVO, ("9.5 rad/s", speed))
    assert (found.code, found.where) == ("SPEC184", "motors.m.no_load_speed")
    assert message in found.message
    # 60 deg in 0.11 s.
    assert ("it is 9.52 rad/s" in (found.help or "")) == (speed == "0.11 rad/s")


@pytest.mark.parametrize(
    "changes",
    [
        [("9.5 rad/s", "0.3 rad/s")],
        # A slow joint has a stiff drive.
        [("9.5 rad/s", "0.11 rad/s"), ("kp: 10, kd: 0.2", "kp: 100, kd: 5")],
        # A heavy motor: 3.43 N*m turn 0.1 kg*m^2 to 0.11 rad/s in 3.2 ms.
        [("9.5 rad/s", "0.11 rad/s"), ("unknown", "0.1 kg*m^2")],
    ],
)
def test_a_speed_that_is_slow(changes: list[tuple[str, str]]) -> None:
    assert said(SERVO, *changes) == []


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        # 1.0472 / 0.17 = 6.16.
        ([("9.5 rad/s", "0.17 rad/s, nominal_voltage: 7.4 V")], True),
        ([("9.5 rad/s", "0.17 rad/s, nominal_voltage: 12 V")], False),
        ([("9.5 rad/s", "0.17 rad/s, nominal_voltage: 7.4 V"), ("35 kgf*cm", "12 N*m")], False),
        ([("9.5 rad/s", "0.31 rad/s, nominal_voltage: 7.4 V")], False),
    ],
)
def test_a_servos_time_as_its_speed(changes: list[tuple[str, str]], told: bool) -> None:
    """With a stiff kp the joint takes 0.2 s for its error, as slow joints do: the supply tells that it is a servo."""
    found = said(SERVO, ("kp: 10, kd: 0.2", "kp: 100, kd: 5"), *changes)
    assert [(item.code, item.where) for item in found] == [("SPEC184", "motors.m.no_load_speed")] * told
    for item in found:
        assert (item.help or "").startswith(
            "is it in s per 60 deg, as sheets of servos have it? Then it is 6.16 rad/s"
        )


def test_a_servos_time_behind_a_stated_gear() -> None:
    """0.14 rad/s are 38.5 at the rotor; 1.0472 / 0.14 = 7.48. Of a drive of 40 N*m it is no servo's time."""
    (found,) = said(SERVO, ("9.5 rad/s", "0.14 rad/s, gear_ratio: 275"))
    help = "is it in s per 60 deg, as sheets of servos have it? Then it is 7.48 rad/s"
    assert (found.where, found.help) == ("motors.m.no_load_speed", help)
    (found,) = said(SERVO, ("9.5 rad/s", "0.14 rad/s, gear_ratio: 275"), ("35 kgf*cm", "40 N*m"))
    assert found.help == "did you mean 1.4 rad/s?"


WORM = """actspec: 1
robot: {name: turret, model: leg.xml}
motors: {slew: {side: joint, peak_torque: 800 N*m, no_load_speed: SPEED}}
actuators:
  turret: {joints: [turret], motor: slew, level: ideal_pd, kp: 20000, kd: 2000, effort_limit: peakARMATURE}
"""
TURRET = (
    '<mujoco><worldbody><body><joint name="turret"/><inertial pos="0 0 0" mass="1" diaginertia="0.154 0.154 0.154"/>'
    "</body></worldbody></mujoco>"
)


@pytest.mark.parametrize(
    ("speed", "armature", "told"),
    [
        # 800 N*m turn 397 kg*m^2 to 0.105 rad/s in 52 ms, and 1.39 to 30 rad/s: 20000 / 1.54 is 114 rad/s squared.
        ("1 rpm", "", False),
        ("30 rad/s", "", False),
        # With 50000 N*m/rad 180 rad/s.
        ("30 rad/s", ", kp: 50000", True),
        ("1 rpm", ", armature: 0.1 kg*m^2", True),
    ],
)
def test_a_kp_by_an_armature_that_nobody_states(speed: str, armature: str, told: bool) -> None:
    """By the links alone 360 rad/s, which says only that the armature is missing."""
    text = WORM.replace("SPEED", speed).replace("ARMATURE", armature)
    text = text.replace("kp: 20000, ", "") if "kp: 5" in text else text
    found = [item.where for item in said(text, model=TURRET) if item.code == "SPEC192"]
    assert found == ["actuators.turret.kp"] * told


FLANGE = """actspec: 1
robot: {name: arm, model: leg.xml}
motors:
  wrist:
    side: motor
    gear_ratio: 200
    efficiency: 0.75
    peak_torque: 12 N*m
    no_load_speed: 5500 rpm
    rotor_inertia: INERTIA kg*cm^2
actuators: {a6: {joints: [turret], motor: wrist, level: ideal_pd, kp: 5e4, kd: 1500, effort_limit: peak}}
"""


@pytest.mark.parametrize(("links", "told"), [("0.0552", False), ("0.029", False), ("0.027", True)])
def test_a_flange_without_a_tool(links: str, told: bool) -> None:
    """7 kg*cm^2 x 200^2 = 28 kg*m^2, 507 times 0.0552 and 1037 times 0.027."""
    found = said(FLANGE.replace("INERTIA", "7"), model=TURRET.replace("0.154", links))
    assert [item.code for item in found] == ["SPEC191"] * told


EXOSKELETON = """actspec: 1
robot: {name: exo, model: leg.xml}
motors:
  m: {side: motor, gear_ratio: 160, efficiency: 0.7, torque_constant: 53.4 mN*m/A, nominal_current: 4.72 A,
      peak_current: 15 A, no_load_speed: 4250 rpm, nominal_voltage: 24 V, rotor_inertia: 1210 g*cm^2}
actuators: {exo: {joints: [turret], motor: m, level: ideal_pd, kp: 400, kd: 40, effort_limit: continuousARMATURE}}
"""


@pytest.mark.parametrize(
    ("armature", "told"), [("", False), (", armature: 3.1", False), (", armature: 4", True)]
)
def test_an_exoskeleton_whose_wearer_is_in_no_model(armature: str, told: bool) -> None:
    """1.21e-4 x 160^2 = 3.0976 kg*m^2 are 229 times 0.0135: 28.2 N*m turn them with 9.1 rad/s^2. 4 are another's."""
    found = said(EXOSKELETON.replace("ARMATURE", armature), model=TURRET.replace("0.154", "0.0135"))
    assert [item.code for item in found] == ["SPEC191"] * told


STIFF_ARM = """actspec: 1
robot: {name: arm, model: leg.xml}
motors:
  fha25: {side: joint, gear_ratio: 100, peak_torque: 230 N*m, continuous_torque: 90 N*m, no_load_speed: 40 rpm,
          torque_constant: 40 N*m/A, peak_current: 5.75 A, reflected_inertia: 3.3 kg*m^2}
actuators:
  arm: {joints: [turret], motor: fha25, level: ideal_pd, kp: 3000, kd: 250, effort_limit: peak,
        friction: {coulomb: 9 N*m, viscous: 6 N*m*s/rad}}
"""
PER_DEGREE = "is it per degree? Per radian it is 3002 N*m/rad, and kd 57.3 times as well"


@pytest.mark.parametrize(
    ("changes", "help"),
    [
        ((), None),
        # 230 N*m / 250 N*m*s/rad are 0.92 rad/s, of 4.19: slower than others, and yet no wrong point.
        ((("kp: 3000, kd: 250", "kp: 250, kd: 3000"),), "are the two exchanged?"),
        # 9 / 52.4 = 0.17 rad; sqrt(52.4 / 5.1) = 3.2 rad/s; a kd of 4.36 beside a viscous friction of 6.
        ((("kp: 3000, kd: 250", "kp: 52.4, kd: 4.36"),), PER_DEGREE),
        ((("kp: 3000, kd: 250", "kp: 52.4, kd: 6.1"),), None),
        # 4.7 / 52.4 = 0.09 rad.
        ((("kp: 3000, kd: 250", "kp: 52.4, kd: 4.36"), ("coulomb: 9", "coulomb: 4.7")), None),
    ],
)
def test_gains_of_a_stiff_arm(changes: tuple[tuple[str, str], ...], help: str | None) -> None:
    found = [item.help or "" for item in said(STIFF_ARM, *changes, model=TURRET.replace("0.154", "1.8"))]
    assert len(found) == (help is not None)
    assert not found or found[0].startswith(help or "")
