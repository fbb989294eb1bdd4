"""Pictures of a joint in a log: as it was read, and as the fitted joint moves."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from actspec.fields import units_of
from actspec.report.axes import Axis
from actspec.report.page import figure, plain
from actspec.report.plot import COMMAND, FIT, NOISE, READ, Band, Bars, Chart, Line, Mark, Rule, svg
from actspec.report.sysid_answers import Loop, bode, friction_cloud, step_answers
from actspec.sysid.recording import scatter
from actspec.sysid.replay import Replay

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

LAGS = 100
"""Most rows between two residuals that are compared."""
BINS = 41
"""Bars of a histogram."""


def pictures(one: Replay, loop: Loop | None = None, *, named: bool) -> Iterator[str]:
    """All of a joint in a log.

    Args:
        one: The joint and the log.
        loop: What the results say of the closed loop.
        named: Whether to say which log it is.
    """
    if named:
        yield f"<h3>{plain(one.recording.log.path)}</h3>"
    yield '<div class="grid">'
    yield from _seconds(one)
    yield from bode(one, loop)
    yield from step_answers(one, loop)
    yield from friction_cloud(one)
    yield from _residuals(one)
    yield "</div>"


def _unit(one: Replay, signal: str) -> str:
    found: str = getattr(units_of(one.recording.kind), signal)
    return found


def _seconds(one: Replay) -> Iterator[str]:
    """The worst stretch, and one in the middle of all."""
    ranked = one.ranked()
    chosen = [("Worst stretch", ranked[-1])]
    if len(ranked) > 1:
        chosen.append(("Typical stretch", ranked[(len(ranked) - 1) // 2]))
    for words, piece in chosen:
        start = int(one.starts[piece])
        yield from _overlay(one, words, "position", start)
    if "torque" in one.model:
        yield from _overlay(one, "Worst stretch", "torque", int(one.starts[ranked[-1]]))


def _overlay(one: Replay, words: str, signal: str, start: int) -> Iterator[str]:
    rows = slice(start, start + one.rows)
    time = one.recording.time[rows]
    marks: list[Mark] = []
    if signal == "position":
        marks.append(Line(time, one.recording.command[rows], "command", COMMAND, "dotted", stairs=True))
    marks.append(Line(time, one.recording.measured[signal][rows], "log", READ, broad=True))
    marks.append(Line(time, one.model[signal][rows], one.name, FIT, "dashed"))
    unit = _unit(one, signal)
    size = _rms(one.residual(signal)[rows])
    title = f"{words}: {signal}"
    said = f"{time[0]:.4g} to {time[-1]:.4g} s; log less {one.name} {size:.3g} {unit} (root mean square)."
    yield from figure(svg(Chart(title, Axis("time", "s"), Axis(signal, unit), marks)), title, said)


def _residuals(one: Replay) -> Iterator[str]:
    import numpy as np

    left = one.residual("position")
    good = left[np.isfinite(left)]
    size, most, unit = _rms(left), float(np.abs(good).max()), _unit(one, "position")
    title = f"Position: log less {one.name}"
    noise = scatter(one.recording.measured["position"], one.recording.time)
    times = f", {size / noise:.3g} times the noise of the readings" if noise > 0 else ""
    said = f"Root mean square {size:.3g} {unit}{times}; largest {most:.3g} {unit}."
    marks: list[Mark] = [Line(one.recording.time, left, "", READ), Rule(0.0)]
    yield from figure(
        svg(Chart(title, Axis("time", "s"), Axis(f"log less {one.name}", unit), marks)), title, said
    )
    yield from _histogram(good, size, unit, f"log less {one.name}")
    yield from _correlogram(left, one.recording.step, f"log less {one.name}")


def _histogram(good: Array, size: float, unit: str, of: str) -> Iterator[str]:
    """How large the residuals are, beside normal noise of the same size."""
    import numpy as np

    wide = min(float(np.abs(good).max()), 5.0 * size) or 1.0
    edges = np.linspace(-wide, wide, BINS + 1)
    heights = np.histogram(good, edges)[0].astype(float)
    at = np.linspace(-wide, wide, 200)
    bell = np.exp(-0.5 * (at / size) ** 2) / (size * math.sqrt(2.0 * math.pi)) * len(good) * 2.0 * wide / BINS
    beyond = float(np.mean(np.abs(good) > 3.0 * size))
    title = "Residuals by size"
    said = f"{100.0 * beyond:.2g} % are beyond three standard deviations, 0.27 % of normal noise are."
    marks: list[Mark] = [
        Bars(edges, heights, of, READ),
        Line(at, bell, "normal noise", FIT, "dashed"),
    ]
    yield from figure(svg(Chart(title, Axis(of, unit), Axis("rows"), marks)), title, said)


def _correlogram(left: Array, step: float, of: str) -> Iterator[str]:
    """How residuals go together with later ones; gaps count for nothing."""
    import numpy as np

    good = np.isfinite(left)
    filled = np.where(good, left - left[good].mean(), 0.0)
    lags = np.arange(1, min(LAGS, len(left) // 4) + 1)
    power = float(filled @ filled) / max(int(good.sum()), 1)
    found = np.array(
        [
            float(filled[k:] @ filled[:-k]) / max(int((good[k:] & good[:-k]).sum()), 1) / max(power, 1e-300)
            for k in lags.tolist()
        ]
    )
    chance = 1.96 / math.sqrt(max(int(good.sum()), 1))
    time: Array = np.asarray(lags * step, dtype=np.float64)
    band: Array = np.full(len(lags), chance, dtype=np.float64)
    title = "Correlation of the residuals"
    share = float(np.mean(np.abs(found) > chance))
    said = (
        f"Of neighbouring rows {found[0]:.2f}; {100.0 * share:.0f} % of the lags are beyond what chance gives to 5 %. "
        "Intervals are made for correlation within a second."
    )
    marks: list[Mark] = [
        Band(time, -band, band, "chance, 95 %", NOISE),
        Line(time, found, of, READ),
    ]
    x, y = (
        Axis("later by", "s"),
        Axis("correlation", low=min(-0.2, float(found.min())), high=max(1.0, float(found.max()))),
    )
    yield from figure(svg(Chart(title, x, y, marks)), title, said)


def _rms(values: Array) -> float:
    import numpy as np

    good = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(good**2))) if len(good) else 0.0
