"""Joints of one log pull at each other: how each moved, and what that makes of the load on the others.

The links come from MuJoCo at the rows of the log. Between two rows the others' accelerations jump where a command
arrives or a joint turns back, and the load bends: both are taken at several moments, and a joint's course has the
straight line with the same push and the same lever in time, which moves it as far and makes it as fast.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.sysid.course import Between, Course
from actspec.sysid.descent import Piecewise
from actspec.sysid.links import Links, links_along
from actspec.sysid.motion import Moved
from actspec.sysid.recording import SMOOTH, Recording, reading_noise, smooth
from actspec.sysid.stand import Stand

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MOMENT = 1.25e-3
"""Longest time between two moments between rows [s]. Chosen: jumps are told apart, at three times the work of 5 ms."""
POSE = 0.02
"""Time between two rows at which the slope of the load is taken [s]. Chosen: it follows the pose, and counts for the
path's noise alone."""
TRUSTED = 3.0
"""Most times the noise of the readings by which a fit may be off for its path to be taken in place of the readings'."""


@dataclass(frozen=True, slots=True)
class Path:
    """How a joint moved along a log, its encoder's bias taken off.

    Attributes:
        q: At the rows [rad or m], shape (n,).
        qd: Likewise [rad/s or m/s].
        acceleration: Likewise [rad/s^2 or m/s^2].
        parts: Mean acceleration, and position at the middle, of the parts into which the time after each row is
            divided, shape (n - 1, n_part) each; None: nobody knows more than by row.
    """

    q: Array
    qd: Array
    acceleration: Array
    parts: tuple[Array, Array] | None = None


def read(recording: Recording, bias: float) -> Path:
    """By the readings, smoothed."""
    return Path(recording.position - bias, recording.velocity, recording.acceleration)


def dense(pieces: Piecewise, recording: Recording) -> Piecewise:
    """The pieces with rows as dense as the moments between rows; only to be simulated."""
    count = _moments(recording)
    rows = (pieces.rows - 1) * count + 1
    return Piecewise(pieces.course.divided(count), {}, pieces.starts * count, rows, own=pieces.own)


def _moments(recording: Recording) -> int:
    return max(2, math.ceil(recording.step / MOMENT))


def _inside(signal: Array, count: int) -> Array:
    """A signal in the middle of so many parts of each row, by a straight line, shape (n - 1, count)."""
    import numpy as np

    found: Array = signal[:-1, None] + np.diff(signal)[:, None] * (np.arange(count) + 0.5) / count
    return found


def fitted(recording: Recording, bias: float, runs: Sequence[tuple[Piecewise, Moved]]) -> Path:
    """By a fit: what noise and the filter do to readings is not in it; outside of its pieces by the readings.

    Args:
        recording: Of the joint.
        bias: Of its encoder by the fit [rad or m].
        runs: Dense pieces of this recording, and how the joint moves along them.
    """
    import numpy as np

    count, before = _moments(recording), read(recording, bias)
    q, qd, acceleration = before.q.copy(), before.qd.copy(), before.acceleration.copy()
    pushes, middle = _inside(acceleration, count), _inside(q, count)
    off: list[Array] = []
    for pieces, moved in runs:
        for piece, start in enumerate(pieces.starts):
            time = pieces.course.time[start : start + pieces.rows]
            at, speed = moved.q[:, piece, 0], moved.qd[:, piece, 0]
            length = np.diff(time)
            mean = np.diff(speed) / length
            first, last = start // count, (start + pieces.rows - 1) // count
            pushes[first:last] = mean.reshape(-1, count)
            middle[first:last] = (0.5 * (at[:-1] + at[1:]) - 0.125 * length**2 * mean).reshape(-1, count)
            here = slice(first, last + 1)
            q[here], qd[here] = at[::count], speed[::count]
            ends = np.concatenate([mean[:1], 0.5 * (mean[:-1] + mean[1:]), mean[-1:]])
            acceleration[here] = ends[::count]
            off.append(before.q[here] - q[here])
    left = math.sqrt(float(np.mean(np.concatenate(off) ** 2))) if off else 0.0
    if left > TRUSTED * reading_noise([recording]):
        q, qd, middle = before.q, before.qd, _inside(before.q, count)
    return Path(q, qd, acceleration, (pushes, middle))


def links_of(
    stand: Stand,
    recordings: Sequence[Recording],
    paths: Sequence[Path],
    names: Sequence[str],
    width: float = SMOOTH,
) -> tuple[Links, list[Path]]:
    """The links along the paths of joints of one log, and the paths with those of other joints that move behind them.

    Args:
        stand: The model, and where its other joints are.
        recordings: Of the joints.
        paths: Likewise.
        names: Likewise.
        width: Of the filter of the others' readings [s].

    Raises:
        RobotError: see `links_along`.
    """
    import numpy as np

    first = recordings[0]
    robot, moving = stand.beside(first.log, names)
    every = [*paths, *(_beside(first, signal, width) for signal in moving.values())]
    base = first.log.sidecar.base
    q, qd = np.stack([path.q for path in every], axis=1), np.stack([path.qd for path in every], axis=1)
    rows = max(1, round(POSE / first.step))
    orientation = None if base is None else base.orientation
    return links_along(robot, [*names, *moving], q, qd, orientation, rows), every


def _beside(recording: Recording, position: Array, width: float) -> Path:
    """How a joint moves that is not fitted, by its readings at the log's rows."""
    import numpy as np

    time, known = recording.time, np.isfinite(position)
    read = np.interp(time, recording.log.time[known], position[known])
    q, qd, acceleration = (smooth(time, read, width, derivative) for derivative in range(3))
    count = _moments(recording)
    return Path(q, qd, acceleration, (_inside(acceleration, count), _inside(q, count)))


def course_of(recording: Recording, links: Links, paths: Sequence[Path], j: int) -> Course:
    """A joint's course: its own inertia, and a load in which the others' accelerations are.

    Args:
        recording: Of the joint.
        links: Along the paths.
        paths: Of all joints, in the order of the links; see `links_of`.
        j: Which of them it is.
    """
    rows = links.load[:, j].copy()
    for k, path in enumerate(paths):
        if k != j:
            rows += links.inertia[:, j, k] * path.acceleration
    return Course(
        recording.time,
        recording.command,
        recording.speed_command,
        links.inertia[:, j, j].copy(),
        rows,
        links.slope[:, j].copy(),
        paths[j].q,
        _between(recording.time, links, paths, j),
    )


def _between(time: Array, links: Links, paths: Sequence[Path], j: int) -> Between | None:
    """The lines between rows; None where a path is known by row alone."""
    import numpy as np
    from scipy.interpolate import CubicSpline

    parts = [path.parts for path in paths if path.parts is not None]
    if len(parts) < len(paths) or len(paths) < 2:
        return None
    count = parts[0][0].shape[1]
    shares = (np.arange(count) + 0.5) / count
    moments = time[:-1, None] + np.diff(time)[:, None] * shares
    dense = CubicSpline(time, np.column_stack([links.inertia[:, j], links.load[:, j]]))(moments)
    load = dense[:, :, -1]
    for k, (pushes, _) in enumerate(parts):
        if k != j:
            load = load + dense[:, :, k] * pushes
    return Between(_line(dense[:, :, j]), _line(load), _line(parts[j][1]))


def _line(values: Array) -> Array:
    """Begin and end of the straight line with the same mean and the same first moment, row by row, shape (n, 2)."""
    import numpy as np

    count = values.shape[1]
    away = (np.arange(count) + 0.5) / count - 0.5
    mean = values.mean(axis=1)
    # The parts' own extent takes 1/count^2 from the moment of a line.
    rise = 12.0 * (values * away).mean(axis=1) / (1.0 - 1.0 / count**2)
    found: Array = np.stack([mean - 0.5 * rise, mean + 0.5 * rise], axis=1)
    return found
