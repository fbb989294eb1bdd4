"""Compile a spec for mjlab, run its module there, and say in what it differs from the spec."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from actspec.laws import TorqueLaw, law_of
from tests.frameworks.asking import RTOL, STEP, Array, Run, joints, points, sent_files, torque_faults
from tests.frameworks.prepare import Frameworks
from tests.targets.mjlab.emitting import Written

PROBE = Path(__file__).with_name("mjlab_probe.py")

ENVS = 32
"""Environments for delays: so many that every lag is drawn."""


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

    def request(self) -> dict[str, Any]:
        """For the probe."""
        return {
            "files": sent_files(self),
            "module": self.written.emission.files[0].path,
            "model": self.model,
            "step": STEP,
            "joints": joints(self),
            "command": {a.joint: a.command.value for a in self.written.actuators.joints},
            "envs": ENVS,
        }

    def law(self, joint: str) -> TorqueLaw:
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
    if sorted(set(said["actuators"]) - {"kept"}) != sorted(joints(job)):
        return [f"actuators {said['actuators']} are not {joints(job)}"]
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
    return found + torque_faults(job, arrays)


def probed(frameworks: Frameworks, jobs: dict[str, Job]) -> Run[Job]:
    """Run modules in mjlab, all in one process."""
    arrays: dict[str, Array] = {}
    for name, one in jobs.items():
        arrays |= {f"{name}.{key}": value for key, value in points(one).items()}
        if one.sequence:
            arrays[f"{name}.sequence"] = np.tile(np.array(one.sequence)[:, None], (1, len(joints(one))))
    answer = frameworks.run_probe(PROBE, {n: j.request() for n, j in jobs.items()}, arrays)
    return Run(answer, faults, jobs)
