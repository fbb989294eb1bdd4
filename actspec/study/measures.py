"""What logs say of each joint: how near the motor's bounds it works, how fast, and which law gives its torque."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span
from actspec.ir import JointActuator, Level
from actspec.laws import TorqueLaw, delay_steps, law_of, passive_torque
from actspec.logs import JointLog, Log
from actspec.simulate.reference import PassiveFriction, held_torque
from actspec.study.learned import Sampled, along
from actspec.study.metrics import FULL
from actspec.study.spectra import spectrum
from actspec.study.variants import lined, variants_of
from actspec.sysid.figures import Bounds
from actspec.sysid.recording import driven, scatter
from actspec.targets.kit.network import network_clip

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

EDGE, BEYOND = 0.02, 0.05
"""Shares of the effort limit: so near to a bound is at it; so far past it is beyond what the motor can."""
VARIES, LOUD = 0.02, 2.0
"""Least standard deviation of a torque that a law is asked to tell: as a share of the effort limit, and over the noise
of its readings. Chosen: less is friction's, or noise."""
FALLBACK = 30.0
"""Frequency above which a torque is fast where neither motor nor filter has one [Hz]. Chosen: what legs follow."""
MOST_POWER = 0.95
"""Of the command's variance, below the end of its band."""
LEAST = 20
"""Fewest rows that say anything. As the fewest of a log."""
HUGE = 1e12
"""What no joint does and no drive gives [rad, m, rad/s, m/s, N*m or N]."""
LAG = 0.5
"""Longest shift that is looked for between two logs [s]. Chosen: a policy's step is 20 ms."""


@dataclass(frozen=True, slots=True)
class Gap:
    """How a joint moves in one log and in another, from their first rows on.

    Attributes:
        position_rmse: [rad or m].
        velocity_rmse: [rad/s or m/s]; None: not in both.
        torque_rmse: [N*m or N]; None: not in both.
        lag: How much later the second moves [s]; None: one of them stands.
    """

    position_rmse: float | None
    velocity_rmse: float | None
    torque_rmse: float | None
    lag: float | None


@dataclass(frozen=True, slots=True)
class JointMeasures:
    """Of one joint, over all logs that have it; None: the logs or the spec do not tell.

    Attributes:
        joint: Its name.
        rows: With a torque and a speed.
        torque_from: `log`, or `law`: the spec's at the logged command and state.
        saturated: Share of rows with at least 0.9 of the effort limit.
        at_edge: Share within 0.02 L of a bound of the four quadrants, or past it.
        beyond: Share more than 0.05 L past the motor's line; None without a line.
        rms_torque: [N*m or N].
        peak_torque: [N*m or N].
        peak_speed: [rad/s or m/s].
        continuous_ratio: RMS torque over the motor's continuous torque.
        high_frequency: Share of the torque's variance above `fast`.
        fast: The motor's bandwidth, else the filter's cutoff, else 30 Hz.
        command_band: Frequency below which 95 % of the command's variance is [Hz].
        tracking_rmse: Command less position [rad or m].
        torque_error: Law to the RMSE of its torque against the logged one [N*m or N].
        torque_untold: Standard deviation of what the spec's law misses of a logged torque over that of the torque,
            noise taken off both; None: there is no such law, or the torque hardly varies.
        position_error: Likewise to the RMSE of its position in rollouts, where no torque was logged [rad or m].
        torque_late: Rows by which the command of a logged torque is behind its own: 1 by the form of logs.
        gap: To another log.
        velocity_from: `log`, or `position`: its derivative.
    """

    joint: str
    rows: int
    torque_from: str
    saturated: float | None
    at_edge: float | None
    beyond: float | None
    rms_torque: float
    peak_torque: float
    peak_speed: float
    continuous_ratio: float | None
    high_frequency: float | None
    fast: float
    command_band: float | None
    tracking_rmse: float | None
    torque_error: Mapping[str, float]
    torque_untold: float | None
    position_error: Mapping[str, float]
    torque_late: int
    gap: Gap | None
    velocity_from: str


@dataclass(frozen=True, slots=True)
class Track:
    """One joint in one log; NaN where there is no reading.

    Attributes:
        time: [s], shape (n,).
        command: [rad or m]; None: not logged.
        position: [rad or m].
        velocity: [rad/s or m/s].
        torque: [N*m or N]; None: not logged.
        behind: Whether the torque was measured behind the joint's friction.
        differentiated: Whether the velocity is the position's derivative.
        path: Of the log.
    """

    time: Array
    command: Array | None
    position: Array
    velocity: Array
    torque: Array | None
    behind: bool
    differentiated: bool
    path: str


def track_of(log: Log, joint: JointLog, actuator: JointActuator, out: Collector) -> Track | str:
    """A joint's part of a log; a text says why it cannot be judged."""
    import numpy as np

    unlike = joint.unlike(actuator.kind)
    if unlike is not None:
        return unlike
    joint = driven(log, joint, actuator, out)
    if joint.position is None:
        return "no position was logged"
    velocity, differentiated = joint.velocity, joint.velocity is None
    if velocity is None:
        velocity = np.gradient(joint.position, log.time)
    off = np.zeros(len(log.time), dtype=bool) if joint.enabled is None else joint.enabled == 0.0
    read = (joint.command, joint.position, velocity, joint.torque)
    wild = [signal is not None and np.abs(signal) > HUGE for signal in read]
    count = int(np.any([rows for rows in wild if rows is not False], axis=0).sum())
    if count:
        message = f"{count} rows have a reading beyond {HUGE:g}: it is left out"
        out.info("DGN015", message, where=joint.name, span=Span(log.path))
    signals = [
        None if signal is None else np.where(off | rows, np.nan, signal)
        for signal, rows in zip(read, wild, strict=True)
    ]
    command, position, speed, torque = signals
    assert position is not None and speed is not None
    if int((np.isfinite(position) & np.isfinite(speed)).sum()) < LEAST:
        return f"fewer than {LEAST} rows have a position and a speed"
    if torque is not None and not np.isfinite(torque).any():
        torque = None
    if command is not None and not np.isfinite(command).any():
        command = None
    behind = log.sidecar.torque == "joint"
    return Track(log.time, command, position, speed, torque, behind, differentiated, log.path)


def laws_by_level(actuator: JointActuator, learned: Sampled | None) -> dict[str, TorqueLaw | Sampled]:
    """The law of each variant of a joint that has one; that of a network is called by its level.

    Args:
        actuator: The joint's.
        learned: Its network; None: it has none, or it is not known.
    """
    found: dict[str, TorqueLaw | Sampled] = {}
    for name, variant in variants_of(actuator)[0].items():
        called = Level.ACTUATOR_NET.value if name == "network" else name
        if variant.level is not Level.ACTUATOR_NET:
            found[called] = law_of(variant)
        elif learned is not None:
            drive = replace(learned.drive, clip=law_of(network_clip(variant)))
            found[called] = replace(learned, drive=drive)
    return found


def measured(
    actuator: JointActuator, tracks: Sequence[Track], gap: Gap | None, learned: Sampled | None = None
) -> JointMeasures | str:
    """What the tracks of one joint say; a text says why they say nothing.

    Args:
        actuator: The joint's.
        tracks: Its part of the logs.
        gap: To another log.
        learned: Its network; None: it has none, or it is not known.
    """
    import numpy as np

    variants = laws_by_level(actuator, learned)
    logged = any(track.torque is not None for track in tracks)
    used = [t for t in tracks if t.torque is not None] if logged else list(tracks)
    whole = variants.get("spec")
    torques: list[Array] = []
    if logged:
        torques = [t.torque for t in used if t.torque is not None]
    elif whole is None:
        return "no torque was logged, and the spec's law is not known"
    else:
        used = [t for t in used if t.command is not None]
        if not used:
            return "neither torque nor command was logged"
        torques = [law_torque(whole, actuator, t) for t in used]
    good = [np.isfinite(torque) & np.isfinite(t.velocity) for torque, t in zip(torques, used, strict=True)]
    torque = np.concatenate([part[rows] for part, rows in zip(torques, good, strict=True)])
    speed = np.concatenate([t.velocity[rows] for t, rows in zip(used, good, strict=True)])
    if len(torque) < LEAST:
        return f"fewer than {LEAST} rows have a torque and a speed"
    limit = actuator.effort_limit.value
    size = np.abs(torque)
    at_edge = beyond = None
    if limit is not None and limit > 0.0:
        low, high = bounds_at(actuator, speed)
        past = np.maximum(torque - high, low - torque)
        at_edge = float(np.mean(past >= -EDGE * limit))
        beyond = float(np.mean(past > BEYOND * limit)) if has_line(actuator) else None
    errors, late = _torque_errors(variants, actuator, used) if logged else ({}, 1)
    rms = float(np.sqrt(np.mean(torque**2)))
    continuous = actuator.continuous_torque.value
    fast = fast_from(actuator)
    of_torque = spectrum([(t.time, part) for t, part in zip(used, torques, strict=True)])
    commands = [(t.time, t.command) for t in tracks if t.command is not None]
    of_command = spectrum(commands)
    return JointMeasures(
        actuator.joint,
        len(torque),
        "log" if logged else "law",
        None if not limit else float(np.mean(size >= FULL * limit)),
        at_edge,
        beyond,
        rms,
        float(size.max()),
        float(np.abs(speed).max()),
        None if not continuous else rms / continuous,
        None if of_torque is None else of_torque.above(fast),
        fast,
        None if of_command is None else of_command.below_which(MOST_POWER),
        _tracking(tracks),
        errors,
        _untold(whole, actuator, used, late) if logged and whole is not None else None,
        {},
        late,
        gap,
        "position" if any(t.differentiated for t in used) else "log",
    )


def fast_from(actuator: JointActuator) -> float:
    """Frequency above which the drive does not follow [Hz]."""
    bandwidth = None if actuator.motor_line is None else actuator.motor_line.bandwidth
    for figure in (bandwidth, actuator.filter_cutoff):
        if figure is not None and figure.value:
            return figure.value
    return FALLBACK


def knows_bandwidth(actuator: JointActuator) -> bool:
    """Whether the spec states what the drive follows."""
    bandwidth = None if actuator.motor_line is None else actuator.motor_line.bandwidth
    return any(figure is not None and bool(figure.value) for figure in (bandwidth, actuator.filter_cutoff))


def has_line(actuator: JointActuator) -> bool:
    """Whether the motor's torque-speed line is known, whatever the level."""
    return lined(actuator) is not None


def bounds_at(actuator: JointActuator, speed: Array) -> tuple[Array, Array]:
    """Least and greatest torque that the motor can give at speeds [N*m or N], of the line whatever the level."""
    import numpy as np

    clip = Bounds.of(lined(actuator) or actuator).clip
    return clip(np.full_like(speed, -HUGE), speed), clip(np.full_like(speed, HUGE), speed)


def law_torque(law: TorqueLaw | Sampled, actuator: JointActuator, track: Track, late: int = 0) -> Array:
    """A law's torque at the rows of a track, delay and filter included; behind friction where the log's is.

    Args:
        law: Of the drive.
        actuator: For the friction.
        track: With a command.
        late: 0: as soon as the row's command is sent; 1: as it is read in that row, under the command before.
    """
    import numpy as np

    assert track.command is not None
    command = held(track.command)
    command = np.concatenate([command[:late], command])[: len(command)]
    if isinstance(law, Sampled):
        torque = along(law, track.time, command, track.position, track.velocity)
    else:
        step = float(np.median(np.diff(track.time)))
        q = track.position - law.encoder_bias
        torque = held_torque(law, command, q, track.velocity, step, delay_steps(law.delay, step).steps)
    if track.behind:
        friction = PassiveFriction.of(actuator)
        torque = torque + passive_torque(
            track.velocity,
            coulomb=friction.coulomb,
            viscous=friction.viscous,
            static=friction.static,
            stribeck_velocity=friction.stribeck_velocity,
        )
    return torque


def held(command: Array) -> Array:
    """A command without holes: the last one is held."""
    import numpy as np

    good = np.isfinite(command)
    at = np.maximum.accumulate(np.where(good, np.arange(len(command)), 0))
    found: Array = np.where(good[at], command[at], command[np.flatnonzero(good)[0]])
    return found


def _torque_errors(
    laws: Mapping[str, TorqueLaw | Sampled], actuator: JointActuator, tracks: Sequence[Track]
) -> tuple[dict[str, float], int]:
    """RMSE of each law's torque against the logged one [N*m or N], and under which row's command it was read.

    By the form of logs a torque is read before the row's command is sent. A simulation's log may hold it the other way;
    that is taken where it leaves less than half of the error.
    """
    import numpy as np

    found: list[dict[str, float]] = []
    for late in (1, 0):
        errors = {}
        for name, law in laws.items():
            squares = []
            for track in tracks:
                if track.command is not None and track.torque is not None:
                    left = law_torque(law, actuator, track, late) - track.torque
                    squares.append(left[np.isfinite(left)] ** 2)
            joined = np.concatenate(squares) if squares else np.empty(0)
            if len(joined):
                errors[name] = math.sqrt(float(joined.mean()))
        found.append(errors)
    before, own = found
    other_way = bool(before) and min(own.values()) < 0.5 * min(before.values())
    return (own, 0) if other_way else (before, 1)


def _untold(
    law: TorqueLaw | Sampled, actuator: JointActuator, tracks: Sequence[Track], late: int
) -> float | None:
    """See `JointMeasures.torque_untold`."""
    import numpy as np

    logged, missed, noise = [], [], []
    for track in tracks:
        if track.command is not None and track.torque is not None:
            left = law_torque(law, actuator, track, late) - track.torque
            rows = np.isfinite(left)
            logged.append(track.torque[rows])
            missed.append(left[rows])
            noise.append(scatter(track.torque))
    if sum(map(len, logged)) < LEAST:
        return None
    spread, off = (float(np.std(np.concatenate(parts))) for parts in (logged, missed))
    limit = actuator.effort_limit.value
    if not limit or spread < max(VARIES * limit, LOUD * max(noise)):
        return None
    grain = max(noise) ** 2
    return math.sqrt(max(off**2 - grain, 0.0) / (spread**2 - grain))


def _tracking(tracks: Sequence[Track]) -> float | None:
    import numpy as np

    parts = [t.command - t.position for t in tracks if t.command is not None]
    if not parts:
        return None
    left = np.concatenate(parts)
    left = left[np.isfinite(left)]
    return math.sqrt(float(np.mean(left**2))) if len(left) else None


def gap_between(one: Track, other: Track) -> Gap:
    """How two tracks of a joint differ over the time that both have, from their first rows on."""
    import numpy as np

    time = one.time - one.time[0]
    theirs = other.time - other.time[0]
    rows = time <= theirs[-1]

    def rmse(mine: Array | None, its: Array | None) -> float | None:
        if mine is None or its is None:
            return None
        good = np.isfinite(its)
        if good.sum() < LEAST:
            return None
        left = mine[rows] - np.interp(time[rows], theirs[good], its[good])
        left = left[np.isfinite(left)]
        return math.sqrt(float(np.mean(left**2))) if len(left) else None

    return Gap(
        rmse(one.position, other.position),
        rmse(one.velocity, other.velocity),
        rmse(one.torque, other.torque),
        _lag(time[rows], one.position[rows], theirs, other.position),
    )


def _lag(time: Array, one: Array, theirs: Array, other: Array) -> float | None:
    """Shift at which two courses are most alike [s], between samples by a parabola."""
    import numpy as np

    good, sound = np.isfinite(one), np.isfinite(other)
    if good.sum() < LEAST or sound.sum() < LEAST:
        return None
    step = float(np.median(np.diff(time)))
    even = np.arange(0.0, time[-1] + 0.5 * step, step)
    a = np.interp(even, time[good], one[good])
    b = np.interp(even, theirs[sound], other[sound])
    most = min(round(LAG / step), len(even) // 3)
    if most < 1 or not (np.ptp(a) > 0.0 and np.ptp(b) > 0.0):
        return None

    def apart(shift: int) -> float:
        mine, its = (a[: len(a) - shift], b[shift:]) if shift >= 0 else (a[-shift:], b[: len(b) + shift])
        return float(np.mean((mine - its) ** 2))

    shifts = list(range(-most, most + 1))
    found = [apart(shift) for shift in shifts]
    k = int(np.argmin(found))
    between = 0.0
    if 0 < k < len(found) - 1:
        before, at, after = found[k - 1 : k + 2]
        bend = before - 2.0 * at + after
        between = 0.5 * (before - after) / bend if bend > 0.0 else 0.0
    return (shifts[k] + between) * step
