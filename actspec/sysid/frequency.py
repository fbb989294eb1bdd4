"""The closed loop of a joint in the frequency domain: averaged spectra, and the second-order system in them.

    q/a = g wn^2 exp(-s delay) / (s^2 + 2 zeta wn s + wn^2),  a held from row to row

Spectra of a log leak from frequency to frequency, and a command that is held comes half a row late. So the system's
own answer to the log's commands, held as they were, goes through the same windows as what was read, and the two cross
spectra are compared: neither leakage nor the hold is left in the figures. Dry friction is no linear system, but its
torque is known but for its size where the joint moves: against the speed. It is a second input, and its size a fifth
figure; with it the others are those of the joint without dry friction.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Collector, Span
from actspec.ir import JointActuator
from actspec.sysid.identified import Indicator, JointFit, Parameter, State, bounded
from actspec.sysid.judge import LATE, VAGUE
from actspec.sysid.recording import SMOOTH, Recording, longest_step, smooth
from actspec.sysid.step import second_order
from actspec.sysid.system import WIDE
from actspec.units import format_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Curve = NDArray[np.complex128]

SEGMENTS = 5
"""Segments of a log without their overlap, which is a half. Chosen: nine spectra tell noise from what follows the
command, and each sees its slowest wave several times."""
SHORTEST, LONGEST = 1.0, 10.0
"""Length of a segment [s]. Chosen: many times what a joint remembers, and short enough for an average."""
LEAST = 64
"""Fewest rows of a segment."""
HOLES = 0.1
"""Longest time without a reading that is bridged by a straight line [s]."""
COHERENT = 0.5
"""Least coherence of a frequency that counts."""
QUIET = 1e-4
"""Least power of the command at a frequency that counts, as a share of its greatest."""
SURE = 1.0 - 1e-6
"""Greatest coherence that counts as such: none is known better than the numbers of a log."""
NOTCH = 1.5
"""Neighbouring frequencies of a Hann window that are not independent, as a factor of the covariance."""
STILL = 0.02
"""Speed below which dry friction does not know its direction, as a share of the greatest."""
FIGURES = ("gain", "rate", "damping", "delay", "hold")
"""Of a loop: g [1], wn [rad/s], zeta [1], delay [s], and dry friction over inertia [rad/s^2 or m/s^2]."""
SEEN = 4.0
"""Standard deviations from which on dry friction is taken to be there."""
STICKS = 0.2
"""Share of what dry friction bends that counts as uncertain. Chosen: where a joint sticks, the sign of its speed does
not say what friction does."""
BENT = (0.01, 0.1)
"""Change of the bandwidth by dry friction that is reported, and from which on it is a warning."""
ALIKE = 0.05
"""Share of the response that the second-order system may leave. Chosen."""
BEYOND = 1.2
"""How far above the log's frequencies a figure may lie, as a factor of the last one."""


@dataclass(frozen=True, slots=True)
class Response:
    """What averaged spectra say of a joint in one log; shape (n,) each, at the frequencies that count.

    Attributes:
        frequency: [Hz].
        value: Position over command [1], complex.
        coherence: Share of the position's power that follows the command.
        averages: Segments that were averaged.
        amplitude: Half the range of the command [rad or m].
    """

    frequency: Array
    value: Curve
    coherence: Array
    averages: int
    amplitude: float

    @property
    def gain(self) -> Array:
        """Of position over command [1]."""
        import numpy as np

        found: Array = np.abs(self.value)
        return found

    @property
    def phase(self) -> Array:
        """Of position over command, unwrapped; negative: late. The hold's half row is in it [rad]."""
        import numpy as np

        found: Array = np.unwrap(np.angle(self.value))
        return found

    @property
    def std(self) -> Array:
        """Of real and of imaginary part of `value`, by the coherence. Source: Bendat, Piersol, Random Data, 9.2."""
        import numpy as np

        sure = np.minimum(self.coherence, SURE)
        found: Array = self.gain * np.sqrt((1.0 - sure) / sure / (2.0 * max(self.averages - 1, 1)))
        return found


@dataclass(frozen=True, slots=True)
class Loop:
    """A second-order system in one or several logs.

    Attributes:
        values: By `FIGURES`; `hold` is 0 where no dry friction shows.
        covariance: Of `gain`, `rate`, `damping`, `delay`, shape (4, 4).
        plain: Values of the system that would do all that dry friction does; the same where none shows.
        left: Share of the response that the system does not explain, frequencies weighted by their certainty.
        fastest: Highest frequency that counted [Hz].
    """

    values: Mapping[str, float]
    covariance: Array
    plain: Mapping[str, float]
    left: float
    fastest: float

    def at(self, frequency: Array) -> Curve:
        """Position over command without hold and dry friction [1], shape (n,), at frequencies [Hz]."""
        import numpy as np

        return _system(2.0 * np.pi * np.asarray(frequency), self.values)


def response(recording: Recording) -> Response | None:
    """Averaged spectra of position over command; None where no stretch is long enough, or nothing follows.

    Args:
        recording: A joint's part of a log.
    """
    spectra = _spectra(recording)
    return None if spectra is None else spectra.found


def loop(recordings: Sequence[Recording]) -> Loop | None:
    """The second-order system of a joint, weighted by coherence.

    Args:
        recordings: The joint's parts of one or several logs.

    Returns: None where the frequencies that count are too few.
    """
    import numpy as np
    from scipy.optimize import least_squares

    spectra = [one for recording in recordings if (one := _spectra(recording)) is not None]
    if sum(len(one.found.frequency) for one in spectra) < 2 * len(FIGURES):
        return None
    fastest = max(float(one.found.frequency[-1]) for one in spectra)
    step = spectra[0].step

    def start(x: Array) -> Array:
        values = _values(x)
        left = []
        for one in spectra:
            rate = 2.0 * np.pi * one.found.frequency
            hold = np.sinc(one.found.frequency * one.step) * np.exp(-0.5j * rate * one.step)
            left.append((hold * _system(rate, values) - one.found.value) / one.found.std)
        return _parts(left)

    def residuals(x: Array, stds: Sequence[Array]) -> Array:
        values = _values(x)
        return _parts(
            [(one.followed(values) - one.found.value) / std for one, std in zip(spectra, stds, strict=True)]
        )

    size = [0.1, 0.1, 0.1, step, 1.0]
    low = [0.0, -math.inf, math.log(1e-3), 0.0, -math.inf]

    def descended(function: Any, x: Array, *given: Any) -> Any:
        n = len(x)
        return least_squares(function, x, x_scale=size[:n], bounds=(low[:n], [math.inf] * n), args=given)

    tried = [
        descended(start, np.array([1.0, math.log(2.0 * math.pi * share * fastest), math.log(0.7), step]))
        for share in (0.2, 0.45, 0.9)
    ]
    x = min(tried, key=lambda one: float(one.cost)).x
    stds = [one.found.std for one in spectra]
    plain = descended(residuals, x, stds)
    best = descended(residuals, np.append(plain.x, 0.0), stds)
    for _ in range(2):
        # What the coherence counts as noise is in part leakage, which both sides have: what is left is the noise.
        stds = [one.std_of(_values(best.x)) for one in spectra]
        best = descended(residuals, best.x, stds)
    covariance = _covariance(best)
    if best.x[4] < SEEN * math.sqrt(covariance[4, 4]):
        stds = [one.std_of(_values(plain.x)) for one in spectra]
        best = plain = descended(residuals, plain.x, stds)
        covariance = _covariance(best)
    grow = np.array([1.0, *np.exp(best.x[1:3]), 1.0])
    covariance = covariance[:4, :4] * np.outer(grow, grow)
    values, bent = _values(best.x), _values(plain.x)
    stuck = np.array([STICKS * (values[name] - bent[name]) for name in FIGURES[:4]])
    whole = _parts([one.found.value / std for one, std in zip(spectra, stds, strict=True)])
    left = math.sqrt(2.0 * float(best.cost) / float(whole @ whole))
    return Loop(values, covariance + np.diag(stuck**2), bent, left, fastest)


@dataclass(frozen=True, slots=True)
class _Spectra:
    """A recording on even rows, and the windows that it is seen through.

    Attributes:
        command: [rad or m], shape (n_row,), as are the next two.
        position: [rad or m].
        against: Sign of the speed, 0 where the joint stands.
        step: Between rows [s].
        runs: Rows without a gap.
        parts: Rows that count.
        rows: Of a segment.
        counts: Which frequencies count, shape (n_frequency,).
        power: Of the command, likewise.
        found: What it says.
    """

    command: Array
    position: Array
    against: Array
    step: float
    runs: list[slice]
    parts: list[slice]
    rows: int
    counts: NDArray[np.bool_] = field(repr=False)
    power: Array = field(repr=False)
    found: Response

    def followed(self, values: Mapping[str, float]) -> Curve:
        """Position over command as the windows would see it of the system [1], shape (n,)."""
        moved = self.moved(values)
        found: Curve = (_cross(self.command, moved, self.parts, self.rows, self.step)[1] / self.power)[
            self.counts
        ]
        return found

    def std_of(self, values: Mapping[str, float]) -> Array:
        """Of real and of imaginary part of the response, by what the system leaves of the position."""
        import numpy as np
        from scipy.ndimage import median_filter

        left = self.position - self.moved(values)
        rest = np.real(_cross(left, left, self.parts, self.rows, self.step)[1])[self.counts]
        rest = np.maximum(median_filter(rest, 5, mode="nearest"), 1e-30)
        power = self.power[self.counts]
        found: Array = np.sqrt(rest / power / (2.0 * max(self.found.averages - 1, 1)))
        return found

    def moved(self, values: Mapping[str, float]) -> Array:
        """What the system does under the held commands [rad or m], shape (n_row,)."""
        import numpy as np

        out = np.empty_like(self.command)
        for run in self.runs:
            given = self.command[run] - self.command[run.start]
            natural, damping = values["rate"], values["damping"]
            out[run] = _held(natural, damping, values["gain"] * natural**2, values["delay"], given, self.step)
            if values["hold"]:
                way = self.against[run]
                way = 0.5 * (way + np.append(way[1:], way[-1]))
                out[run] -= _held(natural, damping, values["hold"], 0.0, way, self.step)
        return out


def _held(natural: float, damping: float, scale: float, delay: float, given: Array, step: float) -> Array:
    """scale / (s^2 + 2 damping natural s + natural^2) of an input that is held from row to row and comes late."""
    import numpy as np
    from scipy.signal import lfilter

    rows = math.floor(delay / step)
    part = delay - rows * step
    y, h = second_order(np.array([step, part, step - part]), natural, damping)
    # What a speed becomes in a row, in position and in speed; and where an input leads from rest, in each part of it.
    along, across = h / natural**2, 1.0 - y - 2.0 * damping * h / natural
    to, speed = scale / natural**2 * y, scale / natural**2 * h
    new = to[2], speed[2]
    old = (1.0 - y[2]) * to[1] + along[2] * speed[1], -h[2] * to[1] + across[2] * speed[1]
    above = np.zeros(4 + rows)
    for first, (position, fast) in ((rows, new), (rows + 1, old)):
        above[first + 1 : first + 3] += (position, along[0] * fast - across[0] * position)
    below = [1.0, y[0] - 1.0 - across[0], (1.0 - y[0]) * across[0] + along[0] * h[0]]
    found: Array = lfilter(above, below, given)
    return found


def _spectra(recording: Recording) -> _Spectra | None:
    import numpy as np

    step = recording.step
    runs, parts = _stretches(recording)
    lengths = [part.stop - part.start for part in parts]
    if not parts:
        return None
    rows = int(np.clip(sum(lengths) / SEGMENTS, SHORTEST / step, LONGEST / step))
    rows = min(rows, max(lengths))
    if rows < LEAST:
        return None
    parts = [part for part, length in zip(parts, lengths, strict=True) if length >= rows]
    command, position, against = _even(recording, runs)
    frequency, both = _cross(command, position, parts, rows, step)
    power = np.real(_cross(command, command, parts, rows, step)[1])
    own = np.real(_cross(position, position, parts, rows, step)[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        coherence = np.abs(both) ** 2 / (power * own)
        value = both / power
    counts = (power > QUIET * power.max()) & (frequency < 0.4 / step) & (coherence > COHERENT)
    # What the mean that is taken out touches.
    counts[:2] = False
    if not counts.any():
        return None
    found = Response(
        frequency[counts],
        value[counts],
        coherence[counts],
        sum(_segments(part, rows) for part in parts),
        0.5 * float(np.ptp(command)),
    )
    return _Spectra(command, position, against, step, runs, parts, rows, counts, power, found)


def _segments(part: slice, rows: int) -> int:
    return int((part.stop - part.start - rows // 2) // (rows - rows // 2))


def _cross(one: Array, other: Array, parts: Sequence[slice], rows: int, step: float) -> tuple[Array, Curve]:
    """Frequencies [Hz], and the cross spectrum averaged over all segments of all parts."""
    from scipy.signal import csd

    total: Any = 0.0
    frequency: Any = None
    count = 0
    for part in parts:
        mine = _segments(part, rows)
        frequency, found = csd(one[part], other[part], fs=1.0 / step, nperseg=rows, noverlap=rows // 2)
        total, count = total + mine * found, count + mine
    return frequency, total / count


def _stretches(recording: Recording) -> tuple[list[slice], list[slice]]:
    """Rows without a gap; and those among them while the command moves, without long holes."""
    import numpy as np

    moves = np.flatnonzero(np.diff(recording.command))
    active = np.zeros(len(recording.time), dtype=bool)
    active[max(moves[0] - 1, 0) : moves[-1] + round(0.5 / recording.step)] = True
    lost = ~np.isfinite(recording.measured["position"])
    edges = np.flatnonzero(np.diff(np.concatenate([[False], lost, [False]]).astype(int)))
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        if (end - start) * recording.step > HOLES:
            active[start:end] = False
    gaps = np.flatnonzero(np.diff(recording.time) > longest_step(recording.time)) + 1
    bounds = [0, *gaps.tolist(), len(recording.time)]
    runs = [slice(first, last) for first, last in pairwise(bounds)]
    parts = []
    for run in runs:
        edges = (
            np.flatnonzero(np.diff(np.concatenate([[False], active[run], [False]]).astype(int))) + run.start
        )
        parts += [slice(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    return runs, parts


def _even(recording: Recording, runs: Sequence[slice]) -> tuple[Array, Array, Array]:
    """Command, position and direction on even rows; a row that came late is put back between its neighbours."""
    import numpy as np

    time, read = recording.time, recording.measured["position"]
    good = np.isfinite(read)
    even = np.concatenate(
        [np.linspace(time[run.start], time[run.stop - 1], run.stop - run.start) for run in runs]
    )
    velocity = recording.measured.get("velocity")
    speed = recording.velocity if velocity is None else smooth(time, velocity, SMOOTH)
    slow = STILL * float(np.abs(speed).max())
    return (
        np.interp(even, time, recording.command),
        np.interp(even, time[good], read[good]),
        np.clip(speed / slow, -1.0, 1.0),
    )


def _system(rate: Array, values: Mapping[str, float]) -> Curve:
    """The system at angular frequencies [rad/s]."""
    import numpy as np

    s, natural = 1j * rate, values["rate"]
    below = s**2 + 2.0 * values["damping"] * natural * s + natural**2
    found: Curve = values["gain"] * natural**2 * np.exp(-s * values["delay"]) / below
    return found


def _values(x: Array) -> dict[str, float]:
    """Figures of a descent, in which rate and damping are logarithms."""
    found = dict.fromkeys(FIGURES, 0.0) | {name: float(v) for name, v in zip(FIGURES, x, strict=False)}
    return found | {name: math.exp(found[name]) for name in ("rate", "damping")}


def _parts(left: Sequence[Curve]) -> Array:
    import numpy as np

    found: Array = np.concatenate([part for curve in left for part in (curve.real, curve.imag)])
    return found


def _covariance(found: Any) -> Array:
    """Of a descent, by the noise or by what is left, whichever is more."""
    import numpy as np

    left = 2.0 * float(found.cost) / max(len(found.fun) - NOTCH * len(found.x), 1.0)
    covariance: Array = np.linalg.pinv(found.jac.T @ found.jac) * NOTCH * max(left, 1.0)
    return covariance


def bandwidth(values: Mapping[str, float]) -> float:
    """Where the system's gain is 3 dB below that at rest [Hz]."""
    part = 1.0 - 2.0 * values["damping"] ** 2
    return values["rate"] / (2.0 * math.pi) * math.sqrt(part + math.sqrt(part**2 + 1.0))


def phase_margin(values: Mapping[str, float]) -> float:
    """Of the position's loop, T/(1 - T), the command's delay outside of it [rad]; NaN: its gain is below 1 everywhere.

    T is the system without delay, so T/(1 - T) = g wn^2 / (s^2 + 2 zeta wn s + (1 - g) wn^2).
    """
    still, damping = 1.0 - values["gain"], values["damping"]
    half = 2.0 * damping**2 - still
    inner = half**2 - (still**2 - values["gain"] ** 2)
    crossing = -half + math.sqrt(inner) if inner >= 0.0 else -1.0
    if crossing <= 0.0:
        return math.nan
    return math.pi - math.atan2(2.0 * damping * math.sqrt(crossing), still - crossing)


def judged(actuator: JointActuator, recordings: Sequence[Recording], out: Collector) -> JointFit | None:
    """What the spectra of a joint's logs say; None where they say nothing, with the reason.

    Args:
        actuator: The joint.
        recordings: Its parts of the logs.
        out: Takes what is wrong.
    """
    name, place = actuator.joint, Span(recordings[0].log.path)
    found = loop(recordings)
    if found is None:
        message = "too few frequencies of the command show in the position for a response"
        help = "send a chirp or a multisine of ten seconds or more: `actspec sysid design`"
        out.warning("SYS051", message, where=name, span=place, help=help)
        return None
    if found.left > ALIKE:
        message = (
            f"a second-order system leaves {found.left:.0%} of the response: more than a PD moves the joint"
        )
        help = "a torque at its limit, a low-pass, play or a soft link: try a smaller command, or --method rollout"
        out.warning("SYS054", message, where=name, span=place, help=help)
    _bent(name, place, found, out)
    figures = {
        "closed_loop_bandwidth": (bandwidth, "Hz"),
        "natural_frequency": (lambda values: values["rate"] / (2.0 * math.pi), "Hz"),
        "damping_ratio": (lambda values: values["damping"], "1"),
        "phase_margin": (phase_margin, "rad"),
        "static_gain": (lambda values: values["gain"], "1"),
    }
    shown = []
    for figure, (function, unit) in figures.items():
        value, std = _derived(found, function)
        why = _untold(found, figure, value, std)
        shown.append(Indicator(figure, None if why else value, None if why else std, unit, why))
        if why:
            out.info("SYS053", f"{figure} has no value: {why}", where=name, span=place)
    return JointFit(name, actuator.kind, (_delay(found),), (), (), None, None, None, None, tuple(shown))


def _derived(found: Loop, function: Callable[[Mapping[str, float]], float]) -> tuple[float, float]:
    """A figure of a loop, and its standard deviation by differences."""
    import numpy as np

    value, slopes = function(found.values), []
    for i, name in enumerate(FIGURES[:4]):
        away = 0.1 * math.sqrt(found.covariance[i, i])
        slopes.append(
            (function({**found.values, name: found.values[name] + away}) - value) / away if away else 0.0
        )
    slope = np.array(slopes)
    return value, math.sqrt(float(slope @ found.covariance @ slope))


def _untold(found: Loop, figure: str, value: float, std: float) -> str:
    """Why a figure is not told; "": it is."""
    if math.isnan(value):
        return "the loop's gain is below 1 at every frequency"
    if not std < VAGUE * abs(value):
        return f"its standard deviation would be {std / abs(value):.0%} of it"
    highest = (
        bandwidth(found.values)
        if figure == "closed_loop_bandwidth"
        else found.values["rate"] / (2.0 * math.pi)
    )
    if figure in ("closed_loop_bandwidth", "natural_frequency") and highest > BEYOND * found.fastest:
        return f"it lies above {found.fastest:.3g} Hz, where the log's frequencies end"
    return ""


def _delay(found: Loop) -> Parameter:
    value, std = found.values["delay"], math.sqrt(found.covariance[3, 3])
    if std > LATE:
        why = f"its standard deviation would be {format_number(std, 2)} s"
        return Parameter("delay", State.UNIDENTIFIABLE, None, None, None, None, "s", why)
    return bounded("delay", value, std, value - WIDE * std, value + WIDE * std, "s")


def _bent(name: str, place: Span, found: Loop, out: Collector) -> None:
    """Report how far dry friction bends the response."""
    measured, free = bandwidth(found.plain), bandwidth(found.values)
    bend = measured / free - 1.0
    damping = found.plain["damping"] / found.values["damping"] - 1.0
    if not found.values["hold"] or max(abs(bend), abs(damping)) < BENT[0]:
        return
    message = (
        f"dry friction bends the response: as measured the bandwidth is {measured:.3g} Hz ({bend:+.1%}) and the "
        f"damping ratio {found.plain['damping']:.3g} ({damping:+.1%}); the figures are those without it"
    )
    report = out.warning if max(abs(bend), abs(damping)) > BENT[1] else out.info
    help = "a larger command is bent less; --method rollout fits the friction"
    report("SYS052", message, where=name, span=place, help=help)
