"""Networks in studies: the PD that one is near to, its answer alone on an inertia, and its torque along a log."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from actspec.ir import Command
from actspec.laws import TorqueLaw, delay_steps
from actspec.laws.network import NetworkDrive, NetworkLaw
from actspec.simulate.reference import (
    DrivenJoint,
    PassiveFriction,
    Trajectory,
    effective_commands,
    integrate,
    reaching_commands,
)
from actspec.sysid.recording import GAP

if TYPE_CHECKING:
    from actspec.laws.arrays import Floats as Array
    from actspec.learn.bundle import Bundle

FARTHEST = 1.0
"""Largest error that is looked at where the training data's is not known [rad or m]."""
ERRORS = 400
"""How many are."""
SLOW = 0.05
"""Speed at which a network's damping is read, as a share of the fastest of its training, else of 1 [rad/s or m/s]."""
SETTLED = 200
"""Samples after which an LSTM under constant inputs has settled."""
WARM, PIECE = 20, 200
"""Samples that settle an LSTM's state on a log, as in its training, and those that follow."""
_FREE = TorqueLaw(Command.EFFORT, 0.0, 0.0, math.inf, None, None, None, 0.0, None, 0.0)


def near(drive: NetworkDrive) -> TorqueLaw | str:
    """The PD that a network at rest is like: the stiffness with which it reaches half of its limit, its damping there.

    A text says why there is none.
    """
    import numpy as np

    law, limit = drive.network, drive.clip.effort_limit
    farthest, fastest = drive.most or (FARTHEST, 1.0)
    errors = np.linspace(0.0, farthest or FARTHEST, ERRORS + 1)
    torque = _at_rest(law, errors, 0.0 * errors)
    torque = torque - torque[0]
    half = 0.5 * min(limit, float(torque.max()))
    if not half > 0.0:
        return "its network at rest does not pull towards the command"
    k = int(np.argmax(torque >= half))
    share = (half - torque[k - 1]) / (torque[k] - torque[k - 1])
    error = errors[k - 1] + share * (errors[k] - errors[k - 1])
    speeds = SLOW * (fastest or 1.0) * np.array([-1.0, 1.0])
    slope = np.diff(_at_rest(law, 0.0 * speeds, speeds)) / np.diff(speeds)
    return replace(
        drive.clip, command=Command.POSITION, kp=half / float(error), kd=max(-float(slope[0]), 0.0)
    )


def _at_rest(law: NetworkLaw, error: Array, velocity: Array) -> Array:
    """Torque under inputs that have long been the same [N*m or N], shape (n,)."""
    taps = len(law.taps)
    e, w = (part[:, None].repeat(taps, axis=1) for part in (error, velocity))
    torque, state = law.torque(e, w)
    for _ in range(SETTLED if law.layers.recurrent else 0):
        torque, state = law.torque(e, w, state)
    found: Array = torque
    return found


@dataclass(frozen=True, slots=True)
class LearnedJoint:
    """A body of one joint that a network drives.

    Attributes:
        drive: The network in its drive.
        friction: Of the joint.
        inertia: J, armature included > 0 [kg*m^2 or kg].
    """

    drive: NetworkDrive
    friction: PassiveFriction
    inertia: float


def respond(
    joints: Sequence[LearnedJoint], command: Array, start: Array, step: float, parts: int
) -> Trajectory:
    """Let joints follow their commands, from rest.

    A network is sampled once a physics step, and its torque is held until the next, as in all simulators; the body
    moves in steps so small that smaller ones change nothing.

    Args:
        joints: The columns of every array.
        command: One a physics step, shape (n_step, n_joint).
        start: Where they start [rad or m], shape (n_joint,).
        step: Physics step [s].
        parts: Samples of the answer in a step.
    """
    import numpy as np

    n = len(command)
    clips = [joint.drive.clip for joint in joints]
    reaching = reaching_commands(clips, command, step)
    bias = np.array([clip.encoder_bias for clip in clips])
    networks = {id(joint.drive.network): joint.drive.network for joint in joints}
    groups = [
        (np.array([i for i, joint in enumerate(joints) if id(joint.drive.network) == key]), _memory(law))
        for key, law in networks.items()
    ]
    free = [DrivenJoint(_FREE, joint.friction, joint.inertia) for joint in joints]
    out = Trajectory(*(np.empty((n * parts + more, len(joints))) for more in (1, 1, 0)))
    q, qd = np.array(start, dtype=float), np.zeros(len(joints))
    out.q[0], out.qd[0] = q, qd
    for k in range(n):
        torque = np.empty(len(joints))
        for columns, remembered in groups:
            torque[columns] = remembered((reaching[k] - q - bias)[columns], qd[columns])
        torque = np.array(
            [float(clip.torque(torque[i], q[i], qd[i])) for i, clip in enumerate(clips)], dtype=float
        )
        moved = integrate(free, np.tile(torque, (parts, 1)), q, qd, step / parts, substeps=1)
        rows = slice(k * parts + 1, (k + 1) * parts + 1)
        out.q[rows], out.qd[rows], out.torque[k * parts : (k + 1) * parts] = moved.q[1:], moved.qd[1:], torque
        q, qd = moved.q[-1], moved.qd[-1]
    return out


def _memory(law: NetworkLaw) -> Callable[[Array, Array], Array]:
    """The network as a function of each step's error and velocity, shapes (n,), which remembers those before."""
    import numpy as np

    past: list[tuple[Array, Array]] = []
    state: list[Any] = [None]

    def torque(error: Array, velocity: Array) -> Array:
        now = error, velocity
        if not past:
            blank = now if law.backfill else (0.0 * error, 0.0 * velocity)
            past.extend([blank] * max(law.taps))
        past.append(now)
        seen = [past[-1 - tap] for tap in law.taps]
        del past[: len(past) - max(law.taps)]
        e, w = (np.stack([sample[k] for sample in seen], axis=-1) for k in (0, 1))
        found, state[0] = law.torque(e, w, state[0])
        result: Array = found
        return result

    return torque


def bundle_of(drive: NetworkDrive, joint: str, actuator: str, step: float) -> Bundle:
    """What the runtime needs to drive one joint of a MuJoCo model.

    Args:
        drive: The network in its drive.
        joint: Name in the model.
        actuator: Likewise.
        step: Physics step [s].
    """
    from actspec.learn.bundle import Bundle, DrivenGroup
    from actspec.learn.bundle import DrivenJoint as Driven

    clip = drive.clip
    line = (
        None
        if clip.stall_torque is None or clip.no_load_speed is None
        else (clip.stall_torque, clip.no_load_speed)
    )
    one = Driven(joint, actuator, clip.effort_limit, line, clip.curve, clip.encoder_bias)
    return Bundle("", step, (DrivenGroup(actuator, drive.network, (one,), None),))


@dataclass(frozen=True, slots=True)
class Sampled:
    """A network in its drive, on a log.

    Attributes:
        drive: Its taps are physics steps.
        step: One of them [s].
    """

    drive: NetworkDrive
    step: float


def along(network: Sampled, time: Array, command: Array, position: Array, velocity: Array) -> Array:
    """Torque of a network at the rows of a log [N*m or N], shape (n,); NaN without a whole history before the row.

    Between rows positions and speeds are interpolated, and commands held; delay and filter go in steps of the log.

    Args:
        network: That drives the joint.
        time: Of the rows [s], shape (n,).
        command: As sent, without holes, likewise.
        position: As read [rad or m]; NaN where it was not.
        velocity: [rad/s or m/s], likewise.
    """
    import numpy as np

    period = float(np.median(np.diff(time)))
    clip, law = network.drive.clip, network.drive.network
    reaching = effective_commands(clip, command, period, delay_steps(clip.delay, period).steps)
    good = np.isfinite(position) & np.isfinite(velocity)
    if good.sum() < 2:
        return np.full(len(time), np.nan)
    known = time[good]

    def at(when: Array) -> tuple[Array, Array]:
        """Error and velocity at times; NaN in gaps and before the first row."""
        later = np.clip(np.searchsorted(known, when - 1e-9), 1, len(known) - 1)
        between = (known[later] - known[later - 1] <= GAP * period) & (when > known[0])
        whole = between | (np.abs(known[later] - when) < 1e-9) | (np.abs(known[later - 1] - when) < 1e-9)
        sent = reaching[np.clip(np.searchsorted(time, when + 1e-9, side="right") - 1, 0, None)]
        error = sent - np.interp(when, known, position[good])
        return (
            np.where(whole, error, np.nan),
            np.where(whole, np.interp(when, known, velocity[good]), np.nan),
        )

    if law.layers.recurrent:
        # The state goes on in samples; between them the torque is interpolated.
        grid = np.arange(time[0], time[-1] + 0.5 * law.tap_period, law.tap_period)
        torque = np.interp(time, grid, _recurrent(law, *at(grid)))
    else:
        seen = [at(time - tap * network.step) for tap in law.taps]
        e, w = (np.stack([sample[k] for sample in seen], axis=-1) for k in (0, 1))
        torque, _ = law.torque(e, w)
    found: Array = np.asarray(clip.torque(torque, position - clip.encoder_bias, velocity))
    return found


def _recurrent(law: NetworkLaw, error: Array, velocity: Array) -> Array:
    """Torque of an LSTM along samples, the state settled over those before each piece, shape (n,)."""
    import numpy as np

    starts = np.arange(WARM, len(error), PIECE)
    rows = starts[None, :] + np.arange(-WARM, PIECE)[:, None]
    inside = rows < len(error)
    e, w = (part[np.where(inside, rows, -1)] for part in (error, velocity))
    found, state = np.full(len(error), np.nan), None
    for k in range(len(rows)):
        torque, state = law.torque(e[k][:, None], w[k][:, None], state)
        if k >= WARM:
            found[rows[k][inside[k]]] = torque[inside[k]]
    return found
