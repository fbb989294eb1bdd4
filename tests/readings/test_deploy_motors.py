"""unitree_rl_lab's deploy.yaml: gains by the number of the motor, pose and action by the policy's order."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.settings import Settings
from actspec.cli.main import main
from actspec.readings.artifact import RobotConfig
from actspec.readings.deploy import read_deploy

SDK = ("hip", "knee", "", "foot")
"""Motor 2 is a gap, as the H1 and the G1 of 23 joints have some."""

DEPLOY = """\
joint_ids_map: [3, 0, 1]
step_dt: 0.02
stiffness: [10.0, 20.0, 0.0, 30.0]
damping: [1.0, 2.0, 0.0, 3.0]
default_joint_pos: [0.3, 0.1, -0.2]
actions:
  JointPositionAction:
    clip: null
    joint_names: [.*]
    scale: [0.5, 0.25, 0.25]
    offset: [0.3, 0.1, -0.2]
    joint_ids: null
"""
"""The simulator's order is foot, hip, knee: the map has the motor of each."""

RUN = """\
sim: {dt: 0.005}
decimation: 4
scene:
  robot:
    class_type: isaaclab.assets.articulation.articulation:Articulation
    spawn: {usd_path: /somewhere/leggy.usd}
    init_state: {joint_pos: {hip: 0.1, knee: -0.2, foot: 0.3}}
    joint_sdk_names: [hip, knee, '', foot]
    actuators:
      legs:
        class_type: isaaclab.actuators.actuator_pd:IdealPDActuator
        joint_names_expr: [hip, knee, foot]
        effort_limit: 23.5
        stiffness: {hip: 10.0, knee: 20.0, foot: 30.0}
        damping: {hip: 1.0, knee: 2.0, foot: 3.0}
actions:
  joint_pos:
    class_type: isaaclab.envs.mdp.actions.joint_actions:JointPositionAction
    clip: null
    joint_names: [.*]
    scale: {hip: 0.25, knee: 0.25, foot: 0.5}
    offset: 0.0
    use_default_offset: true
"""

NAMES = "joint_sdk_names: [hip, knee, '', foot]\n"


def config_of(text: str) -> RobotConfig:
    (artifact,) = read_deploy("deploy.yaml", text.encode()).artifacts
    assert artifact.config is not None
    return artifact.config


@pytest.mark.parametrize("names", [NAMES, "joint_names_sdk_order: [hip, knee, null, foot]\n"])
def test_both_orders(names: str) -> None:
    """Each list by its own: the second default position is the hip's, the second stiffness the knee's."""
    config = config_of(names + DEPLOY)
    found = {
        group.name: tuple(group.settings[name].value for name in ("kp", "kd", "default_position"))
        for group in config.groups
    }
    assert found == {"hip": (10.0, 1.0, 0.1), "knee": (20.0, 2.0, -0.2), "foot": (30.0, 3.0, 0.3)}
    (term,) = config.actions
    assert term.scale is not None and term.scale.value == {"foot": 0.5, "hip": 0.25, "knee": 0.25}
    assert term.zero is None and (term.command, term.joints) == ("position", ("foot", "hip", "knee"))
    assert str(term.scale.place("knee")) == "deploy.yaml:11:24"
    assert config.settings["joint_order"].value == SDK and config.notes == ()


def test_nobody_names_the_motors() -> None:
    """Nothing is guessed, and the advice is for an order that there is."""
    config = config_of(DEPLOY)
    assert config.groups == () and {note.where for note in config.notes} == {
        "stiffness",
        "damping",
        "default_joint_pos",
    }
    assert {note.help for note in config.notes} == {
        "name the env.yaml of its run with it, which has them, or add joint_sdk_names: [...] with 4 names in the order "
        "of its kp and kd; the others are read by joint_ids_map"
    }


def test_an_action_that_is_not_added_to_the_pose() -> None:
    """`use_default_offset: false` writes zeros: the command at zero action is 0, whatever the pose."""
    (term,) = config_of(NAMES + DEPLOY.replace("offset: [0.3, 0.1, -0.2]", "offset: [0.0, 0.0, 0.0]")).actions
    assert term.zero is not None and term.zero.value == {"foot": 0.0, "hip": 0.0, "knee": 0.0}


@pytest.mark.parametrize(
    ("pose", "said"),
    [
        ("0.1, 0.1, -0.2", ["joints 1 and 2 of the policy have 0.1 rad here, and an offset of 0.4 rad"]),
        (
            "0.1, 0.2, -0.2",
            [
                "joint 1 of the policy has 0.1 rad here, and an offset of 0.4 rad",
                "joint 2 of the policy has 0.2 rad here, and an offset of 0.4 rad",
            ],
        ),
    ],
)
def test_joints_with_the_same_two_positions_are_one_slip(pose: str, said: list[str]) -> None:
    """A left and a right one are written together; others have slips of their own."""
    text = DEPLOY.replace("offset: [0.3, 0.1", "offset: [0.4, 0.4").replace(
        "pos: [0.3, 0.1, -0.2", f"pos: [{pose}"
    )
    found = [note.message.partition(" in Joint")[0] for note in config_of(NAMES + text).notes]
    assert found == said


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "[1.0, 2.0, 0.0, 3.0]",
            "[1.0, 2.0, 3.0]",
            "DEPLOY001 [warning] damping: it has 3 values for 4 joints",
        ),
        (
            "pos: [0.3, 0.1",
            "pos: [0.1",
            "DEPLOY001 [warning] default_joint_pos: it has 2 values for 3 joints",
        ),
        (
            "stiffness: [10.0",
            "stiffness: [1O.0",
            "DEPLOY003 [warning] stiffness: entry 1 has 1O.0, which is no number as YAML reads it: it is not judged",
        ),
        (
            "offset: [0.3, 0.1",
            "offset: [0.3, 0.4",
            "DEPLOY007 [warning] default_joint_pos: joint 2 of the policy has 0.1 rad here, and an offset of 0.4 rad "
            "in JointPositionAction, which has the default positions of the others",
        ),
        (
            "map: [3, 0, 1]",
            "map: [3, 0, 0]",
            "DEPLOY008 [warning] joint_ids_map: joints 2 and 3 of the policy have motor 0",
        ),
        (
            "map: [3, 0, 1]",
            "map: [3, 0, 4]",
            "DEPLOY008 [warning] joint_ids_map: joint 3 of the policy has motor 4, and the gains are of motors 0 to 3",
        ),
        (
            "map: [3, 0, 1]",
            "map: [3, 0, -1]",
            "DEPLOY008 [warning] joint_ids_map: joint 3 of the policy has motor -1, and the gains are of motors 0 to 3",
        ),
    ],
)
def test_lists_that_contradict_each_other(old: str, new: str, said: str) -> None:
    """What is not taken as it is written is said; the rest is read."""
    config = config_of(NAMES + DEPLOY.replace(old, new))
    (note,) = config.notes
    assert f"{note.code} [{note.severity.value}] {note.where}: {note.message}" == said
    left = {field for group in config.groups for field in group.settings}
    assert len(config.groups) == 3 and left >= ({"kp", "kd"} if "DEPLOY001" not in said else {"kp"})


def test_a_motor_twice(run: Path) -> None:
    """The gains are by motor and are compared, also of the one that no joint has; the pose of the other two is not."""
    text = DEPLOY.replace("map: [3, 0, 1]", "map: [3, 0, 2, 0]").replace("0.1, -0.2]", "0.1, -0.2, 9.0]")
    config = config_of(NAMES.replace("''", "toe") + text)
    (note,) = config.notes
    assert note.message == "joints 2 and 4 of the policy have motor 0; none has motor 1"
    assert note.span is not None and (note.span.line, note.span.column) == (2, 26)
    found = {group.name: set(group.settings) for group in config.groups}
    both, pose = {"kp", "kd"}, {"kp", "kd", "default_position"}
    assert found == {"hip": both, "knee": both, "toe": pose, "foot": pose}
    (run / "deploy.yaml").write_text(
        DEPLOY.replace("[3, 0, 1]", "[3, 0, 0]").replace("20.0, 0.0", "200.0, 0.0")
    )
    files = [str(run / "env.yaml"), str(run / "deploy.yaml")]
    assert set(told(*files)) == {("AUD022", "", None, None), ("SRC103", "knee", 200.0, 20.0)}


@pytest.mark.parametrize("numbers", ["[0, 3, 4]", "[3, 4, 5]", "[3, 0, 0.5]", "[]", "5"])
def test_a_map_that_is_none(numbers: str) -> None:
    """The lists are then without names, as any; gaps that ascend are of gains in the policy's order."""
    config = config_of(DEPLOY.replace("[3, 0, 1]", numbers))
    assert config.motors is None and "joint_names: [...]" in (config.notes[0].help or "")


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a run, with both of its files."""
    monkeypatch.chdir(tmp_path)
    Path("run/params").mkdir(parents=True)
    Path("run/params/env.yaml").write_text(RUN)
    Path("run/params/deploy.yaml").write_text(DEPLOY)
    return Path("run/params")


def told(*paths: str, as_named: bool = False) -> list[tuple[str, str | None, float | None, float | None]]:
    report = audit(list(paths), Settings(select=("SRC", "DEPLOY"), as_named=as_named))
    findings = [one.finding for one in report.findings]
    return [(one.code, one.joint, one.value, one.expected) for one in findings]


def test_the_pair_of_a_run_agrees(run: Path) -> None:
    """Its run names the motors; nothing departs, and no list is told to be without names."""
    report = audit([str(run / "env.yaml"), str(run / "deploy.yaml")], Settings())
    assert [len(robot.artifacts) for robot in report.case.robots] == [2]
    assert not [item for item in report.diagnostics() if item.code in ("DEPLOY002", "AUD015")]
    assert told("run") == told(str(run / "env.yaml"), str(run / "deploy.yaml")) == []


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [
        ("20.0, 0.0", "200.0, 0.0", ("SRC103", "knee", 200.0, 20.0)),
        ("scale: [0.5", "scale: [5.0", ("SRC106", "foot", 5.0, 0.5)),
        ("[0.3, 0.1, -0.2]", "[0.3, -0.1, -0.2]", ("SRC106", "hip", -0.1, 0.1)),
        ("step_dt: 0.02", "step_dt: 0.005", ("SRC107", "", 0.005, 0.02)),
    ],
)
def test_what_departs_from_the_run(
    old: str, new: str, found: tuple[str, str, float, float], run: Path
) -> None:
    """A figure of one joint, by the order of its own list; the step of the policy needs no names."""
    (run / "deploy.yaml").write_text(DEPLOY.replace(old, new))
    assert told(str(run / "env.yaml"), str(run / "deploy.yaml")) == [found]
    assert told("run") == [found]


def test_two_runs(run: Path) -> None:
    """Each deploy file is held to what its own run recorded, in any order: what is right of the other is wrong here."""
    Path("two/params").mkdir(parents=True)
    Path("two/params/env.yaml").write_text(
        RUN.replace("hip: 0.1", "hip: 0.4").replace("dt: 0.005", "dt: 0.01")
    )
    later = DEPLOY.replace("[0.3, 0.1, -0.2]", "[0.3, 0.4, -0.2]").replace("step_dt: 0.02", "step_dt: 0.04")
    files = [f"{name}/params/{file}.yaml" for name in ("run", "two") for file in ("env", "deploy")]
    Path(files[3]).write_text(later)
    for names in (files, files[::-1], ["run", "two"]):
        assert told(*names) == []
    Path(files[3]).write_text(later.replace("20.0, 0.0", "200.0, 0.0").replace("0.4,", "0.1,"))
    (run / "deploy.yaml").write_text(DEPLOY.replace("step_dt: 0.02", "step_dt: 0.04"))
    for names in (files, files[::-1]):
        found = audit(names, Settings(select=("SRC",))).findings
        assert {(one.finding.code, one.finding.value, one.finding.span.path) for one in found} == {
            ("SRC103", 200.0, files[3]),
            ("SRC106", 0.1, files[3]),
            ("SRC107", 0.04, files[1]),
        }
        assert {(one.severity.value, one.finding.related[0].path) for one in found} == {
            ("warning", files[2]),
            ("warning", files[0]),
        }


def test_a_file_elsewhere(run: Path) -> None:
    """Named with the run it has its names; in a folder that is not the run's it has none; nor of two robots' orders."""
    Path("robot").mkdir()
    Path("robot/deploy.yaml").write_text(DEPLOY.replace("20.0, 0.0", "200.0, 0.0"))
    departs = [("SRC103", "knee", 200.0, 20.0)]
    assert told(str(run / "env.yaml"), "robot/deploy.yaml") == departs
    assert told(str(run / "env.yaml"), "robot") == []
    other = RUN.replace("[hip, knee, '', foot]", "[knee, hip, '', foot]")
    Path("env.yaml").write_text(other)
    assert told(str(run / "env.yaml"), "env.yaml", "robot/deploy.yaml") == []


CONFIG = """\
from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.assets import ArticulationCfg

def legs(hip, knee):
    return {"legs": IdealPDActuatorCfg(
        joint_names_expr=["hip", "knee", "foot"], effort_limit=23.5,
        stiffness={"hip": hip, "knee": knee, "foot": 30.0}, damping={"hip": hip / 10, "knee": knee / 10, "foot": 3.0},
    )}

class Cfg(ArticulationCfg):
    joint_sdk_names: list = []

UNITREE_GO2_CFG = Cfg(actuators=legs(10.0, 20.0), joint_sdk_names=["hip", "knee", "", "foot"])
UNITREE_B2_CFG = Cfg(actuators=legs(20.0, 10.0), joint_sdk_names=["knee", "hip", "", "foot"])
"""


def test_the_folder_of_its_robot_tells_whose_names_it_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """unitree_rl_lab's own layout, in a folder: the Go2's numbering, and not the B2's, and the Go2's gains."""
    monkeypatch.chdir(tmp_path)
    Path("robots").mkdir()
    Path("robots/unitree.py").write_text(CONFIG)
    for robot, joint in (("go2", "hip"), ("b2", "knee"), ("h1", None)):
        folder = Path(f"deploy/robots/{robot}/config/policy/velocity/v0/params")
        folder.mkdir(parents=True)
        (folder / "deploy.yaml").write_text(DEPLOY)
        assert told(".", as_named=True) == []
        (folder / "deploy.yaml").write_text(DEPLOY.replace("10.0, 20.0", "100.0, 20.0"))
        departs = [("SRC103", joint, 100.0, 10.0)] if joint else []
        assert told(".", as_named=True) == departs
        (folder / "deploy.yaml").unlink()


def test_a_change_is_told_once(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The entry is the joint's, and no number without one any more."""
    files = [str(run / "env.yaml"), str(run / "deploy.yaml")]
    assert main(["lock", *files, "-o", "actspec.lock"]) == 0
    (run / "deploy.yaml").write_text(DEPLOY.replace("20.0, 0.0", "22.0, 0.0"))
    capsys.readouterr()
    assert main(["lock", "--check", "-o", "actspec.lock"]) == 1
    out = capsys.readouterr().out
    assert out.count("20 -> 22") == 1 and "knee" in out and "entry 2 of stiffness" not in out


def test_a_draw_of_the_exporter_is_no_other_pose(run: Path) -> None:
    """Tracking tasks draw the pose within 0.01 rad, and the file has one draw: 0.31 beside 0.3 is at that bound."""
    (run / "deploy.yaml").write_text(DEPLOY.replace("[0.3,", "[0.31,"))
    assert told("run") == []
    (run / "deploy.yaml").write_text(DEPLOY.replace("[0.3,", "[0.312,"))
    assert told("run") == [("SRC106", "foot", 0.312, 0.3)]


VELOCITY = "  JointVelocityAction:\n    joint_names: [foo.*]\n    scale: [5.0]\n    offset: [0.0]\n    joint_ids: [@]\n"
"""The foot is joint 0 of the policy, motor 3."""


@pytest.mark.parametrize(
    ("ids", "names", "said"),
    [
        ("0", NAMES, ()),
        # The map has motor 0, the hip, for joint 1 of the policy.
        (
            "1",
            NAMES,
            (
                "JointVelocityAction.joint_ids: these are the numbers of hip, which its joint_names do not select: the "
                "action goes there",
            ),
        ),
        # Nothing names a joint so: the names are of another robot.
        ("1", NAMES.replace("foot", "sole"), ()),
        ("1", "", ()),
    ],
)
def test_an_action_whose_numbers_are_of_other_joints(ids: str, names: str, said: tuple[str, ...]) -> None:
    reading = read_deploy("deploy.yaml", (names + DEPLOY + VELOCITY.replace("@", ids)).encode())
    told = [item for item in reading.diagnostics if item.code == "DEPLOY010"]
    assert tuple(f"{item.where}: {item.message}" for item in told) == said
    for item in told:
        assert (item.span and item.span.line) == 18
        assert item.help == "the numbers of what joint_names select are 0"


@pytest.mark.parametrize("names", ["", NAMES])
@pytest.mark.parametrize(
    ("ids", "column", "said"),
    [
        # The policy has joints 0 to 2.
        ("0, 99", 20, "99 is no joint's number: those of the policy are 0 to 2"),
        ("-2, 0, 3", 17, "-2, 3 are no joints' numbers: those of the policy are 0 to 2"),
        ("-1", 17, "-1 is no joint's number: those of the policy are 0 to 2"),
    ],
)
def test_an_action_with_a_number_of_no_joint(ids: str, column: int, said: str, names: str) -> None:
    """The number is told, once, and none of the joints that the action is not for."""
    text = VELOCITY.replace("@", ids).replace("[5.0]", str([5.0] * len(ids.split(","))))
    reading = read_deploy("deploy.yaml", (names + DEPLOY + text).encode())
    (told,) = [item for item in reading.diagnostics if item.code == "DEPLOY010"]
    assert (told.where, told.message) == ("JointVelocityAction.joint_ids", said)
    assert told.span is not None
    assert (told.span.line, told.span.column) == (17 + bool(names), column)
    (artifact,) = reading.artifacts
    assert artifact.config is not None
    if names:
        scale = artifact.config.actions[1].scale
        assert scale is not None and scale.value == ({"foot": 5.0} if "0" in ids else {})


def test_an_action_with_a_number_twice() -> None:
    """At the second place of the first; of the scale nobody knows then what is the joint's."""
    text = VELOCITY.replace("@", "0, 0, 1, 0").replace("[5.0]", "[5.0, 6.0, 7.0, 8.0]")
    config = config_of(NAMES + DEPLOY + text)
    said = [note for note in config.notes if note.help == "write the number of each joint once"]
    assert [str(note.span) for note in said] == ["deploy.yaml:18:20"]
    assert said[0].code == "DEPLOY010"
    assert said[0].message == "0 stands more than once, and each number is of a joint of its own"
    assert config.actions[1].joints == ("foot", "hip")
    assert config.actions[1].scale is not None and config.actions[1].scale.value is None


def test_a_pose_is_counted_as_the_policy_counts_its_joints() -> None:
    """The action is of the second and the third joint; the offset of the third is another number than its pose."""
    text = DEPLOY.replace("joint_ids: null", "joint_ids: [1, 2]")
    text = text.replace("[0.5, 0.25, 0.25]", "[0.25, 0.25]").replace(
        "offset: [0.3, 0.1, -0.2]", "offset: [0.1, -0.5]"
    )
    (note,) = config_of(NAMES + text).notes
    assert note.code == "DEPLOY007"
    assert note.message.startswith("joint 3 of the policy has -0.2 rad here, and an offset of -0.5 rad")


def test_an_action_of_other_joints_by_the_names_of_a_run(tmp_path: Path) -> None:
    """It is told where the run beside the file names the motors, once, and fails the run."""
    (tmp_path / "deploy.yaml").write_text(DEPLOY + VELOCITY.replace("@", "2"))
    (tmp_path / "env.yaml").write_text(RUN)
    report = audit([str(tmp_path / "deploy.yaml"), str(tmp_path / "env.yaml")], Settings())
    told = [one.finding for one in report.findings if one.finding.code == "AUD022"]
    assert [one.message for one in told] == [
        "JointVelocityAction.joint_ids: these are the numbers of knee, which its joint_names do not select: the action "
        "goes there (DEPLOY010)"
    ]
