"""Configurations in the shapes that Isaac Lab, mjlab, legged_gym and their users write."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from actspec.readings.artifact import ActuatorGroup, FileKind, Framework, RandomizedRange, RobotConfig
from actspec.readings.config import control_of_group, figures_of
from actspec.readings.python.read import read_python
from actspec.readings.versions import Versions


def read(folder: Path, text: str, name: str = "cfg.py") -> dict[str, RobotConfig]:
    """The configurations in a file with this text, by name."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    reading = read_python(str(path))
    assert reading.reason is None, reading.reason
    assert {artifact.kind for artifact in reading.artifacts} <= {FileKind.CFG}
    return {artifact.name: artifact.config for artifact in reading.artifacts if artifact.config is not None}


def values(group: ActuatorGroup) -> dict[str, object]:
    """Settings of a group without places; what is unknown by its reason."""
    return {
        name: one.value if one.unknown is None else f"? {one.unknown}" for name, one in group.settings.items()
    }


def settings(config: RobotConfig) -> dict[str, object]:
    """Robot-wide settings without places; what is unknown by its reason."""
    return {
        name: one.value if one.unknown is None else f"? {one.unknown}"
        for name, one in config.settings.items()
    }


def terms(config: RobotConfig) -> list[tuple[object, ...]]:
    """Action terms: name, joints, what they command and their scale."""
    return [
        (one.name, one.joints, one.command, None if one.scale is None else one.scale.value)
        for one in config.actions
    ]


def ranges(config: RobotConfig) -> list[tuple[object, ...]]:
    """Ranges without places."""
    return [(r.field, r.operation, r.low, r.high, r.joints, r.distribution) for r in config.randomize]


ISAACLAB = """
import isaaclab.sim as sim_utils
from isaaclab.actuators import DCMotorCfg, ImplicitActuatorCfg
from isaaclab.assets.articulation import ArticulationCfg
from isaaclab.utils.assets import ISAACLAB_NUCLEUS_DIR

KNEE = 35.0
LEG_ACTUATOR = DCMotorCfg(
    joint_names_expr=[".*_hip", ".*_knee"],
    effort_limit={".*_hip": 20.0, ".*_knee": KNEE * 1.5},
    saturation_effort=60,
    velocity_limit=30.0,
    stiffness=25.0,
    damping=0.5,
)
SPARE = DCMotorCfg(joint_names_expr=["spare"], stiffness=1.0)

DOG_CFG = ArticulationCfg(
    spawn=sim_utils.UsdFileCfg(usd_path=f"{ISAACLAB_NUCLEUS_DIR}/Robots/Dog/dog.usd"),
    init_state=ArticulationCfg.InitialStateCfg(pos=(0, 0, 1), joint_pos={".*_hip": 0.1, ".*_knee": -1.5}),
    soft_joint_pos_limit_factor=0.9,
    actuators={
        "legs": LEG_ACTUATOR,
        "arm": ImplicitActuatorCfg(joint_names_expr="arm_.*", stiffness=None, damping=0.0, effort_limit_sim=5),
    },
)
LEG_ACTUATOR.stiffness = 99.0

STIFF_DOG_CFG = DOG_CFG.replace(soft_joint_pos_limit_factor=1.0)
STIFF_DOG_CFG.actuators["legs"].stiffness *= 2
STIFF_DOG_CFG.init_state.joint_pos[".*_hip"] = 0.0
del STIFF_DOG_CFG.actuators["arm"]
"""


def test_isaaclab_robots(tmp_path: Path) -> None:
    """Robots, their copies and what is assigned afterwards; a configclass shares nothing with what it was given."""
    configs = read(tmp_path, ISAACLAB)
    assert list(configs) == ["SPARE", "DOG_CFG", "STIFF_DOG_CFG"]
    assert {config.framework for config in configs.values()} == {Framework.ISAACLAB}
    dog, stiff = configs["DOG_CFG"], configs["STIFF_DOG_CFG"]
    legs, arm = dog.groups
    assert (legs.name, legs.cls, legs.joints, legs.span.line) == (
        "legs",
        "DCMotorCfg",
        (".*_hip", ".*_knee"),
        8,
    )
    # 35 * 1.5 = 52.5
    assert values(legs) == {
        "effort_limit": {".*_hip": 20.0, ".*_knee": 52.5},
        "saturation_effort": 60,
        "velocity_limit": 30.0,
        "stiffness": 25.0,
        "damping": 0.5,
    }
    assert (arm.cls, arm.joints) == ("ImplicitActuatorCfg", ("arm_.*",))
    assert values(arm) == {"stiffness": None, "damping": 0.0, "effort_limit_sim": 5}
    assert settings(dog) == {
        "soft_joint_pos_limit_factor": 0.9,
        "default_position": {".*_hip": 0.1, ".*_knee": -1.5},
        "model": "{ISAACLAB_NUCLEUS_DIR}/Robots/Dog/dog.usd",
    }
    assert [group.name for group in stiff.groups] == ["legs"]
    assert values(stiff.groups[0])["stiffness"] == 50.0
    assert settings(stiff)["default_position"] == {".*_hip": 0.0, ".*_knee": -1.5}
    assert settings(stiff)["soft_joint_pos_limit_factor"] == 1.0
    assert dog.notes == stiff.notes == ()


def test_isaaclab_3_names_and_dict(tmp_path: Path) -> None:
    """A dict of actuators alone, as actspec writes it, with the names of Isaac Lab 3; fields stay as written."""
    configs = read(
        tmp_path,
        """
from isaaclab.actuators import DCMotorCfg
DOG_ACTUATORS = {
    "legs": DCMotorCfg(joint_names_expr=["a"], actuator_effort_limit=3.0, joint_velocity_limit=4.0),
}
DOG_ACTION_SCALE = {"a": 0.25}
""",
    )
    (config,) = configs.values()
    assert (config.name, config.span.line, config.span.column) == ("DOG_ACTUATORS", 3, 1)
    assert values(config.groups[0]) == {"actuator_effort_limit": 3.0, "joint_velocity_limit": 4.0}
    assert settings(config) == {"action_scale": {"a": 0.25}}


def test_own_actuator_classes(tmp_path: Path) -> None:
    """Classes of the user's own file beside it: their fields are written there, in base classes too."""
    (tmp_path / "motors.py").write_text(
        """
from dataclasses import MISSING
from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.utils import configclass

class CurveActuator:
    pass

@configclass
class CurveActuatorCfg(IdealPDActuatorCfg):
    class_type: type = CurveActuator
    X1: float = 1e9
    Y1: float = MISSING

@configclass
class CurveActuatorCfg_Small(CurveActuatorCfg):
    X1 = 13.5
    Y1 = 20.2
""",
        encoding="utf-8",
    )
    configs = read(
        tmp_path,
        """
from isaaclab.assets import ArticulationCfg
from isaaclab.utils import configclass
import motors

@configclass
class DogArticulationCfg(ArticulationCfg):
    joint_sdk_names: list[str] = None
    soft_joint_pos_limit_factor = 0.8

DOG_CFG = DogArticulationCfg(
    actuators={"all": motors.CurveActuatorCfg_Small(joint_names_expr=[".*"], stiffness=25.0)},
    joint_sdk_names=["FR", "FL"],
)

@configclass
class CatCfg(DogArticulationCfg):
    actuators = {"all": motors.CurveActuatorCfg(joint_names_expr=["b"], Y1=2.0)}

    def __post_init__(self):
        self.actuators["all"].damping = 3.0
""",
    )
    assert list(configs) == ["DOG_CFG", "CatCfg"]
    (group,) = configs["DOG_CFG"].groups
    assert group.cls == "CurveActuatorCfg_Small"
    assert values(group) == {"class_type": "CurveActuator", "X1": 13.5, "Y1": 20.2, "stiffness": 25.0}
    assert group.settings["Y1"].span.path == str(tmp_path / "motors.py")
    assert settings(configs["DOG_CFG"]) == {"soft_joint_pos_limit_factor": 0.8, "joint_order": ("FR", "FL")}
    (group,) = configs["CatCfg"].groups
    assert values(group) == {"class_type": "CurveActuator", "X1": 1e9, "Y1": 2.0, "damping": 3.0}


ENVIRONMENT = """
from isaaclab.envs import ManagerBasedRLEnvCfg
import isaaclab.envs.mdp as mdp
from isaaclab.managers import EventTermCfg as EventTerm, SceneEntityCfg
from isaaclab.scene import InteractiveSceneCfg
from isaaclab.utils import configclass
from isaaclab_assets import DOG_CFG

@configclass
class SceneCfg(InteractiveSceneCfg):
    robot = DOG_CFG.replace(prim_path="{ENV_REGEX_NS}/Robot")

@configclass
class ActionsCfg:
    joint_pos = mdp.JointPositionActionCfg(asset_name="robot", joint_names=[".*"], scale=0.5)

@configclass
class EventCfg:
    gains = EventTerm(
        func=mdp.randomize_actuator_gains,
        mode="reset",
        params={
            "asset_cfg": SceneEntityCfg("robot", joint_names=[".*_hip"]),
            "stiffness_distribution_params": (0.75, 1.5),
            "damping_distribution_params": (0.3, 3.0),
            "operation": "scale",
            "distribution": "log_uniform",
        },
    )
    joints = EventTerm(
        func=mdp.randomize_joint_parameters,
        mode="startup",
        params={"asset_cfg": SceneEntityCfg("robot"), "armature_distribution_params": (0.01, 0.02)},
    )
    push = EventTerm(func=mdp.push_by_setting_velocity, mode="interval", params={"velocity_range": {}})

@configclass
class DogEnvCfg(ManagerBasedRLEnvCfg):
    scene: SceneCfg = SceneCfg(num_envs=4)
    actions: ActionsCfg = ActionsCfg()
    events: EventCfg = EventCfg()

    def __post_init__(self):
        self.decimation = 4
        self.sim.dt = 1 / 200
        if getattr(self.curriculum, "levels", None) is not None:
            self.sim.render_interval = 1

@configclass
class DogFlatEnvCfg(DogEnvCfg):
    def __post_init__(self):
        super().__post_init__()
        self.actions.joint_pos.scale = 0.25
        self.events.joints = None
        self.events.gains.params["stiffness_distribution_params"] = (0.9, 1.1)

@configclass
class DogFlatEnvCfg_PLAY(DogFlatEnvCfg):
    def __post_init__(self):
        super().__post_init__()
        self.scene.num_envs = 1
"""


def test_isaaclab_environment(tmp_path: Path) -> None:
    """Environments by inheritance, with what `__post_init__` assigns; a variant for playing is not read twice."""
    configs = read(tmp_path, ENVIRONMENT)
    assert list(configs) == ["DogEnvCfg", "DogFlatEnvCfg"]
    base, flat = configs["DogEnvCfg"], configs["DogFlatEnvCfg"]
    assert settings(base) == {"physics_dt": 0.005, "decimation": 4}
    assert terms(base) == [("joint_pos", (".*",), "position", 0.5)]
    assert ranges(base) == [
        ("kp", "scale", 0.75, 1.5, (".*_hip",), "log_uniform"),
        ("kd", "scale", 0.3, 3.0, (".*_hip",), "log_uniform"),
        # Without `operation` Isaac Lab takes the range itself.
        ("armature", "abs", 0.01, 0.02, None, "uniform"),
    ]
    assert settings(flat) == {"physics_dt": 0.005, "decimation": 4}
    assert terms(flat) == [("joint_pos", (".*",), "position", 0.25)]
    assert [one[:4] for one in ranges(flat)] == [("kp", "scale", 0.9, 1.1), ("kd", "scale", 0.3, 3.0)]
    assert base.groups == ()
    (note,) = base.notes
    assert str(note) == (
        f"{tmp_path / 'cfg.py'}:11:13: CFG001 [info] robot: "
        "not known without running it: DOG_CFG comes from isaaclab_assets, which is not beside this file"
    )


CHANGED = {
    "loop": (
        "for name in DOG_CFG.actuators:\n    DOG_CFG.actuators[name].stiffness = 5.0\n",
        {"stiffness": "? built in a loop", "damping": 1.0},
    ),
    "loop over values": (
        "for one in DOG_CFG.actuators.values():\n    one.damping *= 2\n",
        {"stiffness": 2.0, "damping": "? built in a loop"},
    ),
    "function": (
        "def soften(cfg, by=0.5):\n    cfg.actuators['legs'].stiffness *= by\nsoften(DOG_CFG)\n",
        {"stiffness": 1.0, "damping": 1.0},
    ),
    "copy is another": (
        "OTHER = DOG_CFG.copy()\nOTHER.actuators['legs'].stiffness = 7.0\n",
        {"stiffness": 2.0, "damping": 1.0},
    ),
    "same object": (
        "OTHER = DOG_CFG\nOTHER.actuators['legs'].stiffness = 7.0\n",
        {"stiffness": 7.0, "damping": 1.0},
    ),
    "unknown switch": (
        "import os\nif os.environ:\n    DOG_CFG.actuators['legs'].stiffness = 7.0\n",
        {
            "stiffness": "? depends on a condition: environ comes from Python's os, which is not run",
            "damping": 1.0,
        },
    ),
    "setattr in a loop": (
        "for name in ('stiffness', 'damping'):\n    setattr(DOG_CFG.actuators['legs'], 'stiffness', 3)\n",
        {"stiffness": "? built in a loop", "damping": 1.0},
    ),
}


@pytest.mark.parametrize("change, found", CHANGED.values(), ids=CHANGED)
def test_changed_afterwards(tmp_path: Path, change: str, found: dict[str, object]) -> None:
    """A number that a later statement may have changed is never read as it was before."""
    text = """
from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.assets import ArticulationCfg
DOG_CFG = ArticulationCfg(
    actuators={"legs": IdealPDActuatorCfg(joint_names_expr=["a"], stiffness=2.0, damping=1.0)},
)
"""
    config = read(tmp_path, text + change)["DOG_CFG"]
    assert values(config.groups[0]) == found


def test_unknown_groups(tmp_path: Path) -> None:
    """Groups that another package has, or that are added in a loop, are notes with their reasons."""
    config = read(
        tmp_path,
        """
from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.assets import ArticulationCfg
from my_lab import LEGS, ARM
DOG_CFG = ArticulationCfg(
    actuators={"legs": LEGS, **ARM, "tail": IdealPDActuatorCfg(joint_names_expr=ARM.names, stiffness=2.0)},
)
""",
    )["DOG_CFG"]
    (tail,) = config.groups
    assert (tail.name, tail.joints) == ("tail", None)
    reasons = [(note.where, note.message) for note in config.notes]
    assert reasons == [
        ("actuators", "not known without running it: ARM comes from my_lab, which is not beside this file"),
        (
            "actuators.legs",
            "not known without running it: LEGS comes from my_lab, which is not beside this file",
        ),
        ("tail", "not known without running it: names comes from my_lab, which is not beside this file"),
    ]


def test_refused_patterns(tmp_path: Path) -> None:
    """A pattern that could hang selects nothing, of which the group's note says why."""
    config = read(
        tmp_path,
        """
from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.assets import ArticulationCfg
DOG_CFG = ArticulationCfg(
    actuators={"legs": IdealPDActuatorCfg(joint_names_expr=[".*", "(a+)+$"], stiffness={"(b*)*": 2.0, ".*": 1.0})},
)
""",
    )["DOG_CFG"]
    assert [(note.code, note.where, note.message) for note in config.notes] == [
        (
            "CFG001",
            where,
            f"not matched: '{pattern}' has a repeat inside a repeat, which can take forever (catastrophic "
            "backtracking)",
        )
        for where, pattern in (("legs.stiffness", "(b*)*"), ("legs.joints", "(a+)+$"))
    ]


def test_text_is_no_number(tmp_path: Path) -> None:
    """A setting that is none is unknown, and the next of its names does not take its place."""
    config = read(
        tmp_path,
        """
from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.assets import ArticulationCfg
DOG_CFG = ArticulationCfg(
    actuators={
        "legs": IdealPDActuatorCfg(
            joint_names_expr=["hip"], effort_limit="24", effort_limit_sim=80.0, stiffness=[25.0], damping=0.5
        )
    },
)
""",
    )["DOG_CFG"]
    (group,) = config.groups
    found = figures_of(config, group, "hip", "hip", None, Versions())
    assert (found["effort_limit"].value, found["effort_limit"].why) == (None, "it is '24', which is text")
    assert (found["kp"].value, found["kp"].why) == (None, "it is a list")
    assert (found["kd"].value, found["solver_effort_limit"].value) == (0.5, 80.0)


MJLAB = """
from mjlab.actuator import BuiltinPositionActuatorCfg, XmlActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg, EntityCfg
from mjlab.utils.actuator import ElectricActuator, reflected_inertia
from pathlib import Path
import mujoco

XML = Path(__file__).parent / "xmls" / "dog.xml"

def get_spec() -> mujoco.MjSpec:
    return mujoco.MjSpec.from_file(str(XML))

MOTOR = ElectricActuator(reflected_inertia=reflected_inertia(1e-4, 10), velocity_limit=30.0, effort_limit=23.7)
FREQUENCY = 10 * 2.0 * 3.0
LEGS = BuiltinPositionActuatorCfg(
    target_names_expr=(".*_hip", ".*_knee"),
    stiffness=MOTOR.reflected_inertia * FREQUENCY**2,
    damping=2.0 * 2.0 * MOTOR.reflected_inertia * FREQUENCY,
    effort_limit=MOTOR.effort_limit,
    armature=MOTOR.reflected_inertia,
)
DOG_ARTICULATION = EntityArticulationInfoCfg(
    actuators=(LEGS, XmlActuatorCfg(target_names_expr=("tail",), command_field="position")),
    soft_joint_pos_limit_factor=0.9,
)

def get_dog_robot_cfg() -> EntityCfg:
    return EntityCfg(
        init_state=EntityCfg.InitialStateCfg(joint_pos={".*": 0.5}),
        spec_fn=get_spec,
        articulation=DOG_ARTICULATION,
    )

DOG_ACTION_SCALE: dict[str, float] = {}
for a in DOG_ARTICULATION.actuators:
    DOG_ACTION_SCALE[a.target_names_expr[0]] = 0.25 * a.effort_limit / a.stiffness
"""


MADE = """
from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.assets import ArticulationCfg

def make_cfg(scale=1.0):
    return ArticulationCfg(actuators={
        "legs": IdealPDActuatorCfg(joint_names_expr=[".*"], stiffness=20.0 * scale, damping=1.0, effort_limit=9.0),
    })
"""


@pytest.mark.parametrize(
    ("more", "names"),
    [
        ("BIPED_CFG = make_cfg()", ["BIPED_CFG"]),
        ("BIPED_CFG = make_cfg(scale=1.0)\nHEAVY_CFG = make_cfg(2.0)", ["BIPED_CFG", "HEAVY_CFG"]),
        # 20 * 2 = 40 N*m/rad is another robot than the function's own 20; a private name is nobody's robot.
        ("HEAVY_CFG = make_cfg(2.0)", ["make_cfg", "HEAVY_CFG"]),
        ("_BASE = make_cfg()", ["make_cfg", "_BASE"]),
        ("", ["make_cfg"]),
    ],
)
def test_robot_that_a_function_makes(tmp_path: Path, more: str, names: list[str]) -> None:
    """A robot is called as its constant is; the function's name counts where no constant is the same."""
    assert list(read(tmp_path, MADE + more)) == names


def test_mjlab_robot(tmp_path: Path) -> None:
    """An articulation with the entity that uses it: pose and model come from there, groups have their names."""
    (config,) = read(tmp_path, MJLAB).values()
    assert (config.framework, config.name) == (Framework.MJLAB, "DOG_ARTICULATION")
    legs, tail = config.groups
    assert (legs.name, legs.cls, legs.joints) == ("LEGS", "BuiltinPositionActuatorCfg", (".*_hip", ".*_knee"))
    # 1e-4 * 10^2 = 0.01; 0.01 * 60^2 = 36; 4 * 0.01 * 60 = 2.4
    assert values(legs) == pytest.approx(
        {"stiffness": 36.0, "damping": 2.4, "effort_limit": 23.7, "armature": 0.01}
    )
    # Where the numbers are written: the motor's, not the cfg's that names them.
    assert (legs.settings["effort_limit"].span.line, legs.settings["stiffness"].span.line) == (13, 17)
    assert (tail.name, tail.cls, values(tail)) == (
        "actuators[1]",
        "XmlActuatorCfg",
        {"command_field": "position"},
    )
    assert settings(config) == {
        "soft_joint_pos_limit_factor": 0.9,
        "default_position": {".*": 0.5},
        "model": f"{tmp_path}/xmls/dog.xml",
        "action_scale": "? built in a loop",
    }


def test_mjlab_environment(tmp_path: Path) -> None:
    """A function that makes an environment, with the randomisation of its events and the robot of a file beside it."""
    (tmp_path / "dog.py").write_text(MJLAB, encoding="utf-8")
    configs = read(
        tmp_path,
        """
from mjlab.envs import ManagerBasedRlEnvCfg
from mjlab.envs.mdp import dr
from mjlab.envs.mdp.actions import JointPositionActionCfg
from mjlab.managers.event_manager import EventTermCfg
from mjlab.managers.scene_entity_config import SceneEntityCfg
from mjlab.scene import SceneCfg
from mjlab.sim import MujocoCfg, SimulationCfg
from dog import get_dog_robot_cfg

def _base():
    events = {
        "gains": EventTermCfg(
            func=dr.pd_gains, params={"asset_cfg": SceneEntityCfg("robot"), "kp_range": (0.8, 1.2), "kd_range": (1, 2)}
        ),
        "friction": EventTermCfg(
            func=dr.joint_friction,
            params={"ranges": {".*_hip": (0.1, 0.2), ".*_knee": (0.3, 0.4)}, "operation": "add"},
        ),
        "bias": EventTermCfg(func=dr.encoder_bias, params={"bias_range": (-0.1, 0.1)}),
        "feet": EventTermCfg(func=dr.geom_friction, params={"ranges": (0.3, 1.2)}),
    }
    return ManagerBasedRlEnvCfg(
        scene=SceneCfg(entities={}),
        actions={"joint_pos": JointPositionActionCfg(entity_name="robot", actuator_names=(".*",), scale=0.5)},
        events=events,
        sim=SimulationCfg(mujoco=MujocoCfg(timestep=0.005)),
        decimation=4,
    )

def dog_env_cfg(play: bool = False) -> ManagerBasedRlEnvCfg:
    cfg = _base()
    cfg.scene.entities = {"robot": get_dog_robot_cfg()}
    cfg.actions["joint_pos"].scale = 0.2
    if play:
        cfg.decimation = 1
    return cfg

def needs_arguments_env_cfg(rough):
    return _base()
""",
    )
    (config,) = configs.values()
    assert (config.name, config.framework) == ("dog_env_cfg", Framework.MJLAB)
    assert [group.name for group in config.groups] == ["LEGS", "actuators[1]"]
    found = settings(config)
    assert (found["physics_dt"], found["decimation"]) == (0.005, 4)
    assert terms(config) == [("joint_pos", (".*",), "position", 0.2)]
    assert ranges(config) == [
        ("kp", "scale", 0.8, 1.2, None, "uniform"),
        ("kd", "scale", 1.0, 2.0, None, "uniform"),
        ("friction", "add", 0.1, 0.2, (".*_hip",), "uniform"),
        ("friction", "add", 0.3, 0.4, (".*_knee",), "uniform"),
        ("encoder_bias", "add", -0.1, 0.1, None, "uniform"),
    ]


def test_older_mjlab(tmp_path: Path) -> None:
    """mjlab 1.0 to 1.2: `joint_names_expr`, and a wrapper that delays another actuator."""
    configs = read(
        tmp_path,
        """
from mjlab.actuator import DelayedActuatorCfg, IdealPdActuatorCfg
LEGS = DelayedActuatorCfg(
    base_cfg=IdealPdActuatorCfg(joint_names_expr=("a",), stiffness=5.0, damping=1.0), delay_max_lag=3
)
""",
    )
    (config,) = configs.values()
    (group,) = config.groups
    assert (config.framework, group.name, group.cls, group.joints) == (
        Framework.MJLAB,
        "LEGS",
        "DelayedActuatorCfg",
        ("a",),
    )
    assert values(group) == {
        "stiffness": 5.0,
        "damping": 1.0,
        "delay_max_lag": 3,
        "base_cfg": "IdealPdActuatorCfg",
    }


BASE = """
class BaseConfig:
    pass

class LeggedRobotCfg(BaseConfig):
    class init_state:
        default_joint_angles = {"joint_a": 0.0}
    class control:
        control_type = 'P'
        stiffness = {'joint_a': 10.0}
        damping = {'joint_a': 1.0}
        action_scale = 0.5
        decimation = 4
    class asset:
        file = ""
        armature = 0.
    class domain_rand:
        randomize_friction = True
        friction_range = [0.5, 1.25]
    class sim:
        dt = 0.005
"""

DOG = """
from legged_gym.envs.base.legged_robot_config import LeggedRobotCfg, LeggedRobotCfgPPO

class DogRoughCfg( LeggedRobotCfg ):
    class init_state( LeggedRobotCfg.init_state ):
        default_joint_angles = { # [rad]
            'FL_hip_joint': 0.1, 'FR_hip_joint': -0.1 ,
        }
    class control( LeggedRobotCfg.control ):
        stiffness = {'hip': 20., 'calf': 40}  # [N*m/rad]
        damping = {'hip': 0.5, 'calf': 1 / 2}
        action_scale = 0.25
    class asset( LeggedRobotCfg.asset ):
        file = '{LEGGED_GYM_ROOT_DIR}/resources/robots/dog/urdf/dog.urdf'
    class domain_rand( LeggedRobotCfg.domain_rand ):
        randomize_motor_strength = True
        motor_strength_range = [0.9, 1.1]
        randomize_Kp_factor = False
        Kp_factor_range = [0.8, 1.3]
        kd_range = [0.7, 1.4]

class DogRoughCfgPPO( LeggedRobotCfgPPO ):
    class algorithm( LeggedRobotCfgPPO.algorithm ):
        entropy_coef = 0.01
"""


def test_legged_gym_robot(tmp_path: Path) -> None:
    """A class with nested classes, the base read from its package; keys stay parts of names, as written."""
    base = tmp_path / "legged_gym" / "envs" / "base"
    base.mkdir(parents=True)
    for folder in (tmp_path / "legged_gym", tmp_path / "legged_gym" / "envs"):
        (folder / "__init__.py").write_text("", encoding="utf-8")
    dog = base.with_name("dog")
    dog.mkdir()
    (base / "legged_robot_config.py").write_text(BASE, encoding="utf-8")
    (config,) = read(dog, DOG, "dog_config.py").values()
    assert (config.framework, config.name, config.span.line) == (Framework.LEGGED_GYM, "DogRoughCfg", 4)
    (group,) = config.groups
    assert (group.name, group.cls, group.joints) == ("control", "P", ("hip", "calf"))
    assert values(group) == {
        "stiffness": {"hip": 20.0, "calf": 40},
        "damping": {"hip": 0.5, "calf": 0.5},
        "armature": 0.0,
    }
    assert group.settings["armature"].span.path == str(base / "legged_robot_config.py")
    assert settings(config) == {
        "decimation": 4,
        "action_scale": 0.25,
        "physics_dt": 0.005,
        "default_position": {"FL_hip_joint": 0.1, "FR_hip_joint": -0.1},
        "model": "{LEGGED_GYM_ROOT_DIR}/resources/robots/dog/urdf/dog.urdf",
    }
    # The switch of kp is off; the ground's friction is no joint's.
    assert ranges(config) == [
        ("strength", "scale", 0.9, 1.1, None, "uniform"),
        ("kd", "scale", 0.7, 1.4, None, "uniform"),
    ]
    assert config.notes == ()


@pytest.mark.parametrize(("low", "scaled"), [("0.7", True), ("0", True), ("-0.1", False)])
def test_a_range_below_zero_is_no_factor(tmp_path: Path, low: str, scaled: bool) -> None:
    """Some forks of legged_gym add to a gain what others multiply it by: 0.5 +- 0.1, not 0.5 times -0.1."""
    text = BASE.replace("friction_range = [0.5, 1.25]", f"kd_range = [{low}, 0.1]")
    (config,) = read(tmp_path, text.replace('file = ""', 'file = "dog.urdf"')).values()
    found = [("kd", "scale", float(low), 0.1, None, "uniform")] if scaled else []
    assert ranges(config) == found
    assert [note.where for note in config.notes] == ([] if scaled else ["domain_rand.kd_range"])


def test_an_armature_that_training_draws_is_not_the_assets(tmp_path: Path) -> None:
    """Forks put the drawn one in its place, add it, or multiply by it: what the asset has is nobody's figure."""
    both = BASE.replace('file = ""', 'file = "dog.urdf"').replace("LeggedRobotCfg", "DogCfg")
    drawn = "    class domain_rand:\n        randomize_joint_armature = %s\n"
    (without,) = read(
        tmp_path, both.replace("    class domain_rand:\n", drawn % False), "one_config.py"
    ).values()
    assert values(without.groups[0])["armature"] == 0.0
    (config,) = read(
        tmp_path, both.replace("    class domain_rand:\n", drawn % True), "dog_config.py"
    ).values()
    assert (
        config.groups[0].settings["armature"].unknown == "domain_rand.randomize_joint_armature draws another"
    )
    assert [(note.code, note.where) for note in config.notes] == [("CFG001", "asset.armature")]
    named = both.replace('file = "dog.urdf"', 'file = "dog.urdf"\n        dof_armature = 0.13')
    (config,) = read(tmp_path, named, "named_config.py").values()
    assert config.groups[0].settings["armature"].unknown == "asset.dof_armature may be in its place"


@pytest.mark.parametrize(
    ("asset", "control", "unknown"),
    [
        ("rotor_inertia = [0.0001188] * 12", "", "asset.rotor_inertia may be in its place"),
        ("", "motor_inertia = 0.01", "control.motor_inertia may be in its place"),
        ("use_dof_armature = True", "", "asset.use_dof_armature may be in its place"),
        # Of links, nothing, and not in force.
        ("override_inertia = True", "", None),
        ("dof_armature = []", "", None),
        ("use_dof_armature = False", "", None),
    ],
)
def test_an_armature_of_a_forks_own(tmp_path: Path, asset: str, control: str, unknown: str | None) -> None:
    """Forks write one of their own into the joints: what `armature` has, or has not, is not all then."""
    text = BASE.replace('file = ""', f'file = "dog.urdf"\n        {asset or "pass"}')
    text = text.replace("    class control:\n", f"    class control:\n        {control or 'pass'}\n")
    (config,) = read(tmp_path, text).values()
    assert config.groups[0].settings["armature"].unknown == unknown


def test_a_base_may_have_the_forks_armature(tmp_path: Path) -> None:
    """What a robot's asset inherits is its own."""
    base = BASE.replace('file = ""', 'file = "dog.urdf"\n        rotor_inertia = [0.01]')
    text = (
        base
        + "\nclass CatCfg(LeggedRobotCfg):\n    class asset(LeggedRobotCfg.asset):\n        file = 'cat.urdf'\n"
    )
    cat = next(one for one in read(tmp_path, text).values() if one.name == "CatCfg")
    assert cat.groups[0].settings["armature"].unknown == "asset.rotor_inertia may be in its place"


@pytest.mark.parametrize(("mode", "cls"), [(1, "PhysX"), (2, "PhysX"), (3, "P")])
def test_a_drive_of_physx_is_no_torque(tmp_path: Path, mode: int, cls: str) -> None:
    """Isaac Gym: DOF_MODE_POS and DOF_MODE_VEL are 1 and 2, DOF_MODE_EFFORT is 3."""
    text = BASE.replace('file = ""', f'file = "dog.urdf"\n        default_dof_drive_mode = {mode}')
    (config,) = read(tmp_path, text).values()
    assert config.groups[0].cls == cls
    assert control_of_group(config.framework, config.groups[0]) == ("ideal_pd" if mode == 3 else "implicit")


NETTED = """
class AnymalCfg(LeggedRobotCfg):
    class asset(LeggedRobotCfg.asset):
        file = "anymal.urdf"
    class control(LeggedRobotCfg.control):
        use_actuator_network = %s
        actuator_net_file = "legs.pt"%s

class AnymalFlatCfg(AnymalCfg):
    class control(AnymalCfg.control):
        decimation = 2
"""


@pytest.mark.parametrize(
    ("used", "own", "cls", "control"),
    [
        ("True", None, "actuator_net", "other"),
        ("False", None, "P", "ideal_pd"),
        ("True", "P", "P", "ideal_pd"),
        ("True", "V", "V", "velocity"),
        ("True", "T", "T", "motor"),
        ("True", "actuator_net", "actuator_net", "other"),
        ("True", "D", "actuator_net", "other"),
    ],
)
def test_a_network_in_place_of_the_gains(
    tmp_path: Path, used: str, own: str | None, cls: str, control: str
) -> None:
    """legged_gym's ANYmal C inherits its P and has a network; a class that states P beside the network runs the PD.

    So does what inherits both. Seen in Imitation_from_video, aliengo_amp_config.py.
    """
    stated = "" if own is None else f"\n        control_type = {own!r}"
    configs = read(tmp_path, BASE + NETTED % (used, stated))
    assert configs.keys() == {"AnymalCfg", "AnymalFlatCfg"}
    for config in configs.values():
        assert config.groups[0].cls == cls
        assert control_of_group(config.framework, config.groups[0]) == control


def test_what_a_fork_of_legged_gym_adds_to_control(tmp_path: Path) -> None:
    """Of the class and of its base; legged_gym's own names, and other classes' torque limits, are none."""
    fork = DOG.replace("action_scale = 0.25", "torque_limits = 30.0\n        hip_reduction = 0.5")
    fork = fork.replace("class asset", "class safety:\n        torque_limit = 0.85\n    class asset")
    (config,) = read(tmp_path, BASE + fork).values()
    assert config.groups[0].own == ("torque_limits", "hip_reduction")
    (plain,) = read(tmp_path, BASE + DOG).values()
    assert plain.groups[0].own == ()


def test_legged_gym_without_its_base(tmp_path: Path) -> None:
    """A robot alone has what it writes; what it inherits is a note, not a default."""
    (config,) = read(tmp_path, DOG).values()
    assert settings(config)["action_scale"] == 0.25
    assert "physics_dt" not in config.settings
    assert "armature" not in config.groups[0].settings
    assert config.groups[0].cls == ""
    (note,) = config.notes
    assert note.message == (
        "not known without running it: what it inherits: LeggedRobotCfg comes from legged_gym, which is not beside "
        "this file"
    )


BODIES = """
from isaaclab.actuators import ImplicitActuatorCfg
from isaaclab.assets import ArticulationCfg, AssetBaseCfg
from isaaclab.scene import InteractiveSceneCfg
from isaaclab.utils import configclass
from srb.core.asset import LeggedRobot

class Cassie(LeggedRobot):
    asset_cfg: ArticulationCfg = ArticulationCfg(
        init_state=ArticulationCfg.InitialStateCfg(joint_pos={"knee": -1.8}),
        actuators={"legs": ImplicitActuatorCfg(joint_names_expr=["knee"], stiffness=200.0)},
    )
    regex_feet_links: str = "(left|right)_toe"

class Stiff(Cassie):
    asset_cfg: ArticulationCfg = Cassie().asset_cfg.copy()
    asset_cfg.actuators["legs"].stiffness = 300.0

class Painted(Cassie):
    colour = "red"

@configclass
class SceneCfg(InteractiveSceneCfg):
    light = AssetBaseCfg(prim_path="/World/light")
    robot: ArticulationCfg = Cassie().asset_cfg.replace(prim_path="{ENV_REGEX_NS}/Robot")
    arm = ArticulationCfg(actuators={"arm": ImplicitActuatorCfg(joint_names_expr=["elbow"], stiffness=5.0)})
    door = ArticulationCfg(prim_path="/World/door", actuators={})

    def __post_init__(self):
        self.arm.actuators["arm"].stiffness *= 2
"""


def test_class_bodies(tmp_path: Path) -> None:
    """A class that is no cfg itself has the robots that its own body names, as they are when it is made.

    What it inherits, or takes as it is, is told once; an articulation without actuators is no robot.
    """
    configs = read(tmp_path, BODIES)
    found = {
        name: (one.span.line, [(group.joints, values(group)["stiffness"]) for group in one.groups])
        for name, one in configs.items()
    }
    assert found == {
        "Cassie.asset_cfg": (9, [(("knee",), 200.0)]),
        "Stiff.asset_cfg": (16, [(("knee",), 300.0)]),
        # 5 * 2
        "SceneCfg.arm": (26, [(("elbow",), 10.0)]),
    }
    assert settings(configs["Cassie.asset_cfg"]) == {"default_position": {"knee": -1.8}}


def test_a_class_of_mjlab(tmp_path: Path) -> None:
    """A class of an entity is one, with what it sets when it is made; the framework's own has no actuators."""
    text = """
from dataclasses import dataclass, field
from mjlab.actuator import BuiltinPositionActuatorCfg
from mjlab.entity.entity import EntityCfg

@dataclass
class EntityArticulationInfoCfg:
    actuators: tuple = field(default_factory=tuple)
    soft_joint_pos_limit_factor: float = 1.0

@dataclass
class T1Cfg(EntityCfg):
    articulation: EntityArticulationInfoCfg = field(default_factory=lambda: EntityArticulationInfoCfg(
        actuators=(BuiltinPositionActuatorCfg(target_names_expr=("Waist",), stiffness=75.0),)))

    def __post_init__(self):
        self.init_state = EntityCfg.InitialStateCfg(joint_pos={"Waist": 0.5})
"""
    ((name, config),) = read(tmp_path, text).items()
    assert name == "T1Cfg"
    assert [(group.joints, values(group)) for group in config.groups] == [(("Waist",), {"stiffness": 75.0})]
    assert settings(config) == {"default_position": {"Waist": 0.5}, "soft_joint_pos_limit_factor": 1.0}


@pytest.mark.parametrize(
    ("body", "place", "reason"),
    [
        ("def make(kp):\n    return DCMotorCfg(joint_names_expr=['a'], stiffness=kp)", (2, 12), "function make()"),
        ("class A:\n    def make(self, kp):\n        self.a = M(target_names_expr=['a'])", (3, 18), "function make()"),
        ("ALL = [DCMotorCfg(joint_names_expr=['a'])]", (1, 8), "no robot's configuration"),
    ],
)  # fmt: skip
def test_actuators_that_are_not_reached(
    tmp_path: Path, body: str, place: tuple[int, int], reason: str
) -> None:
    """Of actuators where none are read it is said where they stand, and not that there are none."""
    path = tmp_path / "a.py"
    path.write_text(body, encoding="utf-8")
    reading = read_python(str(path))
    (said,) = reading.diagnostics
    assert said.span is not None
    assert (said.code, (said.span.line, said.span.column)) == ("CFG002", place)
    assert reading.reason is not None and reason in reading.reason


def test_nothing_in_it(tmp_path: Path) -> None:
    """A file without actuators says that it has none, so that nobody takes it for audited."""
    path = tmp_path / "rewards.py"
    path.write_text("import torch\n\ndef reward(env):\n    return torch.zeros(3)\n", encoding="utf-8")
    reading = read_python(str(path))
    assert (reading.reason, reading.artifacts) == ("no actuators of Isaac Lab, mjlab or legged_gym in it", ())
    assert [str(d) for d in reading.diagnostics] == [
        f"{path}: CFG002: no actuators of Isaac Lab, mjlab or legged_gym in it\n"
        "  help: name the robot's configuration; it finds its base itself"
    ]


def test_ranges_that_are_not_known(tmp_path: Path) -> None:
    """A range that cannot be folded is a note; a number alone is no range."""
    (config,) = read(
        tmp_path,
        """
from mjlab.envs.mdp import dr
from mjlab.managers.event_manager import EventTermCfg
from my_lab import KP
EVENTS = {
    "gains": EventTermCfg(func=dr.pd_gains, params={"kp_range": KP, "kd_range": 1.5}),
    "bias": EventTermCfg(func=dr.encoder_bias, params={"bias_range": (-0.1, 0.2)}),
}
""",
    ).values()
    assert config.randomize == (
        RandomizedRange(
            "encoder_bias", "add", -0.1, 0.2, None, config.randomize[0].span, "uniform", event="bias"
        ),
    )
    assert [(note.where, note.message) for note in config.notes] == [
        ("kp", "not known without running it: KP comes from my_lab, which is not beside this file"),
        ("kd", "not known without running it: a range is two numbers"),
    ]


FORK = """from isaaclab.utils import configclass
from . import actuator_pd
from .actuator_base_cfg import ActuatorBaseCfg
from dataclasses import MISSING

@configclass
class IdealPDActuatorCfg(ActuatorBaseCfg):
    class_type: type = actuator_pd.IdealPDActuator

@configclass
class DCMotorCfg(IdealPDActuatorCfg):
    saturation_effort: float = MISSING

@configclass
class IdentifiedActuatorCfg(DCMotorCfg):
    friction_static: float = MISSING
    damping: float = 0.7
"""
FORKED = """from isaaclab.actuators import IdentifiedActuatorCfg, IdealPDActuatorCfg
from isaaclab.assets import ArticulationCfg
LEG_CFG = ArticulationCfg(actuators={
    "legs": IdentifiedActuatorCfg(
        joint_names_expr=["hip"], effort_limit=20.0, saturation_effort=30.0, velocity_limit=9.0, stiffness=40.0),
    "arms": IdealPDActuatorCfg(joint_names_expr=["arm"], effort_limit=5.0, stiffness=4.0, damping=0.1),
})
"""


@pytest.mark.parametrize("layout", ["isaaclab", "omni.isaac.lab"])
def test_an_actuator_that_a_fork_of_isaac_lab_has_added(tmp_path: Path, layout: str) -> None:
    """It is read by its base and its defaults, in 2.x's folders and 1.x's; Isaac Lab's own are known by their names."""
    parts = layout.split(".")
    actuators = tmp_path.joinpath("source", layout, *parts, "actuators")
    actuators.mkdir(parents=True)
    (actuators / "actuator_cfg.py").write_text(FORK, encoding="utf-8")
    (actuators / "actuator_base_cfg.py").write_text("class ActuatorBaseCfg:\n    armature: float = 0.02\n")
    (actuators / "__init__.py").write_text("from .actuator_cfg import *\n", encoding="utf-8")
    robots = tmp_path.joinpath("source", f"{layout}_assets", *parts[:-1], f"{parts[-1]}_assets")
    robots.mkdir(parents=True)
    (robots / "__init__.py").write_text("", encoding="utf-8")
    (robots / "leg.py").write_text(
        FORKED.replace("isaaclab.actuators", f"{layout}.actuators"), encoding="utf-8"
    )
    reading = read_python(str(robots / "leg.py"))
    (artifact,) = reading.artifacts
    assert artifact.config is not None
    legs, arms = artifact.config.groups
    assert legs.bases == ("DCMotorCfg", "IdealPDActuatorCfg", "ActuatorBaseCfg")
    assert (legs.settings["damping"].value, legs.settings["armature"].value) == (0.7, 0.02)
    assert (arms.cls, arms.bases, arms.settings.keys() & {"armature"}) == ("IdealPDActuatorCfg", (), set())
    assert [Path(file.path).name for file in reading.files] == [
        "leg.py", "__init__.py", "actuator_cfg.py", "actuator_base_cfg.py"
    ]  # fmt: skip


def test_a_fork_behind_a_link_is_not_read(tmp_path: Path) -> None:
    """A link to another place is none that the named file's repository has."""
    elsewhere = tmp_path / "elsewhere" / "isaaclab" / "actuators"
    elsewhere.mkdir(parents=True)
    (elsewhere / "__init__.py").write_text(FORK, encoding="utf-8")
    robots = tmp_path / "source" / "isaaclab_assets" / "isaaclab_assets"
    robots.mkdir(parents=True)
    (tmp_path / "source" / "isaaclab").symlink_to(tmp_path / "elsewhere")
    (robots / "__init__.py").write_text("", encoding="utf-8")
    (robots / "leg.py").write_text(FORKED, encoding="utf-8")
    reading = read_python(str(robots / "leg.py"))
    (artifact,) = reading.artifacts
    assert artifact.config is not None
    assert artifact.config.groups[0].bases == ()
    assert [Path(file.path).name for file in reading.files] == ["leg.py"]


SPREAD = """from proj.assets.leg import LEG_CFG
from isaaclab.envs import ManagerBasedRLEnvCfg
from isaaclab.scene import InteractiveSceneCfg
class Scene(InteractiveSceneCfg):
    robot = LEG_CFG.replace(prim_path="{ENV_REGEX_NS}/Robot")
class LegEnvCfg(ManagerBasedRLEnvCfg):
    scene = Scene(num_envs=1)
    decimation = 4
"""


@pytest.mark.parametrize("packages", [("tasks",), ("tasks", "assets")])
@pytest.mark.parametrize("start", [".", "proj/tasks"])
def test_a_package_without_init_above_the_file(
    tmp_path: Path, packages: tuple[str, ...], start: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`from proj.assets.leg import LEG_CFG` in proj/tasks (PEP 420), and what that imports of `proj` itself."""
    for name in ("tasks", "assets"):
        (tmp_path / "proj" / name).mkdir(parents=True)
        if name in packages:
            (tmp_path / "proj" / name / "__init__.py").write_text("", encoding="utf-8")
    leg = FORKED.replace(
        "from isaaclab.actuators import IdentifiedActuatorCfg", "from proj.assets.motor import MotorCfg"
    )
    leg = leg.replace(", IdealPDActuatorCfg", "\nfrom isaaclab.actuators import IdealPDActuatorCfg", 1)
    (tmp_path / "proj/assets/leg.py").write_text(
        leg.replace("Identified", "Motor").replace("MotorActuator", "Motor")
    )
    motor = "from isaaclab.actuators import DCMotorCfg\nclass MotorCfg(DCMotorCfg):\n    damping = 0.7\n"
    (tmp_path / "proj/assets/motor.py").write_text(motor, encoding="utf-8")
    (tmp_path / "proj/tasks/env_cfg.py").write_text(SPREAD, encoding="utf-8")
    monkeypatch.chdir(tmp_path / start)
    reading = read_python(os.path.relpath(tmp_path / "proj/tasks/env_cfg.py"))
    env = next(one.config for one in reading.artifacts if one.name == "LegEnvCfg")
    assert env is not None
    assert [(group.cls, group.bases, group.settings["damping"].value) for group in env.groups] == [
        ("MotorCfg", ("DCMotorCfg",), 0.7),
        ("IdealPDActuatorCfg", (), 0.1),
    ]
