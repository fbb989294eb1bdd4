"""Torques that were read at another moment than the motion that they make."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from actspec.diagnostics import Severity
from actspec.logs import JointLog, Log, Sidecar
from actspec.sysid.identified import Identification, State
from tests.sysid.pendulum import pendulum
from tests.sysid.test_fit import LINK, fitted
from tests.sysid.test_more import logged, slow

pytest.importorskip("scipy")
pytestmark = pytest.mark.slow
FINE, PARTS = 5e-4, 4
TRUE = {"kp": (32.0, 0.003), "kd": (0.9, 0.004), "armature": (0.012, 0.01), "friction.viscous": (0.04, 0.06)}
"""Figures and how far off they may be. Left as they are, torques of one row later make kd 4 % and viscous friction
90 % wrong."""


def parted(late: int, delay: int = 33) -> Log:
    """A log with rows of 2 ms, whose torque is so many times 0.5 ms older than the row."""
    time = np.arange(round(6.0 / FINE)) * FINE
    given = np.repeat(slow(time)[::PARTS], PARTS)
    read = pendulum(
        given, FINE, inertia=LINK + 0.012, kp=32.0, kd=0.9, coulomb=0.2, viscous=0.04, mgl=0.8 * 9.81 * 0.15,
        delay=delay,
    )  # fmt: skip
    torque = np.concatenate([np.full(late, read[2][0]), read[2]])[: len(time)]
    random = np.random.default_rng(4)
    q, qd, torque = (
        part[::PARTS] + size * random.standard_normal(len(time) // PARTS)
        for part, size in ((read[0], 5e-4), (read[1], 0.05), (torque, 0.03))
    )
    joint = JointLog("hip", False, command=given[::PARTS], position=q, velocity=qd, torque=torque)
    return Log("hip.csv", "0" * 64, time[::PARTS], {"hip": joint}, Sidecar())


def lateness(found: Identification) -> list[tuple[Severity, str]]:
    return [(item.severity, item.message) for item in found.findings if item.code == "SYS012"]


def right(found: Identification) -> None:
    for field, (true, share) in TRUE.items():
        parameter = found.joints[0].parameter(field)
        assert parameter.state is State.IDENTIFIED, field
        assert parameter.value == pytest.approx(true, rel=share), field


@pytest.mark.parametrize("rows", [0, 1, 2, 3, 5])
def test_a_torque_that_is_whole_rows_late(tmp_path: Path, rows: int) -> None:
    found = fitted(tmp_path, parted(rows * PARTS))
    right(found)
    said = f"the torque is {rows} row{'s' * (rows > 1)} ({2 * rows} ms) behind the motion that it makes"
    expected = [(Severity.WARNING, f"{said}: it is fitted as that of so much earlier")] if rows else []
    assert lateness(found) == expected


@pytest.mark.parametrize(
    ("parts", "severity"), [(1, Severity.INFO), (3, Severity.WARNING), (6, Severity.WARNING)]
)
def test_a_torque_that_is_parts_of_a_row_late(tmp_path: Path, parts: int, severity: Severity) -> None:
    found = fitted(tmp_path, parted(parts))
    right(found)
    ((said, message),) = lateness(found)
    assert said is severity
    assert float(message.split()[3]) == pytest.approx(parts / PARTS, abs=0.04)


def test_a_torque_of_its_own_row_s_command(tmp_path: Path) -> None:
    """A simulation without delay, that holds in a row the torque of the command sent then."""
    log = parted(0, delay=0)
    hip = log.joints["hip"]
    before = pendulum(
        np.repeat(hip.command, PARTS), FINE, inertia=LINK + 0.012, kp=32.0, kd=0.9, coulomb=0.2, viscous=0.04,
        mgl=0.8 * 9.81 * 0.15, delay=0,
    )  # fmt: skip
    own = 32.0 * (hip.command - before[0][::PARTS]) - 0.9 * before[1][::PARTS]
    noisy = own + 0.03 * np.random.default_rng(5).standard_normal(len(own))
    found = fitted(tmp_path, replace(log, joints={"hip": replace(hip, torque=noisy)}))
    right(found)
    message = "the torque is taken as that of the row's own command, which fits better"
    assert lateness(found) == [(Severity.INFO, message)]


def test_a_slow_drive_is_no_late_torque(tmp_path: Path) -> None:
    """Behind 40 Hz, its torque read at once: such slow motion tells 47."""
    found = fitted(tmp_path, logged(period=0.002, lag=1 / (2 * np.pi * 40)))
    assert lateness(found) == []
    assert found.joints[0].parameter("bandwidth").value == pytest.approx(40.0, rel=0.2)
