"""Inverse dynamics of a robot whose base flew free, and when it was in contact: then its motion tells no torque."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from actspec.diagnostics import Span, listed
from actspec.learn.spline import spline, stiffness
from actspec.logs import Log, LogError
from actspec.robot.view import RobotView
from actspec.sysid.links import bench_model

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

NEEDED = ("orientation", "linear_velocity", "angular_velocity")
"""What a log must tell of the base; where it is does not matter."""
CARRIED = 0.2
"""Share of the weight that something else must carry for a contact. Chosen: noise of accelerations is below."""
AROUND = 0.02
"""Time around a contact whose accelerations a spline draws into it [s]. Chosen."""


def floating(
    robot: RobotView, names: Sequence[str], log: Log, time: Array, q: Array, qd: Array, qdd: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """What the links need at the joints, and where something else than the joints acted.

    Args:
        robot: The model.
        names: Joints; others stay at the reference pose.
        log: With the base's motion.
        time: Of the rows [s], shape (n,).
        q: Positions [rad or m], shape (n, n_joint).
        qd: Speeds, likewise.
        qdd: Accelerations, likewise.

    Returns:
        Torque without armature and friction [N*m or N], shape (n, n_joint), and rows in contact, shape (n,).

    Raises:
        LogError: a column of the base is missing, or the model's base is not free.
    """
    import mujoco
    import numpy as np

    assert log.base is not None
    missing = [f"base.{name}" for name in NEEDED if getattr(log.base, name) is None]
    if missing:
        message = f"the log tells how the base moved, without {listed(missing)}"
        raise LogError.of("LRN024", message, Span(log.path, 1), help="log them, or hang the robot up")
    model, pose = bench_model(robot, names, None)
    (free,) = np.nonzero(model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE))
    if len(free) != 1:
        message = "the log tells how the base moved, and the model's base is fixed"
        raise LogError.of("LRN024", message, Span(log.path, 1), help="--base fixed leaves those columns out")
    at, dof = int(model.jnt_qposadr[free[0]]), int(model.jnt_dofadr[free[0]])
    ids = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name) for name in names]
    joint_at, joint_dof = model.jnt_qposadr[ids], model.jnt_dofadr[ids]
    turn, linear, angular = (np.asarray(getattr(log.base, name)) for name in NEEDED)
    # q and -q are one orientation.
    signs = np.cumprod(np.where(np.sum(turn[1:] * turn[:-1], axis=1) < 0.0, -1.0, 1.0))
    turn = turn * np.concatenate([[1.0], signs])[:, None]
    turn = np.stack([np.interp(time, log.time, column) for column in turn.T], axis=1)
    courses = [
        spline(log.time, column, stiffness(log.time, column))
        for column in np.concatenate([linear, angular], axis=1).T
    ]
    speed = np.stack([course(time) for course in courses], axis=1)
    rate = np.stack([course.derivative()(time) for course in courses], axis=1)
    data = mujoco.MjData(model)
    data.qpos[:] = pose
    torque, carried = np.empty_like(q), np.empty(len(time))
    for k in range(len(time)):
        data.qpos[at + 3 : at + 7] = turn[k] / np.linalg.norm(turn[k])
        data.qpos[joint_at], data.qvel[joint_dof], data.qacc[joint_dof] = q[k], qd[k], qdd[k]
        data.qvel[dof : dof + 6], data.qacc[dof : dof + 6] = speed[k], rate[k]
        mujoco.mj_inverse(model, data)
        torque[k] = data.qfrc_inverse[joint_dof]
        carried[k] = np.linalg.norm(data.qfrc_inverse[dof : dof + 3])
    weight = float(model.body_mass.sum()) * float(np.linalg.norm(model.opt.gravity))
    touching = carried > CARRIED * weight
    near = np.searchsorted(time[touching], [time - AROUND, time + AROUND + 1e-9])
    return torque, near[1] > near[0]
