"""The text for older mjlab, run in those releases on the environment's MuJoCo Warp."""

from __future__ import annotations

import os

import numpy as np
import pytest

from actspec.verify.environments import EngineUnavailableError, prepare_release
from tests.frameworks.asking import RTOL, STEP, Run, expected_line, points
from tests.frameworks.mjlab_asking import ENVS, PROBE, Job, faults
from tests.frameworks.mjlab_specs import (
    EPISODE,
    GRID,
    GROUPS,
    LINE_PD,
    MOTORS,
    ONE,
    PLAIN_PD,
    RAMP,
    RICH,
)
from tests.frameworks.prepare import RELEASES as FETCHED
from tests.frameworks.prepare import Frameworks
from tests.targets.mjlab.emitting import written

pytestmark = pytest.mark.slow

VERSIONS_PROBE = PROBE.with_name("mjlab_versions_probe.py")

RELEASES = {version.rpartition(".")[0]: version for version in FETCHED["mjlab"][1:]}
"""One release on each side of every change that the table of versions names; 40 MB each."""

VELOCITY_PD = """
  leg: {joints: [hip], level: ideal_pd, command: velocity, kd: 2 N*m*s/rad, effort_limit: 9 N*m, delay: 10 ms}
"""


def jobs(version: str) -> dict[str, Job]:
    """Every module for a version."""
    # mjlab 1.0 finds no joint without a name.
    model = RICH.replace("<freejoint/>", '<freejoint name="base"/>')
    one = {
        "fixed": PLAIN_PD % "10 ms",
        "fixed_dc": LINE_PD % "10 ms",
        "fixed_velocity": VELOCITY_PD,
        "episode": PLAIN_PD % EPISODE,
    }
    rich = Job(written(GROUPS, model, version, robot='unmanaged: ["rest"]', motors=MOTORS), model, GRID)
    return {
        "rich": rich,
        **{
            name: Job(written(text, ONE, version, robot="", motors=MOTORS), ONE, sequence=RAMP)
            for name, text in one.items()
        },
    }


@pytest.fixture(scope="module", params=RELEASES)
def version(request: pytest.FixtureRequest) -> str:
    """A version."""
    return str(request.param)


@pytest.fixture(scope="module")
def ran(frameworks: Frameworks, version: str) -> Run[Job]:
    """All modules in a release, in one process."""
    try:
        folder = prepare_release("mjlab", RELEASES[version])
    except EngineUnavailableError as err:
        (pytest.fail if os.environ.get("CI") else pytest.skip)(str(err))
    asked = jobs(version)
    arrays = {f"{name}.{key}": value for name, one in asked.items() for key, value in points(one).items()}
    for name, one in asked.items():
        if one.sequence:
            arrays[f"{name}.sequence"] = np.array(one.sequence)[:, None]
    job = {
        "mjlab": str(folder),
        "probe": str(PROBE),
        "jobs": {name: one.request() for name, one in asked.items()},
    }
    return Run(frameworks.run_probe(VERSIONS_PROBE, job, arrays), faults, asked)


def unstated(run: Run[Job], name: str) -> list[str]:
    """Faults that are not among the approximations."""
    lost = {(a.joint, a.field) for a in run.jobs[name].written.emission.approximations}
    viscous = tuple(f"{joint}: friction_viscous" for joint, field in lost if field == "friction.viscous")
    return [fault for fault in run.faults(name) if not fault.startswith(viscous or ("-",))]


def test_torque_and_passive_numbers(ran: Run[Job], version: str) -> None:
    """The torque is the law's on the whole grid; before 1.3 viscous friction stays the model's, and that is said."""
    assert unstated(ran, "rich") == []
    lost = {a.field for a in ran.jobs["rich"].written.emission.approximations}
    assert lost == ({"friction.viscous"} if version in ("1.0", "1.2") else set())


@pytest.mark.parametrize("name", ["fixed", "fixed_dc", "fixed_velocity"])
def test_fixed_delay(ran: Run[Job], name: str) -> None:
    """10 ms are two steps of 5 ms, in a second episode too; a wrapper holds them before 1.3, the cfg since."""
    assert STEP == 0.005
    assert "error" not in ran.said(name), ran.said(name)
    lagged = ran.arrays(name)["lagged"][..., 0]
    expected = expected_line(ran.jobs[name], "hip", 2)
    np.testing.assert_allclose(lagged, np.broadcast_to(expected[:, None], lagged.shape), rtol=RTOL)


def test_delay_of_an_episode(ran: Run[Job]) -> None:
    """Each environment holds one lag of 0, 1 or 2 steps through an episode, and all three occur."""
    lagged = ran.arrays("episode")["lagged"][..., 0]
    table = [expected_line(ran.jobs["episode"], "hip", steps) for steps in range(3)]
    for episode in lagged:
        lags = [
            [k for k in range(3) if np.allclose(episode[:, env], table[k], rtol=RTOL)] for env in range(ENVS)
        ]
        assert {tuple(lag) for lag in lags} == {(0,), (1,), (2,)}
