"""The models of ANYmal C and D: the sums of what ANYbotics' URDFs fix together, limits, and a stance on the feet."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.robots.anymal_parts import LEGS, Part, anymal_c, anymal_d
from tests.robots.published import (
    ROBOTS,
    Link,
    check_bare_motors,
    check_limits,
    check_links,
    check_mass_matrix,
    check_no_self_collision,
    pose,
    poses,
    spec_of,
    tensor,
    vendor_model,
)

mujoco = pytest.importorskip("mujoco")

NAMES = ("anymal_c", "anymal_d")
JOINTS = [f"{leg}_{joint}" for leg in LEGS for joint in ("HAA", "HFE", "KFE")]
URDF = "anymal_d_simple_description/urdf/anymal.urdf"


def _sum(parts: list[Part]) -> Part:
    """Parts as one: moments of inertia are additive about one point, here the frame's origin."""
    total = sum(mass for mass, _, _ in parts)
    centre = sum(mass * place for mass, place, _ in parts) / total
    about_origin = sum(matrix + mass * _steiner(place) for mass, place, matrix in parts)
    return total, centre, about_origin - total * _steiner(centre)


def _steiner(place: np.ndarray) -> np.ndarray:
    x, y, z = place
    return tensor(y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z)


PARTS = {"anymal_c": anymal_c, "anymal_d": anymal_d}
# Hip, thigh and knee of the left front leg from their parents [m]; foot: the ball's centre, its radius.
PLACES = {
    "anymal_c": ((0.2999, 0.104, 0), (0.0599, 0.08381, 0), (0, 0.1003, -0.285), 0.03),
    "anymal_d": ((0.304, 0.109, 0), (0.069, 0.006, 0), (0, 0.1805, -0.285), 0.031455),
}
# Left HAA [rad]; the right one is its mirror image.
HAA = {"anymal_c": (-0.72, 0.49), "anymal_d": (-0.7853985, 0.6108655)}
LIMIT = {"anymal_c": 80.0, "anymal_d": 89.0}
"""Of the spec [N*m]; both URDFs have 80."""


@pytest.fixture(scope="module", params=NAMES)
def name(request: pytest.FixtureRequest) -> str:
    """Each robot in turn."""
    return str(request.param)


@pytest.fixture(scope="module")
def model(name: str) -> Any:
    """The robot alone, as written."""
    return mujoco.MjModel.from_xml_path(str(ROBOTS / name / f"{name}.xml"))


def test_motors_and_sensors(name: str, model: Any) -> None:
    """Order LF, RF, LH, RH and HAA, HFE, KFE; ideal torque motors of the spec's limit; nothing passive."""
    check_bare_motors(model, JOINTS, ["imu_quat", "imu_gyro", "imu_acc"])
    assert model.actuator_ctrlrange.tolist() == [[-LIMIT[name], LIMIT[name]]] * 12


def test_ranges(name: str, model: Any) -> None:
    """HAA opens further inwards, mirrored on the right; HFE and KFE turn one and a half times each way."""
    low, high = HAA[name]
    for joint in JOINTS:
        if joint.endswith("HAA"):
            expected = [low, high] if joint[0] == "L" else [-high, -low]
        else:
            expected = [-3 * np.pi, 3 * np.pi]
        assert model.joint(joint).range == pytest.approx(expected, abs=1e-9), joint


def test_links_are_the_sums_of_their_parts(name: str, model: Any) -> None:
    """Mass, centre and inertia of each body are those of the published parts that are fixed together."""
    links: list[Link] = []
    for body, parts in PARTS[name]().items():
        mass, centre, matrix = _sum(parts)
        links.append((body, mass, tuple(centre), matrix))
    check_links(model, links)


@pytest.mark.parametrize(
    ("name", "total"),
    # C: 26.37317 + 4 x (2.781 + 3.071 + 0.58842). D: 31.85171 + 4 x (0.36586 + 5.1322 + 0.79598)
    [("anymal_c", 52.13485), ("anymal_d", 57.02787)],
    ids=NAMES,
    indirect=["name"],
)
def test_total_mass(model: Any, total: float) -> None:
    """The robots weigh 52.135 and 57.028 kg."""
    assert model.body_mass.sum() == pytest.approx(total, abs=1e-9)


def test_link_places(name: str, model: Any) -> None:
    """Hip, thigh and shank stand at their published offsets, mirrored from the left front leg."""
    for leg in LEGS:
        y = 1.0 if leg[0] == "L" else -1.0
        x = 1.0 if leg[1] == "F" else -1.0
        for part, offset in zip(("HIP", "THIGH", "SHANK"), PLACES[name], strict=False):
            expected = (offset[0] * x, offset[1] * y, offset[2])
            assert model.body(f"{leg}_{part}").pos == pytest.approx(expected, abs=1e-12), (leg, part)


# MuJoCo refuses the C's URDF: its cameras and its hatch have inertias that no body can have.
@pytest.mark.parametrize("name", ["anymal_d"], indirect=True)
@pytest.mark.parametrize("seed", [None, 1, 2], ids=["home", "pose1", "pose2"])
def test_mass_matrix_matches_the_urdf(model: Any, seed: int | None) -> None:
    """The vendor's URDF, compiled by MuJoCo, has the same mass matrix with its payload held at 0."""
    check_mass_matrix(model, vendor_model(URDF, "base"), JOINTS, poses(model, JOINTS, seed))


@pytest.mark.parametrize("name", ["anymal_d"], indirect=True)
def test_limits_match_the_urdf(model: Any) -> None:
    """The vendor's URDF has the same joint ranges, and axes in the base's frame; its limit is not the spec's."""
    vendor = vendor_model(URDF, "base")
    data = mujoco.MjData(vendor)
    mujoco.mj_forward(vendor, data)
    vendor.jnt_axis[:] = data.xaxis
    check_limits(model, vendor, JOINTS, {"": (LIMIT["anymal_d"], 80.0)})


def test_home_keyframe_is_the_spec_default_pose(name: str, model: Any) -> None:
    """The model's first keyframe and the spec's default pose say the same."""
    assert model.key(0).name == "home"
    assert model.key(0).qpos[7:] == pytest.approx(pose(spec_of(name), JOINTS))


def test_home_stands_on_its_feet(name: str) -> None:
    """At `home` the four feet touch the floor to within 0.2 mm."""
    model = mujoco.MjModel.from_xml_path(str(ROBOTS / name / "scene.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    gaps = [data.site(f"{leg}_FOOT").xpos[2] - PLACES[name][3] for leg in LEGS]
    assert np.abs(gaps).max() < 2e-4


def test_links_never_collide_with_each_other(model: Any) -> None:
    """No pose makes two links of the robot touch."""
    check_no_self_collision(model)
