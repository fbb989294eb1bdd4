"""What the robot's file contradicts where no slip explains it, and where it is only chosen lower."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.diagnostics import ActspecError, Diagnostic
from actspec.resolution import resolve
from actspec.robot.load import joints_of_text
from actspec.spec.document import document_from_text
from actspec.spec.plausible import BY_CODE
from actspec.spec.validate import validate

JOINT = """  <joint name="{name}" type="{kind}"><parent link="a"/><child link="{name}_link"/><axis xyz="0 1 0"/>
    <limit lower="-0.5" upper="0.5" effort="{effort}" velocity="{speed}"/></joint>
"""
GEARED = "{side: motor, peak_torque: 0.6, no_load_speed: 120 rad/s, gear_ratio: 10}"
"""6 N*m and 12 rad/s."""
DRIVEN = "level: ideal_pd, kp: 4, kd: 0.1"


def said(
    folder: Path,
    joints: dict[str, tuple[str, float, float]],
    motors: str,
    groups: dict[str, str],
    robot: str = "",
) -> list[Diagnostic]:
    """What is said of motors and groups beside a file with these joints: kind, effort, velocity."""
    path = folder / "arm.urdf"
    links = "".join(f'<link name="{name}"/>' for name in ("a", *(f"{name}_link" for name in joints)))
    written = "".join(
        JOINT.format(name=name, kind=kind, effort=effort, speed=speed)
        for name, (kind, effort, speed) in joints.items()
    )
    path.write_text(f'<robot name="arm">{links}\n{written}</robot>', encoding="utf-8")
    actuators = "".join(f"  {name}: {{{group}}}\n" for name, group in groups.items())
    text = (
        f"actspec: 1\nrobot: {{name: arm, model: {path.name}{robot}}}\nmotors: {{{motors}}}\n"
        f"actuators:\n{actuators}"
    )
    try:
        spec = validate(document_from_text(text, str(folder / "s.yaml")))
        found = [*resolve(spec, joints_of_text(str(path))).diagnostics]
    except ActspecError as err:
        found = [*err.diagnostics]
    return [item for item in found if item.code in BY_CODE]


@pytest.mark.parametrize(
    ("effort", "speed", "limits", "place", "ratio"),
    [
        # 91.2 over 12 is 7.6; the file's speed may be chosen lower, 12 over 1.3 is 9.2, and 90 be anybody's.
        (7.5, 91.2, "", "no_load_speed", "7.6 times above"),
        (7.5, 1.3, "", None, ""),
        (7.5, 90, "", None, ""),
        # 45 over 6 is 7.5, 6 over 0.83 is 7.23: told unless the spec gives the joint less than the 6.
        (45, 13, "", "peak_torque", "7.5 times above"),
        (0.83, 13, ", effort_limit: peak", "peak_torque", "7.23 times below"),
        (0.83, 13, ", effort_limit: 1.1", None, ""),
        (0.83, 13, "", "peak_torque", "7.23 times below"),
        # Below five times.
        (29.5, 59.5, ", effort_limit: peak", None, ""),
    ],
)
def test_a_figure_that_no_slip_explains(
    tmp_path: Path, effort: float, speed: float, limits: str, place: str | None, ratio: str
) -> None:
    group = f"joints: [hip], motor: m, {DRIVEN}{limits}"
    found = said(tmp_path, {"hip": ("revolute", effort, speed)}, f"m: {GEARED}", {"legs": group})
    assert [item.where for item in found] == ([f"motors.m.{place}"] if place else [])
    assert all(ratio in item.message for item in found)
    assert all("no usual slip" in str(item.help) for item in found)


def test_all_joints_of_the_group(tmp_path: Path) -> None:
    """One joint of the group that agrees: the file is the odd one at the other."""
    joints = {"hip": ("revolute", 7.5, 91.2), "knee": ("revolute", 7.5, 13.1)}
    assert said(tmp_path, joints, f"m: {GEARED}", {"legs": f"joints: [hip, knee], motor: m, {DRIVEN}"}) == []


def test_another_motor_of_the_group(tmp_path: Path) -> None:
    """The motor's 6 N*m are those of the hip, and 7.23 times the 0.83 N*m of the foot."""
    joints = {"hip": ("revolute", 6, 12.1), "foot": ("revolute", 0.83, 12.1)}
    groups = {
        "legs": f"joints: [hip], motor: m, {DRIVEN}, effort_limit: peak",
        "feet": f"joints: [foot], motor: m, {DRIVEN}, effort_limit: peak",
    }
    (found,) = said(tmp_path, joints, f"m: {GEARED}", groups)
    assert (found.code, found.where, found.help) == (
        "SPEC187",
        "actuators.feet.motor",
        "is another motor meant here?",
    )


def test_one_speed_for_two_motors(tmp_path: Path) -> None:
    """An exporter's."""
    joints = {"hip": ("revolute", 6, 91.2), "foot": ("revolute", 5.5, 91.2)}
    groups = {
        name: f"joints: [{joint}], motor: {name}, {DRIVEN}" for name, joint in (("m", "hip"), ("n", "foot"))
    }
    assert said(tmp_path, joints, f"m: {GEARED}, n: {GEARED}", groups) == []


@pytest.mark.parametrize(
    ("stage", "effort", "speed", "help"),
    [
        # 0.6 N*m over 15 mm are 40 N, and 120 rad/s times it 1.8 m/s.
        (
            "radius: 30 mm",
            40,
            1.8,
            "is it the diameter? Then the radius is 15 mm: with it force and speed both agree",
        ),
        ("radius: 60 mm", 40, 1.8, "did you mean 15 mm? With it force and speed both agree"),
        ("radius: 0.06 m", 40, 1.8, "did you mean 0.015 m? With it force and speed both agree"),
        # Half the speed, or half the force, alone may be chosen.
        ("radius: 30 mm", 22, 1.8, None),
        ("radius: 30 mm", 40, 3.5, None),
        ("radius: 60 mm", 40, 7.0, None),
        # 2 pi 0.6 N*m over 5 mm are 754 N, and 120 rad/s times that over 2 pi 0.0955 m/s.
        ("lead: 16 mm/rev", 754, 0.0955, "did you mean 5 mm/rev? With it force and speed both agree"),
        ("lead: 0.005 m/rad", 754, 0.0955, "is it per turn? Then write 5 mm/rev"),
        ("lead: 5 mm/rad", 754, 0.0955, "is it per turn? Then write 5 mm/rev"),
        # A power of ten, also where the gear is stated as 1: it is none that was forgotten.
        ("radius: 150 mm", 40, 1.8, "did you mean 15 mm?"),
        ("radius: 150 mm", 39, 1.85, "did you mean 15 mm?"),
        ("radius: 15 mm", 40, 1.8, None),
    ],
)
def test_the_length_of_a_transmission(
    tmp_path: Path, stage: str, effort: float, speed: float, help: str | None
) -> None:
    motor = "m: {side: motor, peak_torque: 0.6, no_load_speed: 120 rad/s, gear_ratio: 1}"
    group = (
        f"joints: [lift], motor: m, transmission: [{{{stage}}}], level: ideal_pd, kp: 4e3 N/m, kd: 100 N*s/m"
    )
    found = said(
        tmp_path,
        {"lift": ("prismatic", effort, speed)},
        motor,
        {"lift": f"{group}, effort_limit: peak"},
    )
    key = stage.partition(":")[0]
    expected = [] if help is None else [(f"actuators.lift.transmission[0].{key}", help)]
    assert [(item.where, item.help) for item in found] == expected


@pytest.mark.parametrize(
    ("wrong", "speed", "effort", "help"),
    [
        # 114.6 deg/s are 2 rad/s, and 114.6 rpm 12.0.
        ("no_load_speed: 114.6 deg/s", 12, 6.5, "is it in rpm? 114.6 rpm is 12 rad/s"),
        # 687.5 rpm are 72 rad/s, and 687.5 deg/s 12.0.
        ("no_load_speed: 687.5 rpm", 12, 6.5, "is it in deg/s? 687.5 deg/s is 12 rad/s"),
        # 11.46 rpm are 1.2 rad/s: of 12.0 a tenth, to the digit, and 11.46 rad/s are 1.05 times off.
        ("no_load_speed: 11.46 rpm", 12, 6.5, "did you mean 114.6 rpm (12 rad/s)?"),
        # 6 kgf*cm are 0.588 N*m.
        ("peak_torque: 6 kgf*cm", 12, 6, "did you mean 6 N*m?"),
    ],
)
def test_the_file_tells_the_unit(tmp_path: Path, wrong: str, speed: float, effort: float, help: str) -> None:
    sheet = {"peak_torque": "6", "no_load_speed": "12 rad/s"}
    key, _, value = wrong.partition(": ")
    figures = ", ".join(f"{name}: {one}" for name, one in {**sheet, key: value}.items())
    motor = f"m: {{side: joint, {figures}}}"
    group = {"legs": f"joints: [hip], motor: m, {DRIVEN}"}
    (found,) = said(tmp_path, {"hip": ("revolute", effort, speed)}, motor, group)
    assert (found.where, found.help) == (f"motors.m.{key}", help)


def test_a_peak_below_the_continuous_torque_by_the_file(tmp_path: Path) -> None:
    """12 N*m of 120. The rotor's would be 108 behind the gear, and ten times as much is the file's to the digit."""
    motor = "m: {side: joint, peak_torque: 12, continuous_torque: 40, no_load_speed: 21 rad/s, gear_ratio: 9}"
    group = {"legs": f"joints: [hip], motor: m, {DRIVEN}"}
    (found,) = said(tmp_path, {"hip": ("revolute", 120, 21)}, motor, group)
    assert (found.where, found.help) == ("motors.m.peak_torque", "did you mean 120 N*m?")


def test_a_velocity_limit_in_rpm_below_the_motors(tmp_path: Path) -> None:
    """91 rpm are 9.53 rad/s, 0.79 of motor and file."""
    group = {"legs": f"joints: [hip], motor: m, {DRIVEN}, velocity_limit: 91 rad/s"}
    (found,) = said(tmp_path, {"hip": ("revolute", 6, 12)}, f"m: {GEARED}", group)
    assert (found.where, found.help) == (
        "actuators.legs.velocity_limit",
        "is it in rpm? 91 rpm is 9.53 rad/s",
    )


def test_a_speed_that_the_file_refutes_is_not_offered(tmp_path: Path) -> None:
    """Ten times 0.35 rad/s are 3.5, and the file has 7.5."""
    motor = "m: {side: joint, peak_torque: 2, no_load_speed: 0.35 rad/s, gear_ratio: 100}"
    group = {"legs": f"joints: [hip], motor: m, {DRIVEN}"}
    (found,) = said(tmp_path, {"hip": ("revolute", 2.1, 7.5)}, motor, group)
    assert found.where == "motors.m.no_load_speed"
    assert "did you mean" not in str(found.help)
    assert "velocity limit of 7.5 rad/s" in str(found.help)


@pytest.mark.parametrize(
    ("constant", "torque", "help"),
    [
        # 60 / (2 pi 115) = 0.08304, by which 29.5 A are 2.45 N*m; 0.115 would make 3.39.
        ("115", "2.45", "is it Kv, in rpm/V? Then the constant is 60 / (2 pi Kv), 0.083 N*m/A"),
        # 83 mN*m/A.
        ("83", "2.45", "is it in mN*m/A? 83 mN*m/A is 0.083 N*m/A"),
        # 29.5 A are 2.95 N*m by 0.1, and 2.82 by a Kv of 100.
        ("100", "2.95", "is it in mN*m/A? 100 mN*m/A is 0.1 N*m/A"),
    ],
)
def test_a_kv_for_the_constant(tmp_path: Path, constant: str, torque: str, help: str) -> None:
    figures = f"peak_torque: {torque}, torque_constant: {constant}, peak_current: 29.5 A, gear_ratio: 6"
    group = {"legs": f"joints: [hip], motor: m, {DRIVEN}"}
    (found,) = said(tmp_path, {"hip": ("revolute", 14, 21)}, f"m: {{side: motor, {figures}}}", group)
    assert (found.code, found.where, found.help) == ("SPEC181", "motors.m.torque_constant", help)


def test_a_gear_the_other_way_round(tmp_path: Path) -> None:
    """50, which is sound, though 200 would make the inertia at the rotor a more usual one."""
    motor = (
        "m: {side: joint, peak_torque: 150, continuous_torque: 62, no_load_speed: 90 rpm, reflected_inertia: 0.86, "
        "gear_ratio: 0.02}"
    )
    group = {"legs": f"joints: [hip], motor: m, {DRIVEN}"}
    (found,) = said(tmp_path, {"hip": ("revolute", 151, 9.42)}, motor, group)
    help = "did you mean 50? gear_ratio is rotor turns in one output turn"
    assert (found.where, found.help) == ("motors.m.gear_ratio", help)


@pytest.mark.parametrize(
    ("pose", "help"),
    [
        # The range is -0.5 to 0.5 m: 0.25 m is inside, and 25 m by 1e-3 alone.
        ("2.5 m", "is the point wrong, or is it in mm? Then write 2.5 mm"),
        ("25 m", "is it in mm? Then write 25 mm"),
    ],
)
def test_a_pose_of_a_slide(tmp_path: Path, pose: str, help: str) -> None:
    """A range of half a metre either way."""
    group = "joints: [lift], level: ideal_pd, kp: 4e3 N/m, kd: 100 N*s/m"
    joints: dict[str, tuple[str, float, float]] = {"lift": ("prismatic", 40, 1.8)}
    (found,) = said(tmp_path, joints, "", {"lift": group}, f", default_pose: {{lift: {pose}}}")
    assert (found.code, found.help) == ("SPEC190", help)
