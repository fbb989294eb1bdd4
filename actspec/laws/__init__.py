"""The torque laws: the reference that every target is held to.

Pure functions over arrays: numpy, torch, jax or any array-API library in, the same out; Python
floats are computed by numpy. Everything is joint side and SI: torques [N*m] at a hinge and
[N] at a slide, positions [rad or m], speeds [rad/s or m/s]; positive speed and positive torque
point the same way. Shapes broadcast; a result has the broadcast shape of the arguments.

Order of one physics step: command clamp, delay, filter (`step_command`), PD, drive clamp
(`TorqueLaw.torque`); the passive part (`passive_torque`) is added outside of every clamp.
"""

from __future__ import annotations

from actspec.laws.actuator import TorqueLaw, law_of
from actspec.laws.arrays import Array, array_namespace
from actspec.laws.command import (
    MAX_DELAY_STEPS,
    CommandState,
    DelaySteps,
    clip_command,
    delay_steps,
    filter_gain,
    initial_command_state,
    step_command,
)
from actspec.laws.drive import (
    clip_asymmetric,
    clip_dc_motor,
    clip_effort,
    passive_torque,
    position_pd,
    velocity_pd,
)

__all__ = [
    "MAX_DELAY_STEPS",
    "Array",
    "CommandState",
    "DelaySteps",
    "TorqueLaw",
    "array_namespace",
    "clip_asymmetric",
    "clip_command",
    "clip_dc_motor",
    "clip_effort",
    "delay_steps",
    "filter_gain",
    "initial_command_state",
    "law_of",
    "passive_torque",
    "position_pd",
    "step_command",
    "velocity_pd",
]
