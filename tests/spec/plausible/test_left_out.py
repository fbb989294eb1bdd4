"""A reduction that is left out, by what the robot's file says of the joint."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.diagnostics import ActspecError, Diagnostic
from actspec.resolution import resolve
from actspec.robot.load import joints_of_text
from actspec.spec.document import document_from_text
from actspec.spec.plausible import BY_CODE
from actspec.spec.validate import validate

MJCF = """\
<mujoco model="leg">
  <worldbody>
    <body><joint name="knee" armature="{armature}" range="-1 1"/><geom size="0.1"/></body>
  </worldbody>
  <actuator><motor joint="knee" ctrlrange="-{limit} {limit}"/></actuator>
</mujoco>
"""

MOTOR = "{side: motor, gear_ratio: 9, rotor_inertia: 1e-4 kg*m^2, peak_torque: 2 N*m}"
"""18 N*m and 0.0081 kg*m^2 behind its own gear; 27 N*m and 0.018225 kg*m^2 behind another 1.5."""


def said(folder: Path, armature: float, limit: float, own: str = "", stated: float = 27) -> list[Diagnostic]:
    """What is said of SPEC182, with these keys of the group, beside a file with these figures."""
    path = folder / "leg.xml"
    path.write_text(MJCF.format(armature=armature, limit=limit), encoding="utf-8")
    text = (
        f"actspec: 1\nrobot: {{name: leg, model: {path.name}}}\nmotors: {{m: {MOTOR}}}\n"
        "actuators: {legs: {joints: [knee], motor: m, level: ideal_pd, kp: 20, kd: 0.5, "
        f"effort_limit: {stated} N*m{own}}}}}\n"
    )
    spec = validate(document_from_text(text, str(folder / "s.yaml")))
    try:
        found = [*resolve(spec, joints_of_text(str(path))).diagnostics]
    except ActspecError as err:
        found = [*err.diagnostics]
    return [item for item in found if item.code in BY_CODE and item.code == "SPEC182"]


def test_a_reduction_that_is_left_out(tmp_path: Path) -> None:
    (found,) = said(tmp_path, 0.0182, 27)
    assert found.where == "actuators.legs.motor" and (found.span and found.span.line) == 4
    assert found.message == (
        "knee: the robot's file has an effort limit of 27 N*m, 1.5 times the motor's 18 N*m, and the robot's file an "
        "armature of 0.0182 kg*m^2, 2.25 times the motor's 0.0081 kg*m^2: as behind a reduction of 1.5"
    )
    assert found.help == "did you leave out `reduction: 1.5`?"


@pytest.mark.parametrize("stated", [20, 40])
def test_beside_another_limit(stated: float, tmp_path: Path) -> None:
    """The file's own limit and armature say it, whatever the spec limits the joint to."""
    assert len(said(tmp_path, 0.0182, 27, stated=stated)) == 1


def test_by_the_limit_of_the_spec(tmp_path: Path) -> None:
    (found,) = said(tmp_path, 0.0182, 60)
    assert found.message.startswith(
        "knee: the spec has an effort limit of 27 N*m, 1.5 times the motor's 18 N*m"
    )


@pytest.mark.parametrize(
    ("armature", "limit", "own"),
    [
        # It is there, or two motors are.
        (0.0182, 27, ", reduction: 1.5"),
        (0.0182, 27, ", motors_per_joint: 2"),
        # The armature is the motor's, or says something else; none is stated.
        (0.0081, 27, ""),
        (0.0122, 27, ""),
        (0.0, 27, ""),
        # A limit just above the motor's.
        (0.0098, 19.8, ""),
    ],
)
def test_what_is_no_reduction(armature: float, limit: float, own: str, tmp_path: Path) -> None:
    stated = 19.8 if limit < 20 else 27
    assert said(tmp_path, armature, limit, own, stated) == []
