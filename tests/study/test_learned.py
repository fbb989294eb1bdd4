"""Networks in `compare` and `diagnose`: against steps of our own by the network's formula."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import actspec
from actspec.cli.main import main
from actspec.ir import Command
from actspec.laws import TorqueLaw
from actspec.laws.network import NetworkDrive, NetworkLaw, sequence
from actspec.study.learned import Sampled, along, near
from actspec.study.variants import Assumed
from tests.learn import netted
from tests.learn.test_files import lstm
from tests.study.test_compare import compared

pytest.importorskip("onnx")


@pytest.fixture(scope="module")
def spec(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("net")
    netted.build(folder)
    return folder / "spec.yaml"


def let_go(inertia: float, size: float, steps: int, fine: int) -> tuple[np.ndarray, np.ndarray]:
    """A joint of the network, whose formula is asked every 5 ms and held, in semi-implicit steps of a part of that:
    position and torque from the change of its command on, which comes after two steps."""
    h = 0.005 / fine
    error: list[float] = []
    velocity: list[float] = []
    q = qd = 0.0
    course, torques = [0.0], []
    for k in range(steps + 2):
        error.append(size * (k >= 2) - q)
        velocity.append(qd)
        (torque,) = netted.torques(np.array(error)[-3:, None], np.array(velocity)[-3:, None])[-1]
        for _ in range(fine):
            qd += h * torque / inertia
            q += h * qd
            course.append(q)
            torques.append(torque)
    return np.array(course[2 * fine :]), np.array(torques[2 * fine :])


@pytest.mark.slow
def test_a_network_answers_as_its_formula(spec: Path) -> None:
    """Limit 6 N*m: the step is the error at which the formula, at rest, gives 3 N*m more than at none.

    The hip has 1 kg at 0.1 m, 0.5 kg at 0.3 m and two balls of 5 cm: 0.01 + 0.045 + 1.5 * 0.4 * 0.0025 kg*m^2.
    """
    found = compared(spec, Assumed(), 0.5)
    rows = {(row.actuator.joint, row.variant, row.course): row for row in found.rows}
    step, swing = rows["hip", "spec", "step"], rows["hip", "network", "swing"]

    def at_rest(error: float) -> float:
        return float(netted.torques(np.full((3, 1), error), np.zeros((3, 1)))[-1, 0])

    low, high = 0.0, 0.2
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if at_rest(middle) - at_rest(0.0) < 3.0 else (low, middle)
    assert step.amplitude == pytest.approx(low, rel=1e-3)
    assert swing.amplitude == pytest.approx(4.0 * low, rel=1e-3)
    assert step.inertia == pytest.approx(0.01 + 0.045 + 1.5 * 0.4 * 0.0025)
    course, torques = let_go(step.inertia, step.amplitude, 100, 500)
    share, h = course / step.amplitude, 1e-5
    metrics = step.law_metrics
    assert metrics.rise_time == pytest.approx(
        h * (np.argmax(share >= 0.9) - np.argmax(share >= 0.1)), rel=0.01
    )
    assert metrics.overshoot == pytest.approx(share.max() - 1.0, rel=0.01)
    assert metrics.peak_torque == pytest.approx(np.abs(torques).max(), rel=0.01)
    # MuJoCo's steps are as long as those in which the torque is held: it is that of semi-implicit steps of 5 ms.
    coarse, _ = let_go(step.inertia, step.amplitude, 100, 1)
    assert step.simulated is not None
    assert step.simulated.answer == pytest.approx(coarse, abs=1e-5 * step.amplitude)
    # A joint's own line is no part of the network alone: 4 rad/s leave 4.8 of 6 N*m.
    assert {row.variant for row in found.rows if row.actuator.joint == "hip"} == {"network", "spec"}
    assert {row.variant for row in found.rows if row.actuator.joint == "arm"} == {"ideal_pd", "spec"}


def test_a_network_is_a_level_of_the_torques_error(
    spec: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A log whose torques are the formula's, the command of a row acting from it on: nothing is left."""
    monkeypatch.chdir(spec.parent)
    rng, n = np.random.default_rng(2), 400
    t = 0.005 * np.arange(n)
    q = np.stack([0.02 * np.sin(9 * t), 0.03 * np.sin(7 * t)], axis=1)
    qd = np.stack([0.18 * np.cos(9 * t), 0.21 * np.cos(7 * t)], axis=1)
    command = q + 0.02 * rng.standard_normal((n, 2))
    before = np.concatenate([command[:1], command[:-1]])
    torque = netted.torques(before - q, qd)
    recorder = actspec.Recorder(["hip", "knee"], 0.005)
    for k in range(n):
        recorder.add(command[k], q[k], qd[k], torque[k])
    recorder.save("log.csv")
    assert main(["diagnose", "spec.yaml", "log.csv", "--output-format", "json", "--fail-on", "never"]) == 0
    record = json.loads(capsys.readouterr().out)
    for joint in record["joints"]:
        errors = joint["torque_error"]
        assert set(errors) == {"actuator_net", "spec"}
        assert errors["actuator_net"]["rmse"] < 1e-5
        assert joint["torque_late"] == 1
        # The motor's line is known though the spec has no PD.
        assert joint["beyond"] == 0.0
    assert record["level"]["current"] == "actuator_net"


def clip(cutoff: float | None = None) -> TorqueLaw:
    return TorqueLaw(Command.EFFORT, 0.0, 0.0, 100.0, None, None, None, 0.1, cutoff, 0.0)


def test_a_log_of_another_rate_and_with_a_gap() -> None:
    """Taps 10 ms apart in a log of 5 ms with a gap of 0.5 s: as the law in steps, nothing over the gap or before it.

    Of an LSTM the state settles over 20 samples before it is believed.
    """
    h, n = 0.005, 600
    time = h * np.arange(n)
    time[300:] += 0.5
    q, qd = np.sin(5 * time), 5 * np.cos(5 * time)
    command = np.sin(5 * time + 0.3)
    dense = NetworkLaw(_layers(), (0, 2), 0.01)
    found = along(Sampled(NetworkDrive(dense, clip()), h), time, command, q, qd)
    wanted = np.concatenate(
        [sequence(dense, (command - q)[part], qd[part], 1) for part in (slice(300), slice(300, n))]
    )
    known = np.isfinite(found)
    assert np.flatnonzero(~known).tolist() == [0, 1, 300, 301]
    assert found[known] == pytest.approx(wanted[known])
    recurrent = NetworkLaw(lstm(2), (0,), h)
    found = along(Sampled(NetworkDrive(recurrent, clip()), h), time[:300], command[:300], q[:300], qd[:300])
    wanted = sequence(recurrent, (command - q)[:300], qd[:300], 1)
    assert np.isnan(found[:20]).all()
    assert found[20:] == pytest.approx(wanted[20:], abs=1e-3)


def _layers() -> Any:
    from actspec.laws.network import Dense, Layers

    return Layers(
        (), (Dense(netted.WEIGHTS, np.zeros(2), "tanh"), Dense(np.array([[5.0, 3.0]]), np.zeros(1)))
    )


def test_a_network_that_pushes_away_is_none() -> None:
    """Its torque is against the command: there is no PD like it, and a text says so."""
    away = NetworkLaw(_layers(), (0, 1), 0.005, torque_scale=-1.0)
    assert near(NetworkDrive(away, clip())) == "its network at rest does not pull towards the command"
