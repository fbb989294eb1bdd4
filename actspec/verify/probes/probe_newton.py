"""Ask a real Newton: `probe_newton.py JOB.json IN.npz OUT.json OUT.npz`.

Standalone: it runs in the frameworks' environment, with `actspec/simulate/standalone.py` beside it, and imports nothing
else of actspec.

Job, beside what `standalone` says:
    path: folders for sys.path, before all others: an older release.
    overlay: the `.usda` that is laid on the stage.
    stage: text of the stage.
    joints: prims of the managed joints, the columns of every array.
    networks: whether torques of networks are asked for; else none is loaded.

Answers, likewise: `version`; `figures`: per column what the model has of the joint.
"""

from __future__ import annotations

import os
import sys
import warnings
from typing import Any

import numpy as np
from standalone import Body, Driven, follow, serve  # type: ignore[import-not-found]

Array = np.ndarray[Any, Any]

FIGURES = {
    "joint_armature": "armature",
    "joint_friction": "frictionloss",
    "joint_damping": "joint_damping",
    "joint_velocity_limit": "velocity_limit",
}
"""Array of a model to what it is."""

COPIES = 64
"""Of the robot that are asked at once, at most: a pass takes as long for one as for many, and each is built."""


class Rig:
    """Copies of a robot whose joints are put where they are wanted.

    Args:
        robot: A builder that has the stage with the overlay.
        joints: Prims of the joints.
        commands: What each is commanded by.
        step: Physics step [s].
        count: How many copies.
    """

    def __init__(self, robot: Any, joints: list[str], commands: list[str], step: float, count: int) -> None:
        builder = type(robot)()
        builder.replicate(robot, count)
        self.model = model = builder.finalize(device="cpu")
        self.commands, self.step = np.array(commands), step
        labels = list(getattr(model, "joint_label", None) or model.joint_key)
        # Of the first copy; the others lie behind it, one after the other.
        at = [labels.index(path) for path in joints]
        copies = np.arange(count)[:, None]
        self.dofs = model.joint_qd_start.numpy()[at] + copies * (model.joint_dof_count // count)
        self.coords = model.joint_q_start.numpy()[at] + copies * (model.joint_coord_count // count)
        self.state, self.control = model.state(), model.control()
        first = model.actuators[0]
        self.names = {
            "position": first.control_target_pos_attr or "joint_target_pos",
            "velocity": first.control_target_vel_attr or "joint_target_vel",
            "effort": first.control_feedforward_attr,
        }

    def figures(self) -> list[dict[str, float]]:
        """What the model has of each joint."""
        found = {key: getattr(self.model, name).numpy()[self.dofs[0]] for name, key in FIGURES.items()}
        return [{key: float(values[i]) for key, values in found.items()} for i in range(self.dofs.shape[1])]

    def states(self) -> list[tuple[Any, Any]]:
        """What each actuator remembers, before the first step."""
        return [(actuator.state(), actuator.state()) for actuator in self.model.actuators]

    def torque(
        self, states: list[tuple[Any, Any]], command: Array, q: Array, qd: Array
    ) -> tuple[Array, list[tuple[Any, Any]]]:
        """One step of every actuator at states, (n_copy, n_joint); torques, and what the actuators remember then."""
        self._put(command, q, qd)
        self.control.joint_f.zero_()
        after = []
        for actuator, (now, then) in zip(self.model.actuators, states, strict=True):
            actuator.step(self.state, self.control, now, then, dt=self.step)
            after.append((then, now))
        return self.control.joint_f.numpy()[self.dofs].astype(np.float64), after

    def motion(self, command: Array, q: Array, qd: Array) -> Array:
        """Torques of environments that each begin anew, (n_step, n_env, n_joint) all; as many at once as copies."""
        found, (last, count) = np.empty(q.shape), (q.shape[1] - 1, len(self.dofs))
        for first in range(0, last + 1, count):
            # Copies that are left over do as the last environment.
            envs = np.minimum(np.arange(first, first + count), last)
            states = self.states()
            for k in range(len(q)):
                found[k, envs], states = self.torque(states, command[k, envs], q[k, envs], qd[k, envs])
        return found

    def _put(self, command: Array, q: Array, qd: Array) -> None:
        _write(self.state.joint_q, self.coords, q)
        _write(self.state.joint_qd, self.dofs, qd)
        for kind, attribute in self.names.items():
            mine = self.commands == kind
            if not mine.any():
                continue
            target = getattr(self.control, attribute)
            # A position target has a place for each coordinate, or in older releases for each degree of freedom.
            whole = len(target) == self.model.joint_coord_count and kind == "position"
            _write(target, (self.coords if whole else self.dofs)[:, mine], command[:, mine])


def _write(array: Any, places: Array, values: Array) -> None:
    """Set some elements of a warp array."""
    whole = array.numpy().copy()
    whole[places] = values
    array.assign(whole)


def composed(stage: str, overlay: str, networks: bool = False) -> Any:
    """A stage with the overlay as its session's layer, as the overlay's head says."""
    from pxr import Usd

    with open("stage.usda", "w", encoding="utf-8") as file:
        file.write(stage)
    opened = Usd.Stage.Open("stage.usda")
    opened.GetSessionLayer().subLayerPaths.append(os.path.abspath(overlay))
    for prim in opened.Traverse():
        network = prim.GetAttribute("newton:modelPath")
        if network and network.HasAuthoredValue() and not networks:
            # No torque of a network is asked for.
            prim.SetActive(False)
    return opened


def run(job: dict[str, Any], arrays: dict[str, Array]) -> tuple[dict[str, Any], dict[str, Array]]:
    """Every motion."""
    import newton
    import warp

    warp.config.quiet = True
    builder = newton.ModelBuilder()
    builder.add_usd(composed(job["stage"], job["overlay"], job["networks"]))
    count = min(COPIES, max(arrays[f"{name}/q"].shape[1] for name in job["motions"]))
    rig = Rig(builder, job["joints"], job["commands"], job["step"], count)
    parts = ("command", "q", "qd")
    out = {name: rig.motion(*(arrays[f"{name}/{part}"] for part in parts)) for name in job["motions"]}
    return {"version": newton.__version__, "figures": rig.figures()}, out


def respond(job: dict[str, Any], arrays: dict[str, Array]) -> tuple[dict[str, Any], dict[str, Array]]:
    """Bodies of one joint each, moved by the actuators' torques."""
    import newton
    import warp

    warp.config.quiet = True
    out = {}
    for parts in job["parts"]:
        stage = composed(job["stage"], job["overlay"])
        # The overlay is a part of the session's layer: what is set in the stage's own is below it.
        stage.SetEditTarget(stage.GetSessionLayer())
        for prim in stage.Traverse():
            late = prim.GetAttribute("newton:delaySteps")
            if late and late.HasAuthoredValue():
                late.Set(late.Get() * parts)
        builder = newton.ModelBuilder()
        builder.add_usd(stage)
        step = job["step"] / parts
        # A copy for each course.
        rig = Rig(builder, job["joints"], job["commands"], step, len(arrays["q"]))
        armature = np.array([figures["armature"] for figures in rig.figures()])
        states = rig.states()

        def drive(command: Array, q: Array, qd: Array, rig: Rig = rig) -> Array:
            nonlocal states
            torque, states = rig.torque(states, command, q, qd)
            return torque

        body = Body(
            arrays["inertia"] + armature,
            arrays["coulomb"],
            arrays["viscous"],
            step,
            arrays["q"],
            arrays["qd"],
        )
        out[f"q{parts}"], out[f"torque{parts}"] = follow(Driven(drive, body), arrays["command"], parts)
    return {"version": newton.__version__}, out


def begin(job: dict[str, Any]) -> None:
    """Before `newton` is imported."""
    # An older release stands beside the installed one.
    sys.path[:0] = job["path"]
    # Newton runs what a checkpoint of torch says; an overlay that names one cannot have it loaded.
    sys.modules["torch"] = None  # type: ignore[assignment]  # the documented way to make an import fail
    warnings.simplefilter("ignore")


if __name__ == "__main__":
    serve(lambda job, arrays: (respond if "parts" in job else run)(job, arrays), begin)
