"""Let joints of a MuJoCo model move: `probe_mujoco_response.py JOB.json IN.npz OUT.json OUT.npz`.

Standalone on purpose: only mujoco and numpy, nothing of actspec, so that an agreement is one between two programs.

Each joint is moved with its actuators to a model of its own: one body of a given inertia, no gravity, no contacts, no
limits, no spring, and the file's time step, integrator and solver. What it is made of is compared with the
file's compiled model row by row, so that it is the file's numbers that move.

Job:
    path: compiled model (`.mjb`) or MJCF.
    joints: hinges and slides, the columns of every array.
    parts: into how many steps each step of the file is divided, for each run: [1, 2].
Arrays: `command` (n_step, n_course, n_joint); `q` and `qd` at the start (n_course, n_joint); `inertia` of the
    bodies without armature (n_joint,).

Answers: `version`; `module`; `error` where the model is refused; `errors` by joint; arrays `q1` and `torque1` for
`parts` 1, and so on: positions (n_step + 1, n_course, n_joint) and torques of the actuators at the start of each
step (n_step, n_course, n_joint); NaN from where the engine gives up.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import mujoco
import numpy as np

Array = np.ndarray[Any, Any]

JOINT = {
    "type": "jnt_type",
    "pos": "jnt_pos",
    "axis": "jnt_axis",
    "range": "jnt_range",
    "limited": "jnt_limited",
    "margin": "jnt_margin",
    "group": "jnt_group",
    "solref_limit": "jnt_solref",
    "solimp_limit": "jnt_solimp",
    "actfrcrange": "jnt_actfrcrange",
    "actfrclimited": "jnt_actfrclimited",
    "actgravcomp": "jnt_actgravcomp",
    "springyield": "jnt_springyield",
    "armature": "dof_armature",
    "frictionloss": "dof_frictionloss",
    "solref_friction": "dof_solref",
    "solimp_friction": "dof_solimp",
}
"""Attribute of a joint to the row of a compiled model."""
ACTUATOR = {
    name: f"actuator_{name}"
    for name in (
        *(
            "gaintype",
            "biastype",
            "dyntype",
            "gainprm",
            "biasprm",
            "dynprm",
            "trntype",
            "gear",
            "cranklength",
        ),
        *("ctrllimited", "ctrlrange", "forcelimited", "forcerange", "actlimited", "actrange", "actearly"),
        *("group", "lengthrange", "delay", "armature", "ctrlspec"),
    )
}
"""Likewise of an actuator."""
OTHERS = {
    *("jnt_bodyid", "jnt_qposadr", "jnt_dofadr", "jnt_actuatorid", "jnt_plasticadr", "jnt_user"),
    *("dof_bodyid", "dof_jntid", "dof_parentid", "dof_treeid", "dof_Madr", "dof_simplenum"),
    *("dof_M0", "dof_invweight0", "dof_length"),
    *("actuator_trnid", "actuator_actadr", "actuator_ctrladr", "actuator_historyadr", "actuator_outadr"),
    *("actuator_acc0", "actuator_length0", "actuator_plugin", "actuator_user"),
}
"""Rows that are places in the model, or follow from its bodies: they are other ones here."""
SPRING = ("jnt_stiffness", "jnt_stiffnesspoly")


class Refused(Exception):
    """A joint cannot be moved out of its model."""


def main(job_path: str, arrays_path: str, said_path: str, out_path: str) -> None:
    """Answer a job; what the engine refuses is told."""
    with open(job_path, encoding="utf-8") as file:
        job = json.load(file)
    with np.load(arrays_path) as found:
        arrays = {key: found[key] for key in found.files}
    said: dict[str, Any] = {"version": mujoco.__version__, "module": mujoco.__file__, "errors": {}}
    out: dict[str, Array] = {}
    try:
        whole = load(job["path"])
    except Exception as err:  # whatever the engine says is the answer
        said["error"] = str(err) or repr(err)
    else:
        out = run(whole, job, arrays, said["errors"])
    with open(said_path, "w", encoding="utf-8") as file:
        json.dump(said, file)
    np.savez(out_path, **out)  # type: ignore[arg-type]  # numpy's stub takes them for allow_pickle


def load(path: str) -> Any:
    """The compiled model of a file."""
    if path.endswith(".mjb"):
        return mujoco.MjModel.from_binary_path(path)
    return mujoco.MjModel.from_xml_path(path)


def run(
    whole: Any, job: dict[str, Any], arrays: dict[str, Array], errors: dict[str, str]
) -> dict[str, Array]:
    """Every course of every joint."""
    command, start = arrays["command"], (arrays["q"], arrays["qd"])
    n_step, n_course, n_joint = command.shape
    out = {}
    for parts in job["parts"]:
        out[f"q{parts}"] = np.full((n_step + 1, n_course, n_joint), np.nan)
        out[f"torque{parts}"] = np.full((n_step, n_course, n_joint), np.nan)
    for column, name in enumerate(job["joints"]):
        for parts in job["parts"]:
            try:
                model = alone(whole, name, float(arrays["inertia"][column]), parts)
            except Exception as err:  # whatever the engine says is the answer
                errors[name] = str(err) or repr(err)
                continue
            for course in range(n_course):
                at, speed = (float(part[course, column]) for part in start)
                q, torque = follow(model, command[:, course, column], at, speed, parts)
                out[f"q{parts}"][:, course, column] = q
                out[f"torque{parts}"][:, course, column] = torque
    return out


def alone(whole: Any, name: str, inertia: float, parts: int) -> Any:
    """The compiled model of one joint and what drives it.

    Args:
        whole: Compiled model of the file.
        name: Of the joint.
        inertia: Of the body, armature aside [kg*m^2 or kg].
        parts: Into how many steps a step is divided; a delay stays what it is in seconds.
    """
    at = mujoco.mj_name2id(whole, mujoco.mjtObj.mjOBJ_JOINT, name)
    if at < 0:
        raise Refused("the model has no such joint")
    drives = driven_by(whole, at)
    if not drives:
        raise Refused("the joint has no actuator")
    model = build(whole, at, drives, inertia, 1).compile()
    for prefix, index, places in (
        ("jnt_", [at], [0]),
        ("dof_", [int(whole.jnt_dofadr[at])], [0]),
        ("actuator_", drives, range(len(drives))),
    ):
        same(whole, model, prefix, index, places)
    if parts != 1:
        model = build(whole, at, drives, inertia, parts).compile()
    for field in SPRING:
        if hasattr(model, field):
            getattr(model, field)[:] = 0.0
    options(whole.opt, model.opt, parts)
    return model


def driven_by(whole: Any, joint: int) -> list[int]:
    """The actuators of a joint."""
    kinds = {int(getattr(mujoco.mjtTrn, kind)) for kind in ("mjTRN_JOINT", "mjTRN_JOINTINPARENT")}
    trntype, trnid = whole.actuator_trntype, whole.actuator_trnid
    return [i for i in range(len(trntype)) if int(trntype[i]) in kinds and trnid[i, 0] == joint]


def build(whole: Any, at: int, drives: list[int], inertia: float, parts: int) -> Any:
    """The model of one joint, to be compiled."""
    spec = mujoco.MjSpec()
    # Before 3.2.5 a specification has the compiler's settings itself. Compiled ranges are in radians.
    getattr(spec, "compiler", spec).degree = False
    body = spec.worldbody.add_body()
    # The joint's own axis and place are kept, so the body is a ball there.
    body.explicitinertial = True
    body.ipos = whole.jnt_pos[at]
    slide = int(whole.jnt_type[at]) == int(mujoco.mjtJoint.mjJNT_SLIDE)
    body.mass = inertia if slide else 1.0
    body.inertia = [1.0 if slide else inertia] * 3
    joint = body.add_joint()
    joint.name = "joint"
    dof = int(whole.jnt_dofadr[at])
    for attribute, field in JOINT.items():
        put(joint, attribute, whole, field, dof if field.startswith("dof_") else at)
    joint.ref = float(whole.qpos0[whole.jnt_qposadr[at]])
    joint.springref = float(whole.qpos_spring[whole.jnt_qposadr[at]])
    polynomial(joint, "damping", whole, "dof_damping", dof)
    polynomial(joint, "stiffness", whole, "jnt_stiffness", at)
    for index in drives:
        drive = spec.add_actuator()
        drive.target = "joint"
        for attribute, field in ACTUATOR.items():
            put(drive, attribute, whole, field, index)
        drive.actdim = int(whole.actuator_actnum[index]) if int(whole.actuator_dyntype[index]) else -1
        if hasattr(whole, "actuator_dampingpoly"):
            polynomial(drive, "damping", whole, "actuator_damping", index)
        if hasattr(whole, "actuator_history"):
            drive.nsample, drive.interp = (int(value) for value in whole.actuator_history[index])
            drive.nsample *= parts
    return spec


def put(element: Any, attribute: str, whole: Any, field: str, index: int) -> None:
    """Set an attribute to a row of the compiled model, where this release has both."""
    if not hasattr(element, attribute) or not hasattr(whole, field):
        return
    value = getattr(whole, field)[index]
    if isinstance(value, np.ndarray):
        getattr(element, attribute)[: len(value)] = value
        return
    kind = type(getattr(element, attribute))
    setattr(
        element,
        attribute,
        kind(int(value)) if issubclass(kind, int) or hasattr(kind, "__members__") else value,
    )


def polynomial(element: Any, attribute: str, whole: Any, field: str, index: int) -> None:
    """Set a coefficient, and those of higher powers where there are any."""
    first = float(getattr(whole, field)[index])
    if np.ndim(getattr(element, attribute)) == 0:
        setattr(element, attribute, first)
    else:
        setattr(element, attribute, [first, *getattr(whole, field + "poly")[index]])


def same(whole: Any, model: Any, prefix: str, index: list[int], places: Any) -> None:
    """Raise unless the rows of the small model are those of the file's."""
    for field in dir(whole):
        if not field.startswith(prefix) or field in OTHERS:
            continue
        rows = getattr(whole, field)
        for i, j in zip(index, places, strict=True):
            if not np.array_equal(rows[i], getattr(model, field)[j]):
                raise Refused(
                    f"a model of this joint alone has another {field}: {getattr(model, field)[j]}, not {rows[i]}"
                )


def options(given: Any, mine: Any, parts: int) -> None:
    """The file's time step, integrator and solver, without gravity, contacts, limits and media."""
    for name in dir(given):
        if not name.startswith("_"):
            value = getattr(given, name)
            if isinstance(value, np.ndarray):
                getattr(mine, name)[:] = value
            elif isinstance(value, int | float):
                setattr(mine, name, value)
    mine.timestep = given.timestep / parts
    mine.gravity[:] = 0.0
    mine.wind[:] = 0.0
    mine.density = mine.viscosity = 0.0
    for flag in ("mjDSBL_CONTACT", "mjDSBL_LIMIT"):
        mine.disableflags |= int(getattr(mujoco.mjtDisableBit, flag))


def follow(model: Any, command: Array, q: float, qd: float, parts: int) -> tuple[Array, Array]:
    """Positions and torques while a joint follows its command; the actuators have always had the first one."""
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = q, qd
    settle(model, data, float(command[0]))
    first = int(getattr(model, "actuator_ctrladr", [0])[0])
    found, torque = np.full(len(command) + 1, np.nan), np.full(len(command), np.nan)
    found[0] = q
    for k, value in enumerate(command):
        data.ctrl[first] = value
        # Read before the step: RK4 would leave its last stage's forces behind.
        mujoco.mj_forward(model, data)
        torque[k] = data.qfrc_actuator[0]
        before = data.time
        for _ in range(parts):
            mujoco.mj_step(model, data)
        if not data.time > before:
            # The simulation diverged, and the engine began again.
            torque[k] = np.nan
            break
        found[k + 1] = data.qpos[0]
    return found, torque


def settle(model: Any, data: Any, value: float) -> None:
    """Fill filter and delay line of the first actuator as if it had always had this control."""
    filters = {int(getattr(mujoco.mjtDyn, kind)) for kind in ("mjDYN_FILTER", "mjDYN_FILTEREXACT")}
    if int(model.actuator_dyntype[0]) in filters:
        limited, limits = model.actuator_ctrllimited[0], model.actuator_ctrlrange[0]
        data.act[model.actuator_actadr[0]] = np.clip(value, *limits) if limited else value
    history = getattr(model, "actuator_history", None)
    if history is not None and history[0, 0]:
        mujoco.mj_initCtrlHistory(model, data, 0, None, np.full(int(history[0, 0]), value))


if __name__ == "__main__":
    main(*sys.argv[1:])
