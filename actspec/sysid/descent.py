"""The figures with which a joint moves as it was logged: weighted least squares over pieces of the log.

Each piece begins at a state of its own, which is free too and is eliminated piece by piece, so noise in what was read
at its first row biases nothing. Noise is that of the residuals, channel by channel; the covariance is a sandwich over
blocks of time, so residuals may be correlated within each.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from actspec.sysid.course import Course
from actspec.sysid.figures import Bounds, Figures
from actspec.sysid.motion import Moved, move
from actspec.sysid.system import System

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

ROUNDS = 30
"""Most steps of the descent. Chosen: it takes four to eight."""
DONE = 0.05
"""Largest step, in standard deviations, at which the descent has arrived. Chosen: the interval does not show it."""
BLOCKS = 40
"""Blocks of time that the sandwich has at least, as long as they are `BLOCK` long; none is longer than a piece."""
BLOCK = 0.1
"""Least length of a block [s]. Chosen: residuals are no longer alike after that."""
ENOUGH = 0.05
"""Fall of the squared residuals, in those of the noise, that is nothing any more: a fifth of a standard deviation."""

EXACT = 1e-4
"""Least noise of a channel, as a share of the standard deviation of what was read. Chosen: no joint is what its model
says to more than that, and a simulated speed without noise would outweigh everything else."""
REFUSED = 3
"""Steps in a row that lead up, after which less than one of those is not looked for any more."""
BENT = 0.2
"""Share of what a refused step rises by from which on a piece is held where it begins. Chosen: where a joint comes to a
stand the cost of a state bends, and one such piece of sixty refused every step of all."""
HELD = 100.0
"""Damping of its state. Chosen: it stays, and goes with the figures."""
TOGETHER = 2048
"""Most lanes that several descents have together. Chosen: beyond that an operation takes as long as its numbers, and
their memory."""
HOPELESS = 100.0
"""By how much a search must promise to end above another one to be given up. Chosen: a wrong row costs thousands."""


@dataclass(frozen=True, slots=True)
class Piecewise:
    """One log of a joint, in pieces.

    Attributes:
        course: Commands and model.
        measured: Channel to what was read, NaN where nothing was or it is left out, shape (n,).
        starts: First rows of the pieces.
        rows: Length of each.
        joint_torque: Whether the torque was read behind friction.
        own: Figures that the log does not share with all others, to the name of their value and a factor on it.
        ago: By how much its torque is older than the row [s].
    """

    course: Course
    measured: Mapping[str, Array]
    starts: NDArray[np.intp]
    rows: int
    joint_torque: bool = False
    own: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    ago: float = 0.0

    def figures(self, values: Mapping[str, Array]) -> Figures:
        """The motion's figures from the values of a fit, one entry a set."""
        shared = {name: (name, 1.0) for name in Figures.names()} | dict(self.own)
        return Figures(**{name: values[key] * factor for name, (key, factor) in shared.items()})

    def shows(self, value: str) -> bool:
        """Whether the motion depends on a value of the fit."""
        keys = {key for key, factor in self.own.values() if factor}
        return value in keys or (value in Figures.names() and value not in self.own)

    def cut(self, channel: str) -> Array:
        """A channel by row and piece, shape (rows, n_piece)."""
        import numpy as np

        rows = self.starts[None, :] + np.arange(self.rows)[:, None]
        found: Array = self.measured[channel][rows]
        return found


@dataclass(frozen=True, slots=True)
class Fit:
    """Where a descent ended.

    Attributes:
        values: Every figure.
        free: Names of those that were free.
        covariance: Of these, shape (n_free, n_free). Where few blocks tell it, so much larger that 1.96 standard
            deviations are 95 % all the same.
        normal: Their normal matrix, states eliminated, likewise.
        noise: Channel to the standard deviation of its residuals.
        cost: Minus twice the log-likelihood, but for a constant; less is better.
        states: Of each log, positions and speeds at the starts.
        arrived: Whether it came to rest.
        reading: Delay by which the torques were read, see `move`: at the end of a row the best delay may be in the
            next one.
    """

    values: Mapping[str, float]
    free: tuple[str, ...]
    covariance: Array
    normal: Array
    noise: Mapping[str, float]
    cost: float
    states: States
    arrived: bool
    reading: float | None = None

    def std(self, name: str) -> float:
        """Of a figure that was free."""
        i = self.free.index(name)
        return math.sqrt(max(float(self.covariance[i, i]), 0.0))


@dataclass(frozen=True, slots=True)
class Search:
    """What a descent is over.

    Attributes:
        logs: Of the joint.
        bounds: Of the drive.
        free: Names of the free figures.
        scale: Of each figure, for differences.
        low: Least values.
        reading: See `move`.
        last: The last motions, if any: where another reading is tried the joint moves as it did.
    """

    logs: Sequence[Piecewise]
    bounds: Bounds
    free: tuple[str, ...]
    scale: Mapping[str, float]
    low: Mapping[str, float]
    reading: float | None = None
    last: list[_Motions] = field(default_factory=list, compare=False, repr=False)


States = tuple[tuple["Array", "Array"], ...]
"""Of each log, positions and speeds at the starts."""


@dataclass(frozen=True, slots=True)
class _Motions:
    """Position and speed of each log's pieces, and of what search, figures and states they are."""

    logs: Sequence[Piecewise]
    free: tuple[str, ...]
    values: Mapping[str, float]
    states: States
    moved: Sequence[tuple[Array, Array]]

    def of(self, search: Search, values: Mapping[str, float], states: States) -> bool:
        """Whether they are of these."""
        same = self.states is states and self.logs is search.logs and self.free == search.free
        return same and self.values == values


FURTHER, FASTER = 1e-4, 1e-2
"""Changes of a state for differences [rad or m, rad/s or m/s]."""
DIFFERENCE = 1e-3
"""Of a figure's scale, for differences. Chosen: beyond the bends where a joint comes to rest."""


def descend(
    search: Search,
    values: Mapping[str, float],
    fit: Fit | None = None,
    beat: float = math.inf,
    rounds: int = ROUNDS,
) -> Fit:
    """Search from given figures on.

    Args:
        search: Over what.
        values: Every figure, where to begin.
        fit: An earlier fit whose states and noise are begun with.
        beat: Cost above which the end is of no use: where it cannot be reached, the search is given up.
        rounds: Most steps.
    """
    (found,) = _descended(search, [_descent(search, values, fit, beat, rounds)])
    return found


def descend_each(search: Search, starts: Sequence[Mapping[str, float]], fit: Fit | None = None) -> list[Fit]:
    """Search from several beginnings, side by side: in less than half the time."""
    return _descended(search, [_descent(search, values, fit) for values in starts])


_Descent = Generator[tuple[Mapping[str, float], States], System, Fit]
"""Asks for the residuals at figures and states, one after the other."""


def _descended(search: Search, descents: Sequence[_Descent]) -> list[Fit]:
    """The ends of descents over one search."""
    ends: dict[int, Fit] = {}
    asked = {i: next(one) for i, one in enumerate(descents)}
    lanes = max((len(log.starts) for log in search.logs), default=1) * (3 + 2 * len(search.free))
    some = max(1, TOGETHER // lanes)
    while asked:
        keys = list(asked)[:some] if some < len(asked) else list(asked)
        for i, system in zip(keys, linearised_each(search, [asked.pop(i) for i in keys]), strict=True):
            try:
                asked[i] = descents[i].send(system)
            except StopIteration as end:
                ends[i] = end.value
    return [ends[i] for i in range(len(descents))]


def _descent(
    search: Search,
    values: Mapping[str, float],
    fit: Fit | None = None,
    beat: float = math.inf,
    rounds: int = ROUNDS,
) -> _Descent:
    """See `descend`."""
    import numpy as np

    now = dict(values)
    states = fit.states if fit is not None else tuple(first_states(log, now["bias"]) for log in search.logs)
    damping, refused, arrived, still = 0.0, 0, False, False
    held = [np.zeros(len(log.starts)) for log in search.logs]
    system = yield now, states
    noise = system.noise()
    solved = system.solve(noise)
    for _ in range(rounds):
        step = solved.step(damping)
        fall = float(step @ solved.right)
        if still and fall < ENOUGH:
            arrived = True
            break
        if system.likelihood(noise) - 2.0 * fall > beat + HOPELESS:
            break
        trial = {**now}
        for name, change in zip(search.free, step, strict=True):
            trial[name] = max(now[name] + float(change), search.low[name])
        taken = np.array([trial[name] - now[name] for name in search.free])
        new_states = solved.states(states, taken, [damping + more for more in held])
        new_system = yield trial, new_states
        rises = [new - old for new, old in zip(new_system.costs(noise), system.costs(noise), strict=True)]
        before, rise = system.cost(noise), float(sum(part.sum() for part in rises))
        if rise <= before * 1e-9:
            small = float(np.abs(taken / solved.spread()).max()) if len(taken) else 0.0
            now, states, system = trial, new_states, new_system
            fresh = system.noise()
            still = all(abs(fresh[c] / noise[c] - 1) < 1e-2 for c in fresh)
            noise = fresh
            solved = system.solve(noise)
            damping, held = 0.2 * damping, [0.1 * more for more in held]
            if damping < 1e-6:
                damping = 0.0
            refused = 0
            if still and (small < DONE or -rise < ENOUGH):
                arrived = True
                break
        else:
            refused += 1
            if refused == REFUSED and fall < 1.0:
                # Where joints come to a stand the cost has bends; less than a standard deviation is left.
                arrived = True
                break
            most = BENT * sum(float(part[part > 0.0].sum()) for part in rises)
            bent = [(part > most) & (more < 1.0) for part, more in zip(rises, held, strict=True)]
            rest = sum(float(part[~some].sum()) for part, some in zip(rises, bent, strict=True))
            if rest < 0.0:
                held = [np.where(some, HELD, more) for some, more in zip(bent, held, strict=True)]
            else:
                damping = max(10.0 * damping, 1e-3)
            if damping > 1e8:
                break
    covariance = solved.sandwich(*system.blocks(noise, solved, block_rows(search.logs)))
    likelihood = system.likelihood(noise)
    return Fit(
        now, search.free, covariance, solved.normal, noise, likelihood, states, arrived, search.reading
    )


def block_rows(logs: Sequence[Piecewise]) -> int:
    """Rows of a block of the sandwich."""
    import numpy as np

    total = sum(len(log.starts) * log.rows for log in logs)
    step = min(float(np.median(np.diff(log.course.time))) for log in logs)
    return max(total // BLOCKS, round(BLOCK / step), 1)


def simulated(
    log: Piecewise,
    values: Mapping[str, float],
    bounds: Bounds,
    states: tuple[Array, Array],
    reading: float | None = None,
    finer: int = 1,
) -> Moved:
    """How a joint of given figures moves along the pieces of a log; one set. For the last two see `move`."""
    q, qd = (state[:, None] for state in states)
    return move(
        log.course, _one(log, values), bounds, log.starts, log.rows, q, qd, reading, finer, ago=log.ago
    )


def seen(log: Piecewise, values: Mapping[str, float], moved: Moved) -> dict[str, Array]:
    """What the sensors of a log read of such a motion, by channel, shape (rows, n_piece)."""
    return {channel: model[:, :, 0] for channel, model in shown(moved, log, values["bias"]).items()}


def _one(log: Piecewise, values: Mapping[str, float]) -> Figures:
    import numpy as np

    return log.figures({name: np.array([value]) for name, value in values.items()})


def first_states(log: Piecewise, bias: float) -> tuple[Array, Array]:
    """Positions and speeds at the beginning of each piece by the readings, without the encoder's bias."""
    import numpy as np

    q = log.measured["position"][log.starts] - bias
    velocity = log.measured.get("velocity")
    qd = (
        velocity[log.starts]
        if velocity is not None
        else np.gradient(log.measured["position"], log.course.time)[log.starts]
    )
    return np.nan_to_num(q), np.nan_to_num(qd)


def linearised(search: Search, values: Mapping[str, float], states: States) -> System:
    """Residuals at given figures and states, and their derivatives."""
    return linearised_each(search, [(values, states)])[0]


def linearised_each(search: Search, where: Sequence[tuple[Mapping[str, float], States]]) -> list[System]:
    """The same at several figures and states, in one motion."""
    import numpy as np

    known = next((one.moved for one in search.last if len(where) == 1 and one.of(search, *where[0])), None)
    channels: list[list[dict[str, tuple[Array, Array, Array]]]] = [[] for _ in where]
    motions = []
    for k, log in enumerate(search.logs):
        active = [i for i, name in enumerate(search.free) if log.shows(name)]
        sets = [_beside(search, active, values, states[k]) for values, states in where]
        figures = log.figures(
            {name: np.concatenate([one.values[name] for one in sets]) for name in sets[0].values}
        )
        q, qd = (np.concatenate([getattr(one, name) for one in sets], axis=1) for name in ("q", "qd"))
        moved = move(
            log.course, figures, search.bounds, log.starts, log.rows, q, qd, search.reading,
            moved=None if known is None else known[k], ago=log.ago,
        )  # fmt: skip
        motions.append((moved.q, moved.qd))
        width = 3 + 2 * len(active)
        for channel, models in shown(moved, log, figures.bias).items():
            measured = log.cut(channel)
            for i, one in enumerate(sets):
                model = models[:, :, i * width : (i + 1) * width]
                if len(channels[i]) == k:
                    channels[i].append({})
                channels[i][k][channel] = _differences(measured, model, active, one.steps, len(search.free))
    least: dict[str, float] = {}
    for log in search.logs:
        for channel, read in log.measured.items():
            least[channel] = max(least.get(channel, 0.0), EXACT * float(np.nanstd(read)))
    search.last[:] = [_Motions(search.logs, search.free, *where[0], motions)] if len(where) == 1 else []
    return [System(found, len(search.free), least) for found in channels]


@dataclass(frozen=True, slots=True)
class _Sets:
    """Figures and states, and these with each that is free a little to either side.

    Attributes:
        values: One entry a set.
        q: Positions at the starts, shape (n_piece, n_set).
        qd: Speeds there, likewise.
        steps: Between the two sides, of each active figure.
    """

    values: Mapping[str, Array]
    q: Array
    qd: Array
    steps: Sequence[float]


def _beside(
    search: Search, active: Sequence[int], values: Mapping[str, float], states: tuple[Array, Array]
) -> _Sets:
    import numpy as np

    p = len(active)
    columns = {name: np.full(1 + 2 * p + 2, value) for name, value in values.items()}
    steps = []
    for k, i in enumerate(active):
        name = search.free[i]
        step = DIFFERENCE * search.scale[name]
        lower = max(values[name] - step, search.low[name])
        columns[name][1 + 2 * k], columns[name][2 + 2 * k] = values[name] + step, lower
        # Nothing is left of a step beside a figure that ran away, in a trial that is dropped then.
        steps.append(values[name] + step - lower or math.inf)
    q, qd = (np.tile(state[:, None], (1, 3 + 2 * p)) for state in states)
    q[:, -2] += FURTHER
    qd[:, -1] += FASTER
    return _Sets(columns, q, qd, steps)


def _differences(
    measured: Array, model: Array, active: Sequence[int], steps: Sequence[float], count: int
) -> tuple[Array, Array, Array]:
    """Residuals of a channel, and their derivatives; see `System`."""
    import numpy as np

    # The first row of a piece is that of its state: it counts, as any other.
    r = measured - model[:, :, 0]
    jac = np.zeros((*r.shape, count))
    for k, i in enumerate(active):
        jac[:, :, i] = (model[:, :, 1 + 2 * k] - model[:, :, 2 + 2 * k]) / steps[k]
    local = np.stack(
        [(model[:, :, -2] - model[:, :, 0]) / FURTHER, (model[:, :, -1] - model[:, :, 0]) / FASTER], axis=2
    )
    bad = ~np.isfinite(r)
    jac[bad], local[bad] = 0.0, 0.0
    return r, jac, local


def shown(moved: Moved, log: Piecewise, bias: Array | float) -> dict[str, Array]:
    """What sensors read of a motion, by channel, shape (rows, n_piece, n_set).

    Args:
        moved: The motion.
        log: Whose sensors.
        bias: Of the encoder, of all sets or of each [rad or m].
    """
    found = {}
    if "position" in log.measured:
        found["position"] = moved.q + bias
    if "velocity" in log.measured:
        found["velocity"] = moved.qd
    if "torque" in log.measured:
        found["torque"] = moved.torque - moved.friction if log.joint_torque else moved.torque
    return found
