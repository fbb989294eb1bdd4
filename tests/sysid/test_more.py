"""Figures beyond the usual ones: taken in where the logs call for them, and only there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from actspec.logs import JointLog, Log, Sidecar
from actspec.sysid.identified import State
from actspec.sysid.work import FitOptions
from tests.sysid.pendulum import pendulum
from tests.sysid.test_fit import LINK, fitted

pytest.importorskip("scipy")
pytestmark = pytest.mark.slow
PERIOD, LONG = 0.004, 6.0


def slow(t: np.ndarray) -> np.ndarray:
    """A few sines that turn often at low speed, and a faster one."""
    found: np.ndarray = 0.25 * np.sin(2 * np.pi * 0.7 * t) + 0.1 * np.sin(2 * np.pi * 2.3 * t + 1)
    return found + 0.04 * np.sin(2 * np.pi * 6.1 * t + 2) - (0.1 * np.sin(1) + 0.04 * np.sin(2))


def logged(*, delay: int = 33, period: float = PERIOD, **figures: float) -> Log:
    """A log of the joint with torque, noise as in `test_fit`."""
    time = np.arange(round(LONG / period)) * period
    given = slow(time)
    read = pendulum(
        given, period, inertia=LINK + 0.012, kp=32.0, kd=0.9, coulomb=0.2, viscous=0.04, mgl=0.8 * 9.81 * 0.15,
        delay=delay, **figures,
    )  # fmt: skip
    random = np.random.default_rng(4)
    noise = (5e-4, 0.05, 0.02 * float(np.sqrt(np.mean(read[2] ** 2))))
    q, qd, torque = (
        part + size * random.standard_normal(len(time)) for part, size in zip(read, noise, strict=True)
    )
    joint = JointLog("hip", False, command=given, position=q, velocity=qd, torque=torque)
    return Log("hip.csv", "0" * 64, time, {"hip": joint}, Sidecar())


def test_stribeck_friction_is_found_unasked(tmp_path: Path) -> None:
    """Break-away 0.5 over Coulomb 0.2 N*m within 0.15 rad/s: all three, and what was gained is reported."""
    found = fitted(tmp_path, logged(static=0.5, stribeck=0.15))
    (joint,) = found.joints
    (added,) = (item for item in found.findings if item.code == "SYS026")
    assert "friction.static, friction.stribeck_velocity fitted too" in added.message
    for field, true, share in (
        ("friction.static", 0.5, 0.1), ("friction.stribeck_velocity", 0.15, 0.2), ("friction.coulomb", 0.2, 0.03),
    ):  # fmt: skip
        parameter = joint.parameter(field)
        assert parameter.state is State.IDENTIFIED
        assert parameter.value == pytest.approx(true, rel=share), field
    assert joint.misfit < 1.2


def test_a_low_pass_is_found_unasked(tmp_path: Path) -> None:
    """The command behind 12 Hz, 1 / (2 pi 12) = 13.3 ms, and 3.3 ms late; no Stribeck friction is made of it."""
    found = fitted(tmp_path, logged(lag=1 / (2 * np.pi * 12)))
    (joint,) = found.joints
    assert [item.message.split(" fitted")[0] for item in found.findings if item.code == "SYS026"] == [
        "bandwidth"
    ]
    assert joint.parameter("bandwidth").value == pytest.approx(12.0, rel=0.03)
    assert joint.parameter("delay").value == pytest.approx(0.0033, abs=3e-4)


def test_a_low_pass_is_found_where_slow_motion_hardly_shows_it(tmp_path: Path) -> None:
    """80 Hz in 6 s of slow motion: left out the position is off by its noise alone, and kp by 0.7 %."""
    found = fitted(tmp_path, logged(period=0.002, lag=1 / (2 * np.pi * 80)))
    (joint,) = found.joints
    assert "bandwidth fitted too" in next(item.message for item in found.findings if item.code == "SYS026")
    assert joint.parameter("kp").value == pytest.approx(32.0, rel=0.003)
    # It goes into the delay, 3.3 ms, with its 2 ms; which of the two has how much shows less.
    lag, delay = joint.parameter("bandwidth").value, joint.parameter("delay").value
    assert lag is not None and delay is not None
    assert 1 / (2 * np.pi * lag) + delay == pytest.approx(0.0053, abs=2e-4)


def test_a_low_pass_that_is_not_there_takes_nothing(tmp_path: Path) -> None:
    """Of a delay of two rows, with `--free bandwidth`, no low-pass is made, nor a wrong kp."""
    (joint,) = fitted(tmp_path, logged(delay=80), FitOptions(free=frozenset({"bandwidth"}))).joints
    bandwidth = joint.parameter("bandwidth")
    assert (bandwidth.state, bandwidth.why) == (
        State.AT_BOUND,
        "a low-pass makes the fit no better than none does",
    )
    assert joint.parameter("kp").value == pytest.approx(32.0, rel=0.005)
    assert joint.parameter("delay").value == pytest.approx(0.008, abs=5e-5)
    # Torques are read by the row in which the delay is, also where its best value is in the one before: 0.82 mrad.
    assert joint.held_out_rmse == pytest.approx(5e-4, rel=0.1)


def test_nothing_is_added_to_a_joint_that_has_nothing_more(tmp_path: Path) -> None:
    """Coulomb friction alone."""
    found = fitted(tmp_path, logged())
    assert not [item for item in found.findings if item.code == "SYS026"]
    assert {p.field for p in found.joints[0].parameters}.isdisjoint({"friction.static", "bandwidth"})


@pytest.mark.parametrize("more", [1.05, 1.08])
def test_masses_that_are_wrong_are_no_low_pass(tmp_path: Path, more: float) -> None:
    """Positions alone, the link 5 or 8 % heavier than the model's, and the delay 3.3 ms all the same."""
    time = np.arange(1500) * PERIOD
    given = 2.5 * slow(time)
    position, *_ = pendulum(
        given, PERIOD, inertia=more * LINK + 0.012, kp=32.0, kd=0.9, coulomb=0.2, viscous=0.04,
        mgl=more * 0.8 * 9.81 * 0.15, delay=33,
    )  # fmt: skip
    position = position + 5e-4 * np.random.default_rng(4).standard_normal(len(time))
    stated = Sidecar.model_validate({"gains": {"hip": {"kp": 32.0, "kd": 0.9}}})
    joint = JointLog("hip", False, command=given, position=position)
    found = fitted(tmp_path, Log("hip.csv", "0" * 64, time, {"hip": joint}, stated))
    assert "bandwidth" not in " ".join(item.message for item in found.findings if item.code == "SYS026")
    assert found.joints[0].parameter("delay").value == pytest.approx(0.0033, abs=2e-4)
