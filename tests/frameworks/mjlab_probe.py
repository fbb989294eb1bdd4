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

import numpy as np
import torch

sys.path.insert(0, str(Path(__file__).parents[2] / "actspec" / "verify" / "probes"))

from probe_mjlab import Robot, Simulated


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
    joints = job["joints"]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            module = runpy.run_path(str((folder / job["module"]).resolve()))
            robot = Robot(module, job["model"], joints, sort=bool(job.get("sort")))
        except Exception as err:
            return {"error": f"{type(err).__name__}: {err}"}, {}
    names = robot.actuators
    said = {"actuators": names, "warnings": [str(w.message) for w in caught], "scales": scales(module)}
    if not set(joints) <= set(names):
        return said, {}
    found = robot.figures()
    if f"{name}.q" in arrays:
        q, qd, asked = (arrays[f"{name}.{key}"] for key in ("q", "qd", "command"))
        simulated = Simulated(robot, job["command"], job["step"], len(q))
        found["force"] = simulated.step(asked, q, qd)
    if f"{name}.sequence" in arrays:
        found["lagged"] = lagged(robot, job, arrays[f"{name}.sequence"])
    return said, found


def scales(module: dict[str, Any]) -> dict[str, float]:
    """The action scale."""
    return next((v for k, v in module.items() if k.endswith("_ACTION_SCALE")), {})


def lagged(robot: Robot, job: dict[str, Any], sequence: np.ndarray) -> np.ndarray:
    """Torque over steps of two episodes (episode, step, environment, joint), the joints held at 0."""
    count = job["envs"]
    simulated = Simulated(robot, job["command"], job["step"], count)
    torch.manual_seed(0)
    force = np.empty((2, len(sequence), count, len(robot.joints)))
    held = np.zeros((count, len(robot.joints)))
    for episode in range(2):
        simulated.reset()
        for k, row in enumerate(sequence):
            force[episode, k] = simulated.step(np.broadcast_to(row, held.shape), held, held)
    return force


def live(job: dict[str, Any]) -> dict[str, Any]:
    """What `actspec.mjlab` gives for a spec, in a Python that has both."""
    sys.path += job["paths"]
    from actspec.mjlab import articulation
    from actspec.testing import compared

    found = articulation(job["live"])
    beside = compared(job["live"], found)
    return {
        "class": type(found).__name__,
        "actuators": [dataclass_of(cfg) for cfg in found.actuators],
        "compared": [beside.count, beside.wrong()],
    }


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
