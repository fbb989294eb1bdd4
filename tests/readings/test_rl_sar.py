"""rl_sar's policies, whose joints' names stand in the base.yaml of their robot."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.settings import Settings
from actspec.readings.artifact import FileReading, RobotConfig
from actspec.readings.dynamics import settings_of
from actspec.readings.read import read_file

BASE = """dog:
  dt: 0.005
  decimation: 4
  fixed_kp: [80, 80, 80, 80]
  fixed_kd: [3, 3, 3, 3]
  torque_limits: [30, 40, 30, 40]
  joint_names: [fl_hip, fl_knee, fr_hip, fr_knee]
  joint_mapping: [0, 1, 2, 3]
"""

POLICY = """dog/robot_lab:
  rl_kp: [20, 25, 20, 25]
  rl_kd: [0.5, 0.6, 0.5, 0.6]
  decimation: 2
"""

CFG = """
from isaaclab.actuators import ImplicitActuatorCfg
from isaaclab.assets import ArticulationCfg

DOG_CFG = ArticulationCfg(
    actuators={
        "hips": ImplicitActuatorCfg(joint_names_expr=[".*_hip"], effort_limit_sim=30.0, stiffness=20.0, damping=0.5),
        "knees": ImplicitActuatorCfg(joint_names_expr=[".*_knee"], effort_limit_sim=40.0, stiffness=25.0, damping=0.6),
    },
)
"""


def _read(
    folder: Path, policy: str, base: str = BASE, path: str = "dog/robot_lab/config.yaml"
) -> FileReading:
    file = folder / path
    file.parent.mkdir(parents=True, exist_ok=True)
    (folder / "dog").mkdir(exist_ok=True)
    (folder / "dog" / "base.yaml").write_text(base)
    file.write_text(policy)
    return read_file(str(file))


def _config(reading: FileReading) -> RobotConfig:
    (artifact,) = reading.artifacts
    assert artifact.config is not None
    return artifact.config


def _gains(config: RobotConfig) -> dict[str, object]:
    return {group.name: group.settings["kp"].value for group in config.groups if "kp" in group.settings}


def test_a_policy_has_what_its_robot_has(tmp_path: Path) -> None:
    """Its own figures count, and those of its robot where it has none, each at its place."""
    reading = _read(tmp_path, POLICY)
    config = _config(reading)
    assert _gains(config) == {"fl_hip": 20.0, "fl_knee": 25.0, "fr_hip": 20.0, "fr_knee": 25.0}
    own, shared = str(tmp_path / "dog" / "robot_lab" / "config.yaml"), str(tmp_path / "dog" / "base.yaml")
    limit = config.groups[1].settings["effort_limit"]
    assert (limit.value, str(limit.span)) == (40.0, f"{shared}:6:23")
    assert str(config.groups[1].settings["kp"].span) == f"{own}:2:15"
    assert [file.path for file in reading.files] == [own, shared]
    # 5 ms of the robot, twice of the policy's own.
    assert settings_of(reading.artifacts[0], bare_dt=True)["control_dt"] == 0.01
    assert reading.diagnostics == () and not config.mapped


@pytest.mark.parametrize(
    ("places", "gains", "found"),
    [
        (
            "[2, 3, 0, 1]",
            "[20, 25, 21, 26]",
            {"fr_hip": 20.0, "fr_knee": 25.0, "fl_hip": 21.0, "fl_knee": 26.0},
        ),
        # A policy of the right leg.
        ("[2, 3]", "[20, 25]", {"fr_hip": 20.0, "fr_knee": 25.0}),
    ],
)
def test_the_order_is_the_policys(tmp_path: Path, places: str, gains: str, found: dict[str, float]) -> None:
    figures = "".join(f"  {key}: {gains}\n" for key in ("rl_kp", "rl_kd", "torque_limits"))
    policy = f"dog/robot_lab:\n{figures}  joint_mapping: {places}\n"
    config = _config(_read(tmp_path, policy))
    assert _gains(config) == found and config.mapped
    assert str(config.settings["joint_order"].span).endswith("config.yaml:5:18")


@pytest.mark.parametrize(
    ("policy", "base", "path"),
    [
        # Fewer joints than the robot's, and nobody knows which.
        (
            POLICY.replace("20, 25, 20, 25", "20, 25, 20").replace("0.5, 0.6, 0.5, 0.6", "0.5, 0.6, 0.5"),
            BASE,
            "",
        ),
        # Another robot's, a broken one, and one in another place.
        (POLICY, BASE.replace("dog:", "cat:"), ""),
        (POLICY, BASE.replace("30, 40]", "30, 40"), ""),
        (POLICY, BASE, "dog/robot_lab/walk/config.yaml"),
        (POLICY.replace("dog/robot_lab:", "dog:"), BASE, ""),
    ],
)
def test_names_that_are_not_the_policys(tmp_path: Path, policy: str, base: str, path: str) -> None:
    reading = _read(tmp_path, policy, base, path or "dog/robot_lab/config.yaml")
    assert [note.code for note in reading.diagnostics][:2] == ["DEPLOY002", "DEPLOY002"]
    assert _gains(_config(reading)) == {}


def test_a_policy_two_folders_below(tmp_path: Path) -> None:
    path = "dog/mimic/dance/config.yaml"
    reading = _read(tmp_path, POLICY.replace("dog/robot_lab", "dog/mimic/dance"), path=path)
    assert len(_gains(_config(reading))) == 4


def test_an_author_s_own_policy_moves_some_joints(tmp_path: Path) -> None:
    (note,) = _read(tmp_path, POLICY + "  action_scale: [0.25, 0.5]\n").diagnostics
    assert (note.code, note.severity.value) == ("DEPLOY001", "info")
    assert note.message == "it has 2 values for 4 joint names"


def test_ten_times_the_gain(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each gain of the policy is held to its joint's of the training."""
    monkeypatch.chdir(tmp_path)
    Path("dog_cfg.py").write_text(CFG)
    for text, wanted in (
        (POLICY, []),
        (POLICY.replace("25, 20, 25", "250, 20, 250"), ["fl_knee", "fr_knee"]),
    ):
        _read(Path(), text)
        found = audit(["dog_cfg.py", "dog/robot_lab/config.yaml"], Settings()).findings
        assert [(item.finding.code, item.finding.joint) for item in found] == [
            ("SRC103", knee) for knee in wanted
        ]
