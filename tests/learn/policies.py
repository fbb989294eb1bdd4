"""Logs of a policy on robots that MuJoCo itself steps: the compiled file, with commands that a fault changes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from actspec import api, output
from actspec.logs import BaseLog, JointLog, Log, Sidecar, write_log
from actspec.runtime import reset
from tests.learn.pendulums import MODEL

STEP, PARTS = 0.005, 4
SPEC = """actspec: 1
robot: {name: pendulums, model: robot.xml}
timing: {physics_dt: 5 ms, decimation: 4}
actuators:
  legs: {joints: [hip, arm], level: ideal_pd, kp: 20 N*m/rad, kd: 0.5 N*m*s/rad, effort_limit: 30 N*m,
    armature: 0.02 kg*m^2, friction: {coulomb: 0 N*m, viscous: 0.1 N*m*s/rad}, action_scale: 0.25}
targets: {mujoco: {version: "3.16"}}
"""
FLOATING = """<mujoco>
  <option timestep="0.005" integrator="implicitfast"/>
  <worldbody>
    <geom type="plane" size="5 5 .1"/>
    <body name="trunk" pos="0 0 .3"><freejoint/><geom type="box" size=".2 .1 .05" mass="3"/>
      <body pos=".1 0 0"><joint name="hip" axis="0 1 0"/>
        <geom type="capsule" size=".02" fromto="0 .12 0 0 .12 -.25" mass=".4"/></body>
      <body pos="-.1 0 0"><joint name="arm" axis="0 1 0"/>
        <geom type="capsule" size=".02" fromto="0 -.12 0 0 -.12 -.25" mass=".4"/></body>
    </body>
  </worldbody>
</mujoco>
"""
Fault = Callable[[Any, Any, Any], Any]
"""Position, velocity and command to what is added to the command; shapes (2,)."""


def folder(path: Path, spec: str = SPEC, model: str = MODEL) -> Path:
    """Spec and model."""
    (path / "robot.xml").write_text(model, encoding="utf-8")
    (path / "spec.yaml").write_text(spec, encoding="utf-8")
    return path


def commands(rows: int, seed: int, size: float = 0.3) -> Any:
    """Sines of two joints, held between rows, shape (n, 2)."""
    random = np.random.default_rng(seed)
    time = STEP * PARTS * np.arange(rows)
    return np.stack(
        [
            sum(size / 3 * np.sin(2 * np.pi * f * time + p) for f, p in random.uniform(0.3, 3.0, (3, 2)))
            for _ in "ab"
        ],
        axis=1,
    )


def walk(
    path: Path, name: str, fault: Fault | None = None, *, rows: int = 200, seed: int = 0, size: float = 0.3
) -> Log:
    """Written in the folder of a spec, whose compiled file is stepped."""
    made = api.compile(str(path / "spec.yaml"), output=str(path / "build"))
    output.write(output.outputs(made))
    model = mujoco.MjModel.from_xml_path(str(path / "build/mujoco/robot.xml"))
    data = mujoco.MjData(model)
    command = commands(rows, seed, size)
    names = ("hip", "arm")
    joints = [model.joint(joint) for joint in names]
    actuators = [
        next(a for a in range(model.nu) if model.actuator_trnid[a, 0] == joint.id) for joint in joints
    ]
    q_at, v_at = [j.qposadr[0] for j in joints], [j.dofadr[0] for j in joints]
    bias = np.array([made.actuators.joint(j).encoder_bias.value or 0.0 for j in names])  # type: ignore[union-attr]
    found, base = np.empty((3, rows, 2)), np.empty((rows, 13))
    for k in range(rows):
        q, qd = data.qpos[q_at] + bias, data.qvel[v_at].copy()
        sent = command[k] + (0.0 if fault is None else fault(q, qd, command[k]))
        if k == 0:
            reset(
                model, data, command={model.actuator(a).name: c for a, c in zip(actuators, sent, strict=True)}
            )
        found[:, k] = q, qd, command[k]
        if model.nv > 2:
            base[k] = *data.qpos[:7], *data.qvel[:6]
        data.ctrl[actuators] = sent
        for _ in range(made.actuators.decimation or 1):
            mujoco.mj_step(model, data)
    logged = {
        joint: JointLog(joint, False, found[2, :, j], found[0, :, j], found[1, :, j])
        for j, joint in enumerate(names)
    }
    moved = BaseLog(base[:, :3], base[:, 3:7], base[:, 7:10], base[:, 10:]) if model.nv > 2 else None
    step = STEP * (made.actuators.decimation or 1)
    log = Log(str(path / name), "", step * np.arange(rows), logged, Sidecar(), base=moved)
    write_log(log)
    return log
