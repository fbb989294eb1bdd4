"""Which number is told where several may be wrong: the one that others contradict, else all of them, and each once."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.cli.main import main
from actspec.diagnostics import ActspecError, Diagnostic
from actspec.resolution import resolve
from actspec.robot.load import joints_of_text
from actspec.spec.document import document_from_text
from actspec.spec.plausible import BY_CODE
from actspec.spec.validate import validate
from tests.fitting import fit, spec_of

URDF = """<robot name="arm"><link name="a"/><link name="b"/><link name="c"/>
  <joint name="hip" type="revolute"><parent link="a"/><child link="b"/>
    <limit lower="-1" upper="1" effort="30" velocity="3.14"/><dynamics damping="2" friction="1"/></joint>
  <joint name="knee" type="revolute"><parent link="b"/><child link="c"/>
    <limit lower="-1" upper="1" effort="30" velocity="3.14"/><dynamics damping="2" friction="1"/></joint>
</robot>
"""


def said(
    folder: Path,
    fields: str,
    more: str = "",
    model: str = "arm.urdf",
    level: str = "ideal_pd",
    urdf: str = URDF,
) -> list[Diagnostic]:
    """What is said of two joints whose file has 30 N*m, 3.14 rad/s and friction of 1 N*m and 2 N*m*s/rad."""
    path = folder / "arm.urdf"
    path.write_text(urdf, encoding="utf-8")
    text = (
        f"actspec: 1\nrobot: {{name: arm, model: {model}}}\n"
        f"sources: {{own: {{title: file, page: arm.urdf}}, other: {{title: sheet, page: 12}}}}\n{more}"
        f"actuators: {{arm: {{joints: [hip, knee], level: {level}, kp: 40, kd: 1, {fields}}}}}\n"
    )
    try:
        spec = validate(document_from_text(text, str(folder / "s.yaml")))
        return [item for item in resolve(spec, joints_of_text(str(path))).diagnostics if item.code in BY_CODE]
    except ActspecError as err:
        return [*err.diagnostics]


@pytest.mark.parametrize(
    ("fields", "where", "help"),
    [
        (
            "effort_limit: {value: 300 N*m, source: own}",
            "effort_limit",
            "is the point in the wrong place? Then it is 30",
        ),
        # 30 / 0.0980665 = 305.9.
        (
            "effort_limit: {value: 306 N*m, source: own}",
            "effort_limit",
            "is it in kgf*cm? Then it is 30.01 N*m",
        ),
        (
            "effort_limit: {value: 3 N*m, source: own}",
            "effort_limit",
            "is the point in the wrong place? Then it is 30",
        ),
        # 30 / 9.80665 = 3.059: a hundredth more than a tenth tells it from that.
        (
            "effort_limit: {value: 3.06 N*m, source: own}",
            "effort_limit",
            "is it in kgf*m? Then it is 30.01 N*m",
        ),
        # 3.14 rad/s are 179.9 deg/s, and 30 rpm.
        (
            "velocity_limit: {value: 180 rad/s, source: own}",
            "velocity_limit",
            "is it in deg/s? Then it is 3.142 rad/s",
        ),
        (
            "velocity_limit: {value: 30 rad/s, source: own}",
            "velocity_limit",
            "is it in rpm? Then it is 3.142 rad/s",
        ),
        (
            "friction: {viscous: {value: 0.2 N*m*s/rad, source: own}}",
            "friction.viscous",
            "is the point in the wrong place? Then it is 2 N*m*s/rad",
        ),
        # 2 x 57.3 = 114.6.
        (
            "friction: {viscous: {value: 114.6 N*m*s/rad, source: own}}, effort_limit: 30",
            "friction.viscous",
            "is it multiplied by 57.3? Then it is 2 N*m*s/rad",
        ),
        ("effort_limit: {value: 170 N*m, source: own}", "effort_limit", "look for a wrong unit"),
    ],
)
def test_a_number_that_is_not_its_sources(tmp_path: Path, fields: str, where: str, help: str) -> None:
    (found,) = said(tmp_path, fields)
    assert (found.code, found.where) == ("SPEC194", f"actuators.arm.{where}")
    assert found.message.startswith("hip, knee: ")
    assert "names own as its source, the robot's file, which has " in found.message
    assert (found.help or "").startswith(help)


@pytest.mark.parametrize(
    "fields",
    [
        "effort_limit: {value: 30 N*m, source: own}",
        # Tuned: a factor of 4.
        "effort_limit: {value: 120 N*m, source: own}",
        # From elsewhere, or from nowhere.
        "effort_limit: {value: 300 N*m, source: other}",
        "effort_limit: {value: 300 N*m}",
        "effort_limit: {value: 3 N*m, source: other}",
        "effort_limit: {value: 300 N*m, source: own, sure: true}",
    ],
)
def test_a_number_that_may_be_meant(tmp_path: Path, fields: str) -> None:
    assert said(tmp_path, fields) == []


@pytest.mark.parametrize(
    ("fields", "code", "where"),
    [
        # The file has the same friction, and 30 N*m.
        ("effort_limit: 0.3 N*m, friction: {coulomb: 1 N*m}", "SPEC187", "effort_limit"),
        ("effort_limit: 30 N*m, friction: {coulomb: 20 N*m}", "FRC101", "friction.coulomb"),
        # It has neither.
        ("effort_limit: 0.3 N*m, friction: {coulomb: 0.2 N*m}", "FRC101", "friction.coulomb"),
    ],
)
def test_friction_beside_a_limit(tmp_path: Path, fields: str, code: str, where: str) -> None:
    (found,) = said(tmp_path, fields)
    assert (found.code, found.where) == (code, f"actuators.arm.{where}")
    if code == "FRC101":
        # Which of the two it is, nothing tells.
        assert (found.help or "").endswith(f" Or is the limit wrong ({tmp_path / 's.yaml'}:4:86)?")


def test_friction_is_told_without_the_robots_file() -> None:
    """As a warning: with the file it may be the limit."""
    text = spec_of(
        "legs: {joints: [hip], level: ideal_pd, effort_limit: 0.3 N*m, friction: {coulomb: 1 N*m}}"
    )
    (found,) = validate(document_from_text(text, "s.yaml")).diagnostics
    assert (found.code, found.severity.value) == ("FRC101", "warning")


def told_of(groups: str, motor: str) -> list[Diagnostic]:
    """What is said of a motor and its group, whatever the robot is."""
    rest = "rest: {joints: [calf, slide], level: ideal_pd, kp: 1, kd: 1}"
    return [*fit(spec_of(f"{groups}, {rest}", motors=f"{{m: {{{motor}}}}}")).diagnostics]


def test_two_numbers_of_which_one_is_wrong() -> None:
    """0.88 x 5.1 = 4.488 N*m of 45: a gear of 51, a torque of 8.8 and a limit of 4.5 would all do.

    45 kgf*cm are 4.413 N*m, 2 % off.
    """
    (found,) = told_of(
        "legs: {joints: [hip], motor: m, level: ideal_pd, kp: 60, kd: 1.5, effort_limit: 45 N*m}",
        "side: motor, peak_torque: 0.88 N*m, gear_ratio: 5.1",
    )
    assert found.code == "SPEC187"
    help = found.help or ""
    assert help.startswith("one of 3 numbers is wrong. effort_limit: did you mean 4.5 N*m? Or")
    assert "Or gear_ratio (s.yaml:3:" in help and "): did you mean 51?" in help
    assert "Or peak_torque (s.yaml:3:" in help and "): did you mean 8.8 N*m?" in help


def test_a_voltage_beside_a_constant() -> None:
    """1.21 N*m/A x 5.92 rad/s = 7.16 V of 74: nothing else tells which."""
    (found,) = told_of(
        "legs: {joints: [hip], motor: m, level: ideal_pd, kp: 8, kd: 0.2}",
        "side: joint, stall_torque: 3.25, no_load_speed: 5.92 rad/s, torque_constant: 1.21, nominal_voltage: 74 V",
    )
    assert (found.code, found.where) == ("SPEC181", "motors.m.torque_constant")
    assert (found.help or "").startswith(
        "one of 3 numbers is wrong. torque_constant: did you mean 12.1 N*m/A? Or no_l"
    )
    assert (found.help or "").endswith("did you mean 7.4 V?")


def test_many_motors_a_joint() -> None:
    """12 x 300 N*m are 12 times the limit, and one motor's are the limit itself."""
    (found,) = told_of(
        "legs: {joints: [hip], motor: m, motors_per_joint: 12, level: ideal_pd, kp: 200, kd: 4, effort_limit: 300}",
        "side: joint, peak_torque: 300",
    )
    assert (found.code, found.where) == ("SPEC187", "actuators.legs.motors_per_joint")
    assert (found.help or "").startswith("did you mean 1? motors_per_joint is")


@pytest.mark.parametrize(
    ("limits", "told"),
    [
        # 18 N*m and 20 rad/s behind 22.2 are 400 N*m and 0.9 rad/s, behind 2.22 the limits.
        ("effort_limit: 40, velocity_limit: 9 rad/s", "reduction"),
        # Behind 22.2 they are the limits themselves.
        ("effort_limit: 400, velocity_limit: 0.9 rad/s", ""),
    ],
)
def test_a_reduction_with_its_point_in_the_wrong_place(limits: str, told: str) -> None:
    found = told_of(
        f"legs: {{joints: [hip], motor: m, reduction: 22.2, level: ideal_pd, kp: 40, kd: 2, {limits}}}",
        "side: joint, peak_torque: 18, no_load_speed: 20 rad/s",
    )
    assert [item.where for item in found] == [f"actuators.legs.{told}"] * bool(told)
    assert all((item.help or "").startswith("did you mean 2.22? reduction is turns of") for item in found)


def test_viscous_friction_is_told_without_a_figure() -> None:
    """45 N*m*s/rad of ANYmal's 4.5: neither 0.045 nor 0.785 is near, and nothing tells which it is."""
    (found,) = told_of(
        "legs: {joints: [hip], motor: m, level: dc_motor, kp: 40, kd: 5, friction: {viscous: 45}}",
        "side: joint, peak_torque: 89, stall_torque: 140, no_load_speed: 8.5 rad/s",
    )
    assert found.code == "FRC106"
    assert found.help == (
        "is it in mN*m*s/rad, times 57.3, or the point in the wrong place? The slope of the torque-speed line belongs "
        "to the motor, not to friction"
    )


SPEED_FIRST = """one of 2 numbers is wrong. no_load_speed: is it in rpm? 81.2 rpm is 8.5 rad/s; or is it in deg/s? \
81.2 deg/s is 1.42 rad/s. Or viscous (s.yaml:4:99): is it in mN*m*s/rad, times 57.3, or the point in the wrong place?"""
VISCOUS_FIRST = """one of 2 numbers is wrong. viscous: is it in mN*m*s/rad, times 57.3, or the point in the wrong \
place? Or no_load_speed (s.yaml:3:78): is it in rpm? 40 rpm is 4.19 rad/s"""
ALONE = """is it in mN*m*s/rad, times 57.3, or the point in the wrong place? The slope of the torque-speed line \
belongs to the motor, not to friction"""


@pytest.mark.parametrize(
    ("motor", "viscous", "where", "help"),
    [
        # ANYmal D in rpm. 81.2 x sqrt(89) = 766, beyond the usual 500; 8.5 x 4.5 = 38 of 89 N*m.
        (
            "peak_torque: 89, stall_torque: 140, no_load_speed: 81.2 rad/s",
            "4.5",
            "motors.m.no_load_speed",
            SPEED_FIRST,
        ),
        # 40 x 1 of 50 N*m. 4.19 rad/s are as usual as 40, and in deg/s 0.698 less so.
        (
            "peak_torque: 50, stall_torque: 100, no_load_speed: 40 rad/s",
            "1.0",
            "actuators.legs.friction.viscous",
            VISCOUS_FIRST,
        ),
        # In rpm a gear's rotor of 360 rad/s would turn with 38, less than the 40 of any: it is none.
        (
            "peak_torque: 50, stall_torque: 100, no_load_speed: 40 rad/s, gear_ratio: 9",
            "1.0",
            "actuators.legs.friction.viscous",
            ALONE,
        ),
        # 40 x 10 in rpm is 42 of 50 N*m still.
        (
            "peak_torque: 50, stall_torque: 100, no_load_speed: 40 rad/s",
            "10",
            "actuators.legs.friction.viscous",
            ALONE,
        ),
    ],
)
def test_viscous_friction_or_the_speed(motor: str, viscous: str, where: str, help: str) -> None:
    (found,) = told_of(
        f"legs: {{joints: [hip], motor: m, level: dc_motor, kp: 85, kd: 0.6, friction: {{viscous: {viscous}}}}}",
        f"side: joint, {motor}",
    )
    assert (found.code, found.where) == ("FRC106", where)
    assert found.help == help


@pytest.mark.parametrize(("viscous", "speed_first"), [("2", True), ("2.6", False)])
def test_viscous_friction_that_the_robots_file_has(tmp_path: Path, viscous: str, speed_first: bool) -> None:
    """2 x 16 and 2.6 x 16 of 30 N*m; the file has 2, and no speed but a placeholder. 16 rpm are 1.68 rad/s."""
    fields = f"motor: m, friction: {{viscous: {viscous}}}"
    motor = "motors: {m: {side: joint, peak_torque: 30, stall_torque: 31, no_load_speed: 16 rad/s}}\n"
    urdf = URDF.replace("3.14", "100")
    (found,) = said(tmp_path, fields, motor, level="dc_motor", urdf=urdf)
    assert found.code == "FRC106"
    assert found.where == ("motors.m.no_load_speed" if speed_first else "actuators.arm.friction.viscous")
    assert "is it in rpm? 16 rpm is 1.68 rad/s" in (found.help or "")


@pytest.mark.parametrize(("viscous", "found"), [("20", 0), ("21", 1)])
def test_viscous_friction_of_the_file_beside_a_velocity_limit(
    tmp_path: Path, viscous: str, found: int
) -> None:
    """20 x 3 rad/s of 30 N*m. What the file has as well, damping a simulator needs, is not mistyped."""
    fields = f"velocity_limit: 3 rad/s, friction: {{viscous: {viscous}}}"
    urdf = URDF.replace('damping="2"', 'damping="20"')
    assert [item.code for item in said(tmp_path, fields, urdf=urdf)] == ["FRC106"] * found


def test_a_speed_in_degrees() -> None:
    """429.7 deg/s is 7.5 rad/s, 429.7 rpm 45 rad/s: both are usual."""
    (found,) = told_of(
        "legs: {joints: [hip], motor: m, level: ideal_pd, kp: 40, kd: 5}",
        "side: joint, peak_torque: 80, no_load_speed: 429.7 rad/s",
    )
    assert found.help == "is it in rpm? 429.7 rpm is 45 rad/s; or is it in deg/s? 429.7 deg/s is 7.5 rad/s"


@pytest.mark.parametrize(
    ("fields", "told", "help"),
    [
        # 802 x sqrt(300) = 13891 of 1000; 802 deg/s are 14 rad/s.
        ("effort_limit: 300, velocity_limit: 802 rad/s", True, "is it in deg/s? Then it is 14 rad/s"),
        # 137 rpm are 14.35 rad/s; x sqrt(300) = 2373. In degrees it is 2.39 rad/s.
        (
            "effort_limit: 300, velocity_limit: 137 rad/s",
            True,
            "is it in deg/s? Then it is 2.391 rad/s; or is it in rpm? Then it is 14.35 rad/s",
        ),
        (
            "velocity_limit: 210 rad/s",
            True,
            "is it in deg/s? Then it is 3.665 rad/s; or is it in rpm? Then it is 21.99",
        ),
        # Published: 560 of 1000.
        ("effort_limit: 26, velocity_limit: 109.8 rad/s", False, ""),
        ("effort_limit: 7, velocity_limit: 200 rad/s", False, ""),
        ("effort_limit: 300, velocity_limit: 1000 rad/s", False, ""),
    ],
)
def test_a_velocity_limit_alone(fields: str, told: bool, help: str) -> None:
    text = spec_of(
        f"legs: {{joints: [hip], level: ideal_pd, kp: 60, kd: 1.5, {fields}}}, "
        "rest: {joints: [calf, slide], level: ideal_pd, kp: 1, kd: 1}"
    )
    found = fit(text).diagnostics
    assert [item.where for item in found] == ["actuators.legs.velocity_limit"] * told
    assert all((item.help or "").startswith(help) for item in found)


@pytest.mark.parametrize(
    ("speed", "told"),
    [
        # Beside 30 N*m no joint reaches 1000 / sqrt(30) = 183 rad/s; three times that are 548 rad/s.
        ("540", False),
        ("802", True),
    ],
)
def test_a_velocity_limit_that_the_file_has(tmp_path: Path, speed: str, told: bool) -> None:
    """What the file says as well is not mistyped in the spec, and beyond every joint it is wrong in both."""
    fast = URDF.replace("3.14", speed)
    (tmp_path / "fast.urdf").write_text(fast, encoding="utf-8")
    text = (
        "actspec: 1\nrobot: {name: arm, model: fast.urdf}\n"
        f"actuators: {{arm: {{joints: [hip, knee], level: ideal_pd, kp: 40, kd: 1, velocity_limit: {speed} rad/s}}}}\n"
    )
    spec = validate(document_from_text(text, str(tmp_path / "s.yaml")))
    own = resolve(spec, joints_of_text(str(tmp_path / "fast.urdf"))).diagnostics
    assert [item.code for item in own] == ["SPEC184"] * told
    (found,) = said(tmp_path, f"velocity_limit: {speed} rad/s")
    assert (found.code, found.where) == ("SPEC184", "actuators.arm.velocity_limit")


@pytest.mark.parametrize(
    ("inertia", "told", "help"),
    [
        # 0.738 / 22.5^2 = 1.458e-3 of 4.89e-5 kg*m^2: 29.8 times; 0.738 kg*cm^2 are 0.003 of it.
        ("0.738 kg*m^2", True, "is it in kg*cm^2? 0.738 kg*cm^2 is 7.38e-05 kg*m^2"),
        ("0.738e-4 kg*m^2", False, ""),
        # 0.04 / 506.25 = 7.9e-5: 1.6 times.
        ("0.04 kg*m^2", False, ""),
    ],
)
def test_inertia_of_a_stage(inertia: str, told: bool, help: str) -> None:
    motor = (
        "side: joint, peak_torque: 139, rotor_inertia: 0.489e-4, gearbox: [{ratio: 4.5, inertia: 0.109e-4}, "
        f"{{ratio: 5, inertia: {inertia}}}]"
    )
    found = told_of("legs: {joints: [hip], motor: m, level: ideal_pd, kp: 99, kd: 6.3}", motor)
    assert [item.where for item in found] == ["motors.m.gearbox[1].inertia"] * told
    assert all((item.help or "").startswith(help) for item in found)


def test_an_anchor_is_told_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Two groups have the same line, and variants judge it again."""
    path = tmp_path / "s.yaml"
    path.write_text(
        "actspec: 1\nrobot: {name: leg, model: none, joints: [hip, knee]}\n"
        "actuators:\n  a: {joints: [hip], level: ideal_pd, kp: 9, kd: 1, delay: &late {nominal: 0.4 s}}\n"
        "  b: {joints: [knee], level: ideal_pd, kp: 9, kd: 1, delay: *late}\n",
        encoding="utf-8",
    )
    assert main(["validate", "--strict", str(path)]) == 1
    assert capsys.readouterr().err.count("SPEC186 [warning]") == 1


def test_a_position_in_degrees_a_little_outside(tmp_path: Path) -> None:
    """-58.1 deg is -1.014 rad, 0.014 rad outside, which is nothing."""
    (found,) = said(tmp_path, "effort_limit: 30", model="arm.urdf, default_pose: {hip: -58.1 rad}")
    assert (found.code, found.help) == ("SPEC190", "is it in degrees? Then write -58.1 deg, -1.014 rad")


SIDED = "level: ideal_pd, kp: 60, kd: 1.5"


@pytest.mark.parametrize(
    ("motor", "limit", "where", "help"),
    [
        # 18 N*m and 40 rad/s are the joint's, 0.095 N*m/A x 32 A = 3.04 N*m the rotor's: times 6, 0.57 N*m/A.
        (
            "side: motor, peak_torque: 18, no_load_speed: 40 rad/s, torque_constant: 0.095, peak_current: 32 A, "
            "gear_ratio: 6",
            "peak",
            "motors.m.side",
            "are the figures those of the gearbox output? Then write `side: joint`, and torque_constant for that side, "
            "about 0.57 N*m/A",
        ),
        # 0.277 x 101 = 27.98 N*m; a hundred times are 27.7.
        (
            "side: joint, peak_torque: 28, gear_ratio: 101",
            "0.277",
            "actuators.legs.effort_limit",
            "is it quoted at the rotor? At the joint it is 27.977 N*m",
        ),
        # 0.25 x 101 = 25.25: neither is what the motor gives.
        (
            "side: joint, peak_torque: 28, gear_ratio: 101",
            "0.25",
            "actuators.legs.effort_limit",
            "one of 2 numbers is wrong. effort_limit: did you mean 25 N*m? Or peak_torque (s.yaml:3:40): did you mean "
            "0.28 N*m?",
        ),
        # 3.8 x 101 = 383.8 rad/s.
        (
            "side: joint, peak_torque: 28, no_load_speed: 3.8 rad/s, gear_ratio: 101",
            "28, velocity_limit: 384 rad/s",
            "actuators.legs.velocity_limit",
            "is it quoted at the rotor? At the joint it is 3.802 rad/s",
        ),
        # 0.28 x 100 is a hundred times, too. 0.444 x 100 x 0.7 is the continuous torque there.
        (
            "side: joint, peak_torque: 28, gear_ratio: 100",
            "0.28",
            "actuators.legs.effort_limit",
            "is it quoted at the rotor? At the joint it is 28 N*m; or is the point in the wrong place?",
        ),
        (
            "side: motor, stall_torque: 4.67, continuous_torque: 0.444, no_load_speed: 3190 rpm, gear_ratio: 80, "
            "efficiency: 0.7, rotor_inertia: 3.06e-4",
            "0.444",
            "actuators.legs.effort_limit",
            "is it quoted at the rotor? At the joint it is 24.864 N*m",
        ),
        # 1.4 x 26 x 0.83 = 30.212 N*m. It is 0.146 of the continuous 9.58 N*m there, which less might be meant to be.
        (
            "side: motor, peak_torque: 1.4, continuous_torque: 0.444, no_load_speed: 3190 rpm, gear_ratio: 26, "
            "efficiency: 0.83, torque_constant: 0.0705, nominal_current: 6.06 A",
            "1.4",
            "actuators.legs.effort_limit",
            "is it quoted at the rotor? At the joint it is 30.212 N*m",
        ),
        # 40 / 9 = 4.444 N*m.
        (
            "side: joint, peak_torque: 40, continuous_torque: 20, no_load_speed: 320 rpm, gear_ratio: 9",
            "4.44",
            "actuators.legs.effort_limit",
            "is it quoted at the rotor? At the joint it is 39.96 N*m",
        ),
        # Without a speed the torque may as well be the joint's.
        (
            "side: motor, peak_torque: 4.2, gear_ratio: 9",
            "4.2",
            "motors.m.side",
            "one of 2 values is wrong. side: are the figures those of the gearbox output? Then write `side: joint`. Or "
            "peak_torque (s.yaml:3:40): is it quoted at the gearbox output? At the rotor 4.2 N*m is about 0.4667 N*m",
        ),
    ],
)
def test_the_other_side_of_the_gear(motor: str, limit: str, where: str, help: str) -> None:
    (found,) = told_of(f"legs: {{joints: [hip], motor: m, {SIDED}, effort_limit: {limit}}}", motor)
    assert (found.where, found.help) == (where, help)


@pytest.mark.parametrize(
    ("motor", "limit"),
    [
        # A round eighth, and 4.5 N*m: less than the motor gives is often right.
        ("side: joint, peak_torque: 40, continuous_torque: 20, no_load_speed: 320 rpm, gear_ratio: 8", "5"),
        (
            "side: joint, peak_torque: 40.5, continuous_torque: 20, no_load_speed: 320 rpm, gear_ratio: 9",
            "4.5",
        ),
        # Behind a gear of 2 rotor and output are hardly told apart.
        ("side: motor, peak_torque: 4.2, no_load_speed: 500 rpm, gear_ratio: 2", "4.2"),
        # 1.5 N*m is none of the rotor's figures.
        (
            "side: motor, peak_torque: 1.4, continuous_torque: 0.444, no_load_speed: 3190 rpm, gear_ratio: 26",
            "1.5",
        ),
    ],
)
def test_a_small_limit_that_may_be_meant(motor: str, limit: str) -> None:
    assert told_of(f"legs: {{joints: [hip], motor: m, {SIDED}, effort_limit: {limit}}}", motor) == []


@pytest.mark.parametrize(
    ("peak", "help"),
    [
        # 0.9 x 50 = 45 N*m of 45; 9 kgf*cm are 44.1 N*m there.
        ("9", "did you mean 0.9 N*m?"),
        ("9.18", "is it in kgf*cm? 9.18 kgf*cm is 0.9003 N*m"),
    ],
)
def test_kgf_cm_is_told_from_a_wrong_point(tmp_path: Path, peak: str, help: str) -> None:
    motor = f"motors: {{m: {{side: motor, peak_torque: {peak}, no_load_speed: 180 rad/s, gear_ratio: 50}}}}\n"
    (found,) = said(tmp_path, "motor: m", motor, urdf=URDF.replace('effort="30"', 'effort="45"'))
    assert (found.where, found.help) == ("motors.m.peak_torque", help)


SERVO = """actspec: 1
robot: {{name: r, model: none, joints: [{{name: j}}]}}
motors:
  m:
    {{side: joint, stall_torque: {stall}, no_load_speed: 46 rpm, torque_constant: 1.783, peak_current: 2.3 A{more}}}
actuators: {{g: {{joints: [j], motor: m, level: dc_motor, kp: 20, kd: 0.5, effort_limit: {limit}}}}}
"""


@pytest.mark.parametrize(
    ("stall", "limit", "more", "told"),
    [
        # 1.783 x 2.3 = 4.101 N*m; 41.8 kgf*cm are 4.099 N*m.
        ("41.8 N*m", "4.1 N*m", "", True),
        ("4.1 N*m", "4.1 N*m", "", False),
        # Of a winding it may be any other multiple of what the drive gives, whether ten times it or twelve.
        ("41 N*m", "4.1 N*m", "", False),
        ("50 N*m", "4.1 N*m", "", False),
        # A limit that says something else, or a peak that says what the drive gives.
        ("41.8 N*m", "3.9 N*m", "", False),
        ("41.8 N*m", "4.1 N*m", ", peak_torque: 4.1 N*m", False),
    ],
)
def test_a_stall_torque_in_kgf_cm_beside_current_and_limit(
    tmp_path: Path, stall: str, limit: str, more: str, told: bool
) -> None:
    text = SERVO.format(stall=stall, limit=limit, more=more)
    found = [
        item for item in validate(document_from_text(text, "s.yaml")).diagnostics if item.code in BY_CODE
    ]
    expected = [("SPEC181", "motors.m.stall_torque", "is it in kgf*cm? 41.8 kgf*cm is 4.099 N*m")]
    assert [(item.code, item.where, item.help) for item in found] == expected * told
