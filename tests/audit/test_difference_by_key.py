"""What configurations state by pattern, where no file names the joints: key by key, in the framework's order."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.difference import compare_files
from actspec.readings.versions import Versions
from actspec.report.difference import lines, report_lines
from tests.audit.test_difference_beside import both

GO2 = """from isaaclab.actuators import DCMotorCfg
from isaaclab.assets import ArticulationCfg

GO2_CFG = ArticulationCfg(
    init_state=ArticulationCfg.InitialStateCfg(
        joint_pos={
            ".*L_hip_joint": 0.1,
            ".*R_hip_joint": -0.1,
            "F[L,R]_thigh_joint": 0.8,
            "R[L,R]_thigh_joint": 1.0,
            ".*_calf_joint": -1.5,
        },
    ),
    actuators={
        "legs": DCMotorCfg(
            joint_names_expr=[".*_hip_joint", ".*_thigh_joint"],
            effort_limit={".*_hip_.*": 23.7, ".*_thigh_.*": 23.7},
            saturation_effort=23.7,
            velocity_limit=30.1,
            stiffness={".*_hip_.*": 25.0, ".*_thigh_.*": 25.0},
            damping={".*_hip_.*": 0.5, ".*_thigh_.*": 0.5},
            armature={".*_hip_.*": 0.01, ".*_thigh_.*": 0.01},
            viscous_friction={".*_hip_.*": 0.1, ".*_thigh_.*": 0.1},
        ),
        "knees": DCMotorCfg(
            joint_names_expr=[".*_calf_joint"],
            effort_limit=45.43,
            saturation_effort=45.43,
            velocity_limit=15.7,
            stiffness=25.0,
            damping=0.5,
        ),
    },
)
"""
"""In the manner of Isaac Lab's own: the keys of dicts are not the patterns of the groups."""

LOW = """
LOW_CFG = GO2_CFG.copy()
LOW_CFG.init_state.joint_pos[".*L_hip_joint"] = 0.2
"""
"""A second robot of the same file, with another pose."""


@pytest.mark.parametrize(
    "old, new, expected",
    [
        ('L_hip_joint": 0.1', 'L_hip_joint": 0.5', [".*L_hip_joint:", "  default position 0.1 -> 0.5 rad"]),
        (
            'thigh_joint": 0.8',
            'thigh_joint": -0.8',
            ["F[L,R]_thigh_joint:", "  default position 0.8 -> -0.8 rad"],
        ),
        ('joint": -1.5', 'joint": -1.2', [".*_calf_joint:", "  default position -1.5 -> -1.2 rad"]),
        ('_hip_.*": 25.0', '_hip_.*": 40.0', [".*_hip_.*:", "  stiffness kp 25 -> 40 N*m/rad (+60 %)"]),
        ('_hip_.*": 0.5', '_hip_.*": 5.0', [".*_hip_.*:", "  drive gain kd 0.5 -> 5 N*m*s/rad (x10)"]),
        ('_hip_.*": 23.7', '_hip_.*": 2.37', [".*_hip_.*:", "  effort limit 23.7 -> 2.37 N*m (x0.1)"]),
        ('_hip_.*": 0.01', '_hip_.*": 0.04', [".*_hip_.*:", "  armature 0.01 -> 0.04 kg*m^2 (x4)"]),
        ('_hip_.*": 0.1', '_hip_.*": 0.3', [".*_hip_.*:", "  joint damping 0.1 -> 0.3 N*m*s/rad (x3)"]),
        ('".*R_hip_joint": -0.1,\n', "", [".*R_hip_joint:", "  default position -0.1 rad -> none"]),
        # A joint that the pose misses is at 0, in Isaac Lab 2.3.2 and mjlab 1.6.0.
        ('"R[L,R]_thigh_joint": 1.0', '"R[L,R]_thigh_joint": 1.0, "waist.*": 0.0', []),
        # Isaac Lab refuses two keys that match one joint: their order says nothing.
        (
            '".*L_hip_joint": 0.1,\n            ".*R_hip_joint": -0.1,',
            '".*R_hip_joint": -0.1,\n            ".*L_hip_joint": 0.1,',
            [],
        ),
        ('"legs": DC', '"hips_and_thighs": DC', []),
        # All of a dict in one number: the groups' patterns have it.
        (
            'armature={".*_hip_.*": 0.01, ".*_thigh_.*": 0.01}',
            "armature=0.02",
            [
                ".*_hip_.*, .*_thigh_.*:",
                "  armature 0.01 kg*m^2 -> none",
                ".*_hip_joint, .*_thigh_joint:",
                "  armature by pattern -> 0.02 kg*m^2",
            ],
        ),
    ],
    ids=[
        "pose",
        "pose by class",
        "pose of a group",
        "kp",
        "kd",
        "limit",
        "armature",
        "friction",
        "key gone",
        "zero",
        "order",
        "group renamed",
        "one number",
    ],
)
def test_keys_are_compared_as_they_are_written(
    old: str, new: str, expected: list[str], tmp_path: Path
) -> None:
    """Which joints a key is for nobody knows without the robot; that its number is another one can be told."""
    assert old in GO2
    found = both(tmp_path, "go2_cfg.py", GO2, GO2.replace(old, new, 1))
    assert list(lines(found, "")) == expected
    assert found.same is not bool(expected)
    assert not found.left


def test_a_pose_of_a_second_robot_of_the_file(tmp_path: Path) -> None:
    """What it writes over is its own."""
    for name, text in (("old.py", GO2 + LOW), ("new.py", GO2 + LOW.replace("0.2", "0.3"))):
        (tmp_path / name).write_text(text)
    found = compare_files(str(tmp_path / "old.py"), str(tmp_path / "new.py"), Versions())
    assert {item.new.name: list(lines(item, "")) for item in found} == {
        "GO2_CFG": [],
        "LOW_CFG": [".*L_hip_joint:", "  default position 0.2 -> 0.3 rad"],
    }


def test_a_dict_that_is_not_read_stays_unknown(tmp_path: Path) -> None:
    """It is told as not compared where both sides have it so, and once a side is read, as any other figure."""
    unread = GO2.replace('".*_hip_.*": 0.01', '".*_hip_.*": rotor()')
    found = both(tmp_path, "go2_cfg.py", unread, unread)
    expected = "  not compared: armature at 2 patterns of joints, unknown"
    assert expected in report_lines([found], "a", "b")
    found = both(tmp_path / "read", "go2_cfg.py", unread, GO2)
    assert list(lines(found, "")) == [".*_hip_.*, .*_thigh_.*:", "  armature unknown -> 0.01 kg*m^2"]


MJLAB = """from mjlab.actuator import BuiltinPositionActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg, EntityCfg

LEGS = BuiltinPositionActuatorCfg(target_names_expr=(".*_hip_joint", ".*_knee_joint"), stiffness=20.0, damping=1.0)


def get_go1_robot_cfg() -> EntityCfg:
    return EntityCfg(
        init_state=EntityCfg.InitialStateCfg(joint_pos={POSE}),
        articulation=EntityArticulationInfoCfg(actuators=(LEGS,)),
    )
"""

GYM = """from legged_gym.envs.base.legged_robot_config import LeggedRobotCfg


class LegCfg(LeggedRobotCfg):
    class control(LeggedRobotCfg.control):
        control_type = "P"
        stiffness = {GAINS}
        damping = {"hip": 0.5, "knee": 1.0}
"""


@pytest.mark.parametrize(
    "text, old, new, expected",
    [
        # mjlab 1.6.0, measured: `resolve_expr` gives FL_hip_joint 0.1 with the one order, 0.2 with the other.
        (MJLAB, '"FL_hip.*": 0.2, ".*_hip_j.*": 0.1', '".*_hip_j.*": 0.1, "FL_hip.*": 0.2', []),
        (
            MJLAB,
            '"FL_hip_joint": 0.2, ".*_hip_j.*": 0.1',
            '".*_hip_j.*": 0.1, "FL_hip_joint": 0.2',
            ["default position where '.*_hip_j.*' and 'FL_hip_joint' both match 0.2 -> 0.1 rad"],
        ),
        # A pattern of the group beside one of its joints, which its own figure does not tell.
        (
            MJLAB,
            '".*_hip_joint": 0.2, ".*R_hip_joint": 0.1',
            '".*R_hip_joint": 0.1, ".*_hip_joint": 0.2',
            ["default position where '.*R_hip_joint' and '.*_hip_joint' both match 0.2 -> 0.1 rad"],
        ),
        (MJLAB, '".*L_hip.*": 0.2, ".*R_hip.*": 0.1', '".*R_hip.*": 0.1, ".*L_hip.*": 0.2', []),
        (MJLAB, '".*L_hip.*": 0.1, ".*": 0.1', '".*": 0.1, ".*L_hip.*": 0.1', []),
        (
            MJLAB,
            '".*L_hip.*": 0.2, ".*": 0.1',
            '".*": 0.1, ".*L_hip.*": 0.2',
            ["default position where '.*' and '.*L_hip.*' both match 0.2 -> 0.1 rad"],
        ),
        # legged_gym's last key that is part of the name counts.
        (
            GYM,
            '"hip": 20.0, "hip_yaw": 30.0',
            '"hip_yaw": 30.0, "hip": 20.0',
            ["stiffness kp where 'hip_yaw' and 'hip' both match 30 -> 20 N*m/rad (-33.3 %)"],
        ),
        (GYM, '"hip": 20.0, "knee": 30.0', '"knee": 30.0, "hip": 20.0', []),
    ],
    ids=[
        "may both match",
        "one is in the other",
        "of the group",
        "sides",
        "equal",
        "all",
        "legged_gym",
        "legged_gym apart",
    ],
)
def test_the_order_counts_where_the_framework_has_it(
    text: str, old: str, new: str, expected: list[str], tmp_path: Path
) -> None:
    """Of two keys for one joint, mjlab's first and legged_gym's last; told where one is for what the other is for."""
    texts = [text.replace("POSE", side).replace("GAINS", side) for side in (old, new)]
    found = both(tmp_path, "leg_cfg.py", *texts)
    assert list(lines(found, "")) == expected


NAMED_GYM = """from legged_gym.envs.base.legged_robot_config import LeggedRobotCfg


class LegCfg(LeggedRobotCfg):
    class init_state(LeggedRobotCfg.init_state):
        default_joint_angles = {"hip_roll": 0.1, "hip_yaw": 0.2}

    class control(LeggedRobotCfg.control):
        control_type = "P"
        stiffness = {"hip": 20.0, "hip_yaw": 30.0}
        damping = {"hip_yaw": 0.7, "hip": 0.5}
"""


@pytest.mark.parametrize(
    "old, new, expected",
    [
        ('yaw": 30.0', 'yaw": 35.0', ["hip_yaw:", "  stiffness kp 30 -> 35 N*m/rad (+16.7 %)"]),
        (
            '"hip": 20.0, "hip_yaw": 30.0',
            '"hip_yaw": 30.0, "hip": 20.0',
            [
                "hip_yaw:",
                "  stiffness kp 30 -> 20 N*m/rad (-33.3 %)",
                "  drive gain kd 0.7 -> 0.5 N*m*s/rad (-28.6 %)",
            ],
        ),
        ('"hip_yaw": 0.7, "hip": 0.5', '"hip": 0.5, "hip_yaw": 0.7', []),
    ],
    ids=["the one that counts", "order", "order of damping"],
)
def test_a_joint_that_two_keys_are_for(old: str, new: str, expected: list[str], tmp_path: Path) -> None:
    """legged_gym's `_init_buffers` takes the last key of `stiffness` that is part of the name, for both gains."""
    assert old in NAMED_GYM
    found = both(tmp_path, "leg_config.py", NAMED_GYM, NAMED_GYM.replace(old, new))
    assert list(lines(found, "")) == expected
