"""Action terms as they are read, held to the commands of the real classes of Isaac Lab and mjlab."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from actspec.lift.config import lift_config
from actspec.readings.python.read import read_python
from tests.frameworks.prepare import Frameworks

HERE = Path(__file__).parent

JOINTS = ("hip_L", "hip_R", "wheel_L", "wheel_R")
POSE = (0.7, 0.4, 0.0, 0.2)
NOW = (0.1, -0.2, 0.3, 0.5)
LOW = (-1.0, -1.5, -2.0, -2.5)
HIGH = (1.0, 2.0, 3.0, 2.5)
ACTIONS = (0.5, -0.75, 2.0, -8.0)

TERMS: tuple[tuple[str, dict[str, Any], str], ...] = (
    ("JointPositionActionCfg", {"scale": 0.25}, "position"),
    ("JointPositionActionCfg", {}, "position"),
    ("JointPositionActionCfg", {"scale": {"hip_.*": 0.25}}, "position"),
    ("JointPositionActionCfg", {"scale": {".*_L": 0.25, ".*_R": 0.5}, "offset": 0.3}, "position"),
    ("JointPositionActionCfg", {"scale": 0.25, "use_default_offset": False}, "position"),
    ("JointPositionActionCfg", {"scale": 0.25, "use_default_offset": False, "offset": 0.3}, "position"),
    (
        "JointPositionActionCfg",
        {"scale": 0.5, "use_default_offset": False, "offset": {"hip_.*": 0.3}},
        "position",
    ),
    ("JointPositionActionCfg", {"scale": 0.5, "clip": {"hip_L": (-0.5, 0.8), "wheel.*": (-1.0, 1.0)}}, "position"),
    ("JointVelocityActionCfg", {"scale": 10.0}, "velocity"),
    ("JointVelocityActionCfg", {"scale": 10.0, "use_default_offset": False, "offset": 2.0}, "velocity"),
    ("JointVelocityActionCfg", {"scale": 10.0, "clip": {".*": (-5.0, 15.0)}}, "velocity"),
    ("JointEffortActionCfg", {"scale": 40.0}, "effort"),
    ("JointEffortActionCfg", {"scale": 40.0, "offset": 2.0}, "effort"),
    ("RelativeJointPositionActionCfg", {"scale": 0.25}, "position"),
)  # fmt: skip
"""Class, arguments beside the joints, and what it commands."""

LIMITS: tuple[tuple[str, dict[str, Any], str], ...] = (
    ("JointPositionToLimitsActionCfg", {"scale": 0.25}, "position"),
    ("JointPositionToLimitsActionCfg", {"scale": 0.25, "rescale_to_limits": False}, "position"),
    ("EMAJointPositionToLimitsActionCfg", {"scale": 0.25, "alpha": 0.5}, "position"),
)
"""Of Isaac Lab alone."""

UNKNOWN = ("RelativeJointPositionActionCfg", *(cls for cls, *_ in LIMITS))
"""Whose command is no default position + scale x action: nothing is said of it."""

LAB = """from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.assets import ArticulationCfg
from isaaclab.envs import ManagerBasedRLEnvCfg, mdp
BOT_CFG = ArticulationCfg(
    init_state=ArticulationCfg.InitialStateCfg(joint_pos={pose}),
    actuators={{"all": IdealPDActuatorCfg(joint_names_expr=[".*"], {gains}, effort_limit=500.0)}})
class SceneCfg:
    robot = BOT_CFG
class ActionsCfg:
    term = mdp.{cls}(asset_name="robot", joint_names={joints}{more})
class BotEnvCfg(ManagerBasedRLEnvCfg):
    scene = SceneCfg()
    actions = ActionsCfg()
    decimation = 4
"""

MJLAB = """from mjlab.actuator import BuiltinPositionActuatorCfg, BuiltinVelocityActuatorCfg, BuiltinMotorActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg, EntityCfg
from mjlab.envs import ManagerBasedRlEnvCfg
from mjlab.envs.mdp.actions import {cls}
from mjlab.scene import SceneCfg
ALL = {gains}
def bot_env_cfg():
    bot = EntityCfg(
        init_state=EntityCfg.InitialStateCfg(joint_pos={pose}),
        articulation=EntityArticulationInfoCfg(actuators=(ALL,)))
    return ManagerBasedRlEnvCfg(
        decimation=4, scene=SceneCfg(entities={{"robot": bot}}),
        actions={{"term": {cls}(entity_name="robot", actuator_names={joints}{more})}})
"""

GAINS = {
    "position": "stiffness=40.0, damping=2.0",
    "velocity": "stiffness=0.0, damping=2.0",
    "effort": "stiffness=0.0, damping=0.0",
}
DRIVES = {
    "position": 'BuiltinPositionActuatorCfg(target_names_expr=(".*",), stiffness=40.0, damping=2.0)',
    "velocity": 'BuiltinVelocityActuatorCfg(target_names_expr=(".*",), damping=2.0)',
    "effort": 'BuiltinMotorActuatorCfg(target_names_expr=(".*",), effort_limit=500.0)',
}


def read(folder: Path, framework: str, cls: str, arguments: dict[str, Any], command: str) -> np.ndarray:
    """The command of each joint, by what is read of a task with the term; nan: nothing is said of it."""
    text, drives = (LAB, GAINS) if framework == "isaaclab" else (MJLAB, DRIVES)
    beside = dict(arguments)
    joints = beside.pop("joints")
    more = "".join(f", {key}={value!r}" for key, value in beside.items())
    pose = dict(zip(JOINTS, POSE, strict=True))
    path = folder / "env_cfg.py"
    path.write_text(
        text.format(cls=cls, gains=drives[command], joints=joints, more=more, pose=pose), encoding="utf-8"
    )
    (env,) = (one for one in read_python(str(path)).artifacts if "nv" in one.name)
    found = lift_config(env, JOINTS).actuators
    out = np.full(len(JOINTS), np.nan)
    selected = [name for name in JOINTS if name.startswith(tuple(joints)) or joints == [".*"]]
    for name, action in zip(selected, ACTIONS, strict=False):
        joint = found.joint(name)
        assert joint is not None and joint.command.value == command
        if joint.action_scale is None or joint.action_scale.value is None:
            continue
        value = joint.action_scale.value * action
        value += joint.default_position.require() if command == "position" else 0.0
        if joint.command_range is not None:
            value = min(max(value, joint.command_range[0].require()), joint.command_range[1].require())
        out[JOINTS.index(name)] = value
    return out


@pytest.mark.parametrize("framework", ["isaaclab-2.3.2.post1", "isaaclab-2.2.0", "mjlab"])
@pytest.mark.parametrize("joints", [[".*"], ["wheel_R", "hip_R"]])
def test_commands(frameworks: Frameworks, tmp_path: Path, framework: str, joints: list[str]) -> None:
    """Where a scale is read, the command by it is the real one; else the real one is another law, or an offset."""
    name, _, version = framework.partition("-")
    terms = [*TERMS, *(LIMITS if name == "isaaclab" else ())]
    if joints != [".*"]:
        terms = [term for term in terms if not any(isinstance(one, dict) for one in term[1].values())]
    key = "joint_names" if name == "isaaclab" else "actuator_names"
    job = {
        "framework": name, "root": str(frameworks.isaaclab(version)) if version else "", "joints": JOINTS,
        "pose": POSE, "now": NOW, "low": LOW, "high": HIGH, "actions": ACTIONS,
        "terms": [(cls, {key: joints, **arguments}) for cls, arguments, _ in terms],
    }  # fmt: skip
    _, arrays = frameworks.run_probe(HERE / "actions_probe.py", job)
    for at, (cls, arguments, command) in enumerate(terms):
        mine = read(tmp_path, name, cls, {"joints": joints, **arguments}, command)
        real = arrays[f"{command}_{at}"]
        told = f"{framework} {cls} {arguments}"
        if cls in UNKNOWN and arguments.get("rescale_to_limits") is not False:
            assert np.isnan(mine).all() and not np.isnan(real).all(), told
        elif command != "position" and arguments.get("offset"):
            assert np.isnan(mine).all(), told
            np.testing.assert_allclose(
                real[-1],
                arguments["offset"] + arguments["scale"] * np.array(ACTIONS)[-1 if joints == [".*"] else 1],
                rtol=1e-6,
                err_msg=told,
            )
        else:
            np.testing.assert_allclose(mine, real, rtol=1e-6, err_msg=told)
