"""A robot of three joints whose torque a small network gives, compiled for MuJoCo into a folder."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from actspec import api, output
from tests.network_files import onnx_mlp

ROBOT = """<mujoco>
  <option timestep="0.005" integrator="implicitfast"/>
  <worldbody>
    <body><joint name="hip" axis="0 1 0"/><geom size=".05" pos="0 0 -.1" mass="1"/>
      <body pos="0 0 -.2"><joint name="knee" axis="0 1 0"/><geom size=".05" pos="0 0 -.1" mass="0.5"/></body></body>
    <body pos="1 0 0"><joint name="arm" axis="0 1 0"/><geom size=".05" pos="0 0 -.1" mass="1"/></body>
  </worldbody>
  <actuator><motor name="arm_motor" joint="arm"/></actuator>
</mujoco>
"""
SPEC = """actspec: 1
robot: {name: netted, model: robot.xml}
timing: {physics_dt: 5 ms}
motors: {m: {side: joint, stall_torque: 8 N*m, no_load_speed: 10 rad/s, peak_torque: 6 N*m}}
actuators:
  legs: {joints: [hip, knee], level: actuator_net, effort_limit: 6 N*m, motor: m, network: {manifest: net.json}}
  arm: {joints: [arm], level: ideal_pd, kp: 20 N*m/rad, kd: 1 N*m*s/rad, effort_limit: 5 N*m, armature: 0.01 kg*m^2}
targets: {mujoco: {version: "3.11"}}
"""
TAPS = (0, 2)
WEIGHTS = np.array([[20.0, 4.0, -0.5, -0.1], [10.0, -3.0, -0.2, 0.05]])
"""Of error now and two samples ago, then of the velocity; no two alike."""


def layers() -> list[tuple[Any, Any, str]]:
    """tanh of two sums, and what they are worth."""
    return [(WEIGHTS, [0.01, -0.02], "Tanh"), ([[5.0, 3.0]], [0.1], "")]


def build(folder: Path, *, history: str = "first_sample", spec: str = SPEC) -> Path:
    """The folder that `compile` writes for MuJoCo."""
    import hashlib

    data = onnx_mlp(layers())
    (folder / "net.onnx").write_bytes(data)
    manifest = {
        "format": "actspec-network/1",
        "kind": "mlp",
        "inputs": "position_velocity",
        "taps": list(TAPS),
        "tap_period": "5 ms",
        "position_scale": 1.0,
        "velocity_scale": 1.0,
        "torque_scale": 1.0,
        "initial_history": history,
        "files": {"onnx": {"path": "net.onnx", "sha256": hashlib.sha256(data).hexdigest()}},
        "range": {
            "error": {"low": -0.9, "high": 0.9, "least": -1.0, "most": 1.0},
            "velocity": {"low": -4.0, "high": 4.0, "least": -5.0, "most": 5.0},
        },
    }
    (folder / "net.json").write_text(json.dumps(manifest), encoding="utf-8")
    (folder / "robot.xml").write_text(ROBOT, encoding="utf-8")
    (folder / "spec.yaml").write_text(spec, encoding="utf-8")
    made = api.compile(str(folder / "spec.yaml"), output=str(folder / "build"))
    output.write(output.outputs(made))
    return folder / "build" / "mujoco"


def torques(error: Any, velocity: Any, *, backfill: bool = True) -> Any:
    """The torque of each step by the formula, clamped by limit and line; shapes (n_step, n_joint)."""
    found = np.empty_like(error)
    for k in range(len(error)):
        rows = []
        for past in (error, velocity):
            for tap in TAPS:
                rows.append(past[max(k - tap, 0)] if backfill or k >= tap else 0.0 * past[0])
        hidden = np.tanh(np.einsum("hi,ij->hj", WEIGHTS, np.array(rows)) + np.array([[0.01], [-0.02]]))
        tau = 5.0 * hidden[0] + 3.0 * hidden[1] + 0.1
        x = np.clip(velocity[k], -10.0 * (1 + 6 / 8), 10.0 * (1 + 6 / 8)) / 10.0
        found[k] = np.clip(tau, np.maximum(-6.0, 8.0 * (-1.0 - x)), np.minimum(6.0, 8.0 * (1.0 - x)))
    return found
