"""Columns of another joint, of another signal or of another moment: named, or put right, before they become figures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from actspec.diagnostics import Collector, Diagnostic, Severity
from actspec.logs import JointLog, Log, LogError, Sidecar
from actspec.sysid.checks import check
from actspec.sysid.course import Course
from actspec.sysid.doubts import judge_torques
from actspec.sysid.figures import Bounds
from actspec.sysid.recording import Recording, record, without_velocity
from actspec.sysid.torques import answer, prompt
from tests.sysid.test_fit import PERIOD, ROWS, command, fitted, logged
from tests.sysid.truth import truth

pytest.importorskip("scipy")

RANGES = {"hip": (-1.5, 1.5), "knee": (-1.5, 1.5)}


@pytest.fixture(scope="module")
def log() -> Log:
    """Two pendulums of the same drive, the second with the first one's command backwards in time."""
    given = np.stack([command(), command()[::-1]], axis=1)
    one = {
        "J": 0.03, "kp": 20.0, "kd": 0.5, "tc": 0.1, "b": 0.02, "delay": 0.0053, "limit": 30.0, "mgl": 1.2, "bias": 0.0,
    }  # fmt: skip
    q, qd, torque = truth({name: np.full(2, value) for name, value in one.items()}, given, PERIOD)
    random = np.random.default_rng(3)
    columns = {
        name: JointLog(
            name,
            False,
            command=given[:, j],
            position=q[:, j] + 5e-4 * random.standard_normal(ROWS),
            velocity=qd[:, j] + 0.05 * random.standard_normal(ROWS),
            torque=torque[:, j] + 0.02 * torque[:, j].std() * random.standard_normal(ROWS),
        )
        for j, name in enumerate(RANGES)
    }
    return Log("leg.csv", "0" * 64, np.arange(ROWS) * PERIOD, columns, Sidecar())


def checked(log: Log, **joints: JointLog) -> tuple[dict[str, list[Recording]], list[Diagnostic]]:
    """What the checks make and say of the log with other joints."""
    out = Collector()
    log = replace(log, joints={**log.joints, **joints})
    recordings = {name: [record(log, joint, out)] for name, joint in log.joints.items()}
    sound = {name: [one for one in mine if one is not None] for name, mine in recordings.items()}
    made = check(sound, dict.fromkeys(sound, Bounds(limit=30.0)), RANGES, out)
    return made, list(out.sorted())


def exchanged(log: Log, signal: str) -> dict[str, JointLog]:
    """The two joints with each other's column."""
    hip, knee = log.joints["hip"], log.joints["knee"]
    return {
        "hip": replace(hip, **{signal: getattr(knee, signal)}),
        "knee": replace(knee, **{signal: getattr(hip, signal)}),
    }


@pytest.mark.slow
def test_a_sound_log_has_no_flaw(log: Log) -> None:
    assert checked(log)[1] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("signal", "hip"),
    [
        ("velocity", "the velocity is the derivative of the position of knee, not of its own position"),
        ("torque", "the torque answers to the error of knee, not to its own"),
    ],
)
def test_columns_of_two_joints_are_exchanged(log: Log, signal: str, hip: str) -> None:
    found = checked(log, **exchanged(log, signal))[1]
    assert [(one.code, one.severity, one.where) for one in found] == [
        ("SYS015", Severity.ERROR, "hip"),
        ("SYS015", Severity.ERROR, "knee"),
    ]
    assert found[0].message == hip


@pytest.mark.slow
@pytest.mark.parametrize("count", [0.005, 0.02])
def test_a_slow_joint_on_a_coarse_encoder(log: Log, count: float) -> None:
    """Both follow one slow sine: the derivative of the coarse one is all steps, and its velocity like the other's.

    0.3 rad at 0.1 Hz is at most 0.19 rad/s: a count of 0.005 rad comes every 13 rows, one of 0.02 every 53.
    """
    time = np.arange(ROWS) * PERIOD
    w = 2.0 * np.pi * 0.1
    went, speed = 0.3 * np.sin(w * time), 0.3 * w * np.cos(w * time)
    noisy = speed + 0.01 * np.random.default_rng(3).standard_normal(ROWS)
    fine = JointLog("knee", False, command=went, position=np.round(went / 1e-4) * 1e-4, velocity=noisy)
    coarse = replace(fine, name="hip", position=np.round(went / count) * count)
    assert checked(log, hip=coarse, knee=fine)[1] == []
    other = replace(coarse, velocity=-noisy[::-1])
    assert [one.where for one in checked(log, hip=other, knee=fine)[1]] == ["hip"]


@pytest.mark.slow
def test_command_and_position_are_exchanged(log: Log) -> None:
    """By the velocity; without one by the torque, which brakes as it should and pulls the wrong way."""
    hip = log.joints["hip"]
    turned = replace(hip, command=hip.position, position=hip.command)
    found = checked(log, hip=turned)[1]
    assert "the velocity is the derivative of the command" in found[0].message
    assert all(one.code == "SYS015" and "exchanged" in (one.help or "") for one in found)


def test_the_sign_of_a_torque(log: Log) -> None:
    hip = log.joints["hip"]
    assert hip.torque is not None
    (one,) = checked(log, hip=replace(hip, torque=-hip.torque))[1]
    assert (one.code, one.message) == ("SYS014", "the torque pulls away from the command")


def promptly(log: Log, torque: np.ndarray) -> Recording:
    """The hip with another torque, taken earlier if it is late."""
    made, _ = checked(log, hip=replace(log.joints["hip"], torque=torque))
    (hip,) = made["hip"]
    still = np.zeros(ROWS)
    load, slope = 1.2 * np.sin(hip.position), 1.2 * np.cos(hip.position)
    course = Course(hip.time, hip.command, still, still + 0.02, load, slope, hip.position)
    return prompt(hip, course)


@pytest.mark.slow
@pytest.mark.parametrize("rows", [3, 7, 20])
def test_a_torque_that_is_late_is_taken_earlier(log: Log, rows: int) -> None:
    """Beside a delay of 2.65 rows, which shifts the command alone; 20 rows are 40 ms."""
    torque = log.joints["hip"].torque
    assert torque is not None
    made = promptly(log, np.concatenate([np.full(rows, np.nan), torque[:-rows]]))
    assert made.late == rows
    np.testing.assert_array_equal(made.measured["torque"][: ROWS - rows], torque[: ROWS - rows])
    assert np.isnan(made.measured["torque"][ROWS - rows :]).all()
    assert promptly(log, torque).late == 0


@pytest.mark.slow
def test_a_drive_that_is_slow_itself_is_not_late(log: Log) -> None:
    """Its torque follows error and speed by 10 ms, and moves the joint at once: J 0.03, kp 20, kd 0.5, mgl 1.2."""
    given, parts = command(), 20
    q, qd, torque = np.zeros(ROWS), np.zeros(ROWS), np.zeros(ROWS)
    at, speed, drive = 0.0, 0.0, 0.0
    for row in range(ROWS):
        q[row], qd[row], torque[row] = at, speed, drive
        for _ in range(parts):
            h = PERIOD / parts
            drive += h / 0.010 * (20.0 * (given[row] - at) - 0.5 * speed - drive)
            speed += h / 0.03 * (drive - 0.02 * speed - 1.2 * np.sin(at))
            at += h * speed
    random = np.random.default_rng(4)
    slow = replace(
        log.joints["hip"],
        position=q + 5e-4 * random.standard_normal(ROWS),
        velocity=qd + 0.05 * random.standard_normal(ROWS),
    )
    log = replace(log, joints={**log.joints, "hip": slow})
    noisy = torque + 0.02 * torque.std() * random.standard_normal(ROWS)
    (hip,) = checked(log, hip=replace(slow, torque=noisy))[0]["hip"]
    found = answer(noisy, hip, 30.0)
    assert found is not None and found.late > 2
    assert promptly(log, noisy).late == 0


def test_gains_of_a_torque_by_regression(log: Log) -> None:
    """kp 20 and kd 0.5 to a twentieth: the delay is no whole number of rows."""
    (hip,) = checked(log)[0]["hip"]
    found = answer(hip.measured["torque"], hip, 30.0)
    assert found is not None and found.late == 0 and found.left < 0.02
    assert (found.kp, found.kd) == (pytest.approx(20.0, rel=0.05), pytest.approx(0.5, rel=0.05))


def test_all_columns_of_two_joints_are_exchanged(log: Log) -> None:
    """Each is where only the other can be: the knee from 1 to 2.2 rad, the hip from -0.6 to 0.6."""
    hip, knee = log.joints["hip"], log.joints["knee"]
    bent = replace(knee, position=knee.position + 1.6, command=knee.command + 1.6)
    turned = {"hip": replace(bent, name="hip"), "knee": replace(hip, name="knee")}
    out = Collector()
    log = replace(log, joints=turned)
    recordings = {name: [record(log, joint, out)] for name, joint in turned.items()}
    sound = {name: [one for one in mine if one is not None] for name, mine in recordings.items()}
    check(sound, dict.fromkeys(sound, Bounds()), {"hip": (-0.8, 0.8), "knee": (0.9, 2.7)}, out)
    assert [(one.code, one.where) for one in out.sorted()] == [("SYS015", "hip"), ("SYS015", "knee")]


def test_motion_without_a_velocity_is_the_position_s(log: Log) -> None:
    """A velocity that is left out may be wrong: the links must not follow it."""
    out = Collector()
    hip = log.joints["hip"]
    assert hip.velocity is not None
    wrong = record(log, replace(hip, velocity=hip.velocity + 3.0), out)
    right = record(log, replace(hip, velocity=None), out)
    assert wrong is not None and right is not None
    made = without_velocity(wrong)
    assert set(made.measured) == set(made.released) | {"torque"} == {"position", "torque"}
    (checked_too,) = checked(log, hip=replace(hip, velocity=np.roll(hip.velocity, 500)))[0]["hip"]
    for part in ("position", "velocity", "acceleration"):
        np.testing.assert_array_equal(getattr(made, part), getattr(right, part))
        np.testing.assert_array_equal(getattr(checked_too, part), getattr(right, part))


@pytest.mark.slow
def test_a_torque_of_another_scale_is_refused_before_the_fit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """0.4 of it; the speed that is read is filtered, which makes up to a fifth less of the scale."""
    monkeypatch.setattr("actspec.sysid.fit.roll", None)  # nothing is fitted
    log = logged(gravity=True)
    hip = log.joints["hip"]
    assert hip.torque is not None
    with pytest.raises(LogError, match=r"the torque is 0\.3[2-9]\d* .* times what the model's masses need"):
        fitted(tmp_path, replace(log, joints={"hip": replace(hip, torque=0.4 * hip.torque)}))


@pytest.mark.slow
def test_a_command_that_the_drive_did_not_get_has_no_figures(tmp_path: Path) -> None:
    """What moved the joint went to 0.6 rad, the log has it cut off at a third."""
    log = logged(gravity=True, rows=500)
    hip = log.joints["hip"]
    cut = replace(hip, command=np.clip(hip.command, -0.2, 0.2))
    with pytest.raises(LogError, match=r"no figures make the model move as the log does"):
        fitted(tmp_path, replace(log, joints={"hip": cut}))


def legs(rows: int = 800) -> Log:
    """Two joints, 4 s at 200 Hz: sines of 0.7 and 1.9 Hz, and of 0.5 and 2.3 Hz, 0.2 mrad and 0.03 rad/s of noise.

    The first goes 1.9 rad/s at most, 9.5 mrad a row.
    """
    t, random = 0.005 * np.arange(rows), np.random.default_rng(7)
    parts = {"hip": ((0.7, 0.3), (1.9, 0.05)), "knee": ((0.5, -0.25), (2.3, 0.08))}
    joints = {}
    for name, sines in parts.items():
        course = sum(size * np.sin(2 * np.pi * f * t) for f, size in sines)
        speed = sum(2 * np.pi * f * size * np.cos(2 * np.pi * f * t) for f, size in sines)
        position = course + 2e-4 * random.standard_normal(rows)
        joints[name] = JointLog(
            name,
            False,
            command=course,
            position=position,
            velocity=speed + 0.03 * random.standard_normal(rows),
        )
    return Log("leg.csv", "0" * 64, t, joints, Sidecar())


def scaled(log: Log, **factors: float) -> dict[str, JointLog]:
    """The joints with their velocities times a factor."""
    return {
        name: replace(log.joints[name], velocity=factor * log.joints[name].velocity)
        for name, factor in factors.items()
    }


def test_a_velocity_of_another_scale() -> None:
    """Twice the derivative at one of two joints, or 1.5 and 9 at both: no unit's factors, nor the time's."""
    log = legs()
    (one,) = checked(log, **scaled(log, knee=2.0))[1]
    assert (one.code, one.severity, one.where) == ("SYS014", Severity.ERROR, "knee")
    assert one.message == "the velocity is 2 times the position's derivative"
    both = checked(log, **scaled(log, hip=1.5, knee=1 / 9))[1]
    assert [one.message[:28] for one in both] == [
        "the velocity is 1.5 times th",
        "the velocity is 0.111 times ",
    ]
    assert [one.message[-9:] for one in checked(log, **scaled(log, hip=30 / np.pi))[1]] == ["is in rpm"]


def test_a_velocity_as_drives_report_it_has_its_scale() -> None:
    """Behind a low-pass of 5 Hz, in counts of 0.024 rad/s that are cut off, late by 2 rows, with 0.3 rad/s of noise."""
    log = legs()
    for name, joint in log.joints.items():
        speed = joint.velocity
        assert speed is not None
        slow = np.zeros_like(speed)
        for row in range(1, len(speed)):
            # 2 pi 5 Hz 5 ms = 0.157, of which 1 - exp(-0.157) = 0.145.
            slow[row] = slow[row - 1] + 0.145 * (speed[row] - slow[row - 1])
        noise = 0.3 * np.random.default_rng(1).standard_normal(len(speed))
        for other in (slow, 0.024 * np.trunc(speed / 0.024), np.roll(speed, 2), speed + noise):
            found = checked(log, **{name: replace(joint, velocity=other)})[1]
            assert not [one for one in found if one.severity is not Severity.INFO], name


def test_a_time_of_another_scale() -> None:
    """Twice too long: both joints' velocities are twice what their positions make of it, and the time is told."""
    log = legs()
    (one,) = checked(replace(log, time=2.0 * log.time))[1]
    assert (one.code, one.severity, one.where) == ("SYS014", Severity.ERROR, "time")
    assert one.message.startswith("the velocities of both joints are 2 times their positions' derivatives")
    assert one.message.endswith("ms by the velocities, and every 10 ms by the time")


def test_rows_that_are_missing_behind_a_time_that_goes_on() -> None:
    """100 rows less from row 300 on, 0.5 s, in which the joints go elsewhere: line 301 of the file is the last before.

    With the times that they had it is a gap as others are.
    """
    log = legs()
    kept = np.r_[0:300, 400:800]
    joints = {
        name: replace(
            joint, **{signal: getattr(joint, signal)[kept] for signal in ("command", "position", "velocity")}
        )
        for name, joint in log.joints.items()
    }
    found = checked(replace(log, time=log.time[:700]), **joints)[1]
    (one,) = [one for one in found if one.severity is not Severity.INFO]
    assert (one.code, one.severity, one.where) == ("SYS013", Severity.ERROR, "time")
    assert one.message.startswith("the positions of 2 of 2 joints jump from this row to the next: ")
    assert one.span == log.span(299)
    assert {one.severity for one in checked(replace(log, time=log.time[kept]), **joints)[1]} == {
        Severity.INFO
    }


def test_readings_that_are_held_are_no_gap() -> None:
    """Eight rows in which a bus gives the same readings again: behind them the joints go on by a leap."""
    log = legs()
    held = np.arange(800)
    held[300:308] = 300
    joints = {
        name: replace(joint, position=joint.position[held], velocity=joint.velocity[held])
        for name, joint in log.joints.items()
    }
    assert not [one for one in checked(log, **joints)[1] if one.severity is Severity.ERROR]


@pytest.mark.parametrize("rows", [2, 4, 12])
def test_a_position_that_is_late_is_taken_earlier(rows: int) -> None:
    """12 rows are 60 ms; one row may be how a program reads, and is left."""
    whole = legs(820)
    log = replace(
        whole,
        time=whole.time[20:],
        joints={
            name: replace(joint, **{signal: read[20:] for signal, read in joint.signals.items()})
            for name, joint in whole.joints.items()
        },
    )
    hip, position = log.joints["hip"], whole.joints["hip"].position
    assert position is not None
    made, (one,) = checked(log, hip=replace(hip, position=position[20 - rows : 820 - rows]))
    assert (one.code, one.severity, one.where) == ("SYS012", Severity.WARNING, "hip")
    assert one.message.startswith(f"the position is {rows} rows ({5 * rows} ms) behind its velocity")
    read = made["hip"][0].measured["position"]
    np.testing.assert_array_equal(read[: 800 - rows], position[20 : 820 - rows])
    assert np.isnan(read[800 - rows :]).all()
    assert checked(log, hip=replace(hip, position=position[19:819]))[1] == []


@pytest.mark.parametrize(
    ("factor", "gear", "words"),
    [(9.0, 9.0, "about 1/9 (hip: 0.09"), (9.0, 6.0, "times what"), (1.0, 9.0, None)],
)
def test_a_torque_of_the_motor_s_side(log: Log, factor: float, gear: float, words: str | None) -> None:
    """A ninth of the joint's, where the spec's gear is 9; one of 6 does not explain it."""
    hip = log.joints["hip"]
    assert hip.torque is not None
    out = Collector()
    read = record(log, replace(hip, torque=hip.torque / factor), out)
    assert read is not None
    still = np.zeros(ROWS)
    load, slope = 1.2 * np.sin(read.position), 1.2 * np.cos(read.position)
    course = Course(read.time, read.command, still, still + 0.02, load, slope, read.position)
    one = SimpleNamespace(
        recordings=[read], courses=[course], actuator=SimpleNamespace(joint="hip", gear=gear)
    )
    judge_torques([one], out)  # type: ignore[list-item]
    assert [(one.code, one.where) for one in out.sorted()] == ([("SYS018", "hip")] if words else [])
    for found in out.sorted():
        assert words is not None and words in found.message
        assert ("by 9" in (found.help or "")) is (gear == factor)
