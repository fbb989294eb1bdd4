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
        "joints:\n  0: {kp: 20, kd: 1}\n  1: {kp: 40, kd: 2}\n  2: {kp: 20, kd: 1}\n",
        "joints:\n  - {name: 0, kp: 20, kd: 1}\n  - {name: 1, kp: 40, kd: 2}\n  - {name: 2, kp: 20, kd: 1}\n",
        "kp: {0: 20, 2: 20, 1: 40}\nkd: {0: 1, 1: 2, 2: 1}\n",
    ],
)
@pytest.mark.parametrize("names", ["", "joint_names: [hip, knee, foot]\n"])
def test_figures_by_number_are_a_list(text: str, names: str) -> None:
    """Nobody guesses whose they are, as in a list; with names each is its joint's."""
    reading = read_deploy("walk.yaml", (text + names).encode())
    (config,) = [artifact.config for artifact in reading.artifacts]
    assert config is not None
    if names:
        found = [
            (group.name, group.settings["kp"].value, group.settings["kd"].value) for group in config.groups
        ]
        assert found == [("hip", 20.0, 1.0), ("knee", 40.0, 2.0), ("foot", 20.0, 1.0)]
    else:
        assert config.groups == ()
        assert [one.value for one in config.nameless["kp"]] == [20.0, 40.0, 20.0]
        message = "it is by number, without joint names: which joint a value belongs to is not guessed"
        assert [(note.code, note.where, note.message) for note in reading.diagnostics] == [
            ("DEPLOY002", "kp", message),
            ("DEPLOY002", "kd", message),
        ]


@pytest.mark.parametrize(
    ("names", "figures"),
    [
        ("joints: {0: hip, 1: knee, 2: foot}", "kp: [20, 40, 60]"),
        ("joint_names: {2: foot, 0: hip, 1: knee}", "kp: {0: 20, 2: 60, 1: 40}"),
        ('{"joint_names": {"0": "hip", "1": "knee", "2": "foot"}}', "kp: [20, 40, 60]"),
        ("order: &names {0: hip, 1: knee, 2: foot}", "joint_names: *names\nkp: [20, 40, 60]"),
        ("dof_names: {1: hip, 2: knee, 3: foot}", "kp: [20, 40, 60]"),
        ("joint_names: {3: foot, 2: knee, 1: hip}", "kp: {2: 40, 1: 20, 3: 60}"),
        ("joint_names: [hip, knee, foot]", "kp: {1: 20, 2: 40, 3: 60}"),
    ],
)
def test_names_by_number(names: str, figures: str) -> None:
    """They are the list of names in the order of the numbers, from 0 or 1 on; so are figures from 1 on beside them."""
    if names.startswith("{"):
        names, figures = names[:-1] + ",", '"kp": [20, 40, 60], "kd": [1, 1, 1]}'
    (artifact,) = read_deploy("walk.yaml", f"{names}\n{figures}".encode()).artifacts
    assert artifact.config is not None
    found = {group.name: group.settings["kp"].value for group in artifact.config.groups}
    assert found == {"hip": 20.0, "knee": 40.0, "foot": 60.0}
    assert artifact.config.settings["joint_order"].value == ("hip", "knee", "foot")


@pytest.mark.parametrize(
    "names",
    [
        "{0: hip, 2: knee, 3: foot}",
        "{0: hip, 1: null, 2: foot}",
        "{hip: 0, knee: 1, foot: 2}",
        "{0: hip, 1: knee, 2: foot, ? [3] : toe}",
        "{0: hip, 1: knee, 1: toe, 2: foot}",
    ],
)
def test_names_that_are_not_numbered_in_a_row(names: str) -> None:
    """A gap is a motor that no joint has, for all that is told: whose a value of a list is stays open."""
    reading = read_deploy("walk.yaml", f"joint_names: {names}\nkp: [20, 40, 60]\nkd: [1, 1, 1]".encode())
    assert "DEPLOY002" in [note.code for note in reading.diagnostics]


@pytest.mark.parametrize(("names", "first"), [("{0: hip, 1: knee}", 1), ("{1: hip, 2: knee}", 0)])
def test_names_and_figures_that_are_numbered_from_unlike_ends(names: str, first: int) -> None:
    """Of `{1: hip, 2: knee}` and `{0: 20, 1: 40}` the hip has 20 by the order, and 40 by its number: it stays open."""
    kp, kd = (f"{{{first}: {one}, {first + 1}: {two}}}" for one, two in ((20, 40), (1, 2)))
    reading = read_deploy("walk.yaml", f"joint_names: {names}\nkp: {kp}\nkd: {kd}".encode())
    configs = [artifact.config for artifact in reading.artifacts if artifact.config is not None]
    assert not {"hip", "knee"} & {group.name for config in configs for group in config.groups}


def test_numbers_within_names_are_no_places() -> None:
    """legged_gym's rule: a key is a part of the name."""
    text = b"joint_names: [leg2, leg1]\nkp: {1: 20, 2: 40}\nkd: {1: 1, 2: 2}"
    (artifact,) = read_deploy("walk.yaml", text).artifacts
    assert artifact.config is not None
    found = {group.name: group.settings["kp"].value for group in artifact.config.groups}
    assert found == {"leg2": 40.0, "leg1": 20.0}


def test_joints_that_are_called_by_numbers() -> None:
    """Some robots' joints are called 1, 2, 3."""
    (artifact,) = read_deploy("arm.yaml", b"kp: {1: 20, 2: 40}\nkd: {1: 1, 2: 2}\n").artifacts
    assert artifact.config is not None
    assert [group.name for group in artifact.config.groups] == ["1", "2"]


@pytest.mark.parametrize(
    "text",
    [
        # One joint may be any controller; words without gains are a list of something else.
        "joints:\n  hip: {kp: 20, kd: 1}\n",
        "joints:\n  hip: {kp: 20, kd: 1}\n  knee: {kp: 20}\n  foot: {kp: 20}\n  toe: {id: 3}\n",
        # One joint, of which nobody knows which figures count.
        "joints:\n  - {name: hip, kp: 20, kd: 1}\n  - {name: hip, kp: 40, kd: 2}\n",
        # Modes of a controller, not joints.
        "modes:\n  stand: {kp: 20, kd: 1}\n  walk: {kp: 40, kd: 2}\n",
    ],
)
def test_what_is_no_figures_by_joint(text: str) -> None:
    assert read_deploy("walk.yaml", text.encode()).artifacts == ()


@pytest.mark.parametrize(
    ("text", "said", "hip"),
    [
        # As PyYAML has it.
        (
            "joints:\n  hip: {kp: 20, kd: 1}\n  hip: {kp: 99, kd: 1}\n  knee: {kp: 40, kd: 2}\n",
            "3:3 'hip' stands a second time, with another value than in line 2: PyYAML takes the last one, yaml-cpp "
            "the first",
            99.0,
        ),
        (
            ENTRIES + "  - {name: hip, kp: 99, kd: 1}\n  - {name: foot, kp: 9, kd: 1}\n",
            "4:12 the joint names have 'hip' twice, first at 2:12: which of its figures count is not known",
            None,
        ),
    ],
)
def test_a_joint_twice(text: str, said: str, hip: float | None) -> None:
    """It is told, and the others are read; in a list nobody's figures are taken."""
    reading = read_deploy("walk.yaml", text.encode())
    (told,) = reading.diagnostics
    assert told.code == "DEPLOY004" and told.span is not None
    assert f"{told.span.line}:{told.span.column} {told.message}" == said
    (artifact,) = reading.artifacts
    assert artifact.config is not None
    kp = {group.name: group.settings["kp"].value for group in artifact.config.groups}
    assert kp.get("hip") == hip and kp["knee"] == 40.0


@pytest.mark.parametrize(
    "text",
    [
        "all: &all {kp: 20, kd: 1}\njoints:\n  hip: *all\n  knee: {<<: *all, kp: 40}\n  foot: {<<: *all}\n",
        "legs: &legs\n  hip: {kp: 20, kd: 1}\n  knee: {kp: 9, kd: 1}\n"
        "joints:\n  <<: *legs\n  knee: {kp: 40, kd: 1}\n  foot: {kp: 20, kd: 1}\n",
        "all: &all {kp: 20, kd: 1}\njoints:\n- {<<: *all, name: hip}\n- {<<: *all, name: knee, kp: 40}\n"
        "- {name: foot, <<: *all}\n",
    ],
)
def test_figures_that_are_merged(text: str) -> None:
    """A key of one's own wins, as everywhere in the file."""
    (artifact,) = read_deploy("walk.yaml", text.encode()).artifacts
    assert artifact.config is not None
    found = {
        group.name: tuple(group.settings[name].value for name in ("kp", "kd"))
        for group in artifact.config.groups
    }
    assert found == {"hip": (20.0, 1.0), "knee": (40.0, 1.0), "foot": (20.0, 1.0)}


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
