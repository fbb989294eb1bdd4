"""What an engine is asked, and what it answers."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from actspec.diagnostics import shortened
from actspec.ir import ActuatorSet
from actspec.robot.view import RobotView
from actspec.simulate.excitation import HeldMotions, motion_arrays
from actspec.targets.base import TargetOptions
from actspec.verify.agreement import Skip
from actspec.verify.environments import EngineError, Frameworks, find_frameworks, unusable

if TYPE_CHECKING:
    from actspec.laws.arrays import Floats as Array

T = TypeVar("T")

PROBES = Path(__file__).parents[1] / "probes"
"""Scripts that run in the simulators' environments: they import no module of actspec."""
SETUP = "actspec verify --setup SPEC"


class EngineRefused(Exception):
    """The engine does not take the file; the message is its own, on one line."""


class EngineMissing(Exception):
    """There is no engine for a target here.

    Attributes:
        reason: Why.
        help: What would change that; None: nothing would.
        setup: Whether it can be installed: by `actspec verify --setup`, or as `help` says.
    """

    def __init__(self, reason: str, help: str | None = None, *, setup: bool = False) -> None:
        super().__init__(reason)
        self.reason, self.help, self.setup = reason, help, setup

    def skip(self, target: str, what: str) -> Skip:
        """What was not asked of a target for that."""
        return Skip(target, "", what, self.reason, self.help, self.setup)


def answered(ask: Callable[..., T], *args: Any) -> T | EngineMissing | EngineRefused:
    """What an engine answers, or why there is no answer."""
    try:
        return ask(*args)
    except (EngineMissing, EngineRefused) as err:
        return err


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

    def job(self, motions: HeldMotions) -> tuple[dict[str, Any], dict[str, Array]]:
        """What a script gets of joints that are held, and its arrays."""
        commands = [actuator.command.value for actuator in self.actuators.joints]
        job = {"columns": self.joints, "commands": commands, "motions": list(motions)}
        return job, motion_arrays(motions)


@dataclass(frozen=True, slots=True)
class EngineAnswer:
    """What an engine made of joints that are held.

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


BodyFriction = tuple[Sequence[float], Sequence[float]]
"""Dry and viscous friction of each joint of an experiment [N*m or N], [N*m*s/rad or N*s/m]."""


@dataclass(frozen=True, slots=True)
class EngineResponse:
    """What an engine made of an experiment.

    Attributes:
        engine: Its name and version.
        single: Whether it computes in single precision.
        q: Positions at the start of each step and at the end [rad or m], shape (n_step + 1, n_course, n_joint);
            NaN from where the engine gives up.
        halved: The same in steps of half the length, the delay the same in seconds.
        torque: Of the drive at the start of each step [N*m or N], shape (n_step, n_course, n_joint).
        errors: Why joints could not be asked.
    """

    engine: str
    single: bool
    q: Array
    halved: Array
    torque: Array
    errors: Mapping[str, str]

    @classmethod
    def of(
        cls, engine: str, said: Mapping[str, Any], out: Mapping[str, Array], *, single: bool
    ) -> EngineResponse:
        """From a script's answer and arrays."""
        return cls(engine, single, out["q1"], out["q2"], out["torque1"], said.get("errors", {}))


def prepared(engine: str) -> Frameworks:
    """The environment with the simulators.

    Args:
        engine: Name and release of the one that is asked for.

    Raises: EngineMissing: it is not prepared, or no release is for this machine.
    """
    why = unusable()
    if why is not None:
        raise EngineMissing(why)
    frameworks = find_frameworks()
    if frameworks is None:
        raise EngineMissing(f"{engine} is not prepared", SETUP, setup=True)
    return frameworks


def probed(
    frameworks: Frameworks, probe: str, job: Mapping[str, Any], arrays: Mapping[str, Any]
) -> tuple[Any, dict[str, Array]]:
    """What a script of `PROBES` answers, and its arrays.

    Raises: EngineRefused: the package does not take the file, or the script died.
    """
    try:
        said, out = frameworks.run_probe(PROBES / probe, job, arrays)
    except EngineError as err:
        raise EngineRefused(shortened(str(err), 300)) from err
    if "error" in said:
        raise EngineRefused(shortened(said["error"], 300))
    return said, out
