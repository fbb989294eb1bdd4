"""Compile a spec for Newton, lay the overlay on a stage there, and say in what it differs from the spec."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from actspec.ir import JointKind
from actspec.laws import TorqueLaw, initial_command_state, law_of, step_command
from actspec.targets.kit.python_text import stated
from tests.frameworks.newton_stage import WRONG
from tests.frameworks.prepare import Frameworks, ProbeAnswer
from tests.targets.newton.emitting import Written

PROBE = Path(__file__).with_name("newton_probe.py")

RTOL = 1e-5
"""Newton computes in single precision: 24 bits, a few roundings deep."""

STEP = 0.005
"""Physics step [s]."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Job:
    """One overlay to run.

    Attributes:
        written: It, with its spec and robot.
        stage: What it is laid on.
        paths: Prim of each managed joint, by a second way than the target's.
        grid: Errors and speeds to compute torques for, (error, speed); empty: none.
        sequence: Commands of each step, for delays and networks; empty: none.
        motion: Positions and speeds at each of those steps; empty: held at 0.
        solve: Command of each joint for one step of a solver; empty: none.
        mutation: Text to replace in the overlay, and what by.
    """

    written: Written
    stage: str
    paths: tuple[str, ...]
    grid: tuple[Array, Array] | None = None
    sequence: tuple[float, ...] = ()
    motion: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    solve: tuple[float, ...] = ()
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
            "overlay": first.path,
            "stage": self.stage,
            "joints": self.paths,
            "command": [a.command.value for a in self.written.actuators.joints],
            "step": STEP,
            "solve": {"step": 1e-3, "command": self.solve} if self.solve else None,
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

    def law(self, joint: str) -> TorqueLaw:
        """The law that Newton is held to: what is a recorded approximation is out of it."""
        actuator = self.written.actuators.joint(joint)
        assert actuator is not None
        return replace(law_of(actuator), filter_cutoff=None, command_range=None)

    def arrays(self) -> dict[str, Array]:
        """For the probe."""
        found = self.points()
        for key, row in zip(
            ("sequence", "sequence_q", "sequence_qd"), (self.sequence, *(self.motion or ())), strict=False
        ):
            if row:
                found[key] = np.tile(np.array(row)[:, None], (1, len(self.joints)))
        return found


def faults(job: Job, said: Mapping[str, Any], arrays: Mapping[str, Array]) -> list[str]:
    """Everything in which Newton differs from the spec; empty: nothing."""
    if "error" in said:
        return [said["error"]]
    found = []
    actuators = job.written.actuators.joints
    if said["actuators"] != len(actuators):
        found.append(f"{said['actuators']} actuators for {len(actuators)} joints")
    if said["others"]:
        found.append(f"the model's own actuators act: {said['others']}")
    for k, actuator in enumerate(actuators):
        # What the spec does not state keeps the stage's.
        degree = math.pi / 180.0 if actuator.kind is JointKind.HINGE else 1.0
        for key, quantity, own in (
            ("joint_armature", actuator.armature, WRONG["armature"]),
            ("joint_friction", actuator.friction_coulomb, WRONG["friction"]),
            ("joint_damping", actuator.friction_viscous, WRONG["damping"] / degree),
            ("joint_velocity_limit", actuator.velocity_limit, WRONG["velocity_limit"] * degree),
            ("joint_effort_limit", actuator.effort_limit, WRONG["max_force"]),
        ):
            asked = quantity.require() if stated(quantity) else own
            if not np.isclose(arrays[key][k], asked, rtol=RTOL, atol=0.0):
                found.append(f"{actuator.joint}: {key} {arrays[key][k]:g} is not {asked:g}")
        gains = arrays["joint_target_ke"][k], arrays["joint_target_kd"][k]
        if any(gains):
            found.append(f"{actuator.joint}: the stage's own drive acts with gains {gains}")
    if job.grid is not None:
        points = job.points()
        for column, actuator in enumerate(actuators):
            law = job.law(actuator.joint)
            q, qd, command = (points[name][:, column] for name in ("q", "qd", "command"))
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


@dataclass
class Run:
    """All overlays, run."""

    answer: ProbeAnswer
    jobs: dict[str, Job] = field(default_factory=dict)

    def said(self, name: str) -> dict[str, Any]:
        """What was said of one overlay."""
        found: dict[str, Any] = self.answer.said[name]
        return found

    def arrays(self, name: str) -> dict[str, Array]:
        """Its arrays."""
        head = f"{name}."
        return {k.removeprefix(head): v for k, v in self.answer.arrays.items() if k.startswith(head)}

    def faults(self, name: str) -> list[str]:
        """In what it differs."""
        return faults(self.jobs[name], self.said(name), self.arrays(name))


def probed(frameworks: Frameworks, jobs: dict[str, Job], path: Sequence[str] = ()) -> Run:
    """Run overlays in Newton, all in one process.

    Args:
        frameworks: The environment.
        jobs: By name.
        path: Folders of another release than the installed one.
    """
    arrays = {f"{name}.{key}": value for name, one in jobs.items() for key, value in one.arrays().items()}
    request = {"path": list(path), "jobs": {name: one.request() for name, one in jobs.items()}}
    return Run(frameworks.run_probe(PROBE, request, arrays), jobs)
