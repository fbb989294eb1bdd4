"""What a joint is commanded and the model along its path, by row, and when commands arrive. All in SI, at the joint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MOST_ARRIVALS = 3
"""Commands that may arrive between two rows. Chosen: a jitter of a whole step gives two."""


@dataclass(frozen=True, slots=True)
class Between:
    """The model between rows where it bends or jumps: the straight line that moves a joint as far and makes it as fast.

    Attributes:
        inertia: At the beginning and at the end of the time after each row, shape (n - 1, 2).
        load: Likewise.
        path: Likewise.
    """

    inertia: Array
    load: Array
    path: Array


@dataclass(frozen=True, slots=True)
class Course:
    """What a joint was commanded, and the model along its path; shape (n,) each, by row.

    Attributes:
        time: [s].
        command: Sent at the row's time [rad or m].
        speed_command: v* [rad/s or m/s].
        inertia: Of the links [kg*m^2 or kg].
        load: g, what the links need beside inertia, at `path` [N*m or N].
        slope: s = dg/dq [N*m/rad or N/m].
        path: q_ref, where load and slope hold [rad or m].
        between: What the model has between rows; None: a straight line from one to the next.
    """

    time: Array
    command: Array
    speed_command: Array
    inertia: Array
    load: Array
    slope: Array
    path: Array
    between: Between | None = None

    def ends(self, name: str) -> tuple[Array, Array]:
        """What the model has at the beginning and at the end of the time after each row, shape (n - 1,) each."""
        if self.between is not None and name != "slope":
            line: Array = getattr(self.between, name)
            return line[:, 0], line[:, 1]
        values: Array = getattr(self, name)
        return values[:-1], values[1:]

    def divided(self, parts: int) -> Course:
        """The same course with rows so many times as dense, in whose parts nothing else is sent."""
        import numpy as np

        share = np.arange(parts) / parts
        lines = {}
        for name in ("time", "inertia", "load", "slope", "path"):
            begin, end = (self.time[:-1], self.time[1:]) if name == "time" else self.ends(name)
            ends = [begin[:, None] + (end - begin)[:, None] * (share + more) for more in (0.0, 1.0 / parts)]
            lines[name] = np.stack([part.reshape(-1) for part in ends], axis=1)
        rows = {
            name: np.append(line[:, 0], self.time[-1] if name == "time" else getattr(self, name)[-1])
            for name, line in lines.items()
        }
        held = {
            name: np.append(np.repeat(getattr(self, name)[:-1], parts), getattr(self, name)[-1])
            for name in ("command", "speed_command")
        }
        return Course(**rows, **held, between=Between(lines["inertia"], lines["load"], lines["path"]))


@dataclass(frozen=True, slots=True)
class Parts:
    """The time between two rows, divided where commands arrive; shapes (n - 1, n_part, n_delay).

    Attributes:
        begin: As a share of the row.
        end: Likewise.
        index: Of the command that holds.
        before: Index of the command whose torque is read at each row, shape (n, n_delay).
    """

    begin: Array
    end: Array
    index: NDArray[np.intp]
    before: NDArray[np.intp]


def told(time: Array, delay: float) -> NDArray[np.intp]:
    """Index of the command that a torque read at each row tells, shape (n,).

    Args:
        time: Of the rows [s].
        delay: [s]. A command that arrives at a row's time is not in what is read then.
    """
    import numpy as np

    sent = np.searchsorted(time + delay, time - 1e-9, side="left") - 1
    return np.clip(sent, 0, None)


def parts_of(time: Array, delays: Array) -> Parts:
    """The time between rows, divided where commands arrive that were sent at the rows.

    Args:
        time: Of the rows [s].
        delays: [s].
    """
    import numpy as np

    start, length = time[:-1], np.diff(time)
    per_delay = []
    for delay in delays:
        arrival = time + delay
        # What arrives at a row's time acts from then on, and is not in what is read then.
        first = np.searchsorted(arrival, start + 1e-9, side="right")
        last = np.searchsorted(arrival, time[1:] - 1e-9, side="left")
        per_delay.append((arrival, first, last, told(time, delay)))
    count = min(max(int((last - first).max()) for _, first, last, _ in per_delay), MOST_ARRIVALS)
    shape = (len(start), count + 1, len(delays))
    begin, end, index = np.empty(shape), np.empty(shape), np.empty(shape, dtype=np.intp)
    for d, (arrival, first, last, _) in enumerate(per_delay):
        for k in range(count + 1):
            left = arrival[np.clip(first + k - 1, 0, len(arrival) - 1)]
            right = arrival[np.clip(first + k, 0, len(arrival) - 1)]
            begin[:, k, d] = 0.0 if k == 0 else np.where(first + k - 1 < last, (left - start) / length, 1.0)
            inside = (first + k < last) if k < count else np.zeros(len(start), dtype=bool)
            end[:, k, d] = np.where(inside, (right - start) / length, 1.0)
            index[:, k, d] = np.clip(first + k - 1, 0, len(arrival) - 1)
    before_all = np.stack([before for *_, before in per_delay], axis=1)
    return Parts(begin, end, index, before_all)
