"""The SO-101's model: the masses, frames and ranges of the URDF that The Robot Studio exports from its drawings."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.robots.published import ROBOTS, Link, check_links, tensor

mujoco = pytest.importorskip("mujoco")

JOINTS = ["shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll", "gripper"]
# Body, mass [kg], centre of mass [m], inertia as xx, yy, zz, xy, xz, yz [kg*m^2].
LINKS: list[Link] = [
    (
        "base",
        0.147,
        (0.0137179, -5.19711e-05, 0.0334843),
        tensor(0.000114686, 0.000136117, 0.000130364, -4.59787e-07, 4.97151e-06, 9.75275e-08),
    ),
    (
        "shoulder",
        0.100006,
        (-0.0307604, -1.66727e-05, -0.0252713),
        tensor(8.3759e-05, 8.10403e-05, 2.39783e-05, 7.55525e-08, -1.16342e-06, 1.54663e-07),
    ),
    (
        "upper_arm",
        0.103,
        (-0.0898471, -0.00838224, 0.0184089),
        tensor(4.08002e-05, 0.000147318, 0.000142487, -1.97819e-05, -4.03016e-08, 8.97326e-09),
    ),
    (
        "lower_arm",
        0.104,
        (-0.0980701, 0.00324376, 0.0182831),
        tensor(2.87438e-05, 0.000159844, 0.00014529, 7.41152e-06, 1.26409e-06, -4.90188e-08),
    ),
    (
        "wrist",
        0.079,
        (-0.000103312, -0.0386143, 0.0281156),
        tensor(3.68263e-05, 2.5391e-05, 2.1e-05, 1.7893e-08, -5.28128e-08, 3.6412e-06),
    ),
    (
        "gripper",
        0.087,
        (0.000213627, 0.000245138, -0.025187),
        tensor(2.75087e-05, 4.33657e-05, 3.45059e-05, -3.35241e-07, -5.7352e-06, -5.17847e-08),
    ),
    (
        "jaw",
        0.012,
        (-0.00157495, -0.0300244, 0.0192755),
        tensor(6.61427e-06, 1.89032e-06, 5.28738e-06, -3.19807e-07, -5.90717e-09, -1.09945e-07),
    ),
]
# Body: its place in its parent [m], and roll, pitch, yaw about the parent's axes [rad].
FRAMES = {
    "shoulder": ((0.0388353, 0, 0.0624), (3.14159, 0, -3.14159)),
    "upper_arm": ((-0.0303992, -0.0182778, -0.0542), (-1.5708, -1.5708, 0)),
    "lower_arm": ((-0.11257, -0.028, 0), (0, 0, 1.5708)),
    "wrist": ((-0.1349, 0.0052, 0), (0, 0, -1.5708)),
    "gripper": ((0, -0.0611, 0.0181), (1.5708, 0.0486795, 3.14159)),
    "jaw": ((0.0202, 0.0188, -0.0234), (1.5708, 0, 0)),
}
RANGES = [
    [-1.91986, 1.91986],
    [-1.74533, 1.74533],
    [-1.69, 1.69],
    [-1.65806, 1.65806],
    [-2.74385, 2.84121],
    [-0.174533, 1.74533],
]


@pytest.fixture(scope="module")
def model() -> Any:
    """The arm alone, as written."""
    return mujoco.MjModel.from_xml_path(str(ROBOTS / "so101" / "so101.xml"))


def test_motors_and_joints(model: Any) -> None:
    """Six ideal torque motors of 19.5 kgf*cm in the order of the servos, nothing passive."""
    assert [model.joint(index).name for index in range(model.njnt)] == JOINTS
    assert [model.actuator(index).name for index in range(model.nu)] == JOINTS
    assert model.actuator_trnid[:, 0].tolist() == list(range(6))
    # 19.5 x 9.80665 N x 0.01 m = 1.9123
    assert model.actuator_ctrlrange.tolist() == [[-1.9123, 1.9123]] * 6
    assert (model.actuator_biastype == mujoco.mjtBias.mjBIAS_NONE).all()
    for values in (model.dof_damping, model.dof_frictionloss, model.dof_armature, model.jnt_stiffness):
        assert not np.any(values)
    np.testing.assert_array_equal(model.jnt_range, RANGES)
    np.testing.assert_array_equal(model.jnt_axis, [[0.0, 0.0, 1.0]] * 6)


def test_links(model: Any) -> None:
    """Each link has its published mass, centre of mass and full inertia, and there is no other."""
    check_links(model, LINKS)


@pytest.mark.parametrize("body", FRAMES)
def test_frames(model: Any, body: str) -> None:
    """Every frame stands where the URDF has it: turned about the parent's x, then y, then z."""
    place, angles = FRAMES[body]
    turned = np.array([1.0, 0.0, 0.0, 0.0])
    for axis, angle in enumerate(angles):
        quat, product = np.zeros(4), np.zeros(4)
        mujoco.mju_axisAngle2Quat(quat, np.eye(3)[axis], angle)
        mujoco.mju_mulQuat(product, quat, turned)
        turned = product
    assert model.body(body).pos == pytest.approx(place, abs=1e-12)
    # A quaternion and its negative are the same turn.
    assert abs(np.dot(model.body(body).quat, turned)) == pytest.approx(1.0, abs=1e-12)


def test_links_never_collide_with_each_other(model: Any) -> None:
    """No pose makes two links of the arm touch."""
    data = mujoco.MjData(model)
    low, high = model.jnt_range.T
    for angles in np.random.default_rng(7).uniform(low, high, size=(50, 6)):
        data.qpos[:] = angles
        mujoco.mj_forward(model, data)
        assert data.ncon == 0
