"""Configurations as ActuatorSets: what each framework's classes make of what is written."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from actspec.ir import Command, JointActuator, JointKind, Level, Origin
from actspec.lift import Lifted, lift_config
from actspec.readings.artifact import Artifact, Setting
from actspec.readings.config import rows_of_config
from actspec.readings.python.read import read_python
from actspec.readings.read import read_file
from actspec.readings.versions import Versions
from actspec.robot.view import JointView
from tests.compiling import view_of

LAB = Versions(isaaclab="2.3", isaac_sim="5.1")

MODEL = """<mujoco><compiler angle="radian"/><worldbody><body>
<joint name="hip" range="-1 2"/><geom size="0.1"/><body>
<joint name="knee"/><geom size="0.1"/><body>
<joint name="lift" type="slide"/><geom size="0.1"/></body></body></body></worldbody></mujoco>"""


def joints() -> tuple[JointView, ...]:
    """hip and knee, hinges, and lift, a slide."""
    return view_of(MODEL, folder="").joints


def artifact_of(folder: Path, text: str, name: str = "cfg.py") -> Artifact:
    """The one robot in a file with this text."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    reading = read_file(str(path))
    assert reading.reason is None, reading.reason
    (artifact,) = reading.artifacts
    return artifact


def isaaclab(
    folder: Path, *groups: str, versions: Versions = LAB, dt: float | None = None, extra: str = ""
) -> Lifted:
    """Isaac Lab groups, `Class(joints, fields)` each."""
    classes = sorted({group.partition("(")[0] for group in groups})
    body = "".join(
        f'"g{i}": {group.replace("(", "(joint_names_expr=", 1)},' for i, group in enumerate(groups)
    )
    text = f"""from isaaclab.actuators import {", ".join(classes)}
from isaaclab.assets import ArticulationCfg
BOT_CFG = ArticulationCfg({extra} actuators={{{body}}})
"""
    return lift_config(artifact_of(folder, text), joints(), versions=versions, physics_dt=dt)


def by_name(found: Lifted) -> dict[str, JointActuator]:
    """Joint to actuator."""
    return {actuator.joint: actuator for actuator in found.actuators.joints}


def test_groups_meet_the_robots_joints(tmp_path: Path) -> None:
    """Joints come in the robot's order with their kind, range and pattern; one that no group selects is left alone."""
    found = isaaclab(
        tmp_path, 'IdealPDActuatorCfg(["li.*", "hip"], stiffness=25.0, damping=0.5, effort_limit=3)'
    )
    hip, lift = found.actuators.joints
    assert (hip.joint, hip.kind, hip.position_range, hip.pattern) == ("hip", JointKind.HINGE, (-1, 2), "hip")
    assert (lift.joint, lift.kind, lift.pattern, lift.group) == ("lift", JointKind.SLIDE, "li.*", "g0")
    assert hip.kp is not None and lift.kp is not None
    assert (hip.kp.unit, lift.kp.unit) == ("N*m/rad", "N/m")
    assert hip.kp.span is not None and hip.kp.span.line == 3
    assert [(item.joint, item.why) for item in found.left_alone] == [
        ("knee", "no group of the configuration selects it")
    ]


def test_dict_that_misses_a_joint(tmp_path: Path) -> None:
    """Isaac Lab gives such a joint 0, which nobody wrote: a default with the reason."""
    found = by_name(
        isaaclab(
            tmp_path, 'DCMotorCfg(["hip", "knee"], stiffness={"hip": 25.0}, damping={"hip": 0.5, "knee": 1})'
        )
    )
    knee = found["knee"]
    assert knee.command is Command.VELOCITY
    assert found["hip"].kp is not None and found["hip"].kp.value == 25.0


def test_friction_by_version(tmp_path: Path) -> None:
    """A torque in 2.3 on Sim 5, a factor on Sim 4.5, dead in 2.2 on Sim 5, one torque on Newton; unnamed: unknown."""
    fields = "friction=0.3, dynamic_friction=0.2, viscous_friction=0.1, stiffness=1.0, damping=1.0"
    group = f'IdealPDActuatorCfg(["hip"], {fields})'

    def of(versions: Versions) -> tuple[float | None, float | None, float | None]:
        hip = by_name(isaaclab(tmp_path, group, versions=versions))["hip"]
        static = None if hip.friction_static is None else hip.friction_static.value
        return hip.friction_coulomb.value, static, hip.friction_viscous.value

    assert of(LAB) == (0.2, 0.3, 0.1)
    assert of(Versions(isaaclab="2.3", isaac_sim="4.5")) == (None, None, None)
    assert of(Versions(isaaclab="2.2", isaac_sim="5.0")) == (None, None, None)
    assert of(Versions(isaaclab="3.0", backend="newton")) == (0.3, None, 0.1)
    assert of(Versions(isaaclab="3.0", backend="ovphysx")) == (None, None, 0.1)
    unnamed = isaaclab(tmp_path, group, versions=Versions())
    assert by_name(unnamed)["hip"].friction_coulomb.origin is Origin.UNKNOWN
    assert unnamed.notes[""] == (
        "friction is left unknown: what it means depends on the versions of Isaac Lab and Isaac Sim (of 3.0 on the "
        "backend); state the version of Isaac Lab and the version of Isaac Sim, such as -t isaaclab==2.3 "
        "-t isaac_sim==5.1",
    )
    # What is stated is not asked for again.
    for versions, lacking in (
        (Versions(isaaclab="2.3"), "state the version of Isaac Sim, such as -t isaac_sim==5.1"),
        (Versions(isaac_sim="5.1"), "state the version of Isaac Lab, such as -t isaaclab==2.3"),
        (Versions(isaaclab="3.0"), "state the backend, such as -t backend==newton"),
    ):
        (note,) = isaaclab(tmp_path, group, versions=versions).notes[""]
        assert note.endswith(f"; {lacking}")


def test_no_friction_is_none_in_every_unit(tmp_path: Path) -> None:
    """A 0 is a 0, whatever the unit, but where it never reaches the solver."""
    group = 'IdealPDActuatorCfg(["hip"], friction=0.0, stiffness=1.0, damping=1.0)'
    hip = by_name(isaaclab(tmp_path, group, versions=Versions()))["hip"]
    assert (hip.friction_coulomb.value, hip.friction_coulomb.origin) == (0.0, Origin.MODEL)
    dead = by_name(isaaclab(tmp_path, group, versions=Versions(isaaclab="2.2", isaac_sim="5.0")))["hip"]
    assert dead.friction_coulomb.value is None


def test_dc_motor_and_limits(tmp_path: Path) -> None:
    """saturation_effort and velocity_limit are the line, velocity_limit_sim the joint's limit; 1e9 is no limit."""
    found = isaaclab(
        tmp_path,
        'DCMotorCfg(["hip"], saturation_effort=45, velocity_limit=30, effort_limit=24, velocity_limit_sim=25,'
        " effort_limit_sim=20, stiffness=1.0, damping=1.0)",
        'IdealPDActuatorCfg(["knee"], effort_limit=1e9, velocity_limit=7.0, stiffness=1.0, damping=1.0)',
        'ImplicitActuatorCfg(["lift"], effort_limit_sim=5, velocity_limit=7.0, stiffness=1.0, damping=1.0)',
    )
    hip, knee, lift = found.actuators.joints
    assert hip.level is Level.DC_MOTOR
    assert hip.stall_torque is not None and hip.no_load_speed is not None
    assert (hip.stall_torque.value, hip.no_load_speed.value, hip.effort_limit.value) == (45.0, 30.0, 24.0)
    assert hip.velocity_limit.value == 25.0
    assert found.notes["hip"] == ("the solver clips at 20 N*m too (effort_limit_sim), below effort_limit",)
    assert (knee.effort_limit.value, knee.effort_limit.note) == (None, "1e9 N*m is no limit")
    assert (lift.effort_limit.value, lift.velocity_limit.value) == (5.0, None)


_SOLVERS = "outside Isaac Lab 2.0.2 to 2.3.0 the model clips at the USD's limit"


@pytest.mark.parametrize(
    ("release", "usd", "limit", "remark"),
    [
        # 45 is where the solver clips in every release; 30 or 60 may be the USD's.
        ("2.2", "", 45.0, ""),
        ("2.3.0", 'actuatorfrcrange="-30 30"', 45.0, ""),
        (
            None,
            "",
            45.0,
            f"effort_limit is effort_limit_sim, 45 N*m, where the solver clips; {_SOLVERS} too, ",
        ),
        (
            "2.3.2",
            "",
            45.0,
            f"effort_limit is effort_limit_sim, 45 N*m, where the solver clips; {_SOLVERS} too, ",
        ),
        ("2.3.2", 'actuatorfrcrange="-60 60"', 45.0, "effort_limit is effort_limit_sim, 45 N*m"),
        (
            "2.3.2",
            'actuatorfrcrange="-30 30"',
            None,
            f"the solver clips at 45 N*m too (effort_limit_sim); {_SOLVERS}",
        ),
        (
            "2.0.1",
            'actuatorfrcrange="-30 30"',
            None,
            f"the solver clips at 45 N*m too (effort_limit_sim); {_SOLVERS}",
        ),
        ("2.3", "", 45.0, "effort_limit is effort_limit_sim, 45 N*m"),
    ],
)
@pytest.mark.parametrize("cls", ["IdealPDActuatorCfg", "DelayedPDActuatorCfg"])
def test_solvers_limit_alone(
    tmp_path: Path, cls: str, release: str | None, usd: str, limit: float | None, remark: str
) -> None:
    """`effort_limit_sim` alone limits an explicit drive; a robot file's lower limit, where that counts, stays."""
    group = f'{cls}(joint_names_expr=["hip"], effort_limit_sim=45.0, stiffness=1.0, damping=1.0)'
    text = f"""from isaaclab.actuators import {cls}
from isaaclab.assets import ArticulationCfg
BOT_CFG = ArticulationCfg(actuators={{"legs": {group}}})
"""
    view = view_of(MODEL.replace('name="hip"', f'name="hip" {usd}'), folder="").joints
    versions = Versions(isaaclab=release)
    found = lift_config(artifact_of(tmp_path, text), view, versions=versions)
    hip = by_name(found)["hip"]
    assert hip.effort_limit.value == limit
    (told,) = found.notes.get("hip", ("",))
    assert told.startswith(remark) and bool(told) == bool(remark)
    if limit is not None:
        assert hip.effort_limit.span is not None and hip.effort_limit.span.line == 3


def test_solvers_limit_of_a_placeholder_is_none(tmp_path: Path) -> None:
    """1e9 at the solver limits nothing."""
    found = isaaclab(
        tmp_path, 'IdealPDActuatorCfg(["hip"], effort_limit_sim=1e9, stiffness=1.0, damping=1.0)'
    )
    hip = by_name(found)["hip"]
    why = "Isaac Lab 2.0.2 to 2.3.0 do not clip then, others at the USD's"
    assert (hip.effort_limit.value, hip.effort_limit.note) == (None, why)


def test_speed_limit_of_a_placeholder_is_none(tmp_path: Path) -> None:
    """1e9 rad/s limits nothing, as 1e9 N*m does."""
    (found,) = isaaclab(
        tmp_path,
        'ImplicitActuatorCfg(["hip"], effort_limit_sim=9.0, velocity_limit_sim=1e9, stiffness=1.0, damping=1.0)',
    ).actuators.joints
    assert (found.velocity_limit.value, found.velocity_limit.note) == (None, "1e9 rad/s is no limit")


@pytest.mark.parametrize("own, told", [("20.0", True), ("40.0", False), ("None", False)])
def test_two_limits_of_an_implicit_drive(tmp_path: Path, own: str, told: bool) -> None:
    """The solver's is taken, and that Isaac Lab 2.x refuses two that differ is told.

    Source: Isaac Lab 2.3.2, actuators/actuator_pd.py, ImplicitActuator.__init__ raises ValueError.
    """
    found = isaaclab(
        tmp_path,
        f'ImplicitActuatorCfg(["hip"], effort_limit={own}, effort_limit_sim=40.0, stiffness=1.0, damping=1.0)',
    )
    (hip,) = found.actuators.joints
    assert hip.effort_limit.value == 40.0
    said = (
        "effort_limit and effort_limit_sim differ: Isaac Lab 2.x raises ValueError when it builds the group; "
        "effort_limit_sim is taken"
    )
    assert (said in found.notes.get("hip", ())) is told


def test_dc_motor_with_the_solvers_speed_alone(tmp_path: Path) -> None:
    """`velocity_limit_sim` is no end of a torque-speed line: 25 rad/s is the solver's, the 45 N*m of it are lost."""
    group = 'DCMotorCfg(["hip"], saturation_effort=45, velocity_limit_sim=25, effort_limit=9, stiffness=1, damping=1)'
    found = isaaclab(tmp_path, group)
    hip = by_name(found)["hip"]
    assert (hip.level, hip.velocity_limit.value, hip.stall_torque) == (Level.IDEAL_PD, 25.0, None)
    assert found.notes["hip"] == (
        "its torque-speed line is left out: no velocity_limit (velocity_limit_sim is the solver's), without which "
        "DCMotorCfg cannot be built",
    )


@pytest.mark.parametrize(
    "cls, written, limit, note",
    [
        # Only the solver clamps a speed, at velocity_limit_sim: 25, not 7 nor what the USD has.
        ("IdealPDActuatorCfg", "velocity_limit=7.0", None, "velocity_limit 7"),
        ("DelayedPDActuatorCfg", "velocity_limit={'.*': 7.0}", None, "velocity_limit"),
        ("DelayedPDActuatorCfg", "velocity_limit=7.0, velocity_limit_sim=25.0", 25.0, "velocity_limit 7"),
        ("IdealPDActuatorCfg", "velocity_limit_sim=25.0", 25.0, ""),
        ("IdealPDActuatorCfg", "velocity_limit=1e9", None, ""),
    ],
    ids=["explicit", "dict", "both", "solver's", "none"],
)
def test_speed_limit_that_acts_nowhere(
    tmp_path: Path, cls: str, written: str, limit: float | None, note: str
) -> None:
    """`velocity_limit` of an explicit class without a line is left out with a remark, the solver's stays."""
    group = f'{cls}(["hip"], effort_limit=24.0, {written}, stiffness=1.0, damping=1.0)'
    found = isaaclab(tmp_path, group)
    hip = by_name(found)["hip"]
    assert (hip.velocity_limit.value, hip.no_load_speed) == (limit, None)
    why = "is left out: an explicit drive without a torque-speed line uses it nowhere; the solver's limit is "
    told = f"{note} {why}velocity_limit_sim, else the USD's own"
    assert found.notes.get("hip", ()) == ((told,) if note else ())


def test_speed_limit_that_acts_nowhere_in_3_0(tmp_path: Path) -> None:
    """The names of 3.0: `actuator_velocity_limit` is the line's, `joint_velocity_limit` the solver's."""
    group = 'IdealPDActuatorCfg(["hip"], actuator_velocity_limit=7.0, stiffness=1.0, damping=1.0)'
    found = isaaclab(tmp_path, group, versions=Versions(isaaclab="3.0", backend="physx"))
    assert by_name(found)["hip"].velocity_limit.value is None
    (told,) = found.notes["hip"]
    assert told.startswith("actuator_velocity_limit 7 is left out: an explicit drive")
    assert told.endswith("the solver's limit is joint_velocity_limit, else the USD's own")


@pytest.mark.parametrize(
    "stall, speed, why",
    [
        ("elsewhere()", "30.0", "elsewhere is not defined here"),
        ("45.0", "-30.0", "-30 rad/s"),
        ("0.0", "30.0", "0 N*m"),
        ('float("nan")', "30.0", "nan N*m"),
    ],
    ids=["unknown", "negative", "zero", "nan"],
)
def test_line_that_is_none(tmp_path: Path, stall: str, speed: str, why: str) -> None:
    """A torque-speed line with a point that is unknown or not above 0 is left out with the reason; the PD stays."""
    group = (
        f'DCMotorCfg(["hip"], saturation_effort={stall}, velocity_limit={speed}, effort_limit=24.0, stiffness=1.0, '
        "damping=1.0)"
    )
    found = isaaclab(tmp_path, group)
    hip = by_name(found)["hip"]
    assert (hip.level, hip.stall_torque, hip.no_load_speed) == (Level.IDEAL_PD, None, None)
    assert hip.effort_limit.value == 24.0
    assert found.notes["hip"] == (f"its torque-speed line is left out: a point of it is {why}",)


def test_delay_in_steps(tmp_path: Path) -> None:
    """2 to 6 steps of 5 ms are 10 to 30 ms; in 3.0 the largest; without a step they are unknown, and noted."""
    group = 'DelayedPDActuatorCfg(["hip"], min_delay=2, max_delay=6, stiffness=1.0, damping=1.0)'
    hip = by_name(isaaclab(tmp_path, group, dt=0.005))["hip"]
    assert hip.delay is not None
    assert (hip.delay.nominal.value, hip.delay.low, hip.delay.high) == (None, 0.01, 0.03)
    assert hip.delay.sampling == "episode"
    new = by_name(isaaclab(tmp_path, group, dt=0.005, versions=Versions(isaaclab="3.0", backend="physx")))
    assert new["hip"].delay is not None
    assert (new["hip"].delay.nominal.value, new["hip"].delay.low) == (0.03, 0.03)
    silent = isaaclab(tmp_path, group)
    assert by_name(silent)["hip"].delay is not None
    assert silent.notes["hip"] == ("delay: 2 to 6 physics steps, whose length no file states",)


_TABLE = "joint_parameter_lookup=[[-2.0, -24.0, 37.5], [-1.0, -75.0, 112.5], [0.0, -40.0, 60.0]]"


@pytest.mark.parametrize(
    ("more", "limit", "remarks"),
    [
        # The largest of 37.5, 112.5 and 60; the class takes no effort_limit, and the solver clips what is above 90.
        ("", 112.5, []),
        (", effort_limit=45.0", 112.5, []),
        (
            ", effort_limit_sim=90.0",
            112.5,
            ["the solver clips at 90 N*m too (effort_limit_sim), below effort_limit"],
        ),
    ],
)
def test_limit_by_angle(tmp_path: Path, more: str, limit: float, remarks: list[str]) -> None:
    """A table of torques is its peak as one number, with a remark on the least and the largest and its line."""
    group = f'RemotizedPDActuatorCfg(["hip"], {_TABLE}{more}, stiffness=1.0, damping=1.0)'
    found = isaaclab(tmp_path, group)
    hip = by_name(found)["hip"]
    assert hip.effort_limit.value == limit
    first, *others = found.notes["hip"]
    assert first.startswith(
        "its torque limit depends on the angle, 37.5 N*m to 112.5 N*m by a table at line 3 (joint_parameter_lookup): "
        "effort_limit is its peak"
    )
    assert others == remarks


@pytest.mark.parametrize("table", ["elsewhere()", "[[0.0, 1.0]]", "[]", "[[0.0, 1.0, elsewhere()]]"])
def test_limit_by_an_angle_that_is_not_known(tmp_path: Path, table: str) -> None:
    """A table that cannot be read limits by nothing that is known."""
    group = f'RemotizedPDActuatorCfg(["hip"], joint_parameter_lookup={table}, stiffness=1.0, damping=1.0)'
    hip = by_name(isaaclab(tmp_path, group))["hip"]
    why = "it depends on the angle, by a table that is not known (joint_parameter_lookup)"
    assert (hip.effort_limit.value, hip.effort_limit.note) == (None, why)


def test_overlapping_groups(tmp_path: Path) -> None:
    """Of two groups with one joint Isaac Lab 2.x takes the last, and a note says so."""
    found = isaaclab(
        tmp_path,
        'IdealPDActuatorCfg([".*"], stiffness=1.0, damping=1.0)',
        'IdealPDActuatorCfg(["hip"], stiffness=9.0, damping=1.0)',
    )
    hip = by_name(found)["hip"]
    assert hip.kp is not None and hip.kp.value == 9.0
    assert found.notes["hip"] == (
        "several groups have the joint (g0, g1): as in Isaac Lab 2.x the last counts, over what others state",
    )


def test_what_a_drive_without_stiffness_follows(tmp_path: Path) -> None:
    """Stiffness 0 leaves the speed's gain, both 0 the torque; None is the USD's own and says nothing."""
    found = isaaclab(
        tmp_path,
        'IdealPDActuatorCfg(["hip"], stiffness=0.0, damping=2.0)',
        'IdealPDActuatorCfg(["knee"], stiffness=0.0, damping=0.0)',
        'IdealPDActuatorCfg(["lift"], stiffness=None, damping=0.0)',
    )
    hip, knee, lift = found.actuators.joints
    assert (hip.command, hip.kp, hip.kd and hip.kd.value) == (Command.VELOCITY, None, 2.0)
    assert (knee.command, knee.kp, knee.kd) == (Command.EFFORT, None, None)
    assert lift.command is Command.POSITION
    assert lift.kp is not None and (lift.kp.value, lift.kp.note) == (None, "the USD's own")
    assert found.notes == {
        "hip": ("stiffness 0: the command is a speed",),
        "knee": ("stiffness 0: the command is a torque",),
    }


def test_network(tmp_path: Path) -> None:
    """A network has no gains here; a line at 1e9 is none."""
    found = isaaclab(
        tmp_path,
        'ActuatorNetMLPCfg(["hip"], network_file="nets/a.pt", saturation_effort=1e9, velocity_limit=1e9,'
        ' effort_limit=23.7, pos_scale=1.0, vel_scale=1.0, torque_scale=1.0, input_order="pos_vel", input_idx=[0, 1])',
        'ActuatorNetLSTMCfg(["knee"], network_file="b.pt", saturation_effort=120, velocity_limit=7.5, effort_limit=80)',
    )
    hip, knee = found.actuators.joints
    assert (hip.level, hip.kp, hip.kd, hip.stall_torque) == (Level.ACTUATOR_NET, None, None, None)
    assert hip.network is not None and (hip.network.file, hip.network.manifest) == ("nets/a.pt", None)
    assert knee.stall_torque is not None and knee.stall_torque.value == 120.0


def test_pose_scale_and_ranges(tmp_path: Path) -> None:
    """An environment's pose, action scale, step and ranges reach the joints that they select."""
    text = """from isaaclab.actuators import DelayedPDActuatorCfg
from isaaclab.assets import ArticulationCfg
from isaaclab.envs import ManagerBasedRLEnvCfg, mdp
from isaaclab.managers import EventTermCfg, SceneEntityCfg
from isaaclab.utils import configclass

BOT_CFG = ArticulationCfg(
    init_state=ArticulationCfg.InitialStateCfg(joint_pos={"hip": 0.4}),
    actuators={"all": DelayedPDActuatorCfg(joint_names_expr=[".*"], stiffness=1.0, damping=1.0, max_delay=4)},
)

@configclass
class EventCfg:
    gains = EventTermCfg(
        func=mdp.randomize_actuator_gains, mode="interval", interval_range_s=(1.0, 2.0),
        params={"asset_cfg": SceneEntityCfg("robot", joint_names=["k.*"]),
                "stiffness_distribution_params": (0.8, 1.2), "operation": "scale", "distribution": "log_uniform"},
    )

@configclass
class SceneCfg:
    robot = BOT_CFG

@configclass
class ActionsCfg:
    pos = mdp.JointPositionActionCfg(scale=0.25)

@configclass
class BotEnvCfg(ManagerBasedRLEnvCfg):
    scene = SceneCfg()
    actions = ActionsCfg()
    events = EventCfg()
    def __post_init__(self):
        self.decimation = 4
        self.sim.dt = 0.005
"""
    path = tmp_path / "env_cfg.py"
    path.write_text(text, encoding="utf-8")
    artifact = next(a for a in read_python(str(path)).artifacts if a.name == "BotEnvCfg")
    found = lift_config(artifact, joints(), versions=LAB)
    hip, knee, _ = found.actuators.joints
    assert (hip.default_position.value, hip.default_position.origin) == (0.4, Origin.MODEL)
    assert (knee.default_position.value, knee.default_position.origin) == (0.0, Origin.DEFAULT)
    assert hip.action_scale is not None and hip.action_scale.value == 0.25
    assert (found.actuators.physics_dt.value, found.actuators.decimation) == (0.005, 4)
    assert hip.delay is not None and hip.delay.high == 0.02  # 4 x 5 ms
    assert hip.randomize == ()
    (one,) = knee.randomize
    assert (one.field, one.operation, one.low, one.high) == ("kp", "scale", 0.8, 1.2)
    assert (one.distribution, one.when, one.every) == ("log_uniform", "interval", (1.0, 2.0))


def test_class_of_somebody_else(tmp_path: Path) -> None:
    """A class of one's own is read as its stock base, and a note says that it may do more."""
    text = """from isaaclab.actuators import IdealPDActuator, IdealPDActuatorCfg
from isaaclab.utils import configclass

class MyActuator(IdealPDActuator):
    pass

@configclass
class MyActuatorCfg(IdealPDActuatorCfg):
    class_type: type = MyActuator
    drive_torque: float = 3.0
    fade: float = 1.0

BOT = {"legs": MyActuatorCfg(joint_names_expr=["hip"], stiffness=1.0, damping=1.0, effort_limit=9.0)}
"""
    found = lift_config(artifact_of(tmp_path, text), joints(), versions=LAB)
    hip = by_name(found)["hip"]
    # `drive_torque` would be a curve in actspec's own class, which has no `fade`.
    assert (hip.level, hip.curve) == (Level.IDEAL_PD, None)
    assert found.notes["hip"] == (
        "MyActuatorCfg is read as IdealPDActuatorCfg: what else it does with drive_torque, fade is not known here",
    )


MJLAB = """from mjlab.actuator import {classes}
from mjlab.entity import EntityArticulationInfoCfg
BOT = EntityArticulationInfoCfg(actuators=({cfgs},))
"""


@pytest.mark.parametrize(
    ("cls", "fields", "command", "level"),
    [
        ("BuiltinPositionActuatorCfg", "stiffness=3.0, damping=1.0", Command.POSITION, Level.IDEAL_PD),
        ("BuiltinPdActuatorCfg", "stiffness=3.0, damping=1.0", Command.POSITION, Level.IDEAL_PD),
        ("BuiltinVelocityActuatorCfg", "damping=1.0", Command.VELOCITY, Level.IDEAL_PD),
        ("BuiltinMotorActuatorCfg", "effort_limit=2.0", Command.EFFORT, Level.IDEAL_PD),
        (
            "DcMotorActuatorCfg",
            "stiffness=3.0, damping=1.0, saturation_effort=9.0, velocity_limit=8.0, effort_limit=5.0",
            Command.POSITION,
            Level.DC_MOTOR,
        ),
    ],
    ids=["position", "pd", "velocity", "motor", "dc motor"],
)
def test_mjlab_classes(tmp_path: Path, cls: str, fields: str, command: Command, level: Level) -> None:
    """What each class takes for a command."""
    cfg = f'{cls}(target_names_expr=("hip",), {fields})'
    found = lift_config(artifact_of(tmp_path, MJLAB.format(classes=cls, cfgs=cfg)), joints())
    hip = by_name(found)["hip"]
    assert (hip.command, hip.level) == (command, level)
    assert (hip.kp is not None, hip.kd is not None) == (
        command is Command.POSITION,
        command is not Command.EFFORT,
    )


def test_mjlabs_network_has_the_line(tmp_path: Path) -> None:
    """`velocity_limit` of mjlab's learned class is the no-load speed of its line, as of its DC motor."""
    cls = "LearnedMlpActuatorCfg"
    fields = 'network_file="a.pt", saturation_effort=9.0, velocity_limit=8.0, effort_limit=5.0'
    text = MJLAB.format(classes=cls, cfgs=f'{cls}(target_names_expr=("hip",), {fields})')
    hip = by_name(lift_config(artifact_of(tmp_path, text), joints()))["hip"]
    assert hip.stall_torque is not None and hip.no_load_speed is not None
    assert (hip.stall_torque.value, hip.no_load_speed.value, hip.velocity_limit.value) == (9.0, 8.0, None)


@pytest.mark.parametrize(
    ("cls", "fields", "why"),
    [
        ("XmlActuatorCfg", "", "XmlActuatorCfg leaves it to the model's own actuator"),
        ("XmlPositionActuatorCfg", "", "XmlPositionActuatorCfg leaves it to the model's own actuator"),
        ("BuiltinMuscleActuatorCfg", "", "an actuator of another kind (BuiltinMuscleActuatorCfg)"),
        (
            "BuiltinDcMotorActuatorCfg",
            "stiffness=40.0, damping=0.2, voltage_limit=24.0",
            "the gains of BuiltinDcMotorActuatorCfg are in volts",
        ),
    ],
    ids=["xml", "xml position", "muscle", "volts"],
)
def test_mjlab_left_alone(tmp_path: Path, cls: str, fields: str, why: str) -> None:
    """Classes that no law describes are left alone with the reason."""
    cfg = f'{cls}(target_names_expr=("hip",), {fields})'
    found = lift_config(artifact_of(tmp_path, MJLAB.format(classes=cls, cfgs=cfg)), joints())
    assert found.actuators.joints == ()
    assert found.left_alone[0].why == why


def test_mjlab_two_cfgs_for_one_joint(tmp_path: Path) -> None:
    """mjlab refuses that, so nothing is guessed."""
    cfg = 'BuiltinMotorActuatorCfg(target_names_expr=("hip",), effort_limit={})'
    text = MJLAB.format(classes="BuiltinMotorActuatorCfg", cfgs=f"{cfg.format(1)}, {cfg.format(2)}")
    found = lift_config(artifact_of(tmp_path, text), joints())
    assert found.left_alone[0].why == "2 groups select it: actuators[0], actuators[1]"


@pytest.mark.parametrize(
    ("fields", "sampling", "notes"),
    [
        ("", "step", ()),
        (", delay_update_period=10**9, delay_per_env_phase=False", "episode", ()),
        (
            ", delay_update_period=8, delay_hold_prob=0.5",
            "step",
            (
                "delay: a lag is kept with probability 0.5 (delay_hold_prob), which a spec cannot express",
                "delay: a lag is drawn every 8 steps, a spec has every step or every episode",
            ),
        ),
    ],
    ids=["each step", "episode", "between"],
)
def test_mjlab_delay(tmp_path: Path, fields: str, sampling: str, notes: tuple[str, ...]) -> None:
    """1 to 3 steps of 2 ms; without a period mjlab draws in every step (1.6, measured)."""
    cfg = (
        'BuiltinMotorActuatorCfg(target_names_expr=("hip",), effort_limit=1, delay_min_lag=1, delay_max_lag=3'
        f"{fields})"
    )
    text = MJLAB.format(classes="BuiltinMotorActuatorCfg", cfgs=cfg)
    found = lift_config(artifact_of(tmp_path, text), joints(), physics_dt=0.002)
    delay = by_name(found)["hip"].delay
    assert delay is not None
    assert (delay.low, delay.high, delay.sampling) == (0.002, 0.006, sampling)
    assert found.notes.get("hip", ()) == notes


LEGGED = """class BotCfg(LeggedRobotCfg):
    class init_state:
        default_joint_angles = {"hip": 0.1, "knee": -0.8}
    class control:
        CONTROL
        stiffness = {"hip": 20.0, "knee": 30.0}
        damping = {"hip": 0.5, "knee": 0.6}
        action_scale = 0.25
        decimation = 4
    class asset:
        file = "{ROOT}/bot.urdf"
    class sim:
        dt = 0.005
"""


@pytest.mark.parametrize("control", ["", 'control_type = "P"'], ids=["default", "stated"])
def test_legged_gym(tmp_path: Path, control: str) -> None:
    """Gains by a part of the name, pose, scale and timing; a joint that no key names is left alone."""
    found = lift_config(artifact_of(tmp_path, LEGGED.replace("CONTROL", control)), joints())
    hip, knee = found.actuators.joints
    assert hip.kp is not None and knee.kd is not None and hip.action_scale is not None
    assert (hip.kp.value, knee.kd.value, knee.default_position.value) == (20.0, 0.6, -0.8)
    assert (hip.action_scale.value, hip.command, hip.effort_limit.value) == (0.25, Command.POSITION, None)
    assert (found.actuators.physics_dt.value, found.actuators.decimation) == (0.005, 4)
    assert [item.joint for item in found.left_alone] == ["lift"]


def test_what_a_fork_of_legged_gym_adds_is_said(tmp_path: Path) -> None:
    text = LEGGED.replace("CONTROL", "torque_limits = 9.0\n        hip_reduction = 0.5")
    found = lift_config(artifact_of(tmp_path, text), joints())
    assert found.notes["hip"] == (
        "control has torque_limits, hip_reduction of its own: what that does is not known here",
    )


TRAINED = """from legged_gym.envs.base.legged_robot_config import LeggedRobotCfg, LeggedRobotCfgPPO

class BotRoughCfg( LeggedRobotCfg ):
    class env( LeggedRobotCfg.env ):
        num_observations = 48
    class init_state( LeggedRobotCfg.init_state ):
        pos = [0.0, 0.0, 0.5] # x,y,z [m]
        default_joint_angles = { # = target angles [rad] when action = 0.0
            'FL_hip_joint': 0.1,   # [rad]
            'FR_hip_joint': -0.1 ,
            'FL_calf_joint': -1.5,
            'FR_calf_joint': -1.5,
        }
    class control( LeggedRobotCfg.control ):
        control_type = 'P'
        stiffness = {'joint': 30., 'hip': 20.}  # [N*m/rad]
        damping = {'hip': 0.5, 'joint': 0.5}     # [N*m*s/rad]
        # action scale: target angle = actionScale * action + defaultAngle
        action_scale = 0.25
        decimation = 4
    class asset( LeggedRobotCfg.asset ):
        file = '{LEGGED_GYM_ROOT_DIR}/resources/robots/bot/urdf/bot.urdf'
        penalize_contacts_on = ["thigh", "calf"]
        self_collisions = 1 # 1 to disable, 0 to enable...bitwise filter
    class rewards( LeggedRobotCfg.rewards ):
        class scales( LeggedRobotCfg.rewards.scales ):
            torques = -0.0002

class BotRoughCfgPPO( LeggedRobotCfgPPO ):
    class algorithm( LeggedRobotCfgPPO.algorithm ):
        entropy_coef = 0.01
"""


def test_legged_gym_as_it_is_written(tmp_path: Path) -> None:
    """A cfg in the style of the real ones: bases of another package, nested classes, a second class for the trainer."""
    names = [f"{side}_{part}_joint" for part in ("hip", "calf") for side in ("FL", "FR")]
    found = lift_config(artifact_of(tmp_path, TRAINED), names)
    said = [
        (a.joint, a.kp and a.kp.value, a.kd and a.kd.value, a.default_position.value)
        for a in found.actuators.joints
    ]
    # The last key of stiffness that is a part of the name counts: 'hip' behind 'joint'.
    assert said == [
        ("FL_hip_joint", 20.0, 0.5, 0.1),
        ("FR_hip_joint", 20.0, 0.5, -0.1),
        ("FL_calf_joint", 30.0, 0.5, -1.5),
        ("FR_calf_joint", 30.0, 0.5, -1.5),
    ]
    assert (found.actuators.decimation, found.actuators.physics_dt.value) == (4, None)
    assert found.left_alone == ()


def test_legged_gym_other_controls(tmp_path: Path) -> None:
    """Control V acts on accelerations, which the law does not; control T is a torque."""
    speed = lift_config(artifact_of(tmp_path, LEGGED.replace("CONTROL", 'control_type = "V"')), joints())
    assert {item.why for item in speed.left_alone if item.joint != "lift"} == {
        "control_type V: its gains act on speeds and accelerations"
    }
    torque = lift_config(artifact_of(tmp_path, LEGGED.replace("CONTROL", 'control_type = "T"')), joints())
    assert {actuator.command for actuator in torque.actuators.joints} == {Command.EFFORT}


DEPLOY = """joint_names: [hip, knee]
kps: [20, 30]
kds: [0.5, 0.6]
default_angles: [0.1, -0.8]
control_dt: 0.02
"""


def test_deploy_names_its_joints(tmp_path: Path) -> None:
    """A deploy file alone has its joints, of unknown kind, and no more than it says."""
    found = lift_config(artifact_of(tmp_path, DEPLOY, "bot.yaml"))
    hip, knee = found.actuators.joints
    assert hip.kp is not None and knee.kp is not None
    assert (hip.kp.value, knee.kp.value, knee.default_position.value) == (20.0, 30.0, -0.8)
    assert (hip.effort_limit.origin, hip.kind) == (Origin.UNKNOWN, JointKind.HINGE)
    assert found.notes[""] == (
        "no robot file states the kinds of the joints: all are taken as hinges; a joint that slides is "
        "{name: NAME, kind: slide} in robot.joints of the spec, with a group of its own: --joints with the robot's "
        "URDF does both",
    )


def test_patterns_without_a_robot_file(tmp_path: Path) -> None:
    """Plain and escaped names are joints; a pattern is left alone, with what to do."""
    text = """from isaaclab.actuators import IdealPDActuatorCfg
BOT = {
    "a": IdealPDActuatorCfg(joint_names_expr=["hip", r"knee\\.left"], stiffness=1.0, damping=1.0),
    "b": IdealPDActuatorCfg(joint_names_expr=[".*_arm"], stiffness=2.0, damping=1.0),
}
"""
    found = lift_config(artifact_of(tmp_path, text))
    assert [actuator.joint for actuator in found.actuators.joints] == ["hip", "knee.left"]
    assert [(item.joint, item.why) for item in found.left_alone] == [
        (".*_arm", "a pattern, and no file names the joints: name the robot's MJCF or URDF too")
    ]


def test_patterns_beside_a_name(tmp_path: Path) -> None:
    """A pattern does not vanish because its group names one joint, too."""
    text = """from isaaclab.actuators import IdealPDActuatorCfg
BOT = {"a": IdealPDActuatorCfg(joint_names_expr=["hand_(FF|MF)J[1-3]", "hand_THJ0"], stiffness=1.0, damping=1.0)}
"""
    found = lift_config(artifact_of(tmp_path, text))
    assert [actuator.joint for actuator in found.actuators.joints] == ["hand_THJ0"]
    assert [item.joint for item in found.left_alone] == ["hand_(FF|MF)J[1-3]"]


def test_refused_patterns_are_said(tmp_path: Path) -> None:
    """A pattern that could hang selects nothing, and the group says so."""
    found = isaaclab(tmp_path, 'IdealPDActuatorCfg(["hip", "(k+)+$"], stiffness=1.0, damping=1.0)')
    assert [actuator.joint for actuator in found.actuators.joints] == ["hip"]
    (told,) = found.notes[""]
    assert told.startswith("group g0: '(k+)+$' has a repeat") and told.endswith(", so it selects no joint")


@pytest.mark.parametrize("low, high", [(-1, 2), (3, 2), (0, "1e999"), (-2, -1)])
def test_delays_that_are_none(tmp_path: Path, low: float, high: float | str) -> None:
    """A delay below 0, without end or from high to low is left out with a remark."""
    group = f'DelayedPDActuatorCfg(["hip"], min_delay={low}, max_delay={high}, stiffness=1.0, damping=1.0)'
    found = isaaclab(tmp_path, group, dt=0.005)
    assert by_name(found)["hip"].delay is None
    (told,) = found.notes["hip"]
    assert told.startswith("delay: ") and told.endswith("physics steps, which is none")


@pytest.mark.parametrize("step", ["0.0", "-0.005", "1e999"])
def test_step_that_is_none(tmp_path: Path, step: str) -> None:
    """A physics step that is not above 0 is unknown, at its place."""
    text = LEGGED.replace("CONTROL", "").replace("dt = 0.005", f"dt = {step}")
    found = lift_config(artifact_of(tmp_path, text), joints()).actuators.physics_dt
    assert (found.value, found.origin, found.span and found.span.line) == (None, Origin.UNKNOWN, 13)


def test_what_could_not_be_folded(tmp_path: Path) -> None:
    """A number that the reader cannot fold is unknown with the reason, at its place."""
    group = 'IdealPDActuatorCfg(["hip"], stiffness=elsewhere(), damping=1.0)'
    hip = by_name(isaaclab(tmp_path, group))["hip"]
    assert hip.kp is not None and hip.kp.origin is Origin.UNKNOWN
    assert hip.kp.note and hip.kp.span is not None and hip.kp.span.line == 3


@pytest.mark.parametrize(
    ("versions", "friction", "viscous", "delay"),
    [
        (LAB, 0.3, 0.05, None),  # sliding 0.3 beside static 0.4; lags of 0 to 3 steps are a range
        (Versions(isaaclab="2.2", isaac_sim="5.1"), None, None, None),
        (Versions(isaaclab="2.3", isaac_sim="4.5"), None, None, None),
        (Versions(isaaclab="3.0", backend="newton"), 0.4, 0.05, 0.012),  # one friction; one lag, 3 x 4 ms
    ],
    ids=["2.3", "dead", "coefficient", "native"],
)
def test_ledger_and_import_read_one_joint_alike(
    tmp_path: Path, versions: Versions, friction: float | None, viscous: float | None, delay: float | None
) -> None:
    """What the solver does with friction, and how many lags there are, is one decision for both."""
    text = """from isaaclab.actuators import DelayedPDActuatorCfg
BOT = {"legs": DelayedPDActuatorCfg(joint_names_expr=["hip"], stiffness=20.0, damping=0.5, effort_limit=9.0,
    friction=0.4, dynamic_friction=0.3, viscous_friction=0.05, max_delay=3)}
"""
    artifact = artifact_of(tmp_path, text)
    assert artifact.config is not None
    settings = {**artifact.config.settings, "physics_dt": Setting(0.004, artifact.config.span)}
    artifact = replace(artifact, config=replace(artifact.config, settings=settings))
    (row,) = rows_of_config(artifact, 0, [], versions)
    hip = by_name(lift_config(artifact, joints(), versions=versions))["hip"]
    assert (row.frictionloss, row.joint_damping, row.delay) == (friction, viscous, delay)
    assert hip.delay is not None
    assert (hip.friction_coulomb.value, hip.friction_viscous.value, hip.delay.nominal.value) == (
        (friction, viscous, delay)
    )


def test_legged_gym_without_a_control_type_is_a_position_drive_in_the_ledger_too(tmp_path: Path) -> None:
    """As its base class says; with V the gains act on speeds."""
    for control, kind in (("", "ideal_pd"), ('control_type = "V"', "velocity")):
        rows = rows_of_config(artifact_of(tmp_path, LEGGED.replace("CONTROL", control)), 0, [], Versions())
        assert {row.control for row in rows} == {kind}
