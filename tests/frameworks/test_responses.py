"""Time responses of the real frameworks: they agree with the law, and mistakes in their files do not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from actspec.verify.response import SOFT
from tests.frameworks.prepare import Frameworks
from tests.verify.making import SPEC, Edit, both, replaced
from tests.verify.responding import SLIDE, SLIDE_MODEL, Bench

NEWTONS = {"newton": "1.8", "newton4": "1.4"}
pytestmark = pytest.mark.slow

TARGETS = ("custom", "isaaclab", "il45", "mjlab", *NEWTONS)


@pytest.fixture(scope="module")
def bench(frameworks: Frameworks, tmp_path_factory: pytest.TempPathFactory) -> Bench:
    """The rich spec for all of them."""
    paths = '{".*": "joints/{joint}"}'
    lines = [
        f'  {name}: {{target: newton, version: "{version}", joint_paths: {paths}}}\n'
        for name, version in NEWTONS.items()
    ]
    return Bench.of(tmp_path_factory.mktemp("responses"), SPEC + "".join(lines), *TARGETS)


@pytest.mark.parametrize("name", TARGETS)
def test_every_course_of_every_joint_agrees(bench: Bench, name: str) -> None:
    """16 rows; known approximations are marked where they show, and what they do not explain agrees beside them."""
    rows = bench.rows(name)
    assert len(rows) == 16
    assert [(row.joint, row.quantity, row.message) for row in rows if not row.ok] == []
    marked = {key for row in rows for key in row.approximations}
    losses = {loss.key for loss in bench.built.targets[name].losses}
    assert marked <= {*losses, SOFT}
    # Isaac Lab's `class: custom` filters, delays, clamps and reads a bias as the law does: it needs none.
    assert bool(marked) == (name != "custom")


def test_a_slide_with_dry_friction_agrees_in_mjlab(frameworks: Frameworks, tmp_path: Path) -> None:
    """The body of its own is fixed to the world, which would make the friction of a slide softer than a robot's."""
    # A third of the steps that 1 ms asks for.
    spec = replaced("physics_dt: 1 ms, decimation: 8", "physics_dt: 4 ms, decimation: 2")(SLIDE)
    bench = Bench.of(tmp_path, spec + "targets: {mjlab: {}}\n", "mjlab", model=SLIDE_MODEL)
    rows = bench.rows("mjlab")
    assert [row.message for row in rows if not row.ok] == []
    assert SOFT in {key for row in rows for key in row.approximations}


LIGHT_MODEL = (
    '<mujoco model="rich"><compiler angle="radian"/><option timestep="0.001" integrator="implicitfast"/><worldbody>'
    + "".join(
        f'<body pos="0 0 {i}"><joint name="finger{i}"/>'
        '<inertial pos="0 0 0" mass="0.01" diaginertia="2e-6 2e-6 2e-6"/></body>'
        for i in range(10)
    )
    + '<body><joint name="rail" type="slide"/><geom type="sphere" size="0.1" mass="2"/></body></worldbody></mujoco>'
)
LIGHT = """actspec: 1
robot: {name: hand, model: rich.xml}
timing: {physics_dt: 1 ms, decimation: 8}
actuators:
  fingers: {joints: ["finger.*"], level: ideal_pd, command: effort, effort_limit: 2 mN*m, armature: 2e-6 kg*m^2}
  rail: {joints: [rail], level: ideal_pd, command: effort, effort_limit: 600 N, armature: 0 kg}
targets: {mjlab: {}}
"""


def test_light_joints_that_a_torque_drives_agree_in_mjlab(frameworks: Frameworks, tmp_path: Path) -> None:
    """The last of ten fingers of 4e-6 kg*m^2 is as light as the first, while a slide of 2 kg travels for metres.

    Half of the limit, 1 mN*m, makes 250 rad/s^2 of it.
    """
    bench = Bench.of(tmp_path, LIGHT, "mjlab", model=LIGHT_MODEL)
    assert [row.message for row in bench.rows("mjlab") if not row.ok] == []
    q = bench.asked("mjlab").q
    # Long after the step of the first course: from one tenth of a second to the next.
    gain = (q[-1] - 2.0 * q[-101] + q[-201])[0, :10] / 0.1**2
    assert gain == pytest.approx(np.full(10, 250.0), rel=1e-4)
    assert abs(q[-1, 0, 10]) > 3.0


FAULTS: dict[str, tuple[str, tuple[Edit, ...], set[str]]] = {
    "custom three steps more of delay, armature twice": (
        "custom",
        (
            replaced("min_delay=2,", "min_delay=5,"),
            replaced("max_delay=2,", "max_delay=5,"),
            replaced("armature=0.018225", "armature=0.03645"),
        ),
        {"hips", "knees"},
    ),
    "custom kd of half, filter for another step": (
        "custom",
        (replaced("damping=1.5,", "damping=0.75,"), replaced("physics_dt=0.005", "physics_dt=0.02")),
        {"hips", "knees"},
    ),
    "isaaclab armature left out": ("isaaclab", (replaced("armature=0.018225", "armature=0.0"),), {"knees"}),
    "mjlab three steps more of delay, armature ten times": (
        "mjlab",
        (
            replaced("delay_min_lag=2,", "delay_min_lag=5,"),
            replaced("delay_max_lag=2,", "delay_max_lag=5,"),
            replaced("armature=0.3,", "armature=3.0,"),
        ),
        {"hips", "lift"},
    ),
    "newton four steps more of delay, armature ten times": (
        "newton",
        (
            replaced("newton:delaySteps = 2", "newton:delaySteps = 6", 0),
            replaced("newton:armature = 0.3 ", "newton:armature = 3.0 "),
        ),
        {"hips", "knees", "lift"},
    ),
}
"""What is done to whose file, and the groups that show it: a mistake in each, as joints do not touch each other."""


@pytest.mark.parametrize("fault", FAULTS)
def test_a_mistake_shows_in_the_response(bench: Bench, fault: str) -> None:
    """In its group, and in no other."""
    name, edits, groups = FAULTS[fault]
    wrong = [row for row in bench.rows(name, both(*edits)) if not row.ok]
    assert {row.group for row in wrong} == groups
    assert {row.code for row in wrong} <= {"VFY112", "VFY113"}
