"""Compile a spec for Isaac Lab, and ask the real package what the text is."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from actspec.ir import ActuatorSet, Command, JointActuator
from actspec.laws import law_of
from actspec.resolution import resolve
from actspec.robot.load import listed_robot
from actspec.robot.view import RobotView
from actspec.spec.document import document_from_text
from actspec.spec.validate import validate
from actspec.targets.base import Emission, TargetOptions
from actspec.targets.isaaclab.emit import emit
from tests.compiling import target_options
from tests.frameworks.prepare import ISAACLAB, Frameworks

PROBE = Path(__file__).with_name("isaaclab_probe.py")

WHEELS = {"2.2": ISAACLAB[0], "2.3": ISAACLAB[1]}
"""Version of a target to the release that runs its text."""

USD = 123.0
"""What the USD says of everything: a number that is left out shows as this, one that a dict forgets as 0."""

RTOL = 1e-5
"""The classes compute in single precision: 24 bits, a few roundings deep."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Emitted:
    """A spec, compiled.

    Attributes:
        actuators: What it means.
        robot: Its robot.
        emission: What was written.
    """

    actuators: ActuatorSet
    robot: RobotView
    emission: Emission

    @property
    def text(self) -> str:
        """The module."""
        return self.emission.files[0].data.decode("utf-8")

    @property
    def constant(self) -> str:
        """Name of the dict of cfgs, read from the text."""
        return next(line for line in self.text.splitlines() if line.endswith("_ACTUATORS = {")).split()[0]

    @property
    def joints(self) -> list[str]:
        """All joints of the robot."""
        return [joint.name for joint in self.robot.joints]


def options(version: str = "2.3", cls: str | dict[str, str] = "auto", **more: Any) -> TargetOptions:
    """The target at a version."""
    return target_options("isaaclab", version, class_=cls, **more)


def compiled(
    text: str, version: str = "2.3", cls: str | dict[str, str] = "auto", *, path: str = "s.yaml", **more: Any
) -> Emitted:
    """Compile a spec without a model."""
    spec = validate(document_from_text(text, path))
    robot = listed_robot(spec)
    actuators = resolve(spec, robot)
    return Emitted(actuators, robot, emit(actuators, robot, options(version, cls, **more)))


@dataclass
class Answer:
    """What the real classes say.

    Attributes:
        joints: Numbers by joint.
        torque: Torque of each step, environment and joint after a reset [N*m or N].
        fresh: The same without one.
        again: The same motion once more, after a reset of the first environment alone.
    """

    joints: dict[str, dict[str, Any]]
    torque: Array
    fresh: Array
    again: Array


@dataclass
class Motion:
    """What the joints are told and do; each (n_step, n_env, n_joint)."""

    positions: Array
    velocities: Array
    efforts: Array
    q: Array
    qd: Array
    commands: Array = field(default_factory=lambda: np.zeros(0))


def ask(
    frameworks: Frameworks, emitted: Emitted, motion: Motion, *, version: str = "2.3", text: str = ""
) -> Answer:
    """Execute the text, or a changed one, in a release and compute a motion."""
    networks = {f.path: np.frombuffer(f.data, dtype=np.uint8) for f in emitted.emission.files[1:]}
    said, arrays = frameworks.run_probe(
        PROBE,
        {
            "root": str(frameworks.isaaclab(WHEELS[version])),
            "text": text or emitted.text,
            "constant": emitted.constant,
            "joints": emitted.joints,
            "usd": USD,
            "seed": 7,
            "networks": list(networks),
        },
        {
            **{name: getattr(motion, name) for name in ("positions", "velocities", "efforts", "q", "qd")},
            **{f"file:{name}": data for name, data in networks.items()},
        },
    )
    return Answer(said["joints"], arrays["torque"], arrays["fresh"], arrays["again"])


def still(emitted: Emitted, n_step: int, n_env: int) -> Motion:
    """Nothing commanded, nothing moving."""
    return Motion(*(np.zeros((n_step, n_env, len(emitted.joints))) for _ in range(6)))


def command(motion: Motion, actuator: JointActuator, column: int, values: Array) -> None:
    """Give a joint its command, in the part of the action that its kind of command has."""
    part = {
        Command.POSITION: motion.positions,
        Command.VELOCITY: motion.velocities,
        Command.EFFORT: motion.efforts,
    }[actuator.command]
    part[:, :, column] = values
    motion.commands[:, :, column] = values


def grid(emitted: Emitted, *, side: int = 25, asked: float = 3.0, speed: float = 2.5) -> Motion:
    """One step over error x speed.

    Args:
        emitted: The spec.
        side: Points a side.
        asked: Largest torque that the drive asks for before its clamp, in effort limits.
        speed: Largest speed, in no-load speeds.
    """
    motion = still(emitted, 1, side * side)
    for column, name in enumerate(emitted.joints):
        actuator = emitted.actuators.joint(name)
        if actuator is None:
            continue
        law = law_of(actuator)
        reach = asked * law.effort_limit
        fastest = law.curve[3] if law.curve else law.no_load_speed or 20.0
        torques, speeds = (
            part.ravel()
            for part in np.meshgrid(
                np.linspace(-reach, reach, side), np.linspace(-speed * fastest, speed * fastest, side)
            )
        )
        motion.q[0, :, column] = 0.3
        motion.qd[0, :, column] = speeds
        if law.command is Command.POSITION:
            values = 0.3 + law.encoder_bias + (torques + law.kd * speeds) / law.kp
        elif law.command is Command.VELOCITY:
            values = torques / law.kd + speeds
        else:
            values = torques
        command(motion, actuator, column, values[None])
    return motion


def expected(emitted: Emitted, joint: str, motion: Motion) -> Array:
    """The law's torque at the first step, where delay and filter are still at the first command."""
    actuator, column = emitted.actuators.joint(joint), emitted.joints.index(joint)
    assert actuator is not None
    law = law_of(actuator)
    # What reaches the classes is in single precision.
    given, q, qd = (
        part[0, :, column].astype(np.float32).astype(float) for part in (motion.commands, motion.q, motion.qd)
    )
    low, high = law.command_range or (-math.inf, math.inf)
    return np.asarray(law.torque(np.clip(given, low, high), q, qd), dtype=float)


def torque_faults(emitted: Emitted, answer: Answer, motion: Motion) -> list[str]:
    """Joints whose torque is not the law's anywhere on the grid."""
    found = []
    for column, name in enumerate(emitted.joints):
        actuator = emitted.actuators.joint(name)
        if actuator is None:
            continue
        want, got = expected(emitted, name, motion), answer.torque[0, :, column]
        # Terms that cancel leave their rounding: that of the largest.
        law = law_of(actuator)
        terms = max(law.kp, 1.0) * np.abs(motion.commands[0, :, column]) + law.kd * np.abs(
            motion.qd[0, :, column]
        )
        wrong = np.abs(got - want) > RTOL * np.abs(want) + 1e-6 * terms
        if wrong.any():
            at = int(np.argmax(np.abs(got - want)))
            found.append(
                f"{name} torque: {got[at]:.6g}, the law has {want[at]:.6g} ({wrong.mean():.0%} of the grid)"
            )
    return found


def number_faults(emitted: Emitted, answer: Answer, numbers: dict[str, dict[str, float | None]]) -> list[str]:
    """Joints whose numbers are not those that are expected; None: the USD's own.

    Args:
        emitted: The spec.
        answer: What the classes hold.
        numbers: Name of the class's number to joint to value.
    """
    found = []
    for name, values in numbers.items():
        for joint, value in values.items():
            got = answer.joints.get(joint, {}).get(name)
            want = USD if value is None else value
            if got is None or not math.isclose(got, want, rel_tol=1e-6, abs_tol=1e-9):
                found.append(f"{joint} {name}: {got}, asked {want}")
    return found
