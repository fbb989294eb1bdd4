"""How large an approximation is: the largest difference in torque between two laws.

Static fields: over speeds |w| <= 2 w0 and, at each speed, commands for which the unclamped drive
asks for -2 L to 2 L. (A range of the error alone, |e| <= 2 L/kp, would never ask for driving torque at
speed where kd is high, and so never see the torque-speed line.) Delay and filter: after a step of the
command of 0.5 L/kp with the joint held.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from actspec.ir import Command
from actspec.laws import TorqueLaw, clip_command
from actspec.resolution.simplified import NEGLIGIBLE
from actspec.simulate.excitation import command_for, own_speed, speed_scale, torque_scale
from actspec.units import format_quantity

GRID = 40
"""Points on either side of 0, which is among them.

Chosen: 81^2 laws take under a millisecond; finer grids find a few per cent more.
"""

Torque = Callable[[Any, Any, Any], Any]
"""(command, q, qd) to torque."""


def static_error(
    law: TorqueLaw, emitted: Torque, *, speed: float | None = None, position: float = 0.0
) -> float:
    """Largest |torque of law - torque of emitted| over the grid of torque asked for and speed.

    Args:
        law: What the spec asks for.
        emitted: What the target computes; same arguments as `TorqueLaw.torque`.
        speed: Half-width in speed [rad/s or m/s]; default 2 w0.
        position: Where the joint is [rad or m].
    """
    width = speed if speed is not None else 2.0 * speed_scale(law)
    return float(_differences(law, emitted, width, position)[2].max())


def _differences(
    law: TorqueLaw, emitted: Torque, width: float, position: float = 0.0
) -> tuple[Any, Any, Any]:
    """The grid's torques asked for and speeds, and |torque of law - torque of emitted| there."""
    import numpy as np

    # Standstill must be exact: an asymmetric curve holds its joint with the brake torque.
    parts = np.arange(-GRID, GRID + 1) / GRID
    torques, speeds = np.meshgrid(2.0 * torque_scale(law) * parts, width * parts)
    q = np.full_like(torques, position)
    command = command_for(law, torques, q, speeds)
    return torques, speeds, np.abs(law.torque(command, q, speeds) - emitted(command, q, speeds))


@dataclass(frozen=True, slots=True)
class LineError:
    """How large the loss of a torque-speed line or curve is, and where.

    Attributes:
        error: Largest difference up to no-load speed, which no motor passes by itself [N*m or N].
        at: Where that is: `driving at 20.9 rad/s`, and whether the other of driving and braking is right; "" where
            there is none.
        beyond: Largest difference from there to 2 w0, where a load drives the motor [N*m or N].
    """

    error: float
    at: str
    beyond: float


def line_error(law: TorqueLaw, emitted: Torque, unit: str) -> LineError:
    """The loss of a line or curve, over the grid of `static_error`; of equal differences that at the lowest speed.

    Args:
        law: What the spec asks for, with its line or curve.
        emitted: What the target computes.
        unit: Of a speed.
    """
    import numpy as np

    w0 = speed_scale(law)
    torques, speeds, difference = _differences(law, emitted, 2.0 * w0)
    inside = np.abs(speeds) <= w0
    error, beyond = float(difference[inside].max()), float(difference[~inside].max())
    if error <= NEGLIGIBLE * torque_scale(law):
        return LineError(0.0, "", beyond)
    worst = inside & (difference >= error * (1.0 - NEGLIGIBLE))
    slowest = np.abs(speeds[worst]).min()
    here = worst & (np.abs(speeds) == slowest)
    speed = format_quantity(float(slowest), unit, 3)
    driving, braking = (sign * torques * speeds > 0.0 for sign in (1.0, -1.0))
    if not here[driving].any() and not here[braking].any():
        return LineError(error, "at standstill", beyond)
    if here[driving].any() and here[braking].any():
        return LineError(error, f"at {speed}", beyond)
    way, other, none = "driving", braking, "braking"
    if here[braking].any():
        way, other, none = "braking", driving, "driving"
    rest = float(difference[inside & other].max())
    tail = "" if rest > NEGLIGIBLE * torque_scale(law) else f", none {none}"
    return LineError(error, f"{way} at {speed}{tail}", beyond)


def widest_speed(law: TorqueLaw, velocity_limit: float | None) -> float | None:
    """Speed up to which a loss that grows with speed is sized: 2 w0, else the joint's limit [rad/s or m/s].

    Args:
        law: What the spec asks for.
        velocity_limit: The joint's speed limit [rad/s or m/s]; None: unknown.

    Returns: None where neither is known: such a loss has no size.
    """
    own = own_speed(law)
    return velocity_limit if own is None else 2.0 * own


def viscous_error(law: TorqueLaw, change: float, velocity_limit: float | None) -> float | None:
    """Largest torque of a change of the passive viscous friction [N*m or N]; None: no speed is known.

    Args:
        law: What the spec asks for.
        change: Of the friction [N*m*s/rad or N*s/m].
        velocity_limit: The joint's speed limit [rad/s or m/s]; None: unknown.
    """
    widest = widest_speed(law, velocity_limit)
    return None if widest is None else abs(change) * widest


def held_step_error(law: TorqueLaw, *, filtered: bool = False, late: float = math.inf) -> float:
    """Largest difference in torque after a step of the command of 0.5 L/kp, the joint held.

    Where one path has the command already and the other still has none of it, that is the whole
    0.5 L (or what the law gives of it at standstill). Behind a filter that both paths have, the
    later one has caught up with the start of the step before the earlier one is through.

    Args:
        law: What the spec asks for.
        filtered: Whether the law's filter is emitted too.
        late: How far apart the two paths are in time [s].
    """
    import numpy as np

    half, zero = np.array(0.5 * torque_scale(law)), np.array(0.0)
    step = float(law.torque(command_for(law, half, zero, zero), zero, zero))
    if filtered and law.filter_cutoff is not None:
        step *= -math.expm1(-2.0 * math.pi * law.filter_cutoff * late)
    return abs(step)


def lined(law: TorqueLaw) -> TorqueLaw:
    """The drive side of an asymmetric curve as a torque-speed line, cut at the lesser of the two limits."""
    if law.curve is None:
        return law
    drive, _, knee, no_load = law.curve
    # A cliff has no slope that a line could have: a steep one stands in for it.
    share = max(1.0 - knee / no_load, 1e-3) if no_load > 0 else 1.0
    return replace(
        law,
        curve=None,
        stall_torque=drive / share,
        no_load_speed=no_load,
        effort_limit=min(law.effort_limit, drive),
    )


def command_range_error(law: TorqueLaw, positions: tuple[float, float] | None) -> float:
    """Largest difference that the clamp of the command makes, over the grid of `static_error` at both ends.

    Behind a clamp the drive's torque only falls with the position, so it differs most at an end of the range.

    Args:
        law: With its `command_range`.
        positions: The joint's range [rad or m]; None: that of the command.
    """

    assert law.command_range is not None
    low, high = law.command_range
    ends = [end for end in (low, high) if math.isfinite(end)]
    if not ends:
        return 0.0
    held = (positions or (min(ends), max(ends))) if law.command is Command.POSITION else (0.0,)

    def clamped(command: Any, q: Any, qd: Any) -> Any:
        return law.torque(clip_command(command, low=low, high=high), q, qd)

    return max(static_error(law, clamped, position=position) for position in held)


def unclipped(law: TorqueLaw) -> TorqueLaw:
    """The drive without limit, line and curve."""
    return replace(law, effort_limit=math.inf, stall_torque=None, no_load_speed=None, curve=None)


def boxed(law: TorqueLaw) -> TorqueLaw:
    """The drive with its effort limit alone."""
    return replace(law, stall_torque=None, no_load_speed=None, curve=None)


def two_quadrants(law: TorqueLaw) -> Torque:
    """The DC motor of Isaac Lab 2.1: either limit ends at 0, so it does not brake above no-load speed.

    hi = clip(ts (1 - w/w0), 0, L), lo = clip(ts (-1 - w/w0), -L, 0).

    Source:
        Isaac Lab issue 2103, which quotes the code; changed by extension 0.44.
    """
    free = unclipped(law)
    stall, no_load, limit = law.stall_torque, law.no_load_speed, law.effort_limit
    assert stall is not None and no_load is not None

    def torque(command: Any, q: Any, qd: Any) -> Any:
        import numpy as np

        high = np.clip(stall * (1.0 - qd / no_load), 0.0, limit)
        low = np.clip(stall * (-1.0 - qd / no_load), -limit, 0.0)
        return np.clip(free.torque(command, q, qd), low, high)

    return torque


def at_standstill(law: TorqueLaw) -> Torque:
    """The law with its clamp at speed 0, whatever the speed."""
    free, clamp = unclipped(law), replace(law, command=Command.EFFORT)

    def torque(command: Any, q: Any, qd: Any) -> Any:
        return clamp.torque(free.torque(command, q, qd), q, 0.0 * qd)

    return torque


def summed_viscous_error(law: TorqueLaw, viscous: float, velocity_limit: float | None) -> float | None:
    """Passive friction inside the drive's clamp in place of outside of it; None: no speed is known."""
    widest = widest_speed(law, velocity_limit)
    if widest is None:
        return None
    free, clamp = unclipped(law), replace(law, command=Command.EFFORT)

    def torque(command: Any, q: Any, qd: Any) -> Any:
        # The friction that the law has beside its drive, on both sides of the comparison.
        return clamp.torque(free.torque(command, q, qd) - viscous * qd, q, qd) + viscous * qd

    return static_error(law, torque, speed=widest)
