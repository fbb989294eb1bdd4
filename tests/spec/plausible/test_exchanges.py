"""Two motors with a line exchanged: each gives what the robot's file has of the other's joints."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from actspec.diagnostics import ActspecError, Diagnostic, Severity
from actspec.resolution import resolve
from actspec.robot.load import joints_of_text
from actspec.spec.document import document_from_text
from actspec.spec.plausible import BY_CODE
from actspec.spec.validate import validate

JOINT = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{name}_"/>
    <limit lower="-1" upper="1" effort="{effort}" velocity="{speed}"/></joint>
"""
SPEC = """actspec: 1
robot: {{name: leg, model: leg.urdf}}
motors:
  abd: {{side: motor, peak_torque: {peaks[0]} N*m, no_load_speed: 304 rad/s, gear_ratio: {gears[0]}}}
  flex: {{side: motor, peak_torque: {peaks[1]} N*m, no_load_speed: 136 rad/s, gear_ratio: {gears[1]}}}
actuators:
  hip: {{joints: [hip], motor: {motors[0]}, level: ideal_pd, kp: 100, kd: 3, effort_limit: {limit}}}
  leg: {{joints: [knee], motor: {motors[1]}, level: ideal_pd, kp: 200, kd: 6, effort_limit: peak}}
"""
"""4.5 N*m x 25 = 112.5 N*m and 12.2 x 16 = 195.2."""


def said(
    folder: Path,
    *,
    gears: tuple[float, float] = (25, 16),
    peaks: tuple[float, float] = (4.5, 12.2),
    motors: tuple[str, str] = ("abd", "flex"),
    efforts: tuple[float, float] = (112, 195),
    limit: str = "peak",
    at_output: bool = False,
) -> list[Diagnostic]:
    """What is said of the two motors beside a file with these efforts."""
    path = folder / "leg.urdf"
    links = "".join(f'<link name="{name}"/>' for name in ("base", "hip_", "knee_"))
    hip = JOINT.format(name="hip", parent="base", effort=efforts[0], speed=12)
    knee = JOINT.format(name="knee", parent="hip_", effort=efforts[1], speed=8)
    path.write_text(f'<robot name="leg">{links}{hip}{knee}</robot>', encoding="utf-8")
    text = SPEC.format(gears=gears, peaks=peaks, motors=motors, limit=limit)
    if at_output:
        for name, stall, peak, speed in (("abd", 150, 112, 12.2), ("flex", 250, 195, 8.5)):
            sheet = f"side: joint, stall_torque: {stall}, peak_torque: {peak}, no_load_speed: {speed} rad/s"
            text = re.sub(f"  {name}: {{side: .*, gear", f"  {name}: {{{sheet}, gear", text)
    spec = validate(document_from_text(text, str(folder / "s.yaml")))
    try:
        found = resolve(spec, joints_of_text(str(path))).diagnostics
    except ActspecError as err:
        found = err.diagnostics
    return [item for item in found if item.code in BY_CODE]


@pytest.mark.parametrize(
    ("wrong", "where", "help"),
    [
        # 72 and 305 N*m.
        ({"gears": (16, 25)}, "motors.abd.gear_ratio", "are gear_ratio of 'abd' and of 'flex' ("),
        ({"peaks": (12.2, 4.5)}, "motors.abd.peak_torque", "are peak_torque of 'abd' and of 'flex' ("),
        # 195.2 N*m at the hip.
        ({"motors": ("flex", "abd")}, "actuators.leg.motor", "are motor of 'leg' and of 'hip' ("),
    ],
)
def test_two_lines_exchanged(
    tmp_path: Path, wrong: dict[str, tuple[float, float]], where: str, help: str
) -> None:
    assert said(tmp_path) == []
    (found,) = said(tmp_path, **wrong)
    assert (found.code, found.where) == ("SPEC187", where)
    assert (found.help or "").startswith(help)
    assert (found.help or "").endswith(") exchanged?")
    assert "'hip'" in found.message and "'knee'" in found.message


def test_no_exchange_where_the_other_does_not_fit(tmp_path: Path) -> None:
    """72 and 305 N*m of 112 and 250: exchanged, the second would be 1.28 times off. 112.5 of 106 is 1.06."""
    assert said(tmp_path, gears=(16, 25), efforts=(112, 250)) == []
    assert said(tmp_path, gears=(16, 25), efforts=(106, 195)) == []
    # 135 of 112.5 N*m is 1.2, which may be meant: 30 and 25 are no exchange.
    assert said(tmp_path, gears=(30, 25), efforts=(112.5, 366)) == []


def test_a_limit_of_the_spec_is_a_witness_too(tmp_path: Path) -> None:
    """A limit of 112 N*m of a motor that gives 305; one of 90 N*m is nobody's."""
    (found,) = said(tmp_path, peaks=(12.2, 4.5), limit="112 N*m")
    assert found.where == "motors.abd.peak_torque"
    assert said(tmp_path, peaks=(12.2, 4.5), limit="90 N*m") == []


def test_one_message_of_two_that_are_ten_times_off(tmp_path: Path) -> None:
    """Gears of 8 and 80: 36 and 400 N*m. Exchanged, each by itself would be told as one with a wrong point."""
    assert said(tmp_path, gears=(8, 80), peaks=(4.5, 5), efforts=(36, 400)) == []
    (found,) = said(tmp_path, gears=(80, 8), peaks=(4.5, 5), efforts=(36, 400))
    assert (found.where, "exchanged" in (found.help or "")) == ("motors.abd.gear_ratio", True)


def test_motors_exchanged_whose_peaks_are_above_their_limits(tmp_path: Path) -> None:
    """450 and 32 N*m of 200 and 25, in each other's place 18 and 0.071 times: no other figure is offered."""
    sound = {"gears": (100, 16), "peaks": (4.5, 2.0), "efforts": (200, 25)}
    assert said(tmp_path, **sound, limit="180 N*m") == []
    (found,) = said(tmp_path, **sound, limit="180 N*m", motors=("flex", "abd"))
    assert (found.where, found.code) == ("actuators.leg.motor", "SPEC187")
    assert (found.help or "").startswith("are motor of 'leg' and of 'hip' (")


def test_a_limit_far_above_its_motor_is_judged_beside_the_file(tmp_path: Path) -> None:
    """180 of 4.8 N*m, 37.5 times: nothing could be right, and whether it is the limit the file tells."""
    sound = {"gears": (100, 16), "peaks": (4.5, 0.3), "efforts": (200, 4.8)}
    (found,) = said(tmp_path, **sound, limit="180 N*m", motors=("flex", "abd"))
    assert (found.where, found.severity) == ("actuators.leg.motor", Severity.ERROR)


def test_two_motors_that_are_off_each_by_itself(tmp_path: Path) -> None:
    """45 N*m of 450 and 320 of 32: in each other's place 0.71 and 1.4 of the file's, but 4.5 and 20 times the peak."""
    found = said(tmp_path, gears=(100, 16), peaks=(0.45, 20.0), efforts=(450, 320 / 100))
    assert len(found) == 2
    assert not any("exchanged" in (item.help or "") for item in found)


def test_one_motor_of_another_group(tmp_path: Path) -> None:
    """32 N*m beside a limit of 180 N*m: the file has 200."""
    found = said(
        tmp_path,
        gears=(100, 16),
        peaks=(4.5, 2.0),
        efforts=(200, 25),
        motors=("flex", "flex"),
        limit="180 N*m",
    )
    (help,) = [item.help for item in found if item.where == "actuators.hip.effort_limit"]
    assert (
        help == "the robot's file has about the same: is another motor meant, or has this one a wrong unit?"
    )


def test_the_end_of_a_line_above_the_peak_hides_no_exchange(tmp_path: Path) -> None:
    """150 and 250 N*m at standstill are 1.34 and 1.28 times the file's 112 and 195, which the peaks are."""
    assert said(tmp_path, at_output=True) == []
    (found,) = said(tmp_path, at_output=True, motors=("flex", "abd"))
    assert found.where == "actuators.leg.motor"
    assert (found.help or "").startswith("are motor of 'leg' and of 'hip' (")


@pytest.mark.parametrize("exchanged", ["", "motor", "continuous_torque"])
def test_motors_of_which_the_joints_take_the_continuous_torque(tmp_path: Path, exchanged: str) -> None:
    """113 and 30 N*m, which the file has; the peaks, 233 and 64, are neither's."""
    path = tmp_path / "leg.urdf"
    links = "".join(f'<link name="{name}"/>' for name in ("base", "hip_", "knee_"))
    hip = JOINT.format(name="hip", parent="base", effort=113, speed=5.8)
    knee = JOINT.format(name="knee", parent="hip_", effort=30, speed=6.3)
    path.write_text(f'<robot name="leg">{links}{hip}{knee}</robot>', encoding="utf-8")
    big, small = ("sha20", "sha25") if exchanged == "motor" else ("sha25", "sha20")
    torques = (30, 113) if exchanged == "continuous_torque" else (113, 30)
    group = "level: ideal_pd, kp: 800, kd: 40, effort_limit: continuous"
    text = f"""actspec: 1
robot: {{name: leg, model: leg.urdf}}
motors:
  sha25: {{side: joint, peak_torque: 233, continuous_torque: {torques[0]}, no_load_speed: 55.4 rpm}}
  sha20: {{side: joint, peak_torque: 64, continuous_torque: {torques[1]}, no_load_speed: 60 rpm}}
actuators:
  hip: {{joints: [hip], motor: {big}, {group}}}
  knee: {{joints: [knee], motor: {small}, {group}}}
"""
    if exchanged == "continuous_torque":
        # Of a torque above its peak that is told.
        text = text.replace("peak_torque: 64", "peak_torque: 150")
    spec = validate(document_from_text(text, str(tmp_path / "s.yaml")))
    found = [item for item in resolve(spec, joints_of_text(str(path))).diagnostics if item.code in BY_CODE]
    assert len(found) == bool(exchanged)
    for item in found:
        assert item.code == "SPEC187"
        assert "continuous_torque 113 N*m" in item.message or "continuous_torque 113" in item.message
        assert (item.help or "").startswith(f"are {exchanged} of ")


@pytest.mark.parametrize(
    ("torques", "effort", "help"),
    [
        # The file's 3.5 N*m: 350 N*cm, and 496 oz*in x 0.00706155 = 3.503.
        (
            (410, 350, 130),
            3.5,
            "are stall_torque, peak_torque, continuous_torque in N*cm? 410 N*cm is 4.1 N*m",
        ),
        (
            (580, 496, 184),
            3.5,
            "are stall_torque, peak_torque, continuous_torque in oz*in? 580 oz*in is 4.096 N*m",
        ),
        (
            (4100, 3500, 1300),
            3.5,
            "are stall_torque, peak_torque, continuous_torque in mN*m? 4100 mN*m is 4.1 N*m",
        ),
    ],
)
def test_all_torques_of_a_servo_in_a_sheet_s_unit(
    tmp_path: Path, torques: tuple[int, int, int], effort: float, help: str
) -> None:
    path = tmp_path / "leg.urdf"
    hip = JOINT.format(name="hip", parent="base", effort=effort, speed=4.8)
    path.write_text(
        f'<robot name="leg"><link name="base"/><link name="hip_"/>{hip}</robot>', encoding="utf-8"
    )
    stall, peak, continuous = torques
    text = f"""actspec: 1
robot: {{name: leg, model: leg.urdf}}
motors:
  servo: {{side: joint, stall_torque: {stall} N*m, no_load_speed: 46 rpm, peak_torque: {peak} N*m,
    continuous_torque: {continuous} N*m, gear_ratio: 353.5, reflected_inertia: 0.012 kg*m^2}}
actuators:
  hip: {{joints: [hip], motor: servo, level: ideal_pd, kp: 18, kd: 0.6, effort_limit: peak}}
"""
    try:
        spec = validate(document_from_text(text, str(tmp_path / "s.yaml")))
        every = resolve(spec, joints_of_text(str(path))).diagnostics
    except ActspecError as err:
        every = err.diagnostics
    (found,) = [item for item in every if item.code in BY_CODE]
    assert (found.where, found.help) == ("motors.servo.stall_torque", help)


HUB = """actspec: 1
robot: {{name: cart, model: none, joints: [roll]}}
motors:
  hub: {{side: joint, stall_torque: {} N*m, no_load_speed: 38 rad/s, peak_torque: {} N*m,
    continuous_torque: {} N*m, gear_ratio: 1, torque_constant: {}, nominal_current: 3.5 A, peak_current: 10 A,
    rotor_inertia: 1.1e-3 kg*m^2{}}}
actuators:
  wheels: {{joints: [roll], motor: hub, level: dc_motor, command: velocity, kd: 0.5, effort_limit: peak}}
"""


@pytest.mark.parametrize("more", ["", ", nominal_voltage: 24 V"])
@pytest.mark.parametrize(
    ("torques", "constant", "where", "help"),
    [
        # 0.6 N*m/A x 10 A = 6 N*m, a hundredth of 600.
        (
            (720, 600, 210),
            "0.6 N*m/A",
            "stall_torque",
            "are stall_torque, peak_torque, continuous_torque in N*cm? 720 N*cm is 7.2 N*m",
        ),
        # With sound torques it is the one number that is wrong.
        ((7.2, 6, 2.1), "0.006 N*m/A", "torque_constant", "did you mean 0.6 N*m/A?"),
        ((7.2, 6, 2.1), "60 N*m/A", "torque_constant", "did you mean 0.6 N*m/A?"),
    ],
)
def test_all_torques_by_the_current(
    torques: tuple[float, float, float], constant: str, where: str, help: str, more: str
) -> None:
    spec = validate(document_from_text(HUB.format(*torques, constant, more), "s.yaml"))
    (found,) = [item for item in spec.diagnostics if item.code in BY_CODE]
    assert (found.help or "").removesuffix("; `sure: true` beside it keeps a number that is right") == help
    assert found.where in (f"motors.hub.{where}", "motors.hub.peak_torque")
