"""A second implementation of joints on a bench: nothing of actspec, a tenth of a millisecond, exact stick-slip."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]


def truth(
    figures: dict[str, Array],
    command: Array,
    period: float | Array,
    step: float = 1e-4,
    low_pass: float = math.inf,
) -> tuple[Array, ...]:
    """Pendulums J q'' = clip(kp (a - q - bias) - kd q') - b q' - tc sign(q') - mgl sin q, from rest at 0.

    Args:
        figures: J, kp, kd, tc, b, delay, limit, mgl, bias, an array each, shape (n_joint,).
        command: At every row, shape (n_row, n_joint).
        period: Between rows [s]; or the rows' times, shape (n_row,).
        step: Of the integration [s].
        low_pass: Cutoff of the first-order filter behind the speed sensor [Hz].

    Returns: What encoder, speed and torque sensor read at the rows; a command sent at a row's time is not in it.
    """
    n_row, n = command.shape
    time = np.arange(n_row) * period if isinstance(period, float) else period
    delay, joints = figures["delay"], np.arange(n)

    def sent(at: Array, side: Any) -> Array:
        found: Array = np.clip(np.searchsorted(time, at, side=side) - 1, 0, n_row - 1)
        return found

    told = command[sent(time[:, None] - delay - 1e-9, "left"), joints]
    rows: list[tuple[float, Array]] = []
    for now, then in pairwise(time.tolist()):
        parts = max(1, round((then - now) / step))
        h = (then - now) / parts
        at = now + h * np.arange(parts)[:, None]
        first, last = sent(at - delay + 1e-9, "right"), sent(at + h - delay - 1e-9, "right")
        share = np.where(last > first, (time[last] + delay - at) / h, 1.0)
        rows.append((h, command[first, joints] * share + command[last, joints] * (1.0 - share)))
    read = np.empty((3, n_row, n))
    for j in range(n):
        one = {name: float(values[j]) for name, values in figures.items()}
        read[:, :, j] = _moved(one, told[:, j].tolist(), [(h, a[:, j].tolist()) for h, a in rows], low_pass)
    return read[0], read[1], read[2]


def _moved(
    figures: dict[str, float], told: list[float], rows: list[tuple[float, list[float]]], low_pass: float
) -> Array:
    """What one joint's sensors read, in plain numbers: numpy takes ten times as long for a few joints."""
    inertia, kp, kd, tc, b, limit, mgl, bias = (
        figures[k] for k in ("J", "kp", "kd", "tc", "b", "limit", "mgl", "bias")
    )
    filtered = math.isfinite(low_pass)
    q = v = passed = 0.0
    read = []

    def drive(a: float, q: float, v: float) -> float:
        return min(max(kp * (a - q - bias) - kd * v, -limit), limit)

    def net(a: float, q: float, v: float) -> float:
        return drive(a, q, v) - b * v - mgl * math.sin(q)

    for a, (h, given) in zip(told, [*rows, (0.0, [])], strict=True):
        read.append((q + bias, passed if filtered else v, drive(a, q, v)))
        keep = math.exp(-2.0 * math.pi * low_pass * h) if filtered else 0.0
        for command in given:
            was, pull = v, net(command, q, v)
            if v != 0.0 or abs(pull) > tc:
                way = math.copysign(1.0, pull if v == 0.0 else v)
                middle = v + 0.5 * h * (pull - way * tc) / inertia
                new = v + h * (net(command, q + 0.5 * h * v, middle) - way * tc) / inertia
                if way * new < 0.0:
                    # To the moment at which it stands, and on if something pulls.
                    until = v / (v - new) * h
                    q += 0.5 * until * v
                    pull, left = net(command, q, 0.0), h - until
                    fresh = (pull - math.copysign(tc, pull)) / inertia if abs(pull) > tc else 0.0
                    q, v = q + 0.5 * fresh * left**2, fresh * left
                else:
                    q, v = q + h * middle, new
            passed = keep * passed + (1.0 - keep) * 0.5 * (was + v)
    return np.array(read).T
