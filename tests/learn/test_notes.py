"""What `compile` says of networks: what of the model has changed, and what is counted twice, with its torque."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import pytest

from actspec import api
from actspec.cli.main import main
from actspec.diagnostics import Diagnostic
from actspec.learn.dynamics import dynamics_entries
from tests.learn import pendulums
from tests.network_files import onnx_mlp

NET = pendulums.SPEC.replace(
    "level: ideal_pd, kp: 20 N*m/rad, kd: 0.5 N*m*s/rad", "level: actuator_net, network: {manifest: net.json}"
)
CONVENTIONS: dict[str, Any] = {
    **{"format": "actspec-network/1", "kind": "mlp", "inputs": "position_velocity", "taps": [0, 1]},
    **{"tap_period": "5 ms", "position_scale": 1.0, "velocity_scale": 1.0, "torque_scale": 1.0},
    **{"initial_history": "zero", "joints": ["hip", "arm"]},
    "range": {
        "error": {"low": -0.2, "high": 0.2, "least": -0.3, "most": 0.3},
        "velocity": {"low": -2.5, "high": 2.0, "least": -9.0, "most": 9.0},
    },
}


def written(folder: Path, manifest: dict[str, Any], spec: str = NET, model: str = pendulums.MODEL) -> Path:
    """A spec whose network gives 8 and 12 N*m/rad of the errors of two samples, -0.5 of the velocity."""
    data = onnx_mlp([([[8.0, 12.0, -0.5, 0.0]], [0.0], "")])
    (folder / "net.onnx").write_bytes(data)
    files = {"onnx": {"path": "net.onnx", "sha256": hashlib.sha256(data).hexdigest()}}
    (folder / "net.json").write_text(json.dumps({**CONVENTIONS, "files": files, **manifest}))
    (folder / "robot.xml").write_text(model)
    (folder / "spec.yaml").write_text(spec + 'targets: {mujoco: {version: "3.11"}}\n')
    return folder / "spec.yaml"


def compiled(
    folder: Path, manifest: dict[str, Any], spec: str = NET, model: str = pendulums.MODEL
) -> list[Diagnostic]:
    """What `compile` says of what a network counts twice, and of its model."""
    done = api.compile(str(written(folder, manifest, spec, model)), output=str(folder / "build"))
    return [item for item in done.diagnostics if item.code in ("NET013", "NET014", "NET015")]


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What a training with the pendulums leaves of their dynamics."""
    folder = tmp_path_factory.mktemp("trained")
    (folder / "robot.xml").write_text(pendulums.MODEL)
    (folder / "spec.yaml").write_text(pendulums.SPEC)
    spec = api.load(folder / "spec.yaml")
    robot = api.load_robot(spec)
    found = dynamics_entries(robot, api.resolve(spec, robot).joints)
    # 1 and 2 kg; m l^2 + armature, l 0.2 and 0.1 m
    assert found["dynamics"]["mass"] == pytest.approx(3.0)
    assert found["dynamics"]["joints"]["hip"]["inertia"] == pytest.approx(0.04 + 0.02, abs=1e-6)
    return {**found, "torque": "inferred"}


def test_the_same_model_is_silent(trained: dict[str, Any], tmp_path: Path) -> None:
    """Level and gains are no dynamics."""
    assert compiled(tmp_path, trained) == []


@pytest.mark.parametrize(
    "spec, model, expected",
    [
        (
            ("armature: 0.02 kg*m^2", "armature: 0.01 kg*m^2"),
            ("", ""),
            [
                "armature of hip is 0.01 kg*m^2, was 0.02 kg*m^2",
                "inertia of hip is 0.05 kg*m^2, was 0.06 kg*m^2",
            ],
        ),
        (
            ("viscous: 0.1", "viscous: 0.3"),
            ("", ""),
            ["viscous friction of arm is 0.3 N*m*s/rad, was 0.1 N*m*s/rad"],
        ),
        (
            ("", ""),
            ('mass="2"', 'mass="2.5"'),
            ["mass of the robot is 3.5 kg, was 3 kg", "inertia of arm is 0.045"],
        ),
        (
            ("", ""),
            ('<joint name="arm" axis="0 1 0"/>', '<joint name="arm" axis="1 0 0"/>'),
            ["links, axes or springs"],
        ),
    ],
    ids=["armature", "friction", "mass", "axis"],
)
def test_a_changed_model_is_named(
    spec: tuple[str, str],
    model: tuple[str, str],
    expected: list[str],
    trained: dict[str, Any],
    tmp_path: Path,
) -> None:
    """The figure, what it was and what it is."""
    (said,) = compiled(tmp_path, trained, NET.replace(*spec), pendulums.MODEL.replace(*model))
    assert said.code == "NET013" and said.severity.value == "warning"
    assert said.where == "actuators.legs.network" and said.span is not None
    for text in expected:
        assert text in said.message


def test_another_torque_source_is_not_asked(trained: dict[str, Any], tmp_path: Path) -> None:
    """A network of measured torques has no model to change."""
    assert compiled(tmp_path, {"torque": "drive"}, NET.replace("0.02 kg", "0.01 kg")) == []


def test_friction_and_armature_again(tmp_path: Path) -> None:
    """By hand: 0.3 + 0.1 * 2.5 = 0.55 N*m at the 2.5 rad/s of the range; 0.02 of 0.06 kg*m^2 is a third of 30 N*m."""
    (said,) = compiled(tmp_path, {"torque": "joint"}, NET.replace("coulomb: 0 N*m", "coulomb: 0.3 N*m"))
    assert said.code == "NET014"
    assert "hip: friction 0.55 N*m at 2.5 rad/s; armature 0.02 kg*m^2, 10 N*m of 30 N*m" in said.message
    # the arm has 0.02 of 0.04
    assert "arm: friction 0.55 N*m at 2.5 rad/s; armature 0.02 kg*m^2, 15 N*m of 30 N*m" in said.message


def test_delay_and_filter_again(tmp_path: Path) -> None:
    """By hand: 20 N*m/rad * 2.5 rad/s * 10 ms = 0.5 N*m; a filter of 5 Hz is late by 1/(10 pi) s, 1.59 N*m."""
    spec = NET.replace("network:", "delay: 10 ms, command_filter: {cutoff: 5 Hz}, network:")
    (said,) = compiled(tmp_path, {}, spec)
    assert said.code == "NET015"
    assert (
        "hip, arm: delay 10 ms, 0.5 N*m at 2.5 rad/s | hip, arm: command_filter 5 Hz, 1.59 N*m"
        in said.message
    )


COMMANDS = (
    ["validate", "spec.yaml"],
    ["compile", "spec.yaml", "-t", "mujoco", "-o", "build"],
    ["verify", "spec.yaml", "-t", "mujoco"],
)


@pytest.mark.parametrize(
    ("manifest", "said"),
    [
        (None, "NET004 actuators.legs.network: the manifest cannot be read: there is no file"),
        ('{"format": "actspec-netw', "NET004"),
        (
            {"inputs": "sideways"},
            "SPEC105 inputs: must be one of position_velocity, velocity_position, got 'sideways'",
        ),
        ({"tap_period": "7 ms"}, "NET007 actuators.legs.network: tap_period 7 ms is not a whole number of"),
    ],
)
def test_every_command_tells_a_broken_manifest(
    manifest: dict[str, Any] | str | None,
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Without it no target knows the network, MuJoCo's plain motors least of all; 7 ms are 1.4 steps of 5 ms."""
    written(tmp_path, manifest if isinstance(manifest, dict) else {})
    monkeypatch.chdir(tmp_path)
    if isinstance(manifest, str):
        Path("net.json").write_text(manifest)
    elif manifest is None:
        Path("net.json").unlink()
    for command in COMMANDS:
        assert main(command) == 2
        assert capsys.readouterr().err.count(said) == 1
    assert not Path("build").exists()
