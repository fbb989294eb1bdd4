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


@dataclass(slots=True)
class _Plant:
    """Figures of the joints, an array each, and the links."""

    kp: Array
    kd: Array
    armature: Array
    coulomb: Array
    static: Array
    per_stribeck: Array
    even: bool
    viscous: Array
    delay: Array
    bias: Array
    limit: Array
    stall: Array
    per_speed: Array
    curves: Sequence[tuple[int, Bounds]]
    rate: Array
    sag: float
    on: Array
    links: Callable[[Array, Array], tuple[Array, Array]] = field(repr=False)

    def drive(self, command: Array, speed_command: Array, q: Array, qd: Array) -> Array:
        import numpy as np

        wanted = self.kp * (command - q - self.bias) + self.kd * (speed_command - qd)
        stall, line = self.stall, self.per_speed * qd
        if self.sag:
            stall = stall * (1.0 - self.sag * np.minimum(np.abs(wanted) / self.limit, 1.0))
        high, low = np.minimum(self.limit, stall - line), np.maximum(-self.limit, -stall - line)
        found: Array = np.minimum(np.maximum(wanted, low), high)
        for i, curved in self.curves:
            found[i] = curved.clip(wanted[i], qd[i])
        return found * self.on

    def dry(self, qd: Array) -> Array:
        import numpy as np

        if self.even:
            return self.coulomb
        found: Array = self.coulomb + (self.static - self.coulomb) * np.exp(-((qd * self.per_stribeck) ** 2))
        return found

    def acceleration(
        self, mass: Array, net: Array, qd: Array, way: Array, held: NDArray[np.bool_]
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Accelerations, and which joints dry friction holds.

        Args:
            mass: With armature.
            net: All torques but dry friction [N*m or N].
            qd: Speeds.
            way: Signs that dry friction is against.
            held: Joints that stand.
        """
        import numpy as np

        if not held.any():
            return _solved(mass, net - way * self.dry(qd)), held
        found = np.zeros_like(net)
        for _ in range(ROUNDS):
            moves = ~held
            found = np.zeros_like(net)
            if moves.any():
                force = net - way * self.dry(qd)
                found[moves] = _solved(mass[np.ix_(moves, moves)], force[moves])
            # What friction must give so that a held joint stays.
            needed = net - mass @ found
            slips = held & (np.abs(needed) > self.static)
            if not slips.any():
                break
            held = held & ~slips
            way = np.where(slips, np.sign(needed), way)
        return found, held


def _solved(mass: Array, force: Array) -> Array:
    """Acceleration of joints by their mass matrix."""
    import numpy as np

    # Ten times as fast as a call of the library, for the joint that is alone.
    found = force / mass[0, 0] if len(force) == 1 else np.linalg.solve(mass, force)
    return np.asarray(found, dtype=float)


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
    plant = _plant(actuators, flaws.sag, links)
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

    plant = _plant(actuators, 0.0, links_at(robot, [a.joint for a in actuators], orientation))
    mass, _ = plant.links(command[0], 0.0 * command[0])
    inertia = np.diag(mass) + plant.armature
    rate = float(np.maximum(np.sqrt(plant.kp / inertia), (plant.kd + plant.viscous) / inertia).max())
    step = max(STEP, min(COARSE, FINE / rate)) if rate > 0 else COARSE
    return _moved(plant, time, command, 0.0 * command, np.ones_like(command), step, None)


def _plant(
    actuators: Sequence[JointActuator], sag: float, links: Callable[[Array, Array], tuple[Array, Array]]
) -> _Plant:
    import numpy as np

    figures = [figures_of(actuator) for actuator in actuators]
    bounds = [Bounds.of(actuator) for actuator in actuators]

    def of(name: str) -> Array:
        return np.array([values[name] for values in figures])

    coulomb, stribeck, lag = of("coulomb"), of("stribeck_velocity"), of("lag")
    static = np.where(stribeck > 0, np.maximum(of("static"), coulomb), coulomb)
    return _Plant(
        kp=of("kp"),
        kd=of("kd"),
        armature=of("armature"),
        coulomb=coulomb,
        static=static,
        even=bool((static == coulomb).all()),
        per_stribeck=1.0 / np.where(stribeck > 0, stribeck, 1.0),
        viscous=of("viscous"),
        delay=of("delay"),
        bias=of("bias"),
        limit=np.array([bound.limit for bound in bounds]),
        stall=np.array([bound.stall for bound in bounds]),
        per_speed=np.array(
            [bound.stall / bound.no_load if math.isfinite(bound.stall) else 0.0 for bound in bounds]
        ),
        curves=[(i, bound) for i, bound in enumerate(bounds) if bound.curve is not None],
        rate=1.0 / np.where(lag > 0, lag, 1.0) + np.where(lag > 0, 0.0, math.inf),
        sag=sag,
        on=np.ones(len(figures)),
        links=links,
    )


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
    out = [np.empty((n, width)) for _ in range(3)]
    q, qd, rate = command[0] - plant.bias, np.zeros(width), np.zeros(width)
    arrival = time[:, None] + plant.delay
    columns = np.arange(width)
    sent = np.zeros(width, dtype=int)
    filtered = command[0].astype(float)
    slow = np.isfinite(plant.rate)
    for row in range(n):
        if progress is not None and row % 100 == 0:
            progress(row, n)
        out[0][row], out[1][row] = q, qd
        plant.on = enabled[row]
        out[2][row] = plant.drive(filtered, speed_command[row], q, qd)
        if row == n - 1:
            break
        parts = max(1, round((time[row + 1] - time[row]) / usual))
        step = (time[row + 1] - time[row]) / parts
        edges = time[row] + step * np.arange(1, parts + 1)
        arrived = np.stack(
            [np.maximum(np.searchsorted(arrival[:, j], edges - 1e-12) - 1, 0) for j in columns], axis=1
        )
        keep = np.where(slow, np.exp(-np.where(slow, plant.rate, 0.0) * step), 0.0)
        for i in range(parts):
            then = arrived[i]
            late = target = command[then, columns]
            if (then > sent).any():
                # A command that arrives within the step counts for the rest of it.
                share = np.where(
                    then > sent, np.clip((edges[i] - arrival[then, columns]) / step, 0.0, 1.0), 1.0
                )
                target = command[sent, columns] + share * (late - command[sent, columns])
                sent = then
            middle, after = target, late
            if slow.any():
                middle = np.where(slow, target + (filtered - target) * np.sqrt(keep), target)
                after = np.where(slow, target + (filtered - target) * keep, late)
            q, qd, rate = _stepped(plant, middle, speed_command[row], q, qd, rate, step)
            filtered = after
    return out[0], out[1], out[2]


def _stepped(
    plant: _Plant, command: Array, speed_command: Array, q: Array, qd: Array, rate: Array, step: float
) -> tuple[Array, Array, Array]:
    """One step of the midpoint rule; the links are taken at the middle, which the acceleration before leads to.

    A joint that comes to a stand within the step ends a part of the step there, and friction is asked anew.
    """
    import numpy as np

    left, columns = step, np.arange(len(q))
    for _ in range(TURNS):
        stands = (qd == 0.0) & (plant.static > 0.0)
        way = np.sign(qd)
        half_q = q + 0.5 * left * qd
        mass, load = plant.links(half_q, qd + 0.5 * left * rate)
        mass[columns, columns] += plant.armature
        net = plant.drive(command, speed_command, q, qd) - plant.viscous * qd - load
        first, held = plant.acceleration(mass, net, qd, way, stands)
        way = np.where(stands & ~held, np.sign(first), way)
        half_qd = np.where(held, 0.0, qd + 0.5 * left * first)
        net = plant.drive(command, speed_command, half_q, half_qd) - plant.viscous * half_qd - load
        second, _ = plant.acceleration(mass, net, half_qd, way, held)
        rate = np.where(held, 0.0, second)
        new_qd = qd + left * rate
        turned = (way * new_qd < 0.0) & ~held & (plant.static > 0.0)
        # What another joint pulls back within the step it broke away in has not broken away.
        stays = turned & stands
        half_qd, new_qd = np.where(stays, 0.0, half_qd), np.where(stays, 0.0, new_qd)
        held, turned, rate = held | stays, turned & ~stands, np.where(stays, 0.0, rate)
        if not turned.any():
            return q + left * half_qd, new_qd, rate
        share = np.where(turned, qd / np.where(qd == new_qd, 1.0, qd - new_qd), 1.0)
        until = float(share.min()) * left
        # To the first of them; its speed is 0 there to the square of the step.
        q = q + until * np.where(held, 0.0, qd + 0.5 * until * first)
        qd = np.where(held | (turned & (share == share.min())), 0.0, qd + until * second)
        left -= until
    return q, np.where(turned, 0.0, qd), rate


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
