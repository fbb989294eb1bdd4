"""What the joints are told, and how what became of it is judged."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from actspec.ir import JointActuator
from actspec.targets.base import Approximation
from actspec.verify.agreement import Row
from actspec.verify.response import COURSES, SOFT, Plan, Responded, plan
from actspec.verify.response_reference import Dry, Lane
from actspec.verify.response_rows import (
    Expected,
    expected,
    kept_friction,
    reference,
    response_rows,
    response_skips,
)
from actspec.verify.target import Target
from actspec.verify.torque import laws_of
from tests.verify.making import SPEC, Built, build

HIP_LIMIT, HIP_KP = 22.5, 40.0
STEP, SATURATED, CHIRP, COAST = range(4)


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """The rich spec, for MuJoCo and for Isaac Lab of several kinds."""
    return build(tmp_path_factory.mktemp("responses"), SPEC)


@pytest.fixture(scope="module")
def told(built: Built) -> Plan:
    """What its joints are told."""
    actuators = built.compilation.actuators
    return plan(actuators, laws_of(actuators).laws)


def test_a_body_beside_the_armature_has_the_rest_of_the_inertia(built: Built, told: Plan) -> None:
    """J has the armature once: 0.0081 of the hips', 0.018225 of the knees', 0.3 kg of the lift's is not the body's."""
    held = {a.joint: a.inertia_held for a in built.compilation.actuators.joints}
    assert told.inertia.tolist() == [held[name].reference for name in told.names]  # type: ignore[union-attr]
    assert np.allclose(
        told.inertia - told.body, [0.0081, 0.018225, 0.0081, 0.018225, 0.3], rtol=0, atol=1e-12
    )


def test_a_step_is_worth_half_the_limit_and_one_saturates(told: Plan) -> None:
    """0.5 x 22.5 / 40 = 0.28125 rad after two steps, and four times that; the joint rests at 0."""
    hip = told.command[:, :, 0]
    assert hip[:2, :2].tolist() == [[0.0, 0.0], [0.0, 0.0]]
    assert np.allclose(hip[2:, STEP], 0.28125)
    assert np.allclose(hip[2:, SATURATED], 1.125)
    assert (told.q[:, 0] == 0.0).all()
    # 0.5 x 150 N / 300 N*s/m = 0.25 m/s
    assert np.allclose(told.command[2:, STEP, 4], 0.25)


def test_a_clamped_joint_rests_in_the_middle_and_its_encoder_reads_more(told: Plan) -> None:
    """-1.9 to 0 rad: at -0.95, which the encoder with its bias of 0.02 reads as -0.93."""
    assert (told.q[:, 1] == -0.95).all()
    assert np.allclose(told.command[0, :, 1], -0.93)


def test_a_chirp_sweeps_to_twice_the_closed_loop(told: Plan) -> None:
    """0.1 x 20^(t / T) of sqrt(40 / J), integrated by fine rectangles; 0.25 x 22.5 / 40 rad high."""
    rate = math.sqrt(HIP_KP / told.inertia[0])
    steps, fine = len(told.command), 1000
    share = (np.arange(steps * fine) + 0.5) / (steps * fine)
    phase = np.cumsum(0.1 * rate * 20.0**share) * told.step / fine
    expected_phase = np.r_[0.0, phase[fine - 1 :: fine]][:steps]
    assert np.abs(told.command[:, CHIRP, 0] - 0.140625 * np.sin(expected_phase)).max() < 1e-6


def test_a_coast_down_begins_with_a_speed_at_no_error(told: Plan) -> None:
    """0.28125 rad x sqrt(40 / J), at most half the no-load speed of 30; 0.25 m/s of the velocity drive."""
    rate = math.sqrt(HIP_KP / told.inertia[0])
    assert told.qd[:, 0].tolist() == [0.0, 0.0, 0.0, pytest.approx(min(0.28125 * rate, 15.0))]
    assert (told.command[:, COAST, 0] == told.command[0, COAST, 0]).all()
    assert told.qd[COAST, 4] == pytest.approx(0.25)


def without_inertia(actuator: JointActuator) -> JointActuator:
    """As in a spec that lists its joints."""
    return replace(actuator, inertia_held=None)


def with_large_armature(actuator: JointActuator) -> JointActuator:
    """Armature of more than all the inertia."""
    return replace(actuator, armature=replace(actuator.armature, value=50.0))


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        pytest.param(without_inertia, "no model says its inertia", id="no model"),
        pytest.param(with_large_armature, "is not more than its armature, 50", id="armature"),
    ],
)
def test_what_has_no_body_is_not_moved(built: Built, change: Any, reason: str) -> None:
    """The group is told, and the others move."""
    actuators = built.compilation.actuators
    joints = tuple(change(a) if a.group == "hips" else a for a in actuators.joints)
    changed = replace(actuators, joints=joints)
    found = plan(changed, laws_of(changed).laws)
    assert found.names == ["left_knee", "right_knee", "lift"]
    (skip,) = response_skips(built.targets["mujoco"], found)
    assert (skip.group, skip.what) == ("hips", "responses")
    assert reason in skip.reason


def test_a_plan_without_joints_has_arrays_all_the_same(built: Built) -> None:
    """A spec that lists its joints: nothing moves, and nothing fails."""
    actuators = built.compilation.actuators
    none = replace(actuators, joints=tuple(map(without_inertia, actuators.joints)))
    found = plan(none, laws_of(none).laws)
    assert found.names == []
    assert reference(found, [()]) == {}


def of(built: Built, told: Plan, name: str) -> dict[str, Expected]:
    """What is expected of a target, by joint."""
    return dict(zip(told.names, expected(built.targets[name], told), strict=True))


def test_mujoco_s_friction_is_soft(built: Built, told: Plan) -> None:
    """Its own joint is known to creep; a body that actspec moves is not."""
    hip = of(built, told, "mujoco")["left_hip"]
    assert hip.asked.friction == Dry(0.3, 0.05)
    assert hip.left == replace(hip.asked, friction=Dry(0.3, 0.05, soft=True))
    assert hip.losses == (SOFT,)
    custom = of(built, told, "custom")["left_hip"]
    assert custom.left == custom.asked
    assert custom.losses == ()


def test_known_losses_leave_another_law(built: Built, told: Plan) -> None:
    """Isaac Lab's stock classes: no filter, bias and clamp at the knee, no delay at the hip."""
    found = of(built, told, "isaaclab")
    knee, hip = found["left_knee"], found["left_hip"]
    law = knee.left.law
    assert (law.filter_cutoff, law.encoder_bias, law.command_range, law.delay) == (None, 0.0, None, 0.01)
    assert (hip.asked.law.delay, hip.left.law.delay) == (0.01, 0.0)
    assert hip.losses == ("isaaclab.delay",)
    assert knee.sized


def test_friction_in_the_drive_s_gain_is_taken_from_the_body(built: Built, told: Plan) -> None:
    """Isaac Sim 4.5: 1.5 + 0.05 in `damping`, and no dry friction; the body then has neither."""
    hip = of(built, told, "il45")["left_hip"]
    assert hip.left.law.kd == pytest.approx(1.55)
    assert hip.left.friction == Dry(0.0, 0.0)
    coulomb, viscous = kept_friction(expected(built.targets["il45"], told))
    assert (coulomb[0], viscous[0]) == (0.0, 0.0)
    assert kept_friction(expected(built.targets["custom"], told))[1][0] == 0.05


@pytest.mark.parametrize(
    ("field", "emitted", "changes"),
    [
        ("torque_speed_curve", "a clip at 22.5 N*m", {"stall_torque": None, "no_load_speed": None}),
        ("delay", "10 ms (2 steps of 5 ms)", {}),
        ("velocity_limit", "none", {}),
        ("delay.range", "10 ms", {}),
    ],
    ids=["clip", "rounded delay", "speed limit", "range"],
)
def test_a_loss_changes_its_part_of_the_law(
    built: Built, told: Plan, field: str, emitted: str, changes: dict[str, Any]
) -> None:
    """And nothing else; one that changes no response is not counted."""
    loss = Approximation("custom", "left_hip", field, "asked", emitted, "why", 1.0)
    target = replace(built.targets["custom"], losses=(loss,))
    hip = expected(target, told)[0]
    assert hip.left.law == replace(hip.asked.law, **changes)
    assert hip.losses == ((f"custom.{field}",) if changes else ())


def test_a_loss_that_does_not_say_what_is_left_allows_anything(built: Built, told: Plan) -> None:
    """A gain that is another one has no law."""
    loss = Approximation("custom", "left_hip", "kp", "40", "39.9", "rounded", 1.0)
    target = replace(built.targets["custom"], losses=(loss,))
    assert not expected(target, told)[0].sized


def judged(
    built: Built, told: Plan, name: str, *, add: float = 0.0, change: float = 0.0, wrong: bool = False
) -> Iterator[Row]:
    """Rows of an engine that is off by a ramp, and whose half step differs by one."""
    target, actuators = built.targets[name], built.compilation.actuators
    wanted = expected(target, told)
    moved = reference(told, [wanted])
    lanes: list[Lane] = [one.asked if wrong else one.left for one in wanted]
    q = np.stack([moved[i, lane].q for i, lane in enumerate(lanes)], axis=2)
    torque = np.stack([moved[i, lane].torque for i, lane in enumerate(lanes)], axis=2)
    ramp = np.linspace(0.0, 1.0, len(q))[:, None, None]
    answer = Responded("engine 1", False, q + add * ramp, q + (add + change) * ramp, torque, {})
    return response_rows(target, actuators, told, wanted, moved, answer)


def row(rows: Iterator[Row], joint: str, course: int) -> Row:
    """One of them."""
    return next(r for r in rows if r.joint == joint and r.quantity == COURSES[course])


def test_three_times_the_engine_s_own_change_is_allowed(built: Built, told: Plan) -> None:
    """Off by 2.9 mm with a change of 1 mm agrees, by 3.1 it does not, and says where: at the end, after 300 steps."""
    good = row(judged(built, told, "custom", add=2.9e-3, change=1e-3), "lift", STEP)
    bad = row(judged(built, told, "custom", add=3.1e-3, change=1e-3), "lift", STEP)
    assert (good.ok, good.code, good.unit) == (True, None, "m")
    assert (bad.ok, bad.code) == (False, "VFY112")
    assert bad.max_error == pytest.approx(3.1e-3)
    assert bad.tolerance == pytest.approx(3e-3, rel=1e-3)
    assert bad.at is not None
    assert bad.at.step == 300
    assert bad.at.time == pytest.approx(1.5)
    assert "the response is 0.0031 m off the law's" in bad.message


def test_a_known_loss_allows_its_own_size_and_no_more(built: Built, told: Plan) -> None:
    """Without its delay Isaac Lab agrees, marked; with it, it would not be what is written, and does not."""
    good = row(judged(built, told, "isaaclab", change=1e-5), "left_hip", STEP)
    bad = row(judged(built, told, "isaaclab", change=1e-5, wrong=True), "left_knee", STEP)
    assert good.ok
    assert good.approximations == ("isaaclab.delay",)
    assert good.max_error is not None
    assert 1e-3 < good.max_error < good.tolerance < 1.2 * good.max_error
    # As the spec asks for it: that agrees too, without a mark.
    assert bad.ok
    assert bad.approximations == ()


def test_a_fault_beside_a_known_loss_is_one(built: Built, told: Plan) -> None:
    """2 mrad beside what the loss explains is VFY112, and is told without the loss."""
    bad = row(judged(built, told, "isaaclab", add=2e-3, change=1e-5), "left_knee", STEP)
    assert bad.code == "VFY112"
    assert bad.max_error == pytest.approx(2e-3, rel=1e-3)
    assert bad.message.endswith("known approximations aside")


def test_a_step_that_decides_the_response_is_no_tolerance(built: Built, told: Plan) -> None:
    """Half the step changes it by 0.2 rad of about 0.4: VFY113, although 3 x 0.2 would allow the error."""
    bad = row(judged(built, told, "custom", add=0.3, change=0.3), "left_hip", STEP)
    assert bad.code == "VFY113"
    assert bad.max_error == pytest.approx(0.3)


def test_a_simulation_that_diverges_is_told(built: Built, told: Plan) -> None:
    """Not a number is no number."""
    bad = row(judged(built, told, "custom", add=math.nan), "left_hip", STEP)
    assert (bad.ok, bad.code, bad.max_error) == (False, "VFY113", None)


def test_joints_with_the_same_numbers_share_a_row(built: Built, told: Plan) -> None:
    """Two hips; the knees have different gains."""
    rows = [r for r in judged(built, told, "custom") if r.quantity == COURSES[STEP]]
    assert [(r.group, r.joints) for r in rows] == [("hips", 2), ("knees", 1), ("knees", 1), ("lift", 1)]


def test_joints_that_an_engine_could_not_move_are_skipped(built: Built, told: Plan) -> None:
    """They have no row, and a line."""
    target: Target = built.targets["mujoco"]
    nothing = np.zeros((1, 4, 5))
    answer = Responded("engine 1", False, nothing, nothing, nothing, {"lift": "it is stuck"})
    (skip,) = response_skips(target, told, answer)
    assert (skip.group, skip.reason) == ("lift", "lift: it is stuck")


def test_paths_are_here() -> None:
    """The probes are files of the package."""
    from actspec.verify.engines.mujoco import RESPONSES

    assert Path(RESPONSES).is_file()
