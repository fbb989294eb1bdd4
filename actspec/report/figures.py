"""Pictures as files: SVG by itself, PNG and PDF through matplotlib, all of the same marks."""

from __future__ import annotations

import csv
import hashlib
import io
import math
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from html import escape
from typing import Any

from actspec.diagnostics import one_line
from actspec.report.axes import Axis, plot_style
from actspec.report.plot import Band, Bars, Chart, Line, Mark, Points, svg
from actspec.report.row_pictures import Stacks, stacks

SUFFIXES = (".svg", ".png", ".pdf")
"""Of pictures that can be written."""
_COLOURS = ("#0072b2", "#d55e00", "#6e7781", "#00805d", "#a8508a")
"""Those of `templates/report/plot.css` on white."""
_DASHES = {"": "-", "dashed": "--", "dotted": ":"}
_WIDTH, _GAP = 520, 14
_PALETTE = (
    ":root { --text: #1f2328; --faint: #59636e; --line: #d1d9e0; --back: #fff; }\n"
    "@media (prefers-color-scheme: dark) {\n"
    "  :root { --text: #e6edf3; --faint: #9198a1; --line: #3d444d; --back: #0d1117; } }\n"
    "rect.paper { fill: var(--back); } text.title { font: 600 12px system-ui, sans-serif; fill: var(--text); }\n"
)


class MatplotlibMissing(ImportError):
    """PNG and PDF need matplotlib, which is not installed."""


def picture_of(chart: Chart | Stacks) -> str:
    """A chart as one `<svg>` element."""
    return svg(chart) if isinstance(chart, Chart) else stacks(chart)


def drawn(charts: Sequence[Chart], path: str) -> bytes:
    """Charts as one file, two beside each other.

    Args:
        charts: At least one.
        path: Its suffix says the format, one of `SUFFIXES`.

    Raises:
        MatplotlibMissing: for PNG and PDF.
    """
    kind = os.path.splitext(path)[1].lower()
    return _svg(charts).encode("utf-8") if kind == ".svg" else _matplotlib(charts, kind[1:])


def _svg(charts: Sequence[Chart | Stacks], beside: str = "") -> str:
    """The charts as SVG; `beside` is the CSV of what they draw, by whose hash actspec knows it again."""
    pictures = [picture_of(chart) for chart in charts]
    sizes = [_size(picture) for picture in pictures]
    rows = [max(high for _, high in sizes[k : k + 2]) + 22.0 for k in range(0, len(sizes), 2)]
    columns = min(2, len(charts))
    width = columns * _WIDTH + (columns + 1) * _GAP
    height = sum(rows) + _GAP * (len(rows) + 1)
    body, top = [], float(_GAP)
    for row, high in enumerate(rows):
        for column in range(min(2, len(charts) - 2 * row)):
            k, x = 2 * row + column, _GAP + column * (_WIDTH + _GAP)
            body.append(
                f'<text class="title" x="{x}" y="{top + 12:.0f}">{escape(one_line(charts[k].title))}</text>'
            )
            # A nested picture would fill the whole one.
            sized = f'class="plot" style="width:{sizes[k][0]:.0f}px;height:{sizes[k][1]:.0f}px"'
            picture = pictures[k].replace('class="plot"', sized, 1)
            body.append(f'<g transform="translate({x} {top + 20:.0f})">{picture}</g>')
        top += high + _GAP
    told = f"; CSV: {hashlib.sha256(beside.encode('utf-8')).hexdigest()}" if beside else ""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height:.0f}" width="{width}" '
        f'height="{height:.0f}">\n<!-- Written by `actspec`{told} -->\n<style>{_PALETTE}{plot_style()}</style>\n'
        '<rect class="paper" width="100%" height="100%"/>\n' + "\n".join(body) + "\n</svg>\n"
    )


def _size(picture: str) -> tuple[float, float]:
    """Width and height of one of our own pictures [px]."""
    found = re.search(r'viewBox="0 0 (\d+) (\d+)"', picture)
    assert found is not None
    return float(found[1]), float(found[2])


def _matplotlib(charts: Sequence[Chart], kind: str) -> bytes:
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.backends.backend_pdf import FigureCanvasPdf
        from matplotlib.figure import Figure
    except ImportError as err:
        raise MatplotlibMissing from err

    count = math.ceil(len(charts) / 2)
    figure = Figure(figsize=(11.0, 2.9 * count), layout="constrained")
    canvas = FigureCanvasPdf(figure) if kind == "pdf" else FigureCanvasAgg(figure)
    for k, chart in enumerate(charts):
        axes = figure.add_subplot(count, min(2, len(charts)), k + 1)
        for mark in chart.marks:
            _draw(axes, mark)
        # Names of strangers are no formulas.
        axes.set_title(_literal(chart.title), fontsize=9, loc="left")
        for axis, of in ((chart.x, "x"), (chart.y, "y")):
            _set_axis(axes, axis, of)
        axes.grid(color="#d1d9e0", linewidth=0.5)
        if any(mark.label for mark in chart.marks):
            axes.legend(fontsize=7, frameon=False, loc="best")
        axes.tick_params(labelsize=8)
    out = io.BytesIO()
    # The same input gives the same bytes.
    stamp = {"CreationDate": None, "Creator": "actspec"} if kind == "pdf" else {"Software": "actspec"}
    canvas.print_figure(out, format=kind, dpi=150, metadata=stamp)
    return out.getvalue()


def _draw(axes: Any, mark: Mark) -> None:
    colour = _COLOURS[mark.colour]
    label = _literal(mark.label) if mark.label else None
    if isinstance(mark, Line):
        width = 2.6 if mark.broad else 1.3
        style = {"color": colour, "linestyle": _DASHES[mark.dash], "linewidth": width, "label": label}
        if mark.stairs:
            axes.step(mark.x, mark.y, where="post", **style)
        else:
            axes.plot(mark.x, mark.y, **style)
    elif isinstance(mark, Points):
        axes.plot(mark.x, mark.y, ".", color=colour, markersize=2.5, alpha=0.6, label=label)
    elif isinstance(mark, Band):
        axes.fill_between(mark.x, mark.low, mark.high, color=colour, alpha=0.3, linewidth=0, label=label)
    elif isinstance(mark, Bars):
        axes.stairs(mark.heights, mark.edges, fill=True, color=colour, alpha=0.35, label=label)
    else:
        line = axes.axvline if mark.upright else axes.axhline
        line(mark.at, color=colour, linewidth=1.0, label=label)


def _set_axis(axes: Any, axis: Axis, of: str) -> None:
    unit = f" [{axis.unit}]" if axis.unit else ""
    getattr(axes, f"set_{of}label")(_literal(axis.label + unit), fontsize=8)
    if axis.log:
        getattr(axes, f"set_{of}scale")("log")
    if axis.low is not None or axis.high is not None:
        getattr(axes, f"set_{of}lim")(axis.low, axis.high)


def _literal(text: str) -> str:
    """Text that matplotlib shows as it is: `$` would begin a formula, and a leading `_` hides a label."""
    shown = one_line(text).replace("$", r"\$")
    return f"\u200b{shown}" if shown.startswith("_") else shown


def files_of(charts: Iterable[tuple[str, str, Chart | Stacks]]) -> Iterator[tuple[str, bytes]]:
    """Each chart as SVG and what it draws as CSV, under names of kind and joint.

    Args:
        charts: Kind, a joint's name and picture of each.
    """
    taken: set[str] = set()
    for kind, joint, chart in charts:
        stem = f"{kind}-{re.sub(r'[^A-Za-z0-9_.-]', '_', joint)[:80]}"
        name = stem
        while name.lower() in taken:
            name = f"{stem}-{len(taken)}"
        taken.add(name.lower())
        rows = _csv(chart)
        yield f"{name}.svg", _svg([chart], rows).encode("utf-8")
        yield f"{name}.csv", rows.encode("utf-8")


def _csv(chart: Chart | Stacks) -> str:
    """Every line and cloud below each other: series, x, y; of sums a row each, with its parts."""
    if isinstance(chart, Stacks):
        out = io.StringIO()
        table = csv.writer(out, lineterminator="\n")
        table.writerow(["joint", *(f"{part} [{chart.axis.unit}]" for part in chart.parts)])
        table.writerows([_name(name), *(f"{value:.7g}" for value in values)] for name, values in chart.rows)
        return out.getvalue()
    axes = [f"{axis.label} [{axis.unit}]" if axis.unit else axis.label for axis in (chart.x, chart.y)]
    out = io.StringIO()
    table = csv.writer(out, lineterminator="\n")
    table.writerow(["series", *axes])
    for mark in chart.marks:
        if isinstance(mark, Line | Points):
            for x, y in zip(mark.x.tolist(), mark.y.tolist(), strict=True):
                table.writerow([_name(mark.label) or "bound", f"{x:.7g}", f"{y:.7g}"])
    return out.getvalue()


def _name(text: str) -> str:
    """A stranger's name as a cell that no spreadsheet takes for a formula."""
    return f"'{one_line(text)}" if text.startswith(("=", "+", "-", "@")) else one_line(text)
