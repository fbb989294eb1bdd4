"""Where a descent begins: figures by linear regression, the delay by trying every whole number of rows."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.sysid.motion import Bounds, Course
from actspec.sysid.recording import Recording

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

LONGEST = 0.06
"""Longest delay that is tried [s]. Chosen: slower drives are not position-controlled."""
CLIPPED = 0.95
"""Share of the limit from which a torque counts as clipped."""


@dataclass(frozen=True, slots=True)
class Beginning:
    """What a regression says.

    Attributes:
        values: `kp`, `kd`, `armature`, `coulomb`, `viscous`, `delay`.
        lag: The delay in rows: the torque tells the command of so many rows before.
        unexplained: Share of the torque's variance that is left.
        against: Whether the torque pulls away from the command.
    """

    values: Mapping[str, float]
    lag: int
    unexplained: float
    against: bool = False


def begin(
    recordings: Sequence[Recording],
    courses: Sequence[Course],
    bounds: Bounds,
    gains: tuple[float, float] | None,
) -> Beginning:
    """First figures of a joint.

    Args:
        recordings: Its logs.
        courses: Links along them.
        bounds: Of the drive.
        gains: kp and kd where they are held; None: from the torque.
    """
    import numpy as np

    step = recordings[0].step
    found = None
    for lag in range(0, max(2, math.ceil(LONGEST / step)) + 1):
        tried = _tried(recordings, courses, bounds, gains, lag)
        if tried is not None and (found is None or tried[1] < found[1]):
            found = (tried[0], tried[1], lag)
    if found is None:
        values = {"kp": 1.0, "kd": 0.1} if gains is None else dict(zip(("kp", "kd"), gains, strict=True))
        return Beginning({**values, "armature": 0.0, "coulomb": 0.0, "viscous": 0.0, "delay": 0.0}, 0, 1.0)
    values, left, lag = found
    against = values["kp"] < 0.0 and left < 0.5
    values["kp"], values["kd"] = max(values["kp"], 1e-3), max(values["kd"], 0.0)
    inertia = float(np.mean([course.inertia.mean() for course in courses]))
    values["armature"] = max(values["armature"], 0.01 * inertia)
    for name in ("coulomb", "viscous"):
        values[name] = max(values[name], 0.0)
    values["delay"] = max(lag - 0.5, 0.25) * step
    return Beginning(values, lag, left, against)


def _tried(
    recordings: Sequence[Recording],
    courses: Sequence[Course],
    bounds: Bounds,
    gains: tuple[float, float] | None,
    lag: int,
) -> tuple[dict[str, float], float] | None:
    """Figures with a delay of so many rows, and what is left of the variance."""
    import numpy as np

    drives, sides = [], []
    for recording, course in zip(recordings, courses, strict=True):
        error = course.command[np.maximum(np.arange(len(course.time)) - lag, 0)] - recording.position
        against = course.speed_command - recording.velocity
        motion = np.stack([recording.acceleration, recording.velocity, np.sign(recording.velocity)], axis=1)
        needed = course.inertia * recording.acceleration + course.load
        fast = np.abs(recording.velocity) > 0.05 * np.abs(recording.velocity).max()
        if gains is None:
            torque = recording.measured["torque"]
            free = np.isfinite(torque) & (np.abs(torque) < CLIPPED * bounds.limit)
            drives.append((np.stack([error, against, np.ones_like(error)], axis=1)[free], torque[free]))
            known = np.isfinite(torque)
        else:
            torque = bounds.clip(gains[0] * error + gains[1] * against, recording.velocity)
            known = np.isfinite(recording.measured["position"])
        sides.append((motion[fast & known], (torque - needed)[fast & known]))
    found: dict[str, float] = {}
    left = 1.0
    if gains is None:
        solved = _regress(drives)
        if solved is None:
            return None
        (found["kp"], found["kd"], _), left = solved
    else:
        found["kp"], found["kd"] = gains
    moved = _regress(sides)
    if moved is None:
        return None
    (found["armature"], found["viscous"], found["coulomb"]), of_motion = moved
    return found, left if gains is None else of_motion


def _regress(parts: Sequence[tuple[Array, Array]]) -> tuple[list[float], float] | None:
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
