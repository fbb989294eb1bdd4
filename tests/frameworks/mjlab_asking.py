"""Compile a spec for mjlab, run its module there, and say in what it differs from the spec."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from actspec.laws import initial_command_state, law_of, step_command
from tests.frameworks.prepare import Frameworks, ProbeAnswer
from tests.targets.mjlab.emitting import Written

PROBE = Path(__file__).with_name("mjlab_probe.py")

RTOL = 1e-5
"""mjlab computes in single precision: 24 bits, a few roundings deep."""

STEP = 0.005
"""Simulation step [s]."""
ENVS = 32
"""Environments for delays: so many that every lag is drawn."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Job:
    """One module to run.

    Attributes:
        written: It, with its spec and robot.
        model: The robot's text.
        grid: Errors and speeds to compute torques for, (error, speed); empty: none.
        sequence: Commands of each step, for delays; empty: none.
        mutation: Text to replace in the module, and what by.
    """

    written: Written
    model: str
    grid: tuple[Array, Array] | None = None
    sequence: tuple[float, ...] = ()
    mutation: tuple[str, str] | None = None

    @property
    def joints(self) -> list[str]:
        """Managed joints in the robot's order: the columns of every array."""
        return [actuator.joint for actuator in self.written.actuators.joints]

    def request(self) -> dict[str, Any]:
        """For the probe."""
        first, *rest = self.written.emission.files
        data = first.data
        if self.mutation is not None:
            old, new = (text.encode() for text in self.mutation)
            assert data.count(old) >= 1, old
            data = data.replace(old, new)
        files = {first.path: data, **{file.path: file.data for file in rest}}
        return {
            "files": {path: base64.b64encode(held).decode() for path, held in files.items()},
            "module": first.path,
            "model": self.model,
            "step": STEP,
            "joints": self.joints,
            "command": {a.joint: a.command.value for a in self.written.actuators.joints},
            "envs": ENVS,
        }

    def points(self) -> dict[str, Array]:
        """States and commands, (n_point, n_joint): each joint is asked for -3 to 3 times its limit."""
        if self.grid is None:
            return {}
        shares, speeds = (axis.ravel() for axis in np.meshgrid(*self.grid))
        q = 0.05 * np.cos(np.arange(len(shares)))
        columns = []
        for actuator in self.written.actuators.joints:
            law = self.law(actuator.joint)
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

    def law(self, joint: str) -> Any:
        """The law that mjlab is held to: what is a recorded approximation is out of it."""
        actuator = self.written.actuators.joint(joint)
        assert actuator is not None
        return replace(law_of(actuator), encoder_bias=0.0, filter_cutoff=None, command_range=None)


def faults(job: Job, said: Mapping[str, Any], arrays: Mapping[str, Array]) -> list[str]:
    """Everything in which mjlab differs from the spec; empty: nothing."""
    if "error" in said:
        return [said["error"]]
    found = []
    actuators = job.written.actuators.joints
    if sorted(set(said["actuators"]) - {"kept"}) != sorted(job.joints):
        return [f"actuators {said['actuators']} are not {job.joints}"]
    for key, name in (
        ("armature", "armature"),
        ("frictionloss", "friction_coulomb"),
        ("damping", "friction_viscous"),
    ):
        for actuator, value in zip(actuators, arrays[key], strict=True):
            asked = getattr(actuator, name).value
            if asked is not None and not np.isclose(value, asked, rtol=RTOL, atol=0.0):
                found.append(f"{actuator.joint}: {name} {value:g} is not {asked:g}")
    for actuator, limits, limited in zip(
        actuators, arrays["forcerange"], arrays["forcelimited"], strict=True
    ):
        asked = actuator.effort_limit.value
        if (asked is not None) != bool(limited) or (asked and not np.allclose(limits, (-asked, asked))):
            found.append(f"{actuator.joint}: forcerange {limits} is not -+{asked}")
    if job.grid is not None:
        points = job.points()
        for column, actuator in enumerate(actuators):
            law = job.law(actuator.joint)
            q, qd, command = (points[name][:, column] for name in ("q", "qd", "command"))
            # What the probe's arrays become there is what the law gets too.
            q, qd, command = (x.astype(np.float32).astype(np.float64) for x in (q, qd, command))
            asked = law.torque(command, q, qd)
            error = np.abs(arrays["force"][:, column] - asked) / np.abs(asked).max()
            if not error.max() <= RTOL:
                found.append(f"{actuator.joint}: torque differs by {error.max():.1e}")
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


@dataclass
class Run:
    """All modules, run."""

    answer: ProbeAnswer
    jobs: dict[str, Job] = field(default_factory=dict)

    def said(self, name: str) -> dict[str, Any]:
        """What was said of one module."""
        found: dict[str, Any] = self.answer.said[name]
        return found

    def arrays(self, name: str) -> dict[str, Array]:
        """Its arrays."""
        head = f"{name}."
        return {k.removeprefix(head): v for k, v in self.answer.arrays.items() if k.startswith(head)}

    def faults(self, name: str) -> list[str]:
        """In what it differs."""
        return faults(self.jobs[name], self.said(name), self.arrays(name))


def probed(frameworks: Frameworks, jobs: dict[str, Job]) -> Run:
    """Run modules in mjlab, all in one process."""
    arrays: dict[str, Array] = {}
    for name, one in jobs.items():
        arrays |= {f"{name}.{key}": value for key, value in one.points().items()}
        if one.sequence:
            arrays[f"{name}.sequence"] = np.tile(np.array(one.sequence)[:, None], (1, len(one.joints)))
    return Run(frameworks.run_probe(PROBE, {n: j.request() for n, j in jobs.items()}, arrays), jobs)
