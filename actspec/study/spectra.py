"""Where in frequency a signal of a log has its power, over stretches without gaps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.sysid.recording import GAP

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

LEAST = 32
"""Fewest rows of a stretch. Chosen: fewer have no spectrum."""


@dataclass(frozen=True, slots=True)
class Spectrum:
    """Power by frequency, that of the mean left out; frequencies of all stretches in one order.

    Attributes:
        frequency: Growing, above 0 [Hz], shape (n,).
        power: Parts of the variance, likewise; their sum is the variance times the rows.
    """

    frequency: Array
    power: Array

    def above(self, frequency: float) -> float:
        """Share of the variance above a frequency [Hz]."""
        return float(self.power[self.frequency > frequency].sum() / self.power.sum())

    def below_which(self, share: float) -> float:
        """Frequency below which a share of the variance is [Hz]."""
        import numpy as np

        sums = np.cumsum(self.power)
        return float(self.frequency[int(np.searchsorted(sums, share * sums[-1]))])


def spectrum(parts: Sequence[tuple[Array, Array]]) -> Spectrum | None:
    """Of a signal in several recordings; None: it is constant, or no stretch is long enough.

    Args:
        parts: Time [s] and signal of each, shapes (n,); NaN where there is no reading.
    """
    import numpy as np

    found = [stretch for time, signal in parts for stretch in _stretches(time, signal)]
    if not found:
        return None
    frequency = np.concatenate([f for f, _ in found])
    power = np.concatenate([p for _, p in found])
    if not power.sum() > 0.0:
        return None
    order = np.argsort(frequency, kind="stable")
    return Spectrum(frequency[order], power[order])


def _stretches(time: Array, signal: Array) -> Iterator[tuple[Array, Array]]:
    """Frequencies and power of each stretch without a gap."""
    import numpy as np

    good = np.isfinite(signal)
    if good.sum() < LEAST:
        return
    time, signal = time[good], signal[good]
    step = float(np.median(np.diff(time)))
    for part in np.split(np.arange(len(time)), np.flatnonzero(np.diff(time) > GAP * step) + 1):
        if len(part) < LEAST:
            continue
        even = np.arange(time[part[0]], time[part[-1]] + 0.5 * step, step)
        values = np.interp(even, time[part], signal[part])
        values = values - values.mean()
        # One side of the periodogram: each line but that of half the rate stands for two.
        power = np.abs(np.fft.rfft(values))[1:] ** 2 * (2.0 / len(values))
        if len(values) % 2 == 0:
            power[-1] *= 0.5
        yield np.arange(1, len(power) + 1) / (len(values) * step), power
