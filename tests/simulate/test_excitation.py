"""The grid that engines are asked over: what is on it, by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from actspec.ir import Command
from actspec.laws import TorqueLaw
from actspec.simulate.excitation import (
    BEFORE,
    HELD,
    RAMP,
    HeldMotion,
    command_for,
    corner_speeds,
    held_motions,
    rest_position,
)
from tests.verify.making import Built, build

PD = TorqueLaw(Command.POSITION, 40.0, 1.5, 20.0, None, None, None, 0.02, None, 0.0)
LINE = replace(PD, stall_torque=50.0, no_load_speed=30.0)
CURVE = replace(PD, curve=(20.0, 25.0, 14.0, 30.0), effort_limit=10.0)


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """The rich spec, compiled."""
    return build(tmp_path_factory.mktemp("rich"))


@pytest.mark.parametrize(
    "law, speeds",
    [
        (PD, []),
        # knee 30 (1 - 20/50) = 18, no load 30, over-speed 30 (1 + 20/50) = 42
        (LINE, [18.0, 30.0, 42.0]),
        # knee and no load; L = 10 meets 20 (1 - x) and 25 (1 - x) at x = 0.5 and 0.6 of the way from 14 to 30
        (CURVE, [14.0, 30.0, 22.0, 23.6]),
    ],
    ids=["pd", "line", "curve"],
)
def test_corners_of_the_clamp(law: TorqueLaw, speeds: list[float]) -> None:
    """The speeds at which a clamp bends are those of its lines' crossings."""
    assert corner_speeds(law) == pytest.approx(speeds)


def test_commands_ask_for_a_torque() -> None:
    """40 (u - (0.1 + 0.02)) - 1.5 * 2 = 9 N*m gives u = 0.42; with a speed command 1.5 (u - 2) = 9 gives 8."""
    assert command_for(PD, 9.0, 0.1, 2.0) == pytest.approx(0.42)
    assert command_for(replace(PD, command=Command.VELOCITY), 9.0, 0.1, 2.0) == pytest.approx(8.0)
    assert command_for(replace(PD, command=Command.EFFORT), 9.0, 0.1, 2.0) == pytest.approx(9.0)


def grid(built: Built, law: TorqueLaw) -> dict[str, HeldMotion]:
    """Motions of one joint, 5 ms steps."""
    return held_motions([law], [built.compilation.actuators.joints[0]], 0.005)


def test_grid_has_corners_limits_and_both_signs(built: Built) -> None:
    """At every corner speed, both ways, torques of 0, the limit, twice the limit and their negatives are asked for."""
    motion = grid(built, LINE)["torque"]
    assert motion.q.shape == (1, motion.q.shape[1], 1)
    asked = 40.0 * (motion.command - motion.q - 0.02) - 1.5 * motion.qd
    pairs = {
        (round(float(t), 6), round(float(w), 6))
        for t, w in zip(asked[0, :, 0], motion.qd[0, :, 0], strict=True)
    }
    for speed in (0.0, 18.0, 30.0, 42.0, 60.0):
        for torque in (0.0, 20.0, 40.0):
            assert {(a * torque, b * speed) for a in (1, -1) for b in (1, -1)} <= pairs
    assert np.ptp(motion.q) > 0.05


def test_histories_step_and_ramp(built: Built) -> None:
    """The command is held, then steps or ramps by 0.5 L / kp = 0.25 rad, up in one environment, down in the other."""
    found = grid(built, LINE)
    step, ramp = found["torque.step"].command[:, :, 0], found["torque.ramp"].command[:, :, 0]
    start = HELD + 0.02
    assert step[:BEFORE] == pytest.approx(start) and ramp[: BEFORE + 1] == pytest.approx(start)
    assert step[BEFORE] == pytest.approx([start + 0.25, start - 0.25])
    assert ramp[BEFORE + RAMP // 2] == pytest.approx([start + 0.125, start - 0.125])
    assert ramp[-1] == pytest.approx([start + 0.25, start - 0.25])
    # 2 steps of delay and 14 others
    assert len(step) == 2 + RAMP + 4 + 2
    assert np.all(found["torque.step"].qd == 0.0)


def test_history_is_long_enough_for_a_filter(built: Built) -> None:
    """A filter of 2 Hz is followed for 5 time constants: 5 / (2 pi 2 Hz 5 ms) = 79.6 steps more."""
    assert len(grid(built, replace(LINE, filter_cutoff=2.0))["torque.step"].q) == 2 + RAMP + 4 + 2 + 80


@pytest.mark.parametrize(
    "ends, middle",
    [((-1.9, -0.9), -1.4), ((-np.inf, 2.0), 2.0), ((1.0, np.inf), 1.0), (None, 0.0)],
    ids=["both", "upper", "lower", "none"],
)
def test_joint_is_where_its_command_may_be(ends: tuple[float, float] | None, middle: float) -> None:
    """A clamped command is followed inside its range, or nothing of it would be seen."""
    assert rest_position(replace(PD, command_range=ends)) == pytest.approx(middle)
