"""Lift: what a robot file, a configuration or a deploy file says of its actuators, as an ActuatorSet."""

from __future__ import annotations

from collections.abc import Sequence

from actspec.lift.config import lift_config
from actspec.lift.lifted import LeftAlone, Lifted
from actspec.lift.newton import lift_newton
from actspec.lift.robot import lift_robot
from actspec.readings.artifact import Artifact
from actspec.readings.versions import Versions
from actspec.robot.view import JointView

__all__ = ["LeftAlone", "Lifted", "lift", "lift_config", "lift_newton", "lift_robot"]


def lift(
    artifact: Artifact,
    joints: Sequence[JointView | str] | None = None,
    *,
    versions: Versions | None = None,
    physics_dt: float | None = None,
) -> Lifted:
    """What one robot's description in one file says of its actuators; arguments as in `lift_config`."""
    if artifact.robot is not None:
        return lift_robot(artifact.robot)
    return lift_config(artifact, joints, versions=versions, physics_dt=physics_dt)
