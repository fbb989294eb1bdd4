"""A network's manifest beside its joints, as `validate` reads it: the network's own file is not there at all."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from actspec.cli.main import main

SPEC = """actspec: 1
robot: {name: legged, model: none, joints: [JOINTS]}
timing: {physics_dt: 5 ms}
actuators:
  legs: {joints: [".*"], level: actuator_net, network: {manifest: legs.json}, FIGURES}
targets: {mujoco: {}}
"""
JOINTS = "{name: hip, range: [-1 rad, 1 rad]}, {name: knee, range: [-2.5 rad, 0 rad]}"
SLIDE = "{name: lift, kind: slide, range: [0 m, 0.1 m]}"
FIGURES = "effort_limit: 24 N*m, velocity_limit: 20 rad/s, armature: 0.01 kg*m^2"
OF_SLIDE = "effort_limit: 24 N, velocity_limit: 20 m/s, armature: 0.01 kg"


def ends(most: float) -> dict[str, float]:
    """A range whose low end is nearer, and whose outliers are ten times as far."""
    return {"low": -most / 2, "high": most, "least": -10 * most, "most": 10 * most}


def written(folder: Path, manifest: dict[str, Any], joints: str, figures: str, more: str = "") -> str:
    """A spec and its manifest, a key a line: `tap_period` on line 6, `position_scale` on 7."""
    whole = {
        **{"format": "actspec-network/1", "kind": "mlp", "inputs": "position_velocity", "taps": [0]},
        **{"tap_period": "5 ms", "position_scale": 1, "velocity_scale": 1, "torque_scale": 1},
        **{"initial_history": "zero", **manifest},
    }
    lines = ",\n".join(f'"{key}": {json.dumps(value)}' for key, value in whole.items())
    (folder / "legs.json").write_text(f"{{\n{lines}\n}}\n")
    text = SPEC.replace("JOINTS", joints).replace("FIGURES", figures) + more
    (folder / "spec.yaml").write_text(text)
    return "spec.yaml"


def trained(error: float = 0.5, velocity: float = 12.0) -> dict[str, Any]:
    return {"range": {"error": ends(error), "velocity": ends(velocity)}}


def validated(rmse: float, relative_error: float) -> dict[str, Any]:
    return {"validation": {"rmse": rmse, "relative_error": relative_error, "r2": 0.9, "rows": 9}}


@pytest.mark.parametrize(
    ("manifest", "joints", "figures", "key"),
    [
        # 100 steps of 5 ms; one more is above half a second.
        ({"tap_period": "500 ms"}, JOINTS, FIGURES, None),
        ({"tap_period": "505 ms"}, JOINTS, FIGURES, "tap_period"),
        # The knee's 2.5 rad three times; a full turn of 6.28 rad where the range is small; 12 x 0.1 m.
        (trained(error=7.4), JOINTS, FIGURES, None),
        (trained(error=7.6), JOINTS, FIGURES, "range.error.high"),
        (trained(error=6.2), "{name: hip, range: [0 rad, 0.1 rad]}", FIGURES, None),
        (trained(error=6.4), "{name: hip, range: [0 rad, 0.1 rad]}", FIGURES, "range.error.high"),
        (trained(error=1.19), SLIDE, OF_SLIDE, None),
        (trained(error=1.21), SLIDE, OF_SLIDE, "range.error.high"),
        # A joint that turns on has no range to be beyond.
        (trained(error=90.0), f"{JOINTS}, wheel", FIGURES, None),
        # Ten times 20 rad/s; 100 rad/s and 10 rad/s are nobody's numbers.
        (trained(velocity=199.0), JOINTS, FIGURES, None),
        (trained(velocity=201.0), JOINTS, FIGURES, "range.velocity.high"),
        (trained(velocity=201.0), JOINTS, FIGURES.replace("20 rad/s", "10 rad/s"), None),
        (trained(velocity=201.0), JOINTS, "effort_limit: 24 N*m, armature: 0.01 kg*m^2", None),
        # RMS torques of 4.7 / 0.02 = 235 and 4.9 / 0.02 = 245 N*m beside ten times 24 N*m; an error of 245 N*m alone.
        (validated(4.7, 0.02), JOINTS, FIGURES, None),
        (validated(4.9, 0.02), JOINTS, FIGURES, "validation.rmse"),
        (validated(245.0, 0.0), JOINTS, FIGURES, "validation.rmse"),
        (validated(4.9, 0.02), JOINTS, "velocity_limit: 20 rad/s, armature: 0.01 kg*m^2", None),
        # A network of measured - target needs the minus, and one of errors alone no velocity.
        ({"position_scale": -1, "velocity_scale": -57.3, "torque_scale": 40000}, JOINTS, FIGURES, None),
        ({"velocity_scale": 0}, JOINTS, FIGURES, None),
        ({"position_scale": 0}, JOINTS, FIGURES, "position_scale"),
        ({"torque_scale": 0}, JOINTS, FIGURES, "torque_scale"),
    ],
)
def test_bounds(
    manifest: dict[str, Any],
    joints: str,
    figures: str,
    key: str | None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """One warning, with the manifest's key."""
    monkeypatch.chdir(tmp_path)
    assert main(["validate", written(tmp_path, manifest, joints, figures)]) == 0
    err = capsys.readouterr().err
    assert re.findall(r"NET017 \[warning\] actuators\.legs\.network: (\S+): ", err) == [key] * (
        key is not None
    )
    assert err.count("[warning]") == (key is not None)


@pytest.mark.parametrize(
    ("manifest", "line"),
    [
        (
            {"tap_period": "5 s"},
            "legs.json:6:15: NET017 [warning] actuators.legs.network: tap_period: samples 5 s apart, and control steps "
            "of robots are 0.5 s at most\n  help: did you mean 5 ms?\n",
        ),
        # 0.5 rad are 28.65 deg.
        (
            trained(error=28.65),
            "NET017 [warning] actuators.legs.network: range.error.high: training data of 28.65 rad, and the widest "
            "range of its joints is 2.5 rad\n  help: is it in deg? Then write 0.5, in rad\n",
        ),
        # 12 rad/s are 687.5 deg/s.
        (
            trained(velocity=687.5),
            "range.velocity.high: training data of 687.5 rad/s, and the fastest of its joints has 20 rad/s\n"
            "  help: is it in deg/s? Then write 12, in rad/s\n",
        ),
    ],
)
def test_words(
    manifest: dict[str, Any],
    line: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """At the manifest's own line, with the group, and the number that was meant."""
    monkeypatch.chdir(tmp_path)
    assert main(["validate", written(tmp_path, manifest, JOINTS, FIGURES)]) == 0
    assert line in capsys.readouterr().err


def test_a_period_that_is_refused_has_one_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """5.001 s are 1000.2 steps of 5 ms, which no target takes."""
    monkeypatch.chdir(tmp_path)
    assert main(["validate", written(tmp_path, {"tap_period": "5.001 s"}, JOINTS, FIGURES)]) == 2
    err = capsys.readouterr().err
    assert err.count("NET007") == 1 and "NET017" not in err


def test_strict_and_accept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`--strict` refuses it; `accept` keeps it, and without a network keeps nothing (SPEC164)."""
    monkeypatch.chdir(tmp_path)
    manifest, accept = {"tap_period": "5 s"}, 'accept: {spec.NET017: "one sample every 5 s"}\n'
    assert main(["validate", "--strict", written(tmp_path, manifest, JOINTS, FIGURES)]) == 1
    assert "spec.NET017" in capsys.readouterr().err
    assert main(["validate", "--strict", written(tmp_path, manifest, JOINTS, FIGURES, accept)]) == 0
    assert "NET017" not in capsys.readouterr().err
    spec = Path(written(tmp_path, manifest, JOINTS, FIGURES, accept))
    spec.write_text(spec.read_text().replace("actuator_net, network: {manifest: legs.json}", "ideal_pd"))
    main(["validate", str(spec)])
    assert "NET017 finds nothing in this spec" in capsys.readouterr().err


def test_groups_of_one_network_are_told_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """By the strongest: ten times the knee's 48 N*m are 480, ten times the hip's 24 N*m 240 N*m."""
    monkeypatch.chdir(tmp_path)
    two = "  shin: {joints: [knee], level: actuator_net, network: {manifest: legs.json}, effort_limit: 48 N*m}\n"
    for rmse, count in ((470.0, 0), (490.0, 1)):
        spec = Path(written(tmp_path, validated(rmse, 1.0), JOINTS, FIGURES))
        spec.write_text(spec.read_text().replace('[".*"]', "[hip]").replace("targets:", f"{two}targets:"))
        assert main(["validate", str(spec)]) == 0
        assert capsys.readouterr().err.count("NET017") == count
