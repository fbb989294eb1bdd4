"""Are two compiled models the same, field by field?

Two questions are asked on every run. Is the edited text the same model as the edited MjSpec, in
every field? Is the edited model the original in every field that the plan does not touch?
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Diagnostic, Severity
from actspec.ir import ActuatorSet, Command, JointActuator, Level
from actspec.readings.compare import EXACT, same
from actspec.readings.joint import read_joints
from actspec.robot.compiled import DERIVED, differences, model_fields, unequal
from actspec.robot.view import RobotView
from actspec.targets.mujoco.plan import Plan
from actspec.units import format_quantity

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
        if name == "opt.integrator" and plan.integrator is not None:
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


def check_readback(actuators: ActuatorSet, written: RobotView) -> Iterator[Diagnostic]:
    """Compare what the written model does with what the spec asks for; each difference is an error.

    Codes: DMP002 damping counted twice or lost, FRC003 friction in another unit or lost,
    RTP001 stiffness, RTP002 armature, RTP003 effort limit, RTP004 number of drives.
    """
    readings = read_joints(written)
    for actuator in actuators.joints:
        reading = readings[actuator.joint]

        def fault(code: str, message: str, actuator: JointActuator = actuator) -> Diagnostic:
            return Diagnostic(
                code,
                Severity.ERROR,
                f"{actuator.joint}: {message}",
                f"actuators.{actuator.group}",
                actuator.span,
                "this is an error of the compiler: please report it with the spec and the model",
            )

        if len(reading.acting) != 1:
            yield fault("RTP004", f"the written model has {len(reading.acting)} drives on the joint, not one")
            continue
        own = reading.acting[0]
        kd_unit, torque_unit = actuator.friction_viscous.unit, actuator.effort_limit.unit
        network = actuator.level is Level.ACTUATOR_NET
        kd = actuator.kd.value if actuator.kd is not None and actuator.command is not Command.EFFORT else 0.0
        kd = 0.0 if network else kd
        viscous, damping = actuator.friction_viscous.value, reading.friction_viscous.value
        total = None if own.kd.value is None or damping is None else own.kd.value + damping
        if kd is not None and viscous is not None and _differ(total, kd + viscous):
            yield fault(
                "DMP002",
                f"damping is {format_quantity(total, kd_unit)} in the written model (drive "
                f"{_number(own.kd.value)}, joint {_number(reading.joint_damping.value)}, actuator "
                f"{_number(own.damping)}), the spec asks for {format_quantity(kd + viscous, kd_unit)} "
                f"(kd {_number(kd)}, viscous {_number(viscous)})",
            )
        coulomb, found = actuator.friction_coulomb.value, reading.frictionloss.value
        if coulomb is not None and _differ(found, coulomb):
            yield fault(
                "FRC003",
                f"frictionloss is {format_quantity(found, torque_unit)} in the written model, the spec "
                f"asks for {format_quantity(coulomb, torque_unit)}",
            )
        kp = actuator.kp.value if actuator.kp is not None else 0.0
        if network or actuator.command is not Command.POSITION:
            kp = 0.0
        armature, limit = actuator.armature.value, actuator.effort_limit.value
        if limit is not None and own.view.control == "motor" and actuator.command_range is not None:
            # A clamped torque command is a limit of its own.
            limit = min(limit, max(abs(end.value or 0.0) for end in actuator.command_range))
        limit = None if actuator.curve is not None else limit
        for code, noun, got, asked in (
            ("RTP001", "stiffness", own.kp.value, kp),
            ("RTP002", "armature", reading.armature.value, armature),
            ("RTP003", "the effort limit", reading.drive_limit.value, limit),
        ):
            if asked is not None and _differ(got, asked):
                yield fault(
                    code, f"{noun} is {_number(got)} in the written model, the spec asks for {_number(asked)}"
                )


def _number(value: float | None) -> str:
    return format_quantity(value, "")


def _differ(found: float | None, asked: float) -> bool:
    return not same(found, asked, EXACT, EXACT)
