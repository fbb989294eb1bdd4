"""What each actuator is commanded, alone on its inertia: a step, a swing and a chirp worth shares of its own torque.

- `step`: worth 0.5 L, which the drive can follow.
- `swing`: worth 2 L, which meets the limit and, at speed, the torque-speed line.
- `chirp`: 0.25 L, from far below to beyond the closed loop's bandwidth, then back to where it began.

The command is one number a physics step, and begins after `BEFORE` steps.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from actspec.ir import Command
from actspec.laws import TorqueLaw
from actspec.simulate.excitation import BEFORE, chirp, command_for, rest_position, stepped, torque_scale
from actspec.simulate.experiment import CHIRP, SAMPLES, SATURATED, STEP

if TYPE_CHECKING:
    from actspec.laws.arrays import Floats as Array

SHARES = {"step": STEP, "swing": SATURATED, "chirp": CHIRP}
"""Of the effort limit, by course: those of `verify`'s responses."""
SWEPT = (0.1, 3.0)
"""Frequencies of the chirp, as parts of the closed loop's bandwidth. Chosen: −3 dB lies well inside."""
RETURN = 0.35
"""Last part of a chirp's time in which the command is back at the start, so that the answer ends too. Chosen."""


def amplitude(law: TorqueLaw, course: str) -> float:
    """How far a course's command goes [rad or m; rad/s or m/s for a velocity drive]."""
    at = rest_position(law)
    there, back = (command_for(law, torque, at, 0.0) for torque in (SHARES[course] * torque_scale(law), 0.0))
    return float(there - back)


def sweep(laws: Iterable[TorqueLaw], viscous: float, inertia: float, step: float) -> tuple[float, float]:
    """First and last frequency of the chirp that several laws of one joint take [rad/s].

    Args:
        laws: Of its variants.
        viscous: Friction of the joint [N*m*s/rad or N*s/m].
        inertia: J [kg*m^2 or kg].
        step: Physics step [s].
    """
    widths = [closed_loop_bandwidth(law, viscous, inertia) for law in laws]
    high = min(SWEPT[1] * max(widths), 2.0 * math.pi / (SAMPLES * step))
    return min(SWEPT[0] * min(widths), 0.2 * high), high


def closed_loop_bandwidth(law: TorqueLaw, viscous: float, inertia: float) -> float:
    """Roughly where the answer is 3 dB down [rad/s]: of the linear loop, and less with a filter before it.

    Source: a second-order system 1 / (1 + 2 zeta s + s^2), s = w / wn, has it at
        wn sqrt(1 - 2 zeta^2 + sqrt(4 zeta^4 - 4 zeta^2 + 2)).
    """
    damping = law.kd + viscous
    if law.command is Command.POSITION and law.kp > 0.0:
        rate = math.sqrt(law.kp / inertia)
        zeta2 = (damping / (2.0 * inertia * rate)) ** 2
        # The same without a difference of large numbers, for a drive that is damped far beyond critical.
        inner = 1.0 - 2.0 * zeta2
        root = math.sqrt(inner * inner + 1.0)
        width = rate * math.sqrt(inner + root if inner > 0 else 1.0 / (root - inner))
    else:
        width = damping / inertia
    if law.filter_cutoff is not None:
        width = 1.0 / (1.0 / width + 1.0 / (2.0 * math.pi * law.filter_cutoff))
    return width


def commands(law: TorqueLaw, swept: tuple[float, float], step: float, duration: float) -> Mapping[str, Array]:
    """The command of each course, one number a physics step, shape (n_step,).

    Args:
        law: Of the joint.
        swept: First and last frequency of the chirp [rad/s].
        step: Physics step [s].
        duration: From the command's change on [s].
    """
    import numpy as np

    n = BEFORE + max(round(duration / step), 2)
    at, limit = np.full(n, rest_position(law)), torque_scale(law)
    swing = np.zeros(n)
    moving = max(round((1.0 - RETURN) * (n - BEFORE)), 2)
    swing[BEFORE : BEFORE + moving] = chirp(moving, step, *swept)
    shapes = {"step": stepped(n), "swing": stepped(n), "chirp": swing}
    return {
        name: command_for(law, SHARES[name] * limit * shape, at, np.zeros(n))
        for name, shape in shapes.items()
    }
