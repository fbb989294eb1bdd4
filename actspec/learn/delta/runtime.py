"""A delta action beside any environment: corrections of a policy's actions, frozen.

delta = delta_action("nets/delta.json")
delta.delta(state, command)                         # rad, of arrays of numpy or torch
env = delta.wrap(env, state=lambda: ...)            # anything with step(action)
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from actspec.diagnostics import Span, listed
from actspec.laws.arrays import array_namespace
from actspec.learn.delta.files import DeltaFault, DeltaNetwork, read_delta


def delta_action(path: str | os.PathLike[str]) -> DeltaAction:
    """The delta action of a manifest.

    Raises:
        DeltaFault: it cannot be read.
    """
    return DeltaAction(read_delta(path))


class DeltaAction:
    """A frozen delta action.

    Attributes:
        joints: Names, the columns of commands and corrections.
        state: Columns of a state.
        measured: Those of them that a simulator tells: all but the last commands.
        max_delta: Largest correction [rad].
        period: Time between two commands [s].
    """

    def __init__(self, network: DeltaNetwork) -> None:
        manifest = network.manifest
        self._network = network
        self.joints, self.max_delta, self.period = manifest.joints, manifest.max_delta, manifest.period
        self.state, self.measured = manifest.state, manifest.measured

    def delta(self, state: Any, action: Any) -> Any:
        """Corrections of commands [rad].

        Args:
            state: Columns `state`, shape (n, n_state) or (n_state,) [rad, rad/s].
            action: Commands [rad], shape (n, n_joint) or (n_joint,): what the policy wants the joints' positions to
                be, `default + scale * action`.

        Returns: Of the commands' shape and library, at most `max_delta`; no gradient goes through it.

        Raises:
            DeltaFault: the shapes do not fit.
        """
        xp = array_namespace(state, action)
        if xp.__name__ == "torch":
            with xp.no_grad():
                return self._delta(xp, state, action)
        return self._delta(xp, state, action)

    def _delta(self, xp: Any, state: Any, action: Any) -> Any:
        flat = action.ndim == 1
        s, a = (x[None] if x.ndim == 1 else x for x in (state, action))
        if (
            s.ndim != 2
            or a.ndim != 2
            or len(s) != len(a)
            or s.shape[1] != len(self.state)
            or a.shape[1] != len(self.joints)
        ):
            message = (
                f"got a state of shape {tuple(state.shape)} and commands of shape {tuple(action.shape)}, "
                f"takes (n, {len(self.state)}) and (n, {len(self.joints)})"
            )
            raise DeltaFault.of(
                "LRN062", message, Span(self._network.path), help="`.state` and `.joints` name them"
            )
        x = xp.concatenate([s, a], axis=1)
        if not x.dtype.is_floating_point if hasattr(x.dtype, "is_floating_point") else x.dtype.kind != "f":
            x = xp.asarray(x, dtype=xp.float32)
        found = self._network(x)
        return found[0] if flat else found

    def wrap(
        self,
        env: Any,
        *,
        state: Callable[[], Any],
        joints: Sequence[str] | None = None,
        action_scale: Mapping[str, float] | Sequence[float] | float | None = None,
        default_position: Mapping[str, float] | Sequence[float] | float | None = None,
    ) -> CorrectedEnv:
        """An environment whose actions are corrected before each step.

        Args:
            env: Anything with `step(action)`; its actions are default + scale * action in rad.
            state: Gives columns `state`, or `measured`: the last commands are then kept here. Shape (n, n_column).
            joints: Order of the environment's actions; None: that of `joints`.
            action_scale: Command [rad] per unit of an action, by joint or in that order; None: as the spec stated.
            default_position: Command at action 0 [rad], likewise.

        Raises:
            DeltaFault: scale or default of a joint are unknown, or the joints are others.
        """
        return CorrectedEnv(self, env, state, joints, action_scale, default_position)

    def _figures(self, name: str, given: Any, joints: Sequence[str]) -> list[float]:
        """One of each joint, in the environment's order."""
        if given is not None and not isinstance(given, Mapping):
            row = [given] * len(joints) if isinstance(given, int | float) else list(given)
            if len(row) != len(joints):
                raise self._fault(f"{name} has {len(row)} figures, there are {len(joints)} joints")
            return [float(value) for value in row]
        found: Mapping[str, float] = getattr(self._network.manifest, name) if given is None else given
        if unknown := [joint for joint in joints if joint not in found]:
            raise self._fault(
                f"{name} is unknown of {listed(unknown)}", f"state it in the spec, or give {name}="
            )
        return [float(found[joint]) for joint in joints]

    def _fault(self, message: str, help: str | None = None) -> DeltaFault:
        return DeltaFault.of("LRN062", message, Span(self._network.path), help=help)


class CorrectedEnv:
    """An environment behind a delta action; all but `step` and `reset` is the environment's own.

    Attributes:
        env: The environment.
        last_delta: The last corrections [rad], in the environment's order; None before the first step.
    """

    def __init__(
        self,
        delta: DeltaAction,
        env: Any,
        state: Callable[[], Any],
        joints: Sequence[str] | None,
        action_scale: Any,
        default_position: Any,
    ) -> None:
        order = list(delta.joints if joints is None else joints)
        if sorted(order) != sorted(delta.joints):
            raise delta._fault(
                f"the environment moves {listed(order)}, the delta action {listed(delta.joints)}"
            )
        self.env, self.last_delta = env, None
        self._delta, self._state = delta, state
        self._mine = [order.index(joint) for joint in delta.joints]
        self._theirs = [delta.joints.index(joint) for joint in order]
        self._scale = delta._figures("action_scale", action_scale, order)
        self._middle = delta._figures("default_position", default_position, order)
        if 0.0 in self._scale:
            raise delta._fault("action_scale must not be 0")
        self._last: Any = None
        self._fresh: Any = None
        measured = {name: k for k, name in enumerate(delta.measured)}
        self._places = [measured.get(name, -1) for name in delta.state]
        self._of = [
            delta.joints.index(name.rpartition(".")[0]) if name.endswith(".last_command") else -1
            for name in delta.state
        ]

    def __getattr__(self, name: str) -> Any:
        return getattr(self.env, name)

    def step(self, action: Any) -> Any:
        """Step the environment with the corrected action.

        Where it answers as gymnasium does (observation, reward, terminated, truncated, info), or as rsl_rl does
        (observation, reward, done, extras), environments that are done forget their last commands.
        """
        delta = self._delta
        xp = array_namespace(action)
        options = {"dtype": action.dtype} | ({"device": action.device} if xp.__name__ == "torch" else {})
        scale, middle = (xp.asarray(row, **options) for row in (self._scale, self._middle))
        flat = action.ndim == 1
        command = (middle + scale * action)[..., self._mine]
        rows = command[None] if flat else command
        state = self._state()
        state = state[None] if state.ndim == 1 else state
        if state.shape[-1] == len(delta.measured) != len(delta.state):
            state = self._with_last(xp, state, rows)
        found = delta.delta(state, rows)[..., self._theirs]
        self._last, self._fresh = rows, None
        self.last_delta = found = found[0] if flat else found
        answer = self.env.step(action + xp.asarray(found, **options) / scale)
        if isinstance(answer, tuple) and len(answer) in (4, 5):
            done = answer[2] if len(answer) == 4 else answer[2] | answer[3]
            self.forget(done)
        return answer

    def _with_last(self, xp: Any, state: Any, command: Any) -> Any:
        """The state's columns from those that the simulator tells and the last commands."""
        last = command if self._last is None or self._last.shape != command.shape else self._last
        if self._fresh is not None and self._last is not None:
            last = xp.where(self._fresh[:, None], command, last)
        columns = [
            last[:, of] if of >= 0 else state[:, place]
            for of, place in zip(self._of, self._places, strict=True)
        ]
        return xp.stack(columns, -1)

    def forget(self, done: Any = True) -> None:
        """Forget the last commands, of all environments or of those where `done`, shape (n,), is true."""
        if done is True or self._last is None or getattr(done, "ndim", 0) == 0:
            if bool(done):
                self._last = None
            return
        done = done.bool() if hasattr(done, "bool") else done.astype(bool)
        self._fresh = done if self._fresh is None else self._fresh | done

    def reset(self, *args: Any, **options: Any) -> Any:
        """Reset the environment; last commands are forgotten."""
        self.forget()
        return self.env.reset(*args, **options)
