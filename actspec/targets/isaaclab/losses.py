"""How much torque an approximation of this target costs; see `targets/approximation.py` for the grid."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from actspec.ir import Command
from actspec.laws import TorqueLaw
from actspec.targets.approximation import Torque, static_error, widest_speed


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
