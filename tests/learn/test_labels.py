"""Torques that no sensor read: accelerations of noisy speeds, and what dry friction leaves open."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from actspec import api
from actspec.diagnostics import Collector
from actspec.learn.closed_loop import HORIZON, Bench
from actspec.learn.floating import floating
from actspec.learn.labels import inferred
from actspec.learn.spline import spline, stiffness
from actspec.learn.steps import Course, sharpened
from actspec.learn.train import beyond
from actspec.learn.windows import dataset, slacks
from actspec.logs import BaseLog, JointLog, Log, LogError, Sidecar
from actspec.sysid.stand import Stand
from tests.learn.pendulums import SPEC, folder, log
from tests.sysid.test_stand import BENT, MODEL

pytest.importorskip("scipy")


def test_a_spline_is_as_stiff_as_the_noise_allows() -> None:
    """3 sin(4 pi t) with noise of 0.02: differences over two rows of 5 ms err by 0.02 sqrt(2) / 0.01 = 2.8."""
    time = 0.005 * np.arange(400)
    clean = 3.0 * np.sin(4.0 * np.pi * time)
    slope = 12.0 * np.pi * np.cos(4.0 * np.pi * time)
    noisy = clean + 0.02 * np.random.default_rng(0).standard_normal(400)
    middle = slice(20, -20)
    assert np.std((np.gradient(noisy, time) - slope)[middle]) == pytest.approx(2.8, rel=0.1)
    assert np.std((spline(time, noisy, stiffness(time, noisy)).derivative()(time) - slope)[middle]) < 0.8
    # Without noise, nothing is bent away; a reading that is none is left out.
    holed = np.where(np.arange(400) == 200, np.nan, clean)
    assert (
        np.abs((spline(time, holed, stiffness(time, holed)).derivative()(time) - slope)[middle]).max() < 0.05
    )


@pytest.mark.parametrize("rows", [3, 4, 5, 50, 400])
@pytest.mark.parametrize("stiff", [1e-13, 1e-6, 1e-2, 10.0])
def test_the_spline_is_scipys(rows: int, stiff: float) -> None:
    """The natural spline with the least squares and bends is one; scipy makes it by B-splines, from five rows on.

    Of fewer the sum itself is least: moved a little at any row, it is larger.
    """
    from scipy.integrate import quad
    from scipy.interpolate import CubicSpline, make_smoothing_spline

    random = np.random.default_rng(rows)
    time = np.cumsum(0.005 * random.uniform(0.6, 1.4, rows))
    signal = 3.0 * np.sin(20.0 * time) + 0.1 * random.standard_normal(rows)
    found = spline(time, signal, stiff)
    if rows >= 5:
        other = make_smoothing_spline(time, signal, lam=stiff)
        beyond_the_ends = np.concatenate([[time[0] - 0.01], time, [time[-1] + 0.01]])
        for order in (0, 1, 2):
            size = max(1.0, np.abs(other(time, order)).max())
            assert found(beyond_the_ends, order) == pytest.approx(
                other(beyond_the_ends, order), abs=1e-6 * size
            )
        return

    def cost(values: np.ndarray) -> float:
        bent = CubicSpline(time, values, bc_type="natural")
        bends = sum(quad(lambda t: bent(t, 2) ** 2, *ends)[0] for ends in pairwise(time))
        return float(np.sum((values - signal) ** 2) + stiff * bends)

    least = cost(found(time))
    for row in range(rows):
        for way in (-1e-2, 1e-2):
            assert cost(found(time) + way * np.eye(rows)[row]) > least


def test_friction_is_told_where_a_joint_slides(tmp_path: Path) -> None:
    """0.4 N*m against the speed; below 0.05 rad/s nothing, and a slack of the 0.6 N*m that hold it."""
    folder(tmp_path)
    dry = "coulomb: 0.4 N*m, static: 0.6 N*m, stribeck_velocity: 0.1 rad/s"
    (tmp_path / "dry.yaml").write_text(SPEC.replace("coulomb: 0 N*m", dry), "utf-8")
    logs = [log(tmp_path / "1.npz", rows=400)]
    found = []
    for name in ("spec.yaml", "dry.yaml"):
        spec = api.load(str(tmp_path / name))
        robot = api.load_robot(spec)
        stand = Stand(robot, api.resolve(spec, robot))
        data = dataset(stand.actuators, logs, Collector(), taps=(0, 1), measured=False)
        found.append(inferred(data, stand, logs, "fixed", Collector()))
    for without, rubbed in zip(found[0].tracks, found[1].tracks, strict=True):
        more = rubbed.torque - without.torque
        assert rubbed.slack is not None
        stands = rubbed.slack > 0
        assert 1 < stands.sum() < 200 and set(np.round(rubbed.slack, 9)) == {0.0, 0.6}
        assert more[stands] == pytest.approx(0.0, abs=0.005)
        assert more[~stands] == pytest.approx(0.4 * np.sign(rubbed.velocity[~stands]), abs=0.005)
        # Without friction in the spec the labels are the drive's torque, but for the steps of the command.
        measured = logs[0].joints[without.joint].torque
        assert measured is not None
        rows = slice(10, -10)
        assert np.std((without.torque - measured)[rows]) < 0.1 * np.std(measured)
    rows = [track.rows for track in found[1].tracks]
    assert np.array_equal(
        slacks(found[1], rows),
        np.concatenate([t.slack[t.rows] for t in found[1].tracks if t.slack is not None]),
    )
    assert not slacks(replace(found[1], tracks=(replace(found[1].tracks[0], slack=None),)), rows[:1]).any()


def test_steps_are_as_sharp_as_the_command() -> None:
    """20 (c(7 ms ago) - q) - 0.5 q' on 0.06 kg*m^2, targets that hold for 20 ms, speeds with noise of 0.02 rad/s."""
    random = np.random.default_rng(2)
    rows = 800
    command = np.repeat(0.3 * np.sin(random.standard_normal(rows // 4).cumsum()), 4)
    q, qd, read = 0.0, 0.0, np.empty((rows, 4))
    for k in range(5 * rows):
        late = command[max(k - 7, 0) // 5]
        tau = 20.0 * (late - q) - 0.5 * qd
        if k % 5 == 0:
            read[k // 5] = q, qd, tau / 0.06, tau
        qd += 0.001 * tau / 0.06
        q += 0.001 * qd
    time, torque = 0.005 * np.arange(rows), read[:, 3]
    noisy = read[:, 1] + 0.02 * random.standard_normal(rows)
    for order, signal in ((1, noisy), (2, read[:, 0] + 5e-5 * random.standard_normal(rows))):
        stiff = stiffness(time, signal)
        blurred = 0.06 * spline(time, signal, stiff).derivative(order)(time)
        course = Course(time, command, time, read[:, 0], noisy, blurred, np.ones(rows, bool), stiff, order)
        middle = slice(20, -20)
        ((found,),) = sharpened([[course]], [np.inf])
        assert np.std((found - torque)[middle]) < 0.3 * np.std((blurred - torque)[middle])
        # Not beyond the limit, and not by a command that does not tell the torque.
        ((kept,),) = sharpened([[course]], [1.0])
        assert np.all(np.abs(kept) <= np.maximum(1.0, np.abs(blurred)) + 1e-9) and np.any(kept != found)
        ((other,),) = sharpened([[replace(course, command=command[::-1].copy())]], [np.inf])
        assert other == pytest.approx(blurred)


def test_what_lies_within_the_slack_is_no_error() -> None:
    """0.5 and -0.7 with a slack of 0.6: nothing, and -0.1."""
    assert beyond(np, np.array([0.5, -0.7, 0.2]), np.array([0.6, 0.6, 0.0])) == pytest.approx(
        [0.0, -0.1, 0.2]
    )


def test_a_base_that_flies_and_lands(tmp_path: Path) -> None:
    """A body with an arm that is thrown and lands: MuJoCo's own torque in flight, contact left out."""
    import mujoco

    (tmp_path / "robot.xml").write_text(
        """<mujoco><option timestep="0.0005"/><worldbody><geom type="plane" size="5 5 1"/>
        <body pos="0 0 1"><freejoint/><geom size=".1" mass="2"/>
        <body pos=".1 0 0"><joint name="arm" axis="0 1 0"/>
        <geom type="capsule" fromto="0 0 0 .2 0 0" size=".02" mass=".5" contype="0" conaffinity="0"/></body></body>
        </worldbody><actuator><motor joint="arm"/></actuator></mujoco>""",
        "utf-8",
    )
    (tmp_path / "spec.yaml").write_text(
        "actspec: 1\nrobot: {name: thrown, model: robot.xml}\ntiming: {physics_dt: 5 ms}\n"
        "actuators: {arm: {joints: [arm], level: ideal_pd, "
        "kp: 1 N*m/rad, kd: 0 N*m*s/rad, effort_limit: 5 N*m}}\n",
        "utf-8",
    )
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    data = mujoco.MjData(model)
    data.qvel[:6] = 1.0, 0.0, 1.0, 0.5, 1.0, -0.5
    rows: list[np.ndarray] = []
    for k in range(1600):
        data.ctrl[0] = 0.3 * np.sin(0.02 * k)
        mujoco.mj_step1(model, data)
        if k % 10 == 0:
            rows.append(np.concatenate([[data.time, data.ctrl[0], data.ncon > 0], data.qpos, data.qvel]))
        mujoco.mj_step2(model, data)
    all_rows = np.array(rows)
    time, torque, hit, q, v = (
        all_rows[:, 0],
        all_rows[:, 1],
        all_rows[:, 2] > 0,
        all_rows[:, 3:11],
        all_rows[:, 11:],
    )
    assert 10 < hit.sum() < 100
    moved = BaseLog(
        q[:, :3], q[:, 3:7] * np.where(np.arange(len(q)) % 2, -1.0, 1.0)[:, None], v[:, :3], v[:, 3:6]
    )
    joint = JointLog("arm", False, command=torque, position=q[:, 7], velocity=v[:, 6])
    log = Log("thrown.csv", "", time, {"arm": joint}, Sidecar(), base=moved)
    spec = api.load(str(tmp_path / "spec.yaml"))
    robot = api.load_robot(spec)
    qdd = spline(time, v[:, 6], stiffness(time, v[:, 6])).derivative()(time)
    found, touching = floating(robot, ["arm"], log, time, q[:, 7:8], v[:, 6:7], qdd[:, None])
    assert touching[hit].mean() > 0.8 and not touching[: np.flatnonzero(hit)[0] - 10].any()
    free = slice(3, np.flatnonzero(hit)[0] - 6)
    assert found[free, 0] == pytest.approx(torque[free], abs=0.01)
    actuators, out = api.resolve(spec, robot), Collector()
    stand = Stand(robot, actuators)
    data = dataset(actuators, [log], out, taps=(0,), measured=False)
    (track,) = inferred(data, stand, [log], None, out).tracks
    said = [item.message for item in out if item.code == "LRN026"]
    assert said == [f"{int(touching.sum())} of 160 rows are in contact: they are left out"]
    assert list(track.rows) == list(np.flatnonzero(~touching))
    # Hung up, something else carries all of it: why no row is left is said, and what helps.
    still = replace(moved, orientation=np.tile([1.0, 0, 0, 0], (160, 1)), linear_velocity=np.zeros((160, 3)))
    hung = replace(log, base=replace(still, angular_velocity=np.zeros((160, 3))))
    out = Collector()
    data = dataset(actuators, [hung], out, taps=(0,), measured=False)
    with pytest.raises(LogError) as caught:
        inferred(data, stand, [hung], None, out)
    (error,) = (item for item in caught.value.diagnostics if item.severity.value == "error")
    assert error.code == "LRN005" and "160 rows are in contact, as the columns base.* tell" in error.message
    assert error.span is not None and error.span.path == hung.path and "--base fixed" in str(error.help)
    heard: list[tuple[int, int]] = []
    fixed = inferred(data, stand, [hung], "fixed", Collector(), lambda *part: heard.append(part))
    assert len(fixed.tracks[0].rows) == 160
    # The motion of one joint, the links along one log, the steps of the commands.
    assert heard == [(1, 3), (2, 3), (3, 3)]
    for lacking in ("orientation", "angular_velocity"):
        part = replace(log, base=replace(moved, **{lacking: None}))
        with pytest.raises(LogError, match=f"base.{lacking}"):
            floating(robot, ["arm"], part, time, q[:, 7:8], v[:, 6:7], qdd[:, None])


LEG = """actspec: 1
robot: {name: bench, model: bench.xml, default_pose: {knee: 90 deg}, unmanaged: [tail]}
timing: {physics_dt: 5 ms}
actuators:
  thigh: {joints: [hip], GAINS}
  shank: {joints: [knee], GAINS}
""".replace(
    "GAINS",
    "level: ideal_pd, kp: 40 N*m/rad, kd: 0 N*m*s/rad, effort_limit: 30 N*m, armature: 0.02 kg*m^2, "
    "friction: {coulomb: 0 N*m, viscous: 0 N*m*s/rad}",
)
"""Of the bench of `test_stand`, without gravity."""


def leg(folder: Path) -> Stand:
    (folder / "bench.xml").write_text(MODEL.replace("0 0 -9.81", "0 0 0"), "utf-8")
    (folder / "leg.yaml").write_text(LEG, "utf-8")
    spec = api.load(str(folder / "leg.yaml"))
    robot = api.load_robot(spec)
    return Stand(robot, api.resolve(spec, robot))


def swing(size: float, rate: float, time: np.ndarray) -> np.ndarray:
    """Position, speed and acceleration of `size` sin(`rate` t)."""
    phase = rate * time
    return size * np.stack([np.sin(phase), rate * np.cos(phase), -(rate**2) * np.sin(phase)])


def swung(**joints: tuple[np.ndarray, np.ndarray]) -> Log:
    """A log of joints, by position and speed."""
    columns = {
        name: JointLog(name, False, command=q, position=q, velocity=v) for name, (q, v) in joints.items()
    }
    return Log("leg.csv", "", 0.005 * np.arange(len(next(iter(joints.values()))[0])), columns, Sidecar())


def test_a_joint_of_another_group_moves_as_read(tmp_path: Path) -> None:
    """1 kg at 0.2 m from a knee that the thigh carries at 0.3 m from the hip: Lagrange's equation of the knee is
    0.04 (h'' + k'') + 0.06 (cos k h'' + sin k h'^2) + 0.02 k'' = torque. With the hip held it would be 0.06 k''."""
    stand, time = leg(tmp_path), 0.005 * np.arange(600)
    (h, hd, hdd), (k, kd, kdd) = swing(0.5, 6.0, time), swing(0.3, 9.0, time)
    k = k + 1.0
    torque = 0.04 * (hdd + kdd) + 0.06 * (np.cos(k) * hdd + np.sin(k) * hd**2) + 0.02 * kdd
    logs, out = [swung(hip=(h, hd), knee=(k, kd))], Collector()
    data = dataset(stand.actuators, logs, out, group="shank", taps=(0,), measured=False)
    (track,) = inferred(data, stand, logs, "fixed", out).tracks
    middle = slice(20, -20)
    assert np.abs(torque).max() > 1.0 and np.abs(torque - 0.06 * kdd).max() > 0.9
    assert track.torque[middle] == pytest.approx(torque[middle], abs=0.03)
    assert not [item for item in out if item.code == "SYS038"]
    # In the closed loop too: under that torque the knee goes where it went, for the second that a rollout has.
    bench = Bench(stand, data, data.tracks, 0.001)
    start = bench.starts()[:1]
    fine = bench.grid[start[0] :]
    (_, rate, turning), (swings, _, pulls) = swing(0.5, 6.0, fine), swing(0.3, 9.0, fine)
    bends = swings + 1.0
    exact = (
        0.04 * (turning + pulls) + 0.06 * (np.cos(bends) * turning + np.sin(bends) * rate**2) + 0.02 * pulls
    )
    errors = bench.rolled(start, lambda _, step, *__: exact[step : step + 1, None], None)
    assert len(errors) == round(HORIZON / 0.001) and np.abs(errors).max() < 0.01


def test_a_joint_that_is_not_logged_is_where_the_spec_has_it(tmp_path: Path) -> None:
    """With the knee at 90 degrees 0.13 + 0.02 kg*m^2 turn at the hip; straight, as the file draws it, 0.25 + 0.02."""
    stand, time = leg(tmp_path), 0.005 * np.arange(600)
    h, hd, hdd = swing(0.5, 6.0, time)
    logs, out = [swung(hip=(h, hd))], Collector()
    data = dataset(stand.actuators, logs, out, taps=(0,), measured=False)
    (track,) = inferred(data, stand, logs, "fixed", out).tracks
    assert track.torque[20:-20] == pytest.approx((BENT + 0.02) * hdd[20:-20], abs=0.03)
    (said,) = (item for item in out if item.code == "SYS038")
    assert said.message == "not in the log, held by robot.default_pose: knee 1.571 rad"
    bench = Bench(stand, data, data.tracks, 0.001)
    start = bench.starts()[:1]
    exact = (BENT + 0.02) * swing(0.5, 6.0, bench.grid[start[0] :])[2]
    errors = bench.rolled(start, lambda _, step, *__: exact[step : step + 1, None], None)
    assert np.abs(errors).max() < 0.01
