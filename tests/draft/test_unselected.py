"""Keys of a configuration that select no joint, with the robot's joints named and without."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.cli.main import main
from tests.importing import urdf_of

ISAACLAB = """from isaaclab.actuators import ImplicitActuatorCfg
from isaaclab.assets import ArticulationCfg

HAND_CFG = ArticulationCfg(
    init_state=ArticulationCfg.InitialStateCfg(joint_pos={"left_finger": 0.02, "right_finger": -0.02}),
    actuators={"f": ImplicitActuatorCfg(joint_names_expr=["left_finger"], stiffness=100.0, damping=5.0)},
)
"""
MJLAB = """from mjlab.actuator import IdealPdActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg, EntityCfg

HIP = IdealPdActuatorCfg(target_names_expr=("hip_roll",), stiffness=40.0, damping=2.0, effort_limit=18.0)
LEG_ARTICULATION = EntityArticulationInfoCfg(actuators=(HIP,))
LEG_CFG = EntityCfg(
    init_state=EntityCfg.InitialStateCfg(joint_pos={@POSE@}),
    articulation=LEG_ARTICULATION,
)
"""
NOTE = (
    "cfg.py:5:96: DRF012 [info]: no group of HAND_CFG drives `right_finger` of default_position\n"
    "  help: passive, or misspelt? Name the robot's MJCF or URDF too\n"
)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def _said(capsys: pytest.CaptureFixture[str], text: str, *more: str, code: int = 0) -> str:
    Path("cfg.py").write_text(text, encoding="utf-8")
    assert main(["import", "cfg.py", *more]) == code
    return capsys.readouterr().err


def test_a_passive_joint_of_the_pose(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Nobody knows whether the robot has it, as a finger that follows the other: one note, and none with the robot."""
    err = _said(capsys, ISAACLAB)
    assert NOTE in err and err.count("DRF012") == 1
    (folder / "hand.urdf").write_text(urdf_of("left_finger", "right_finger"), encoding="utf-8")
    for more in (["hand.urdf"], ["--joints", "hand.urdf"], ["--joints", "left_finger,right_finger"]):
        assert "DRF012" not in _said(capsys, ISAACLAB, *more)
    (folder / "hand.urdf").write_text(urdf_of("left_finger", "thumb"), encoding="utf-8")
    told = "DRF012 [warning]: `right_finger` of default_position selects none of the 2 joints of "
    for more, of in ((["hand.urdf"], "hand.urdf"), (["--joints", "left_finger,thumb"], "--joints")):
        err = _said(capsys, ISAACLAB, *more)
        assert f"{told}{of}\n" in err and "HAND_CFG is refused for it when the robot is made" in err


def test_a_misspelt_joint_of_the_pose(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What has no position of its own may be meant; what has one is not."""
    pose = ISAACLAB.replace('"left_finger": 0.02, "right', '"left')
    err = _said(capsys, pose.replace('"left_finger": -', '"left_fingr": -'))
    assert (
        "drives `left_fingr` of default_position\n  help: did you mean `left_finger`? Name the robot" in err
    )
    err = _said(capsys, ISAACLAB.replace('"right_finger"', '"left_fingers"'))
    assert "drives `left_fingers` of default_position\n  help: passive, or misspelt?" in err


def test_one_note_for_all(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Several joints are one note, and what a pattern of a group may select is none of them."""
    text = ISAACLAB.replace('"right_finger": -0.02', '"toe": 0.1, "heel": 0.1, "arm_a": 0.1, "arm_.*": 0.1')
    text = text.replace('["left_finger"]', '["left_finger", "arm_.*"]')
    (folder / "deploy.yaml").write_text("joint_names: [left_finger, heel]\nkp: [9, 9]\n", encoding="utf-8")
    err = _said(capsys, text, "deploy.yaml")
    # A deploy file has the joints of a policy; `heel` is there, and `arm_.*` may be of the others.
    assert (
        err.count("DRF012") == 1 and "[info]: no group of HAND_CFG drives `toe` of default_position\n" in err
    )
    err = _said(capsys, ISAACLAB.replace('"right_finger": -0.02', '"toe": 0.1, "heel": 0.1'))
    assert err.count("DRF012") == 1 and "drives `toe`, `heel` of default_position\n" in err


def test_a_key_of_a_group_needs_no_robot(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Whatever joints the robot has, the group has one."""
    err = _said(capsys, ISAACLAB.replace("stiffness=100.0", 'stiffness={"left_finger": 9.0, "toe": 8.0}'))
    assert "DRF012 [warning]: `toe` of stiffness selects no joint of group f\n" in err and NOTE in err


@pytest.mark.parametrize("more", [(), ("leg.urdf",)])
def test_mjlab_takes_what_begins_a_name(
    folder: Path, more: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    """mjlab 1.6.0, `resolve_expr`: `re.match`, and a key of the pose for no joint is passed over."""
    (folder / "leg.urdf").write_text(urdf_of("hip_roll"), encoding="utf-8")
    assert "DRF012" not in _said(capsys, MJLAB.replace("@POSE@", '"hip": 0.1'), *more)
    err = _said(capsys, MJLAB.replace("@POSE@", '"roll": 0.1'), *more)
    assert "is refused" not in err and ("mjlab passes over it" in err) is bool(more)


def test_mjlab_scales_what_is_driven(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """mjlab 1.6.0, `JointAction`: its scales are matched with the joints that have an actuator, and no others."""
    text = MJLAB.replace("@POSE@", "") + '\nLEG_ACTION_SCALE = {"hip_roll": 0.5, "toe": 0.3}\n'
    err = _said(capsys, text)
    assert "cfg.py:11:20: DRF012 [warning]: `toe` of action_scale selects no joint of a group\n" in err


def test_the_models_own_actuators(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A configuration that leaves its joints to the model is read with that, which is named."""
    (folder / "leg.xml").write_text(
        "<mujoco><worldbody><body><joint name='hip_roll'/><geom size='0.1'/></body></worldbody>"
        "<actuator><position joint='hip_roll' kp='30' kv='2'/></actuator></mujoco>",
        encoding="utf-8",
    )
    spec = '    spec_fn=lambda: mujoco.MjSpec.from_file("leg.xml"),\n    articulation'
    text = MJLAB.replace("@POSE@", "").replace("IdealPd", "XmlPosition").replace("    articulation", spec)
    text = "import mujoco\n" + text.replace(", stiffness=40.0, damping=2.0, effort_limit=18.0", "")
    why = (
        "cfg.py: DRF002: none of the joints of LEG_ARTICULATION can go into a group: XmlPositionActuatorCfg leaves it "
        "to the model's own actuator\n  help: name leg.xml too, which it reads\n"
    )
    for more in ((), ("--joints", "hip_roll")):
        assert why in _said(capsys, text, *more, code=2)
    assert main(["import", "cfg.py", "leg.xml"]) == 0
    assert "kp: {value: 30 N*m/rad, source: leg_mjcf}" in capsys.readouterr().out
    (folder / "leg.xml").unlink()
    assert "help: name the robot's MJCF or URDF too\n" in _said(capsys, text, code=2)


def test_joints_and_keys_of_an_action_term(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Isaac Lab 2.3.2, `JointAction`: it looks for the term's joints in the robot, for the scale's keys in the term."""
    term = (
        'mdp.JointPositionActionCfg(joint_names=["hip", "toe"], scale={"hip": 0.5, "knee": 1.0, "h.*": 2.0})'
    )
    text = f"""from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.assets import ArticulationCfg
from isaaclab.envs import ManagerBasedRLEnvCfg, mdp

class SceneCfg:
    robot = ArticulationCfg(actuators={{"legs": IdealPDActuatorCfg(
        joint_names_expr=["hip", "knee"], stiffness=25.0, damping=0.5, effort_limit=20.0)}})

class ActionsCfg:
    pos = {term}

class DogoEnvCfg(ManagerBasedRLEnvCfg):
    scene = SceneCfg()
    actions = ActionsCfg()
    decimation = 4
"""
    (tmp_path / "cfg.py").write_text(text, encoding="utf-8")
    assert main(["import", str(tmp_path / "cfg.py"), "--robot", "DogoEnvCfg", "--joints", "hip,knee"]) == 0
    out, err = capsys.readouterr()
    assert "DRF012 [warning]: `toe` of actions.pos selects none of the 2 joints of --joints\n" in err
    assert "DRF012 [warning]: `knee` of action_scale selects no joint of actions.pos\n" in err
    assert "DRF014 [warning]: `h.*` of the action scale is for hip, which `hip` is for already\n" in err
    assert "action_scale: unknown    # the keys 'hip' and 'h.*' both match the joint, which Isaac Lab" in out
