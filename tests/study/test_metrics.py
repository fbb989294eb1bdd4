"""Metrics of answers that are known in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from actspec.study.metrics import Course, chirp_metrics, step_metrics

RATE, DAMPING = 20.0, 0.5
"""Of a second-order system: natural frequency [rad/s], damping ratio."""


def answered(share: np.ndarray, period: float, size: float = 0.4) -> Course:
    n = len(share) - 1
    speed, torque = np.gradient(size * share, period), np.linspace(0.0, 10.0, n)
    return Course(period, np.full(n, size), size * share, speed, torque, 10.0)


def test_a_second_order_step() -> None:
    """wn 20, zeta 0.5: overshoot exp(-pi zeta / sqrt(1 - zeta^2)) = 0.16303; rise and settling by bisection.

    The samples are 3 ms apart: a reading of the nearest one would be off by up to 3 ms of 82 and 405.
    """
    wd = RATE * math.sqrt(1.0 - DAMPING**2)

    def share(t: np.ndarray | float) -> np.ndarray:
        t = np.asarray(t)
        return 1.0 - np.exp(-DAMPING * RATE * t) * (np.cos(wd * t) + DAMPING * RATE / wd * np.sin(wd * t))

    fine = np.arange(0.0, 1.0, 1e-6)
    exact = share(fine)
    first = [fine[np.argmax(exact >= level)] for level in (0.1, 0.9)]
    last = fine[np.flatnonzero(np.abs(exact - 1.0) > 0.02)[-1]]
    found = step_metrics(answered(share(np.arange(0.0, 1.0, 0.003)), 0.003))
    assert found.rise_time == pytest.approx(first[1] - first[0], rel=2e-3)
    assert found.overshoot == pytest.approx(0.16303, rel=2e-3)
    assert found.settling_time == pytest.approx(last, rel=2e-3)
    assert found.steady_state_error == pytest.approx(0.0, abs=1e-4)
    assert found.bandwidth is None
    # A tenth of a ramp from 0 to 10 has at least 9, to within one of 333 samples.
    assert found.saturated == pytest.approx(0.1, abs=4e-3)
    assert found.peak_torque == 10.0


def test_what_never_comes_is_none() -> None:
    """An answer that ends at 0.85 of 0.4 rad does not rise to 90 %, nor settle; 0.06 rad are left."""
    found = step_metrics(answered(0.85 * (1.0 - np.exp(-np.arange(1000) * 0.01)), 0.001))
    assert (found.rise_time, found.settling_time, found.overshoot) == (None, None, 0.0)
    assert found.steady_state_error == pytest.approx(0.4 * 0.15, rel=1e-2)


def test_the_bandwidth_of_a_first_order_lag() -> None:
    """A lag of 1 / (2 pi 5 Hz) is 3 dB down at 5 Hz; held commands and their return included, exactly by recursion."""
    period, corner = 0.002, 5.0
    swept = (2.0 * math.pi * 0.5, 2.0 * math.pi * 15.0)
    time = np.arange(650) * period
    growth = math.log(swept[1] / swept[0])
    command = np.sin(swept[0] * time[-1] / growth * np.expm1(growth * time / time[-1]))
    command = np.concatenate([command, np.zeros(350)])
    answer = np.zeros(1001)
    decay = math.exp(-2.0 * math.pi * corner * period)
    for k, asked in enumerate(command):
        answer[k + 1] = asked + (answer[k] - asked) * decay
    course = Course(period, command, answer, np.zeros(1001), np.zeros(1000), math.inf)
    found = chirp_metrics(course, swept)
    assert found.bandwidth == pytest.approx(corner, rel=5e-3)
    assert (found.saturated, found.rise_time) == (None, None)
