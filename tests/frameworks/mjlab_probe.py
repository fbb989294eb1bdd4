"""Run emitted mjlab modules in the frameworks' environment; see `Frameworks.run_probe`.

Each job of in.json is one module with its robot. The module is written to a folder, executed there, and
builds a real Entity; one environment a grid point gives the torques, stepping gives the delays.
"""

from __future__ import annotations

import base64
import io
import json
import runpy
import sys
import warnings
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import torch
from mjlab.entity import Entity, EntityCfg
from mjlab.sim.sim import MujocoCfg, Simulation, SimulationCfg


def main(job_path: str, arrays_path: str, said_path: str, out_path: str) -> None:
    """Run every job."""
    jobs = json.loads(Path(job_path).read_text(encoding="utf-8"))
    arrays = dict(np.load(arrays_path))
    said, out = {}, {}
    for name, job in jobs.items():
        if "live" in job:
            said[name], found = live(job), {}
        elif "weights" in job:
            said[name], found = {}, {"network": network(job["weights"])}
        else:
            said[name], found = run(name, job, arrays)
        out.update({f"{name}.{key}": value for key, value in found.items()})
    Path(said_path).write_text(json.dumps(said), encoding="utf-8")
    np.savez(out_path, **out)


def run(name: str, job: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """One module: its model, its torques on a grid, its delays."""
    folder = Path(name)
    folder.mkdir()
    for file, data in job["files"].items():
        (folder / file).write_bytes(base64.b64decode(data))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            module = runpy.run_path(str((folder / job["module"]).resolve()))
            articulation = next(v for k, v in module.items() if k.endswith("_ARTICULATION"))
            prepare = module.get("prepare_spec", lambda spec: spec)
            entity = Entity(
                EntityCfg(
                    spec_fn=lambda: prepare(mujoco.MjSpec.from_string(job["model"])),
                    articulation=articulation,
                    # mjlab 1.0 has no such field.
                    **({"sort_actuators": True} if job.get("sort") else {}),
                )
            )
            model = entity.compile()
        except Exception as err:
            return {"error": f"{type(err).__name__}: {err}"}, {}
    names = [model.actuator(i).name for i in range(model.nu)]
    said = {"actuators": names, "warnings": [str(w.message) for w in caught], "scales": scales(module)}
    if not set(job["joints"]) <= set(names):
        return said, {}
    joints = [model.joint(name).id for name in job["joints"]]
    drives = [model.actuator(name).id for name in job["joints"]]
    dofs = model.jnt_dofadr[joints]
    found = {
        "armature": model.dof_armature[dofs],
        "frictionloss": model.dof_frictionloss[dofs],
        "damping": model.dof_damping[dofs],
        "forcerange": model.actuator_forcerange[drives],
        "forcelimited": model.actuator_forcelimited[drives],
        "actfrcrange": model.jnt_actfrcrange[joints],
    }
    if f"{name}.q" in arrays:
        found["force"] = torques(
            entity, model, job, *(arrays[f"{name}.{key}"] for key in ("q", "qd", "command"))
        )
    if f"{name}.sequence" in arrays:
        found["lagged"] = lagged(job, arrays[f"{name}.sequence"], articulation, prepare)
    return said, found


def scales(module: dict[str, Any]) -> dict[str, float]:
    """The action scale."""
    return next((v for k, v in module.items() if k.endswith("_ACTION_SCALE")), {})


def simulate(entity: Any, model: Any, step: float, count: int) -> Any:
    """The entity in a simulation on the CPU."""
    cfg = SimulationCfg(mujoco=MujocoCfg(timestep=step))
    sim = Simulation(num_envs=count, cfg=cfg, model=model, device="cpu")
    entity.initialize(model, sim.model, sim.data, "cpu")
    return sim


def command(entity: Any, job: dict[str, Any], values: torch.Tensor) -> None:
    """Hand each joint its command."""
    ids = {name: i for i, name in enumerate(entity.joint_names)}
    targets = {kind: torch.zeros((values.shape[0], len(ids))) for kind in ("position", "velocity", "effort")}
    for column, name in enumerate(job["joints"]):
        targets[job["command"][name]][:, ids[name]] = values[:, column]
    entity.set_joint_position_target(targets["position"])
    entity.set_joint_velocity_target(targets["velocity"])
    entity.set_joint_effort_target(targets["effort"])


def place(model: Any, sim: Any, job: dict[str, Any], q: torch.Tensor, qd: torch.Tensor) -> None:
    """Put the joints where the grid says, straight into the simulation's state."""
    for column, name in enumerate(job["joints"]):
        joint = model.joint(name)
        sim.data.qpos[:, int(joint.qposadr[0])] = q[:, column]
        sim.data.qvel[:, int(joint.dofadr[0])] = qd[:, column]
    sim.forward()


def drive_torque(model: Any, sim: Any, job: dict[str, Any]) -> np.ndarray:
    """What all actuators together do at each joint, after every clamp, in the step that was just made."""
    dofs = [int(model.joint(name).dofadr[0]) for name in job["joints"]]
    return sim.data.qfrc_actuator[:].cpu().numpy()[:, dofs]


def torques(entity: Any, model: Any, job: dict[str, Any], *points: np.ndarray) -> np.ndarray:
    """Torque at each joint in each environment, in one real step from its state."""
    q, qd, asked = (torch.tensor(values, dtype=torch.float32) for values in points)
    sim = simulate(entity, model, job["step"], q.shape[0])
    place(model, sim, job, q, qd)
    command(entity, job, asked)
    entity.write_data_to_sim()
    sim.step()
    return drive_torque(model, sim, job)


def lagged(job: dict[str, Any], sequence: np.ndarray, articulation: Any, prepare: Any) -> np.ndarray:
    """Torque over steps of two episodes (episode, step, environment, joint), the joints held at 0."""
    count = job["envs"]
    entity = Entity(
        EntityCfg(spec_fn=lambda: prepare(mujoco.MjSpec.from_string(job["model"])), articulation=articulation)
    )
    model = entity.compile()
    sim = simulate(entity, model, job["step"], count)
    torch.manual_seed(0)
    force = np.empty((2, len(sequence), count, len(job["joints"])))
    held = torch.zeros((count, len(job["joints"])))
    for episode in range(2):
        entity.reset()
        for k, row in enumerate(sequence):
            place(model, sim, job, held, held)
            command(entity, job, torch.tensor(row, dtype=torch.float32).expand(count, -1))
            entity.write_data_to_sim()
            sim.step()
            force[episode, k] = drive_torque(model, sim, job)
            entity.update(job["step"])
    return force


def live(job: dict[str, Any]) -> dict[str, Any]:
    """What `actspec.mjlab` gives for a spec, in a Python that has both."""
    sys.path += job["paths"]
    from actspec.mjlab import articulation

    found = articulation(job["live"])
    return {"class": type(found).__name__, "actuators": [dataclass_of(cfg) for cfg in found.actuators]}


def dataclass_of(cfg: Any) -> list[Any]:
    """Class and fields of a cfg."""
    return [
        type(cfg).__name__,
        {key: value for key, value in vars(cfg).items() if key != "transmission_type"},
    ]


def network(weights: dict[str, Any]) -> np.ndarray:
    """A TorchScript network of one layer, as bytes."""
    layer = torch.nn.Linear(len(weights["weight"]), 1)
    with torch.no_grad():
        layer.weight[:] = torch.tensor([weights["weight"]])
        layer.bias[:] = weights["bias"]
    stream = io.BytesIO()
    torch.jit.save(torch.jit.script(torch.nn.Sequential(layer)), stream)
    return np.frombuffer(stream.getvalue(), dtype=np.uint8)


if __name__ == "__main__":
    main(*sys.argv[1:])
