"""The command path: clamp, delay in whole steps, first-order filter."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from actspec.laws.arrays import Array, between, out, same

MAX_DELAY_STEPS = 1_000_000
"""Longest delay line, so that a delay of years in a stranger's file cannot fill the memory. Chosen."""


def clip_command(command: Array, *, low: Array, high: Array) -> Array:
    """Clamp a command to the spec's `command_range`; before delay and filter.

    Args:
        command: [rad or m], [rad/s or m/s] or [N*m or N].
        low: Least command, in the command's unit.
        high: Largest command, in the command's unit.

    Returns:
        The command within the range.

    Source:
        DESIGN section 5; MuJoCo `ctrlrange`. Before or after the delay is the same.
    """
    xp, (u, lo, hi) = same(command, low, high)
    return out(xp, between(xp, u, lo, hi))


def filter_gain(cutoff: float, step: float) -> float:
    """Share of the way that a first-order low-pass goes in one step.

    alpha = 1 - exp(-h/tau), tau = 1/(2 pi cutoff).

    Args:
        cutoff: -3 dB frequency > 0 [Hz], not [rad/s].
        step: Time step h > 0 [s].

    Returns:
        alpha, above 0 and at most 1.

    Raises:
        ValueError: cutoff or step is not positive and finite.

    Source:
        DESIGN section 5; MuJoCo `dyntype="filterexact"` (`filter` has h/tau, which diverges for h > 2 tau).
    """
    _require_positive("cutoff", cutoff, "Hz")
    _require_positive("step", step, "s")
    return -math.expm1(-2.0 * math.pi * cutoff * step)


SAME_STEP = 0.01
"""Share of a step by which a delay may be off whole steps and nothing is lost. Chosen: a simulator knows no time
between its steps, logs tell no delay that closely, and a loss as large as a command's jump would be a false alarm."""


class DelaySteps(NamedTuple):
    """A delay in whole steps.

    Attributes:
        steps: Number of steps.
        loss: steps * h - delay [s]; positive: later than asked for; 0 within `SAME_STEP` of a step.
    """

    steps: int
    loss: float


def delay_steps(delay: float, step: float) -> DelaySteps:
    """Round a delay to the nearest whole number of steps; half a step rounds up.

    Args:
        delay: >= 0 [s].
        step: Time step h > 0 [s].

    Returns:
        The steps, and what the rounding costs [s].

    Raises:
        ValueError: delay negative, not finite or above `MAX_DELAY_STEPS`, or step not positive and finite.

    Source:
        DESIGN section 5, n = delay/h. Half up is chosen: MuJoCo's zero-order hold rounds 2.5 steps up to 3.
    """
    _require_positive("step", step, "s")
    if not (math.isfinite(delay) and delay >= 0):
        raise ValueError(f"delay must be finite and >= 0 s, got {delay:g} s")
    if delay / step > MAX_DELAY_STEPS:
        raise ValueError(f"delay must be at most {MAX_DELAY_STEPS} steps of {step:g} s, got {delay:g} s")
    # The quotient of two decimals may come out a hair below the half, the loss a hair off zero.
    steps = math.floor(delay / step + 0.5 + 1e-9)
    loss = steps * step - delay
    return DelaySteps(steps, 0.0 if abs(loss) <= SAME_STEP * step else loss)


@dataclass(frozen=True, slots=True)
class CommandState:
    """What the command path remembers between two steps.

    Attributes:
        line: Commands on their way through the delay, oldest first, newest last; as many as delay steps.
        filtered: Filter state a_k, in the command's unit.
    """

    line: tuple[Array, ...]
    filtered: Array


def initial_command_state(first_command: Array, steps: int) -> CommandState:
    """State before the first step: the line is full of the first command, and a_0 is it.

    Args:
        first_command: First command of the episode, in the command's unit.
        steps: Delay in steps, >= 0.

    Returns:
        The state.

    Raises:
        ValueError: steps is negative or above `MAX_DELAY_STEPS`.

    Source:
        DESIGN section 5. (MuJoCo after a bare reset starts both at 0, and the robot jumps.)
    """
    if not 0 <= steps <= MAX_DELAY_STEPS:
        raise ValueError(f"delay must be 0 to {MAX_DELAY_STEPS} steps, got {steps}")
    command = _kept(first_command)
    return CommandState((command,) * steps, command)


def step_command(
    state: CommandState, command: Array, *, steps: int, alpha: Array | None
) -> tuple[Array, CommandState]:
    """One step of the command path: delay, then filter.

    u_k is the command of `steps` steps ago. The torque of step k uses a_k before its update,
    a_(k+1) = a_k + alpha (u_k - a_k); without a filter it uses u_k itself.

    Args:
        state: State before the step.
        command: Command of this step, in the command's unit.
        steps: Delay in steps, as in `initial_command_state`.
        alpha: Share of `filter_gain`; None: no filter.

    Returns:
        The effective command of this step, and the state for the next one.

    Raises:
        ValueError: `steps` is not the length of the state's line.

    Source:
        DESIGN section 5; MuJoCo `filterexact` with `actearly` false, and its native delay.
    """
    if steps != len(state.line):
        raise ValueError(f"the state holds a delay of {len(state.line)} steps, asked for {steps}")
    newest = _kept(command)
    line = (*state.line, newest)
    u, line = line[0], line[1:]
    if alpha is None:
        return u, CommandState(line, u)
    xp, (a, target, share) = same(state.filtered, u, alpha)
    return state.filtered, CommandState(line, out(xp, a + share * (target - a)))


def _kept(command: Array) -> Array:
    """A copy: callers reuse their command buffer, and the line must not change with it."""
    copy = getattr(command, "clone", None) or getattr(command, "copy", None)
    return command if copy is None else copy()


def _require_positive(name: str, value: float, unit: str) -> None:
    if not (math.isfinite(value) and value > 0):
        raise ValueError(f"{name} must be finite and > 0 {unit}, got {value:g} {unit}")
