"""Networks of many environments at once: history, forward pass and clamp, once a physics step."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from actspec.diagnostics import listed
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
            self._state = [_State(group, self.envs, q) for group in self._groups]
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
        """Forget the history of some environments, by index or mask of (envs,); None: of all.

        Raises:
            RuntimeFault: there is no such environment, or the mask is of another length.
        """
        if envs is not None:
            envs = self._chosen(envs)
        for state in self._state or ():
            state.reset(envs)

    def _chosen(self, envs: Any) -> Any:
        """Environments as an array that indexes; one that is not there is refused before any history is changed."""
        import numpy as np

        if not hasattr(envs, "dtype"):
            envs = np.array(envs)
            # An empty list is no list of floats.
            envs = envs.astype(int) if not envs.size else envs
        last, kind = self.envs - 1, str(envs.dtype)
        help = f"envs are indices from 0 to {last}, or a mask of {self.envs} truth values"
        if kind.endswith("bool"):
            if tuple(envs.shape) != (self.envs,):
                message = (
                    f"the mask envs has the shape {tuple(envs.shape)}, there are {self.envs} environments"
                )
                raise RuntimeFault.of("LRN042", message, help=help)
        elif "int" not in kind:
            raise RuntimeFault.of("LRN042", f"envs are of type {kind}, neither indices nor a mask", help=help)
        elif bool(((envs < 0) | (envs > last)).any()):
            strange = envs[(envs < 0) | (envs > last)].reshape(-1).tolist()
            message = f"envs has {listed(map(str, strange), 5)}, there are {self.envs} environments"
            raise RuntimeFault.of("LRN042", message, help=help)
        return envs


class _State:
    """History of one network's joints, and its arithmetic in one library."""

    def __init__(self, group: DrivenGroup, envs: int, like: Any) -> None:
        xp = array_namespace(like)
        law, shape = group.law, (envs, len(group.joints))
        self.group, self.xp, self.like, self.shape = group, xp, like, shape

        def array(value: Any) -> Any:
            if xp.__name__ == "torch":
                return xp.as_tensor(value, dtype=like.dtype, device=like.device)
            return xp.asarray(value, dtype=like.dtype)

        # Both inputs in the network's order: a row a sample, the oldest overwritten.
        self.past = xp.stack([xp.stack([array([[0.0] * shape[1]] * envs)] * (group.reach + 1))] * 2)
        self.one, self.two = (1, 0) if law.velocity_first else (0, 1)
        self.at = 0
        self.fresh = self.past[0, 0, :, 0] == 0.0
        self.fresh_any = True
        self.clamp = Clamp.of(group, array)
        bias = [joint.encoder_bias for joint in group.joints]
        self.bias = array(bias) if any(bias) else None
        self.memory: Any = None
        self.forward: Callable[[], Any]
        if law.layers.recurrent:
            layers, (depth, hidden) = recurrent_forward(law.layers, like)
            zero = array([0.0] * hidden) * self.past[0, 0, :, :, None]
            self.memory = [xp.stack([zero] * depth) for _ in range(2)]
            self.forward = lambda: self._recurrent(layers)
        else:
            self.forward = self._perceptron()

    def fits(self, q: Any) -> bool:
        """Whether the arrays are of this library, type and device."""
        same = type(q) is type(self.like) and q.dtype == self.like.dtype
        return same and getattr(q, "device", None) == getattr(self.like, "device", None)

    def reset(self, envs: Any) -> None:
        """Of some environments."""
        self.fresh[slice(None) if envs is None else envs] = True
        self.fresh_any = True

    def step(self, command: Any, q: Any, qd: Any) -> Any:
        """Torque of this step."""
        law = self.group.law
        self.at = (self.at + 1) % self.past.shape[1]
        error = command - q if self.bias is None else command - q - self.bias
        if self.fresh_any:
            self._begin(error, qd)
        scaled = (law.position_scale, law.velocity_scale)
        self.past[self.one, self.at] = error if scaled[0] == 1.0 else error * scaled[0]
        self.past[self.two, self.at] = qd if scaled[1] == 1.0 else qd * scaled[1]
        out = self.forward().reshape(self.shape)
        return self.clamp(self.xp, out if law.torque_scale == 1.0 else out * law.torque_scale, qd)

    def _begin(self, error: Any, qd: Any) -> None:
        """Fill the history of environments that were reset."""
        law, fresh = self.group.law, self.fresh
        for which, value, scale in (
            (self.one, error, law.position_scale),
            (self.two, qd, law.velocity_scale),
        ):
            self.past[which][:, fresh] = value[fresh][None] * scale if law.backfill else 0.0
        for part in self.memory or ():
            part[:, fresh] = 0.0
        self.fresh[:] = False
        self.fresh_any = False

    def _rows(self) -> list[int]:
        """Row of the history of each tap."""
        length = self.past.shape[1]
        return [(self.at - tap) % length for tap in self.group.law.taps]

    def _recurrent(self, layers: Layers) -> Any:
        x = self.xp.stack([self.past[i, row] for i in range(2) for row in self._rows()], -1)
        value, self.memory = layers(x, (self.memory[0], self.memory[1]))
        return value[..., 0]

    def _perceptron(self) -> Callable[[], Any]:
        """The pass over this history; numpy's arrays by torch's kernels on the same memory, where there is torch."""
        import numpy as np

        xp, layers, past = self.xp, self.group.law.layers, self.past
        name = str(self.like.dtype).rpartition(".")[2]
        try:
            import torch
        except ImportError:
            torch = None
        if torch is None or (xp is not torch and name not in ("float32", "float64")):
            run = numpy_forward(layers, self.like.dtype)
            return lambda: run(np.ascontiguousarray(past[:, self._rows()].reshape(layers.inputs, -1).T))
        history = past if xp is torch else torch.from_numpy(past)
        fast = torch_forward(layers, history.dtype, history.device)
        columns = history.reshape(-1, history.shape[2] * history.shape[3])
        own = torch.as_tensor(layers.dense[0].weight, dtype=history.dtype, device=history.device)
        own = own.reshape(len(own), 2, -1)
        first = torch.zeros((len(own), 2, past.shape[1]), dtype=history.dtype, device=history.device)

        def forward() -> Any:
            first.zero_()
            first[:, :, self._rows()] = own
            out = fast(columns, first.reshape(len(own), -1))
            return out if xp is torch else out.numpy()

        return forward

    def outside(self) -> int:
        """Samples of this step beyond the training data."""
        law = self.group.law
        if self.group.range is None:
            return 0
        beyond = None
        scales = (law.position_scale, law.velocity_scale)
        for (low, high), which, scale in zip(self.group.range, (self.one, self.two), scales, strict=True):
            now = self.past[which, self.at] / scale
            here = (now < low) | (now > high)
            beyond = here if beyond is None else beyond | here
        return int(self.xp.sum(beyond))


@dataclass(frozen=True, slots=True)
class Clamp:
    """Limits and torque-speed lines of the joints, an array each; of `ends` the upper one and the lower."""

    high: Any
    low: Any
    ends: Any
    slope: Any
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
        curved = [(i, j.curve, j.effort_limit) for i, j in enumerate(joints) if j.curve is not None]
        return cls(
            array(limits),
            array([-limit for limit in limits]),
            array([[stalls], [[-stall for stall in stalls]]]),
            array([stall / speed for stall, speed in zip(stalls, speeds, strict=True)]),
            any(line is not None for line in lines),
            any(math.isfinite(limit) for limit in limits),
            curved,
        )

    def __call__(self, xp: Any, tau: Any, qd: Any) -> Any:
        if self.curved:
            from actspec.laws import clip_asymmetric

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
        high, low = self.high, self.low
        if self.lined:
            # Beyond the speed at which the law holds the line's end, the line is at the other limit.
            high, low = xp.maximum(xp.minimum(self.ends - qd * self.slope, high), low)
        if self.lined or self.limited:
            return xp.minimum(xp.maximum(tau, low), high)
        return tau
