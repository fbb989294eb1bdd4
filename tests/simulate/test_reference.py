"""The reference of time responses against closed forms, the laws, and its own halved step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from actspec.ir import Command
from actspec.laws import TorqueLaw
from actspec.simulate.reference import (
    SOFT_RATE,
    SOFT_SHARE,
    DrivenJoint,
    PassiveFriction,
    Trajectory,
    _Numbers,
    _Pull,
    integrate,
)

pytestmark = pytest.mark.slow

STEP = 0.005
FREE = PassiveFriction(0.0, 0.0)


def law(**changed: Any) -> TorqueLaw:
    """A torque drive without a limit, unless something else is asked for."""
    numbers: dict[str, Any] = {
        "command": Command.EFFORT,
        "kp": 0.0,
        "kd": 0.0,
        "effort_limit": math.inf,
        "stall_torque": None,
        "no_load_speed": None,
        "curve": None,
        "encoder_bias": 0.0,
        "filter_cutoff": None,
        "delay": 0.0,
    }
    return TorqueLaw(**{**numbers, **changed})


def spring(**changed: Any) -> TorqueLaw:
    """A position drive of 25 N*m/rad."""
    return law(**{"command": Command.POSITION, "kp": 25.0, **changed})


def moved(
    one: TorqueLaw,
    friction: PassiveFriction,
    inertia: float,
    command: Any,
    *,
    q: float = 0.0,
    qd: float = 0.0,
    substeps: int = 64,
) -> Trajectory:
    """One joint that follows its command."""
    told = np.asarray(command, dtype=float)[:, None]
    return integrate(
        [DrivenJoint(one, friction, inertia)], told, np.array([q]), np.array([qd]), STEP, substeps=substeps
    )


def times(steps: int) -> Any:
    """Of the samples [s]."""
    return STEP * np.arange(steps + 1)


def test_an_undamped_drive_oscillates() -> None:
    """J q'' = kp (q* - q): q = q* (1 - cos w t), w = sqrt(25 / 0.1) = 15.8 rad/s."""
    found = moved(spring(), FREE, 0.1, np.full(200, 0.3))
    w = math.sqrt(250.0)
    assert np.abs(found.q[:, 0] - 0.3 * (1.0 - np.cos(w * times(200)))).max() < 1e-11
    assert np.abs(found.torque[:, 0] - 25.0 * 0.3 * np.cos(w * times(199))).max() < 1e-9


def test_viscous_friction_decays() -> None:
    """w = w0 exp(-b t / J) and q = w0 J / b (1 - exp): b 0.5, J 0.2."""
    found = moved(law(), PassiveFriction(0.0, 0.5), 0.2, np.zeros(200), qd=3.0)
    decay = np.exp(-2.5 * times(200))
    assert np.abs(found.qd[:, 0] - 3.0 * decay).max() < 1e-11
    assert np.abs(found.q[:, 0] - 1.2 * (1.0 - decay)).max() < 1e-11


def test_kd_is_a_drive_s_and_not_friction() -> None:
    """kd 0.5 of a velocity drive towards 0 decays as friction of 0.5 does, and has a torque; friction has none."""
    drive = moved(law(command=Command.VELOCITY, kd=0.5), FREE, 0.2, np.zeros(100), qd=3.0)
    passive = moved(law(), PassiveFriction(0.0, 0.5), 0.2, np.zeros(100), qd=3.0)
    assert np.allclose(drive.q, passive.q, rtol=0, atol=1e-12)
    assert drive.torque[0, 0] == -1.5
    assert passive.torque[0, 0] == 0.0


def test_dry_friction_stops_a_joint_for_good() -> None:
    """w0 J / tau_c = 3 x 0.1 / 0.21 = 1.42857 s, within a substep, after w0 / 2 of that: 2.142857 rad."""
    found = moved(law(), PassiveFriction(0.21, 0.0), 0.1, np.zeros(400), qd=3.0)
    stop = 3.0 * 0.1 / 0.21
    before = times(400) < stop
    assert np.abs(found.qd[before, 0] - (3.0 - 2.1 * times(400)[before])).max() < 1e-11
    assert (found.qd[~before, 0] == 0.0).all()
    assert np.abs(found.q[~before, 0] - 1.5 * stop).max() < 1e-12


def test_a_joint_that_stands_stays_until_more_than_friction_pulls() -> None:
    """0.2 N*m against 0.2 does not integrate it, 0.21 accelerates it by 0.01 / 0.1 rad/s^2 from the third step on."""
    command = np.r_[[0.2] * 3, [0.21] * 97]
    found = moved(law(), PassiveFriction(0.2, 0.0), 0.1, command)
    t = np.maximum(times(100) - 3 * STEP, 0.0)
    assert (found.q[:4] == 0.0).all()
    assert np.abs(found.q[:, 0] - 0.5 * 0.1 * t**2).max() < 1e-13


def test_break_away_friction_is_larger_than_sliding_friction() -> None:
    """0.29 N*m does not break 0.3 away; 0.31 does, and then only 0.2 is left: 0.11 / 0.1 rad/s^2."""
    held = moved(law(), PassiveFriction(0.2, 0.0, static=0.3), 0.1, np.full(50, 0.29))
    found = moved(law(), PassiveFriction(0.2, 0.0, static=0.3), 0.1, np.full(50, -0.31))
    assert (held.q == 0.0).all()
    assert np.abs(found.q[:, 0] + 0.5 * 1.1 * times(50) ** 2).max() < 1e-13


def test_the_stribeck_effect_fades_with_speed() -> None:
    """A joint that is pushed with 0.25 from 1 rad/s: J w' = 0.25 - 0.2 - 0.1 exp(-w^2 / 0.5^2), by fine Euler steps."""
    found = moved(
        law(), PassiveFriction(0.2, 0.0, static=0.3, stribeck_velocity=0.5), 0.1, np.full(40, 0.25), qd=1.0
    )
    w = 1.0
    for _ in range(200_000):
        w += 1e-6 / 0.1 * (0.05 - 0.1 * math.exp(-((w / 0.5) ** 2)))
    assert abs(found.qd[40, 0] - w) < 1e-6
    assert abs(w - (1.0 + 0.05 / 0.1 * 0.2)) > 1e-3


def test_a_spring_with_dry_friction_loses_the_same_each_half_swing() -> None:
    """Each turn is 2 tau_c / kp = 0.16 rad nearer; from 1 rad turns at -0.84, 0.68 …, and it stands within 0.08."""
    found = moved(spring(), PassiveFriction(2.0, 0.0), 0.1, np.zeros(300), q=1.0)
    half = math.pi / math.sqrt(250.0)
    # Between turns it is a cosine about -+0.08; the third half swing goes from 0.68 to -0.52 about 0.08.
    k = int(2.5 * half / STEP)
    assert abs(found.q[k, 0] - (0.08 + 0.6 * math.cos(math.sqrt(250.0) * (k * STEP - 2 * half)))) < 1e-10
    # 1, -0.84, 0.68, -0.52, 0.36, -0.20, 0.04: the last is within 0.08 of rest, where friction holds.
    assert abs(found.q[-1, 0] - 0.04) < 1e-10
    assert found.qd[-1, 0] == 0.0


def test_a_limit_accelerates_evenly() -> None:
    """A step of 1 N*m that asks for 8: w = L t / J = 3 / 0.1 t."""
    found = moved(law(effort_limit=3.0), FREE, 0.1, np.full(50, 8.0))
    assert np.abs(found.qd[:, 0] - 30.0 * times(50)).max() < 1e-10
    assert (found.torque == 3.0).all()


def test_a_torque_speed_line_ends_at_its_no_load_speed() -> None:
    """J w' = ts (1 - w / w0): w = w0 (1 - exp(-ts t / (J w0))) with ts 4, w0 20, J 0.1."""
    line = law(effort_limit=100.0, stall_torque=4.0, no_load_speed=20.0)
    found = moved(line, FREE, 0.1, np.full(200, 50.0))
    assert np.abs(found.qd[:, 0] - 20.0 * (1.0 - np.exp(-2.0 * times(200)))).max() < 1e-10


def test_a_filter_goes_on_between_the_steps() -> None:
    """Torque 1 - exp(-t / tau): w = (t - tau (1 - exp(-t / tau))) / J, tau = 1 / (2 pi 5 Hz) = 31.8 ms."""
    tau = 1.0 / (2.0 * math.pi * 5.0)
    found = moved(law(filter_cutoff=5.0), FREE, 0.1, np.r_[0.0, np.ones(99)])
    t = np.maximum(times(100) - STEP, 0.0)
    assert np.abs(found.qd[:, 0] - 10.0 * (t - tau * -np.expm1(-t / tau))).max() < 1e-9
    # At the steps it is the law's own: a_k = 1 - exp(-k h / tau).
    assert np.abs(found.torque[:, 0] + np.expm1(-np.maximum(times(99) - STEP, 0.0) / tau)).max() < 1e-13


def test_a_filter_breaks_a_joint_away_between_the_steps() -> None:
    """It reaches 0.5 N*m after tau ln 2 = 22.06 ms, no multiple of a step, and only then moves."""
    tau = 1.0 / (2.0 * math.pi * 5.0)
    found = moved(
        law(filter_cutoff=5.0), PassiveFriction(0.5, 0.0), 0.1, np.r_[0.0, np.ones(8)], substeps=1600
    )
    start = STEP + tau * math.log(2.0)
    end = 8 * STEP
    # J w = integral of 1 - exp(-s / tau) - 0.5 from tau ln 2 on.
    s, s0 = end - STEP, start - STEP
    expected = 10.0 * (0.5 * (s - s0) + tau * (math.exp(-s / tau) - math.exp(-s0 / tau)))
    assert (found.q[:5] == 0.0).all()
    assert abs(found.qd[8, 0] - expected) < 1e-4 * expected


def test_a_delay_is_whole_steps_and_starts_with_the_first_command() -> None:
    """12 ms are 2 steps of 5; the line is full of the first command, 0.4."""
    found = moved(law(delay=0.012), FREE, 0.1, [0.4, 1.0, 2.0, 3.0, 4.0])
    assert found.torque[:, 0].tolist() == [0.4, 0.4, 0.4, 1.0, 2.0]


def test_commands_are_clamped_before_delay_and_filter() -> None:
    """A clamp at 1 lets 3 through as 1."""
    found = moved(law(command_range=(-1.0, 1.0), delay=STEP), FREE, 0.1, [0.5, 3.0, -2.0, 0.0])
    assert found.torque[:, 0].tolist() == [0.5, 0.5, 1.0, -1.0]


def test_soft_friction_creeps() -> None:
    """Under 0.1 N*m it ends where d (tau + J r v) = tau: v = tau (1 - d) / (d J r) = 1.0556e-3 rad/s for J 0.1."""
    found = moved(law(), PassiveFriction(0.2, 0.0, soft=True), 0.1, np.full(200, 0.1))
    creep = 0.1 * (1.0 - SOFT_SHARE) / (SOFT_SHARE * 0.1 * SOFT_RATE)
    assert abs(creep - 1.05556e-3) < 1e-8
    assert abs(found.qd[-1, 0] - creep) < 1e-9


def test_soft_friction_is_mujoco_s(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo with ever smaller steps ends at it: 1e-5 s leave 1e-4 of the way, hard friction 30 times that."""
    import mujoco

    monkeypatch.chdir(tmp_path)
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><option gravity="0 0 0" timestep="1e-5"/><worldbody><body>
        <joint name="j" frictionloss="0.6" damping="0.05"/>
        <inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/></body></worldbody>
        <actuator><position joint="j" kp="25"/></actuator></mujoco>"""
    )
    data = mujoco.MjData(model)
    data.qpos[0] = 0.3
    found = moved(spring(), PassiveFriction(0.6, 0.05, soft=True), 0.1, np.zeros(100), q=0.3)
    hard = moved(spring(), PassiveFriction(0.6, 0.05), 0.1, np.zeros(100), q=0.3)
    got = [0.3]
    for _ in range(100):
        mujoco.mj_step(model, data, 500)
        got.append(data.qpos[0])
    assert np.abs(np.array(got) - found.q[:, 0]).max() < 5e-5
    assert np.abs(found.q - hard.q).max() > 1e-3


def laws(rng: np.random.Generator) -> list[TorqueLaw]:
    """One of each kind, with random numbers."""
    L, ts, w0, kp, kd = rng.uniform(1.0, 40.0, 5)
    common: dict[str, Any] = {"command": Command.POSITION, "kp": kp, "kd": kd, "encoder_bias": 0.1}
    knee = w0 * rng.uniform(0.1, 0.9)
    return [
        law(**common),
        law(**common, effort_limit=L),
        law(**common, effort_limit=L, stall_torque=ts, no_load_speed=w0),
        law(**common, stall_torque=ts, no_load_speed=w0),
        law(**common, effort_limit=L, curve=(ts, 1.3 * ts, knee, w0)),
        law(**common, effort_limit=L, curve=(ts, 1.3 * ts, w0, w0)),
        law(command=Command.VELOCITY, kd=kd, effort_limit=L),
        law(effort_limit=L, stall_torque=ts, no_load_speed=w0),
    ]


@pytest.mark.parametrize("seed", range(10), ids=str)
def test_the_drive_is_the_law(seed: int) -> None:
    """The many-lane form of the laws, written for speed, is `TorqueLaw.torque` at random states and at every corner."""
    rng = np.random.default_rng(seed)
    for one in laws(rng):
        speeds = [
            0.0,
            *(s * x for x in (*(one.curve or ())[2:], one.no_load_speed or 1.0) for s in (1, -1)),
        ]
        qd = np.r_[rng.uniform(-80.0, 80.0, 200), speeds]
        q, command = rng.uniform(-2.0, 2.0, (2, len(qd)))
        lanes = [DrivenJoint(one, FREE, 1.0)] * len(qd)
        (pull,) = _Pull.all(lanes, command[None], STEP)
        found = _Numbers.of(lanes).drive(pull.at(0.0), q, qd)
        assert np.abs(found - one.torque(command, q, qd)).max() < 1e-11 * 40.0 * 80.0


def test_lanes_of_all_kinds_do_not_touch_each_other() -> None:
    """Together they integrate as each alone."""
    rng = np.random.default_rng(7)
    frictions = [
        FREE,
        PassiveFriction(0.3, 0.1),
        PassiveFriction(0.3, 0.0, soft=True),
        PassiveFriction(0.2, 0.0, static=0.4, stribeck_velocity=0.2),
    ]
    lanes = [
        DrivenJoint(one, frictions[i % 4], 0.1 + 0.05 * i)
        for i, one in enumerate([*laws(rng), spring(filter_cutoff=8.0, delay=0.01)])
    ]
    command = np.tile(np.where(np.arange(60) < 20, 0.5, -0.3)[:, None], (1, len(lanes)))
    start = np.full(len(lanes), 0.05)
    together = integrate(lanes, command, start, -start, STEP)
    for i, lane in enumerate(lanes):
        alone = integrate([lane], command[:, [i]], start[[i]], -start[[i]], STEP)
        assert np.abs(alone.q[:, 0] - together.q[:, i]).max() < 1e-12


def test_half_the_substep_changes_nothing_that_is_judged() -> None:
    """Corners of a clamp and landings included: less than 1e-6 of the way, the floor of `response_rows`."""
    one = spring(
        kd=0.4, effort_limit=6.0, stall_torque=8.0, no_load_speed=12.0, filter_cutoff=20.0, delay=0.01
    )
    command = np.where(np.arange(200) % 80 < 40, 0.5, -0.5)
    coarse, fine = (moved(one, PassiveFriction(0.5, 0.02), 0.05, command, substeps=n) for n in (64, 128))
    assert np.ptp(fine.q) > 1.0
    assert np.abs(coarse.q - fine.q).max() < 1e-6
