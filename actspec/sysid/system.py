"""Residuals of a joint's motion and their derivatives: the linear system of a step, its covariance, what is left out.

States at the pieces' first rows are free, and are eliminated piece by piece. Noise is that of the residuals, channel by
channel; the covariance is a sandwich over blocks of time, so residuals may be correlated within each.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

CHANNELS = ("position", "velocity", "torque")
WIDE = 1.96
"""Half the 95 % interval in standard deviations."""


@dataclass(slots=True)
class Solved:
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

    def solve(self, noise: Mapping[str, float]) -> Solved:
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
        return Solved(normal, right, pieces)

    def blocks(self, noise: Mapping[str, float], solved: Solved, rows: int) -> tuple[Array, Array]:
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
