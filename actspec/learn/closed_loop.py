"""Motion in MuJoCo under a network's torque, or a law's, from logged states: how far it drifts from the log.

The base and joints that are not logged are held; contacts and ends of ranges do not act.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import RobotError
from actspec.ir import JointActuator, Level
from actspec.laws import law_of
from actspec.laws.network import NetworkLaw
from actspec.learn.labels import motion_of_others
from actspec.learn.windows import Dataset, Track
from actspec.spec.network import NetworkManifest
from actspec.sysid.figures import Bounds
from actspec.sysid.stand import Stand

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

HORIZON = 1.0
"""Length of a rollout [s]."""
HELD = 1e8
"""Armature of what does not move [kg*m^2 or kg]."""
ROLLED = ("network", "dc_motor", "ideal_pd")
"""What drives the model in the closed loop."""
BASELINES: Mapping[str, Level] = {"ideal_pd": Level.IDEAL_PD, "dc_motor": Level.DC_MOTOR}


def baseline_laws(actuator: JointActuator) -> dict[str, Any]:
    """The laws of the spec's figures that it states."""
    found = {}
    for name, level in BASELINES.items():
        try:
            found[name] = law_of(replace(actuator, level=level, network=None))
        except ValueError:
            continue
    return found


class RollImpossible(ValueError):
    """No closed loop can be run; its text says why."""


def closed_loop(
    data: Dataset,
    law: NetworkLaw,
    manifest: NetworkManifest,
    stand: Stand,
    step: float,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Array]:
    """RMSE of the position after each step of rollouts from logged states, each as long as `HORIZON`.

    Returns: `ROLLED` to the RMSE [rad or m], shape (n_step,), without laws that the spec does not state.

    Raises:
        RollImpossible: there is no model, or no stretch is long enough.
    """
    import numpy as np

    squares: dict[str, list[Array]] = {name: [] for name in ROLLED}
    for path in dict.fromkeys(track.log.path for track in data.tracks):
        tracks = [track for track in data.tracks if track.log.path == path]
        try:
            bench = Bench(stand, data, tracks, step)
        except RobotError as err:
            raise RollImpossible(err.diagnostics[0].message) from err
        starts = bench.starts()
        if not len(starts):
            continue
        for name in squares:
            laws = [baseline_laws(a).get(name) for a in bench.actuators]
            if name != "network" and any(found is None for found in laws):
                continue
            drive = network_drive(bench, law) if name == "network" else law_drive(bench, laws)
            bench.friction(name != "network" or manifest.torque != "joint")
            squares[name].append(bench.rolled(starts, drive, progress) ** 2)
    if not squares["network"]:
        raise RollImpossible(f"no stretch of {HORIZON:g} s without a gap")
    return {
        name: np.sqrt(np.concatenate([part.reshape(len(part), -1) for part in parts], axis=1).mean(axis=1))
        for name, parts in squares.items()
        if parts
    }


class Bench:
    """A model whose logged joints move under given torques, from logged states."""

    def __init__(self, stand: Stand, data: Dataset, tracks: Sequence[Track], step: float) -> None:
        import mujoco
        import numpy as np

        from actspec.sysid.links import bench_model

        self.tracks, self.step = tracks, step
        by_name = {actuator.joint: actuator for actuator in data.actuators}
        self.actuators = [by_name[track.joint] for track in tracks]
        names = [track.joint for track in tracks]
        log = tracks[0].log
        base, (robot, others) = log.sidecar.base, stand.beside(log, names)
        self.model, self.pose = bench_model(robot, names, None if base is None else base.orientation)
        model = self.model
        ids = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name) for name in [*names, *others]]
        at, dof = model.jnt_qposadr[ids], model.jnt_dofadr[ids]
        self.at, self.others_at = np.split(at, [len(names)])
        self.dof, self.others_dof = np.split(dof, [len(names)])
        # Constraints act again, for dry friction; contacts and ends of ranges would be those of another place.
        model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT)
        model.opt.timestep = step
        model.dof_armature[:] = HELD
        self.data = mujoco.MjData(model)
        self.bias = np.array([actuator.encoder_bias.value or 0.0 for actuator in self.actuators])
        self.grid = np.arange(tracks[0].time[0], tracks[0].time[-1], step)
        self.others = motion_of_others(log, others, self.grid)
        late = [np.searchsorted(t.time, self.grid + 1e-9, side="right") - 1 for t in tracks]
        self.command = np.stack([t.command[row] for t, row in zip(tracks, late, strict=True)], axis=1)
        self.q = np.stack([self._between(t, t.position) for t in tracks], axis=1)
        self.qd = np.stack([self._between(t, t.velocity) for t in tracks], axis=1)
        self.friction(True)

    def _between(self, track: Track, signal: Array) -> Array:
        import numpy as np

        good = np.isfinite(signal)
        found: Array = np.interp(self.grid, track.time[good], signal[good])
        row = np.clip(np.searchsorted(track.time[good], self.grid, side="left"), 1, int(good.sum()) - 1)
        gap = track.time[good][row] - track.time[good][row - 1]
        found[gap > 4.0 * float(np.median(np.diff(track.time)))] = np.nan
        return found

    def friction(self, own: bool) -> None:
        """Give the joints armature and friction of the spec, or none where the torque is behind them."""
        for dof, actuator in zip(self.dof, self.actuators, strict=True):
            self.model.dof_armature[dof] = (actuator.armature.value or 0.0) * own
            self.model.dof_damping[dof] = (actuator.friction_viscous.value or 0.0) * own
            self.model.dof_frictionloss[dof] = (actuator.friction_coulomb.value or 0.0) * own

    def starts(self) -> NDArray[np.intp]:
        """Rows of the grid from which a horizon goes, with a whole history before each."""
        import numpy as np

        reach = max(t.reach * float(np.median(np.diff(t.time))) for t in self.tracks)
        before, length = math.ceil(reach / self.step) + 1, round(HORIZON / self.step)
        told = np.isfinite(np.concatenate([self.q, self.qd], axis=1)).all(axis=1).reshape(-1)
        begins = range(before, len(self.grid) - length, length)
        return np.array([k for k in begins if told[k - before : k + length].all()], dtype=np.intp)

    def rolled(
        self,
        starts: NDArray[np.intp],
        drive: Callable[..., Array],
        progress: Callable[[int, int], None] | None,
    ) -> Array:
        """Errors of the position after each step [rad or m], shape (n_step, n_start, n_joint)."""
        import mujoco
        import numpy as np

        length = round(HORIZON / self.step)
        states = [mujoco.MjData(self.model) for _ in starts]
        for data, k in zip(states, starts, strict=True):
            data.qpos[:], data.qvel[:] = self.pose, 0.0
            data.qpos[self.at], data.qvel[self.dof] = self.q[k] - self.bias, self.qd[k]
        q, qd = self.q[starts].copy(), self.qd[starts].copy()
        found = np.empty((length, len(starts), len(self.at)))
        for step in range(length):
            torque = drive(starts, step, self.command[starts + step], q, qd)
            for i, data in enumerate(states):
                data.qpos[self.others_at], data.qvel[self.others_dof] = (
                    x[starts[i] + step] for x in self.others[:2]
                )
                data.qfrc_applied[self.others_dof] = HELD * self.others[2][starts[i] + step]
                data.qfrc_applied[self.dof] = torque[i]
                mujoco.mj_step(self.model, data)
                q[i], qd[i] = data.qpos[self.at] + self.bias, data.qvel[self.dof]
            found[step] = q - self.q[starts + step + 1]
            if progress is not None:
                progress(step + 1, length)
        # A law that does not settle is as wrong as can be seen, not infinitely so.
        return np.nan_to_num(np.clip(found, -10.0, 10.0), nan=10.0)


def network_drive(bench: Bench, law: NetworkLaw) -> Callable[..., Array]:
    """The network, its history begun with what was logged."""
    import numpy as np

    stride = max(1, round(law.tap_period / bench.step))
    bounds = [Bounds.of(actuator) for actuator in bench.actuators]
    recurrent = bool(law.layers.recurrent)
    if recurrent and stride != 1:
        raise RollImpossible("an LSTM's samples are physics steps, and the spec has another step")
    reach = max(track.taps[-1] for track in bench.tracks) if recurrent else stride * max(law.taps)
    past: dict[str, Array] = {}
    state: list[Any] = [None]

    def drive(starts: NDArray[np.intp], step: int, command: Array, q: Array, qd: Array) -> Array:
        if step == 0:
            rows = starts[None] - np.arange(reach + 1)[:, None]
            past["error"], past["velocity"] = (bench.command - bench.q)[rows], bench.qd[rows]
            state[0] = None
            for k in range(reach, 0, -1) if recurrent else ():
                _, state[0] = law.torque(
                    past["error"][k, ..., None], past["velocity"][k, ..., None], state[0]
                )
        if recurrent:
            torque, state[0] = law.torque((command - q)[..., None], qd[..., None], state[0])
        else:
            for name, now in (("error", command - q), ("velocity", qd)):
                if step:
                    past[name] = np.roll(past[name], 1, axis=0)
                past[name][0] = now
            picked = [stride * tap for tap in law.taps]
            inputs = [np.moveaxis(past[name][picked], 0, -1) for name in ("error", "velocity")]
            torque = law.torque(inputs[0], inputs[1])[0]
        return np.stack([bound.clip(torque[:, j], qd[:, j]) for j, bound in enumerate(bounds)], axis=1)

    return drive


def law_drive(bench: Bench, laws: Sequence[Any]) -> Callable[..., Array]:
    """A law of the spec, without delay, as simulators have it."""
    import numpy as np

    def drive(starts: Any, step: int, command: Array, q: Array, qd: Array) -> Array:
        parts = [law.torque(command[:, j], q[:, j] - bench.bias[j], qd[:, j]) for j, law in enumerate(laws)]
        return np.stack(parts, axis=1)

    return drive
