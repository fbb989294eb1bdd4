"""An evaluation of a network as one page: torque beside what was read, errors, motion in MuJoCo, and the grade."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import actspec
from actspec.fields import units_of
from actspec.laws.network import NetworkLaw
from actspec.learn.closed_loop import HORIZON
from actspec.learn.evaluate import FAIR, GOOD, Evaluation, JointErrors, predicted
from actspec.learn.windows import Dataset, Track
from actspec.report.axes import Axis, plot_style
from actspec.report.page import figure, fold, plain, plain_table, whole
from actspec.report.plot import FIT, READ, Bars, Chart, Line, Rule, svg
from actspec.sysid.figures import Bounds
from actspec.units import format_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SHOWN = 2.0
"""Time of a joint's torque that is shown [s]."""
BINS = 41
"""Bars of a histogram."""
COLOURS = {"network": FIT, "dc_motor": 2, "ideal_pd": 3}


def evaluate_page(found: Evaluation, data: Dataset, law: NetworkLaw, path: str) -> str:
    """The page.

    Args:
        found: The evaluation.
        data: What it was judged on.
        law: The network.
        path: Of its manifest.
    """
    return whole(f"network {path}", _body(found, data, law, path), (plot_style(),))


def _body(found: Evaluation, data: Dataset, law: NetworkLaw, path: str) -> Iterator[str]:
    unit = units_of(data.actuators[0].kind).torque
    yield f"<h1>Network {plain(path)}</h1>"
    logs = ", ".join(dict.fromkeys(track.log.path for track in data.tracks))
    yield f"<p>Judged on {plain(logs)}. Grade: <b>{found.grade}</b>, that of its worst joint.</p>"
    yield from plain_table(*_table(found, unit), right=tuple(range(1, 5 + len(found.baselines))))
    shares = [
        f"below {100 * most:g} % of the effort limit and R2 above {least:g}" for most, least in (GOOD, FAIR)
    ]
    yield f"<p>Good: RMSE {shares[0]}; fair: {shares[1]}.</p>"
    if found.outside is not None:
        share = format_number(100.0 * found.outside["any"], 3)
        yield f"<p>{share} % of the rows lie outside of the range that it was trained on.</p>"
    yield from _motion(found, data)
    worst = max(found.joints, key=lambda joint: joint.errors.relative_error or 0.0)
    for joint in found.joints:
        actuator = next(a for a in data.actuators if a.joint == joint.joint)
        tracks = [t for t in data.tracks if t.joint == joint.joint and len(t.rows)]
        torques = predicted(law, tracks, Bounds.of(actuator))
        title = f"{joint.joint}: {joint.grade}"
        yield from fold(title, _joint(joint, tracks, torques, unit), shown=joint is worst)
    yield f"<footer>actspec {actspec.__version__}</footer>"


def _table(found: Evaluation, unit: str) -> tuple[list[str], list[list[str]]]:
    """Heads, and a row a joint, the last of all."""
    bases = [f"RMSE of {name} [{unit}]" for name in found.baselines]
    heads = ["joint", f"RMSE [{unit}]", "relative", f"worst [{unit}]", "R2", *bases, "grade"]
    rows = []
    for name, e, of, grade in (
        *((j.joint, j.errors, j.baselines, j.grade) for j in found.joints),
        ("all", found.overall, found.baselines, found.grade),
    ):
        relative = "-" if e.relative_error is None else f"{100 * e.relative_error:.3g} %"
        r2 = "-" if e.r2 is None else format_number(e.r2, 4)
        others = [format_number(of[b].rmse, 3) for b in found.baselines]
        rows.append([name, format_number(e.rmse, 3), relative, format_number(e.worst, 3), r2, *others, grade])
    return heads, rows


def _motion(found: Evaluation, data: Dataset) -> Iterator[str]:
    """How far rollouts drift from the log."""
    import numpy as np

    if found.closed_loop is None:
        yield f"<p>No closed loop: {plain(found.why_not or '')}</p>"
        return
    unit = units_of(data.actuators[0].kind).position
    marks = [
        # One law lies on the other where no torque-speed line acts: the one below is seen between the dashes.
        Line(
            np.linspace(0.0, HORIZON, len(rmse) + 1)[1:],
            rmse,
            name,
            COLOURS[name],
            "dashed" if name == "ideal_pd" else "",
        )
        for name, rmse in found.growth.items()
    ]
    title = f"Position error of rollouts in MuJoCo, {HORIZON:g} s each"
    said = ", ".join(
        f"{name} {format_number(value, 3)} {unit}"
        for name, value in found.closed_loop.items()
        if value is not None
    )
    chart = Chart(title, Axis("time since the start", "s"), Axis("RMSE", unit), marks)
    yield from figure(svg(chart), title, f"Root mean square over all: {said}.")


def _joint(joint: JointErrors, tracks: list[Track], torques: list[Array], unit: str) -> Iterator[str]:
    """Torque where the network is worst, and all its errors."""
    import numpy as np

    lefts = [torque - t.torque[t.rows] for torque, t in zip(torques, tracks, strict=True)]
    which = max(range(len(lefts)), key=lambda k: float(np.abs(lefts[k]).max()))
    track, rows = tracks[which], tracks[which].rows
    at = track.time[rows[int(np.abs(lefts[which]).argmax())]]
    near = np.abs(track.time[rows] - at) <= 0.5 * SHOWN
    time = track.time[rows][near]
    marks = [
        Line(time, track.torque[rows][near], "log", READ, broad=True),
        Line(time, torques[which][near], "network", FIT, "dashed"),
    ]
    title = f"{joint.joint}: torque around the worst row"
    words = f"{track.log.path}, {time[0]:.4g} to {time[-1]:.4g} s; worst {format_number(joint.errors.worst, 3)} {unit}."
    yield '<div class="grid">'
    yield from figure(svg(Chart(title, Axis("time", "s"), Axis("torque", unit), marks)), title, words)
    left = np.concatenate(lefts)
    # One far row makes no flat picture; it is counted in the last bar.
    end = float(np.quantile(np.abs(left), 0.999)) or 1.0
    edges = np.linspace(-end, end, BINS + 1)
    heights, _ = np.histogram(np.clip(left, -end, end), edges)
    marks_of: list[Bars | Rule] = [Bars(edges, heights / len(left) * 100.0), Rule(0.0, upright=True)]
    title = f"{joint.joint}: network less log"
    rmse = format_number(joint.errors.rmse, 3)
    words = f"{len(left)} rows, RMSE {rmse} {unit}; the outermost bars hold what is beyond."
    chart = Chart(title, Axis("error", unit), Axis("share of the rows", "%"), marks_of)
    yield from figure(svg(chart), title, words)
    yield "</div>"
