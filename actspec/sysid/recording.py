"""A joint's part of a log, ready for a fit: even rows, what is left out, and pieces.

Rows that were dropped are put in again, without readings, the command between its neighbours; a longer gap ends a
stretch. What a filter makes of the readings is used to begin with and for the links alone: the fit sees the readings.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, listed, many
from actspec.fields import units_of
from actspec.ir import JointActuator
from actspec.joints import JointKind
from actspec.logs import JointLog, Log
from actspec.sysid.descent import EXACT
from actspec.sysid.spoilt import MOST, frozen, jumps, wild
from actspec.units import format_number, format_quantity

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

GAP, MOST_GAP = 1.5, 1.8
"""Usual row times from which on rows are missing, where rows come evenly and where they do not. Chosen: behind a row
that is missing, the next comes after two."""
AROUND = 31
"""Rows by which that is told."""
UNEVEN = 4.0
"""Standard deviations of the time between two rows that are no sign of a missing row."""
FILLED = 10
"""Most missing rows in a row that are put in again. Chosen: a command changes little in 20 ms."""
PIECE = 1.0
"""Length of a piece [s]. Chosen: far longer than a joint remembers how it began, and short enough for sixty of them
in a minute."""
LEAST_PIECE = 30
"""Fewest rows of a piece."""
LEAST_TIME = 0.2
"""Least length of a piece [s]. Chosen: a drive's oscillation is longer."""
SWITCHED = 0.06
"""Time after the drive goes on or off that is in no piece [s]. Chosen: as long as the longest delay; a command that was
sent before still acts, or does not yet."""
LEAST_ROWS = 100
"""Fewest rows that are judged by shares and correlations."""
HUGE = 1e6
"""Command beyond which it is none [rad or m]. Chosen: a wheel turns less in a day."""
FEW = 0.01
"""Share of the commands either way that do not count where it is told how far the others reach."""
SMOOTH = 0.012
"""Width of the filter [s]. Chosen: it keeps what legs do, and the fit puts right what noise it leaves."""


@dataclass(frozen=True, slots=True)
class Recording:
    """One joint in one log, on rows without short gaps.

    Attributes:
        log: Where it comes from.
        joint: Its name.
        time: [s], shape (n,).
        command: [rad or m], likewise.
        speed_command: [rad/s or m/s]; 0 where none was logged.
        measured: `position`, and `velocity` and `torque` where they were logged; NaN where left out, and where the
            drive is off.
        off: Whether the drive is off, shape (n,).
        released: `position` and `velocity` with the drive off; NaN elsewhere, and where left out.
        position: Without gaps, smoothed, on and off [rad or m].
        velocity: Likewise [rad/s or m/s].
        acceleration: Likewise [rad/s^2 or m/s^2].
        starts: First rows of the pieces.
        rows: Length of each.
        late: Rows by which the torque was logged late, taken out of it; before `prompt`, by which it seems to be.
        ago: By how much the torque is older than its row yet [s].
    """

    log: Log
    joint: str
    time: Array
    command: Array
    speed_command: Array
    measured: dict[str, Array]
    off: NDArray[np.bool_]
    released: dict[str, Array]
    position: Array
    velocity: Array
    acceleration: Array
    starts: NDArray[np.intp]
    rows: int
    late: int = 0
    ago: float = 0.0

    @property
    def kind(self) -> JointKind:
        """Of the joint, by its units."""
        return self.log.joints[self.joint].kind

    @property
    def step(self) -> float:
        """The usual time between two rows [s]."""
        import numpy as np

        return float(np.median(np.diff(self.time)))

    def place(self, row: int | None = None) -> Span:
        """The file, or a row of it."""
        import numpy as np

        if row is None:
            return Span(self.log.path)
        return self.log.span(int(np.searchsorted(self.log.time, self.time[row], side="right")) - 1)


def record(log: Log, joint: JointLog, out: Collector) -> Recording | None:
    """A joint's part of a log; None after an error.

    Args:
        log: The log.
        joint: The joint's columns.
        out: Takes what is wrong, and what is left out.
    """
    import numpy as np

    place = Span(log.path)
    lacking = [name for name in ("command", "position") if getattr(joint, name) is None]
    if lacking:
        message = f"no column {listed([f'{joint.name}.{name}' for name in lacking])}"
        help = log.misnamed(joint.name, lacking) or "a fit needs command and position"
        out.error("SYS010", message, where=joint.name, span=place, help=help)
        return None
    assert joint.command is not None and joint.position is not None
    told = np.isfinite(joint.command)
    if told.mean() < 0.5:
        message = f"the command is not a number in {int((~told).sum())} of {len(told)} rows"
        out.error("SYS010", message, where=joint.name, span=place, help="log the command in every row")
        return None
    unit = units_of(joint.kind).position
    far = told & (np.abs(joint.command) > HUGE)
    if far.any():
        row = int(np.flatnonzero(far)[0])
        worst = format_number(float(joint.command[row]), 3)
        message = f"the command is {worst} {unit} in {many(int(far.sum()), 'row')}"
        help = "no joint goes there: correct the cell, or leave it empty"
        out.error("SYS017", message, where=joint.name, span=log.span(row), help=help)
        return None
    if np.ptp(joint.command[told]) == 0.0:
        shown = format_quantity(float(joint.command[told][0]), unit, 4)
        message = f"the command is {shown} in every row: nothing moves the joint"
        out.error(
            "SYS011", message, where=joint.name, span=place, help="`actspec sysid design` writes commands"
        )
        return None
    measured = {"position": joint.position}
    for name in ("velocity", "torque"):
        signal = getattr(joint, name)
        if signal is not None:
            measured[name] = signal
    for name, signal in list(measured.items()):
        fault = _unusable(signal)
        if fault and name == "position":
            out.error("SYS011", f"the position {fault}", where=joint.name, span=place)
            return None
        if fault:
            out.warning("SYS012", f"the {name} {fault}: it is left out", where=joint.name, span=place)
            del measured[name]
    off = joint.enabled == 0.0 if joint.enabled is not None else np.zeros(len(log.time), dtype=bool)
    if off.any():
        message = f"{int(off.sum())} rows with the drive off: no command acts there"
        out.info("SYS013", message, where=joint.name, span=place)
    whole = {name: np.where(np.isfinite(signal), signal, np.nan) for name, signal in measured.items()}
    measured = {name: np.where(off, np.nan, signal) for name, signal in whole.items()}
    bad = int(np.isnan(measured["position"]).sum() - off.sum())
    if bad > 0:
        first = log.span(int(np.flatnonzero(np.isnan(measured["position"]) & ~off)[0]))
        out.info("SYS013", f"{bad} rows have no position: they are left out", where=joint.name, span=first)
    for name in sorted(measured.keys() - {"position"}):
        lost = np.isnan(measured[name]) & ~off & ~np.isnan(measured["position"])
        if lost.any() and not lost.all():
            first = log.span(int(np.flatnonzero(lost)[0]))
            message = f"{int(lost.sum())} rows have no {name}: they are left out of it"
            out.info("SYS013", message, where=joint.name, span=first)
    given = np.interp(log.time, log.time[told], joint.command[told])
    spikes = _spikes(given)
    if spikes.any():
        row = int(np.flatnonzero(spikes)[0])
        message = (
            f"the command jumps to {format_number(float(given[row]), 3)} {unit} and back in "
            f"{many(int(spikes.sum()), 'row')}, further than it goes in all others"
        )
        help = "leave the cell empty where the drive did not get it"
        out.warning("SYS017", message, where=joint.name, span=log.span(row), help=help)
    measured = _sound(log, joint.name, given, measured, out)
    released = {name: np.where(off, whole[name], np.nan) for name in measured if name != "torque"}
    if off.any():
        released = _sound(log, joint.name, given, released, out)
    if np.isfinite(measured["position"]).mean() < 0.2:
        message = "no stretch of the position is sound"
        out.error("SYS011", message, where=joint.name, span=place)
        return None
    speed = joint.velocity_command if joint.velocity_command is not None else np.zeros(len(log.time))
    rows_told = np.flatnonzero(told)
    time, index, fresh = _filled(log.time[told])
    index = rows_told[index]
    if fresh.any():
        message = f"{int(fresh.sum())} rows are missing: the command between its neighbours is taken there"
        out.info("SYS013", message, where=joint.name, span=place)
    gaps = np.flatnonzero(np.diff(time) > longest_step(time))
    if len(gaps):
        first = log.span(int(np.searchsorted(log.time, time[gaps[0]])))
        longest = float(np.diff(time)[gaps].max())
        shown = (
            f"{longest:.3g} s without rows"
            if len(gaps) == 1
            else f"{len(gaps)} gaps, up to {longest:.3g} s without rows"
        )
        out.info("SYS013", f"{shown}: nothing is read across", where=joint.name, span=first)
    command = np.interp(time, log.time, given)
    measured, released = (
        {name: np.where(fresh, np.nan, signal[index]) for name, signal in readings.items()}
        for readings in (measured, released)
    )
    off = off[index]
    # A row that was put in lacks no reading.
    starts, rows = _pieces(time, np.where(fresh, 0.0, measured["position"]), off)
    if not len(starts):
        message = "no stretch of the log is long enough for a fit"
        out.error(
            "SYS011", message, where=joint.name, span=place, help="log at least two seconds without a gap"
        )
        return None
    position, velocity, acceleration = _motion(time, measured, off, released)
    speed = np.interp(time, log.time, np.nan_to_num(speed))
    return Recording(
        log,
        joint.name,
        time,
        command,
        speed,
        measured,
        off,
        released,
        position,
        velocity,
        acceleration,
        starts,
        rows,
    )


def _spikes(command: Array) -> NDArray[np.bool_]:
    """Single commands that are as far from those before and behind as those reach at all, shape (n,)."""
    import numpy as np

    if len(command) < LEAST_ROWS:
        return np.zeros(len(command), dtype=bool)
    low, high = np.quantile(command, [FEW, 1.0 - FEW])
    before = np.abs(np.diff(command, prepend=command[0]))
    behind = np.abs(np.diff(command, append=command[-1]))
    outside = (command < low - (high - low)) | (command > high + (high - low))
    found: NDArray[np.bool_] = outside & (np.minimum(before, behind) > high - low) & (high > low)
    return found


def _motion(
    time: Array, measured: dict[str, Array], off: NDArray[np.bool_], released: dict[str, Array]
) -> tuple[Array, Array, Array]:
    """Position, velocity and acceleration without gaps, smoothed, with the drive on and off."""
    import numpy as np

    return _smooth(time, {name: np.where(off, signal, measured[name]) for name, signal in released.items()})


def without_velocity(recording: Recording) -> Recording:
    """The recording as if its velocity had not been logged."""
    measured, released = (
        {name: signal for name, signal in readings.items() if name != "velocity"}
        for readings in (recording.measured, recording.released)
    )
    return _with(recording, measured, released)


def earlier(recording: Recording, rows: int) -> Recording:
    """The recording with its position as that of so many rows earlier, for it was read late."""
    import numpy as np

    off = recording.off
    read = np.where(off, recording.released["position"], recording.measured["position"])
    position = _rows_on(recording.time, read, rows)
    measured = {**recording.measured, "position": np.where(off, np.nan, position)}
    released = {**recording.released, "position": np.where(off, position, np.nan)}
    return _with(recording, measured, released)


def with_torque_of(recording: Recording, rows: int) -> Recording:
    """The recording with its torque as that of so many rows earlier, for it was logged late; below 0: later."""
    if not rows or "torque" not in recording.measured:
        return recording
    torque = _rows_on(recording.time, recording.measured["torque"], rows)
    late = recording.late + rows
    return replace(recording, measured={**recording.measured, "torque": torque}, late=late)


def _rows_on(time: Array, signal: Array, rows: int) -> Array:
    """At each row what a signal is so many rows on, NaN where that is across a gap or no row."""
    import numpy as np

    gaps = np.concatenate([[0], np.cumsum(np.diff(time) > longest_step(time))])
    at = np.arange(len(time)) + rows
    there = np.clip(at, 0, len(time) - 1)
    # Behind a gap is another moment.
    return np.where((there == at) & (gaps[there] == gaps), signal[there], np.nan)


def _with(recording: Recording, measured: dict[str, Array], released: dict[str, Array]) -> Recording:
    """The recording with other readings."""
    position, velocity, acceleration = _motion(recording.time, measured, recording.off, released)
    return replace(
        recording,
        measured=measured,
        released=released,
        position=position,
        velocity=velocity,
        acceleration=acceleration,
    )


def driven(log: Log, joint: JointLog, actuator: JointActuator, out: Collector) -> JointLog:
    """A joint's columns with current times torque constant as the torque, where that was not logged.

    Args:
        log: The log.
        joint: The joint's columns.
        actuator: Its drive by the spec, whose motor may state a torque constant.
        out: Takes what the current is used for.
    """
    if joint.torque is not None or joint.current is None:
        return joint
    place, stated = Span(log.path), log.sidecar.torque_constant_of(joint.name)
    whose = "by the sidecar"
    unit = "N/A" if joint.linear else "N*m/A"
    if stated is None and actuator.torque_constant is not None and actuator.torque_constant.value is not None:
        stated, whose = actuator.torque_constant.value, "by the spec's motor"
    if stated is None:
        message = "the current is not used: no torque constant is known"
        help = f"state it, gears counted, in the sidecar: `torque_constant: {{{joint.name}: ... {unit}}}`"
        out.info("SYS044", message, where=joint.name, span=place, help=help)
        return joint
    message = f"the torque is the current times {format_number(stated)} {unit}, {whose}"
    out.info("SYS044", message, where=joint.name, span=place)
    return replace(joint, torque=stated * joint.current)


def _sound(
    log: Log, joint: str, command: Array, measured: dict[str, Array], out: Collector
) -> dict[str, Array]:
    """The readings without wild ones and without those that stand still, both reported."""
    import numpy as np

    found = {}
    for name, signal in measured.items():
        rows = wild(signal, None if name == "position" else jumps(command, log.step))
        share = float(rows.mean())
        if share > MOST:
            message = f"{share:.0%} of the readings of the {name} jump away from those around them"
            out.warning("SYS017", message, where=joint, span=log.span(int(np.flatnonzero(rows)[0])))
        elif rows.any():
            message = f"wild readings of the {name} are left out in {int(rows.sum())} of {len(rows)} rows"
            out.info("SYS013", message, where=joint, span=log.span(int(np.flatnonzero(rows)[0])))
            signal = np.where(rows, np.nan, signal)
        found[name] = signal
    still = frozen(log.time, command, found)
    everywhere = (
        np.logical_and.reduce(list(still.values())) if len(still) > 1 else np.zeros(len(command), bool)
    )
    parts = {
        "all readings": everywhere,
        **{f"the {name}": rows & ~everywhere for name, rows in still.items()},
    }
    for what, rows in parts.items():
        if rows.any():
            verb = "stand" if what == "all readings" else "stands"
            message = (
                f"{what} {verb} still in {int(rows.sum())} rows while the command moves: they are left out"
            )
            out.warning("SYS013", message, where=joint, span=log.span(int(np.flatnonzero(rows)[0])))
    return {name: np.where(still[name], np.nan, signal) for name, signal in found.items()}


def _unusable(signal: Array) -> str | None:
    """Why a signal tells nothing."""
    import numpy as np

    finite = signal[np.isfinite(signal)]
    if len(finite) < 0.5 * len(signal):
        return f"is not a number in {len(signal) - len(finite)} of {len(signal)} rows"
    if np.ptp(finite) == 0.0:
        return f"is {format_number(float(finite[0]), 4)} in every row"
    return None


def usual(gaps: Array) -> Array:
    """The usual time between two rows, as it is around each [s]: a loop may go faster while the drive is off."""
    from scipy.ndimage import median_filter

    found: Array = median_filter(gaps, AROUND, mode="nearest")
    return found


def longest_step(time: Array) -> Array:
    """The times between two rows from which on rows are missing [s], shape (n - 1,).

    1.5 times what is usual there, and more where a clock jitters.
    """
    import numpy as np

    most = min(max(GAP, 1.0 + UNEVEN * unevenness(time)), MOST_GAP)
    return np.asarray(most * usual(np.diff(time)), dtype=float)


def unevenness(time: Array) -> float:
    """Standard deviation of the time between two rows, as a share of what is usual there."""
    import numpy as np

    gaps = np.diff(time)
    return 1.4826 * float(np.median(np.abs(gaps / usual(gaps) - 1.0)))


def _filled(time: Array) -> tuple[Array, NDArray[np.intp], NDArray[np.bool_]]:
    """Times with missing rows put in, the old row of each, and which are new."""
    import numpy as np

    gaps = np.diff(time)
    missing = np.where(gaps > longest_step(time), np.round(gaps / usual(gaps)) - 1, 0).astype(int)
    missing[missing > FILLED] = 0
    index = np.repeat(np.arange(len(time)), np.append(missing, 0) + 1)
    rank = np.arange(len(index)) - np.searchsorted(index, index)
    length = np.append(gaps, 0.0)[index] / (np.append(missing, 0)[index] + 1)
    return time[index] + rank * length, index, rank > 0


def _pieces(time: Array, position: Array, off: NDArray[np.bool_]) -> tuple[NDArray[np.intp], int]:
    """First rows of pieces of equal length, none over a gap or with the drive off, and the length."""
    import numpy as np

    usual = float(np.median(np.diff(time)))
    found = stretches(time, ~off)
    longest = max((last - first for first, last in found), default=0)
    rows = min(max(round(PIECE / usual), LEAST_PIECE), longest)
    if rows < LEAST_PIECE or rows * usual < LEAST_TIME:
        return np.empty(0, dtype=np.intp), rows
    return cut(found, rows, position), rows


def stretches(time: Array, wanted: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First rows, and those after the last, of what is wanted without a gap.

    Args:
        time: [s], shape (n,).
        wanted: Whether the drive is on, or off; after each change some time is left out.
    """
    import numpy as np

    gaps = np.diff(time)
    usual = float(np.median(gaps))
    turns = wanted[1:] != wanted[:-1]
    ends = np.flatnonzero((gaps > longest_step(time)) | turns) + 1
    both = zip([0, *ends.tolist()], [*ends.tolist(), len(time)], strict=True)
    wait = math.ceil(SWITCHED / usual)
    found = [
        (first + wait if first and turns[first - 1] else first, last) for first, last in both if wanted[first]
    ]
    return [(first, last) for first, last in found if last > first]


def cut(found: Sequence[tuple[int, int]], rows: int, position: Array) -> NDArray[np.intp]:
    """First rows of pieces of so many rows, half of which at least have a position."""
    import numpy as np

    starts = [
        start
        for first, last in found
        for start in range(first, last - rows + 1, rows)
        if np.isfinite(position[start : start + rows]).mean() > 0.5
    ]
    return np.array(starts, dtype=np.intp)


def _smooth(time: Array, measured: dict[str, Array]) -> tuple[Array, Array, Array]:
    """Position, speed and acceleration by a local cubic."""
    position, velocity, acceleration = (smooth(time, measured["position"], SMOOTH, d) for d in range(3))
    if "velocity" in measured:
        acceleration = smooth(time, measured["velocity"], SMOOTH, 1)
    return position, velocity, acceleration


def smooth(time: Array, signal: Array, width: float, derivative: int = 0) -> Array:
    """A signal, or its derivative, by a local cubic; what is not a number is filled by a straight line.

    Args:
        time: [s], shape (n,).
        signal: Likewise.
        width: Of the cubic [s].
        derivative: Which.
    """
    import numpy as np
    from scipy.signal import savgol_filter

    gaps = np.diff(time)
    rows = max(round(width / float(np.median(gaps))) // 2 * 2 + 1, 5)
    good = np.isfinite(signal)
    filled = np.interp(time, time[good], signal[good])
    found = np.zeros(len(time))
    # Across a gap the signal jumps, which is no speed.
    for part in np.split(np.arange(len(time)), np.flatnonzero(gaps > longest_step(time)) + 1):
        wide = min(rows, (len(part) - 1) // 2 * 2 - 1)
        if wide < 5:
            found[part] = filled[part] if derivative == 0 else 0.0
            continue
        course, first, second = (savgol_filter(filled[part], wide, 3, deriv=d) for d in range(3))
        if derivative == 0:
            found[part] = course
            continue
        # By row at first. The rows' own times go through the same cubic, so that a clock may jitter or change its rate.
        rate, change = (savgol_filter(time[part], wide, 3, deriv=d) for d in (1, 2))
        speed = first / rate
        found[part] = speed if derivative == 1 else (second - speed * change) / rate**2
    return found


def scatter(signal: Array, time: Array | None = None) -> float:
    """Standard deviation of a signal's noise, from what a local parabola leaves of it.

    Args:
        signal: NaN where it is unknown, shape (n,).
        time: Of its rows, likewise; None: even. With a clock that jitters, a joint's speed would count as noise.
    """
    import numpy as np

    rows = np.arange(len(signal), dtype=float) if time is None else time
    at = [rows[i : len(rows) - 3 + i] for i in range(4)]
    # Divided differences, of which the first, middle and last row of even ones are 1, 3, 3, 1.
    weights = [1.0 / np.prod([at[i] - at[j] for j in range(4) if j != i], axis=0) for i in range(4)]
    size = np.sqrt(sum(weight**2 for weight in weights))
    third = sum(weight * signal[i : len(signal) - 3 + i] for i, weight in enumerate(weights)) / size
    left = np.abs(third[np.isfinite(third)])
    return 1.4826 * float(np.median(left)) if len(left) else 0.0


def reading_noise(recordings: Sequence[Recording]) -> float:
    """Noise of the position's readings [rad or m]."""
    import numpy as np

    # What is no number keeps the recordings apart.
    readings = [np.append(recording.measured["position"], np.nan) for recording in recordings]
    times = [np.append(recording.time, recording.time[-1] + recording.step) for recording in recordings]
    readings_std = max(float(np.nanstd(one)) for one in readings)
    ends = np.cumsum([0.0, *(time[-1] + time[1] - time[0] for time in times[:-1])])
    noise = scatter(
        np.concatenate(readings), np.concatenate([t + e for t, e in zip(times, ends, strict=True)])
    )
    return max(noise, EXACT * readings_std, 1e-9)
