"""The figures with which a joint moves as it was logged: weighted least squares over pieces of the log.

Each piece begins at a state of its own, which is free too and is eliminated piece by piece, so noise in what was read
at its first row biases nothing. Noise is that of the residuals, channel by channel; the covariance is a sandwich over
blocks of time, so residuals may be correlated within each.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from actspec.sysid.course import Course
from actspec.sysid.figures import Bounds, Figures
from actspec.sysid.motion import Moved, move

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

CHANNELS = ("position", "velocity", "torque")
ROUNDS = 30
"""Most steps of the descent. Chosen: it takes four to eight."""
DONE = 0.05
"""Largest step, in standard deviations, at which the descent has arrived. Chosen: the interval does not show it."""
BLOCKS = 40
"""Blocks of time that the sandwich has at least, as long as they are `BLOCK` long; none is longer than a piece."""
BLOCK = 0.1
"""Least length of a block [s]. Chosen: residuals are no longer alike after that."""
WIDE = 1.96
"""Half the 95 % interval in standard deviations."""
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
    states: tuple[tuple[Array, Array], ...]
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
    """

    logs: Sequence[Piecewise]
    bounds: Bounds
    free: tuple[str, ...]
    scale: Mapping[str, float]
    low: Mapping[str, float]
    reading: float | None = None


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
    import numpy as np

    now = dict(values)
    states = fit.states if fit is not None else tuple(first_states(log, now["bias"]) for log in search.logs)
    damping, refused, arrived, still = 0.0, 0, False, False
    held = [np.zeros(len(log.starts)) for log in search.logs]
    system = linearised(search, now, states)
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
        new_system = linearised(search, trial, new_states)
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
    return move(log.course, _one(log, values), bounds, log.starts, log.rows, q, qd, reading, finer)


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


@dataclass(slots=True)
class _Solved:
    """A linear system, weighted, states eliminated."""

    normal: Array
    right: Array
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

    def sandwich(self, scores: Array, normals: Array) -> Array:
        """The covariance.

        Args:
            scores: By block, shape (n_block, p).
            normals: Their parts of the normal matrix, shape (n_block, p, p).
        """
        import numpy as np
        from scipy.special import stdtrit

        inverse = self.inverse()
        n = max(len(scores), 2)
        middle = scores.T @ scores * n / max(n - self.normal.shape[0], 1)
        found = inverse @ middle @ inverse
        # What each block adds to a variance: those that add most are the ones that tell it. Source: Satterthwaite 1946.
        parts = np.einsum("ip,bpq,qi->bi", inverse, normals, inverse)
        # Their shares alone count; of a figure that the log does not tell, the squares are beyond what a float holds.
        parts = parts / np.maximum(np.abs(parts).max(axis=0), 1e-300)
        freedom = parts.sum(axis=0) ** 2 / np.maximum((parts**2).sum(axis=0), 1e-300)
        wide = stdtrit(np.maximum(freedom, 1.0), 0.975) / WIDE
        # Few blocks may agree by chance: never less than what white residuals would give.
        plain = np.diag(inverse)
        grow = np.sqrt(np.maximum(plain / np.maximum(np.diag(found), 1e-300), wide**2))
        grown: Array = found * np.outer(grow, grow)
        return grown

    def states(
        self, states: Sequence[tuple[Array, Array]], step: Array, damping: Sequence[Array]
    ) -> tuple[tuple[Array, Array], ...]:
        """The states that go with a step of the figures; damped too, by piece, as one may refuse every step."""
        import numpy as np

        found = []
        for (q, qd), (offset, slope), less in zip(states, self.pieces, damping, strict=True):
            change = offset / (1.0 + less)[:, None] - np.einsum("sip,p->si", slope, step)
            found.append((q + change[:, 0], qd + change[:, 1]))
        return tuple(found)


@dataclass(slots=True)
class System:
    """Residuals and their derivatives, by log and channel: (r, J, L), shapes (m, n_piece), (.., p), (.., 2).

    L is that over the states at the pieces' first rows; `count` is p, `least` the least noise of each channel.
    """

    logs: list[dict[str, tuple[Array, Array, Array]]]
    count: int
    least: Mapping[str, float] = field(default_factory=dict)

    def noise(self) -> dict[str, float]:
        """Standard deviation of each channel's residuals, as if states and figures took none; or its least."""
        import numpy as np

        found = {}
        for channel in CHANNELS:
            parts = [log[channel][0] for log in self.logs if channel in log]
            if not parts:
                continue
            used = sum(int(np.isfinite(part).sum()) for part in parts)
            total = sum(float(np.nansum(part**2)) for part in parts)
            taken = sum(2 * part.shape[1] for part in parts) / 2 + self.count
            least = max(self.least.get(channel, 0.0), 1e-12)
            found[channel] = max(math.sqrt(total / max(used - taken, 1)), least)
        return found

    def shifts(
        self, noise: Mapping[str, float], changes: Sequence[Sequence[Mapping[str, Array]]]
    ) -> NDArray[np.float64]:
        """How far the best figures move where what is compared changes by a little, to first order.

        Args:
            noise: Of each channel.
            changes: For each cause, for each log, channel to the change of measured less model, shape (rows, n_piece).

        Returns: Shape (n_cause, n_free).
        """
        import numpy as np

        found = []
        for change in changes:
            logs = [
                {
                    channel: (np.where(np.isfinite(r), new.get(channel, 0.0 * r), np.nan), jac, local)
                    for channel, (r, jac, local) in log.items()
                }
                for log, new in zip(self.logs, change, strict=True)
            ]
            found.append(System(logs, self.count).solve(noise).step(0.0))
        return np.array(found).reshape(len(changes), self.count)

    def left_out(self, noise: Mapping[str, float], which: Sequence[NDArray[np.bool_]]) -> System:
        """The residuals of some pieces with figures from the others, to first order; states are those pieces' own.

        Args:
            noise: Of each channel.
            which: For each log, whether a piece is left out, shape (n_piece,).
        """
        import numpy as np

        def of(pieces: Sequence[NDArray[np.bool_]]) -> System:
            logs = [
                {
                    channel: (r[:, some], jac[:, some], local[:, some])
                    for channel, (r, jac, local) in log.items()
                }
                for log, some in zip(self.logs, pieces, strict=True)
            ]
            return System(logs, self.count)

        step = of([~some for some in which]).solve(noise).step(0.0)
        blind = of(which)
        logs = []
        for log, (offset, slope) in zip(blind.logs, blind.solve(noise).pieces, strict=True):
            change = offset - np.einsum("sip,p->si", slope, step)
            logs.append(
                {
                    channel: (r - jac @ step - np.einsum("msi,si->ms", local, change), jac[:, :, :0], local)
                    for channel, (r, jac, local) in log.items()
                }
            )
        return System(logs, 0)

    def costs(self, noise: Mapping[str, float]) -> list[Array]:
        """Squared residuals in those of the noise; of each log by piece, shape (n_piece,)."""
        import numpy as np

        return [
            np.sum([np.nansum(part[0] ** 2, axis=0) / noise[c] ** 2 for c, part in log.items()], axis=0)
            for log in self.logs
        ]

    def cost(self, noise: Mapping[str, float]) -> float:
        """The same of all pieces together."""
        return float(sum(part.sum() for part in self.costs(noise)))

    def likelihood(self, noise: Mapping[str, float]) -> float:
        import numpy as np

        found = 0.0
        for log in self.logs:
            for channel, part in log.items():
                count = float(np.isfinite(part[0]).sum())
                found += 2.0 * count * math.log(noise[channel]) - count
        return found + self.cost(noise)

    def solve(self, noise: Mapping[str, float]) -> _Solved:
        import numpy as np

        p = self.count
        normal, right, pieces = np.zeros((p, p)), np.zeros(p), []
        for log in self.logs:
            r, jac, local = _weighted(log, noise)
            hat = np.einsum("msi,msj->sij", local, local)
            # A state that shows in nothing, as the speed of a joint that stands, stays where it is.
            hat += (1e-9 * np.trace(hat, axis1=1, axis2=2)[:, None, None] + 1e-12) * np.eye(2)
            inverse = np.linalg.inv(hat)
            slope = np.einsum("sij,msj,msp->sip", inverse, local, jac)
            offset = np.einsum("sij,msj,ms->si", inverse, local, r)
            jac = jac - np.einsum("msi,sip->msp", local, slope)
            r = r - np.einsum("msi,si->ms", local, offset)
            flat = jac.reshape(r.size, p)
            normal += flat.T @ flat
            right += flat.T @ r.reshape(-1)
            pieces.append((offset, slope))
        return _Solved(normal, right, pieces)

    def blocks(self, noise: Mapping[str, float], solved: _Solved, rows: int) -> tuple[Array, Array]:
        """What each block of so many rows adds: its score, shape (n_block, p), and its part of the normal matrix."""
        import numpy as np

        scores, normals = [], []
        for log, (offset, slope) in zip(self.logs, solved.pieces, strict=True):
            r, jac, local = _weighted(log, noise)
            jac = jac - np.einsum("msi,sip->msp", local, slope)
            r = r - np.einsum("msi,si->ms", local, offset)
            length = len(r) // len(log)
            count = max(1, round(length / rows))
            which = np.tile(np.arange(length) * count // length, len(log))
            for block in range(count):
                mine = which == block
                scores.append(np.einsum("msp,ms->sp", jac[mine], r[mine]))
                piecewise = np.moveaxis(jac[mine], 1, 0)
                normals.append(np.swapaxes(piecewise, 1, 2) @ piecewise)
        return np.concatenate(scores), np.concatenate(normals)


def _weighted(
    log: Mapping[str, tuple[Array, Array, Array]], noise: Mapping[str, float]
) -> tuple[Array, Array, Array]:
    """Residuals and derivatives of a log, channels one after the other, over the noise; 0 where nothing was read."""
    import numpy as np

    r, jac, local = (
        np.concatenate([np.nan_to_num(part[i]) / noise[channel] for channel, part in log.items()], axis=0)
        for i in range(3)
    )
    return r, jac, local


def linearised(search: Search, values: Mapping[str, float], states: Sequence[tuple[Array, Array]]) -> System:
    """Residuals at given figures and states, and their derivatives."""
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
            # Nothing is left of a step beside a figure that ran away, in a trial that is dropped then.
            steps.append(values[name] + step - lower or math.inf)
        figures = log.figures(columns)
        q, qd = np.tile(q0[:, None], (1, 3 + 2 * p)), np.tile(qd0[:, None], (1, 3 + 2 * p))
        q[:, -2] += FURTHER
        qd[:, -1] += FASTER
        moved = move(log.course, figures, search.bounds, log.starts, log.rows, q, qd, search.reading)
        channels = {}
        for channel, model in shown(moved, log, figures.bias).items():
            measured = log.cut(channel)
            # The first row of a piece is that of its state: it counts, as any other.
            r = measured - model[:, :, 0]
            jac = np.zeros((*r.shape, len(search.free)))
            for k, i in enumerate(active):
                jac[:, :, i] = (model[:, :, 1 + 2 * k] - model[:, :, 2 + 2 * k]) / steps[k]
            local = np.stack(
                [
                    (model[:, :, -2] - model[:, :, 0]) / FURTHER,
                    (model[:, :, -1] - model[:, :, 0]) / FASTER,
                ],
                axis=2,
            )
            bad = ~np.isfinite(r)
            jac[bad], local[bad] = 0.0, 0.0
            channels[channel] = (r, jac, local)
        found.append(channels)
    least: dict[str, float] = {}
    for log in search.logs:
        for channel, read in log.measured.items():
            least[channel] = max(least.get(channel, 0.0), EXACT * float(np.nanstd(read)))
    return System(found, len(search.free), least)


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
