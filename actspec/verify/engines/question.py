"""What an engine is asked, and what it answers."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from actspec.ir import ActuatorSet
from actspec.robot.view import RobotView
from actspec.targets.base import TargetOptions
from actspec.verify.motion import Motion

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


class EngineRefused(Exception):
    """The engine does not take the file; the message is its own, on one line."""


class EngineMissing(Exception):
    """There is no engine for a target here.

    Attributes:
        reason: Why.
        help: What would change that; None: nothing would.
        setup: Whether `actspec verify --setup` would.
    """

    def __init__(self, reason: str, help: str | None = None, *, setup: bool = False) -> None:
        super().__init__(reason)
        self.reason, self.help, self.setup = reason, help, setup


SETUP = "actspec verify --setup SPEC"


def not_prepared(name: str) -> EngineMissing:
    """An engine that `--setup` brings."""
    return EngineMissing(f"{name} is not prepared", SETUP, setup=True)


@dataclass(frozen=True, slots=True)
class Question:
    """A target's files, and what they are to be held to.

    Attributes:
        options: Which target, at which version.
        folder: Where its files lie.
        files: Their paths below it, the main one first.
        actuators: What the spec asks for.
        robot: Its robot.
        refusal: Why the installed MuJoCo does not take the main file; None: it does, or was not asked.
    """

    options: TargetOptions
    folder: str
    files: tuple[str, ...]
    actuators: ActuatorSet
    robot: RobotView
    refusal: str | None = None

    @property
    def main(self) -> str:
        """Path of the main file."""
        return os.path.join(self.folder, self.files[0])

    @property
    def step(self) -> float:
        """Physics step [s]."""
        return self.actuators.physics_dt.require()

    @property
    def joints(self) -> tuple[str, ...]:
        """Managed joints in the robot's order: the columns of every motion."""
        return tuple(actuator.joint for actuator in self.actuators.joints)


@dataclass(frozen=True, slots=True)
class EngineAnswer:
    """What an engine made of it.

    Attributes:
        engine: Its name and version: `mujoco 4.0.0`.
        single: Whether it computes in single precision.
        torques: Quantity to torque of each step, environment and joint [N*m or N]; NaN where a joint has no drive.
        figures: Joint to fields that the engine itself reports, in SI.
    """

    engine: str
    single: bool
    torques: Mapping[str, Array]
    figures: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


Motions = Mapping[str, Motion]
