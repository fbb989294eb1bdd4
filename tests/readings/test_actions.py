"""What action terms say of each joint. What the terms do is measured in tests/frameworks/test_actions.py."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.settings import Settings
from actspec.lift.config import lift_config
from actspec.readings.artifact import Artifact
from actspec.readings.config import rows_of_config
from actspec.readings.python.read import read_python
from actspec.readings.versions import Versions
from actspec.report.ledger import ledger_sheets

JOINTS = ("hip_L", "hip_R", "wheel_L", "wheel_R")

LAB = """
from isaaclab.actuators import ImplicitActuatorCfg
from isaaclab.assets import ArticulationCfg
from isaaclab.envs import ManagerBasedRLEnvCfg, mdp
import tasks.mdp as own

BOT_CFG = ArticulationCfg(
    init_state=ArticulationCfg.InitialStateCfg(joint_pos={"hip_.*": 0.7}),
    actuators={
        "legs": ImplicitActuatorCfg(joint_names_expr=["hip_.*"], stiffness=40.0, damping=2.5),
        "wheels": ImplicitActuatorCfg(joint_names_expr=["wheel_.*"], stiffness=0.0, damping=0.8),
    },
)

class SceneCfg:
    robot = BOT_CFG

class ActionsCfg:
    @TERMS@

class BotEnvCfg(ManagerBasedRLEnvCfg):
    scene = SceneCfg()
    actions = ActionsCfg()
    decimation = 4
"""

MJLAB = """
from mjlab.actuator import BuiltinPositionActuatorCfg, BuiltinVelocityActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg, EntityCfg
from mjlab.envs import ManagerBasedRlEnvCfg, mdp
from mjlab.scene import SceneCfg

LEGS = BuiltinPositionActuatorCfg(target_names_expr=("hip_.*",), stiffness=40.0, damping=2.5)
WHEELS = BuiltinVelocityActuatorCfg(target_names_expr=("wheel_.*",), damping=0.8)

def bot_env_cfg():
    bot = EntityCfg(
        init_state=EntityCfg.InitialStateCfg(joint_pos={"hip_.*": 0.7}),
        articulation=EntityArticulationInfoCfg(actuators=(LEGS, WHEELS)),
    )
    return ManagerBasedRlEnvCfg(
        decimation=4, scene=SceneCfg(entities={"robot": bot}), actions=dict(
            @TERMS@
        ),
    )
"""

LEGS = 'a = mdp.JointPositionActionCfg(joint_names=["hip_.*"], scale=0.25)'
WHEELS = 'b = mdp.JointVelocityActionCfg(joint_names=["wheel_.*"], scale=10.0)'


def environment(folder: Path, terms: tuple[str, ...], text: str = LAB) -> Artifact:
    """The environment of a file with these terms."""
    lab = "mjlab" not in text
    body = ("\n    " if lab else ",\n            ").join(terms)
    if not lab:
        body = body.replace("joint_names", "actuator_names").replace("asset_name", "entity_name")
    path = folder / "cfg.py"
    path.write_text(text.replace("@TERMS@", body), encoding="utf-8")
    return next(one for one in read_python(str(path)).artifacts if one.name in ("BotEnvCfg", "bot_env_cfg"))


def scales(folder: Path, terms: tuple[str, ...], text: str = LAB) -> list[float | str | None]:
    """The action scale of each joint; why it is unknown; None: not stated."""
    found = []
    for joint in lift_config(environment(folder, terms, text), JOINTS).actuators.joints:
        scale = joint.action_scale
        found.append(None if scale is None else scale.note if scale.value is None else scale.value)
    return found


CASES: dict[str, tuple[tuple[str, ...], list[float | str | None]]] = {
    "legs and wheels": ((LEGS, WHEELS), [0.25, 0.25, 10.0, 10.0]),
    "wheels first": ((WHEELS, LEGS), [0.25, 0.25, 10.0, 10.0]),
    "legs alone": ((LEGS,), [0.25, 0.25, None, None]),
    "wheels alone": ((WHEELS,), [None, None, 10.0, 10.0]),
    "two terms of one kind": (
        (LEGS.replace("hip_.*", "hip_L"), LEGS.replace("hip_.*", "hip_R").replace("a =", "c =").replace("0.25", "2")),
        [0.25, 2.0, None, None],
    ),
    "without a scale": ((LEGS.replace(", scale=0.25", ""),), [1.0, 1.0, None, None]),
    "a dict that misses a joint": (
        (LEGS.replace("0.25", '{"hip_L": 0.5}'), WHEELS),
        [0.5, 1.0, 10.0, 10.0],
    ),
    "two for one joint": (
        (LEGS, LEGS.replace("a =", "c =").replace("hip_.*", ".*_L")),
        ["actions.a and actions.c are both for the joint", 0.25,
         "JointPositionActionCfg commands a position, 0.25 x action, and the joint's command is a speed", None],
    ),
    "joints of unknown names": (
        (LEGS.replace('["hip_.*"]', "elsewhere()"), WHEELS),
        [0.25, 0.25, 10.0, 10.0],
    ),
    "two of unknown names": (
        (LEGS.replace('["hip_.*"]', "elsewhere()"), WHEELS.replace('["wheel_.*"]', "elsewhere()")),
        ["which joints actions.a and actions.b are for is not known"] * 4,
    ),
    "of another robot": (
        (LEGS.replace("joint_names", 'asset_name="robot", joint_names'),
         WHEELS.replace("joint_names", 'asset_name="hand", joint_names')),
        [0.25, 0.25, None, None],
    ),
    "relative": (
        (LEGS.replace("JointP", "RelativeJointP"), WHEELS),
        ["RelativeJointPositionActionCfg: the command is the position now + 0.25 x action"] * 2 + [10.0, 10.0],
    ),
    "open and closed": (
        (LEGS.replace("JointP", "BinaryJointP"),),
        ["BinaryJointPositionActionCfg makes the command in a way of its own"] * 2 + [None, None],
    ),
    "an offset of a speed": (
        (WHEELS.replace("scale", "use_default_offset=False, offset=2.0, scale"),),
        [None, None, *["JointVelocityActionCfg adds an offset of 2 to the command"] * 2],
    ),
    "a speed for a position": (
        (WHEELS.replace("wheel_.*", "hip_.*"),),
        ["JointVelocityActionCfg commands a speed, 10 x action, and the joint's command is a position"] * 2
        + [None, None],
    ),
}  # fmt: skip


@pytest.mark.parametrize("text", [LAB, MJLAB], ids=["isaaclab", "mjlab"])
@pytest.mark.parametrize("case", CASES)
def test_the_scale_of_each_joint(tmp_path: Path, case: str, text: str) -> None:
    """A term is for the joints that it names, in what it commands; one that nobody is for has no scale."""
    terms, expected = CASES[case]
    assert scales(tmp_path, terms, text) == expected


def test_terms_of_isaac_lab_alone(tmp_path: Path) -> None:
    """Classes that scale to the joint's range, own classes, and a base that is not read."""
    found = scales(tmp_path, (LEGS.replace("JointPosition", "JointPositionToLimits"),))
    assert found[0] == "JointPositionToLimitsActionCfg: actions of -1 and 1 are the ends of the joint's range"
    own = "a = mdp.JointPositionActionCfg(joint_names=['hip_.*'], scale=0.25, class_type=own.SlowAction)"
    assert scales(tmp_path, (own,))[0] == "JointPositionActionCfg makes the command in a way of its own"
    own = 'a = own.MaskedJointPositionActionCfg(joint_names=["hip_.*"], scale=0.25)'
    assert scales(tmp_path, (own,))[0] == "MaskedJointPositionActionCfg makes the command in a way of its own"
    # A class of the same name of somebody's own may have another default.
    assert scales(tmp_path, ('a = own.JointPositionActionCfg(joint_names=["hip_.*"])',))[0] is None
    base = LAB.replace("(ManagerBasedRLEnvCfg)", "(own.BotEnvCfg)").replace(
        "    actions = ActionsCfg()\n", ""
    )
    post = "    def __post_init__(self):\n        self.actions.{}.scale = 0.5\n"
    assert scales(tmp_path, ("pass",), base + post.format("joint_pos"))[:2] == [0.5, 0.5]
    wrong = "actions.joint_vel commands a speed, 0.5 x action, and the joint's command is a position"
    assert scales(tmp_path, ("pass",), base + post.format("joint_vel")) == [wrong, wrong, 0.5, 0.5]


@pytest.mark.parametrize("text", [LAB, MJLAB], ids=["isaaclab", "mjlab"])
@pytest.mark.parametrize(
    ("more", "pose", "told"),
    [
        ("", 0.7, False),
        ("offset=0.3, ", 0.7, False),
        ("use_default_offset=True, ", 0.7, False),
        ("use_default_offset=False, ", 0.0, True),
        ("use_default_offset=False, offset=0.3, ", 0.3, True),
        ("use_default_offset=False, offset=0.7, ", 0.7, False),
        ('use_default_offset=False, offset={"hip_L": 0.3}, ', 0.3, True),
        ("use_default_offset=False, offset=elsewhere(), ", None, False),
        ("use_default_offset=elsewhere(), ", None, False),
    ],
)
def test_the_position_at_zero_action(
    tmp_path: Path, text: str, more: str, pose: float | None, told: bool
) -> None:
    """The default position, unless the term has its own zero; where the joint starts is told then."""
    part = environment(tmp_path, (LEGS.replace("scale", f"{more}scale"),), text)
    found = lift_config(part, JOINTS)
    hip = found.actuators.joints[0]
    assert hip.default_position.value == pose
    assert hip.action_scale is not None and hip.action_scale.value == 0.25
    line = part.config.actions[0].span.line if part.config is not None else 0
    zero = f"default_pose is {pose or 0} rad, the command at zero action (line {line})"
    note = f"{zero}; that it starts at 0.7 rad is left out"
    assert (note in found.notes.get("hip_L", ())) is told
    # The audit holds no command against the pose that is not in it.
    (row,) = (row for row in rows_of_config(part, 0, (), Versions(), joints=JOINTS) if row.joint == "hip_L")
    assert row.default_position == (0.7 if pose == 0.7 else None)
    assert row.action_scale == 0.25


@pytest.mark.parametrize(
    ("clip", "ends"),
    [
        ('{".*": (-1.0, 0.5)}', (-1.0, 0.5)),
        ('{"hip_L": (-1.0, 0.5), "hip_R": (-3.0, 3.0)}', (-1.0, 0.5)),
        ('{".*": (-100.0, 100.0)}', None),
        ("None", None),
        ('{"hip_R": (-1.0, 1.0)}', None),
    ],
)
def test_the_clip_of_a_command(tmp_path: Path, clip: str, ends: tuple[float, float] | None) -> None:
    """A clip keeps the command between its ends, as a spec's command_range; one of 100 rad clips nothing."""
    part = environment(tmp_path, (LEGS.replace("scale", f"clip={clip}, scale"),))
    found = lift_config(part, JOINTS).actuators.joints[0].command_range
    assert (None if found is None else tuple(end.value for end in found)) == ends


@pytest.mark.parametrize(("terms", "unit"), [((LEGS,), "rad"), ((WHEELS,), "rad/s"), ((LEGS, WHEELS), "")])
def test_the_unit_of_a_scale_is_that_of_the_command(
    tmp_path: Path, terms: tuple[str, ...], unit: str
) -> None:
    """A wheel's is a speed for an action of 1; a column of both has no unit."""
    part = environment(tmp_path, terms)
    rows = [
        row for row in rows_of_config(part, 0, (), Versions(), joints=JOINTS) if row.action_scale is not None
    ]
    units = {"hip": "rad", "wheel": "rad/s"}
    assert [row.unit("action_scale") for row in rows] == [units[row.joint.split("_")[0]] for row in rows]
    case = audit([part.path], Settings()).case
    (heads,) = (dict(sheet.heads) for sheet in ledger_sheets(case) if "action scale" in dict(sheet.heads))
    assert heads["action scale"] == unit


_ANOTHER = "with another that no command reaches"


@pytest.mark.parametrize(
    ("clip", "why"),
    [
        ('{".*": (-float("inf"), 0.5)}', f"has one end, 0.5 rad: write [LOW, 0.5 rad] {_ANOTHER}"),
        ('{".*": (-0.5, 1e9)}', f"has one end, -0.5 rad: write [-0.5 rad, HIGH] {_ANOTHER}"),
        ('{".*": ("-inf", 2)}', "is not known: it is no pair of numbers"),
        ('{".*": (0.5, 0.5)}', "is not known: its ends are 0.5 and 0.5"),
        ('{".*": (1.0, -1.0)}', "is not known: its ends are 1 and -1"),
        ('{".*": (-1.0, float("nan"))}', "is not known: its ends are -1 and nan"),
        ('{".*": (-1.0, 1.0), "hip_L": (-2.0, 2.0)}', "is not known: 2 keys are for the joint"),
        ("(-1.0, 1.0)", "is not known: it is no dict of (low, high) by joint"),
        ("LIMITS", "is not known: LIMITS is not defined here"),
        ('{".*": (float("-inf"), float("inf"))}', None),
        ('{"hip_R": (float("-inf"), 1.0)}', None),
    ],
)  # fmt: skip
def test_a_clip_that_no_spec_can_hold_is_told(tmp_path: Path, clip: str, why: str | None) -> None:
    """A command_range has two ends, both known: any other clip of a joint is told, once, at its line."""
    part = environment(tmp_path, (LEGS.replace("scale", f"clip={clip}, scale"),))
    found = lift_config(part, JOINTS)
    assert found.actuators.joints[0].command_range is None
    (line,) = (
        at
        for at, text in enumerate(Path(part.path).read_text(encoding="utf-8").splitlines(), 1)
        if "clip=" in text
    )
    said = [note for note in found.notes.get("hip_L", ()) if "command_range" in note]
    told = f"command_range is left out: the action's clip (line {line}) {why}"
    assert said == ([] if why is None else [told])


@pytest.mark.parametrize(
    ("terms", "expected"),
    [
        ((LEGS, WHEELS), [0.25, 10.0]),
        ((LEGS.replace("hip_.*", ".*"),), [0.25, None]),
        ((LEGS.replace("hip_.*", "hip_L"),), [None, None]),
        ((LEGS.replace("hip_.*", ".*_L"), WHEELS), [None, None]),
        ((LEGS.replace("0.25", '{"hip_.*": 0.5}'),), [0.5, None]),
    ],
)
def test_joints_that_nobody_names(
    tmp_path: Path, terms: tuple[str, ...], expected: list[float | None]
) -> None:
    """Of a group by pattern a term is known to be for all joints by the same pattern, or by one for all."""
    rows = rows_of_config(environment(tmp_path, terms), 0, (), Versions())
    assert [row.action_scale for row in rows] == expected


def test_a_class_of_another_law_takes_what_it_wants(tmp_path: Path) -> None:
    """A list is told where it is no number: not in a class whose scale is one of axes, nor in one that is not read."""
    lists = 'a = mdp.{}(joint_names=["hip_.*"], scale=[0.1, 0.2])'
    told = []
    for cls in ("JointPositionActionCfg", "DifferentialInverseKinematicsActionCfg"):
        config = environment(tmp_path, (lists.format(cls),)).config
        assert config is not None
        told.append([note.where for note in config.notes])
    assert told == [["actions.a.scale"], []]


DIRECT = (
    LAB.partition("class SceneCfg")[0].replace("ManagerBasedRLEnvCfg, mdp", "DirectRLEnv, DirectRLEnvCfg")
    + """
class BotEnvCfg(DirectRLEnvCfg):
    robot = BOT_CFG
    decimation = 4
    action_scale = 0.25
"""
)
ENV = """
class BotEnv(DirectRLEnv):
    def _pre_physics_step(self, actions: torch.Tensor) -> None:
        self._actions = actions.clone()
        self._targets = self.cfg.action_scale * self._actions + self._robot.data.default_joint_pos

    def _apply_action(self) -> None:
        self._robot.set_joint_position_target(self._targets)
"""
LAW = "self.cfg.action_scale * self._actions + self._robot.data.default_joint_pos"
SET = "self._robot.set_joint_position_target(self._targets)"
LATE = (f"        self._targets = {LAW}\n", ""), (SET, f"self._robot.set_joint_position_target({LAW})")


@pytest.mark.parametrize(
    ("code", "known"),
    [
        # Isaac Lab's anymal_c, as it stands in one file with its cfg up to 2.0.
        (ENV, True),
        (ENV.replace(*LATE[0]).replace(*LATE[1]), True),
        (ENV.replace("actions.clone()", "torch.clamp(actions, -1.0, 1.0).to(self.device)"), True),
        (ENV.replace("actions.clone()", "actions.clamp(-1.0, 1.0)"), True),
        (ENV.replace(LAW, "self._robot.data.default_joint_pos + self._actions * self.cfg.action_scale"), True),
        (ENV.replace(LAW, f"torch.clamp({LAW}, self.low, self.high)"), True),
        # The environment stands in another file.
        ("", False),
        # Isaac Lab's franka_cabinet, cartpole and ant, and ManiSkill's franka.
        (ENV.replace(LAW, "self._targets + self.speed * self.dt * self._actions * self.cfg.action_scale"), False),
        (ENV.replace(LAW, "self.cfg.action_scale * self._actions").replace("_position_", "_effort_"), False),
        (ENV.replace(LAW, "self.cfg.action_scale * self.joint_gears * self._actions"), False),
        (ENV.replace(LAW, "torch.clamp(self._actions + self._robot.data.joint_pos, self.low, self.high)"), False),
        # What looks like the law, and is another.
        (ENV.replace(LAW, LAW.replace("*", "+")), False),
        (ENV.replace("default_joint_pos", "joint_pos"), False),
        (ENV.replace("actions.clone()", "2.0 * actions"), False),
        (ENV.replace("actions.clone()", "0.8 * self._actions + 0.2 * actions"), False),
        (ENV.replace("_position_", "_effort_"), False),
        (ENV.replace("(self._targets)", "(self._targets, joint_ids=self._legs)"), False),
        (ENV.replace(SET, f"{SET}\n        self._robot.set_joint_effort_target(self._torques)"), False),
        (ENV.replace(SET, f"self._targets = self._filter(self._targets)\n        {SET}"), False),
        (ENV.replace(SET, f"self._targets += 0.1\n        {SET}"), False),
        (ENV.replace(SET, f"if self.cfg.debug:\n            {SET}"), False),
        (ENV + ENV.replace("BotEnv(", "StrongEnv(").replace("actions.clone()", "2.0 * actions"), False),
        (ENV.replace("DirectRLEnv", "OwnEnv").partition("    def _apply")[0], False),
        (ENV.replace("actions.clone()", f"actions{' + 0.0' * 1500}"), False),
    ],
)  # fmt: skip
def test_the_scale_of_a_direct_task(tmp_path: Path, code: str, known: bool) -> None:
    """`action_scale` of a direct task is what its code makes of it: a position's where that is seen."""
    part = environment(tmp_path, (), DIRECT + code)
    found = [joint.action_scale for joint in lift_config(part, JOINTS).actuators.joints]
    told = [None if one is None else one.note if one.value is None else one.value for one in found]
    if known:
        speed = "BotEnvCfg commands a position, 0.25 x action, and the joint's command is a speed"
        assert told == [0.25, 0.25, speed, speed]
    else:
        assert told == ["what the environment's code makes of BotEnvCfg.action_scale = 0.25 is not known"] * 4
    rows = rows_of_config(part, 0, (), Versions(), joints=JOINTS)
    assert [row.action_scale for row in rows] == ([0.25, 0.25, None, None] if known else [None] * 4)
    # A change of the number is one of the policy's all the same: diff and lock have it as it stands.
    assert part.config is not None
    entries = {where: one.value for where, one in part.config.entries.items()}
    assert entries == ({} if known else {"action_scale": 0.25})


def test_a_manager_based_task_scales_by_its_terms(tmp_path: Path) -> None:
    """An attribute of the author's own beside the terms says nothing of a joint."""
    text = LAB.replace("    decimation = 4", "    decimation = 4\n    action_scale = 9.0")
    assert scales(tmp_path, (LEGS, WHEELS), text) == [0.25, 0.25, 10.0, 10.0]
