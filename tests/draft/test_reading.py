"""Whole files: reading, pairing, and joints and steps that come from the file beside."""

from __future__ import annotations

from pathlib import Path

from actspec.draft.reading import read_robot_files
from actspec.lift import Lifted
from actspec.readings.versions import Versions
from tests.audit.robots import LEG

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


def read(folder: Path, **files: str) -> list[Lifted]:
    """Files of one robot, written and lifted together; `_` in a keyword is the dot before its ending."""
    paths = []
    for key, text in files.items():
        stem, _, ending = key.rpartition("_")
        paths.append(folder / f"{stem}.{ending}")
        paths[-1].write_text(text, encoding="utf-8")
    readings, _ = read_robot_files([str(path) for path in paths], None, Versions())
    return [reading.lifted for reading in readings]


def test_parts_of_one_robot(tmp_path: Path) -> None:
    """A cfg gets its joints from the MJCF and its step from the environment, whose drives are the cfg's alone."""
    model, cfg, env = read(tmp_path, leg_xml=LEG, leg_cfg_py=CFG, leg_env_cfg_py=ENV)
    assert env.actuators.joints == ()
    for part in (model, cfg):
        assert [actuator.joint for actuator in part.actuators.joints] == ["hip", "knee"]
    hip = cfg.actuators.joints[0]
    assert hip.kp is not None and hip.kp.value == 90.0
    assert hip.delay is not None and hip.delay.nominal.value == 0.01  # 2 x 5 ms
    assert hip.position_range is not None
    assert env.actuators.physics_dt.value == 0.005
    assert model.actuators.joints[0].effort_limit.value == 30.0


def test_a_step_is_of_its_own_framework(tmp_path: Path) -> None:
    """The 2 ms of an mjlab task say nothing of a lag in Isaac Lab, whose length nobody states then."""
    task = """from mjlab.envs import ManagerBasedRlEnvCfg
from mjlab.sim import MujocoCfg, SimulationCfg
LEG_ENV_CFG = ManagerBasedRlEnvCfg(decimation=4, sim=SimulationCfg(mujoco=MujocoCfg(timestep=0.002)))
"""
    parts = read(tmp_path, leg_xml=LEG, leg_cfg_py=CFG, leg_task_py=task)
    (cfg,) = (part for part in parts if part.actuators.robot == "LEG_CFG")
    delay = cfg.actuators.joints[0].delay
    assert delay is not None and delay.nominal.value is None


def test_joints_of_a_deploy_file(tmp_path: Path) -> None:
    """Where no robot file is, the names of a deploy file serve, and a note says that the kind is not known."""
    deploy = "joint_names: [hip, knee]\nkps: [1, 2]\nkds: [1, 1]\n"
    cfg, _ = read(tmp_path, leg_cfg_py=CFG, leg_yaml=deploy)
    assert [actuator.joint for actuator in cfg.actuators.joints] == ["hip", "knee"]
    assert any("taken as hinges" in note for note in cfg.notes[""])
