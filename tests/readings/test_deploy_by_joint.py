"""Deploy files whose figures stand joint by joint, and those that say whose they are."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.settings import Settings
from actspec.readings.deploy import read_deploy

MAPPING = "joints:\n  hip: {kp: 20, kd: 1, default_pos: 0.1}\n  knee: {kp: 40, kd: 2}\n"
ENTRIES = "joints:\n  - {name: hip, kp: 20, kd: 1, default_pos: 0.1}\n  - {name: knee, kp: 40, kd: 2}\n"


@pytest.mark.parametrize("text", [MAPPING, ENTRIES, ENTRIES.replace("name:", "joint:")])
def test_figures_joint_by_joint(text: str) -> None:
    (artifact,) = read_deploy("walk.yaml", text.encode()).artifacts
    assert artifact.config is not None and artifact.name == "walk"
    found = {
        group.name: {name: (one.value, one.span.line) for name, one in group.settings.items()}
        for group in artifact.config.groups
    }
    assert found == {
        "hip": {"kp": (20.0, 2), "kd": (1.0, 2), "default_position": (0.1, 2)},
        "knee": {"kp": (40.0, 3), "kd": (2.0, 3)},
    }


@pytest.mark.parametrize(
    "text",
    [
        # One joint may be any controller; words without gains are a list of something else.
        "joints:\n  hip: {kp: 20, kd: 1}\n",
        "joints:\n  hip: {kp: 20, kd: 1}\n  knee: {kp: 20}\n  foot: {kp: 20}\n  toe: {id: 3}\n",
        # Which of the two counts is not guessed.
        "joints:\n  - {name: hip, kp: 20, kd: 1}\n  - {name: hip, kp: 40, kd: 2}\n",
        # Modes of a controller, not joints.
        "modes:\n  stand: {kp: 20, kd: 1}\n  walk: {kp: 40, kd: 2}\n",
    ],
)
def test_what_is_no_figures_by_joint(text: str) -> None:
    assert read_deploy("walk.yaml", text.encode()).artifacts == ()


@pytest.mark.parametrize(
    ("line", "name"), [("robot: go2\n", "go2"), ("robot: {name: go2}\n", "walk"), ("robot: 3\n", "walk")]
)
def test_what_a_file_calls_its_robot(line: str, name: str) -> None:
    (artifact,) = read_deploy("walk.yaml", (line + MAPPING).encode()).artifacts
    assert artifact.name == name


def test_two_files_of_one_robot_in_a_folder(tmp_path: Path) -> None:
    """No name of a file shows whose they are, which they say; ten times the kp is told, and nothing of AUD015."""
    joint = '<joint name="{0}"/><geom size="0.1"/></body>'.format
    (tmp_path / "stork.xml").write_text(
        f'<mujoco model="stork"><worldbody><body>{joint("hip")}<body>{joint("knee")}</worldbody><actuator>'
        '<position joint="hip" kp="20" kv="1" forcerange="-9 9"/><position joint="knee" kp="40" kv="2" '
        'forcerange="-9 9"/></actuator></mujoco>'
    )
    (tmp_path / "walk.yaml").write_text("robot: stork\n" + MAPPING)
    (tmp_path / "hop.yaml").write_text("robot: stork\n" + MAPPING)
    report = audit([str(tmp_path)], Settings(as_named=True))
    assert [len(robot.artifacts) for robot in report.case.robots] == [3]
    assert not [item for item in report.problems if item.code == "AUD015"]
