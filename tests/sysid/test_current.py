"""Current as torque: whose constant it is, and that the gear counts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from actspec import api
from actspec.diagnostics import Collector
from actspec.ir import JointActuator
from actspec.logs import JointLog, Log, Sidecar
from actspec.sysid.recording import driven
from tests.sysid.test_fit import MODEL, SPEC

CURRENT = np.array([0.0, 1.0, -2.0])
MOTOR = "motors:\n  m: {side: motor, gear_ratio: 6, efficiency: 0.9, torque_constant: 0.1 N*m/A}\nactuators:"


def actuator(folder: Path, motor: bool) -> JointActuator:
    """The drive of the bench; with a motor of 0.1 N*m/A behind a gear of 6 and 90 %, two of them."""
    spec = SPEC
    if motor:
        drive = "joints: [hip]\n    motor: m\n    motors_per_joint: 2"
        spec = spec.replace("actuators:", MOTOR).replace("joints: [hip]", drive)
    (folder / "bench.xml").write_text(MODEL.replace("AXIS", "0 1 0"))
    (folder / "spec.yaml").write_text(spec)
    loaded = api.load(folder / "spec.yaml")
    found = api.resolve(loaded, api.load_robot(loaded)).joint("hip")
    assert found is not None
    return found


def torque(
    given: JointActuator, sidecar: Sidecar, logged: np.ndarray | None = None
) -> tuple[np.ndarray | None, str, str]:
    """The joint's torque, and what is reported."""
    joint = JointLog("hip", False, torque=logged, current=CURRENT)
    out = Collector()
    found = driven(Log("a.csv", "", np.arange(3.0), {"hip": joint}, sidecar), joint, given, out)
    assert len(out.items) < 2
    message, help = next(((item.message, item.help or "") for item in out.items), ("", ""))
    return found.torque, message, help


def test_the_motor_s_constant_counts_its_gear(tmp_path: Path) -> None:
    """0.1 N*m/A x 6 x 0.9 x 2 motors is 1.08 N*m/A; the sidecar's own figure wins."""
    given = actuator(tmp_path, motor=True)
    found, message, _ = torque(given, Sidecar())
    assert found == pytest.approx(1.08 * CURRENT)
    assert message == "the torque is the current times 1.08 N*m/A, by the spec's motor"
    sidecar = Sidecar.model_validate({"torque_constant": {"hi.*": 0.7}})
    found, message, _ = torque(given, sidecar)
    assert found == pytest.approx(0.7 * CURRENT)
    assert message == "the torque is the current times 0.7 N*m/A, by the sidecar"


def test_a_torque_that_was_logged_is_taken(tmp_path: Path) -> None:
    """The current beside it is not."""
    logged = np.array([3.0, 4.0, 5.0])
    found, message, _ = torque(actuator(tmp_path, motor=True), Sidecar(), logged)
    assert found is logged and message == ""


def test_without_a_constant_the_current_is_not_used(tmp_path: Path) -> None:
    """It is reported, with the line to write."""
    found, message, help = torque(actuator(tmp_path, motor=False), Sidecar())
    assert found is None
    assert message == "the current is not used: no torque constant is known"
    assert "`torque_constant: {hip: ... N*m/A}`" in help
