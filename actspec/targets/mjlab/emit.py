"""The mjlab target: actuator cfgs that read as if written by hand, and the articulation that holds them.

`soft_joint_pos_limit_factor` is left at mjlab's default: it belongs to a task's rewards, not to an actuator.
"""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from functools import partial

from actspec.diagnostics import Collector, EmitError, listed
from actspec.ir import ActuatorSet, JointActuator, JointKind
from actspec.robot.view import ModelFormat, RobotView
from actspec.targets.base import Emission, EmittedFile, TargetOptions
from actspec.targets.check import mjlab_row
from actspec.targets.kit.joint import delta_action_loss, unknown_passive, unlimited_joints
from actspec.targets.kit.network import network_files
from actspec.targets.kit.python_text import joint_patterns, module_name, stated
from actspec.targets.mjlab.joint_cfg import cfgs_of, own_passive
from actspec.targets.mjlab.text import Preparation, module_text


def emit(actuators: ActuatorSet, robot: RobotView, options: TargetOptions) -> Emission:
    """Write a robot's actuators as a module for mjlab; see `choose.Emit`."""
    collector = Collector()
    dialect = mjlab_row(options, collector)
    for actuator in actuators.joints:
        _check_springdamper(actuator, robot, collector)
    cfgs = cfgs_of(actuators, robot, dialect, options.name, collector)
    names = _short_names(actuators, robot, collector)
    networks = ((cfg.actuator, cfg.network) for cfg in cfgs)
    files = network_files(networks, "MJL010", "differ", collector)
    collector.raise_if_failed(EmitError)

    matched = _matched(actuators, robot)

    def patterns(members: Sequence[JointActuator], first: Sequence[str] = ()) -> tuple[str, ...]:
        if names is not None:
            return tuple(re.escape(names[member.joint]) for member in members)
        return joint_patterns(members, matched, first)

    lost = [loss for cfg in cfgs for loss in cfg.lost]
    why = "an actuator cfg holds no residual policy: wrap the environment with the runtime"
    lost += unknown_passive(actuators, options.name, "mjlab", partial(own_passive, robot))
    lost += delta_action_loss(actuators, options.name, why)
    text = module_text(
        actuators,
        cfgs,
        lost,
        dialect,
        patterns,
        _preparation(actuators, robot),
        "" if robot.format is ModelFormat.NONE else os.path.basename(robot.path),
    )
    module = EmittedFile(f"{module_name(actuators.robot)}.py", text.encode("utf-8"))
    explicit = frozenset(cfg.actuator.joint for cfg in cfgs if cfg.explicit)
    return Emission(
        (module, *files), tuple(lost), collector.sorted(), explicit, unlimited_joints(actuators, robot)
    )


def _matched(actuators: ActuatorSet, robot: RobotView) -> list[str]:
    """The names that mjlab matches a pattern against: every joint but a free one."""
    names = [joint.name for joint in robot.joints if joint.kind is not JointKind.FREE]
    if any(item.code == "ROBOT113" for item in robot.diagnostics):
        # Joints without a name: mjlab would match them too.
        names.append("")
    return names or [actuator.joint for actuator in actuators.joints]


def _short_names(actuators: ActuatorSet, robot: RobotView, collector: Collector) -> dict[str, str] | None:
    """What mjlab calls the joints where a name has a `/`: what is behind the last; None where none has."""
    full = [joint.name for joint in robot.joints if joint.kind is not JointKind.FREE]
    if not any("/" in name for name in full):
        return None
    short: dict[str, list[str]] = {}
    for name in full:
        short.setdefault(name.rsplit("/", 1)[-1], []).append(name)
    managed = {actuator.joint for actuator in actuators.joints}
    for same in short.values():
        if len(same) > 1 and not managed.isdisjoint(same):
            collector.at(same[0]).error(
                "MJL008",
                f"mjlab identifies a joint by what is behind the last '/', which is the same for {listed(same)}",
                "rename the joints in the model",
            )
    return {name: name.rsplit("/", 1)[-1] for name in full}


def _check_springdamper(actuator: JointActuator, robot: RobotView, collector: Collector) -> None:
    joint = robot.joint(actuator.joint)
    if joint is None or not joint.springdamper:
        return
    asked = ((actuator.friction_viscous, joint.damping), (actuator.armature, joint.armature))
    if any(stated(quantity) and quantity.value != own for quantity, own in asked):
        collector.at(joint.name, joint.span).error(
            "MJL009",
            "the joint has a springdamper in force, which overwrites viscous_damping and follows the armature",
            "take it out of the model, or use the model that the mujoco target writes",
        )


def _preparation(actuators: ActuatorSet, robot: RobotView) -> Preparation:
    widened = []
    for actuator in actuators.joints:
        joint, limit = robot.joint(actuator.joint), actuator.effort_limit.value
        if joint is None or joint.effort_range is None or limit is None:
            continue
        low, high = joint.effort_range
        if low > -limit or high < limit:
            widened.append((joint.name, limit))
    return Preparation(bool(robot.actuators), tuple(widened))
