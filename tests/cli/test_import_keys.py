"""`actspec import`: two keys for one joint, lags and their step, and action scales that a loop fills."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.cli.main import main
from actspec.spec.validate import load_spec
from tests.importing import urdf_of

ISAACLAB = """from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.assets import ArticulationCfg

LEG_CFG = ArticulationCfg(
    init_state=ArticulationCfg.InitialStateCfg(joint_pos={@POSE@}),
    actuators={
        "all": IdealPDActuatorCfg(
            joint_names_expr=[".*"],
            effort_limit={
                ".*": 20.0,
                "knee": 22.0,
            },
            stiffness={@KP@},
            damping={"hip_.*": 1.0},
        )
    },
)
"""
LEGGED_GYM = """from legged_gym.envs.base.legged_robot_config import LeggedRobotCfg

class LegCfg(LeggedRobotCfg):
    class init_state(LeggedRobotCfg.init_state):
        default_joint_angles = {"hip": 0.1, "hip_roll": 0.2, "knee": -0.9}
    class control(LeggedRobotCfg.control):
        control_type = "P"
        stiffness = {"hip": 60.0, "hip_roll": 40.0, "knee": 80.0}
        damping = {"hip_roll": 1.0, "hip": 1.5, "knee": 2.0}
    class asset(LeggedRobotCfg.asset):
        file = "leg.urdf"
"""
MJLAB = """from mjlab.actuator import IdealPdActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg, EntityCfg

HIP = IdealPdActuatorCfg(target_names_expr=("hip_.*",), stiffness=40.0, damping=2.0, effort_limit=18.0)
KNEE = IdealPdActuatorCfg(target_names_expr=("knee",), stiffness=60.0, damping=1.5, effort_limit=22.0@LAG@)
LEG_ARTICULATION = EntityArticulationInfoCfg(actuators=(HIP, KNEE))
LEG_CFG = EntityCfg(
    init_state=EntityCfg.InitialStateCfg(joint_pos={@POSE@}),
    articulation=LEG_ARTICULATION,
)
"""
LOOP = """
LEG_ACTION_SCALE: dict[str, float] = {}
for a in LEG_ARTICULATION.actuators:
  assert isinstance(a, IdealPdActuatorCfg)
  e = a.effort_limit
  s = a.stiffness
  assert e is not None
  for n in a.target_names_expr:
    LEG_ACTION_SCALE[n] = @SCALE@
"""
BY_VALUES = """
LEG_ACTION_SCALE = {}
for a in LEG_CFG.actuators.values():
    e = a.effort_limit
    s = a.stiffness
    names = a.joint_names_expr
    if not isinstance(e, dict):
        e = {n: e for n in names}
    if not isinstance(s, dict):
        s = {n: s for n in names}
    for n in s:
        if n in e and s[n]:
            LEG_ACTION_SCALE[n] = 0.25 * e[n] / s[n]
"""
NAMES = ("hip_roll", "hip_pitch", "knee")


def _mjcf(option: str) -> str:
    return (
        f"<mujoco>{option}<worldbody>"
        + "".join(f"<body><joint name='{name}'/><geom size='0.1' mass='1'/></body>" for name in NAMES)
        + "</worldbody></mujoco>"
    )


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "leg.urdf").write_text(urdf_of(*NAMES), encoding="utf-8")
    return tmp_path


def _imported(folder: Path, text: str, *models: str) -> str:
    (folder / "leg_cfg.py").write_text(text, encoding="utf-8")
    assert main(["import", "leg_cfg.py", *(models or ["leg.urdf"]), "-o", "leg.yaml", "--force"]) == 0
    load_spec("leg.yaml")
    return (folder / "leg.yaml").read_text("utf-8")


def test_isaaclab_refuses_two_keys(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each is told at its own line, and the joints have no number of the dict, whichever stands first."""
    for pose, kp in (
        ('".*": 0.0, "knee": -0.5', '".*": 60.0, "hip_.*": 80.0'),
        ('"knee": -0.5, ".*": 0.0', '"hip_.*": 80.0, ".*": 60.0'),
    ):
        text = _imported(folder, ISAACLAB.replace("@POSE@", pose).replace("@KP@", kp))
        err = capsys.readouterr().err
        assert (
            "leg_cfg.py:11:25: DRF014 [warning]: `knee` of effort_limit is for knee, which `.*` is for already\n"
            in err
        )
        assert "help: let one key match each joint: LEG_CFG is refused for it when the robot is made" in err
        assert "leg_cfg.py:5:" in err and err.count("DRF014") == 3
        # 60 and 80 are both for the hips; knee has 60 alone. The knee's limit is the URDF's, 9.
        assert "kp: {value: 60 N*m/rad" in text and "80" not in text and "-0.5" not in text
        assert "kp: unknown" in text and "both match the joint, which Isaac Lab refuses" in text
        assert "effort_limit: {value: 9 N*m, source: leg_urdf}" in text and "22 N*m" not in text
        assert "stated as 0, but for knee: the keys" in text
        # No key of damping is for the knee: no servo and no MuJoCo is in it.
        assert (
            "kd: unknown    # no key of the dict covers the joint: it gets 0" in text
            and "MuJoCo takes" not in text
        )


def test_isaaclab_takes_keys_apart(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Keys of other joints are none of a joint."""
    text = ISAACLAB.replace("@POSE@", '"hip_.*": 0.1, "knee": -0.5').replace(
        "@KP@", '"hip_.*": 80.0, "knee": 60.0'
    )
    text = _imported(folder, text.replace('".*": 20.0', '"hip_.*": 20.0'))
    assert (
        "DRF014" not in capsys.readouterr().err and "effort_limit: {value: 22 N*m, source: leg_cfg}" in text
    )


def test_legged_gym_takes_the_last_key(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of `stiffness`, for both gains, whatever the order of `damping`; a pose goes by the whole name."""
    names = ("hip_roll", "hip", "knee")
    (folder / "leg.urdf").write_text(urdf_of(*names), encoding="utf-8")
    _imported(folder, LEGGED_GYM)
    joints = {joint.joint: joint for joint in _resolved()}
    # `hip` and `hip_roll` are both part of `hip_roll`: the last, 40 and 1, counts.
    assert [joints[name].kp.value for name in names] == [40.0, 60.0, 80.0]
    assert [joints[name].kd.value for name in names] == [1.0, 1.5, 2.0]
    assert [joints[name].default_position.value for name in names] == [0.2, 0.1, -0.9]
    err = capsys.readouterr().err
    assert (
        "leg_cfg.py:8:47: DRF014 [info]: `hip_roll` of stiffness is for hip_roll, which `hip` is for already\n"
        in err
    )
    assert "legged_gym takes the last that is part of the name" in err and "of the pose" not in err


def _resolved() -> tuple:  # type: ignore[type-arg]
    import actspec

    return actspec.resolve(actspec.load("leg.yaml")).joints


@pytest.mark.parametrize(
    ("pose", "knee", "told"),
    [
        ('".*": 0.1, "knee": -0.5', 0.1, True),
        ('"knee": -0.5, ".*": 0.1', -0.5, True),
        # `re.match`: the pattern only begins the name.
        ('"kn": -0.7, "hip_.*": 0.1', -0.7, False),
    ],
)
def test_mjlab_takes_the_first_key_of_a_pose(
    folder: Path, pose: str, knee: float, told: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    _imported(folder, MJLAB.replace("@POSE@", pose).replace("@LAG@", ""))
    assert {joint.joint: joint.default_position.value for joint in _resolved()}["knee"] == knee
    err = capsys.readouterr().err
    assert ("mjlab takes the first that matches" in err) is told and ("DRF014 [warning]" in err) is told


LAGS = ", delay_min_lag=0, delay_max_lag=3"


def test_lags_count_the_models_step(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """3 steps of 4 ms are 12 ms; a default of the engine, and no step, are no length: never 0 to 0."""
    cfg = MJLAB.replace("@POSE@", "").replace("@LAG@", LAGS)
    (folder / "leg.xml").write_text(_mjcf('<option timestep="0.004"/>'), encoding="utf-8")
    text = _imported(folder, cfg, "leg.xml")
    assert (
        "delay: {nominal: unknown, range: [0 ms, 12 ms], sampling: step}    # a range: 0 to 3 steps x 0.004 s"
        in text
    )
    assert "delays count the step of leg.xml, 0.004 s: no other is stated" in capsys.readouterr().out
    (folder / "leg.xml").write_text(_mjcf(""), encoding="utf-8")
    for model in ("leg.xml", "leg.urdf"):
        text = _imported(folder, cfg, model)
        assert (
            "delay: unknown    # 0 to 3 physics steps, whose length no file states\n" in text
            and "0 ms" not in text
        )


PROGRAM = """
if __name__ == "__main__":
    import mujoco.viewer as viewer

    LEG_ACTION_SCALE["knee"] = 9.0
    viewer.launch(LEG_CFG.spec_fn().compile())
"""
KEYS = ISAACLAB.replace("@KP@", '"hip_.*": 80.0, "knee": 60.0').replace('".*": 20.0', '"hip_.*": 20.0')


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        # 0.25 x 18 / 40 and 0.25 x 22 / 60.
        (MJLAB + LOOP.replace("@SCALE@", "0.25 * e / s"), [0.1125, 0.1125, 5.5 / 60]),
        # The robot has another name than the scale, and is the only one.
        ((MJLAB + LOOP).replace("LEG_ART", "ART").replace("@SCALE@", "0.5 * e / s"), [0.225, 0.225, 11 / 60]),
        # 0.25 x 20 / 80 at the hips and 0.25 x 22 / 60 at the knee.
        (KEYS + BY_VALUES, [0.0625, 0.0625, 5.5 / 60]),
        # As mjlab's own robots end: what only a program does is not done by who imports the file.
        (MJLAB + LOOP.replace("@SCALE@", "0.25 * e / s") + PROGRAM, [0.1125, 0.1125, 5.5 / 60]),
    ],
)
def test_a_loop_fills_the_action_scale(folder: Path, text: str, expected: list[float]) -> None:
    _imported(folder, text.replace("@POSE@", "").replace("@LAG@", ""))
    assert [joint.action_scale.value for joint in _resolved()] == pytest.approx(expected, rel=1e-9)


TASK = """
from isaaclab.envs import ManagerBasedRLEnvCfg, mdp
from isaaclab.scene import InteractiveSceneCfg
from isaaclab.utils import configclass
from robot import LEG_CFG, @NAME@
@configclass
class Scene(InteractiveSceneCfg):
    robot = LEG_CFG.replace(prim_path="{ENV_REGEX_NS}/Robot")
@configclass
class Actions:
    joint_pos = mdp.JointPositionActionCfg(asset_name="robot", joint_names=[".*"])
@configclass
class LegEnvCfg(ManagerBasedRLEnvCfg):
    scene: Scene = Scene(num_envs=1)
    actions: Actions = Actions()
    def __post_init__(self):
        self.decimation = 4
        self.sim.dt = 0.005
        self.actions.joint_pos.scale = @SCALE@
"""


@pytest.mark.parametrize("name", ["LEG_ACTION_SCALE", "beyondmimic_action_scale"])
def test_a_loop_of_the_robot_s_file_fills_the_scale_of_its_environment(
    folder: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """0.25 x 20 / 80 at the hips and 0.25 x 22 / 60 at the knee, as of the robot alone, and nothing is unread."""
    robot = (KEYS + BY_VALUES).replace("@POSE@", "").replace("LEG_ACTION_SCALE", name)
    (folder / "robot.py").write_text(robot, encoding="utf-8")
    for beside in ((), ("robot.py",)):
        _imported(folder, TASK.replace("@NAME@", name).replace("@SCALE@", name), "leg.urdf", *beside)
        assert [joint.action_scale.value for joint in _resolved()] == pytest.approx(
            [0.0625, 0.0625, 5.5 / 60], rel=1e-9
        )
        said = capsys.readouterr()
        assert "CFG001" not in said.out + said.err


@pytest.mark.parametrize(
    ("scale", "more"),
    [
        ('LEG_ACTION_SCALE["knee"]', ""),
        ("{**LEG_ACTION_SCALE, 'knee': 0.1}", ""),
        ("LEG_ACTION_SCALE", '        self.actions.joint_pos.scale["knee"] = 0.1\n'),
        ("LEG_ACTION_SCALE", "        self.actions.joint_pos.scale.update(knee=0.1)\n"),
        ("LEG_ACTION_SCALE", '        LEG_ACTION_SCALE.pop("knee")\n'),
        ("LEG_ACTION_SCALE", '        del LEG_ACTION_SCALE["knee"]\n'),
        ("LEG_ACTION_SCALE.copy()", '        self.actions.joint_pos.scale["knee"] = 0.1\n'),
    ],
)
def test_a_scale_that_an_environment_changes_is_unknown(folder: Path, scale: str, more: str) -> None:
    """A dict that a loop fills is known as that loop leaves it, and no longer."""
    (folder / "robot.py").write_text((KEYS + BY_VALUES).replace("@POSE@", ""), encoding="utf-8")
    task = TASK.replace("@NAME@", "LEG_ACTION_SCALE").replace("@SCALE@", scale) + more
    text = _imported(folder, task)
    assert "action_scale: unknown" in text and "action_scale: {" not in text


@pytest.mark.parametrize(
    ("scale", "after", "why"),
    [
        ("limit_of(a) / s", "", "which is not run"),
        ("0.25 * e / s", "HIP.stiffness = 80.0\n", "and line 20 may change it afterwards"),
        ("0.25 * e / s", "\nLEG_ACTION_SCALE.update(knee=1.0)\n", "and line 21 may change it afterwards"),
        ("0.25 * e / s", "LEG_ACTION_SCALE['knee'] = 1.0\n", "and line 20 may change it afterwards"),
        # This module is no program, and a name that nobody knows may be anything.
        (
            "0.25 * e / s",
            "if __name__ != '__main__':\n  HIP.kp = 1\n",
            "and line 21 may change it afterwards",
        ),
        ("0.25 * e / s", "if FINE:\n  HIP.stiffness = 1\n", "and line 20 may change it afterwards"),
        ("a.pop(n)", "", "which is not run"),
    ],
)
def test_a_scale_that_is_not_read_is_told(
    folder: Path, scale: str, after: str, why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """What the loop calls, or what is changed after it, is not known; the place is the loop's."""
    cfg = MJLAB.replace("@POSE@", "").replace("@LAG@", "") + LOOP.replace("@SCALE@", scale) + after
    text = _imported(folder, cfg)
    assert f"action_scale: unknown    # it is computed in a loop, {why}\n" in text
    assert f"  action_scale is left out, it is computed in a loop, {why}: " in capsys.readouterr().out
