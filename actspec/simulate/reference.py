"""One joint as the law has it, held or moving: the reference for every engine and every fit.

    joint = DrivenJoint(law_of(actuator), PassiveFriction.of(actuator), inertia=0.12)
    moved = integrate([joint], command[:, None], q=np.zeros(1), qd=np.zeros(1), step=0.005)

A body of one joint and no gravity, J q'' = tau(a, q, q') - b q' - dry friction. The drive is continuous in
position and speed. Its command is one number a physics step, and so late by whole steps; behind a filter it goes on
from a_k to a_(k+1) as the low-pass itself does, a' = (u_k - a) / tau, which is where an engine with ever smaller steps
ends. Classical Runge-Kutta at a fraction of the step, with exact stick-slip: a joint whose speed comes to 0 within
a substep is taken to that moment, and stays while no more than the break-away friction pulls at it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

from actspec.ir import Command, JointActuator
from actspec.laws import (
    TorqueLaw,
    clip_command,
    delay_steps,
    filter_gain,
    initial_command_state,
    step_command,
)
from actspec.laws.network import NetworkDrive, sequence

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SUBSTEPS = 64
"""Of a physics step. Chosen: halving it changes less than 1e-6 of the way."""
TURNS = 4
"""Most changes of direction within one substep; a joint that is not through then stands."""
NO_LINE = 1e300
"""Stall torque that stands for a missing torque-speed line [N*m or N]; finite, because infinity less itself is none."""

SOFT_SHARE = 0.9
"""Share of the force at a resting dry friction that the constraint takes. Source: MuJoCo, `solimp`, its first number's
default; the constraint's regularisation is A (1 - d) / d."""
SOFT_RATE = 2.0 / (0.95 * 0.02)
"""Rate at which it stops a joint [1/s]: 2 / (dmax timeconst). Source: MuJoCo, "Solver parameters", `solref` 0.02 1 and
`solimp` 0.9 0.95, the defaults."""


@dataclass(frozen=True, slots=True)
class PassiveFriction:
    """Passive friction of a joint, outside of every clamp.

    Attributes:
        coulomb: Kinetic dry friction >= 0 [N*m or N].
        viscous: b >= 0 [N*m*s/rad or N*s/m].
        static: Break-away friction [N*m or N]; None: as kinetic.
        stribeck_velocity: [rad/s or m/s]; None: no Stribeck effect.
        soft: Whether dry friction is MuJoCo's constraint with default solver parameters, which creeps.
    """

    coulomb: float
    viscous: float
    static: float | None = None
    stribeck_velocity: float | None = None
    soft: bool = False

    @classmethod
    def of(cls, actuator: JointActuator) -> PassiveFriction:
        """That of a joint; what is unknown counts as 0, as in a target that emits nothing for it."""
        static, stribeck = actuator.friction_static, actuator.stribeck_velocity
        return cls(
            actuator.friction_coulomb.value or 0.0,
            actuator.friction_viscous.value or 0.0,
            None if static is None else static.value,
            None if stribeck is None else stribeck.value,
        )


@dataclass(frozen=True, slots=True)
class DrivenJoint:
    """A body of one joint, and its drive.

    Attributes:
        law: Of its drive.
        friction: Of the joint.
        inertia: J, armature included > 0 [kg*m^2 or kg].
    """

    law: TorqueLaw
    friction: PassiveFriction
    inertia: float


@dataclass(frozen=True, slots=True)
class Trajectory:
    """How joints moved.

    Attributes:
        q: Position at the start of each step and at the end of the last [rad or m], shape (n_step + 1, n_joint).
        qd: Speed, likewise [rad/s or m/s].
        torque: Of the drive at the start of each step [N*m or N], shape (n_step, n_joint).
    """

    q: Array
    qd: Array
    torque: Array


def held_torque(law: TorqueLaw, command: Array, q: Array, qd: Array, step: float, lag: int) -> Array:
    """Torque of a drive whose joint is put somewhere before every step; delay line and filter begin settled.

    Args:
        law: Of the joint.
        command: One a step, before clamp, delay and filter; shape (n_step, ...).
        q: Positions [rad or m], likewise.
        qd: Speeds [rad/s or m/s], likewise.
        step: Physics step > 0 [s].
        lag: Delay in physics steps, in place of the law's own.

    Returns:
        Torque in each step [N*m or N], likewise.

    Source:
        DESIGN section 5: the filter goes on once a step.
    """
    import numpy as np

    found: Array = np.asarray(law.torque(effective_commands(law, command, step, lag), q, qd))
    return found


def effective_commands(law: TorqueLaw, command: Array, step: float, lag: int) -> Array:
    """What reaches a drive of its commands: clamped, late, filtered; delay line and filter begin settled.

    Args: as of `held_torque`.

    Returns:
        Effective command in each step, in the command's unit, shape (n_step, ...).
    """
    import numpy as np

    low, high = law.command_range or (-math.inf, math.inf)
    given = np.asarray(clip_command(command, low=low, high=high))
    late: Array = np.concatenate([np.repeat(given[:1], lag, axis=0), given])[: len(given)]
    if law.filter_cutoff is None:
        return late
    alpha, found = filter_gain(law.filter_cutoff, step), np.empty_like(late)
    state = initial_command_state(given[0], 0)
    for k, now in enumerate(late):
        found[k], state = step_command(state, now, steps=0, alpha=alpha)
    return found


def reaching_commands(laws: Sequence[TorqueLaw], command: Array, step: float) -> Array:
    """What reaches several drives, each behind its own delay and filter; see `effective_commands`.

    Args:
        laws: Of the columns.
        command: In each step, shape (n_step, n_law).
        step: Of the commands [s].
    """
    import numpy as np

    return np.stack(
        [
            effective_commands(law, command[:, i], step, delay_steps(law.delay, step).steps)
            for i, law in enumerate(laws)
        ],
        axis=1,
    )


def held_network_torque(
    drive: NetworkDrive, command: Array, q: Array, qd: Array, step: float, lag: int
) -> Array:
    """Torque of a network's drive along courses, each begun at a reset.

    Args: as of `held_torque`; the drive's taps are physics steps.

    Returns:
        Torque in each step [N*m or N], shape (n_step, ...).

    Source:
        DESIGN section 5: the network gets the error of the effective command, its torque is clamped.
    """
    import numpy as np

    clip = drive.clip
    error = effective_commands(clip, command, step, lag) - (q + clip.encoder_bias)
    found: Array = np.asarray(clip.torque(sequence(drive.network, error, qd, 1), q, qd))
    return found


def integrate(
    joints: Sequence[DrivenJoint],
    command: Array,
    q: Array,
    qd: Array,
    step: float,
    *,
    substeps: int = SUBSTEPS,
) -> Trajectory:
    """Let every joint follow its command, each for itself.

    Args:
        joints: The joints, the columns of every array; one that takes several courses is named several times.
        command: One a step, before clamp, delay and filter, in each joint's own unit; shape (n_step, n_joint).
        q: Where they start [rad or m], shape (n_joint,).
        qd: How fast [rad/s or m/s], likewise.
        step: Physics step > 0 [s].
        substeps: Of a step.

    Source:
        DESIGN section 5. Measured: halving the substep changes less than 1e-6 of the way.
    """
    import numpy as np

    mine, pulls = _Numbers.of(joints), _Pull.all(joints, command, step)
    out = Trajectory(*(np.empty((len(command) + more, len(joints))) for more in (1, 1, 0)))
    still = np.zeros(len(joints))
    now = _State(np.array(q, dtype=float), np.array(qd, dtype=float), still, still)
    out.q[0], out.qd[0] = now.q, now.qd
    # What diverges is nan from there on, for who looks.
    with np.errstate(over="ignore", invalid="ignore"):
        for k, pull in enumerate(pulls):
            out.torque[k] = mine.drive(pull.at(0.0), now.q, now.qd)
            for i in range(substeps):
                if i == 0 or pull.gap is not None:
                    now = _pulled(mine, pull.at(i * step / substeps), now)
                now = _advance(mine, pull, now, i * step / substeps, step / substeps)
            out.q[k + 1], out.qd[k + 1] = now.q, now.qd
    return out


@dataclass(frozen=True, slots=True)
class _State:
    """Of the joints: position, speed, the direction that dry friction is taken for, and 0 where a joint stands."""

    q: Array
    qd: Array
    direction: Array
    go: Array


@dataclass(frozen=True, slots=True)
class _Pull:
    """What the command adds to the torque before the clamp, over one step [N*m or N].

    Attributes:
        end: Where it goes.
        gap: How far from there it is at the step's start; None where no joint has a filter.
        rate: Of the filter [1/s]; infinity without one.
    """

    end: Array
    gap: Array | None
    rate: Array

    @classmethod
    def all(cls, joints: Sequence[DrivenJoint], command: Array, step: float) -> Iterator[_Pull]:
        """Of every step."""
        import numpy as np

        due = np.empty_like(command)
        for i, joint in enumerate(joints):
            low, high = joint.law.command_range or (-math.inf, math.inf)
            late = delay_steps(joint.law.delay, step).steps
            given = np.asarray(clip_command(command[:, i], low=low, high=high))
            due[:, i] = np.concatenate([np.full(late, given[0]), given])[: len(given)]
        gain, offset = (np.array(column) for column in zip(*map(_worth, joints), strict=True))
        due = gain * due + offset
        rate = np.array([2.0 * math.pi * (joint.law.filter_cutoff or math.inf) for joint in joints])
        if not np.isfinite(rate).any():
            yield from (cls(end, None, rate) for end in due)
            return
        now = due[0]
        for end in due:
            # A joint without a filter has no gap.
            pull = cls(end, np.where(np.isfinite(rate), now - end, 0.0), rate)
            yield pull
            now = pull.at(step)

    def at(self, time: float | Array) -> Array:
        """A time after the step's start [s]."""
        import numpy as np

        if self.gap is None or (isinstance(time, float) and time == 0.0):
            return self.end if self.gap is None else self.end + self.gap
        found: Array = self.end + self.gap * np.exp(-np.minimum(self.rate, NO_LINE) * time)
        return found

    def take(self, where: NDArray[np.intp]) -> _Pull:
        """That of some joints."""
        return _Pull(self.end[where], None if self.gap is None else self.gap[where], self.rate[where])


@dataclass(frozen=True, slots=True)
class _Numbers:
    """The joints' numbers, an array each; a joint without a line has one that never acts."""

    kp: Array
    kd: Array
    limit: Array
    stall: Array
    slope: Array
    fastest: Array
    drive_torque: Array
    brake_torque: Array
    knee: Array
    span: Array
    curved: Array
    inertia: Array
    viscous: Array
    dry: Array
    extra: Array
    per_stribeck: Array
    breakaway: Array
    soft: Array
    share: Array
    rate: Array
    lined: bool
    curving: bool
    slipping: bool
    softened: bool

    @classmethod
    def of(cls, joints: Sequence[DrivenJoint]) -> _Numbers:
        """Those of joints."""
        import numpy as np

        rows = [_row(joint) for joint in joints]
        laws, frictions = [joint.law for joint in joints], [joint.friction for joint in joints]
        kinds = (
            any(law.stall_torque is not None for law in laws),
            any(law.curve is not None for law in laws),
            any(friction.stribeck_velocity is not None for friction in frictions),
            any(friction.soft for friction in frictions),
        )
        values: list[Any] = [*(np.array(column, dtype=float) for column in zip(*rows, strict=True)), *kinds]
        return cls(*values)

    def take(self, where: NDArray[np.intp]) -> _Numbers:
        """Those of some joints."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        arrays = {name: value[where] for name, value in values.items() if not isinstance(value, bool)}
        return replace(self, **arrays)

    def drive(self, pull: Array, q: Array, qd: Array) -> Array:
        """Torque of the drives: `TorqueLaw.torque` of many laws at once, to which a test holds it.

        Args:
            pull: What the command adds before the clamp [N*m or N].
            q: [rad or m].
            qd: [rad/s or m/s].
        """
        import numpy as np

        tau = pull - self.kp * q - self.kd * qd
        high, low = self.limit, -self.limit
        if self.lined:
            line = self.slope * np.minimum(np.maximum(qd, -self.fastest), self.fastest)
            high, low = np.minimum(high, self.stall - line), np.maximum(low, -self.stall - line)
        found: Array = np.minimum(np.maximum(tau, low), high)
        if not self.curving:
            return found
        base = np.where(tau * qd > 0.0, self.drive_torque, self.brake_torque)
        over = np.abs(qd) - self.knee
        left = np.where(
            self.span > 0.0,
            np.clip(1.0 - over / np.where(self.span > 0.0, self.span, 1.0), 0.0, 1.0),
            over <= 0.0,
        )
        bound = np.minimum(base * left, self.limit)
        return np.where(self.curved > 0.0, np.minimum(np.maximum(tau, -bound), bound), found)

    def acceleration(self, pull: Array, q: Array, qd: Array, direction: Array) -> Array:
        """q'' while dry friction acts against a direction."""
        import numpy as np

        net = self.drive(pull, q, qd) - self.viscous * qd
        dry = self.dry
        if self.slipping:
            dry = dry + self.extra * np.exp(-((qd * self.per_stribeck) ** 2))
        force = net - direction * dry
        if self.softened:
            held = self.share * (net + self.inertia * self.rate * qd)
            force = force - np.minimum(np.maximum(held, -self.soft), self.soft)
        found: Array = force / self.inertia
        return found


def _row(joint: DrivenJoint) -> tuple[float, ...]:
    law, friction = joint.law, joint.friction
    stall, slope, fastest = NO_LINE, 0.0, math.inf
    if law.curve is None and law.stall_torque is not None and law.no_load_speed is not None:
        stall, slope = law.stall_torque, law.stall_torque / law.no_load_speed
        fastest = law.no_load_speed * (1.0 + law.effort_limit / law.stall_torque)
    drive, brake, knee, no_load = law.curve or (0.0, 0.0, 0.0, 0.0)
    dry = friction.coulomb
    static = dry if friction.static is None else max(friction.static, dry)
    stribeck = friction.stribeck_velocity
    hard = 0.0 if friction.soft else 1.0
    return (
        *(law.kp, law.kd, law.effort_limit, stall, slope, fastest),
        *(drive, brake, knee, no_load - knee, float(law.curve is not None)),
        *(joint.inertia, friction.viscous, hard * dry),
        *(hard * (static - dry) if stribeck else 0.0, 1.0 / stribeck if stribeck else 0.0, hard * static),
        *((1.0 - hard) * dry, SOFT_SHARE, SOFT_RATE),
    )


def _worth(joint: DrivenJoint) -> tuple[float, float]:
    """What a command is worth as a torque: times the first, and the second more."""
    law = joint.law
    if law.command is Command.POSITION:
        return law.kp, -law.kp * law.encoder_bias
    return (law.kd, 0.0) if law.command is Command.VELOCITY else (1.0, 0.0)


def _pulled(mine: _Numbers, pull: Array, now: _State) -> _State:
    """The state under another pull: joints that stand break away, or do not."""
    import numpy as np

    stands = (now.qd == 0.0) & (mine.breakaway > 0.0)
    if not stands.any():
        return _State(now.q, now.qd, np.sign(now.qd), np.ones_like(now.qd))
    net = mine.drive(pull, now.q, np.zeros_like(now.q))
    held = stands & (np.abs(net) <= mine.breakaway)
    direction = np.where(stands, np.sign(net), np.sign(now.qd))
    return _State(now.q, now.qd, direction, np.where(held, 0.0, 1.0))


def _advance(mine: _Numbers, pull: _Pull, now: _State, start: float, time: float) -> _State:
    """One substep, which starts a time after the step's start."""
    import numpy as np

    q, qd = _runge_kutta(mine, pull, now, start, time)
    back = (now.direction * qd < 0.0) & (mine.breakaway > 0.0) & (now.go > 0.0)
    if not back.any():
        return _State(q, qd, now.direction, now.go)
    (where,) = np.nonzero(back)
    before = _State(*(getattr(now, field.name)[where] for field in fields(now)))
    after = _turn(mine.take(where), pull.take(where), before, start, time)
    direction, go = now.direction.copy(), now.go.copy()
    q[where], qd[where], direction[where], go[where] = after.q, after.qd, after.direction, after.go
    return _State(q, qd, direction, go)


def _turn(mine: _Numbers, pull: _Pull, now: _State, start: float, time: float) -> _State:
    """A substep within which these joints come to stand: to that moment, and on if something pulls."""
    import numpy as np

    end = np.full(len(now.q), start + time)
    begin: Array = np.full(len(now.q), start)
    for _ in range(TURNS):
        left = end - begin
        q, qd = _runge_kutta(mine, pull, now, begin, left)
        back = (now.direction * qd < 0.0) & (now.go > 0.0)
        if not back.any():
            return _State(q, qd, now.direction, now.go)
        # A straight line in the speed: it is 0 there to the square of the substep, and so is where it stands.
        until = np.where(back, left * now.qd / np.where(back, now.qd - qd, 1.0), left)
        at, speed = _runge_kutta(mine, pull, now, begin, until)
        begin = begin + until
        now = _pulled(mine, pull.at(begin), _State(at, np.where(back, 0.0, speed), now.direction, now.go))
    return _State(now.q, np.where(back, 0.0, now.qd), now.direction, np.where(back, 0.0, now.go))


def _runge_kutta(
    mine: _Numbers, pull: _Pull, now: _State, start: float | Array, time: float | Array
) -> tuple[Array, Array]:
    """Position and speed after a time, in one step of the classical method."""
    q, qd, way = now.q, now.qd, now.direction
    begin, middle, end = (pull.at(start + share * time) for share in (0.0, 0.5, 1.0))
    time = time * now.go
    half = 0.5 * time
    first = mine.acceleration(begin, q, qd, way)
    speed = qd + half * first
    second = mine.acceleration(middle, q + half * qd, speed, way)
    later = qd + half * second
    third = mine.acceleration(middle, q + half * speed, later, way)
    last = mine.acceleration(end, q + time * later, qd + time * third, way)
    change = first + second + third
    return q + time * (qd + time / 6.0 * change), qd + time / 6.0 * (change + second + third + last)
