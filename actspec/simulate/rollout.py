"""Joints of a MuJoCo model, put somewhere or let go: torques at states, torques over time, rollouts.

    rig = Rig(model, ["knee"])
    moved = rollout(rig, command, q=np.array([0.1]), qd=np.zeros(1))

A file of two uses: a module of actspec, and a script that any MuJoCo from 3.2 on runs in a process of its own
(`rollout.py JOB.json IN.npz OUT.json OUT.npz`). So it imports mujoco and numpy, and nothing of actspec: what
`actspec verify` finds is then an agreement between two programs.

Angles are in rad, joint side and SI; a command is a control of the file, in the file's own unit and gear.

Job:
    path: MJCF or a compiled `.mjb`.
    columns: hinges and slides, the columns of every array, each with one actuator.
    motions: names of motions; or
    parts: into how many steps each step is divided, for each run of responses.
Arrays: `NAME/command`, `NAME/q`, `NAME/qd` for each motion, see `held_torques`; for responses see `responses`.

Answers: version, module, `error` where the model is refused, `errors` by joint; arrays `NAME`, or those of `responses`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray[Any, Any]

JOINT = {
    **{name: f"jnt_{name}" for name in ("type", "pos", "axis", "range", "limited", "margin", "group")},
    **{name: f"jnt_{name}" for name in ("actfrcrange", "actfrclimited", "actgravcomp", "springyield")},
    "solref_limit": "jnt_solref",
    "solimp_limit": "jnt_solimp",
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
PLACES = frozenset(
    (
        *("jnt_bodyid", "jnt_qposadr", "jnt_dofadr", "jnt_actuatorid", "jnt_plasticadr", "jnt_user"),
        *("dof_bodyid", "dof_jntid", "dof_parentid", "dof_treeid", "dof_Madr", "dof_simplenum"),
        *("dof_M0", "dof_invweight0", "dof_length"),
        *("actuator_trnid", "actuator_actadr", "actuator_ctrladr", "actuator_historyadr", "actuator_outadr"),
        *("actuator_acc0", "actuator_length0", "actuator_plugin", "actuator_user"),
    )
)
"""Rows that are places in a model, or follow from its bodies: they are other ones in another model of the joint."""
SPRING = ("jnt_stiffness", "jnt_stiffnesspoly")


class JobError(Exception):
    """The model does not have what is asked for, or a joint cannot be moved out of it."""


def load_model(path: str | None, xml: str | None = None, *, contacts: bool = True) -> Any:
    """The compiled model of a file or a text; a `.mjb` is compiled already.

    Args:
        path: Of MJCF or MJB; None: the text.
        xml: MJCF.
        contacts: Whether contacts and limits act; they only take time where joints are put where no robot would be.
    """
    import mujoco

    if path is None:
        model = mujoco.MjModel.from_xml_string(xml)
    elif path.endswith(".mjb"):
        model = mujoco.MjModel.from_binary_path(path)
    else:
        model = mujoco.MjModel.from_xml_path(path)
    if not contacts:
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    return model


def actuator_count(model: Any) -> int:
    """Actuators; before 3.11 each had one control and `nu` counted both."""
    return int(getattr(model, "nactuator", model.nu))


def drivers(model: Any, joint: int) -> list[int]:
    """The actuators that drive a joint, by index."""
    import mujoco

    on_joint = _values(mujoco.mjtTrn, "mjTRN_JOINT", "mjTRN_JOINTINPARENT")
    trntype, trnid = model.actuator_trntype, model.actuator_trnid
    return [
        i for i in range(actuator_count(model)) if int(trntype[i]) in on_joint and int(trnid[i, 0]) == joint
    ]


def _values(enum: Any, *names: str) -> set[int]:
    """Enum members as integers: from 3.12 a member no longer equals the numpy integer of its value."""
    return {int(getattr(enum, name)) for name in names}


def _named(model: Any, kind: Any, name: str) -> int:
    """Index of a joint or actuator."""
    import mujoco

    index = mujoco.mj_name2id(model, kind, name)
    if index < 0:
        raise JobError(f"no {kind.name[6:].lower()} {name!r} in the model")
    return int(index)


class Rig:
    """A model whose joints are put where they are wanted.

    Args:
        model: Compiled.
        joints: Hinges and slides, by name: the columns of positions and speeds.
        actuators: The columns of controls, by name; None: the one actuator of each joint.

    Raises:
        JobError: there is no such joint or actuator, or a joint has no or several actuators and none are named.

    Attributes:
        qpos, qvel: Addresses of the joints.
        ctrl: Addresses of the actuators' first controls.
        settled: Filtered actuators among them: (act address, column).
    """

    def __init__(self, model: Any, joints: Sequence[str], actuators: Sequence[str] | None = None) -> None:
        import mujoco

        at = [_named(model, mujoco.mjtObj.mjOBJ_JOINT, name) for name in joints]
        if actuators is None:
            found = [drivers(model, joint) for joint in at]
            for name, mine in zip(joints, found, strict=True):
                if len(mine) != 1:
                    raise JobError(f"joint {name!r} has {len(mine)} actuators: name the ones to command")
            drives = [mine[0] for mine in found]
        else:
            drives = [_named(model, mujoco.mjtObj.mjOBJ_ACTUATOR, name) for name in actuators]
        for i, name in zip(at, joints, strict=True):
            if int(model.jnt_type[i]) not in _values(mujoco.mjtJoint, "mjJNT_HINGE", "mjJNT_SLIDE"):
                raise JobError(f"joint {name!r} is neither hinge nor slide")
        self.model, self.data, self.actuators = model, mujoco.MjData(model), drives
        self.qpos = np.array([model.jnt_qposadr[i] for i in at], dtype=int)
        self.qvel = np.array([model.jnt_dofadr[i] for i in at], dtype=int)
        first = getattr(model, "actuator_ctrladr", np.arange(model.nu))
        self.ctrl = np.array([first[i] for i in drives], dtype=int)
        filters = _values(mujoco.mjtDyn, "mjDYN_FILTER", "mjDYN_FILTEREXACT")
        self.settled = [
            (int(model.actuator_actadr[a]), column)
            for column, a in enumerate(drives)
            if int(model.actuator_dyntype[a]) in filters
        ]
        self.reset()

    def reset(self) -> None:
        """Go back to the model's own state."""
        import mujoco

        mujoco.mj_resetData(self.model, self.data)
        self.qpos0, self.qvel0 = self.data.qpos.copy(), self.data.qvel.copy()

    def place(self, q: Any, qd: Any, ctrl: Any) -> None:
        """Put the joints at (q, qd), everything else at the reset state, and set the controls."""
        self.data.qpos[:], self.data.qvel[:] = self.qpos0, self.qvel0
        self.data.qpos[self.qpos], self.data.qvel[self.qvel], self.data.ctrl[self.ctrl] = q, qd, ctrl

    def settle(self, ctrl: Any) -> None:
        """Fill filters and delay lines as if the controls had always been these."""
        import mujoco

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

    def step(self, parts: int = 1) -> bool:
        """Make steps; whether the simulation goes on, and the engine did not begin again because it diverged."""
        import mujoco

        before = self.data.time
        for _ in range(parts):
            mujoco.mj_step(self.model, self.data)
        return bool(self.data.time > before)


def held_torques(rig: Rig, command: Array, q: Array, qd: Array) -> Array:
    """Torques of all actuators at each joint, the joints put back before every step.

    Args:
        rig: The joints and actuators; filters and delay lines begin settled at an environment's first controls.
        command: Controls, shape (n_step, n_env, n_actuator).
        q: Positions [rad or m], shape (n_step, n_env, n_joint).
        qd: Speeds [rad/s or m/s], likewise.

    Returns: [N*m or N], likewise.
    Raises: JobError: the simulation diverged.
    """
    import mujoco

    found = np.empty(q.shape)
    for env in range(q.shape[1]):
        rig.reset()
        rig.settle(command[0, env])
        for k in range(len(q)):
            rig.place(q[k, env], qd[k, env], command[k, env])
            # Read before the step: RK4 would leave its last stage's forces behind.
            mujoco.mj_forward(rig.model, rig.data)
            found[k, env] = rig.data.qfrc_actuator[rig.qvel]
            if k + 1 < len(q) and not rig.step():
                raise JobError("the simulation diverged and the engine reset it")
    return found


class Rolled(NamedTuple):
    """How joints moved; NaN from where the simulation diverged.

    Attributes:
        q: Positions at the start of each step and at the end [rad or m], shape (n_step + 1, n_joint).
        qd: Speeds, likewise [rad/s or m/s].
        torque: Of all actuators at each joint at the start of each step [N*m or N], shape (n_step, n_joint).
    """

    q: Array
    qd: Array
    torque: Array


def rollout(rig: Rig, command: Array, q: Array, qd: Array, *, parts: int = 1) -> Rolled:
    """Let joints follow their commands; the actuators have always had the first one.

    Args:
        rig: The joints and actuators; its data are overwritten.
        command: Controls of each step, shape (n_step, n_actuator).
        q: Positions at the start [rad or m], shape (n_joint,); everything else begins at the model's own state.
        qd: Speeds at the start [rad/s or m/s], likewise.
        parts: Simulated steps to a command.
    """
    import mujoco

    rig.reset()
    rig.place(q, qd, command[0])
    rig.settle(command[0])
    shape = len(command), len(rig.qpos)
    places, speeds = (np.full((shape[0] + 1, shape[1]), np.nan) for _ in range(2))
    torque = np.full(shape, np.nan)
    places[0], speeds[0] = q, qd
    for k, now in enumerate(command):
        rig.data.ctrl[rig.ctrl] = now
        # Read before the step: RK4 would leave its last stage's forces behind.
        mujoco.mj_forward(rig.model, rig.data)
        before = rig.data.qfrc_actuator[rig.qvel].copy()
        if not rig.step(parts):
            break
        torque[k] = before
        places[k + 1], speeds[k + 1] = rig.data.qpos[rig.qpos], rig.data.qvel[rig.qvel]
    return Rolled(places, speeds, torque)


def responses(
    whole: Any, joints: Sequence[str], inputs: dict[str, Array], parts: Sequence[int]
) -> tuple[dict[str, str], dict[str, Array]]:
    """Every course of every joint, each joint with its actuators on a body of its own.

    Args:
        whole: Compiled model of a file.
        joints: Hinges and slides, the columns of every array.
        inputs: `command`, shape (n_step, n_course, n_joint); `q` and `qd` at the start (n_course, n_joint); `inertia`
            of the bodies without armature (n_joint,).
        parts: Into how many steps each step of the file is divided, for each run: [1, 2].

    Returns:
        Why joints could not be moved; `q1` (n_step + 1, n_course, n_joint) and `torque1` (n_step, n_course, n_joint)
        for `parts` 1, and so on.
    """
    command = inputs["command"]
    n_step, n_course, n_joint = command.shape
    out, errors = {}, {}
    for part in parts:
        out[f"q{part}"] = np.full((n_step + 1, n_course, n_joint), np.nan)
        out[f"torque{part}"] = np.full((n_step, n_course, n_joint), np.nan)
    for column, name in enumerate(joints):
        for part in parts:
            try:
                model = isolated(whole, name, float(inputs["inertia"][column]), part)
            except Exception as err:  # whatever the engine says is the answer
                errors[name] = str(err) or repr(err)
                continue
            rig = Rig(model, ["joint"], ["actuator0"])
            for course in range(n_course):
                at, speed = (inputs[of][course, column][None] for of in ("q", "qd"))
                moved = rollout(rig, command[:, course, column][:, None], at, speed, parts=part)
                out[f"q{part}"][:, course, column] = moved.q[:, 0]
                out[f"torque{part}"][:, course, column] = moved.torque[:, 0]
    return errors, out


def isolated(whole: Any, name: str, inertia: float, parts: int = 1) -> Any:
    """A compiled model of one joint and what drives it, with the rows of the file's compiled model.

    One body, no gravity, no contacts, no limits, no spring; the file's time step, integrator and solver.

    Args:
        whole: Compiled model of the file.
        name: Of the joint.
        inertia: Of the body, armature aside > 0 [kg*m^2 or kg].
        parts: Into how many steps a step is divided; a delay stays what it is in seconds.

    Raises:
        JobError: there is no such joint, or nothing drives it, or a row is another one than the file's.
    """
    import mujoco

    at = mujoco.mj_name2id(whole, mujoco.mjtObj.mjOBJ_JOINT, name)
    if at < 0:
        raise JobError("the model has no such joint")
    drives = drivers(whole, at)
    if not drives:
        raise JobError("the joint has no actuator")
    model = _build(whole, at, drives, inertia, 1).compile()
    for prefix, index, places in (
        ("jnt_", [at], [0]),
        ("dof_", [int(whole.jnt_dofadr[at])], [0]),
        ("actuator_", drives, range(len(drives))),
    ):
        _check_same(whole, model, prefix, index, places)
    if parts != 1:
        model = _build(whole, at, drives, inertia, parts).compile()
    # A body fixed to the world with slides alone gets 1 / mass, without armature, by which its dry friction is softer:
    # the body here is fixed to the world, the file's seldom is.
    model.dof_invweight0[:] = 1.0 / model.dof_M0
    for field in SPRING:
        if hasattr(model, field):
            getattr(model, field)[:] = 0.0
    _set_options(whole.opt, model.opt, parts)
    return model


def _build(whole: Any, at: int, drives: list[int], inertia: float, parts: int) -> Any:
    """A model of one body, its joint and actuators."""
    import mujoco

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
        _put(joint, attribute, whole, field, dof if field.startswith("dof_") else at)
    joint.ref = float(whole.qpos0[whole.jnt_qposadr[at]])
    joint.springref = float(whole.qpos_spring[whole.jnt_qposadr[at]])
    _put_polynomial(joint, "damping", whole, "dof_damping", dof)
    _put_polynomial(joint, "stiffness", whole, "jnt_stiffness", at)
    for number, index in enumerate(drives):
        drive = spec.add_actuator()
        drive.name = f"actuator{number}"
        drive.target = "joint"
        for attribute, field in ACTUATOR.items():
            _put(drive, attribute, whole, field, index)
        drive.actdim = int(whole.actuator_actnum[index]) if int(whole.actuator_dyntype[index]) else -1
        if hasattr(whole, "actuator_dampingpoly"):
            _put_polynomial(drive, "damping", whole, "actuator_damping", index)
        if hasattr(whole, "actuator_history"):
            drive.nsample, drive.interp = (int(value) for value in whole.actuator_history[index])
            drive.nsample *= parts
    return spec


def _put(element: Any, attribute: str, whole: Any, field: str, index: int) -> None:
    """Set an attribute to a row of the compiled model, where this release has both."""
    if not hasattr(element, attribute) or not hasattr(whole, field):
        return
    value = getattr(whole, field)[index]
    if isinstance(value, np.ndarray):
        getattr(element, attribute)[: len(value)] = value
        return
    kind = type(getattr(element, attribute))
    whole_number = issubclass(kind, int) or hasattr(kind, "__members__")
    setattr(element, attribute, kind(int(value)) if whole_number else value)


def _put_polynomial(element: Any, attribute: str, whole: Any, field: str, index: int) -> None:
    """Set a coefficient, and those of higher powers where there are any."""
    first = float(getattr(whole, field)[index])
    if np.ndim(getattr(element, attribute)) == 0:
        setattr(element, attribute, first)
    else:
        setattr(element, attribute, [first, *getattr(whole, field + "poly")[index]])


def _check_same(whole: Any, model: Any, prefix: str, index: list[int], places: Any) -> None:
    """Raise unless the rows of the small model are those of the file's."""
    for field in dir(whole):
        if not field.startswith(prefix) or field in PLACES:
            continue
        rows = getattr(whole, field)
        for i, j in zip(index, places, strict=True):
            if not np.array_equal(rows[i], getattr(model, field)[j]):
                raise JobError(
                    f"a model of this joint alone has another {field}: {getattr(model, field)[j]}, not {rows[i]}"
                )


def _set_options(given: Any, mine: Any, parts: int) -> None:
    """The file's time step, integrator and solver, without gravity, contacts, limits and media."""
    import mujoco

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


def answer(job: dict[str, Any], arrays: dict[str, Array]) -> tuple[dict[str, Any], dict[str, Array]]:
    """The answer and arrays of a job; what the engine says is an answer."""
    import mujoco

    said: dict[str, Any] = {"version": mujoco.__version__, "module": mujoco.__file__}
    try:
        if "parts" in job:
            said["errors"], out = responses(load_model(job["path"]), job["columns"], arrays, job["parts"])
            return said, out
        rig = Rig(load_model(job["path"], contacts=False), job["columns"])
        of = ("command", "q", "qd")
        return said, {n: held_torques(rig, *(arrays[f"{n}/{part}"] for part in of)) for n in job["motions"]}
    except Exception as err:  # whatever the engine says is the answer
        return {**said, "error": str(err) or repr(err)}, {}


if __name__ == "__main__":
    from standalone import serve  # type: ignore[import-not-found]

    serve(answer)
