"""Pictures of data as SVG in text: axes with units, lines, points, bands, bars, intervals. No script, no font, no id.

Colours are classes (`templates/report/plot.css`), so a picture follows the page into the dark and onto paper. A line
of many points is drawn by the least and the greatest of each column of pixels, so no peak is lost.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from html import escape
from typing import TYPE_CHECKING

from actspec.diagnostics import one_line, shortened
from actspec.resources import data_path

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

READ, FIT, COMMAND, NOISE = 0, 1, 2, 3
"""Colours of what was measured, of a model, of what was asked for, and of what chance gives."""
FINE = 10
"""Parts of a pixel in which places are written."""
LETTER = 6.6
"""Width of a letter of the axes [px]. Measured: the mean of a wide common font at 11 px."""
CELL = 2.0
"""Points that fall into one square of such sides are one [px]."""
_BIG = 10 * FINE
"""So far outside of the picture a line may go, in its widths: it is cut there, and its slope at the edge is kept."""
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


@dataclass(frozen=True, slots=True)
class Line:
    """A line through points; a NaN interrupts it.

    Attributes:
        x: Growing, shape (n,).
        y: Likewise.
        label: In the legend; "": it is not there.
        colour: Number of its class, 0 to 4.
        dash: "", `dashed` or `dotted`.
        stairs: Whether each value holds until the next.
        broad: Whether it is so wide that another line over it leaves it to be seen.
    """

    x: Array
    y: Array
    label: str = ""
    colour: int = 0
    dash: str = ""
    stairs: bool = False
    broad: bool = False


@dataclass(frozen=True, slots=True)
class Points:
    """A cloud.

    Attributes:
        x: Shape (n,).
        y: Likewise.
        label: In the legend; "": it is not there.
        colour: Number of its class.
    """

    x: Array
    y: Array
    label: str = ""
    colour: int = 0


@dataclass(frozen=True, slots=True)
class Band:
    """What lies between two lines.

    Attributes:
        x: Growing, shape (n,).
        low: Likewise.
        high: Likewise.
        label: In the legend; "": it is not there.
        colour: Number of its class.
    """

    x: Array
    low: Array
    high: Array
    label: str = ""
    colour: int = 0


@dataclass(frozen=True, slots=True)
class Bars:
    """Bars from 0.

    Attributes:
        edges: Shape (n + 1,).
        heights: Shape (n,).
        label: In the legend; "": it is not there.
        colour: Number of its class.
    """

    edges: Array
    heights: Array
    label: str = ""
    colour: int = 0


@dataclass(frozen=True, slots=True)
class Rule:
    """A straight line across the picture.

    Attributes:
        at: Where on its axis.
        label: In the legend; "": it is not there.
        upright: Whether it stands on the x axis.
        colour: Number of its class.
    """

    at: float
    label: str = ""
    upright: bool = False
    colour: int = 2


Mark = Line | Points | Band | Bars | Rule


@dataclass(frozen=True, slots=True)
class Chart:
    """A picture.

    Attributes:
        title: What it shows, for those who do not see it too.
        x: Axis below.
        y: Axis at the left.
        marks: In the order of drawing.
        width: [px].
        height: Of the picture with its axes, without the legend [px].
    """

    title: str
    x: Axis
    y: Axis
    marks: Sequence[Mark]
    width: int = 520
    height: int = 220


@dataclass(frozen=True, slots=True)
class Interval:
    """One row of a picture of intervals.

    Attributes:
        name: At its left.
        value: Its best value; None: there is none, and `note` stands in its place.
        low: Lower end.
        high: Upper end.
        other: What it is compared with; None: nothing.
        note: In place of a value.
    """

    name: str
    value: float | None = None
    low: float | None = None
    high: float | None = None
    other: float | None = None
    note: str = ""


def plot_style() -> str:
    """The CSS that pictures need, once a page."""
    return data_path("templates", "report/plot.css").read_text(encoding="utf-8")


def svg(chart: Chart) -> str:
    """A picture as one `<svg>` element."""
    legend = [(mark.label, mark) for mark in chart.marks if mark.label]
    x_all, y_all = _extent(chart)
    y_axis = _Placed.of(chart.y, y_all)
    left = 26.0 + LETTER * max((len(text) for _, text in y_axis.ticks), default=1)
    rows = _legend_rows([label for label, _ in legend], chart.width - left)
    top = 6.0 + 15.0 * (max(rows, default=-1) + 1)
    x_axis = _Placed.of(chart.x, x_all)
    wide, high = chart.width - left - 10.0, chart.height - 44.0
    height = top + high + 38.0
    body = [
        *_grid(x_axis, y_axis, left, top, wide, high),
        *_legend(legend, rows, left),
        _field(chart.marks, x_axis, y_axis, left, top, wide, high),
    ]
    return _framed(chart.title, chart.width, height, body)


def intervals(
    title: str, axis: Axis, rows: Sequence[Interval], other: str = "spec", width: int = 520, named: int = 24
) -> str:
    """Values with their intervals, one row each, as one `<svg>` element.

    Args:
        title: What it shows.
        axis: Below.
        rows: From top to bottom.
        other: What `Interval.other` is, for the legend.
        width: [px].
        named: Most letters of a name; longer ones are cut.
    """
    names = [shortened(one_line(row.name), named) for row in rows]
    given = [v for row in rows for v in (row.value, row.low, row.high, row.other) if v is not None]
    placed = _Placed.of(axis, (min(given), max(given)) if given else (0.0, 1.0), room=0.06)
    left = 14.0 + LETTER * max((len(name) for name in names), default=1)
    compared = any(row.other is not None for row in rows)
    top, wide, high = (22.0 if compared else 6.0), width - left - 14.0, 20.0 * len(rows) + 4.0
    body = list(_grid(placed, None, left, top, wide, high))
    if compared:
        body.append(f'<path class="k2 diamond" d="{_diamond(left + 6, 11)}"/>')
        body.append(f'<text x="{left + 15:.0f}" y="15">{_text(other)}</text>')
    for place, (row, name) in enumerate(zip(rows, names, strict=True)):
        y = top + 20.0 * place + 12.0
        body.append(f'<text x="{left - 7:.0f}" y="{y + 4:.0f}" class="end">{_text(name)}</text>')
        if row.other is not None:
            body.append(
                f'<path class="k2 diamond" d="{_diamond(left + wide * placed.share(row.other), y)}"/>'
            )
        if row.value is None:
            # Beside the diamond, not across it.
            crowded = row.other is not None and placed.share(row.other) < 0.5
            end = ' class="end faint"' if crowded else ' class="faint"'
            at = left + wide - 6 if crowded else left + 6
            body.append(f'<text x="{at:.0f}" y="{y + 4:.0f}"{end}>{_text(shortened(row.note, 40))}</text>')
            continue
        if row.low is not None and row.high is not None:
            a, b = (left + wide * placed.share(v) for v in (row.low, row.high))
            body.append(
                f'<path class="c0 thick" d="M{a:.1f} {y:.1f}H{b:.1f}M{a:.1f} {y - 5:.1f}v10M{b:.1f} {y - 5:.1f}v10"/>'
            )
        body.append(
            f'<circle class="k0" cx="{left + wide * placed.share(row.value):.1f}" cy="{y:.1f}" r="3"/>'
        )
    return _framed(title, width, top + high + 38.0, body)


def stacks(
    title: str,
    axis: Axis,
    rows: Sequence[tuple[str, Sequence[float]]],
    parts: Sequence[str],
    width: int = 520,
    named: int = 24,
) -> str:
    """Sums of parts above 0, one bar a row, as one `<svg>` element.

    Args:
        title: What it shows.
        axis: Below.
        rows: Name and parts of each, from top to bottom.
        parts: What the parts are, for the legend; at most five.
        width: [px].
        named: Most letters of a name; longer ones are cut.
    """
    names = [shortened(one_line(name), named) for name, _ in rows]
    most = max((sum(values) for _, values in rows), default=0.0)
    placed = _Placed.of(replace(axis, low=0.0), (0.0, most if most > 0.0 else 1.0))
    left = 14.0 + LETTER * max((len(name) for name in names), default=1)
    top, wide, high = 22.0, width - left - 14.0, 20.0 * len(rows) + 4.0
    body = list(_grid(placed, None, left, top, wide, high))
    x = left
    for place, part in enumerate(parts):
        body.append(f'<rect class="f{place}" x="{x:.0f}" y="6" width="10" height="10"/>')
        body.append(f'<text x="{x + 14:.0f}" y="15">{_text(part)}</text>')
        x += 26.0 + LETTER * len(part)
    for row, ((_, values), name) in enumerate(zip(rows, names, strict=True)):
        y, at = top + 20.0 * row + 5.0, 0.0
        body.append(f'<text x="{left - 7:.0f}" y="{y + 11:.0f}" class="end">{_text(name)}</text>')
        for place, value in enumerate(values):
            a, b = (left + wide * placed.share(v) for v in (at, at + value))
            if b - a > 0.05:
                body.append(
                    f'<rect class="f{place}" x="{a:.1f}" y="{y:.1f}" width="{b - a:.1f}" height="14"/>'
                )
            at += value
    return _framed(title, width, top + high + 38.0, body)


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


def thinned(x: Array, y: Array, columns: int) -> tuple[Array, Array]:
    """A line in no more points than show: of each column the least and the greatest, in the order they come.

    Args:
        x: Growing, shape (n,), finite.
        y: Likewise.
        columns: Of pixels.
    """
    import numpy as np

    if len(x) <= 3 * columns:
        return x, y
    column = np.minimum((x - x[0]) / (x[-1] - x[0]) * columns, columns - 1).astype(int)
    starts = np.concatenate([[0], np.flatnonzero(np.diff(column)) + 1])
    ends = np.append(starts[1:], len(x))
    kept = []
    for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
        part = y[start:end]
        kept += sorted({start + int(part.argmin()), start + int(part.argmax())})
    index = np.array(kept)
    return x[index], y[index]


@dataclass(frozen=True, slots=True)
class _Placed:
    """An axis with its ends and ticks; `share` is the place of a number, 0 to 1."""

    axis: Axis
    low: float
    high: float
    ticks: tuple[tuple[float, str], ...]
    title: str

    @classmethod
    def of(cls, axis: Axis, extent: tuple[float, float], room: float = 0.0) -> _Placed:
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


def _extent(chart: Chart) -> tuple[tuple[float, float], tuple[float, float]]:
    """The data's least and greatest, with room above and below."""
    import numpy as np

    xs: list[Array] = []
    ys: list[Array] = []
    for mark in chart.marks:
        if isinstance(mark, Rule):
            (xs if mark.upright else ys).append(np.array([mark.at]))
        elif isinstance(mark, Band):
            xs.append(mark.x)
            ys += [mark.low, mark.high]
        elif isinstance(mark, Bars):
            xs.append(mark.edges)
            ys += [mark.heights, np.zeros(1)]
        else:
            xs.append(mark.x)
            ys.append(mark.y)
    found = []
    bars = any(isinstance(mark, Bars) for mark in chart.marks)
    for axis, parts in ((chart.x, xs), (chart.y, ys)):
        values = np.concatenate([np.asarray(part, dtype=float).ravel() for part in parts] or [np.empty(0)])
        values = values[np.isfinite(values) & ((values > 0) if axis.log else True)]
        low, high = (float(values.min()), float(values.max())) if len(values) else (1.0, 10.0)
        if axis is chart.y and not axis.log:
            away = 0.04 * (high - low)
            # Bars stand on the axis.
            low, high = (low if bars and low == 0.0 else low - away), high + away
        found.append((low, high))
    return found[0], found[1]


def _text(text: str) -> str:
    return escape(one_line(text))


def _framed(title: str, width: float, height: float, body: Iterable[str]) -> str:
    size = f'viewBox="0 0 {width:.0f} {height:.0f}" width="{width:.0f}" height="{height:.0f}"'
    return f'<svg class="plot" role="img" {size}><title>{_text(title)}</title>{"".join(body)}</svg>'


def _grid(x: _Placed, y: _Placed | None, left: float, top: float, wide: float, high: float) -> Iterator[str]:
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
    yield f'<text x="{left + wide / 2:.1f}" y="{bottom + 31:.1f}" class="mid">{_text(x.title)}</text>'
    if y is not None:
        middle = top + high / 2
        yield f'<text transform="translate(11 {middle:.1f}) rotate(-90)" class="mid">{_text(y.title)}</text>'


def _legend_rows(labels: Sequence[str], wide: float) -> list[int]:
    """The row of each label."""
    found, at, row = [], 0.0, 0
    for label in labels:
        size = 36.0 + LETTER * len(label)
        if at and at + size > wide:
            at, row = 0.0, row + 1
        found.append(row)
        at += size
    return found


def _legend(legend: Sequence[tuple[str, Mark]], rows: Sequence[int], left: float) -> Iterator[str]:
    at, before = left, 0
    for (label, mark), row in zip(legend, rows, strict=True):
        if row != before:
            at, before = left, row
        y = 9.0 + 15.0 * row
        if isinstance(mark, Band | Bars):
            yield f'<rect class="f{mark.colour}" x="{at:.1f}" y="{y - 4:.1f}" width="18" height="8"/>'
        elif isinstance(mark, Points):
            yield f'<path class="c{mark.colour} dots" d="M{at + 5:.1f} {y:.1f}h0m8 0h0"/>'
        else:
            yield f'<path class="{_classes(mark)}" d="M{at:.1f} {y:.1f}h18"/>'
        yield f'<text x="{at + 22:.1f}" y="{y + 4:.1f}">{_text(label)}</text>'
        at += 36.0 + LETTER * len(label)


def _field(
    marks: Sequence[Mark], x: _Placed, y: _Placed, left: float, top: float, wide: float, high: float
) -> str:
    """What is drawn, in a window of its own that cuts what sticks out."""
    w, h = wide * FINE, high * FINE
    parts = "".join(_drawn(mark, x, y, wide, high) for mark in marks)
    return (
        f'<svg x="{left:.1f}" y="{top:.1f}" width="{wide:.1f}" height="{high:.1f}" '
        f'viewBox="0 0 {w:.0f} {h:.0f}" preserveAspectRatio="none">{parts}</svg>'
    )


def _drawn(mark: Mark, x: _Placed, y: _Placed, wide: float, high: float) -> str:
    import numpy as np

    w, h = wide * FINE, high * FINE
    if isinstance(mark, Rule):
        if mark.upright:
            path = f"M{w * x.share(mark.at):.0f} 0V{h:.0f}"
        else:
            path = f"M0 {h * (1 - y.share(mark.at)):.0f}H{w:.0f}"
        return f'<path class="{_classes(mark)}" d="{path}"/>'
    if isinstance(mark, Bars):
        edges, tops, floor = (
            np.round(w * x.shares(mark.edges)),
            np.round(h * (1 - y.shares(mark.heights))),
            round(h * (1 - y.share(0.0))),
        )
        path = "".join(
            f"M{a:.0f} {floor}V{t:.0f}H{b:.0f}V{floor}"
            for a, b, t in zip(edges[:-1], edges[1:], tops, strict=True)
            if t < floor
        )
        return f'<path class="f{mark.colour}" d="{path}"/>'
    px = w * x.shares(np.asarray(mark.x, dtype=float))
    if isinstance(mark, Band):
        lower, upper = (_cut(h * (1 - y.shares(v)), h) for v in (mark.low, mark.high))
        path = ""
        for run in _runs(np.isfinite(px) & np.isfinite(lower) & np.isfinite(upper)):
            a, b = thinned(px[run], upper[run], round(wide)), thinned(px[run], lower[run], round(wide))
            path += (
                _path(
                    np.concatenate([a[0], b[0][::-1]]),
                    np.concatenate([a[1], b[1][::-1]]),
                )
                + "z"
            )
        return f'<path class="f{mark.colour}" d="{path}"/>'
    py = _cut(h * (1 - y.shares(np.asarray(mark.y, dtype=float))), h)
    good = np.isfinite(px) & np.isfinite(py)
    if isinstance(mark, Points):
        cells = np.unique(np.round(np.stack([px[good], py[good]], axis=1) / (CELL * FINE)), axis=0)
        return f'<path class="c{mark.colour} dots" d="{_dots(cells * CELL * FINE)}"/>'
    path = ""
    for run in _runs(good):
        u, v = px[run], py[run]
        if mark.stairs:
            u, v = np.repeat(u, 2)[1:], np.repeat(v, 2)[:-1]
        path += _path(*thinned(u, v, round(wide)))
    return f'<path class="{_classes(mark)}" d="{path}"/>'


def _classes(mark: Line | Rule) -> str:
    more = (mark.dash, "broad" * mark.broad) if isinstance(mark, Line) else ("dashed",)
    return " ".join(("c" + str(mark.colour), *filter(None, more)))


def _cut(values: Array, high: float) -> Array:
    import numpy as np

    found: Array = np.clip(values, -_BIG * high, _BIG * high)
    return found


def _runs(good: NDArray[np.bool_]) -> list[slice]:
    """Stretches that are good."""
    import numpy as np

    edges = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(int)))
    return [slice(a, b) for a, b in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)]


def _path(x: Array, y: Array) -> str:
    """A line in whole parts of a pixel, each place by its way from the last."""
    import numpy as np

    u, v = np.round(x).astype(int), np.round(y).astype(int)
    if len(u) == 1:
        return f"M{u[0]} {v[0]}h0"
    ways = zip(np.diff(u).tolist(), np.diff(v).tolist(), strict=True)
    return f"M{u[0]} {v[0]}l" + " ".join(f"{a} {b}" if b >= 0 else f"{a}{b}" for a, b in ways)


def _dots(places: Array) -> str:
    import numpy as np

    whole = np.round(places).astype(int)
    if not len(whole):
        return ""
    ways = np.diff(whole, axis=0).tolist()
    return f"M{whole[0, 0]} {whole[0, 1]}h0" + "".join(f"m{a} {b}h0" for a, b in ways)


def _diamond(x: float, y: float) -> str:
    return f"M{x:.1f} {y - 5:.1f}l5 5-5 5-5-5z"
