"""One network, written once: the real classes of Isaac Lab, mjlab and Newton give its torque from one manifest."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from actspec.laws.network import NetworkLaw, sequence
from actspec.learn.files import write_network
from tests.frameworks import mjlab_asking, newton_asking
from tests.frameworks.isaaclab_asking import ask, compiled, still
from tests.frameworks.mjlab_specs import job as mjlab_job
from tests.frameworks.newton_specs import job as newton_job
from tests.frameworks.prepare import Frameworks
from tests.learn.test_files import lstm, perceptron

pytest.importorskip("torch")
pytestmark = pytest.mark.engine

GROUP = "  leg: {joints: [hip], level: actuator_net, effort_limit: 12 N*m, network: {manifest: net.json}}"
COMMANDS = (0.1, 0.3, -0.2, 0.4, 0.0)
CONVENTIONS: dict[str, Any] = {
    "inputs": "position_velocity",
    "tap_period": "5 ms",
    "position_scale": 1.0,
    "velocity_scale": 1.0,
    "torque_scale": 1.0,
}


def by_law(law: NetworkLaw) -> np.ndarray:
    """Torques along `COMMANDS` with the joint at 0."""
    error = np.array(COMMANDS)
    return np.asarray(sequence(law, error, 0.0 * error, 1))


@pytest.mark.parametrize("history", ["zero", "first_sample"])
def test_perceptron(history: str, frameworks: Frameworks, tmp_path: Path) -> None:
    """Each class keeps its own history after a reset: zeros in Isaac Lab and Newton, the first sample in mjlab."""
    write_network(
        str(tmp_path / "net"), perceptron(), {**CONVENTIONS, "taps": [0, 1], "initial_history": history}
    )
    path = str(tmp_path / "spec.yaml")
    zero, first = (
        by_law(NetworkLaw(perceptron(), (0, 1), 0.005, backfill=backfill)) for backfill in (False, True)
    )
    assert abs(zero[0] - first[0]) > 1e-3 and np.abs(zero).max() < 12.0
    if history == "first_sample":
        run = mjlab_asking.probed(frameworks, {"net": mjlab_job(GROUP, path=path, sequence=COMMANDS)})
        assert run.arrays("net")["lagged"][0, :, 0, 0] == pytest.approx(first, abs=1e-5)
        return
    run = newton_asking.probed(frameworks, {"net": newton_job(GROUP, path=path, sequence=COMMANDS)})
    assert run.arrays("net")["lagged"][0, :, 0] == pytest.approx(zero, abs=1e-5)
    assert isaaclab(frameworks, tmp_path) == pytest.approx(zero, abs=1e-5)


def test_lstm(frameworks: Frameworks, tmp_path: Path) -> None:
    """Isaac Lab's and Newton's classes keep the state of an LSTM, found by its names."""
    write_network(str(tmp_path / "net"), lstm(1), {**CONVENTIONS, "taps": [0], "initial_history": "zero"})
    expected = by_law(NetworkLaw(lstm(1), (0,), 0.005))
    one = newton_job(GROUP, path=str(tmp_path / "spec.yaml"), sequence=COMMANDS)
    run = newton_asking.probed(frameworks, {"net": one})
    assert run.arrays("net")["lagged"][0, :, 0] == pytest.approx(expected, abs=1e-5)
    assert isaaclab(frameworks, tmp_path) == pytest.approx(expected, abs=1e-5)


def isaaclab(frameworks: Frameworks, folder: Path) -> np.ndarray:
    """The torque of the real class."""
    spec = f"""actspec: 1
robot: {{name: netted, model: none, joints: [hip]}}
timing: {{physics_dt: 5 ms}}
actuators:
{GROUP.replace("level:", "armature: 0.01 kg*m^2, level:")}
"""
    emitted = compiled(spec, path=str(folder / "isaac.yaml"))
    motion = still(emitted, len(COMMANDS), 1)
    motion.positions[:, 0, 0] = COMMANDS
    return np.asarray(ask(frameworks, emitted, motion).torque[:, 0, 0])
