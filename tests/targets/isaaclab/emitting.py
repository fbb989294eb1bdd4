"""Compile groups for Isaac Lab, and read the module back without running it."""

from __future__ import annotations

import ast
from typing import Any

from tests.frameworks.isaaclab_asking import Emitted, compiled

SPEC = """actspec: 1
robot: {{name: {name}, model: none, joints: [{joints}]{robot}}}
timing: {{physics_dt: 5 ms, decimation: 4}}
motors:
  m: {{side: joint, stall_torque: 45 N*m, no_load_speed: 30 rad/s, peak_torque: 24 N*m}}
  small: {{side: joint, stall_torque: 30 N*m, no_load_speed: 25 rad/s, peak_torque: 24 N*m}}
actuators: {{{groups}}}
"""

PD = "level: ideal_pd, kp: 20 N*m/rad, kd: 0.5 N*m*s/rad, effort_limit: 9 N*m"
DC = "motor: m, level: dc_motor, kp: 20 N*m/rad, kd: 0.5 N*m*s/rad, effort_limit: 9 N*m"


def made(
    groups: str,
    version: str = "2.3",
    cls: str | dict[str, str] = "auto",
    *,
    joints: str = "a_hip, b_hip, a_knee, b_knee",
    name: str = "bot",
    robot: str = "",
    **more: Any,
) -> Emitted:
    """Compile groups in flow style."""
    text = SPEC.format(name=name, joints=joints, groups=groups, robot=robot)
    return compiled(text, version, cls, **more)


def cfgs(text: str) -> dict[str, dict[str, Any]]:
    """The groups of a module, read by its syntax tree: class and keywords, nothing executed."""
    for node in ast.parse(text).body:
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Dict):
            found = {}
            for key, call in zip(node.value.keys, node.value.values, strict=True):
                assert isinstance(key, ast.Constant) and isinstance(call, ast.Call)
                assert isinstance(call.func, ast.Name)
                keywords = {str(k.arg): ast.literal_eval(k.value) for k in call.keywords}
                found[str(key.value)] = {"class": call.func.id, **keywords}
            return found
    raise AssertionError("the module has no dict")


def lost(emitted: Emitted, joint: str = "a_hip") -> dict[str, float | None]:
    """Field to size of what one joint loses."""
    found = [a for a in emitted.emission.approximations if a.joint == joint]
    assert len({a.field for a in found}) == len(found), "a field is lost once"
    return {a.field: a.max_torque_error for a in found}
