"""What `compile`, `verify` and `net inspect --spec` say of the weights of a network beside manifest and joints."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from actspec.cli.main import main
from tests.learn.test_notes import NET, written
from tests.network_files import onnx_mlp

pytest.importorskip("onnx")

WORDS = "NET018 [warning] actuators.legs.network: "


def said(
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    manifest: dict[str, Any],
    weights: list[float] | None = None,
) -> list[str]:
    """What `compile` says by NET018, a line each, from its place on; the limits are 30 N*m."""
    written(folder, manifest)
    if weights is not None:
        data = onnx_mlp([([weights], [0.0], "")])
        (folder / "net.onnx").write_bytes(data)
    found = json.loads((folder / "net.json").read_text())
    found = {key: value for key, value in found.items() if key != "files" and value is not None}
    # A key a line, from line 2 on.
    lines = ",\n".join(f'"{key}": {json.dumps(value)}' for key, value in found.items())
    (folder / "net.json").write_text(f'{{\n{lines},\n"files": {{"onnx": {entry(folder)}}}\n}}\n')
    assert main(["compile", "spec.yaml", "-t", "mujoco", "-o", "build", "--force"]) == 0
    return [line for line in capsys.readouterr().err.splitlines() if "NET018" in line]


def entry(folder: Path) -> str:
    import hashlib

    sha256 = hashlib.sha256((folder / "net.onnx").read_bytes()).hexdigest()
    return json.dumps({"path": "net.onnx", "sha256": sha256})


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


# The network gives 8 + 12 = 20 N*m/rad of errors that stay and -0.5 N*m*s/rad of velocities. The training data has,
# but for a thousandth, 0.2 rad and 2.5 rad/s; ten times the limits are 300 N*m, a hundredth of them is 0.3 N*m.
@pytest.mark.parametrize(
    ("manifest", "key", "words"),
    [
        ({}, None, ""),
        # 20 x 0.2 x 74 = 296 and x 76 = 304 N*m; of the velocity 0.5 x 2.5 x 76 = 95 N*m.
        ({"torque_scale": 74.0}, None, ""),
        ({"torque_scale": 76.0}, "position_scale", "an error of 0.2 rad, as in training, gives 304 N*m"),
        # 0.5 x 2.5 x 241 = 301 N*m: both are too large, which is the torque's scale.
        ({"torque_scale": 241.0}, "torque_scale", "an error of 0.2 rad, as in training, gives 964 N*m"),
        # 0.5 x 2.5 x 239 = 299 and x 241 = 301 N*m; the damping is 120 N*m*s/rad of 20 x 10 N*m/rad, 0.6 s.
        ({"velocity_scale": 239.0, "position_scale": 10.0}, None, ""),
        (
            {"velocity_scale": 241.0, "position_scale": 10.0},
            "velocity_scale",
            "a velocity of 2.5 rad/s, as in training, gives 301.25 N*m",
        ),
        # 20 x 3 x 0.0051 = 0.306 N*m and x 0.0049 = 0.294 N*m.
        ({"torque_scale": 0.0051}, None, ""),
        (
            {"torque_scale": 0.0049},
            "torque_scale",
            "no error up to 3 rad gives more than 0.294 N*m, and the least effort limit of its joints is 30 N*m",
        ),
        ({"position_scale": -1.0}, "position_scale", "a torque away from the target: -20 N*m/rad"),
        # 0.5 x 0.5 = 0.25 N*m*s/rad are driven on.
        ({"velocity_scale": -0.5}, "velocity_scale", "a velocity is driven on, not damped: 0.25 N*m*s/rad"),
        # -0.5 N*m/rad and 20 N*m*s/rad in that order.
        ({"inputs": "velocity_position"}, "inputs", "are the inputs position_velocity?"),
    ],
)
def test_bounds(
    manifest: dict[str, Any],
    key: str | None,
    words: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """One warning at the number's own line of the manifest."""
    found = said(tmp_path, capsys, manifest)
    assert len(found) == (key is not None)
    if key is not None:
        line = (tmp_path / "net.json").read_text().splitlines()[int(found[0].split(":")[1]) - 1]
        assert found[0].startswith("net.json:") and line.startswith(f'"{key}"')
        assert WORDS in found[0] and words in found[0]


def test_degrees_have_a_help(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """57.3 x 20 x 2 rad x 0.2 = 458 N*m, by a torque scale of 2."""
    said(tmp_path, capsys, {"position_scale": 57.3, "torque_scale": 2.0})
    main(["compile", "spec.yaml", "-t", "mujoco", "-o", "build", "--force"])
    assert "help: position_scale 57.3 makes degrees of rad: did you mean 1?" in capsys.readouterr().err


def test_without_a_training_range(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """20 x 3 rad x 499 = 29940 N*m and x 501 = 30060 N*m beside a thousand times 30 N*m."""
    for scale, count in ((499.0, 0), (501.0, 1)):
        assert len(said(tmp_path, capsys, {"torque_scale": scale, "range": None})) == count


def test_a_network_of_measured_less_target_is_right(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As Isaac Lab has Go1's, pos_scale -1: -8 - 12 of measured - target are 20 N*m/rad of target - measured."""
    weights = [-8.0, -12.0, -0.5, 0.0]
    assert said(tmp_path, capsys, {"position_scale": -1.0}, weights) == []
    assert len(said(tmp_path, capsys, {"position_scale": 1.0}, weights)) == 1


def test_friction_that_is_made_up_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """0.19 N*m*s/rad over 20 N*m/rad is 9.5 ms, 0.21 are 10.5 ms: drives damp by as much."""
    assert said(tmp_path, capsys, {}, [8.0, 12.0, 0.19, 0.0]) == []
    assert len(said(tmp_path, capsys, {}, [8.0, 12.0, 0.21, 0.0])) == 1


def test_play_at_rest_is_no_wrong_sign(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """20 (relu(e - 0.02) - relu(-e - 0.02)) - 0.2 e, of both samples: away from the target below 0.02 rad alone.

    With the first term turned around too, it is so at every error.
    """
    first = np.array([[1.0, 1.0, 0.0, 0.0], [-1.0, -1.0, 0.0, 0.0]] * 2)
    for last, count in (([20.0, -20.0, -0.2, 0.2], 0), ([-20.0, 20.0, -0.2, 0.2], 1)):
        written(tmp_path, {})
        data = onnx_mlp([(first, [-0.02, -0.02, 0.0, 0.0], "Relu"), ([last], [0.0], "")])
        (tmp_path / "net.onnx").write_bytes(data)
        manifest = json.loads((tmp_path / "net.json").read_text())
        manifest["files"] = {"onnx": json.loads(entry(tmp_path))}
        (tmp_path / "net.json").write_text(json.dumps(manifest))
        assert main(["compile", "spec.yaml", "-t", "mujoco", "-o", "build", "--force"]) == 0
        assert capsys.readouterr().err.count("NET018") == count


def test_doubts_of_the_conversion_are_told_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """NET016 has them already; too much torque it does not tell."""
    doubts = {"doubts": ["a torque away from the target"], "position_scale": -1.0}
    assert said(tmp_path, capsys, doubts) == []
    assert len(said(tmp_path, capsys, {**doubts, "torque_scale": 241.0})) == 1


def test_a_range_in_degrees_judges_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """28.65 rad would be 573 N*m; it is told by NET017 alone, beside a range of 2 rad."""
    ends = {"low": -28.65, "high": 28.65, "least": -40.0, "most": 40.0}
    ranges = {"error": ends, "velocity": {"low": -2.0, "high": 2.0, "least": -9.0, "most": 9.0}}
    written(tmp_path, {"range": ranges})
    model = (tmp_path / "robot.xml").read_text().replace('axis="', 'range="-1 1" limited="true" axis="')
    (tmp_path / "robot.xml").write_text(model)
    assert main(["compile", "spec.yaml", "-t", "mujoco", "-o", "build"]) == 0
    err = capsys.readouterr().err
    assert err.count("NET017") == 1 and "NET018" not in err


def test_placeholders_of_a_file_are_no_limits(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """20 x 3 rad x 0.1 = 6 N*m beside a hundredth of 1000 N*m, which the spec states or the file has."""
    for spec, count in (
        (NET.replace("effort_limit: 30 N*m", "effort_limit: 1000 N*m"), 1),
        (NET.replace("effort_limit: 30 N*m, ", "").replace(", effort_limit: 30 N*m", ""), 0),
    ):
        written(tmp_path, {"torque_scale": 0.1}, spec)
        limits = (
            '<actuator><motor joint="hip" ctrlrange="-1000 1000"/><motor joint="arm" ctrlrange="-1000 1000"/>'
        )
        model = (tmp_path / "robot.xml").read_text()
        if count == 0:
            model = model.replace("</mujoco>", f"{limits}</actuator></mujoco>")
            (tmp_path / "robot.xml").write_text(model)
        assert main(["compile", "spec.yaml", "-t", "mujoco", "-o", "build", "--force"]) == 0
        assert capsys.readouterr().err.count("NET018") == count


def test_accept_strict_and_verify(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`--strict` refuses it, `accept` keeps it, `verify` prints it."""
    losses = '"the test\'s own"'
    spec = NET + f"accept: {{mujoco.network: {losses}}}\n"
    written(tmp_path, {"torque_scale": 241.0}, spec)
    assert main(["compile", "spec.yaml", "-t", "mujoco", "-o", "build", "--strict"]) == 1
    assert "spec.NET018" in capsys.readouterr().err
    main(["verify", "spec.yaml", "-t", "mujoco", "--fields-only"])
    assert capsys.readouterr().err.count("NET018") == 1
    written(tmp_path, {"torque_scale": 241.0}, spec.replace("accept: {", 'accept: {spec.NET018: "strong", '))
    assert main(["compile", "spec.yaml", "-t", "mujoco", "-o", "build", "--strict"]) == 0
    assert "NET018" not in capsys.readouterr().err


def test_inspect_with_a_spec(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The limits are those of the group that names the manifest; another manifest is refused."""
    written(tmp_path, {"torque_scale": 241.0})
    inspect = ["net", "inspect", "net.onnx", "--output-format", "json", "--manifest"]
    assert main([*inspect, "net.json"]) == 0
    capsys.readouterr()
    assert main([*inspect, "./net.json", "--spec", "spec.yaml"]) == 1
    (told,) = json.loads(capsys.readouterr().out)["contradictions"]
    assert told.startswith("an error of 0.2 rad, as in training, gives 964 N*m")
    (tmp_path / "other.json").write_text((tmp_path / "net.json").read_text())
    assert main([*inspect, "other.json", "--spec", "spec.yaml"]) == 2
    assert "no group has the manifest other.json" in capsys.readouterr().out
    assert main(["net", "inspect", "net.onnx", "--spec", "spec.yaml"]) == 2
    assert "--spec needs --manifest" in capsys.readouterr().err
