"""Lay overlays on stages in the real Newton, and measure the torques and joints that they make.

A script for the frameworks' environment: it knows nothing of actspec or of the tests.

    python newton_probe.py in.json in.npz out.json out.npz
"""

from __future__ import annotations

import base64
import json
import os
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2] / "actspec" / "verify" / "probes"))

from probe_newton import COPIES, Rig

MODEL = ("joint_armature", "joint_friction", "joint_damping", "joint_velocity_limit", "joint_effort_limit",
         "joint_target_ke", "joint_target_kd")  # fmt: skip


def main(job_in: str, arrays_in: str, job_out: str, arrays_out: str) -> None:
    """Run every job of the input."""
    with open(job_in, encoding="utf-8") as file:
        request = json.load(file)
    # Before `newton`: an older release stands beside the installed one.
    sys.path[:0] = request["path"]
    warnings.simplefilter("ignore")
    import newton
    import warp

    warp.config.quiet = True
    arrays = dict(np.load(arrays_in))
    said: dict[str, Any] = {"version": newton.__version__}
    found: dict[str, np.ndarray] = {}
    for name, job in request["jobs"].items():
        own = {key.removeprefix(f"{name}."): a for key, a in arrays.items() if key.startswith(f"{name}.")}
        if "network" in job:
            found[f"{name}.file"] = network(job["network"])
            said[name] = {}
            continue
        try:
            said[name], out = run(name, job, own)
        except ValueError as err:
            # Newton's own word on an overlay that it refuses.
            said[name], out = {"error": f"{type(err).__name__}: {err}"}, {}
        found |= {f"{name}.{key}": array for key, array in out.items()}
    with open(job_out, "w", encoding="utf-8") as file:
        json.dump(said, file)
    np.savez(arrays_out, **found)  # type: ignore[arg-type]


def run(
    name: str, job: dict[str, Any], arrays: dict[str, np.ndarray]
) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """One stage with its overlay: what is in the model, and torques over the states and commands of `arrays`."""
    import newton

    stage = composed(name, job)
    builder = newton.ModelBuilder()
    result = builder.add_usd(stage)
    rig = Rig(builder, job["joints"], job["command"], job["step"], COPIES if "q" in arrays else 1)
    found = {key: getattr(rig.model, key).numpy()[rig.dofs[0]].astype(np.float64) for key in MODEL}
    said = {
        "actuators": int(result["actuator_count"]),
        "others": sorted(str(p.GetPath()) for p in stage.Traverse() if p.GetTypeName() == "MjcActuator"),
    }
    if "q" in arrays:
        (found["force"],) = rig.motion(*(arrays[key][None] for key in ("command", "q", "qd")))
    if "sequence" in arrays:
        # The joint held at 0 unless its motion is given; then a second episode after a reset.
        still = np.zeros_like(arrays["sequence"])
        motion = [arrays.get(f"sequence_{key}", still) for key in ("q", "qd")]
        states = rig.states()
        episodes = []
        for _ in range(2):
            for now, _ in states:
                if now is not None:
                    now.reset()
            row = []
            for q, qd, command in zip(*motion, arrays["sequence"], strict=True):
                # The same in each copy.
                torque, states = rig.torque(
                    states, *(np.broadcast_to(x, rig.dofs.shape) for x in (command, q, qd))
                )
                row.append(torque[0])
            episodes.append(row)
        found["lagged"] = np.array(episodes)
    if job.get("solve"):
        found["accelerated"] = solve(rig, job["solve"])
    return said, found


def composed(name: str, job: dict[str, Any]) -> Any:
    """The stage with the overlay as its session's layer, as the overlay's head says; both as files."""
    from pxr import Usd

    os.makedirs(name)
    for path, data in job["files"].items():
        with open(os.path.join(name, path), "wb") as file:
            file.write(base64.b64decode(data))
    with open(os.path.join(name, "stage.usda"), "w", encoding="utf-8") as file:
        file.write(job["stage"])
    stage = Usd.Stage.Open(os.path.join(name, "stage.usda"))
    stage.GetSessionLayer().subLayerPaths.append(os.path.abspath(os.path.join(name, job["overlay"])))
    return stage


def solve(rig: Rig, job: dict[str, Any]) -> np.ndarray:
    """Angular acceleration about Y of the one body, in one step of a solver from rest, its own drives included."""
    import newton

    rig.model.set_gravity((0.0, 0.0, 0.0))
    solver = newton.solvers.SolverSemiImplicit(rig.model)
    after, step = rig.model.state(), job["step"]
    zeros = np.zeros(rig.dofs.shape)
    rig.torque(rig.states(), np.array([job["command"]]), zeros, zeros)
    newton.eval_fk(rig.model, rig.state.joint_q, rig.state.joint_qd, rig.state)
    solver.step(rig.state, after, rig.control, None, step)
    # Linear velocity first, then angular.
    accelerated: np.ndarray = after.body_qd.numpy()[:, 4].astype(np.float64) / step
    return accelerated


def network(job: dict[str, Any]) -> np.ndarray:
    """An ONNX network as bytes: one linear layer, or an LSTM of one unit whose output is its hidden state."""
    import onnx
    from onnx import TensorProto, helper

    if job["kind"] == "mlp":
        weight = np.array(job["weight"], dtype=np.float32)[None]
        nodes = [helper.make_node("Gemm", ["x", "w", "b"], ["y"], transB=1)]
        initial = [
            helper.make_tensor("w", TensorProto.FLOAT, weight.shape, weight.ravel()),
            helper.make_tensor("b", TensorProto.FLOAT, [1], [job["bias"]]),
        ]
        shapes = ({"x": ["n", weight.shape[1]]}, {"y": ["n", 1]})
    else:
        # Gates in ONNX's order i, o, f, c; without recurrence but for the cell.
        weights = np.array(job["weight"], dtype=np.float32).reshape(1, 4, 2)
        nodes = [
            helper.make_node("LSTM", ["x", "w", "r", "", "", "h0", "c0"], ["", "h1", "c1"], hidden_size=1),
            helper.make_node("Squeeze", ["h1", "axes"], ["y"]),
        ]
        initial = [
            helper.make_tensor("w", TensorProto.FLOAT, weights.shape, weights.ravel()),
            helper.make_tensor("r", TensorProto.FLOAT, [1, 4, 1], np.zeros(4, np.float32)),
            helper.make_tensor("axes", TensorProto.INT64, [1], [0]),
        ]
        state = [1, "n", 1]
        shapes = ({"x": [1, "n", 2], "h0": state, "c0": state}, {"y": ["n", 1], "h1": state, "c1": state})
    values = [
        [helper.make_tensor_value_info(name, TensorProto.FLOAT, shape) for name, shape in side.items()]
        for side in shapes
    ]
    graph = helper.make_graph(nodes, "net", *values, initial)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)])
    if job.get("metadata"):
        helper.set_model_props(model, job["metadata"])
    onnx.checker.check_model(model)
    return np.frombuffer(model.SerializeToString(), dtype=np.uint8)


if __name__ == "__main__":
    main(*sys.argv[1:])
