"""Ask a real mjlab: `probe_mjlab.py JOB.json IN.npz OUT.json OUT.npz`.

Standalone: it runs in the frameworks' environment, with `actspec/simulate/standalone.py` beside it, and imports nothing
else of actspec.

Job, beside what `standalone` says:
    module: the file with an articulation; it is executed.
    model: MJCF text of a robot.

Answers, likewise: `figures`: per joint what the compiled model has. A torque is what all actuators do at a joint, the
joints put back before every step. Bodies are the model's own.
"""

from __future__ import annotations

import dataclasses
import re
import runpy
from typing import Any

import mujoco
import numpy as np
import torch
from standalone import follow, serve  # type: ignore[import-not-found]

Array = np.ndarray[Any, Any]


class Robot:
    """An emitted module on a robot.

    Attributes:
        model: Compiled.
        joints: The joints that are asked about.
    """

    def __init__(self, names: dict[str, Any], text: str, joints: list[str], *, sort: bool = False) -> None:
        self.joints = joints
        self._articulation = next(v for k, v in names.items() if k.endswith("_ARTICULATION"))
        self._prepare = names.get("prepare_spec", lambda spec: spec)
        self._text = text
        # mjlab 1.0 has no such field.
        self._more = {"sort_actuators": True} if sort else {}
        self.model = self.entity().compile()

    def entity(self) -> Any:
        """A new entity of it."""
        from mjlab.entity import Entity, EntityCfg

        return Entity(
            EntityCfg(
                spec_fn=lambda: self._prepare(mujoco.MjSpec.from_string(self._text)),
                articulation=self._articulation,
                **self._more,
            )
        )

    @property
    def actuators(self) -> list[str]:
        """Names of its actuators, in the model's order."""
        return [self.model.actuator(i).name for i in range(self.model.nu)]

    def figures(self) -> dict[str, Array]:
        """What the compiled model has of each joint."""
        joints = [self.model.joint(name).id for name in self.joints]
        drives = [self.model.actuator(name).id for name in self.joints]
        dofs = self.model.jnt_dofadr[joints]
        return {
            "armature": self.model.dof_armature[dofs],
            "frictionloss": self.model.dof_frictionloss[dofs],
            "damping": self.model.dof_damping[dofs],
            "forcerange": self.model.actuator_forcerange[drives],
            "forcelimited": self.model.actuator_forcelimited[drives],
            "actfrcrange": self.model.jnt_actfrcrange[joints],
        }


class Simulated:
    """A robot in a simulation on the CPU.

    Args:
        robot: The robot.
        commands: What each of its joints is commanded by.
        step: Physics step [s].
        count: Environments.
        alone: Whether gravity, contacts and limits are off; else all constraints, which move joints that are put back.
    """

    def __init__(
        self, robot: Robot, commands: dict[str, str], step: float, count: int, *, alone: bool = False
    ) -> None:
        from mjlab.sim.sim import MujocoCfg, Simulation, SimulationCfg

        self.robot, self.commands, self.dt, self.count = robot, commands, step, count
        self.entity = robot.entity()
        self.model = self.entity.compile()
        if alone:
            # As `isolated` does: a slide that is alone in the world would have softer dry friction than on a robot.
            self.model.dof_invweight0[:] = 1.0 / self.model.dof_M0
        more: dict[str, Any] = (
            {"gravity": (0.0, 0.0, 0.0), "disableflags": ("contact", "limit")} if alone else {}
        )
        sizes = {}
        if not alone:
            # In the model, as mjlab 1.0 has no such option; without rows the solver is not run either.
            self.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
            self.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
            sizes = {"njmax": 0, "nconmax": 0}
        cfg = SimulationCfg(mujoco=MujocoCfg(timestep=step, **more), **sizes)
        self.sim = Simulation(num_envs=count, cfg=cfg, model=self.model, device="cpu")
        self.entity.initialize(self.model, self.sim.model, self.sim.data, "cpu")

    def reset(self) -> None:
        """Begin an episode."""
        self.entity.reset()

    def step(self, command: Array, q: Array, qd: Array) -> Array:
        """Put the joints somewhere, command them, and make one real step; (n_env, n_joint) each.

        Returns: What all actuators together did at each joint, after every clamp [N*m or N].
        """
        self.place(torch.tensor(q, dtype=torch.float32), torch.tensor(qd, dtype=torch.float32))
        return self.go(command)

    def go(self, command: Array) -> Array:
        """Command the joints where they are, and make one real step; (n_env, n_joint).

        Returns: As `step`.
        """
        self._command(torch.tensor(command, dtype=torch.float32))
        self.entity.write_data_to_sim()
        self.sim.step()
        dofs = [int(self.model.joint(name).dofadr[0]) for name in self.robot.joints]
        found: Array = self.sim.data.qfrc_actuator[:].cpu().numpy()[:, dofs]
        self.entity.update(self.dt)
        return found

    def positions(self) -> Array:
        """Where the joints are, (n_env, n_joint)."""
        places = [int(self.model.joint(name).qposadr[0]) for name in self.robot.joints]
        found: Array = self.sim.data.qpos[:].cpu().numpy()[:, places].astype(float)
        return found

    def place(self, q: torch.Tensor, qd: torch.Tensor) -> None:
        for column, name in enumerate(self.robot.joints):
            joint = self.model.joint(name)
            self.sim.data.qpos[:, int(joint.qposadr[0])] = q[:, column]
            self.sim.data.qvel[:, int(joint.dofadr[0])] = qd[:, column]

    def _command(self, values: torch.Tensor) -> None:
        ids = {name: i for i, name in enumerate(self.entity.joint_names)}
        targets = {kind: torch.zeros((self.count, len(ids))) for kind in ("position", "velocity", "effort")}
        for column, name in enumerate(self.robot.joints):
            targets[self.commands[name]][:, ids[name]] = values[:, column]
        self.entity.set_joint_position_target(targets["position"])
        self.entity.set_joint_velocity_target(targets["velocity"])
        self.entity.set_joint_effort_target(targets["effort"])


def run(job: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Every motion."""
    columns = job["columns"]
    names = runpy.run_path(job["module"])
    choose(names, columns)
    robot = Robot(names, job["model"], columns)
    missing = [name for name in columns if name not in robot.actuators]
    if missing:
        raise ValueError(f"{missing[0]} has no actuator")
    commands = dict(zip(columns, job["commands"], strict=True))
    held = robot.figures()
    figures = {
        name: {
            key: float(held[of][i])
            for key, of in (
                ("armature", "armature"),
                ("frictionloss", "frictionloss"),
                ("joint_damping", "damping"),
            )
        }
        for i, name in enumerate(columns)
    }
    out = {}
    for name in job["motions"]:
        command, q, qd = (arrays[f"{name}/{part}"] for part in ("command", "q", "qd"))
        simulated = Simulated(robot, commands, job["step"], q.shape[1])
        # Lags that are drawn are the same each time.
        torch.manual_seed(0)
        simulated.reset()
        out[name] = np.stack([simulated.step(*now) for now in zip(command, q, qd, strict=True)])
    return {"figures": figures}, out


def respond(job: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Every course in an environment of its own; the joints are on bodies of their own already."""
    columns, command = job["columns"], arrays["command"]
    commands = dict(zip(columns, job["commands"], strict=True))
    lags = dict(zip(columns, job["lags"], strict=True))
    out = {}
    for parts in job["parts"]:
        names = runpy.run_path(job["module"])
        choose(names, columns)
        divide(names, columns, lags, parts)
        robot = Robot(names, job["model"], columns)
        simulated = Simulated(robot, commands, job["step"] / parts, command.shape[1], alone=True)
        simulated.reset()
        simulated.place(*(torch.tensor(arrays[name], dtype=torch.float32) for name in ("q", "qd")))
        out[f"q{parts}"], out[f"torque{parts}"] = follow(simulated, command, parts)
    return {}, out


def choose(names: dict[str, Any], joints: list[str]) -> None:
    """Leave actuators out of the articulation that drive none of the joints.

    Nobody asks for them; of a network, which is a program in TorchScript, nothing is loaded then.
    """
    key = next(key for key in names if key.endswith("_ARTICULATION"))
    names[key] = dataclasses.replace(
        names[key],
        actuators=tuple(
            cfg
            for cfg in names[key].actuators
            if any(re.fullmatch(pattern, name) for pattern in cfg.target_names_expr for name in joints)
        ),
    )


def divide(names: dict[str, Any], joints: list[str], lags: dict[str, int], parts: int) -> None:
    """Delays for steps of a part of the length: the one nearest to a joint's lag, as long in seconds."""
    from mjlab.utils.lab_api.string import resolve_matching_names

    articulation = next(v for k, v in names.items() if k.endswith("_ARTICULATION"))
    for cfg in articulation.actuators:
        mine = [joints[i] for i in resolve_matching_names(cfg.target_names_expr, joints)[0]]
        lag = lags[mine[0]] if mine else 0
        lag = min(max(lag, cfg.delay_min_lag), cfg.delay_max_lag) * parts
        cfg.delay_min_lag = cfg.delay_max_lag = lag


if __name__ == "__main__":
    serve(lambda job, arrays: (respond if "parts" in job else run)(job, arrays))
