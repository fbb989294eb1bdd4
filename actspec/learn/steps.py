"""Steps of a command, which a spline through readings blurs: the torque jumps with them, between two rows.

Readings tell such a jump over several rows. Its moment and its size are in the log: a delay after the command's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.learn.spline import spline
from actspec.learn.windows import LONGEST

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

FINE = 0.001
"""Steps in which it is looked for [s]."""
ROWS = 2000
"""Rows of a joint in a log that tell it. Chosen: 10 s at 200 Hz, of every joint."""
EXPLAINED = 0.5
"""Least share of a torque's variance that a law of command, position and speed must explain. Chosen: half."""


@dataclass(frozen=True, slots=True)
class Course:
    """A joint's torque as its motion tells it.

    Attributes:
        sent: Times of the rows [s], shape (m,).
        command: Held from each of them on [rad or m], likewise.
        time: Of what follows [s], shape (n,).
        position, velocity: [rad or m], [rad/s or m/s], likewise.
        torque: Blurred [N*m or N], likewise; NaN where it is not told.
        slides: Where dry friction leaves nothing open, likewise.
        stiff: Of the spline that the acceleration was taken from.
        order: Of the derivative that was taken.
    """

    sent: Array
    command: Array
    time: Array
    position: Array
    velocity: Array
    torque: Array
    slides: NDArray[np.bool_]
    stiff: float
    order: int

    def arrived(self, delay: float, rows: slice = slice(None)) -> tuple[Array, Array]:
        """The command a delay ago, and the same as the spline blurs it, shapes (n,)."""
        import numpy as np

        at = self.time[rows] - delay
        level = float(self.command.mean())
        # A torque is read before the command of its own row is sent.
        late = np.searchsorted(self.sent, at - 1e-9, side="right") - 1
        now = self.command[np.maximum(late, 0)] - level
        # Of a command that is held, each integral is a polynomial between two rows.
        steps = np.diff(self.sent, append=self.sent[-1] + 1.0)
        once = np.concatenate([[0.0], np.cumsum((self.command - level) * steps)])[:-1]
        since = np.where(late < 0, at - self.sent[0], at - self.sent[np.maximum(late, 0)])
        first = once[np.maximum(late, 0)] + now * since
        if self.order == 2:
            twice = np.concatenate([[0.0], np.cumsum(once * steps + 0.5 * (self.command - level) * steps**2)])
            start = np.maximum(late, 0)
            first = twice[start] + once[start] * since + 0.5 * now * since**2
        return now, np.asarray(
            spline(self.time[rows], first, self.stiff).derivative(self.order)(self.time[rows])
        )


def sharpened(courses: Sequence[Sequence[Course]], limits: Sequence[float]) -> list[list[Array]]:
    """Torques with the command's steps in them, of courses of each joint.

    One delay is looked for in all, and a stiffness in each joint: those with which a blurred command, position and
    speed explain most of the blurred torques. What the spline took from the command comes back times that stiffness.
    A joint whose torque they do not explain stays as it is.

    Args:
        courses: Of each joint, those of its logs.
        limits: Of each joint's torque [N*m or N]: what comes back does not lead beyond.
    """
    import numpy as np

    coarse = np.arange(0.0, LONGEST + 1e-9, 5.0 * FINE)
    left = [sum(_left(mine, delay)[0] for mine in courses) for delay in coarse]
    around = coarse[int(np.argmin(left))] + FINE * np.arange(-4, 5)
    fine = around[around >= 0.0]
    delay = float(fine[int(np.argmin([sum(_left(mine, d)[0] for mine in courses) for d in fine]))])
    found = []
    for mine, limit in zip(courses, limits, strict=True):
        share, stiffness = _left(mine, delay)
        torques = [course.torque for course in mine]
        if share < 1.0 - EXPLAINED and stiffness > 0.0:
            for k, course in enumerate(mine):
                now, blurred = course.arrived(delay)
                sharp = torques[k] + stiffness * (now - blurred)
                most = np.maximum(np.abs(torques[k]), limit)
                torques[k] = np.clip(sharp, -most, most)
        found.append(torques)
    return found


def _left(courses: Sequence[Course], delay: float) -> tuple[float, float]:
    """Share of a joint's variance that is left, and its stiffness [N*m/rad or N/m]."""
    import numpy as np

    parts, torques = [], []
    for course in courses:
        rows = slice(0, ROWS)
        _, blurred = course.arrived(delay, rows)
        told = course.slides[rows] & np.isfinite(course.torque[rows])
        columns = (blurred, course.position[rows], course.velocity[rows], np.ones(len(blurred)))
        parts.append(np.stack(columns, axis=1)[told])
        torques.append(course.torque[rows][told])
    a, b = np.concatenate(parts), np.concatenate(torques)
    if len(b) < 10 * a.shape[1] or not np.var(b) > 0.0:
        return 1.0, 0.0
    solved = np.linalg.lstsq(a, b, rcond=None)[0]
    share = float(np.sum((b - a @ solved) ** 2) / np.sum((b - b.mean()) ** 2))
    return min(share, 1.0) if math.isfinite(share) else 1.0, float(solved[0])
