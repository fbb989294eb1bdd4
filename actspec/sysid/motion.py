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
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.sysid.figures import Bounds, Figures

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MOST_ARRIVALS = 3
"""Commands that may arrive between two rows. Chosen: a jitter of a whole step gives two."""
FINE = 0.25
"""Longest step times the fastest rate of the joint. Measured: halving it changes figures by less than 1e-5."""


@dataclass(frozen=True, slots=True)
class Course:
    """What a joint was commanded, and the model along its path; shape (n,) each, by row.

    Attributes:
        time: [s].
        command: Sent at the row's time [rad or m].
        speed_command: v* [rad/s or m/s].
        inertia: Of the links [kg*m^2 or kg].
        load: g, what the links need beside inertia, at `path` [N*m or N].
        slope: s = dg/dq [N*m/rad or N/m].
        path: q_ref, where load and slope hold [rad or m].
    """

    time: Array
    command: Array
    speed_command: Array
    inertia: Array
    load: Array
    slope: Array
    path: Array


@dataclass(frozen=True, slots=True)
class _Parts:
    """The time between two rows, divided where commands arrive; shapes (n - 1, n_part, n_delay).

    Attributes:
        begin: As a share of the row.
        end: Likewise.
        index: Of the command that holds.
        before: Index of the command whose torque is read at each row, shape (n, n_delay).
    """

    begin: Array
    end: Array
    index: NDArray[np.intp]
    before: NDArray[np.intp]


def _divided(time: Array, delays: Array) -> _Parts:
    import numpy as np

    start, length = time[:-1], np.diff(time)
    per_delay = []
    for delay in delays:
        arrival = time + delay
        # What arrives at a row's time acts from then on, and is not in what is read then.
        first = np.searchsorted(arrival, start + 1e-9, side="right")
        last = np.searchsorted(arrival, time[1:] - 1e-9, side="left")
        before = np.searchsorted(arrival, time - 1e-9, side="left") - 1
        per_delay.append((arrival, first, last, before))
    count = min(max(int((last - first).max()) for _, first, last, _ in per_delay), MOST_ARRIVALS)
    shape = (len(start), count + 1, len(delays))
    begin, end, index = np.empty(shape), np.empty(shape), np.empty(shape, dtype=np.intp)
    for d, (arrival, first, last, _) in enumerate(per_delay):
        for k in range(count + 1):
            left = arrival[np.clip(first + k - 1, 0, len(arrival) - 1)]
            right = arrival[np.clip(first + k, 0, len(arrival) - 1)]
            begin[:, k, d] = 0.0 if k == 0 else np.where(first + k - 1 < last, (left - start) / length, 1.0)
            inside = (first + k < last) if k < count else np.zeros(len(start), dtype=bool)
            end[:, k, d] = np.where(inside, (right - start) / length, 1.0)
            index[:, k, d] = np.clip(first + k - 1, 0, len(arrival) - 1)
    before_all = np.stack([np.clip(before, 0, None) for *_, before in per_delay], axis=1)
    return _Parts(begin, end, index, before_all)


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
            found: Array = value[0][where[1]]
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
        found: Array = self.target + (self.command - self.target) * np.exp(-self.rate * after)
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
    import numpy as np

    delays, which = np.unique(figures.delay, return_inverse=True)
    parts = _divided(course.time, delays)
    lags, lag_of = np.unique(np.stack([figures.delay, figures.lag]), axis=1, return_inverse=True)
    filtered = _filtered(course, lags, parts, delays) if np.any(lags[1] > 0) else None
    speed = figures.stribeck_velocity
    joint = _Joint(
        kp=figures.kp[None, :],
        kd=figures.kd[None, :],
        armature=figures.armature[None, :],
        coulomb=figures.coulomb[None, :],
        viscous=figures.viscous[None, :],
        bias=figures.bias[None, :],
        static=figures.static[None, :],
        per_stribeck=(1.0 / np.where(speed > 0, speed, np.inf))[None, :],
        slipping=bool(np.any((figures.static > figures.coulomb) & (speed > 0))),
        bounds=bounds,
    )
    rate = np.where(figures.lag > 0, 1.0 / np.where(figures.lag > 0, figures.lag, 1.0), np.inf)[None, :]
    rate_used = None if filtered is None else np.minimum(rate, 1e9)
    read = None
    if reading is not None:
        sent = np.searchsorted(course.time + reading, course.time - 1e-9, side="left") - 1
        read = course.command[np.clip(sent, 0, None)]
    fine = _division(course, figures) * finer
    shape = (rows, len(starts), len(figures.kp))
    out = Moved(*(np.empty(shape) for _ in range(4)))
    now_q, now_qd = np.array(q, dtype=float), np.array(qd, dtype=float)
    for k in range(rows):
        row = starts + k
        vd = course.speed_command[row][:, None]
        seen = course.command[parts.before[row][:, which]] if read is None else read[row][:, None]
        if filtered is not None:
            seen = filtered[row][:, lag_of]
        out.q[k], out.qd[k] = now_q, now_qd
        torque = joint.drive(seen, vd, now_q, now_qd)
        load = (course.load[row])[:, None] + course.slope[row][:, None] * (now_q - course.path[row][:, None])
        still = now_qd == 0.0
        resting = np.clip(torque - load, -joint.breakaway(), joint.breakaway())
        out.torque[k] = torque
        out.friction[k] = joint.viscous * now_qd + np.where(
            still, resting, np.sign(now_qd) * joint.dry(now_qd)
        )
        if k == rows - 1:
            break
        length = (course.time[row + 1] - course.time[row])[:, None]
        ends = [
            (getattr(course, name)[row][:, None], getattr(course, name)[row + 1][:, None])
            for name in ("inertia", "load", "slope", "path")
        ]
        command = None if filtered is None else filtered[row][:, lag_of]
        for p in range(parts.begin.shape[1]):
            begin, end = parts.begin[row, p][:, which], parts.end[row, p][:, which]
            if not np.any(end > begin):
                continue
            target = course.command[parts.index[row, p][:, which]]
            for i in range(fine):
                first = begin + (end - begin) * (i / fine)
                share = (end - begin) / fine
                between = _Between(
                    ends[0], ends[1], ends[2], ends[3], vd, target, target if command is None else command,
                    rate_used, length,
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


def _filtered(course: Course, pairs: Array, parts: _Parts, delays: Array) -> Array:
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
