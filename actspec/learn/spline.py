"""A spline through noisy readings, for their derivatives."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from actspec.sysid.recording import scatter

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

HALVINGS = 14
"""Of the range of a spline's stiffness."""
STIFFNESS = (1e-14, 1e2)
"""Its least and largest value. Chosen: from a spline through every reading to one that bends over seconds."""


def spline(time: Array, signal: Array) -> Any:
    """A cubic spline through readings, as stiff as their noise allows; what is not a number is left out.

    Args:
        time: [s], shape (n,), growing.
        signal: Likewise.

    Returns:
        One of scipy's, called with times, and with `derivative()`.
    """
    import numpy as np
    from scipy.interpolate import CubicSpline, make_smoothing_spline

    good = np.isfinite(signal)
    time, signal = time[good], signal[good]
    noise = scatter(signal, time)
    if len(time) < 5 or not noise > 0.0:
        return CubicSpline(time, signal)
    low, high = (math.log(end) for end in STIFFNESS)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        found = make_smoothing_spline(time, signal, lam=math.exp(middle))
        if float(np.mean((found(time) - signal) ** 2)) > noise**2:
            high = middle
        else:
            low = middle
    return make_smoothing_spline(time, signal, lam=math.exp(low))
