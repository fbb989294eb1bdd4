"""From logs to samples of a network: rows of each joint with the samples before them, none over a gap.

A row is what was read at its time and the command sent then, so its torque answers to the command of the row before. A
sample's inputs are command - position, of the command that had arrived, and velocity of its row and of rows a tap
period apart before it; its torque is that of its row.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, listed
from actspec.ir import ActuatorSet, Command, JointActuator
from actspec.logs import Log, LogError
from actspec.sysid.checks import check
from actspec.sysid.figures import Bounds
from actspec.sysid.fit import joints_of
from actspec.sysid.recording import GAP, Recording, record, usual
from actspec.units import format_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Rows = NDArray[np.intp]

SAME_RATE = 0.01
"""Share by which steps of logs may differ and still be one rate. Chosen: clocks are better."""
WHOLE = 1e-3
"""How near a ratio of times must be to a whole number."""
USUAL = 4e-3
"""Delay of a drive of which none is known, beyond whole rows [s]. Chosen: of a bus and a control loop."""
HELD_OUT = 0.2
"""Share of the rows to validate on."""
LONGEST = 0.06
"""Longest delay with which a torque is expected to follow its command [s]."""
BROKEN = 0.25
"""Share of steps longer than the usual one from which on a log has two rates. Chosen: gaps are rare."""
OTHER = 0.3
"""Share by which the step that is usual around a row may differ from the whole log's. Chosen: one row in four that
is missing makes it 0.25, a clock that jitters by half a step 0.06 as a standard deviation."""
STRETCH = 0.05
"""Share of the time with another step from which on a log has two rates. Chosen: a second in twenty."""


@dataclass(frozen=True, slots=True)
class Track:
    """One joint in one log, on the rows of the network.

    Attributes:
        log: Where it comes from.
        joint: Its name.
        time: [s], shape (n,).
        command: Sent when the row was read [rad or m], likewise; NaN where there is none.
        position: As read [rad or m]; NaN where left out.
        velocity: [rad/s or m/s].
        torque: [N*m or N]; NaN where there is none.
        stride: Rows between two taps.
        rows: Rows with a whole history behind them.
        taps: Which past samples; 0 is the row's own.
        arrived: Whether a sample's own command is that of its row, not that of the row before.
        slack: How far the torque may be from what `torque` says [N*m or N], shape (n,); None: not at all.
    """

    log: Log
    joint: str
    time: Array
    command: Array
    position: Array
    velocity: Array
    torque: Array
    stride: int
    rows: Rows
    taps: tuple[int, ...]
    arrived: bool = False
    slack: Array | None = None

    @property
    def in_force(self) -> Array:
        """The command that a drive had when the row was read [rad or m], shape (n,); NaN in the first row."""
        import numpy as np

        return np.concatenate([[np.nan], self.command[:-1]])

    @property
    def reach(self) -> int:
        """Rows to the oldest sample."""
        return self.stride * max(self.taps)

    @property
    def error(self) -> Array:
        """command - position of a sample [rad or m], shape (n,)."""
        return (self.command if self.arrived else self.in_force) - self.position

    def inputs(self, rows: Rows) -> Array:
        """Errors, then velocities, from now back; shape (n_row, 2 n_tap)."""
        import numpy as np

        past = rows[:, None] - self.stride * np.array(self.taps)
        return np.concatenate([self.error[past], self.velocity[past]], axis=1)


@dataclass(frozen=True, slots=True)
class Dataset:
    """All samples of a group.

    Attributes:
        group: Of the spec.
        actuators: Its joints.
        tracks: One for each joint of each log.
        taps: Which past samples, from now back.
        period: Between two taps [s].
        kind: Where the torque was measured: `drive`, `joint`, or `inferred`.
        recordings: As read, by joint, for the dynamics.
    """

    group: str
    actuators: tuple[JointActuator, ...]
    tracks: tuple[Track, ...]
    taps: tuple[int, ...]
    period: float
    kind: str
    recordings: Mapping[str, Sequence[Recording]]

    @property
    def moved(self) -> dict[str, list[tuple[Log, Array]]]:
        """Joint to each of its logs, and its position there without the encoder's bias [rad or m]."""
        found: dict[str, list[tuple[Log, Array]]] = {}
        bias = {actuator.joint: actuator.encoder_bias.value or 0.0 for actuator in self.actuators}
        for track in self.tracks:
            found.setdefault(track.joint, []).append((track.log, track.position - bias[track.joint]))
        return found


def chosen_group(actuators: ActuatorSet, logs: Sequence[Log], group: str | None) -> str:
    """The group that a network is for: the one that is named, or the only one of the logs' joints.

    Raises:
        LogError: there is no such group, or the logs have joints of several.
    """
    groups = list(dict.fromkeys(joint.group for joint in actuators.joints))
    if group is not None:
        if group not in groups:
            message = f"the spec has no group '{group}'"
            raise LogError.of("LRN002", message, where="--group", help=f"groups: {listed(groups)}")
        return group
    logged = {name for log in logs for name in log.joints}
    of = list(dict.fromkeys(joint.group for joint in actuators.joints if joint.joint in logged))
    if len(of) > 1:
        message = f"the logs have joints of {len(of)} groups: {listed(of)}"
        raise LogError.of("LRN002", message, help="a network is of one group: give --group")
    return of[0] if of else groups[0]


def dataset(
    actuators: ActuatorSet,
    logs: Sequence[Log],
    out: Collector,
    *,
    group: str | None = None,
    taps: tuple[int, ...] = (0, 1, 2, 3, 4, 5),
    period: float | None = None,
    torque_of: str | None = None,
    measured: bool = True,
    every_joint: bool = True,
) -> Dataset:
    """The samples of a group's logs.

    Args:
        actuators: The spec, resolved.
        logs: Recordings.
        out: Takes what is found and left out.
        group: Of the spec; None: that of the logs' joints.
        taps: Which past samples; 0 is now.
        period: Between two of them [s]; None: the logs' step.
        torque_of: `drive` or `joint`; None: as the sidecars say.
        measured: Whether a torque is needed.
        every_joint: Whether each joint of the group must be in a log.

    Raises:
        LogError: they cannot be used, with every reason.
    """
    import numpy as np

    names = joints_of(actuators, logs, out)
    out.raise_if_failed(LogError)
    group = chosen_group(actuators, logs, group)
    mine = tuple(joint for joint in actuators.joints if joint.group == group)
    names = [joint.joint for joint in mine if joint.joint in names]
    _check_joints(mine, names, logs, every_joint, out)
    kind = _kind(logs, torque_of, out) if measured else "inferred"
    found = _period(logs, period, out)
    out.raise_if_failed(LogError)
    period = _fitting(actuators, found, None if period is not None else logs[0].path, out)
    if measured:
        _check_torque(names, logs, out)
    out.raise_if_failed(LogError)
    recorded: dict[str, list[Recording]] = {}
    for name in names:
        parts = (record(log, log.joints[name], out) for log in logs if name in log.joints)
        recorded[name] = [part for part in parts if part is not None]
    limits = {joint.joint: joint.position_range for joint in mine}
    recordings = check(recorded, {joint.joint: Bounds.of(joint) for joint in mine}, limits, out)
    out.raise_if_failed(LogError)
    delays = {joint.joint: joint.delay.nominal.value for joint in mine if joint.delay is not None}
    physics = actuators.physics_dt.require()
    tracks = [
        _track(recording, taps, period, delays.get(name), physics, measured, out)
        for name in names
        for recording in recordings[name]
    ]
    for track in tracks:
        if measured and not np.isfinite(track.torque).any():
            message = "the torque tells nothing, as a warning says"
            out.error("LRN006", message, where=track.joint, span=Span(track.log.path))
    out.raise_if_failed(LogError)
    for joint in mine:
        own = [track for track in tracks if track.joint == joint.joint]
        if own and not sum(len(track.rows) for track in own):
            place = Span(own[0].log.path)
            shown = f"{max(taps) + 1} samples of {format_number(period * 1e3, 4)} ms"
            message = f"no row has a history of {shown} behind it" + (" and a torque" if measured else "")
            out.error(
                "LRN005", message, where=joint.joint, span=place, help="log longer, or take fewer --taps"
            )
    check_copies(((track.log.path, track.joint, track.position) for track in tracks), out)
    out.raise_if_failed(LogError)
    return Dataset(group, mine, tuple(tracks), taps, period, kind, recordings)


def _check_joints(
    mine: Sequence[JointActuator], names: Sequence[str], logs: Sequence[Log], every: bool, out: Collector
) -> None:
    wrong = [joint.joint for joint in mine if joint.command is not Command.POSITION]
    if wrong:
        message = f"its command is {mine[0].command.value}, and networks take position errors"
        out.error("LRN003", message, where=listed(wrong), help="write command: position in the group")
    lacking = [joint.joint for joint in mine if joint.joint not in names]
    if lacking and (every or not names):
        message = f"no log has {listed(lacking)} of group {mine[0].group}"
        help = "a network is used for every joint of its group: log each, or put the others into a group of their own"
        out.error("LRN004", message, where=mine[0].group, span=Span(logs[0].path, 1), help=help)


def _check_torque(names: Sequence[str], logs: Sequence[Log], out: Collector) -> None:
    for log in logs:
        lacking = [n for n in names if n in log.joints and log.joints[n].torque is None]
        if lacking:
            current = all(log.joints[name].current is not None for name in lacking)
            message = f"no column {listed(f'{name}.torque' for name in lacking)}"
            named = next((help for n in lacking if (help := log.misnamed(n, ["torque"]))), None)
            help = named or "train with --torque inferred, which needs none"
            if current:
                help = "a current is no torque: log it times torque constant and gear, or train with --torque inferred"
            out.error("LRN006", message, where=lacking[0], span=Span(log.path, 1), help=help)


def _kind(logs: Sequence[Log], torque_of: str | None, out: Collector) -> str:
    """Where the torque was measured."""
    if torque_of is not None:
        return torque_of
    said = {log.path: log.sidecar.torque for log in logs}
    kinds = {kind for kind in said.values() if kind is not None}
    if len(kinds) > 1:
        shown = listed(f"{kind} in {path}" for path, kind in said.items())
        out.error("LRN007", f"the torque was not measured at one place: {shown}", help="give --torque-of")
    if not kinds:
        help = "give --torque-of, or write `torque: drive` or `torque: joint` beside the log"
        message = "no sidecar says where the torque was measured: taken as the drive's, before friction"
        out.info("LRN007", message, help=help)
    return next(iter(kinds), "drive")


def _period(logs: Sequence[Log], period: float | None, out: Collector) -> float:
    """Time between two taps [s]."""
    import numpy as np

    steps = {log.path: log.step for log in logs}
    for log in logs:
        _check_rate(log, out)
    if period is not None:
        for path, step in steps.items():
            if period < step * (1.0 - SAME_RATE):
                shown = (
                    f"{format_number(step * 1e3, 4)} ms, a tap period of {format_number(period * 1e3, 4)} ms"
                )
                help = "a history's samples are rows: log faster, or take a longer period"
                out.error("LRN008", f"a row comes every {shown} is shorter", span=Span(path), help=help)
        return period
    if max(steps.values()) > (1.0 + SAME_RATE) * min(steps.values()):
        shown = listed(f"{step * 1e3:.4g} ms in {path}" for path, step in steps.items())
        help = "give --tap-period: the logs are brought to it"
        out.error("LRN008", f"the logs have different rates: {shown}", span=Span(logs[0].path), help=help)
    return float(np.median(list(steps.values())))


def _check_rate(log: Log, out: Collector) -> None:
    """Rows of two rates, in turn or one after the other; single ones that are missing are gaps."""
    import numpy as np
    from scipy.ndimage import uniform_filter1d

    gaps, step = np.diff(log.time), log.step
    # Rows of 2.5 ms with stamps in milliseconds come after 2 and 3 ms: that is one rate.
    even = uniform_filter1d(gaps, 4, mode="nearest")
    around, middle = usual(even), float(np.median(even))
    # A loop may go faster while the drives are off: no row of that time is learned.
    off = [joint.enabled == 0.0 for joint in log.joints.values() if joint.enabled is not None]
    driven = np.ones(len(log.time), dtype=bool)
    if off and len(off) == len(log.joints):
        driven = ~np.all(off, axis=0)
    other, long, short = (
        found & driven[1:]
        for found in (np.abs(around / middle - 1.0) > OTHER, gaps > GAP * step, gaps < step / 1.8)
    )
    stretch = float(around[other].sum()) > STRETCH * float(around.sum())
    if not stretch and max(float(np.mean(long)), float(np.mean(short))) <= BROKEN:
        return
    ends = (middle, float(np.median(around[other]))) if stretch else np.quantile(gaps, (0.1, 0.9))
    shown = " and ".join(format_number(end * 1e3, 4) for end in sorted(ends))
    first = int(np.flatnonzero(other if stretch else long | short)[0])
    help = "log at one rate, or give each part as a log of its own"
    out.error("LRN008", f"the rows come at two rates, {shown} ms apart", span=log.span(first + 1), help=help)


def _fitting(actuators: ActuatorSet, period: float, log: str | None, out: Collector) -> float:
    """The period, which is a log's or, where no path of one is given, was asked for, as a whole number of steps."""
    step = actuators.physics_dt.value
    if step is None:
        message = "timing.physics_dt is unknown, and a network's samples are physics steps apart"
        out.error("LRN009", message, where="timing.physics_dt", span=actuators.physics_dt.span)
        return period
    count = round(period / step)
    # A logged step has the jitter of its clock.
    near = WHOLE if log is None else SAME_RATE
    if count < 1 or abs(period / step - count) > near * count:
        best = max(1, math.ceil(period / step - WHOLE)) * step
        what = "the tap period is" if log is None else "a row comes every"
        steps = f"physics steps of {format_number(step * 1e3)} ms"
        message = f"{what} {format_number(period * 1e3, 4)} ms, no whole number of {steps}"
        help = f'give --tap-period "{format_number(best * 1e3)} ms", or another timing.physics_dt'
        where, place = ("--tap-period", actuators.physics_dt.span) if log is None else ("", Span(log))
        out.error("LRN009", message, where=where, span=place, help=help)
        return period
    return count * step


def _track(
    recording: Recording,
    taps: tuple[int, ...],
    period: float,
    delay: float | None,
    physics: float,
    measured: bool,
    out: Collector,
) -> Track:
    """A joint's rows; where the period is no whole number of rows, brought to it between them."""
    import numpy as np

    time, command = recording.time, recording.command
    position = recording.measured["position"]
    velocity = recording.measured.get("velocity")
    if velocity is None:
        out.info(
            "LRN010",
            "no usable velocity was logged: the position's derivative is taken",
            where=recording.joint,
            span=Span(recording.log.path),
        )
        velocity = np.where(np.isfinite(position), recording.velocity, np.nan)
    torque = recording.measured.get("torque", np.full(len(time), np.nan))
    step = recording.step
    stride = max(1, round(period / step))
    if abs(period / step - stride) > SAME_RATE * stride:
        # Between rows; a command is held.
        fresh = np.arange(time[0], time[-1], period)
        late = np.searchsorted(time, fresh, side="right") - 1
        apart = time[np.minimum(late + 1, len(time) - 1)] - time[late]

        def between(signal: Array) -> Array:
            good = np.isfinite(signal)
            if not good.any():
                return np.full(len(fresh), np.nan)
            sound = good[late] & good[np.minimum(late + 1, len(time) - 1)] & (apart < GAP * step)
            return np.where(sound, np.interp(fresh, time[good], signal[good]), np.nan)

        position, velocity, torque = between(position), between(velocity), between(torque)
        # What is in force at a time was sent at the one before.
        command = command[np.append(late[1:], late[-1])]
        time, step, stride = fresh, period, 1
    track = Track(
        recording.log,
        recording.joint,
        time,
        command,
        position,
        velocity,
        torque,
        stride,
        np.empty(0, int),
        taps,
        arrived=has_arrived(delay, step, physics),
    )
    return with_rows(track, torque, needed=measured)


def has_arrived(delay: float | None, step: float, physics: float) -> bool:
    """Whether a sample's own command is that of its row, so that the network learns one row more of delay.

    Rows tell a delay to a row: a drive that answers between two of them may have any command of the row before. A
    simulator steps speeds first, and moves a joint half a physics step before its torque would. What then comes nearer
    to the drive's delay is taken. Where both are as near, as of whole rows that are physics steps, it is the row more:
    a network's torque is computed before the step, with a speed that is half a step old, so that a joint comes earlier
    still.

    Args:
        delay: Of the drive by the spec [s]; None: it is not known.
        step: Between two rows [s].
        physics: Physics step [s].
    """
    over = min(USUAL, 0.5 * step) if delay is None else delay - step * math.floor(delay / step + WHOLE)
    return over > 0.5 * (step - physics) - WHOLE * step


def with_rows(track: Track, torque: Array, *, needed: bool = True) -> Track:
    """A track with its torque, and the rows with a whole history, and with a torque where one is needed."""
    import numpy as np

    n, reach = len(track.time), track.reach
    told = np.isfinite(track.error) & np.isfinite(track.velocity)
    whole = np.zeros(n, dtype=bool)
    if n > reach:
        step = float(np.median(np.diff(track.time)))
        whole[reach:] = np.isfinite(torque[reach:]) if needed else True
        for tap in track.taps:
            whole[reach:] &= told[reach - tap * track.stride : n - tap * track.stride]
        length = track.time[reach:] - track.time[: n - reach]
        whole[reach:] &= np.abs(length - reach * step) < 0.5 * step * max(1, track.stride)
    return replace(track, torque=torque, rows=np.flatnonzero(whole))


def check_copies(positions: Iterable[tuple[str, str, Array]], out: Collector) -> None:
    """One joint's readings in the columns of several.

    Args:
        positions: Path of a log, joint, and its positions [rad or m].
        out: Takes the errors.
    """
    import numpy as np

    seen: dict[tuple[str, bytes], str] = {}
    for path, joint, position in positions:
        other = seen.setdefault((path, np.round(position, 9).tobytes()), joint)
        if other != joint:
            message = f"all positions are those of {other}, to the last digit"
            help = "one joint's data do not stand for another's"
            out.error("LRN004", message, where=joint, span=Span(path), help=help)


@dataclass(frozen=True, slots=True)
class Split:
    """Rows to train on and to validate on, for each track of a dataset.

    Attributes:
        train, validate: Rows, one array a track.
        logs: Paths of what is validated on.
        whole: Whether those are whole recordings.
    """

    train: tuple[Rows, ...]
    validate: tuple[Rows, ...]
    logs: tuple[str, ...]
    whole: bool


def split(data: Dataset) -> Split:
    """Hold out the last recordings whose joints are in others too; else the last block of each recording."""
    import numpy as np

    paths = list(dict.fromkeys(track.log.path for track in data.tracks))
    rows = {path: sum(len(t.rows) for t in data.tracks if t.log.path == path) for path in paths}
    out: list[str] = []
    for path in reversed(paths):
        if sum(rows[p] for p in out) >= HELD_OUT * sum(rows.values()):
            break
        kept = {t.joint for t in data.tracks if t.log.path not in (*out, path) and len(t.rows)}
        if kept >= {t.joint for t in data.tracks}:
            out.append(path)
    if out:
        none = np.empty(0, dtype=np.intp)
        train = tuple(none if t.log.path in out else t.rows for t in data.tracks)
        validate = tuple(t.rows if t.log.path in out else none for t in data.tracks)
        return Split(train, validate, tuple(path for path in paths if path in out), True)
    train_rows, validate_rows = [], []
    for track in data.tracks:
        first = len(track.time) - round(HELD_OUT * len(track.time))
        reach = track.reach
        train_rows.append(track.rows[track.rows < first - reach])
        validate_rows.append(track.rows[track.rows >= first])
    return Split(tuple(train_rows), tuple(validate_rows), tuple(paths), False)


def gathered(data: Dataset, rows: Sequence[Rows]) -> tuple[Array, Array, NDArray[np.intp]]:
    """Inputs, shape (n, 2 n_tap), torques and joint indices, shape (n,), of chosen rows of each track."""
    import numpy as np

    index = {joint.joint: i for i, joint in enumerate(data.actuators)}
    x = [track.inputs(mine) for track, mine in zip(data.tracks, rows, strict=True)]
    y = [track.torque[mine] for track, mine in zip(data.tracks, rows, strict=True)]
    j = [np.full(len(mine), index[t.joint]) for t, mine in zip(data.tracks, rows, strict=True)]
    return np.concatenate(x), np.concatenate(y), np.concatenate(j)


def slacks(data: Dataset, rows: Sequence[Rows]) -> Array:
    """How far torques may be from what is said of them [N*m or N], shape (n,), in the order of `gathered`."""
    import numpy as np

    parts = [
        np.zeros(len(mine)) if track.slack is None else track.slack[mine]
        for track, mine in zip(data.tracks, rows, strict=True)
    ]
    return np.concatenate(parts)
