"""What a MuJoCo drive cannot hold: what is said, and the torque that it makes; L = 9 N*m, kp = 40, step 2 ms."""

from __future__ import annotations

import math

import pytest

from tests.compiling import compile_text

LEG = """<mujoco><option timestep="0.002"/><worldbody><body>
  <joint name="hip"/><geom size=".1"/></body></worldbody></mujoco>"""
HIP = (
    "  hip:\n    joints: [hip]\n    level: %s\n    kp: 40\n    kd: 2\n    effort_limit: 9\n    motor: line\n"
)
HALF = 4.5
"""0.5 L: a step of the command that one path has and the other has not yet [N*m]."""


def losses(
    fields: str, version: str, level: str = "ideal_pd"
) -> dict[str, tuple[str, str, str, float | None]]:
    """Asked, emitted, why and error of each field that is lost."""
    found = compile_text(HIP % level + "".join(f"    {line}\n" for line in fields.split("; ")), LEG, version)
    return {a.field: (a.asked, a.emitted, a.why, a.max_torque_error) for a in found.emission.approximations}


@pytest.mark.parametrize(
    ("fields", "version", "field", "expected"),
    [
        pytest.param(
            "delay: 5 ms",
            "4.0",
            "delay",
            # 2.5 steps are rounded up
            ("5 ms", "6 ms (3 steps of 2 ms)", "1 ms more than asked", HALF),
            id="longer delay",
        ),
        pytest.param(
            "delay: 4.5 ms",
            "4.0",
            "delay",
            ("4.5 ms", "4 ms (2 steps of 2 ms)", "0.5 ms less than asked", HALF),
            id="shorter delay",
        ),
        pytest.param(
            "delay: 6 ms",
            "3.2",
            "delay",
            ("6 ms", "none", "MuJoCo 3.2 has no actuator delay", HALF),
            id="no delay",
        ),
        pytest.param(
            "delay: {nominal: 6 ms, range: [2 ms, 9 ms]}",
            "4.0",
            "delay.range",
            ("2 to 9 ms, drawn each episode", "6 ms (3 steps of 2 ms)", "one fixed delay", HALF),
            id="range",
        ),
        pytest.param(
            "delay: {nominal: 6 ms, range: [2 ms, 9 ms], sampling: step}; command_filter: {cutoff: 10 Hz}",
            "4.0",
            "delay.range",
            # 4 ms at most from the fixed 6 ms; the filter has then let through 1 - exp(-2 pi 10 Hz 4 ms) of the step.
            (
                "2 to 9 ms, drawn each step",
                "6 ms (3 steps of 2 ms)",
                "one fixed delay",
                HALF * (1 - math.exp(-0.08 * math.pi)),
            ),
            id="range behind a filter",
        ),
        pytest.param(
            "delay: {nominal: 4 ms, range: [0 ms, 9 ms]}; command_filter: {cutoff: 10 Hz}",
            "3.2",
            "delay.range",
            # Without a delay, 9 ms are the farthest.
            (
                "0 to 9 ms, drawn each episode",
                "none",
                "one fixed delay",
                HALF * (1 - math.exp(-0.18 * math.pi)),
            ),
            id="range without delay",
        ),
        pytest.param(
            "delay: {nominal: unknown, range: [0 ms, 9 ms]}; command_filter: {cutoff: 10 Hz}",
            "4.0",
            "delay.range",
            # Without a nominal there is no delay, 9 ms from the farthest.
            (
                "0 to 9 ms, drawn each episode",
                "none",
                "one fixed delay, and the nominal is unknown",
                HALF * (1 - math.exp(-0.18 * math.pi)),
            ),
            id="range of an unknown delay",
        ),
        pytest.param(
            "delay: 3 ms; command_filter: {cutoff: 10 Hz}",
            "4.0",
            "delay",
            # 1.5 steps are rounded up; the filter lets through 1 - exp(-2 pi 10 Hz 1 ms) in 1 ms.
            ("3 ms", "4 ms (2 steps of 2 ms)", "1 ms more", HALF * (1 - math.exp(-0.02 * math.pi))),
            id="two steps",
        ),
        pytest.param(
            "delay: 2.4 ms; command_filter: {cutoff: 10 Hz}",
            "4.0",
            "delay",
            ("2.4 ms", "2 ms (1 step of 2 ms)", "0.4 ms less", HALF * (1 - math.exp(-0.008 * math.pi))),
            id="one step",
        ),
        pytest.param(
            "friction: {coulomb: 0.1, static: 0.3}",
            "4.0",
            "friction.static",
            ("0.3 N*m", "0.1 N*m", "one number for sticking and sliding", 0.2),
            id="static friction",
        ),
        pytest.param(
            "velocity_limit: 20 rad/s",
            "4.0",
            "velocity_limit",
            ("20 rad/s", "none", "MuJoCo has no speed limit of a joint", None),
            id="speed limit",
        ),
    ],
)
def test_losses(fields: str, version: str, field: str, expected: tuple[str, str, str, float | None]) -> None:
    """What is lost, what stands in its place, why, and the torque that it makes; nothing else is lost."""
    found = losses(fields, version)
    # before 3.5 the delay itself is lost too
    assert set(found) == ({field, "delay"} if version == "3.2" else {field})
    asked, emitted, why, error = found[field]
    assert (asked, emitted) == expected[:2]
    assert expected[2] in why
    assert error == (None if expected[3] is None else pytest.approx(expected[3], rel=1e-12))


def test_a_stribeck_curve_needs_its_static_friction() -> None:
    """From 0.3 N*m at rest to 0.1 N*m in motion, 0.2 N*m are lost, twice said; without a difference nothing is."""
    found = losses("friction: {coulomb: 0.1, static: 0.3, stribeck_velocity: 0.5 rad/s}", "4.0")
    assert {field: (asked, emitted) for field, (asked, emitted, *_) in found.items()} == {
        "friction.static": ("0.3 N*m", "0.1 N*m"),
        "friction.stribeck_velocity": ("0.5 rad/s", "none"),
    }
    assert [error for *_, error in found.values()] == pytest.approx([0.2, 0.2])
    assert losses("friction: {coulomb: 0.1, static: 0.1, stribeck_velocity: 0.5 rad/s}", "4.0") == {}


def test_a_network_is_named_by_its_file() -> None:
    """The loss has the file's name, not its folder's."""
    text = "  hip: {joints: [hip], level: actuator_net, effort_limit: 9, network: {file: nets/a.pt}}\n"
    (loss,) = compile_text(text, LEG, "4.0").emission.approximations
    assert (loss.field, loss.asked) == ("network", "a.pt")


@pytest.mark.parametrize(
    ("fields", "field", "expected"),
    [
        ("command_filter: {cutoff: 30 Hz}", "command_filter", ("30 Hz", "none", HALF)),
        # kp bias = 40 * 0.02
        ("encoder_bias: 0.02 rad", "encoder_bias", ("0.02 rad", "none", 0.8)),
    ],
    ids=["filter", "bias"],
)
def test_a_dcmotor_has_no_filter_and_no_bias(
    fields: str, field: str, expected: tuple[str, str, float]
) -> None:
    """With the torque-speed line kept, what comes before it is lost; a position servo keeps both."""
    asked, emitted, _, error = losses(fields, "4.0", "dc_motor")[field]
    assert (asked, emitted) == expected[:2]
    assert error == pytest.approx(expected[2], rel=1e-9)
    assert losses(fields, "4.0") == {}


@pytest.mark.parametrize(
    ("version", "fields", "said"),
    [
        ("3.6", "", "MuJoCo 3.6 has no dcmotor"),
        ("3.11", "", None),
        ("3.11", "command: velocity", "the dcmotor of MuJoCo 3.11 takes position commands only"),
        ("3.12", "command: velocity", None),
    ],
    ids=["before", "position", "velocity", "all commands"],
)
def test_line_without_a_dcmotor(version: str, fields: str, said: str | None) -> None:
    """Where no dcmotor takes the command, the line becomes a clip at L, and the reason names the version."""
    text = HIP % "dc_motor" + f"    {fields}\n"
    if fields:
        text = text.replace("    kp: 40\n", "")
    found = compile_text(text, LEG, version).emission.approximations
    assert [(a.field, a.asked, a.emitted, a.why) for a in found] == (
        []
        if said is None
        else [("torque_speed_curve", "line from 45 N*m to 30 rad/s", "a clip at 9 N*m", said)]
    )
