"""Readings that are none: single wild ones, and those that stand still where the joint does not.

What a joint does passes: a median over a few rows leaves every steady motion as it is, and a joint in stiction may
stand for seconds on a coarse encoder. What is left out here bends no figure; what is kept may still be noise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Mask = NDArray[np.bool_]

WINDOW = 7
"""Rows of the median. Chosen: up to three wild readings in a row."""
WILD = 10.0
"""Standard deviations of the noise from which on a reading is wild. Chosen."""
USUAL = 4.0
"""Likewise, in what all but 2 % of the readings are away from the median."""
COUNTS = 4.0
"""Likewise, in counts of an encoder."""
MOST = 0.05
"""Largest share of wild readings; more are no accident."""
AFTER = 0.06
"""After a jump of the command for so long a velocity or torque may jump too [s]."""
FROZEN = 0.1
"""Time for which a reading stands still to the last digit [s]. Chosen: noise changes it from row to row."""
LEAST_ROWS = 10
"""Likewise in rows."""
EXCITED = 1e-3
"""Least movement of a command or a joint [rad or m]."""
SLOW = 15
"""Rows over which a signal's speed is taken."""
WHITE = -0.4
"""Correlation of third differences from row to row below which they are noise: -0.75 for white noise, and above 0 for
a smooth course."""


@dataclass(frozen=True, slots=True)
class Texture:
    """What a signal is made of between rows.

    Attributes:
        noise: Standard deviation; 0: what is between rows is no noise.
        count: Smallest step.
    """

    noise: float
    count: float

    @property
    def flickers(self) -> bool:
        """Whether a joint at rest would show noise."""
        return self.noise > self.count


def texture(signal: Array) -> Texture:
    """Noise and count of a signal, where it is slow; NaN is passed over."""
    import numpy as np

    steps = np.abs(np.diff(signal))
    steps = steps[np.isfinite(steps) & (steps > 0)]
    count = float(steps.min()) if len(steps) else 0.0
    if len(signal) < 4 * SLOW:
        return Texture(0.0, count)
    # Jitter makes noise of speed, so only slow rows tell the sensor's; those that stand still tell nothing.
    gone = np.abs(signal[SLOW:] - signal[:-SLOW])
    stands = np.convolve(np.diff(signal) == 0.0, np.ones(SLOW), mode="valid") == SLOW
    gone = np.where(stands, np.nan, gone)
    third = signal[3:] - 3 * signal[2:-1] + 3 * signal[1:-2] - signal[:-3]
    third = third[SLOW // 2 : SLOW // 2 + len(gone)]
    if not np.isfinite(gone).any():
        return Texture(0.0, count)
    slow = np.isfinite(third) & (gone <= np.nanquantile(gone, 0.25))
    if slow.sum() < SLOW:
        return Texture(0.0, count)
    sizes = np.abs(third)
    slow &= sizes <= 20.0 * max(float(np.median(sizes[slow])), count)
    both = slow[1:] & slow[:-1]
    size = float(np.sum(third[1:][both] ** 2))
    if size == 0.0 or float(np.sum(third[1:][both] * third[:-1][both])) > WHITE * size:
        return Texture(0.0, count)
    # 1, 3, 3, 1 of white noise: the sum of the squares is 20.
    return Texture(1.4826 * float(np.median(sizes[slow])) / math.sqrt(20.0), count)


def wild(signal: Array, jumps: Mask | None = None) -> Mask:
    """Readings far from where those around them lead; shape (n,).

    Args:
        signal: NaN is passed over.
        jumps: Rows at which the signal may jump by itself.
    """
    import numpy as np
    from scipy.ndimage import median_filter

    good = np.flatnonzero(np.isfinite(signal))
    found = np.zeros(len(signal), dtype=bool)
    if len(good) < 4 * WINDOW:
        return found
    values = signal[good]
    away = np.abs(values - median_filter(values, WINDOW, mode="nearest"))
    seen = texture(values)
    passed = np.abs(values[2:] - values[:-2])
    least = max(
        WILD * seen.noise,
        USUAL * float(np.quantile(away, 0.98)),
        COUNTS * seen.count,
        0.5 * float(np.quantile(passed, 0.98)),
        1e-9,
    )
    far = away > least
    if far.mean() <= MOST:
        # Where a course bends it is away from the median too, but not from a cubic through its neighbours.
        far &= np.abs(values - _led(values, far)) > least
    if jumps is not None:
        far &= ~jumps[good]
    found[good] = far
    return found


def _led(values: Array, left_out: Mask) -> Array:
    """Where the readings around those that are left out lead, by a cubic through the three nearest on either side."""
    import numpy as np

    found = values.copy()
    kept = np.flatnonzero(~left_out)
    for row in np.flatnonzero(left_out).tolist():
        at = int(np.searchsorted(kept, row))
        near = kept[max(at - 3, 0) : at + 3]
        if len(near) >= 4:
            found[row] = float(np.polyval(np.polyfit(near - row, values[near], 3), 0.0))
    return found


def jumps(command: Array, step: float) -> Mask:
    """Rows within `AFTER` a jump of the command or of its slope; shape (n,)."""
    import numpy as np

    rows = max(2, math.ceil(AFTER / step))
    slope = np.diff(command, prepend=command[0])
    jumped = np.zeros(len(command), dtype=bool)
    for size in (np.abs(slope), np.abs(np.diff(slope, prepend=slope[0]))):
        jumped |= size > 2.0 * float(np.quantile(size, 0.98))
    return np.convolve(jumped, np.ones(rows + 1), mode="full")[: len(command)] > 0


def frozen(time: Array, command: Array, measured: dict[str, Array]) -> dict[str, Mask]:
    """Rows of each signal in which it stands still and the joint or its drive does not; shape (n,) each.

    Args:
        time: [s], shape (n,).
        command: [rad or m].
        measured: `position`, `velocity`, `torque`; NaN is passed over.
    """
    import numpy as np

    found = {name: np.zeros(len(time), dtype=bool) for name in measured}
    textures = {name: texture(signal) for name, signal in measured.items()}
    for name, signal in measured.items():
        for start, end in _still(time, signal):
            rows = slice(start, end + 1)
            if np.ptp(command[rows]) > EXCITED and _spoilt(name, start, end, time, measured, textures):
                found[name][rows] = True
    return found


def _still(time: Array, signal: Array) -> list[tuple[int, int]]:
    """First and last rows of stretches in which a signal stands still to the last digit."""
    import numpy as np

    same = np.diff(signal) == 0.0
    edges = np.flatnonzero(np.diff(np.concatenate([[False], same, [False]]).astype(int)))
    return [
        (start, end)
        for start, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
        if time[end] - time[start] >= FROZEN and end - start >= LEAST_ROWS
    ]


def _spoilt(
    name: str, start: int, end: int, time: Array, measured: dict[str, Array], textures: dict[str, Texture]
) -> bool:
    """Whether a stretch is that of a sensor, and not of a joint at rest or of a torque at its limit."""
    import numpy as np

    signal, seen = measured[name], textures[name]
    rows = slice(start, end + 1)
    position = measured["position"]
    if name == "torque":
        largest = float(np.nanmax(np.abs(signal)))
        return seen.flickers and abs(float(signal[start])) < 0.97 * largest
    if name == "velocity":
        gone = position[rows][np.isfinite(position[rows])]
        if len(gone) < 2:
            return False
        away = np.ptp(gone - signal[start] * (time[rows][np.isfinite(position[rows])] - time[start]))
        least = max(WILD * textures["position"].noise, COUNTS * textures["position"].count, EXCITED)
        # A servo that stands may read a count of speed.
        return float(away) - seen.count * float(time[end] - time[start]) > least
    if seen.flickers:
        return True
    usual = np.abs(np.diff(signal))
    usual = usual[np.isfinite(usual)]
    least = max(COUNTS * seen.count, 3.0 * float(np.quantile(usual, 0.98)))
    if end + 1 < len(signal) and abs(float(signal[end + 1] - signal[end])) > least:
        return True
    velocity = measured.get("velocity")
    if velocity is None or not np.isfinite(velocity[rows]).all():
        return False
    length = float(time[end] - time[start])
    went = np.ptp(np.cumsum(velocity[rows][:-1] * np.diff(time[rows]))) - textures["velocity"].count * length
    drift = WILD * textures["velocity"].noise * math.sqrt(length * length / (end - start))
    return float(went) > max(COUNTS * seen.count, drift, EXCITED)
