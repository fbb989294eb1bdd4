"""From a policy's logs to samples: the robot's state and command at a row, and where it was at the next.

A row is what was read at its time and the command sent then, held until the next row.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Severity, Span, listed
from actspec.ir import ActuatorSet, Command, JointKind, Level
from actspec.learn.delta.plant import Motion, Plant
from actspec.learn.windows import check_copies
from actspec.logs import BASE, Log, LogError
from actspec.sysid.checks import check
from actspec.sysid.figures import Bounds
from actspec.sysid.fit import joints_of
from actspec.sysid.recording import GAP, record
from actspec.sysid.stand import Stand

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Rows = NDArray[np.intp]

SAME_RATE = 0.01
"""Share by which a log's step may differ from the policy's. Chosen: clocks are better."""
BROKEN = 0.1
"""Share of steps longer than the usual one from which on a log is none of one rate. Chosen: gaps are rare."""
LEAST = 50
"""Fewest samples. Chosen: a second of a policy at 50 Hz."""
SIGNALS = ("position", "velocity", "last_command")
"""Of a joint, before what is known of the base; the command comes last."""
FELT = ("orientation", "angular_velocity")
"""Of the base: what its sensors read, and no more."""


@dataclass(frozen=True, slots=True)
class Samples:
    """Rows of logs with the rows before and after them.

    Attributes:
        joints: Names, the columns of commands.
        states: Of the simulator, shape (n, n_state).
        inputs: Raw columns as `columns` names them, shape (n, n_column).
        columns: `JOINT.position`, `.velocity`, `.last_command`, the base's where it is free, `.command`.
        after: Position as read [rad or m], then velocity [rad/s or m/s], of the next row, shape (n, 2 n_joint).
        plants: Who simulates which samples.
        logs: Paths of the logs and which samples are of each.
        runs: First samples of stretches without a gap, and their lengths.
    """

    joints: tuple[str, ...]
    states: Array
    inputs: Array
    columns: tuple[str, ...]
    after: Array
    plants: tuple[tuple[Plant, slice], ...]
    logs: tuple[tuple[str, slice], ...]
    runs: tuple[tuple[int, int], ...]

    def __len__(self) -> int:
        return len(self.states)

    @property
    def command(self) -> Array:
        """As logged [rad or m], shape (n, n_joint)."""
        found: Array = self.inputs[:, -len(self.joints) :]
        return found

    def step(self, states: Array, command: Array, rows: Rows) -> Array:
        """States a control period later, shape (n_row, n_state); NaN where the simulation diverged.

        Args:
            states: Shape (n_row, n_state).
            command: [rad or m], shape (n_row, n_joint).
            rows: Samples whose plants are meant, in order.
        """
        import numpy as np

        out = np.empty_like(states)
        for plant, part in self.plants:
            mine = (rows >= part.start) & (rows < part.stop)
            if mine.any():
                out[mine] = plant.advance(states[mine], command[mine])
        return out

    def errors(self, delta: Array | float = 0.0, rows: Rows | None = None) -> Array:
        """Simulated less logged position and velocity of the next row, shape (n_row, 2 n_joint).

        Args:
            delta: Correction of the commands [rad], shape (n_row, n_joint).
            rows: Samples; None: all.
        """
        import numpy as np

        rows = np.arange(len(self)) if rows is None else rows
        after = self.step(self.states[rows], self.command[rows] + delta, rows)
        return np.concatenate(self.plants[0][0].read(after), axis=1) - self.after[rows]

    def slopes(self, delta: Array, errors: Array, step: float, rows: Rows) -> NDArray[np.float32]:
        """Change of the errors over that of each command, by differences, shape (n_row, 2 n_joint, n_joint).

        Args:
            delta: Where [rad], shape (n_row, n_joint).
            errors: There, likewise but (n_row, 2 n_joint).
            step: Of the difference [rad]; towards no correction.
            rows: Samples.
        """
        import numpy as np

        out = np.empty((len(rows), errors.shape[1], delta.shape[1]), dtype=np.float32)
        for j in range(delta.shape[1]):
            moved = delta.copy()
            way = np.where(delta[:, j] > 0, -step, step)
            moved[:, j] += way
            out[:, :, j] = (self.errors(moved, rows) - errors) / way[:, None]
        return out

    def columns_of(self, states: Array, rows: Rows) -> Array:
        """Raw columns of other states at the rows' commands, shape (n_row, n_column)."""
        import numpy as np

        q, qd = self.plants[0][0].read(states)
        n = q.shape[1]
        found = self.inputs[rows].copy()
        found[:, :n], found[:, n : 2 * n] = q, qd
        if found.shape[1] > 4 * n:
            found[:, 3 * n : -n] = felt(self.plants[0][0].base(states))
        return np.ascontiguousarray(found)


def felt(base: Array) -> Array:
    """What the base's sensors read of `Motion.free`, shape (n, 7)."""
    import numpy as np

    return np.concatenate([base[:, 3:7], base[:, 10:13]], axis=1)


def collect(stand: Stand, logs: Sequence[Log], base: str | None, out: Collector) -> Samples:
    """The samples of a policy's logs.

    Args:
        stand: The model, the spec, and where joints are that no motor drives.
        logs: At the policy's rate.
        base: `fixed`: a base that is free in the model was held.
        out: Takes what is left out.

    Raises:
        LogError: they cannot be used, with every reason.
        RobotError, EmitError: the model cannot be compiled.
    """
    import numpy as np

    actuators = stand.actuators
    names = joints_of(actuators, logs, out)
    stand.check(logs, out)
    _check_spec(actuators, out)
    period = _period(actuators, out)
    out.raise_if_failed(LogError)
    for log in logs:
        _check_log(log, names, [joint.joint for joint in actuators.joints], period, out)
    out.raise_if_failed(LogError)
    check_copies(
        (
            (log.path, name, position)
            for log in logs
            for name in names
            if (position := log.joints[name].position) is not None
        ),
        out,
    )
    _check_signals(actuators, logs, out)
    free = {log.path: _free(log, out) for log in logs}
    held = base == "fixed" or all(log.sidecar.base is not None for log in logs)
    out.raise_if_failed(LogError)
    plants: dict[tuple[object, ...], Plant] = {}
    parts: list[tuple[Log, Plant, Motion]] = []
    for log in logs:
        moves = free[log.path] is not None and not held
        robot, _ = stand.beside(log, names)
        told = log.sidecar.base
        orientation = None if moves or told is None else told.orientation
        key = orientation, *robot.pose.items()
        if key not in plants:
            plants[key] = Plant(actuators, robot, held=not moves, orientation=orientation)
        plant = plants[key]
        if not moves and plant.held_free and base is None and told is None:
            message = "the model's base is free, and the log does not tell how it moved"
            help = (
                "log base.position, base.orientation, base.linear_velocity and base.angular_velocity; a robot that was "
                "hung up: --base fixed, or `base: {orientation: [1, 0, 0, 0]}` beside the log"
            )
            out.error("LRN054", message, span=Span(log.path, 1), help=help)
        parts.append((log, plant, _motion(log, names, period, free[log.path] if plant.free else None)))
    if any(plant.free and not plant.floor for plant in plants.values()):
        message = "the base is free, and nothing in the model's world can be stood on: the robot falls"
        help = "name a model with a floor in `robot.model`, such as the scene that includes the robot"
        out.warning("LRN061", message, where="robot.model", span=Span(stand.robot.path), help=help)
    if len({plant.free for plant in plants.values()}) > 1:
        message = "the base is held in some of the logs, and free in others"
        out.error("LRN054", message, span=Span(logs[0].path), help="train on one or the other")
    out.raise_if_failed(LogError)
    moved = {
        name: [(log, motion.q[:, j] - plant.bias[j]) for log, plant, motion in parts]
        for j, name in enumerate(names)
    }
    stand.tell(moved, out)
    found = _joined(tuple(names), parts)
    if len(found) < LEAST:
        message = f"{len(found)} rows have one before and one after them, at least {LEAST} are needed"
        raise LogError.of("LRN056", message, Span(logs[0].path), help="log longer")
    lost = int((~np.isfinite(found.errors()).all(axis=1)).sum())
    if lost > 0.5 * len(found):
        message = f"the simulation diverges within a control period from {lost} of {len(found)} rows"
        help = "are units and the order of the base's quaternion right (w, x, y, z)? `actspec validate` checks the spec"
        raise LogError.of("LRN057", message, Span(logs[0].path), help=help)
    if lost:
        message = f"{lost} of {len(found)} rows are left out: the simulation diverges from their states"
        out.warning("LRN057", message, span=Span(logs[0].path))
    return found


def _check_spec(actuators: ActuatorSet, out: Collector) -> None:
    wrong = [joint.joint for joint in actuators.joints if joint.command is not Command.POSITION]
    if wrong:
        message = "its command is no position, and a delta action corrects positions"
        out.error("LRN055", message, where=listed(wrong), help="put it under `unmanaged`")
    nets = list(dict.fromkeys(j.group for j in actuators.joints if j.level is Level.ACTUATOR_NET))
    if nets:
        message = (
            f"level actuator_net, of {listed(nets)}: what such a network saw in the physics steps between two rows is "
            "not in a policy's log"
        )
        help = (
            "train on a variant of the spec with level dc_motor, or leave out the network or the delta action"
        )
        out.error("LRN055", message, where="level", help=help)
    if len({joint.kind for joint in actuators.joints}) > 1:
        slides = listed(joint.joint for joint in actuators.joints if joint.kind is JointKind.SLIDE)
        message = f"slides and hinges have no common largest correction: {slides}"
        out.error("LRN055", message, where="actuators", help="put the slides under `unmanaged`")


def _period(actuators: ActuatorSet, out: Collector) -> float:
    """The policy's [s]."""
    if actuators.control_period is None or actuators.decimation is None:
        message = "the policy's rate is unknown"
        help = "write `timing: {physics_dt: 5 ms, decimation: 4}`: a control period is so many physics steps"
        out.error("LRN051", message, where="timing", help=help)
        return 1.0
    return actuators.control_period


def _check_log(log: Log, names: Sequence[str], joints: Sequence[str], period: float, out: Collector) -> None:
    """What a log has to hold: all joints, at the policy's rate, with numbers in every cell."""
    import numpy as np

    gaps = np.diff(log.time)
    broken = float(np.mean((gaps > GAP * log.step) | (gaps < log.step / GAP)))
    if abs(log.step / period - 1.0) > SAME_RATE or broken > BROKEN:
        message = f"a row comes every {log.step * 1e3:.4g} ms, the policy's period is {period * 1e3:.4g} ms"
        if broken > BROKEN:
            shown = f"{np.quantile(gaps, 0.1) * 1e3:.4g} to {np.quantile(gaps, 0.9) * 1e3:.4g} ms"
            message = f"rows come every {shown}, the policy's period is {period * 1e3:.4g} ms"
        help = "log a row for each command of the policy, when it is sent; or correct `timing` in the spec"
        out.error("LRN051", message, span=Span(log.path), help=help)
    lacking = [name for name in joints if name not in log.joints]
    if lacking:
        message = (
            f"the log has no {listed(lacking)}: it has {len(joints) - len(lacking)} of {len(joints)} joints"
        )
        help = "a delta action is of the whole robot: log every joint, or put the others under `unmanaged`"
        out.error("LRN052", message, span=Span(log.path, 1), help=help)
    for name in names:
        for signal in ("command", "position", "velocity"):
            values = getattr(log.joints[name], signal) if name in log.joints else np.zeros(1)
            if values is None:
                near = log.misnamed(name, [signal])
                out.error(
                    "LRN053", f"no column {name}.{signal}", where=name, span=Span(log.path, 1), help=near
                )
            elif (bad := np.flatnonzero(~np.isfinite(values))).size:
                message = f"the {signal} is not a number in {bad.size} rows"
                help = "leave these rows out: a gap in the time is understood"
                out.error("LRN053", message, where=name, span=log.span(int(bad[0])), help=help)


def _check_signals(actuators: ActuatorSet, logs: Sequence[Log], out: Collector) -> None:
    """Signs, units and exchanged joints, as for a fit; what a fit leaves out is none of a step's business."""
    seen = Collector()
    recorded = {
        joint.joint: [
            found for log in logs if (found := record(log, log.joints[joint.joint], seen)) is not None
        ]
        for joint in actuators.joints
    }
    limits = {joint.joint: joint.position_range for joint in actuators.joints}
    check(recorded, {joint.joint: Bounds.of(joint) for joint in actuators.joints}, limits, seen)
    for item in seen:
        if item.severity is Severity.ERROR:
            out.add(item)


def _free(log: Log, out: Collector) -> Array | None:
    """How the base moved, as `Motion.free`; None: the log does not tell."""
    import numpy as np

    if log.base is None:
        return None
    parts = {signal: getattr(log.base, signal) for signal in BASE}
    if lacking := [f"base.{signal}" for signal, values in parts.items() if values is None]:
        message = f"the base's state is not whole: no {listed(lacking)}"
        out.error(
            "LRN054", message, span=Span(log.path, 1), help="a step of the simulation begins from all of it"
        )
        return None
    for signal, values in parts.items():
        assert values is not None
        if (bad := np.flatnonzero(~np.isfinite(values).all(axis=1))).size:
            message = f"base.{signal} is not a number in {bad.size} rows"
            out.error("LRN053", message, where="base", span=log.span(int(bad[0])))
    turn = parts["orientation"]
    assert turn is not None
    parts["orientation"] = turn / np.linalg.norm(turn, axis=1)[:, None]
    return np.concatenate([values for values in parts.values() if values is not None], axis=1)


def _motion(log: Log, names: Sequence[str], period: float, free: Array | None) -> Motion:
    import numpy as np

    def columns(signal: str) -> Array:
        return np.stack([getattr(log.joints[name], signal) for name in names], axis=1)

    gaps = np.diff(log.time) / period
    first = np.concatenate([[True], (gaps > GAP) | (gaps < 1.0 / GAP)])
    return Motion(columns("position"), columns("velocity"), columns("command"), first, free)


def _joined(names: tuple[str, ...], parts: Sequence[tuple[Log, Plant, Motion]]) -> Samples:
    """The rows that have one before and one after them, of all logs."""
    import numpy as np

    count = len(names)
    states, inputs, after = [], [], []
    plants: list[tuple[Plant, slice]] = []
    logs: list[tuple[str, slice]] = []
    runs: list[tuple[int, int]] = []
    begin = 0
    for log, plant, motion in parts:
        # A gap has no row before the one behind it, and none after the one before it.
        whole = ~motion.first[1:-1] & ~motion.first[2:]
        rows = np.flatnonzero(whole) + 1
        states.append(plant.states(motion)[rows])
        base = [] if motion.free is None else [felt(motion.free[rows])]
        own = (motion.q[rows], motion.qd[rows], motion.command[rows - 1], *base, motion.command[rows])
        inputs.append(np.concatenate(own, axis=1))
        after.append(np.concatenate([motion.q[rows + 1], motion.qd[rows + 1]], axis=1))
        part = slice(begin, begin + len(rows))
        plants.append((plant, part))
        logs.append((log.path, part))
        ends = np.flatnonzero(np.diff(rows) > 1) + 1
        for stretch in np.split(np.arange(len(rows)), ends):
            if len(stretch):
                runs.append((begin + int(stretch[0]), len(stretch)))
        begin = part.stop
    columns = [f"{name}.{signal}" for signal in SIGNALS for name in names]
    if inputs[0].shape[1] > 4 * count:
        columns += [f"base.{signal}.{component}" for signal in FELT for component in BASE[signal][0]]
    columns += [f"{name}.command" for name in names]
    return Samples(
        names,
        np.concatenate(states),
        np.concatenate(inputs),
        tuple(columns),
        np.concatenate(after),
        tuple(plants),
        tuple(logs),
        tuple(runs),
    )
