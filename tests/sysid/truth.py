"""A second implementation of joints on a bench: nothing of actspec, a tenth of a millisecond, exact stick-slip."""

from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]


def truth(figures: dict[str, Array], command: Array, period: float, step: float = 1e-4) -> tuple[Array, ...]:
    """Pendulums J q'' = clip(kp (a - q - bias) - kd q') - b q' - tc sign(q') - mgl sin q, from rest at 0.

    Args:
        figures: J, kp, kd, tc, b, delay, limit, mgl, bias, an array each, shape (n_joint,).
        command: At every row, shape (n_row, n_joint).
        period: Between rows [s].
        step: Of the integration [s].

    Returns: What encoder, speed and torque sensor read at the rows; a command sent at a row's time is not in it.
    """
    n_row, n = command.shape
    inertia, kp, kd, tc, b, delay, limit, mgl, bias = (
        figures[k] for k in ("J", "kp", "kd", "tc", "b", "delay", "limit", "mgl", "bias")
    )
    joints = np.arange(n)
    q, v = np.zeros(n), np.zeros(n)
    read = [np.empty((n_row, n)) for _ in range(3)]

    def drive(a: Array, q: Array, v: Array) -> Array:
        return np.clip(kp * (a - q - bias) - kd * v, -limit, limit)

    def net(a: Array, q: Array, v: Array) -> Array:
        return drive(a, q, v) - b * v - mgl * np.sin(q)

    for row in range(n_row):
        now = row * period
        before = np.clip(np.ceil((now - delay) / period - 1e-9).astype(int) - 1, 0, n_row - 1)
        read[0][row], read[1][row] = q + bias, v
        read[2][row] = drive(command[before, joints], q, v)
        for part in range(round(period / step)):
            at = now + part * step
            first = np.clip(np.floor((at - delay) / period + 1e-9).astype(int), 0, n_row - 1)
            last = np.clip(np.floor((at + step - delay) / period - 1e-9).astype(int), 0, n_row - 1)
            share = np.where(last > first, (last * period + delay - at) / step, 1.0)
            a = command[first, joints] * share + command[last, joints] * (1.0 - share)
            pull = net(a, q, v)
            still = v == 0.0
            held = still & (np.abs(pull) <= tc)
            way = np.where(still, np.sign(pull), np.sign(v))
            middle = v + 0.5 * step * (pull - way * tc) / inertia
            new_v = v + step * (net(a, q + 0.5 * step * v, middle) - way * tc) / inertia
            back = (way * new_v < 0.0) & ~held
            until = np.where(back, v / np.where(back, v - new_v, 1.0), 1.0) * step
            stop = q + 0.5 * until * v
            again = net(a, stop, 0.0 * v)
            fresh = np.where(np.abs(again) > tc, (again - np.sign(again) * tc) / inertia, 0.0)
            left = step - until
            q = np.where(held, q, np.where(back, stop + 0.5 * fresh * left**2, q + step * middle))
            v = np.where(held, 0.0, np.where(back, fresh * left, new_v))
    return read[0], read[1], read[2]
