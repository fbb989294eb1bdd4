"""What the law says to a motion: the reference for every engine's torque."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from actspec.ir import JointActuator
from actspec.laws import (
    TorqueLaw,
    clip_command,
    delay_steps,
    filter_gain,
    initial_command_state,
    step_command,
)
from actspec.verify.motion import Motion

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


def lags(law: TorqueLaw, actuator: JointActuator, step: float, *, ranged: bool) -> tuple[int, ...]:
    """Delays that are right, in physics steps.

    Args:
        law: Of the joint.
        actuator: Likewise.
        step: Physics step [s].
        ranged: Whether the engine draws a delay from the range; else it has the nominal one.
    """
    delay = actuator.delay
    if ranged and delay is not None and delay.low != delay.high:
        low, high = (delay_steps(end, step).steps for end in (delay.low, delay.high))
        return tuple(range(low, high + 1))
    return (delay_steps(law.delay, step).steps,)


def torques(law: TorqueLaw, motion: Motion, column: int, step: float, steps: int) -> Array:
    """The law's torque in each step and environment [N*m or N], shape (n_step, n_env).

    Args:
        law: Of the joint.
        motion: What it is told and does.
        column: Of the joint in the motion.
        step: Physics step [s].
        steps: Delay in physics steps.
    """
    import numpy as np

    low, high = law.command_range or (-math.inf, math.inf)
    given = np.asarray(clip_command(motion.command[:, :, column], low=low, high=high))
    q, qd = motion.q[:, :, column], motion.qd[:, :, column]
    alpha = None if law.filter_cutoff is None else filter_gain(law.filter_cutoff, step)
    state = initial_command_state(given[0], steps)
    found = np.empty_like(q)
    for k in range(len(given)):
        effective, state = step_command(state, given[k], steps=steps, alpha=alpha)
        found[k] = law.torque(effective, q[k], qd[k])
    return found
