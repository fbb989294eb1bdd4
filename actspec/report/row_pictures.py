"""Pictures with a name a row: values with their intervals, and sums of parts as bars."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from actspec.diagnostics import one_line, shortened
from actspec.report.axes import LETTER, Axis, Placed, framed, grid, text_of


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
    placed = Placed.of(axis, (min(given), max(given)) if given else (0.0, 1.0), room=0.06)
    left = 14.0 + LETTER * max((len(name) for name in names), default=1)
    compared = any(row.other is not None for row in rows)
    top, wide, high = (22.0 if compared else 6.0), width - left - 14.0, 20.0 * len(rows) + 4.0
    body = list(grid(placed, None, left, top, wide, high))
    if compared:
        body.append(f'<path class="k2 diamond" d="{_diamond(left + 6, 11)}"/>')
        body.append(f'<text x="{left + 15:.0f}" y="15">{text_of(other)}</text>')
    for place, (row, name) in enumerate(zip(rows, names, strict=True)):
        y = top + 20.0 * place + 12.0
        body.append(f'<text x="{left - 7:.0f}" y="{y + 4:.0f}" class="end">{text_of(name)}</text>')
        if row.other is not None:
            body.append(
                f'<path class="k2 diamond" d="{_diamond(left + wide * placed.share(row.other), y)}"/>'
            )
        if row.value is None:
            # Beside the diamond, not across it.
            crowded = row.other is not None and placed.share(row.other) < 0.5
            end = ' class="end faint"' if crowded else ' class="faint"'
            at = left + wide - 6 if crowded else left + 6
            body.append(f'<text x="{at:.0f}" y="{y + 4:.0f}"{end}>{text_of(shortened(row.note, 40))}</text>')
            continue
        if row.low is not None and row.high is not None:
            a, b = (left + wide * placed.share(v) for v in (row.low, row.high))
            body.append(
                f'<path class="c0 thick" d="M{a:.1f} {y:.1f}H{b:.1f}M{a:.1f} {y - 5:.1f}v10M{b:.1f} {y - 5:.1f}v10"/>'
            )
        body.append(
            f'<circle class="k0" cx="{left + wide * placed.share(row.value):.1f}" cy="{y:.1f}" r="3"/>'
        )
    return framed(title, width, top + high + 38.0, body)


@dataclass(frozen=True, slots=True)
class Stacks:
    """Sums of parts above 0, one bar a row.

    Attributes:
        title: What it shows.
        axis: Below.
        rows: Name and parts of each, from top to bottom.
        parts: What the parts are, for the legend; at most five.
        width: [px].
    """

    title: str
    axis: Axis
    rows: Sequence[tuple[str, Sequence[float]]]
    parts: Sequence[str]
    width: int = 420


def stacks(chart: Stacks, named: int = 30) -> str:
    """Sums of parts as one `<svg>` element.

    Args:
        chart: What is drawn.
        named: Most letters of a name; longer ones are cut.
    """
    title, axis, rows, parts, width = chart.title, chart.axis, chart.rows, chart.parts, chart.width
    names = [shortened(one_line(name), named) for name, _ in rows]
    most = max((sum(values) for _, values in rows), default=0.0)
    placed = Placed.of(replace(axis, low=0.0), (0.0, most if most > 0.0 else 1.0))
    left = 14.0 + LETTER * max((len(name) for name in names), default=1)
    top, wide, high = 22.0, width - left - 14.0, 20.0 * len(rows) + 4.0
    body = list(grid(placed, None, left, top, wide, high))
    x = left
    for place, part in enumerate(parts):
        body.append(f'<rect class="f{place}" x="{x:.0f}" y="6" width="10" height="10"/>')
        body.append(f'<text x="{x + 14:.0f}" y="15">{text_of(part)}</text>')
        x += 26.0 + LETTER * len(part)
    for row, ((_, values), name) in enumerate(zip(rows, names, strict=True)):
        y, at = top + 20.0 * row + 5.0, 0.0
        body.append(f'<text x="{left - 7:.0f}" y="{y + 11:.0f}" class="end">{text_of(name)}</text>')
        for place, value in enumerate(values):
            a, b = (left + wide * placed.share(v) for v in (at, at + value))
            if b - a > 0.05:
                body.append(
                    f'<rect class="f{place}" x="{a:.1f}" y="{y:.1f}" width="{b - a:.1f}" height="14"/>'
                )
            at += value
    return framed(title, width, top + high + 38.0, body)


def _diamond(x: float, y: float) -> str:
    return f"M{x:.1f} {y - 5:.1f}l5 5-5 5-5-5z"
