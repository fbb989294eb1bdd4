"""Axes of pictures: ends, round numbers on them, units with prefixes; the frame that all pictures stand in."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

from actspec.diagnostics import one_line
from actspec.fields import units_of
from actspec.joints import JointKind
from actspec.resources import data_path

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

FINE = 10
"""Parts of a pixel in which places are written."""
LETTER = 6.6
"""Width of a letter of the axes [px]. Measured: the mean of a wide common font at 11 px."""
_PREFIXED = {"rad", "s", "m", "Hz", "N", "N*m", "A"}
"""Units that take a prefix; before others stands a power of ten."""
_PREFIX = {-9: "n", -6: "u", -3: "m", 3: "k"}


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis.

    Attributes:
        label: What is drawn along it.
        unit: SI unit; "": none.
        log: Whether equal ways are equal ratios; what is not above 0 is not drawn.
        low: Where it begins; None: where the data do.
        high: Where it ends; None: likewise.
    """

    label: str
    unit: str = ""
    log: bool = False
    low: float | None = None
    high: float | None = None


def speed_and_torque(kind: JointKind, fastest: float | None = None) -> tuple[Axis, Axis]:
    """The axes of a joint's torque against its speed.

    Args:
        kind: A slide has a force.
        fastest: End of the speeds, either way [rad/s or m/s]; None: of the data.
    """
    units = units_of(kind)
    speed = Axis("speed", units.speed, low=None if fastest is None else -fastest, high=fastest)
    return speed, Axis("force" if kind is JointKind.SLIDE else "torque", units.torque)


def plot_style() -> str:
    """The CSS that pictures need, once a page."""
    return data_path("templates", "report/plot.css").read_text(encoding="utf-8")


def ticks(low: float, high: float, count: int = 6) -> list[float]:
    """Round numbers from `low` to `high`, 1, 2 or 5 times a power of ten apart.

    Args:
        low: First.
        high: Last, above it.
        count: Most.
    """
    raw = (high - low) / max(count - 1, 1)
    size = 10.0 ** math.floor(math.log10(raw))
    step = next(size * m for m in (1, 2, 5, 10) if size * m >= raw * (1 - 1e-9))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [i * step for i in range(first, last + 1)]


def log_ticks(low: float, high: float, count: int = 8) -> list[float]:
    """Powers of ten from `low` to `high`, and 2 and 5 times these where there is room.

    Args:
        low: First, above 0.
        high: Last, above it.
        count: Most.
    """
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    for parts, apart in (((1, 2, 5), 1), ((1, 3), 1), ((1,), 1), ((1,), 2), ((1,), 3)):
        found = [
            m * 10.0**e
            for e in range(first, last + 1)
            if e % apart == 0
            for m in parts
            if low * (1 - 1e-9) <= m * 10.0**e <= high * (1 + 1e-9)
        ]
        if len(found) <= count:
            break
    return found if len(found) > 1 else ticks(low, high, count)


@dataclass(frozen=True, slots=True)
class Placed:
    """An axis with its ends and ticks; `share` is the place of a number, 0 to 1."""

    axis: Axis
    low: float
    high: float
    ticks: tuple[tuple[float, str], ...]
    title: str

    @classmethod
    def of(cls, axis: Axis, extent: tuple[float, float], room: float = 0.0) -> Placed:
        low = extent[0] if axis.low is None else axis.low
        high = extent[1] if axis.high is None else axis.high
        if axis.log:
            low = max(low, 1e-300)
            high = high if high > low else 10.0 * low
            found = log_ticks(low, high)
            named = tuple((tick, f"{tick:g}") for tick in found)
            return cls(axis, low, high, named, _title(axis, 0))
        if not high - low > 1e-12 * max(abs(low), abs(high)):
            away = 0.5 * abs(low) or 1.0
            low, high = low - away, high + away
        wide = high - low
        low = low - room * wide if axis.low is None else low
        high = high + room * wide if axis.high is None else high
        found = ticks(low, high)
        most = max(abs(low), abs(high))
        power = 3 * math.floor(math.log10(most) / 3) if most > 0 else 0
        power = 0 if -2 <= math.log10(most) < 5 or not axis.unit else power
        step = found[1] - found[0] if len(found) > 1 else wide
        digits = max(0, -math.floor(math.log10(step / 10.0**power) + 1e-9))
        # -0.0 is 0.
        named = tuple((tick, f"{round(tick / 10.0**power, digits) + 0.0:.{digits}f}") for tick in found)
        return cls(axis, low, high, named, _title(axis, power))

    def share(self, value: float) -> float:
        if self.axis.log:
            value = max(value, 1e-300)
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def shares(self, values: Array) -> Array:
        """The same of many; NaN where a number has no place."""
        import numpy as np

        if self.axis.log:
            positive = np.where(values > 0, values, np.nan)
            found: Array = np.log(positive / self.low) / math.log(self.high / self.low)
            return found
        found = (values - self.low) / (self.high - self.low)
        return found


def _title(axis: Axis, power: int) -> str:
    unit = axis.unit
    if power:
        prefix = _PREFIX.get(power) if unit in _PREFIXED else None
        unit = f"{prefix}{unit}" if prefix else f"1e{power} {unit}".strip()
    return f"{axis.label} [{unit}]" if unit else axis.label


def text_of(text: str) -> str:
    return escape(one_line(text))


def framed(title: str, width: float, height: float, body: Iterable[str]) -> str:
    size = f'viewBox="0 0 {width:.0f} {height:.0f}" width="{width:.0f}" height="{height:.0f}"'
    return f'<svg class="plot" role="img" {size}><title>{text_of(title)}</title>{"".join(body)}</svg>'


def grid(x: Placed, y: Placed | None, left: float, top: float, wide: float, high: float) -> Iterator[str]:
    """Frame, ticks and titles of the axes."""
    lines = []
    bottom = top + high
    room = 1.0 if not x.ticks else wide / len(x.ticks)
    every = max(1, math.ceil((max((len(text) for _, text in x.ticks), default=1) + 1.5) * LETTER / room))
    for place, (tick, text) in enumerate(x.ticks):
        at = left + wide * x.share(tick)
        lines.append(f"M{at:.1f} {top:.1f}v{high:.1f}")
        if place % every == 0:
            yield f'<text x="{at:.1f}" y="{bottom + 14:.1f}" class="mid">{text}</text>'
    for tick, text in () if y is None else y.ticks:
        at = bottom - high * y.share(tick)  # type: ignore[union-attr]
        lines.append(f"M{left:.1f} {at:.1f}h{wide:.1f}")
        yield f'<text x="{left - 5:.1f}" y="{at + 4:.1f}" class="end">{text}</text>'
    yield f'<path class="grid" d="{"".join(lines)}"/>'
    yield f'<path class="frame" d="M{left:.1f} {top:.1f}v{high:.1f}h{wide:.1f}"/>'
    yield f'<text x="{left + wide / 2:.1f}" y="{bottom + 31:.1f}" class="mid">{text_of(x.title)}</text>'
    if y is not None:
        middle = top + high / 2
        yield f'<text transform="translate(11 {middle:.1f}) rotate(-90)" class="mid">{text_of(y.title)}</text>'
