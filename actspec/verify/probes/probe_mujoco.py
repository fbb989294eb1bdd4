"""Run jobs on the MuJoCo that PYTHONPATH names: `probe_mujoco.py JOBS.json ARRAYS.npz OUT.json OUT.npz`.

Standalone on purpose: only mujoco and numpy, nothing of actspec, so that an agreement is one between two
programs. `actspec.verify.engines.mujoco_release` writes the jobs and reads the answers.
"""

from __future__ import annotations

import json
import sys
from functools import lru_cache
from typing import Any

import mujoco
import numpy as np

# What a load reports where the release has it; the caller asks for more by name.
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
SIZES = ("nq", "nv", "nu", "na", "njnt", "nkey", "nactuator")


class JobError(Exception):
    """The model does not have what the job asks for."""


def main(jobs_path: str, arrays_path: str, out_path: str, out_arrays_path: str) -> None:
    """Answer every job; one that fails says why and does not stop the others."""
    with open(jobs_path, encoding="utf-8") as file:
        jobs = json.load(file)
    answers, arrays = [], {}
    with np.load(arrays_path) as given:
        for i, job in enumerate(jobs):
            inputs = {k.split(".", 1)[1]: given[k] for k in given.files if k.startswith(f"{i}.")}
            try:
                answer, found = run(job, inputs)
            except Exception as err:  # whatever the engine says is the answer
                answer, found = {"error": str(err) or repr(err)}, {}
            answers.append(answer)
            arrays.update({f"{i}.{key}": value for key, value in found.items()})
    np.savez(out_arrays_path, **arrays)
    with open(out_path, "w", encoding="utf-8") as file:
        json.dump({"version": mujoco.__version__, "module": mujoco.__file__, "answers": answers}, file)


def run(job: dict[str, Any], inputs: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Answer one job: what the model is, and for `grid` and `time` its torques."""
    model = load(job)
    answer, arrays = describe(model, job["fields"])
    if job["kind"] == "grid":
        arrays.update(grid(model, job, inputs))
    elif job["kind"] == "time":
        arrays.update(time(model, job, inputs))
    return answer, arrays


def load(job: dict[str, Any]) -> Any:
    """Compile the job's text or file; a `.mjb` is compiled already."""
    model = compiled(job["path"], job["xml"])
    # The joints may be put where the robot would never be; contacts only take time then.
    off = int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    model.opt.disableflags = (
        model.opt.disableflags & ~off if job["contacts"] else model.opt.disableflags | off
    )
    return model


@lru_cache(maxsize=1)
def compiled(path: str | None, xml: str | None) -> Any:
    """The model of a file or text, compiled once for jobs that follow each other."""
    if path is None:
        return mujoco.MjModel.from_xml_string(xml)
    if path.endswith(".mjb"):
        return mujoco.MjModel.from_binary_path(path)
    return mujoco.MjModel.from_xml_path(path)


def describe(model: Any, more: list[str]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Names, sizes, options and arrays of a compiled model."""
    n_actuator = actuator_count(model)
    answer = {
        "sizes": {name: int(getattr(model, name)) for name in SIZES if hasattr(model, name)},
        "timestep": float(model.opt.timestep),
        "integrator": mujoco.mjtIntegrator(model.opt.integrator).name,
        "joints": [model.joint(i).name for i in range(model.njnt)],
        "actuators": [model.actuator(i).name for i in range(n_actuator)],
        "gaintypes": [mujoco.mjtGain(int(t)).name for t in model.actuator_gaintype],
        "biastypes": [mujoco.mjtBias(int(t)).name for t in model.actuator_biastype],
        "dyntypes": [mujoco.mjtDyn(int(t)).name for t in model.actuator_dyntype],
    }
    names = [name for name in [*FIELDS.split(), *more] if hasattr(model, name)]
    arrays = {f"field.{name}": np.array(getattr(model, name)) for name in names}
    return answer, arrays


def actuator_count(model: Any) -> int:
    """Actuators; before 3.11 each had one control and `nu` counted both."""
    return int(getattr(model, "nactuator", model.nu))


class Rig:
    """A model whose joints are put where the job says.

    Attributes:
        qpos, qvel: Addresses of the job's joints.
        ctrl: Addresses of the controls in the job's columns.
        settled: Filtered actuators among them: (act address, column).
    """

    def __init__(self, model: Any, job: dict[str, Any]) -> None:
        self.model, self.data = model, mujoco.MjData(model)
        joints = [named(model, mujoco.mjtObj.mjOBJ_JOINT, name) for name in job["joints"]]
        for i, name in zip(joints, job["joints"], strict=True):
            if int(model.jnt_type[i]) not in values(mujoco.mjtJoint, "mjJNT_HINGE", "mjJNT_SLIDE"):
                raise JobError(f"joint {name!r} is neither hinge nor slide")
        self.qpos = np.array([model.jnt_qposadr[i] for i in joints], dtype=int)
        self.qvel = np.array([model.jnt_dofadr[i] for i in joints], dtype=int)
        if job["actuators"] is None:
            self.actuators = [driver(model, i, name) for i, name in zip(joints, job["joints"], strict=True)]
        else:
            self.actuators = [named(model, mujoco.mjtObj.mjOBJ_ACTUATOR, name) for name in job["actuators"]]
        first = getattr(model, "actuator_ctrladr", np.arange(model.nu))
        self.ctrl = np.array([first[i] for i in self.actuators], dtype=int)
        filters = values(mujoco.mjtDyn, "mjDYN_FILTER", "mjDYN_FILTEREXACT")
        self.settled = [
            (int(model.actuator_actadr[a]), column)
            for column, a in enumerate(self.actuators)
            if int(model.actuator_dyntype[a]) in filters
        ]
        self.reset()

    def reset(self) -> None:
        """Go back to the model's own state."""
        mujoco.mj_resetData(self.model, self.data)
        self.qpos0, self.qvel0 = self.data.qpos.copy(), self.data.qvel.copy()

    def place(self, q: Any, qd: Any, ctrl: Any) -> None:
        """Put the joints at (q, qd), everything else at the reset state, and set the controls."""
        self.data.qpos[:], self.data.qvel[:] = self.qpos0, self.qvel0
        self.data.qpos[self.qpos], self.data.qvel[self.qvel], self.data.ctrl[self.ctrl] = q, qd, ctrl

    def settle(self, ctrl: Any) -> None:
        """Fill filters and delay lines as if the controls had always been these."""
        ctrl = np.array(ctrl, dtype=float)
        limited, limits = self.model.actuator_ctrllimited, self.model.actuator_ctrlrange
        for act, column in self.settled:
            adr = self.ctrl[column]
            self.data.act[act] = np.clip(ctrl[column], *limits[adr]) if limited[adr] else ctrl[column]
        history = getattr(self.model, "actuator_history", None)
        if history is None:
            return
        for column, actuator in enumerate(self.actuators):
            n = int(history[actuator, 0])
            if n:
                mujoco.mj_initCtrlHistory(self.model, self.data, actuator, None, np.full(n, ctrl[column]))


def values(enum: Any, *names: str) -> set[int]:
    """Enum members as integers: from 3.12 a member no longer equals the numpy integer of its value."""
    return {int(getattr(enum, name)) for name in names}


def named(model: Any, kind: Any, name: str) -> int:
    """Index of a joint or actuator."""
    index = mujoco.mj_name2id(model, kind, name)
    if index < 0:
        raise JobError(f"no {kind.name[6:].lower()} {name!r} in the model")
    return int(index)


def driver(model: Any, joint: int, name: str) -> int:
    """The one actuator that drives a joint."""
    on_joint = values(mujoco.mjtTrn, "mjTRN_JOINT", "mjTRN_JOINTINPARENT")
    found = [
        i
        for i in range(actuator_count(model))
        if int(model.actuator_trntype[i]) in on_joint and model.actuator_trnid[i, 0] == joint
    ]
    if len(found) != 1:
        raise JobError(f"joint {name!r} has {len(found)} actuators: name the ones to command")
    return found[0]


def grid(model: Any, job: dict[str, Any], inputs: dict[str, Any]) -> dict[str, Any]:
    """Torques at each sample, filters and delays settled at its controls."""
    rig, out = Rig(model, job), Recorder()
    for q, qd, ctrl in zip(inputs["q"], inputs["qd"], inputs["ctrl"], strict=True):
        rig.place(q, qd, ctrl)
        rig.settle(ctrl)
        mujoco.mj_forward(model, rig.data)
        out.record(rig)
    return out.arrays()


def time(model: Any, job: dict[str, Any], inputs: dict[str, Any]) -> dict[str, Any]:
    """Torques at each step of a control sequence, the joints put back before every step."""
    rig, out = Rig(model, job), Recorder()
    if "start" in inputs:
        rig.settle(inputs["start"])
    for q, qd, ctrl in zip(inputs["q"], inputs["qd"], inputs["ctrl"], strict=True):
        rig.place(q, qd, ctrl)
        # Read before the step: RK4 would leave its last stage's forces behind.
        mujoco.mj_forward(model, rig.data)
        out.record(rig)
        before = rig.data.time
        mujoco.mj_step(model, rig.data)
        if not rig.data.time > before:
            raise JobError("the simulation diverged and the engine reset it")
    return out.arrays()


class Recorder:
    """Forces of each evaluation, on every degree of freedom and on the job's joints."""

    def __init__(self) -> None:
        self.rows: dict[str, list[Any]] = {}

    def record(self, rig: Rig) -> None:
        """Keep one evaluation."""
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
        for name, value in values.items():
            self.rows.setdefault(name, []).append(np.array(value))

    def arrays(self) -> dict[str, Any]:
        """Stack the rows: shape (n_sample, …)."""
        return {name: np.array(rows) for name, rows in self.rows.items()}


if __name__ == "__main__":
    main(*sys.argv[1:])
