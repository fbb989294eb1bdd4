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

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

_SHARED = ("kp", "kd", "armature", "coulomb", "viscous", "bias", "static")
"""Figures that the motion takes as they are."""
AT_ONCE = 1e9
"""Rate of a low-pass that is none [1/s]."""
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


@dataclass(slots=True)
class _Joint:
    """Figures of every lane, which is a piece with a set of figures; shape (n_set, n_piece), or of some lanes (n,)."""

    kp: Array
    kd: Array
    armature: Array
    coulomb: Array
    viscous: Array
    bias: Array
    static: Array
    per_stribeck: Array
    slipping: bool
    bounds: Bounds

    def take(self, lanes: NDArray[np.intp]) -> _Joint:
        return _Joint(
            kp=self.kp.take(lanes),
            kd=self.kd.take(lanes),
            armature=self.armature.take(lanes),
            coulomb=self.coulomb.take(lanes),
            viscous=self.viscous.take(lanes),
            bias=self.bias.take(lanes),
            static=self.static.take(lanes),
            per_stribeck=self.per_stribeck.take(lanes),
            slipping=self.slipping,
            bounds=self.bounds,
        )

    def drive(self, command: Array, speed_command: Array, q: Array, qd: Array) -> Array:
        return self.bounds.clip(self.kp * (command - q - self.bias) + self.kd * (speed_command - qd), qd)

    def dry(self, qd: Array) -> Array:
        import numpy as np

        if not self.slipping:
            return self.coulomb
        more = np.maximum(self.static - self.coulomb, 0.0)
        found: Array = self.coulomb + more * np.exp(-((qd * self.per_stribeck) ** 2))
        return found

    def breakaway(self) -> Array:
        import numpy as np

        found: Array = np.maximum(self.static, self.coulomb) if self.slipping else self.coulomb
        return found


@dataclass(slots=True)
class _Between:
    """The model between two rows, linear in time, and the command of one part; by lane.

    Inertia, load, slope and path are pairs: at the earlier row, and the change to the later one.
    """

    inertia: tuple[Array, Array]
    load: tuple[Array, Array]
    slope: tuple[Array, Array]
    path: tuple[Array, Array]
    speed_command: Array
    target: Array
    command: Array
    rate: Array | None
    length: Array

    def take(self, lanes: NDArray[np.intp]) -> _Between:
        def both(pair: tuple[Array, Array]) -> tuple[Array, Array]:
            return pair[0].take(lanes), pair[1].take(lanes)

        return _Between(
            both(self.inertia),
            both(self.load),
            both(self.slope),
            both(self.path),
            self.speed_command.take(lanes),
            self.target.take(lanes),
            self.command.take(lanes),
            None if self.rate is None else self.rate.take(lanes),
            self.length.take(lanes),
        )

    def at(self, pair: tuple[Array, Array], share: Array) -> Array:
        return pair[0] + pair[1] * share

    def command_at(self, gone: Array | float) -> Array:
        """The filtered command so much of the row after the part's step began."""
        import numpy as np

        if self.rate is None:
            return self.target
        left = np.where(self.rate < AT_ONCE, np.exp(-self.rate * (gone * self.length)), 0.0)
        found: Array = self.target + (self.command - self.target) * left
        return found


@dataclass(slots=True)
class _Moment:
    """What acts at one moment, as a function of position and speed.

    Attributes:
        joint: Figures.
        drive: Torque of the drive at position and speed 0, before it is clipped.
        push: Of the links there.
        slope: Of their load over the position.
        light: One over the inertia.
    """

    joint: _Joint
    drive: Array
    push: Array
    slope: Array
    light: Array

    @classmethod
    def of(cls, joint: _Joint, between: _Between, share: Array, gone: Array | float) -> _Moment:
        """At a share of the row, so much of it after the part's step began."""
        command = between.command_at(gone)
        slope = between.at(between.slope, share)
        return cls(
            joint,
            joint.kp * (command - joint.bias) + joint.kd * between.speed_command,
            slope * between.at(between.path, share) - between.at(between.load, share),
            slope,
            1.0 / (between.at(between.inertia, share) + joint.armature),
        )

    def net(self, q: Array, qd: Array) -> Array:
        """All that pulls at the joint but dry friction."""
        joint = self.joint
        torque = joint.bounds.clip(self.drive - joint.kp * q - joint.kd * qd, qd)
        return torque + self.push - self.slope * q - joint.viscous * qd

    def acceleration(self, net: Array, qd: Array, way: Array) -> Array:
        """With what pulls, and dry friction against a way."""
        return (net - way * self.joint.dry(qd)) * self.light


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
    """
    found = _rolled(_table(course, figures, starts, rows, reading), bounds, q, qd, finer)
    return found


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
    whole = _rolled(_Table.beside(tables), bounds, q, qd, 1)
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


def _rolled(table: _Table, bounds: Bounds, q: Array, qd: Array, finer: int) -> Moved:
    """The motion, row by row.

    Within, lanes are (n_set, n_piece), and all arrays are whole: what stands by piece or by delay is copied to every
    set, because an operation on arrays of unlike shapes takes five times as long.
    """
    import numpy as np

    figures, which, seen_of = table.joint, table.which, table.seen_of
    slipping = bool(np.any((figures["static"] > figures["coulomb"]) & (figures["per_stribeck"] > 0)))
    joint = _Joint(**figures, slipping=slipping, bounds=bounds)
    rows, fine = len(table.length), table.fine * finer
    rate = table.rate if table.filtered else None
    some = np.any(table.parts[1] > table.parts[0], axis=(2, 3))
    every = 0 * which
    out = [np.empty((rows, *q.shape[::-1])) for _ in range(4)]
    now_q, now_qd = np.array(q.T, dtype=float, order="C"), np.array(qd.T, dtype=float, order="C")
    breakaway = joint.breakaway()
    for k in range(rows):
        vd, seen = table.vd[k].take(every, 0), table.seen[k].take(seen_of, 0)
        torque = joint.drive(seen, vd, now_q, now_qd)
        load, slope, path = (values[k].take(every, 0) for values in table.at_row)
        resting = torque - load - slope * (now_q - path)
        resting = np.minimum(np.maximum(resting, -breakaway), breakaway)
        sliding = np.sign(now_qd) * joint.dry(now_qd)
        out[0][k], out[1][k], out[2][k] = now_q, now_qd, torque
        out[3][k] = joint.viscous * now_qd + np.where(now_qd == 0.0, resting, sliding)
        if k == rows - 1:
            break
        length = table.length[k].take(every, 0)
        inertia, load_of, slope_of, path_of = (
            (begin[k].take(every, 0), rise[k].take(every, 0)) for begin, rise in table.lines
        )
        command = seen if table.filtered else None
        for p, lasts in enumerate(some[k]):
            if not lasts:
                continue
            begin, end, target = (values[k, p].take(which, 0) for values in table.parts)
            share = (end - begin) / fine
            for i in range(fine):
                at = begin + share * i
                for step in _cut(share, rate, length):
                    between = _Between(
                        inertia, load_of, slope_of, path_of, vd, target, target if command is None else command,
                        rate, length,
                    )  # fmt: skip
                    now_q, now_qd = _advance(joint, between, now_q, now_qd, at, step)
                    at = at + step
                    if command is not None:
                        command = between.command_at(step)
    return Moved(*(np.swapaxes(values, 1, 2) for values in out))


def _cut(share: Array, rate: Array | None, length: Array) -> list[Array]:
    """A step in those that a fast low-pass needs, as shares of the row."""
    import numpy as np

    if rate is None:
        return [share]
    ends = [*(np.minimum(time / (rate * length), share) for time in CUTS), share]
    steps = [ends[0], *(later - end for end, later in pairwise(ends))]
    return [step for step in steps if step.any()]


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


def _advance(
    joint: _Joint, between: _Between, q: Array, qd: Array, first: Array, share: Array
) -> tuple[Array, Array]:
    """One step: position and speed after it."""
    import numpy as np

    way, go = np.sign(qd), share
    begin = _Moment.of(joint, between, first, 0.0)
    net = begin.net(q, qd)
    still = qd == 0.0
    if still.any():
        held = still & (np.abs(net) <= joint.breakaway())
        way = np.where(still, np.sign(net), way)
        go = np.where(held, 0.0, share)
    new_q, new_qd = _runge_kutta(begin, net, between, q, qd, way, first, go)
    back = ((way * new_qd < 0.0) & (go > 0.0)).ravel()
    if back.any():
        lanes = np.flatnonzero(back)
        values = (values.take(lanes) for values in (q, qd, way, first, share, new_qd))
        turned = _turned(joint.take(lanes), between.take(lanes), *values)
        new_q.put(lanes, turned[0])
        new_qd.put(lanes, turned[1])
    return new_q, new_qd


def _turned(
    joint: _Joint,
    between: _Between,
    q: Array,
    qd: Array,
    way: Array,
    first: Array,
    share: Array,
    after: Array,
) -> tuple[Array, Array]:
    """A step within which these joints come to a stand: to that moment, and on if something pulls."""
    import numpy as np

    begin = _Moment.of(joint, between, first, 0.0)
    net = begin.net(q, qd)
    # A straight line in the speed, put right once: it is 0 there to the fourth power of the step.
    until = share * np.where(qd == after, 0.0, qd / np.where(qd == after, 1.0, qd - after))
    for _ in range(2):
        at, speed = _runge_kutta(begin, net, between, q, qd, way, first, until)
        end = _Moment.of(joint, between, first + until, until)
        pull = end.acceleration(end.net(at, speed), speed, way)
        until = np.clip(
            until - np.where(pull == 0.0, 0.0, speed / np.where(pull == 0.0, 1.0, pull)) / between.length,
            0.0,
            share,
        )
    at, _ = _runge_kutta(begin, net, between, q, qd, way, first, until)
    rest = 0.0 * at
    stand = _Moment.of(joint, between, first + until, until)
    net = stand.net(at, rest)
    goes = np.abs(net) > joint.breakaway()
    left = np.where(goes, share - until, 0.0)
    new_way = np.sign(net)
    new_q, new_qd = _runge_kutta(stand, net, between, at, rest, new_way, first + until, left, until)
    again = new_way * new_qd < 0.0
    return np.where(again, at, new_q), np.where(again, 0.0, new_qd)


def _runge_kutta(
    begin: _Moment,
    net: Array,
    between: _Between,
    q: Array,
    qd: Array,
    way: Array,
    first: Array,
    go: Array,
    gone: Array | float = 0.0,
) -> tuple[Array, Array]:
    """Position and speed after `go` of the row, in one step of the classical method.

    Args:
        begin: What acts at the step's beginning.
        net: What pulls there.
        between: The model between two rows.
        q: At the beginning.
        qd: Likewise.
        way: In which dry friction is overcome.
        first: Share of the row at the beginning.
        go: Share of the row that the step takes.
        gone: Share of the row since the part's step began.
    """
    time, halfway = go * between.length, 0.5 * go
    half = 0.5 * time
    middle = _Moment.of(begin.joint, between, first + halfway, gone + halfway)
    end = _Moment.of(begin.joint, between, first + go, gone + go)
    a1 = begin.acceleration(net, qd, way)
    v2 = qd + half * a1
    a2 = middle.acceleration(middle.net(q + half * qd, v2), v2, way)
    v3 = qd + half * a2
    a3 = middle.acceleration(middle.net(q + half * v2, v3), v3, way)
    v4 = qd + time * a3
    a4 = end.acceleration(end.net(q + time * v3, v4), v4, way)
    sixth, change = time / 6.0, a1 + a2 + a3
    return q + time * (qd + sixth * change), qd + sixth * (change + a2 + a3 + a4)
