"""A spline through noisy readings, for their derivatives."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from actspec.sysid.recording import scatter

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

HALVINGS = 9
"""Of the range of a spline's stiffness. Chosen: it is then known to 8 %, its width in time to 2 %."""
STIFFNESS = (1e-14, 1e2)
"""Its least and largest value. Chosen: from a spline through every reading to one that bends over seconds."""


def stiffness(time: Array, signal: Array) -> float:
    """How stiff a spline may be: it then leaves as much of the readings as is noise; 0: it goes through all of them.

    Args:
        time: [s], shape (n,), growing.
        signal: Likewise; what is not a number is left out.
    """
    import numpy as np

    good = np.isfinite(signal)
    noise = scatter(signal[good], time[good])
    if good.sum() < 5 or not noise > 0.0:
        return 0.0
    low, high = (math.log(end) for end in STIFFNESS)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if float(np.mean(_away(time[good], signal[good], math.exp(middle)) ** 2)) > noise**2:
            high = middle
        else:
            low = middle
    return math.exp(low)


def spline(time: Array, signal: Array, stiff: float) -> Any:
    """A cubic spline through readings; what is not a number is left out.

    Args:
        time: [s], shape (n,), growing.
        signal: Likewise.
        stiff: See `stiffness`.

    Returns:
        One of scipy's, called with times, and with `derivative()`.
    """
    import numpy as np
    from scipy.interpolate import CubicSpline

    good = np.isfinite(signal)
    if stiff == 0.0 or good.sum() < 3:
        return CubicSpline(time[good], signal[good])
    return CubicSpline(time[good], signal[good] - _away(time[good], signal[good], stiff), bc_type="natural")


def _away(time: Array, signal: Array, stiff: float) -> Array:
    """By how much readings are above the natural cubic spline f with the least sum of squares + stiff * integral f''^2.

    Reinsch, Smoothing by spline functions (1967): of its second derivatives g at the inner readings
    (R + stiff Q'Q) g = Q' signal, and it is stiff Q g away. scipy's make_smoothing_spline gives the same, by a loop of
    Python over the rows that takes 40 to 80 times as long.

    Args:
        time: [s], shape (n,), growing; three at least.
        signal: Likewise.
        stiff: See `stiffness`.
    """
    import numpy as np
    from scipy.linalg import solveh_banded

    steps = np.diff(time)
    # Q has three numbers in each column: what a second difference takes of three readings.
    first, last = 1.0 / steps[:-1], 1.0 / steps[1:]
    middle = -(first + last)
    band = np.zeros((3, len(middle)))
    band[2] = (steps[:-1] + steps[1:]) / 3.0 + stiff * (first**2 + middle**2 + last**2)
    band[1, 1:] = steps[1:-1] / 6.0 + stiff * (middle[:-1] * first[1:] + last[:-1] * middle[1:])
    band[0, 2:] = stiff * last[:-2] * first[2:]
    bends = solveh_banded(band, first * signal[:-2] + middle * signal[1:-1] + last * signal[2:])
    away = np.zeros(len(time))
    away[:-2] += first * bends
    away[1:-1] += middle * bends
    away[2:] += last * bends
    return stiff * away
