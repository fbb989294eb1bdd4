"""One step of joints that are driven, with dry friction: classical Runge-Kutta, to a stand where they come to one.

What acts at a moment is linear in position and speed but for the drive's clip and dry friction. Its numbers do not
depend on where a joint is: they are worked out for many steps at once.

Arrays are by lane, which is a piece of a log with a set of figures; all in SI, at the joint.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.sysid.figures import Bounds

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

AT_ONCE = 1e9
"""Rate of a low-pass that is none [1/s]."""


@dataclass(slots=True)
class Joint:
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

    def take(self, lanes: NDArray[np.intp]) -> Joint:
        return Joint(
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
class Between:
    """The model between two rows, linear in time, and the command of one part; by row and lane, or by lane.

    Inertia, load, slope and path are pairs: at the earlier row, and the change to the later one. The rate has no rows.
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

    def take(self, row: int, lanes: NDArray[np.intp]) -> Between:
        """Of some lanes in one row."""

        def both(pair: tuple[Array, Array]) -> tuple[Array, Array]:
            return pair[0][row].take(lanes), pair[1][row].take(lanes)

        return Between(
            both(self.inertia),
            both(self.load),
            both(self.slope),
            both(self.path),
            self.speed_command[row].take(lanes),
            self.target[row].take(lanes),
            self.command[row].take(lanes),
            None if self.rate is None else self.rate.take(lanes),
            self.length[row].take(lanes),
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
class Moment:
    """What acts at one moment, as a function of position and speed; by lane, or by row and lane.

    Attributes:
        joint: Figures.
        drive: Torque of the drive at position and speed 0, before it is clipped.
        push: Of the links there.
        slope: Of their load over the position.
        light: One over the inertia.
    """

    joint: Joint
    drive: Array
    push: Array
    slope: Array
    light: Array

    @classmethod
    def of(cls, joint: Joint, between: Between, share: Array, command: Array) -> Moment:
        """At a share of the row, with the command that acts then."""
        slope = between.at(between.slope, share)
        return cls(
            joint,
            joint.kp * (command - joint.bias) + joint.kd * between.speed_command,
            slope * between.at(between.path, share) - between.at(between.load, share),
            slope,
            1.0 / (between.at(between.inertia, share) + joint.armature),
        )

    def row(self, row: int) -> Moment:
        """In one row."""
        return Moment(self.joint, self.drive[row], self.push[row], self.slope[row], self.light[row])

    def net(self, q: Array, qd: Array) -> Array:
        """All that pulls at the joint but dry friction."""
        joint = self.joint
        torque = joint.bounds.clip(self.drive - joint.kp * q - joint.kd * qd, qd)
        return torque + self.push - self.slope * q - joint.viscous * qd

    def acceleration(self, net: Array, dry: Array) -> Array:
        """With what pulls, and dry friction."""
        return (net - dry) * self.light


@dataclass(slots=True)
class Step:
    """One step in each of several rows; by row and lane.

    Attributes:
        between: The model there.
        begin: What acts at its beginning.
        middle: Halfway.
        end: At its end.
        first: Share of the row at its beginning.
        share: Of the row that it takes.
        time: That it takes [s].
        acts: Of each row, whether it takes any.
    """

    between: Between
    begin: Moment
    middle: Moment
    end: Moment
    first: Array
    share: Array
    time: Array
    acts: list[bool]


def advance(joint: Joint, step: Step, row: int, q: Array, qd: Array) -> tuple[Array, Array]:
    """One step of a row: position and speed after it."""
    import numpy as np

    way, time = np.sign(qd), step.time[row]
    begin = step.begin.row(row)
    net = begin.net(q, qd)
    # In a third of the time that `any` takes.
    if np.count_nonzero(qd) < qd.size:
        still = qd == 0.0
        held = still & (np.abs(net) <= joint.breakaway())
        way = np.where(still, np.sign(net), way)
        # What acts later in the step is no matter where it takes no time.
        time = np.where(held, 0.0, time)
    new_q, new_qd = _runge_kutta(begin, step.middle.row(row), step.end.row(row), net, q, qd, way, time)
    back = (way * new_qd < 0.0) & (time > 0.0)
    if np.count_nonzero(back):
        lanes = np.flatnonzero(back)
        parts = (q, qd, way, step.first[row], step.share[row], new_qd)
        turned = _turned(
            joint.take(lanes), step.between.take(row, lanes), *(values.take(lanes) for values in parts)
        )
        new_q.put(lanes, turned[0])
        new_qd.put(lanes, turned[1])
    return new_q, new_qd


def _turned(
    joint: Joint,
    between: Between,
    q: Array,
    qd: Array,
    way: Array,
    first: Array,
    share: Array,
    after: Array,
) -> tuple[Array, Array]:
    """A step within which these joints come to a stand: to that moment, and on if something pulls."""
    import numpy as np

    def moment(share: Array, gone: Array | float) -> Moment:
        return Moment.of(joint, between, share, between.command_at(gone))

    begin = moment(first, 0.0)
    net = begin.net(q, qd)
    # A straight line in the speed, put right once: it is 0 there to the fourth power of the step.
    until = share * np.where(qd == after, 0.0, qd / np.where(qd == after, 1.0, qd - after))

    def stopped() -> tuple[Array, Array]:
        halfway = 0.5 * until
        middle, end = moment(first + halfway, halfway), moment(first + until, until)
        return _runge_kutta(begin, middle, end, net, q, qd, way, until * between.length)

    for _ in range(2):
        at, speed = stopped()
        end = moment(first + until, until)
        pull = end.acceleration(end.net(at, speed), way * joint.dry(speed))
        until = np.clip(
            until - np.where(pull == 0.0, 0.0, speed / np.where(pull == 0.0, 1.0, pull)) / between.length,
            0.0,
            share,
        )
    at, _ = stopped()
    rest = 0.0 * at
    stopping = first + until
    stand = moment(stopping, until)
    pulls = stand.net(at, rest)
    left = np.where(np.abs(pulls) > joint.breakaway(), share - until, 0.0)
    new_way = np.sign(pulls)
    middle = moment(stopping + 0.5 * left, until + 0.5 * left)
    end = moment(stopping + left, until + left)
    new_q, new_qd = _runge_kutta(stand, middle, end, pulls, at, rest, new_way, left * between.length)
    again = new_way * new_qd < 0.0
    return np.where(again, at, new_q), np.where(again, 0.0, new_qd)


def _runge_kutta(
    begin: Moment, middle: Moment, end: Moment, net: Array, q: Array, qd: Array, way: Array, time: Array
) -> tuple[Array, Array]:
    """Position and speed a time later, in one step of the classical method.

    Args:
        begin: What acts at the step's beginning.
        middle: Halfway.
        end: At its end.
        net: What pulls at its beginning.
        q: Then.
        qd: Likewise.
        way: In which dry friction is overcome.
        time: That the step takes [s].
    """
    joint, half = begin.joint, 0.5 * time
    always = None if joint.slipping else way * joint.coulomb

    def dry(speed: Array) -> Array:
        return way * joint.dry(speed) if always is None else always

    a1 = begin.acceleration(net, dry(qd))
    v2 = qd + half * a1
    a2 = middle.acceleration(middle.net(q + half * qd, v2), dry(v2))
    v3 = qd + half * a2
    a3 = middle.acceleration(middle.net(q + half * v2, v3), dry(v3))
    v4 = qd + time * a3
    a4 = end.acceleration(end.net(q + time * v3, v4), dry(v4))
    sixth, change = time / 6.0, a1 + a2 + a3
    return q + time * (qd + sixth * change), qd + sixth * (change + a2 + a3 + a4)
