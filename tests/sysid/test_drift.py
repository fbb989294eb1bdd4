"""Friction that changes while a log is made, and friction that does not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from actspec.logs import JointLog, Log, Sidecar
from actspec.sysid.identified import Identification
from actspec.sysid.work import FitOptions
from tests.sysid.test_fit import LINK, PERIOD, ROWS, TRUE, command, fitted
from tests.sysid.truth import truth

pytest.importorskip("scipy")
pytestmark = pytest.mark.slow


def warming(coulomb: list[float], rows: int = ROWS) -> Log:
    """Three stretches of 4 s, or as many rows, with a Coulomb friction each, 0.1 s apart, by an integrator that is not
    ours."""
    same = {
        "J": LINK + TRUE["armature"], "kp": TRUE["kp"], "kd": TRUE["kd"], "b": TRUE["friction.viscous"],
        "delay": TRUE["delay"], "limit": 30.0, "mgl": 0.8 * 9.81 * 0.15, "bias": 0.0,
    }  # fmt: skip
    figures = {name: np.full(3, value) for name, value in same.items()} | {"tc": np.array(coulomb)}
    given = np.tile(command()[:rows, None], (1, 3))
    read = [part.T.reshape(-1) for part in truth(figures, given, PERIOD)]
    random = np.random.default_rng(4)
    noise = (5e-4, 0.05, 0.02 * np.sqrt(np.mean(read[2] ** 2)))
    noisy = [part + size * random.standard_normal(len(part)) for part, size in zip(read, noise, strict=True)]
    time = (np.arange(rows) * PERIOD + np.arange(3)[:, None] * (rows * PERIOD + 0.1)).reshape(-1)
    joint = JointLog("hip", False, given.T.reshape(-1), *noisy[:2], torque=noisy[2])
    return Log("hip.csv", "0" * 64, time, {"hip": joint}, Sidecar())


NO_MORE = FitOptions(hold=frozenset({"friction.static", "friction.stribeck_velocity", "bandwidth"}))
"""Figures that friction on its way down would have tried, in most of a fit's time: they are in `test_more`."""


def drifts(found: Identification) -> list[str]:
    return [item.message for item in found.findings if item.code == "SYS045"]


def test_a_gear_that_warms_up(tmp_path: Path) -> None:
    """Coulomb 0.3, 0.25, 0.2 N*m: both figures are reported, with the joint."""
    (message,) = drifts(fitted(tmp_path, warming([0.3, 0.25, 0.2]), NO_MORE))
    first, last = (float(word) for word in message.split("(Coulomb ")[1].split(" N*m")[0].split(" and "))
    assert first == pytest.approx(0.3, abs=0.01)
    assert last == pytest.approx(0.2, abs=0.01)


@pytest.mark.parametrize(
    ("coulomb", "told"),
    [([0.3, 0.225, 0.15], True), ([0.25, 0.25, 0.25], False)],
    ids=["halved", "stays"],
)
def test_a_log_of_nine_seconds(coulomb: list[float], told: bool, tmp_path: Path) -> None:
    """Three pieces of 1 s in each third are enough."""
    assert bool(drifts(fitted(tmp_path, warming(coulomb, ROWS * 3 // 4), NO_MORE))) is told


def test_friction_that_stays(tmp_path: Path) -> None:
    """No finding: the same figures all along, and other noise."""
    assert drifts(fitted(tmp_path, warming([0.25, 0.25, 0.25]), NO_MORE)) == []
