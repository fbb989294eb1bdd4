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
    """Figures spread over pieces and sets, and the equation of motion."""

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

    def take(self, where: tuple[NDArray[np.intp], ...]) -> _Joint:
        def of(value: Array) -> Array:
            found: Array = value[where[0] if len(value) > 1 else 0, where[1]]
            return found

        return _Joint(
            kp=of(self.kp),
            kd=of(self.kd),
            armature=of(self.armature),
            coulomb=of(self.coulomb),
            viscous=of(self.viscous),
            bias=of(self.bias),
            static=of(self.static),
            per_stribeck=of(self.per_stribeck),
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
    """The model between two rows, linear in time, and the command of one part."""

    inertia: tuple[Array, Array]
    load: tuple[Array, Array]
    slope: tuple[Array, Array]
    path: tuple[Array, Array]
    speed_command: Array
    target: Array
    command: Array
    rate: Array | None
    length: Array

    def take(self, where: tuple[NDArray[np.intp], ...]) -> _Between:
        import numpy as np

        def chosen(value: Array) -> Array:
            shape = np.broadcast_shapes(value.shape, self.target.shape)
            found: Array = np.broadcast_to(value, shape)[where]
            return found

        def both(pair: tuple[Array, Array]) -> tuple[Array, Array]:
            return chosen(pair[0]), chosen(pair[1])

        return _Between(
            both(self.inertia),
            both(self.load),
            both(self.slope),
            both(self.path),
            chosen(self.speed_command),
            chosen(self.target),
            chosen(self.command),
            None if self.rate is None else chosen(self.rate),
            chosen(self.length),
        )

    def at(self, pair: tuple[Array, Array], share: Array) -> Array:
        return pair[0] + (pair[1] - pair[0]) * share

    def command_at(self, after: Array) -> Array:
        """The filtered command a time after the part's start [s]."""
        import numpy as np

        if self.rate is None:
            return self.target
        left = np.where(self.rate < AT_ONCE, np.exp(-self.rate * after), 0.0)
        found: Array = self.target + (self.command - self.target) * left
        return found


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
    """

    course: Course
    figures: Figures
    starts: NDArray[np.intp]
    q: Array
    qd: Array


def move_each(runs: Sequence[Run], bounds: Bounds, rows: int) -> list[Moved]:
    """What `move` gives for each of several joints, whose drives have the same bounds, in far less time."""
    import numpy as np

    tables = [_table(run.course, run.figures, run.starts, rows, None) for run in runs]
    q, qd = (np.concatenate([getattr(run, name) for run in runs]) for name in ("q", "qd"))
    whole = _rolled(_Table.beside(tables), bounds, q, qd, 1)
    ends = np.cumsum([len(run.starts) for run in runs])[:-1]
    split = [np.split(getattr(whole, field.name), ends, axis=1) for field in fields(Moved)]
    return [Moved(*parts) for parts in zip(*split, strict=True)]


@dataclass(slots=True)
class _Table:
    """All that a motion needs, by row and piece; of figures by set.

    Attributes:
        length: To the next row [s], shape (rows, n_piece).
        vd: Speed command, likewise.
        at_row: Load, slope and path at the row, likewise.
        lines: Inertia, load, slope and path after the row, at the beginning and at the end, likewise.
        parts: Begin and end as shares of the row, and the command of each part, shape (rows, n_part, n_piece, n_delay).
        which: Delay of each set.
        seen: Command that a row's torque tells, shape (rows, n_piece, n_delay), or by pairs of delay and low-pass.
        seen_of: Which of these belongs to each set.
        filtered: Whether that is behind a low-pass.
        rate: Of it, by set [1/s], shape (1 or n_piece, n_set).
        joint: Figures, arrays of shape (1 or n_piece, n_set).
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

        def tall(value: Array, pieces: int) -> Array:
            found: Array = np.broadcast_to(value, (pieces, value.shape[1]))
            return found

        def padded(table: _Table, i: int) -> Array:
            # A part that begins where it ends is none.
            values = table.parts[i]
            lacking = n_part - values.shape[1]
            more = np.ones((len(values), lacking, *values.shape[2:]))
            found: Array = np.concatenate([values, more], axis=1)
            return found

        widths = [table.length.shape[1] for table in tables]
        both = list(zip(tables, widths, strict=True))
        return cls(
            length=np.concatenate([t.length for t in tables], axis=1),
            vd=np.concatenate([t.vd for t in tables], axis=1),
            at_row=(
                np.concatenate([t.at_row[0] for t in tables], axis=1),
                np.concatenate([t.at_row[1] for t in tables], axis=1),
                np.concatenate([t.at_row[2] for t in tables], axis=1),
            ),
            lines=[
                (
                    np.concatenate([t.lines[i][0] for t in tables], axis=1),
                    np.concatenate([t.lines[i][1] for t in tables], axis=1),
                )
                for i in range(len(one.lines))
            ],
            parts=(
                np.concatenate([padded(t, 0) for t in tables], axis=2),
                np.concatenate([padded(t, 1) for t in tables], axis=2),
                np.concatenate([padded(t, 2) for t in tables], axis=2),
            ),
            which=one.which,
            seen=np.concatenate([t.seen for t in tables], axis=1),
            seen_of=one.seen_of,
            filtered=any(t.filtered for t in tables),
            rate=np.concatenate([tall(t.rate, n) for t, n in both]),
            joint={name: np.concatenate([tall(t.joint[name], n) for t, n in both]) for name in one.joint},
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
    by_set = {name: getattr(figures, name)[None, :] for name in _SHARED}
    by_set["per_stribeck"] = (1.0 / np.where(speed > 0, speed, np.inf))[None, :]
    begin, end, target = (
        np.swapaxes(values[after], 1, 2) for values in (parts.begin, parts.end, course.command[parts.index])
    )
    return _Table(
        length=np.diff(course.time)[after],
        vd=course.speed_command[row],
        at_row=(course.load[row], course.slope[row], course.path[row]),
        lines=[
            (first[after], last[after])
            for first, last in (course.ends(name) for name in ("inertia", "load", "slope", "path"))
        ],
        parts=(begin, end, target),
        which=which,
        seen=seen,
        seen_of=seen_of,
        filtered=filtered,
        rate=rate[None, :],
        joint=by_set,
        fine=_division(course, figures),
    )


def _rolled(table: _Table, bounds: Bounds, q: Array, qd: Array, finer: int) -> Moved:
    """The motion, row by row."""
    import numpy as np

    figures, which, seen_of = table.joint, table.which, table.seen_of
    slipping = bool(np.any((figures["static"] > figures["coulomb"]) & (figures["per_stribeck"] > 0)))
    joint = _Joint(**figures, slipping=slipping, bounds=bounds)
    rows, fine = len(table.length), table.fine * finer
    rate = table.rate if table.filtered else None
    out = Moved(*(np.empty((rows, *q.shape)) for _ in range(4)))
    now_q, now_qd = np.array(q, dtype=float), np.array(qd, dtype=float)
    for k in range(rows):
        vd, seen = table.vd[k][:, None], table.seen[k][:, seen_of]
        out.q[k], out.qd[k] = now_q, now_qd
        torque = joint.drive(seen, vd, now_q, now_qd)
        load, slope, path = (value[k][:, None] for value in table.at_row)
        load = load + slope * (now_q - path)
        still = now_qd == 0.0
        resting = np.clip(torque - load, -joint.breakaway(), joint.breakaway())
        out.torque[k] = torque
        out.friction[k] = joint.viscous * now_qd + np.where(
            still, resting, np.sign(now_qd) * joint.dry(now_qd)
        )
        if k == rows - 1:
            break
        length = table.length[k][:, None]
        ends = [(begin[k][:, None], end[k][:, None]) for begin, end in table.lines]
        command = seen if table.filtered else None
        for p in range(table.parts[0].shape[1]):
            begin, end, target = (values[k, p][:, which] for values in table.parts)
            if not np.any(end > begin):
                continue
            for i in range(fine):
                first = begin + (end - begin) * (i / fine)
                share = (end - begin) / fine
                between = _Between(
                    ends[0], ends[1], ends[2], ends[3], vd, target, target if command is None else command,
                    rate, length,
                )  # fmt: skip
                now_q, now_qd = _advance(joint, between, now_q, now_qd, first, share)
                if command is not None:
                    command = between.command_at(share * length)
    return out


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

    way = np.sign(qd)
    net = None
    still = qd == 0.0
    if still.any():
        net = _net(joint, between, q, qd, first, 0.0 * first)
        held = still & (np.abs(net) <= joint.breakaway())
        way = np.where(still, np.sign(net), way)
        go = np.where(held, 0.0, share)
    else:
        go = share
    new_q, new_qd = _step(joint, between, q, qd, way, first, 0.0 * first, go)
    back = (way * new_qd < 0.0) & (go > 0.0)
    if back.any():
        where = np.nonzero(back)
        some, part = joint.take(where), between.take(where)
        was_q, was_qd, was_way, begun, wide = (
            np.broadcast_to(value, back.shape)[where] for value in (q, qd, way, first, share)
        )
        new_q[where], new_qd[where] = _turned(some, part, was_q, was_qd, was_way, begun, wide, new_qd[where])
    return new_q, new_qd


def _step(
    joint: _Joint, between: _Between, q: Array, qd: Array, way: Array, first: Array, gone: Array, go: Array
) -> tuple[Array, Array]:
    """See `_runge_kutta`."""
    found = _within_bounds(joint, between, q, qd, way, first, go)
    return found or _runge_kutta(joint, between, q, qd, way, first, gone, go)


def _within_bounds(
    joint: _Joint, between: _Between, q: Array, qd: Array, way: Array, first: Array, go: Array
) -> tuple[Array, Array] | None:
    """What `_runge_kutta` gives where no torque is clipped, in half of the time; None where it is another's.

    Within bounds, with a command that stays and dry friction of one size, the acceleration is linear in position and
    speed, with factors that are needed at the beginning, the middle and the end alone.
    """
    if between.rate is not None or joint.slipping:
        return None
    command = between.target - joint.bias
    drive = joint.kp * (command - q) + joint.kd * (between.speed_command - qd)
    if joint.bounds.binds(drive, qd):
        return None
    constant = joint.kp * command + joint.kd * between.speed_command - way * joint.coulomb
    damping = joint.kd + joint.viscous
    factors = []
    for share in (first, first + 0.5 * go, first + go):
        slope = between.at(between.slope, share)
        push = constant - between.at(between.load, share) + slope * between.at(between.path, share)
        factors.append((push, joint.kp + slope, 1.0 / (between.at(between.inertia, share) + joint.armature)))

    def acceleration(stage: int, q: Array, qd: Array) -> Array:
        push, stiffness, light = factors[stage]
        return (push - stiffness * q - damping * qd) * light

    time = go * between.length
    half = 0.5 * time
    a1 = acceleration(0, q, qd)
    v2 = qd + half * a1
    a2 = acceleration(1, q + half * qd, v2)
    v3 = qd + half * a2
    a3 = acceleration(1, q + half * v2, v3)
    v4 = qd + time * a3
    a4 = acceleration(2, q + time * v3, v4)
    sixth, change = time / 6.0, a1 + a2 + a3
    new_q, new_qd = q + time * (qd + sixth * change), qd + sixth * (change + a2 + a3 + a4)
    if joint.bounds.binds(joint.kp * (command - new_q) + joint.kd * (between.speed_command - new_qd), new_qd):
        return None
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

    # A straight line in the speed, put right once: it is 0 there to the fourth power of the step.
    until = share * np.where(qd == after, 0.0, qd / np.where(qd == after, 1.0, qd - after))
    for _ in range(2):
        at, speed = _step(joint, between, q, qd, way, first, 0.0 * first, until)
        pull = _acceleration(joint, between, at, speed, way, first + until, until)
        until = np.clip(
            until - np.where(pull == 0.0, 0.0, speed / np.where(pull == 0.0, 1.0, pull)) / between.length,
            0.0,
            share,
        )
    at, _ = _step(joint, between, q, qd, way, first, 0.0 * first, until)
    rest = 0.0 * at
    net = _net(joint, between, at, rest, first + until, until)
    goes = np.abs(net) > joint.breakaway()
    left = np.where(goes, share - until, 0.0)
    new_way = np.sign(net)
    new_q, new_qd = _step(joint, between, at, rest, new_way, first + until, until, left)
    again = new_way * new_qd < 0.0
    return np.where(again, at, new_q), np.where(again, 0.0, new_qd)


def _net(joint: _Joint, between: _Between, q: Array, qd: Array, share: Array, gone: Array) -> Array:
    """All that pulls at the joint but dry friction; `share` of the row, `gone` since the part's step began."""
    drive = joint.drive(between.command_at(gone * between.length), between.speed_command, q, qd)
    load = between.at(between.load, share) + between.at(between.slope, share) * (
        q - between.at(between.path, share)
    )
    return drive - joint.viscous * qd - load


def _acceleration(
    joint: _Joint, between: _Between, q: Array, qd: Array, way: Array, share: Array, gone: Array
) -> Array:
    force = _net(joint, between, q, qd, share, gone) - way * joint.dry(qd)
    return force / (between.at(between.inertia, share) + joint.armature)


def _runge_kutta(
    joint: _Joint, between: _Between, q: Array, qd: Array, way: Array, first: Array, gone: Array, go: Array
) -> tuple[Array, Array]:
    """Position and speed after `go` of the row, in one step of the classical method."""
    time = go * between.length
    half, middle, end = 0.5 * time, first + 0.5 * go, first + go
    a1 = _acceleration(joint, between, q, qd, way, first, gone)
    v2 = qd + half * a1
    a2 = _acceleration(joint, between, q + half * qd, v2, way, middle, gone + 0.5 * go)
    v3 = qd + half * a2
    a3 = _acceleration(joint, between, q + half * v2, v3, way, middle, gone + 0.5 * go)
    v4 = qd + time * a3
    a4 = _acceleration(joint, between, q + time * v3, v4, way, end, gone + go)
    change = a1 + a2 + a3
    return q + time * (qd + time / 6.0 * change), qd + time / 6.0 * (change + a2 + a3 + a4)
