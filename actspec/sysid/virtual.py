"""A spec in place of the robot: what its joints do under a log of commands, and what sensors make of that.

Joints on a stand, coupled through the links, by the midpoint rule at a fifth of a millisecond; dry friction holds a
joint exactly. The program is not that of the fit: it works joint by joint in time, with the mass matrix of every step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Span, listed
from actspec.ir import Command, JointActuator
from actspec.logs import JointLog, Log, LogError, Sidecar
from actspec.robot.view import RobotView
from actspec.sysid.figures import Bounds, figures_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

STEP = 2e-4
"""Step of the virtual robot [s]. Chosen: a tenth of a fast log's, and below the steps of the fit."""
TURNS = 6
"""Most joints that come to a stand within one step."""
ROUNDS = 6
"""Most changes of what stands and what slides within one step."""
COARSE, FINE = 1e-3, 0.1
"""Longest step of what is expected of an experiment [s], and the longest as a share of the time in which the joints
answer. Chosen: the midpoint rule's error is then a few thousandths."""
MOST_JITTER = 0.45
"""Of a row, as a share of the usual step, to either side: rows stay in their order."""


@dataclass(frozen=True, slots=True)
class Flaws:
    """What sensors and the link to them do; 0: nothing.

    Attributes:
        position_noise: Standard deviation [rad or m].
        velocity_noise: [rad/s or m/s].
        torque_noise: As a share of the torque's root mean square.
        bits: Of an encoder over one turn, or over a metre; 0: none.
        velocity_filter: Cutoff of the velocity's low-pass [Hz].
        jitter: Standard deviation of when a row is read and its command sent, as a share of the usual step.
        dropped: Share of rows that are missing.
        play: Between joint and encoder, from end to end [rad or m].
        sag: Share of the torque-speed line that is lost at full torque.
        torque_scale: Error of the torque sensor as a factor less 1.
        torque_constant: The log has `current` in place of torque [N*m/A].
    """

    position_noise: float = 0.0
    velocity_noise: float = 0.0
    torque_noise: float = 0.0
    bits: int = 0
    velocity_filter: float = 0.0
    jitter: float = 0.0
    dropped: float = 0.0
    play: float = 0.0
    sag: float = 0.0
    torque_scale: float = 0.0
    torque_constant: float = 0.0


@dataclass(frozen=True, slots=True)
class _Joint:
    """Figures of one joint, as plain numbers: numpy takes ten times as long for a few joints."""

    kp: float
    kd: float
    armature: float
    coulomb: float
    static: float
    per_stribeck: float
    viscous: float
    delay: float
    bias: float
    lag: float
    sag: float
    bounds: Bounds
    per_speed: float

    @classmethod
    def of(cls, actuator: JointActuator, sag: float) -> _Joint:
        values, bounds = figures_of(actuator), Bounds.of(actuator)
        coulomb, stribeck = values["coulomb"], values["stribeck_velocity"]
        return cls(
            kp=values["kp"],
            kd=values["kd"],
            armature=values["armature"],
            coulomb=coulomb,
            static=max(values["static"], coulomb) if stribeck > 0 else coulomb,
            per_stribeck=1.0 / stribeck if stribeck > 0 else 1.0,
            viscous=values["viscous"],
            delay=values["delay"],
            bias=values["bias"],
            lag=values["lag"],
            sag=sag,
            bounds=bounds,
            per_speed=bounds.stall / bounds.no_load if math.isfinite(bounds.stall) else 0.0,
        )

    def drive(self, command: float, speed_command: float, q: float, qd: float) -> float:
        """Its torque while it is on."""
        wanted = self.kp * (command - q - self.bias) + self.kd * (speed_command - qd)
        bounds = self.bounds
        if bounds.curve is not None:
            return float(bounds.clip(wanted, qd))  # type: ignore[arg-type]
        stall, line = bounds.stall, self.per_speed * qd
        if self.sag:
            stall *= 1.0 - self.sag * min(abs(wanted) / bounds.limit, 1.0)
        low, high = max(-bounds.limit, -stall - line), min(bounds.limit, stall - line)
        return min(max(wanted, low), high)

    def dry(self, qd: float) -> float:
        """Size of the dry friction."""
        if self.static == self.coulomb:
            return self.coulomb
        return self.coulomb + (self.static - self.coulomb) * math.exp(-((qd * self.per_stribeck) ** 2))


@dataclass(slots=True)
class _Plant:
    """The joints, and the links. Figures of all joints are lists, in their order."""

    joints: Sequence[_Joint]
    links: Callable[[Array, Array], tuple[Array, Array]] = field(repr=False)

    def at(self, q: list[float], qd: list[float]) -> tuple[Array, list[float]]:
        """The mass matrix with armature, and the links' loads."""
        import numpy as np

        mass, load = self.links(np.array(q), np.array(qd))
        for i, joint in enumerate(self.joints):
            mass[i, i] += joint.armature
        return mass, load.tolist()

    def drive(
        self,
        on: list[float],
        command: list[float],
        speed_command: list[float],
        q: list[float],
        qd: list[float],
    ) -> list[float]:
        """Torques of the drives, of which some may be off."""
        parts = zip(self.joints, on, command, speed_command, q, qd, strict=True)
        return [there * joint.drive(a, v, at, speed) for joint, there, a, v, at, speed in parts]

    def rubbed(self, net: list[float], qd: list[float], way: list[float]) -> list[float]:
        """All torques, dry friction among them."""
        parts = zip(self.joints, net, qd, way, strict=True)
        return [pull - sign * joint.dry(speed) for joint, pull, speed, sign in parts]

    def acceleration(
        self, mass: Array, net: list[float], qd: list[float], way: list[float], held: list[bool]
    ) -> tuple[list[float], list[bool]]:
        """Accelerations, and which joints dry friction holds.

        Args:
            mass: With armature.
            net: All torques but dry friction [N*m or N].
            qd: Speeds.
            way: Signs that dry friction is against.
            held: Joints that stand.
        """
        import numpy as np

        if not any(held):
            return _solved(mass, self.rubbed(net, qd, way)), held
        found = [0.0] * len(net)
        for _ in range(ROUNDS):
            found = [0.0] * len(net)
            moves = [i for i, one in enumerate(held) if not one]
            if moves:
                force = self.rubbed(net, qd, way)
                parts = _solved(mass[np.ix_(moves, moves)], [force[i] for i in moves])
                for i, part in zip(moves, parts, strict=True):
                    found[i] = part
            # What friction must give so that a held joint stays.
            pulls = (mass @ found).tolist() if moves else found
            needed = [pull - other for pull, other in zip(net, pulls, strict=True)]
            slips = [
                one and abs(pull) > joint.static
                for joint, one, pull in zip(self.joints, held, needed, strict=True)
            ]
            if not any(slips):
                break
            held = [one and not slip for one, slip in zip(held, slips, strict=True)]
            way = [_sign(pull) if slip else sign for slip, pull, sign in zip(slips, needed, way, strict=True)]
        return found, held


def _sign(value: float) -> float:
    return math.copysign(1.0, value) if value else 0.0


def _solved(mass: Array, force: list[float]) -> list[float]:
    """Acceleration of joints by their mass matrix."""
    import numpy as np

    # Ten times as fast as a call of the library, for the joint that is alone.
    if len(force) == 1:
        return [force[0] / float(mass[0, 0])]
    found: list[float] = np.linalg.solve(mass, force).tolist()
    return found


def follow(
    robot: RobotView,
    actuators: Sequence[JointActuator],
    commands: Log,
    path: str,
    flaws: Flaws,
    seed: int,
    progress: Callable[[int, int], None] | None = None,
) -> Log:
    """Let the virtual robot follow a log's commands.

    Args:
        robot: Its model.
        actuators: Of the joints that the log commands, in its order.
        commands: The log; only time, commands and `enabled` count: a drive that is off gives no torque.
        path: Name of the new log.
        flaws: Of the sensors.
        seed: Of all noise: the same seed gives the same log.
        progress: Called with rows done, of how many.

    Raises:
        LogError: a joint has no position command.
        RobotError: the model does not tell the links' inertia.
    """
    import numpy as np

    from actspec.sysid.links import links_at

    names = [actuator.joint for actuator in actuators]
    wrong = [a.joint for a in actuators if a.command is not Command.POSITION]
    missing = [name for name in names if commands.joints[name].command is None]
    if wrong or missing:
        message = f"no position command: {listed([*wrong, *missing])}"
        raise LogError.of("SYS022", message, Span(commands.path))
    base = commands.sidecar.base
    links = links_at(robot, names, None if base is None else base.orientation)
    plant = _Plant([_Joint.of(actuator, flaws.sag) for actuator in actuators], links)
    command = np.stack([np.asarray(commands.joints[name].command) for name in names], axis=1)
    speeds = [commands.joints[name].velocity_command for name in names]
    speed_command = np.stack([np.zeros(len(command)) if s is None else s for s in speeds], axis=1)
    stated = [commands.joints[name].enabled for name in names]
    enabled = np.stack([np.ones(len(command)) if s is None else s for s in stated], axis=1)
    random = np.random.default_rng(seed)
    time = commands.time.copy()
    if flaws.jitter > 0:
        # The loop comes late or early: what it reads is read then, and what it sends is sent then.
        shift = np.clip(random.normal(0.0, flaws.jitter, len(time)), -MOST_JITTER, MOST_JITTER)
        time[1:-1] += commands.step * shift[1:-1]
    q, qd, torque = _moved(plant, time, command, speed_command, enabled, STEP, progress)
    return sensed(replace(commands, time=time), actuators, q, qd, torque, path, flaws, random)


def expected(
    robot: RobotView,
    actuators: Sequence[JointActuator],
    time: Array,
    command: Array,
    orientation: Sequence[float] | None,
) -> tuple[Array, Array, Array]:
    """What the joints do under commands, all of them coupled, in steps that are just fine enough for them.

    Args:
        robot: Its model.
        actuators: Of the joints.
        time: Of the commands [s], shape (n,).
        command: Position commands [rad or m], shape (n, n_joint).
        orientation: Of the base; see `links_at`.

    Returns:
        Position [rad or m], speed and the drive's torque at every row, shape (n, n_joint) each.

    Raises: RobotError: the model does not tell the links' inertia.
    """
    import numpy as np

    from actspec.sysid.links import links_at

    links = links_at(robot, [a.joint for a in actuators], orientation)
    plant = _Plant([_Joint.of(actuator, 0.0) for actuator in actuators], links)
    mass, _ = plant.at(command[0].tolist(), [0.0] * len(actuators))
    rate = max(
        max(math.sqrt(joint.kp / inertia), (joint.kd + joint.viscous) / inertia)
        for joint, inertia in zip(plant.joints, np.diag(mass).tolist(), strict=True)
    )
    step = max(STEP, min(COARSE, FINE / rate)) if rate > 0 else COARSE
    return _moved(plant, time, command, 0.0 * command, np.ones_like(command), step, None)


def _moved(
    plant: _Plant,
    time: Array,
    command: Array,
    speed_command: Array,
    enabled: Array,
    usual: float,
    progress: Callable[[int, int], None] | None,
) -> tuple[Array, Array, Array]:
    """True position, speed and torque of the drive at every row, in steps of about `usual`; shape (n, n_joint)."""
    import numpy as np

    n, width = command.shape
    out = np.empty((3, n, width))
    clock: list[float] = time.tolist()
    sent: list[list[float]] = command.astype(float).tolist()
    wires = [_Wire(joint, clock, [row[j] for row in sent]) for j, joint in enumerate(plant.joints)]
    q, qd, rate = [wire.filtered - wire.joint.bias for wire in wires], [0.0] * width, [0.0] * width
    for row in range(n):
        if progress is not None and row % 100 == 0:
            progress(row, n)
        on, speeds = enabled[row].tolist(), speed_command[row].tolist()
        out[:, row] = q, qd, plant.drive(on, [wire.filtered for wire in wires], speeds, q, qd)
        if row == n - 1:
            break
        parts = max(1, round((clock[row + 1] - clock[row]) / usual))
        step = (clock[row + 1] - clock[row]) / parts
        for i in range(1, parts + 1):
            middle = [wire.advance(clock[row] + step * i, step) for wire in wires]
            q, qd, rate = _stepped(plant, on, middle, speeds, q, qd, rate, step)
    return out[0], out[1], out[2]


@dataclass(slots=True)
class _Wire:
    """What a joint's drive has been told.

    Attributes:
        joint: Its figures.
        clock: When commands are sent [s].
        commands: These.
        row: Of the last that has arrived.
        filtered: What the drive follows now.
    """

    joint: _Joint
    clock: Sequence[float]
    commands: Sequence[float]
    row: int = 0
    filtered: float = field(init=False)

    def __post_init__(self) -> None:
        self.filtered = self.commands[0]

    def advance(self, end: float, step: float) -> float:
        """What the drive follows in the middle of a step that ends then; it takes in what arrives."""
        clock, delay, before = self.clock, self.joint.delay, self.row
        while self.row + 1 < len(clock) and clock[self.row + 1] + delay < end - 1e-12:
            self.row += 1
        late = target = self.commands[self.row]
        if self.row > before:
            # A command that arrives within the step counts for the rest of it.
            share = min(max((end - (clock[self.row] + delay)) / step, 0.0), 1.0)
            target = self.commands[before] + share * (late - self.commands[before])
        if self.joint.lag <= 0:
            self.filtered = late
            return target
        keep, off = math.exp(-step / self.joint.lag), self.filtered - target
        self.filtered = target + off * keep
        return target + off * math.sqrt(keep)


def _stepped(
    plant: _Plant,
    on: list[float],
    command: list[float],
    speed_command: list[float],
    q: list[float],
    qd: list[float],
    rate: list[float],
    step: float,
) -> tuple[list[float], list[float], list[float]]:
    """One step of the midpoint rule; the links are taken at the middle, which the acceleration before leads to.

    A joint that comes to a stand within the step ends a part of the step there, and friction is asked anew.
    """
    left, turned = step, [False] * len(q)
    rubs = [joint.static > 0.0 for joint in plant.joints]

    def on_by(by: float, what: list[float], change: list[float]) -> list[float]:
        return [one + by * more for one, more in zip(what, change, strict=True)]

    def but(held: list[bool], values: list[float]) -> list[float]:
        return [0.0 if one else value for one, value in zip(held, values, strict=True)]

    def pulls(q: list[float], qd: list[float], load: list[float]) -> list[float]:
        torque = plant.drive(on, command, speed_command, q, qd)
        parts = zip(plant.joints, torque, qd, load, strict=True)
        return [drive - joint.viscous * speed - weight for joint, drive, speed, weight in parts]

    for _ in range(TURNS):
        half = 0.5 * left
        stands = [speed == 0.0 and one for speed, one in zip(qd, rubs, strict=True)]
        way = [_sign(speed) for speed in qd]
        half_q = on_by(half, q, qd)
        mass, load = plant.at(half_q, on_by(half, qd, rate))
        first, held = plant.acceleration(mass, pulls(q, qd, load), qd, way, stands)
        parts = zip(stands, held, first, way, strict=True)
        way = [_sign(more) if stood and not one else sign for stood, one, more, sign in parts]
        half_qd = but(held, on_by(half, qd, first))
        second, _ = plant.acceleration(mass, pulls(half_q, half_qd, load), half_qd, way, held)
        rate = but(held, second)
        new_qd = on_by(left, qd, rate)
        turned = [
            sign * speed < 0.0 and not one and rub
            for sign, speed, one, rub in zip(way, new_qd, held, rubs, strict=True)
        ]
        if any(turned):
            # What another joint pulls back within the step it broke away in has not broken away.
            stays = [turn and stood for turn, stood in zip(turned, stands, strict=True)]
            half_qd, new_qd, rate = but(stays, half_qd), but(stays, new_qd), but(stays, rate)
            held = [one or stay for one, stay in zip(held, stays, strict=True)]
            turned = [turn and not stood for turn, stood in zip(turned, stands, strict=True)]
        if not any(turned):
            return on_by(left, q, half_qd), new_qd, rate
        shares = [
            speed / (speed - new) if turn else 1.0
            for turn, speed, new in zip(turned, qd, new_qd, strict=True)
        ]
        share = min(shares)
        until = share * left
        # To the first of them; its speed is 0 there to the square of the step.
        q = on_by(until, q, but(held, on_by(0.5 * until, qd, first)))
        stopped = [
            one or (turn and own == share) for one, turn, own in zip(held, turned, shares, strict=True)
        ]
        qd = but(stopped, on_by(until, qd, second))
        left -= until
    return q, but(turned, qd), rate


def sensed(
    commands: Log,
    actuators: Sequence[JointActuator],
    q: Array,
    qd: Array,
    torque: Array,
    path: str,
    flaws: Flaws,
    random: np.random.Generator,
) -> Log:
    """What is logged of a motion.

    Args:
        commands: The log of commands, on the rows that were read.
        actuators: Of the joints.
        q, qd: True position [rad or m] and speed, shape (n, n_joint).
        torque: Of the drive [N*m or N], likewise.
        path: Of the log.
        flaws: Of the sensors.
        random: Draws the noise, joint by joint.
    """
    time, step = commands.time, commands.step
    kept = random.random(len(time)) >= flaws.dropped
    kept[[0, -1]] = True
    joints: Mapping[str, JointLog] = {
        actuator.joint: _joint(commands, actuator, q[:, j], qd[:, j], torque[:, j], step, flaws, random, kept)
        for j, actuator in enumerate(actuators)
    }
    sidecar = Sidecar(robot=commands.sidecar.robot, base=commands.sidecar.base, pose=commands.sidecar.pose)
    return Log(path, "", time[kept], joints, sidecar)


def _joint(
    commands: Log,
    actuator: JointActuator,
    q: Array,
    qd: Array,
    torque: Array,
    step: float,
    flaws: Flaws,
    random: np.random.Generator,
    kept: NDArray[np.bool_],
) -> JointLog:
    import numpy as np

    given = commands.joints[actuator.joint]
    read = _behind_play(q, flaws.play) + (actuator.encoder_bias.value or 0.0)
    read = read + flaws.position_noise * random.standard_normal(len(q))
    if flaws.bits:
        count = 2.0 * math.pi / 2**flaws.bits if not given.linear else 1.0 / 2**flaws.bits
        read = np.round(read / count) * count
    speed = qd + flaws.velocity_noise * random.standard_normal(len(q))
    if flaws.velocity_filter > 0:
        keep = math.exp(-2.0 * math.pi * flaws.velocity_filter * step)
        slow = np.empty_like(speed)
        value = speed[0]
        for i, now in enumerate(speed):
            value = now + (value - now) * keep
            slow[i] = value
        speed = slow
    rms = float(np.sqrt(np.mean(torque**2)))
    felt = torque * (1.0 + flaws.torque_scale) + flaws.torque_noise * rms * random.standard_normal(len(q))
    current = felt / flaws.torque_constant if flaws.torque_constant else None
    return JointLog(
        actuator.joint,
        given.linear,
        command=np.asarray(given.command)[kept],
        position=read[kept],
        velocity=speed[kept],
        velocity_command=None if given.velocity_command is None else given.velocity_command[kept],
        torque=felt[kept] if current is None else None,
        current=None if current is None else current[kept],
        enabled=None if given.enabled is None else given.enabled[kept],
    )


def _behind_play(q: Array, play: float) -> Array:
    """An encoder that is taken along at either end of the play."""
    import numpy as np

    if play <= 0:
        return q
    found = np.empty_like(q)
    value = q[0]
    for i, now in enumerate(q):
        value = min(max(value, now - 0.5 * play), now + 0.5 * play)
        found[i] = value
    return found
