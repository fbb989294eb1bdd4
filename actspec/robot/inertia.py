"""Mass matrices of a compiled model at its reference pose and over sampled poses.

Poses are a Latin hypercube, not a Sobol sequence: scipy takes longer to import than a whole
compile may, and its extremes over 256 poses agree with those of 4096 Sobol poses (see the test).
The ranks come from splitmix64, so the poses are the same in every version of numpy.

Joint coupling by equality constraints is ignored: a sampled pose need not satisfy them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from actspec.robot.view import PoseInertia

if TYPE_CHECKING:
    import mujoco
    import numpy as np
    from numpy.typing import NDArray

POSES = 256
"""Sampled poses beside the reference pose. Source: the design, §4."""

SEED = 20261121
"""Chosen: any fixed number."""

MOST_BYTES = 256 * 1024 * 1024
"""Chosen: fewer poses are taken where their matrices would need more memory than this."""


class InertiaUnknown(ValueError):
    """The mass matrices cannot be had; the text says why."""


def pose_inertia(model: mujoco.MjModel, poses: int = POSES) -> PoseInertia:
    """Mass matrices without armature at the reference pose and at sampled poses.

    The reference pose is the first keyframe, else qpos0. Sampled are hinges and slides, within
    their ranges; a hinge without a range over +-pi; a slide without one, balls and free joints
    stay at the reference. Tendon armature, which couples joints, counts as inertia here.

    Args:
        model: Compiled; its armature is set to 0 during the call and restored.
        poses: Sampled poses at most.

    Raises: InertiaUnknown: no matrix fits into `MOST_BYTES`, there is no memory for the model's
        state, or a matrix is not finite.
    """
    import mujoco
    import numpy as np

    nv = model.nv
    fit = MOST_BYTES // max(8 * nv * nv, 1)
    if fit < 1:
        raise InertiaUnknown(f"{nv} degrees of freedom are too many for mass matrices in memory")
    columns, low, high = _sampled(model)
    count = min(poses, fit - 1) if len(columns) else 0
    qpos = np.tile(reference_pose(model), (1 + count, 1))
    qpos[1:, columns] = low + (high - low) * latin_hypercube(count, len(columns), SEED)

    try:
        data = mujoco.MjData(model)
    except (mujoco.FatalError, MemoryError, ValueError) as err:
        raise InertiaUnknown("there is no memory for the model's state") from err
    joint_armature = model.dof_armature.copy()
    actuator_armature = model.actuator_armature.copy()
    diagonal = model.dof_M0.copy()
    total = joint_armature + _actuator_armature(model)
    coupled = bool(np.any(model.tendon_armature))
    flat = np.empty((1 + count, len(data.M)))
    try:
        model.dof_armature[:] = 0.0
        model.actuator_armature[:] = 0.0
        # For a body that moves on its own principal axes MuJoCo copies the diagonal from here.
        model.dof_M0[:] = diagonal - total
        for row, pose in zip(flat, qpos, strict=True):
            data.qpos[:] = pose
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            if coupled:
                mujoco.mj_tendon(model, data)
                mujoco.mj_makeM(model, data)
            else:
                mujoco.mj_crb(model, data)
            row[:] = data.M
    finally:
        model.dof_armature[:] = joint_armature
        model.actuator_armature[:] = actuator_armature
        model.dof_M0[:] = diagonal
    if not np.isfinite(flat).all():
        raise InertiaUnknown("the mass matrix is not finite")
    return PoseInertia(_dense(model, flat), total)


def reference_pose(model: mujoco.MjModel) -> NDArray[np.float64]:
    """qpos of the first keyframe, else qpos0; shape (nq,) [rad or m]."""
    pose: NDArray[np.float64] = (model.key_qpos[0] if model.nkey else model.qpos0).copy()
    return pose


def latin_hypercube(count: int, dimensions: int, seed: int) -> NDArray[np.float64]:
    """Points in the unit cube, each coordinate once in the middle of each of `count` cells.

    Args:
        count: Number of points.
        dimensions: Number of coordinates.
        seed: Of the splitmix64 sequence whose ranks are the cells.

    Returns: Shape (count, dimensions), in (0, 1).
    Source: splitmix64, Steele, Lea, Flood, "Fast splittable pseudorandom number generators", 2014.
    """
    import numpy as np

    # Unsigned arithmetic wraps, which is what the generator asks for.
    state = np.arange(1, count * dimensions + 1, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    state += np.uint64(seed)
    state = (state ^ (state >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    state = (state ^ (state >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    state ^= state >> np.uint64(31)
    drawn = state.reshape(count, dimensions)
    ranks = np.argsort(np.argsort(drawn, axis=0, kind="stable"), axis=0, kind="stable")
    points: NDArray[np.float64] = (ranks + 0.5) / max(count, 1)
    return points


def _sampled(
    model: mujoco.MjModel,
) -> tuple[NDArray[np.intp], NDArray[np.float64], NDArray[np.float64]]:
    """Columns of qpos that are sampled, with their ends [rad or m]."""
    import mujoco
    import numpy as np

    limited = model.jnt_limited.astype(bool)
    hinge = model.jnt_type == int(mujoco.mjtJoint.mjJNT_HINGE)
    slide = model.jnt_type == int(mujoco.mjtJoint.mjJNT_SLIDE)
    chosen = np.flatnonzero(hinge | (slide & limited))
    low = np.where(limited[chosen], model.jnt_range[chosen, 0], -np.pi)
    high = np.where(limited[chosen], model.jnt_range[chosen, 1], np.pi)
    return model.jnt_qposadr[chosen].astype(np.intp), low, high


def _actuator_armature(model: mujoco.MjModel) -> NDArray[np.float64]:
    """Armature that actuators add to the joints that they drive, gear^2 included; shape (nv,)."""
    import mujoco
    import numpy as np

    added = np.zeros(model.nv)
    direct = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
    scalar = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
    for actuator in np.flatnonzero(model.actuator_armature):
        joint = model.actuator_trnid[actuator, 0]
        if model.actuator_trntype[actuator] in direct and model.jnt_type[joint] in scalar:
            gear = model.actuator_gear[actuator, 0]
            added[model.jnt_dofadr[joint]] += gear**2 * model.actuator_armature[actuator]
    return added


def _dense(model: mujoco.MjModel, flat: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lower triangles in MuJoCo's sparse rows to full matrices, shape (n_pose, nv, nv)."""
    import numpy as np

    nv = model.nv
    rows = np.repeat(np.arange(nv), model.M_rownnz)
    matrices = np.zeros((len(flat), nv, nv))
    matrices[:, rows, model.M_colind] = flat
    matrices[:, model.M_colind, rows] = flat
    return matrices
