"""Where a descent begins: figures by linear regression, the delay by trying every whole number of rows."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.sysid.course import Course
from actspec.sysid.figures import Bounds
from actspec.sysid.recording import Recording

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

LONGEST = 0.06
"""Longest delay that is tried [s]. Chosen: slower drives are not position-controlled."""
MOVES = 0.05
"""Share of the greatest speed above which friction has its sign."""
CLIPPED = 0.95
"""Share of the limit from which a torque counts as clipped."""


@dataclass(frozen=True, slots=True)
class Beginning:
    """What a regression says.

    Attributes:
        values: `armature`, `coulomb`, `viscous`, `delay`.
        gains: kp and kd of every set of logs.
        lag: The delay in rows: the torque tells the command of so many rows before.
    """

    values: Mapping[str, float]
    gains: Sequence[tuple[float, float]]
    lag: int


def begin(
    recordings: Sequence[Recording],
    courses: Sequence[Course],
    bounds: Bounds,
    used: Sequence[int],
    gains: Sequence[tuple[float, float]] | None,
) -> Beginning:
    """First figures of a joint.

    Args:
        recordings: Its logs.
        courses: Links along them.
        bounds: Of the drive.
        used: Set of gains of every log, counted from 0.
        gains: kp and kd of every set; None: from the torque.
    """
    import numpy as np

    step = recordings[0].step
    found = None
    for lag in range(0, max(2, math.ceil(LONGEST / step)) + 1):
        tried = _tried(recordings, courses, bounds, used, gains, lag)
        if tried is not None and (found is None or tried[2] < found[2]):
            found = (*tried, lag)
    if found is None:
        zero = {"armature": 0.0, "coulomb": 0.0, "viscous": 0.0, "delay": 0.0}
        return Beginning(zero, gains or [(1.0, 0.1)] * (max(used) + 1), 0)
    values, pairs, _, lag = found
    pairs = [(max(kp, 1e-3), max(kd, 0.0)) for kp, kd in pairs]
    inertia = float(np.mean([course.inertia.mean() for course in courses]))
    values["armature"] = max(values["armature"], 0.01 * inertia)
    for name in ("coulomb", "viscous"):
        values[name] = max(values[name], 0.0)
    values["delay"] = max(lag - 0.5, 0.25) * step
    return Beginning(values, pairs, lag)


def _tried(
    recordings: Sequence[Recording],
    courses: Sequence[Course],
    bounds: Bounds,
    used: Sequence[int],
    gains: Sequence[tuple[float, float]] | None,
    lag: int,
) -> tuple[dict[str, float], Sequence[tuple[float, float]], float] | None:
    """Figures with a delay of so many rows, gains, and what is left of the variance."""
    import numpy as np

    drives: list[list[tuple[Array, Array]]] = [[] for _ in range(max(used) + 1)]
    sides = []
    for mine, recording, course in zip(used, recordings, courses, strict=True):
        error = course.command[np.maximum(np.arange(len(course.time)) - lag, 0)] - recording.position
        against = course.speed_command - recording.velocity
        motion = np.stack([recording.acceleration, recording.velocity, np.sign(recording.velocity)], axis=1)
        needed = course.inertia * recording.acceleration + course.load
        fast = np.abs(recording.velocity) > MOVES * np.abs(recording.velocity).max()
        if gains is None:
            torque = recording.measured["torque"]
            free = np.isfinite(torque) & (np.abs(torque) < CLIPPED * bounds.limit)
            drives[mine].append((np.stack([error, against, np.ones_like(error)], axis=1)[free], torque[free]))
            known = np.isfinite(torque)
        else:
            kp, kd = gains[mine]
            torque = bounds.clip(kp * error + kd * against, recording.velocity)
            known = np.isfinite(recording.measured["position"])
        sides.append((motion[fast & known], (torque - needed)[fast & known]))
    moved = regress(sides)
    if moved is None:
        return None
    found = dict(zip(("armature", "viscous", "coulomb"), moved[0], strict=True))
    if gains is not None:
        return found, gains, moved[1]
    solved = [regress(parts) for parts in drives]
    told = [one for one in solved if one is not None]
    if len(told) < len(solved):
        return None
    return found, [(one[0][0], one[0][1]) for one in told], sum(one[1] for one in told) / len(told)


def regress(parts: Sequence[tuple[Array, Array]]) -> tuple[list[float], float] | None:
    """Least squares, and the share of the variance that is left; None where there is nothing to tell from."""
    import numpy as np

    a = np.concatenate([part[0] for part in parts])
    b = np.concatenate([part[1] for part in parts])
    if len(b) < 4 * a.shape[1] or not np.var(b) > 0:
        return None
    scale = np.maximum(np.abs(a).max(axis=0), 1e-12)
    solved = np.linalg.lstsq(a / scale, b, rcond=1e-9)[0]
    left = float(np.sum((b - a / scale @ solved) ** 2) / np.sum((b - b.mean()) ** 2))
    return [float(value) for value in solved / scale], left
