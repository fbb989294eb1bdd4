"""Names of joints in texts of all kinds: what is taken, and what is refused with its cause."""

from __future__ import annotations

import json

import pytest

from actspec.readings.joint_texts import NoNamesError, lists_in, lists_in_notebook, without_beginning

NAMES = ("FL_hip", "FR_hip", "FL_calf", "FR_calf")
HEADED = "2026-11-28 10:00:00 [INFO] [articulation.py:1574] "

JOINT_TABLE = """Simulation parameters for joints in /World/envs/env_.*/Robot:
+------------------------------------------------------------------+
| Simulation Joint Information (Prim path: /World/envs/env_.*/Robot) |
+--------+----------+-------------+--------------------------------+
| Index  | Name     |  Stiffness  |        Position Limits         |
+--------+----------+-------------+--------------------------------+
|   0    | FL_hip   |    0.000    |       [-1.0e+03, 1.000]        |
|   1    | FR_hip   |    0.000    |       [-1.0e+03, 1.000]        |
|   2    | FL_calf  |    0.000    |       [-1.0e+03, 1.000]        |
|   3    | FR_calf  |    0.000    |       [-1.0e+03, 1.000]        |
+--------+----------+-------------+--------------------------------+
"""
"""As prettytable prints what Isaac Lab 2.3.2 gives it in `_log_articulation_info`."""
REWARDS = """[INFO] Reward Manager:  <RewardManager> contains 2 active terms.
+--------------------------------+
|       Active Reward Terms      |
+-------+---------------+--------+
| Index | Name          | Weight |
+-------+---------------+--------+
|   0   | track         |   4    |
|   1   | joint_acc     |   2    |
+-------+---------------+--------+
"""
CHANGED = """
+-------+-----------+--------+----+-----------+--------------------+
| Group |  Property |  Name  | ID | USD Value | ActutatorCfg Value |
+-------+-----------+--------+----+-----------+--------------------+
|  legs | stiffness | FL_hip | 0  |     1     |         2          |
+-------+-----------+--------+----+-----------+--------------------+
"""
OTHER_TABLES = REWARDS + CHANGED
COLLECTIONS = (
    f"{HEADED}Actuator collection: calfs with model 'DCMotor' (type: explicit) and joint names: "
    "['FL_calf', 'FR_calf'] [tensor([2, 3], device='cuda:0')].\n"
    f"{HEADED}Actuator collection: hips with model 'DCMotor' (type: explicit) and joint names: "
    "['FL_hip', 'FR_hip'] [tensor([0, 1], device='cuda:0')].\n"
)
BODIES = f"{HEADED}Body names: ['base', 'FL_hip', 'FR_hip', 'FL_calf', 'FR_calf']\n"


@pytest.mark.parametrize(
    "text",
    [
        JOINT_TABLE,
        JOINT_TABLE + OTHER_TABLES,
        OTHER_TABLES + JOINT_TABLE,
        COLLECTIONS,
        f"{BODIES}{HEADED}Number of joints: 4\n{HEADED}Joint names: {[*NAMES]}\n",
        f"[INFO] Action Manager:  <ActionManager> contains 1 active terms.\n[INFO]: joint names: {[*NAMES]}\n",
        f"It is the robot's joint list: {[*NAMES]}\n",
        f"[robot]\nname = 'dog'\njoint_names = {json.dumps(NAMES)}\nfeet = ['FL_foot', 'FR_foot']\n",
        f"{NAMES}\n",
        f"array({[*NAMES]}, dtype='<U8')\n",
        "['FL_hip' 'FR_hip' 'FL_calf'\n 'FR_calf']\n",
        'const std::array<std::string, 4> kJointNames = {\n"FL_hip", "FR_hip",\n"FL_calf", "FR_calf",\n};\n',
        'std::vector<std::string> joints{"FL_hip", "FR_hip", "FL_calf", "FR_calf"};\n',
        "joint_names = [['FL_hip', 'FR_hip'], ['FL_calf', 'FR_calf']]\n",
        "| index | joint | note |\n|---|---|---|\n" + "".join(f"| 0 | `{n}` | |\n" for n in NAMES),
        "+---+\n| Index | Name |\n+---+\n" + "".join(f"| {i} | {n} |\n" for i, n in enumerate(NAMES)),
        "\n".join(NAMES),
    ],
    ids=[
        *("Isaac Lab's table", "before others", "behind others", "groups", "Joint names", "under a remark"),
        *("an apostrophe", "TOML", "tuple", "array", "array without commas", "C", "C++", "nested"),
        *("Markdown", "a table without title", "lines"),
    ],
)
def test_what_is_taken(text: str) -> None:
    """Joints in the robot's order; nothing that is called otherwise."""
    assert lists_in(text) == [NAMES]


@pytest.mark.parametrize(
    "text, message, line",
    [
        ("one\n[INFO] hip\n", "[INFO] is no name of a joint", 2),
        ("(hip\n", "(hip is no name of a joint", 1),
        (".*_hip\n", ".*_hip is a pattern, and names are needed", 1),
        ("hip_[lr]\n", "hip_[lr] is a pattern, and names are needed", 1),
        ("[joints]\nhip = 0\n", "[joints] is no name of a joint", 1),
        ("hip\nknee = 0\n", "0 is a number beside names", 2),
        ("hip\nknee\nhip\n", "hip stands there twice", 3),
        ("joints:\n[hip, knee,\nhip]\n", "hip stands there twice", 3),
        ("[hip, knee, 0]\n", "0 is a number beside names", 1),
        (f"{HEADED}Joint names: ['hip', 'hip']\n", "hip stands there twice", 1),
        ("['a', 'b']\n['c', 'd']\n", "which of its lists has the joints is not told", 0),
        ("hip\0", "is no text", 0),
        (REWARDS, "[INFO] is no name of a joint", 1),
        (CHANGED, "+-------+-----------+--------+----+-----------+--------------------+ is no name of a joint", 2),
        (BODIES, "[INFO] is no name of a joint", 1),
    ],
)  # fmt: skip
def test_what_is_refused(text: str, message: str, line: int) -> None:
    """With the cause, and the line that has it. A robot's bodies, which patterns of joints may match, are no joints."""
    with pytest.raises(NoNamesError) as caught:
        lists_in(text)
    assert (str(caught.value), caught.value.line) == (message, line)


def test_groups_without_their_places() -> None:
    """They are in the order of the groups then; groups of two robots that share a name stay apart."""
    start = "Actuator collection: a and joint names:"
    text = f"{start} ['x', 'y'] [0, 1, 3].\n{start} ['z']"
    assert lists_in(text) == [("x", "y", "z")]
    twice = f"{text} [2].\n{start} ['x']"
    assert lists_in(twice) == [("x", "y"), ("z",), ("x",)]


def test_notebooks() -> None:
    """What was printed counts before the code, whose lists may be of anything."""
    code = ["robot.find_joints(['a', 'b'])\n", "print(robot.joint_names)"]
    stream = {"output_type": "stream", "text": [f"{[*NAMES]}\n"]}
    shown = {"output_type": "execute_result", "data": {"text/plain": [f"{[*NAMES]}"], "image/png": "x"}}
    for output in (stream, shown):
        cells = [
            {"cell_type": "markdown", "source": ["# Dog"]},
            {"cell_type": "code", "source": code, "outputs": [output]},
        ]
        assert lists_in_notebook(json.dumps({"cells": cells}).encode()) == [NAMES]
    code = [f"JOINT_NAMES = {[*NAMES]}\n"]
    cells = [{"cell_type": "code", "source": code, "outputs": []}]
    assert lists_in_notebook(json.dumps({"cells": cells}).encode()) == [NAMES]
    for data in (b"{", b"[]", b'{"cells": 3}', b"[" * 100_000):
        with pytest.raises(NoNamesError, match="is no notebook"):
            lists_in_notebook(data)
    with pytest.raises(NoNamesError, match="no list of joint names is in it"):
        lists_in_notebook(b'{"cells": [{"source": "1 + 1"}]}')


def recording(*heads: str) -> str:
    """A recording with these columns and one row."""
    return ",".join(heads) + "\n" + ",".join("0" * len(heads)) + "\n"


@pytest.mark.parametrize(
    "heads, expected",
    [
        (["t", "q_FL_hip", "q_FR_hip", "dq_FL_hip", "dq_FR_hip", "base_z"], [["FL_hip", "FR_hip"]]),
        (["t", "dof_pos_FL_hip", "dof_pos_FR_hip", "tau_des_FL_hip"], [["FL_hip", "FR_hip"]]),
        (["t", "q_FL_hip", "q_FR_hip", "base_z"], [["q_FL_hip", "q_FR_hip"]]),
        (["pos_x", "pos_y", "vel_x", "vel_y", "q_a", "q_b", "dq_a", "dq_b"], [["x", "y"], ["a", "b"]]),
        (["FL_hip_pos", "FR_hip_pos", "FL_hip_vel", "FR_hip_vel", "base_z"], [["FL_hip", "FR_hip"]]),
        (["__time", "/js/FL_hip/position", "/js/FR_hip/position"], [["/js/FL_hip", "/js/FR_hip"]]),
        (["q_1", "q_2", "dq_1", "dq_2"], [["q_1", "q_2", "dq_1", "dq_2"]]),
        (["q_joint_a1", "q_joint_a2", "dq_joint_a1", "dq_joint_a2"], [["joint_a1", "joint_a2"]]),
        (["joint_a1", "joint_a2"], [["joint_a1", "joint_a2"]]),
    ],
)  # fmt: skip
def test_recordings(heads: list[str], expected: list[list[str]]) -> None:
    """Two signals of the same joints name these; of one signal it may be a part of the names, and stays."""
    assert lists_in(recording(*heads)) == [tuple(names) for names in expected]


@pytest.mark.parametrize(
    "names, bare, cut",
    [
        (["q_hip", "q_knee"], ["hip", "knee"], "the beginning q_"),
        (["dof_pos_hip", "dof_pos_knee"], ["hip", "knee"], "the beginning dof_pos_"),
        (["/World/dog/joints/hip", "/World/dog/joints/knee"], ["hip", "knee"], "the path /World/dog/joints/"),
        (["/World/dog/base/hip", "/World/dog/hip/knee"], ["hip", "knee"], "their paths"),
        (["robot/left/hip", "robot/right/hip"], ["left/hip", "right/hip"], "the path robot/"),
        (["/js/q_hip", "/js/q_knee"], ["hip", "knee"], "the path /js/ and the beginning q_"),
        (["left/hip", "right/hip"], [], ""),
        (["/left/hip", "/right/hip"], [], ""),
        (["q_1", "q_2"], [], ""),
        (["q_hip", "knee"], [], ""),
        (["q_hip", "dq_knee"], [], ""),
        (["joint_hip", "joint_knee"], [], ""),
        (["left_hip", "left_knee"], [], ""),
        (["q_hip"], [], ""),
    ],
)
def test_what_names_share_before_them(names: list[str], bare: list[str], cut: str) -> None:
    """A path or a signal, and no word of a name."""
    assert without_beginning(names) == (bare, cut)
