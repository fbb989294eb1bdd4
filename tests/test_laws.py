"""The torque laws, at points where each wrong reading gives another number."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from actspec import laws
from actspec.ir import (
    AsymmetricCurve,
    Command,
    Delay,
    JointActuator,
    JointKind,
    Level,
    Origin,
    Quantity,
)

EXACT = 1e-12  # float64 rounding of a handful of operations
SINGLE = 1e-6  # float32: 2^-24 a rounding, relative, times a few operations


def q(value: float | None, unit: str = "N*m") -> Quantity:
    return Quantity(value, unit, Origin.UNKNOWN if value is None else Origin.AUTHORED)


BASE = JointActuator(
    joint="FL_hip_joint",
    kind=JointKind.HINGE,
    group="legs",
    pattern=".*_hip_joint",
    motor=None,
    level=Level.IDEAL_PD,
    command=Command.POSITION,
    kp=q(100.0, "N*m/rad"),
    kd=q(4.0, "N*m*s/rad"),
    effort_limit=q(20.0),
    velocity_limit=q(None, "rad/s"),
    stall_torque=None,
    no_load_speed=None,
    curve=None,
    peak_torque=q(None),
    continuous_torque=q(None),
    armature=q(0.01, "kg*m^2"),
    reflected_inertia=q(None, "kg*m^2"),
    friction_coulomb=q(0.5),
    friction_static=None,
    friction_viscous=q(0.1, "N*m*s/rad"),
    stribeck_velocity=None,
    filter_cutoff=None,
    command_range=None,
    delay=None,
    encoder_bias=q(0.0, "rad"),
    action_scale=None,
    default_position=q(0.0, "rad"),
    position_range=None,
    network=None,
    randomize=(),
    inertia_held=None,
    inertia_free=None,
    span=None,
)
GO2 = replace(
    BASE,
    level=Level.DC_MOTOR,
    kp=q(25.0, "N*m/rad"),
    kd=q(0.5, "N*m*s/rad"),
    effort_limit=q(23.5),
    stall_torque=q(23.5),
    no_load_speed=q(30.0, "rad/s"),
)
CURVE = AsymmetricCurve(q(20.0), q(30.0), q(10.0, "rad/s"), q(30.0, "rad/s"))


# PD


def test_position_pd_anchor() -> None:
    """100 (0.5 - 0.3) + 4 (0 - 2) = 20 - 8 = 12; a gain on the wrong sign of the speed gives 28."""
    assert laws.position_pd(0.5, 0.3, 2.0, kp=100.0, kd=4.0) == pytest.approx(12.0, rel=EXACT)


def test_position_pd_speed_command_and_feedforward() -> None:
    """100 * 0.2 + 4 (3 - 2) + 1.5 = 25.5; a feedforward inside the gain gives another number."""
    tau = laws.position_pd(0.5, 0.3, 2.0, kp=100.0, kd=4.0, target_qd=3.0, feedforward=1.5)
    assert tau == pytest.approx(25.5, rel=EXACT)


def test_encoder_bias_is_added_to_the_position() -> None:
    """q_m = 0.3 + 0.05: 100 (0.5 - 0.35) = 15; PACE's later sign, q - bias, gives 25."""
    tau = laws.position_pd(0.5, 0.3, 0.0, kp=100.0, kd=4.0, encoder_bias=0.05)
    assert tau == pytest.approx(15.0, rel=EXACT)


def test_velocity_pd() -> None:
    """4 (3 - 5) + 1 = -7: slower than it runs means a negative torque."""
    assert laws.velocity_pd(3.0, 5.0, kd=4.0, feedforward=1.0) == pytest.approx(-7.0, rel=EXACT)


# Clamps


@pytest.mark.parametrize(
    ("asked", "given"), [(25.0, 20.0), (-25.0, -20.0), (3.0, 3.0)], ids=["high", "low", "inside"]
)
def test_clip_effort(asked: float, given: float) -> None:
    """An ideal drive stops at +- L and touches nothing inside."""
    assert laws.clip_effort(asked, effort_limit=20.0) == given


def test_clip_effort_without_a_limit() -> None:
    """An infinite limit is no limit, and no warning."""
    assert laws.clip_effort(1e6, effort_limit=math.inf) == 1e6


@pytest.mark.parametrize(
    ("qd", "expected"),
    [(0.0, 23.5), (15.0, 11.75), (30.0, 0.0), (45.0, -11.75), (60.0, -23.5), (70.0, -23.5)],
    ids=lambda v: f"{v:g}",
)
def test_dc_motor_anchors(qd: float, expected: float) -> None:
    """Six speeds measured alike in Isaac Lab, mjlab and Newton; kp = 25, kd = 0.5, target 10 rad."""
    tau = laws.position_pd(10.0, 0.0, qd, kp=25.0, kd=0.5)
    got = laws.clip_dc_motor(tau, qd, stall_torque=23.5, no_load_speed=30.0, effort_limit=23.5)
    assert got == pytest.approx(expected, abs=1e-12)


# ts = 40, L = 20, w0 = 30: the knee is at 30 (1 - 20/40) = 15, w is clipped at 30 (1 + 20/40) = 45.
@pytest.mark.parametrize(
    ("tau", "qd", "expected"),
    [
        # Drive: ts (1 - 10/30) = 26.7, so L; L is not scaled by the line (that gives 13.3).
        pytest.param(50.0, 10.0, 20.0, id="below-the-knee"),
        pytest.param(50.0, 15.0, 20.0, id="at-the-knee"),
        pytest.param(50.0, 22.5, 10.0, id="above-the-knee"),  # 40 (1 - 0.75)
        pytest.param(-50.0, -22.5, -10.0, id="above-the-knee-backward"),
        # Braking: the whole L; ts (1 - |w|/w0) gives 10.
        pytest.param(-50.0, 22.5, -20.0, id="brake-forward"),
        pytest.param(50.0, -22.5, 20.0, id="brake-backward"),
        # Beyond no-load speed: 40 (1 - 40/30) = -13.33 though + is asked; a clip at 0 gives 0.
        pytest.param(50.0, 40.0, -40.0 / 3.0, id="overspeed-forward"),
        pytest.param(-50.0, -40.0, 40.0 / 3.0, id="overspeed-backward"),
        pytest.param(-50.0, 40.0, -20.0, id="overspeed-brake"),
        # 60 counts as 45: 40 (1 - 1.5) = -20; without that clip -40, more than the drive has.
        pytest.param(50.0, 60.0, -20.0, id="speed-clip-forward"),
        pytest.param(-50.0, -60.0, 20.0, id="speed-clip-backward"),
        pytest.param(3.0, 10.0, 3.0, id="inside"),
    ],
)
def test_dc_motor_quadrants(tau: float, qd: float, expected: float) -> None:
    """Four quadrants of a motor whose stall torque is twice its limit."""
    got = laws.clip_dc_motor(tau, qd, stall_torque=40.0, no_load_speed=30.0, effort_limit=20.0)
    assert got == pytest.approx(expected, rel=EXACT)


def test_dc_motor_braking_is_not_the_symmetric_form() -> None:
    """At half speed a brake of a motor with ts = L has 23.5; ts (1 - |w|/w0) gives 11.75."""
    got = laws.clip_dc_motor(-50.0, 15.0, stall_torque=23.5, no_load_speed=30.0, effort_limit=23.5)
    assert got == -23.5


def test_dc_motor_without_effort_limit() -> None:
    """An infinite L leaves the line: drive 40 (1 - 0.5) = 20, brake 40 (-1 - 0.5) = -60."""
    kwargs = {"stall_torque": 40.0, "no_load_speed": 30.0, "effort_limit": math.inf}
    assert laws.clip_dc_motor(500.0, 15.0, **kwargs) == pytest.approx(20.0, rel=EXACT)
    assert laws.clip_dc_motor(-500.0, 15.0, **kwargs) == pytest.approx(-60.0, rel=EXACT)


# drive 20, brake 30, knee 10, no-load 30.
@pytest.mark.parametrize(
    ("tau", "qd", "limit", "expected"),
    [
        # Below the knee the slope 1 - (5 - 10)/20 = 1.25 must not be taken: it gives 25.
        pytest.param(50.0, 5.0, 1000.0, 20.0, id="drive"),
        pytest.param(-50.0, 5.0, 1000.0, -30.0, id="brake"),
        pytest.param(-50.0, -5.0, 1000.0, -20.0, id="drive-backward"),
        pytest.param(50.0, -5.0, 1000.0, 30.0, id="brake-backward"),
        pytest.param(50.0, 0.0, 1000.0, 30.0, id="standstill-is-brake"),
        pytest.param(50.0, 10.0, 1000.0, 20.0, id="at-the-knee"),
        pytest.param(50.0, 20.0, 1000.0, 10.0, id="drive-above-the-knee"),  # 20 (1 - 10/20)
        pytest.param(-50.0, 20.0, 1000.0, -15.0, id="brake-above-the-knee"),  # 30 (1 - 10/20)
        # Never negative: 20 (1 - 30/20) = -10 would turn the torque round.
        pytest.param(50.0, 40.0, 1000.0, 0.0, id="beyond-no-load"),
        pytest.param(-50.0, 40.0, 1000.0, 0.0, id="beyond-no-load-brake"),
        pytest.param(50.0, 5.0, 12.0, 12.0, id="limit"),
        # min(10, 12); an L that falls with the curve gives 6.
        pytest.param(50.0, 20.0, 12.0, 10.0, id="limit-does-not-fall"),
        pytest.param(3.0, 5.0, 1000.0, 3.0, id="inside"),
        pytest.param(0.0, 5.0, 1000.0, 0.0, id="nothing-asked"),
    ],
)
def test_asymmetric_curve(tau: float, qd: float, limit: float, expected: float) -> None:
    """Drive and brake torque, the knee, and the drive's limit."""
    got = laws.clip_asymmetric(
        tau,
        qd,
        drive_torque=20.0,
        brake_torque=30.0,
        knee_speed=10.0,
        no_load_speed=30.0,
        effort_limit=limit,
    )
    assert got == pytest.approx(expected, rel=EXACT, abs=1e-12)


@pytest.mark.parametrize(
    ("qd", "expected"), [(9.9, 20.0), (10.0, 20.0), (10.1, 0.0)], ids=["below", "at", "above"]
)
def test_asymmetric_curve_may_be_a_cliff(qd: float, expected: float) -> None:
    """A knee at no-load speed divides by nothing."""
    got = laws.clip_asymmetric(
        50.0,
        qd,
        drive_torque=20.0,
        brake_torque=30.0,
        knee_speed=10.0,
        no_load_speed=10.0,
        effort_limit=1000.0,
    )
    assert got == expected


def test_clip_command() -> None:
    """A command range clamps both ends, each by its own bound."""
    got = laws.clip_command(np.array([-3.0, 0.0, 3.0]), low=-1.0, high=2.0)
    np.testing.assert_array_equal(got, [-1.0, 0.0, 2.0])


# Passive part


@pytest.mark.parametrize(
    ("qd", "expected"), [(2.0, -0.7), (-2.0, 0.7), (0.0, 0.0)], ids=["forward", "backward", "still"]
)
def test_passive_torque(qd: float, expected: float) -> None:
    """-(0.5 + 0.1 * 2) = -0.7: against the motion, and nothing at rest."""
    assert laws.passive_torque(qd, coulomb=0.5, viscous=0.1) == pytest.approx(expected, rel=EXACT)


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["forward", "backward"])
def test_stribeck(sign: float) -> None:
    """1 + 2 exp(-(1/0.5)^2) = 1.0366313, and 0.2 * 1: 1.2366313; the exponent -|w|/ws gives 1.4706706."""
    got = laws.passive_torque(sign, coulomb=1.0, viscous=0.2, static=3.0, stribeck_velocity=0.5)
    assert got == pytest.approx(-sign * 1.2366312777774683, rel=1e-9)


def test_static_friction_alone_changes_no_sliding_friction() -> None:
    """Break-away friction without a Stribeck velocity is the engine's business at rest."""
    assert laws.passive_torque(1.0, coulomb=1.0, viscous=0.2, static=3.0) == pytest.approx(-1.2, rel=EXACT)


# Command path


def run(commands: list[float], first: float, steps: int, alpha: float | None) -> list[float]:
    state = laws.initial_command_state(first, steps)
    seen = []
    for command in commands:
        effective, state = laws.step_command(state, command, steps=steps, alpha=alpha)
        seen.append(float(effective))
    return seen


TAU_50_MS = 1.0 / (2.0 * math.pi * 0.05)  # cutoff of tau = 0.05 s: 3.1831 Hz


def test_filter_gain_is_exact_and_takes_hertz() -> None:
    """1 - exp(-0.01/0.05) = 0.181269; h/tau gives 0.2, a cutoff in rad/s 0.0313."""
    assert laws.filter_gain(TAU_50_MS, 0.01) == pytest.approx(0.18126924692201815, rel=1e-12)


@pytest.mark.parametrize("bad", [0.0, -1.0, math.inf, math.nan], ids=["zero", "negative", "inf", "nan"])
def test_filter_gain_refuses(bad: float) -> None:
    """A cutoff or step that is none is an error with its unit."""
    with pytest.raises(ValueError) as error:
        laws.filter_gain(bad, 0.01)
    assert str(error.value) == f"cutoff must be finite and > 0 Hz, got {bad:g} Hz"
    with pytest.raises(ValueError):
        laws.filter_gain(30.0, bad)


def test_filter_step_by_step() -> None:
    """MuJoCo filterexact: 0, then 1 - exp(-k h/tau); a filter that acts early starts at 0.181269."""
    seen = run([1.0] * 4, 0.0, 0, laws.filter_gain(TAU_50_MS, 0.01))
    assert seen == pytest.approx([0.0, 0.181269, 0.329680, 0.451188], abs=5e-7)


def test_delay_step_by_step() -> None:
    """MuJoCo delay of 3 steps: the step arrives in the fourth."""
    assert run([1.0] * 5, 0.0, 3, None) == [0.0, 0.0, 0.0, 1.0, 1.0]


def test_delay_line_keeps_order_and_starts_at_the_first_command() -> None:
    """The line holds 7 until the commands come out in the order they went in; MuJoCo's reset starts at 0."""
    assert run([7.0, 1.0, 2.0, 3.0, 4.0], 7.0, 2, None) == [7.0, 7.0, 7.0, 1.0, 2.0]


def test_no_delay_and_no_filter_is_the_command_itself() -> None:
    """Without delay and filter there is no lag of one step either."""
    assert run([1.0, 2.0, 3.0], 0.0, 0, None) == [1.0, 2.0, 3.0]


def test_delay_comes_before_the_filter() -> None:
    """3 steps late, then the filter's own lag of one: 0 0 0 0 0.181269, as measured in MuJoCo."""
    seen = run([1.0] * 6, 0.0, 3, laws.filter_gain(TAU_50_MS, 0.01))
    assert seen == pytest.approx([0.0, 0.0, 0.0, 0.0, 0.181269, 0.329680], abs=5e-7)


def test_filter_starts_at_the_first_command() -> None:
    """A joint that stands at its command stays there: no jump from 0."""
    assert run([0.8, 0.8, 0.8], 0.8, 2, 0.25) == pytest.approx([0.8, 0.8, 0.8], rel=EXACT)


def test_state_does_not_share_the_callers_buffer() -> None:
    """A command buffer that is written anew each step does not rewrite the delay line."""
    buffer = np.array([1.0, 1.0])
    state = laws.initial_command_state(buffer, 1)
    buffer[:] = 5.0
    first, state = laws.step_command(state, buffer, steps=1, alpha=None)
    buffer[:] = 9.0
    second, state = laws.step_command(state, buffer, steps=1, alpha=None)
    np.testing.assert_array_equal(first, [1.0, 1.0])
    np.testing.assert_array_equal(second, [5.0, 5.0])


def test_step_command_leaves_the_old_state_alone() -> None:
    """The same state stepped twice gives the same answer."""
    state = laws.initial_command_state(0.0, 1)
    _, once = laws.step_command(state, 1.0, steps=1, alpha=0.5)
    _, again = laws.step_command(state, 1.0, steps=1, alpha=0.5)
    assert once == again
    assert state == laws.CommandState((0.0,), 0.0)


def test_step_command_refuses_another_delay() -> None:
    """A state of one delay is not silently used for another."""
    with pytest.raises(ValueError) as error:
        laws.step_command(laws.initial_command_state(0.0, 2), 1.0, steps=3, alpha=None)
    assert str(error.value) == "the state holds a delay of 2 steps, asked for 3"


@pytest.mark.parametrize("steps", [-1, laws.MAX_DELAY_STEPS + 1], ids=["negative", "endless"])
def test_initial_state_refuses(steps: int) -> None:
    """A delay line has a length that a machine can hold."""
    with pytest.raises(ValueError, match="delay must be 0 to 1000000 steps"):
        laws.initial_command_state(0.0, steps)


@pytest.mark.parametrize(
    ("delay", "step", "steps", "loss"),
    [
        pytest.param(0.03, 0.01, 3, 0.0, id="whole"),
        pytest.param(0.0, 0.005, 0, 0.0, id="none"),
        pytest.param(0.007, 0.005, 1, -0.002, id="shorter"),  # 5 ms given for 7 ms
        pytest.param(0.008, 0.005, 2, 0.002, id="longer"),  # 10 ms given for 8 ms
        pytest.param(0.025, 0.01, 3, 0.005, id="half-goes-up"),  # 2.5: half-even would give 2
        pytest.param(0.0045, 0.003, 2, 0.0015, id="half-goes-up-though-inexact"),  # 1.4999999999999998
        pytest.param(0.002, 0.005, 0, -0.002, id="lost"),
        pytest.param(3e-6, 0.002, 0, 0.0, id="a-seven-hundredth-is-none"),
        pytest.param(0.002019, 0.002, 1, 0.0, id="a-hundredth-more-is-whole"),
        pytest.param(0.00203, 0.002, 1, -3e-5, id="more-than-a-hundredth"),
    ],
)
def test_delay_steps(delay: float, step: float, steps: int, loss: float) -> None:
    """The nearest number of steps, and what it costs in seconds; whole steps cost exactly nothing."""
    got = laws.delay_steps(delay, step)
    assert got.steps == steps
    assert got.loss == (pytest.approx(loss, rel=1e-9) if loss else 0.0)


@pytest.mark.parametrize(
    ("delay", "step"),
    [(-0.001, 0.005), (math.inf, 0.005), (math.nan, 0.005), (1.0, 0.0), (1e308, 1e-300)],
    ids=["negative", "inf", "nan", "no-step", "endless"],
)
def test_delay_steps_refuses(delay: float, step: float) -> None:
    """A delay or step that is none is a ValueError, never an overflow."""
    with pytest.raises(ValueError, match="must be"):
        laws.delay_steps(delay, step)


# One actuator


def test_law_of_ideal_pd() -> None:
    """100 (0.5 - 0.3) - 4 * 2 = 12 inside; 100 * 0.7 = 70 stops at 20."""
    law = laws.law_of(BASE)
    assert law.torque(0.5, 0.3, 2.0) == pytest.approx(12.0, rel=EXACT)
    assert law.torque(1.0, 0.3, 0.0) == 20.0


def test_law_of_ideal_pd_ignores_a_line() -> None:
    """The line of a motor is no part of the ideal drive: 20 at no-load speed, not 0."""
    law = laws.law_of(replace(BASE, stall_torque=q(20.0), no_load_speed=q(30.0), curve=CURVE))
    assert (law.stall_torque, law.no_load_speed, law.curve) == (None, None, None)
    assert law.torque(10.0, 0.0, 30.0) == 20.0


def test_law_of_dc_motor() -> None:
    """The anchor at 15 rad/s, 11.75, through the IR."""
    assert laws.law_of(GO2).torque(10.0, 0.0, 15.0) == pytest.approx(11.75, rel=EXACT)


def test_law_of_curve_stands_in_place_of_the_line() -> None:
    """At 20 rad/s the curve leaves 20 (1 - 10/20) = 10 and the line 23.5 (1 - 20/30) = 7.83."""
    law = laws.law_of(replace(GO2, curve=CURVE))
    assert law.curve == (20.0, 30.0, 10.0, 30.0)
    assert law.torque(10.0, 0.0, 20.0) == pytest.approx(10.0, rel=EXACT)


def test_law_of_velocity_command() -> None:
    """4 (3 - 5) = -8, with no pull to a position: kp = 0 and q = 9 does nothing."""
    law = laws.law_of(replace(BASE, command=Command.VELOCITY, kp=None))
    assert law.kp == 0.0
    assert law.torque(3.0, 9.0, 5.0) == pytest.approx(-8.0, rel=EXACT)


def test_law_of_effort_command_is_clipped() -> None:
    """A torque command has no gains, but the drive's clamp."""
    law = laws.law_of(replace(BASE, command=Command.EFFORT, kp=None, kd=None))
    assert law.torque(7.0, 9.0, 5.0) == 7.0
    assert law.torque(70.0, 9.0, 5.0) == 20.0


def test_law_of_uses_the_encoder_bias() -> None:
    """100 (0.5 - (0.3 + 0.05)) = 15."""
    law = laws.law_of(replace(BASE, encoder_bias=q(0.05, "rad")))
    assert law.torque(0.5, 0.3, 0.0) == pytest.approx(15.0, rel=EXACT)


def test_friction_is_outside_the_clamp() -> None:
    """At 2 rad/s the drive gives its whole 20 and friction takes 0.7 of it; inside the clamp 20 is left."""
    drive = laws.law_of(BASE).torque(10.0, 0.0, 2.0)
    assert drive == 20.0
    passive = laws.passive_torque(
        2.0, coulomb=BASE.friction_coulomb.require(), viscous=BASE.friction_viscous.require()
    )
    assert drive + passive == pytest.approx(19.3, rel=EXACT)


def test_law_of_unknown_limit_is_no_limit() -> None:
    """100 * 10 = 1000 passes where nobody says what the drive can do."""
    law = laws.law_of(replace(BASE, effort_limit=q(None)))
    assert law.effort_limit == math.inf
    assert law.torque(10.0, 0.0, 0.0) == 1000.0


def test_law_of_command_path() -> None:
    """Filter, nominal delay and range are carried over; the range's unknown end is open."""
    law = laws.law_of(
        replace(
            BASE,
            filter_cutoff=q(30.0, "Hz"),
            delay=Delay(q(0.005, "s"), 0.0, 0.01, "episode"),
            command_range=(q(-1.0, "rad"), q(None, "rad")),
        )
    )
    assert (law.filter_cutoff, law.delay, law.command_range) == (30.0, 0.005, (-1.0, math.inf))
    bare = laws.law_of(BASE)
    assert (bare.filter_cutoff, bare.delay, bare.command_range) == (None, 0.0, None)


@pytest.mark.parametrize(
    ("actuator", "message"),
    [
        pytest.param(
            replace(BASE, level=Level.ACTUATOR_NET),
            "FL_hip_joint: level actuator_net has no torque law here: its torque is the network's",
            id="network",
        ),
        pytest.param(
            replace(BASE, kp=q(None)),
            "FL_hip_joint: kp is unknown, level ideal_pd with command position needs it",
            id="kp",
        ),
        pytest.param(
            replace(BASE, kd=q(None)),
            "FL_hip_joint: kd is unknown, level ideal_pd with command position needs it",
            id="kd",
        ),
        pytest.param(
            replace(GO2, stall_torque=None),
            "FL_hip_joint: stall_torque is unknown, level dc_motor with command position needs it",
            id="no-line",
        ),
        pytest.param(
            replace(GO2, no_load_speed=q(0.0)),
            "FL_hip_joint: stall_torque and no_load_speed must be > 0, got 23.5 and 0",
            id="line-to-zero",
        ),
        pytest.param(
            replace(GO2, curve=replace(CURVE, brake_torque=q(None))),
            "FL_hip_joint: curve.brake_torque is unknown, level dc_motor with command position needs it",
            id="curve-unknown",
        ),
        pytest.param(
            replace(GO2, curve=replace(CURVE, knee_speed=q(40.0))),
            "FL_hip_joint: curve.knee_speed must be from 0 to no_load_speed, got 40 with no_load_speed 30",
            id="curve-knee",
        ),
        pytest.param(
            replace(GO2, curve=replace(CURVE, drive_torque=q(-1.0))),
            "FL_hip_joint: curve.drive_torque and brake_torque must be >= 0, got -1 and 30",
            id="curve-negative",
        ),
        pytest.param(
            replace(BASE, effort_limit=q(-5.0)),
            "FL_hip_joint: effort_limit must be >= 0 N*m, got -5",
            id="limit-negative",
        ),
    ],
)
def test_law_of_refuses(actuator: JointActuator, message: str) -> None:
    """Where there is no law the error names the joint, the field and the value."""
    with pytest.raises(ValueError) as error:
        laws.law_of(actuator)
    assert str(error.value) == message


# Libraries

SPEEDS = [-70.0, -22.5, -5.0, 0.0, 5.0, 10.0, 22.5, 70.0]


def every_law(array: Any) -> list[Any]:
    """All laws over `SPEEDS`, with parameters that are no short binary fractions."""
    w = array(SPEEDS)
    tau = array([-30.1, 30.2, 3.3, 30.4, -30.5, 30.6, -0.7, 30.8])
    curve = {"drive_torque": 20.1, "brake_torque": 30.2, "knee_speed": 10.0, "no_load_speed": 30.3}
    state = laws.initial_command_state(w, 1)
    _, state = laws.step_command(state, tau, steps=1, alpha=0.1)
    filtered, state = laws.step_command(state, tau, steps=1, alpha=0.1)
    return [
        laws.position_pd(0.1, tau, w, kp=100.1, kd=4.1, encoder_bias=0.1),
        laws.velocity_pd(0.1, w, kd=4.1),
        laws.clip_effort(tau, effort_limit=20.1),
        laws.clip_dc_motor(tau, w, stall_torque=40.1, no_load_speed=30.1, effort_limit=20.1),
        laws.clip_asymmetric(tau, w, **curve, effort_limit=25.1),
        laws.clip_command(tau, low=-0.1, high=0.7),
        laws.passive_torque(w, coulomb=0.1, viscous=0.3),
        laws.passive_torque(w, coulomb=0.1, viscous=0.3, static=0.7, stribeck_velocity=6.1),
        filtered,
        state.filtered,
        laws.law_of(GO2).torque(0.1, tau, w),
    ]


def test_floats_and_arrays_agree() -> None:
    """One call over an array is many calls over floats, and a float stays a scalar."""
    together = laws.law_of(GO2).torque(10.0, np.zeros(len(SPEEDS)), np.array(SPEEDS))
    alone = [laws.law_of(GO2).torque(10.0, 0.0, w) for w in SPEEDS]
    np.testing.assert_array_equal(together, alone)
    assert all(isinstance(tau, float) for tau in alone)


def test_limits_may_differ_by_joint() -> None:
    """Parameters broadcast: (2, 1) states by (3,) joints give (2, 3)."""
    tau = laws.clip_effort(np.array([[5.0], [50.0]]), effort_limit=np.array([1.0, 10.0, 100.0]))
    np.testing.assert_array_equal(tau, [[1.0, 5.0, 5.0], [1.0, 10.0, 50.0]])


@pytest.mark.slow
@pytest.mark.parametrize("library", ["torch", "array_api_strict"])
@pytest.mark.parametrize(
    ("dtype", "tolerance"), [("float64", EXACT), ("float32", SINGLE)], ids=["f64", "f32"]
)
def test_libraries_agree(library: str, dtype: str, tolerance: float) -> None:
    """The same numbers from another library, of its own type and width: 0.1 is not cut to float32."""
    xp = pytest.importorskip(library)
    expected = every_law(np.array)
    given = every_law(lambda values: xp.asarray(values, dtype=getattr(xp, dtype)))
    for want, got in zip(expected, given, strict=True):
        assert type(got) is type(xp.asarray([0.0]))
        assert got.dtype == getattr(xp, dtype)
        scale = float(np.abs(want).max())
        np.testing.assert_allclose([float(v) for v in got], want, rtol=tolerance, atol=tolerance * scale)


@pytest.mark.slow
def test_torch_gradients_pass() -> None:
    """d tau/dq is -kp = -25 inside the clamp and 0 in it; a copy cut off the graph has none."""
    torch = pytest.importorskip("torch")
    position = torch.tensor([0.0, -9.0], dtype=torch.float64, requires_grad=True)
    laws.law_of(GO2).torque(0.1, position, 0.0).sum().backward()
    assert position.grad.tolist() == [-25.0, 0.0]


def test_numpy_keeps_single_precision() -> None:
    """Python parameters do not widen a float32 array."""
    for got in every_law(lambda values: np.array(values, dtype=np.float32)):
        assert got.dtype == np.float32


def test_integer_arrays_do_not_cut_parameters() -> None:
    """0.5 next to integers stays 0.5: 0.5 (0 - 3) = -1.5."""
    assert laws.velocity_pd(np.array([0]), np.array([3]), kd=0.5)[0] == -1.5


def test_two_libraries_are_refused() -> None:
    """Arrays of two libraries are an error that names both, not a copy behind one's back."""
    strict = pytest.importorskip("array_api_strict")
    with pytest.raises(TypeError) as error:
        laws.array_namespace(np.zeros(1), 1.0, strict.asarray([0.0]))
    assert str(error.value) == "arrays of two libraries: array_api_strict, numpy"


def test_namespace_of_numbers_is_numpy() -> None:
    """Python numbers fit every library, and alone they are numpy's."""
    assert laws.array_namespace(1.0, 2) is np
    assert laws.array_namespace() is np


def test_import_is_light() -> None:
    """Importing laws and units imports no array library."""
    code = "import sys, actspec.laws, actspec.units; print({'numpy', 'torch', 'jax'} & set(sys.modules))"
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    result = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "set()"
