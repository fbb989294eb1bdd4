"""What the answer of a joint to a step or a chirp shows, with crossings between samples."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from actspec.laws.arrays import Floats as Array

RISE = (0.1, 0.9)
"""Shares of the command between which it rises."""
BAND = 0.02
"""Of settling, as a share of the command."""
REST = 0.1
"""Last part of a course whose mean is what is left."""
FULL = 0.9
"""Share of the effort limit from which on a drive counts as saturated."""
DOWN = math.sqrt(0.5)
"""Of an amplitude that is 3 dB down."""
TONES = 400
"""Frequencies at which a chirp's answer is looked at, in equal ratios."""
COARSE = 10
"""Of these, each which is looked at first: 12 % apart. Chosen: no joint's answer falls and comes back within that."""


@dataclass(frozen=True, slots=True)
class Metrics:
    """What an answer shows; None: the course does not show it, or it never comes.

    Attributes:
        rise_time: From 10 to 90 % of the command [s].
        overshoot: Beyond the command, as a share of it.
        settling_time: From the command's change until it stays within 2 % of the command [s].
        steady_state_error: Command less answer, mean of the last tenth [rad, m, rad/s or m/s].
        peak_torque: Of the drive [N*m or N].
        peak_speed: [rad/s or m/s].
        saturated: Share of the time with at least 0.9 of the effort limit; None: there is no limit.
        bandwidth: Where the answer is 3 dB below the command [Hz].
    """

    rise_time: float | None
    overshoot: float | None
    settling_time: float | None
    steady_state_error: float | None
    peak_torque: float
    peak_speed: float
    saturated: float | None
    bandwidth: float | None


@dataclass(frozen=True, slots=True)
class Course:
    """One course of one joint, from the command's change on.

    Attributes:
        period: Between samples [s].
        command: From where it began, one a sample, held; shape (n,).
        answer: From where it began, at each sample and at the end of the last; shape (n + 1,).
        speed: Likewise [rad/s or m/s].
        torque: Of the drive at each sample [N*m or N], shape (n,).
        limit: Effort limit [N*m or N]; infinity: none.
    """

    period: float
    command: Array
    answer: Array
    speed: Array
    torque: Array
    limit: float


def step_metrics(course: Course) -> Metrics:
    """Of a step, whose command is the same from the first sample on."""
    size = float(course.command[-1])
    share = course.answer / size
    low, high = (_crossing(share, level) for level in RISE)
    last = max(round(REST * len(share)), 1)
    return Metrics(
        None if low is None or high is None else (high - low) * course.period,
        max(float(_peak(share)) - 1.0, 0.0),
        _settled(share, course.period),
        size - float(course.answer[-last:].mean()),
        *_loads(course),
        None,
    )


def chirp_metrics(course: Course, swept: tuple[float, float]) -> Metrics:
    """Of a chirp between two frequencies [rad/s]."""
    return Metrics(None, None, None, None, *_loads(course), _bandwidth(course, swept))


def _loads(course: Course) -> tuple[float, float, float | None]:
    import numpy as np

    size = np.abs(course.torque)
    full = None if math.isinf(course.limit) else float(np.mean(size >= FULL * course.limit))
    return float(size.max()), float(np.abs(course.speed).max()), full


def _crossing(share: Array, level: float) -> float | None:
    """Samples until a level is reached first; None: never."""
    import numpy as np

    (above,) = np.nonzero(share >= level)
    if not len(above):
        return None
    k = int(above[0])
    if k == 0:
        return 0.0
    return k - 1 + float((level - share[k - 1]) / (share[k] - share[k - 1]))


def _peak(share: Array) -> float:
    """The greatest value, of a parabola through the three samples around it."""
    k = int(share.argmax())
    if not 0 < k < len(share) - 1:
        return float(share[k])
    before, at, after = (float(x) for x in share[k - 1 : k + 2])
    bend = before - 2.0 * at + after
    return at if bend == 0.0 else at - (after - before) ** 2 / (8.0 * bend)


def _settled(share: Array, period: float) -> float | None:
    import numpy as np

    off = np.abs(share - 1.0)
    (outside,) = np.nonzero(off > BAND)
    if not len(outside):
        return 0.0
    k = int(outside[-1])
    if k == len(share) - 1:
        return None
    return (k + float((off[k] - BAND) / (off[k] - off[k + 1]))) * period


def _bandwidth(course: Course, swept: tuple[float, float]) -> float | None:
    """Where the answer's spectrum falls below the command's by 3 dB [Hz].

    Both begin and end at rest, so that the ratio of their transforms is the loop's answer at any frequency.
    """
    import numpy as np

    n, h = len(course.command), course.period
    omega = np.geomspace(*swept, TONES)
    # What has not come back is taken for an even fall over the return: friction holds the joint a little off.
    answer = course.answer - course.answer[-1] * np.linspace(0.0, 1.0, n + 1)

    def gain(tones: Array) -> Array:
        wave = np.exp(-1j * tones[:, None] * h * np.arange(n + 1))
        # A held sample is a bar, whose transform is that of its middle times a sinc.
        middle = np.exp(-0.5j * tones * h) * np.sinc(tones * h / (2.0 * math.pi))
        found: Array = np.abs(wave @ answer) / np.maximum(
            np.abs(wave[:, :-1] @ course.command * middle), 1e-300
        )
        return found

    def falls(found: Array) -> int | None:
        (below,) = np.nonzero((found[1:] < DOWN) & (found[:-1] >= DOWN))
        return int(below[0]) if len(below) else None

    # Far apart first, then all of those around the first fall.
    rough = np.unique(np.append(np.arange(0, TONES, COARSE), TONES - 1))
    k = falls(gain(omega[rough]))
    if k is None:
        return None
    tones = omega[rough[k] : rough[k + 1] + 1]
    fine = gain(tones)
    k = falls(fine)
    assert k is not None
    at = (fine[k] - DOWN) / (fine[k] - fine[k + 1])
    return float(np.exp((1 - at) * math.log(tones[k]) + at * math.log(tones[k + 1])) / (2.0 * math.pi))
