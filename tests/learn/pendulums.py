"""Logs of two pendulums, rows of 5 ms; the drive gives 20 (command of a row ago - position) - 0.5 velocity at any time.

A row reads its torque before its own command is sent: it answers to the command of two rows before.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from actspec.logs import JointLog, Log, Sidecar, write_log

MODEL = """<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.005" integrator="implicitfast"/>
  <worldbody>
    <body><joint name="hip" axis="0 1 0"/><inertial pos="0 0 -.2" mass="1" diaginertia="1e-9 1e-9 1e-9"/></body>
    <body pos="1 0 0"><joint name="arm" axis="0 1 0"/>
      <inertial pos="0 0 -.1" mass="2" diaginertia="1e-9 1e-9 1e-9"/></body>
  </worldbody>
</mujoco>
"""
SPEC = """actspec: 1
robot: {name: pendulums, model: robot.xml}
timing: {physics_dt: 5 ms}
actuators:
  legs: {joints: [hip, arm], level: ideal_pd, kp: 20 N*m/rad, kd: 0.5 N*m*s/rad, effort_limit: 30 N*m,
    armature: 0.02 kg*m^2, friction: {coulomb: 0 N*m, viscous: 0.1 N*m*s/rad}}
"""
STEP, FINE = 0.005, 10
INERTIA = {"hip": 0.04, "arm": 0.02}
"""m l^2 of the points [kg*m^2]."""
WEIGHT = {"hip": 9.81 * 0.2, "arm": 2 * 9.81 * 0.1}
"""m g l [N*m]."""
KP, KD = 20.0, 0.5


def course(name: str, rows: int, seed: int, size: float) -> JointLog:
    """A joint that follows sines; a tenth of the rows' step in each step of the integration."""
    random = np.random.default_rng([seed, len(name), ord(name[0])])
    time = STEP * np.arange(rows)
    command = sum(
        size * np.sin(2 * np.pi * f * time + phase)
        for f, phase in zip(random.uniform(0.3, 4.0, 6), random.uniform(0, 6, 6), strict=True)
    )
    inertia, weight = INERTIA[name] + 0.02, WEIGHT[name]
    q, qd, read = 0.0, 0.0, np.empty((rows, 3))
    for k in range(rows):
        read[k] = q, qd, KP * (command[max(k - 2, 0)] - q) - KD * qd
        for _ in range(FINE):
            tau = KP * (command[max(k - 1, 0)] - q) - KD * qd
            qd += STEP / FINE * (tau - 0.1 * qd - weight * np.sin(q)) / inertia
            q += STEP / FINE * qd
    return JointLog(name, False, command, read[:, 0], read[:, 1], torque=read[:, 2])


def log(path: Path, seed: int = 0, rows: int = 2000, size: float = 0.12) -> Log:
    """Written where it is asked for."""
    found = Log(
        str(path),
        "",
        STEP * np.arange(rows),
        {name: course(name, rows, seed, size) for name in ("hip", "arm")},
        Sidecar(),
    )
    write_log(found)
    return found


def folder(path: Path) -> Path:
    """Spec and model."""
    (path / "robot.xml").write_text(MODEL, encoding="utf-8")
    (path / "spec.yaml").write_text(SPEC, encoding="utf-8")
    return path
