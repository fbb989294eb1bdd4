"""Flaws that no column contradicts alone: degrees everywhere, commands that are cut off, a joint that hardly moves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from actspec.diagnostics import Collector, Diagnostic
from actspec.logs import Log
from actspec.sysid.checks import check
from actspec.sysid.figures import Bounds
from actspec.sysid.recording import record
from tests.sysid.test_fit import command, logged

pytest.importorskip("scipy")


@pytest.fixture(scope="module")
def log() -> Log:
    """Of the pendulum, without torque."""
    found = logged(gravity=True)
    return replace(found, joints={"hip": replace(found.joints["hip"], torque=None)})


def said(log: Log, **columns: np.ndarray) -> list[Diagnostic]:
    """What the checks say of the log with other columns."""
    out = Collector()
    recording = record(log, replace(log.joints["hip"], **columns), out)
    assert recording is not None
    check({"hip": [recording]}, {"hip": Bounds()}, {"hip": (-1.5, 1.5)}, out)
    return list(out.sorted())


@pytest.mark.slow
def test_a_sound_log_has_no_flaw(log: Log) -> None:
    assert said(log) == []


@pytest.mark.slow
def test_all_columns_in_degrees(log: Log) -> None:
    """57.3 times too large, all of them: only the joint's range of 3 rad tells."""
    joint = log.joints["hip"]
    turned = {name: getattr(joint, name) * 180.0 / np.pi for name in ("command", "position", "velocity")}
    (one,) = said(log, **turned)
    assert (one.code, one.severity.value, one.where) == ("SYS047", "error", "hip")
    assert "range is -1.5 to 1.5 rad" in one.message and "[deg]" in (one.help or "")


@pytest.mark.slow
def test_a_position_of_another_zero_is_only_doubted(log: Log) -> None:
    """One turn off, as a multi-turn encoder may be."""
    joint = log.joints["hip"]
    (one,) = said(log, position=joint.position + 2 * np.pi)
    assert (one.code, one.severity.value) == ("SYS047", "warning")


def test_a_joint_beyond_its_range_is_not_in_degrees(log: Log) -> None:
    """Over 1.5 times the range of 3 rad, as at a resonance: 57.3 times smaller it would fit too, and is not meant."""
    joint = log.joints["hip"]
    assert joint.position is not None
    factor = 4.8 / np.ptp(joint.position)
    found = said(log, **{name: factor * getattr(joint, name) for name in ("command", "position", "velocity")})
    assert [(one.code, one.severity.value) for one in found if one.code == "SYS047"] == [
        ("SYS047", "warning")
    ]


def test_counts_are_no_angle(log: Log) -> None:
    """Readings of an encoder with 4096 counts a turn: more than 20 times the joint's range of 3 rad."""
    joint = log.joints["hip"]
    counts = 4096 / (2 * np.pi)
    out = said(log, **{name: counts * getattr(joint, name) for name in ("command", "position", "velocity")})
    assert ("SYS047", "error") in {(one.code, one.severity.value) for one in out}


def test_readings_that_are_lost_are_counted_where_they_begin(log: Log) -> None:
    """No number in 100 rows of the velocity, from row 500: line 502 of the file, behind the header."""
    velocity = log.joints["hip"].velocity.copy()
    velocity[500:600] = np.nan
    (one,) = said(log, velocity=velocity)
    assert (one.code, one.message) == ("SYS013", "100 rows have no velocity: they are left out of it")
    assert one.span == log.span(500)


def test_a_joint_that_stops_wherever_its_command_goes(log: Log) -> None:
    """An end at 0.25 rad for a command of up to 0.6 rad either way."""
    joint = log.joints["hip"]
    assert joint.position is not None and joint.velocity is not None
    noise = 5e-4 * np.random.default_rng(1).standard_normal(len(joint.position))
    stopped = np.clip(joint.position, -0.25, 0.25) + noise
    speed = np.where(np.abs(joint.position) > 0.25, 0.0, joint.velocity)
    found = said(log, position=stopped, velocity=speed)
    assert {one.code for one in found} == {"SYS046"}
    assert "the joint stops at 0.25" in found[0].message and found[0].span is not None


def test_a_command_that_is_cut_off_is_fitted_as_it_stands(log: Log) -> None:
    """At 0.3 rad of 0.6, both ways."""
    found = said(log, command=np.clip(command(), -0.3, 0.3))
    assert [(one.code, one.severity.value) for one in found] == [("SYS046", "info")] * 2
    assert "cut off at 0.3 rad" in found[0].message


def test_a_joint_that_hardly_moves_is_refused(log: Log) -> None:
    """0.8 mrad of movement under 0.5 mrad of noise; in 20 s the jump with which the log begins is no movement."""
    joint, rows = log.joints["hip"], 5 * len(log.time)
    assert joint.position is not None
    noise = 5e-4 * np.random.default_rng(1).standard_normal(rows)
    tiny = 8e-4 * np.tile(joint.position / np.std(joint.position), 5) + noise
    tiny[:100] += 0.05
    longer = replace(log, time=0.002 * np.arange(rows))
    found = said(longer, command=np.tile(command(), 5), position=tiny, velocity=None)
    assert [(one.code, one.severity.value, one.where) for one in found] == [("SYS011", "error", "hip")]
    assert "the joint moves by 0.00" in found[0].message and "rad (standard" in found[0].message


def test_a_gap_is_no_speed(log: Log) -> None:
    """0.4 s without rows, over which the joint moved: its speed still is the position's derivative."""
    kept = np.r_[0:900, 1100:2000]
    columns = {name: getattr(log.joints["hip"], name)[kept] for name in ("command", "position", "velocity")}
    found = said(replace(log, time=log.time[kept]), **columns)
    assert {(one.code, one.severity.value) for one in found} == {("SYS013", "info")}
    assert any("0.402 s without rows" in one.message for one in found)


@pytest.mark.parametrize("slope, told", [(0.0, True), (0.3, False)])
def test_a_torque_with_noise_that_still_grows_is_not_clipped(log: Log, slope: float, told: bool) -> None:
    """Up to 3 N*m it is 40 times the error, beyond that by `slope` of it: to 3.9 N*m, nine times the noise."""
    t = log.time
    wave = 0.5 * np.sin(2 * np.pi * t) + 0.2 * np.sin(2 * np.pi * 3.3 * t + 1.0)
    position = 0.8 * np.roll(wave, 6)
    asked = 40.0 * (wave - position)
    torque = np.sign(asked) * np.where(abs(asked) < 3.0, abs(asked), 3.0 + slope * (abs(asked) - 3.0))
    torque += 0.1 * np.random.default_rng(3).standard_normal(len(t))
    columns = {"command": wave, "position": position, "velocity": np.gradient(position, t)}
    assert ("SYS016" in {one.code for one in said(log, **columns, torque=torque)}) is told


def test_a_drive_that_holds_is_not_clipped(log: Log) -> None:
    """A joint that stands against gravity has one torque for long; a limit has it while the error changes."""
    t = log.time
    level = np.where(t < 1.0, 0.2 * np.sin(2 * np.pi * 2 * t), 0.5)
    late = np.concatenate([np.full(5, level[0]), level[:-5]]) * 0.9
    position = np.round(late / 1e-3) * 1e-3
    torque = np.round(np.where(t < 1.05, 20 * (level - late), 4.0) / 0.05) * 0.05
    columns = {"command": level, "position": position, "velocity": np.gradient(late, t)}
    assert not [one for one in said(log, **columns, torque=torque.clip(-4, 4)) if one.code == "SYS016"]
    wave = 0.5 * np.sin(2 * np.pi * 2 * t)
    columns = {"command": wave, "position": 0.9 * wave, "velocity": np.gradient(0.9 * wave, t)}
    (one,) = [one for one in said(log, **columns, torque=(100 * wave).clip(-4, 4)) if one.code == "SYS016"]
    assert "the torque is clipped at 4 N*m" in one.message
