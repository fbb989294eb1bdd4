"""Joints of given figures along their logs, all at once: only where each piece begins is free.

A joint's motion is a row after the other, which many joints take in the time of one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

from actspec.sysid.descent import FASTER, FURTHER, Piecewise, first_states, shown
from actspec.sysid.figures import Bounds
from actspec.sysid.motion import Moved, Run, move_each
from actspec.sysid.system import System

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    States = tuple[Array, Array]
    Squares = Mapping[str, Array]

STEPS = 2
"""Steps towards the best states. Chosen: the first is within the noise but where a joint stands."""


@dataclass(frozen=True, slots=True)
class Going:
    """A joint in a log.

    Attributes:
        log: In pieces.
        values: Every figure.
        bounds: Of the drive.
        reading: See `move`.
    """

    log: Piecewise
    values: Mapping[str, float]
    bounds: Bounds
    reading: float | None = None


def moved_each(joints: Sequence[Going], states: Sequence[States]) -> list[Moved]:
    """How each moves from these states on; one set."""
    return _moved(joints, [(q[:, None], qd[:, None]) for q, qd in states])


def settled(
    joints: Sequence[Going], states: Sequence[States] | None = None, steps: int = STEPS
) -> list[tuple[States, Moved]]:
    """The states at which the pieces begin so that each agrees best with its readings, and how it moves from there.

    Args:
        joints: With their figures.
        states: Where to begin; None: at the readings.
        steps: Of Gauss and Newton; of each piece the best counts.
    """
    import numpy as np

    now = list(states) if states is not None else [first_states(j.log, j.values["bias"]) for j in joints]
    best: list[tuple[States, Moved, Squares]] = []
    for step in range(steps + 1):
        tries = [
            (np.stack([q, q + FURTHER, q], axis=1), np.stack([qd, qd, qd + FASTER], axis=1)) for q, qd in now
        ]
        for i, (joint, moved) in enumerate(zip(joints, _moved(joints, tries), strict=True)):
            system = _system(joint, moved)
            noise = system.noise()
            squares = {c: np.nansum(part[0] ** 2, axis=0) for c, part in system.logs[0].items()}
            mine = (now[i], _first(moved), squares)
            if step == 0:
                best.append(mine)
            else:
                best[i] = _better(best[i], mine, noise)
            if step < steps:
                (now[i],) = system.solve(noise).states([now[i]], np.zeros(0), [np.zeros(len(now[i][0]))])
    return [(at, moved) for at, moved, _ in best]


def _first(moved: Moved) -> Moved:
    return Moved(*(getattr(moved, field.name)[:, :, :1] for field in fields(Moved)))


def _better(
    old: tuple[States, Moved, Squares], new: tuple[States, Moved, Squares], noise: Mapping[str, float]
) -> tuple[States, Moved, Squares]:
    """Piece by piece, both by the noise of one of them: that of each makes them alike."""
    import numpy as np

    falls = np.sum([(new[2][c] - old[2][c]) / noise[c] ** 2 for c in noise], axis=0) < 0.0
    at = (np.where(falls, new[0][0], old[0][0]), np.where(falls, new[0][1], old[0][1]))
    moved = (
        np.where(falls[None, :, None], getattr(new[1], field.name), getattr(old[1], field.name))
        for field in fields(Moved)
    )
    return at, Moved(*moved), {c: np.where(falls, new[2][c], old[2][c]) for c in noise}


def _system(joint: Going, moved: Moved) -> System:
    """Residuals, and their derivatives over the states."""
    import numpy as np

    channels = {}
    for channel, model in shown(moved, joint.log, joint.values["bias"]).items():
        r = joint.log.cut(channel) - model[:, :, 0]
        local = np.stack(
            [(model[:, :, 1] - model[:, :, 0]) / FURTHER, (model[:, :, 2] - model[:, :, 0]) / FASTER], axis=2
        )
        local[~np.isfinite(r)] = 0.0
        channels[channel] = (r, np.zeros((*r.shape, 0)), local)
    return System([channels], 0)


def _moved(joints: Sequence[Going], states: Sequence[States]) -> list[Moved]:
    """All of them, those with the same bounds and length of pieces at once."""
    import numpy as np

    groups: dict[tuple[Bounds, int], list[int]] = {}
    for i, joint in enumerate(joints):
        groups.setdefault((joint.bounds, joint.log.rows), []).append(i)
    found: dict[int, Moved] = {}
    for (bounds, rows), mine in groups.items():
        runs = []
        for i in mine:
            log, (q, qd) = joints[i].log, states[i]
            sets = {name: np.full(q.shape[1], value) for name, value in joints[i].values.items()}
            runs.append(Run(log.course, log.figures(sets), log.starts, q, qd, joints[i].reading))
        found |= dict(zip(mine, move_each(runs, bounds, rows), strict=True))
    return [found[i] for i in range(len(joints))]
