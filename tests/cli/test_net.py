"""`actspec net`: from logs to a network that compiles, and how good it is; what is refused."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from actspec.cli.main import main
from actspec.laws.network import NetworkLaw
from actspec.learn.evaluate import Evaluation, behind_the_law, errors_of, graded, worse_in_motion
from actspec.logs import load_log, write_log
from actspec.owned import kind_of
from actspec.readings.onnx_network import read_onnx
from tests.learn.pendulums import KD, KP, SPEC, folder, log
from tests.schemas import fits

pytest.importorskip("torch")
pytestmark = pytest.mark.slow


def checked(name: str, text: str) -> dict[str, Any]:
    """Output that its schema takes."""
    found: dict[str, Any] = json.loads(text)
    fits(name, found)
    return found


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """A folder with spec, logs and a network, and what `train` printed."""
    path = folder(tmp_path_factory.mktemp("net"))
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(path)
        for seed in (1, 2, 3):
            log(Path(f"{seed}.npz"), seed, 4200 if seed == 1 else 1200, size=0.14 if seed == 1 else 0.12)
        import contextlib
        import io

        stream = io.StringIO()
        with contextlib.redirect_stdout(stream):
            code = main(
                [
                    *("net", "train", "spec.yaml", "1.npz", "2.npz", "-o", "nets/legs", "--taps", "3"),
                    *("--hidden", "64", "--epochs", "80", "--output-format", "json"),
                ]
            )
        assert code == 0
    return path, checked("net-train", stream.getvalue())


def test_a_linear_law_is_learned(trained: tuple[Path, dict[str, Any]]) -> None:
    """The delayed drive beside the same by least squares; and the Jacobian at rest.

    The command of two rows ago stands beside the position of then: 20 x 10 ms of velocity make up for that.
    """
    path, record = trained
    assert record["validation"]["whole_recordings"] and record["validation"]["logs"] == ["2.npz"]
    # Least squares leave nothing.
    assert record["validation"]["relative_error"] < 0.03
    # Of the 30 N*m of the spec 1.5 % are 0.45 N*m.
    assert max(joint["rmse"] for joint in record["joints"]) < 0.45
    assert min(joint["r2"] for joint in record["joints"]) > 0.95
    assert [joint["grade"] for joint in record["joints"]] == ["good", "good"]
    assert record["validation"]["grade"] == "good"
    law = NetworkLaw(read_onnx((path / "nets/legs.onnx").read_bytes()), (0, 1, 2), 0.005)
    small = 0.01
    inputs = np.concatenate([np.zeros((1, 6)), small * np.eye(6)])
    torque = law.torque(inputs[:, :3], inputs[:, 3:])[0]
    slopes = (torque[1:] - torque[0]) / small
    assert slopes[:3].sum() == pytest.approx(KP, rel=0.05)
    assert slopes[3:].sum() == pytest.approx(-KD - KP * 0.010, abs=0.1)
    manifest = json.loads((path / "nets/legs.json").read_text("utf-8"))
    assert (manifest["taps"], manifest["tap_period"], manifest["torque"]) == ([0, 1, 2], "5 ms", "drive")


def test_the_same_seed_gives_the_same_files(
    trained: tuple[Path, dict[str, Any]], monkeypatch: Any, capsys: Any
) -> None:
    """Weights follow from logs, options and seed; of several seeds the best is kept, and the spread is told."""
    path, _ = trained
    monkeypatch.chdir(path)
    options = ["--taps", "2", "--hidden", "4", "--epochs", "1", "--output-format", "json"]
    found = {}
    for name, seed in (("a", "5"), ("b", "5"), ("c", "6"), ("d", "5")):
        several = ["--seeds", "2"] if name == "d" else []
        command = [
            "net",
            "train",
            "spec.yaml",
            "2.npz",
            "3.npz",
            "-o",
            name,
            *options,
            "--seed",
            seed,
            *several,
        ]
        assert main(command) in (0, 1)
        found[name] = checked("net-train", capsys.readouterr().out)
    data = {name: Path(f"{name}.onnx").read_bytes() for name in "abcd"}
    assert data["a"] == data["b"] != data["c"]
    rmse = [run["rmse"] for run in found["d"]["seeds"]]
    assert rmse == [found[name]["validation"]["rmse"] for name in "ac"] and found["a"]["spread"] is None
    assert found["d"]["spread"] == pytest.approx(abs(rmse[0] - rmse[1]) / 2)
    assert data["d"] == data[{5: "a", 6: "c"}[found["d"]["seed"]]]


def test_evaluate(trained: tuple[Path, dict[str, Any]], monkeypatch: Any, capsys: Any) -> None:
    """The network is good, better than the PD that does not know the delay, in torque and in motion."""
    path, _ = trained
    monkeypatch.chdir(path)
    arguments = ["net", "evaluate", "spec.yaml", "3.npz", "--network", "nets/legs.json"]
    assert main([*arguments, "--output-format", "json"]) == 0
    found = checked("net-evaluate", capsys.readouterr().out)
    assert found["overall"]["grade"] == "good" and found["overall"]["r2"] > 0.99
    assert list(found["baselines"]) == ["ideal_pd"]
    assert found["overall"]["rmse"] < 0.25 * found["baselines"]["ideal_pd"]["rmse"]
    closed = found["closed_loop"]
    assert closed["horizon"] == 1.0 and closed["dc_motor"] is None
    # The rows' own steps are a tenth of those in which MuJoCo integrates: no torque makes up for that.
    assert closed["network"]["position_rmse"] < 0.5 * closed["ideal_pd"]["position_rmse"]
    assert main([*arguments, "--html", "legs.html"]) == 0
    assert "good" in capsys.readouterr().out
    page = Path("legs.html").read_text("utf-8")
    # Motion once, torque and errors of each joint.
    assert page.count("<svg class") == 5 and "<script" not in page and "arm: good" in page
    assert kind_of(Path("legs.html").read_bytes()) == "page"
    Path("legs.html").write_text("mine")
    assert main([*arguments, "--html", "legs.html"]) == 2
    assert "OUT003: exists already" in capsys.readouterr().err
    assert main([*arguments, "--html", "spec.yaml", "--force"]) == 2


def test_an_lstm(trained: tuple[Path, dict[str, Any]], monkeypatch: Any, capsys: Any) -> None:
    """It learns the delay too, and its state goes on through the closed loop; sizes that differ are refused."""
    path, _ = trained
    monkeypatch.chdir(path)
    command = ["net", "train", "spec.yaml", "1.npz", "2.npz", "-o", "nets/lstm", "--kind", "lstm"]
    assert main([*command, "--hidden", "8,16"]) == main([*command, "--tap-period", "10 ms"]) == 2
    assert capsys.readouterr().err.count("LRN025") == 2 and not Path("nets/lstm.json").exists()
    assert main([*command, "--hidden", "16", "--epochs", "40"]) == 0
    manifest = json.loads(Path("nets/lstm.json").read_text("utf-8"))
    assert (manifest["kind"], manifest["taps"], manifest["initial_history"]) == ("lstm", [0], "zero")
    capsys.readouterr()
    main(["net", "evaluate", "spec.yaml", "3.npz", "--network", "nets/lstm.json", "--output-format", "json"])
    found = checked("net-evaluate", capsys.readouterr().out)
    assert found["overall"]["r2"] > 0.95
    assert found["overall"]["rmse"] < 0.5 * found["baselines"]["ideal_pd"]["rmse"]
    closed = found["closed_loop"]
    assert closed["network"]["position_rmse"] < 0.5 * closed["ideal_pd"]["position_rmse"]


def test_data(trained: tuple[Path, dict[str, Any]], monkeypatch: Any, capsys: Any) -> None:
    """10 s are a finding; a policy that goes further is another."""
    path, _ = trained
    monkeypatch.chdir(path)
    assert main(["net", "data", "spec.yaml", "1.npz", "--output-format", "json"]) == 0
    found = checked("net-data", capsys.readouterr().out)
    # 4200 rows of 5 ms less the first five, which have no history.
    assert found["joints"][0]["minutes"] == pytest.approx(4195 * 0.005 / 60)
    assert found["joints"][0]["rate"] == pytest.approx(200.0)
    assert main(["net", "data", "spec.yaml", "1.npz"]) == 0
    # 0.34958 minutes, in three digits.
    assert re.search(r"hip +0\.35 +200 Hz", capsys.readouterr().out)
    assert main(["net", "data", "spec.yaml", "2.npz", "--policy", "3.npz", "--output-format", "json"]) == 1
    found = checked("net-data", capsys.readouterr().out)
    # Both joints are in one log: said once, with both.
    (short,) = (item for item in found["findings"] if item["code"] == "LRN020")
    assert short["message"] == (
        "all 2 joints have 5.97 s of rows with a whole history, 20 s at least make a network: hip, arm"
    )
    assert found["joints"][0]["outside"]["velocity"] >= 0.0


def test_inferred_torques_are_those_of_the_drive(
    trained: tuple[Path, dict[str, Any]], monkeypatch: Any, capsys: Any
) -> None:
    """I q'' + m g l sin q + viscous friction is the torque that moved the pendulums."""
    path, _ = trained
    monkeypatch.chdir(path)
    options = ["--taps", "3", "--hidden", "24", "--epochs", "20"]
    arguments = ["net", "train", "spec.yaml", "1.npz", "2.npz", "-o", "nets/inferred", "--torque", "inferred"]
    assert main([*arguments, *options]) == 0
    manifest = json.loads(Path("nets/inferred.json").read_text("utf-8"))
    assert manifest["torque"] == "inferred" and len(manifest["model"]) == 64
    capsys.readouterr()
    main(
        [
            "net",
            "evaluate",
            "spec.yaml",
            "3.npz",
            "--network",
            "nets/inferred.json",
            "--output-format",
            "json",
        ]
    )
    found = checked("net-evaluate", capsys.readouterr().out)
    assert found["overall"]["r2"] > 0.99


def test_a_network_without_a_torque_sensor_is_judged(
    trained: tuple[Path, dict[str, Any]], monkeypatch: Any, capsys: Any
) -> None:
    """Its logs have no torque: it is compared with what the model needs, and rolled out; one of a sensor is refused."""
    path, _ = trained
    monkeypatch.chdir(path)
    known = load_log("3.npz")
    write_log(
        replace(known, path="4.npz", joints={n: replace(j, torque=None) for n, j in known.joints.items()})
    )
    options = ["--taps", "3", "--hidden", "24", "--epochs", "20", "--torque", "inferred", "--force"]
    assert main(["net", "train", "spec.yaml", "1.npz", "2.npz", "-o", "nets/silent", *options]) == 0
    capsys.readouterr()
    judge = ["net", "evaluate", "spec.yaml", "4.npz", "--output-format", "json", "--network"]
    main([*judge, "nets/silent.json"])
    found = checked("net-evaluate", capsys.readouterr().out)
    assert found["overall"]["r2"] > 0.99 and found["closed_loop"]["network"] is not None
    assert "LRN032" in {item["code"] for item in found["findings"]}
    assert main([*judge, "nets/legs.json"]) == 2
    assert "LRN006" in capsys.readouterr().out


def test_worse_in_motion() -> None:
    """0.03 rad beside 0.01 of the better law are 3 times, 0.019 are not twice; without a rollout nothing is said."""
    errors = errors_of(np.zeros(2), np.ones(2))

    def of(closed: dict[str, float | None] | None) -> Evaluation:
        return Evaluation(errors, "good", (), {}, closed, {}, None, None)

    (one,) = worse_in_motion(of({"network": 0.03, "ideal_pd": 0.05, "dc_motor": 0.01}))
    assert (one.code, one.severity.value) == ("LRN033", "warning")
    assert one.message.startswith(
        "in motion the network is 3 times as far from the logs as dc_motor: 0.03 and 0.01 rad"
    )
    assert not list(worse_in_motion(of({"network": 0.019, "ideal_pd": 0.01, "dc_motor": None})))
    assert not list(worse_in_motion(of(None)))


def test_a_trained_network_compiles(trained: tuple[Path, dict[str, Any]], monkeypatch: Any) -> None:
    """Each target takes the file that it reads from the one manifest."""
    path, _ = trained
    monkeypatch.chdir(path)
    spec = SPEC.replace("level: ideal_pd, kp: 20 N*m/rad, kd: 0.5 N*m*s/rad", "level: actuator_net")
    spec = spec.replace("effort_limit:", "network: {manifest: nets/legs.json}, effort_limit:")
    Path("net.yaml").write_text(
        spec + 'targets: {mujoco: {version: "3.12"}, isaaclab: {version: "2.3"}, mjlab: {version: "1.6"}}\n'
    )
    assert main(["compile", "net.yaml", "-o", "out"]) == 0
    written = {file.suffix for file in Path("out").rglob("legs.*")}
    assert {".onnx", ".pt"} <= written


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["train", "spec.yaml", "2.npz", "-o", "mine"], "OUT003"),
        (["train", "spec.yaml", "2.npz", "-o", "new", "--hidden", "0"], "LRN015"),
        (["train", "spec.yaml", "2.npz", "-o", "new", "--hidden", ""], "LRN015"),
        (["train", "spec.yaml", "2.npz", "-o", "new", "--kind", "lstm", "--hidden", ""], "LRN015"),
        (["train", "spec.yaml", "2.npz", "-o", "new", "--taps", "0"], "LRN015"),
        (["train", "spec.yaml", "2.npz", "-o", "new", "--kind", "lstm", "--taps", "6"], "LRN025 --taps"),
        (
            ["train", "spec.yaml", "2.npz", "-o", "new", "--kind", "lstm", "--activation", "elu"],
            "LRN025 --activation",
        ),
        (["train", "spec.yaml", "2.npz", "-o", "new", "--max-time", "5 m"], "LRN015"),
        (["train", "spec.yaml", "2.npz", "2.npz", "-o", "new"], "LRN014"),
        (["train", "spec.yaml", "pickle.npz", "-o", "new"], "LOG"),
        (["train", "spec.yaml", "missing.csv", "-o", "new"], "LOG001"),
        (["evaluate", "spec.yaml", "2.npz", "--network", "missing.json"], "LRN013"),
        (["evaluate", "spec.yaml", "2.npz", "--network", "other.json"], "NET005"),
        (["evaluate", "spec.yaml", "2.npz", "--network", "cut.json"], "NET0"),
        (["evaluate", "spec.yaml", "2.npz", "--network", "out.json"], "SPEC106"),
    ],
)
def test_what_is_refused(
    arguments: list[str], code: str, trained: tuple[Path, dict[str, Any]], monkeypatch: Any, capsys: Any
) -> None:
    """Exit code 2, one cause, and nothing is written."""
    path, _ = trained
    monkeypatch.chdir(path)
    Path("pickle.npz").write_bytes(b"\x80\x04\x95\x00")
    Path("mine.pt").write_bytes(b"mine")
    text = Path("nets/legs.json").read_text("utf-8")
    Path("other.json").write_text(text.replace('"legs.onnx"', '"other.onnx"'), "utf-8")
    Path("other.onnx").write_bytes(b"other")
    Path("out.json").write_text(text.replace('"legs.onnx"', '"../legs.onnx"'), "utf-8")
    import hashlib

    whole = Path("nets/legs.onnx").read_bytes()
    Path("cut.onnx").write_bytes(whole[:200])
    old, new = (hashlib.sha256(data).hexdigest() for data in (whole, whole[:200]))
    Path("cut.json").write_text(text.replace("legs.onnx", "cut.onnx").replace(old, new), "utf-8")
    before = {file: file.read_bytes() for file in Path().rglob("*") if file.is_file()}
    assert main(["net", *arguments]) == 2
    shown = capsys.readouterr().err
    assert code in shown and "Traceback" not in shown
    assert {file: file.read_bytes() for file in Path().rglob("*") if file.is_file()} == before


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"taps": [0, 1]},
            "NET010 --network: 'legs.onnx' is not what its manifest describes: it has 6 inputs",
        ),
        (
            {"kind": "lstm"},
            "NET010 --network: 'legs.onnx' is not what its manifest describes: it is of kind mlp",
        ),
        (
            {"tap_period": "7 ms"},
            "NET007 --network: tap_period 7 ms is not a whole number of physics steps of 5 ms",
        ),
        ({"tap_period": "unknown"}, "NET007 --network: tap_period is unknown"),
        (
            {"files": {"onnx": {"path": "gone.onnx", "sha256": 64 * "0"}}},
            "NET003 --network: there is no file 'gone.onnx'",
        ),
        (
            {"files": {"onnx": {"path": "legs.onnx", "sha256": 64 * "0"}}},
            "NET005 --network: the network is not the one",
        ),
    ],
    ids=lambda part: next(iter(part)) if isinstance(part, dict) else "",
)
def test_a_broken_manifest_is_named(
    change: dict[str, Any], message: str, trained: tuple[Path, dict[str, Any]], monkeypatch: Any, capsys: Any
) -> None:
    """Of all files that a command reads, the one that is wrong stands before the message."""
    path, _ = trained
    monkeypatch.chdir(path)
    manifest = json.loads(Path("nets/legs.json").read_text("utf-8"))
    Path("nets/broken.json").write_text(json.dumps({**manifest, **change}), "utf-8")
    assert main(["net", "evaluate", "spec.yaml", "3.npz", "--network", "nets/broken.json"]) == 2
    assert capsys.readouterr().err.startswith(f"nets/broken.json: {message}")


def test_joints_that_a_network_was_not_trained_on(
    trained: tuple[Path, dict[str, Any]], monkeypatch: Any, capsys: Any
) -> None:
    """Its manifest names other joints: both are told, with the manifest."""
    path, _ = trained
    monkeypatch.chdir(path)
    manifest = json.loads(Path("nets/legs.json").read_text("utf-8"))
    Path("nets/others.json").write_text(json.dumps({**manifest, "joints": ["hip", "knee"]}), "utf-8")
    main(["net", "evaluate", "spec.yaml", "3.npz", "--network", "nets/others.json"])
    shown = capsys.readouterr().err
    assert "nets/others.json: NET008 [warning] --network: the network was not trained on arm\n" in shown
    assert "its manifest names hip, knee" in shown
    main(["net", "evaluate", "spec.yaml", "3.npz", "--network", "nets/legs.json"])
    assert "NET008" not in capsys.readouterr().err


def test_the_manifest_tells_the_group(
    trained: tuple[Path, dict[str, Any]], monkeypatch: Any, capsys: Any
) -> None:
    """Of logs with joints of two groups the manifest's is judged; joints of both say nothing."""
    path, _ = trained
    monkeypatch.chdir(path)
    legs = "  legs: {joints: [hip, arm], "
    assert legs in SPEC
    _, _, drive = SPEC.partition(legs)
    split = SPEC.replace(legs, "  hips: {joints: [hip], ") + "  arms: {joints: [arm], " + drive
    Path("split.yaml").write_text(split, "utf-8")
    manifest = json.loads(Path("nets/legs.json").read_text("utf-8"))
    Path("nets/arms.json").write_text(json.dumps({**manifest, "joints": ["arm"]}), "utf-8")
    command = ["net", "evaluate", "split.yaml", "3.npz", "--output-format", "json", "--network"]
    main([*command, "nets/arms.json"])
    found = checked("net-evaluate", capsys.readouterr().out)
    assert [joint["joint"] for joint in found["joints"]] == ["arm"]
    assert main([*command, "nets/legs.json"]) == 2
    assert "a network is of one group: give --group" in capsys.readouterr().out


def test_the_share_held_out_is_told(
    trained: tuple[Path, dict[str, Any]], monkeypatch: Any, capsys: Any
) -> None:
    """The long log is last: of 4200 and 1200 rows two joints, less histories, 77.8 % are held out."""
    path, _ = trained
    monkeypatch.chdir(path)
    options = ["--taps", "2", "--hidden", "4", "--epochs", "1", "-o", "nets/long"]
    main(["net", "train", "spec.yaml", "2.npz", "1.npz", *options])
    assert "held out (whole recordings, 78%)" in capsys.readouterr().out


OTHER_SIZES: tuple[tuple[dict[str, Any], str], ...] = (
    ({"hidden_size": 7}, "its hidden_size is 3, the manifest says 7"),
    ({"num_layers": 2}, "its num_layers is 1, the manifest says 2"),
    ({"kind": "mlp"}, "it is of kind lstm, the manifest says mlp"),
    ({"taps": [0, 1]}, "it has 2 inputs, and position errors and velocities at 2 taps are 4"),
)


def test_sizes_that_are_not_the_networks(tmp_path: Path, monkeypatch: Any, capsys: Any) -> None:
    """An LSTM of 3 by another's manifest: `inspect` lists it as a contradiction, `convert` writes nothing."""
    from actspec.learn.files import write_network
    from tests.learn.test_files import MANIFEST, lstm

    monkeypatch.chdir(tmp_path)
    write_network("net", lstm(1), {**MANIFEST, "taps": [0]})
    manifest = json.loads(Path("net.json").read_text("utf-8"))
    for change, message in OTHER_SIZES:
        Path("other.json").write_text(json.dumps({**manifest, **change}), "utf-8")
        assert main(["net", "inspect", "net.onnx", "--manifest", "other.json"]) == 1
        assert f"contradiction: {message}" in capsys.readouterr().out
        before = sorted(Path().iterdir())
        assert main(["net", "convert", "net.onnx", "--manifest", "other.json", "-o", "new"]) == 2
        assert (
            f"net.onnx: LRN013: the network is not what other.json describes: {message}"
            in capsys.readouterr().err
        )
        assert sorted(Path().iterdir()) == before
    assert main(["net", "convert", "net.onnx", "--manifest", "net.json", "-o", "new"]) in (0, 1)


def test_a_model_in_place_of_a_manifest(tmp_path: Path, monkeypatch: Any, capsys: Any) -> None:
    """XML is one long YAML value: the help speaks of a manifest, and not of a spec."""
    monkeypatch.chdir(folder(tmp_path))
    log(Path("l.csv"))
    Path("leg.xml").write_text("<mujoco/>")
    assert main(["net", "evaluate", "spec.yaml", "l.csv", "--network", "leg.xml"]) == 2
    text = capsys.readouterr().err
    assert "NET004" in text and "help: a manifest is the JSON beside a network" in text
    assert "actspec: 1" not in text


def test_errors_by_hand() -> None:
    """Torques 3 and -4, found 3.5 and -4: mse 0.125; RMS^2 12.5; variance 12.25."""
    errors = errors_of(np.array([3.5, -4.0]), np.array([3.0, -4.0]))
    assert (errors.mse, errors.worst, errors.rows) == (0.125, 0.5, 2)
    assert errors.relative_error == pytest.approx(0.1)
    assert errors.r2 == pytest.approx(1 - 0.125 / 12.25)
    # RMSE 0.354: of 30 N*m 1.2 %, of 20 1.8 %, of 10 3.5 %.
    assert [graded(errors, limit, {}) for limit in (30.0, 20.0, 10.0, None)] == [
        "good",
        "fair",
        "poor",
        "good",
    ]


def test_the_grade_by_the_law_that_it_would_replace() -> None:
    """An RMSE of 0.1 beside 0.11, 0.06 and 0.04 N*m: nearer, 1.67 and 2.5 times as far; the nearest law counts."""
    torque = np.array([3.0, -3.0, 3.0, -3.0])
    network, far, near, best = (errors_of(torque + off, torque) for off in (0.1, 0.11, 0.06, 0.04))
    laws = ({}, {"ideal_pd": far}, {"ideal_pd": far, "dc_motor": near}, {"ideal_pd": best, "dc_motor": far})
    assert [graded(network, 30.0, law) for law in laws] == ["good", "good", "fair", "poor"]
    assert not list(behind_the_law([("hip", network, laws[1]), ("knee", network, {})], "N*m"))
    (one,) = behind_the_law([("hip", network, laws[2])], "N*m")
    assert (one.code, one.severity.value, one.where) == ("LRN035", "info", "hip")
    (one,) = behind_the_law(
        [("hip", network, laws[2]), ("knee", network, laws[3]), ("toe", network, {})], "N*m"
    )
    assert (one.severity.value, one.where, one.message) == (
        "warning",
        "knee",
        "the network's torque is 2.5 times as far from the logs as that of ideal_pd, the spec's own law, at most of "
        "2 joints: 0.1 and 0.04 N*m",
    )
    exact = errors_of(torque, torque)
    assert [graded(one, 30.0, {"ideal_pd": exact}) for one in (exact, network)] == ["good", "poor"]
