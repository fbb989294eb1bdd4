"""What contradicts a fit from outside: the torque's scale against gravity, measured gains against stated ones."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from actspec.diagnostics import Diagnostic, Severity
from actspec.logs import Log, Sidecar
from actspec.sysid.doubts import DRIVE_UNITS, Scale, _cause, _marked
from actspec.sysid.identified import Identification
from tests.sysid.test_fit import TRUE, fitted, logged

pytest.importorskip("scipy")
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def pendulum() -> Log:
    """A log of the joint under gravity, 1.18 N*m at most, by an integrator that is not ours."""
    return logged(gravity=True)


def off(log: Log, scale: float, offset: float, **sidecar: Any) -> Log:
    """The log of a torque sensor that is off."""
    joint = log.joints["hip"]
    assert joint.torque is not None
    joints = {"hip": replace(joint, torque=joint.torque * scale + offset)}
    return replace(log, joints=joints, sidecar=Sidecar.model_validate(sidecar))


def diagnostics(found: Identification) -> dict[str, tuple[float, float | None]]:
    return {item.name: (item.value, item.std) for item in found.joints[0].diagnostics}


def warned(found: Identification) -> list[Diagnostic]:
    return [item for item in found.findings if item.severity is Severity.WARNING]


def test_a_sound_torque_has_scale_1(tmp_path: Path, pendulum: Log) -> None:
    """Within its own interval, and without a warning; gains as sent are not doubted."""
    found = fitted(tmp_path, off(pendulum, 1.0, 0.0, gains={"hip": {"kp": TRUE["kp"], "kd": TRUE["kd"]}}))
    scale, std = diagnostics(found)["torque_scale"]
    assert std is not None and std < 0.02
    assert abs(scale - 1.0) < 3 * std
    assert abs(diagnostics(found)["torque_offset"][0]) < 0.01
    assert warned(found) == []


def test_a_torque_sensor_that_is_off(tmp_path: Path, pendulum: Log) -> None:
    """8 % and 0.1 N*m: both are found, and what follows from the first is reported."""
    found = fitted(tmp_path, off(pendulum, 1.08, 0.1, gains={"hip": {"kp": TRUE["kp"], "kd": TRUE["kd"]}}))
    scale, std = diagnostics(found)["torque_scale"]
    assert std is not None and abs(scale - 1.08) < 3 * std
    assert diagnostics(found)["torque_offset"][0] == pytest.approx(0.1, abs=0.02)
    (one,) = [item for item in warned(found) if item.code == "SYS018"]
    assert one.where == "hip" and "kp, kd and friction" in one.message
    assert one.help is not None and "torque constant" in one.help


def test_accuracy_that_is_stated_is_no_contradiction(tmp_path: Path, pendulum: Log) -> None:
    """Masses known to 5 % and torque to 3 % allow a scale of 1.08."""
    given = off(pendulum, 1.08, 0.0, accuracy={"torque": 0.03, "masses": 0.05})
    found = fitted(tmp_path, given)
    scale, std = diagnostics(found)["torque_scale"]
    # The regression's own is below 0.02, and 5 % of 1.08 are 0.054.
    assert scale > 1.05 and std is not None and 0.053 < std < 0.058
    assert not [item for item in warned(found) if item.code == "SYS018"]


def test_without_gravity_there_is_nothing_to_compare(tmp_path: Path) -> None:
    """A vertical axis: the link's inertia is one with the armature."""
    found = fitted(tmp_path, off(logged(gravity=False), 1.08, 0.0), axis="0 0 1")
    assert "torque_scale" not in diagnostics(found)


def test_gains_that_are_not_those_stated(tmp_path: Path, pendulum: Log) -> None:
    """The sidecar states kd in N*m/rpm, 9.549 times too small for N*m*s/rad: both numbers, and the unit."""
    given = off(pendulum, 1.0, 0.0, gains={"hip": {"kp": TRUE["kp"], "kd": TRUE["kd"] / 9.549297}})
    (one,) = warned(fitted(tmp_path, given))
    assert (one.code, one.where) == ("SYS019", "hip")
    assert "0.0942478" in one.message and "9.55 times" in one.message and "kp" not in one.message
    assert one.help == "the drive takes kd per rpm"


@pytest.mark.parametrize(
    ("kp", "kd", "scale", "words"),
    [
        (57.3, 57.3, None, "kp per degree"),
        (1 / 57.3, 1 / 57.3, None, "kp per degree"),
        (40.1, 40.4, None, "6.33^2"),
        (0.8, 0.79, None, "torque constant"),
        (1.06, 1.05, Scale(1.07, 0.01, 0.0), "it is the torque that is wrong"),
        (1.0, 0.7, None, "filtered or late"),
        (1.7, 0.6, None, "units of their own"),
    ],
)  # fmt: skip
def test_causes(kp: float, kd: float, scale: Scale | None, words: str) -> None:
    """By the factors alone: 57.3 is 180 / pi; 40.1 is 6.33 squared, the Go1's gear."""
    assert words in _cause({"kp": kp, "kd": kd}, scale)
    assert _marked(3.0, DRIVE_UNITS) is None
