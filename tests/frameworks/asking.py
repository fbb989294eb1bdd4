"""What is asked of a simulator that runs a target's files: torques on a grid and along a sequence, as the law's."""

from __future__ import annotations

import base64
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from actspec.ir import ActuatorSet
from actspec.laws import TorqueLaw, initial_command_state, step_command
from actspec.targets.base import Emission
from tests.frameworks.prepare import ProbeAnswer

RTOL = 1e-5
"""mjlab and Newton compute in single precision: 24 bits, a few roundings deep."""

STEP = 0.005
"""Physics step [s]."""

Array = NDArray[np.float64]


class Written(Protocol):
    """A spec compiled for a target."""

    @property
    def actuators(self) -> ActuatorSet: ...
    @property
    def emission(self) -> Emission: ...


class Job(Protocol):
    """One emission to run.

    Attributes:
        written: It, with its spec and robot.
        grid: Errors and speeds to compute torques for, (error, speed); empty: none.
        sequence: Commands of each step, for delays and networks; empty: none.
        mutation: Text to replace in the main file, and what by.
    """

    @property
    def written(self) -> Written: ...
    @property
    def grid(self) -> tuple[Array, Array] | None: ...
    @property
    def sequence(self) -> tuple[float, ...]: ...
    @property
    def mutation(self) -> tuple[str, str] | None: ...
    def law(self, joint: str) -> TorqueLaw:
        """What the simulator is held to: what is a recorded approximation is out of it."""


def joints(job: Job) -> list[str]:
    """Managed joints in the robot's order: the columns of every array."""
    return [actuator.joint for actuator in job.written.actuators.joints]


def sent_files(job: Job) -> dict[str, str]:
    """The emission's files for the probe, by path, the main one with its mutation."""
    first, *rest = job.written.emission.files
    data = first.data
    if job.mutation is not None:
        old, new = (text.encode() for text in job.mutation)
        assert data.count(old) >= 1, old
        data = data.replace(old, new)
    files = {first.path: data, **{file.path: file.data for file in rest}}
    return {path: base64.b64encode(held).decode() for path, held in files.items()}


def points(job: Job) -> dict[str, Array]:
    """States and commands, (n_point, n_joint): each joint is asked for -3 to 3 times its limit."""
    if job.grid is None:
        return {}
    shares, speeds = (axis.ravel() for axis in np.meshgrid(*job.grid))
    q = 0.05 * np.cos(np.arange(len(shares)))
    columns = []
    for actuator in job.written.actuators.joints:
        law = job.law(actuator.joint)
        limit = law.effort_limit if np.isfinite(law.effort_limit) else 10.0
        scale = law.no_load_speed or (limit / law.kd if law.kd else 1.0)
        qd = scale * speeds
        asked = limit * shares
        command = {
            "position": q + (asked + law.kd * qd) / (law.kp or 1.0),
            "velocity": qd + asked / (law.kd or 1.0),
            "effort": asked,
        }[actuator.command.value]
        columns.append((q, qd, command))
    return {
        name: np.stack([column[k] for column in columns], axis=1)
        for k, name in enumerate(("q", "qd", "command"))
    }


def torque_faults(job: Job, arrays: Mapping[str, Array]) -> list[str]:
    """Joints whose torque on the grid is not the law's; without a grid: none."""
    if job.grid is None:
        return []
    found = []
    asked = points(job)
    for column, actuator in enumerate(job.written.actuators.joints):
        law = job.law(actuator.joint)
        q, qd, command = (asked[name][:, column] for name in ("q", "qd", "command"))
        # What the probe's arrays become there is what the law gets too.
        q, qd, command = (x.astype(np.float32).astype(np.float64) for x in (q, qd, command))
        torque = law.torque(command, q, qd)
        error = np.abs(arrays["force"][:, column] - torque).max() / np.abs(torque).max()
        if not error <= RTOL:
            found.append(f"{actuator.joint}: torque differs by {error:.1e}")
    return found


def expected_line(job: Job, joint: str, steps: int) -> Array:
    """Torque of the law at each step of the sequence, the joint held at 0, behind a delay of `steps`."""
    law = job.law(joint)
    state = initial_command_state(job.sequence[0], steps)
    torques = []
    for command in job.sequence:
        effective, state = step_command(state, command, steps=steps, alpha=None)
        torques.append(float(law.torque(np.float64(effective), np.float64(0.0), np.float64(0.0))))
    return np.array(torques)


J = TypeVar("J", bound=Job)


@dataclass
class Run(Generic[J]):
    """All jobs, run.

    Attributes:
        answer: What the probe said.
        judge: What a job's answer and arrays have that differs from the spec.
        jobs: By name.
    """

    answer: ProbeAnswer
    judge: Callable[[J, Mapping[str, Any], Mapping[str, Array]], list[str]]
    jobs: dict[str, J] = field(default_factory=dict)

    def said(self, name: str) -> dict[str, Any]:
        """What was said of one job."""
        found: dict[str, Any] = self.answer.said[name]
        return found

    def arrays(self, name: str) -> dict[str, Array]:
        """Its arrays."""
        head = f"{name}."
        return {k.removeprefix(head): v for k, v in self.answer.arrays.items() if k.startswith(head)}

    def faults(self, name: str) -> list[str]:
        """In what it differs."""
        return self.judge(self.jobs[name], self.said(name), self.arrays(name))
