"""Figures of step answers whose closed forms are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from actspec.diagnostics import Collector
from actspec.logs import JointLog, Log, Sidecar
from actspec.sysid.figures import Bounds
from actspec.sysid.recording import Recording, record
from actspec.sysid.step import Step, counted, steps, unit_step

pytest.importorskip("scipy")

PERIOD = 0.002


def answers(
    sizes: list[float],
    natural: float,
    damping: float,
    held: float = 1.0,
    noise: float = 0.0,
    torque: float = 0.0,
) -> Recording:
    """A second-order joint that is 3 ms late, under levels in turn; every level is held as long."""
    rows = round(held / PERIOD)
    time = np.arange(rows * len(sizes)) * PERIOD
    command = np.repeat(sizes, rows)
    position = np.zeros(len(time))
    for k, (before, after) in enumerate(zip([0.0, *sizes], sizes, strict=False)):
        position += (after - before) * unit_step(time - k * held - 0.003, natural, damping)
    position += noise * np.random.default_rng(2).standard_normal(len(time))
    joint = JointLog(
        "hip", False, command=command, position=position,
        torque=np.minimum(torque, np.linspace(0.0, 2.0 * torque, len(time))) if torque else None,
    )  # fmt: skip
    log = Log("steps.csv", "0" * 64, time, {"hip": joint}, Sidecar())
    found = record(log, joint, Collector())
    assert found is not None
    return found


def mean(found: list[Step], name: str) -> float:
    values = [value for step in found if (value := getattr(step, name)) is not None]
    assert values, name
    return float(np.mean(values))


def test_answer_of_the_second_order_system() -> None:
    """At its first top, at pi / wd, it is 1 + exp(-pi zeta / sqrt(1 - zeta^2)); critically damped it has a limit."""
    root = math.sqrt(1 - 0.4**2)
    assert unit_step(np.array([-1.0, math.pi / (30 * root)]), 30.0, 0.4) == pytest.approx(
        [0.0, 1 + math.exp(-math.pi * 0.4 / root)]
    )
    t = np.array([0.03])
    # 1 - exp(-x) (1 + x), x = 0.9.
    assert unit_step(t, 30.0, 1.0) == pytest.approx([1 - 1.9 * math.exp(-0.9)])
    assert unit_step(t, 30.0, 1.0 + 1e-5) == pytest.approx([1 - 1.9 * math.exp(-0.9)], rel=1e-4)


def test_closed_forms() -> None:
    """Overshoot exp(-pi zeta / sqrt(1 - zeta^2)); the times by bisection of the closed form at 0.1 us."""
    found = steps(answers([0.0, 0.4, -0.3, 0.2], 30.0, 0.4), Bounds(), None)
    assert len(found) == 3 and not counted(found) and not any(step.cut_off for step in found)
    fine = np.arange(0, 1, 1e-6)
    course = unit_step(fine, 30.0, 0.4)
    rise = fine[np.argmax(course >= 0.9)] - fine[np.argmax(course >= 0.1)]
    settled = fine[np.flatnonzero(np.abs(course - 1) > 0.02)[-1]] + 0.003
    for step in found:
        # Between rows: a tenth of a row.
        assert step.rise_time == pytest.approx(rise, abs=2e-4)
        assert step.settling_time == pytest.approx(settled, abs=2e-4)
        assert step.overshoot == pytest.approx(math.exp(-math.pi * 0.4 / math.sqrt(0.84)), abs=2e-4)
        assert step.natural_frequency == pytest.approx(30.0, rel=1e-4)
        assert step.damping_ratio == pytest.approx(0.4, rel=1e-4)
        assert step.delay == pytest.approx(0.003, abs=1e-5)
        assert step.steady_state_error == pytest.approx(0.0, abs=1e-5)


def test_noise_is_no_overshoot() -> None:
    """Over-damped, 1 mrad of noise: the greatest reading lies above rest, the answer does not."""
    found = steps(answers([0.0, 0.4, -0.3, 0.2], 30.0, 1.5, noise=1e-3), Bounds(), None)
    assert mean(found, "overshoot") < 0.002
    assert mean(found, "damping_ratio") == pytest.approx(1.5, rel=0.03)
    assert mean(found, "natural_frequency") == pytest.approx(30.0, rel=0.03)


def test_what_is_cut_off_has_no_settling_time() -> None:
    """0.15 s of an answer that rings for a second: frequency and damping show, where it comes to rest does not."""
    recording = answers([0.0, 0.4], 30.0, 0.1, held=0.15)
    (step,) = steps(recording, Bounds(), None)
    assert step.cut_off and step.left_out is None
    for name in ("final", "rise_time", "overshoot", "settling_time", "steady_state_error"):
        assert getattr(step, name) is None, name
    assert step.natural_frequency == pytest.approx(30.0, rel=0.01)
    assert step.damping_ratio == pytest.approx(0.1, rel=0.05)


def test_steps_that_do_not_count() -> None:
    """A level left before the joint rests, one of 5 mrad in 1 mrad of noise, and a drive at its limit of 8 N*m."""
    found = steps(answers([0.0, 0.4, -0.3], 30.0, 0.1, held=0.15), Bounds(), None)
    assert counted(found) == {"not at rest before it": 1}
    found = steps(answers([0.0, 0.005, 0.4], 30.0, 0.7, noise=1e-3), Bounds(), None)
    assert counted(found) == {"too small": 1}
    clipped = answers([0.0, 0.4, -0.3], 30.0, 0.7, torque=8.0)
    assert counted(steps(clipped, Bounds(8.0), None)) == {"saturated": 2}
    assert not counted(steps(clipped, Bounds(9.0), None))
    # Without torque by kp: 20 N*m/rad times 0.4 rad and 0.7 rad are 8 and 14 N*m.
    blind = answers([0.0, 0.4, -0.3], 30.0, 0.7)
    assert counted(steps(blind, Bounds(10.0), (20.0, 0.5))) == {"saturated": 1}
