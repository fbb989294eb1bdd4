"""One joint on a bench with Stribeck friction, a low-pass of the command, and a drive that may be off: plain loops."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]
STEP = 1e-4


def pendulum(
    command: Array,
    period: float,
    on: Array | None = None,
    *,
    inertia: float,
    kp: float,
    kd: float,
    coulomb: float,
    viscous: float,
    mgl: float,
    delay: int,
    static: float = 0.0,
    stribeck: float = 1.0,
    lag: float = 0.0,
) -> tuple[Array, Array, Array]:
    """J q'' = on (kp (a - q) - kd q') - b q' - dry(q') sign(q') - mgl sin q; the delay in steps of 0.1 ms.

    dry(v) = coulomb + (static - coulomb) exp(-(v / stribeck)^2). Returns position, speed and torque at the rows.
    """
    parts = round(period / STEP)
    read = np.empty((3, len(command)))
    static = max(static, coulomb)
    keep = math.exp(-STEP / lag) if lag else 0.0
    q = v = 0.0
    passed = float(command[0])

    def dry(speed: float) -> float:
        return coulomb + (static - coulomb) * math.exp(-((speed / stribeck) ** 2))

    for row in range(len(command)):
        driven = on is None or bool(on[row])
        for part in range(parts):
            target = float(command[max(0, (row * parts + part - delay) // parts)])
            # What arrives at a row's time is not in what is read then.
            drive = kp * (passed - q) - kd * v if driven else 0.0
            if part == 0:
                read[:, row] = q, v, drive
            passed = target + (passed - target) * keep
            drive = kp * (passed - q) - kd * v if driven else 0.0
            net = drive - viscous * v - mgl * math.sin(q)
            if v == 0.0 and abs(net) <= static:
                continue
            way = math.copysign(1.0, net if v == 0.0 else v)
            half = v + 0.5 * STEP * (net - way * dry(v)) / inertia
            middle = q + 0.5 * STEP * v
            drive = kp * (passed - middle) - kd * half if driven else 0.0
            net = drive - viscous * half - mgl * math.sin(middle)
            new = v + STEP * (net - way * dry(half)) / inertia
            q += STEP * half
            v = 0.0 if way * new < 0.0 else new
    return read[0], read[1], read[2]
