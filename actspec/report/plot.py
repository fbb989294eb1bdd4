"""Pictures of data as SVG in text: lines, points, bands and bars between axes. No script, no font, no id.

Colours are classes (`templates/report/plot.css`), so a picture follows the page into the dark and onto paper. A line
of many points is drawn by the least and the greatest of each column of pixels, so no peak is lost.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.report.axes import FINE, LETTER, Axis, Placed, framed, grid, text_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

READ, FIT, COMMAND, NOISE = 0, 1, 2, 3
"""Colours of what was measured, of a model, of what was asked for, and of what chance gives."""
CELL = 2.0
"""Points that fall into one square of such sides are one [px]."""
_BIG = 10 * FINE
"""So far outside of the picture a line may go, in its widths: it is cut there, and its slope at the edge is kept."""


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


def svg(chart: Chart) -> str:
    """A picture as one `<svg>` element."""
    legend = [(mark.label, mark) for mark in chart.marks if mark.label]
    x_all, y_all = _extent(chart)
    y_axis = Placed.of(chart.y, y_all)
    left = 26.0 + LETTER * max((len(text) for _, text in y_axis.ticks), default=1)
    rows = _legend_rows([label for label, _ in legend], chart.width - left)
    top = 6.0 + 15.0 * (max(rows, default=-1) + 1)
    x_axis = Placed.of(chart.x, x_all)
    wide, high = chart.width - left - 10.0, chart.height - 44.0
    height = top + high + 38.0
    body = [
        *grid(x_axis, y_axis, left, top, wide, high),
        *_legend(legend, rows, left),
        _field(chart.marks, x_axis, y_axis, left, top, wide, high),
    ]
    return framed(chart.title, chart.width, height, body)


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
        yield f'<text x="{at + 22:.1f}" y="{y + 4:.1f}">{text_of(label)}</text>'
        at += 36.0 + LETTER * len(label)


def _field(
    marks: Sequence[Mark], x: Placed, y: Placed, left: float, top: float, wide: float, high: float
) -> str:
    """What is drawn, in a window of its own that cuts what sticks out."""
    w, h = wide * FINE, high * FINE
    parts = "".join(_drawn(mark, x, y, wide, high) for mark in marks)
    return (
        f'<svg x="{left:.1f}" y="{top:.1f}" width="{wide:.1f}" height="{high:.1f}" '
        f'viewBox="0 0 {w:.0f} {h:.0f}" preserveAspectRatio="none">{parts}</svg>'
    )


def _drawn(mark: Mark, x: Placed, y: Placed, wide: float, high: float) -> str:
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
