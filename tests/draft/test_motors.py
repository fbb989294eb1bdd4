"""Groups, overrides and motors that the figures of a robot suggest; and that a spec of a spec is the same."""

from __future__ import annotations

import math
import os
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

from actspec import api
from actspec.diagnostics import Span
from actspec.draft import draft
from actspec.draft.combine import combine
from actspec.draft.sources import RobotReading, places
from actspec.ir import ActuatorSet, Origin, Quantity
from actspec.lift import Lifted
from actspec.readings.artifact import Artifact, FileKind
from actspec.resolution import resolve
from actspec.robot.load import load_robot
from actspec.spec.document import document_from_text
from actspec.spec.validate import validate
from tests.importing import Imported, bare, imported, mjcf, write

LINK = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
PARTS = ("hip", "thigh", "calf")


def urdf(limits: dict[str, tuple[float, float]], sides: tuple[str, ...] = ("FL", "FR")) -> str:
    """A quadruped's legs; each part of them has (effort, velocity)."""
    text = '<robot name="dog"><link name="base"/>'
    for side in sides:
        parent = "base"
        for part, (effort, speed) in limits.items():
            name = f"{side}_{part}"
            text += (
                f'<link name="{name}">{LINK}</link><joint name="{name}_joint" type="revolute">'
                f'<parent link="{parent}"/><child link="{name}"/>'
                f'<limit lower="-1" upper="1" effort="{effort}" velocity="{speed}"/></joint>'
            )
            parent = name
    return text + "</robot>"


def read(folder: Path, limits: dict[str, tuple[float, float]]) -> Imported:
    """The legs, imported."""
    return imported(write(folder, dog_urdf=urdf(limits)), folder)


def test_knee_behind_more_gear(tmp_path: Path) -> None:
    """The Go2's limits give one motor, and its calf a reduction of 45.43 / 23.7; every limit stays the file's."""
    found = read(tmp_path, {"hip": (23.7, 30.1), "thigh": (23.7, 30.1), "calf": (45.43, 15.7)})
    # 23.7 x 30.1 = 713.37 W, 45.43 x 15.7 = 713.25 W.
    assert bare(found.data["motors"]) == {"legs_motor": {"side": "joint", "peak_torque": "23.7 N*m"}}
    (legs,) = bare(found.data["actuators"]).values()
    assert legs["motor"] == "legs_motor"
    assert legs["effort_limit"] == "23.7 N*m"
    assert legs["overrides"] == {
        ".*_calf_joint": {
            "reduction": 1.91687763713,
            "effort_limit": "45.43 N*m",
            "velocity_limit": "15.7 rad/s",
        }
    }
    assert found.draft.inferred == (
        "FL_calf_joint, FR_calf_joint: inferred: 45.43 N*m x 15.7 rad/s are the 23.7 N*m x 30.1 rad/s of FL_hip_joint "
        "behind 1.917 times the gear",
    )


@pytest.mark.parametrize(
    "calf",
    [
        # 1 % more power: two motors. The audit's GEA101 still asks.
        (45.43, 15.86),
        (23.7, 15.7),
        # More power by far.
        (45.43, 30.1),
        # 1.05 times the torque at 1 / 1.05 of the speed: rounding of one figure.
        (24.885, 28.667),
    ],
    ids=["other power", "slower alone", "stronger alone", "no ratio"],
)
def test_other_motors(tmp_path: Path, calf: tuple[float, float]) -> None:
    """Where power or ratio speak against it nothing is inferred."""
    found = read(tmp_path, {"hip": (23.7, 30.1), "thigh": (23.7, 30.1), "calf": calf})
    assert found.draft.inferred == ()
    assert "motors" not in found.data


def test_other_limb(tmp_path: Path) -> None:
    """Joints of an arm and a leg may have two motors of one power."""
    text = urdf({"hip": (20, 30), "calf": (40, 15)}).replace("calf", "elbow")
    found = imported(write(tmp_path, dog_urdf=text), tmp_path)
    assert found.draft.inferred == ()
    assert list(found.data["actuators"]) == ["hips", "elbows"]


DC_CFG = """from isaaclab.actuators import DCMotorCfg
from isaaclab.assets import ArticulationCfg

DOG_CFG = ArticulationCfg(
    actuators={
        "hips": DCMotorCfg(joint_names_expr=[".*_(hip|thigh)_joint"], effort_limit=20.0, saturation_effort=24.0,
                           velocity_limit=30.0, stiffness=25.0, damping=0.5),
        "calves": DCMotorCfg(joint_names_expr=[".*_calf_joint"], effort_limit=40.0, saturation_effort=48.0,
                             velocity_limit=SPEED, stiffness=25.0, damping=0.5),
    },
)
"""


@pytest.mark.parametrize("speed, shared", [(15.0, True), (15.05, False)], ids=["exact", "nearly"])
def test_torque_speed_line_behind_a_gear(tmp_path: Path, speed: float, shared: bool) -> None:
    """One motor's line is shared only where the reduction gives the file's own numbers; else it is a question."""
    paths = write(
        tmp_path,
        dog_urdf=urdf(dict.fromkeys(PARTS, (50, 50))),
        dog_py=DC_CFG.replace("SPEED", str(speed)),
    )
    found = imported(paths, tmp_path)
    motors = bare(found.data["motors"])
    line = {"side": "joint", "stall_torque": "24 N*m", "no_load_speed": "30 rad/s"}
    assert next(iter(motors.values())) == line
    assert (len(motors) == 1) is shared
    (told,) = found.draft.inferred
    assert ("inferred: " in told) is shared
    question = (
        ".*_calf_joint: the motor of FL_hip_joint behind 2 times the gear? 48 N*m x 15.05 rad/s are its"
    )
    assert (question in found.draft.text) is not shared
    (tmp_path / "spec.yaml").write_text(found.draft.text, encoding="utf-8")
    calf = api.resolve(tmp_path / "spec.yaml").joint("FL_calf_joint")
    assert calf is not None and calf.stall_torque is not None and calf.no_load_speed is not None
    assert calf.stall_torque.value == pytest.approx(48.0, rel=1e-9)
    assert calf.no_load_speed.value == pytest.approx(speed, rel=1e-9)


def test_three_fields_make_a_group(tmp_path: Path) -> None:
    """Joints of one limb that differ in three fields have a group of their own; in two, an override."""
    joints = "\n".join(
        f'<joint name="{part}_joint" armature="{a}"/>' for part, a in zip(PARTS, (1, 1, 2), strict=True)
    )
    servos = "".join(
        f'<position joint="{part}_joint" kp="{kp}" kv="{kd}"/>'
        for part, kp, kd in zip(PARTS, (10, 10, 20), (1, 1, 2), strict=True)
    )
    found = imported(write(tmp_path, leg_xml=mjcf(joints, servos)), tmp_path)
    assert list(found.data["actuators"]) == ["legs", "calf"]
    same = servos.replace('kv="2"', 'kv="1"')
    found = imported(write(tmp_path, leg_xml=mjcf(joints, same)), tmp_path)
    (legs,) = bare(found.data["actuators"]).values()
    assert legs["overrides"] == {"calf_joint": {"kp": "20 N*m/rad", "armature": "2 kg*m^2"}}


def test_kv_and_joint_damping(tmp_path: Path) -> None:
    """Joint damping beside a kv is friction, kv is kd, and the sum is told."""
    text = mjcf('<joint name="j" damping="2"/>', '<position joint="j" kp="100" kv="0.5"/>')
    found = imported(write(tmp_path, leg_xml=text), tmp_path)
    (group,) = bare(found.data["actuators"]).values()
    assert (group["kd"], group["friction"]["viscous"]) == ("0.5 N*m*s/rad", "2 N*m*s/rad")
    assert (
        "joint damping beside the servo's kv: 2.5 N*m*s/rad together; the effort limit does not clamp this part"
        in found.draft.text
    )


def test_pose_that_nobody_states(tmp_path: Path) -> None:
    """The first keyframe is the pose; where the zero of a joint lies says nothing about one."""
    joints = '<joint name="j" ref="0.5"/>\n<joint name="k"/>'
    text = mjcf(joints, '<motor joint="j"/><motor joint="k"/>', '<compiler angle="radian"/>')
    assert "default_pose" not in imported(write(tmp_path, leg_xml=text), tmp_path).data["robot"]
    key = '<keyframe><key qpos="0 0.2"/></keyframe>'
    found = imported(write(tmp_path, leg_xml=text.replace("</mujoco>", f"{key}</mujoco>")), tmp_path)
    assert bare(found.data["robot"]["default_pose"]) == {"k": "0.2 rad"}


def test_limits_that_are_none(tmp_path: Path) -> None:
    """A servo without a limit says so; an effort of 0 is nobody's limit."""
    text = mjcf('<joint name="j"/>', '<position joint="j" kp="100"/>')
    found = imported(write(tmp_path, leg_xml=text), tmp_path)
    assert "effort_limit: unknown    # the file has no limit\n" in found.draft.text
    found = read(tmp_path, {"hip": (0, 0)})
    (group,) = bare(found.data["actuators"]).values()
    assert (group["effort_limit"], group["velocity_limit"]) == ("unknown", "unknown")
    assert "effort_limit: unknown    # the file says 0 N*m, which is a placeholder\n" in found.draft.text


@pytest.mark.parametrize(
    "lines, expected",
    [
        ([(("a.xml"), 3)], "a.xml:3"),
        ([("a.xml", 3), ("a.xml", 4), ("a.xml", 9), ("b.py", 1)], "a.xml:3, 4, 9; b.py:1"),
        ([("a.xml", n) for n in (3, 4, 5)], "a.xml:3 to 5"),
        ([("a.xml", n) for n in (1, 3, 5, 7, 9)], "a.xml:1 to 9"),
        ([("a.xml", 0)], "a.xml"),
    ],
    ids=["one", "two files", "run", "many", "whole file"],
)
def test_places(lines: list[tuple[str, int]], expected: str) -> None:
    """Lines of a file are told as runs, many of them as a range."""
    assert places([Span(path, line) for path, line in lines]) == expected


# --- the same again -------------------------------------------------------------------------------

ROOT = Path(__file__).resolve().parents[2]

UNDERIVED = (Origin.DEFAULT, Origin.UNKNOWN)
"""A default that nobody stated is written as `unknown`, which keeps it."""

PLACES = ("group", "pattern", "motor", "gear", "span", "inertia_held", "inertia_free")
"""What depends on names in the spec, not on the actuators, and the motor's gear, behind figures at the joint."""

SPEC = """actspec: 1
robot: {name: leg, model: leg.xml, default_pose: {".*_hip": 0.5 rad}}
timing: {physics_dt: 4 ms, decimation: 5}
motors:
  line: {side: motor, gear_ratio: 9, stall_torque: 2 N*m, no_load_speed: 90 rad/s, rotor_inertia: 1e-4 kg*m^2}
  curve:
    side: joint
    curve: {drive_torque: 20 N*m, brake_torque: 25 N*m, knee_speed: 14 rad/s, no_load_speed: 30 rad/s}
    peak_torque: 20 N*m
    continuous_torque: 8 N*m
actuators:
  hips:
    joints: [".*_hip"]
    motor: line
    level: dc_motor
    kp: {derive: torque_at_error, fraction: 0.5, error: 0.2 rad}
    kd: 0.5 N*m*s/rad
    friction: {coulomb: 0.1 N*m, viscous: 0.02 N*m*s/rad, static: 0.2 N*m, stribeck_velocity: 0.5 rad/s}
    command_filter: {cutoff: 30 Hz}
    delay: {nominal: 5 ms, range: [0 ms, 10 ms]}
    encoder_bias: 0.01 rad
    action_scale: 0.25
    overrides: {left_hip: {kd: 0.7 N*m*s/rad}}
    randomize:
      kp: {scale: [0.75, 1.5], distribution: log_uniform, when: startup}
      encoder_bias: {add: [-0.02 rad, 0.02 rad], per: env}
      delay: {abs: [0 ms, 8 ms], when: interval, every: [5 s, 10 s]}
      friction.coulomb: {scale: [1, 0.1], distribution: gaussian}
  knees:
    joints: [".*_knee"]
    motor: curve
    level: dc_motor
    kp: {value: 20 N*m/rad, std: 0.5 N*m/rad}
    kd: unknown
    velocity_limit: 10 rad/s
    command_range: [-1 rad, 2 rad]
    delay: {nominal: unknown, range: [0 ms, 10 ms], sampling: step}
  slides: {joints: [".*_slide"], level: ideal_pd, command: velocity, kd: 100 N*s/m, effort_limit: 200 N}
  wheels: {joints: [".*_wheel"], level: ideal_pd, command: effort, effort_limit: 5 N*m, armature: 0.01,
           delay: {nominal: 4 ms, sampling: step}}
"""


def _set(path: Path) -> ActuatorSet:
    return api.resolve(path)


def again(actuators: ActuatorSet, model: Path, folder: Path) -> ActuatorSet:
    """The actuators, written as a spec and resolved once more."""
    artifact = Artifact("spec.yaml", FileKind.SPEC, actuators.robot, spec=actuators)
    reading = RobotReading(Lifted(actuators), artifact)
    found = draft(combine([reading]), os.path.relpath(model, folder), [])
    path = folder / "again.yaml"
    path.write_text(found.text, encoding="utf-8")
    return resolve(validate(document_from_text(found.text, str(path))), load_robot(str(model)))


def plain(value: Any) -> Any:
    """A field of an actuator without places and origins; a default is unknown."""
    if isinstance(value, Quantity):
        known = value.value is not None and value.origin not in UNDERIVED
        return (value.value, value.unit, value.std) if known else (None, value.unit, None)
    if isinstance(value, tuple):
        return [plain(item) for item in value]
    if hasattr(value, "__dataclass_fields__"):
        return {f.name: plain(getattr(value, f.name)) for f in fields(value) if f.name != "span"}
    return value


def near(one: Any, other: Any) -> bool:
    """Whether two fields are the same, but for rounding of computed numbers to 12 digits."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(near(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple) and isinstance(other, list | tuple):
        return len(one) == len(other) and all(map(near, one, other))
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=1e-11)
    return bool(one == other)


def check_same(one: ActuatorSet, other: ActuatorSet) -> None:
    """Every field of every joint is the same."""
    assert [j.joint for j in one.joints] == [j.joint for j in other.joints]
    assert set(one.unmanaged) == set(other.unmanaged)
    assert (plain(one.physics_dt), one.decimation) == (plain(other.physics_dt), other.decimation)
    for first, second in zip(one.joints, other.joints, strict=True):
        for field in fields(first):
            if field.name in PLACES:
                continue
            a, b = plain(getattr(first, field.name)), plain(getattr(second, field.name))
            assert near(a, b), (first.joint, field.name, a, b)


def test_spec_of_a_spec(tmp_path: Path) -> None:
    """A spec written from what a spec resolves to resolves to the same, field by field."""
    names = [f"{side}_{part}" for side in ("left", "right") for part in ("hip", "knee", "slide", "wheel")]
    text = mjcf(
        "\n".join(
            f'<joint name="{name}" type="{"slide" if "slide" in name else "hinge"}" range="-1 2"/>'
            for name in names
        )
        + '\n<joint name="spare"/>',
        '<motor joint="left_hip"/>',
        '<compiler angle="radian"/>',
    )
    write(tmp_path, leg_xml=text, spec_yaml=SPEC)
    first = _set(tmp_path / "spec.yaml")
    check_same(first, again(first, tmp_path / "leg.xml", tmp_path))


@pytest.mark.parametrize("name", ["a1", "a1_stiff"])
def test_robot_library_again(name: str, tmp_path: Path) -> None:
    """Our own robots survive being written as a spec."""
    path = ROOT / "robots" / f"{name}.yaml"
    first = _set(path)
    check_same(first, again(first, ROOT / "robots" / "a1" / "a1.xml", tmp_path))
