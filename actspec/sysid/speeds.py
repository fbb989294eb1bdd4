"""A joint's velocity against its position: whose it is, its sign, scale and lag, and where rows are missing unseen.

A scale is told by the velocity's integral: sums of noise are small beside a position, and a filter or a few rows of
lag do little to what is slow. What all joints of a log share is the time's.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, many
from actspec.fields import units_of
from actspec.sysid.recording import (
    LEAST_ROWS,
    Recording,
    earlier,
    longest_step,
    smooth,
    without_velocity,
)
from actspec.sysid.spoilt import texture
from actspec.sysid.stand import by_log
from actspec.sysid.torques import EXPLAINED, LATEST, STANDS, rows_of
from actspec.units import format_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SURE = 0.8
"""Correlation from which on two signals are the same thing. Chosen."""
FACTORS = {180.0 / math.pi: "degrees", 30.0 / math.pi: "rpm", 1e3: "thousandths", 2.0 * math.pi: "turns"}
"""Scale to the unit that it is the mark of."""
NEAR = 0.12
"""How near a scale must be to one of these, as a share. Chosen: they are far from each other, and from 1."""
CLEAR = 1.25
"""Factor, or one over it, from which on a scale is another. Measured: 0.94 to 1.003 in virtual logs with noise, counts,
jitter, missing rows and low-passes down to 10 Hz, the least
of them at 50 Hz; behind a low-pass of 3 Hz too little is explained."""
ALIKE = 0.03
"""How near the scales of joints must be to their middle to be one, as a share. Measured: 0.006."""
COUNTS = 10.0
"""Least speed of a joint, as a root mean square in counts of the velocity. Chosen: cut off instead of rounded, it is
a twentieth too small there."""
LEAP = 5.0
"""Rows in which a joint must go as far as it does from one row to the next, at the speed around, to call that a leap.
Chosen: it stops or turns back slower than that, and what is lost in a bus's message or two is less."""
COARSE = 0.0125
"""Time between two rows from which on leaps tell nothing [s]. Chosen: a joint of 7 ms that follows a step of its
command goes 0.94 of the way between two rows at 50 Hz, and rests by the second; at 80 Hz it does not."""
LATE = 1.5e-3
"""Lag of a velocity from which on it counts as filtered [s]. Measured: a first-order low-pass of 40 Hz is 4 ms late
and makes kp 2 to 4 %, viscous friction up to 100 % wrong."""
CHANCE = 10.8
"""What a lag must explain better, as twice the logarithm of a likelihood over independent values, one in each `WINDOW`.
Chi-square of one degree of freedom, passed by chance once in a thousand."""
FEWEST = 1.5
"""Rows by which a position must be behind. Chosen: a simulator's step puts its speed half a row before or behind."""
FAR = 0.5
"""Share of what a lag of the position leaves unexplained of the velocity, of that without one, below which it is told.
Chosen: it is a derivative of the same motion, so noise alone may be left."""
WINDOW = 0.03
"""Width of the filter with which a velocity is compared, and longest lag of it that is looked for [s]."""
SEEN = 10.0
"""Least speed of a joint, in the smoothed noise of its velocity, at which the two are compared."""


@dataclass(frozen=True, slots=True)
class Scale:
    """A velocity over the derivative of its position.

    Attributes:
        value: Factor.
        sure: Correlation of the velocity's integral with the position, within pieces without their trends.
        clear: Whether three of four pieces, and the whole, are beyond `CLEAR` on one side of 1.
    """

    value: float
    sure: float
    clear: bool


def check_speeds(
    found: Mapping[str, list[Recording]], recordings: Mapping[str, Sequence[Recording]], out: Collector
) -> None:
    """Judge the velocities of all joints; what is late is left out or taken earlier.

    Args:
        found: Joint to its part of every log; takes what is kept of each.
        recordings: Likewise of the joints that do not move too.
        out: Takes what is found.
    """
    parts = {name: [(one.log, i) for i, one in enumerate(mine)] for name, mine in found.items()}
    for _, here in by_log(parts):
        every = [(found[name], i) for name, i in here.items()]
        compared = [(mine, i) for mine, i in every if len(mine[i].measured.get("velocity", ())) >= LEAST_ROWS]
        if not compared or _jumped([mine[i] for mine, i in compared], out):
            continue
        scales = [_scaled(mine[i]) for mine, i in compared]
        if _clock([mine[i] for mine, i in compared], scales, out):
            continue
        for (mine, i), scale in zip(compared, scales, strict=True):
            mine[i] = _velocity(mine[i], scale, recordings, out)


def correlated(a: Array, b: Array) -> tuple[float, float]:
    """Slope of a over b, and their correlation."""
    import numpy as np

    x, y = b - b.mean(), a - a.mean()
    size = float(np.sqrt((x @ x) * (y @ y)))
    if size == 0.0:
        return 0.0, 0.0
    return float(x @ y / (x @ x)), float(x @ y) / size


def unit_of(scale: float) -> str | None:
    """The unit that a scale is the mark of."""
    return next((unit for factor, unit in FACTORS.items() if abs(abs(scale) / factor - 1.0) < NEAR), None)


def _scaled(recording: Recording) -> Scale | None:
    """The velocity's integral over the position; None where there is too little to compare."""
    import numpy as np

    velocity = recording.measured["velocity"]
    if float(np.sqrt(np.nanmean(velocity**2))) < COUNTS * texture(velocity).count:
        return None
    sums = [(a @ a, a @ b, b @ b) for a, b in _courses(recording)]
    if not sums:
        return None
    each = np.array(sums)
    xx, xy, yy = each.sum(axis=0).tolist()
    if xx * yy == 0.0 or xy <= 0.0:
        return None
    value, sure = math.sqrt(yy / xx), xy / math.sqrt(xx * yy)
    moved = each[each[:, 0] > 0.1 * each[:, 0].max()]
    low, high = np.quantile(moved[:, 1] / moved[:, 0], [0.25, 0.75])
    # Noise of the position makes a slope smaller, that of the velocity makes the value larger.
    clear = min(low, xy / xx) > CLEAR or max(high, yy / xy) < 1.0 / CLEAR
    return Scale(value, sure, bool(clear) and 1.0 - sure**2 < EXPLAINED)


def _courses(recording: Recording) -> Iterator[tuple[Array, Array]]:
    """The position and the velocity's integral in each piece, without their trends [rad or m]."""
    import numpy as np
    from scipy.interpolate import CubicSpline

    position, velocity = recording.measured["position"], recording.measured["velocity"]
    for start in recording.starts:
        rows = slice(start, start + recording.rows)
        time, known = recording.time[rows], np.isfinite(position[rows]) & np.isfinite(velocity[rows])
        if known.mean() < 0.5:
            continue
        # A spline, for the trapezoids of a fast motion in few rows are too small.
        speed = CubicSpline(time, np.interp(time, time[known], velocity[rows][known]))
        went = speed.antiderivative()(time)[known]
        # A sensor's offset is a trend of the integral, and noise of both begins anew in each piece.
        even = np.stack([np.ones_like(went), time[known] - time[0]], axis=1)
        both = np.stack([position[rows][known], went], axis=1)
        yield (both - even @ np.linalg.lstsq(even, both, rcond=None)[0]).T


def _adds_up(recording: Recording) -> bool:
    """Whether the velocity goes to where the joint is, but for a count of its encoder or the noise of a reading.

    The derivative of so slow a motion, read so coarsely, says nothing against it.
    """
    import numpy as np

    seen = texture(recording.measured["position"])
    off = [a - b for a, b in _courses(recording)]
    return bool(off) and float(np.std(np.concatenate(off))) < max(seen.noise, seen.count)


def _clock(recordings: Sequence[Recording], scales: Sequence[Scale | None], out: Collector) -> bool:
    """Whether all joints' velocities have one scale that is not 1, nor a unit's: that is the time's, and an error."""
    told = [scale.value for scale in scales if scale is not None and scale.clear]
    judged = [scale for scale in scales if scale is not None and scale.sure > SURE]
    if len(told) < 2 or len(told) < len(judged):
        return False
    middle = sorted(told)[len(told) // 2]
    alike = all(abs(value / middle - 1.0) < ALIKE for value in told)
    if not alike or unit_of(middle) is not None or unit_of(1.0 / middle) is not None:
        return False
    log = recordings[0].log
    message = (
        f"the velocities of {'both' if len(told) == 2 else f'all {len(told)}'} joints are {middle:.3g} times their "
        f"positions' derivatives: a row comes every {format_number(1e3 * log.step / middle, 3)} ms by the velocities, "
        f"and every {format_number(1e3 * log.step, 3)} ms by the time"
    )
    help = "correct the time; if that is right, all velocities have another scale, as on the motor's side of a gear"
    out.error("SYS014", message, where="time", span=Span(log.path, 1), help=help)
    return True


def _jumped(recordings: Sequence[Recording], out: Collector) -> bool:
    """Whether positions jump in one row, most of them in the same: rows are missing, and the time hides it."""
    import numpy as np
    from scipy.ndimage import maximum_filter1d

    first = recordings[0]
    if first.step > COARSE or any(len(one.time) != len(first.time) for one in recordings):
        return False
    gaps = np.diff(first.time)
    even = maximum_filter1d((gaps > longest_step(first.time)).astype(float), 5) == 0.0
    far = np.stack([_leaps(one) for one in recordings])
    # Of a joint whose reading there is left out, the leap is a row off.
    near = maximum_filter1d(far, 3, axis=1) > 0.0
    rows = np.flatnonzero(even & (far.max(axis=0) > 0.0) & (near.sum(axis=0) > 0.5 * len(recordings)))
    rows = rows[np.diff(rows, prepend=-2) > 2]
    if not len(rows):
        return False
    row = int(rows[0])
    most = int(np.argmax(far[:, row]))
    worst, size = recordings[most], float(far[most, row])
    fastest = float(np.nanmax(np.abs(worst.measured["velocity"][_around(row, worst)])))
    units = units_of(worst.kind)
    more = f", and {len(rows) - 1} more times" if len(rows) > 1 else ""
    whose = (
        "the position jumps"
        if len(recordings) == 1
        else f"the positions of {int(near[:, row].sum())} of {many(len(recordings), 'joint')} jump"
    )
    speed = f"{fastest:.3g} {units.speed}"
    message = (
        f"{whose} from this row to the next{more}: {worst.joint} by {format_number(size, 3)} {units.position} in "
        f"{format_number(1e3 * float(gaps[row]), 3)} ms, at a velocity of up to {speed}"
    )
    help = "rows are missing there, and the time was numbered anew: log each row's own time, or split the file there"
    out.error("SYS013", message, where="time", span=first.place(row), help=help)
    return True


def _around(row: int, recording: Recording) -> slice:
    """Rows around two of which their speed may be that, behind a filter or late."""
    wide = math.ceil(WINDOW / recording.step)
    return slice(max(row - wide, 0), row + wide + 2)


def _leaps(recording: Recording) -> Array:
    """How far a position goes to the next row, 0 where the speeds and steps around make that in `LEAP` rows.

    A reading that was held goes on by a leap too: it stands still before.
    """
    import numpy as np
    from scipy.ndimage import maximum_filter1d, rank_filter

    read, speed = recording.measured["position"], np.nan_to_num(np.abs(recording.measured["velocity"]))
    # A single reading at a leap may count as a wild one.
    known = np.maximum.accumulate(np.where(np.isfinite(read), np.arange(len(read)), 0))
    held = np.arange(len(read)) - known > 2
    position = np.where(held, np.nan, read[known])
    steps = np.nan_to_num(np.abs(np.diff(position)))
    wide = 2 * math.ceil(WINDOW / recording.step) + 3
    fast = recording.step * maximum_filter1d(speed, wide)
    usual = np.maximum(rank_filter(steps, -3, wide), np.maximum(fast[:-1], fast[1:]))
    seen = texture(read)
    leaps = steps > LEAP * usual + 2.0 * STANDS * max(seen.noise, seen.count)
    leaps[1:] &= (steps[:-1] > 0.0) | (known[2:] - known[1:-1] != 1)
    return np.where(leaps, steps, 0.0)


def _velocity(
    recording: Recording,
    scale: Scale | None,
    recordings: Mapping[str, Sequence[Recording]],
    out: Collector,
) -> Recording:
    """The velocity against the position's derivative."""
    import numpy as np

    read = recording.measured["velocity"]
    known = np.isfinite(recording.measured["position"]) & np.isfinite(read)
    slopes = smooth(recording.time, recording.position, WINDOW, 1)[known]
    course = smooth(recording.time, read, WINDOW)[known]
    read = read[known]
    sure = correlated(course, slopes)[1]
    place, name = recording.place(), recording.joint
    if float(np.std(course)) < SEEN * float(np.nanstd(read - course)) * math.sqrt(recording.step / WINDOW):
        # Noise is all that one sees of so slow a joint: there is nothing to compare.
        return recording
    if sure < -SURE:
        message = f"the velocity has the opposite sign of the position's derivative (correlation {sure:.2f})"
        out.error("SYS014", message, where=name, span=place, help="turn the sign of one of the two columns")
        return recording
    if scale is not None and scale.sure > SURE and _misscaled(recording, scale, out):
        return recording
    behind = _late_position(course, slopes, recording.step)
    if behind is not None:
        message = (
            f"the position is {rows_of(behind)} ({format_number(1e3 * behind * recording.step, 3)} ms) behind its "
            "velocity: it is fitted as that of so much earlier"
        )
        help = "log what the drive reads in one message, or take the lag out of the column"
        out.warning("SYS012", message, where=name, span=place, help=help)
        return earlier(recording, behind)
    lag, at_lag = _lag(course, slopes, recording.step)
    if at_lag < SURE:
        if _adds_up(recording):
            return recording
        if whose := _derivative_of(recording, recordings, course, known):
            message = f"the velocity is the derivative of {whose}, not of its own position"
            help = "columns are exchanged"
            if whose == "the command":
                help = "command and position are exchanged, or it is a commanded velocity"
            out.error("SYS015", message, where=name, span=place, help=help)
            return recording
        message = f"the velocity is not the position's derivative (correlation {at_lag:.2f}): it is left out"
        out.warning("SYS012", message, where=name, span=place)
        return without_velocity(recording)
    better = (1.0 - sure**2) / max(1.0 - at_lag**2, 1e-12)
    if lag > LATE and len(course) * recording.step / WINDOW * math.log(better) > CHANCE:
        message = f"the velocity is {lag * 1e3:.2g} ms late, as behind a filter: it is left out"
        out.info("SYS012", message, where=name, span=place)
        return without_velocity(recording)
    return recording


def _misscaled(recording: Recording, scale: Scale, out: Collector) -> bool:
    """Whether a velocity has another scale than the position's derivative, which is an error; a unit's is named."""
    place, name, value = recording.place(), recording.joint, scale.value
    if (unit := unit_of(value)) is not None:
        message = f"the velocity is {value:.3g} times the position's derivative: it is in {unit}"
        shown = {"degrees": "deg/s", "rpm": "rpm", "thousandths": "mrad/s", "turns": "rev/s"}[unit]
        out.error("SYS014", message, where=name, span=place, help=f"write [{shown}] in its header")
    elif (unit := unit_of(1.0 / value)) is not None and unit != "rpm":
        message = (
            f"the position's derivative is {1.0 / value:.3g} times the velocity: the position is in {unit}"
        )
        shown = {"degrees": "deg", "thousandths": "mrad", "turns": "rev"}[unit]
        out.error("SYS014", message, where=name, span=place, help=f"write [{shown}] in its header")
    elif scale.clear:
        message = f"the velocity is {value:.3g} times the position's derivative"
        help = (
            "correct the scale of the velocity's column, as where it is read on the motor's side of a gear; "
            "of several joints with one such factor it is the time's"
        )
        out.error("SYS014", message, where=name, span=place, help=help)
    else:
        return False
    return True


def _late_position(course: Array, slopes: Array, step: float) -> int | None:
    """Rows by which a position is behind its velocity; None: it is not, or noise hides it."""
    lag, at_lag = _lag(slopes, course, step, LATEST)
    left, without = 1.0 - at_lag**2, 1.0 - correlated(course, slopes)[1] ** 2
    # At the longest lag that was tried it may be a longer one, or another signal.
    inside = FEWEST * step < lag < LATEST - step
    return round(lag / step) if inside and left < min(FAR * without, EXPLAINED) else None


def _derivative_of(
    recording: Recording,
    recordings: Mapping[str, Sequence[Recording]],
    course: Array,
    known: NDArray[np.bool_],
) -> str | None:
    """What else of the log a velocity is the derivative of; None: nothing."""
    signals = {"the command": recording.command} | {
        f"the position of {joint}": other.position
        for joint, theirs in recordings.items()
        for other in theirs
        if joint != recording.joint and other.log is recording.log and len(other.time) == len(recording.time)
    }
    for name, signal in signals.items():
        lag, sure = _lag(course, smooth(recording.time, signal, WINDOW, 1)[known], recording.step)
        if sure > SURE and abs(lag) < LATE:
            return name
    return None


def _lag(late: Array, early: Array, step: float, longest: float = WINDOW) -> tuple[float, float]:
    """By how much one signal is behind another [s], by a parabola through the best correlations; and the best."""
    import numpy as np

    rows = max(2, round(longest / step))
    found = []
    for lag in range(-2, rows + 1):
        a = late[max(lag, 0) : len(late) + min(lag, 0)]
        b = early[max(-lag, 0) : len(early) - max(lag, 0)]
        found.append(correlated(a, b)[1])
    best = int(np.argmax(found))
    top = found[best]
    if 0 < best < len(found) - 1:
        left, right = found[best - 1], found[best + 1]
        bend = left - 2.0 * top + right
        shift = 0.0 if bend == 0.0 else 0.5 * (left - right) / bend
    else:
        shift = 0.0
    return (best - 2 + shift) * step, top
