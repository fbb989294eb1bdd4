"""Whole files: reading, pairing, and joints and steps that come from the file beside."""

from __future__ import annotations

from pathlib import Path

from actspec.lift import lift_files
from actspec.readings.artifact import FileKind
from tests.audit.robots import LEG, SPEC

CFG = """from isaaclab.actuators import DelayedPDActuatorCfg
LEG_CFG = {"legs": DelayedPDActuatorCfg(
    joint_names_expr=[".*"], stiffness=90.0, damping=3.0, effort_limit=30.0, min_delay=2, max_delay=2)}
"""

ENV = """from isaaclab.envs import ManagerBasedRLEnvCfg
from leg_cfg import LEG_CFG
from isaaclab.assets import ArticulationCfg

class LegEnvCfg(ManagerBasedRLEnvCfg):
    robot = ArticulationCfg(actuators=LEG_CFG)
    def __post_init__(self):
        self.decimation = 4
        self.sim.dt = 0.005
"""


def test_parts_of_one_robot(tmp_path: Path) -> None:
    """A cfg gets its joints from the MJCF and its step from the environment; a spec is not read for that."""
    files = {"leg.xml": LEG, "leg_cfg.py": CFG, "leg_env_cfg.py": ENV, "leg.yaml": SPEC}
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    found = lift_files([str(tmp_path / name) for name in files])
    (robot,) = found.robots
    kinds = [part.artifact.kind for part in robot.parts if part.artifact is not None]
    assert kinds == [FileKind.MJCF, FileKind.CFG, FileKind.CFG]
    assert [reading.kind for reading in found.readings][-1] is FileKind.SPEC
    model, cfg, env = robot.parts
    for part in robot.parts:
        assert [actuator.joint for actuator in part.actuators.joints] == ["hip", "knee"]
    hip = cfg.actuators.joints[0]
    assert hip.kp is not None and hip.kp.value == 90.0
    assert hip.delay is not None and hip.delay.nominal.value == 0.01  # 2 x 5 ms
    assert hip.position_range is not None
    assert env.actuators.physics_dt.value == 0.005
    assert model.actuators.joints[0].effort_limit.value == 30.0


def test_joints_of_a_deploy_file(tmp_path: Path) -> None:
    """Where no robot file is, the names of a deploy file serve, and a note says that the kind is not known."""
    (tmp_path / "leg_cfg.py").write_text(CFG, encoding="utf-8")
    (tmp_path / "leg.yaml").write_text(
        "joint_names: [hip, knee]\nkps: [1, 2]\nkds: [1, 1]\n", encoding="utf-8"
    )
    found = lift_files([str(tmp_path / "leg_cfg.py"), str(tmp_path / "leg.yaml")])
    parts = [part for robot in found.robots for part in robot.parts if part.actuators.robot == "LEG_CFG"]
    assert [actuator.joint for actuator in parts[0].actuators.joints] == ["hip", "knee"]
    assert any("taken as hinges" in note for note in parts[0].notes[""])


def test_unreadable(tmp_path: Path) -> None:
    """A file that cannot be read says why, and the others are lifted."""
    (tmp_path / "leg.xml").write_text(LEG, encoding="utf-8")
    (tmp_path / "bad.xml").write_text("<mujoco>", encoding="utf-8")
    found = lift_files([str(tmp_path / "bad.xml"), str(tmp_path / "leg.xml")])
    assert [bool(reading.reason) for reading in found.readings] == [True, False]
    assert len(found.robots) == 1
