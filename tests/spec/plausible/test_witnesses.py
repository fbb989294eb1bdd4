"""Limits of the robot's file as witnesses of a motor's figures: the wrong figure is told, placeholders tell nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.diagnostics import ActspecError, Diagnostic
from actspec.resolution import resolve
from actspec.robot.load import joints_of_text
from actspec.spec.document import document_from_text
from actspec.spec.plausible import BY_CODE
from actspec.spec.validate import validate

URDF = """<robot name="arm"><link name="a"/><link name="b"/>
  <joint name="hip" type="revolute"><parent link="a"/><child link="b"/>
    <limit lower="-1" upper="1" effort="{effort}" velocity="{speed}"/></joint>
</robot>
"""
GEARED = {
    # 120 rad/s and 0.6 N*m behind a gear of 10 are 12 rad/s and 6 N*m.
    "side": "motor",
    "peak_torque": "0.6",
    "no_load_speed": "120 rad/s",
    "gear_ratio": "10",
}
SERVO = {"side": "joint", "stall_torque": "1.4", "no_load_speed": "57 rpm", "gear_ratio": "258"}
"""5.97 rad/s."""


def said(
    folder: Path, sheet: dict[str, str], *, effort: float, speed: float, limits: str = "", **wrong: str
) -> list[Diagnostic]:
    """What is said of a motor beside a file with these limits."""
    path = folder / "arm.urdf"
    path.write_text(URDF.format(effort=effort, speed=speed), encoding="utf-8")
    motor = ", ".join(f"{key}: {value}" for key, value in {**sheet, **wrong}.items())
    text = (
        f"actspec: 1\nrobot: {{name: arm, model: {path.name}}}\nmotors: {{m: {{{motor}}}}}\n"
        f"actuators: {{arm: {{joints: [hip], motor: m, level: ideal_pd, kp: 4, kd: 0.1{limits}}}}}\n"
    )
    spec = validate(document_from_text(text, str(folder / "s.yaml")))
    try:
        return [item for item in resolve(spec, joints_of_text(str(path))).diagnostics if item.code in BY_CODE]
    except ActspecError as err:
        return [*err.diagnostics]


@pytest.mark.parametrize(
    ("sheet", "effort", "speed", "wrong", "code", "place", "help"),
    [
        # 120 rad/s and 0.6 N*m at the joint: ten times the speed and a tenth of the torque.
        (GEARED, 6, 12, {"gear_ratio": "1"}, "SPEC187", "gear_ratio", "is a gear forgotten? gear_ratio is"),
        (GEARED, 6, 12, {"peak_torque": "6"}, "SPEC187", "peak_torque", "is it quoted at the gearbox output"),
        # Of 6 N*m.
        (
            {"peak_torque": "0.6", "side": "motor", "gear_ratio": "10"},
            6,
            12,
            {"side": "joint"},
            "SPEC187",
            "side",
            # The torque is the only figure of the side.
            "one of 2 values is wrong. side: are the figures those of the rotor? Then write `side: motor`. Or "
            "peak_torque (",
        ),
        # 1146 rpm is 120 rad/s.
        (
            GEARED,
            6,
            12,
            {"no_load_speed": "1146 rad/s"},
            "SPEC184",
            "no_load_speed",
            "is it in rpm? 1146 rpm is 120",
        ),
        # 14.3 x 0.0980665 = 1.402 N*m.
        (
            SERVO,
            1.4,
            6,
            {"stall_torque": "14.3"},
            "SPEC187",
            "stall_torque",
            "is it in kgf*cm? 14.3 kgf*cm is 1.402 N*m",
        ),
        # 5.7 rpm is 0.597 rad/s.
        (SERVO, 1.4, 6, {"no_load_speed": "5.7 rpm"}, "SPEC184", "no_load_speed", "did you mean 5.7 rad/s?"),
    ],
)
def test_the_file_tells_a_wrong_figure(
    tmp_path: Path,
    sheet: dict[str, str],
    effort: float,
    speed: float,
    wrong: dict[str, str],
    code: str,
    place: str,
    help: str,
) -> None:
    assert said(tmp_path, sheet, effort=effort, speed=speed) == []
    (found,) = said(tmp_path, sheet, effort=effort, speed=speed, **wrong)
    assert (found.code, found.where) == (code, f"motors.m.{place}")
    assert (found.help or "").startswith(help)
    assert "the robot's file gives the joint 'hip' " in found.message


@pytest.mark.parametrize(
    ("peak", "help"),
    [
        # 35.278 / 0.0980665 = 359.74; a tenth of it is 1.02 times the file's.
        ("359.74", "is it in kgf*cm? 359.74 kgf*cm is 35.28 N*m"),
        ("352.78", "did you mean 35.278 N*m?"),
        # 36.9 is 1.046 times the file's, 42 is 1.19 times.
        ("369", "did you mean 36.9 N*m?"),
        ("420", "is the point in the wrong place?"),
    ],
)
def test_a_figure_is_offered_near_the_files(tmp_path: Path, peak: str, help: str) -> None:
    sheet = {"side": "joint", "peak_torque": "35.278"}
    assert said(tmp_path, sheet, effort=35.278, speed=20) == []
    (found,) = said(tmp_path, sheet, effort=35.278, speed=20, peak_torque=peak)
    assert (found.where, found.help) == ("motors.m.peak_torque", help)
    # A limit that agrees with the file says nothing of the torque.
    (found,) = said(
        tmp_path, sheet, effort=35.278, speed=20, peak_torque="352.78", limits=", effort_limit: 35.278"
    )
    assert found.help == "did you mean 35.278 N*m?"


@pytest.mark.parametrize("limit", ["", ", effort_limit: peak", ", effort_limit: 9"])
def test_a_reduction_of_the_group(tmp_path: Path, limit: str) -> None:
    """6 N*m and 12 rad/s behind 1.55 are 9.3 N*m and 7.74 rad/s, whether the spec states a limit or not."""
    sheet = {"side": "joint", "peak_torque": "6", "no_load_speed": "12 rad/s"}
    assert said(tmp_path, sheet, effort=9.3, speed=7.74, limits=f"{limit}, reduction: 1.55") == []
    (found,) = said(tmp_path, sheet, effort=9.3, speed=7.74, limits=f"{limit}, reduction: 15.5")
    assert found.where == "actuators.arm.reduction"
    assert found.help == "did you mean 1.55? reduction is turns of the motor's output in one of the joint"


@pytest.mark.parametrize(("limits", "told"), [("6 rpm", True), ("0.6 rad/s", False), ("6 rad/s", False)])
def test_a_limit_in_another_unit(tmp_path: Path, limits: str, told: bool) -> None:
    """6 rpm is 0.628 rad/s; a tenth of the file's limit may be meant."""
    found = said(tmp_path, SERVO, effort=1.4, speed=6, limits=f", velocity_limit: {limits}")
    assert [item.where for item in found] == ["actuators.arm.velocity_limit"] * told
    assert [item.help for item in found] == ["did you mean 6 rad/s?"] * told


@pytest.mark.parametrize(
    ("effort", "speed"),
    [
        # Placeholders: powers of ten, none, and an exporter's two equal ones.
        (100, 1000),
        (1, 1),
        (0, 0),
        (1e9, 1e9),
        (30, 30),
        # 6 N*m and 12 rad/s of 29.9 and 59.9: below five times.
        (29.9, 59.9),
    ],
)
def test_no_witness(tmp_path: Path, effort: float, speed: float) -> None:
    assert said(tmp_path, GEARED, effort=effort, speed=speed) == []


def test_a_windings_stall_torque_is_no_limit(tmp_path: Path) -> None:
    """6 N*m of the drive, 60 of the winding, at the joint."""
    assert said(tmp_path, GEARED, effort=6, speed=12, stall_torque="6") == []


@pytest.mark.parametrize(
    ("peak", "speed", "limits"),
    [
        # 10 N*m and 10 rad/s at the joint: a power of ten would explain 100 N*m, did it say anything.
        ("1", "100 rad/s", (100, 11)),
        # 3 N*m and 30 rad/s: likewise.
        ("0.3", "300 rad/s", (30, 30)),
    ],
)
def test_a_placeholder_is_no_witness(
    tmp_path: Path, peak: str, speed: str, limits: tuple[float, float]
) -> None:
    said_of = said(tmp_path, GEARED, effort=limits[0], speed=limits[1], peak_torque=peak, no_load_speed=speed)
    assert said_of == []


def test_a_limit_that_no_slip_brings_to_the_file(tmp_path: Path) -> None:
    """Of 3200 N*m 320 are 1.6 times the file's 200, and 32 a sixth of them; the motor gives 30 x 6.6 = 198."""
    agreed = "did you mean 200 N*m? The motor and the robot's file agree on that"
    sheet = {"side": "motor", "gear_ratio": "6.6", "peak_torque": "30", "continuous_torque": "11"}
    for limit, help in (("3200", agreed), ("1980", "did you mean 198 N*m?")):
        (found,) = said(tmp_path, sheet, effort=200, speed=23, limits=f", effort_limit: {limit}")
        assert (found.code, found.where, found.help) == ("SPEC187", "actuators.arm.effort_limit", help)


@pytest.mark.parametrize(
    ("limits", "field", "help"),
    [
        # 5.36 and 3.57 times what motor and file have: a tenth, 15 and 10 N*m, is neither's.
        (
            "effort_limit: 150",
            "effort_limit",
            "did you mean 28 N*m? The motor and the robot's file agree on that",
        ),
        (
            "effort_limit: 100",
            "effort_limit",
            "did you mean 28 N*m? The motor and the robot's file agree on that",
        ),
        # Where a slip makes it theirs, that is told.
        ("effort_limit: 280", "effort_limit", "did you mean 28 N*m?"),
        (
            "velocity_limit: 15 rad/s",
            "velocity_limit",
            "did you mean 3.2 rad/s? The motor and the robot's file agree on that",
        ),
    ],
)
def test_a_limit_beside_motor_and_file(tmp_path: Path, limits: str, field: str, help: str) -> None:
    sheet = {"side": "joint", "peak_torque": "28", "no_load_speed": "3.8 rad/s"}
    (found,) = said(tmp_path, sheet, effort=28, speed=3.2, limits=f", {limits}")
    assert (found.where, found.help) == (f"actuators.arm.{field}", help)


def test_of_motor_and_limit_the_file_tells_the_motor(tmp_path: Path) -> None:
    """A torque of 2.8 N*m beside a limit and a file of 28."""
    sheet = {"side": "joint", "peak_torque": "2.8"}
    (found,) = said(tmp_path, sheet, effort=28, speed=3.2, limits=", effort_limit: 28")
    assert (found.where, found.help) == ("motors.m.peak_torque", "did you mean 28 N*m?")


def test_a_large_arm(tmp_path: Path) -> None:
    """40 N*m x 183 x 0.8 = 5856 N*m and 12 kW are an industrial arm's; beside them the kp of 4 N*m/rad is told."""
    sheet = {
        "side": "motor",
        "peak_torque": "40",
        "no_load_speed": "3600 rpm",
        "gear_ratio": "183",
        "efficiency": "0.8",
        "rotor_inertia": "3.8e-3",
    }
    assert [item.code for item in said(tmp_path, sheet, effort=0, speed=2)] == ["SPEC192"]
    # 800 x 183 x 0.8 = 117 kN*m, of no gear a robot of a usual size; the file may say it, too.
    vast = {**sheet, "peak_torque": "800", "no_load_speed": "60 rad/s", "rotor_inertia": "0.08"}
    (found,) = said(tmp_path, vast, effort=0, speed=2)
    assert (found.code, found.where) == ("SPEC183", "motors.m.peak_torque")
    assert (found.help or "").startswith("look for a wrong unit: mN*m as N*m, rpm as rad/s; `sure: true`")
    assert [item.code for item in said(tmp_path, vast, effort=117000, speed=2)] == ["SPEC192"]
    # 1.1 x 1200 x 0.8 = 1056 N*m behind 1200 turns; with a tenth of the gear it is a robot's.
    motor = {"peak_torque": "1.1", "no_load_speed": "2400 rpm", "gear_ratio": "1200", "rotor_inertia": "2e-5"}
    (found,) = said(tmp_path, {**sheet, **motor}, effort=0, speed=2)
    assert (found.help or "").startswith("did you mean 120?")


SHEET = {
    "side": "joint",
    "stall_torque": "62.6",
    "peak_torque": "48",
    "continuous_torque": "18",
    "no_load_speed": "33.5 rad/s",
    "gear_ratio": "9",
}


@pytest.mark.parametrize(
    ("wrong", "where", "help"),
    [
        (("626", "480", "180"), "stall_torque", "10 times too large? A tenth of 626 N*m is 62.6 N*m"),
        # 489 kgf*cm are 47.95 N*m; a tenth, 48.9, is not the file's 48.
        (("638", "489", "184"), "stall_torque", "in kgf*cm? 638 kgf*cm is 62.57 N*m"),
    ],
)
def test_all_torques_ten_times_too_large(
    tmp_path: Path, wrong: tuple[str, str, str], where: str, help: str
) -> None:
    """The file tells a factor of 10 from kgf*cm, which is 10.2."""
    assert said(tmp_path, SHEET, effort=48, speed=33) == []
    keys = ("stall_torque", "peak_torque", "continuous_torque")
    (found,) = said(tmp_path, SHEET, effort=48, speed=33, **dict(zip(keys, wrong, strict=True)))
    assert (found.code, found.where) == ("SPEC187", f"motors.m.{where}")
    assert found.help == f"are {', '.join(keys)} {help}"


def test_two_digits_exchanged(tmp_path: Path) -> None:
    """84 is above the 62.6 at standstill, and 48 is the file's; 84 beside a file of 60 may be the other's figure."""
    (found,) = said(tmp_path, SHEET, effort=48, speed=33, peak_torque="84")
    help = "are two digits exchanged? With 48 N*m it is what the robot's file has"
    assert (found.code, found.where, found.help) == ("SPEC180", "motors.m.peak_torque", help)
    (found,) = said(tmp_path, SHEET, effort=60, speed=33, peak_torque="84")
    assert found.help == "are stall_torque and peak_torque swapped?"


def test_a_zero_too_many_is_no_exchange_of_digits(tmp_path: Path) -> None:
    """400 is 40, the file's, with its point in another place, and not 040."""
    (found,) = said(tmp_path, SHEET, effort=40, speed=33, peak_torque="400")
    assert (found.code, found.where) == ("SPEC180", "motors.m.peak_torque")
    assert found.help == "did you mean 40 N*m?"


@pytest.mark.parametrize(
    ("wrong", "help"),
    [
        # 480 rad/s are 59 V, 4800 rpm 61.8 V.
        ({"no_load_speed": "480 rpm"}, "did you mean 480 rad/s? Or did you mean 4800 rpm (502.7 rad/s)?"),
        # 60 / (2 pi 100) = 0.0955: 100 rpm/V x 48 V are just 4800 rpm; 0.1 is nearer to 2.48 / 23.2 = 0.107.
        ({"torque_constant": "100"}, "is it Kv, in rpm/V? Then the constant is 60 / (2 pi Kv), 0.0955 N*m/A"),
        # 5000 rpm are not.
        (
            {"torque_constant": "100", "no_load_speed": "5000 rpm"},
            "is it in mN*m/A? 100 mN*m/A is 0.1 N*m/A",
        ),
    ],
)
def test_figures_of_a_rotor(tmp_path: Path, wrong: dict[str, str], help: str) -> None:
    """0.123 N*m/A x 502.7 rad/s are 61.8 V of 48: a published sheet. The file's speed is a placeholder."""
    sheet = {
        "side": "motor",
        "peak_torque": "2.48",
        "no_load_speed": "4800 rpm",
        "gear_ratio": "10",
        "torque_constant": "0.123",
        "peak_current": "23.2 A",
        "nominal_voltage": "48 V",
    }
    assert said(tmp_path, sheet, effort=24.8, speed=1000) == []
    (found,) = said(tmp_path, sheet, effort=24.8, speed=1000, **wrong)
    assert found.help == help
