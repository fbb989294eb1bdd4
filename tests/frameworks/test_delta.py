"""`actspec.mjlab.delta_state` and `wrap` round a real environment of mjlab, with a free base."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from actspec.logs import load_log
from tests.frameworks.prepare import Frameworks
from tests.learn.policies import FLOATING
from tests.learn.test_delta import expected, written

onnx = pytest.importorskip("onnx")
pytestmark = pytest.mark.slow

PROBE = Path(__file__).with_name("mjlab_delta_probe.py")
PATHS = [str(Path(__file__).parents[2]), str(Path(onnx.__file__).parents[1])]
"""What actspec is imported from there, behind the frameworks' own packages."""


def test_an_environment_of_mjlab(tmp_path: Path, frameworks: Frameworks) -> None:
    """Each step is driven by default + scale * action + delta of the engine's own qpos and qvel; by a formula."""
    pytest.importorskip("torch")
    actions = np.random.default_rng(0).normal(size=(20, 2, 2))
    model = FLOATING.replace('<geom type="plane" size="5 5 .1"/>', "")
    job = {"paths": PATHS, "manifest": written(tmp_path), "model": model, "actions": actions.tolist(),
           "log": str(tmp_path / "rollout.csv")}  # fmt: skip
    run = frameworks.run_probe(PROBE, job)
    assert run.said["joints"] == ["hip", "arm"] and run.said["envs"] == 2
    assert run.said["measured"][4:6] == ["base.orientation.w", "base.orientation.x"]
    command = 0.25 * actions
    last = command[0]
    for k in range(20):
        qpos, qvel = run.arrays["qpos"][k], run.arrays["qvel"][k]
        # qvel of a free joint has its rotation in the body's axes, as a gyroscope reads it.
        measured = np.concatenate([qpos[:, 7:], qvel[:, 6:], qpos[:, 3:7], qvel[:, 3:6]], axis=1)
        assert run.arrays["state"][k] == pytest.approx(measured, abs=1e-5)
        columns = np.concatenate([measured[:, :4], last, measured[:, 4:], command[k]], axis=1)
        assert run.arrays["ctrl"][k] == pytest.approx(command[k] + expected(columns), abs=1e-5)
        last = command[k]
    # The robot fell and turned: a reading of other axes would have been seen.
    assert np.abs(run.arrays["qvel"][-1][:, 3:6]).max() > 0.1
    # The second environment's rows: read before the step, the command that it then sent, held until the next.
    kept = load_log(str(tmp_path / "rollout.csv"))
    assert kept.time == pytest.approx(0.004 * np.arange(20))
    for j, name in enumerate(("hip", "arm")):
        assert kept.joints[name].command == pytest.approx(run.arrays["ctrl"][:, 1, j], abs=1e-5)
        assert kept.joints[name].position == pytest.approx(run.arrays["qpos"][:, 1, 7 + j], abs=1e-5)
        assert kept.joints[name].velocity == pytest.approx(run.arrays["qvel"][:, 1, 6 + j], abs=1e-5)
