"""Networks in plain MuJoCo: `data.ctrl` is the position command, the network's torque the actuator's force.

    attached = attach(model, "build/a1/mujoco")     # or with attach(...):
    data.ctrl[:] = targets; mujoco.mj_step(model, data)

The actuators get gain 0 and a user bias, in memory alone; MuJoCo asks for the bias once an evaluation of the forces.
History is that of each MjData: a sample is kept when its time moves on, and time that jumps is a reset. mj_forward
between steps, several MjData and the threads of mujoco.rollout are right; an integrator that evaluates the forces more
than once a step is refused.
"""

from __future__ import annotations

import math
import os
import sys
import threading
from typing import TYPE_CHECKING, Any

from actspec.learn.bundle import Bundle, DrivenGroup, RuntimeFault, read_bundle

if TYPE_CHECKING:
    import mujoco
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MOST_DATA = 4096
"""Most MjData whose history is kept; the oldest goes first."""
MARK = 0.2968617
"""Stands in what MuJoCo does not read of a user bias, so that a copy of the model is known. Chosen: no model has it."""


def attach(
    model: mujoco.MjModel, folder: str | os.PathLike[str], *, watch: bool = False, double: bool = False
) -> Attached:
    """Let networks drive the joints of a model, until `detach()` or the end of a `with` block.

    Args:
        model: Compiled from the folder's file, or one that includes it; it is changed in memory.
        folder: That `actspec compile` wrote for MuJoCo.
        watch: Whether steps outside of the networks' training data are counted.
        double: Whether a perceptron is computed in double precision, for derivatives by differences; else in single,
            as simulators do.

    Raises:
        RuntimeFault: the model has no such actuators, another time step or integrator, or is attached already.
    """
    return Attached(model, read_bundle(folder), watch=watch, double=double)


class Attached:
    """Networks on a model; see `attach`."""

    def __init__(
        self, model: mujoco.MjModel, bundle: Bundle, *, watch: bool = False, double: bool = False
    ) -> None:
        import mujoco

        _check(model, bundle)
        self.joints: tuple[str, ...] = tuple(j.joint for g in bundle.groups for j in g.joints)
        """Names of the joints that networks drive."""
        self._model: Any = model
        self._groups = [_Group(model, group, watch, double) for group in bundle.groups]
        self.owner = {int(i): (group, k) for group in self._groups for k, i in enumerate(group.actuators)}
        ids = sorted(self.owner)
        self._ids = ids
        self._before = [
            (name, getattr(model, name)[ids].copy())
            for name in (
                "actuator_gainprm",
                "actuator_biasprm",
                "actuator_biastype",
                "actuator_gaintype",
                "actuator_ctrllimited",
            )
        ]
        model.actuator_gaintype[ids] = int(mujoco.mjtGain.mjGAIN_FIXED)
        model.actuator_gainprm[ids] = 0.0
        model.actuator_biastype[ids] = int(mujoco.mjtBias.mjBIAS_USER)
        model.actuator_biasprm[ids] = MARK
        model.actuator_ctrllimited[ids] = False
        _register(self)

    @property
    def outside(self) -> int:
        """With `watch`: samples, one a joint and step, outside of what the networks were trained on."""
        return sum(group.outside for group in self._groups)

    def __enter__(self) -> Attached:
        return self

    def __exit__(self, *_: object) -> None:
        self.detach()

    def detach(self) -> None:
        """Give the model its own actuators back; to be called once."""
        if self._model is None:
            return
        for name, values in self._before:
            getattr(self._model, name)[self._ids] = values
        _unregister(self)
        self._model = None


def _check_steps(model: Any, step: float) -> None:
    """Samples are as far apart as the network's: one a step, of its length."""
    import mujoco

    if model.opt.integrator == int(mujoco.mjtIntegrator.mjINT_RK4):
        help = (
            "implicitfast takes joint damping and Coriolis forces as well; a network is sampled once a step"
        )
        raise RuntimeFault.of("LRN043", "RK4 evaluates forces four times a step, a network once", help=help)
    if not math.isclose(model.opt.timestep, step, rel_tol=1e-6):
        message = f"the model's time step is {model.opt.timestep:g} s, the networks' {step:g} s"
        raise RuntimeFault.of("LRN043", message, help="compile the spec with that timing.physics_dt")


def _check(model: Any, bundle: Bundle) -> None:
    import mujoco

    _check_steps(model, bundle.physics_dt)
    named = [joint.actuator for group in bundle.groups for joint in group.joints]
    missing = [n for n in named if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, n) < 0]
    if missing:
        message = f"the model has no actuator {', '.join(missing[:5])}"
        raise RuntimeFault.of("LRN043", message, help="it is not the model that compile wrote")


class _Group:
    """One network's joints on a model."""

    def __init__(self, model: Any, group: DrivenGroup, watch: bool, double: bool) -> None:
        import mujoco
        import numpy as np

        self.group, self.watch, self.outside = group, watch, 0
        self.actuators = np.array(
            [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, j.actuator) for j in group.joints]
        )
        address = getattr(model, "actuator_ctrladr", None)
        self.controls = self.actuators if address is None else np.array(address)[self.actuators]
        self.joints = model.actuator_trnid[self.actuators, 0]
        gear = model.actuator_gear[self.actuators, 0].copy()
        self.gear = None if (gear == 1.0).all() else gear
        bias = np.array([joint.encoder_bias for joint in group.joints])
        self.bias = bias if bias.any() else None
        self.double = double
        self.qpos, self.qvel = model.jnt_qposadr[self.joints], model.jnt_dofadr[self.joints]
        self.model, self.step = model, float(model.opt.timestep)
        self.count = len(self.actuators)
        self.ranks: list[int] = self.actuators.tolist()
        self.histories: dict[int, _History] = {}
        self.lock = threading.Lock()

    def torque(self, data: Any, k: int) -> float:
        """Force of the k-th actuator [N*m or N]; all are computed at the first of an evaluation."""
        history = self.histories.get(data._address)
        if history is None:
            history = self._fresh(data._address)
        # MuJoCo asks in the order of the actuators, and leaves out those that are switched off.
        rank = self.ranks[k]
        if rank <= history.last:
            history.evaluate(data)
            if self.watch and history.moved:
                self.outside += history.outside()
        history.last = rank
        return history.force[k]

    def _fresh(self, address: int) -> _History:
        with self.lock:
            while len(self.histories) >= MOST_DATA:
                self.histories.pop(next(iter(self.histories)))
            return self.histories.setdefault(address, _History(self))


class _History:
    """Samples and scratch of one MjData."""

    def __init__(self, owner: _Group) -> None:
        import numpy as np

        from actspec.learn.batch import Clamp
        from actspec.learn.kernel import numpy_forward

        law, n = owner.group.law, owner.count
        self.owner, self.law = owner, law
        # Both inputs in the network's order, so that one look-up finds the samples of both.
        self.past = np.zeros((2, owner.group.reach + 1, n))
        self.one, self.two = (1, 0) if law.velocity_first else (0, 1)
        length = owner.group.reach + 1
        # Where the samples are, by where the newest one is.
        self.rows = (np.arange(length)[:, None] - np.array(law.taps)) % length
        self.at, self.time, self.moved, self.begun = 0, math.nan, False, True
        self.last = 1 << 30
        self.force: list[float] = [0.0] * n
        scales = (law.position_scale, law.velocity_scale)
        self.scale = None if scales == (1.0, 1.0) else np.array(scales)[[self.one, self.two], None]
        dtype = np.float64 if owner.double or law.layers.recurrent else np.float32
        self.inputs = np.empty((n, law.inputs), dtype)
        self.by_tap = self.inputs.reshape(n, 2, len(law.taps))
        self.clamp = Clamp.of(owner.group, lambda value: np.asarray(value, dtype=float))
        self.forward = None if law.layers.recurrent else numpy_forward(law.layers, dtype)
        self.memory: tuple[Array, Array] | None = None
        self.kept: tuple[Array, Array] | None = None

    def evaluate(self, data: Any) -> None:
        """Torques at the data's state; a sample of the same time takes the place of the last."""
        import numpy as np

        owner, law, past = self.owner, self.law, self.past
        time, qd = data.time, data.qvel[owner.qvel]
        error = data.ctrl[owner.controls] - data.qpos[owner.qpos]
        if owner.bias is not None:
            error -= owner.bias
        self.moved = time != self.time
        if self.moved:
            self.begun = not abs(time - self.time - owner.step) <= 1e-3 * owner.step
            if self.begun:
                # Another integrator or step, set since, shows as a jump of time.
                _check_steps(owner.model, owner.step)
                past[:] = 0.0
                self.memory = None
            else:
                self.at = (self.at + 1) % past.shape[1]
            self.kept, self.time = self.memory, time
        rows: Any = slice(None) if self.begun and law.backfill else self.at
        past[self.one, rows], past[self.two, rows] = error, qd
        samples = past.take(self.rows[self.at], axis=1).transpose(2, 0, 1)
        self.by_tap[...] = samples if self.scale is None else samples * self.scale
        if self.forward is not None:
            out = self.forward(self.inputs)
        else:
            value, self.memory = law.layers(self.inputs, self.kept)
            out = value[..., 0]
        if law.torque_scale != 1.0:
            out = out * law.torque_scale
        tau = self.clamp(np, out[None], qd[None])[0]
        # The actuator multiplies its force by the gear on the way to the joint.
        self.force = (tau if owner.gear is None else tau / owner.gear).tolist()

    def outside(self) -> int:
        """Joints of this sample beyond the training data."""
        import numpy as np

        ends = self.owner.group.range
        if ends is None:
            return 0
        beyond = np.zeros(self.owner.count, dtype=bool)
        for (low, high), which in zip(ends, (self.one, self.two), strict=True):
            now = self.past[which, self.at]
            beyond |= (now < low) | (now > high)
        return int(beyond.sum())


_ATTACHED: dict[int, Attached] = {}
"""By the address of the model; the callback is one for all of MuJoCo."""
_OTHER: Any = None


def _register(attached: Attached) -> None:
    import mujoco

    global _OTHER
    address = attached._model._address
    if address in _ATTACHED:
        raise RuntimeFault.of("LRN043", "networks are attached to this model already")
    if not _ATTACHED:
        _OTHER = mujoco.get_mjcb_act_bias()
        mujoco.set_mjcb_act_bias(_callback)
    _ATTACHED[address] = attached


def _unregister(attached: Attached) -> None:
    import mujoco

    global _OTHER
    _ATTACHED.pop(attached._model._address, None)
    if not _ATTACHED:
        mujoco.set_mjcb_act_bias(_OTHER)
        _OTHER = None


def _callback(model: Any, data: Any, actuator: int) -> float:
    attached = _ATTACHED.get(model._address)
    found = None if attached is None else attached.owner.get(actuator)
    try:
        if found is not None:
            return found[0].torque(data, found[1])
        if attached is None and model.actuator_biasprm[actuator, 0] == MARK:
            message = "the model is a copy of one that networks are attached to, and no network drives it"
            raise RuntimeFault.of("LRN043", message, help="attach to the copy, or copy before you attach")
    except RuntimeFault as err:
        if threading.current_thread() is not threading.main_thread():
            # MuJoCo ends the process there, and says no more than that Python raised something.
            print(err, file=sys.stderr, flush=True)
        raise
    return float(_OTHER(model, data, actuator)) if _OTHER is not None else 0.0
