"""Wild readings and frozen ones are found; what a joint and a coarse encoder do is not."""

from __future__ import annotations

import numpy as np
import pytest

from actspec.sysid.recording import longest_step, scatter, smooth
from actspec.sysid.spoilt import frozen, jumps, texture, wild

pytest.importorskip("scipy")

T = 0.002 * np.arange(4000)
CHIRP = 0.4 * np.sin(2 * np.pi * (0.2 + 0.6 * T) * T)
"""0.2 Hz to 9.8 Hz; its greatest speed is 25 rad/s, 50 mrad a row."""
COUNT = 2 * np.pi / 4096
NOISE = 5e-4 * np.random.default_rng(0).standard_normal(len(T))


def ringing() -> np.ndarray:
    """Steps of a stiff joint every 0.5 s, which rings at 12 Hz; between them it rests."""
    found, level = np.zeros(len(T)), 0.0
    for k, target in enumerate((0.3, -0.2, 0.25, -0.3, 0.1, 0.35, -0.1, 0.2) * 2):
        rows = slice(250 * k, 250 * k + 250)
        t = T[rows] - T[250 * k]
        found[rows] = target + (level - target) * np.exp(-25 * t) * np.cos(2 * np.pi * 12 * t)
        level = target
    return found


def sticking() -> np.ndarray:
    """A joint that stands while the command passes over 0.1 rad, then follows: a slow triangle behind a dead band."""
    triangle = 0.2 * np.abs((0.25 * T) % 2 - 1)
    found = np.empty_like(T)
    value = triangle[0]
    for i, now in enumerate(triangle):
        value = min(max(value, now - 0.05), now + 0.05)
        found[i] = value
    return found


@pytest.mark.parametrize(
    "course", [CHIRP + NOISE, np.round(CHIRP / COUNT) * COUNT, CHIRP], ids=["noise", "counts", "exact"]
)
def test_wild_readings_are_found_and_no_others(course: np.ndarray) -> None:
    """Singles, a pair and a triple of 0.5 rad, one of them where the joint is fastest."""
    rows = [100, 777, 778, 1500, 2500, 2501, 2502, 3333, 3990]
    spoilt = course.copy()
    spoilt[rows] += 0.5 * np.array([1, -1, -1, 1, 1, 1, 1, -1, 1])
    assert np.flatnonzero(wild(spoilt)).tolist() == rows
    assert not wild(course).any()


@pytest.mark.parametrize("course", [ringing(), sticking()], ids=["ringing", "sticking"])
@pytest.mark.parametrize("sensor", ["exact", "noise", "counts"])
@pytest.mark.parametrize("every", [1, 5])
def test_what_joints_do_is_not_wild(course: np.ndarray, sensor: str, every: int) -> None:
    """At 500 Hz and at 100 Hz: kinks where it breaks away, and steps within few rows."""
    read = {"exact": course, "noise": course + NOISE, "counts": np.round(course / COUNT) * COUNT}[sensor]
    assert not wild(read[::every]).any()


def test_a_torque_may_jump_where_its_command_does() -> None:
    """A pulse of the command makes one of the torque; one without a command is wild."""
    command, torque = np.zeros(len(T)), 0.05 * np.sin(T) + 100 * NOISE
    command[1000:1002] = 0.1
    torque[1003:1005] += 4.0
    torque[2000] += 4.0
    assert np.flatnonzero(wild(torque, jumps(command, 0.002))).tolist() == [2000]


def test_a_sensor_with_noise_does_not_stand_still() -> None:
    """150 equal readings, 0.3 s, of a sensor whose noise is 0.5 mrad; the same of a torque."""
    spoilt = CHIRP + NOISE
    spoilt[1000:1150] = spoilt[1000]
    torque = 3 * np.cos(3 * T) + 100 * NOISE
    assert texture(spoilt).noise == pytest.approx(5e-4, rel=0.2)
    held = torque.copy()
    held[2000:2100] = held[2000]
    found = frozen(T, CHIRP, {"position": spoilt, "torque": held})
    assert np.flatnonzero(found["position"]).tolist() == list(range(1000, 1150))
    assert np.flatnonzero(found["torque"]).tolist() == list(range(2000, 2100))


@pytest.mark.parametrize("count", [COUNT, 0.0], ids=["counts", "exact"])
def test_stiction_is_no_frozen_sensor(count: float) -> None:
    """For 0.8 s at each turn the joint stands and the torque grows; with a speed of 0, without one, and at rest."""
    course = sticking()
    read = np.round(course / count) * count if count else course
    triangle = 0.2 * np.abs((0.25 * T) % 2 - 1)
    torque = 20 * (triangle - course)
    speed = np.gradient(course, T)
    assert max(np.diff(np.flatnonzero(np.diff(read) != 0.0))) > 200
    for measured in ({"position": read}, {"position": read, "velocity": speed, "torque": torque}):
        assert not any(rows.any() for rows in frozen(T, triangle, measured).values())


def test_a_coarse_encoder_that_hangs_shows_by_where_it_goes_on() -> None:
    """0.4 s without a count, then 0.1 rad at once: a jump of 65 counts; or the speed says that it moved."""
    read = np.round(0.3 * np.sin(2 * np.pi * 0.5 * T) / COUNT) * COUNT
    spoilt = read.copy()
    spoilt[1250:1450] = spoilt[1250]
    assert abs(spoilt[1450] - spoilt[1449]) > 60 * COUNT
    found = frozen(T, 0.3 * np.sin(2 * np.pi * 0.5 * T), {"position": spoilt})
    assert found["position"][1250:1450].all() and found["position"].sum() < 260
    # Half a period: it goes on where it hung, and only the speed tells.
    spoilt = read.copy()
    spoilt[1000:1500] = spoilt[1000]
    speed = 0.3 * 2 * np.pi * 0.5 * np.cos(2 * np.pi * 0.5 * T) + 20 * NOISE
    found = frozen(T, 0.3 * np.sin(2 * np.pi * 0.5 * T), {"position": spoilt, "velocity": speed})
    assert found["position"][1000:1500].all()


def test_a_clock_that_jitters_is_no_noise_and_no_gap() -> None:
    """Rows 15 % early or late: the noise is 0.5 mrad at 6 rad/s too, and only what was taken out is missing."""
    random = np.random.default_rng(1)
    time = 0.004 * (np.arange(2500) + np.clip(0.15 * random.standard_normal(2500), -0.45, 0.45))
    read = 0.3 * np.sin(2 * np.pi * 3 * time) + 5e-4 * random.standard_normal(2500)
    assert scatter(read, time) == pytest.approx(5e-4, rel=0.15)
    assert scatter(read) > 1e-3
    short = np.delete(time, np.arange(50, 2500, 50))
    assert 36 < np.sum(np.diff(short) > longest_step(short)) < 52
    even = 0.004 * np.arange(100)
    assert longest_step(even) == pytest.approx(np.full(99, 0.006))
    # Third differences 1, 3, 3, 1: what even rows give by hand.
    signal = random.standard_normal(97)
    third = np.abs(signal[3:] - 3 * signal[2:-1] + 3 * signal[1:-2] - signal[:-3])
    assert scatter(signal, even[:97]) == pytest.approx(1.4826 * np.median(third) / np.sqrt(20.0))
    # A loop that is slower from a row on: nothing is missing there, and the speed is the same.
    turn = np.cumsum(np.repeat([0.0035, 0.0053], [400, 400]))
    assert np.sum(np.diff(turn) > longest_step(turn)) <= 15
    speed = smooth(turn, np.sin(3 * turn), 0.02, 1)
    assert speed[10:-10] == pytest.approx(3 * np.cos(3 * turn)[10:-10], abs=5e-3)
    bend = smooth(turn, np.sin(3 * turn), 0.02, 2)
    assert bend[420:-20] == pytest.approx(-9 * np.sin(3 * turn)[420:-20], abs=0.05)


def test_a_servo_that_stands_reads_a_count_of_speed() -> None:
    """0.4 s in stiction at 0.024 rad/s, the least that it can tell, while the command moves: nothing is left out."""
    time = 0.005 * np.arange(1000)
    course = np.clip(0.5 * np.sin(time), -0.4, 0.4)
    read = np.round(course / 0.001534) * 0.001534
    speed = np.round(np.gradient(course, time) / 0.024) * 0.024
    speed[np.abs(course) == 0.4] = 0.024
    found = frozen(time, 0.6 * np.sin(time), {"position": read, "velocity": speed})
    assert not found["position"].any() and not found["velocity"].any()
    # Three counts are a speed that a joint has.
    speed[np.abs(course) == 0.4] = 0.096
    found = frozen(time, 0.6 * np.sin(time), {"position": read, "velocity": speed})
    assert found["position"].any()
