"""How a joint moves under the commands of a log: many pieces of the log, and many sets of figures, at once.

    J(t) q'' = clip(kp (a - q - bias) + kd (v* - q')) - b q' - dry friction - g(t) - s(t) (q - q_ref(t))

J, g and s are those of the robot's model along the measured path: link inertia, gravity with all that the other joints
do, and its slope. The command is held from when it arrives, a delay after it was sent, which need not be a multiple of
anything: time is divided where a command arrives, and within each part the classical Runge-Kutta method is used. A
joint whose speed comes to 0 is taken to that moment, and stays while no more than the dry friction pulls at it.

Arrays are (n_piece, n_set) where nothing else is said. All in SI, at the joint.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import pairwise
from typing import TYPE_CHECKING

from actspec.sysid.course import Course, Parts, parts_of, told
from actspec.sysid.figures import Bounds, Figures
from actspec.sysid.stepping import AT_ONCE, Between, Joint, Moment, Step, advance

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

_SHARED = ("kp", "kd", "armature", "coulomb", "viscous", "bias", "static")
"""Figures that the motion takes as they are."""
AHEAD = 8192
"""Rows times lanes whose moments are worked out at once. Chosen: arrays of 64 KiB, a hundred of them."""
FINE = 0.25
"""Longest step times the fastest rate of the joint. Measured: halving it changes figures by less than 1e-5."""

CUTS = (2.0, 5.0, 12.0)
"""Where a step is cut behind a fast low-pass, in its time constants. A Runge-Kutta step that is many of them long takes
the command of its beginning for a sixth of itself. Measured: position and speed are as by steps of 1/500 of a row."""


@dataclass(frozen=True, slots=True)
class Moved:
    """How a joint moved, at the rows of each piece; shape (n_row, n_piece, n_set).

    Attributes:
        q: Position, without the encoder's bias [rad or m].
        qd: [rad/s or m/s].
        torque: Of the drive, as read at the row: a command that arrives then is not in it [N*m or N].
        friction: What friction takes from it at the row [N*m or N].
    """

    q: Array
    qd: Array
    torque: Array
    friction: Array


def move(
    course: Course,
    figures: Figures,
    bounds: Bounds,
    starts: NDArray[np.intp],
    rows: int,
    q: Array,
    qd: Array,
    reading: float | None = None,
    finer: int = 1,
    moved: tuple[Array, Array] | None = None,
    ago: float = 0.0,
) -> Moved:
    """Let the joint follow its commands from several rows on.

    Args:
        course: Commands and model.
        figures: Sets of figures.
        bounds: Of the drive.
        starts: First rows of the pieces, shape (n_piece,).
        rows: Length of each piece, its first row included.
        q: Positions at the starts, bias not included [rad or m], shape (n_piece, n_set).
        qd: Speeds there [rad/s or m/s], likewise.
        reading: Delay by which the command in a row's torque is told; None: each set's own. That torque jumps where
            a command arrives, so a fit searches over this, and descends over the other.
        finer: Into how many each step is divided.
        moved: Its position and speed where another reading of the same is known: then only torques are told.
        ago: By how much a row's torque is older than its position [s], less than the time of a row; of the command
            that `reading` tells.
    """
    import numpy as np

    table = _table(course, figures, starts, rows, reading)
    joint = _joint(table, bounds)
    if moved is None:
        return _read(table, joint, *_rolled(table, joint, q, qd, finer), ago=ago)
    at, speed = (np.swapaxes(values, 1, 2) for values in moved)
    return _read(table, joint, at, speed, ago)


@dataclass(frozen=True, slots=True)
class Run:
    """Pieces of one joint's course, with figures that have one delay and one low-pass.

    Attributes:
        course: Commands and model.
        figures: Sets of figures, of as many in every run.
        starts: First rows of the pieces, shape (n_piece,).
        q: Positions at the starts, bias not included [rad or m], shape (n_piece, n_set).
        qd: Speeds there [rad/s or m/s], likewise.
        reading: See `move`.
    """

    course: Course
    figures: Figures
    starts: NDArray[np.intp]
    q: Array
    qd: Array
    reading: float | None = None


def move_each(runs: Sequence[Run], bounds: Bounds, rows: int) -> list[Moved]:
    """What `move` gives for each of several joints, whose drives have the same bounds, in far less time."""
    import numpy as np

    tables = [_table(run.course, run.figures, run.starts, rows, run.reading) for run in runs]
    q, qd = (np.concatenate([getattr(run, name) for run in runs]) for name in ("q", "qd"))
    table = _Table.beside(tables)
    joint = _joint(table, bounds)
    whole = _read(table, joint, *_rolled(table, joint, q, qd, 1))
    ends = np.cumsum([len(run.starts) for run in runs])[:-1]
    split = [np.split(getattr(whole, field.name), ends, axis=1) for field in fields(Moved)]
    return [Moved(*parts) for parts in zip(*split, strict=True)]


@dataclass(slots=True)
class _Table:
    """All that a motion needs, by row and piece; of figures by set.

    Attributes:
        length: To the next row [s], shape (rows, 1, n_piece).
        vd: Speed command, likewise.
        at_row: Load, slope and path at the row, likewise.
        lines: Inertia, load, slope and path after the row, at the beginning and their change, likewise.
        parts: Begin and end as shares of the row, and the command of each part, shape (rows, n_part, n_delay, n_piece).
        which: Delay of each set.
        seen: Command that a row's torque tells, shape (rows, n_delay, n_piece), or by pairs of delay and low-pass.
        seen_of: Which of these belongs to each set.
        filtered: Whether that is behind a low-pass.
        rate: Of it [1/s], shape (n_set, n_piece).
        joint: Figures, likewise.
        fine: Into how many steps a part is divided.
    """

    length: Array
    vd: Array
    at_row: tuple[Array, Array, Array]
    lines: Sequence[tuple[Array, Array]]
    parts: tuple[Array, Array, Array]
    which: NDArray[np.intp]
    seen: Array
    seen_of: NDArray[np.intp]
    filtered: bool
    rate: Array
    joint: Mapping[str, Array]
    fine: int

    @classmethod
    def beside(cls, tables: Sequence[_Table]) -> _Table:
        """Several as one; of figures with one delay and one low-pass each."""
        import numpy as np

        one = tables[0]
        n_part = max(table.parts[0].shape[1] for table in tables)

        def joined(values: Sequence[Array]) -> Array:
            return np.concatenate(values, axis=-1)

        def padded(table: _Table, i: int) -> Array:
            # A part that begins where it ends is none.
            values = table.parts[i]
            lacking = n_part - values.shape[1]
            more = np.ones((len(values), lacking, *values.shape[2:]))
            found: Array = np.concatenate([values, more], axis=1)
            return found

        return cls(
            length=joined([t.length for t in tables]),
            vd=joined([t.vd for t in tables]),
            at_row=(
                joined([t.at_row[0] for t in tables]),
                joined([t.at_row[1] for t in tables]),
                joined([t.at_row[2] for t in tables]),
            ),
            lines=[
                (joined([t.lines[i][0] for t in tables]), joined([t.lines[i][1] for t in tables]))
                for i in range(len(one.lines))
            ],
            parts=(
                joined([padded(t, 0) for t in tables]),
                joined([padded(t, 1) for t in tables]),
                joined([padded(t, 2) for t in tables]),
            ),
            which=one.which,
            seen=joined([t.seen for t in tables]),
            seen_of=one.seen_of,
            filtered=any(t.filtered for t in tables),
            rate=joined([t.rate for t in tables]),
            joint={name: joined([t.joint[name] for t in tables]) for name in one.joint},
            fine=max(t.fine for t in tables),
        )


def _table(
    course: Course, figures: Figures, starts: NDArray[np.intp], rows: int, reading: float | None
) -> _Table:
    import numpy as np

    row = starts + np.arange(rows)[:, None]
    # After the last row of a piece nothing is looked up.
    after = np.minimum(row, len(course.time) - 2)
    delays, which = np.unique(figures.delay, return_inverse=True)
    parts = parts_of(course.time, delays)
    lags, lag_of = np.unique(np.stack([figures.delay, figures.lag]), axis=1, return_inverse=True)
    filtered = bool(np.any(lags[1] > 0))
    seen, seen_of = course.command[parts.before][row], which
    if filtered:
        seen, seen_of = _filtered(course, lags, parts, delays)[row], lag_of
    elif reading is not None:
        seen, seen_of = course.command[told(course.time, reading)][row][:, :, None], 0 * which
    speed = figures.stribeck_velocity
    rate = np.where(figures.lag > 0, 1.0 / np.where(figures.lag > 0, figures.lag, 1.0), AT_ONCE)

    def lanes(values: Array) -> Array:
        return np.repeat(values[:, None], len(starts), axis=1)

    def pieces_last(values: Array) -> Array:
        return np.ascontiguousarray(np.moveaxis(values, 1, -1))

    by_set = {name: lanes(getattr(figures, name)) for name in _SHARED}
    by_set["per_stribeck"] = lanes(1.0 / np.where(speed > 0, speed, np.inf))
    begin, end, target = (
        pieces_last(values[after]) for values in (parts.begin, parts.end, course.command[parts.index])
    )
    ends = [course.ends(name) for name in ("inertia", "load", "slope", "path")]
    return _Table(
        length=np.diff(course.time)[after][:, None],
        vd=course.speed_command[row][:, None],
        at_row=(course.load[row][:, None], course.slope[row][:, None], course.path[row][:, None]),
        lines=[(first[after][:, None], (last - first)[after][:, None]) for first, last in ends],
        parts=(begin, end, target),
        which=which,
        seen=pieces_last(seen),
        seen_of=seen_of,
        filtered=filtered,
        rate=lanes(rate),
        joint=by_set,
        fine=_division(course, figures),
    )


def _joint(table: _Table, bounds: Bounds) -> Joint:
    import numpy as np

    figures = table.joint
    slipping = bool(np.any((figures["static"] > figures["coulomb"]) & (figures["per_stribeck"] > 0)))
    return Joint(**figures, slipping=slipping, bounds=bounds)


def _rolled(table: _Table, joint: Joint, q: Array, qd: Array, finer: int) -> tuple[Array, Array]:
    """Position and speed, row by row; shape (rows, n_set, n_piece).

    Within, lanes are (n_set, n_piece), and all arrays are whole: what stands by piece or by delay is copied to every
    set, because an operation on arrays of unlike shapes takes five times as long. What does not depend on where a joint
    is, is worked out for many rows at once: on a few hundred lanes an operation takes little longer than its call.
    """
    import numpy as np

    rows, fine = len(table.length), table.fine * finer
    now_q, now_qd = np.array(q.T, dtype=float, order="C"), np.array(qd.T, dtype=float, order="C")
    at, speed = np.empty((rows, *now_q.shape)), np.empty((rows, *now_q.shape))
    at[0], speed[0] = now_q, now_qd
    ahead = max(1, AHEAD // max(now_q.size, 1))
    for first in range(0, rows - 1, ahead):
        some = slice(first, min(first + ahead, rows - 1))
        steps = _steps(table, joint, some, fine)
        for k in range(some.stop - first):
            for step in steps:
                if step.acts[k]:
                    now_q, now_qd = advance(joint, step, k, now_q, now_qd)
            at[first + k + 1], speed[first + k + 1] = now_q, now_qd
    return at, speed


def _read(table: _Table, joint: Joint, at: Array, speed: Array, ago: float = 0.0) -> Moved:
    """Such a motion with its torques."""
    import numpy as np

    command, then, speed_then = table.seen.take(table.seen_of, 1), at, speed
    if ago:
        rate = _rate(table, speed, ago)
        then, speed_then = at - ago * speed + 0.5 * ago**2 * rate, speed - ago * rate
        # What a low-pass lets through changes all the time; else it is a matter of `reading` which command acts.
        command = command - ago * _rate(table, command, ago) if table.filtered else command
    torque = joint.drive(command, table.vd, then, speed_then)
    load, slope, path = table.at_row
    breakaway = joint.breakaway()
    resting = torque - load - slope * (at - path)
    resting = np.minimum(np.maximum(resting, -breakaway), breakaway)
    friction = joint.viscous * speed + np.where(speed == 0.0, resting, np.sign(speed) * joint.dry(speed))
    return Moved(*(np.swapaxes(values, 1, 2) for values in (at, speed, torque, friction)))


def _rate(table: _Table, values: Array, ago: float) -> Array:
    """The change of what goes straight between rows, on the side where the moment so long ago is."""
    import numpy as np

    found = np.diff(values, axis=0) / table.length[:-1]
    # Before the first row, and behind the last, it goes on as beside them.
    return np.concatenate([found[:1], found] if ago > 0.0 else [found, found[-1:]])


def _steps(table: _Table, joint: Joint, some: slice, fine: int) -> list[Step]:
    """The steps of some rows, in their order."""
    import numpy as np

    every = 0 * table.which

    def whole(values: Array) -> Array:
        return values[some].take(every, 1)

    length, vd = whole(table.length), whole(table.vd)
    inertia, load, slope, path = ((whole(begin), whole(rise)) for begin, rise in table.lines)
    rate = table.rate if table.filtered else None
    command = table.seen[some].take(table.seen_of, 1) if table.filtered else None
    found = []
    for p in range(table.parts[0].shape[1]):
        begin, end, target = (values[some, p].take(table.which, 1) for values in table.parts)
        share = (end - begin) / fine
        for i in range(fine):
            first = begin + share * i
            for step in _cut(share, rate, length):
                acts: NDArray[np.bool_] = np.any(step != 0.0, axis=(1, 2))
                between = Between(
                    inertia, load, slope, path, vd, target, target if command is None else command, rate, length
                )  # fmt: skip
                after = between.command_at(step)
                if acts.any():
                    half = 0.5 * step
                    begun = Moment.of(joint, between, first, between.command_at(0.0))
                    middle = Moment.of(joint, between, first + half, between.command_at(half))
                    ended = Moment.of(joint, between, first + step, after)
                    time = step * length
                    found.append(Step(between, begun, middle, ended, first, step, time, acts.tolist()))
                first = first + step
                if command is not None:
                    command = np.where(acts[:, None, None], after, command)
    return found


def _cut(share: Array, rate: Array | None, length: Array) -> list[Array]:
    """A step in those that a fast low-pass needs, as shares of the row."""
    import numpy as np

    if rate is None:
        return [share]
    ends = [*(np.minimum(time / (rate * length), share) for time in CUTS), share]
    return [ends[0], *(later - end for end, later in pairwise(ends))]


def _division(course: Course, figures: Figures) -> int:
    """Into how many steps a part is divided."""
    import numpy as np

    inertia = np.maximum(figures.armature + course.inertia.min(), 1e-12)
    rate = np.maximum(np.sqrt(figures.kp / inertia), (figures.kd + figures.viscous) / inertia).max()
    return max(1, math.ceil(float(rate) * float(np.median(np.diff(course.time))) / FINE / 2.0))


def _filtered(course: Course, pairs: Array, parts: Parts, delays: Array) -> Array:
    """The low-passed command at every row, for each pair of delay and time constant; shape (n, n_pair)."""
    import numpy as np

    out = np.empty((len(course.time), pairs.shape[1]))
    length = np.diff(course.time)
    for i, (delay, lag) in enumerate(pairs.T):
        d = int(np.searchsorted(delays, delay))
        value = course.command[parts.before[0, d]]
        out[0, i] = value
        if lag <= 0:
            out[:, i] = course.command[parts.before[:, d]]
            continue
        keep = np.exp(-(parts.end[:, :, d] - parts.begin[:, :, d]) * length[:, None] / lag)
        target = course.command[parts.index[:, :, d]]
        # From row to row it is a straight line in the value before: factor and offset of all rows at once.
        factor, offset = np.ones(len(length)), np.zeros(len(length))
        for p in range(keep.shape[1]):
            factor, offset = factor * keep[:, p], target[:, p] + (offset - target[:, p]) * keep[:, p]
        values = [float(value)]
        for a, b in zip(factor.tolist(), offset.tolist(), strict=True):
            values.append(a * values[-1] + b)
        out[:, i] = values
    return out
