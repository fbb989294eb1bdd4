"""Are two compiled models the same, field by field?

Two questions are asked on every run. Is the edited text the same model as the edited MjSpec, in
every field? Is the edited model the original in every field that the plan does not touch?
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from actspec.robot.model_fields import DERIVED, differences, model_fields, unequal
from actspec.robot.view import RobotView
from actspec.targets.mujoco.plan import Plan

if TYPE_CHECKING:
    import mujoco

__all__ = ["differences", "outside_plan"]

COUNTS = frozenset(
    {"nu", "na", "nactuator", "nout", "nJmom", "nhistory", "nnames", "nnames_map", "nuser_actuator"}
)
"""Sizes that a changed number of actuators changes."""

NAME_TABLES = ("name_", "names")
"""Name buffers: addresses move when a name is added."""

DOF_ROWS = ("dof_damping", "dof_dampingpoly", "dof_armature", "dof_frictionloss")
JOINT_ROWS = ("jnt_stiffness", "jnt_stiffnesspoly", "jnt_actfrclimited", "jnt_actfrcrange")
KEY_ROWS = ("key_ctrl", "key_act")
ACTUATOR_IDS = ("jnt_actuatorid", "tendon_actuatorid")
"""By joint and tendon: the actuator whose own armature or damping acts there (4.0); -1: none, -2: several."""
REFERENCES = ("sensor_objid", "tuple_objid", "exclude_signature")
"""Fields that hold indices of actuators."""


def outside_plan(original: mujoco.MjModel, edited: mujoco.MjModel, plan: Plan, robot: RobotView) -> list[str]:
    """Fields in which the edited model differs from the original although the plan does not touch them."""
    import mujoco

    found = []
    theirs = dict(model_fields(edited))
    touched = {edit.joint for edit in plan.joints}
    joint_names = [
        mujoco.mj_id2name(original, mujoco.mjtObj.mjOBJ_JOINT, index) or "" for index in range(original.njnt)
    ]
    free_joints = [index for index, name in enumerate(joint_names) if name not in touched]
    free_dofs = [
        dof for dof in range(original.nv) if joint_names[int(original.dof_jntid[dof])] not in touched
    ]
    # springdamper of a joint left alone follows the inertia, which armatures change.
    followers = {joint.name for joint in robot.joints if joint.springdamper and joint.name not in touched}
    free_joints = [i for i in free_joints if joint_names[i] not in followers]
    free_dofs = [d for d in free_dofs if joint_names[int(original.dof_jntid[d])] not in followers]
    kept = _kept_actuators(plan, robot)
    driven = {drive.joint for drive in plan.drives}
    undriven = [index for index, name in enumerate(joint_names) if name not in driven]
    for name, value in model_fields(original):
        other = theirs.get(name)
        if name in DERIVED or name in COUNTS or name in KEY_ROWS or name.startswith(NAME_TABLES):
            continue
        if name == "opt.timestep" and plan.timestep is not None:
            continue
        if name in REFERENCES and (plan.removed or plan.renamed):
            continue
        if name in ACTUATOR_IDS and other is not None:
            value = _moved(value, dict(kept))
            if name == "jnt_actuatorid":
                value, other = value[undriven], other[undriven]
        if name.startswith("actuator_"):
            found += _kept_rows(name, value, other, kept, original, robot)
            continue
        if name in DOF_ROWS and other is not None:
            value, other = value[free_dofs], other[free_dofs]
        elif name in JOINT_ROWS and other is not None:
            value, other = value[free_joints], other[free_joints]
        text = unequal(value, other)
        if text is not None:
            found.append(f"{name}: {text}")
    return found


def _kept_actuators(plan: Plan, robot: RobotView) -> list[tuple[int, int]]:
    """(old, new) index of each actuator that the plan leaves alone."""
    replaced = {entry.index for entry in plan.replaced}
    pairs = []
    new = 0
    for old in range(len(robot.actuators)):
        if old in plan.removed:
            continue
        if old not in replaced:
            pairs.append((old, new))
        new += 1
    return pairs


def _moved(ids: Any, moved: dict[int, int]) -> Any:
    """Indices of actuators as they are after the edit."""
    import numpy as np

    return np.array([moved.get(int(old), int(old)) for old in ids], dtype=ids.dtype)


def _kept_rows(
    name: str, value: Any, other: Any, kept: list[tuple[int, int]], original: Any, robot: RobotView
) -> list[str]:
    """Rows of the actuators left alone; addresses may move with the others."""
    if name.endswith(("adr", "_user")) or name in ("actuator_history", "actuator_historyadr"):
        return []
    if getattr(value, "ndim", 0) == 0 or value.shape[0] != len(robot.actuators):
        # By control instead of by actuator: compared only while the two are the same.
        return []
    found = []
    for old, new in kept:
        if name == "actuator_biasprm" and robot.actuators[old].control in ("position", "other"):
            # dampratio is resolved with the joint's inertia, which armatures change.
            value_row, other_row = value[old][:2], other[new][:2]
        else:
            value_row, other_row = value[old], other[new]
        text = unequal(value_row, other_row)
        if text is not None:
            found.append(f"{name} of '{robot.actuators[old].name}': {text}")
    return found
