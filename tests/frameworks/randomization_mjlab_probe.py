"""Run by `Frameworks.run_probe`: real mjlab events on a real entity, in a real simulation on the CPU.

Job:
    cfg: the mjlab target's module; articulation: name of its articulation.
    events: the randomisation target's module; dict: name of its events.
    model: MJCF of the robot, with the prepared actuators removed.
    envs: number of environments.
    partial: environments whose episode ends after the first reset.

Answers: joint names, event names, the model fields they touch; per joint arrays (env, joint) of kp, kd and limit
in effect, armature, frictionloss, damping and encoder bias, after start-up and a reset of all environments
(`first_*`), and after a reset of `partial` (`second_*`).
"""

from __future__ import annotations

import json
import sys
import types
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import torch
from mjlab.actuator import BuiltinPositionActuator, IdealPdActuator
from mjlab.entity import Entity, EntityCfg
from mjlab.managers.event_manager import EventManager
from mjlab.sim import MujocoCfg, Simulation, SimulationCfg


class Scene(dict[str, Any]):
    """What a term asks of a scene: entities by name."""


def numbers(entity: Entity, simulation: Simulation) -> dict[str, np.ndarray]:
    """The effective numbers of each joint in each environment."""
    envs = simulation.num_envs
    found = {name: np.full((envs, entity.num_joints), np.nan) for name in ("kp", "kd", "limit")}
    model = simulation.model
    for actuator in entity.actuators:
        for column, target in enumerate(actuator.target_ids.tolist()):
            if isinstance(actuator, BuiltinPositionActuator):
                index = int(actuator.global_ctrl_ids[column])
                found["kp"][:, target] = model.actuator_gainprm[:, index, 0].numpy()
                np.testing.assert_array_equal(
                    model.actuator_biasprm[:, index, 1].numpy(), -model.actuator_gainprm[:, index, 0].numpy()
                )
                found["kd"][:, target] = -model.actuator_biasprm[:, index, 2].numpy()
                found["limit"][:, target] = model.actuator_forcerange[:, index, 1].numpy()
            else:
                assert isinstance(actuator, IdealPdActuator)
                found["kp"][:, target] = actuator.stiffness[:, column].numpy()
                found["kd"][:, target] = actuator.damping[:, column].numpy()
                found["limit"][:, target] = actuator.force_limit[:, column].numpy()
    columns = entity.indexing.joint_v_adr
    for name in ("dof_armature", "dof_frictionloss", "dof_damping"):
        value = getattr(model, name)[:, columns].numpy()
        found[name] = np.broadcast_to(value, (envs, entity.num_joints)).copy()
    found["bias"] = entity.data.encoder_bias.numpy().copy()
    return found


def main() -> None:
    job = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    torch.manual_seed(5)
    cfg: dict[str, Any] = {"__file__": "cfg.py", "__name__": "cfg"}
    exec(compile(job["cfg"], "cfg.py", "exec"), cfg)
    events: dict[str, Any] = {"__name__": "events"}
    exec(compile(job["events"], "events.py", "exec"), events)

    entity = Entity(
        EntityCfg(
            spec_fn=lambda: mujoco.MjSpec.from_string(job["model"]), articulation=cfg[job["articulation"]]
        )
    )
    model = entity.compile()
    simulation = Simulation(
        num_envs=job["envs"], cfg=SimulationCfg(mujoco=MujocoCfg(timestep=0.005)), model=model, device="cpu"
    )
    env = types.SimpleNamespace(
        num_envs=job["envs"], device="cpu", sim=simulation, scene=Scene(robot=entity), step_dt=0.02
    )
    entity.initialize(model, simulation.model, simulation.data, "cpu")
    manager = EventManager(events[job["dict"]], env)
    simulation.expand_model_fields(manager.domain_randomization_fields)

    everyone = torch.arange(job["envs"])
    if "startup" in manager.available_modes:
        manager.apply("startup")
    if "reset" in manager.available_modes:
        manager.apply("reset", everyone, global_env_step_count=0)
    arrays = {f"first_{key}": value for key, value in numbers(entity, simulation).items()}
    if "reset" in manager.available_modes:
        manager.apply("reset", torch.tensor(job["partial"]), global_env_step_count=100)
    arrays |= {f"second_{key}": value for key, value in numbers(entity, simulation).items()}
    said = {
        "joints": list(entity.joint_names),
        "terms": {mode: list(names) for mode, names in manager.active_terms.items()},
        "fields": list(manager.domain_randomization_fields),
    }
    with open(sys.argv[3], "w", encoding="utf-8") as stream:
        json.dump(said, stream)
    np.savez(sys.argv[4], **arrays)


main()
