"""Compile a spec for Newton, lay the overlay on a stage there, and say in what it differs from the spec."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from actspec.ir import JointKind
from actspec.laws import TorqueLaw, law_of
from actspec.targets.kit.python_text import stated
from tests.frameworks.asking import RTOL, STEP, Array, Run, joints, points, sent_files, torque_faults
from tests.frameworks.newton_stage import WRONG
from tests.frameworks.prepare import Frameworks
from tests.targets.newton.emitting import Written

PROBE = Path(__file__).with_name("newton_probe.py")


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

    def request(self) -> dict[str, Any]:
        """For the probe."""
        return {
            "files": sent_files(self),
            "overlay": self.written.emission.files[0].path,
            "stage": self.stage,
            "joints": self.paths,
            "command": [a.command.value for a in self.written.actuators.joints],
            "step": STEP,
            "solve": {"step": 1e-3, "command": self.solve} if self.solve else None,
        }

    def law(self, joint: str) -> TorqueLaw:
        """The law that Newton is held to: what is a recorded approximation is out of it."""
        actuator = self.written.actuators.joint(joint)
        assert actuator is not None
        return replace(law_of(actuator), filter_cutoff=None, command_range=None)

    def arrays(self) -> dict[str, Array]:
        """For the probe."""
        found = points(self)
        for key, row in zip(
            ("sequence", "sequence_q", "sequence_qd"), (self.sequence, *(self.motion or ())), strict=False
        ):
            if row:
                found[key] = np.tile(np.array(row)[:, None], (1, len(joints(self))))
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
    return found + torque_faults(job, arrays)


def probed(frameworks: Frameworks, jobs: dict[str, Job], path: Sequence[str] = ()) -> Run[Job]:
    """Run overlays in Newton, all in one process.

    Args:
        frameworks: The environment.
        jobs: By name.
        path: Folders of another release than the installed one.
    """
    arrays = {f"{name}.{key}": value for name, one in jobs.items() for key, value in one.arrays().items()}
    request = {"path": list(path), "jobs": {name: one.request() for name, one in jobs.items()}}
    return Run(frameworks.run_probe(PROBE, request, arrays), faults, jobs)
