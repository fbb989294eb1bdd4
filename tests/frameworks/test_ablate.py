"""The train.py of an ablation in the real mjlab: what each variant trains, and a short training on the CPU."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from actspec.cli.main import main
from actspec.verify.environments import EngineUnavailableError
from tests.frameworks.prepare import Frameworks, training

PROBE = Path(__file__).with_name("training_probe.py")
GO1 = Path(__file__).resolve().parents[2] / "robots" / "go1.yaml"
CUTOFF = 8.0
SHORT = 0.1
"""Length of an episode [s], so that some end within an iteration."""
SMALLER = {
    "  cfg.sim.mujoco.timestep = TIMESTEP\n": f"  cfg.episode_length_s = {SHORT}\n",
    "  cfg.agent.max_iterations = iterations\n": "  cfg.agent.num_steps_per_env = 6\n",
}
"""Line of the script to what is put behind it: nothing is learned here."""


@pytest.mark.slow
def test_training_in_mjlab(
    frameworks: Frameworks, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    """C is A with a filter of 8 Hz and nothing else, begins where the joints are, and leaves a result to collect."""
    try:
        packages = training(frameworks)
    except EngineUnavailableError as err:
        (pytest.fail if os.environ.get("CI") else pytest.skip)(f"no training: {err}")
    monkeypatch.chdir(tmp_path)
    command = ["ablate", str(GO1), "-o", "out", "--filter", f"{CUTOFF:g}Hz", "--fail-on", "never"]
    assert main(command) == 0
    script = tmp_path / "out/train.py"
    # Yours to edit.
    text = script.read_text(encoding="utf-8")
    for line, more in SMALLER.items():
        assert text.count(line) == 1
        text = text.replace(line, line + more)
    script.write_text(text, encoding="utf-8")
    arguments = ["C_bandwidth", "--seed", "3", "--iterations", "1", "--envs", "4"]
    request = {"script": str(script), "arguments": arguments, "packages": str(packages)}
    said, arrays = frameworks.run_probe(PROBE, request, timeout=600)
    assert said["code"] == 0
    assert said["rates"] == [0.005, 4]
    position = ["BuiltinPositionActuatorCfg"]
    assert said["classes"] == {
        "A_ideal_pd": position,
        "B_dc_motor": ["DcMotorActuatorCfg"],
        "C_bandwidth": ["XmlActuatorCfg"],
        "D_ideal_pd_dr": position,
    }
    own = {name: set(events) for name, events in said["events"].items()}
    assert own["C_bandwidth"] - own["A_ideal_pd"] == {"settle_filters"}
    assert own["B_dc_motor"] == own["A_ideal_pd"] and own["D_ideal_pd_dr"] > own["A_ideal_pd"]
    # Twelve actuators with mjlab's own model, alike but for the filter's time 1 / (2 pi 8 Hz).
    for key in ("gainprm", "biasprm", "forcerange", "actearly", "armature", "damping", "frictionloss"):
        np.testing.assert_array_equal(arrays[f"C_bandwidth.{key}"], arrays[f"A_ideal_pd.{key}"], key)
        assert len(arrays[f"C_bandwidth.{key}"]) == 12
    assert not arrays["A_ideal_pd.dyntype"].any() and arrays["C_bandwidth.dyntype"].all()
    times = arrays["C_bandwidth.dynprm"][:, 0]
    np.testing.assert_allclose(times, 1.0 / (2.0 * math.pi * CUTOFF), rtol=1e-12)
    assert arrays["act"].shape == (4, 12)
    np.testing.assert_allclose(arrays["act"], arrays["q"], atol=1e-6)
    assert np.abs(arrays["q"]).max() > 1.0
    result = json.loads((tmp_path / "out/runs/C_bandwidth-seed3/result.json").read_text(encoding="utf-8"))
    assert (result["variant"], result["seed"], result["iterations"]) == ("C_bandwidth", 3, 1)
    assert math.isfinite(result["reward"]) and result["tracking_error"] >= 0.0
    assert 0.0 < result["episode_length"] <= SHORT / 0.02
    capsys.readouterr()
    assert main([*command, "--output-format", "json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["training"]
    assert (row["variant"], row["reward"], row["reward_std"], row["seeds"]) == (
        "C_bandwidth",
        result["reward"],
        None,
        [3],
    )
