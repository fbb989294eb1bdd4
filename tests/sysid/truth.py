"""A second implementation of joints on a bench: nothing of actspec, a tenth of a millisecond, exact stick-slip."""

from __future__ import annotations

import math
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
    inertia, kp, kd, tc, b, delay, limit, mgl, bias = (
        figures[k] for k in ("J", "kp", "kd", "tc", "b", "delay", "limit", "mgl", "bias")
    )
    joints = np.arange(n)
    q, v, passed = np.zeros(n), np.zeros(n), np.zeros(n)
    read = [np.empty((n_row, n)) for _ in range(3)]

    def drive(a: Array, q: Array, v: Array) -> Array:
        found: Array = np.minimum(np.maximum(kp * (a - q - bias) - kd * v, -limit), limit)
        return found

    def net(a: Array, q: Array, v: Array) -> Array:
        return drive(a, q, v) - b * v - mgl * np.sin(q)

    def sent(at: Array, side: Any) -> Array:
        found: Array = np.clip(np.searchsorted(time, at, side=side) - 1, 0, n_row - 1)
        return found

    for row in range(n_row):
        now = time[row]
        read[0][row], read[1][row] = q + bias, passed if math.isfinite(low_pass) else v
        read[2][row] = drive(command[sent(now - delay - 1e-9, "left"), joints], q, v)
        if row == n_row - 1:
            break
        parts = max(1, round((time[row + 1] - now) / step))
        h = (time[row + 1] - now) / parts
        keep = math.exp(-2.0 * math.pi * low_pass * h) if math.isfinite(low_pass) else 0.0
        at = now + h * np.arange(parts)[:, None]
        first, last = sent(at - delay + 1e-9, "right"), sent(at + h - delay - 1e-9, "right")
        share = np.where(last > first, (time[last] + delay - at) / h, 1.0)
        given = command[first, joints] * share + command[last, joints] * (1.0 - share)
        for a in given:
            pull = net(a, q, v)
            still = v == 0.0
            held = still & (np.abs(pull) <= tc)
            way = np.where(still, np.sign(pull), np.sign(v))
            middle = v + 0.5 * h * (pull - way * tc) / inertia
            new_v = v + h * (net(a, q + 0.5 * h * v, middle) - way * tc) / inertia
            back = (way * new_v < 0.0) & ~held
            new_q = q + h * middle
            if back.any():
                until = np.where(back, v / np.where(back, v - new_v, 1.0), 1.0) * h
                stop = q + 0.5 * until * v
                again = net(a, stop, 0.0 * v)
                fresh = np.where(np.abs(again) > tc, (again - np.sign(again) * tc) / inertia, 0.0)
                left = h - until
                new_q = np.where(back, stop + 0.5 * fresh * left**2, new_q)
                new_v = np.where(back, fresh * left, new_v)
            q, was = np.where(held, q, new_q), v
            v = np.where(held, 0.0, new_v)
            passed = keep * passed + (1.0 - keep) * 0.5 * (was + v)
    return read[0], read[1], read[2]
