"""What a robot file says of each joint."""

from __future__ import annotations

from collections.abc import Mapping

from actspec.joints import JointKind
from actspec.robot.view import ActuatorView, JointInertia, JointView, RobotView

SCALAR = (JointKind.HINGE, JointKind.SLIDE)


def joint_inertias(robot: RobotView) -> Mapping[str, JointInertia]:
    """Inertia of every named hinge and slide with the file's own armature; none without mass matrices."""
    return inertias_of(robot, _drives(robot))


def _drives(robot: RobotView) -> dict[str, list[ActuatorView]]:
    found: dict[str, list[ActuatorView]] = {}
    for actuator in robot.actuators:
        if actuator.transmission in ("joint", "jointinparent"):
            found.setdefault(actuator.target, []).append(actuator)
    return found


def inertias_of(robot: RobotView, driving: Mapping[str, list[ActuatorView]]) -> Mapping[str, JointInertia]:
    """As `joint_inertias`, with the actuators by joint."""
    if robot.joint_inertia is not None:
        return robot.joint_inertia
    if robot.inertia is None:
        return {}
    armature = {
        joint.dof: armature_of(joint, driving.get(joint.name, []))
        for joint in robot.joints
        if joint.dof >= 0 and joint.kind in SCALAR
    }
    held, free = robot.inertia.held(armature), robot.inertia.free(armature)
    return {
        joint.name: JointInertia(held[joint.dof], free[joint.dof])
        for joint in robot.joints
        if joint.dof in armature
    }


def armature_of(joint: JointView, drives: list[ActuatorView]) -> float:
    """Armature of a joint with that of its actuators."""
    return joint.armature + sum(a.gear**2 * a.armature for a in drives)
