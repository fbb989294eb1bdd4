"""How large an approximation is: the largest difference in torque between two laws.

Static fields: over speeds |w| <= 2 w0 and, at each speed, commands for which the unclamped drive
asks for -2 L to 2 L. (A range of the error alone, |e| <= 2 L/kp, would never ask for driving torque at
speed where kd is high, and so never see the torque-speed line.) Delay and filter: after a step of the
command of 0.5 L/kp with the joint held.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from actspec.ir import Command
from actspec.laws import TorqueLaw, clip_command

GRID = 81
"""Points a side. Chosen: odd, so that zero is among them; 81^2 laws take under a millisecond."""

Torque = Callable[[Any, Any, Any], Any]
"""(command, q, qd) to torque."""


def static_error(law: TorqueLaw, emitted: Torque, *, speed: float | None = None) -> float:
    """Largest |torque of law - torque of emitted| over the grid of torque asked for and speed.

    Args:
        law: What the spec asks for.
        emitted: What the target computes; same arguments as `TorqueLaw.torque`.
        speed: Half-width in speed [rad/s or m/s]; default 2 w0.
    """
    import numpy as np

    width = speed if speed is not None else 2.0 * speed_scale(law)
    half = 2.0 * _limit(law)
    torques, speeds = np.meshgrid(np.linspace(-half, half, GRID), np.linspace(-width, width, GRID))
    zero = np.zeros_like(torques)
    command = _command(law, torques, speeds)
    difference = np.abs(law.torque(command, zero, speeds) - emitted(command, zero, speeds))
    return float(difference.max())


def speed_scale(law: TorqueLaw) -> float:
    """w0: the no-load speed, else the speed at which kd alone takes the whole limit [rad/s or m/s]."""
    if law.curve is not None:
        return law.curve[3]
    if law.no_load_speed is not None:
        return law.no_load_speed
    return _limit(law) / law.kd if law.kd > 0 else 1.0


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

    half, zero = np.array(0.5 * _limit(law)), np.array(0.0)
    step = float(law.torque(_command(law, half, zero), zero, zero))
    if filtered and law.filter_cutoff is not None:
        step *= -math.expm1(-2.0 * math.pi * law.filter_cutoff * late)
    return abs(step)


def _command(law: TorqueLaw, torques: Any, speeds: Any) -> Any:
    """Commands for which the drive without its clamp gives these torques at position 0."""
    if law.command is Command.POSITION:
        return law.encoder_bias + ((torques + law.kd * speeds) / law.kp if law.kp > 0 else 0.0 * torques)
    if law.command is Command.VELOCITY:
        return torques / law.kd + speeds if law.kd > 0 else 0.0 * torques
    return torques


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
    """Largest difference that the clamp of the command makes at standstill.

    Args:
        law: With its `command_range`.
        positions: The joint's range [rad or m]; None: that of the command.
    """
    import numpy as np

    assert law.command_range is not None
    low, high = law.command_range
    ends = [end for end in (low, high) if math.isfinite(end)]
    half = 2.0 * (law.effort_limit if math.isfinite(law.effort_limit) else 1.0)
    gain = {Command.POSITION: law.kp, Command.VELOCITY: law.kd, Command.EFFORT: 1.0}[law.command]
    if gain <= 0.0 or not ends:
        return 0.0
    held = np.zeros(1)
    if law.command is Command.POSITION:
        held = np.linspace(*(positions or (min(ends), max(ends))), 41)
    q, asked = np.meshgrid(held, np.linspace(-half, half, 81))
    command = (q + law.encoder_bias if law.command is Command.POSITION else 0.0) + asked / gain
    still = np.zeros_like(command)
    clamped = clip_command(command, low=low, high=high)
    return float(np.abs(law.torque(command, q, still) - law.torque(clamped, q, still)).max())


def _limit(law: TorqueLaw) -> float:
    if math.isfinite(law.effort_limit):
        return law.effort_limit
    # Without a limit, the torque of an error of one radian (metre) stands in for it.
    return law.kp if law.kp > 0 else (law.kd if law.kd > 0 else 1.0)
