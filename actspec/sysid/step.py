"""Steps in a log, and what each shows: rise, overshoot, settling, what is left, and the second-order system in it.

A command that is held is no approximation of a step, it is one. The answer is taken from where the joint rested before
to where it comes to rest; crossings lie between rows. What cannot be read off an answer has no number: one that is cut
off has no settling time, one in which the drive gave all it can says nothing of its gains.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, listed
from actspec.fields import units_of
from actspec.ir import JointActuator
from actspec.sysid.figures import Bounds
from actspec.sysid.identified import Indicator, JointFit
from actspec.sysid.recording import Recording, longest_step, scatter

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

LEAST_HELD = 0.05
"""Shortest time for which the command is held on both sides of a step [s]."""
LEAST_ROWS = 8
"""Fewest rows of a step."""
LOUD = 100.0
"""Least size of a step in standard deviations of the position's noise. Chosen: two percent of it are then two."""
BAND = 0.02
"""Of settling, as a share of the step."""
RESTED = 0.05
"""Share of the step that the joint may move within the rows before it."""
TAIL = 0.2
"""Last share of a step over which the joint must stand for it to have settled."""
RISE = (0.1, 0.9)
"""From where to where a rise counts, as shares of the step."""
FULL = 0.98
"""Share of what bounds the drive's torque at which it is at its bound."""
SIGNIFICANT = 4.5
"""Standard deviations of the noise that an overshoot must have. Chosen: the greatest of a thousand readings has 3.3."""
LIKE = 0.05
"""Root mean square that the second-order system may leave, as a share of the step. Chosen."""
VAGUE = 0.3
"""Standard deviation of a natural frequency or damping ratio as a share of it, from which on it is not told."""


@dataclass(frozen=True, slots=True)
class Step:
    """One step and what the joint did.

    Attributes:
        row: Of the recording, in which the new command is sent.
        size: Of the command [rad or m].
        time: From that row on [s], shape (n,).
        answer: From where the joint rested, as a share of the command's step [1], likewise.
        left_out: Why it does not count: `too small`, `saturated`, `not at rest before it`; None: it counts.
        cut_off: Whether the next command comes, or the log ends, before the joint rests.
        final: Where the joint comes to rest [1]; None where it does not.
        rise_time: 10 to 90 % [s]; None where it cannot be told, as below.
        overshoot: Beyond where it comes to rest, as a share of the way there [1].
        settling_time: Until it stays within 2 % [s].
        steady_state_error: Command less position at rest, in the direction of the step [rad or m].
        natural_frequency: Of the second-order system that answers most alike [rad/s].
        damping_ratio: Likewise [1].
        delay: Likewise [s].
    """

    row: int
    size: float
    time: Array
    answer: Array
    left_out: str | None = None
    cut_off: bool = False
    final: float | None = None
    rise_time: float | None = None
    overshoot: float | None = None
    settling_time: float | None = None
    steady_state_error: float | None = None
    natural_frequency: float | None = None
    damping_ratio: float | None = None
    delay: float | None = None


def steps(recording: Recording, bounds: Bounds, gains: tuple[float, float] | None) -> list[Step]:
    """All steps of a joint in a log, in time; those that do not count too, with the reason.

    Args:
        recording: The joint's part of the log.
        bounds: Of the drive.
        gains: kp and kd, to see whether the drive is at its bound where no torque was logged; None: unknown.
    """
    import numpy as np

    position, noise = recording.measured["position"], scatter(recording.measured["position"], recording.time)
    found = []
    for before, first, last in _holds(recording):
        size = float(recording.command[first] - recording.command[first - 1])
        rows = slice(first, last)
        at_rest = position[before:first][-max(round(TAIL * (first - before)), 3) :]
        time = recording.time[rows] - recording.time[first]
        good = np.isfinite(position[rows])
        if good.sum() < LEAST_ROWS or not np.isfinite(at_rest).any():
            continue
        begin = float(np.nanmean(at_rest))
        answer = (np.interp(time, time[good], position[rows][good]) - begin) / size
        step = Step(first, size, time, answer)
        if abs(size) < LOUD * noise:
            found.append(_but(step, "too small"))
        elif float(np.nanmax(np.abs(at_rest - begin))) > RESTED * abs(size) + 4.0 * noise:
            found.append(_but(step, "not at rest before it"))
        elif _saturated(recording, rows, bounds, gains):
            found.append(_but(step, "saturated"))
        else:
            found.append(_measured(step, noise / abs(size)))
    return found


def _but(step: Step, why: str) -> Step:
    return Step(step.row, step.size, step.time, step.answer, left_out=why)


def _holds(recording: Recording) -> list[tuple[int, int, int]]:
    """Held commands with a step between them: first row of the one, first of the other, and the row after it."""
    import numpy as np

    command, time = recording.command, recording.time
    gap = np.diff(time) > longest_step(time)
    changes = np.flatnonzero((np.diff(command) != 0.0) | gap) + 1
    edges = [0, *changes.tolist(), len(command)]
    least = max(LEAST_ROWS, round(LEAST_HELD / recording.step))
    return [
        (before, first, last)
        for before, first, last in zip(edges, edges[1:], edges[2:], strict=False)
        if first - before >= least and last - first >= least and not gap[first - 1]
    ]


def _saturated(recording: Recording, rows: slice, bounds: Bounds, gains: tuple[float, float] | None) -> bool:
    """Whether the drive gives all it can: by the torque that was read, or by the gains."""
    import numpy as np

    read, speed = recording.measured.get("torque"), recording.velocity[rows]
    if read is None:
        if gains is None:
            return False
        kp, kd = gains
        torque = kp * (recording.command[rows] - recording.position[rows]) - kd * speed
        return bool(np.any(np.abs(torque) > np.abs(bounds.clip(torque, speed)) * (1.0 + 1e-9)))
    most = bounds.clip(np.copysign(np.inf, read[rows]), speed)
    return int(np.sum(np.abs(read[rows]) >= FULL * np.abs(most))) > 1


def _measured(step: Step, noise: float) -> Step:
    """A step with what it shows; `noise` as a share of it."""
    import numpy as np

    time, answer = step.time, step.answer
    alike = _second_order(time, answer, noise)
    rate = None if alike is None else alike[:3]
    tail = answer[-max(round(TAIL * len(answer)), 3) :]
    final = float(tail.mean())
    if alike is not None and tail.min() <= alike[3] <= tail.max():
        # What still rings comes to rest where the system like it does.
        final = alike[3]
    spread = BAND * abs(final) + 4.0 * noise
    if final < 0.3 or float(np.abs(tail - final).max()) > spread:
        return _with(step, rate, cut_off=True)
    share = answer / final
    outside = np.flatnonzero(np.abs(share - 1.0) > max(BAND, 3.0 * noise / final))
    settling = _crossing(time, np.abs(share - 1.0), int(outside[-1]), BAND) if len(outside) else 0.0
    if settling is None or settling > (1.0 - TAIL) * time[-1]:
        return _with(step, rate, cut_off=True)
    low, high = (_first(time, share, level) for level in RISE)
    return _with(
        step,
        rate,
        final=final,
        rise_time=None if low is None or high is None else high - low,
        overshoot=_overshoot(time, share, noise / final),
        settling_time=settling,
        steady_state_error=(1.0 - final) * abs(step.size),
    )


def _with(
    step: Step,
    alike: tuple[float, float, float] | None,
    *,
    cut_off: bool = False,
    final: float | None = None,
    rise_time: float | None = None,
    overshoot: float | None = None,
    settling_time: float | None = None,
    steady_state_error: float | None = None,
) -> Step:
    natural, damping, delay = alike if alike is not None else (None, None, None)
    return Step(
        step.row, step.size, step.time, step.answer, None, cut_off, final, rise_time, overshoot, settling_time,
        steady_state_error, natural, damping, delay,
    )  # fmt: skip


def _first(time: Array, share: Array, level: float) -> float | None:
    """When an answer first comes to a level, between rows [s]."""
    import numpy as np

    above = np.flatnonzero(share >= level)
    if not len(above) or above[0] == 0:
        return None
    return _crossing(time, share, int(above[0]) - 1, level)


def _crossing(time: Array, signal: Array, row: int, level: float) -> float | None:
    """When a signal goes through a level between a row and the next [s]."""
    if row + 1 >= len(time):
        return None
    part = (level - signal[row]) / (signal[row + 1] - signal[row])
    return float(time[row] + min(max(part, 0.0), 1.0) * (time[row + 1] - time[row]))


def _overshoot(time: Array, share: Array, noise: float) -> float:
    """The greatest excess, at the top of a parabola through the rows around it [1]."""
    import numpy as np

    top = int(np.argmax(share))
    if share[top] - 1.0 < SIGNIFICANT * noise:
        return 0.0
    # Rows around the top that are above nine tenths of it: there the answer is a parabola.
    level = 1.0 + 0.9 * (share[top] - 1.0) - 2.0 * noise
    below = np.flatnonzero(share < level)
    first = int(below[below < top][-1]) + 1 if (below < top).any() else 0
    last = int(below[below > top][0]) if (below > top).any() else len(share)
    if last - first < 4:
        return float(share[top] - 1.0)
    at = time[first:last] - time[top]
    a, b, c = np.polyfit(at, share[first:last], 2)
    peak = c - b * b / (4.0 * a) if a < 0.0 else float(share[top])
    return max(float(peak) - 1.0, 0.0)


def _second_order(time: Array, answer: Array, noise: float) -> tuple[float, float, float, float] | None:
    """Natural frequency [rad/s], damping ratio, delay [s] and last value of the system that answers most alike."""
    import numpy as np
    from scipy.optimize import least_squares

    half = _first(time, answer, 0.5 * float(np.median(answer[len(answer) // 2 :])))
    if half is None or half <= 0.0:
        return None

    def residuals(x: Array) -> Array:
        natural, damping, delay, final = math.exp(x[0]), math.exp(x[1]), x[2], x[3]
        found: Array = final * unit_step(time - delay, natural, damping) - answer
        return found

    tried = [
        least_squares(
            residuals,
            np.array([math.log(1.5 / half), math.log(damping), 0.1 * half, 1.0]),
            x_scale=[0.1, 0.1, 0.1 * half, 0.1],
            bounds=([-math.inf, math.log(0.01), 0.0, 0.0], [math.inf, math.log(20.0), half, math.inf]),
            loss="soft_l1",
            f_scale=max(3.0 * noise, 0.01),
        )
        for damping in (0.3, 1.2)
    ]
    best = min(tried, key=lambda one: float(one.cost))
    left = float(np.sqrt(np.mean(residuals(best.x) ** 2)))
    spread = np.linalg.pinv(best.jac.T @ best.jac) * left**2
    if left > LIKE or math.sqrt(spread[0, 0]) > VAGUE or math.sqrt(spread[1, 1]) > VAGUE:
        return None
    return math.exp(best.x[0]), math.exp(best.x[1]), float(best.x[2]), float(best.x[3])


def unit_step(time: Array, natural: float, damping: float) -> Array:
    """Answer of wn^2 / (s^2 + 2 zeta wn s + wn^2) to a unit step at 0 [1], shape (n,); 0 before it."""
    return second_order(time, natural, damping)[0]


def second_order(time: Array, natural: float, damping: float) -> tuple[Array, Array]:
    """Answer of the system to a unit step at 0 [1], and its slope [1/s], shape (n,) each; 0 before it."""
    import numpy as np

    t = np.maximum(np.asarray(time, dtype=float), 0.0)
    # Apart from critical damping by less than a figure is known, so that both ends stay apart.
    root = natural * np.sqrt(complex(damping**2 - 1.0) or 1e-12)
    fast, slow = -natural * damping - root, -natural * damping + root
    ends = np.exp(fast * t), np.exp(slow * t)
    answer: Array = np.real(1.0 + (slow * ends[0] - fast * ends[1]) / (fast - slow))
    slope: Array = np.real(natural**2 * (ends[1] - ends[0]) / (slow - fast))
    return answer, slope


def counted(found: Sequence[Step]) -> dict[str, int]:
    """How many steps do not count, by the reason."""
    reasons: dict[str, int] = {}
    for step in found:
        if step.left_out is not None:
            reasons[step.left_out] = reasons.get(step.left_out, 0) + 1
    return reasons


def judged(
    actuator: JointActuator,
    recordings: Sequence[Recording],
    bounds: Bounds,
    gains: tuple[float, float] | None,
    out: Collector,
) -> JointFit | None:
    """What the steps of a joint's logs say, as mean and standard deviation over them; None where there are none.

    Args:
        actuator: The joint.
        recordings: Its parts of the logs.
        bounds: Of the drive.
        gains: kp and kd as sent; None: unknown.
        out: Takes what is left out, and why a figure has no value.
    """
    import numpy as np

    name, place = actuator.joint, Span(recordings[0].log.path)
    found = [step for recording in recordings for step in steps(recording, bounds, gains)]
    used = [step for step in found if step.left_out is None]
    reasons = listed([f"{count} {reason}" for reason, count in counted(found).items()])
    if not used:
        message = "the command has no steps" if not found else f"none of {len(found)} steps counts: {reasons}"
        help = "hold each level until the joint rests: `actspec sysid design --experiment steps`"
        out.warning("SYS055", message, where=name, span=place, help=help)
        return None
    if len(used) < len(found):
        message = f"{len(found) - len(used)} of {len(found)} steps are left out: {reasons}"
        out.info("SYS056", message, where=name, span=place)
    cut = sum(step.cut_off for step in used)
    if cut:
        message = (
            f"{cut} of {len(used)} steps end before the joint rests: they tell frequency and damping alone"
        )
        out.info("SYS056", message, where=name, span=place, help="hold each level longer")
    length = units_of(actuator.kind).position
    units = {
        "rise_time": "s", "overshoot": "1", "settling_time": "s", "steady_state_error": length,
        "natural_frequency": "Hz", "damping_ratio": "1",
    }  # fmt: skip
    shown = []
    for figure, unit in units.items():
        values = np.array([value for step in used if (value := getattr(step, figure)) is not None])
        if not len(values):
            why = (
                f"no second-order system answers as the joint does in any of {len(used)} steps"
                if unit == "Hz" or figure == "damping_ratio"
                else f"the joint comes to rest in none of {len(used)} steps"
            )
            shown.append(Indicator(figure, None, None, unit, why))
            out.info("SYS057", f"{figure} has no value: {why}", where=name, span=place)
            continue
        if unit == "Hz":
            values = values / (2.0 * math.pi)
        std = float(values.std(ddof=1)) if len(values) > 1 else None
        shown.append(Indicator(figure, float(values.mean()), std, unit))
    return JointFit(name, actuator.kind, (), (), (), None, None, None, None, tuple(shown))
