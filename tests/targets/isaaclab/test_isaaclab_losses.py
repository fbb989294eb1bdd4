"""What the Isaac Lab classes cannot hold: named, and sized by hand."""

from __future__ import annotations

import pytest

from tests.frameworks.isaaclab_asking import compiled
from tests.frameworks.isaaclab_specs import WHOLE
from tests.targets.isaaclab.emitting import DC, PD, SPEC, cfgs, lost, made


def test_torque_limits_before_delay_before_filter() -> None:
    """DCMotor holds the line and neither delay nor filter: both are lost, sized, and nothing becomes a delay."""
    emitted = made(f'all: {{joints: [".*"], {DC}, delay: 10 ms, command_filter: {{cutoff: 30 Hz}}}}')
    group = cfgs(emitted.text)["all"]
    assert group["class"] == "DCMotorCfg"
    assert "max_delay" not in group
    sizes = {a.field: a.max_torque_error for a in emitted.emission.approximations if a.joint == "a_hip"}
    assert sizes == {"delay": pytest.approx(4.5), "command_filter": pytest.approx(4.5)}


def test_two_quadrants_of_2_1_are_sized() -> None:
    """From 30 (1 + 9/45) = 36 rad/s the law forces -9 N*m; DCMotor of 2.1 allows 0, and with 2.2 nothing is lost."""
    group = f'all: {{joints: [".*"], {DC}}}'
    (loss,) = {(a.max_torque_error, a.at, a.beyond) for a in made(group, "2.1").emission.approximations}
    assert loss == (0.0, "", pytest.approx(9.0))
    assert made(group, "2.2").emission.approximations == ()
    assert made(group, "2.1", "custom").emission.approximations == ()


def test_curve_becomes_the_line_of_its_drive_side() -> None:
    """From 20 N*m at 14 rad/s to 0 at 30: a line from 20 / (1 - 14/30) = 37.5 N*m, cut at 20; no braking alike."""
    group = cfgs(compiled(WHOLE).text)["curve"]
    assert (group["saturation_effort"], group["velocity_limit"], group["effort_limit"]) == (37.5, 30.0, 20.0)
    losses = {a.field: a.max_torque_error for a in compiled(WHOLE).emission.approximations if a.joint == "c"}
    # Beyond 30 (1 + 20/37.5) = 46 rad/s the line forces -20 N*m, and the curve has nothing left.
    assert losses["torque_speed_curve"] == pytest.approx(20.0)


@pytest.mark.parametrize(
    "kd, size", [("0 N*m*s/rad", 9.0), ("0.5 N*m*s/rad", 18.0)], ids=["no-kd", "kd-at-speed"]
)
def test_clamp_of_the_command_is_sized(kd: str, size: float) -> None:
    """Commands clamped to +-0.1 rad: at 0.1 the joint gets 0 of the 9 N*m that the law gives, or -9 while it moves."""
    pd = PD.replace("0.5 N*m*s/rad", kd)
    # Without a model the joint is taken to stay in the range of its command. Speeds go to 2 x 9/0.5 = 36 rad/s,
    # where kd alone asks for -18 N*m.
    assert lost(made(f'all: {{joints: [".*"], {pd}, command_range: [-0.1 rad, 0.1 rad]}}')) == {
        "command_range": pytest.approx(size)
    }


BRAKES = SPEC.replace(
    "stall_torque: 45 N*m, no_load_speed: 30 rad/s, peak_torque: 24 N*m",
    "curve: {{drive_torque: 2 N*m, brake_torque: 20 N*m, knee_speed: 3 rad/s, no_load_speed: 6 rad/s}}",
).format(
    name="bot",
    robot="",
    joints="a",
    groups="all: {joints: [a], motor: m, level: dc_motor, kp: 20 N*m/rad, kd: 0 N*m*s/rad, effort_limit: 9 N*m, "
    "encoder_bias: 0.5 rad, command_range: [-0.1 rad, 0.1 rad]}",
)
"""A joint that brakes with 9 N*m and drives with 2."""


def test_clamp_behind_an_asymmetric_curve_is_sized_at_standstill() -> None:
    """Held at 0.1 rad with bias 0.5: the clamped drive asks -20 x 0.5 = -10 and brakes with 9, the law gives +9."""
    # While it moves, the drive side has 2 N*m at most; at standstill either side has the brake's.
    assert lost(compiled(BRAKES), "a")["command_range"] == pytest.approx(18.0)


@pytest.mark.parametrize("version", ["2.1", "2.3"])
def test_curve_is_one_loss(version: str) -> None:
    """Braking with 9 N*m where the drive side's line has 2: one entry of 7, which in 2.1 names the quadrants too."""
    emitted = compiled(BRAKES, version)
    assert lost(emitted, "a")["torque_speed_curve"] == pytest.approx(7.0)
    (loss,) = (a for a in emitted.emission.approximations if a.field == "torque_speed_curve")
    assert loss.asked == "curve: drive 2 N*m, brake 20 N*m, knee 3, no load 6 rad/s"
    assert loss.emitted.startswith("line from 4 N*m to 6 rad/s, cut at 2 N*m")
    assert ("above no-load speed" in loss.emitted) is (version == "2.1")


@pytest.mark.parametrize("version", ["2.1", "2.3"])
@pytest.mark.parametrize(
    "level, more", [(PD, set()), (DC, {"torque_speed_curve"})], ids=["ideal_pd", "dc_motor"]
)
def test_solver_does_not_limit_a_commanded_torque(version: str, level: str, more: set[str]) -> None:
    """Twice 9 N*m asked for through an implicit group arrive whole: 9 too many, with a line and without."""
    effort = level.replace("kp: 20 N*m/rad, kd: 0.5 N*m*s/rad", "command: effort")
    group = f'all: {{joints: [".*"], {effort}}}'
    sizes = lost(made(group, version, "implicit"))
    assert set(sizes) == {"effort_limit", *more}
    assert sizes["effort_limit"] == pytest.approx(9.0)
    if more:
        # At no-load speed the line has nothing left of the 18 that are asked for; at twice that it forces -9.
        assert sizes["torque_speed_curve"] == pytest.approx(18.0)
        emission = made(group, version, "implicit").emission
        assert {a.beyond for a in emission.approximations if a.at} == {27.0}
    assert "effort_limit" not in lost(made(group, version))
    assert "effort_limit" not in lost(made(f'all: {{joints: [".*"], {level}}}', version, "implicit"))


def test_unknown_gains_do_not_shrink_a_loss() -> None:
    """The USD's gains act where kp and kd are unknown: what is lost is as large as the limit allows, not 0."""
    unknown = DC.replace("20 N*m/rad", "unknown").replace("0.5 N*m*s/rad", "unknown")
    more = (
        "encoder_bias: 0.1 rad, command_range: [-1 rad, 1 rad], delay: 10 ms, command_filter: {cutoff: 9 Hz}"
    )
    group = f'all: {{joints: [".*"], {unknown}, {more}}}'
    assert lost(made(group)) == pytest.approx(
        {"encoder_bias": 18.0, "command_range": 18.0, "delay": 4.5, "command_filter": 4.5}
    )


def test_viscous_friction_of_a_torque_command_needs_a_speed() -> None:
    """Without gains and line no speed is given: the size is that at the joint's limit, 0.04 x 12, or none at all."""
    effort = PD.replace("kp: 20 N*m/rad, kd: 0.5 N*m*s/rad", "command: effort")
    group = f'all: {{joints: [".*"], {effort}, friction: {{viscous: 0.04 N*m*s/rad}}%s}}'
    assert lost(made(group % ", velocity_limit: 12 rad/s", "2.1")) == {
        "friction.viscous": pytest.approx(0.48)
    }
    assert lost(made(group % "", "2.1")) == {"friction.viscous": None}


@pytest.mark.parametrize(
    "version, backend",
    [("2.1", None), ("2.2", None), ("2.3", None), ("3.0", None), ("3.0", "newton"), ("3.0", "ovphysx")],
)
def test_stribeck_is_lost_everywhere(version: str, backend: str | None) -> None:
    """Static 0.5 above coulomb 0.3 with a Stribeck velocity: no solver has the curve between them, 0.2 N*m."""
    friction = "friction: {coulomb: 0.3 N*m, static: 0.5 N*m, stribeck_velocity: 0.1 rad/s}"
    emitted = made(f'all: {{joints: [".*"], {PD}, {friction}}}', version, backend=backend)
    assert lost(emitted)["friction.stribeck_velocity"] == pytest.approx(0.2)


def test_sliding_friction_that_nobody_states_is_said() -> None:
    """Static friction alone leaves the sliding one to the USD, which may be above it."""
    emitted = made(f'all: {{joints: [".*"], {PD}, friction: {{coulomb: unknown, static: 0.5 N*m}}}}')
    assert "Nobody states the sliding friction: the USD's own." in emitted.text
    assert "dynamic_friction" not in emitted.text


@pytest.mark.parametrize(
    "version, delay, lags, losses",
    [
        ("2.3", "{nominal: unknown, range: [5 ms, 20 ms]}", (1, 4), {}),
        ("2.3", "{nominal: unknown, range: [10 ms, 10 ms]}", (2, 2), {}),
        ("2.3", "{nominal: 5 ms, range: [4 ms, 6 ms], sampling: step}", (1, 1), {"delay.range": 4.5}),
        ("3.0", "{nominal: unknown, range: [5 ms, 20 ms]}", None, {"delay.range": 4.5}),
        ("3.0", "{nominal: unknown, range: [10 ms, 10 ms]}", (2, 2), {}),
        ("2.3", "unknown", None, {}),
    ],
    ids=["range", "one-value", "one-step", "3.0-range", "3.0-one-value", "unknown"],
)
def test_range_of_an_unknown_delay_is_not_lost(
    version: str, delay: str, lags: tuple[int, int] | None, losses: dict[str, float]
) -> None:
    """A range says what is drawn even where nobody knows the nominal; where it cannot be, the loss is stated."""
    emitted = made(f'all: {{joints: [".*"], {PD}, delay: {delay}}}', version)
    group = cfgs(emitted.text)["all"]
    assert (None if "max_delay" not in group else (group["min_delay"], group["max_delay"])) == lags
    assert lost(emitted) == pytest.approx(losses)
    none = made(f'all: {{joints: [".*"], {DC}, delay: {delay}}}', version)
    assert lost(none) == pytest.approx({} if delay == "unknown" else {"delay": 4.5})
