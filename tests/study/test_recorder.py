"""A recorder of an environment: which command belongs to which row, and where an episode ends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from actspec.logs import load_log
from actspec.recorder import GAP, EnvironmentRecorder


class Loop:
    """An environment whose target of step k is k; position and torque are read after it."""

    def __init__(self) -> None:
        self.k = self.begun = 0

    def step(self) -> None:
        self.k += 1

    def read(self) -> tuple[np.ndarray, ...]:
        k = float(self.k)
        return np.array([k]), np.array([10.0 * k]), np.array([0.0]), np.array([k])


def test_a_command_is_that_of_the_next_step(tmp_path: Path) -> None:
    """30 steps: the row read after step k has the target of step k + 1. An episode ends after step 12."""
    loop = Loop()
    recorder = EnvironmentRecorder(["hip"], 0.02, loop.read, lambda: loop.k == loop.begun)
    recorder.add()
    for _ in range(30):
        loop.step()
        if loop.k == 13:
            loop.begun = 13
        recorder.add()
    path = str(tmp_path / "log.csv")
    recorder.save(path)
    log = load_log(path)
    hip = log.joints["hip"]
    read = [k for k in range(30) if k != 12]
    assert hip.position == pytest.approx([10.0 * k for k in read])
    assert hip.torque == pytest.approx([float(k) for k in read])
    assert hip.command == pytest.approx([k + 1.0 for k in read])
    steps = np.diff(log.time) / 0.02
    assert steps[11] == pytest.approx(GAP)
    assert np.delete(steps, 11) == pytest.approx(1.0)
