"""Logs with fewer rows than commands, and a drive at its limit: the cause is named, and sound logs are none of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from actspec.diagnostics import Collector
from actspec.logs import JointLog, Log, LogError, Sidecar
from actspec.sysid.checks import check
from actspec.sysid.figures import Bounds
from actspec.sysid.recording import record
from tests.sysid.test_fit import LINK, PERIOD, ROWS, TRUE, command, fitted, logged
from tests.sysid.truth import truth

pytest.importorskip("scipy")
pytestmark = pytest.mark.slow


def every(log: Log, rows: int) -> Log:
    """The log with one row in so many."""
    hip = log.joints["hip"]
    cut = {name: signal[::rows] for name, signal in hip.signals.items()}
    return replace(log, time=log.time[::rows], joints={"hip": JointLog("hip", False, **cut)})


def test_a_log_with_fewer_rows_than_commands(tmp_path: Path) -> None:
    """500 commands a second, 50 rows: 9.6 in a period of 2 pi sqrt(0.03 / 32) = 0.192 s. The fit holds each command
    until the next row, so that it acts 9 ms later on average, and the true delay is 5.3 ms."""
    with pytest.raises(LogError) as caught:
        fitted(tmp_path, every(logged(gravity=True), 10))
    (item,) = [one for one in caught.value.diagnostics if one.severity.value == "error"]
    assert (item.code, item.where) == ("SYS039", "hip")
    assert item.message.startswith("a row comes every 20 ms, ") and "other commands between" in item.message
    # Nothing is written: there are no figures that could be uncertain.
    assert "SYS030" not in {one.code for one in caught.value.diagnostics}


def test_as_few_rows_whose_commands_are_held_are_sound(tmp_path: Path) -> None:
    """As many rows, each with its command until the next."""
    period = 10 * PERIOD
    figures = {
        "J": LINK + TRUE["armature"], "kp": TRUE["kp"], "kd": TRUE["kd"], "tc": TRUE["friction.coulomb"],
        "b": TRUE["friction.viscous"], "delay": TRUE["delay"], "limit": 30.0, "mgl": 0.8 * 9.81 * 0.15,
        "bias": TRUE["encoder_bias"],
    }  # fmt: skip
    given = command()[::10]
    read = truth({name: np.array([value]) for name, value in figures.items()}, given[:, None], period)
    q, qd, torque = (part[:, 0] for part in read)
    random = np.random.default_rng(3)
    noise = random.standard_normal((2, len(given))) * np.array([[5e-4], [0.02]])
    hip = JointLog("hip", False, command=given, position=q + noise[0], velocity=qd, torque=torque + noise[1])
    log = Log("hip.csv", "0" * 64, np.arange(len(given)) * period, {"hip": hip}, Sidecar())
    found = fitted(tmp_path, log)
    assert "SYS039" not in {item.code for item in found.findings}
    assert found.joints[0].parameter("kp").value == pytest.approx(TRUE["kp"], rel=0.01)


@pytest.mark.parametrize(("limit", "clipped"), [(2.5, True), (30.0, False)])
def test_a_drive_at_its_limit_behind_noise(limit: float, clipped: bool) -> None:
    """A torque that stops at 2.5 N*m with a noise of 0.05 is clipped there; one that goes to its own peak is not."""
    figures = {
        "J": LINK + TRUE["armature"], "kp": TRUE["kp"], "kd": TRUE["kd"], "tc": TRUE["friction.coulomb"],
        "b": TRUE["friction.viscous"], "delay": 0.0, "limit": limit, "mgl": 0.8 * 9.81 * 0.15, "bias": 0.0,
    }  # fmt: skip
    read = truth({name: np.array([value]) for name, value in figures.items()}, command()[:, None], PERIOD)
    q, qd, torque = (part[:, 0] for part in read)
    random = np.random.default_rng(6)
    noise = random.standard_normal((3, ROWS)) * np.array([[5e-4], [0.02], [0.05]])
    hip = JointLog(
        "hip",
        False,
        command=command(),
        position=q + noise[0],
        velocity=qd + noise[1],
        torque=torque + noise[2],
    )
    log = Log("hip.csv", "0" * 64, np.arange(ROWS) * PERIOD, {"hip": hip}, Sidecar())
    out = Collector()
    recording = record(log, hip, out)
    assert recording is not None
    check({"hip": [recording]}, {"hip": Bounds(limit=30.0)}, {"hip": (-2.0, 2.0)}, out)
    told = [item.message for item in out.sorted() if item.code == "SYS016"]
    if not clipped:
        assert told == []
        return
    (message,) = told
    level = float(message.split("clipped at ")[1].split(" ")[0])
    assert level == pytest.approx(2.5, abs=0.05) and message.endswith("the spec's limit is 30 N*m")
