"""`actspec verify` with the real Isaac Lab, mjlab and Newton: robots agree, and what only a torque shows is found."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec import api
from tests.frameworks.prepare import Frameworks
from tests.verify.making import SPEC, Built, Edit, both, build, replaced

ROOT = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.slow

NEWTON_TARGETS = 'targets:\n  newton: {version: "1.8", joint_paths: {".*": "joints/{joint}"}}\n'


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory, frameworks: Frameworks) -> Built:
    """The rich spec, compiled."""
    return build(tmp_path_factory.mktemp("rich"))


@pytest.fixture(scope="module")
def newton(tmp_path_factory: pytest.TempPathFactory, frameworks: Frameworks) -> Built:
    """The rich spec for Newton."""
    return build(tmp_path_factory.mktemp("newton"), SPEC[: SPEC.index("targets:")] + NEWTON_TARGETS)


def test_a1_agrees_everywhere(frameworks: Frameworks) -> None:
    """Every engine computes the A1's law within 1e-5 of its limit; none is passed over."""
    _, agreement = api.verify(ROOT / "robots" / "a1.yaml")
    assert [row.message for row in agreement.faults] == []
    asked = {row.target: row.engine for row in agreement.rows if row.quantity == "torque"}
    assert set(asked) == {"mujoco", "isaaclab", "mjlab", "newton"}
    assert asked["isaaclab"] == "isaaclab 2.3.2.post1" and asked["newton"] == "newton 1.8.0"
    assert not any(skip.setup for skip in agreement.skipped)
    for row in agreement.rows:
        if row.quantity.startswith("torque"):
            assert row.max_error is not None and row.max_error < 33.5 * 1e-5


@pytest.mark.parametrize("name", ["isaaclab", "custom", "il45", "mjlab"])
def test_what_is_lost_is_as_far_off_as_stated(name: str, built: Built) -> None:
    """Engines that hold a part of the law differ from it by no more than the approximations' sizes."""
    agreement = built.verified(name, engines=True)
    assert [row.message for row in agreement.faults] == []
    rows = [row for row in agreement.rows if row.quantity.startswith("torque")]
    assert len(rows) == 12
    if name == "custom":
        # The class of our own holds the whole law.
        assert all(row.max_error is not None and row.max_error < 1e-4 for row in rows)


@pytest.mark.parametrize(
    "name, edit, shown",
    [
        (
            "custom",
            both(
                # the symmetric form of the torque-speed line, which brakes wrongly; the hips alone have a line
                replaced("self._stall_torque * (-1.0 - speed)", "-self._stall_torque * (1.0 - speed.abs())"),
                # the cutoff taken for rad/s; the knees alone have a filter
                replaced("-2.0 * math.pi * cutoff", "-cutoff"),
            ),
            {("torque", "left_hip"), ("torque.step", "left_knee")},
        ),
        (
            "mjlab",
            both(
                replaced("delay_min_lag=2", "delay_min_lag=3"), replaced("delay_max_lag=2", "delay_max_lag=3")
            ),
            {("torque.step", "left_hip")},
        ),
    ],
    ids=["symmetric line, cutoff in rad/s", "a step late"],
)
def test_fault_in_the_law_is_found(name: str, edit: Edit, shown: set[tuple[str, str]], built: Built) -> None:
    """A mistake in what the simulator computes is found by its torque, in its own group."""
    agreement = built.verified(name, edit, engines=True)
    assert shown <= {(r.quantity, r.joint) for r in agreement.faults if r.code == "VFY100"}


@pytest.mark.parametrize("name", ["isaaclab", "mjlab"])
def test_file_that_the_simulator_refuses(name: str, built: Built) -> None:
    """What the real package says of a file it does not take is told; the other targets are not concerned."""
    agreement = built.verified(name, replaced("stiffness=40.0", "stifness=40.0"), engines=True)
    refused = [row for row in agreement.faults if row.code == "VFY111"]
    assert refused and "stifness" in refused[0].message


NEWTON_FAULTS: dict[str, tuple[Edit, str, str, str]] = {
    # 0.05 N*m*s/rad is 0.000872664626 a degree; 1.5 is 0.0261799388
    "kd as joint damping": (
        replaced("newton:damping = 0.000872664625997", "newton:damping = 0.0261799387799"),
        "VFY101",
        "joint_damping",
        "left_hip",
    ),
    "damping per radian": (
        replaced("newton:damping = 0.000872664625997", "newton:damping = 0.05"),
        "VFY105",
        "joint_damping",
        "right_hip",
    ),
    # 0.3 N*m of 22.5 N*m
    "friction without unit": (
        replaced("newton:friction = 0.3", "newton:friction = 0.0133333333", 0),
        "VFY102",
        "frictionloss",
        "left_hip",
    ),
    "armature at the rotor": (
        replaced("newton:armature = 0.0081", "newton:armature = 0.0001", 0),
        "VFY103",
        "armature",
        "left_hip",
    ),
    "delay off by one": (
        replaced("delaySteps = 2", "delaySteps = 1", 0),
        "VFY100",
        "torque.step",
        "left_hip",
    ),
    "limit lost": (replaced("maxEffort = 33.75", "maxEffort = 1e9", 0), "VFY100", "torque", "left_knee"),
}
"""What is done, by a mistake each in its own number, and the joint and quantity in which it shows."""


def test_newton_agrees(newton: Built) -> None:
    """The overlay's torque and joint numbers are the spec's."""
    agreement = newton.verified("newton", engines=True)
    assert [row.message for row in agreement.faults] == []
    assert {row.quantity for row in agreement.rows} >= {"torque", "armature", "frictionloss", "joint_damping"}


def test_faults_in_an_overlay_are_found(newton: Built) -> None:
    """Mistakes in an overlay, each in a number of its own, are found in the joint's numbers or by the torque."""
    agreement = newton.verified("newton", both(*(edit for edit, *_ in NEWTON_FAULTS.values())), engines=True)
    found = {(row.code, row.quantity, row.joint) for row in agreement.faults}
    assert {name: where for name, (_, *where) in NEWTON_FAULTS.items() if tuple(where) not in found} == {}


def test_kp_is_found_with_and_without_the_engine(newton: Built) -> None:
    """A gain shows in the torque, and is told as the field that it is, at its place."""
    agreement = newton.verified("newton", replaced("kp = 40.0", "kp = 20.0", 0), engines=True)
    assert ("VFY100", "torque") in {(row.code, row.quantity) for row in agreement.faults}
    (row,) = [row for row in agreement.faults if row.quantity == "kp"]
    assert (row.code, row.engine, row.expected, row.got) == ("VFY110", None, 40.0, 20.0)
