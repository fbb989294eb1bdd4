"""Commands for an experiment, held to what the joint can do by simulating the spec."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.diagnostics import listed
from actspec.ir import Command, JointActuator
from actspec.joints import JointKind
from actspec.logs import JointLog, Log, LogError, Sidecar
from actspec.logs.text import MAX_CELLS
from actspec.robot.view import RobotView
from actspec.simulate.excitation import chirp
from actspec.sysid.sizing import Wanted, sized_alone, sized_together

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

EXPERIMENTS = ("chirp", "multisine", "steps", "friction", "random")
SHARE = 0.3
"""Most of a joint's range that a command goes to either side of its middle."""
UNLIMITED = {JointKind.HINGE: 0.5, JointKind.SLIDE: 0.05}
"""Half-amplitude of a joint without a range [rad or m]. Chosen."""
BAND = (0.1, 1.5)
"""First frequency [Hz], and the last as a share of the closed loop's natural frequency."""
FASTEST = 25.0
"""Last frequency at most [Hz]. Chosen: beyond, links bend."""
SINES = 30
"""Of a multisine."""
ROUNDS, CUT = 200, 0.85
"""Steps towards a low crest factor, and the share of the peak that is left in each."""
APART = 0.3
"""Largest correlation of two commands that are sent together."""
MOST_ROWS = 100_000
"""Of one joint's part, or of all together, each of which is simulated. Chosen: 200 s at 500 Hz, 10 s of a processor."""
HOLD = 0.6
"""Time that a step is held [s]."""
SPEEDS = 6
"""Constant speeds of a friction experiment, each both ways."""


@dataclass(frozen=True, slots=True)
class Experiment:
    """A designed experiment.

    Attributes:
        log: Commands, and what the spec's joints would do: position, velocity, torque of the drive.
        amplitudes: Joint to half the amplitude of its command [rad or m].
        limited_by: Joint to what keeps the amplitude small: `range`, `speed` or `torque`.
    """

    log: Log
    amplitudes: Mapping[str, float]
    limited_by: Mapping[str, str]


def design(
    robot: RobotView,
    actuators: Sequence[JointActuator],
    kind: str,
    *,
    path: str,
    duration: float,
    rate: float,
    together: bool,
    linear: bool = False,
    seed: int = 0,
    sidecar: Sidecar | None = None,
) -> Experiment:
    """Commands for joints, one after the other or together.

    Args:
        robot: Its model.
        actuators: Of the joints to move.
        kind: One of `EXPERIMENTS`.
        path: Name of the log.
        duration: For one joint, or for all together [s].
        rate: Of the commands [Hz].
        together: Whether all joints move at once.
        linear: Whether a chirp's frequency grows linearly.
        seed: Of phases and levels.
        sidecar: How the base is held.

    Raises:
        LogError: a joint cannot be moved so, with the reason.
        RobotError: the model does not tell the links' inertia.
    """
    import numpy as np

    wrong = [a.joint for a in actuators if a.command is not Command.POSITION or not a.kp or not a.kp.value]
    if wrong:
        raise LogError.of("SYS022", f"no position drive with a known kp: {listed(wrong)}")
    asked = duration * rate * (1 if together else len(actuators))
    if asked * (1 + 4 * len(actuators)) > MAX_CELLS:
        message = f"{duration:g} s at {rate:g} Hz are more than the {MAX_CELLS} numbers that a log may have"
        raise LogError.of(
            "SYS040", message, where="--duration", help="move fewer joints, or for a shorter time"
        )
    slot = round(duration * rate)
    if slot < 50:
        message = f"{duration:g} s at {rate:g} Hz are {slot} rows, at least 50 are needed"
        raise LogError.of("SYS040", message, where="--duration")
    if slot > MOST_ROWS:
        message = f"{duration:g} s at {rate:g} Hz are {slot} rows to simulate, more than {MOST_ROWS}"
        raise LogError.of("SYS040", message, where="--rate", help="a lower rate, or a shorter time")
    count = slot if together else slot * len(actuators)
    if linear and kind != "chirp":
        message = f"only a chirp's frequency grows linearly, and this is --experiment {kind}"
        raise LogError.of("SYS042", message, where="--linear", help="leave it out, or design a chirp")
    time = np.arange(count) / rate
    sidecar = sidecar or Sidecar()
    shapes = _shapes(actuators, kind, slot, rate, together=together, linear=linear, seed=seed)
    middles = {a.joint: _middle(a) for a in actuators}
    sizes = {a.joint: _size(a) for a in actuators}
    base = None if sidecar.base is None else sidecar.base.orientation
    wanted = Wanted(robot, actuators, time, shapes, middles, sizes, base)
    found = sized_together(wanted) if together else sized_alone(wanted)
    joints = {
        a.joint: JointLog(
            a.joint,
            a.kind is JointKind.SLIDE,
            command=found[a.joint].command,
            position=found[a.joint].q + (a.encoder_bias.value or 0.0),
            velocity=found[a.joint].qd,
            torque=found[a.joint].torque,
        )
        for a in actuators
    }
    return Experiment(
        Log(path, "", time, joints, sidecar),
        {joint: sized.amplitude for joint, sized in found.items()},
        {joint: sized.limited_by for joint, sized in found.items()},
    )


def _middle(actuator: JointActuator) -> float:
    """Where the command swings about: the default pose, as far as the range has room on both sides."""
    pose = actuator.default_position.value or 0.0
    if actuator.position_range is None:
        return pose
    low, high = actuator.position_range
    room = SHARE * (high - low)
    return min(max(pose, low + room), high - room)


def _size(actuator: JointActuator) -> float:
    """Largest half-amplitude that the range allows [rad or m]."""
    if actuator.position_range is None:
        return UNLIMITED[actuator.kind]
    low, high = actuator.position_range
    return min(SHARE * (high - low), 2.0 * UNLIMITED[actuator.kind])


def _shapes(
    actuators: Sequence[JointActuator],
    kind: str,
    count: int,
    rate: float,
    *,
    together: bool,
    linear: bool,
    seed: int,
) -> dict[str, Array]:
    """Courses between -1 and 1 that begin and end near 0, one a joint."""
    found: dict[str, Array] = {}
    for i, actuator in enumerate(actuators):
        last = _last_frequency(actuator, rate)
        stride, offset = (len(actuators), i) if together else (1, 0)
        for attempt in range(10):
            own = seed + 31 * i + attempt
            if kind == "chirp":
                shape = _chirp(count, rate, last * (1.0 - 0.04 * attempt), linear)
            elif kind == "multisine":
                shape = _multisine(count, rate, last, offset, stride, own)
            elif kind == "steps":
                shape = _steps(count, rate, own, mixed=together and i > 0)
            elif kind == "friction":
                shape = _ramps(count, offset + attempt)
            else:
                shape = _random(count, rate, last, own)
            if not together or all(abs(_correlation(shape, other)) < APART for other in found.values()):
                break
        found[actuator.joint] = shape
    return found


def _correlation(a: Array, b: Array) -> float:
    import numpy as np

    return float(np.corrcoef(a, b)[0, 1])


def _last_frequency(actuator: JointActuator, rate: float) -> float:
    """Of the commands [Hz]."""
    kp = actuator.kp.value if actuator.kp is not None else None
    held = actuator.inertia_held
    natural = FASTEST if not kp or held is None else math.sqrt(kp / held.reference) / (2.0 * math.pi)
    return max(min(BAND[1] * natural, FASTEST, rate / 10.0), 4.0 * BAND[0])


def _chirp(count: int, rate: float, last: float, linear: bool) -> Array:
    import numpy as np

    low, high = 2.0 * math.pi * BAND[0], 2.0 * math.pi * last
    if not linear:
        return chirp(count, 1.0 / rate, low, high)
    t = np.arange(count) / rate
    found: Array = np.sin(low * t + 0.5 * (high - low) * t**2 / t[-1])
    return found


def _multisine(count: int, rate: float, last: float, offset: int, stride: int, seed: int) -> Array:
    """Sines of whole periods; joints that move together have frequencies of their own. The crest is below 2."""
    import numpy as np

    base = rate / count
    wanted = np.geomspace(max(BAND[0], base), last, SINES)
    harmonics = np.unique(np.round(wanted / base / stride).astype(int) * stride + offset)
    harmonics = harmonics[harmonics > 0]
    spectrum = np.zeros(count // 2 + 1, dtype=complex)
    weight = 1.0 / np.sqrt(1.0 + (base * harmonics / (0.25 * last)) ** 2)
    phases = np.random.default_rng(seed).uniform(0.0, 2.0 * math.pi, len(harmonics))
    best, lowest = None, math.inf
    for _ in range(ROUNDS):
        spectrum[harmonics] = weight * np.exp(1j * phases)
        shape = np.fft.irfft(spectrum, count)
        crest = float(np.abs(shape).max() / np.sqrt(np.mean(shape**2)))
        if crest < lowest:
            best, lowest = shape, crest
        # What is cut off has the phases of a flatter signal. Source: van der Ouderaa, Schoukens, Renneboog 1988.
        cut = CUT * np.abs(shape).max()
        phases = np.angle(np.fft.rfft(np.clip(shape, -cut, cut))[harmonics])
    assert best is not None
    found: Array = best / np.abs(best).max()
    return found


def _steps(count: int, rate: float, seed: int, *, mixed: bool) -> Array:
    """Levels in turn on both sides, each held; the first and the last are 0. Mixed: the sides in an order by chance."""
    import numpy as np

    random = np.random.default_rng(seed)
    held = max(round(HOLD * rate), 4)
    levels = max(count // held, 3)
    sides = np.where(np.arange(levels) % 2 == 0, 1.0, -1.0)
    sizes = random.permutation(np.linspace(0.25, 1.0, levels)) * (
        random.permutation(sides) if mixed else sides
    )
    sizes[[0, -1]] = 0.0
    found: Array = sizes[np.minimum(np.arange(count) // held, levels - 1)]
    return found


def _ramps(count: int, which: int) -> Array:
    """There and back at constant speeds, each twice as long as the one before it."""
    import numpy as np

    shares = 2.0 ** np.arange(SPEEDS)
    shares = np.roll(shares / shares.sum(), which)
    corners, levels = [0.0], [0.0]
    for share in shares:
        start = corners[-1]
        for part, level in ((0.25, 1.0), (0.75, -1.0), (1.0, 0.0)):
            corners.append(start + part * share)
            levels.append(level)
    found: Array = np.interp(np.arange(count) / count, corners, levels)
    return found


def _random(count: int, rate: float, last: float, seed: int) -> Array:
    """Sines of random frequency and phase, faded in and out."""
    import numpy as np

    random = np.random.default_rng(seed)
    t = np.arange(count) / rate
    frequency = np.exp(random.uniform(math.log(BAND[0]), math.log(last), SINES))
    weight = 1.0 / np.sqrt(1.0 + (frequency / (0.25 * last)) ** 2)
    phase = random.uniform(0, 2 * math.pi, SINES)
    shape = (weight[:, None] * np.sin(2 * math.pi * frequency[:, None] * t + phase[:, None])).sum(0)
    fade = np.minimum(np.minimum(np.arange(count), np.arange(count)[::-1]) / (0.5 * rate), 1.0)
    shape = shape * fade
    found: Array = shape / np.abs(shape).max()
    return found
