"""Torque agreement: tolerances, approximations, drawn delays; on answers made by hand and in the installed MuJoCo."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from actspec.ir import ActuatorSet
from actspec.simulate.excitation import HeldMotion, held_motions, own_speed
from actspec.simulate.reference import held_torque
from actspec.targets.base import Approximation
from actspec.verify.agreement import Row, TargetFiles, alike
from actspec.verify.engines.asking import EngineAnswer
from actspec.verify.joint_laws import laws_of
from actspec.verify.torque import torque_rows, usual
from tests.verify.making import SPEC, Built, build, replaced


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """The rich spec, compiled."""
    return build(tmp_path_factory.mktemp("rich"))


class Bench:
    """The rich robot's motions with the law's own torques, to be spoiled."""

    def __init__(self, built: Built) -> None:
        self.built = built
        self.actuators: ActuatorSet = built.compilation.actuators
        self.laws = laws_of(self.actuators)
        self.moves = held_motions(list(self.laws.laws.values()), self.actuators.joints, 0.005)

    def answer(self, *, steps: int = 2, single: bool = False) -> dict[str, Any]:
        """Torques of the laws, each joint behind the same delay."""
        return {
            name: np.stack(
                [
                    held_torque(
                        law, *(part[:, :, column] for part in motion.arrays), 0.005, steps if law.delay else 0
                    )
                    for column, law in enumerate(self.laws.laws.values())
                ],
                axis=2,
            )
            for name, motion in ((n, m.single() if single else m) for n, m in self.moves.items())
        }

    def rows(
        self, found: dict[str, Any], target: TargetFiles, *, single: bool = False
    ) -> dict[tuple[str, str], Row]:
        """Rows by joint and quantity."""
        answer = EngineAnswer("engine 1", single, found)
        rows = torque_rows(target, self.actuators, self.laws, self.moves, answer)
        return {(row.joint, row.quantity): row for row in rows}

    def target(self, *lost: Approximation, name: str = "mujoco") -> TargetFiles:
        """A target with these losses alone."""
        return replace(self.built.targets[name], losses=lost)


@pytest.fixture(scope="module")
def bench(built: Built) -> Bench:
    """See `Bench`."""
    return Bench(built)


def loss(field: str, size: float | None, emitted: str = "none") -> Approximation:
    """A loss of the left hip."""
    return Approximation("mujoco", "left_hip", field, "asked", emitted, "why", size)


def test_the_law_agrees_with_itself(bench: Bench) -> None:
    """Both hips share their rows, the two knees have one each because one kp is overridden, the slide has its own."""
    rows = bench.rows(bench.answer(), bench.target())
    assert {(row.group, row.joints) for row in rows.values()} == {("hips", 2), ("knees", 1), ("lift", 1)}
    assert len(rows) == 4 * 3
    assert all(row.ok and row.max_error == 0.0 for row in rows.values())
    assert [len(members) for members in alike(bench.actuators)] == [2, 1, 1, 1]


def test_tolerance_is_of_the_limit(bench: Bench) -> None:
    """22.5 N*m allows 2.25e-8 N*m in double and 2.25e-4 N*m in single precision, and little more for rounding."""
    rows = bench.rows(bench.answer(), bench.target())
    assert rows["left_hip", "torque"].tolerance == pytest.approx(2.25e-8, rel=1e-3)
    single = bench.rows(bench.answer(single=True), bench.target(), single=True)
    # kp 40 N*m/rad and kd 1.5 N*m*s/rad at 60 rad/s: terms of some 240 N*m, four roundings of 2^-24 each
    assert 2.25e-4 < single["left_hip", "torque"].tolerance < 2.25e-4 + 4 * 2.0**-24 * 300
    spoiled = bench.answer()
    spoiled["torque"][0, 7, 0] += 3e-8
    row = bench.rows(spoiled, bench.target())["left_hip", "torque"]
    assert (row.ok, row.code, row.joints) == (False, "VFY100", 1)
    assert row.max_error == pytest.approx(3e-8, rel=1e-3)
    # the other hip has a row of its own
    assert bench.rows(spoiled, bench.target())["right_hip", "torque"].ok


def test_what_is_usual_counts_by_itself(bench: Bench) -> None:
    """An error beyond w0 and one at a slow command inside the joint's range are told apart, over both hips."""
    motion, law = bench.moves["torque"], bench.laws.laws["left_hip"]
    where = usual(law, bench.actuators.joints[0], motion, 0)
    command, _, qd = (part[:, :, 0] for part in motion.arrays)
    low, high = bench.actuators.joints[0].position_range or (-math.inf, math.inf)
    assert where.any() and not where.all()
    assert command[where].min() >= low and command[where].max() <= high
    assert abs(qd[where]).max() <= (own_speed(law) or math.inf) < abs(qd).max()
    spoiled = bench.answer()
    inside, outside = (int(np.flatnonzero(mask[0])[0]) for mask in (where, ~where))
    spoiled["torque"][0, outside, 0] += 40.0
    spoiled["torque"][0, inside, 0] += 0.3
    row = bench.rows(spoiled, bench.target(loss("kp", 45.0)))["left_hip", "torque"]
    assert row.ok and (row.max_error, row.usual_error) == (pytest.approx(40.0), pytest.approx(0.3))


def test_row_says_where(bench: Bench) -> None:
    """The place of the largest error is that sample's error, speed, command and step."""
    spoiled = bench.answer()
    spoiled["torque.ramp"][5, 1, 4] -= 2.0
    row = bench.rows(spoiled, bench.target())["lift", "torque.ramp"]
    motion = bench.moves["torque.ramp"]
    assert row.at is not None
    assert (row.at.step, row.at.error) == (5, None)
    assert row.at.command == motion.command[5, 1, 4] and row.at.velocity == motion.qd[5, 1, 4]
    assert row.message == "the torque differs from the law by 2 N"


def test_approximation_widens_only_where_it_shows(bench: Bench) -> None:
    """A sized loss allows 1.05 times its size where the engine differs, and nothing where it does not."""
    spoiled = bench.answer()
    spoiled["torque"][0, 7, 0] += 4.0
    rows = bench.rows(spoiled, bench.target(loss("torque_speed_curve", 4.0)))
    row = rows["left_hip", "torque"]
    assert row.ok and row.tolerance == pytest.approx(4.2)
    assert row.approximations == ("mujoco.torque_speed_curve",)
    # Up to w0 and inside the joint's range the line takes less: see `usual`.
    assert row.usual_error is not None and row.usual_error < 45.0
    assert rows["left_hip", "torque.step"].tolerance < 1e-6
    assert not bench.rows(spoiled, bench.target(loss("torque_speed_curve", 3.5)))["left_hip", "torque"].ok
    unsized = bench.rows(spoiled, bench.target(loss("torque_speed_curve", None)))["left_hip", "torque"]
    assert unsized.ok and unsized.tolerance == math.inf


def test_loss_of_the_history_excuses_no_held_command(bench: Bench) -> None:
    """A lost filter may change what follows a step, never the torque of a command that is held."""
    target = bench.target(loss("command_filter", 11.0))
    spoiled = bench.answer()
    spoiled["torque"][0, 7, 0] += 1.0
    spoiled["torque.step"][4, 0, 0] += 1.0
    rows = bench.rows(spoiled, target)
    assert not rows["left_hip", "torque"].ok
    assert rows["left_hip", "torque.step"].ok


@pytest.mark.parametrize(
    "lost, ok",
    [
        (loss("delay", 11.0), True),
        (loss("delay", 11.0, "10 ms (2 steps of 5 ms)"), False),
        (loss("delay.range", 11.0), False),
    ],
    ids=["lost", "rounded", "range"],
)
def test_delay_that_is_there_is_held_to_its_steps(bench: Bench, lost: Approximation, ok: bool) -> None:
    """A step less is excused where the delay is lost, not where it is rounded, or nominal in place of a range."""
    rows = bench.rows(bench.answer(steps=1), bench.target(lost))
    assert rows["left_hip", "torque.step"].ok is ok


@pytest.mark.parametrize("steps", [1, 2, 3], ids="{} steps".format)
def test_a_drawn_delay_may_be_any_of_the_range(bench: Bench, steps: int) -> None:
    """Where the target draws from 5 to 15 ms, 1, 2 and 3 steps agree; a fixed delay must be the nominal 2."""
    found = bench.answer(steps=steps)
    drawn = bench.rows(found, bench.target(name="mjlab"))
    assert drawn["left_knee", "torque.step"].ok
    fixed = bench.rows(found, bench.target())
    assert fixed["left_knee", "torque.step"].ok is (steps == 2)
    # the hips have 10 ms and no range
    assert drawn["left_hip", "torque.step"].ok is (steps == 2)


def test_delay_outside_of_the_range(bench: Bench) -> None:
    """4 steps are none of 1 to 3."""
    assert not bench.rows(bench.answer(steps=4), bench.target(name="mjlab"))["left_knee", "torque.ramp"].ok


def test_joint_without_a_drive(bench: Bench) -> None:
    """An engine that has no drive for a joint says NaN, which is no torque."""
    spoiled = bench.answer()
    spoiled["torque"][:, :, 4] = np.nan
    row = bench.rows(spoiled, bench.target())["lift", "torque"]
    assert (row.ok, row.code, row.max_error) == (False, "VFY109", None)


def test_single_precision_gets_what_the_engine_gets(bench: Bench) -> None:
    """The law is asked at the rounded command, position and speed."""
    motion: HeldMotion = bench.moves["torque"].single()
    assert np.array_equal(motion.command, motion.command.astype(np.float32))


@pytest.mark.slow
def test_mujoco_agrees(built: Built) -> None:
    """The installed MuJoCo computes the law to the last digits; what it cannot hold is as far off as is stated."""
    agreement = built.verified("mujoco", engines=True)
    assert agreement.skipped == ()
    rows = {(r.joint, r.quantity): r for r in agreement.rows if r.quantity.startswith("torque")}
    assert len(rows) == 12
    for row in rows.values():
        assert row.engine is not None and row.engine.startswith("mujoco ")
        assert row.max_error is not None and row.max_error < 1e-11


@pytest.mark.slow
def test_mujoco_finds_what_no_field_says(built: Built) -> None:
    """A filter that acts a step early has every number of the spec, and another torque."""
    agreement = built.verified(
        "mujoco", replaced('dyntype="filterexact"', 'dyntype="filterexact" actearly="true"', 0), engines=True
    )
    assert {(row.code, row.quantity, row.joint) for row in agreement.faults if row.engine} == {
        ("VFY100", f"torque.{kind}", f"{side}_knee")
        for kind in ("step", "ramp")
        for side in ("left", "right")
    }


@pytest.mark.slow
def test_line_that_a_version_does_not_have(tmp_path_factory: pytest.TempPathFactory) -> None:
    """MuJoCo 3.3 clips at L instead: at 2 w0 the line forces -22.5 N*m where the clip gives 22.5, 45 N*m apart."""
    spec = SPEC[: SPEC.index("targets:")] + 'targets: {mujoco: {version: "3.3"}}\n'
    old = build(tmp_path_factory.mktemp("old"), spec)
    rows = {(r.joint, r.quantity): r for r in old.verified("mujoco", engines=True).rows}
    row = rows["left_hip", "torque"]
    assert row.ok and row.max_error == pytest.approx(45.0)
    assert row.tolerance == pytest.approx(47.25, rel=1e-6)
    assert row.approximations == ("mujoco.torque_speed_curve",)
    # the delay is lost too: all of the step of 0.5 L = 16.875 N*m at the first step that should not have it yet
    step = rows["left_knee", "torque.step"]
    assert step.ok and step.at is not None
    assert {"mujoco.delay", "mujoco.delay.range"} <= set(step.approximations)
