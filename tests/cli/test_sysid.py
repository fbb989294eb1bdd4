"""`actspec sysid`: from a designed experiment over a virtual robot to a results file that compiles."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from actspec.cli.main import main
from actspec.logs import load_log
from actspec.owned import kind_of
from actspec.resources import data_path
from tests.schemas import fits
from tests.sysid.test_fit import MODEL, SPEC

pytest.importorskip("scipy")
pytestmark = pytest.mark.slow

_SIMULATE = ["simulate", "spec.yaml", "--command", "c.csv", "--seed", "1"]


def _exit(arguments: list[str]) -> int:
    """Exit code, argparse's too."""
    try:
        return main(arguments)
    except SystemExit as end:
        assert isinstance(end.code, int)
        return end.code


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with robot, spec, designed commands and the log of the virtual robot."""
    folder = tmp_path_factory.mktemp("bench")
    (folder / "bench.xml").write_text(MODEL.replace("AXIS", "0 1 0"))
    (folder / "spec.yaml").write_text(SPEC)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        design = ["sysid", "design", "spec.yaml", "-o", "c.csv", "--experiment", "multisine"]
        assert main([*design, "--duration", "3 s"]) == 0
        assert main([*_simulate("log.csv")]) == 0
    return folder


def _simulate(output: str, *more: str) -> list[str]:
    noise = ["--position-noise", "0.5 mrad", "--velocity-noise", "0.05 rad/s", "--torque-noise", "2 %"]
    return [
        "sysid",
        "simulate",
        "spec.yaml",
        "--command",
        "c.csv",
        "-o",
        output,
        "--seed",
        "3",
        *noise,
        *more,
    ]


def test_fit_compiles(
    bench: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """JSON by its schema, a results file, and a spec that takes kp from it."""
    monkeypatch.chdir(bench)
    assert main(["sysid", "fit", "spec.yaml", "log.csv", "-o", "r.yaml", "--output-format", "json"]) == 0
    record = json.loads(capsys.readouterr().out)
    fits("sysid", record)
    found = {item["field"]: item for item in record["joints"][0]["parameters"]}
    assert found["kp"]["value"] == pytest.approx(40.0, rel=0.01)
    assert found["kp"]["low"] < 40.0 < found["kp"]["high"]
    assert found["delay"]["value"] == pytest.approx(0.002, abs=1e-4)
    taken = SPEC.replace("kp: 40 N*m/rad", "kp: identified\n    identified: r.yaml")
    (bench / "taken.yaml").write_text(taken)
    assert main(["show", "taken.yaml", "hip", "--output-format", "json"]) == 0
    shown = json.loads(capsys.readouterr().out)["joints"][0]["kp"]
    assert shown["origin"] == "identified"
    assert shown["value"] == pytest.approx(found["kp"]["value"], rel=1e-5)
    assert shown["std"] == pytest.approx(found["kp"]["std"], rel=1e-5)
    # Results are written again, another file stays.
    assert kind_of(Path("r.yaml").read_bytes()) == "sysid fit"
    Path("r.yaml").write_text("mine")
    assert main(["sysid", "fit", "spec.yaml", "log.csv", "-o", "r.yaml"]) == 2
    assert "--force" in capsys.readouterr().err


@pytest.mark.parametrize(("method", "words"), [("frequency", "ten seconds"), ("step", "no steps")])
def test_other_methods_refuse_the_log(
    method: str, words: str, bench: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Three seconds are no spectrum, and sines no steps: reported, and nothing is written."""
    monkeypatch.chdir(bench)
    assert main(["sysid", "fit", "spec.yaml", "log.csv", "--method", method, "-o", "none.yaml"]) == 2
    assert words in capsys.readouterr().err and not (bench / "none.yaml").exists()


def test_same_seed_same_bytes(bench: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    """Noise comes from the seed alone; flaws are in the log."""
    monkeypatch.chdir(bench)
    assert main(_simulate("again.csv")) == 0
    assert (bench / "again.csv").read_bytes() == (bench / "log.csv").read_bytes()
    flaws = ["--encoder-bits", "10", "--dropped", "5 %", "--jitter", "10 %", "--velocity-filter", "40 Hz"]
    assert main(_simulate("rough.csv", *flaws)) == 0
    rough = load_log("rough.csv")
    sound = load_log("log.csv")
    assert 0.9 * len(sound.time) < len(rough.time) < len(sound.time)
    position = rough.joints["hip"].position
    assert position is not None
    # A row comes 10 % of 2 ms early or late, and its position is that of its time.
    late = rough.time[:, None] - sound.time
    assert 1.5e-4 < np.std(late[np.abs(late) < 1e-3]) < 2.5e-4
    # 1024 counts a turn: every reading is a whole number of them, to the ten digits of the file.
    counts = position / (2 * np.pi / 1024)
    assert counts == pytest.approx(np.round(counts), abs=1e-6)
    capsys.readouterr()


@pytest.mark.parametrize("experiment", ["chirp", "steps", "friction", "random"])
def test_design_keeps_to_the_joint(
    experiment: str, bench: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    """30 % of the range of 3 rad to either side, and the torque below 80 % of 30 N*m."""
    monkeypatch.chdir(bench)
    design = ["sysid", "design", "spec.yaml", "-o", f"{experiment}.csv", "--experiment", experiment]
    assert main([*design, "--duration", "4 s", "--rate", "200 Hz"]) == 0
    hip = load_log(f"{experiment}.csv").joints["hip"]
    assert hip.command is not None and hip.torque is not None and hip.position is not None
    assert np.abs(hip.command).max() <= 0.9 + 1e-9
    assert np.abs(hip.command).max() > 0.2
    assert np.abs(hip.torque).max() <= 24.0 + 1e-9
    # The response that the spec would have follows the command.
    assert np.corrcoef(hip.position, hip.command)[0, 1] > 0.5
    capsys.readouterr()


@pytest.mark.parametrize("more", [[], ["--together"]])
def test_design_keeps_a_joint_that_rings_within_its_range(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, more: list[str]
) -> None:
    """A command of 0.9 rad would swing it by 7 rad at its resonance, beyond its range of 1.5 either way."""
    monkeypatch.chdir(tmp_path)
    Path("bench.xml").write_text(MODEL.replace("AXIS", "0 1 0"))
    weak = (
        SPEC.replace("kd: 0.6", "kd: 0.02").replace("coulomb: 0.1", "coulomb: 0.02").replace("30 N", "300 N")
    )
    Path("spec.yaml").write_text(weak)
    design = ["sysid", "design", "spec.yaml", "-o", "c.csv", "--experiment", "chirp", "--duration", "5 s"]
    assert main([*design, *more]) == 0
    log = load_log("c.csv")
    position, command = log.joints["hip"].position, log.joints["hip"].command
    assert position is not None and command is not None
    assert 1.2 < np.abs(position).max() <= 1.5 and np.abs(command).max() > 0.05


def test_steps_together_are_no_copies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    """Three joints of a leg step to sides of their own: commands that went together could not tell the joints apart."""
    monkeypatch.chdir(tmp_path)
    spec = str(data_path("robots", "a1.yaml"))
    design = ["sysid", "design", spec, "-o", "c.csv", "--experiment", "steps", "--together"]
    joints = ["FR_hip_joint", "FR_thigh_joint", "FR_calf_joint"]
    assert main([*design, "--joint", *joints, "--duration", "10 s", "--rate", "200 Hz"]) == 0
    commands = [load_log("c.csv").joints[name].command for name in joints]
    apart = np.abs(np.corrcoef(commands)[np.triu_indices(3, 1)])
    assert apart.max() < 0.5
    capsys.readouterr()


def test_joints_in_turn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    """Each moves in its own part, takes most of what the spec allows, and does what the virtual robot does."""
    monkeypatch.chdir(tmp_path)
    spec = str(data_path("robots", "a1.yaml"))
    design = [
        "sysid",
        "design",
        spec,
        "-o",
        "c.csv",
        "--experiment",
        "steps",
        "--joint",
        "FR_(thigh|calf)_joint",
    ]
    assert main([*design, "--duration", "3 s", "--rate", "200 Hz"]) == 0
    log = load_log("c.csv")
    for i, joint in enumerate(log.joints.values()):
        assert joint.command is not None and joint.velocity is not None and joint.torque is not None
        moves = np.flatnonzero(np.diff(joint.command))
        assert i * 600 <= moves[0] and moves[-1] < (i + 1) * 600
        # 21 rad/s and 33.5 N*m; the amplitudes tried are 9 % apart at most.
        taken = max(np.abs(joint.velocity).max() / 21.0, np.abs(joint.torque).max() / 33.5)
        assert 0.7 < taken <= 0.8
    assert main(["sysid", "simulate", spec, "--command", "c.csv", "-o", "l.csv", "--seed", "1"]) == 0
    thigh, true = (load_log(name).joints["FR_thigh_joint"] for name in ("c.csv", "l.csv"))
    # The calf swings when the thigh moves, which the design leaves out.
    assert thigh.position is not None and true.position is not None
    off = np.std(thigh.position[:600] - true.position[:600])
    assert off < 0.05 * np.std(thigh.position[:600])
    capsys.readouterr()


def test_crest_and_correlation_of_joints_together(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    """Multisines of three joints at once: crest factors of at most 2, correlations below 0.3, links that couple."""
    monkeypatch.chdir(tmp_path)
    spec = str(data_path("robots", "a1.yaml"))
    design = ["sysid", "design", spec, "-o", "c.npz", "--experiment", "multisine", "--joint", "FR_.*"]
    assert main([*design, "--together", "--duration", "5 s", "--rate", "200 Hz"]) == 0
    log = load_log("c.npz")
    commands = np.stack([np.asarray(j.command) - np.mean(j.command) for j in log.joints.values()])  # type: ignore[operator]
    assert len(commands) == 3
    crest = np.abs(commands).max(axis=1) / np.sqrt((commands**2).mean(axis=1))
    assert (crest <= 2.0).all(), crest
    correlation = np.corrcoef(commands)
    assert np.abs(correlation - np.eye(3)).max() < 0.3
    assert main(["sysid", "simulate", spec, "--command", "c.npz", "-o", "l.npz", "--seed", "1"]) == 0
    for name, found in load_log("l.npz").joints.items():
        assert found.position == pytest.approx(log.joints[name].position, abs=3e-3), name
    capsys.readouterr()


def test_joints_that_push_each_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    """Thigh and calf of the A1 at once: their own figures, to the noise, although each moves the other."""
    monkeypatch.chdir(tmp_path)
    spec = str(data_path("robots", "a1.yaml"))
    design = [
        "sysid",
        "design",
        spec,
        "-o",
        "c.csv",
        "--experiment",
        "multisine",
        "--joint",
        "FR_(thigh|calf)_joint",
    ]
    assert main([*design, "--together", "--duration", "5 s", "--rate", "250 Hz"]) == 0
    noise = ["--position-noise", "0.5 mrad", "--velocity-noise", "0.05 rad/s", "--torque-noise", "2 %"]
    assert main(["sysid", "simulate", spec, "--command", "c.csv", "-o", "l.csv", "--seed", "2", *noise]) == 0
    capsys.readouterr()
    assert main(["sysid", "fit", spec, "l.csv", "--output-format", "json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["fit"]["misfit"] < 1.1
    for joint in record["joints"]:
        found = {item["field"]: item for item in joint["parameters"]}
        for field, true, share in (("kp", 25.0, 0.003), ("kd", 0.5, 0.01), ("armature", 0.01, 0.01)):
            assert found[field]["value"] == pytest.approx(true, rel=share), (joint["joint"], field)
            assert abs(found[field]["value"] - true) < 4 * found[field]["std"]
        # A thousandth of the links is not known where others move: noise alone would say 0.008 of the thigh's kp.
        assert 0.015 < found["kp"]["std"] < 0.03


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["fit", "spec.yaml", "missing.csv"], "no such file"),
        (["fit", "spec.yaml", "log.csv", "--free", "armatur"], "did you mean 'armature'?"),
        (["design", "spec.yaml", "-o", "x.csv", "--experiment", "chirp", "--joint", "hp"], "matches no joint"),
        (["design", "spec.yaml", "-o", "x.csv", "--experiment", "chirp", "--duration", "10"], "has no unit"),
        (["design", "spec.yaml", "-o", "x.csv", "--experiment", "steps", "--linear"], "only a chirp's frequency grows"),
        (["design", "spec.yaml", "-o", "x.csv", "--experiment", "steps", "--duration", "1e9 s"], "40000000 numbers"),
        (["design", "spec.yaml", "-o", "x.csv", "--experiment", "steps", "--rate", "1e5 Hz"], "2000000 rows"),
        (["design", "spec.yaml", "-o", "x.csv", "--experiment", "steps", "--rate", "0 Hz"], "must be above 0, got"),
        (["design", "spec.yaml", "-o", "x.csv", "--experiment", "steps", "--seed", "-1"], "'-1' is no whole number"),
        (["design", "spec.yaml", "-o", "x.parquet", "--experiment", "steps"], "written as .csv, .txt or .npz"),
        ([*_SIMULATE, "-o", "spec.yaml/x.csv"], "spec.yaml/x.csv: LOG001"),
        ([*_SIMULATE, "-o", "x.mat"], "written as .csv, .txt or .npz"),
        ([*_SIMULATE, "-o", "x.csv", "--dropped", "100 %"], "--dropped: must be at most 0.9, got 100 %"),
        ([*_SIMULATE, "-o", "x.csv", "--encoder-bits", "9999"], "--encoder-bits: must be at most 40"),
        (["fit", "spec.yaml", "log.csv", "log.csv"], "log.csv: SYS035: is named twice"),
        (["fit", "spec.yaml", "log.csv", "-o", "log.yaml", "--force"], "e.g. log-results.yaml"),
        (["fit", "spec.yaml", "log.csv", "-o", "./c.yaml"], "./c.yaml: SYS036: this is where the sidecar of c.csv is"),
        (["fit", "spec.yaml", "log.csv", "./copy.csv"], "SYS035: the same bytes as log.csv"),
        (["fit", "spec.yaml", "c.csv", "--validate", "log.csv", "--validate", "./copy.csv"], "same bytes as log.csv"),
    ],
)  # fmt: skip
def test_bad_input_writes_nothing(
    arguments: list[str], words: str, bench: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    """Exit code 2, the cause, and no file."""
    monkeypatch.chdir(bench)
    (bench / "copy.csv").write_bytes((bench / "log.csv").read_bytes())
    before = sorted(path.name for path in bench.iterdir())
    assert _exit(["sysid", *arguments]) == 2
    assert words in capsys.readouterr().err
    assert sorted(path.name for path in bench.iterdir()) == before


def test_results_go_into_a_new_folder_and_never_over_what_is_read(
    bench: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`-o results/hip.yaml` makes the folder; the log and the spec are not replaced, whatever --force says."""
    monkeypatch.chdir(bench)
    for path in ("log.csv", "spec.yaml"):
        before = Path(path).read_bytes()
        assert main(["sysid", "fit", "spec.yaml", "log.csv", "-o", path, "--force"]) == 2
        assert "OUT003" in capsys.readouterr().err and Path(path).read_bytes() == before
    assert main(["sysid", "fit", "spec.yaml", "log.csv", "-o", "new/folder/r.yaml"]) in (0, 1)
    assert Path("new/folder/r.yaml").is_file()
