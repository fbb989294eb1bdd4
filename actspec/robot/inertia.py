"""Mass matrices of a compiled model at its reference pose and over sampled poses.

Poses are a Latin hypercube, not a Sobol sequence: scipy takes longer to import than a whole
compile may, and its extremes over 256 poses agree with those of 4096 Sobol poses (see the test).
The ranks come from splitmix64, so the poses are the same in every version of numpy.

Joint coupling by equality constraints is ignored: a sampled pose need not satisfy them.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import TYPE_CHECKING

from actspec.robot.view import PoseInertia

if TYPE_CHECKING:
    import mujoco
    import numpy as np
    from numpy.typing import NDArray

    from actspec.robot.assets import MeshDependence

POSES = 256
"""Sampled poses beside the reference pose. Source: the design, §4."""

SEED = 20261121
"""Chosen: any fixed number."""

MOST_BYTES = 256 * 1024 * 1024
"""Chosen: fewer poses are taken where their matrices would need more memory than this."""
MOST_WORK = 4_000_000_000
"""Chosen: or where n_pose n^3 would be more, which is what it takes to invert them; 2 s."""


class InertiaUnknown(ValueError):
    """The mass matrices cannot be had; the text says why."""


def known_inertia(
    model: mujoco.MjModel, meshes: MeshDependence | None, poses: int
) -> tuple[PoseInertia | None, str]:
    """The inertia of a model, or why there is none.

    Args:
        model: Compiled.
        meshes: Bodies whose mass comes from mesh files; None: no such body.
        poses: Sampled poses beside the reference pose.
    """
    from actspec.robot.mjspec import quiet

    if meshes is not None and meshes.missing:
        return None, meshes.reason
    try:
        with quiet():
            return pose_inertia(model, poses), ""
    except InertiaUnknown as err:
        return None, str(err)


def pose_inertia(model: mujoco.MjModel, poses: int = POSES) -> PoseInertia:
    """Mass matrices without armature at the reference pose and at sampled poses.

    The reference pose is the first keyframe, else qpos0, where a joint that cannot be there is at the nearest end of
    its range. Sampled are hinges and slides, within their ranges; a hinge without a range over +-pi; a slide without
    one, balls and free joints stay at the reference. Tendon armature, which couples joints, counts as inertia here.

    Args:
        model: Compiled; its armature is set to 0 during the call and restored.
        poses: Sampled poses at most.

    Raises: InertiaUnknown: no matrix fits into `MOST_BYTES` and `MOST_WORK`, there is no memory for the model's
        state, or a matrix is not finite.
    """
    import numpy as np

    qpos = _poses(model, poses)
    total = model.dof_armature + _actuator_armature(model)
    with _without_armature(model, total):
        data = _state(model)
        flat = np.empty((len(qpos), len(data.M)))
        for row, _ in zip(flat, _massed(model, data, qpos), strict=True):
            row[:] = data.M
    if not np.isfinite(flat).all():
        raise InertiaUnknown("the mass matrix is not finite")
    return PoseInertia(dense(model, flat), total)


def _poses(model: mujoco.MjModel, poses: int) -> NDArray[np.float64]:
    """The reference pose and as many sampled ones as there are memory and time for, shape (n_pose, nq) [rad or m]."""
    import mujoco
    import numpy as np

    fit = min(MOST_BYTES // max(8 * model.nv**2, 1), MOST_WORK // max(model.nv**3, 1))
    if fit < 1:
        raise InertiaUnknown(f"{model.nv} degrees of freedom are too many for mass matrices")
    columns, low, high = _sampled(model)
    count = min(poses, fit - 1) if len(columns) else 0
    pose = reference_pose(model)
    if not model.nkey:
        held = model.jnt_limited.astype(bool) & (model.jnt_type >= int(mujoco.mjtJoint.mjJNT_SLIDE))
        at, ends = model.jnt_qposadr[held], model.jnt_range[held]
        pose[at] = np.clip(pose[at], ends[:, 0], ends[:, 1])
    qpos = np.tile(pose, (1 + count, 1))
    qpos[1:, columns] = low + (high - low) * latin_hypercube(count, len(columns), SEED)
    return qpos


@contextmanager
def _without_armature(model: mujoco.MjModel, total: NDArray[np.float64]) -> Iterator[None]:
    """Take the armature of joints and actuators, together `total`, off a model; restored at the end."""
    own, actuators, diagonal = model.dof_armature.copy(), model.actuator_armature.copy(), model.dof_M0.copy()
    try:
        model.dof_armature[:] = model.actuator_armature[:] = 0.0
        # For a body that moves on its own principal axes MuJoCo copies the diagonal from here.
        model.dof_M0[:] = diagonal - total
        yield
    finally:
        model.dof_armature[:] = own
        model.actuator_armature[:] = actuators
        model.dof_M0[:] = diagonal


def _state(model: mujoco.MjModel) -> mujoco.MjData:
    import mujoco

    try:
        return mujoco.MjData(model)
    except (mujoco.FatalError, MemoryError, ValueError) as err:
        raise InertiaUnknown("there is no memory for the model's state") from err


def _massed(model: mujoco.MjModel, data: mujoco.MjData, qpos: NDArray[np.float64]) -> Iterator[None]:
    """Put the mass matrix of one pose after the other into `data.M`."""
    import mujoco
    import numpy as np

    steps = [mujoco.mj_kinematics, mujoco.mj_comPos]
    coupled = bool(np.any(model.tendon_armature))
    steps += [mujoco.mj_tendon, mujoco.mj_makeM] if coupled else [mujoco.mj_crb]
    state = data.qpos
    for pose in qpos:
        state[:] = pose
        for step in steps:
            step(model, data)
        yield


def reference_pose(model: mujoco.MjModel) -> NDArray[np.float64]:
    """qpos of the first keyframe, else qpos0; shape (nq,) [rad or m]."""
    pose: NDArray[np.float64] = (model.key_qpos[0] if model.nkey else model.qpos0).copy()
    return pose


@lru_cache(maxsize=64)
def latin_hypercube(count: int, dimensions: int, seed: int) -> NDArray[np.float64]:
    """Points in the unit cube, each coordinate once in the middle of each of `count` cells.

    Args:
        count: Number of points.
        dimensions: Number of coordinates.
        seed: Of the splitmix64 sequence whose ranks are the cells.

    Returns: Shape (count, dimensions), in (0, 1); not to be changed.
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
    points.flags.writeable = False
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


def dense(model: mujoco.MjModel, flat: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lower triangles in MuJoCo's sparse rows to full matrices, shape (n_pose, nv, nv)."""
    import numpy as np

    nv = model.nv
    rows = np.repeat(np.arange(nv), model.M_rownnz)
    matrices = np.zeros((len(flat), nv, nv))
    matrices[:, rows, model.M_colind] = flat
    matrices[:, model.M_colind, rows] = flat
    return matrices
