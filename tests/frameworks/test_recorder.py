"""`actspec.isaaclab.recorder` on Isaac Lab's own articulation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from actspec.logs import load_log
from tests.frameworks.isaaclab_asking import WHEELS
from tests.frameworks.prepare import Frameworks
from tests.frameworks.test_delta import PATHS

pytestmark = [pytest.mark.engine, pytest.mark.slow]
PROBE = Path(__file__).with_name("isaaclab_recorder_probe.py")
STEPS, END = 40, 15


def test_a_log_of_an_articulation(tmp_path: Path, frameworks: Frameworks) -> None:
    """Rows have what is read after a step, and the target of the next; the torque is that of DCMotor's last call.

    20 (target - q) - 0.5 qd, at the state before the last physics step, within 3 N*m and 4 (1 - qd / 8) N*m.
    """
    actions = np.random.default_rng(1).uniform(-0.4, 0.4, (STEPS, 2, 3)).astype(np.float32)
    root = frameworks.isaaclab(WHEELS["2.3"])
    job = {
        "root": str(root),
        "paths": PATHS,
        "log": str(tmp_path / "log.csv"),
        "actions": actions.tolist(),
        "end": END,
    }
    run = frameworks.run_probe(PROBE, job)
    assert run.said == {"class": "isaaclab.assets.articulation.articulation", "drive": "DCMotor"}
    q, qd, torque = (run.arrays[name] for name in ("q", "qd", "torque"))
    log = load_log(str(tmp_path / "log.csv"))
    # The row before the end has no command that was read, and after it an episode begins.
    kept = [k for k in range(STEPS) if k != END]
    for j, name in enumerate(("hip", "knee", "rail")):
        joint = log.joints[name]
        assert joint.linear == (name == "rail")
        assert joint.command == pytest.approx(actions[kept, 1, j], abs=1e-6)
        assert joint.position == pytest.approx(q[kept, j], abs=1e-6)
        assert joint.velocity == pytest.approx(qd[kept, j], abs=1e-6)
        assert joint.torque == pytest.approx(torque[kept, j], abs=1e-6)
    assert np.diff(log.time)[END - 1] == pytest.approx(100 * 0.02)
    # One step by hand: four physics steps of 5 ms under the target of row 3.
    p, v, tau = q[3].astype(float), qd[3].astype(float), np.zeros(3)
    for _ in range(4):
        tau = 20.0 * (actions[3, 1] - p) - 0.5 * v
        tau = np.clip(tau, np.maximum(-3.0, 4.0 * (-1.0 - v / 8.0)), np.minimum(3.0, 4.0 * (1.0 - v / 8.0)))
        v = v + 0.005 * tau / 0.1
        p = p + 0.005 * v
    assert q[4] == pytest.approx(p, abs=1e-5)
    assert torque[4] == pytest.approx(tau, abs=1e-4)
