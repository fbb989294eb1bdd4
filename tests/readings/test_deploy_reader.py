"""The reader of deploy YAML: lists with names, lists without, parts of names; hostile files."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.settings import Settings
from actspec.diagnostics import Span
from actspec.readings.artifact import FileKind, RobotConfig
from actspec.readings.deploy import read_deploy
from actspec.readings.dynamics import settings_of
from actspec.readings.read import read_file


def _read(tmp_path: Path, text: str | bytes) -> tuple[object, dict[str, dict[str, float]], list[str]]:
    """Kind, joint to field to value, and what is said."""
    path = tmp_path / "deploy.yaml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    reading = read_file(str(path))
    found: dict[str, dict[str, float]] = {}
    for artifact in reading.artifacts:
        assert artifact.config is not None
        for group in artifact.config.groups:
            values = {name: setting.value for name, setting in group.settings.items()}
            found[group.name] = {k: v for k, v in values.items() if isinstance(v, float)}
    said = [reading.reason] if reading.reason else [d.message for d in reading.diagnostics]
    return reading.kind, found, said


def test_lists_go_by_the_names(tmp_path: Path) -> None:
    """The n-th value belongs to the n-th name, and each has its own place."""
    text = "joint_names: [knee, hip]\nkps: [60, 25]\nkds:\n  - 1.5\n  - 0.5\n"
    kind, found, said = _read(tmp_path, text)
    assert kind is FileKind.DEPLOY
    assert found == {"knee": {"kp": 60.0, "kd": 1.5}, "hip": {"kp": 25.0, "kd": 0.5}}
    assert said == []
    config = read_file(str(tmp_path / "deploy.yaml")).artifacts[0].config
    assert config is not None
    hip = config.groups[1].settings
    assert (hip["kp"].span.line, hip["kp"].span.column) == (2, 11)
    assert (hip["kd"].span.line, hip["kd"].span.column) == (5, 5)
    assert config.settings["joint_order"].value == ("knee", "hip")


def test_the_policys_period(tmp_path: Path) -> None:
    """Where a file has both, the loop of the drive is another one."""
    path = tmp_path / "deploy.yaml"
    path.write_text("joint_names: [knee, hip]\nkps: [60, 25]\ncontrol_dt: 0.004\npolicy_dt: 0.02\n")
    config = read_file(str(path)).artifacts[0].config
    assert config is not None
    assert (config.settings["control_dt"].value, config.settings["control_dt"].span.line) == (0.02, 4)


UNSAID = "{} s is a step of the policy, of the physics or of the drives: the file does not say of which"


@pytest.mark.parametrize(
    "times, expected",
    [
        ("dt: 0.02", {"control_dt": 0.02}),
        ("dt: 0.01", {"control_dt": 0.01}),
        ("dt: 0.009", {}),
        ("dt: 0.002", {}),
        ("dt: 0.02\npolicy_freq: 100", {}),
        # rl_sar: 5 ms, of which four are 20 ms.
        ("dt: 0.005\ndecimation: 4", {"physics_dt": 0.005, "decimation": 4.0, "control_dt": 0.02}),
        ("dt: 0.02\nphysics_dt: 0.002", {"physics_dt": 0.002, "control_dt": 0.02}),
        ("dt: 0.001\nphysics_dt: 0.002", {"physics_dt": 0.002}),
        ("dt: 0.005\nphysics_dt: 0.002\npolicy_hz: 50", {"physics_dt": 0.002}),
        ("dt: 0.005\ndecimation: 4\npolicy_hz: 50", {"decimation": 4.0}),
        ("dt: 0.002\ncontrol_dt: 0.02", {"control_dt": 0.02}),
        ("dt: 0.002\ndecimation: 10\ncontrol_dt: 0.02", {"decimation": 10.0, "control_dt": 0.02}),
        ("dt: fast", {}),
    ],
)
def test_what_dt_is_a_step_of(times: str, expected: dict[str, float], tmp_path: Path) -> None:
    """What is taken is no entry beside; what is not taken is said, and stays a number that `diff` compares."""
    _, _, said = _read(tmp_path, f"joint_names: [knee, hip]\nkps: [60, 25]\n{times}\n")
    artifact = read_file(str(tmp_path / "deploy.yaml")).artifacts[0]
    assert artifact.config is not None
    assert settings_of(artifact) == expected
    value = times.split()[1]
    taken = "dt" in artifact.config.settings
    assert [line.partition(",")[0] for line in said] == (
        [] if taken or value == "fast" else [UNSAID.format(value).partition(",")[0]]
    )
    assert ("dt" in artifact.config.entries) is (not taken and value != "fast")
    assert "dt" not in artifact.config.others or value == "fast"


TRAINED = """from legged_gym.envs.base.legged_robot_config import LeggedRobotCfg
class DogCfg(LeggedRobotCfg):
    class control(LeggedRobotCfg.control):
        stiffness = {"hip": 60.0, "knee": 25.0}
        damping = {"hip": 2.0, "knee": 2.0}
        decimation = 4
    class sim(LeggedRobotCfg.sim):
        dt = 0.005
"""


def test_a_dt_is_held_to_training_where_its_file_was_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """10 ms beside 4 x 5 ms; in a folder that is audited as strangers' are, `dt` is taken for nothing."""
    monkeypatch.chdir(tmp_path)
    Path("dog_cfg.py").write_text(TRAINED)
    Path("dog_deploy.yaml").write_text("joint_names: [knee, hip]\nkps: [25, 60]\ndt: 0.01\n")
    for named, count in ((["dog_cfg.py", "dog_deploy.yaml"], 1), (["."], 0)):
        found = audit(named, Settings()).findings
        assert sum(item.finding.code == "SRC107" for item in found) == count


def test_nobody_is_asked_about_a_file_that_was_met(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The remark is for who named the file."""
    _read(tmp_path, "joint_names: [knee, hip]\nkps: [60, 25]\ndt: 0.002\n")
    monkeypatch.chdir(tmp_path)
    for named, count in (("deploy.yaml", 1), (".", 0)):
        told = audit([named], Settings()).for_people()
        assert [item.code for item in told if item.code == "DEPLOY005"] == ["DEPLOY005"] * count


def test_lists_in_the_policys_order(tmp_path: Path) -> None:
    """rl_sar: the third value of a list is of the joint in place joint_mapping[2] = 1 among the names."""
    text = "joint_names: [hip, knee, ankle]\nrl_kp: [60, 25, 10]\njoint_mapping: [2, 0, 1]\n"
    _, found, said = _read(tmp_path, text)
    assert {joint: values["kp"] for joint, values in found.items()} == {
        "ankle": 60.0,
        "hip": 25.0,
        "knee": 10.0,
    }
    assert said == []
    # Neither is an order of these three.
    for mapping in ("[2, 0, 0]", "[1, 0]"):
        _, found, _ = _read(tmp_path, text.replace("[2, 0, 1]", mapping))
        assert {joint: values["kp"] for joint, values in found.items()} == {
            "hip": 60.0,
            "knee": 25.0,
            "ankle": 10.0,
        }


@pytest.mark.parametrize(
    ("line", "reordered"),
    [
        ("sdk: [ankle, hip, knee]", True),
        ("sdk: [ankle, hip, knee, toe]", True),
        ("sdk: [hip, knee, ankle]", False),
        ("sdk: [toe, hip, knee]", False),
        ("sdk: [2, 0, 1]", True),
        ("sdk: [2, -1, 1]", True),
        ("sdk: [1, 2, 3]", False),
        ("sdk: [1, -1, 1]", False),
        ("sdk: {hip: 3, ankle: 2, knee: 1}", True),
        ("sdk: [{name: hip, id: 2}, {name: knee, id: 1}, {name: ankle, id: 0}]", True),
        ("sdk: [{name: hip, kd: 2}, {name: knee, kd: 1}, {name: ankle, kd: 3}]", False),
        ("sdk: {0: knee, 1: hip, 2: ankle}", True),
        ("kd: [2, 1, 3]", False),
        # The lists are in the policy's order by it, and nothing else is in another.
        ("joint_mapping: [2, 0, 1]", False),
        (f"sdk: [{'9' * 5000}, 1, 0]", False),
    ],
)
def test_a_file_with_another_order_of_its_joints(tmp_path: Path, line: str, reordered: bool) -> None:
    """Most of the names, or places of all, in a row that is not the list's."""
    path = tmp_path / "deploy.yaml"
    path.write_text(f"joint_names: [hip, knee, ankle]\nkp: [60, 25, 10]\n{line}\n", encoding="utf-8")
    (artifact,) = read_file(str(path)).artifacts
    assert artifact.config is not None and artifact.config.reordered is reordered


RL_SAR = """
dog:
  joint_names: [fl_hip, fl_knee, fr_hip, fr_knee]
  rl_kp: [25, 25, 25, 25]
  rl_kd: [0.5, 0.5, 0.5, 0.5]
  fixed_kp: [80, 30, 80, 30]
  fixed_kd: [3, 3, 3, 3]
  torque_limits: [30, 30, 30, 30]
  default_dof_pos: [0, 1.5, 0, 1.5]
"""


def test_the_policys_gains_are_not_those_of_standing_up(tmp_path: Path) -> None:
    """rl_sar: RLControl sends rl_kp and rl_kd always, Interpolate fixed_kp and fixed_kd where it gets up."""
    _, found, said = _read(tmp_path, RL_SAR)
    for joint, pose in (("fl_hip", 0.0), ("fl_knee", 1.5), ("fr_hip", 0.0), ("fr_knee", 1.5)):
        assert found[joint] == {"kp": 25.0, "kd": 0.5, "effort_limit": 30.0, "default_position": pose}
    assert said == []
    # Its base.yaml has limits and pose of the robot, and no policy.
    alone = "".join(line for line in RL_SAR.splitlines(keepends=True) if "rl_k" not in line)
    _, found, said = _read(tmp_path, alone)
    assert found["fl_knee"] == {"effort_limit": 30.0, "default_position": 1.5}
    assert said == [
        "these are the gains of getting up and lying down (rl_sar), and those of the policy (rl_kp, rl_kd) are not "
        "here: they are compared with nothing"
    ]
    # An author's own keys beside them are no choice between two: fixed_kp is none.
    _, found, said = _read(
        tmp_path, "joint_names: [hip, knee]\nfixed_kp: [80, 30]\nfixed_kd: [3, 3]\nkp_walk: [25, 25]\n"
    )
    assert found == {}
    assert said == [
        "its fixed_kp is of getting up and lying down, and the policy's gains (rl_kp, rl_kd) are not here"
    ]


@pytest.mark.parametrize("policy", [True, False])
@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("[80, 30, 80, 30]", "[80, 30, 80]", "DEPLOY001 fixed_kp: it has 3 values for 4 joint names"),
        (
            "[3, 3, 3, 3]",
            "[3, abc, 3, 3]",
            "DEPLOY003 fixed_kd: fl_knee has abc, which is no number as YAML reads it: it is not judged",
        ),
        ("[3, 3, 3, 3]", "3", ""),
    ],
)
def test_gains_of_standing_up_that_are_none(
    old: str, new: str, told: str, policy: bool, tmp_path: Path
) -> None:
    """They are told as any list is, beside the policy's gains or alone; nothing of them is a figure of a joint."""
    lines = [line for line in RL_SAR.splitlines() if policy or "rl_k" not in line]
    path = tmp_path / "base.yaml"
    path.write_text("\n".join(lines).replace(old, new))
    reading = read_file(str(path))
    assert [f"{one.code} {one.where}: {one.message}" for one in reading.not_taken] == [told] * bool(told)
    (artifact,) = reading.artifacts
    assert artifact.config is not None and len(artifact.config.groups) == 4
    assert all(("kp" in group.settings) == policy for group in artifact.config.groups)


STANDING_CFG = """
from isaaclab.actuators import ImplicitActuatorCfg
from isaaclab.assets import ArticulationCfg

DOG_CFG = ArticulationCfg(
    init_state=ArticulationCfg.InitialStateCfg(joint_pos={".*_hip": 0.0, ".*_knee": 1.6}),
    actuators={
        "legs": ImplicitActuatorCfg(
            joint_names_expr=["fl_hip", "fr_hip", "fl_knee", "fr_knee"],
            effort_limit_sim=30.0, velocity_limit_sim=20.0, stiffness=25.0, damping=0.5,
        ),
    },
)
"""


def test_standing_up_is_held_to_no_training(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """kp 250 of the policy is ten times the training's, whatever fixed_kp is; a pose beside it alone is of standing."""
    monkeypatch.chdir(tmp_path)
    Path("dog_cfg.py").write_text(STANDING_CFG)
    alone = "".join(line for line in RL_SAR.splitlines(keepends=True) if "rl_k" not in line)
    texts = {
        RL_SAR.replace("1.5", "1.6"): [],
        RL_SAR.replace("1.5", "1.6").replace("rl_kp: [25, 25, 25, 25]", "rl_kp: [250, 250, 250, 250]"): [
            ("SRC103", "10 times")
        ],
        alone: [],
        alone.replace("[30, 30, 30, 30]", "[60, 60, 60, 60]"): [("SRC101", "60 N*m")],
    }
    for text, wanted in texts.items():
        Path("dog_deploy.yaml").write_text(text)
        found = audit(["dog_cfg.py", "dog_deploy.yaml"], Settings()).findings
        assert {item.finding.code for item in found} == {code for code, _ in wanted}
        assert all(times in found[0].finding.message for _, times in wanted)
    # The same pose of a policy's own file is another command.
    Path("dog_deploy.yaml").write_text(RL_SAR)
    assert {item.finding.code for item in audit(["dog_cfg.py", "dog_deploy.yaml"], Settings()).findings} == {
        "SRC106"
    }


def test_a_list_without_names_is_not_guessed(tmp_path: Path) -> None:
    """Unequal values without names are left, equal ones belong to every joint."""
    _, found, said = _read(tmp_path, "kps: [60, 25]\nkds: [2, 2]\n")
    assert found == {".*": {"kd": 2.0}}
    config = read_file(str(tmp_path / "deploy.yaml")).artifacts[0].config
    assert config is not None and config.settings["joint_count"].value == 2.0
    assert said == ["it is a list without joint names: which joint a value belongs to is not guessed"]


def test_a_list_of_another_length_is_told(tmp_path: Path) -> None:
    """Three values for two names are no values."""
    _, found, said = _read(tmp_path, "joint_names: [knee, hip]\nkp: [1, 2, 3]\nkd: [4, 5]\n")
    assert found == {"knee": {"kd": 4.0}, "hip": {"kd": 5.0}}
    assert said == ["it has 3 values for 2 joint names"]


def test_a_list_that_is_too_long_and_of_one_value_is_a_note(tmp_path: Path) -> None:
    """Whichever of its values are read, each joint gets the right one; of a list that is too short one gets none."""
    _, found, said = _read(tmp_path, "joint_names: [knee, hip]\nkp: [80, 80, 80]\nkd: [3]\n")
    assert found == {"knee": {"kp": 80.0}, "hip": {"kp": 80.0}}
    assert said == ["it has 3 values for 2 joint names, all 80", "it has 1 value for 2 joint names"]


def test_a_key_is_a_part_of_the_name(tmp_path: Path) -> None:
    """Names above the block; a key that is no name is part of names, and limits come from beside."""
    text = (
        "robot:\n  dof_names: [l_hip_joint, l_knee_joint]\n  dof_effort_limit_list: [88, 139]\n"
        "  control:\n    stiffness: {hip: 100, knee: 200}\n    damping: {_joint: 5}\n"
    )
    _, found, _ = _read(tmp_path, text)
    assert found == {
        "l_hip_joint": {"kp": 100.0, "kd": 5.0, "effort_limit": 88.0},
        "l_knee_joint": {"kp": 200.0, "kd": 5.0, "effort_limit": 139.0},
    }


def test_numbers_are_those_of_the_robots_yaml(tmp_path: Path) -> None:
    """`010` is eight and `1e3` a word to the YAML reader that deploy code uses; infinity is no gain."""
    _, found, _ = _read(tmp_path, "kp: {a: 010, b: 1e3, c: .inf, d: 1_000, e: true}\n")
    assert found == {"a": {"kp": 8.0}, "d": {"kp": 1000.0}}


def test_merges_and_timing(tmp_path: Path) -> None:
    """A merged mapping gives what the block lacks; the timing stands above."""
    timing = "  simulation_dt: 0.002\n  control_decimation: 10\n"
    text = "base: &b {kd: {hip: 1}}\ng1:\n" + timing + "  gains: {<<: *b, kp: {hip: 9}}\n"
    path = tmp_path / "deploy.yaml"
    path.write_text(text)
    configs = [a.config for a in read_file(str(path)).artifacts]
    by_name = {c.name: c for c in configs if c is not None}
    settings = by_name["g1"].settings
    assert (settings["physics_dt"].value, settings["decimation"].value) == (0.002, 10.0)
    assert {k: s.value for k, s in by_name["g1"].groups[0].settings.items()} == {"kp": 9.0, "kd": 1.0}


def _bomb() -> str:
    lines = ["a0: &a0 [1,1,1,1,1,1,1,1,1]"]
    lines += [f"a{i}: &a{i} [{','.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 12)]
    return "\n".join([*lines, "kp: *a11"])


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("[" * 100_000, "it is nested more than 40 deep"),
        (_bomb(), "it has more than 200000 values"),
        (b"kp: \xff", "it is not UTF-8, byte 0xff"),
        ("kp: [1,\nkd: 2", "it is not YAML"),
        ("", "it has no gains"),
        ("- just\n- words\n", "it has no gains"),
        ("a: &a [*a]\n", "it has no gains"),
    ],
    ids=["deep", "bomb", "not-utf-8", "malformed", "empty", "no-gains", "circle"],
)
def test_hostile_files_give_a_reason(tmp_path: Path, text: str | bytes, reason: str) -> None:
    """Whatever is in the file, the answer is a sentence."""
    _, found, said = _read(tmp_path, text)
    assert found == {}
    assert said[0].startswith(reason) or (reason == "it has no gains" and "40 deep" in said[0])


def test_one_kp_and_one_kd_are_of_all_joints_that_are_named(tmp_path: Path) -> None:
    """The names stand in the block itself: beside a policy's lists such numbers are those of another controller."""
    _, found, said = _read(tmp_path, "joint_names: [hip, knee]\nkp: 10\nkd: 0.5\n")
    assert found == {"hip": {"kp": 10.0, "kd": 0.5}, "knee": {"kp": 10.0, "kd": 0.5}}
    assert said == []


_SINGLE = (
    "its kp is one number, and no list of joint names stands beside kp and kd: write joint_names: [...] there, or kp: "
    "{JOINT: NUMBER, ...}"
)


def test_words_of_the_joints_names_are_of_joints(tmp_path: Path) -> None:
    path = tmp_path / "deploy.yaml"
    path.write_text(f"{_SIDES}kp: {{hips: [9, 9, 9], knees: [8, 8, 8]}}\n")
    assert [one.message for one in read_file(str(path)).not_taken] == [
        "it has lists below hips, knees: which joints they are of is not read"
    ]


@pytest.mark.parametrize(
    "line",
    [
        "default_pos: {stand: [0, 0, 0, 0, 0, 0], sit: [0, -1, 0, 0, -1, 0]}",
        "default_joint_angles: {stand: {left_hip: 0, right_hip: 0}, sit: {left_hip: 1, right_hip: 1}}",
        "torque_limits: {peak: [9, 9, 9, 9, 9, 9], continuous: [4, 4, 4, 4, 4, 4]}",
        "action_scale: {position: [1, 1, 1, 1, 1, 1], wheel: [5, 5, 5, 5, 5, 5]}",
        "default_pos: {left: [0, 0, 0], right: [0, 0, 0]}",
    ],
)
def test_figures_below_words_that_are_no_gains(line: str, tmp_path: Path) -> None:
    """Named poses, kinds of limits and of commands are sound, and nothing is said."""
    path = tmp_path / "deploy.yaml"
    path.write_text(f"{_SIDES}kp: [9, 8, 7, 9, 8, 7]\n{line}\n")
    reading = read_file(str(path))
    assert len(reading.artifacts) == 1 and not reading.not_taken


@pytest.mark.parametrize(
    ("text", "reason", "at"),
    [
        ("kp: 10\nkd: 0.5\n", _SINGLE, (1, 5)),
        ("joint_names: [a, b]\nstand:\n  kp: 400\n  kd: 5\n", _SINGLE, (3, 7)),
        (
            "joint_names: [a, b]\nkp: 400\n",
            "its kp is one number, and no kd stands beside it: write kd there, or kp: {JOINT: NUMBER, ...}",
            (2, 5),
        ),
        ("joints:\n  - {name: a, kp: 10, kd: 0.5}\n", _SINGLE, (2, 19)),
        ("joint_names: [a, b]\nKp: [1, 2]\nKd: [1, 2]\n", "'Kp' is no key that is read: write kp", (2, 5)),
        (
            "actuators:\n  legs:\n    joint_names_expr: ['.*']\n    stiffness: 30.0\n    damping: 1.0\n",
            "its gains are of actuator groups, without the scene, sim and decimation of a run's params/env.yaml: name "
            "that file, or the Python configuration that the run had",
            (4, 16),
        ),
    ],
    ids=["alone", "another block", "kp alone", "a list of joints", "capital", "a run of Isaac Lab"],
)
def test_gains_that_are_not_read_are_told(
    tmp_path: Path, text: str, reason: str, at: tuple[int, int]
) -> None:
    """At their place, and not that there are none."""
    path = tmp_path / "deploy.yaml"
    reading = read_deploy(str(path), text.encode())
    assert (reading.kind, reading.reason, reading.refused) == (None, reason, Span(str(path), *at))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "stiffness: {hip: 20, knee: 20}\ndamping: {hip: 0.5, kneee: 0.5}\n",
            ["it has 'kneee' where stiffness has 'knee': neither has both figures"],
        ),
        (
            "joint_names: [hip, knee]\nkp: {hip: 20, knee: 20}\nkd: {hip: 0.5, knie: 0.5}\n",
            ["it has 'knie', which is no joint of the list"],
        ),
        # Other joints beside, a part of a name, whole names beside parts, patterns.
        ("kp: {hip: 20, knee: 20}\nkd: {hip: 0.5, wheel: 0.5, knee: 0.5}\n", []),
        ("kp: {hip_joint: 20, knee: 20}\nkd: {hip: 0.5, knee: 0.5}\n", []),
        ("kp: {hip: 20}\nkd: {hip: 1}\ndefault_angles: {fl_hip: 0.1, fr_hip: 0.1}\n", []),
        ("kp: {.*_hip_roll: 20, a: 1}\nkd: {.*_hip_rol: 0.5, a: 1}\n", []),
        (
            "joint_names: [fl_hip, fl_knee]\nkp: {hip: 20, fl_knee: 20, rr_knee: 3}\nkd: {hip: 1, knee: 1}\n",
            [],
        ),
    ],
)
def test_a_joint_misspelt_in_one_mapping(tmp_path: Path, text: str, told: list[str]) -> None:
    """Where a slip explains it, and nowhere else."""
    assert _read(tmp_path, text)[2] == told


def test_tags_are_never_acted_upon(tmp_path: Path) -> None:
    """A tag that would run a command with an unsafe loader makes nothing."""
    mark = tmp_path / "made"
    _, found, _ = _read(tmp_path, f"kp: !!python/object/apply:os.mkdir ['{mark}']\nkd: {{hip: 1}}\n")
    assert found == {"hip": {"kd": 1.0}}
    assert not mark.exists()


def test_a_missing_file_is_a_reason(tmp_path: Path) -> None:
    """No traceback for what is not there, or is a folder."""
    assert read_file(str(tmp_path / "none.yaml")).reason == "no such file or directory"
    assert read_file(str(tmp_path)).reason is not None


OWN = """format: "FORMAT"
order: {robot: [hip, knee]}
timing: {physics_dt: 0.005, decimation: 4, control_dt: 0.02}
command: [position, effort]
kp: [25, null]
kd: [0.5, null]
effort_limit: [20, 30]
position_lower: [-1, null]
command_range: {low: [null, -2], high: [null, 3]}
policy_delay: {nominal: [null, 0.005], low: [0.0, 0.005], high: [0.01, 0.005]}
"""


def _config(tmp_path: Path, text: str) -> RobotConfig:
    path = tmp_path / "deploy.yaml"
    path.write_text(text, encoding="utf-8")
    (artifact,) = read_file(str(path)).artifacts
    assert artifact.config is not None
    return artifact.config


def test_a_file_of_our_own(tmp_path: Path) -> None:
    """What only actspec writes is read of its own files: command, clamp, delay, range and timing; null is nothing."""
    config = _config(tmp_path, OWN.replace("FORMAT", "actspec-deploy/1"))
    found = {group.name: {k: v.value for k, v in group.settings.items()} for group in config.groups}
    assert found["hip"] == {
        "kp": 25.0, "kd": 0.5, "effort_limit": 20.0, "command": "position", "position_low": -1.0,
        "delay_low": 0.0, "delay_high": 0.01,
    }  # fmt: skip
    assert found["knee"] == {
        "effort_limit": 30.0, "command": "effort", "command_low": -2.0, "command_high": 3.0,
        "delay": 0.005, "delay_low": 0.005, "delay_high": 0.005,
    }  # fmt: skip
    assert (config.physics_dt, config.settings["decimation"].value) == (0.005, 4)


def test_the_same_keys_of_somebody_else(tmp_path: Path) -> None:
    """Of another's file those keys may mean anything, and are left."""
    config = _config(tmp_path, OWN.replace("FORMAT", "mine"))
    assert {name for group in config.groups for name in group.settings} == {"kp", "kd", "effort_limit"}


@pytest.mark.parametrize(
    ("sdk", "expected"),
    [("[knee, null, hip]", ("knee", None, "hip")), ("null", ()), ("{knee: 0}", ()), ("[hip, [knee]]", ())],
    ids=["gap", "not-stated", "mapping", "nested"],
)
def test_the_sdks_order_of_our_own(tmp_path: Path, sdk: str, expected: tuple[str | None, ...]) -> None:
    """The robot's numbering comes back with its gaps; the lists are in the model's order all the same."""
    text = OWN.replace("FORMAT", "actspec-deploy/1").replace("knee]}", f"knee], sdk: {sdk}}}")
    config = _config(tmp_path, text)
    assert config.settings["sdk_order"].value == expected
    assert config.settings["joint_order"].value == ("hip", "knee")
    assert "sdk_order" not in _config(tmp_path, text.replace("actspec-deploy/1", "mine")).settings


@pytest.mark.parametrize(
    ("kp", "said"),
    [
        ("[.nan, 5]", ["leg.yaml:2:6: kp: hip has .nan, which is no finite number: it is not judged"]),
        ("[.inf, -.inf]", ["leg.yaml:2:6: kp: hip has .inf", "leg.yaml:2:12: kp: knee has -.inf"]),
        (
            "[4, oops]",
            ["leg.yaml:2:9: kp: knee has oops, which is no number as YAML reads it: it is not judged"],
        ),
        ("[4, null]", []),
        ("[left, right]", []),
    ],
)
def test_what_is_no_number(kp: str, said: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is said of each, at its place; a list of words is none of numbers, and null is nobody's figure."""
    monkeypatch.chdir(tmp_path)
    Path("leg.yaml").write_text(f"joint_names: [hip, knee]\nkp: {kp}\nkd: [1, 1]\n")
    report = audit(["leg.yaml"], Settings(select=("SRC103",)))
    found = [f"{item.finding.span}: {item.finding.message}" for item in report.findings]
    assert len(found) == len(said) and all(
        text.startswith(start) for text, start in zip(found, said, strict=True)
    )


def test_a_file_without_gains_of_joints_in_a_folder(tmp_path: Path) -> None:
    """A controller's one kp, or a damping of another thing: told where somebody names the file, no part of a folder."""
    (tmp_path / "dynamics.yaml").write_text("friction: {damping: 1.0}\n", encoding="utf-8")
    (tmp_path / "broken.yaml").write_text("kp: {hip: 20.0, knee: [20.0\n", encoding="utf-8")
    named = read_file(str(tmp_path / "dynamics.yaml"))
    assert named.refused is not None and "its damping is one number" in (named.reason or "")
    found = audit([str(tmp_path)], Settings(as_named=True)).findings
    assert [Path(one.finding.span.path).name for one in found] == ["broken.yaml"]


_TEXT = "which is no number as YAML reads it"
_TWICE = "its kp is one number, and joint_names is no list with each joint's name once"


@pytest.mark.parametrize(
    ("text", "found", "told"),
    [
        ("kp: {hip: 25, knee: 25O}", {"hip": 25.0}, [f"kp: knee has 25O, {_TEXT}"]),
        ('kp: {hip: 25, knee: "25"}', {"hip": 25.0}, [f'kp: knee has "25", {_TEXT}']),
        ("kp: {hip: 25, knee: 25 N*m/rad}", {"hip": 25.0}, [f"kp: knee has 25 N*m/rad, {_TEXT}"]),
        ("kp: {hip: 25, knee: high}", {"hip": 25.0}, [f"kp: knee has high, {_TEXT}"]),
        ("kp: {hip: 25, knee: [25]}", {"hip": 25.0}, [f"kp: knee has a list, {_TEXT}"]),
        ("kp: {hip: 25, knee: .nan}", {"hip": 25.0}, ["kp: knee has .nan, which is no finite number"]),
        ("kp:\n  hip: 25\n  knee:\n", {"hip": 25.0}, ["kp: knee has no value"]),
        # Nobody's figure, a mapping of another level.
        ("kp: {hip: 25, knee: null, ankle: ~, toe: unknown, arm: {elbow: 3}}", {"hip": 25.0}, []),
        # Isaac Gym: what is drawn by which rule.
        ("kp: {range: [0.5, 1.5], operation: scaling, distribution: uniform, schedule_steps: 3}", {}, []),
        # Two numbers and a word.
        ("kp: {mode: rel, scale: 0.8, min: 1.0}", {"scale": 0.8, "min": 1.0}, []),
        ("joint_names: [hip]\nkp: 25\nkd: 1, 5", {"hip": 25.0}, [f"kd: it has 1, 5, {_TEXT}"]),
        (
            "joint_names: [hip]\nkp: [25]\nkd: [1]\ntorque_limit: 23.7 N*m",
            {"hip": 25.0},
            [f"torque_limit: it has 23.7 N*m, {_TEXT}"],
        ),
        ("joint_names: [hip]\nkp: [25]\nkd: ${gains.kd}", {"hip": 25.0}, []),
        ("joint_names: [hip]\nkp: [25]\nkd:", {"hip": 25.0}, ["kd: it has no value"]),
        ("joint_names: [hip]\nkp: [25]\nkd: null", {"hip": 25.0}, []),
        ("kp: {hip: 25}\ntorque_limits: {mode: soft}\nkd:", {"hip": 25.0}, ["kd: it has no value"]),
    ],
)
def test_what_is_no_number_in_a_mapping_or_alone(
    text: str, found: dict[str, float], told: list[str], tmp_path: Path
) -> None:
    """It is said as of a list's entry, with the joint; what is read beside it stays."""
    path = tmp_path / "deploy.yaml"
    path.write_text(text)
    reading = read_file(str(path))
    config = reading.artifacts[0].config
    assert config is not None
    kp = {group.name: group.settings["kp"].value for group in config.groups if "kp" in group.settings}
    assert {joint: value for joint, value in kp.items() if joint != "schedule_steps"} == found
    said = [f"{one.where}: {one.message}" for one in reading.not_taken]
    assert said == [f"{one}: it is not judged" for one in told]


_SIDES = """
joint_names: [left_hip, left_knee, left_foot, right_hip, right_knee, right_foot]
kd: [1, 2, 3, 1, 2, 3]
"""


@pytest.mark.parametrize(
    ("kp", "told"),
    [
        (
            "{left: [9, 8, 7], right: [9, 8, 7]}",
            "lists below left, right: which joints they are of is not read",
        ),
        ("{legs: [9, 8, 7, 9, 8, 7]}", "a list below legs: which joints it is of is not read"),
        (
            "{left: {hip: 9, knee: 8}, right: {hip: 9, knee: 8}}",
            "mappings below left, right: which joints they are of is not read",
        ),
        (
            "{left: {hip: 9, knee: 8}, right: [9, 8, 7]}",
            "lists and mappings below left, right: which joints they are of is not read",
        ),
        (
            "{FL_leg: [9, 8, 7], frontRight: [9, 8, 7]}",
            "lists below FL_leg, frontRight: which joints they are of is not read",
        ),
        # What is drawn, of which two or three numbers and a rule are written; a joint's own schedule.
        ("{low: [9, 8, 7], high: [10, 9, 8]}", ""),
        ("{left: {min: 7, max: 9}, right: {min: 7, max: 9}}", ""),
        ("{range: [0.5, 1.5], operation: scaling}", ""),
        # Phases, poses and limits have figures of all joints, in their order.
        ("{walk: [9, 8, 7, 9, 8, 7], stand: [80, 80, 80, 80, 80, 80]}", ""),
        ("{stand_legs: [9, 8, 7, 9, 8, 7]}", ""),
        ("{peak: [9, 8, 7, 9, 8, 7], continuous: [4, 4, 4, 4, 4, 4]}", ""),
        ("{left: [0.5, 1.5], right: [0.5, 1.5]}", ""),
        ("{left_hip: {early: 9, late: 8}, right_hip: {early: 9, late: 8}}", ""),
    ],
)
def test_gains_by_side(kp: str, told: str, tmp_path: Path) -> None:
    """Lists below words that are no joints are said not to be read, as a text in their place is; ranges are none."""
    path = tmp_path / "deploy.yaml"
    path.write_text(f"{_SIDES}kp: {kp}\n")
    reading = read_file(str(path))
    assert {group.name: group.settings["kd"].value for group in reading.artifacts[0].config.groups} == {
        f"{side}_{part}": value
        for side in ("left", "right")
        for part, value in zip(("hip", "knee", "foot"), (1, 2, 3), strict=True)
    }
    said = [
        f"{one.code} {one.span.line}:{one.span.column} {one.where}: {one.message}"
        for one in reading.not_taken
    ]
    assert said == ([f"DEPLOY003 4:5 kp: it has {told}"] if told else [])
    # With no other figure it is why the file cannot be read.
    path.write_text(f"kp: {kp}\n")
    assert not told or read_file(str(path)).reason == f"its kp has {told}"


@pytest.mark.parametrize(
    ("text", "reason", "at"),
    [
        (
            'joint_names: [a, b]\nkp: ["25", "25"]\nkd: ["1", "1"]\n',
            f'kp: a has "25", {_TEXT} (and 3 more)',
            (2, 6),
        ),
        ("joint_names: [a, b]\nkp: 25,0\nkd: 1,0\n", f"kp: it has 25,0, {_TEXT} (and 1 more)", (2, 5)),
        ("joint_names: [a, b]\nkp: [left, right]\nkd: 1,0\n", f"kd: it has 1,0, {_TEXT}", (3, 5)),
        ("joint_names: [a, a]\nkp: 25\nkd: 1\n", _TWICE, (2, 5)),
    ],
)
def test_a_file_with_no_number_says_so(
    text: str, reason: str, at: tuple[int, int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And not that it has no gains, or no list of joint names; in a folder of one's own it counts too."""
    monkeypatch.chdir(tmp_path)
    Path("deploy.yaml").write_text(text)
    reading = read_file("deploy.yaml")
    assert (reading.reason, reading.refused) == (reason, Span("deploy.yaml", *at))
    found = audit(["."], Settings(as_named=True)).findings
    assert [one.finding.code for one in found] == ([] if "a, a" in text else ["AUD008"])


_WALK = "joint_names: [hip, knee]\nkp_walk: [25, 60]\nkd_walk: [1, 2]\n"


@pytest.mark.parametrize(
    "text",
    [
        _WALK,
        _WALK.replace("kp_walk", "motor_kp").replace("kd_walk", "motor_kd"),
        # The names of a mapping's keys need no order.
        "joint_names_sim: [knee, hip]\nkps_rl: {hip: 25, knee: 60}\nkds_rl: {hip: 1, knee: 2}\n",
        # No gains of a joint's position.
        f"{_WALK}kp_range: [0.9, 1.1]\nkd_range: [0.9, 1.1]\nkp_foot: [100, 100]\nkd_foot: [9, 9]\n",
    ],
)
def test_gains_under_keys_of_an_authors_own(text: str, tmp_path: Path) -> None:
    """One kp and one kd beside the names of as many joints are those that run."""
    _, found, said = _read(tmp_path, text)
    assert (found, said) == ({"hip": {"kp": 25.0, "kd": 1.0}, "knee": {"kp": 60.0, "kd": 2.0}}, [])


def test_a_list_of_names_for_another_order_gives_none(tmp_path: Path) -> None:
    """legged_rl_lab, g1_walk.yaml: the gains are in the policy's order, the one list of names in MuJoCo's."""
    _, found, said = _read(tmp_path, _WALK.replace("joint_names", "joint_names_mujoco"))
    assert found == {}
    assert [line.partition(":")[0] for line in said] == ["it is a list without joint names"] * 2
    config = _config(tmp_path, _WALK.replace("joint_names", "joint_names_mujoco").replace("25, 60", "40, 40"))
    assert [(group.name, group.settings["kp"].value) for group in config.groups] == [(".*", 40.0)]
    assert config.settings["joint_count"].value == 2.0


@pytest.mark.parametrize("end", ["bounds", "range", "min"])
def test_gains_between_which_somebody_looks(tmp_path: Path, end: str) -> None:
    """As many of them as joints, and no second set of gains."""
    text = f"joint_names: [hip, knee]\nkp_rl: [25, 60]\nkd_rl: [1, 2]\nkp_{end}: [2, 90]\nkd_{end}: [0, 3]\n"
    assert sorted(group.settings["kp"].value for group in _config(tmp_path, text).groups) == [25.0, 60.0]


@pytest.mark.parametrize(
    ("text", "reason", "told"),
    [
        (
            f"{_WALK}kp_stand: [40, 40]\nkd_stand: [1, 1]\n",
            "it has gains as kp_walk, kp_stand, and does not say which the joints run: write those as kp and kd",
            1,
        ),
        (
            "kp_rl: [1, 2, 3, 4, 5, 6, 7]\nkd_rl: [1, 2, 3, 4, 5, 6, 7]\n",
            "'kp_rl' is no key that is read: write kp",
            0,
        ),
        ("joint_names: [hip, knee]\nKp: [1, 2]\nKd: [1, 2]\n", "'Kp' is no key that is read: write kp", 1),
        # Six are a pose in space as well, a foot is none.
        (
            "kp_rl: [1, 2, 3, 4, 5, 6]\nkd_rl: [1, 2, 3, 4, 5, 6]\n",
            "it has no gains (kp, kps, stiffness, ...): 'kp_rl' is no key that is read",
            0,
        ),
        (
            "joint_names: [hip, knee]\nkp_foot: [1, 2]\nkd_foot: [1, 2]\n",
            "it has no gains (kp, kps, stiffness, ...)",
            0,
        ),
    ],
)
def test_gains_of_several_modes_are_told(
    text: str, reason: str, told: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the file is named, and where its folder is one's own and they are of joints."""
    monkeypatch.chdir(tmp_path)
    Path("deploy.yaml").write_text(text)
    assert read_file("deploy.yaml").reason == reason
    assert len(audit(["."], Settings(as_named=True)).findings) == told


def test_a_scale_by_command_is_no_joints(tmp_path: Path) -> None:
    """legged_rl_lab: a joint called pos is in no model, and the gains would be of none."""
    config = _config(tmp_path, "kp: [40, 40, 40]\nkd: [1, 1, 1]\naction_scale: {pos: 0.25}\n")
    assert [group.name for group in config.groups] == [".*"]
    assert config.others["action_scale.pos"].value == 0.25


_ADMITTANCE = """arm/controller:
  ros__parameters:
    @TYPE@
    joints: [a, b, c, d, e, f]
    @KEY@:
      @NAMES@
      @MASS@
      stiffness: [50, 50, 50, 20, 20, 20]
      damping: [5, 5, 5, 2, 2, 2]
"""


@pytest.mark.parametrize(
    "key, type_of, mass, names, is_read",
    [
        ("admittance", "", "", "", False),
        ("cartesian_impedance", "", "", "", False),
        ("gains", "type: admittance_controller/AdmittanceController", "", "", False),
        ("gains", "", "selected_axes: [true, true, true, false, false, false]", "", False),
        # Of joints: nothing speaks of space, a word of joints, their names beside the figures.
        ("gains", "type: joint_trajectory_controller/JointTrajectoryController", "", "", True),
        ("joint_impedance", "", "", "", True),
        ("impedance", "", "", "", True),
        ("gains", "type: impedance", "", "", True),
        ("gains", "", "mass: [8, 8, 8, 1, 1, 1]", "", True),
        ("impedance", "", "", "joint_names: [a, b, c, d, e, f]", True),
    ],
)
def test_stiffness_along_axes_of_space(
    key: str, type_of: str, mass: str, names: str, is_read: bool, tmp_path: Path
) -> None:
    """ros2_controllers' admittance has a stiffness along x, y, z and about them, and its joints beside it."""
    text = _ADMITTANCE.replace("@KEY@", key).replace("@TYPE@", type_of or "alpha: 0.01")
    text = text.replace("@MASS@", mass or "k: 1").replace("@NAMES@", names or "j: 1")
    kind, found, said = _read(tmp_path, text)
    if is_read:
        assert found["a"] == {"kp": 50.0, "kd": 5.0} and found["f"] == {"kp": 20.0, "kd": 2.0}
    else:
        assert (kind, found) == (None, {})
        assert said == ["it has no gains (kp, kps, stiffness, ...)"]


def test_an_impedance_of_as_many_entries_as_no_pose_has(tmp_path: Path) -> None:
    """A leg's joints may be driven by what their author calls an impedance."""
    text = "joint_names: [a, b, c, d]\nimpedance:\n  kp: [1, 2, 3, 4]\n  kd: [1, 1, 1, 1]\n"
    assert _read(tmp_path, text)[1]["d"] == {"kp": 4.0, "kd": 1.0}


def test_what_hydra_makes_is_no_joint(tmp_path: Path) -> None:
    """`_target_`, `key` and `dim` of an object are no joints; a tensor is its list."""
    node = "\n".join(f"{key}:\n  _target_: obs.Setup\n  key: {key}\n  dim: ${{n}}\n" for key in ("kp", "kd"))
    assert _read(tmp_path, node) == (None, {}, ["it has no gains (kp, kps, stiffness, ...)"])
    tensor = "joint_names: [hip, knee]\n" + "".join(
        f"{key}:\n  _target_: torch.tensor\n  data: {data}\n  device: cpu\n"
        for key, data in (("kp", "[25, 40]"), ("kd", "[0.5, 2]"))
    )
    kind, found, said = _read(tmp_path, tensor)
    assert (kind, said) == (FileKind.DEPLOY, [])
    assert found == {"hip": {"kp": 25.0, "kd": 0.5}, "knee": {"kp": 40.0, "kd": 2.0}}


def test_patterns_in_a_mapping_beside_a_list_of_joints(tmp_path: Path) -> None:
    """A key in full or in part, or an expression that matches all of the name; `.*_hip` is no slip of `left_hips`."""
    path = tmp_path / "deploy.yaml"
    path.write_text(
        "joint_names: [left_hip, right_hip, left_knee]\nkp: {'.*_hip': 20, left_knee: 30}\nkd: {hip: 1, '.*knee': 2}\n"
    )
    reading = read_file(str(path))
    config = reading.artifacts[0].config
    assert config is not None
    gains = {group.name: [group.settings[one].value for one in ("kp", "kd")] for group in config.groups}
    assert gains == {"left_hip": [20.0, 1.0], "right_hip": [20.0, 1.0], "left_knee": [30.0, 2.0]}
    assert not [item for item in reading.diagnostics if item.code.startswith("DEPLOY")]
