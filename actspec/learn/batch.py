"""Networks of many environments at once: history, forward pass and clamp, once a physics step."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from actspec.laws.arrays import array_namespace
from actspec.laws.network import Layers
from actspec.learn.bundle import Bundle, DrivenGroup, RuntimeFault, read_bundle
from actspec.learn.kernel import numpy_forward, recurrent_forward, torch_forward


def networks(folder: str | os.PathLike[str], envs: int = 1, *, watch: bool = False) -> Networks:
    """The networks of a robot, for many environments.

    Args:
        folder: That `actspec compile` wrote for MuJoCo.
        envs: Number of environments.
        watch: Whether steps outside of the networks' training data are counted.

    Raises:
        RuntimeFault: the folder has no networks, or one cannot be read.
    """
    if envs < 1:
        raise RuntimeFault.of("LRN042", f"envs must be at least 1, got {envs}")
    return Networks(read_bundle(folder), envs, watch=watch)


class Networks:
    """Torques of all joints that networks drive.

    Arrays are (envs, joints), in the order of `joints`; numpy in, numpy out, torch in, torch out on its device. The
    first call after a reset fills the history, with its own sample or with zeros as the manifest says.
    """

    def __init__(self, bundle: Bundle, envs: int, *, watch: bool = False) -> None:
        self._groups = bundle.groups
        self.joints: tuple[str, ...] = tuple(j.joint for g in bundle.groups for j in g.joints)
        """Names of the joints, in the order of the arrays' columns."""
        self.envs = envs
        """Number of environments."""
        self.outside = 0
        """With `watch`: samples, one a joint, environment and step, outside of what the networks were trained on."""
        self._watch = watch
        self._state: list[_State] | None = None

    def torque(self, command: Any, q: Any, qd: Any) -> Any:
        """Torque of the drives in this physics step, clamped [N*m or N]; to be called once a step.

        Args:
            command: Position commands [rad or m], shape (envs, joints).
            q: True positions [rad or m], likewise.
            qd: Speeds [rad/s or m/s], likewise.

        Raises:
            RuntimeFault: an array has another shape.
        """
        shape = (self.envs, len(self.joints))
        for name, array in (("command", command), ("q", q), ("qd", qd)):
            if tuple(array.shape) != shape:
                message = (
                    f"{name} has the shape {tuple(array.shape)}, and {shape} are environments and joints"
                )
                raise RuntimeFault.of("LRN042", message)
        if self._state is None or not self._state[0].fits(q):
            self._state = [_State.of(group, self.envs, q) for group in self._groups]
        xp = array_namespace(q)
        found, first = [], 0
        for state in self._state:
            columns = slice(first, first + len(state.group.joints))
            first = columns.stop
            found.append(state.step(command[:, columns], q[:, columns], qd[:, columns]))
            if self._watch:
                self.outside += state.outside()
        return found[0] if len(found) == 1 else xp.concatenate(found, axis=1)

    def reset(self, envs: Any = None) -> None:
        """Forget the history of some environments, by index or mask; None: of all."""
        for state in self._state or ():
            state.reset(envs)


@dataclass(slots=True)
class _State:
    """History of one network's joints, and its arithmetic in one library."""

    group: DrivenGroup
    xp: Any
    like: Any
    errors: Any
    speeds: Any
    at: int
    fresh: Any
    fresh_any: bool
    inputs: Any
    forward: Any
    clamp: Clamp
    bias: Any
    recurrent: Any = None
    memory: Any = field(default=None)

    @classmethod
    def of(cls, group: DrivenGroup, envs: int, like: Any) -> _State:
        xp = array_namespace(like)
        law, n = group.law, len(group.joints)
        torch = xp.__name__ == "torch"

        def array(value: Any) -> Any:
            if torch:
                return xp.as_tensor(value, dtype=like.dtype, device=like.device)
            return xp.asarray(value, dtype=like.dtype)

        zero = array([[0.0] * n] * envs)
        length = group.reach + 1
        recurrent = memory = forward = None
        if law.layers.recurrent:
            recurrent, (depth, hidden) = recurrent_forward(law.layers, like)
            memory = [
                xp.stack([xp.stack([zero[..., None] * array([0.0] * hidden)] * depth)])[0] for _ in range(2)
            ]
        elif torch:
            forward = torch_forward(law.layers, like.dtype, like.device)
        else:
            forward = _by_torch(law.layers, like.dtype) or numpy_forward(law.layers, like.dtype)
        fresh = xp.ones_like(zero[:, 0]) > 0.0
        return cls(
            group,
            xp,
            zero,
            xp.stack([zero] * length),
            xp.stack([zero] * length),
            0,
            fresh,
            True,
            xp.stack([zero] * law.inputs, -1),
            forward,
            Clamp.of(group, array),
            array([joint.encoder_bias for joint in group.joints]),
            recurrent,
            memory,
        )

    def fits(self, q: Any) -> bool:
        """Whether the arrays are of this library, type and device."""
        same = type(q) is type(self.like) and q.dtype == self.like.dtype
        return same and getattr(q, "device", None) == getattr(self.like, "device", None)

    def reset(self, envs: Any) -> None:
        """Of some environments."""
        if envs is None:
            self.fresh[:] = True
        else:
            self.fresh[envs] = True
        self.fresh_any = True

    def step(self, command: Any, q: Any, qd: Any) -> Any:
        """Torque of this step."""
        law, length = self.group.law, len(self.errors)
        self.at = (self.at + 1) % length
        error = command - q - self.bias
        if self.fresh_any:
            self._begin(error, qd)
        self.errors[self.at], self.speeds[self.at] = error, qd
        blocks = ((self.errors, law.position_scale), (self.speeds, law.velocity_scale))
        k = 0
        for past, scale in blocks[::-1] if law.velocity_first else blocks:
            for tap in law.taps:
                sample = past[(self.at - tap) % length]
                self.inputs[..., k] = sample if scale == 1.0 else sample * scale
                k += 1
        if self.recurrent is None:
            out = self.forward(self.inputs.reshape(-1, law.inputs)).reshape(error.shape)
        else:
            value, self.memory = self.recurrent(self.inputs, (self.memory[0], self.memory[1]))
            out = value[..., 0]
        if law.torque_scale != 1.0:
            out = out * law.torque_scale
        return self.clamp(self.xp, out, qd)

    def _begin(self, error: Any, qd: Any) -> None:
        """Fill the history of environments that were reset."""
        backfill = self.group.law.backfill
        self.errors[:, self.fresh] = error[self.fresh][None] if backfill else 0.0
        self.speeds[:, self.fresh] = qd[self.fresh][None] if backfill else 0.0
        if self.memory is not None:
            for part in self.memory:
                part[:, self.fresh] = 0.0
        self.fresh[:] = False
        self.fresh_any = False

    def outside(self) -> int:
        """Samples of this step beyond the training data."""
        if self.group.range is None:
            return 0
        xp = self.xp
        beyond = None
        for (low, high), past in zip(self.group.range, (self.errors, self.speeds), strict=True):
            now = past[self.at]
            here = (now < low) | (now > high)
            beyond = here if beyond is None else beyond | here
        return int(xp.sum(beyond))


def _by_torch(layers: Layers, dtype: Any) -> Callable[[Any], Any] | None:
    """Of numpy's arrays by torch's kernels, on the same memory: several times as fast; None without torch."""
    try:
        import torch
    except ImportError:
        return None
    name = str(dtype)
    if name not in ("float32", "float64"):
        return None
    forward = torch_forward(layers, getattr(torch, name), "cpu")
    return lambda x: forward(torch.from_numpy(x)).numpy()


@dataclass(frozen=True, slots=True)
class Clamp:
    """Limits and torque-speed lines of the joints, an array each."""

    limit: Any
    stall: Any
    slope: Any
    fastest: Any
    lined: bool
    limited: bool
    curved: Sequence[tuple[int, tuple[float, float, float, float], float]]

    @classmethod
    def of(cls, group: DrivenGroup, array: Any) -> Clamp:
        joints = group.joints
        limits = [joint.effort_limit for joint in joints]
        lines = [joint.line if joint.curve is None else None for joint in joints]
        # A joint without a line has one that never acts.
        stalls = [1e12 if line is None else line[0] for line in lines]
        speeds = [1e12 if line is None else line[1] for line in lines]
        fastest = [
            speed * (1.0 + (limit / stall if math.isfinite(limit) else 1e6))
            for speed, stall, limit in zip(speeds, stalls, limits, strict=True)
        ]
        curved = [(i, j.curve, j.effort_limit) for i, j in enumerate(joints) if j.curve is not None]
        return cls(
            array(limits),
            array(stalls),
            array([stall / speed for stall, speed in zip(stalls, speeds, strict=True)]),
            array(fastest),
            any(line is not None for line in lines),
            any(math.isfinite(limit) for limit in limits),
            curved,
        )

    def __call__(self, xp: Any, tau: Any, qd: Any) -> Any:
        from actspec.laws import clip_asymmetric

        if self.curved:
            tau = tau + 0.0
            for i, (drive, brake, knee, no_load), limit in self.curved:
                tau[:, i] = clip_asymmetric(
                    tau[:, i],
                    qd[:, i],
                    drive_torque=drive,
                    brake_torque=brake,
                    knee_speed=knee,
                    no_load_speed=no_load,
                    effort_limit=limit,
                )
        if self.lined:
            line = xp.minimum(xp.maximum(qd, -self.fastest), self.fastest) * self.slope
            high, low = xp.minimum(self.limit, self.stall - line), xp.maximum(-self.limit, -self.stall - line)
            return xp.minimum(xp.maximum(tau, low), high)
        if self.limited:
            return xp.minimum(xp.maximum(tau, -self.limit), self.limit)
        return tau
