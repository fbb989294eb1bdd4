"""MuJoCo's own responses: they agree, and mistakes that no field and no torque shows are found."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from actspec.simulate.experiment import COURSES
from actspec.verify.response import SOFT
from tests.verify.making import MODEL, SPEC, Edit, both, replaced
from tests.verify.responding import SLIDE, SLIDE_MODEL, Bench

pytestmark = pytest.mark.slow

ONLY = 'targets: {mujoco: {version: "3.12"}}\n'
RICH = SPEC.split("targets:")[0] + ONLY
FREE = RICH.replace("    kd: 300\n    effort_limit: 150 N\n", "    kd: 3000\n    effort_limit: unknown\n")
"""The lift with h kd / J = 3.3 and no limit: stable where its drive is integrated implicitly."""


@pytest.fixture(scope="module")
def rich(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    """Hips, knees and a slide, with every kind of number."""
    return Bench.of(tmp_path_factory.mktemp("rich"), RICH, "mujoco")


@pytest.fixture(scope="module")
def free(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    """The same with a stiff lift."""
    return Bench.of(tmp_path_factory.mktemp("free"), FREE, "mujoco")


def test_every_course_of_every_joint_agrees(rich: Bench) -> None:
    """16 rows: hips together, knees apart; where it shows, soft friction is the only approximation."""
    rows = rich.rows("mujoco")
    assert len(rows) == 16
    assert [row.message for row in rows if not row.ok] == []
    assert {key for row in rows for key in row.approximations} <= {SOFT}
    # The tolerance means something: a few hundredths of the way.
    assert all(row.tolerance < 0.15 for row in rows)


UNSTATED = RICH.replace(
    "    friction: {coulomb: 0.2, viscous: 0.04}\n",
    "    friction: {coulomb: unknown, viscous: unknown}\n    armature: unknown\n",
)
OWN = 'frictionloss="0.4" damping="0.7" armature="0.05"'
"""What the model says of its right knee alone, and a spec that states none of it."""


def test_what_the_spec_does_not_state_is_not_held_against_the_file(tmp_path: Path) -> None:
    """The target keeps the model's friction and armature, and the law moves a body that has the same."""
    model = replaced('range="-120 5"/>', f'range="-120 5" {OWN}/>')(MODEL)
    bench = Bench.of(tmp_path, UNSTATED, "mujoco", model=model)
    written = Path(bench.built.targets["mujoco"].path("rich.xml")).read_text("utf-8")
    assert all(part in written for part in OWN.split())
    rows = bench.rows("mujoco")
    assert {row.group for row in rows} == {"hips", "knees", "lift"}
    assert [row.message for row in rows if not row.ok] == []


def test_a_slide_with_dry_friction_agrees(tmp_path: Path) -> None:
    """Of 1.08 kg, 0.08 of them its body's, with 5 of 100 N: known to creep, as a hinge is, and no more than that."""
    rows = Bench.of(tmp_path, SLIDE + ONLY, "mujoco", model=SLIDE_MODEL).rows("mujoco")
    assert [row.quantity for row in rows] == list(COURSES)
    assert [row.message for row in rows if not row.ok] == []
    assert {key for row in rows for key in row.approximations} == {SOFT}


def test_a_first_order_engine_is_off_by_twice_its_change(rich: Bench) -> None:
    """So twice the change, as an estimate, would fail half of what is right; 1.9 to 2.1 for a step of the hips."""
    answer = rich.asked("mujoco")
    q = answer.q[:, 0, 0]
    error = np.abs(q - rich.moved[0, rich.wanted["mujoco"][0].left].q[:, 0]).max()
    assert 1.9 < error / np.abs(q - answer.halved[:, 0, 0]).max() < 2.1


def option(text: str) -> Edit:
    """Another `option`, with flags in it."""
    return replaced('integrator="implicitfast"/>', f'integrator="implicitfast"{text}</option>')


UNSEEN: dict[str, tuple[Edit, str]] = {
    "soft friction made softer": (
        replaced('frictionloss="0.3"', 'frictionloss="0.3" solreffriction="0.2 1"', 0),
        "hips",
    ),
    "friction switched off": (option('><flag frictionloss="disable"/>'), "lift"),
    "damping switched off": (option('><flag damper="disable"/>'), "lift"),
}
"""Mistakes that leave every field and every torque as it was: what is done, and a group that shows it."""

SEEN: dict[str, tuple[Edit, str]] = {
    "a finer time step": (replaced('timestep="0.005"', 'timestep="0.004"'), "lift"),
    "half the time step": (replaced('timestep="0.005"', 'timestep="0.0025"'), "hips"),
    "too few samples": (replaced('nsample="2"', 'nsample="1"', 0), "hips"),
    "a step more of delay": (replaced('delay="0.01" nsample="2"', 'delay="0.015" nsample="3"', 0), "hips"),
    "armature twice": (replaced('armature="0.018225"', 'armature="0.03645"', 0), "knees"),
    "armature at the actuator too": (
        replaced('dyntype="filterexact"', 'armature="0.018225" dyntype="filterexact"', 0),
        "knees",
    ),
    "joint damping ten times": (replaced('damping="0.05"', 'damping="0.5"', 0), "hips"),
    "two mistakes": (
        both(replaced('nsample="2"', 'nsample="1"', 0), replaced('damping="5"', 'damping="50"')),
        "lift",
    ),
}
"""Mistakes that fields or torques show too."""


@pytest.mark.parametrize("name", [*UNSEEN, *SEEN])
def test_a_mistake_shows_in_the_response(rich: Bench, name: str) -> None:
    """VFY112 in the group that has it."""
    edit, group = (UNSEEN | SEEN)[name]
    rows = rich.rows("mujoco", edit)
    assert {row.code for row in rows if not row.ok} == {"VFY112"}
    assert group in {row.group for row in rows if not row.ok}


@pytest.mark.parametrize("name", UNSEEN)
def test_nothing_else_shows_these(rich: Bench, name: str) -> None:
    """Of what MuJoCo does only responses are wrong; beside them the compiled model is reported to be another one."""
    found = rich.built.verified("mujoco", UNSEEN[name][0], engines=True)
    assert {row.quantity for row in found.faults if row.engine} <= set(COURSES)
    assert any(row.engine for row in found.faults)
    assert {row.code for row in found.faults if not row.engine} <= {"VFY110"}


def test_an_integrator_that_is_unstable_is_found(free: Bench) -> None:
    """`Euler` integrates the drive's kd explicitly: 5 ms x 3000 / 4.5 kg is more than 2, and the lift diverges."""
    assert [row.message for row in free.rows("mujoco") if not row.ok] == []
    rows = free.rows("mujoco", replaced("implicitfast", "Euler"))
    assert {(row.group, row.code) for row in rows if not row.ok} == {("lift", "VFY113")}
    assert {row.message for row in rows if not row.ok} == {"the simulation diverges at the physics step"}


def test_another_integrator_that_is_as_good_agrees(rich: Bench) -> None:
    """Runge-Kutta and the discrete integrator are no mistakes."""
    assert [row.message for row in rich.rows("mujoco", replaced("implicitfast", "RK4")) if not row.ok] == []


def test_what_the_model_does_not_have_is_said(rich: Bench) -> None:
    """A joint without an actuator has no row, and a reason."""
    edit = replaced('<velocity name="lift" joint="lift"', '<velocity name="lift" joint="gripper"')
    answer = rich.asked("mujoco", edit)
    assert answer.errors == {"lift": "the joint has no actuator"}
    assert np.isnan(answer.q[1:, :, 4]).all()


def test_a_file_that_mujoco_refuses_is_refused(rich: Bench) -> None:
    """With MuJoCo's own words."""
    from actspec.verify.engines.asking import EngineRefused

    with pytest.raises(EngineRefused, match=r"(?i)gear"):
        rich.asked("mujoco", replaced('gear="1"', 'gear="x"'))


def test_the_lag_of_a_plan_is_in_steps(rich: Bench) -> None:
    """10 ms are 2 steps of 5; the lift has none."""
    assert rich.experiment.lags == [2, 2, 2, 2, 0]
    assert replace(rich.experiment, step=0.0025).lags == [4, 4, 4, 4, 0]
