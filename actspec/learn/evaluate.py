"""How good a network is: torques against those that were logged, beside laws of the spec, and motion in MuJoCo."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Collector, RobotError
from actspec.ir import JointActuator, Level
from actspec.laws import law_of
from actspec.laws.network import NetworkLaw
from actspec.learn.windows import Dataset, Track
from actspec.readings.onnx_network import read_onnx
from actspec.robot.view import RobotView
from actspec.spec.network import NetworkManifest
from actspec.sysid.figures import Bounds

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

HORIZON = 1.0
"""Length of a rollout [s]."""
GOOD = (0.015, 0.95)
"""Largest share of the effort limit and least R² of a good network. Source: 0.5 N*m at 33.5 N*m."""
FAIR = (0.03, 0.85)
"""Likewise of a fair one. Source: 1 N*m at 33.5 N*m."""
HELD = 1e8
"""Armature of what does not move [kg*m^2 or kg]."""
ROLLED = ("network", "dc_motor", "ideal_pd")
"""What drives the model in the closed loop."""
BASELINES: Mapping[str, Level] = {"ideal_pd": Level.IDEAL_PD, "dc_motor": Level.DC_MOTOR}


@dataclass(frozen=True, slots=True)
class Errors:
    """Of torques.

    Attributes:
        rmse: [N*m or N].
        mse: [N^2*m^2 or N^2].
        relative_error: RMSE over the root mean square of the torque [-]; None without torque.
        worst: Largest [N*m or N].
        r2: Share of the variance that is explained [-]; None where the torque is constant.
        rows: How many.
    """

    rmse: float
    mse: float
    relative_error: float | None
    worst: float
    r2: float | None
    rows: int


@dataclass(frozen=True, slots=True)
class JointErrors:
    """Of a joint.

    Attributes:
        joint: Its name.
        errors: Of its torque.
        limit: Effort limit [N*m or N]; None: unknown.
        grade: `good`, `fair` or `poor`.
        baselines: Errors of the spec's laws.
    """

    joint: str
    errors: Errors
    limit: float | None
    grade: str
    baselines: Mapping[str, Errors]


@dataclass(frozen=True, slots=True)
class Evaluation:
    """Of a network on logs.

    Attributes:
        overall: Errors of all rows.
        grade: The worst of the joints'.
        joints: In the spec's order.
        baselines: Errors of the spec's laws; without those that it does not state.
        closed_loop: `network` and the baselines to the RMSE of the position [rad or m]; None: not run.
        growth: Likewise, to the RMSE after each physics step of the rollouts, shape (n_step,).
        why_not: Why no closed loop was run.
        outside: Share of rows outside of the manifest's range: `error`, `velocity`, `any`; None: it has no range.
    """

    overall: Errors
    grade: str
    joints: tuple[JointErrors, ...]
    baselines: Mapping[str, Errors]
    closed_loop: Mapping[str, float | None] | None
    growth: Mapping[str, Array]
    why_not: str | None
    outside: Mapping[str, float] | None


def errors_of(found: Array, torque: Array) -> Errors:
    """Of torques against those that were logged, shapes (n,)."""
    import numpy as np

    left = found - torque
    mse = float(np.mean(left**2))
    rms, var = float(np.sqrt(np.mean(torque**2))), float(np.var(torque))
    return Errors(
        math.sqrt(mse),
        mse,
        math.sqrt(mse) / rms if rms > 0 else None,
        float(np.abs(left).max()),
        1.0 - mse / var if var > 0 else None,
        len(torque),
    )


def graded(errors: Errors, limit: float | None) -> str:
    """`good`, `fair` or `poor`; without a limit by R² alone."""
    share = 0.0 if limit is None else errors.rmse / limit
    r2 = -math.inf if errors.r2 is None else errors.r2
    for name, (most, least) in (("good", GOOD), ("fair", FAIR)):
        if share < most and r2 > least:
            return name
    return "poor"


def baseline_laws(actuator: JointActuator) -> dict[str, Any]:
    """The laws of the spec's figures that it states."""
    found = {}
    for name, level in BASELINES.items():
        try:
            found[name] = law_of(replace(actuator, level=level, network=None))
        except ValueError:
            continue
    return found


def predicted(law: NetworkLaw, tracks: Sequence[Track], bounds: Bounds) -> list[Array]:
    """The network's torque, clamped, at the rows of a joint's tracks [N*m or N], one array a track."""
    if law.layers.recurrent:
        from actspec.learn.recurrent import along

        found = along(law, tracks, [track.rows for track in tracks])
    else:
        found, n = [], len(law.taps)
        for track in tracks:
            x = track.inputs(track.rows)
            found.append(law.torque(x[:, :n], x[:, n:])[0])
    return [
        bounds.clip(torque, track.velocity[track.rows]) for torque, track in zip(found, tracks, strict=True)
    ]


def evaluate(
    data: Dataset,
    law: NetworkLaw,
    manifest: NetworkManifest,
    robot: RobotView,
    step: float,
    *,
    policy: Dataset | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Evaluation:
    """Judge a network on logs.

    Args:
        data: The logs, with torques, at the network's taps.
        law: The network.
        manifest: Its manifest.
        robot: For the closed loop.
        step: Physics step [s].
        policy: Logs whose share outside of the manifest's range is told; None: those of `data`.
        progress: Called with steps done, of how many.
    """
    import numpy as np

    joints, everything = [], []
    for actuator in data.actuators:
        tracks = [t for t in data.tracks if t.joint == actuator.joint and len(t.rows)]
        if not tracks:
            continue
        bounds = Bounds.of(actuator)
        torque = np.concatenate([t.torque[t.rows] for t in tracks])
        found = {"network": np.concatenate(predicted(law, tracks, bounds))}
        bias = actuator.encoder_bias.value or 0.0
        for name, base in baseline_laws(actuator).items():
            parts = [
                base.torque(t.command[t.rows], t.position[t.rows] - bias, t.velocity[t.rows]) for t in tracks
            ]
            found[name] = np.concatenate(parts)
        limit = None if math.isinf(bounds.limit) else bounds.limit
        errors = {name: errors_of(part, torque) for name, part in found.items()}
        network = errors.pop("network")
        joints.append(JointErrors(actuator.joint, network, limit, graded(network, limit), errors))
        everything.append((torque, found))
    torque = np.concatenate([part for part, _ in everything])
    names = [name for name in BASELINES if all(name in found for _, found in everything)]
    overall, *rest = (
        errors_of(np.concatenate([found[name] for _, found in everything]), torque)
        for name in ("network", *names)
    )
    grades = [joint.grade for joint in joints]
    closed, why = None, None
    growth: Mapping[str, Array] = {}
    try:
        growth = closed_loop(data, law, manifest, robot, step, progress)
        closed = {
            name: float(np.sqrt(np.mean(growth[name] ** 2))) if name in growth else None for name in ROLLED
        }
    except RollImpossible as err:
        why = str(err)
    return Evaluation(
        overall,
        next(grade for grade in ("poor", "fair", "good") if grade in grades),
        tuple(joints),
        dict(zip(names, rest, strict=True)),
        closed,
        growth,
        why,
        outside(policy or data, manifest),
    )


def outside(data: Dataset, manifest: NetworkManifest) -> dict[str, float] | None:
    """Share of rows whose inputs the training data did not reach; None: the manifest does not tell."""
    import numpy as np

    if manifest.range is None:
        return None
    parts = {}
    for name in ("error", "velocity"):
        ends = getattr(manifest.range, name)
        values = np.concatenate([getattr(track, name)[track.rows] for track in data.tracks])
        parts[name] = (values < ends.low) | (values > ends.high)
    shares = {name: float(np.mean(part)) for name, part in parts.items()}
    return {**shares, "any": float(np.mean(parts["error"] | parts["velocity"]))}


class RollImpossible(ValueError):
    """No closed loop can be run; its text says why."""


def closed_loop(
    data: Dataset,
    law: NetworkLaw,
    manifest: NetworkManifest,
    robot: RobotView,
    step: float,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Array]:
    """RMSE of the position after each step of rollouts from logged states, each as long as `HORIZON`.

    The base and joints that are not logged are held; contacts and ends of ranges do not act.

    Returns: `ROLLED` to the RMSE [rad or m], shape (n_step,), without laws that the spec does not state.

    Raises:
        RollImpossible: there is no model, or no stretch is long enough.
    """
    import numpy as np

    squares: dict[str, list[Array]] = {name: [] for name in ROLLED}
    for path in dict.fromkeys(track.log.path for track in data.tracks):
        tracks = [track for track in data.tracks if track.log.path == path]
        try:
            bench = _Bench(robot, data, tracks, step)
        except RobotError as err:
            raise RollImpossible(err.diagnostics[0].message) from err
        starts = bench.starts()
        if not len(starts):
            continue
        for name in squares:
            laws = [baseline_laws(a).get(name) for a in bench.actuators]
            if name != "network" and any(found is None for found in laws):
                continue
            drive = _network_drive(bench, law) if name == "network" else _law_drive(bench, laws)
            bench.friction(name != "network" or manifest.torque != "joint")
            squares[name].append(bench.rolled(starts, drive, progress) ** 2)
    if not squares["network"]:
        raise RollImpossible(f"no stretch of {HORIZON:g} s without a gap")
    return {
        name: np.sqrt(np.concatenate([part.reshape(len(part), -1) for part in parts], axis=1).mean(axis=1))
        for name, parts in squares.items()
        if parts
    }


class _Bench:
    """A model whose logged joints move under given torques, from logged states."""

    def __init__(self, robot: RobotView, data: Dataset, tracks: Sequence[Track], step: float) -> None:
        import mujoco
        import numpy as np

        from actspec.sysid.links import bench_model

        self.tracks, self.step = tracks, step
        by_name = {actuator.joint: actuator for actuator in data.actuators}
        self.actuators = [by_name[track.joint] for track in tracks]
        names = [track.joint for track in tracks]
        base = tracks[0].log.sidecar.base
        self.model, self.pose = bench_model(robot, names, None if base is None else base.orientation)
        model = self.model
        ids = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name) for name in names]
        self.at, self.dof = model.jnt_qposadr[ids], model.jnt_dofadr[ids]
        # Constraints act again, for dry friction; contacts and ends of ranges would be those of another place.
        model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT)
        model.opt.timestep = step
        model.dof_armature[:] = HELD
        self.data = mujoco.MjData(model)
        self.bias = np.array([actuator.encoder_bias.value or 0.0 for actuator in self.actuators])
        self.grid = np.arange(tracks[0].time[0], tracks[0].time[-1], step)
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
                data.qfrc_applied[self.dof] = torque[i]
                mujoco.mj_step(self.model, data)
                q[i], qd[i] = data.qpos[self.at] + self.bias, data.qvel[self.dof]
            found[step] = q - self.q[starts + step + 1]
            if progress is not None:
                progress(step + 1, length)
        # A law that does not settle is as wrong as can be seen, not infinitely so.
        return np.nan_to_num(np.clip(found, -10.0, 10.0), nan=10.0)


def _network_drive(bench: _Bench, law: NetworkLaw) -> Callable[..., Array]:
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


def _law_drive(bench: _Bench, laws: Sequence[Any]) -> Callable[..., Array]:
    """A law of the spec, without delay, as simulators have it."""
    import numpy as np

    def drive(starts: Any, step: int, command: Array, q: Array, qd: Array) -> Array:
        parts = [law.torque(command[:, j], q[:, j] - bench.bias[j], qd[:, j]) for j, law in enumerate(laws)]
        return np.stack(parts, axis=1)

    return drive


def network_of(path: str, actuators: Sequence[JointActuator]) -> tuple[NetworkLaw, NetworkManifest]:
    """The network that a manifest names, read as data.

    Raises:
        LogError: the manifest or its ONNX file cannot be read, or they do not fit.
    """
    from actspec.ir import Network
    from actspec.logs import LogError
    from actspec.readings.onnx_network import NetworkFileError, OnnxMissing
    from actspec.targets.kit.network import read_network

    out = Collector()
    named = replace(actuators[0], level=Level.ACTUATOR_NET, network=Network(None, path), span=None)
    found = read_network(named, "onnx", out)
    out.raise_if_failed(LogError)
    assert found is not None
    try:
        return found.manifest.law(read_onnx(found.data)), found.manifest
    except OnnxMissing as err:
        message = "a network is read by onnx, which is not installed"
        raise LogError.of("LRN012", message, help="pip install 'actspec[learn]'") from err
    except NetworkFileError as err:
        raise LogError.of("LRN013", f"the network cannot be read: {err}", where=path) from err
