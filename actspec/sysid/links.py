"""The rigid bodies along a measured path: inertia, gravity with all velocity terms, and its slope, from MuJoCo."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import RobotError, listed
from actspec.robot.view import ModelFormat, RobotView

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

NEAR = 1e-4
"""Change of a position for the slope [rad or m]."""
EVERY = 4
"""Rows between two at which the slope is taken, where nothing else is said. Chosen: it follows the pose."""


@dataclass(frozen=True, slots=True)
class Links:
    """The links at every row, the columns in the order of the joints; without armature.

    Attributes:
        inertia: Mass matrix of these joints, others held [kg*m^2, kg, kg*m], shape (n, n_joint, n_joint).
        load: What holds them against gravity, springs and velocity terms [N*m or N], shape (n, n_joint).
        slope: Of each load over its own joint's position [N*m/rad or N/m], likewise.
    """

    inertia: Array
    load: Array
    slope: Array


def links_along(
    robot: RobotView,
    joints: Sequence[str],
    q: Array,
    qd: Array,
    orientation: Sequence[float] | None,
    every: int = EVERY,
) -> Links:
    """The links of a robot on a stand, moved along a path; joints that are not named stand where `robot.pose`
    has them, else at the reference pose.

    Args:
        robot: Read from its file.
        joints: Hinges and slides.
        q: Positions [rad or m], shape (n, n_joint).
        qd: Speeds [rad/s or m/s], likewise.
        orientation: Quaternion w, x, y, z from the base to the world; None: as in the file.
        every: Rows between two at which the slope is taken; between them it is interpolated.

    Raises:
        RobotError: there is no model, or its masses are in meshes that are not there.
    """
    import numpy as np

    posed = _Posed(robot, joints, orientation)
    n = len(q)
    load = np.empty((n, len(joints)))
    flat = np.empty((n, len(posed.mass)))
    rows = sorted({*range(0, n, every), n - 1})
    slopes: list[list[float]] = []
    for row in range(n):
        load[row] = posed.load(q[row], qd[row])
        flat[row] = posed.mass
        if len(slopes) < len(rows) and row == rows[len(slopes)]:
            slopes.append([_slope(posed, q[row], qd[row], j) for j in range(len(joints))])
    slope = np.stack([np.interp(np.arange(n), rows, column) for column in zip(*slopes, strict=True)], axis=1)
    return Links(posed.dense(flat), load, slope)


def links_at(
    robot: RobotView, joints: Sequence[str], orientation: Sequence[float] | None
) -> Callable[[Array, Array], tuple[Array, Array]]:
    """The links as a function of positions and speeds, shape (n_joint,): mass matrix and loads; see `links_along`."""
    import numpy as np

    posed = _Posed(robot, joints, orientation)
    # Where each pair of joints stands in MuJoCo's rows; behind them a 0, for pairs of which neither carries the other.
    numbers = np.arange(1, len(posed.mass) + 1, dtype=float)
    entries = posed.dense(numbers[None])[0].astype(int) - 1
    flat = np.zeros(len(numbers) + 1)

    def at(q: Array, qd: Array) -> tuple[Array, Array]:
        load = posed.load(q, qd)
        flat[:-1] = posed.mass
        return flat[entries], load

    return at


def bench_model(
    robot: RobotView, joints: Sequence[str], orientation: Sequence[float] | None
) -> tuple[Any, Array]:
    """The compiled model on a stand, with nothing in it but links and springs, and the pose of other joints.

    Args:
        robot: Read from its file.
        joints: That must be in it.
        orientation: See `links_along`; gravity is turned in its place.

    Raises:
        RobotError: there is no model, or its masses are in meshes that are not there.
    """
    model = _model(robot, joints)
    pose = pose_of(robot, model)
    hold_base(model, pose, orientation)
    return model, pose


def pose_of(robot: RobotView, model: Any) -> Array:
    """Where a robot's joints and its base stand in a model of it: qpos, shape (nq,) [rad or m]."""
    import mujoco

    from actspec.robot.inertia import reference_pose

    pose = reference_pose(model)
    for name, position in robot.pose.items():
        pose[model.jnt_qposadr[mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)]] = position
    return pose


class _Posed:
    """The model, put to one state after the other."""

    def __init__(self, robot: RobotView, joints: Sequence[str], orientation: Sequence[float] | None) -> None:
        import mujoco
        import numpy as np

        self.model, pose = bench_model(robot, joints, orientation)
        self.data = mujoco.MjData(self.model)
        ids = [mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_JOINT, name) for name in joints]
        self.at, self.dof = self.model.jnt_qposadr[ids], self.model.jnt_dofadr[ids]
        self.data.qpos[:], self.data.qvel[:] = pose, 0.0
        self.force = np.zeros(self.model.nv)
        # Asked for once: each time MuJoCo makes an array of it.
        self.qpos, self.qvel, self.passive = self.data.qpos, self.data.qvel, self.data.qfrc_passive
        self.mass = self.data.M

    def load(self, q: Array, qd: Array) -> Array:
        """What holds the joints, with the mass matrix in `mass`."""
        import mujoco

        model, data = self.model, self.data
        self.qpos[self.at], self.qvel[self.dof] = q, qd
        for step in (mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_tendon, mujoco.mj_makeM):
            step(model, data)
        for step in (mujoco.mj_comVel, mujoco.mj_passive):
            step(model, data)
        mujoco.mj_rne(model, data, 0, self.force)
        found: Array = self.force[self.dof] - self.passive[self.dof]
        return found

    def dense(self, flat: Array) -> Array:
        """Mass matrices of these joints from MuJoCo's rows."""
        from actspec.robot.inertia import dense

        found: Array = dense(self.model, flat)[:, self.dof[:, None], self.dof[None, :]]
        return found


def _slope(posed: _Posed, q: Array, qd: Array, joint: int) -> float:
    """Of a joint's load over its position."""
    found = []
    for away in (NEAR, -NEAR):
        moved = q.copy()
        moved[joint] += away
        found.append(float(posed.load(moved, qd)[joint]))
    return (found[0] - found[1]) / (2.0 * NEAR)


def _model(robot: RobotView, joints: Sequence[str]) -> Any:
    """The compiled model, with nothing in it but links and springs."""
    import mujoco

    from actspec.robot.assets import need_meshes
    from actspec.robot.mjspec import compile_spec, open_spec, open_urdf

    if robot.format is ModelFormat.NONE:
        raise RobotError.of(
            "SYS001",
            "the spec names no model: link inertia and gravity are unknown",
            where="robot.model",
            help="name the robot's MJCF or URDF, or that of the bench",
        )
    if robot.format is ModelFormat.URDF:
        spec, files = open_urdf(robot.files)
    else:
        spec, files = open_spec(robot.files, format=robot.format, real_assets=True), robot.files
    need_meshes(spec)
    model = compile_spec(spec, files)
    lacking = [n for n in joints if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, n) < 0]
    if lacking:
        raise RobotError.of("SYS001", f"the model has no joint {listed(lacking)}", where="robot.model")
    model.dof_armature[:] = 0.0
    model.dof_damping[:] = 0.0
    model.dof_frictionloss[:] = 0.0
    if hasattr(model, "actuator_armature"):
        model.actuator_armature[:] = 0.0
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)
    return model


def hold_base(model: Any, pose: Array, orientation: Sequence[float] | None) -> None:
    """Turn gravity into a base that does not move; a free base is put upright first."""
    import mujoco
    import numpy as np

    free = model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE)
    for at in model.jnt_qposadr[free]:
        if orientation is not None:
            pose[at + 3 : at + 7] = (1.0, 0.0, 0.0, 0.0)
    if orientation is None:
        return
    turn = np.array(orientation, dtype=float)
    turn /= np.linalg.norm(turn)
    back, gravity = np.empty(4), np.empty(3)
    mujoco.mju_negQuat(back, turn)
    mujoco.mju_rotVecQuat(gravity, np.array(model.opt.gravity), back)
    model.opt.gravity[:] = gravity
