"""Pictures of how a joint answers: by frequency, to steps, and what friction takes; the log beside the fitted joint."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.fields import units_of
from actspec.report.axes import Axis
from actspec.report.page import figure, fold, plain_table
from actspec.report.plot import COMMAND, FIT, NOISE, READ, Band, Chart, Line, Mark, Points, Rule, svg
from actspec.spec.results import JointResult
from actspec.sysid.frequency import Response, response
from actspec.sysid.replay import Replay
from actspec.sysid.step import Step, steps, unit_step

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MOST_STEPS = 12
"""Steps that are drawn over each other. Chosen: more are a blot."""
ROWS = 12
"""Rows of a table beside a picture."""
SPEEDS = 24
"""Stretches of speed in which friction is averaged."""
LEAST = 10
"""Fewest rows in one of them."""


@dataclass(frozen=True, slots=True)
class Loop:
    """The closed loop as a system of second order, by `--method frequency` or `step`.

    Attributes:
        natural: Natural frequency [rad/s].
        damping: Its damping ratio [1].
        gain: At rest [1]; None: that of the steps.
        delay: [s]; None: that of the steps.
    """

    natural: float
    damping: float
    gain: float | None = None
    delay: float | None = None


def loop_of(result: JointResult) -> Loop | None:
    """What the results say of the closed loop; None: nothing, as those of rollouts."""
    told = {name: item.value for name, item in result.diagnostics.items()}
    natural, damping = told.get("natural_frequency"), told.get("damping_ratio")
    if natural is None or damping is None:
        return None
    delay = None if result.delay is None else result.delay.value
    return Loop(2.0 * math.pi * natural, damping, told.get("static_gain"), delay)


def _answer(loop: Loop, frequency: Array, step: float) -> NDArray[np.complex128]:
    """Position over a command that is held from row to row [1]."""
    import numpy as np

    s = 2j * np.pi * frequency
    held = np.sinc(frequency * step) * np.exp(-s * (0.5 * step + (loop.delay or 0.0)))
    gain = 1.0 if loop.gain is None else loop.gain
    system = loop.natural**2 / (s**2 + 2.0 * loop.damping * loop.natural * s + loop.natural**2)
    found: NDArray[np.complex128] = gain * held * system
    return found


def bode(one: Replay, loop: Loop | None = None) -> Iterator[str]:
    """Gain, phase and coherence of position over command; and of the loop, where that was fitted to spectra."""
    import numpy as np

    read, fit = response(one.recording), response(one.simulated)
    if read is None or fit is None:
        return
    x = Axis("frequency", "Hz", log=True)
    decibel = 20.0 / np.log(10.0)
    with np.errstate(divide="ignore"):
        gain, of_fit = decibel * np.log(read.gain), decibel * np.log(fit.gain)
    wide = 1.96 * read.std / read.gain
    fitted: list[list[Mark]] = [[], []]
    if loop is not None and loop.gain is not None:
        value = _answer(loop, read.frequency, one.recording.step)
        turns = np.unwrap(np.angle(value))
        for marks_of, line in zip(
            fitted, (decibel * np.log(np.abs(value)), turns * 180.0 / np.pi), strict=True
        ):
            marks_of.append(Line(read.frequency, line, "second order", COMMAND))
    marks: list[Mark] = [
        Band(read.frequency, gain - decibel * wide, gain + decibel * wide, "95 %", NOISE),
        Line(read.frequency, gain, "log", READ, broad=True),
        Line(fit.frequency, of_fit, one.name, FIT, "dashed"),
        *fitted[0],
        Rule(-3.0),
    ]
    low, high = _ends(gain)
    said = f"Position over command, {read.averages} segments averaged; the line is at -3 dB."
    title = "Bode: gain"
    yield from figure(svg(Chart(title, x, Axis("gain", "dB", low=low, high=high), marks)), title, said)
    turn = 180.0 / np.pi
    phase, late = turn * read.phase, turn * fit.phase
    marks = [
        Band(read.frequency, phase - turn * wide, phase + turn * wide, "95 %", NOISE),
        Line(read.frequency, phase, "log", READ, broad=True),
        Line(fit.frequency, late, one.name, FIT, "dashed"),
        *fitted[1],
    ]
    low, high = _ends(phase)
    title = "Bode: phase"
    said = "Negative: late. The half row by which a held command is late is in it."
    yield from figure(svg(Chart(title, x, Axis("phase", "deg", low=low, high=high), marks)), title, said)
    title = "Coherence"
    marks = [
        Line(read.frequency, read.coherence, "log", READ, broad=True),
        Line(fit.frequency, fit.coherence, one.name, FIT, "dashed"),
    ]
    said = "Share of the position's power that follows the command; noise, friction and limits take from it."
    picture = svg(Chart(title, x, Axis("coherence", low=0.0, high=1.02), marks))
    table = _response_table(read, fit, gain, of_fit, phase, late, one.name)
    yield from figure(picture, title, said, fold("Gain and phase as a table", table, shown=False))


def _ends(values: Array) -> tuple[float, float]:
    """Of an axis, by the log: what noise makes of its fastest frequencies does not choose it."""
    import numpy as np

    low, high = (float(v) for v in np.percentile(values, [0.5, 99.5]))
    away = max(0.15 * (high - low), 1.0)
    return low - away, high + away


def _response_table(
    read: Response, fit: Response, gain: Array, of_fit: Array, phase: Array, late: Array, name: str
) -> Iterator[str]:
    import numpy as np

    wanted = np.geomspace(read.frequency[0], read.frequency[-1], ROWS)
    rows = []
    for i in dict.fromkeys(int(np.argmin(np.abs(read.frequency - f))) for f in wanted):
        j = int(np.argmin(np.abs(fit.frequency - read.frequency[i])))
        near = abs(fit.frequency[j] / read.frequency[i] - 1.0) < 1e-6
        rows.append(
            [
                f"{read.frequency[i]:.3g}",
                f"{gain[i]:.2f}",
                f"{of_fit[j]:.2f}" if near else "",
                f"{phase[i]:.1f}",
                f"{late[j]:.1f}" if near else "",
                f"{read.coherence[i]:.3f}",
            ]
        )
    heads = [
        *(
            "frequency [Hz]",
            "gain, log [dB]",
            f"{name} [dB]",
            "phase, log [deg]",
            f"{name} [deg]",
            "coherence",
        )
    ]
    return plain_table(heads, rows, range(6))


def step_answers(one: Replay, loop: Loop | None = None) -> Iterator[str]:
    """Steps laid over each other, and what is read off each; and the loop, where that was fitted to steps."""
    import numpy as np

    gains = (one.figures["kp"], one.figures["kd"])
    found = [step for step in steps(one.recording, one.bounds, gains) if step.left_out is None]
    if not found:
        return
    of_fit = {step.row: step for step in steps(one.simulated, one.bounds, gains)}
    marks: list[Mark] = []
    for step in found[:MOST_STEPS]:
        first = step is found[0]
        marks.append(Line(step.time, step.answer, "log" if first else "", READ, broad=True))
        if step.row in of_fit:
            other = of_fit[step.row]
            marks.append(Line(other.time, other.answer, one.name if first else "", FIT, "dashed"))
    alike = [(step.final, step.delay) for step in found if step.final is not None and step.delay is not None]
    if loop is not None and loop.gain is None and alike:
        final, delay = (float(np.median(values)) for values in zip(*alike, strict=True))
        longest = max((step.time for step in found), key=len)
        answer = final * unit_step(longest - delay, loop.natural, loop.damping)
        marks.append(Line(longest, answer, "second order", COMMAND))
    marks.append(Rule(1.0))
    title = "Steps"
    shown = f"{MOST_STEPS} of {len(found)}" if len(found) > MOST_STEPS else f"{len(found)}"
    said = f"{shown} laid over each other, each as a share of its own size; the line is the command."
    picture = svg(Chart(title, Axis("time after the command", "s"), Axis("answer"), marks))
    yield from figure(
        picture, title, said, fold("Steps as a table", _step_table(one, found, of_fit), shown=False)
    )


def _step_table(one: Replay, found: Sequence[Step], of_fit: dict[int, Step]) -> Iterator[str]:
    rows = []
    for step in found[:MOST_STEPS]:
        other = of_fit.get(step.row)
        cells = [f"{one.recording.time[step.row]:.4g}", f"{step.size:.3g}"]
        for name in ("rise_time", "overshoot", "settling_time", "steady_state_error"):
            for source in (step, other):
                value = None if source is None else getattr(source, name)
                cells.append("-" if value is None else f"{value:.3g}")
        rows.append(cells)
    units = units_of(one.recording.kind)
    heads = ["at [s]", f"size [{units.position}]"]
    for name, unit in (
        ("rise", "s"),
        ("overshoot", "1"),
        ("settling", "s"),
        ("error at rest", units.position),
    ):
        heads += [f"{name} [{unit}]", one.name]
    return plain_table(heads, rows, range(len(heads)))


@dataclass(frozen=True, slots=True)
class Taken:
    """What friction takes, by row; shape (n,).

    Attributes:
        speed: Of the fitted joint [rad/s or m/s].
        torque: Torque that was read, less what the links need at the fitted joint's course [N*m or N].
    """

    speed: Array
    torque: Array


def taken(one: Replay) -> Taken | None:
    """Friction by row; None where no torque before friction was read.

    Args:
        one: A joint in a log.
    """
    import numpy as np

    if "torque" not in one.recording.measured or one.recording.log.sidecar.torque == "joint":
        return None
    # What the fitted joint's links need is its drive's torque less its friction.
    torque = one.residual("torque") + one.spread["friction"]
    speed = one.spread["velocity"]
    good = np.isfinite(torque) & np.isfinite(speed) & (speed != 0.0)
    return Taken(speed[good], torque[good])


def friction_law(one: Replay, speed: Array) -> Array:
    """Friction of the fitted joint at speeds, shape (n,) [N*m or N]."""
    import numpy as np

    values = one.figures
    dry = np.full(len(speed), values["coulomb"])
    if values["stribeck_velocity"] > 0.0 and values["static"] > values["coulomb"]:
        more = values["static"] - values["coulomb"]
        dry = dry + more * np.exp(-((speed / values["stribeck_velocity"]) ** 2))
    found: Array = np.sign(speed) * dry + values["viscous"] * speed
    return found


def _means(found: Taken) -> Array:
    """Speed and torque of ranges with as many rows each, on both sides of rest, NaN between them; shape (n, 2)."""
    import numpy as np

    means = []
    for way in (-1.0, 1.0):
        mine = np.flatnonzero(np.sign(found.speed) == way)
        mine = mine[np.argsort(found.speed[mine])]
        count = min(SPEEDS // 2, len(mine) // LEAST)
        for part in np.array_split(mine, count) if count else ():
            means.append([float(found.speed[part].mean()), float(found.torque[part].mean())])
        if way < 0.0:
            means.append([0.0, np.nan])
    return np.array(means)


def friction_cloud(one: Replay) -> Iterator[str]:
    """Torque less inertia and gravity over speed, with the fitted law."""
    import numpy as np

    found = taken(one)
    if found is None or len(found.speed) < LEAST * SPEEDS:
        return
    units = units_of(one.recording.kind)
    means = _means(found)
    # The law jumps at rest: a line of its own on each side.
    fastest = float(np.abs(found.speed).max())
    half = np.linspace(1e-3, 1.0, 100) * fastest
    law_speed = np.concatenate([-half[::-1], [0.0], half])
    law = np.where(law_speed == 0.0, np.nan, friction_law(one, law_speed))
    marks: list[Mark] = [
        Points(found.speed, found.torque, "rows", READ),
        Line(means[:, 0], means[:, 1], "means by speed", NOISE),
        Line(law_speed, law, "law of the fit", FIT, "dashed"),
    ]
    low, high = (float(v) for v in np.percentile(found.torque, [0.2, 99.8]))
    title = "Friction over speed"
    fitted = friction_law(one, means[:, 0])
    away = float(np.sqrt(np.nanmean((means[:, 1] - fitted) ** 2)))
    said = (
        f"Torque that was read, less inertia and gravity. The means are {away:.2g} {units.torque} from the law "
        "(root mean square)."
    )
    lines = [[f"{v:.4g}", f"{t:.4g}", f"{f:.4g}"] for (v, t), f in zip(means, fitted, strict=True) if t == t]
    heads = [f"speed [{units.speed}]", f"friction [{units.torque}]", "law"]
    table = fold("Means as a table", plain_table(heads, lines, range(3)), shown=False)
    y = Axis("friction", units.torque, low=low, high=high)
    yield from figure(svg(Chart(title, Axis("speed", units.speed), y, marks)), title, said, table)
