"""What FRC101 says of MuJoCo's dry friction, beside MuJoCo itself."""

from __future__ import annotations

import re
from pathlib import Path

import mujoco
import pytest

from actspec.audit.engine import audit
from actspec.audit.settings import Settings
from actspec.diagnostics import Severity

FINGER = """<mujoco>
  <option gravity="0 0 0" timestep="0.002"/>
  <worldbody><body>
    <joint name="finger" armature="{inertia}" frictionloss="0.5" damping="{damping}"/>
    <inertial pos="0 0 0" mass="1" diaginertia="1e-9 1e-9 1e-9"/>
  </body></worldbody>
  <actuator><motor joint="finger" forcerange="-0.15 0.15" forcelimited="true"/></actuator>
</mujoco>
"""


@pytest.mark.parametrize(
    ("inertia", "damping", "severity"),
    [
        # 947.4 * 0.002 = 1.9 N*m*s/rad of friction beside 0.05 of damping: 0.15 / 1.945 = 0.077 rad/s
        (0.002, 0.05, Severity.WARNING),
        # 947.4 * 1e-5 = 0.0095 beside 5: the damping is what slows it, 0.15 / 5.009 = 0.030 rad/s
        (1e-5, 5.0, Severity.INFO),
    ],
)
def test_the_speed_is_that_of_mujoco(
    inertia: float, damping: float, severity: Severity, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A drive of 0.15 N*m moves a joint with 0.5 N*m of friction, as fast as is said; what hardly brakes is a note."""
    monkeypatch.chdir(tmp_path)
    text = FINGER.format(inertia=inertia, damping=damping)
    Path("hand.xml").write_text(text)
    (found,) = audit(["hand.xml"], Settings(select=("FRC101",))).findings
    said = re.search(r"creep at ([0-9.]+) rad/s", found.finding.message)
    assert said is not None and found.severity is severity
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.ctrl[0] = 1.0
    mujoco.mj_step(model, data, nstep=5000)
    assert float(said[1]) == pytest.approx(float(data.qvel[0]), rel=0.05)


@pytest.mark.parametrize("own", ['solreffriction="0.2 1"', 'solimpfriction="0.5 0.9 0.01 0.5 2"'])
def test_a_softness_of_the_model_s_own(own: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten times softer it creeps ten times as fast: no speed is told, and what a real drive cannot do is a note."""
    monkeypatch.chdir(tmp_path)
    text = FINGER.format(inertia=0.002, damping=0.05)
    Path("hand.xml").write_text(text.replace('name="finger"', f'name="finger" {own}', 1))
    (found,) = audit(["hand.xml"], Settings(select=("FRC101",))).findings
    assert found.finding.message.endswith(": a real drive cannot move the joint")
    assert found.severity is Severity.INFO


def test_a_part_of_which_its_includer_tells_the_inertia(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """MuJoCo refuses the part alone: of what friction does there nothing is known but what its includer compiles to."""
    monkeypatch.chdir(tmp_path)
    part = FINGER.format(inertia=1e-5, damping=5.0).replace('name="finger"', 'name="finger" class="light"', 1)
    Path("finger.xml").write_text(part)

    def said(*files: str) -> tuple[str, Severity]:
        (found,) = audit(list(files), Settings(select=("FRC101",))).findings
        return found.finding.message.partition(": ")[2], found.severity

    assert said("finger.xml") == ("a real drive cannot move the joint", Severity.INFO)
    Path("hand.xml").write_text(
        '<mujoco><default><default class="light"/></default><include file="finger.xml"/></mujoco>'
    )
    creeps = (
        "a real drive cannot move the joint, and MuJoCo's, whose friction is soft, has it creep at 0.03 rad/s"
    )
    assert said("finger.xml", "hand.xml") == (creeps, Severity.INFO)
