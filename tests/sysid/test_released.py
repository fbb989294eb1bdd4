"""A drive that is off: the joint swings free, and what it does then tells kd apart from viscous friction."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from actspec.logs import JointLog, Log, Sidecar
from actspec.sysid.identified import Identification, State
from actspec.sysid.work import FitOptions
from tests.sysid.pendulum import pendulum
from tests.sysid.test_fit import LINK, PERIOD, fitted

pytest.importorskip("scipy")
pytestmark = pytest.mark.slow

ROWS = 3500
OFF = ((800, 1300), (2100, 2700))
"""Rows without a drive, 1 s and 1.2 s, each after the joint was held aside."""
FREE = FitOptions(free=frozenset({"kp", "kd"}))


def logged(*, driven: bool = False) -> Log:
    """Sines about 0 and a rise to 0.7 rad, there released; no torque. kd is 0.9, viscous friction 0.04 N*m*s/rad.

    With `driven` the drive stays on, as if a brake held the joint first and a hand moved it later.
    """
    t = np.arange(ROWS) * PERIOD
    given = sum(a * np.sin(2 * np.pi * f * t) for a, f in ((0.25, 0.9), (0.12, 3.1), (0.05, 7.0)))
    on = np.ones(ROWS)
    for first, last in OFF:
        on[first:last] = 0.0
        up = np.clip((np.arange(ROWS) - first + 250) / 150.0, 0.0, 1.0) * (np.arange(ROWS) < last)
        given += (0.7 - given) * up
    hand = slice(OFF[1][0], OFF[1][1])
    given[hand] += 0.2 * np.sin(2 * np.pi * 1.3 * (t[hand] - t[hand.start])) if driven else 0.0
    q, qd, _ = pendulum(
        given, PERIOD, None if driven else on, inertia=LINK + 0.012, kp=32.0, kd=0.9, coulomb=0.05, viscous=0.04,
        mgl=0.8 * 9.81 * 0.15, delay=33,
    )  # fmt: skip
    random = np.random.default_rng(6)
    position = q + 5e-4 * random.standard_normal(ROWS)
    velocity = qd + 0.05 * random.standard_normal(ROWS)
    joint = JointLog("hip", False, command=given, position=position, velocity=velocity, enabled=on)
    return Log("hip.csv", "0" * 64, t, {"hip": joint}, Sidecar())


def said(found: Identification) -> list[str]:
    return [item.message for item in found.findings if item.code == "SYS034"]


def test_a_released_swing_parts_kd_from_viscous_friction(tmp_path: Path) -> None:
    """Gains free, no torque, gravity: without the swings only the sum of the two is told."""
    found = fitted(tmp_path, logged(), FREE)
    (joint,) = found.joints
    for field, true, share in (
        ("kp", 32.0, 0.002), ("kd", 0.9, 0.003), ("armature", 0.012, 0.003), ("friction.coulomb", 0.05, 0.02),
        ("friction.viscous", 0.04, 0.02), ("delay", 0.0033, 0.01),
    ):  # fmt: skip
        parameter = joint.parameter(field)
        assert parameter.state is State.IDENTIFIED, field
        assert parameter.value == pytest.approx(true, rel=share), field
        assert parameter.low < true < parameter.high, field
    assert said(found) == ["1.88 s of free swing with the drive off are fitted too"]


def test_what_a_brake_or_a_hand_does_is_no_free_swing(tmp_path: Path) -> None:
    """Neither is fitted, and no figure is bent by them."""
    found = fitted(tmp_path, logged(driven=True), FREE)
    assert said(found) == ["2.2 s with the drive off are left out: the joint does not swing free there"]
    (joint,) = found.joints
    assert joint.parameter("kd").state is State.UNIDENTIFIABLE
    assert joint.parameter("kp").value == pytest.approx(32.0, rel=0.01)
    assert joint.combinations[0].value == pytest.approx(0.94, rel=0.01)
