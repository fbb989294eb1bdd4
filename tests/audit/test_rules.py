"""Rules that run inside `compile`, at figures calculated by hand, just above and just below."""

from __future__ import annotations

from dataclasses import replace

import pytest

from actspec.audit.rules import check_actuators
from actspec.diagnostics import Severity
from actspec.ir import ActuatorSet, InertiaRange
from actspec.laws.stability import LIMIT, StepDrive
from tests.fitting import fit, spec_of

HIP = "name: leg, model: robot.xml"
MODEL = """<mujoco><worldbody><body><joint name="hip" axis="0 1 0" damping="%s"/><geom size="0.1" mass="1"/></body>
</worldbody></mujoco>"""


EULER = "MuJoCo with the Euler integrator"


def codes(actuators: ActuatorSet) -> list[str]:
    """What the rules say, by code, of a set that is compiled to nothing."""
    return [item.code for item in check_actuators(actuators, {})]


def one(fields: str, damping: str = "0", motors: str = "{}") -> ActuatorSet:
    """A hip with the file's joint damping."""
    text = spec_of(f"legs: {{joints: [hip], level: ideal_pd, {fields}}}", robot=HIP, motors=motors)
    return fit(text, MODEL % damping)


# --- DMP101 --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fields", "damping", "warned"),
    [
        pytest.param("kp: 25, kd: 0.5", "0.06", True, id="12 %"),
        pytest.param("kp: 25, kd: 0.5", "0.05", False, id="10 %"),
        pytest.param("kp: 25, kd: 0.5", "0.04", False, id="8 %"),
        pytest.param("kp: 25, kd: 0.5, friction: {viscous: 0.06}", "0.06", False, id="stated"),
        pytest.param("kp: 25, kd: 0.5, friction: {viscous: unknown}", "0.06", False, id="said to be unknown"),
        pytest.param("kp: 25, kd: 0", "0.06", False, id="no kd to count twice"),
        pytest.param("kp: 25, kd: unknown", "0.06", False, id="kd unknown"),
        pytest.param("command: effort", "0.06", False, id="no drive"),
        pytest.param("command: velocity, kd: 0.5", "0.06", True, id="velocity"),
        pytest.param(
            "kp: 25, kd: {derive: damping_ratio, ratio: 0.1, inertia: 0.25}",
            "0.06",
            True,
            id="derived kd, 0.5",
        ),
    ],
)
def test_damping_counted_twice(fields: str, damping: str, warned: bool) -> None:
    """The file's joint damping above 10 % of a stated kd is reported, unless the spec speaks of it."""
    assert ("DMP101" in codes(one(fields, damping))) is warned


def test_damping_names_both_and_their_sum() -> None:
    """One warning a group, with kd, the file's part, and the sum: 0.5 + 0.75."""
    (found,) = check_actuators(one("kp: 25, kd: 0.5", "0.75"), {})
    assert (found.code, found.severity, found.where) == ("DMP101", Severity.WARNING, "actuators.legs")
    assert found.message == (
        "hip: damping may be counted twice: the drive has kd 0.5 N*m*s/rad, and the robot's file adds 0.75 N*m*s/rad "
        "of joint damping that the spec does not mention; together 1.25 N*m*s/rad"
    )
    assert found.help is not None and "`0.75 N*m*s/rad`" in found.help


REST = "rest: {joints: [calf, slide], level: ideal_pd, kp: 1, kd: 1}"


# --- STB102 --------------------------------------------------------------------------------------


def of_inertia(kp: float, kd: float, inertia: float, step: str = "5 ms") -> ActuatorSet:
    """A hip whose least free inertia is known, its largest and the held one far from it."""
    text = spec_of(
        f"legs: {{joints: [hip], level: ideal_pd, kp: {kp}, kd: {kd}}}, {REST}",
        more=f"timing: {{physics_dt: {step}}}",
    )
    found = fit(text)
    hip = replace(
        found.joints[0],
        inertia_free=InertiaRange(2 * inertia, inertia, 50 * inertia),
        inertia_held=InertiaRange(9.0, 9.0, 9.0),
    )
    return replace(found, joints=(hip, *found.joints[1:]))


@pytest.mark.parametrize(
    ("kp", "kd", "figure"),
    [
        pytest.param(0, 4, 2.0, id="kd alone: 0.005 x 4 / 0.01"),
        pytest.param(400, 0, 0.5, id="kp alone: 2.5e-5 x 400 / 0.02"),
        pytest.param(400, 4, 2.5, id="their sum"),
    ],
)
def test_margin(kp: float, kd: float, figure: float) -> None:
    """h kd / I + h^2 kp / (2 I), at the least free inertia 0.01 kg*m^2 and 5 ms."""
    assert StepDrive(0.005, kp, kd, 0.0).figure(0.01) == pytest.approx(figure)


def diverges(kp: float, kd: float, inertia: float, step: float) -> bool:
    """Whether semi-implicit Euler of a joint under an explicit PD grows without bound, by stepping it."""
    position, speed = 0.0, 1.0
    for _ in range(20_000):
        speed -= step * (kp * position + kd * speed) / inertia
        position += step * speed
        if max(abs(position), abs(speed)) > 1e6:
            return True
    return False


@pytest.mark.parametrize("share", [0.0, 0.25, 0.5, 0.75, 1.0])
@pytest.mark.parametrize("side", [0.995, 1.005])
def test_the_limit_is_where_the_simulation_diverges(share: float, side: float) -> None:
    """b + a/2 = 2 with a = h^2 kp/I, b = h kd/I: just below it the iteration stays, just above it leaves."""
    inertia, step = 0.03, 0.004
    # The limit split between kp and kd; with kd = 0 the joint is undamped, and stays bounded too.
    kp = side * LIMIT * 2.0 * share * inertia / step**2
    kd = side * LIMIT * (1.0 - share) * inertia / step
    assert diverges(kp, kd, inertia, step) is (side > 1.0)


@pytest.mark.parametrize(
    ("kd", "said"),
    [
        pytest.param(1.9, [], id="0.95"),
        pytest.param(2.1, [("info", "changes its sign with every step")], id="1.05"),
        pytest.param(3.7, [("info", "changes its sign with every step")], id="1.85"),
        pytest.param(3.9, [("warning", "changes its sign with every step")], id="1.95"),
        pytest.param(4.1, [("warning", "diverges")], id="2.05"),
    ],
)
def test_stability_levels(kd: float, said: list[tuple[str, str]]) -> None:
    """A note from 1, a warning from 1.9, as of the audit; unstable from 2."""
    found = [d for d in check_actuators(of_inertia(0, kd, 0.01), {EULER: {"hip"}}) if d.code == "STB102"]
    told = [(d.severity.value, d.message.partition(" the velocity ")[2].partition(" (")[0]) for d in found]
    assert told == said


@pytest.mark.parametrize(
    ("explicit", "concerned"),
    [
        pytest.param({}, None, id="nothing explicit"),
        pytest.param({EULER: {"hip"}, "mjlab": set()}, EULER, id="Euler"),
        pytest.param({"isaaclab": {"hip", "calf"}, "mjlab": {"hip"}}, "isaaclab, mjlab", id="two"),
        pytest.param({"isaaclab": {"hip"}, "mjlab": {"calf"}}, "isaaclab", id="another joint of mjlab"),
        pytest.param({"isaaclab": {"calf"}}, None, id="another joint"),
    ],
)
def test_each_explicit_drive_is_named(explicit: dict[str, set[str]], concerned: str | None) -> None:
    """An implicit drive has no such limit; what drives the joint explicitly is named, and nothing else."""
    found = [d for d in check_actuators(of_inertia(0, 5, 0.01), explicit) if d.code == "STB102"]
    assert [d.message.partition("; concerns ")[2] for d in found] == ([concerned] if concerned else [])


def test_the_worst_joint_of_a_group_speaks_for_it() -> None:
    """One warning a group, at its worst joint, with every figure."""
    text = spec_of(
        'legs: {joints: ["h.*", calf], level: ideal_pd, kp: 0, kd: 5}, rest: {joints: [slide], level: ideal_pd, '
        "kp: 1, kd: 1}",
        more="timing: {physics_dt: 5 ms}",
    )
    found = fit(text)
    low, high = InertiaRange(1.0, 0.02, 1.0), InertiaRange(1.0, 0.01, 1.0)
    joints = (
        replace(found.joints[0], inertia_free=low),
        replace(found.joints[1], inertia_free=high),
        found.joints[2],
    )
    (said,) = check_actuators(replace(found, joints=joints), {EULER: {"hip", "calf"}})
    assert said.message == (
        "calf: the drive (ideal_pd) takes kd 5 N*m*s/rad explicitly: with a step of 5 ms the velocity "
        "diverges (h kd/I = 2.5 in some poses, 0.025 in others, limit 2, "
        "with I = 0.01 kg*m^2, no armature stated); concerns MuJoCo with the Euler integrator"
    )


def test_margin_needs_inertia_and_kd() -> None:
    """What is not known is not judged."""
    text = spec_of(f"legs: {{joints: [hip], level: ideal_pd, kp: 1, kd: 1e6}}, {REST}")
    assert not check_actuators(fit(text), {EULER: {"hip"}})
