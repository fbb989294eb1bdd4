"""The figures with which a joint moves as it was logged: weighted least squares over pieces of the log.

Each piece begins at a state of its own, which is free too and is eliminated piece by piece, so noise in what was read
at its first row biases nothing. Noise is that of the residuals, channel by channel; the covariance is a sandwich over
the pieces, so residuals may be correlated within each.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from actspec.sysid.motion import Bounds, Course, Figures, Moved, move

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

CHANNELS = ("position", "velocity", "torque")
ROUNDS = 30
"""Most steps of the descent. Chosen: it takes four to eight."""
DONE = 0.05
"""Largest step, in standard deviations, at which the descent has arrived. Chosen: the interval does not show it."""
ENOUGH = 0.05
"""Fall of the squared residuals, in those of the noise, that is nothing any more: a fifth of a standard deviation."""


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
    """

    course: Course
    measured: Mapping[str, Array]
    starts: NDArray[np.intp]
    rows: int
    joint_torque: bool = False
    own: Mapping[str, tuple[str, float]] = field(default_factory=dict)

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
        covariance: Of these, shape (n_free, n_free).
        normal: Their normal matrix, states eliminated, likewise.
        noise: Channel to the standard deviation of its residuals.
        cost: Minus twice the log-likelihood, but for a constant; less is better.
        states: Of each log, positions and speeds at the starts.
        arrived: Whether it came to rest.
    """

    values: Mapping[str, float]
    free: tuple[str, ...]
    covariance: Array
    normal: Array
    noise: Mapping[str, float]
    cost: float
    states: tuple[tuple[Array, Array], ...]
    arrived: bool

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
    """

    logs: Sequence[Piecewise]
    bounds: Bounds
    free: tuple[str, ...]
    scale: Mapping[str, float]
    low: Mapping[str, float]
    reading: float | None = None


DIFFERENCE = 1e-3
"""Of a figure's scale, for differences. Chosen: beyond the bends where a joint comes to rest."""


def descend(search: Search, values: Mapping[str, float], fit: Fit | None = None) -> Fit:
    """Search from given figures on.

    Args:
        search: Over what.
        values: Every figure, where to begin.
        fit: An earlier fit whose states and noise are begun with.
    """
    import numpy as np

    now = dict(values)
    states = fit.states if fit is not None else tuple(_first_states(log, now["bias"]) for log in search.logs)
    noise = dict(fit.noise) if fit is not None else None
    damping, arrived = 0.0, False
    system = _linearise(search, now, states)
    noise = system.noise(noise)
    solved = system.solve(noise)
    for _ in range(ROUNDS):
        step = solved.step(damping)
        trial = {**now}
        for name, change in zip(search.free, step, strict=True):
            trial[name] = max(now[name] + float(change), search.low[name])
        taken = np.array([trial[name] - now[name] for name in search.free])
        new_states = solved.states(states, taken)
        new_system = _linearise(search, trial, new_states)
        before, after = system.cost(noise), new_system.cost(noise)
        if after <= before * (1 + 1e-9):
            small = float(np.abs(taken / solved.spread()).max()) if len(taken) else 0.0
            now, states, system = trial, new_states, new_system
            fresh = system.noise(noise)
            still = all(abs(fresh[c] / noise[c] - 1) < 1e-2 for c in fresh)
            noise = fresh
            solved = system.solve(noise)
            damping *= 0.2
            if damping < 1e-6:
                damping = 0.0
            if still and (small < DONE or before - after < ENOUGH):
                arrived = True
                break
        else:
            if len(taken) and float(np.abs(taken / solved.spread()).max()) < DONE:
                # What is left to go shows in no interval, and is less than the errors of the differences.
                arrived = True
                break
            damping = max(10.0 * damping, 1e-3)
            if damping > 1e8:
                break
    return Fit(
        now, search.free, solved.sandwich(), solved.normal, noise, system.likelihood(noise), states, arrived
    )


def simulated(
    log: Piecewise, values: Mapping[str, float], bounds: Bounds, states: tuple[Array, Array]
) -> Moved:
    """How a joint of given figures moves along the pieces of a log; one set."""
    import numpy as np

    figures = log.figures({name: np.array([value]) for name, value in values.items()})
    q, qd = (state[:, None] for state in states)
    return move(log.course, figures, bounds, log.starts, log.rows, q, qd)


def _first_states(log: Piecewise, bias: float) -> tuple[Array, Array]:
    import numpy as np

    q = log.measured["position"][log.starts] - bias
    velocity = log.measured.get("velocity")
    qd = (
        velocity[log.starts]
        if velocity is not None
        else np.gradient(log.measured["position"], log.course.time)[log.starts]
    )
    return np.nan_to_num(q), np.nan_to_num(qd)


@dataclass(slots=True)
class _Solved:
    """A linear system, weighted, states eliminated."""

    normal: Array
    right: Array
    scores: Array
    pieces: list[tuple[Array, Array]]

    def step(self, damping: float) -> Array:
        import numpy as np

        diagonal = np.maximum(np.diag(self.normal), 1e-300)
        root = np.sqrt(diagonal)
        scaled = self.normal / np.outer(root, root) + damping * np.eye(len(root))
        found: Array = np.linalg.lstsq(scaled, self.right / root, rcond=1e-12)[0] / root
        return found

    def spread(self) -> Array:
        import numpy as np

        found: Array = np.sqrt(np.maximum(np.diag(self.inverse()), 1e-300))
        return found

    def inverse(self) -> Array:
        import numpy as np

        root = np.sqrt(np.maximum(np.diag(self.normal), 1e-300))
        scale = np.outer(root, root)
        found: Array = np.linalg.pinv(self.normal / scale, rcond=1e-12, hermitian=True) / scale
        return found

    def sandwich(self) -> Array:
        import numpy as np

        inverse = self.inverse()
        n = max(len(self.scores), 2)
        middle = self.scores.T @ self.scores * n / max(n - self.normal.shape[0], 1)
        found = inverse @ middle @ inverse
        # Few pieces may agree by chance: never less than what white residuals would give.
        plain = np.diag(inverse)
        grow = np.sqrt(np.maximum(plain / np.maximum(np.diag(found), 1e-300), 1.0))
        grown: Array = found * np.outer(grow, grow)
        return grown

    def states(self, states: Sequence[tuple[Array, Array]], step: Array) -> tuple[tuple[Array, Array], ...]:
        import numpy as np

        found = []
        for (q, qd), (offset, slope) in zip(states, self.pieces, strict=True):
            change = offset - np.einsum("sip,p->si", slope, step)
            found.append((q + change[:, 0], qd + change[:, 1]))
        return tuple(found)


@dataclass(slots=True)
class _System:
    """Residuals and their derivatives, by log and channel: (r, J, L), shapes (m, n_piece), (.., p), (.., 2)."""

    logs: list[dict[str, tuple[Array, Array, Array]]]
    count: int

    def noise(self, before: Mapping[str, float] | None) -> dict[str, float]:
        """Standard deviation of each channel's residuals, as if states and figures took none."""
        import numpy as np

        found = {}
        for channel in CHANNELS:
            parts = [log[channel][0] for log in self.logs if channel in log]
            if not parts:
                continue
            used = sum(int(np.isfinite(part).sum()) for part in parts)
            total = sum(float(np.nansum(part**2)) for part in parts)
            taken = sum(2 * part.shape[1] for part in parts) / 2 + self.count
            found[channel] = math.sqrt(max(total / max(used - taken, 1), 1e-24))
        return found

    def cost(self, noise: Mapping[str, float]) -> float:
        import numpy as np

        return sum(
            float(np.nansum(part[0] ** 2)) / noise[channel] ** 2
            for log in self.logs
            for channel, part in log.items()
        )

    def likelihood(self, noise: Mapping[str, float]) -> float:
        import numpy as np

        return sum(
            2.0 * float(np.isfinite(part[0]).sum()) * math.log(noise[channel])
            for log in self.logs
            for channel, part in log.items()
        )

    def solve(self, noise: Mapping[str, float]) -> _Solved:
        import numpy as np

        p = self.count
        normal, right, scores, pieces = np.zeros((p, p)), np.zeros(p), [], []
        for log in self.logs:
            r, jac, local = (
                np.concatenate(
                    [np.nan_to_num(part[i]) / noise[channel] for channel, part in log.items()], axis=0
                )
                for i in range(3)
            )
            hat = np.einsum("msi,msj->sij", local, local)
            # A state that shows in nothing, as the speed of a joint that stands, stays where it is.
            hat += (1e-9 * np.trace(hat, axis1=1, axis2=2)[:, None, None] + 1e-12) * np.eye(2)
            inverse = np.linalg.inv(hat)
            slope = np.einsum("sij,msj,msp->sip", inverse, local, jac)
            offset = np.einsum("sij,msj,ms->si", inverse, local, r)
            jac = jac - np.einsum("msi,sip->msp", local, slope)
            r = r - np.einsum("msi,si->ms", local, offset)
            normal += np.einsum("msp,msq->pq", jac, jac)
            score = np.einsum("msp,ms->sp", jac, r)
            right += score.sum(axis=0)
            scores.append(score)
            pieces.append((offset, slope))
        return _Solved(normal, right, np.concatenate(scores), pieces)


def _linearise(search: Search, values: Mapping[str, float], states: Sequence[tuple[Array, Array]]) -> _System:
    import numpy as np

    found = []
    for log, (q0, qd0) in zip(search.logs, states, strict=True):
        active = [i for i, name in enumerate(search.free) if log.shows(name)]
        p = len(active)
        columns = {name: np.full(1 + 2 * p + 2, value) for name, value in values.items()}
        steps = []
        for k, i in enumerate(active):
            name = search.free[i]
            step = DIFFERENCE * search.scale[name]
            lower = max(values[name] - step, search.low[name])
            columns[name][1 + 2 * k], columns[name][2 + 2 * k] = values[name] + step, lower
            steps.append(values[name] + step - lower)
        figures = log.figures(columns)
        q, qd = np.tile(q0[:, None], (1, 3 + 2 * p)), np.tile(qd0[:, None], (1, 3 + 2 * p))
        away, faster = 1e-4, 1e-2
        q[:, -2] += away
        qd[:, -1] += faster
        moved = move(log.course, figures, search.bounds, log.starts, log.rows, q, qd, search.reading)
        channels = {}
        for channel, model in _seen(moved, figures, log).items():
            measured = log.cut(channel)
            # The first row of a piece is that of its state: it counts, as any other.
            r = measured - model[:, :, 0]
            jac = np.zeros((*r.shape, len(search.free)))
            for k, i in enumerate(active):
                jac[:, :, i] = (model[:, :, 1 + 2 * k] - model[:, :, 2 + 2 * k]) / steps[k]
            local = np.stack(
                [(model[:, :, -2] - model[:, :, 0]) / away, (model[:, :, -1] - model[:, :, 0]) / faster],
                axis=2,
            )
            bad = ~np.isfinite(r)
            jac[bad], local[bad] = 0.0, 0.0
            channels[channel] = (r, jac, local)
        found.append(channels)
    return _System(found, len(search.free))


def _seen(moved: Moved, figures: Figures, log: Piecewise) -> dict[str, Array]:
    """What sensors read of a motion."""
    found = {}
    if "position" in log.measured:
        found["position"] = moved.q + figures.bias
    if "velocity" in log.measured:
        found["velocity"] = moved.qd
    if "torque" in log.measured:
        found["torque"] = moved.torque - moved.friction if log.joint_torque else moved.torque
    return found
