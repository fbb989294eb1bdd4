"""A gear, or a stage of it, that is written twice: the second one is told, and no sound figure beside it."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.diagnostics import Diagnostic
from actspec.resolution import resolve
from actspec.robot.load import joints_of_text
from actspec.spec.document import document_from_text
from actspec.spec.plausible import BY_CODE
from actspec.spec.validate import validate

URDF = """<robot name="pruner"><link name="base"/><link name="slide"/><link name="arm"/>
  <joint name="rail" type="prismatic"><parent link="base"/><child link="slide"/>
    <limit lower="-0.3" upper="0.3" effort="774" velocity="0.75"/></joint>
  <joint name="elbow" type="revolute"><parent link="slide"/><child link="arm"/>
    <limit lower="0.1" upper="2.6" effort="140" velocity="3.8"/></joint>
</robot>
"""
"""Of the rail 1.37 N*m x 14 x 0.85 x 0.95 / 0.02 m = 774.4 N, and 523.6 rad/s / 14 x 0.02 m = 0.748 m/s."""
SPEC = """actspec: 1
robot: {name: pruner, model: MODEL}
motors:
  big:
    side: motor
    stall_torque: 30 N*m
    no_load_speed: 3670 rpm
    peak_torque: 4.38 N*m
    continuous_torque: 1.25 N*m
    gear_ratio: 100
    efficiency: 75 %
  rail:
    side: motor
    stall_torque: 4.4 N*m
    no_load_speed: 5000 rpm
    continuous_torque: 207 mN*m
    peak_torque: 1.37 N*m
    gearbox:
      - {ratio: 14, efficiency: 0.85}
      - {radius: 20 mm, efficiency: 0.95}
actuators:
  arm: {joints: [elbow], motor: big, level: ideal_pd, kp: 900, kd: 60, effort_limit: 140 N*m,
    velocity_limit: 2.5 rad/s}
  rail: {joints: [rail], motor: rail, level: ideal_pd, kp: 8000 N/m, kd: 500 N*s/m, effort_limit: peak}
"""


def said(folder: Path, *changes: tuple[str, str], alone: bool = False) -> list[Diagnostic]:
    """What the checks of numbers report of the spec with these changes; alone: without a robot's file."""
    (folder / "pruner.urdf").write_text(URDF, encoding="utf-8")
    text = SPEC.replace("MODEL", "pruner.urdf")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    if alone:
        text = text.replace("pruner.urdf", "none, joints: [elbow, {name: rail, kind: slide}]")
    spec = validate(document_from_text(text, str(folder / "s.yaml")))
    joints = joints_of_text(str(folder / "pruner.urdf"))
    return [item for item in resolve(spec, joints).diagnostics if item.code in BY_CODE]


def test_sound(tmp_path: Path) -> None:
    assert said(tmp_path) == []


@pytest.mark.parametrize("alone", [False, True])
@pytest.mark.parametrize(
    "line", ["reduction: 100", "transmission: [{ratio: 100}]", "transmission: [{ratio: 10}, {ratio: 10}]"]
)
def test_the_gear_again_behind_a_stated_limit(tmp_path: Path, line: str, alone: bool) -> None:
    """4.38 N*m x 100 x 0.75 x 100 = 32850 N*m, of 140: a gear of 1 explains it as well, and 100 is its sheet's."""
    (found,) = said(tmp_path, ("motor: big,", f"motor: big, {line},"), alone=alone)
    assert found.where == f"actuators.arm.{line.partition(':')[0]}"
    assert (found.help or "").startswith("is the gear counted twice? Then remove this")


def test_a_gear_that_stands_once_is_told_itself(tmp_path: Path) -> None:
    """4.38 N*m x 1000 x 0.75 = 3285 N*m and 0.38 rad/s beside limits of 140 N*m and 2.5 rad/s."""
    (found,) = said(tmp_path, ("gear_ratio: 100", "gear_ratio: 1000"))
    assert (found.where, found.help) == ("motors.big.gear_ratio", "did you mean 100?")


def test_a_stage_written_twice(tmp_path: Path) -> None:
    """10841 N and 0.0534 m/s, 14 times off: a radius of 280 mm would make that, too."""
    stage = "      - {ratio: 14, efficiency: 0.85}\n"
    (found,) = said(tmp_path, (stage, f"{stage}      - {{ratio: 14}}\n"))
    assert (found.where, found.help) == ("motors.rail.gearbox[1].ratio", "is this stage written twice?")


def test_two_equal_stages_before_a_wrong_radius(tmp_path: Path) -> None:
    """1.37 N*m x 16 x 0.85 x 0.95 / 0.2 m = 88.5 N, an eighth of the file's: with 20 mm it is 885 N and 0.65 m/s."""
    stages = ("- {ratio: 14, efficiency: 0.85}", "- {ratio: 4, efficiency: 0.85}\n      - {ratio: 4}")
    assert said(tmp_path, stages) == []
    (found,) = said(tmp_path, stages, ("20 mm", "200 mm"))
    assert "radius (" in (found.help or "")
    assert "twice" not in (found.help or "")
