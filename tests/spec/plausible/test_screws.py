"""Motors whose gearbox ends in a screw, and how many drive one joint: judged by the robot's file as others are."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from actspec.diagnostics import ActspecError, Diagnostic
from actspec.resolution import resolve
from actspec.robot.load import joints_of_text, listed_robot
from actspec.spec.document import document_from_text
from actspec.spec.plausible import BY_CODE
from actspec.spec.validate import validate

URDF = """<robot name="lift"><link name="a"/><link name="b"/><link name="c"/>
  <joint name="lift" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="0.6" effort="{effort}" velocity="0.05"/></joint>
  <joint name="hip" type="revolute"><parent link="b"/><child link="c"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="{torque}" velocity="12"/></joint>
</robot>
"""
SPEC = """actspec: 1
robot: {{name: lift, model: lift.urdf}}
motors:
  screw:
    side: motor
    peak_torque: 0.6 N*m
    no_load_speed: 120 rad/s
    rotor_inertia: {inertia}
    gearbox: [{{teeth: {{driving: 20, driven: 40}}}}, {{lead: {lead}}}]
  geared: {{side: motor, peak_torque: 0.6 N*m, no_load_speed: 120 rad/s, gear_ratio: 10}}
actuators:
  lift: {{joints: [lift], motor: screw, level: ideal_pd, effort_limit: peak, kp: 4e4 N/m, kd: 4e3 N*s/m{more}}}
  hip: {{joints: [hip], motor: geared, motors_per_joint: {motors}, level: ideal_pd, effort_limit: peak, kp: 40, kd: 1}}
"""
"""1.2 N*m and 60 rad/s at the screw: by 5 mm/rev 1508 N and 0.0477 m/s. 6 N*m and 12 rad/s at the hip."""


def said(
    folder: Path,
    *,
    lead: str = "5 mm/rev",
    inertia: str = "100 g*cm^2",
    motors: int = 1,
    more: str = "",
    effort: float = 1600,
    torque: float = 6.5,
) -> list[Diagnostic]:
    """What is said of the two motors beside a file with these efforts."""
    path = folder / "lift.urdf"
    path.write_text(URDF.format(effort=effort, torque=torque), encoding="utf-8")
    text = SPEC.format(lead=lead, inertia=inertia, motors=motors, more=more)
    try:
        spec = validate(document_from_text(text, str(folder / "s.yaml")))
        found = [*resolve(spec, joints_of_text(str(path))).diagnostics]
    except ActspecError as err:
        found = [*err.diagnostics]
    return [item for item in found if item.code in BY_CODE]


LEAD = "motors.screw.gearbox[1].lead"


@pytest.mark.parametrize(
    ("lead", "code", "help"),
    [
        # 1.2 N*m x 2 pi / 0.05e-3 m = 151 kN, 94 times 1600 N; 0.000477 m/s.
        ("0.05 mm/rev", "SPEC187", "did you mean 5 mm/rev?"),
        # 1508 kN is no slide's.
        (
            "0.005 mm/rev",
            "SPEC183",
            "did you mean 0.005 m/rev? `sure: true` beside it keeps a number that is right",
        ),
        # 60 rad/s x 5 m / 2 pi = 47.7 m/s.
        ("5 m/rev", "SPEC184", "did you mean 5 mm/rev?"),
        # 4.77 m/s and 15.1 N.
        ("500 mm/rev", "SPEC187", "did you mean 5 mm/rev?"),
    ],
)
def test_a_lead_in_another_unit(tmp_path: Path, lead: str, code: str, help: str) -> None:
    assert said(tmp_path) == []
    (found,) = said(tmp_path, lead=lead)
    assert (found.code, found.where, found.help) == (code, LEAD, help)


def test_the_lead_is_told_beside_a_limit_of_speed(tmp_path: Path) -> None:
    """0.5 mm/rev is 0.00477 m/s, of a limit of 0.05 m/s: ten times."""
    more = ", velocity_limit: 0.05 m/s"
    assert said(tmp_path, more=more) == []
    (found,) = said(tmp_path, more=more, lead="0.5 mm/rev")
    assert (found.where, found.help) == (LEAD, "did you mean 5 mm/rev?")


def test_a_rotor_of_a_screw(tmp_path: Path) -> None:
    """0.6 N*m over 0.01 kg*m^2 are 60 rad/s^2."""
    (found,) = said(tmp_path, inertia="100 kg*cm^2")
    assert (found.code, found.where) == ("SPEC185", "motors.screw.rotor_inertia")
    assert found.help == "is it in g*cm^2? 100 g*cm^2 is 1e-05 kg*m^2"


def test_many_motors_of_one_joint(tmp_path: Path) -> None:
    """40 times 6 N*m are 240 N*m, 37 times 6.5 N*m; 18 N*m may be."""
    (found,) = said(tmp_path, motors=40)
    assert (found.code, found.where) == ("SPEC187", "actuators.hip.motors_per_joint")
    assert "36.9" in found.message
    assert found.help == "did you mean 1? motors_per_joint is how many motors drive one joint together"
    assert said(tmp_path, motors=3) == []


def test_far_above_may_agree_less_well(tmp_path: Path) -> None:
    """240 N*m of 4 N*m are 60 times: one motor has 1.5 times of it. 24 N*m are 6 times: which may be meant."""
    (found,) = said(tmp_path, motors=40, torque=4)
    assert found.where == "actuators.hip.motors_per_joint"
    assert said(tmp_path, motors=4, torque=4) == []


@pytest.mark.parametrize("effort", [0, 1, 10, 1000, 0.05])
def test_placeholders_of_the_file(tmp_path: Path, effort: float) -> None:
    assert said(tmp_path, effort=effort) == []


AXIS = """actspec: 1
robot: {{name: r, model: none, joints: [{{name: j, kind: {kind}}}]}}
motors: {{m: {{side: motor, peak_torque: {torque} N*m, no_load_speed: {speed} rpm, {gear}}}}}
actuators: {{g: {{joints: [j], motor: m, level: ideal_pd, kp: {kp}, kd: {kd}, effort_limit: peak{more}}}}}
"""


@pytest.mark.parametrize(
    ("kind", "gear", "more", "found"),
    [
        # 5000 rpm are 523.6 rad/s: times the root of 3.8 N*m 1021, of a bound of 1000. 0.833 m/s and 2388 N.
        ("slide", "gearbox: [{lead: 10 mm/rev}]", "", []),
        ("slide", "gear_ratio: 1", ", transmission: [{lead: 10 mm/rev}]", []),
        # 0.01 m at 523.6 rad/s, 5.2 m/s.
        ("slide", "gear_ratio: 1", ", transmission: [{radius: 10 mm}]", []),
        # 83.3 m/s.
        ("slide", "gearbox: [{lead: 1 m/rev}]", "", ["motors.m.gearbox[0].lead"]),
        # 523.6 / 50 = 10.5 rad/s of 190 N*m, 144.
        ("hinge", "gear_ratio: 1", ", reduction: 50", []),
        ("hinge", "gear_ratio: 1", ", transmission: [{ratio: 50}]", []),
        ("hinge", "gear_ratio: 1", "", ["motors.m.no_load_speed"]),
        # 1021 over the root of 1.05 is 996, of 1.04 1001.
        ("hinge", "gear_ratio: 1", ", reduction: 1.05", []),
        ("hinge", "gear_ratio: 1", ", reduction: 1.04", ["motors.m.no_load_speed"]),
        # By a reduction that is doubted itself nothing is judged.
        ("hinge", "gear_ratio: 1", ", reduction: 0.02", ["actuators.g.reduction"]),
    ],
)
def test_the_speed_of_a_joint_is_judged_behind_all_that_slows_it(
    tmp_path: Path, kind: str, gear: str, more: str, found: list[str]
) -> None:
    per = "m" if kind == "slide" else "N*m"
    kp, kd = ("2e4 N/m", "1.5e3 N*s/m") if per == "m" else ("100 N*m/rad", "5 N*m*s/rad")
    text = AXIS.format(kind=kind, torque=3.8, speed=5000, gear=gear, more=more, kp=kp, kd=kd)
    try:
        told = validate(document_from_text(text, str(tmp_path / "s.yaml"))).diagnostics
    except ActspecError as err:
        told = err.diagnostics
    assert [item.where for item in told if item.code in BY_CODE] == found


def test_the_speed_behind_a_linkage_is_not_known(tmp_path: Path) -> None:
    """A Jacobian of 60: what turns the knee is a screw."""
    text = AXIS.format(kind="hinge", torque=3.8, speed=5000, gear="gear_ratio: 1", more="", kp=100, kd=5)
    text = text.replace("motor: m, ", "")
    linkage = "linkages: {l: {joints: [j], motors: [m], jacobian: [[60]]}}\n"
    spec = validate(document_from_text(text + linkage, str(tmp_path / "s.yaml")))
    assert [item.where for item in spec.diagnostics if item.code in BY_CODE] == []


def test_a_direct_drive_is_no_gear_with_a_wrong_point(tmp_path: Path) -> None:
    """1.5 N*m x 4 / 0.15 m = 40 N, of a limit of 380: 1.5 cm make 400 N, and so would a gear of 10."""
    text = AXIS.format(
        kind="slide", torque=1.5, speed=4000, gear="gear_ratio: 1", more="", kp="8e3 N/m", kd="400 N*s/m"
    )
    train = "transmission: [{teeth: {driving: 16, driven: 64}}, {radius: 15 cm}]"
    text = text.replace("effort_limit: peak", f"effort_limit: 380 N, {train}")
    (found,) = validate(document_from_text(text, str(tmp_path / "s.yaml"))).diagnostics
    assert (found.where, found.help) == ("actuators.g.transmission[1].radius", "did you mean 1.5 cm?")


def test_one_limit_that_is_a_hundredth(tmp_path: Path) -> None:
    """40 N and 50 N*s/m x 2 m/s of 23 N, of 2300: dry friction tells the limit's place, the rest says no more."""
    text = AXIS.format(
        kind="slide", torque=8.36, speed=6000, gear="gear_ratio: 1", more="", kp="2e5 N/m", kd="6e3 N*s/m"
    )
    more = "transmission: [{lead: 20 mm/rev}], friction: {coulomb: 40 N, viscous: 50 N*s/m}"
    text = text.replace("effort_limit: peak", f"effort_limit: 23 N, {more}").replace(
        "gear_ratio: 1", "gear_ratio: 1, continuous_torque: 2.39 N*m, rotor_inertia: 0.775e-4"
    )
    spec = validate(document_from_text(text, str(tmp_path / "s.yaml")))
    (found,) = (item for item in resolve(spec, listed_robot(spec)).diagnostics if item.code in BY_CODE)
    assert (found.code, found.where) == ("FRC101", "actuators.g.friction.coulomb")
    assert "Or is the limit wrong (" in (found.help or "")


SPINDLE = """actspec: 1
robot: {{name: beak, model: beak.urdf}}
motors:
  screw:
    side: motor
    stall_torque: 42 mN*m
    no_load_speed: {speed}
    peak_torque: 30 mN*m
    continuous_torque: 14.9 mN*m
    rotor_inertia: 1.1 g*cm^2
    gearbox: [{{ratio: {ratio}, efficiency: 0.81}}, {{lead: {lead}, efficiency: 0.3}}]
actuators:
  beak: {{joints: [beak], motor: screw, level: ideal_pd, effort_limit: peak, kp: 9000 N/m, kd: 60 N*s/m}}
"""
"""0.03 N*m x 5.4 x 0.81 x 2 pi / 0.002 m x 0.3 = 123.67 N behind the screw."""


def said_of_spindle(
    folder: Path, effort: float, ratio: str = "5.4", lead: str = "2 mm/rev", speed: str = "9800 rpm"
) -> list[Diagnostic]:
    """What is said of a motor with a planetary and a screw behind it, beside a file with this effort."""
    (folder / "beak.urdf").write_text(
        '<robot name="beak"><link name="a"/><link name="b"/><joint name="beak" type="prismatic"><parent link="a"/>'
        f'<child link="b"/><axis xyz="1 0 0"/><limit lower="0" upper="0.03" effort="{effort}" velocity="0"/></joint>'
        "</robot>",
        encoding="utf-8",
    )
    text = SPINDLE.format(ratio=ratio, lead=lead, speed=speed)
    try:
        spec = validate(document_from_text(text, str(folder / "s.yaml")))
        found = [*resolve(spec, joints_of_text(str(folder / "beak.urdf"))).diagnostics]
    except ActspecError as err:
        found = [*err.diagnostics]
    return [item for item in found if item.code in BY_CODE]


@pytest.mark.parametrize("effort", [120, 123.67])
@pytest.mark.parametrize(
    ("ratio", "lead", "help"),
    [
        # 1236.7 N: ten times. Sound torques in mN*m are in no kgf*cm, whatever a tenth of them is.
        ("54", "2 mm/rev", "ratio: did you mean 5.4? Or lead (PLACE): did you mean 20 mm/rev?"),
        # 12.367 N: a tenth.
        ("5.4", "20 mm/rev", "ratio: did you mean 54? Or lead (PLACE): did you mean 2 mm/rev?"),
    ],
)
def test_a_ratio_or_a_lead(tmp_path: Path, effort: float, ratio: str, lead: str, help: str) -> None:
    """Of the two only the product is known."""
    assert said_of_spindle(tmp_path, effort) == []
    (found,) = said_of_spindle(tmp_path, effort, ratio, lead)
    assert found.where == "motors.screw.gearbox[0].ratio"
    place = rf"{re.escape(str(tmp_path / 's.yaml'))}:11:5[2-4]"
    assert re.sub(place, "PLACE", found.help or "") == f"one of 2 numbers is wrong. {help}"


def test_a_lead_in_inches(tmp_path: Path) -> None:
    """4.869 N: by 25.4."""
    (found,) = said_of_spindle(tmp_path, 120, lead="2 in/rev")
    assert (found.where, found.help) == ("motors.screw.gearbox[1].lead", "did you mean 2 mm/rev?")


def test_a_rotors_speed_is_in_no_degrees(tmp_path: Path) -> None:
    """9800 rpm are 1026 rad/s; 9800 deg/s would be 171."""
    (found,) = said_of_spindle(tmp_path, 120, speed="9800 rad/s")
    assert (found.where, found.help) == (
        "motors.screw.no_load_speed",
        "is it in rpm? 9800 rpm is 1026 rad/s",
    )
