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
        found = spline(time, signal, math.exp(middle))
        if float(np.mean((found(time[good]) - signal[good]) ** 2)) > noise**2:
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
    from scipy.interpolate import CubicSpline, make_smoothing_spline

    good = np.isfinite(signal)
    if stiff == 0.0:
        return CubicSpline(time[good], signal[good])
    return make_smoothing_spline(time[good], signal[good], lam=stiff)
