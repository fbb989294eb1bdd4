"""Models of ours against what their vendors publish; what only one robot has is in its own file."""

from __future__ import annotations

import pytest

from tests.robots.published import (
    Published,
    check_bare_motors,
    check_limits,
    check_links,
    check_mass_matrix,
    check_no_self_collision,
    pose,
    poses,
    spec_of,
)
from tests.robots.test_g1_model import MODELS
from tests.robots.test_go1_model import MODEL as GO1
from tests.robots.test_go2_model import MODEL as GO2
from tests.robots.test_h1_model import MODEL as H1

pytestmark = pytest.mark.parametrize("robot", [*MODELS, GO1, GO2, H1], ids=str)


def test_motors_and_sensors(robot: Published) -> None:
    """The joints in the published order; ideal torque motors; nothing passive at the joints."""
    check_bare_motors(robot.ours, robot.joints, ["imu_quat", "imu_gyro", "imu_acc"])
    assert robot.ours.actuator_ctrlrange.tolist() == [[-limit, limit] for limit in robot.limits]


def test_total_mass(robot: Published) -> None:
    """The sum that is worked out where the model is."""
    assert robot.ours.body_mass.sum() == pytest.approx(robot.mass, abs=1e-9)


def test_links(robot: Published) -> None:
    """Each link has its published mass, centre of mass and full inertia, and there is no other."""
    check_links(robot.ours, robot.links)


@pytest.mark.parametrize("seed", [None, 1, 2], ids=["home", "pose1", "pose2"])
def test_mass_matrix_matches_the_urdf(robot: Published, seed: int | None) -> None:
    """The vendor's URDF, compiled by MuJoCo, has the same mass matrix: places and tilts of links and rotors too."""
    check_mass_matrix(robot.ours, robot.theirs, robot.joints, poses(robot.ours, robot.joints, seed))


def test_limits_match_the_urdf(robot: Published) -> None:
    """The vendor's URDF has the same joint axes, ranges and torque limits, but for those of another source."""
    check_limits(robot.ours, robot.theirs, robot.joints, robot.others)


def test_home_keyframe_is_the_spec_default_pose(robot: Published) -> None:
    """The model's first keyframe and the spec's default pose say the same."""
    assert robot.ours.key(0).name == "home"
    assert robot.ours.key(0).qpos[7:] == pytest.approx(pose(spec_of(robot.robot), robot.joints))


def test_links_never_collide_with_each_other(robot: Published) -> None:
    """No pose makes two links of the robot touch."""
    check_no_self_collision(robot.ours)
