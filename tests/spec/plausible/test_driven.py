"""What a motor and the robot's file say of a joint: slides, limits far above the file's, gains and hints."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from actspec.diagnostics import ActspecError, Diagnostic
from actspec.resolution import resolve
from actspec.robot.load import joints_of_text
from actspec.spec.document import document_from_text
from actspec.spec.plausible import BY_CODE
from actspec.spec.validate import validate
from tests.fitting import fit, spec_of

MOTOR = (
    "side: joint, stall_torque: 200, peak_torque: 20, no_load_speed: 10 rad/s, torque_constant: 1, "
    "peak_current: 20 A"
)
"""The current says that the peak torque is right: a limit that is not is told, not the peak."""


def told(text: str) -> list[tuple[str, str, str | None]]:
    """Code, place and help of what the checks report."""
    try:
        found = fit(text).diagnostics
    except ActspecError as err:
        found = err.diagnostics
    return [(item.code, item.where, item.help) for item in found if item.code in BY_CODE]


def slide(stages: str, more: str = "", motor: str = MOTOR) -> list[tuple[str, str, str | None]]:
    """What is reported of a slide behind these stages."""
    groups = (
        f"axis: {{joints: [slide], motor: m, transmission: [{stages}], level: ideal_pd, kp: 900, kd: 90{more}}}, "
        "rest: {joints: [hip, calf], level: ideal_pd, kp: 1, kd: 1}"
    )
    return told(spec_of(groups, motors=f"{{m: {{{motor}}}}}"))


@pytest.mark.parametrize(
    ("stages", "more", "expected"),
    [
        # 20 N*m / 0.1 m = 200 N and 10 rad/s x 0.1 m = 1 m/s: three times that, and a fiftieth.
        ("{radius: 100 mm}", ", effort_limit: 600 N, velocity_limit: 3 m/s", None),
        ("{radius: 100 mm}", ", effort_limit: 601 N", ("SPEC187", "effort_limit")),
        ("{radius: 100 mm}", ", effort_limit: 4 N", None),
        ("{radius: 100 mm}", ", effort_limit: 3.9 N", ("SPEC187", "effort_limit")),
        ("{radius: 100 mm}", ", velocity_limit: 3.1 m/s", ("SPEC184", "velocity_limit")),
        # Behind a belt of 2 it is 400 N and 0.5 m/s.
        ("{ratio: 2}, {radius: 100 mm}", ", effort_limit: 1200 N", None),
        ("{ratio: 2}, {radius: 100 mm}", ", effort_limit: 1201 N", ("SPEC187", "effort_limit")),
        ("{ratio: 2}, {radius: 100 mm}", ", velocity_limit: 1.51 m/s", ("SPEC184", "velocity_limit")),
        # 10 rad/s x 3 m = 30 m/s.
        ("{radius: 3 m}", "", None),
        ("{radius: 3.1 m}", "", ("SPEC184", "transmission[0].radius")),
        # 20 N*m / 66 um = 303 kN; of a screw 2 pi x 20 / 0.4 mm = 314 kN.
        # Of 299 kN only kp is odd: it asks for them at 332 m.
        ("{radius: 67 um}", "", ("SPEC192", "kp")),
        ("{radius: 66 um}", "", ("SPEC183", "transmission[0].radius")),
        ("{lead: 0.4 mm/rev}", "", ("SPEC183", "transmission[0].lead")),
        # 10 rad/s x 20 m / 2 pi = 31.8 m/s.
        ("{lead: 20 m/rev}", "", ("SPEC184", "transmission[0].lead")),
    ],
)
def test_a_slide(stages: str, more: str, expected: tuple[str, str] | None) -> None:
    found = [(code, where.removeprefix("actuators.axis.")) for code, where, _ in slide(stages, more)]
    assert found == ([] if expected is None else [expected])


@pytest.mark.parametrize(
    ("stages", "more", "place", "help"),
    [
        ("{radius: 20 m}", "", "transmission[0].radius", "did you mean 20 mm?"),
        ("{lead: 20 m/rev}", "", "transmission[0].lead", "did you mean 20 mm/rev?"),
        ("{radius: 100 mm}", ", effort_limit: 150 kN", "effort_limit", "did you mean 150 N?"),
        (
            "{radius: 100 mm}",
            ", velocity_limit: 900 m/s",
            "velocity_limit",
            "is it in mm/s? 900 mm/s is 0.9 m/s",
        ),
        ("{teeth: {driving: 40, driven: 20}}, {radius: 100 mm}", "", "", None),
    ],
)
def test_what_was_meant_at_a_slide(stages: str, more: str, place: str, help: str | None) -> None:
    """Friction of 5 N would be more than 20 N*m / 20 m = 1 N: it is not told as well."""
    found = [
        (where.removeprefix("actuators.axis."), help)
        for _, where, help in slide(stages, f"{more}, friction: {{coulomb: 5 N}}")
    ]
    assert found == ([(place, help)] if place else [])


def test_a_stage_the_wrong_way_round() -> None:
    """1 / 0.0833 = 12."""
    motor = "side: motor, stall_torque: 2, no_load_speed: 500 rad/s, gearbox: [{ratio: 0.0833}]"
    ((code, where, help),) = slide("{radius: 20 mm}", motor=motor)
    assert (code, where) == ("SPEC182", "motors.m.gearbox[0].ratio")
    assert help is not None and help.startswith("did you mean 12?")


def gains(text: str, motor: str = MOTOR) -> list[tuple[str, str, str | None]]:
    """What is reported of a hinge with these gains."""
    groups = (
        f"legs: {{joints: [hip], motor: m, level: ideal_pd, {text}}}, "
        "rest: {joints: [calf, slide], level: ideal_pd, kp: 1, kd: 1}"
    )
    return told(spec_of(groups, motors=f"{{m: {{{motor}}}}}"))


@pytest.mark.parametrize(
    ("text", "motor", "place", "help"),
    [
        # 40 N*m/rad and 1 N*m*s/rad; per degree kp would take the 20 N*m at 20 / 2292 = 0.009 rad.
        (
            "kp: 40, kd: 57.3",
            MOTOR,
            "kd",
            "is kd multiplied by 57.3? Without that it is 1 N*m*s/rad",
        ),
        # 0.698 x 57.3 = 40, 20 / 40 = 0.5 rad; 1 / 57.3 of kd would leave 28.6 rad.
        ("kp: 0.698, kd: 1", MOTOR, "kp", "is kp per degree? Per radian it is 39.99 N*m/rad"),
        (
            "kp: 40, kd: 57.3",
            "gear_ratio: 9",
            "kp",
            "is kp given per degree, or kd (PLACE) multiplied by 57.3?",
        ),
        ("kp: 100 kN*m/rad, kd: 3", MOTOR, "kp", "did you mean 100 N*m/rad?"),
        ("kp: 100, kd: 3 mN*m*s/rad", MOTOR, "kd", "did you mean 3 N*m*s/rad?"),
        # 4011 / 57.2958 = 70.01: 1 / 70 = 14 ms, and 20 N*m at 0.29 rad.
        ("kp: 4011, kd: 1", MOTOR, "kp", "is kp multiplied by 57.3? Without that it is 70.01 N*m/rad"),
        # Of a multiple of 100 it is no such number (69.8). 40 and 4 are as usual as each other: 0.5 and 5 rad.
        ("kp: 4000, kd: 1", MOTOR, "kp", "is the point in the wrong place?"),
        (
            "kp: 4000, kd: 1",
            "gear_ratio: 9",
            "kp",
            "is kp multiplied by 57.3, or kd (PLACE) given per degree?",
        ),
    ],
)
def test_which_gain_is_wrong(text: str, motor: str, place: str, help: str) -> None:
    ((code, where, said),) = gains(text, motor)
    assert (code, where) == ("SPEC192", f"actuators.legs.{place}")
    assert re.sub(r"s\.yaml:[0-9:]+", "PLACE", said or "") == help


def test_a_slides_gain_per_mm() -> None:
    """20 N/mm are 20000 N/m; a slide has no degrees."""
    assert slide("{radius: 100 mm}", ", overrides: {slide: {kp: 20 N/m, kd: 600 N*s/m}}") == [
        (
            "SPEC192",
            "actuators.axis.overrides.slide.kp",
            "are the two exchanged? kp is the stiffness, kd the velocity gain; or is kp per mm? "
            "Per metre it is 20000 N/m",
        )
    ]


URDF = """<robot name="arm"><link name="a"/><link name="b"/>
  <joint name="hip" type="revolute"><parent link="a"/><child link="b"/>
    <limit lower="-1.2" upper="0.9" effort="{effort}" velocity="{speed}"/></joint>
</robot>
"""


def of_file(
    folder: Path, more: str, *, effort: float = 55, speed: float = 5, pose: str = "0"
) -> list[Diagnostic]:
    """What is said of a joint without a motor beside a file with these limits."""
    path = folder / "arm.urdf"
    path.write_text(URDF.format(effort=effort, speed=speed), encoding="utf-8")
    text = (
        f"actspec: 1\nrobot: {{name: arm, model: {path.name}, default_pose: {{hip: {pose}}}}}\n"
        "sources: {sheet: {title: a sheet}}\n"
        f"actuators: {{arm: {{joints: [hip], level: ideal_pd, kp: 40, kd: 2{more}}}}}\n"
    )
    spec = validate(document_from_text(text, str(folder / "s.yaml")))
    try:
        found = resolve(spec, joints_of_text(str(path))).diagnostics
    except ActspecError as err:
        found = err.diagnostics
    return [item for item in found if item.code in BY_CODE]


ALONE = ("velocity_limit", "is it in deg/s? Then it is 4.992 rad/s; or is it in rpm? Then it is 29.95 rad/s")
"""Of 286 rad/s."""


@pytest.mark.parametrize(
    ("more", "limits", "expected"),
    [
        # 5 times 55 N*m.
        (", effort_limit: 274", {}, None),
        (", effort_limit: 275", {}, ("effort_limit", "look for a wrong unit")),
        (", effort_limit: 55000", {}, ("effort_limit", "is it in mN*m? Then it is 55 N*m")),
        (", effort_limit: 550", {}, ("effort_limit", "is the point in the wrong place? Then it is 55 N*m")),
        # A placeholder, which no motor reaches.
        (", effort_limit: 1e6", {}, None),
        # Isaac Lab's hand of the Panda: 200 N of 20. From 30 times on whatever the source is.
        (", effort_limit: {value: 550 N*m, source: sheet}", {}, None),
        (", effort_limit: {value: 1651 N*m, source: sheet}", {}, ("effort_limit", "look for a wrong unit")),
        # 671 of 1000, with the root of 20 N*m.
        (", velocity_limit: 150 rad/s", {"effort": 20}, None),
        (", velocity_limit: 286 rad/s", {}, ("velocity_limit", "is it in deg/s? Then it is 4.992 rad/s")),
        # Placeholders in the spec and in the file: what the file says nothing of is judged alone.
        (", velocity_limit: 1000 rad/s", {}, None),
        (", velocity_limit: 286 rad/s", {"speed": 1}, ALONE),
        (", velocity_limit: 286 rad/s", {"speed": 0}, ALONE),
        (", velocity_limit: 286 rad/s", {"effort": 5}, ALONE),
    ],
)
def test_a_limit_far_above_the_files(
    tmp_path: Path, more: str, limits: dict[str, float], expected: tuple[str, str] | None
) -> None:
    found = [(item.where.rpartition(".")[2], item.help) for item in of_file(tmp_path, more, **limits)]
    assert found == ([] if expected is None else [expected])


QUADRUPED = """<robot name="dog"><link name="a"/><link name="b"/><link name="c"/>
  <joint name="hip" type="revolute"><parent link="a"/><child link="b"/>
    <limit lower="-1.2" upper="0.9" effort="200" velocity="23"/></joint>
  <joint name="knee" type="revolute"><parent link="b"/><child link="c"/>
    <limit lower="-1.2" upper="0.9" effort="{knee}" velocity="14"/></joint>
</robot>
"""
ROTOR = "side: motor, peak_torque: 30, continuous_torque: 11, gear_ratio: 6.6, no_load_speed: 1452 rpm"
"""At the output 198 N*m and 72.6 N*m, and 23 rad/s."""
OUTPUT = "side: joint, peak_torque: 198, continuous_torque: 11, gear_ratio: 6.6, no_load_speed: 220 rpm"


@pytest.mark.parametrize(
    ("limit", "motor", "knee", "told", "help"),
    [
        ("200", None, 320, None, None),
        ("3200", None, 320, "16 times above", "look for a wrong unit"),
        ("1000", None, 320, "5 times above", "look for a wrong unit"),
        ("2000", None, 320, "10 times above", "is the point in the wrong place? Then it is 200 N*m"),
        # 200 / 0.0980665 = 2039.
        ("2039", None, 320, "10.195 times above", "is it in kgf*cm? Then it is 200 N*m"),
        ("20", None, 320, "10 times below", "is the point in the wrong place? Then it is 200 N*m"),
        # 2 % beside a tenth tell nothing: less is often the truer limit.
        ("20.5", None, 320, None, None),
        ("30", None, 320, None, None),
        # One figure for every joint is often nobody's.
        ("3200", None, 200, None, None),
        ("{value: 1000, sure: true}", None, 320, None, None),
        # 30 x 6.6 = 198.
        ("30.1", ROTOR, 320, "6.64 times below", "is it quoted at the rotor? At the joint it is 198.66 N*m, by the"),
        ("{value: 30.1, source: sheet}", ROTOR, 320, "6.64 times below", "is it quoted at the rotor? At the joint it"),
        ("20", ROTOR, 320, "10 times below", "is the point in the wrong place? Then it is 200 N*m"),
        ("35", ROTOR, 320, None, None),
        ("30", OUTPUT, 320, None, None),
    ],
)  # fmt: skip
def test_an_effort_limit_far_from_the_files(
    tmp_path: Path, limit: str, motor: str | None, knee: float, told: str | None, help: str | None
) -> None:
    path = tmp_path / "dog.urdf"
    path.write_text(QUADRUPED.format(knee=knee), encoding="utf-8")
    text = (
        f"actspec: 1\nrobot: {{name: dog, model: {path.name}}}\nsources: {{sheet: {{title: a sheet}}}}\n"
        + ("" if motor is None else f"motors: {{m: {{{motor}}}}}\n")
        + f"actuators:\n  hips: {{joints: [hip], level: ideal_pd, kp: 400, kd: 10, effort_limit: {limit}"
        + ("}\n" if motor is None else ", motor: m}\n")
        + "  knees: {joints: [knee], level: ideal_pd, kp: 400, kd: 10}\n"
    )
    spec = validate(document_from_text(text, str(tmp_path / "s.yaml")))
    found = [item for item in resolve(spec, joints_of_text(str(path))).diagnostics if item.code in BY_CODE]
    if told is None:
        assert found == []
        return
    (one,) = found
    assert (one.code, one.where) == ("SPEC187", "actuators.hips.effort_limit")
    assert f"{told} the robot's file, which has 200 N*m" in one.message
    assert (one.help or "").startswith(help or "?")


@pytest.mark.parametrize(
    ("pose", "help"),
    [
        # 60 deg are 1.047 rad, outside; -60 deg are inside.
        ("60 deg", "is the sign wrong? -60 deg is inside"),
        ("-60 rad", "is it in degrees? Then write -60 deg, -1.047 rad"),
        ("1.5 rad", "is it in degrees? Then write 1.5 deg, 0.02618 rad"),
    ],
)
def test_a_pose_of_the_wrong_sign(tmp_path: Path, pose: str, help: str) -> None:
    (found,) = of_file(tmp_path, "", pose=pose)
    assert (found.code, found.help) == ("SPEC190", help)


@pytest.mark.parametrize(
    ("ends", "help"),
    [
        # -1.2 and 0.9 rad are -68.75 and 51.57 deg.
        ("[-69 rad, 52 rad]", "is it in degrees? Then write [-69 deg, 52 deg]"),
        ("[-1.2 deg, 0.9 deg]", "did you mean [-1.2 rad, 0.9 rad]?"),
        # 57.3 times a part of it.
        ("[-25 rad, 25 rad]", "is it in degrees? Then write [-25 deg, 25 deg]"),
        ("[-181 rad, 181 rad]", "write `command_range: joint` for the joint's own range"),
    ],
)
def test_a_command_range_in_the_wrong_unit(tmp_path: Path, ends: str, help: str) -> None:
    (found,) = of_file(tmp_path, f", command_range: {ends}")
    assert (found.code, found.where, found.help) == ("SPEC190", "actuators.arm.command_range", help)


@pytest.mark.parametrize(
    ("wrong", "place", "help"),
    [
        (
            {"nominal_current": "30 A", "peak_current": "10 A"},
            "nominal_current",
            "are nominal_current and peak_cu",
        ),
        # 1.5 N*m/A x 30 A = 45 N*m: the peak is right.
        (
            {"stall_torque": "35"},
            "stall_torque",
            "is it quoted at the rotor? At the gearbox output it is about 315",
        ),
        # Nothing proves the peak.
        (
            {"stall_torque": "35", "peak_current": "unknown"},
            "peak_torque",
            "are stall_torque and peak_torque swapped",
        ),
        ({"gear_ratio": "90"}, "gear_ratio", "did you mean 9?"),
    ],
)
def test_the_figure_that_is_wrong(wrong: dict[str, str], place: str, help: str) -> None:
    """45 N*m of 1e-4 kg*m^2 x 90: 5000 rad/s^2, and 3000 rad/s after 0.6 s; 1.5 x 33.3 rad/s = 50 of 48 V."""
    sheet = {
        "side": "joint",
        "stall_torque": "350",
        "peak_torque": "45",
        "continuous_torque": "15",
        "no_load_speed": "33.3 rad/s",
        "torque_constant": "1.5",
        "nominal_voltage": "48 V",
        "nominal_current": "10 A",
        "peak_current": "30 A",
        "gear_ratio": "9",
        "rotor_inertia": "1e-4",
    }
    right = ", ".join(f"{key}: {value}" for key, value in sheet.items())
    assert gains("kp: 60, kd: 2", right) == []
    motor = ", ".join(f"{key}: {value}" for key, value in {**sheet, **wrong}.items())
    ((_, where, found),) = gains("kp: 60, kd: 2", motor)
    assert where == f"motors.m.{place}" and (found or "").startswith(help)


def test_a_heavy_rotor_does_not_hide_a_wrong_peak() -> None:
    """0.65 N*m/A x 40 A = 26 N*m; 25 / 0.008 kg*m^2 = 3125 rad/s^2 is little for a rotor, and sound."""
    hub = (
        "side: joint, stall_torque: 60, peak_torque: {}, continuous_torque: 8, no_load_speed: 500 rpm, "
        "torque_constant: 0.65, nominal_voltage: 36 V, peak_current: 40 A, gear_ratio: 1, rotor_inertia: 0.008"
    )
    assert gains("kp: 10, kd: 1", hub.format(25)) == []
    ((_, where, help),) = gains("kp: 10, kd: 1", hub.format(0.25))
    assert (where, help) == ("motors.m.peak_torque", "did you mean 25 N*m?")


LINE = "side: joint, stall_torque: 36, no_load_speed: 20 rad/s"
CURVE = (
    "side: joint, curve: {drive_torque: 20, brake_torque: 36, knee_speed: 10 rad/s, no_load_speed: 20 rad/s}"
)


@pytest.mark.parametrize(
    ("motor", "group", "end"),
    [
        # 1.25 x 36 N*m = 45 N*m.
        (LINE, "level: dc_motor, effort_limit: 45", None),
        (LINE, "level: dc_motor, effort_limit: 45.1", "36 N*m"),
        # Where no line acts the limit is what a drive is asked for.
        (LINE, "level: ideal_pd, effort_limit: 46", None),
        # Behind a reduction of 2 the line begins at 72 N*m, and 1.25 times that are 90.
        (LINE, "level: dc_motor, reduction: 2, effort_limit: 90", None),
        (LINE, "level: dc_motor, reduction: 2, effort_limit: 90.1", "72 N*m"),
        # A curve's larger torque, which brakes.
        (CURVE, "level: dc_motor, effort_limit: 45", None),
        (CURVE, "level: dc_motor, effort_limit: 45.1", "36 N*m"),
        # From 3 times on the motor's torque says it: one message.
        (LINE, "level: dc_motor, effort_limit: 109", "is 3.03 times above"),
        # Nobody wrote the limit: it is the peak torque, which SPEC180 leaves here.
        (f"{LINE}, peak_torque: 36.5", "level: dc_motor", None),
    ],
)
def test_an_effort_limit_above_the_line(motor: str, group: str, end: str | None) -> None:
    """At level dc_motor the line is the least that clamps: such a limit is dead, and the two may be swapped."""
    groups = f"legs: {{joints: [hip, calf], motor: m, kp: 40, kd: 1, {group}}}, "
    groups += "rest: {joints: [slide], level: ideal_pd, kp: 1, kd: 1}"
    found = [d for d in fit(spec_of(groups, motors=f"{{m: {{{motor}}}}}")).diagnostics if d.code in BY_CODE]
    assert [(d.code, d.where, str(end) in d.message) for d in found] == [
        ("SPEC187", "actuators.legs.effort_limit", True)
    ] * (end is not None)
