"""Drives that the step is too long for, on a joint whose dry friction holds them."""

from __future__ import annotations

import itertools
from pathlib import Path

import mujoco
import pytest

from actspec.audit.engine import audit
from actspec.audit.settings import Settings
from actspec.diagnostics import Severity

ARM = """<mujoco model="arm">
  <option timestep="0.002" gravity="0 0 0" integrator="Euler"/>
  <worldbody><body>
    <joint name="turn" axis="0 0 1" frictionloss="{friction}"/>
    <inertial pos="0 0 0" mass="0.01" diaginertia="0.008 0.008 0.008"/>
  </body></worldbody>
  <actuator><velocity joint="turn" kv="20"{limit}/></actuator>
</mujoco>
"""
LIMIT = ' forcerange="-20 20"'


@pytest.mark.parametrize(
    ("friction", "limit", "severity"),
    [
        pytest.param(15, LIMIT, Severity.INFO, id="three quarters of the limit"),
        pytest.param(14.9, LIMIT, Severity.ERROR, id="less"),
        pytest.param(0, LIMIT, Severity.ERROR, id="none"),
        pytest.param(15, "", Severity.ERROR, id="no limit"),
    ],
)
def test_what_friction_holds_is_a_note(
    friction: float, limit: str, severity: Severity, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """h kd/I = 0.002 * 20 / 0.008 = 5, where 2 diverges: an error of one file, in a folder where nothing holds it."""
    monkeypatch.chdir(tmp_path)
    Path("arms").mkdir()
    Path("arms/arm.xml").write_text(ARM.format(friction=friction, limit=limit))
    for named in ("arms/arm.xml", "arms"):
        (found,) = audit([named], Settings(select=("STB101",))).findings
        there = Severity.INFO if named == "arms" and limit else severity
        assert (found.finding.value, found.severity) == (pytest.approx(5.0), there)


@pytest.mark.parametrize(("friction", "swing"), [(15, 0.01), (0, 4.0)])
def test_what_mujoco_makes_of_it(friction: float, swing: float) -> None:
    """At 1 rad/s the speed is steady; without friction it changes by up to h limit/I = 0.002 * 20 / 0.008 = 5 rad/s."""
    model = mujoco.MjModel.from_xml_string(ARM.format(friction=friction, limit=LIMIT))
    data = mujoco.MjData(model)
    data.ctrl[0] = 1.0
    mujoco.mj_step(model, data, 500)
    speeds = []
    for _ in range(20):
        mujoco.mj_step(model, data)
        speeds.append(data.qvel[0])
    change = max(abs(after - before) for before, after in itertools.pairwise(speeds))
    assert (change < swing) == (friction > 0)
