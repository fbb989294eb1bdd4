"""Lift: what a robot file, a configuration or a deploy file says of its actuators, as an ActuatorSet."""

from __future__ import annotations

from actspec.lift.config import lift_config
from actspec.lift.files import lift, lift_files
from actspec.lift.lifted import LeftAlone, Lifted, LiftedFiles, LiftedRobot
from actspec.lift.newton import lift_newton
from actspec.lift.robot import lift_robot

__all__ = [
    "LeftAlone",
    "Lifted",
    "LiftedFiles",
    "LiftedRobot",
    "lift",
    "lift_config",
    "lift_files",
    "lift_newton",
    "lift_robot",
]
