"""What joints do to each other between the rows of a log, and how the virtual robot moves them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from actspec import api
from actspec.logs import JointLog, Log, Sidecar
from actspec.sysid import virtual
from actspec.sysid.coupling import Path as Way
from actspec.sysid.coupling import course_of, read
from actspec.sysid.links import Links
from actspec.sysid.recording import Recording

LEG = """<mujoco><compiler angle="radian"/><worldbody><body>
  <joint name="hip" axis="0 1 0" range="-2 2"/><inertial pos="0 0 -0.2" mass="1" diaginertia="0.01 0.01 0.01"/>
  <body pos="0 0 -0.3"><joint name="knee" axis="0 1 0" range="-2 2"/>
  <inertial pos="0 0 -0.2" mass="1" diaginertia="0.01 0.01 0.01"/></body></body></worldbody></mujoco>
"""
SPEC = """actspec: 1
robot: {name: leg, model: leg.xml}
actuators:
  all: {joints: [hip, knee], level: ideal_pd, kp: 60, kd: 1, armature: 0.01, effort_limit: 40 N*m,
    velocity_limit: 20 rad/s, friction: {coulomb: 0.2, viscous: 0.01}}
"""


def recording(rows: int, period: float) -> Recording:
    """A joint that stands, of which time and command count alone."""
    time, zero = period * np.arange(rows), np.zeros(rows)
    log = Log("log.csv", "0" * 64, time, {}, Sidecar())
    off = np.zeros(rows, dtype=bool)
    starts = np.array([0])
    return Recording(log, "hip", time, zero, zero, {}, off, {}, zero, zero, zero, starts, rows)


def test_a_push_that_jumps_between_rows_moves_as_far() -> None:
    """From 0 to 1 N*m at three tenths of a row: the line gives 0.7 of a row's speed and 0.7^2 / 2 of its way."""
    rows, period, count = 6, 0.01, 10
    one = recording(rows, period)
    inertia = np.tile(np.array([[0.1, 0.05], [0.05, 0.1]]), (rows, 1, 1))
    links = Links(inertia, np.zeros((rows, 2)), np.zeros((rows, 2)))
    jumps = np.tile(20.0 * (np.arange(count) >= 3), (rows - 1, 1))
    none = np.zeros((rows - 1, count))
    zero = np.zeros(rows)
    ways = [Way(zero, zero, zero, (none, none)), Way(zero, zero, zero, (jumps, none))]
    begin, end = course_of(one, links, ways, 0).ends("load")
    assert 0.5 * (begin + end) == pytest.approx(0.7)
    assert begin / 3.0 + end / 6.0 == pytest.approx(0.7**2 / 2.0, abs=2e-3)
    # Known by row alone, the load is a straight line from row to row.
    plain = course_of(one, links, [read(one, 0.0)] * 2, 0)
    assert plain.between is None


@pytest.mark.slow
def test_steps_of_the_virtual_robot_are_of_second_order(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Half the step, a quarter of the error; velocity terms taken at a step's begin would leave a half."""
    (tmp_path / "leg.xml").write_text(LEG)
    (tmp_path / "s.yaml").write_text(SPEC)
    loaded = api.load(tmp_path / "s.yaml")
    robot = api.load_robot(loaded)
    joints = api.resolve(loaded, robot).joints
    time = 0.01 * np.arange(26)
    given = 1.2 * np.sin(2 * np.pi * 3.0 * time)
    commands = Log(
        "c.csv",
        "0" * 64,
        time,
        {name: JointLog(name, False, command=sign * given) for name, sign in (("hip", 1.0), ("knee", -1.0))},
        Sidecar(),
    )

    def speeds(step: float) -> np.ndarray:
        monkeypatch.setattr(virtual, "STEP", step)
        log = virtual.follow(robot, joints, commands, "l.csv", virtual.Flaws(), 1)
        return np.stack([_speed(log.joints[name]) for name in ("hip", "knee")])

    fine = speeds(1e-4)
    errors = [float(np.sqrt(np.mean((speeds(step) - fine) ** 2))) for step in (8e-4, 4e-4)]
    assert np.abs(fine).max() > 5.0
    # (8^2 - 1) / (4^2 - 1) = 4.2 of second order, (8 - 1) / (4 - 1) = 2.3 of first.
    assert errors[0] / errors[1] > 3.0


def _speed(joint: JointLog) -> np.ndarray:
    assert joint.velocity is not None
    return joint.velocity
