"""How what became of an experiment is judged."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from actspec.ir import JointActuator
from actspec.simulate.experiment import COURSES, Experiment, design
from actspec.simulate.reference import DrivenJoint, PassiveFriction
from actspec.targets.base import Approximation
from actspec.verify.agreement import Row, Skip, TargetFiles
from actspec.verify.engines.asking import EngineResponse
from actspec.verify.joint_laws import laws_of
from actspec.verify.response import (
    SOFT,
    ExpectedResponse,
    expected,
    kept_friction,
    reference,
    response_rows,
    response_skips,
)
from tests.verify.making import SPEC, Built, build

HIP_LIMIT, HIP_KP = 22.5, 40.0
STEP, SATURATED, CHIRP, COAST = range(4)


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """The rich spec, for MuJoCo and for Isaac Lab of several kinds."""
    return build(tmp_path_factory.mktemp("responses"), SPEC)


@pytest.fixture(scope="module")
def experiment(built: Built) -> Experiment:
    """Of its joints."""
    actuators = built.compilation.actuators
    return design(actuators, laws_of(actuators).laws)


def without_inertia(actuator: JointActuator) -> JointActuator:
    """As in a spec that lists its joints."""
    return replace(actuator, inertia_held=None)


def with_large_armature(actuator: JointActuator) -> JointActuator:
    """Armature of more than all the inertia."""
    return replace(actuator, armature=replace(actuator.armature, value=50.0))


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        pytest.param(without_inertia, "its inertia is unknown without a model", id="no model"),
        pytest.param(with_large_armature, "is not more than its armature, 50", id="armature"),
    ],
)
def test_what_has_no_body_is_not_moved(built: Built, change: Any, reason: str) -> None:
    """The group is reported, and the others move."""
    actuators = built.compilation.actuators
    joints = tuple(change(a) if a.group == "hips" else a for a in actuators.joints)
    changed = replace(actuators, joints=joints)
    found = design(changed, laws_of(changed).laws)
    assert found.names == ["left_knee", "right_knee", "lift"]
    (skip,) = response_skips(built.targets["mujoco"], found)
    assert (skip.group, skip.what) == ("hips", "responses")
    assert reason in skip.reason


def test_a_plan_without_joints_has_arrays_all_the_same(built: Built) -> None:
    """A spec that lists its joints: nothing moves, and nothing fails."""
    actuators = built.compilation.actuators
    none = replace(actuators, joints=tuple(map(without_inertia, actuators.joints)))
    found = design(none, laws_of(none).laws)
    assert found.names == []
    assert reference(found, [()]) == {}


def of(built: Built, experiment: Experiment, name: str) -> dict[str, ExpectedResponse]:
    """What is expected of a target, by joint."""
    return dict(zip(experiment.names, expected(built.targets[name], experiment), strict=True))


def test_mujoco_s_friction_is_soft(built: Built, experiment: Experiment) -> None:
    """Its own joint is known to creep; a body that actspec moves is not."""
    hip = of(built, experiment, "mujoco")["left_hip"]
    assert hip.asked.friction == PassiveFriction(0.3, 0.05)
    assert hip.left == replace(hip.asked, friction=PassiveFriction(0.3, 0.05, soft=True))
    assert hip.losses == (SOFT,)
    custom = of(built, experiment, "custom")["left_hip"]
    assert custom.left == custom.asked
    assert custom.losses == ()


def test_known_losses_leave_another_law(built: Built, experiment: Experiment) -> None:
    """Isaac Lab's stock classes: no filter, bias and clamp at the knee, no delay at the hip."""
    found = of(built, experiment, "isaaclab")
    knee, hip = found["left_knee"], found["left_hip"]
    law = knee.left.law
    assert (law.filter_cutoff, law.encoder_bias, law.command_range, law.delay) == (None, 0.0, None, 0.01)
    assert (hip.asked.law.delay, hip.left.law.delay) == (0.01, 0.0)
    assert hip.losses == ("isaaclab.delay",)
    assert knee.sized


def test_friction_in_the_drive_s_gain_is_taken_from_the_body(built: Built, experiment: Experiment) -> None:
    """Isaac Sim 4.5: 1.5 + 0.05 in `damping`, and no dry friction; the body then has neither."""
    hip = of(built, experiment, "il45")["left_hip"]
    assert hip.left.law.kd == pytest.approx(1.55)
    assert hip.left.friction == PassiveFriction(0.0, 0.0)
    coulomb, viscous = kept_friction(expected(built.targets["il45"], experiment))
    assert (coulomb[0], viscous[0]) == (0.0, 0.0)
    assert kept_friction(expected(built.targets["custom"], experiment))[1][0] == 0.05


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
    built: Built, experiment: Experiment, field: str, emitted: str, changes: dict[str, Any]
) -> None:
    """And nothing else; one that changes no response is not counted."""
    loss = Approximation("custom", "left_hip", field, "asked", emitted, "why", 1.0)
    target = replace(built.targets["custom"], losses=(loss,))
    hip = expected(target, experiment)[0]
    assert hip.left.law == replace(hip.asked.law, **changes)
    assert hip.losses == ((f"custom.{field}",) if changes else ())


def test_a_loss_that_does_not_say_what_is_left_allows_anything(built: Built, experiment: Experiment) -> None:
    """A gain that is another one has no law."""
    loss = Approximation("custom", "left_hip", "kp", "40", "39.9", "rounded", 1.0)
    target = replace(built.targets["custom"], losses=(loss,))
    assert not expected(target, experiment)[0].sized


def judged(
    built: Built,
    experiment: Experiment,
    name: str,
    *,
    add: float = 0.0,
    change: float = 0.0,
    wrong: bool = False,
    step: float | None = None,
) -> Iterator[Row | Skip]:
    """Rows of an engine that is off by a ramp, and whose half step differs by one; as if of another step."""
    target, actuators = built.targets[name], built.compilation.actuators
    wanted = expected(target, experiment)
    moved = reference(experiment, [wanted])
    lanes: list[DrivenJoint] = [one.asked if wrong else one.left for one in wanted]
    q = np.stack([moved[i, lane].q for i, lane in enumerate(lanes)], axis=2)
    torque = np.stack([moved[i, lane].torque for i, lane in enumerate(lanes)], axis=2)
    ramp = np.linspace(0.0, 1.0, len(q))[:, None, None]
    answer = EngineResponse("engine 1", False, q + add * ramp, q + (add + change) * ramp, torque, {})
    said = experiment if step is None else replace(experiment, step=step)
    return response_rows(target, actuators, said, wanted, moved, answer)


def row(rows: Iterator[Row | Skip], joint: str, course: int) -> Row:
    """One of them."""
    found = (r for r in rows if isinstance(r, Row))
    return next(r for r in found if r.joint == joint and r.quantity == COURSES[course])


@pytest.mark.slow
def test_three_times_the_engine_s_own_change_is_allowed(built: Built, experiment: Experiment) -> None:
    """Off by 2.9 mm with a change of 1 mm agrees, by 3.1 it does not, and says where: at the end, after 158 steps."""
    good = row(judged(built, experiment, "custom", add=2.9e-3, change=1e-3), "lift", STEP)
    bad = row(judged(built, experiment, "custom", add=3.1e-3, change=1e-3), "lift", STEP)
    assert (good.ok, good.code, good.unit) == (True, None, "m")
    assert (bad.ok, bad.code) == (False, "VFY112")
    assert bad.max_error == pytest.approx(3.1e-3)
    assert bad.tolerance == pytest.approx(3e-3, rel=1e-3)
    assert bad.at is not None
    # Three periods of the slowest, 3 x 2 pi / (24.48 x 0.005) = 154, behind two steps at rest and two of delay.
    assert bad.at.step == 158
    assert bad.at.time == pytest.approx(0.79)
    assert "the response is 0.0031 m off the law's" in bad.message


@pytest.mark.slow
def test_a_known_loss_allows_its_own_size_and_no_more(built: Built, experiment: Experiment) -> None:
    """Without its delay Isaac Lab agrees, marked; with it, it would not be what is written, and does not."""
    good = row(judged(built, experiment, "isaaclab", change=1e-5), "left_hip", STEP)
    bad = row(judged(built, experiment, "isaaclab", change=1e-5, wrong=True), "left_knee", STEP)
    assert good.ok
    assert good.approximations == ("isaaclab.delay",)
    assert good.max_error is not None
    assert 1e-3 < good.max_error < good.tolerance < 1.2 * good.max_error
    # As the spec asks for it: that agrees too, without a mark.
    assert bad.ok
    assert bad.approximations == ()


@pytest.mark.slow
def test_a_fault_beside_a_known_loss_is_one(built: Built, experiment: Experiment) -> None:
    """2 mrad beside what the loss explains is VFY112, and is reported without the loss."""
    bad = row(judged(built, experiment, "isaaclab", add=2e-3, change=1e-5), "left_knee", STEP)
    assert bad.code == "VFY112"
    assert bad.max_error == pytest.approx(2e-3, rel=1e-3)
    assert bad.message.endswith("known approximations aside")


@pytest.mark.slow
def test_a_step_that_decides_the_response_is_no_tolerance(built: Built, experiment: Experiment) -> None:
    """Half the step changes it by 0.2 rad of about 0.4: VFY113, although 3 x 0.2 would allow the error."""
    bad = row(judged(built, experiment, "custom", add=0.3, change=0.3), "left_hip", STEP)
    assert bad.code == "VFY113"
    assert bad.max_error == pytest.approx(0.3)


@pytest.mark.slow
def test_a_step_too_coarse_for_the_spec_s_own_drive_is_no_disagreement(
    built: Built, experiment: Experiment
) -> None:
    """The same at a step beyond J/kd or sqrt(J/kp) of the hips: no course in which they are off is judged.

    One line says so. Just below it is the target's fault.
    """
    both = []
    for name in ("left_hip", "right_hip"):
        i = experiment.names.index(name)
        law, inertia = experiment.laws[i], float(experiment.inertia[i])
        both.append(min(inertia / law.kd, math.sqrt(inertia / law.kp)))
    finest = min(both)
    assert finest > experiment.step
    for step, coarse in ((0.99 * finest, False), (1.01 * max(both), True)):
        found = list(judged(built, experiment, "custom", add=0.3, change=0.3, step=step))
        hips = [one for one in found if one.group == "hips"]
        assert {one.code for one in hips if isinstance(one, Row) and not one.ok} == (
            set() if coarse else {"VFY113"}
        )
        skips = [one for one in hips if isinstance(one, Skip)]
        assert [one.what for one in skips] == ["responses"] * coarse
        for one in skips:
            assert one.reason.startswith(
                f"left_hip, right_hip: the step of {step * 1e3:g} ms is too coarse for the drive"
            )
            assert one.help == f"timing.physics_dt of at most {finest * 1e3:.2g} ms, or smaller gains"


@pytest.mark.slow
def test_a_simulation_that_diverges_is_reported(built: Built, experiment: Experiment) -> None:
    """Not a number is no number."""
    bad = row(judged(built, experiment, "custom", add=math.nan), "left_hip", STEP)
    assert (bad.ok, bad.code, bad.max_error) == (False, "VFY113", None)


@pytest.mark.slow
@pytest.mark.parametrize(("share", "course", "time"), [(5.0, COAST, 0.005), (2.8, None, None)])
def test_a_law_whose_own_integration_diverges_is_no_disagreement(
    built: Built, experiment: Experiment, share: float, course: int | None, time: float | None
) -> None:
    """Viscous friction of 5 J over a substep, a 64th of the step, makes 1 - 5 + 25/2 - 125/6 + 625/24 = 13.7 times the
    speed of each, 1e72 of that with which the coast-down begins after one step. Of 2.8 it is 1.02 times, which takes
    longer. Said once, in words, and no other joint is left out.
    """
    i = experiment.names.index("lift")
    target, actuators = built.targets["custom"], built.compilation.actuators
    wanted = list(expected(target, experiment))
    viscous = share * wanted[i].asked.inertia * 64 / experiment.step
    fast = replace(wanted[i].asked, friction=PassiveFriction(0.0, viscous))
    wanted[i] = replace(wanted[i], asked=fast, left=fast)
    moved = reference(experiment, [wanted])
    lanes = [moved[j, one.asked] for j, one in enumerate(wanted)]
    q = np.nan_to_num(np.stack([lane.q for lane in lanes], axis=2), posinf=0.0, neginf=0.0)
    torque = np.stack([lane.torque for lane in lanes], axis=2)
    answer = EngineResponse("engine 1", False, q, q, torque, {})
    found = list(response_rows(target, actuators, experiment, wanted, moved, answer))
    assert all(one.ok for one in found if isinstance(one, Row))
    assert {one.group for one in found if isinstance(one, Row)} == {"hips", "knees"}
    (skip,) = (one for one in found if isinstance(one, Skip))
    assert (skip.group, skip.what) == ("lift", "responses")
    assert skip.reason.startswith("lift: the law's own integration diverges at ") and "nan" not in skip.reason
    if course is not None:
        assert (
            f"diverges at {time} s (lift, {COURSES[course]}): gains or friction are too large" in skip.reason
        )


@pytest.mark.slow
def test_joints_with_the_same_numbers_share_a_row(built: Built, experiment: Experiment) -> None:
    """Two hips; the knees have different gains."""
    every = [r for r in judged(built, experiment, "custom") if isinstance(r, Row)]
    rows = [r for r in every if r.quantity == COURSES[STEP]]
    assert [(r.group, r.joints) for r in rows] == [("hips", 2), ("knees", 1), ("knees", 1), ("lift", 1)]


def test_joints_that_an_engine_could_not_move_are_skipped(built: Built, experiment: Experiment) -> None:
    """They have no row, and a line."""
    target: TargetFiles = built.targets["mujoco"]
    nothing = np.zeros((1, 4, 5))
    answer = EngineResponse("engine 1", False, nothing, nothing, nothing, {"lift": "it is stuck"})
    (skip,) = response_skips(target, experiment, answer)
    assert (skip.group, skip.reason) == ("lift", "lift: it is stuck")


def test_paths_are_here() -> None:
    """The probes are files of the package."""
    from actspec.verify.engines.mujoco import ROLLOUT

    assert Path(ROLLOUT).is_file()
