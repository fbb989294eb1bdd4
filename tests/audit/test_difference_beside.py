"""What changed beside the figures of joints: lists without names, their order, and what is not read."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.difference import Difference, compare_files
from actspec.readings.versions import Versions
from actspec.report.difference import lines, record, report_lines
from tests.audit.robots import CFG, LEG, SPEC
from tests.audit.test_difference import URDF, compare
from tests.schemas import fits

GYM = """control_dt: 0.02
msg_type: "hg"
leg_joint2motor_idx: [0, 1, 2, 3]
kps: [100, 100, 150, 40]
kds: [2, 2, 4, 2]
arms: {kps: [300, 100, 50], names: [a, b]}
pose: {left: 0.1, right: -0.1, waist: 0.0}
steps: [[], [0.0, 1.36, -2.65]]
limits: [0.5, 1.0]
num_actions: 4
sha256: "%s"
""" % ("0a" * 32)
"""In the manner of unitree_rl_gym's deploy_real: no file names the joints of a list."""


def both(tmp_path: Path, name: str, old: str, new: str) -> Difference:
    """The only robot of two files of one name."""
    tmp_path.mkdir(exist_ok=True)
    (found,) = compare(tmp_path, (name, old), (name, new))
    fits("diff", {"format": "actspec-diff/1", "robots": [record(found, "a", "b")]})
    return found


@pytest.mark.parametrize(
    "old, new, expected",
    [
        ("kps: [100, 100, 150", "kps: [100, 100, 1500", ["entry 3 of kps 150 -> 1500 (x10)"]),
        (
            "idx: [0, 1,",
            "idx: [1, 0,",
            ["entry 1 of leg_joint2motor_idx 0 -> 1", "entry 2 of leg_joint2motor_idx 1 -> 0"],
        ),
        ("[300, 100", "[330, 100", ["entry 1 of arms.kps 300 -> 330 (+10 %)"]),
        ("right: -0.1", "right: -0.3", ["pose.right -0.1 -> -0.3 (x3)"]),
        ("1.36", "1.02", ["entry 2 of entry 2 of steps 1.36 -> 1.02 (-25 %)"]),
        ("[2, 2, 4, 2]", "[2, 2, 4, 2, 2]", ["entry 5 of kds none -> 2"]),
        ("kps: [100, 100", "kps: [100, x", ["entry 2 of kps 100 -> x"]),
    ],
    ids=["gain", "index map", "other list", "mapping", "nested", "longer", "no number"],
)
def test_lists_without_names_are_compared_by_place(
    old: str, new: str, expected: list[str], tmp_path: Path
) -> None:
    """Which joint an entry is of nobody guesses; that it changed is told."""
    assert old in GYM
    found = both(tmp_path, "gym.yaml", GYM, GYM.replace(old, new))
    assert list(lines(found, "")) == expected
    assert not found.same


def test_what_is_of_no_joint_is_told_and_not_compared(tmp_path: Path) -> None:
    """A text, a single number and the two ends of a range are nobody's gains: no change, and no silence."""
    new = (
        GYM.replace('"hg"', '"go"')
        .replace("num_actions: 4", "num_actions: 5")
        .replace("0.5, 1.0", "0.5, 2.0")
    )
    # A hash says nothing that the numbers do not.
    new = new.replace("[a, b]", "[a, c]").replace("0a0a", "0b0b")
    found = both(tmp_path, "gym.yaml", GYM, new)
    assert found.same
    # control_dt; and of lists and maps 4 + 4 + 4 + 3 + 3 + 3 numbers
    assert list(report_lines([found], "a", "b")) == [
        "a -> b (gym)",
        "  no change in 22 figures",
        "  not compared: msg_type hg -> go",
        "  not compared: entry 2 of arms.names b -> c",
        "  not compared: entry 2 of limits 1 -> 2",
        "  not compared: num_actions 4 -> 5",
    ]
    assert list(report_lines([both(tmp_path / "x", "gym.yaml", GYM, GYM)], "a", "b")) == [
        "no change in effective dynamics"
    ]


@pytest.mark.parametrize(
    "times, old, new, expected",
    [
        # Half of 20 ms.
        ("dt: {}", "0.02", "0.01", ["control period 0.02 -> 0.01 s (-50 %)"]),
        ("dt: {}", "0.005", "0.002", ["dt 0.005 -> 0.002 (x0.4)"]),
        ("control_dt: 0.02\ndt: {}", "0.005", "0.002", ["dt 0.005 -> 0.002 (x0.4)"]),
        ("policy_dt: 0.02\ncontrol_dt: {}", "0.005", "0.002", ["control_dt 0.005 -> 0.002 (x0.4)"]),
        ("sim: {{dt: {}}}", "0.005", "0.002", ["sim.dt 0.005 -> 0.002 (x0.4)"]),
        ("num_dt_samples: {}", "5", "2", []),
    ],
)
def test_steps_that_are_not_read_are_compared(
    times: str, old: str, new: str, expected: list[str], tmp_path: Path
) -> None:
    """A step acts on every joint, whatever it is of."""
    texts = (f"{NAMED}{times.format(value)}\n" for value in (old, new))
    found = both(tmp_path, "deploy.yaml", *texts)
    assert list(lines(found, "")) == expected
    assert found.same is not bool(expected)


def test_between_two_kinds(tmp_path: Path) -> None:
    """What has no joint is counted, and compared with nothing."""
    (found,) = compare(tmp_path, ("leg.yaml", SPEC), ("gym.yaml", GYM.replace("4]", "3]")))
    # 4 places, 4 kp, 4 kd, 3 arms, 3 of the pose, 3 of the steps
    assert "    numbers whose joint it does not name 21" in report_lines([found], "a", "b")


def test_blocks_of_one_name(tmp_path: Path) -> None:
    """Two blocks with gains below one key are two robots, the first one with the first."""
    text = "FSM:\n  Stand: {kp: [60, 60, 61], kd: [5, 5, 5]}\n  Walk: {kp: [30, 30, 31], kd: [1, 1, 1]}\n"
    stand, walk = compare(tmp_path, ("fsm.yaml", text), ("fsm.yaml", text.replace("31", "32")))
    assert stand.same
    # 32 / 31 = 1.032
    assert list(lines(walk, "")) == ["entry 3 of FSM.Walk.kp 31 -> 32 (+3.23 %)"]


NAMED = "joint_names: [hip, knee, foot]\nkp: {hip: 100, knee: 150, foot: 40}\nkd: [2, 2, 2]\n"


def test_order_of_the_joint_names(tmp_path: Path) -> None:
    """The numbers of each joint stay, and a policy's outputs go to others."""
    found = both(tmp_path, "deploy.yaml", NAMED, NAMED.replace("hip, knee,", "knee, hip,"))
    assert list(lines(found, "")) == [
        "entry 1 of the joint names hip -> knee",
        "entry 2 of the joint names knee -> hip",
    ]
    # One that is new moves the others, and is told as a joint.
    longer = NAMED.replace("[hip,", "[toe, hip,").replace("{hip", "{toe: 1, hip").replace("2]", "2, 2]")
    assert list(lines(both(tmp_path / "x", "deploy.yaml", NAMED, longer), "")) == ["joints added: toe"]


SECOND = '    <position name="knee" joint="knee" kp="100" kv="3" forcerange="-30 30" forcelimited="true"/>\n'


@pytest.mark.parametrize(
    "new, expected",
    [
        (
            LEG.replace('joint="hip"', 'joint="x"')
            .replace('joint="knee"', 'joint="hip"')
            .replace('"x"', '"knee"'),
            ["ctrl[0], actuator hip, drives hip -> knee", "ctrl[1], actuator knee, drives knee -> hip"],
        ),
        (
            LEG.replace(SECOND, "").replace("<actuator>\n", f"<actuator>\n{SECOND}"),
            ["ctrl[0] drives hip -> knee", "ctrl[1] drives knee -> hip"],
        ),
        (
            LEG.replace('name="hip" joint', 'name="x" joint')
            .replace('name="knee" joint', 'name="hip" joint')
            .replace('name="x" joint', 'name="knee" joint'),
            ["actuator hip drives hip -> knee", "actuator knee drives knee -> hip"],
        ),
        (LEG.replace('name="hip" joint', 'name="motor" joint'), []),
    ],
    ids=["joints exchanged", "order", "names exchanged", "renamed"],
)
def test_which_actuator_drives_which_joint(new: str, expected: list[str], tmp_path: Path) -> None:
    """Every joint keeps its figures, and a control by place or by name moves another one."""
    assert new != LEG
    assert list(lines(both(tmp_path, "leg.xml", LEG, new), "")) == expected


def test_a_joint_that_is_gone_is_no_exchange(tmp_path: Path) -> None:
    """A new name of a joint, and one drive less, are told as that alone."""
    found = both(tmp_path, "leg.xml", LEG, LEG.replace('"knee"', '"shin"'))
    assert list(lines(found, "")) == ["joints added: shin", "joints removed: knee"]
    less = both(
        tmp_path / "x", "leg.xml", LEG, LEG.replace(LEG[LEG.index("    <position") : LEG.index(SECOND)], "")
    )
    assert not any("ctrl" in line for line in lines(less, ""))


def test_a_step_that_nobody_states(tmp_path: Path) -> None:
    """MuJoCo's own step is no statement of the spec, nor of a model without one."""
    bare = LEG.replace('<option timestep="0.002" integrator="implicitfast"/>', "")
    spec = SPEC.replace("timing: {physics_dt: 2 ms, decimation: 10}\n", "").replace("leg.xml", "leg.urdf")
    files = {"leg.xml": bare, "leg.urdf": URDF, "leg.yaml": spec, "leg_cfg.py": CFG}
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    for name in ("leg.xml", "leg.yaml"):
        found = compare_files(str(tmp_path / name), str(tmp_path / "leg_cfg.py"), Versions())
        told = list(report_lines(found, name, "leg_cfg.py"))
        assert any("armature" in line for line in told)
        assert not any("physics step" in line or "integrator" in line for line in told)


def test_a_pose_that_nobody_states(tmp_path: Path) -> None:
    """It is unknown; the zero that a spec without one compiles with is no pose of the robot."""
    posed = SPEC.replace("model: leg.xml", 'model: leg.xml, default_pose: {"hip": -0.2 rad, "knee": 0 rad}')
    found = both(tmp_path, "leg.yaml", posed, SPEC)
    assert list(lines(found, "")) == ["hip:", "  default position -0.2 rad -> unknown"]


def test_patterns_are_no_joints(tmp_path: Path) -> None:
    """Which joints a pattern selects nobody knows without the robot, so they are counted as patterns."""
    text = CFG.replace('["hip", "knee"]', '["hip.*", "knee.*", "foot"]').replace("100.0", "gain()")
    found = both(tmp_path, "leg_cfg.py", text, text)
    expected = "  not compared: stiffness kp at 1 joint and 2 patterns of joints, unknown"
    assert expected in report_lines([found], "a", "b")


TASK = """from isaaclab.assets import ArticulationCfg
from isaaclab.envs import ManagerBasedRLEnvCfg
from isaaclab.scene import InteractiveSceneCfg
from isaaclab.utils import configclass
from elsewhere.robots import GO2_CFG

class SceneCfg(InteractiveSceneCfg):
    robot = GO2_CFG.replace(prim_path="{ENV}/Robot", init_state=ArticulationCfg.InitialStateCfg(joint_pos={"hip": 0.1}))

@configclass
class TaskCfg(ManagerBasedRLEnvCfg):
    scene: SceneCfg = SceneCfg(num_envs=4096)

    def __post_init__(self):
        self.decimation = 4
        self.sim.dt = 0.005
        self.rewards.effort.weight = -0.1
        self.scene.robot.actuators["legs"].stiffness = 40.0
        self.scene.robot.actuators["legs"].damping *= 2.0
        self.scene.robot.actuators["legs"].class_type = Fast
        self.scene.robot.spawn.mass_scale = 1.0

@configclass
class PlayCfg(TaskCfg):
    def __post_init__(self):
        super().__post_init__()
        self.scene.num_envs = 32
"""
"""In the manner of unitree_rl_lab: the robot of the task is imported from elsewhere."""

UNREAD = (
    "  not compared: robot, not known without running it: "
    "GO2_CFG comes from elsewhere, which is not beside this file"
)


@pytest.mark.parametrize(
    "old, new, expected",
    [
        (
            "stiffness = 40.0",
            "stiffness = 400.0",
            ["  scene.robot.actuators['legs'].stiffness 40 -> 400 (x10)", UNREAD],
        ),
        (
            '"hip": 0.1',
            '"hip": 0.3',
            ["  GO2_CFG.replace.init_state.joint_pos['hip'] 0.1 -> 0.3 (x3)", UNREAD],
        ),
        (
            "damping *= 2.0",
            "damping *= 3.0",
            # decimation, dt and the period; the stiffness and the pose
            [
                "  no change in 5 figures",
                UNREAD,
                "  not compared: scene.robot.actuators['legs'].damping *= 2.0 -> *= 3.0",
            ],
        ),
        (
            "mass_scale = 1.0",
            "mass_scale = 1.5",
            ["  no change in 5 figures", UNREAD, "  not compared: scene.robot.spawn.mass_scale 1 -> 1.5"],
        ),
        ("weight = -0.1", "weight = -0.2", ["  no change in 5 figures", UNREAD]),
        (
            "num_envs = 32",
            'robot.actuators["legs"].armature = 0.1',
            ["  PlayCfg: scene.robot.actuators['legs'].armature none -> 0.1", UNREAD],
        ),
        (
            "elsewhere.robots import GO2_CFG",
            "elsewhere.robots import GO2W_CFG as GO2_CFG",
            None,
        ),
    ],
    ids=["gain", "pose", "times", "other", "reward", "play", "another robot"],
)
def test_robot_that_is_not_read(old: str, new: str, expected: list[str] | None, tmp_path: Path) -> None:
    """What a task assigns to it is compared as it stands, or said; and that it is not read, always."""
    text = TASK.replace("num_envs = 32", new if old == "num_envs = 32" else "num_envs = 32")
    if old != "num_envs = 32":
        text = text.replace(old, new)
    assert text != TASK
    found = both(tmp_path, "task_cfg.py", TASK, text)
    told = list(report_lines([found], "a", "b"))[1:]
    if expected is None:
        assert any("GO2_CFG comes from" in line and "GO2W_CFG comes from" in line for line in told)
    else:
        assert told == expected


def test_a_robot_that_is_read_has_no_such_thing(tmp_path: Path) -> None:
    """With the robot beside it the same assignment is a figure of its joints, and told once."""
    text = CFG + TASK.replace("from elsewhere.robots import GO2_CFG", "GO2_CFG = LEG_CFG").replace(
        "*= 2.0", "= 3.0"
    )
    text = text.replace('        self.scene.robot.actuators["legs"].class_type = Fast\n', "")
    changed = text.replace("stiffness = 40.0", "stiffness = 400.0")
    found = {item.new.name: item for item in compare(tmp_path, ("leg_cfg.py", text), ("leg_cfg.py", changed))}
    task = found["TaskCfg"]
    assert list(lines(task, "")) == ["hip, knee:", "  stiffness kp 40 -> 400 N*m/rad (x10)"]
    assert task.new.entries == {} and task.new.unread == {}


def test_ranges_of_a_configuration_are_told(tmp_path: Path) -> None:
    """They are read, and compared with nothing: a lock has none."""
    event = """
from isaaclab.managers import EventTermCfg
import isaaclab.envs.mdp as mdp
class EventCfg:
    gains = EventTermCfg(
        func=mdp.randomize_actuator_gains, mode="reset",
        params={"stiffness_distribution_params": (0.8, 1.2), "operation": "scale"},
    )
"""
    found = compare(tmp_path, ("e_cfg.py", CFG + event), ("e_cfg.py", CFG + event.replace("0.8", "0.5")))
    told = list(report_lines(found, "a", "b"))
    assert (
        "  not compared: randomization of kp scale 0.8 to 1.2 (uniform, reset) -> scale 0.5 to 1.2 (uniform, reset)"
        in told
    )
    # A range of the start before it, and the first of the two changed.
    start = event + event[event.index("    gains") :].replace("gains =", "start =").replace(
        "reset", "startup"
    )
    again = start.replace("(0.8, 1.2)", "(0.5, 1.2)", 1)
    (tmp_path / "two").mkdir()
    found = compare(tmp_path / "two", ("e_cfg.py", CFG + start), ("e_cfg.py", CFG + again))
    beside = ", scale 0.8 to 1.2 (uniform, startup)"
    told = "scale 0.8 to 1.2 (uniform, reset)" + beside + " -> scale 0.5 to 1.2 (uniform, reset)" + beside
    assert f"  not compared: randomization of kp {told}" in list(report_lines(found, "a", "b"))


def test_another_model_is_told(tmp_path: Path) -> None:
    """The same drives on another robot are another machine: its file is not compared, and is not passed over."""
    spawn = 'ArticulationCfg(\n    spawn=sim_utils.UsdFileCfg(usd_path="go2.usd"),\n'
    text = "import isaaclab.sim as sim_utils\n" + CFG.replace("ArticulationCfg(\n", spawn)
    found = both(tmp_path, "leg_cfg.py", text, text.replace("go2.usd", "b2.usd"))
    assert "  not compared: model go2.usd -> b2.usd" in report_lines([found], "a", "b")


@pytest.mark.slow
def test_more_than_is_read_is_said(tmp_path: Path) -> None:
    """A list of more numbers than are looked at, and aliases that make few nodes many: nobody calls them unchanged."""
    bomb = "".join(f"b{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]\n" for n in range(1, 12))
    text = f"{GYM}long: [{', '.join(['1'] * 20_000)}]\na: &a0 []\n{bomb}"
    told = list(report_lines([both(tmp_path, "gym.yaml", text, text)], "a", "b"))
    assert "  not compared: long, more than is read" in told
    assert sum(line.endswith(", more than is read") for line in told) == 2
