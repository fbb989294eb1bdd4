"""`actspec diagnose` on logs whose answers are worked out by hand."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import actspec
from actspec.cli.main import main
from actspec.resources import data_path
from actspec.study.level import Answers, choose_level
from actspec.study.spectra import spectrum

SPEC = """\
actspec: 1
robot: {{name: leg, model: none, joints: [hip, knee]}}
timing: {{physics_dt: 5 ms}}
sources: {{us: {{title: an example}}}}
motors:
  small:
    side: joint
    stall_torque: {{value: 20 N*m, source: us}}
    no_load_speed: {{value: 10 rad/s, source: us}}
    continuous_torque: {{value: 4 N*m, source: us}}
    bandwidth: {{value: 20 Hz, source: us}}
actuators:
  all:
    joints: [".*"]
    level: {level}
    motor: small
    kp: {{value: 20 N*m/rad, source: us}}
    kd: {{value: 1 N*m*s/rad, source: us}}
    effort_limit: {{value: 10 N*m, source: us}}
    armature: {{value: 0.01 kg*m^2, source: us}}
    friction: {{coulomb: {{value: 0 N*m, source: us}}, viscous: {{value: 0 N*m*s/rad, source: us}}}}
"""
PERIOD, ROWS = 0.005, 1000


@pytest.fixture
def leg(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "leg.yaml"
    path.write_text(SPEC.format(level="ideal_pd"))
    return path


def log(path: str, torque: Any, velocity: Any, command: Any = None, position: Any = None) -> None:
    """A log of the hip; the knee stands."""
    recorder = actspec.Recorder(["hip", "knee"], PERIOD)
    still = np.zeros(ROWS)
    q = still if position is None else position
    for k in range(ROWS):
        recorder.add(
            None if command is None else [command[k], 0.0],
            [q[k], 0.0],
            None if velocity is None else [velocity[k], 0.0],
            None if torque is None else [torque[k], 0.001 * math.sin(k)],
        )
    recorder.save(path)


def diagnosed(arguments: list[str], capsys: Any, code: int = 0) -> dict[str, Any]:
    from jsonschema import Draft202012Validator

    assert main(["diagnose", "leg.yaml", *arguments, "--output-format", "json"]) == code
    record: dict[str, Any] = json.loads(capsys.readouterr().out)
    schema = json.loads(data_path("schemas", "actspec-diagnosis-v1.schema.json").read_text("utf-8"))
    Draft202012Validator.check_schema(schema)
    Draft202012Validator(schema).validate(record)
    return record


def test_shares_by_hand(leg: Path, capsys: Any) -> None:
    """Level ideal_pd, so that the line counts though it does not act: at 6 rad/s it leaves 20 (1 - 6/10) = 8 N*m.

    Of 1000 rows 150 have 9.5 N*m at 0 (0.95 L: saturated, not within 0.2 N*m of 10), 100 have 7.9 at 6 (within
    0.2 of 8), 40 have 8.4 at 6 (0.4 past it: at the edge, not 0.5 beyond), 30 have 8.6 at 6 (0.6 past it), 20 have
    -9.9 at 6, where the brake has the whole 10 (at the edge, saturated), 660 have 1 N*m.
    """
    parts = [
        (9.5, 0.0, 150),
        (7.9, 6.0, 100),
        (8.4, 6.0, 40),
        (8.6, 6.0, 30),
        (-9.9, 6.0, 20),
        (1.0, 0.0, 660),
    ]
    torque = np.concatenate([np.full(n, t) for t, _, n in parts])
    velocity = np.concatenate([np.full(n, v) for _, v, n in parts])
    log("rollout.csv", torque, velocity)
    record = diagnosed(["rollout.csv"], capsys, 1)
    hip, knee = record["joints"]
    assert hip["torque_from"] == "log"
    assert hip["saturated"] == pytest.approx(0.17)
    assert hip["at_edge"] == pytest.approx(0.19)
    assert hip["beyond"] == pytest.approx(0.03)
    # (150 * 9.5^2 + 100 * 7.9^2 + 40 * 8.4^2 + 30 * 8.6^2 + 20 * 9.9^2 + 660) / 1000 = 27.4 -> 5.23 N*m
    assert hip["rms_torque"] == pytest.approx(math.sqrt(27.4), rel=2e-3)
    assert hip["continuous_ratio"] == pytest.approx(math.sqrt(27.4) / 4.0, rel=2e-3)
    assert (hip["peak_torque"], hip["peak_speed"], hip["tracking_rmse"]) == (9.9, 6.0, None)
    assert [item["code"] for item in record["findings"] if item["where"] == "hip"][:3] == [
        "DGN001",
        "DGN002",
        "DGN003",
    ]
    assert record["enough"] is False
    assert knee["saturated"] == 0.0
    by_action = {item["action"]: item for item in record["advice"]}
    assert by_action["torque_speed_line"]["origin"] == "log"
    assert by_action["torque_speed_line"]["joints"] == ["hip"]
    assert by_action["torque_speed_line"]["expected"]["origin"] == "reported"
    assert [item["days"] for item in record["advice"]] == sorted(item["days"] for item in record["advice"])
    assert record["level"]["recommended"] == "dc_motor"


def test_the_worst_joint_is_first(leg: Path, capsys: Any) -> None:
    """The hip is at its limit in 20 % of the rows, the knee, behind it in the spec, in 50 %."""
    recorder = actspec.Recorder(["hip", "knee"], PERIOD)
    for k in range(100):
        recorder.add(None, [0.0, 0.0], [0.0, 0.0], [9.5 if k < 20 else 1.0, 9.5 if k < 50 else 1.0])
    recorder.save("rollout.csv")
    found = [item for item in diagnosed(["rollout.csv"], capsys, 1)["findings"] if item["code"] == "DGN001"]
    assert [item["where"] for item in found] == ["knee", "hip"]
    assert "50% of the rows" in found[0]["message"]


def test_a_simulation_without_the_line_measures_no_gain_of_it(leg: Path, capsys: Any) -> None:
    """Its torque is the ideal PD law's: 20 N*m/rad on 1 rad, limited to 10 N*m, where the motor has 8 at 6 rad/s."""
    qd = np.where(np.arange(ROWS) % 2 == 0, 6.0, 0.0)
    command = np.full(ROWS, 1.0)
    log("rollout.csv", np.clip(20.0 * command - qd, -10.0, 10.0), qd, command)
    record = diagnosed(["rollout.csv"], capsys, 1)
    assert record["joints"][0]["torque_error"]["ideal_pd"]["rmse"] == 0.0
    assert record["joints"][0]["torque_error"]["dc_motor"]["rmse"] > 1.0
    expected = {item["action"]: item["expected"] for item in record["advice"]}["torque_speed_line"]
    assert (expected["origin"], expected["low"]) == ("reported", 0.10)


def test_frequencies(leg: Path, capsys: Any) -> None:
    """2 N*m at 5 Hz and 1 N*m at 40 Hz over a mean of 3: 1/5 of the variance is above the motor's 20 Hz.

    A command of 3 rad at 4 Hz and 1 rad at 30 Hz has 90 % of its variance at 4 Hz: 95 % reach to 30 Hz.
    """
    t = np.arange(ROWS) * PERIOD
    torque = 3.0 + 2.0 * np.sin(2 * np.pi * 5 * t) + np.sin(2 * np.pi * 40 * t)
    command = 3.0 * np.sin(2 * np.pi * 4 * t) + np.sin(2 * np.pi * 30 * t)
    log("rollout.csv", torque, 0.0 * t, command)
    record = diagnosed(["rollout.csv", "--fail-on", "never"], capsys)
    hip = record["joints"][0]
    assert hip["fast"] == 20.0
    assert hip["high_frequency"] == pytest.approx(0.2, rel=1e-6)
    assert hip["command_band"] == pytest.approx(30.0, rel=1e-6)
    assert hip["tracking_rmse"] == pytest.approx(math.sqrt((9 + 1) / 2), rel=1e-6)
    assert "DGN005" in {item["code"] for item in record["findings"]}


def test_a_spectrum_does_not_reach_over_gaps() -> None:
    """The same sine before and after a gap of half a period, of 128 rows each: all of it stays at 10 Hz."""
    step = 1.0 / 128.0
    time = np.concatenate([np.arange(128) * step, 5.05 + np.arange(128) * step])
    signal = np.sin(2 * np.pi * 10 * np.concatenate([time[:128], time[128:] - 5.05]))
    found = spectrum([(time, signal)])
    assert found is not None
    assert found.above(10.5) == pytest.approx(0.0, abs=1e-12)
    assert found.below_which(0.95) == pytest.approx(10.0)
    assert spectrum([(time, 0.0 * signal)]) is None


def test_which_law_is_the_robots(leg: Path, capsys: Any) -> None:
    """A torque by the line, read before the row's command is sent: level dc_motor leaves nothing, ideal_pd does.

    A second log has it under the row's own command: it is taken so, with a note.
    """
    rng = np.random.default_rng(3)
    q, qd = 0.3 * rng.standard_normal(ROWS), 6.0 * rng.standard_normal(ROWS)
    command = 0.5 * rng.standard_normal(ROWS)
    before = np.concatenate([command[:1], command[:-1]])

    def law(asked: Any) -> Any:
        high = np.minimum(10.0, 20.0 * (1.0 - np.clip(qd, -15.0, 15.0) / 10.0))
        low = np.maximum(-10.0, 20.0 * (-1.0 - np.clip(qd, -15.0, 15.0) / 10.0))
        return np.clip(20.0 * (asked - q) - 1.0 * qd, low, high)

    log("robot.csv", law(before), qd, command, q)
    record = diagnosed(["robot.csv", "--fail-on", "never"], capsys)
    errors = record["joints"][0]["torque_error"]
    assert errors["dc_motor"]["rmse"] < 1e-8
    assert errors["ideal_pd"]["rmse"] > 0.5
    # A tenth of the limit is 1 N*m.
    missed = [item for item in record["findings"] if item["code"] == "DGN006"]
    assert [item["where"] for item in missed] == (["hip"] if errors["spec"]["rmse"] > 1.0 else [])
    assert missed and record["enough"] is False
    assert record["joints"][0]["torque_late"] == 1
    # The errors of the two laws: what the line takes away was measured.
    lines = [item for item in record["advice"] if item["action"] == "torque_speed_line"]
    assert [item["expected"]["origin"] for item in lines] == ["measured"]
    assert lines[0]["expected"]["low"] == pytest.approx(1.0, abs=1e-3)
    log("own.csv", law(command), qd, command, q)
    record = diagnosed(["own.csv", "--fail-on", "never"], capsys)
    assert record["joints"][0]["torque_error"]["dc_motor"]["rmse"] < 1e-8
    assert "DGN012" in {item["code"] for item in record["notes"]}


@pytest.mark.parametrize("share, told", [(0.45, False), (0.55, True)])
def test_a_law_that_tells_little_of_a_small_torque(share: float, told: bool, leg: Path, capsys: Any) -> None:
    """0.4 sin at 1 Hz by 20 N*m/rad on 0.02 rad, and in the log m cos more, with m = 0.4 s / sqrt(1 - s^2).

    That part is s of the whole, 0.4 / sqrt(1 - s^2), and at most 0.26 N*m: within a tenth of the limit, 1 N*m RMS. Half
    is the bound.
    """
    t = np.arange(ROWS) * PERIOD
    wave, other = np.sin(2 * np.pi * t), np.cos(2 * np.pi * t)
    more = share / math.sqrt(1.0 - share**2)
    log("robot.csv", 0.4 * (wave + more * other), None, 0.02 * wave, 0.0 * t)
    record = diagnosed(["robot.csv", "--fail-on", "never"], capsys)
    # The position stands, so kd does nothing; the torque is that of the row before, 5 ms of 1 s earlier: 0.03.
    assert record["joints"][0]["torque_untold"] == pytest.approx(share, abs=0.04)
    assert record["joints"][1]["torque_untold"] is None
    assert [item["where"] for item in record["findings"] if item["code"] == "DGN006"] == ["hip"] * told


def test_columns_that_contradict_each_other_leave_no_verdict(leg: Path, capsys: Any) -> None:
    """A position in degrees beside a command in radians: the hip is not judged, nor is the model by the knee alone."""
    t = np.arange(ROWS) * PERIOD
    command = 0.3 * np.sin(2 * np.pi * t)
    log("sound.csv", 0.1 * np.cos(t), None, command, command)
    assert diagnosed(["sound.csv"], capsys, 1)["enough"] is False
    log("deg.csv", 0.1 * np.cos(t), None, command, np.rad2deg(command))
    record = diagnosed(["deg.csv"], capsys, 1)
    # The knee's torque is too fast in both.
    found = [(item["code"], item["where"]) for item in record["findings"]]
    assert found == [("SYS014", "hip"), ("DGN004", "knee")]
    assert ([one["joint"] for one in record["joints"]], record["enough"]) == (["knee"], None)
    assert "contradict" in record["skipped"][0]["reason"]
    assert main(["diagnose", "leg.yaml", "deg.csv"]) == 1
    assert "no verdict" in capsys.readouterr().out


def test_without_a_torque_the_law_gives_it(leg: Path, capsys: Any) -> None:
    """kp 20: an error of 0.25 rad at rest is 5 N*m; without a velocity the position's derivative is taken."""
    log("rollout.csv", None, None, np.full(ROWS, 0.25))
    hip = diagnosed(["rollout.csv", "--fail-on", "never"], capsys)["joints"][0]
    assert (hip["torque_from"], hip["velocity_from"]) == ("law", "position")
    assert hip["rms_torque"] == pytest.approx(5.0)
    assert hip["torque_error"] == {}


def test_a_gap_between_two_logs(leg: Path, capsys: Any) -> None:
    """The same course 20 ms later and 0.1 rad higher: sines of 2 rad at 1 Hz are apart by 2 sqrt(2) sin(pi / 50)."""
    t = np.arange(ROWS) * PERIOD
    for name, late in (("sim.csv", 0.0), ("robot.csv", 0.02)):
        phase = 2 * np.pi * (t - late)
        log(name, 0.1 * np.sin(t), 4 * np.pi * np.cos(phase), np.sin(t), 2.0 * np.sin(phase))
    gap = diagnosed(["sim.csv", "--against", "robot.csv", "--fail-on", "never"], capsys)["joints"][0]["gap"]
    assert gap["lag"] == pytest.approx(0.02, abs=2e-4)
    assert gap["position_rmse"] == pytest.approx(2.0 * math.sqrt(2.0) * math.sin(math.pi / 50.0), rel=1e-2)
    assert gap["torque_rmse"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    "current, answers, codes, recommended",
    [
        ("dc_motor", Answers(robot=False, task="jump"), (), "ideal_pd"),
        ("ideal_pd", Answers("jump", True, True), (), "actuator_net"),
        ("ideal_pd", Answers("walk", True, True), (), "dc_motor"),
        ("ideal_pd", Answers("extreme", True, False), (), "delta_action"),
        ("ideal_pd", Answers("walk", True, False), (), "ideal_pd"),
        ("ideal_pd", Answers("run", True, False), (), "dc_motor"),
        ("dc_motor", Answers("jump", True, True, 0.85), (), "dc_motor"),
        ("dc_motor", Answers("walk", True, False, 0.7), (), "actuator_net"),
        ("delta_action", Answers("walk", True, False, 0.7), (), "delta_action"),
        ("ideal_pd", Answers("walk", True, False), ("DGN002",), "dc_motor"),
        ("ideal_pd", Answers(task="run"), (), "dc_motor"),
        ("actuator_net", Answers(), (), "actuator_net"),
    ],
)
def test_levels(current: str, answers: Answers, codes: tuple[str, ...], recommended: str) -> None:
    """The tree of docs/diagnose.md."""
    assert choose_level(current, answers, codes).recommended == recommended


def test_an_answer_that_is_not_given_is_named() -> None:
    """With what it would decide."""
    why = " ".join(choose_level("ideal_pd", Answers(), ()).why)
    assert "--robot" in why and "--task" in why and "--torque-sensor" in why


@pytest.mark.parametrize(
    "arguments, said",
    [
        (["other.csv"], "no joint of the log is one of the spec"),
        (["short.csv"], "rows"),
        (["nothing.csv"], "nothing.csv"),
        (["rollout.npz"], "rollout.npz"),
        (["--transfer", "-1"], "from 0 on"),
        (["--against", "other.csv"], "needs one log"),
    ],
)
def test_what_is_refused(arguments: list[str], said: str, leg: Path, capsys: Any) -> None:
    """Exit code 2 with the file or option named."""
    recorder = actspec.Recorder(["wing"], PERIOD)
    for k in range(50):
        recorder.add([0.1 * k], [0.0])
    recorder.save("other.csv")
    Path("short.csv").write_text("time [s],hip.position [rad]\n0,0\n0.1,0\n")
    import pickle

    Path("rollout.npz").write_bytes(pickle.dumps({"time": [0.0]}))
    assert main(["diagnose", "leg.yaml", *arguments]) == 2
    assert said in capsys.readouterr().err


def test_joints_that_say_nothing_are_named(leg: Path, capsys: Any) -> None:
    """NaN everywhere, a joint of another robot beside ours, one that no log has: each with its reason."""
    recorder = actspec.Recorder(["hip", "wing"], PERIOD)
    for k in range(100):
        recorder.add([0.1 * math.sin(k), 0.0], [math.nan, 0.0])
    recorder.save("rollout.csv")
    record = diagnosed(["rollout.csv"], capsys)
    reasons = {item["joint"]: item["reason"] for item in record["skipped"]}
    assert set(reasons) == {"hip", "knee", "wing"}
    assert (record["joints"], record["enough"]) == ([], None)
    assert "rows" in reasons["hip"]


def test_readings_that_no_joint_gives(leg: Path, capsys: Any) -> None:
    """A torque of 1e200 N*m in 10 of 1000 rows, and infinity in 10 more: they count for nothing, and a note says it."""
    torque = np.ones(ROWS)
    torque[100:110], torque[200:210] = 1e200, math.inf
    log("rollout.csv", torque, np.zeros(ROWS))
    record = diagnosed(["rollout.csv", "--fail-on", "never"], capsys)
    hip = record["joints"][0]
    assert (hip["rows"], hip["peak_torque"], hip["rms_torque"]) == (ROWS - 20, 1.0, 1.0)
    (note,) = (item for item in record["notes"] if item["code"] == "DGN015")
    assert note["where"] == "hip" and "1e+12" in note["message"]


def test_a_recorder_takes_whole_rows() -> None:
    """Other shapes, other signals than in the first row, names twice: errors of Python."""
    recorder = actspec.Recorder(["a", "b"], 0.01)
    recorder.add([0.0, 1.0], [0.0, 0.0])
    with pytest.raises(ValueError, match="shape"):
        recorder.add([0.0], [0.0, 0.0])
    with pytest.raises(ValueError, match="same signals"):
        recorder.add([0.0, 0.0], [0.0, 0.0], [0.0, 0.0])
    with pytest.raises(ValueError, match="once"):
        actspec.Recorder(["a", "a"], 0.01)
    with pytest.raises(ValueError, match="period"):
        actspec.Recorder(["a"], 0.0)
    assert len(recorder) == 1


def test_a_log_of_the_spec_itself_is_not_of_another_drive(leg: Path, capsys: Any) -> None:
    """Level ideal_pd at 6 rad/s, 10 N*m where the line leaves 8: beyond the motor, and yet the law of the log."""
    speed, command = np.full(ROWS, 6.0), np.full(ROWS, 1.0)
    log("own.csv", np.full(ROWS, 10.0 - 1e-6), speed, command, 0.0 * speed)
    record = diagnosed(["own.csv", "--fail-on", "never"], capsys)
    assert "DGN002" in {item["code"] for item in record["findings"]}
    assert "DGN006" not in {item["code"] for item in record["findings"]}
    errors = record["joints"][0]["torque_error"]
    assert errors["ideal_pd"]["rmse"] == pytest.approx(1e-6, rel=1e-3)
    assert errors["dc_motor"]["rmse"] == pytest.approx(2.0, rel=1e-3)
