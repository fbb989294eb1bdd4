"""Configurations whose actuators stand in a file that is not read."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.diagnostics import AuditError
from actspec.draft.reading import read_robot_files
from actspec.readings.versions import Versions
from tests.audit.robots import LEG

ACTS = """from isaaclab.actuators import IdealPDActuatorCfg
ACTS = {"legs": IdealPDActuatorCfg(joint_names_expr=[".*"], stiffness=90.0, damping=3.0, effort_limit=30.0)}
"""
ROBOT = """from isaaclab.assets import ArticulationCfg
from my_robot.acts import ACTS
LEG_CFG = ArticulationCfg(
    init_state=ArticulationCfg.InitialStateCfg(joint_pos={"hip": 0.3, "knee": -0.6}), actuators=ACTS)
"""
SCENE = """from isaaclab.envs import ManagerBasedRLEnvCfg
from scenes import LegScene
class LegEnvCfg(ManagerBasedRLEnvCfg):
    scene = LegScene(num_envs=1)
    decimation = 4
"""
MOTORS = LEG.replace("<position", "<motor").replace('kp="100" kv="3" ', "")
UNKNOWN = "not known without running it"


def written(folder: Path, **files: str) -> list[str]:
    """Paths of files; `__` in a keyword is a folder, the last `_` the dot before the ending."""
    paths = []
    for key, text in files.items():
        stem, _, ending = key.replace("__", "/").rpartition("_")
        path = folder / f"{stem}.{ending}"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        paths.append(str(path))
    return paths


@pytest.mark.parametrize(
    "text, named, place, message, help",
    [
        (ROBOT, None, (2, 1), f"LEG_CFG: its actuators are {UNKNOWN}: ACTS comes from my_robot, which is not beside "
         "this file", "name the file that has them too, or leave this file out"),
        (ROBOT, "hip,knee", (2, 1), f"LEG_CFG: its actuators are {UNKNOWN}: ACTS comes from my_robot, which is not "
         "beside this file", "name the file that has them too"),
        (SCENE, None, (4, 13), f"LegEnvCfg: its scene is {UNKNOWN}: LegScene comes from scenes, which is not beside "
         "this file", "name the robot's configuration too, or leave this file out"),
    ],
    ids=["robot", "joints", "scene"],
)  # fmt: skip
def test_no_torque_motors_in_place_of_drives(
    tmp_path: Path, text: str, named: str | None, place: tuple[int, int], message: str, help: str
) -> None:
    """The model's motors alone are not what the configuration drives the robot with."""
    paths = written(tmp_path, cfg_py=text) if named else written(tmp_path, cfg_py=text, leg_xml=MOTORS)
    with pytest.raises(AuditError) as raised:
        read_robot_files(paths, None, Versions(), named)
    (found,) = raised.value.diagnostics
    assert (found.code, found.message, found.help) == ("DRF002", message, help)
    assert found.span is not None and (found.span.line, found.span.column) == place


def test_an_environment_beside_a_model_with_servos(tmp_path: Path) -> None:
    """Its gains are a drive, and the environment has the step."""
    parts, said = read_robot_files(written(tmp_path, env_py=SCENE, leg_xml=LEG), None, Versions())
    assert len(parts) == 2
    assert any(d.code == "CFG001" and d.where == "scene" for d in said)


def test_drives_of_a_file_that_is_named_too(tmp_path: Path) -> None:
    """They are the robot's, whose pose is taken."""
    paths = written(tmp_path, cfg_py=ROBOT, elsewhere__acts_py=ACTS, leg_xml=LEG)
    parts, said = read_robot_files(paths, None, Versions())
    (robot,) = (part for part in parts if part.path.endswith(".py"))
    hip, knee = robot.lifted.actuators.joints
    assert hip.kp is not None and hip.kp.value == 90.0
    assert (hip.default_position.value, knee.default_position.value) == (0.3, -0.6)
    assert not [d for d in said if d.code == "CFG001"]


def test_a_spare_motor_is_no_robot(tmp_path: Path) -> None:
    """One actuator cfg that nothing of the file uses; by its name it is still found."""
    whole = ROBOT.replace("from my_robot.acts import ACTS\n", ACTS)
    spare = (
        'SPARE = IdealPDActuatorCfg(joint_names_expr=[".*"], stiffness=5.0, damping=1.0, effort_limit=9.0)\n'
    )
    paths = written(tmp_path, cfg_py=whole + spare)
    for name, kp in ((None, 90.0), ("SPARE", 5.0)):
        parts, _ = read_robot_files(paths, name, Versions(), "hip,knee")
        (robot,) = parts
        hip = robot.lifted.actuators.joints[0]
        assert hip.kp is not None and hip.kp.value == kp


BASE = """from dataclasses import MISSING
from isaaclab.assets import ArticulationCfg
from isaaclab.envs import ManagerBasedRLEnvCfg, mdp
from isaaclab.scene import InteractiveSceneCfg
from isaaclab.utils import configclass
@configclass
class Scene(InteractiveSceneCfg):
    robot: ArticulationCfg = MISSING
@configclass
class Actions:
    joint_pos = mdp.JointPositionActionCfg(asset_name="robot", joint_names=[".*"], scale=0.25)
@configclass
class LegEnvCfg(ManagerBasedRLEnvCfg):
    scene: Scene = Scene(num_envs=1)
    actions: Actions = Actions()
    decimation = 4
"""
DERIVED = """
from isaaclab.actuators import IdealPDActuatorCfg
@configclass
class MyEnvCfg(LegEnvCfg):
    def __post_init__(self):
        self.scene.robot = ArticulationCfg(actuators={"legs": IdealPDActuatorCfg(
            joint_names_expr=["hip", "knee"], stiffness=90.0, damping=3.0, effort_limit=30.0)})
"""


@pytest.mark.parametrize("named", [None, "hip,knee"])
@pytest.mark.parametrize(
    ("text", "line", "message", "help"),
    [
        (
            BASE,
            7,
            "LegEnvCfg: its robot is MISSING: an environment that is derived from it sets it",
            "name the file of that environment, or the robot's configuration too",
        ),
        (
            BASE.replace("    robot: ArticulationCfg = MISSING", "    lamp = 1"),
            13,
            "LegEnvCfg: it has no robot, and so no joints",
            "name the robot's configuration too, or the environment that has it",
        ),
    ],
)
def test_an_environment_without_its_robot(
    tmp_path: Path, named: str | None, text: str, line: int, message: str, help: str
) -> None:
    """A base environment is told by its file and class; with --joints, the list is not blamed."""
    with pytest.raises(AuditError) as caught:
        read_robot_files(written(tmp_path, base_py=text), None, Versions(), named)
    (error,) = caught.value.diagnostics
    assert error.span is not None
    assert (error.code, error.span.line, error.message, error.help) == ("DRF002", line, message, help)


def test_an_environment_whose_robot_a_derived_one_sets(tmp_path: Path) -> None:
    """Beside a base of its file it is the robot, with the base's decimation."""
    (reading,) = read_robot_files(written(tmp_path, base_py=BASE + DERIVED), None, Versions())[0]
    assert [joint.joint for joint in reading.lifted.actuators.joints] == ["hip", "knee"]


TWO = """from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.assets import ArticulationCfg
LEG_CFG = ArticulationCfg(actuators={"legs": IdealPDActuatorCfg(
    joint_names_expr=["hip", "knee"], stiffness=20.0, damping=3.0, effort_limit=30.0)})
STIFF_LEG_CFG = LEG_CFG.copy()
STIFF_LEG_CFG.actuators["legs"].stiffness = 80.0
"""


@pytest.mark.parametrize("module", ["two", "elsewhere.robots"])
@pytest.mark.parametrize(("name", "kp"), [("LEG_CFG", 20.0), ("STIFF_LEG_CFG", 80.0)])
def test_an_environment_says_which_of_two_robots_it_takes(
    tmp_path: Path, module: str, name: str, kp: float
) -> None:
    """From the file itself, or from a module that is not found, under another name; --robot counts before it."""
    task = BASE.replace("= MISSING", "= LEG").replace(
        "from dataclasses import MISSING", f"from {module} import {name} as LEG"
    )
    paths = written(tmp_path, env_py=task, two_py=TWO)
    for asked, stiffness in ((None, kp), ("LEG_CFG", 20.0)):
        readings, _ = read_robot_files(paths, asked, Versions())
        found = {
            joint.kp.value
            for one in readings
            for joint in one.lifted.actuators.joints
            if joint.kp is not None
        }
        assert found == {stiffness} or (asked and module == "two")
    with pytest.raises(AuditError):
        read_robot_files(written(tmp_path, two_py=TWO), None, Versions())
