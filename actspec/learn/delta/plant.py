"""The compiled model between two rows of a policy's log: where the joints go under a command, and how it moves them.

One control period from the state of a row, for thousands of rows at once by `mujoco.rollout`. Filters and delay lines
of the drives begin each row as the logged commands before it left them.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from actspec.ir import ActuatorSet
from actspec.robot.mjspec import quiet
from actspec.robot.view import RobotView
from actspec.simulate.rollout import Rig
from actspec.sysid.links import hold_base, pose_of
from actspec.targets.mujoco.model import model_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Flags = NDArray[np.bool_]

HELD = 1e8
"""Armature of what does not move [kg*m^2 or kg]."""
CHUNK = 8192
"""Rollouts at a time. Chosen: their states take some 50 MB."""
THREADS = 8
"""Most threads."""
FAR = 10.0
"""Largest position [rad or m] and hundredth of a speed that counts; a rollout that goes further has diverged."""


@dataclass(frozen=True, slots=True)
class Motion:
    """What a log says of the robot at every row, in SI.

    Attributes:
        q: Positions as read [rad or m], shape (n, n_joint).
        qd: [rad/s or m/s], likewise.
        command: Sent at the row's time and held until the next [rad or m], likewise.
        first: Rows that follow no other: the first one, and those after a gap, shape (n,).
        free: Base position [m], quaternion w, x, y, z, linear velocity in the world [m/s] and angular velocity in the
            base's axes [rad/s], shape (n, 13); None: the base is held.
    """

    q: Array
    qd: Array
    command: Array
    first: Flags
    free: Array | None


class Plant:
    """A robot's model, for control periods.

    Args:
        actuators: The spec, resolved; all joints are commanded in position.
        robot: Its model, with the pose of joints that are not logged.
        held: Whether a base that is free in the model is held; contacts then do not act.
        orientation: Quaternion of a held base; None: as in the model.

    Raises:
        RobotError: the model cannot be compiled, or its masses are unknown.
        EmitError: the MuJoCo target does not take the spec.

    Attributes:
        free: Whether the base is free.
        held_free: Whether it would be, and is held.
        floor: Whether the world has anything that robots stand on.
        step: Control period [s].
    """

    def __init__(
        self,
        actuators: ActuatorSet,
        robot: RobotView,
        *,
        held: bool,
        orientation: Sequence[float] | None = None,
    ) -> None:
        import mujoco
        import numpy as np

        joints = actuators.joints
        self.bias = np.array([joint.encoder_bias.value or 0.0 for joint in joints])
        # Not every element of MuJoCo holds a bias; subtracted from command and reading, it is in all of them.
        unbiased = [
            replace(
                joint, encoder_bias=replace(joint.encoder_bias, value=0.0 * (joint.encoder_bias.value or 0))
            )
            for joint in joints
        ]
        self.model = model = model_of(replace(actuators, joints=tuple(unbiased), delta_action=None), robot)
        self.parts = actuators.decimation or 1
        self.step = self.parts * float(model.opt.timestep)
        free = model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE)
        self.free, self.held_free = bool(free.any()) and not held, bool(free.any()) and held
        world = (model.geom_bodyid == 0) & ((model.geom_contype != 0) | (model.geom_conaffinity != 0))
        self.floor = bool(world.any())
        self.base_q = int(model.jnt_qposadr[free][0]) if self.free else -1
        self.base_v = int(model.jnt_dofadr[free][0]) if self.free else -1
        moving = {int(model.jnt_dofadr[model.joint(joint.joint).id]) for joint in joints}
        if self.free:
            moving |= set(range(self.base_v, self.base_v + 6))
        else:
            model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT) * self.held_free
        if not model.neq:
            # What is neither logged nor the base stays where it is.
            model.dof_armature[[dof for dof in range(model.nv) if dof not in moving]] = HELD
        self.pose = pose_of(robot, model)
        if not self.free:
            hold_base(model, self.pose, orientation)
        self.rig = Rig(model, [joint.joint for joint in joints])
        self.controls = np.zeros(model.nu)
        if model.nkey:
            self.controls[:] = model.key_ctrl[0]
        kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
        self._kind = kind
        self._size = mujoco.mj_stateSize(model, kind)
        at = 1
        self._q = at + self.rig.qpos
        self._v = at + model.nq + self.rig.qvel
        self._base = np.array([], dtype=int)
        if self.free:
            first = at + model.nq + self.base_v
            self._base = np.array([*range(at + self.base_q, at + self.base_q + 7), *range(first, first + 6)])
        self._threads: list[Any] = []

    def states(self, motion: Motion) -> Array:
        """The simulator's state at each row of a log, shape (n, n_state)."""
        import mujoco
        import numpy as np

        model, rig = self.model, self.rig
        rig.reset()
        rig.qpos0, rig.qvel0 = self.pose, 0.0 * rig.qvel0
        n = len(motion.q)
        out = np.empty((n, self._size))
        remembers = bool(model.na) or bool(np.any(getattr(model, "actuator_history", np.zeros(1))))
        with quiet():
            for k in range(n if remembers else 1):
                ctrl = motion.command[k] - self.bias
                rig.data.ctrl[:] = self.controls
                if motion.first[k]:
                    rig.place(motion.q[k] - self.bias, motion.qd[k], ctrl)
                    rig.settle(ctrl)
                rig.place(motion.q[k] - self.bias, motion.qd[k], ctrl)
                if motion.free is not None and self.free:
                    self._place_base(motion.free[k])
                mujoco.mj_getState(model, rig.data, out[k], self._kind)
                if remembers:
                    rig.step(self.parts)
        if not remembers:
            out[1:] = out[0]
            out[:, 0] = 0.0
        out[:, self._q], out[:, self._v] = motion.q - self.bias, motion.qd
        if motion.free is not None and self.free:
            out[:, self._base] = motion.free
        return out

    def _place_base(self, row: Array) -> None:
        data = self.rig.data
        data.qpos[self.base_q : self.base_q + 7] = row[:7]
        data.qvel[self.base_v : self.base_v + 6] = row[7:]

    def advance(self, states: Array, command: Array) -> Array:
        """States a control period later; NaN where the simulation diverged.

        Args:
            states: Shape (n, n_state).
            command: As a log has it [rad or m], shape (n, n_joint).
        """
        import mujoco
        import numpy as np
        from mujoco import rollout

        if not self._threads:
            count = min(os.cpu_count() or 1, THREADS)
            self._threads = [mujoco.MjData(self.model) for _ in range(count)]
        out = np.empty_like(states)
        with quiet():
            for begin in range(0, len(states), CHUNK):
                part = slice(begin, begin + CHUNK)
                ctrl = np.tile(self.controls, (len(command[part]), 1))
                ctrl[:, self.rig.ctrl] = command[part] - self.bias
                found, _ = rollout.rollout(
                    self.model,
                    self._threads,
                    np.ascontiguousarray(states[part]),
                    np.repeat(ctrl[:, None], self.parts, axis=1),
                    persistent_pool=True,
                )
                out[part] = found[:, -1]
        q, qd = self.read(out)
        wild = ~((np.abs(q) < FAR).all(axis=1) & (np.abs(qd) < 100.0 * FAR).all(axis=1))
        out[wild | (out[:, 0] <= states[:, 0])] = np.nan
        return out

    def read(self, states: Array) -> tuple[Array, Array]:
        """Positions as the encoders read them, and speeds, shapes (n, n_joint)."""
        return states[:, self._q] + self.bias, states[:, self._v]

    def base(self, states: Array) -> Array:
        """As `Motion.free`, shape (n, 13)."""
        found: Array = states[:, self._base]
        return found
