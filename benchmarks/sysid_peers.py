"""What others make of the same logs, for sysid.py: `mujoco.sysid`, in an interpreter that has it, and the textbook.

python benchmarks/sysid_peers.py LOG.npz    # one joint by mujoco.sysid: figures, intervals and time as JSON
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
import time as clock
from pathlib import Path
from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]

KNOWN = 0.01
"""Inertia that the textbook takes as known [kg*m^2]."""
SENSORS = ("position", "velocity", "torque")
LOW = {"kp": 1.0, "kd": 0.01, "armature": 1e-4, "tc": 0.0, "b": 0.0, "delay": 0.0, "bias": -0.05}
HIGH = {"kp": 500.0, "kd": 20.0, "armature": 0.5, "tc": 5.0, "b": 2.0, "delay": 0.03, "bias": 0.05}
"""Of every figure, wide about what `RANGES` of sysid.py has."""


def textbook(command: Array, position: Array, time: Array) -> dict[str, float]:
    """Gains from the steps of a log: natural frequency 1.8 over the rise time, damping from the overshoot.

    Args:
        command: Levels in turn [rad], shape (n,).
        position: As read [rad], likewise.
        time: [s], likewise.

    Returns: `kp` and `kd`, medians over the steps.
    """
    corners = np.flatnonzero(np.abs(np.diff(command)) > 0.05) + 1
    ends = np.append(corners[1:], len(command))
    gains = []
    for first, last in zip(corners, ends, strict=True):
        before = float(np.mean(position[max(first - 25, 0) : first]))
        after = float(np.mean(position[max(last - 25, first) : last]))
        if last - first < 60 or abs(after - before) < 0.05:
            continue
        share = (position[first:last] - before) / (after - before)
        at = [int(np.argmax(share >= level)) for level in (0.1, 0.9)]
        rise = float(time[first + at[1]] - time[first + at[0]])
        if rise <= 0.0:
            continue
        over = min(max(float(share.max()) - 1.0, 1e-3), 0.99)
        damping = -math.log(over) / math.hypot(math.pi, math.log(over))
        natural = 1.8 / rise
        gains.append((KNOWN * natural**2, 2.0 * damping * natural * KNOWN))
    kp, kd = np.median(np.array(gains), axis=0) if gains else (math.nan, math.nan)
    return {"kp": float(kp), "kd": float(kd)}


def mujoco_sysid(
    python: str, model: str, columns: dict[str, Array], time: Array, limit: float, start: dict[str, float]
) -> dict[str, Any] | str:
    """One joint by `mujoco.sysid` in an interpreter of its own, from given figures; why not, where that fails."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "log.npz")
        np.savez(path, model=model, time=time, limit=limit, start=json.dumps(start), **columns)
        done = subprocess.run([python, __file__, str(path)], capture_output=True, text=True, check=False)
    if done.returncode:
        return (done.stderr.strip().splitlines() or ["it ended without a word"])[-1]
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def _fit(path: str) -> dict[str, Any]:
    """The log by `mujoco.sysid` as its tests use it: a position drive, its sensors, delay and bias on them."""
    import mujoco
    from mujoco import sysid

    data = dict(np.load(path))
    time, limit = data["time"], float(data["limit"])
    start: dict[str, float] = json.loads(str(data["start"]))
    spec = mujoco.MjSpec.from_string(str(data["model"]))
    spec.option.timestep = float(np.median(np.diff(time)))
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    drive = spec.add_actuator(name="drive", target="hip", trntype=mujoco.mjtTrn.mjTRN_JOINT)
    drive.set_to_position(kp=start["kp"], kv=start["kd"])
    drive.forcelimited, drive.forcerange = True, [-limit, limit]
    kinds = (
        mujoco.mjtSensor.mjSENS_JOINTPOS,
        mujoco.mjtSensor.mjSENS_JOINTVEL,
        mujoco.mjtSensor.mjSENS_JOINTACTFRC,
    )
    for name, kind in zip(SENSORS, kinds, strict=True):
        spec.add_sensor(name=name, type=kind, objtype=mujoco.mjtObj.mjOBJ_JOINT, objname="hip")

    def gain(name: str) -> Any:
        def apply(spec: Any, parameter: Any) -> None:
            value = float(parameter.value[0])
            if name == "kp":
                sysid.apply_pgain(spec, "drive", value)
            elif name == "kd":
                sysid.apply_dgain(spec, "drive", value)
            elif name == "bias":
                # The drive sees the encoder's position.
                spec.actuator("drive").biasprm[0] = -spec.actuator("drive").gainprm[0] * value
            elif name == "b":
                joint = spec.joint("hip")
                joint.damping = [value, 0.0, 0.0] if np.ndim(joint.damping) else value
            else:
                setattr(spec.joint("hip"), {"armature": "armature", "tc": "frictionloss"}[name], value)

        return None if name == "delay" else apply

    begun = clock.process_time()
    parameters = sysid.ParameterDict()
    for name, value in start.items():
        parameters.add(sysid.Parameter(name, value, LOW[name], HIGH[name], modifier=gain(name)))
    compiled = spec.compile()
    state = mujoco.MjData(compiled)
    initial = sysid.create_initial_state(compiled, state.qpos, state.qvel, state.act)
    control = sysid.TimeSeries.from_control_names(time, data["command"][:, None], compiled)
    read = np.stack([data[name] for name in SENSORS], axis=1)
    measured = sysid.TimeSeries.from_names(time, read, compiled)

    def residual(values: Any, predicted: Any, seen: Any, model: Any, whole: bool, **_: Any) -> Any:
        late, bias = float(values["delay"].value[0]), values["bias"]
        seen = sysid.apply_delayed_ts_window(seen, predicted, -HIGH["delay"], 0.0)
        shifted = sysid.apply_resample_and_delay(predicted, seen.times, late)
        shifted = sysid.apply_bias(shifted, "position", bias)
        left = sysid.weighted_diff(predicted_data=shifted.data, measured_data=seen.data, model=model)
        return sysid.normalize_residual(left, seen.data), shifted, seen

    sequences = [sysid.ModelSequences("bench", spec, "log", initial, control, measured)]
    function = sysid.build_residual_fn(models_sequences=sequences, modify_residual=residual, n_threads=1)
    found, result = sysid.optimize(
        initial_params=parameters, residual_fn=function, optimizer="mujoco", verbose=False
    )
    left, _, _ = function(result.x, found)
    _, wide = sysid.calculate_intervals(left, np.asarray(result.jac))
    seconds = clock.process_time() - begun
    values = {name: float(found[name].value[0]) for name in start}
    return {
        "values": values,
        "half": dict(zip(start, np.atleast_1d(wide).astype(float).tolist(), strict=True)),
        "seconds": seconds,
        "version": mujoco.__version__,
    }


if __name__ == "__main__":
    print(json.dumps(_fit(sys.argv[1])))
