"""Run jobs on the MuJoCo that PYTHONPATH names: `rollout_probe.py JOBS.json ARRAYS.npz OUT.json OUT.npz`.

With `actspec/simulate/rollout.py` beside it, which imports nothing of actspec; tests/agree/engines.py writes the jobs
and reads the answers.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from rollout import JobError, Rig, actuator_count, load_model

Array = np.ndarray[Any, Any]

FIELDS = """
    qpos0 jnt_type jnt_qposadr jnt_dofadr jnt_range jnt_limited jnt_stiffness
    jnt_actfrcrange jnt_actfrclimited
    dof_damping dof_dampingpoly dof_frictionloss dof_armature dof_M0
    actuator_trntype actuator_trnid actuator_gear actuator_gainprm actuator_biasprm actuator_dynprm
    actuator_ctrlrange actuator_ctrllimited actuator_forcerange actuator_forcelimited
    actuator_ctrladr actuator_ctrlnum actuator_ctrlspec
    actuator_damping actuator_dampingpoly actuator_armature actuator_delay actuator_history
    key_qpos key_ctrl key_act
"""
"""What a load reports where the release has it; a job asks for more by name."""
SIZES = ("nq", "nv", "nu", "na", "njnt", "nkey", "nactuator")


def forces(rig: Rig) -> dict[str, Array]:
    """Forces of the last evaluation, on the rig's joints and on every degree of freedom."""
    data = rig.data
    values = {
        "torque": data.qfrc_actuator[rig.qvel],
        "passive": data.qfrc_passive[rig.qvel],
        "constraint": data.qfrc_constraint[rig.qvel],
        "qfrc_actuator": data.qfrc_actuator,
        "qfrc_passive": data.qfrc_passive,
        "actuator_force": data.actuator_force,
        "qacc": data.qacc,
        "act": data.act,
    }
    return {name: np.array(value) for name, value in values.items()}


def torques_at(rig: Rig, q: Array, qd: Array, ctrl: Array) -> dict[str, Array]:
    """Forces at states, each evaluated alone, filters and delays settled at its controls.

    Args:
        rig: The joints and actuators.
        q: Positions [rad or m], shape (n_sample, n_joint).
        qd: Speeds [rad/s or m/s], likewise.
        ctrl: Controls, shape (n_sample, n_actuator).

    Returns: As `Rig.forces`, shape (n_sample, ...).
    """
    import mujoco

    rows = []
    for at, speed, now in zip(q, qd, ctrl, strict=True):
        rig.place(at, speed, now)
        rig.settle(now)
        mujoco.mj_forward(rig.model, rig.data)
        rows.append(forces(rig))
    return _stacked(rows)


def torques_over(rig: Rig, q: Array, qd: Array, ctrl: Array, start: Array | None = None) -> dict[str, Array]:
    """Forces at each step of a sequence of controls, the joints put back before every step.

    Args:
        rig: The joints and actuators.
        q: Positions [rad or m], shape (n_step, n_joint).
        qd: Speeds [rad/s or m/s], likewise.
        ctrl: Controls, shape (n_step, n_actuator).
        start: Controls that filters and delay lines begin at, shape (n_actuator,); None: the engine's bare reset.

    Returns: As `Rig.forces`, shape (n_step, ...).
    Raises: JobError: the simulation diverged.
    """
    import mujoco

    if start is not None:
        rig.settle(start)
    rows = []
    for at, speed, now in zip(q, qd, ctrl, strict=True):
        rig.place(at, speed, now)
        # Read before the step: RK4 would leave its last stage's forces behind.
        mujoco.mj_forward(rig.model, rig.data)
        rows.append(forces(rig))
        if not rig.step():
            raise JobError("the simulation diverged and the engine reset it")
    return _stacked(rows)


def _stacked(rows: list[dict[str, Array]]) -> dict[str, Array]:
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def describe(model: Any, more: Sequence[str] = ()) -> tuple[dict[str, Any], dict[str, Any]]:
    """Names, sizes, options and arrays of a compiled model."""
    import mujoco

    found = {
        "sizes": {name: int(getattr(model, name)) for name in SIZES if hasattr(model, name)},
        "timestep": float(model.opt.timestep),
        "integrator": mujoco.mjtIntegrator(model.opt.integrator).name,
        "joints": [model.joint(i).name for i in range(model.njnt)],
        "actuators": [model.actuator(i).name for i in range(actuator_count(model))],
        "gaintypes": [mujoco.mjtGain(int(t)).name for t in model.actuator_gaintype],
        "biastypes": [mujoco.mjtBias(int(t)).name for t in model.actuator_biastype],
        "dyntypes": [mujoco.mjtDyn(int(t)).name for t in model.actuator_dyntype],
    }
    names = [name for name in [*FIELDS.split(), *more] if hasattr(model, name)]
    return found, {f"field.{name}": np.array(getattr(model, name)) for name in names}


_loaded = lru_cache(maxsize=1)(load_model)
"""For jobs of one model that follow each other."""


def _answer(job: dict[str, Any], inputs: dict[str, Array]) -> tuple[dict[str, Any], dict[str, Array]]:
    """What one job asks: what the model is, and its torques or responses."""
    model = _loaded(job["path"], job["xml"], contacts=job["contacts"])
    found, arrays = describe(model, job["fields"])
    if job["kind"] == "grid":
        arrays.update(torques_at(Rig(model, job["joints"], job["actuators"]), **inputs))
    elif job["kind"] == "time":
        arrays.update(torques_over(Rig(model, job["joints"], job["actuators"]), **inputs))
    return found, arrays


def main(jobs_path: str, arrays_path: str, out_path: str, out_arrays_path: str) -> None:
    """Answer every job; one that fails says why and does not stop the others."""
    import mujoco

    with open(jobs_path, encoding="utf-8") as file:
        jobs = json.load(file)
    answers, arrays = [], {}
    with np.load(arrays_path) as given:
        for i, job in enumerate(jobs):
            inputs = {k.split(".", 1)[1]: given[k] for k in given.files if k.startswith(f"{i}.")}
            try:
                answer, found = _answer(job, inputs)
            except Exception as err:  # whatever the engine says is the answer
                answer, found = {"error": str(err) or repr(err)}, {}
            answers.append(answer)
            arrays.update({f"{i}.{key}": value for key, value in found.items()})
    np.savez(out_arrays_path, **arrays)  # type: ignore[arg-type]  # numpy's stub takes them for allow_pickle
    with open(out_path, "w", encoding="utf-8") as file:
        json.dump({"version": mujoco.__version__, "module": mujoco.__file__, "answers": answers}, file)


if __name__ == "__main__":
    main(*sys.argv[1:])
