"""What a compiled model needs while it runs.

nets = networks("build/a1/mujoco", envs=4096)       # torques of networks, for arrays of any library
with attach(model, "build/a1/mujoco"): ...          # the same in plain MuJoCo, data.ctrl stays the position command
reset(model, data)                                  # drives at rest, without a jump
delta_action("nets/delta.json").wrap(env, state=f)  # a policy's actions, corrected before each step
"""

from __future__ import annotations

from actspec.learn.attach import Attached, attach
from actspec.learn.batch import Networks, networks
from actspec.learn.bundle import RuntimeFault
from actspec.learn.delta.files import DeltaFault
from actspec.learn.delta.runtime import CorrectedEnv, DeltaAction, delta_action
from actspec.learn.reset import reset

__all__ = [
    "Attached",
    "CorrectedEnv",
    "DeltaAction",
    "DeltaFault",
    "Networks",
    "RuntimeFault",
    "attach",
    "delta_action",
    "networks",
    "reset",
]
