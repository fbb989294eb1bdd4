"""Figures of a configuration that tasks, events and helpers of its folder write over are notes there, and are told."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.settings import Settings

GROUP = "{cls}(joint_names_expr={joints}, {figures})"
ROBOT = """import isaaclab.sim as sim_utils
from isaaclab.actuators import DCMotorCfg, DelayedPDActuatorCfg, ImplicitActuatorCfg
from isaaclab.assets import ArticulationCfg

{name}_CFG = ArticulationCfg(
    spawn=sim_utils.UsdFileCfg(usd_path="{usd}"),
    actuators={{{groups}}},
)
"""
LEGS = '[".*_hip_joint", ".*_thigh_joint", ".*_calf_joint"]'
GO2 = f"""
    "legs": ImplicitActuatorCfg(joint_names_expr={LEGS}, effort_limit_sim=100.0, velocity_limit_sim=60.0,
        armature=0.5, stiffness=2.0, damping=5.0)"""
"""100 N*m are 4.22 times a Go2's 23.7, 60 rad/s 2 times its 30.1 and 0.5 kg*m^2 33.8 times its 0.0148; 5 N*m*s/rad
beside 2 N*m/rad come back in 2.5 s."""

TASK = """from robots import {name}_CFG
class Task:
    robot = {name}_CFG
    def __post_init__(self):
{body}
"""
CODES = {"KNW101", "KNW103", "UNT107"}


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()


def write(groups: str, *lines: str, name: str = "GO2", usd: str = "go2.usd") -> None:
    """A robot and a task that uses it."""
    Path("r/robots.py").write_text(ROBOT.format(name=name, usd=usd, groups=groups))
    body = "\n".join(f"        {line}" for line in lines or ("pass",))
    Path("r/task.py").write_text(TASK.format(name=name, body=body))


def severities(code: str, *named: str, as_named: bool = False) -> set[str]:
    found = audit(list(named or ("r",)), Settings(select=(code,), as_named=as_named)).findings
    return {item.severity.value for item in found}


def noted() -> set[str]:
    """The rules whose findings of the Go2 are notes, by itself each; each has some."""
    found = {code: severities(code) for code in CODES}
    assert all(found.values())
    return {code for code, grave in found.items() if grave == {"info"}}


@pytest.mark.parametrize(
    ("lines", "wanted"),
    [
        ([], set()),
        (['legs = self.robot.actuators["legs"]', "legs.effort_limit_sim = 23.5"], {"KNW101"}),
        (['legs = self.robot.actuators["legs"]', "x = 1", "legs.stiffness = 20.0"], {"UNT107"}),
        (['setattr(self.robot.actuators["legs"], "armature", 0.01)'], {"KNW103"}),
        (
            ['self.robot.actuators["legs"] = self.robot.actuators["legs"].replace(effort_limit_sim=23.5)'],
            {"KNW101"},
        ),
        (["m = {k: a.replace(stiffness=kp) for k, a in self.robot.actuators.items()}"], {"UNT107"}),
        (["robot.write_joint_effort_limit_to_sim(torch.full_like(limits, 23.5))"], {"KNW101"}),
        (["self.robot.write_joint_armature_to_sim(0.01)"], {"KNW103"}),
        (["self.robot.write_joint_velocity_limit_to_sim(30.0)"], {"KNW103"}),
        (["self.robot.write_joint_stiffness_to_sim(0.0)"], {"UNT107"}),
        (["art.set_gains(kps=0.0, kds=10.0)"], {"UNT107"}),
        (["self.robot.set_joint_effort_target(torch.clip(tau, -23.5, 23.5))"], {"KNW101", "UNT107"}),
        # All of a group, or all groups.
        (['self.robot.actuators["legs"] = DCMotorCfg(joint_names_expr=[".*"])'], CODES),
        (['self.robot.actuators = {"legs": DCMotorCfg(joint_names_expr=[".*"])}'], CODES),
        (["self.robot.actuators.update(legs=LEGS)"], CODES),
        (['del self.robot.actuators["legs"]'], CODES),
        (['self.robot = GO2_CFG.replace(p="/World", actuators={"legs": ImplicitActuatorCfg(x=1)})'], CODES),
        (['self.robot = GO2_CFG.replace(p="/World", actuators={"legs": LEGS})'], CODES),
        # It reads them, or has another object of these names; Isaac Lab's own classes and events write what was stated.
        (['legs = self.robot.actuators["legs"]', "assert legs.effort_limit_sim == 100.0"], set()),
        (['legs = self.robot.actuators["legs"]', "arms.effort_limit_sim = 23.5"], set()),
        (["self.actuators = {}", "self.actuators[name] = actuator"], set()),
        (["self.write_joint_effort_limit_to_sim(actuator.effort_limit)"], set()),
        (["asset.write_joint_armature_to_sim(armature[env_ids])"], set()),
        (["self.robot.write_joint_armature_to_sim(armature * scale)"], set()),
        (['assert self.robot.actuators == {"legs": LEGS}'], set()),
        (['text = text.replace("stiffness=2.0", "")'], set()),
    ],
)
def test_figures_of_a_group(lines: list[str], wanted: set[str]) -> None:
    write(GO2, *lines)
    assert noted() == wanted
    for code in CODES:
        assert severities(code, as_named=True) == severities(code, "r/robots.py") == {"warning"}


@pytest.mark.parametrize(
    ("line", "severity"),
    [
        ("robot.set_joint_position_target(q)", "warning"),
        ("robot.apply_action(ArticulationAction(joint_velocities=v))", "info"),
        ("robot.apply_action(ArticulationAction(q, joint_efforts=tau))", "info"),
        ("robot.apply_action(ArticulationAction(joint_positions=q, joint_velocities=None))", "warning"),
        ("joint_velocities = robot.get_joint_velocities()", "warning"),
        ("robot.apply_wheel_actions(controller.forward(v))", "info"),
        ("controller = DifferentialController('c', 0.1, 0.5)", "info"),
        ("controller = DifferentialIKController(cfg)", "warning"),
        ("action = AckermannActionCfg(drive_joint_names=['.*_wheel'])", "info"),
        ("action = mdp.JointEffortActionCfg(joint_names=['.*_wheel'])", "info"),
        ("action = mdp.JointPositionActionCfg(joint_names=['.*_wheel'])", "warning"),
        ("robot.set_joint_effort_target(tau)", "info"),
        ("art.switch_control_mode('velocity')", "info"),
        ("art.switch_control_mode('position')", "warning"),
        # Forks of legged_gym: a wheel's speed; its own drives by position, and by speed with kp.
        ("torques[:, w] = self.d_gains[w]*(vel - self.dof_vel[:, w])", "info"),
        ("torques = self.p_gains*(q - self.dof_pos) - self.d_gains*self.dof_vel", "warning"),
        ("torques = p - self.d_gains*(self.dof_vel - self.last_dof_vel)/dt", "warning"),
    ],
)
def test_a_joint_that_follows_a_speed_or_a_torque(line: str, severity: str) -> None:
    """kd 100 beside kp 1: it would take 100 s to come back to a position, and nobody commands one."""
    wheels = 'joint_names_expr=[".*_wheel"], effort_limit_sim=20.0, stiffness=1.0, damping=100.0'
    write(f'"wheels": ImplicitActuatorCfg({wheels})', line, name="ROVER", usd="rover.usd")
    assert severities("UNT107") == {severity}
    assert severities("UNT107", as_named=True) == severities("UNT107", "r/robots.py") == {"warning"}


@pytest.mark.parametrize(
    ("group", "joint", "severity"),
    [
        ("doors", "j_.*", "info"),
        ("all", "drawer_top_joint", "info"),
        ("indoor_legs", "slider_.*", "warning"),
    ],
)
def test_a_door_that_nobody_commands(group: str, joint: str, severity: str) -> None:
    """kd 100 beside kp 1 is a brake: there is no command to come back to."""
    drive = f'ImplicitActuatorCfg(joint_names_expr=["{joint}"], effort_limit_sim=20.0, '
    drive += "stiffness=1.0, damping=100.0)"
    write(f'"{group}": {drive}', name="CABINET", usd="cabinet.usd")
    assert severities("UNT107") == {severity}
    assert severities("UNT107", as_named=True) == {"warning"}


_PD = "effort_limit=20.0, stiffness=20.0, damping=0.5"
_TWICE = f"""
    "legs": ImplicitActuatorCfg(joint_names_expr=["hip", "knee"], {_PD}),
    "knee": ImplicitActuatorCfg(joint_names_expr=["knee", "ankle"], {_PD.replace("20.0", "30.0")})"""
_DELAYED = f"""
    "legs": DelayedPDActuatorCfg(joint_names_expr=["hip"], {_PD}, min_delay=4, max_delay=2)"""
_MISSING = f"""
    "legs": ImplicitActuatorCfg(joint_names_expr=["hip", "knee"], {_PD.replace("20.0", '{"hip": 20.0}', 1)})"""
_NO_GAINS = '"legs": DCMotorCfg(joint_names_expr=["hip"], effort_limit=9.0, saturation_effort=9.0, velocity_limit=9.0)'


@pytest.mark.parametrize(
    ("code", "groups", "lines", "severity"),
    [
        ("ORD103", _TWICE, [], "error"),
        ("ORD103", _TWICE, ['self.robot.actuators.pop("knee")'], "info"),
        ("ORD103", _TWICE, ['self.robot.actuators["knee"].joint_names_expr = ["ankle"]'], "info"),
        ("ORD103", _TWICE, ['self.robot.actuators["knee"].stiffness = 9.0'], "error"),
        ("DLY103", _DELAYED, [], "error"),
        ("DLY103", _DELAYED, ['self.robot.actuators["legs"].min_delay = 0'], "info"),
        ("DLY103", _DELAYED, ['self.robot.actuators["legs"].stiffness = 9.0'], "error"),
        ("CFG101", _MISSING, [], "error"),
        ("CFG101", _MISSING, ['self.robot.actuators["legs"].effort_limit = 20.0'], "info"),
        ("CFG101", _MISSING, ['x = self.robot.actuators["legs"].effort_limit'], "error"),
        ("CFG104", _NO_GAINS, [], "error"),
        ("CFG104", _NO_GAINS, ['legs = self.robot.actuators["legs"]', "legs.stiffness = kp"], "info"),
    ],
)
def test_what_could_not_be_made(code: str, groups: str, lines: list[str], severity: str) -> None:
    write(groups, *lines, name="DOG", usd="dog.usd")
    assert severities(code) == {severity}
    # Of a folder of one's own lags alone are asked for there.
    assert severities(code, as_named=True) == {severity if code == "DLY103" else "error"}


EVENTS = """from isaaclab.envs import ManagerBasedRLEnvCfg, mdp
from isaaclab.managers import EventTermCfg as EventTerm, SceneEntityCfg
from isaaclab.scene import InteractiveSceneCfg
from robots import GO2_CFG

class SceneCfg(InteractiveSceneCfg):
    robot = GO2_CFG.replace(prim_path="/World/Robot")

class EventCfg:
    draw = EventTerm(func=mdp.{function}, mode="startup",
        params={{"asset_cfg": SceneEntityCfg("robot", joint_names="{joints}"), {params}}})

class BaseEnvCfg(ManagerBasedRLEnvCfg):
    scene: SceneCfg = SceneCfg(num_envs=4096)
    events: EventCfg = EventCfg()
"""
_NEGATIVE = '"stiffness_distribution_params": (-0.2, 0.2), "operation": "scale"'


def write_events(function: str, params: str, more: str = "", joints: str = ".*") -> None:
    write(GO2.replace("armature=0.5", "armature=0.0"))
    Path("r/env.py").write_text(EVENTS.format(function=function, params=params, joints=joints) + more)


@pytest.mark.parametrize(
    ("more", "severity"),
    [
        ("", "error"),
        ("class Dog(BaseEnvCfg):\n    def __post_init__(self):\n        self.events.draw = None\n", "info"),
        (
            "class Dog(BaseEnvCfg):\n    def __post_init__(self):\n"
            '        self.events.draw.params["stiffness_distribution_params"] = (0.8, 1.2)\n',
            "info",
        ),
        # Another event, its joints alone, and what is only played.
        ("class Dog(BaseEnvCfg):\n    def __post_init__(self):\n        self.events.push = None\n", "error"),
        (
            "class Dog(BaseEnvCfg):\n    def __post_init__(self):\n"
            '        self.events.draw.params["asset_cfg"].joint_names = ".*"\n',
            "error",
        ),
        (
            "class Dog_PLAY(BaseEnvCfg):\n    def __post_init__(self):\n        self.events.draw = None\n",
            "error",
        ),
        ("def randomize_actuator_gains(env, env_ids, asset_cfg):\n    k = 1.0 + draw()\n", "info"),
        ("def randomize_mass(env, env_ids, asset_cfg):\n    k = 1.0 + draw()\n", "error"),
    ],
)
def test_an_event_that_a_task_sets_otherwise(more: str, severity: str) -> None:
    """kp times -0.2 is negative."""
    write_events("randomize_actuator_gains", _NEGATIVE, more)
    assert severities("DRN106") == {severity}
    assert severities("DRN106", as_named=True) == {"error"}


@pytest.mark.parametrize(
    ("line", "severity"),
    [("pass", "warning"), ("armature = 0.01", "info"), ("stiffness = 20.0", "warning")],
)
def test_a_zero_that_a_task_sets(line: str, severity: str) -> None:
    write_events(
        "randomize_joint_parameters", '"armature_distribution_params": (0.8, 1.2), "operation": "scale"'
    )
    setting = line if line == "pass" else f'self.robot.actuators["legs"].{line}'
    Path("r/task.py").write_text(TASK.format(name="GO2", body=f"        {setting}"))
    assert severities("DRN102") == {severity}
    assert severities("DRN102", as_named=True) == {"warning"}


@pytest.mark.parametrize(
    ("params", "joints", "more", "severity"),
    [
        ('"stiffness_distribution_params": (40.0, 60.0), "operation": "abs"', ".*", "", "info"),
        ('"stiffness_distribution_params": (0.8, 1.2), "operation": "scale"', ".*", "", "warning"),
        ('"stiffness_distribution_params": (40.0, 60.0), "operation": "abs"', "arm_.*", "", "warning"),
        (
            '"stiffness_distribution_params": (40.0, 60.0), "operation": "abs"',
            ".*",
            "class Dog(BaseEnvCfg):\n    def __post_init__(self):\n        self.events.draw = None\n",
            "warning",
        ),
    ],
)
def test_gains_that_are_drawn_anew(params: str, joints: str, more: str, severity: str) -> None:
    """Nobody runs with the 2 N*m/rad that stand in the configuration."""
    write_events("randomize_actuator_gains", params, more, joints)
    assert severities("UNT107") == {severity}
    assert severities("UNT107", as_named=True) == {"warning"}


CLAW = """<mujoco model="claw"><compiler angle="radian"/>
<default><joint damping="0.5" armature="0.001"/></default>
<worldbody><body name="base"><geom type="box" size=".05 .05 .05" mass="1"/><body name="a" pos="0 0 .1">
<joint name="yaw" axis="0 0 1" range="-2 2"/><geom type="capsule" fromto="0 0 0 .2 0 0" size=".02" mass=".3"/>
<body name="b" pos=".2 0 0"><joint name="pitch" axis="0 1 0" range="-2 2"/>
<geom type="capsule" fromto="0 0 0 .2 0 0" size=".02" mass=".2"/></body></body></body></worldbody></mujoco>
"""
CONSTANTS = """from pathlib import Path
import mujoco
from mjlab.actuator import IdealPdActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg, EntityCfg
def get_spec():
    {spec}
    return spec
ARM = IdealPdActuatorCfg(target_names_expr=({joints},), stiffness=5.0, damping=0.2, effort_limit=2.0)
CLAW_CFG = EntityCfg(spec_fn=get_spec, articulation=EntityArticulationInfoCfg(actuators=(ARM,)))
"""
LOADS = 'spec = mujoco.MjSpec.from_file("claw.xml")'
CHANGED = """spec = mujoco.MjSpec.from_string(Path("claw.xml").read_text().replace('damping="0.5"', ''))"""


@pytest.mark.parametrize(
    ("spec", "task", "severity"),
    [
        (LOADS, "", "error"),
        (CHANGED, "", "info"),
        (LOADS, "def strip(spec):\n    for joint in spec.joints:\n        joint.damping = 0.0\n", "info"),
        (LOADS, "def setup(env):\n    env.sim.model.dof_damping[:, 6:] = 0.0\n", "info"),
        (LOADS, "def setup(env):\n    cfg.articulation.actuators = (IdealPdActuatorCfg(),)\n", "info"),
        (LOADS, "def setup(env):\n    return env.sim.model.dof_damping[:, 6:]\n", "error"),
        (
            LOADS,
            'EVENTS = {"x": EventTermCfg(mode="startup", func=dr.joint_damping, params={"asset_cfg": '
            'SceneEntityCfg("robot", joint_names=(".*",)), "ranges": (0.0, 0.0), "operation": "abs"})}\n'
            "CFG = ManagerBasedRlEnvCfg(decimation=4, events=EVENTS, scene=SceneCfg(entities={'robot': CLAW_CFG}))\n",
            "info",
        ),
    ],
)
def test_damping_that_a_program_takes_from_a_spec(spec: str, task: str, severity: str) -> None:
    """0.2 and 0.5 N*m*s/rad are 0.7, 3.5 times as much."""
    Path("r/claw.xml").write_text(CLAW)
    Path("r/claw_constants.py").write_text(CONSTANTS.format(spec=spec, joints='".*"'))
    Path("r/env.py").write_text(
        "from mjlab.envs import ManagerBasedRlEnvCfg\nfrom mjlab.envs.mdp import dr\n"
        "from mjlab.managers import EventTermCfg, SceneEntityCfg\nfrom mjlab.scene import SceneCfg\n"
        f"from claw_constants import CLAW_CFG\n{task}run(CLAW_CFG)\n"
    )
    assert severities("DMP105") == {severity}
    assert severities("DMP105", as_named=True) == {"error"}


@pytest.mark.parametrize(
    ("helper", "severity"),
    [
        ("", "warning"),
        ("def tool(spec):\n    spec.add_actuator(name='d', target='d')\n", "info"),
        ("def spin(env):\n    env.sim.data.qfrc_applied[:, 3] = 0.1\n", "info"),
        ("def tool(spec):\n    spec.add_sensor(name='d')\n", "warning"),
    ],
)
def test_a_joint_that_a_helper_drives(helper: str, severity: str) -> None:
    """Three of four joints have a group."""
    bodies = "".join(f'<body><joint name="{n}"/><geom size=".1"/>' for n in "abcd")
    Path("r/claw.xml").write_text(
        f'<mujoco model="claw"><worldbody>{bodies}{"</body>" * 4}</worldbody></mujoco>'
    )
    Path("r/claw_constants.py").write_text(CONSTANTS.format(spec=LOADS, joints='"a", "b", "c"'))
    Path("r/helper.py").write_text(f"from claw_constants import CLAW_CFG\n{helper}run(CLAW_CFG)\n")
    assert severities("CFG102") == {severity}
    assert severities("CFG102", as_named=True) == {"warning"}


@pytest.mark.parametrize(
    ("usd", "told"),
    [
        ("go2/go2.usd", True),
        # Nobody knows that one: its owner may have called a Go2 so.
        ("mydog/mydog.usd", True),
        ("go2_with_arm.usd", True),
        ("b2/b2.usd", False),
        ("robots/b2/usd/robot.usd", False),
        ("b2/go2.usd", True),
    ],
)
def test_a_constant_with_the_model_of_another_robot(usd: str, told: bool) -> None:
    """100 N*m are 4.22 times a Go2's 23.7, and nothing of the kind of a B2's 200."""
    write(GO2, usd=usd)
    assert severities("KNW101") == ({"warning"} if told else set())
