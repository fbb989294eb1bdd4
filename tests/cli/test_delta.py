"""`actspec delta`: from a policy's logs to a delta action that a spec names, and how good it is; what is refused."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from actspec import api
from actspec.cli.main import main
from actspec.diagnostics import EmitError
from actspec.learn.files import write_network
from actspec.logs import write_log
from tests.cli.test_net import checked
from tests.learn.policies import FLOATING, SPEC, folder, walk
from tests.learn.test_files import perceptron

pytest.importorskip("torch")
pytestmark = pytest.mark.slow


def fault(q: Any, qd: Any, c: Any) -> Any:
    """What the robot's drives add to a command [rad]."""
    return 0.08 * np.tanh([-0.5 * qd[0] + 0.3, 2.0 * (c[1] - q[1])])


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with spec, logs and a delta action."""
    path = folder(tmp_path_factory.mktemp("delta"))
    walk(path, "walk.npz", fault, rows=500)
    walk(path, "other.npz", fault, rows=160, seed=1)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(path)
        options = ("-o", "nets/delta", "--epochs", "60")
        assert main(["delta", "train", "spec.yaml", "walk.npz", *options]) == 0
    return path


@pytest.fixture
def inside(trained: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of it, in which the test runs."""
    shutil.copytree(trained, tmp_path / "copy")
    monkeypatch.chdir(tmp_path / "copy")
    return tmp_path / "copy"


def test_train(inside: Path, capsys: Any) -> None:
    """The JSON, the manifest, and the same bytes from the same seed."""
    options = ["--epochs", "2", "--max-delta", "5 deg", "--per", "robot", "--output-format", "json"]
    for name in ("a", "b"):
        assert (
            main(["delta", "train", "spec.yaml", "walk.npz", "other.npz", "-o", f"nets/{name}", *options])
            == 0
        )
        found = checked("delta-train", capsys.readouterr().out)
    assert (found["per"], found["epochs"], found["period"]) == ("robot", 2, 0.02)
    assert found["max_delta"] == pytest.approx(np.radians(5))
    assert found["validation"]["logs"] == ["other.npz"] and found["validation"]["rows"] == 158
    # TorchScript numbers the classes of a process.
    assert Path("nets/a.onnx").read_bytes() == Path("nets/b.onnx").read_bytes()
    manifest = checked("delta", Path("nets/a.json").read_text("utf-8"))
    assert manifest["inputs"][:2] == ["hip.position", "arm.position"]
    assert manifest["inputs"][-2:] == manifest["outputs"] == ["hip.command", "arm.command"]
    assert manifest["action_scale"] == {"hip": 0.25, "arm": 0.25}
    assert [log["path"] for log in manifest["logs"]] == ["walk.npz", "other.npz"]


def test_validate(inside: Path, capsys: Any) -> None:
    """Good on another log; on one without the fault it is poor, and that is exit code 1."""
    arguments = ["delta", "validate", "spec.yaml", "other.npz", "--network", "nets/delta.json"]
    assert main([*arguments, "--output-format", "json"]) == 0
    found = checked("delta-validate", capsys.readouterr().out)
    assert found["grade"] == "good" and found["replay"]["improvement"] > 0.5 and found["replay"]["count"] == 3
    share = found["improvement"]["position"]
    assert share == pytest.approx(1.0 - found["corrected"]["position"] / found["uncorrected"]["position"])
    # The fault is within 0.1 rad, so that its own removal is within both limits.
    assert (
        found["removable"]["at_limit"]["position"] > 0.99
        and found["removable"]["at_twice"]["velocity"] > 0.99
    )
    assert [joint["joint"] for joint in found["joints"]] == ["hip", "arm"]
    assert main(arguments) == 0
    assert "good" in capsys.readouterr().out
    walk(inside, "sound.npz", lambda q, qd, c: -fault(q, qd, c), rows=80, seed=2)
    assert main(["delta", "validate", "spec.yaml", "sound.npz", "--network", "nets/delta.json"]) == 1
    assert "poor" in capsys.readouterr().out


def test_a_wide_limit_is_a_warning(inside: Path, capsys: Any) -> None:
    """Above 0.2 rad."""
    arguments = [
        "delta",
        "train",
        "spec.yaml",
        "walk.npz",
        "-o",
        "wide",
        "--epochs",
        "1",
        "--max-delta",
        "30 deg",
    ]
    assert main(arguments) == 1
    # pi / 6, in the digits of a computed number.
    assert (
        "LRN058 [warning] max_delta: corrections of up to 0.524 rad: more than 0.2 rad"
        in capsys.readouterr().err
    )
    assert Path("wide.json").exists()


def test_a_correction_that_does_harm_is_a_warning(inside: Path, capsys: Any) -> None:
    """A robot whose fault turns its sign after the rows to train on."""
    sign = iter([1.0] * 160 + [-1.0] * 40)
    walk(inside, "turns.npz", lambda q, qd, c: next(sign) * 0.05, rows=200)
    assert main(["delta", "train", "spec.yaml", "turns.npz", "-o", "harm", "--epochs", "20"]) == 1
    assert "LRN063" in capsys.readouterr().err


def test_a_spec_that_names_it(inside: Path) -> None:
    """`compile` counts what no target holds, and says when model, joints, rate or file are others."""
    spec = SPEC + "delta_action: {manifest: nets/delta.json}\n"

    def compiled(text: str) -> list[str]:
        Path("named.yaml").write_text(text, encoding="utf-8")
        return [item.code for item in api.compile("named.yaml").diagnostics if item.code.startswith("LRN")]

    assert compiled(spec) == []
    (lost,) = [
        a for e in api.compile("named.yaml").emissions for a in e.approximations if a.field == "delta_action"
    ]
    assert lost.asked == "delta.json"
    assert compiled(spec.replace("kp: 20 ", "kp: 21 ")) == ["LRN060"]
    for text in (
        spec.replace("decimation: 4", "decimation: 2"),
        spec.replace("[hip, arm]", "[hip]").replace("robot: {", "robot: {unmanaged: [arm], "),
        spec.replace("delta.json", "none.json"),
    ):
        with pytest.raises(EmitError) as caught:
            compiled(text)
        assert [item.code for item in caught.value.diagnostics] == ["LRN059"]
    text = Path("nets/delta.json").read_text("utf-8")
    line = 1 + text[: text.index('"max_delta"')].count("\n")
    negative = text.replace('"max_delta": ', '"max_delta": -')
    # A wrong value is at its line of the manifest; of another format nothing else is said.
    for found, place in (
        (negative, (str(Path("nets/delta.json")), line, "max_delta")),
        (negative.replace("delta/1", "network/1"), (str(Path("nets/delta.json")), 2, "format")),
    ):
        Path("nets/delta.json").write_text(found, "utf-8")
        with pytest.raises(EmitError) as caught:
            compiled(spec)
        (one,) = (item for item in caught.value.diagnostics if item.severity.value == "error")
        assert one.span is not None and (one.span.path, one.span.line, one.where) == place
    Path("nets/delta.json").write_text(text, "utf-8")
    Path("nets/delta.onnx").write_bytes(b"other")
    with pytest.raises(EmitError, match="is not the file"):
        compiled(spec)


def test_a_free_base(inside: Path, capsys: Any) -> None:
    """With base columns it is simulated on the floor; without them it must be said that it was held."""
    folder(inside, model=FLOATING)
    log = walk(inside, "free.npz", fault, rows=150)
    arguments = ["delta", "train", "spec.yaml", "free.npz", "-o", "free", "--epochs", "3"]
    assert main(arguments) == 0
    manifest = json.loads(Path("free.json").read_text("utf-8"))
    assert manifest["inputs"][6] == "base.orientation.w" and len(manifest["inputs"]) == 15
    assert main(["delta", "validate", "spec.yaml", "free.npz", "--network", "free.json"]) in (0, 1)
    capsys.readouterr()
    assert (
        main(["delta", "validate", "spec.yaml", "free.npz", "--network", "free.json", "--base", "fixed"]) == 2
    )
    assert "columns that the logs do not give: base.orientation.w" in capsys.readouterr().err
    assert log.base is not None
    for base, said in ((None, "does not tell how it moved"), (log.base, "no base.linear_velocity")):
        moved = None if base is None else replace(base, linear_velocity=None)
        write_log(replace(log, path="held.npz", base=moved), force=True)
        assert main(["delta", "train", "spec.yaml", "held.npz", "-o", "held"]) == 2
        assert said in capsys.readouterr().err


def rewritten(path: Path, change: Any) -> None:
    """A log whose columns are changed."""
    columns = dict(np.load("walk.npz"))
    change(columns)
    np.savez(path, **columns)


@pytest.mark.parametrize(
    ("change", "code", "said"),
    [
        (
            lambda c: c.__setitem__("time [s]", 0.5 * c["time [s]"]),
            "LRN051",
            "every 10 ms, the policy's period is 20 ms",
        ),
        (
            lambda c: c["hip.velocity [rad/s]"].__setitem__(7, np.nan),
            "LRN053",
            "bad.npz:8: LRN053 hip: the velocity",
        ),
        (lambda c: c.pop("hip.velocity [rad/s]"), "LRN053", "no column hip.velocity"),
        (
            lambda c: c.__setitem__("hip.vel [rad/s]", c.pop("hip.velocity [rad/s]")),
            "LRN053",
            "is it 'hip.vel'? Name that column `hip.velocity`",
        ),
        (
            lambda c: [c.pop(k) for k in list(c) if k.startswith("arm")],
            "LRN052",
            "no arm: it has 1 of 2 joints",
        ),
        (lambda c: c.__setitem__("arm.position [rad]", c["hip.position [rad]"]), "LRN004", "those of hip"),
        (lambda c: c.__setitem__("leg.position [rad]", c["hip.position [rad]"]), "SYS021", "no such joint"),
        (
            lambda c: c.__setitem__("hip.velocity [rad/s]", -c["hip.velocity [rad/s]"]),
            "SYS014",
            "opposite sign",
        ),
        (lambda c: [c.__setitem__(k, v[:40]) for k, v in list(c.items())], "LRN056", "38 rows"),
        (
            lambda c: c.__setitem__("time [s]", c["time [s]"] + 0.01 * (np.arange(500) % 2)),
            "LRN051",
            "rows come every",
        ),
    ],
    ids=[
        "rate",
        "NaN",
        "no column",
        "other column",
        "one joint",
        "copied",
        "other names",
        "sign",
        "short",
        "two rates",
    ],
)
def test_logs_that_are_refused(inside: Path, capsys: Any, change: Any, code: str, said: str) -> None:
    """Exit code 2, the file and joint named, nothing written."""
    rewritten(inside / "bad.npz", change)
    assert main(["delta", "train", "spec.yaml", "bad.npz", "-o", "bad/delta"]) == 2
    told = capsys.readouterr().err
    assert code in told and said in told and "Traceback" not in told
    assert not (inside / "bad").exists()


def test_a_networks_history_is_in_no_policys_log(inside: Path, capsys: Any) -> None:
    """Drives of level actuator_net are refused, with what to do."""
    manifest = {"inputs": "position_velocity", "taps": [0, 1], "tap_period": "5 ms"}
    scales = {f"{name}_scale": 1.0 for name in ("position", "velocity", "torque")}
    write_network("legs", perceptron(), {**manifest, **scales, "initial_history": "zero"})
    spec = Path("spec.yaml").read_text("utf-8")
    netted = spec.replace("level: ideal_pd", "level: actuator_net, network: {manifest: legs.json}")
    Path("netted.yaml").write_text(netted, "utf-8")
    assert main(["delta", "train", "netted.yaml", "walk.npz", "-o", "netted/delta"]) == 2
    told = capsys.readouterr().err
    assert "LRN055 level: level actuator_net, of legs" in told and "level dc_motor" in told
    assert not Path("netted").exists()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--max-delta", "0 rad"], "--max-delta must be above 0"),
        (["--max-delta", "-0.1 rad"], "--max-delta must be above 0"),
        (["--max-delta", "0.1"], "--max-delta"),
        (["--max-delta", "0.1 m"], "is a correction of slides"),
        (["--seed", "-1"], "--seed must be at least 0"),
        (["--epochs", "0"], "--epochs must be at least 1"),
        (["--max-time", "1 us"], "the time is over before the first epoch"),
        (["-o", "mine"], "mine.onnx: OUT003: exists already, and would be lost"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_options_that_are_refused(inside: Path, capsys: Any, options: list[str], said: str) -> None:
    """Exit code 2, nothing written."""
    Path("mine.onnx").write_text("mine")
    arguments = ["delta", "train", "spec.yaml", "walk.npz", "-o", "new", *options]
    assert main(arguments) == 2
    assert said in capsys.readouterr().err
    assert not Path("new.json").exists()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (", decimation: 4", "", "the policy's rate is unknown"),
        (
            "level: ideal_pd, kp: 20 N*m/rad, kd: 0.5 N*m*s/rad",
            "command: effort, level: ideal_pd",
            "is no position",
        ),
    ],
    ids=["no rate", "effort"],
)
def test_specs_that_are_refused(inside: Path, capsys: Any, old: str, new: str, said: str) -> None:
    """What a delta action cannot correct."""
    text = Path("spec.yaml").read_text("utf-8")
    assert old in text
    Path("spec.yaml").write_text(text.replace(old, new), encoding="utf-8")
    assert main(["delta", "train", "spec.yaml", "walk.npz", "-o", "new"]) == 2
    assert said in capsys.readouterr().err


def test_networks_of_others_are_refused(inside: Path, capsys: Any) -> None:
    """A pickle as a log, a network's manifest, another robot's delta action."""
    Path("log.pkl").write_bytes(b"\x80\x04N.")
    assert main(["delta", "train", "spec.yaml", "log.pkl", "-o", "new"]) == 2
    text = Path("nets/delta.json").read_text("utf-8")
    Path("nets/bad.json").write_text(text.replace("arm", "leg"), encoding="utf-8")
    capsys.readouterr()
    assert main(["delta", "validate", "spec.yaml", "other.npz", "--network", "nets/bad.json"]) == 2
    assert "corrects leg" in capsys.readouterr().err
    assert main(["delta", "validate", "spec.yaml", "other.npz", "--network", "none.json"]) == 2
    assert "there is no such file" in capsys.readouterr().err
