"""Spot's model: published legs, a body that makes up the robot's mass, limits, and a stance on its feet."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.robots.published import (
    ROBOTS,
    Link,
    check_bare_motors,
    check_links,
    check_no_self_collision,
    pose,
    spec_of,
)

mujoco = pytest.importorskip("mujoco")

LEGS = ("fl", "fr", "hl", "hr")
JOINTS = [f"{leg}_{joint}" for leg in LEGS for joint in ("hx", "hy", "kn")]
# Mass, centre of mass, roll, pitch, yaw of the principal axes and moments about them, of the left front leg.
PARTS = {
    "hip": (
        1.68,
        (-0.005374345928430557, 0.012841847725212574, 9.875232353806496e-05),
        (-0.716521349312305, 0.02956473059648479, 0.03655230014702582),
        (0.0021147398873455382, 0.0018129577956607131, 0.002265435737304666),
    ),
    "uleg": (
        2.34,
        (0.005142373498529196, -0.0024323679972440004, -0.12100915610790253),
        (-0.26437828203369795, -0.04853174570753804, 0.024046963096353124),
        (0.02755964961185679, 0.027354914287651046, 0.002848145546743553),
    ),
    "lleg": (
        0.35,
        (0.00225794012658298, 4.607596201822162e-05, -0.1800822913646698),
        (-0.007266925694167092, -0.009591807116834161, 0.00035255970529224356),
        (0.003999022654901177, 0.0040503157598010785, 0.0001493402097647426),
    ),
}


def _axes(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """Principal axes as columns, by MuJoCo's quaternions: yaw, then pitch, then roll of the turned frame."""
    turned = np.array([1.0, 0.0, 0.0, 0.0])
    for axis, angle in ((2, yaw), (1, pitch), (0, roll)):
        quat = np.zeros(4)
        mujoco.mju_axisAngle2Quat(quat, np.eye(3)[axis], angle)
        product = np.zeros(4)
        mujoco.mju_mulQuat(product, turned, quat)
        turned = product
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, turned)
    return matrix.reshape(3, 3)


def _links() -> list[Link]:
    """Each link; a leg is the left front one mirrored: y -> -y, and for the hips of the hind legs x -> -x."""
    # 32.86 - 4 x (1.68 + 2.34 + 0.35) = 15.38 kg; a box of 0.85 x 0.24 x 0.18 m:
    # 15.38 / 12 x (0.0576 + 0.0324, 0.7225 + 0.0324, 0.7225 + 0.0576)
    links: list[Link] = [("body", 15.38, (0.0, 0.0, 0.0), np.diag([0.11535, 0.9675301667, 0.9998281667]))]
    for leg in LEGS:
        y = 1.0 if leg[1] == "l" else -1.0
        for part, (mass, centre, angles, moments) in PARTS.items():
            x = -1.0 if leg[0] == "h" and part == "hip" else 1.0
            mirror = np.diag([x, y, 1.0])
            axes = mirror @ _axes(*angles)
            place = mirror @ np.array(centre)
            links.append((f"{leg}_{part}", mass, tuple(place), axes @ np.diag(moments) @ axes.T))
    return links


@pytest.fixture(scope="module")
def model() -> Any:
    """The robot alone, as written."""
    return mujoco.MjModel.from_xml_path(str(ROBOTS / "spot" / "spot.xml"))


def test_motors_and_sensors(model: Any) -> None:
    """Order fl, fr, hl, hr and hx, hy, kn; ideal torque motors, the knee's 1.5 / 0.0132963 N*m; nothing passive."""
    check_bare_motors(model, JOINTS, ["imu_quat", "imu_gyro", "imu_acc"])
    assert model.actuator_ctrlrange.tolist() == [[-45.0, 45.0], [-45.0, 45.0], [-112.8, 112.8]] * 4


@pytest.mark.parametrize(
    ("joint", "low", "high"),
    [("hl_hx", -0.785398, 0.785398), ("fr_hy", -0.898845, 2.295108), ("hr_kn", -2.7929, -0.2471)],
    ids=["hx", "hy", "kn"],
)
def test_ranges(model: Any, joint: str, low: float, high: float) -> None:
    """Joint ranges are published ones, the knee's that of its table."""
    assert model.joint(joint).range == pytest.approx([low, high], abs=1e-9)


def test_total_mass(model: Any) -> None:
    """The robot weighs what is published as its body alone: 32.86 kg."""
    assert model.body_mass.sum() == pytest.approx(32.86, abs=1e-9)


def test_links(model: Any) -> None:
    """Each link has its published mass, centre of mass and full inertia, and there is no other."""
    check_links(model, _links())


@pytest.mark.parametrize("leg", LEGS)
def test_link_places(model: Any, leg: str) -> None:
    """Hip, upper and lower leg stand at their published offsets, and the foot below."""
    x, y = (1.0 if leg[0] == "f" else -1.0), (1.0 if leg[1] == "l" else -1.0)
    assert model.body(f"{leg}_hip").pos == pytest.approx((0.29785 * x, 0.055 * y, 0.0), abs=1e-12)
    assert model.body(f"{leg}_uleg").pos == pytest.approx((0.0, 0.110945 * y, 0.0), abs=1e-12)
    assert model.body(f"{leg}_lleg").pos == pytest.approx((0.025, 0.0, -0.3205), abs=1e-12)
    assert model.site(f"{leg}_foot").pos == pytest.approx((0.0, 0.0, -0.3365), abs=1e-12)


def test_home_keyframe_is_the_spec_default_pose(model: Any) -> None:
    """The model's first keyframe and the spec's default pose say the same."""
    assert model.key(0).name == "home"
    assert model.key(0).qpos[7:] == pytest.approx(pose(spec_of("spot"), JOINTS))


def test_home_stands_on_its_feet() -> None:
    """At `home` the lowest feet touch the floor to within 0.2 mm, and nothing else does."""
    model = mujoco.MjModel.from_xml_path(str(ROBOTS / "spot" / "scene.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    gaps = [data.site(f"{leg}_foot").xpos[2] - 0.036 for leg in LEGS]
    assert abs(min(gaps)) < 2e-4
    touching = {model.geom(index).name for pair in data.contact.geom for index in pair}
    assert touching <= {"floor", "fl_foot_collision", "fr_foot_collision"}


def test_links_never_collide_with_each_other(model: Any) -> None:
    """No pose makes two links of the robot touch."""
    check_no_self_collision(model)
