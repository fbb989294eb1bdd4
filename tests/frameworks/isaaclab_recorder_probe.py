"""Run by `Frameworks.run_probe`: `actspec.isaaclab.recorder` on Isaac Lab's own articulation, without a simulator.

Articulation, its data and its actuators are Isaac Lab's; in place of PhysX each joint turns for itself. The environment
does what `ManagerBasedRLEnv.step` does, in its order.

Job:
    root: folder of the real `isaaclab` package.
    paths: for sys.path, behind all others.
    log: to write.
    actions: targets, (n_step, n_env, n_joint).
    end: step after which the second environment begins anew.

Arrays: `q`, `qd`, `torque` after each step of the second environment, the first row before any.
"""

from __future__ import annotations

import importlib
import json
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np
import torch

sys.path.insert(0, str(Path(__file__).parent))

from isaaclab_stand_ins import Anything, Finder, package

STEP, DECIMATION, INERTIA, SLIDES = 0.005, 4, 0.1, 2
JOINTS = ["hip", "knee", "rail"]


class View:
    """PhysX: joints that each turn for themselves, in semi-implicit steps."""

    def __init__(self, envs: int) -> None:
        self.count = envs
        self.q, self.qd, self.force = (torch.zeros(envs, len(JOINTS)) for _ in range(3))

    def get_dof_positions(self) -> torch.Tensor:
        return self.q.clone()

    def get_dof_velocities(self) -> torch.Tensor:
        return self.qd.clone()

    def set_dof_actuation_forces(self, force: torch.Tensor, envs: Any) -> None:
        self.force = force.clone()

    def step(self) -> None:
        self.qd = self.qd + STEP * self.force / INERTIA
        self.q = self.q + STEP * self.qd


class Environment:
    """The attributes of a `ManagerBasedRLEnv` that a recorder asks for, and its step."""

    step_dt = STEP * DECIMATION

    def __init__(self, robot: Any, view: View) -> None:
        self.scene, self.view = {"robot": robot}, view
        self.episode_length_buf = torch.zeros(view.count, dtype=torch.long)

    @property
    def unwrapped(self) -> Environment:
        return self

    def step(self, action: torch.Tensor, ends: list[int]) -> None:
        robot = self.scene["robot"]
        for _ in range(DECIMATION):
            robot.set_joint_position_target(action)
            robot._apply_actuator_model()
            self.view.set_dof_actuation_forces(robot._joint_effort_target_sim, None)
            self.view.step()
            robot.update(STEP)
        self.episode_length_buf += 1
        for env in ends:
            self.view.q[env], self.view.qd[env] = 0.0, 0.0
            self.episode_length_buf[env] = 0
            robot.data._joint_pos.timestamp = robot.data._joint_vel.timestamp = -1.0


def articulation(view: View) -> Any:
    """Isaac Lab's own, with what its initialisation takes from PhysX."""
    module = importlib.import_module("isaaclab.assets.articulation.articulation")
    actuators = importlib.import_module("isaaclab.actuators")
    simulation = types.SimpleNamespace(get_gravity=lambda: (0.0, 0.0, -9.81))
    data = importlib.import_module("isaaclab.assets.articulation.articulation_data")
    data.SimulationManager = types.SimpleNamespace(get_physics_sim_view=lambda: simulation)
    robot = object.__new__(module.Articulation)
    robot._root_physx_view, robot._data = view, data.ArticulationData(view, "cpu")
    view.shared_metatype = types.SimpleNamespace(dof_names=JOINTS)
    wide = [torch.zeros(view.count, len(JOINTS)) for _ in range(9)]
    names = (
        "joint_pos_target",
        "joint_vel_target",
        "joint_effort_target",
        "computed_torque",
        "applied_torque",
    )
    for name, value in zip((*names, "soft_joint_vel_limits"), wide, strict=False):
        setattr(robot._data, name, value)
    robot._joint_pos_target_sim, robot._joint_vel_target_sim, robot._joint_effort_target_sim = wide[6:]
    cfg = actuators.DCMotorCfg(
        joint_names_expr=[".*"],
        stiffness=20.0,
        damping=0.5,
        effort_limit=3.0,
        saturation_effort=4.0,
        velocity_limit=8.0,
    )
    given = {
        name: torch.full((view.count, len(JOINTS)), 1e9)
        for name in ("stiffness", "damping", "armature", "friction", "effort_limit", "velocity_limit")
    }
    drive = cfg.class_type(
        cfg=cfg, joint_names=JOINTS, joint_ids=slice(None), num_envs=view.count, device="cpu", **given
    )
    robot.actuators = {"legs": drive}
    return robot


def main() -> None:
    job = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    sys.meta_path.append(Finder())
    sys.path.insert(0, job["root"])
    package("isaaclab", f"{job['root']}/isaaclab")
    for part in ("sim", "assets"):
        package(f"isaaclab.{part}", f"{job['root']}/isaaclab/{part}").__class__ = Anything
    sys.path += job["paths"]
    view = View(2)
    robot = articulation(view)
    env = Environment(robot, view)

    from actspec.isaaclab import recorder

    log = recorder(env, environment=1, slides=["rail"])
    log.add()
    rows: dict[str, list[np.ndarray[Any, Any]]] = {"q": [], "qd": [], "torque": []}

    def keep() -> None:
        for name, value in (("q", view.q), ("qd", view.qd), ("torque", view.force)):
            rows[name].append(value[1].numpy().copy())

    keep()
    for k, action in enumerate(job["actions"]):
        env.step(torch.tensor(action), [1] if k == job["end"] else [])
        log.add()
        keep()
    log.save(job["log"])
    said = {"class": type(robot).__module__, "drive": type(robot.actuators["legs"]).__name__}
    Path(sys.argv[3]).write_text(json.dumps(said), encoding="utf-8")
    np.savez(sys.argv[4], **{name: np.array(values) for name, values in rows.items()})


if __name__ == "__main__":
    main()
