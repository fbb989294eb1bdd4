"""The table of known robots, and which robot a file is."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.known import known_robots
from actspec.audit.settings import Settings
from actspec.cli.main import main
from actspec.diagnostics import Severity
from actspec.report.findings import for_people
from tests.audit.known_table import ROBOTS, TABLE, table


@pytest.mark.slow
def test_the_table_is_what_the_specs_say(request: pytest.FixtureRequest) -> None:
    """`robots/known.json` is made of the resolved specs and of the published limits; `--regen` writes it anew."""
    text = table()
    if request.config.getoption("--regen"):
        TABLE.write_text(text, encoding="utf-8")
    assert TABLE.read_text(encoding="utf-8") == text


@pytest.mark.parametrize(
    ("robot", "variant", "joint", "effort"),
    [
        ("unitree_go2", "", "FL_calf_joint", 45.43),
        ("unitree_h1", "", "torso_joint", 200.0),
        ("unitree_g1", "mode_5", "left_hip_roll_joint", 139.0),
        # robots/limits/legged.yaml: the deprecated revision.
        ("unitree_g1", "mode_2", "left_hip_roll_joint", 88.0),
        ("unitree_g1", "mode_2", "left_knee_joint", 139.0),
        # robots/limits/legged.yaml: the first revision, which Isaac Lab trains.
        ("unitree_g1_first", "", "torso_joint", 88.0),
        ("unitree_g1_first", "", "left_elbow_roll_joint", 21.0),
        ("unitree_g1_first", "", "right_five_joint", 0.7),
        ("unitree_g1", "mode_15", "right_wrist_yaw_joint", 13.4),
        # Its torque-speed line at rest is above the limit of 1.9123 N*m.
        ("so101", "", "gripper", 3.24986),
        ("ur10", "", "wrist_1_joint", 56.0),
        ("franka", "", "joint7", 12.0),
        ("kuka_iiwa14", "", "joint_3", 176.0),
        ("kuka_iiwa", "14", "joint_1", 320.0),
        ("kuka_iiwa", "7", "joint_1", 176.0),
        ("ur3e", "", "wrist_3_joint", 12.0),
        ("kinova_jaco_6", "", "joint_2", 80.0),
        ("unitree_b2", "", "FL_calf_joint", 320.0),
        ("mini_cheetah", "", "FR_hip_joint", 18.0),
        ("pal_tiago", "", "arm_4_joint", 26.0),
        ("pr2", "", "l_wrist_roll_joint", 10.0),
        ("realman_rm65", "", "joint4", 10.0),
        ("realman_rm75", "", "joint4", 30.0),
        ("unitree_r1", "", "left_knee_joint", 60.0),
        ("unitree_r1", "", "head_yaw_joint", 33.0),
        ("unitree_b1", "", "RL_hip_joint", 91.0035),
        ("unitree_b1", "", "RL_calf_joint", 140.0),
        ("fourier_n1", "", "right_knee_pitch_joint", 95.0),
        # 1.5484 N*m behind 7.75.
        ("cyberdog2", "", "FL_calf_joint", 12.0001),
        ("booster_k1", "", "right_knee_pitch_joint", 112.0),
        ("booster_k1_serial", "", "Left_Ankle_Roll", 38.3),
        ("deep_m20", "", "hr_wheel_joint", 21.6),
        ("deep_dr02", "", "waist_y_joint", 363.0),
        ("deep_dr02", "", "right_ankle_x_joint", 50.0),
        ("agibot_x2", "", "left_wrist_yaw_joint", 36.0),
        ("fourier_gr1", "", "left_hip_roll_joint", 84.18),
        ("fourier_gr2", "", "right_ankle_roll_joint", 29.835),
        ("limx_tron2a", "", "knee_R_Joint", 150.0),
        ("limx_tron2b", "", "wrist_roll_L_U_Joint", 15.0),
        ("limx_oli", "", "waist_yaw_joint", 42.0),
        # 12.2 N*m behind 16, and 0.9 behind 50.
        ("agility_cassie", "", "left-knee", 195.2),
        ("agility_cassie_urdf", "", "toe_joint_right", 45.0),
        ("ufactory_lite6", "", "joint6", 20.0),
        ("kinova_gen3_lite", "", "joint_2", 14.0),
        ("kinova_gen3_6", "", "joint_4", 9.0),
        ("techman_tm5", "", "joint_4", 43.0),
        ("techman_tm5_ros1", "", "wrist_1_joint", 43.0),
        ("techman_tm12", "", "joint_3", 157.0),
        ("techman_tm12_ros1", "", "elbow_joint", 157.0),
        ("hans_elfin3", "", "elfin_joint4", 104.0),
        ("hans_elfin5", "", "elfin_joint2", 420.0),
        ("rainbow_rby1", "", "left_arm_6", 8.0),
        ("dexmate_vega", "", "head_j2", 2.5),
        ("galaxea_a1x", "", "arm_joint2", 50.0),
        ("galaxea_r1_pro", "", "right_arm_joint4", 25.0),
    ],
)
def test_figures_of_the_table(robot: str, variant: str, joint: str, effort: float) -> None:
    """Published figures, by hand."""
    (known,) = [known for known in known_robots() if known.name == robot]
    assert known.variants[variant][joint].effort == effort


@pytest.mark.parametrize(
    ("robot", "joint", "efforts"),
    [
        ("ur10e", "wrist_2_joint", {54.0, 56.0}),
        # Both files of the maker have one limit for all joints, 10 and 40 or 33.5.
        ("enactic_openarm", "left_joint6", {7.0, 10.0}),
        ("unitree_laikago", "RL_hip_joint", {20.0, 33.5, 40.0}),
        # Unitree's URDFs, and its table of both.
        ("unitree_h1", "left_elbow_joint", {18.0, 75.0}),
        ("unitree_h1_2", "right_hip_roll_joint", {200.0, 220.0}),
        ("unitree_h1_2", "right_ankle_roll_joint", {40.0, 45.0, 75.0}),
        # Of a limit and a peak each.
        ("aubo_i5", "wrist3_joint", {34.0, 61.0, 102.0}),
        # Booster's URDF, and the motor of its training.
        ("booster_k1", "left_hip_roll_joint", {43.0, 76.0}),
        # AgiBot's models of the X2 of today and before.
        ("agibot_x2", "waist_roll_joint", {36.0, 48.0}),
        ("fourier_gr1", "right_knee_pitch_joint", {135.0, 225.0}),
        # A URDF, and the deploy parameters of two motors.
        ("limx_oli", "left_ankle_pitch_joint", {42.0, 80.0}),
        # The limit of its URDF and that of its guide.
        ("kinova_gen3_6", "joint_5", {9.0, 52.0}),
        # Its files for ROS 1 and ROS 2.
        ("hans_elfin3", "elfin_joint3", {69.0, 200.0}),
        ("hans_elfin5", "elfin_joint6", {34.0, 69.0}),
    ],
)
def test_figures_of_a_maker_s_other_files(robot: str, joint: str, efforts: set[float]) -> None:
    """What a maker states of one joint in several files, by hand."""
    (known,) = [known for known in known_robots() if known.name == robot]
    assert known.efforts(joint) == efforts


def test_every_revision_has_all_joints() -> None:
    """Joints of two revisions are the same, each once."""
    for known in known_robots():
        assert len({frozenset(joints) for joints in known.variants.values()}) == 1, known.name
    assert {known.name: len(known.joints) for known in known_robots()}["unitree_g1"] == 29


@pytest.mark.parametrize("name", ["a1", "anymal_c", "anymal_d", "g1", "go1", "go2", "h1", "so101", "spot"])
def test_our_own_models_are_known_and_right(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Each model that ships is taken for its robot, alone, and has the published limits."""
    path = str(ROBOTS / name / f"{name}.xml")
    assert main(["audit", path, "--select", "KNW101", "--output-format", "json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert (record["findings"], record["skipped"]) == ([], [])


def _arm(name: str, limits: Mapping[str, float]) -> str:
    """A URDF of hinges behind each other, each with its limit."""
    joints = "".join(
        f'<link name="l{n}"/><joint name="{joint}" type="revolute"><parent link="l{n - 1}"/><child link="l{n}"/>'
        f'<limit lower="-1" upper="1" effort="{limit}" velocity="2"/></joint>'
        for n, (joint, limit) in enumerate(limits.items(), 1)
    )
    return f'<robot name="{name}"><link name="l0"/>{joints}</robot>'


def _legs(ankles: tuple[str, ...], more: int) -> str:
    """A URDF of two legs, whose knees have 417 N*m, and so many other joints."""
    names = [
        f"{side}_{joint}_joint"
        for side in ("left", "right")
        for joint in ("hip_pitch", "hip_roll", "hip_yaw", "knee", *ankles)
    ]
    names += [f"tail_{n}" for n in range(more)]
    joints = "".join(
        f'<link name="l{n}"/><joint name="{name}" type="revolute"><parent link="base"/><child link="l{n}"/>'
        f'<limit effort="{417 if "knee" in name else 7}" velocity="9" lower="-1" upper="1"/></joint>'
        for n, name in enumerate(names)
    )
    return f'<robot name="legs"><link name="base"/>{joints}</robot>'


@pytest.mark.parametrize(
    ("name", "ankles", "more", "found"),
    [
        pytest.param("g1_12dof.urdf", ("ankle_pitch", "ankle_roll"), 0, True, id="12 of 29, all known"),
        pytest.param("g1_12dof.urdf", ("ankle_pitch", "ankle_roll"), 1, False, id="12 of 13 known: 0.92"),
        pytest.param(
            "h1_12dof.urdf", ("ankle_pitch", "ankle_roll"), 0, False, id="an H1 has one ankle: 8 of 12"
        ),
        pytest.param("g1_8dof.urdf", (), 0, False, id="8 joints are few"),
    ],
)
def test_legs_of_a_known_robot(
    name: str,
    ankles: tuple[str, ...],
    more: int,
    found: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Ten joints tell, nearly all of them the robot's. 417 is three times a G1's 139, and 1.39 times an H1's 300."""
    monkeypatch.chdir(tmp_path)
    Path(name).write_text(_legs(ankles, more))
    said = audit([name], Settings(select=("KNW101",))).findings
    assert {item.finding.joint for item in said} == (
        {"left_knee_joint", "right_knee_joint"} if found else set()
    )


@pytest.mark.parametrize(
    ("joints", "said"),
    [
        pytest.param(6, {"elbow_joint"}, id="all six, and 8 of a gripper: 6 of 14"),
        pytest.param(5, set(), id="5 of 6 are 0.83, and 5 of 13 not six in ten"),
    ],
)
def test_an_arm_with_a_gripper(
    joints: int, said: set[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is mounted on it does not count where it has all its joints. 300 N*m is twice a UR5e's 150."""
    arm = {
        "elbow": 300,
        "shoulder_pan": 150,
        "shoulder_lift": 150,
        "wrist_1": 28,
        "wrist_2": 28,
        "wrist_3": 28,
    }
    limits = dict(list(arm.items())[:joints]) | {f"finger_{at}": 5 for at in range(8)}
    hinges = "".join(
        f'<link name="{name}"/><joint name="{name}_joint" type="revolute"><parent link="base"/><child link="{name}"/>'
        f'<limit lower="-1" upper="1" effort="{limit}" velocity="2"/></joint>'
        for name, limit in limits.items()
    )
    monkeypatch.chdir(tmp_path)
    Path("ur5e.urdf").write_text(f'<robot name="ur5e"><link name="base"/>{hinges}</robot>')
    found = audit(["ur5e.urdf"], Settings(select=("KNW101",))).findings
    assert {item.finding.joint for item in found} == said


def test_speeds_of_a_description_that_nothing_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A UR5e turns at 180 deg/s = 3.14 rad/s; 6.28 in what a program of the folder loads counts."""
    monkeypatch.chdir(tmp_path)
    names = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
    hinges = "".join(
        f'<link name="{name}"/><joint name="{name}_joint" type="revolute"><parent link="base"/><child link="{name}"/>'
        '<limit lower="-1" upper="1" effort="28" velocity="6.28"/></joint>'
        for name in names
    )
    Path("r").mkdir()
    Path("r/ur5e.urdf").write_text(f'<robot name="ur5e"><link name="base"/>{hinges}</robot>')

    def severities(path: str) -> set[str]:
        return {item.severity.value for item in audit([path], Settings(select=("KNW103",))).findings}

    assert severities("r/ur5e.urdf") == {"warning"}
    assert severities("r") == {"info"}
    Path("r/run.py").write_text("import pybullet\nload('ur5e.urdf')\n")
    assert severities("r") == {"warning"}


@pytest.mark.parametrize(
    ("prefixes", "count", "said"),
    [
        pytest.param(("left_", "arm2/right_"), 7, {"left_joint6", "arm2/right_joint6"}, id="two of them"),
        pytest.param(("a.",), 7, {"a.joint6"}, id="one"),
        pytest.param(("left_", "right_"), 6, set(), id="6 of 7 are 0.86, and less than nine in ten"),
        pytest.param(("left_", "right_"), 8, set(), id="a Panda has no joint8"),
        pytest.param(("left", "right"), 7, set(), id="what runs into the name is no prefix"),
    ],
)
def test_arms_mounted_under_a_name_of_the_file_s_own(
    prefixes: tuple[str, ...], count: int, said: set[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A Panda has 87 N*m at joints 1 to 4 and 12 at 5 to 7: 87 at joint6 is 7.25 times that; wheels are a base's."""
    limits = {
        f"{each}joint{at}": 87 if at in (1, 2, 3, 4, 6) else 12
        for each in prefixes
        for at in range(1, count + 1)
    }
    bodies = "".join(
        f'<body><joint name="{name}" actuatorfrcrange="-{limit} {limit}"/><geom size=".1"/></body>'
        for name, limit in {**limits, "wheel_l": 5, "wheel_r": 5}.items()
    )
    monkeypatch.chdir(tmp_path)
    Path("dual_panda.xml").write_text(
        f'<mujoco model="dual_panda"><worldbody>{bodies}</worldbody><actuator>'
        + "".join(f'<motor joint="{name}"/>' for name in limits)
        + "</actuator></mujoco>"
    )
    found = audit(["dual_panda.xml"], Settings(select=("KNW101",))).findings
    assert {item.finding.joint for item in found} == said


@pytest.mark.parametrize(
    ("name", "joint", "limits", "said"),
    [
        pytest.param("fr3v2", "fr3v2_joint{}", (87,) * 7, {5, 6, 7}, id="87 is 7 times 12 at the wrist"),
        pytest.param("rm65", "joint_{}", (60, 60, 30, 30, 10, 10), {4}, id="30 is 3 times 10"),
        pytest.param(
            "mjx_rm75", "joint{}", (60, 60, 30, 30, 10, 10, 10), set(), id="one joint more: its fourth has 30"
        ),
        pytest.param("rm65", "joint{}", (99,) * 7, set(), id="seven joints are no RM65"),
        pytest.param(
            "tiago", "arm_{}_joint", (43, 39, 17.86, 26, 3, 6.6, 6.6), set(), id="either revision, no torso"
        ),
        pytest.param("tiago", "arm_{}_joint", (43, 43, 43, 26, 3, 6.6, 6.6), {3}, id="43 is 1.65 times 26"),
        pytest.param("tiago_dual", "arm_left_{}_joint", (99,) * 7, set(), id="another robot of that maker"),
        pytest.param("xarm_lite6", "joint{}", (50, 50, 32, 32, 32, 32), {6}, id="32 is 1.6 times 20"),
        pytest.param("tm12x", "joint_{}", (353, 353, 157, 54, 54, 157), {6}, id="157 is 2.9 times 54"),
        pytest.param("tm5s", "joint_{}", (353,) * 6, set(), id="the S series is another robot"),
        pytest.param("elfin5", "elfin_joint{}", (420, 420, 420, 200, 69, 69), {3}, id="420 is 2.1 times 200"),
        pytest.param("elfin5", "elfin_joint{}", (200, 200, 200, 104, 34, 34), set(), id="that of ROS 2"),
        pytest.param("a1x", "arm_joint{}", (27, 50, 50, 14, 14, 14), {3}, id="50 is 1.9 times 27"),
        pytest.param("gen3_lite", "joint_{}", (10, 14, 10, 7, 7, 7), set(), id="a lite"),
        pytest.param("gen3lite", "joint_{}", (10, 14, 10, 7, 7, 14), {6}, id="14 is twice 7"),
        pytest.param("lite", "joint_{}", (99,) * 6, set(), id="a lite of anybody's"),
        pytest.param("gen3", "joint_{}", (10, 14, 10, 7, 7, 7), set(), id="one that is called gen3 alone"),
        pytest.param("gen3", "joint_{}", (39, 105, 39, 9, 52, 9), set(), id="six joints, URDF and guide"),
        pytest.param(
            "gen3", "joint_{}", (39, 130, 39, 9, 9, 63), {2, 6}, id="more than 1.2 times 105 and 52"
        ),
    ],
)
def test_an_arm_by_its_numbered_joints(
    name: str,
    joint: str,
    limits: tuple[float, ...],
    said: set[int],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Published are 87 and 12 N*m of an FR3v2, 60, 30 and 10 of an RM65, 43, 26, 3 and 6.6 of TIAGo."""
    monkeypatch.chdir(tmp_path)
    chain = {joint.format(n): limit for n, limit in enumerate(limits, 1)}
    Path(f"{name}.urdf").write_text(_arm(name, chain))
    found = audit([f"{name}.urdf"], Settings(select=("KNW101",))).findings
    assert {int(re.sub(r"fr3v2|\D", "", item.finding.joint)) for item in found} == said


_LEGS = {"hip_pitch": 1, "hip_roll": 1, "hip_yaw": 1, "knee": 1, "ankle_pitch": 2, "ankle_roll": 3}
_BODY = {"shoulder_pitch": 2, "shoulder_roll": 2, "shoulder_yaw": 3, "elbow": 3, "wrist_yaw": 4}
_WAIST = {"waist_yaw_joint": 1, "waist_pitch_joint": 3, "waist_roll_joint": 3}


def _humanoid(figures: Mapping[int, float]) -> dict[str, float]:
    """Joints by the names that the G1, the X2 and Oli have in common, to limits by their class [N*m]."""
    sides = {
        f"{side}_{joint}_joint": kind
        for side in ("left", "right")
        for joint, kind in {**_LEGS, **_BODY}.items()
    }
    return {joint: figures[kind] for joint, kind in {**sides, **_WAIST}.items()}


@pytest.mark.parametrize(
    ("name", "limits", "said"),
    [
        pytest.param("X2-Ultra", _humanoid({1: 120, 2: 60, 3: 36, 4: 36}), set(), id="an X2"),
        pytest.param(
            "x2_ultra",
            _humanoid({1: 120, 2: 36, 3: 24, 4: 24}) | {"waist_pitch_joint": 48, "waist_roll_joint": 48},
            set(),
            id="an X2 of before",
        ),
        pytest.param(
            "X2-Ultra",
            _humanoid({1: 120, 2: 60, 3: 36, 4: 36}) | {"left_elbow_joint": 60},
            {"left_elbow_joint"},
            id="60 is 1.67 times an X2's 36",
        ),
        pytest.param(
            "HU_D04_01", _humanoid({1: 140, 2: 42, 3: 42, 4: 19}), {"waist_yaw_joint"}, id="140 / 42"
        ),
        pytest.param(
            "HU_D04_01",
            _humanoid({1: 140, 2: 42, 3: 42, 4: 19}) | {"waist_yaw_joint": 42, "left_ankle_roll_joint": 80},
            set(),
            id="two motors at Oli's ankle",
        ),
        pytest.param("HU_D03_03", _humanoid({1: 600, 2: 42, 3: 42, 4: 19}), set(), id="another one of LimX"),
        pytest.param(
            "cassie",
            {
                f"{joint}_{side}": limit
                for side in ("left", "right")
                for joint, limit in {
                    "hip_abduction": 200,
                    "hip_rotation": 112,
                    "hip_flexion": 200,
                    "thigh_joint": 200,
                    "ankle_joint": 200,
                    "toe_joint": 20,
                }.items()
            },
            {"hip_abduction_left", "hip_abduction_right"},
            id="200 is 1.78 times 112.5 and 1.02 times 195.2; the ankle has no motor",
        ),
        pytest.param(
            "M20",
            {
                f"{leg}_{joint}_joint": limit
                for leg in ("fl", "fr", "hl", "hr")
                for joint, limit in {"hipx": 76.4, "hipy": 260, "knee": 21.6, "wheel": 21.6}.items()
            },
            {f"{leg}_knee_joint" for leg in ("fl", "fr", "hl", "hr")},
            id="an M20's wheels' at its knees; 260 is a maker's file",
        ),
        pytest.param(
            "SF_TRON2A",
            {
                f"{joint}_{side}_Joint": limit
                for side in "LR"
                for joint, limit in {
                    "proximal_pitch": 150,
                    "proximal_roll": 200,
                    "proximal_yaw": 60,
                    "knee": 60,
                    "ankle_pitch": 70,
                }.items()
            },
            {"knee_L_Joint", "knee_R_Joint"},
            id="a TRON2A's yaw at its knees; 200 and 70 are LimX's, too",
        ),
        pytest.param(
            "K1_locomotion",
            {
                f"{side}_{joint}": limit
                for side in ("Left", "Right")
                for joint, limit in {
                    "Hip_Pitch": 30,
                    "Hip_Roll": 76,
                    "Hip_Yaw": 20,
                    "Knee_Pitch": 40,
                    "Ankle_Pitch": 68,
                    "Ankle_Roll": 15,
                }.items()
            },
            {"Left_Ankle_Pitch", "Right_Ankle_Pitch"},
            id="68 is 1.78 times 38.3, and a K1's legs are known by either names",
        ),
    ],
)
def test_robots_of_joints_that_others_have(
    name: str, limits: Mapping[str, float], said: set[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Right ones of makers with figures of several files of theirs, and a wrong one; by hand."""
    monkeypatch.chdir(tmp_path)
    Path(f"{name}.urdf").write_text(_arm(name, limits))
    found = audit([f"{name}.urdf"], Settings(select=("KNW101",))).findings
    assert {item.finding.joint for item in found} == said


@pytest.mark.parametrize(
    ("constant", "groups", "robot"),
    [
        pytest.param(
            "GEN3", {"joint_[1-3]": 105, "joint_4": 52, "joint_[56]": 52}, None, id="six joints, as published"
        ),
        pytest.param(
            "GEN3", {"joint_[1-3]": 105, "joint_[4-6]": 70}, "kinova_gen3_6", id="70 is 1.35 times 52"
        ),
        pytest.param("GEN3", {"joint_[1-4]": 105, "joint_[5-7]": 70}, "kinova_gen3", id="of seven joints"),
        pytest.param("GEN3", {"joint_.*": 70}, "kinova_gen3", id="any number of joints: seven"),
        pytest.param("GEN3_LITE", {"joint_.*": 70}, "kinova_gen3_lite", id="of a name with both words"),
        pytest.param("R1_PRO", {"(left|right)_arm_joint.*": 63}, "galaxea_r1_pro", id="63 is 3.5 times 18"),
        pytest.param("R1", {"(left|right)_arm_joint.*": 63}, None, id="without Pro, arms of six joints"),
    ],
)
def test_robots_that_share_a_word(
    constant: str,
    groups: dict[str, int],
    robot: str | None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of those whose names a configuration has it is the one whose joints it has all, then the one with more words."""
    monkeypatch.chdir(tmp_path)
    actuators = ", ".join(
        f"'{n}': ImplicitActuatorCfg(joint_names_expr=['{names}'], effort_limit_sim={limit}.0, "
        "stiffness=80.0, damping=4.0)"
        for n, (names, limit) in enumerate(groups.items())
    )
    Path("arms.py").write_text(
        "from isaaclab.actuators import ImplicitActuatorCfg\n"
        "from isaaclab.assets import ArticulationCfg\n"
        f"{constant}_CFG = ArticulationCfg(actuators={{{actuators}}})\n"
    )
    found = audit(["arms.py"], Settings(select=("KNW101",))).findings
    assert {item.finding.message.partition(" for ")[2].partition(":")[0] for item in found} == (
        {robot} if robot else set()
    )


@pytest.mark.parametrize(
    ("name", "joint", "limits", "said"),
    [
        pytest.param(
            "iiwa14", "joint_a", (300,) * 7, {3, 4, 5, 6, 7}, id="300 is 1.7 times 176 and less than 320"
        ),
        pytest.param(
            "lbr_iiwa_7_r800", "joint_a", (176, 176, 110, 110, 110, 40, 300), {7}, id="size in the name"
        ),
        pytest.param(
            "lbr_iiwa", "iiwa_joint_", (300,) * 7, {3, 4, 5, 6, 7}, id="the larger of two that it may be"
        ),
        pytest.param("iiwa", "joint_", (320, 320, 176, 176, 110, 40, 40), set(), id="one of 14 kg"),
        pytest.param("iiwa", "joint_", (176, 176, 110, 110, 110, 40, 40), set(), id="one of 7 kg"),
        pytest.param("kr6", "joint_a", (300,) * 7, set(), id="another robot of that maker"),
        pytest.param("iiwa", "joint_a", (300,) * 6, set(), id="six joints are no iiwa"),
    ],
)
def test_an_iiwa_by_either_spelling(
    name: str,
    joint: str,
    limits: tuple[int, ...],
    said: set[int],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Published are 320, 176, 110 and 40 N*m of the larger one; `iiwa` alone may be either. From 1.2 times on."""
    monkeypatch.chdir(tmp_path)
    chain = {f"{joint}{n}": limit for n, limit in enumerate(limits, 1)}
    Path(f"{name}.urdf").write_text(_arm(name, chain))
    found = audit([f"{name}.urdf"], Settings(select=("KNW101",))).findings
    assert {int(item.finding.joint[-1]) for item in found} == said


def test_an_iiwa_of_a_configuration(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By its name and its pattern; both sizes have 40 N*m at the wrist, and 300 / 40 is 7.5."""
    monkeypatch.chdir(tmp_path)
    Path("arms.py").write_text(
        "from isaaclab.actuators import ImplicitActuatorCfg\n"
        "from isaaclab.assets import ArticulationCfg\n"
        "IIWA_CFG = ArticulationCfg(actuators={'arm': ImplicitActuatorCfg(\n"
        "    joint_names_expr=['iiwa_joint_.*'], effort_limit_sim=300.0, stiffness=800.0, damping=40.0)})\n"
    )
    (found,) = audit(["arms.py"], Settings(select=("KNW101",))).findings
    assert found.finding.message.startswith(
        "the limit of 300 N*m is 7.5 times what is published for kuka_iiwa: 40 N*m, at joint_6"
    )


@pytest.mark.parametrize(
    ("file", "inside", "said"),
    [
        pytest.param("ur5e.urdf", "ur5e", True, id="by both names"),
        pytest.param("ur5e.urdf", "arm", True, id="inside it is called no robot"),
        pytest.param("ur5e.urdf", "ur10e", False, id="by one name one known robot, by the other another"),
        pytest.param("ur5e_leader.urdf", "ur5e", False, id="a person moves it, and its motors are others"),
        pytest.param("ur5e/urdf/robot.urdf", "ur5e", True, id="its folder says the same"),
        pytest.param("ur10e/urdf/robot.urdf", "ur5e", False, id="its folder is another known robot's"),
        pytest.param(
            "ur10e/urdf/ur5e.urdf", "ur5e", True, id="the file's own name is nearer than the folder's"
        ),
    ],
)
def test_two_names(
    file: str, inside: str, said: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """400 N*m is more than a UR5e's 150 and a UR10e's 330."""
    monkeypatch.chdir(tmp_path)
    names = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
    Path(file).parent.mkdir(parents=True, exist_ok=True)
    Path(file).write_text(_arm(inside, {f"{name}_joint": 400.0 for name in names}))
    assert bool(audit([file], Settings(select=("KNW101",))).findings) == said


@pytest.mark.parametrize(
    ("pose", "said"),
    [
        ("", True),
        ("'.*': 0.0", True),
        ("'joint1': 0.0, 'base_wheel': 0.0", True),
        # A Z1 on a quadruped, by names of its own.
        ("'.*_hip_joint': 0.0, 'arm_joint1': 0.0", False),
    ],
)
def test_one_pattern_for_all_joints(
    pose: str, said: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What `.*` selects is told by the keys of the pose, where it has any. A Z1 has 30 N*m at joint1."""
    monkeypatch.chdir(tmp_path)
    Path("arms.py").write_text(
        "from isaaclab.actuators import ImplicitActuatorCfg\n"
        "from isaaclab.assets import ArticulationCfg\n"
        f"TROTTER_Z1_CFG = ArticulationCfg(init_state=ArticulationCfg.InitialStateCfg(joint_pos={{{pose}}}),\n"
        "    actuators={'all': ImplicitActuatorCfg(\n"
        "    joint_names_expr=['.*'], effort_limit_sim=200.0, stiffness=80.0, damping=4.0)})\n"
    )
    assert bool(audit(["arms.py"], Settings(select=("KNW101",))).findings) == said


@pytest.mark.parametrize(
    ("file", "names", "said"),
    [
        pytest.param(
            "j2n7s300", [f"j2n7s300_joint_{n}" for n in range(1, 8)], True, id="7 of 7, 7 of 10 with fingers"
        ),
        pytest.param("j2n6s300", [f"j2n6s300_joint_{n}" for n in range(1, 7)], True, id="6 of 6, 6 of 9"),
        pytest.param(
            "two_j2n6s200",
            [
                f"left_j2n6s200_{name}_{n}"
                for name, many in (("joint", 7), ("joint_finger", 3))
                for n in range(1, many)
            ],
            True,
            id="fingers of its own count, behind a prefix too",
        ),
        pytest.param("two_xarm6", [f"left_joint{n}" for n in range(1, 7)], True, id="6 of 6 behind a prefix"),
        pytest.param("j2n7s300", [f"j2n7s300_joint_{n}" for n in range(1, 6)], False, id="5 of 7 are 0.71"),
        pytest.param(
            "j2n7s300", [f"j2n7s300_joint_finger_{n}" for n in range(1, 4)], False, id="the hand alone"
        ),
    ],
)
def test_an_arm_without_its_fingers(
    file: str, names: list[str], said: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is mounted on an arm does not make it another one. 40 N*m is a Jaco's third joint's, 32 an xArm6's."""
    monkeypatch.chdir(tmp_path)
    limits = [400 if name.rstrip("_")[-1] == "3" and "finger" not in name else 5 for name in names]
    joints = "".join(
        f'<link name="{name}_link"/><joint name="{name}" type="revolute"><parent link="base"/>'
        f'<child link="{name}_link"/><limit lower="-1" upper="1" effort="{limit}" velocity="0.5"/></joint>'
        for name, limit in zip(names, limits, strict=True)
    )
    Path(f"{file}.urdf").write_text(f'<robot name="{file}"><link name="base"/>{joints}</robot>')
    found = [
        item.finding
        for item in audit([f"{file}.urdf"], Settings(select=("KNW101",))).findings
        if (item.finding.value or 0.0) > 300.0
    ]
    assert [item.joint for item in found] == ([names[2]] if said else [])


def test_a_jaco_of_two_fingers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It has another count of joints than the one of three. 2000 / 2 is 1000, and no 1e+03."""
    monkeypatch.chdir(tmp_path)
    names = (*(f"joint_{n}" for n in range(1, 7)), "joint_finger_1", "joint_finger_2")
    joints = "".join(
        f'<link name="{name}_link"/><joint name="j2n6s200_{name}" type="revolute"><parent link="base"/>'
        f'<child link="{name}_link"/><limit lower="-1" upper="1" effort="{limit}" velocity="9"/></joint>'
        for name, limit in zip(names, (40, 80, 40, 20, 20, 20, 2000, 2000), strict=True)
    )
    Path("j2n6s200.urdf").write_text(f'<robot name="arm"><link name="base"/>{joints}</robot>')
    found = audit(["j2n6s200.urdf"], Settings(select=("KNW101",))).findings
    message = "the limit of 2000 N*m is 1000 times what is published for kinova_jaco_6: 2 N*m"
    assert {item.finding.message for item in found} == {message} and len(found) == 2


@pytest.mark.parametrize(
    ("other", "limits", "named", "severity"),
    [
        ("rex", {"hip": 75, "thigh": 90, "calf": 90}, ["."], "info"),
        # Of the other robot only the hip.
        ("rex", {"hip": 75, "thigh": 90, "calf": 60}, ["."], "warning"),
        # An A1 is known: its limits at a Go2 were forgotten there.
        ("a1", {"hip": 75, "thigh": 90, "calf": 90}, ["."], "warning"),
        ("rex", {"hip": 75, "thigh": 90, "calf": 90}, ["go2.urdf", "go2_cfg.py", "rex.urdf"], "warning"),
    ],
)
def test_motors_of_another_robot(
    other: str,
    limits: dict[str, float],
    named: list[str],
    severity: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A Go2 with the 75 and 90 N*m that somebody's own robot has, in place of 23.7 and 45.43, has them on purpose."""
    monkeypatch.chdir(tmp_path)
    for name, efforts in (("go2", {"hip": 23.7, "thigh": 23.7, "calf": 45.43}), (other, limits)):
        joints = "".join(
            f'<link name="{leg}_{part}"/><joint name="{leg}_{part}_joint" type="revolute"><parent link="base"/>'
            f'<child link="{leg}_{part}"/><limit lower="-1" upper="1" effort="{effort}" velocity="20"/></joint>'
            for leg in ("FL", "FR", "RL", "RR")
            for part, effort in efforts.items()
        )
        Path(f"{name}.urdf").write_text(f'<robot name="{name}"><link name="base"/>{joints}</robot>')
    Path("go2_cfg.py").write_text(
        "from isaaclab.actuators import ImplicitActuatorCfg\nfrom isaaclab.assets import ArticulationCfg\n"
        'LEGS = ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness=25.0, damping=0.5,\n'
        '    effort_limit_sim={".*_hip_joint": 75.0, ".*_thigh_joint": 90.0, ".*_calf_joint": 90.0})\n'
        'GO2_CFG = ArticulationCfg(actuators={"legs": LEGS})\n'
    )
    found = audit(named, Settings(select=("KNW101",))).findings
    mine = [item.severity.value for item in found if item.finding.span.path == "go2_cfg.py"]
    assert mine == [severity] * 12


@pytest.mark.parametrize(
    ("name", "roll", "published"), [("g1_12dof", 88, True), ("g1_12dof", 70, False), ("legs", 88, False)]
)
def test_a_reduction_that_another_variant_has_not(
    name: str, roll: int, published: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """88 N*m is published for the hip roll of a G1 of machine type 2, and 139 for later ones: 139 * 20 = 88 * 31.6.

    70 N*m is published for none.
    """
    monkeypatch.chdir(tmp_path)
    names = [
        f"{side}_{joint}_joint"
        for side in ("left", "right")
        for joint in ("hip_pitch", "hip_roll", "hip_yaw", "knee", "ankle_pitch", "ankle_roll")
    ]
    limits = {name: (roll, 2780 / roll) for name in names if "pitch" in name or "yaw" in name}
    joints = "".join(
        f'<link name="l{n}"/><joint name="{joint}" type="revolute"><parent link="l{n - 1 if n % 6 else "b"}"/>'
        f'<child link="l{n}"/><limit effort="{limits.get(joint, (139, 20))[0]}" lower="-1" upper="1" '
        f'velocity="{limits.get(joint, (139, 20))[1]}"/></joint>'
        for n, joint in enumerate(names)
    )
    Path(f"{name}.urdf").write_text(f'<robot name="legs"><link name="lb"/>{joints}</robot>')
    bodies = "".join(
        f'<body><joint name="{joint}" actuatorfrcrange="-{limit} {limit}"/><geom size="0.1"/>'
        + "</body>" * (6 if n % 6 == 5 else 0)
        for n, joint in enumerate(names)
        for limit in [139 if "knee" in joint or "ankle_roll" in joint else roll]
    )
    Path(f"{name}.xml").write_text(
        f'<mujoco model="legs"><worldbody><body>{bodies}</body></worldbody></mujoco>'
    )
    found = audit([f"{name}.urdf", f"{name}.xml"], Settings(select=("GEA101",))).findings
    assert [item.finding.joint for item in found] == ["left_hip_roll_joint", "right_hip_roll_joint"]
    assert {item.severity for item in found} == {Severity.WARNING}
    said = {"; 88 N*m is published for a variant of unitree_g1" in item.finding.message for item in found}
    assert said == {published}


_UR = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")


def _ur10e(limits: Sequence[float], ending: str) -> str:
    """A UR10e with limits."""
    pairs = list(zip(_UR, limits, strict=True))
    if ending == "py":
        groups = ", ".join(
            f"'{name}': ImplicitActuatorCfg(joint_names_expr=['{name}_joint'], effort_limit_sim={limit}, "
            "stiffness=800.0, damping=40.0)"
            for name, limit in pairs
        )
        return (
            "from isaaclab.actuators import ImplicitActuatorCfg\nfrom isaaclab.assets import ArticulationCfg\n"
            f"UR10E_CFG = ArticulationCfg(actuators={{{groups}}})\n"
        )
    joints = "".join(
        f'<link name="{name}"/><joint name="{name}_joint" type="revolute"><parent link="base"/><child link="{name}"/>'
        f'<limit lower="-1" upper="1" effort="{limit}" velocity="2"/></joint>'
        for name, limit in pairs
    )
    return f'<robot name="ur10e"><link name="base"/>{joints}</robot>'


@pytest.mark.parametrize(
    ("limits", "ending", "severity"),
    [
        pytest.param((495.0, 495.0, 225.0, 84.0, 84.0, 84.0), "py", Severity.INFO, id="all 1.5 times"),
        pytest.param(
            (495.0, 495.0, 225.0, 87.0, 84.0, 81.0), "py", Severity.INFO, id="rounded: 1.55 and 1.45"
        ),
        pytest.param((495.0, 495.0, 270.0, 84.0, 84.0, 84.0), "py", Severity.WARNING, id="one 1.8 times"),
        pytest.param((660.0, 660.0, 300.0, 112.0, 112.0, 112.0), "py", Severity.WARNING, id="all twice"),
        pytest.param((18e3,) * 6, "urdf", Severity.INFO, id="none binds: 54.5 times the largest"),
        pytest.param(
            (18e3,) * 5 + (2600.0,), "urdf", Severity.WARNING, id="one 48 times what is published: 54"
        ),
        pytest.param((330, 330, 150, 54, 54, 166), "urdf", Severity.INFO, id="a model's: 56 times 2.96"),
        pytest.param((330, 330, 150, 54, 54, 170), "urdf", Severity.WARNING, id="a model's: 56 times 3.04"),
        pytest.param((330, 330, 150, 54, 54, 107), "urdf", Severity.WARNING, id="a UR20's wrist has 107"),
        pytest.param((330, 330, 150, 150, 54, 54), "urdf", Severity.WARNING, id="the elbow's own 150"),
    ],
)
def test_limits_that_are_no_motor_s_on_purpose(
    limits: tuple[float, ...],
    ending: str,
    severity: Severity,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A UR10e has 330, 330, 150 and three times 54 or 56 N*m."""
    monkeypatch.chdir(tmp_path)
    Path("arms").mkdir()
    Path(f"arms/ur10e.{ending}").write_text(_ur10e(limits, ending))
    if ending == "urdf":
        Path("arms/train.py").write_text("import isaacgym\nload('ur10e.urdf')\n")
    found = audit(["arms"], Settings(select=("KNW101",))).findings
    assert {one.severity for one in found} == {severity}
    named = audit([f"arms/ur10e.{ending}"], Settings(select=("KNW101",))).findings
    assert {one.severity for one in named} == {Severity.WARNING}


@pytest.mark.parametrize(
    ("beside", "found"),
    [
        ('<position joint="wrist_3_joint" kp="9" forcerange="-54 54"/>', None),
        ('<position joint="wrist_3_joint" kp="9" forcerange="-90 90"/>', 144.0),
        ('<motor joint="wrist_3_joint" forcerange="-54 54"/>', 108.0),
    ],
)
def test_a_servo_beside_a_motor(
    beside: str, found: float | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A program uses one of the two: 54 + 54 N*m are no limit of 108. 54 + 90 are beyond 1.2 times 2 * 56 = 134.4."""
    monkeypatch.chdir(tmp_path)
    bodies = "".join(f'<body><joint name="{name}_joint"/><geom size="0.1"/></body>' for name in _UR)
    motors = "".join(
        f'<motor joint="{name}_joint" forcerange="-{limit} {limit}"/>'
        for name, limit in zip(_UR, (330, 330, 150, 54, 54, 54), strict=True)
    )
    Path("ur10e.xml").write_text(
        f'<mujoco model="ur10e"><worldbody>{bodies}</worldbody><actuator>{motors}{beside}</actuator></mujoco>'
    )
    values = {one.finding.value for one in audit(["ur10e.xml"], Settings(select=("KNW101",))).findings}
    assert values == ({found} if found else set())


_UR3 = [
    f"{name}_joint" for name in ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
]


@pytest.mark.parametrize(
    ("robot", "prefix", "joints", "said"),
    [
        pytest.param("UR3", "ur3_arm_", _UR3, True, id="all six joints in the pose"),
        pytest.param("UR3", "ur3_arm_", _UR3[:5], False, id="one of them is missing"),
        pytest.param("UR3", "right_", _UR3, True, id="a prefix of this file's own"),
        pytest.param("UR3", "right_", _UR3[:5], False, id="the same, and one of them is missing"),
        pytest.param("UR3", "right", _UR3, False, id="what runs into the name is none"),
        pytest.param("Z1", "", [f"joint{number}" for number in range(1, 7)], True, id="joint1 to joint6"),
        pytest.param(
            "Z1", "", [f"joint{number}" for number in range(1, 9)], False, id="two more than a Z1 has"
        ),
    ],
)
def test_an_arm_beside_what_is_mounted_on_it(
    robot: str, prefix: str, joints: list[str], said: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of one pattern beside a gripper's two the pose tells that it is the arm.

    A UR3 has 56 N*m and less, a Z1 60 at joint2 and 30 elsewhere: 300 is too much for each.
    """
    monkeypatch.chdir(tmp_path)
    pose = "".join(f'"{prefix}{name}": 0.1, ' for name in joints)
    group = "ImplicitActuatorCfg(joint_names_expr=[{!r}], effort_limit_sim={}, stiffness=800.0, damping=40.0)"
    Path("arms").mkdir()
    Path(f"arms/{robot.lower()}.py").write_text(
        "from isaaclab.actuators import ImplicitActuatorCfg\n"
        "from isaaclab.assets import ArticulationCfg\n"
        f"{robot}_GRIPPER_CFG = ArticulationCfg(\n"
        f'    init_state=ArticulationCfg.InitialStateCfg(joint_pos={{{pose}"gripper_.*": 0.0}}),\n'
        "    actuators={\n"
        f'        "arm": {group.format(prefix + ".*joint.*", 300.0)},\n'
        f'        "fingers": {group.format("gripper_finger_.*", 20.0)},\n'
        f'        "palm": {group.format("gripper_palm_.*", 20.0)},\n'
        "    },\n"
        ")\n"
    )
    found = audit(["arms"], Settings(select=("KNW101",))).findings
    assert [(one.severity, one.finding.value) for one in found] == [(Severity.WARNING, 300.0)] * said


@pytest.mark.parametrize(
    ("name", "arm", "hand", "value"),
    [
        pytest.param("FRANKA", ["panda_joint[1-7]"], ["panda_finger_joint.*"], 7200.0, id="a Panda"),
        pytest.param("FRANKA", ["panda_joint[1-4]", "panda_joint[5-7]"], [".*_x", ".*_y", ".*_z"], 7200.0),
        pytest.param("FRANKA", ["panda_joint[1-6]"], ["f1"], None, id="six of seven"),
        pytest.param("FRANKA", ["panda_joint[1-8]"], [], None, id="a Panda has no joint8"),
        pytest.param("FRANKA", ["panda_joint[1-7]"], [f"f{n}" for n in range(9)], 7200.0, id="all seven"),
        pytest.param("IIWA", ["iiwa7_joint_[1-7]"], ["index_.*", "thumb_.*"], 7200.0, id="behind a prefix"),
        pytest.param("KINOVA_GEN3", ["joint_[1-7]"], ["finger_joint", ".*_knuckle_joint"], 7200.0),
        pytest.param("XARM6", ["joint[1-7]"], [], None, id="one joint more than an xArm6 has"),
    ],
)
def test_an_arm_of_one_pattern_beside_a_hand(
    name: str,
    arm: list[str],
    hand: list[str],
    value: float | None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A pattern that writes its joints out names each of them. 7200 N*m is beyond any arm's."""
    monkeypatch.chdir(tmp_path)
    group = "ImplicitActuatorCfg(joint_names_expr={!r}, effort_limit_sim={}, stiffness=800.0, damping=40.0)"
    Path("arms.py").write_text(
        "from isaaclab.actuators import ImplicitActuatorCfg\n"
        "from isaaclab.assets import ArticulationCfg\n"
        f"{name}_CFG = ArticulationCfg(actuators={{'arm': {group.format(arm, 7200.0)}, "
        f"'hand': {group.format(hand, 5.0)}}})\n"
    )
    found = audit(["arms.py"], Settings(select=("KNW101",))).findings
    assert {one.finding.value for one in found} == ({value} if value else set())


def test_one_figure_in_two_configurations_of_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One to mend: 60 N*m is 2.14 times the 28 of a UR5e's wrists, at `.*` and at `wrist_.*`."""
    group = "ImplicitActuatorCfg(joint_names_expr=[{}], effort_limit=60.0, stiffness=800.0, damping=40.0)"
    every, upper, wrists = (
        group.format(names) for names in ('".*"', '"shoulder_.*", "elbow_.*"', '"wrist_.*"')
    )
    monkeypatch.chdir(tmp_path)
    Path("ur5e.py").write_text(
        "from isaaclab.actuators import ImplicitActuatorCfg\n"
        "from isaaclab.assets import ArticulationCfg\n"
        f'UR5E_CFG = ArticulationCfg(actuators={{"arm": {every}}})\n'
        f'UR5E_TWO_CFG = ArticulationCfg(actuators={{"arm": {upper}, "wrist": {wrists}}})\n'
    )
    report = audit(["ur5e.py"], Settings(select=("KNW101",)))
    assert len(report.findings) > 1
    (group_of_all,) = for_people(report.findings)
    assert {item.finding.span.line for item in (*group_of_all.members, *group_of_all.alike)} == {3, 4}


@pytest.mark.parametrize(
    ("usd", "legs", "said"),
    [
        ("spot_arm_camera.usd", [".*_hx", ".*_hy", ".*_kn"], True),
        # Knees are in no group: three joints out of four are not all of the robot.
        ("spot_arm_camera.usd", [".*_hx", ".*_hy"], False),
        ("quadruped_arm.usd", [".*_hx", ".*_hy", ".*_kn"], False),
        ("spot_z1.usd", [".*_hx", ".*_hy", ".*_kn"], False),
    ],
    ids=["its file", "without its knees", "another file", "another robot on it"],
)
def test_legs_beside_an_arm(
    usd: str, legs: list[str], said: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of three patterns beside an arm's four the file that is loaded tells that they are Spot's; 100 N*m is 2.22 times
    the 45 of its hips.
    """
    monkeypatch.chdir(tmp_path)
    group = "ImplicitActuatorCfg(joint_names_expr={!r}, effort_limit_sim=100.0, stiffness=80.0, damping=4.0)"
    Path("spots").mkdir()
    Path("spots/locomotion_spot_env_cfg.py").write_text(
        "import isaaclab.sim as sim_utils\n"
        "from isaaclab.actuators import ImplicitActuatorCfg\n"
        "from isaaclab.assets import ArticulationCfg\n"
        "SPOT_ARM_CFG = ArticulationCfg(\n"
        f'    spawn=sim_utils.UsdFileCfg(usd_path="/assets/{usd}"),\n'
        '    init_state=ArticulationCfg.InitialStateCfg(joint_pos={".*_hx": 0.0, ".*_hy": 0.8, ".*_kn": -1.5}),\n'
        "    actuators={\n"
        f'        "legs": {group.format(legs)},\n'
        f'        "arm": {group.format(["arm0_sh.*", "arm0_el.*"])},\n'
        f'        "wrist": {group.format(["arm0_wr.*"])},\n'
        f'        "gripper": {group.format(["arm0_f1x"])},\n'
        "    },\n"
        ")\n"
    )
    found = audit(["spots"], Settings(select=("KNW101",))).findings
    assert {(one.severity, one.finding.expected) for one in found} == (
        {(Severity.WARNING, 45.0)} if said else set()
    )
