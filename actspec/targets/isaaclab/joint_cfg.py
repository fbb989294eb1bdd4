"""What each joint's drive becomes in Isaac Lab: a class with its fields, and what it cannot hold.

`class: auto` takes the stock class of the level, `implicit` the solver's own drive, `custom` one class
of our own with the whole law. Torque limits are kept first, then delay, then the filter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector
from actspec.ir import Command, JointActuator, Level
from actspec.laws import TorqueLaw
from actspec.simulators.isaaclab import IsaacLabDialect
from actspec.targets.base import Approximation
from actspec.targets.isaaclab.fields import (
    CfgField,
    IsaacJoint,
    gain_fields,
    joint_fields,
    lag_fields,
    lags,
    no_command_path,
    no_delay,
)
from actspec.targets.kit.python_text import origin_of, stated
from actspec.targets.kit.sizes import (
    Torque,
    at_standstill,
    boxed,
    lined,
    static_error,
    two_quadrants,
    unclipped,
)
from actspec.units import format_quantity

if TYPE_CHECKING:
    from actspec.targets.kit.network import NetworkWithManifest

OUT_OF_THE_WAY = 1e9
"""Torque and speed that no joint reaches [N*m, rad/s]: a torque-speed line that never acts."""

IMPLICIT = "ImplicitActuator"
"""The solver's own drive; every other class computes a torque from the state before the step."""

CUSTOM = "custom"
"""Stands for the name of our own class, which depends on the robot."""


@dataclass(frozen=True, slots=True)
class JointCfg:
    """One joint's part of a cfg; joint side, SI.

    Attributes:
        actuator: The joint's actuator.
        cls: Name of the class without `Cfg`.
        fields: Keywords in the order that they are written in.
        remarks: Comments above the fields.
        approximations: What was lost.
    """

    actuator: JointActuator
    cls: str
    fields: tuple[CfgField, ...]
    remarks: tuple[str, ...]
    approximations: tuple[Approximation, ...]


def cfg_of(
    actuator: JointActuator,
    dialect: IsaacLabDialect,
    actuator_class: str,
    step: float,
    target: str,
    collector: Collector,
    network: tuple[NetworkWithManifest, int] | None,
) -> JointCfg:
    """Choose the class and fields of one joint.

    Args: as of `JointEmission`, and
        actuator: What the spec asks for, with a known effort limit, or a drive of the solver's, which has the USD's.
        actuator_class: `auto`, `implicit` or `custom`.
        network: The network and the physics steps between its taps, for level actuator_net.

    Raises: ValueError: the law lacks a number, or a delay is too long; it says which.
    """
    joint = IsaacJoint(actuator, dialect, step, target, collector, network)
    if actuator.level is Level.ACTUATOR_NET:
        cls, fields = _net(joint)
    elif actuator_class == "implicit":
        cls, fields = _implicit(joint)
    elif actuator_class == "custom":
        cls, fields = _custom(joint)
    elif actuator.level is Level.DC_MOTOR:
        cls, fields = _dc_motor(joint)
    else:
        cls, fields = _ideal(joint)
    silent = [
        name
        for name, quantities in (
            ("armature", [actuator.armature]),
            ("friction", [actuator.friction_coulomb, actuator.friction_static]),
            ("viscous friction", [actuator.friction_viscous]),
        )
        if not any(stated(quantity) for quantity in quantities)
    ]
    if silent:
        joint.remarks.append(f"Nobody states {', '.join(silent)}: the USD's own.")
    return JointCfg(actuator, cls, tuple(fields), tuple(joint.remarks), tuple(joint.lost))


def _ideal(joint: IsaacJoint) -> tuple[str, list[CfgField]]:
    fields = [*_limits(joint, joint.limit), *gain_fields(joint), *joint_fields(joint)]
    cls = "IdealPDActuator"
    steps = lags(joint, filtered=False)
    if steps[1]:
        cls = "DelayedPDActuator"
        fields += lag_fields(joint, steps)
    no_command_path(joint)
    return cls, fields


def _dc_motor(joint: IsaacJoint) -> tuple[str, list[CfgField]]:
    law = lined(joint.law)
    _one_line(joint, law, "DCMotor")
    fields = [*_limits(joint, law.effort_limit, law), *gain_fields(joint), *joint_fields(joint)]
    no_delay(joint, "DCMotor has no delay; the torque-speed line is kept instead")
    no_command_path(joint)
    return "DCMotor", fields


def _implicit(joint: IsaacJoint) -> tuple[str, list[CfgField]]:
    limited = boxed(joint.law)
    clip = f"a clip at {format_quantity(joint.limit, joint.unit)}"
    why = "the solver's drive has one limit at all speeds"
    known = joint.actuator.effort_limit.known
    if joint.actuator.command is Command.EFFORT and known:
        clip, why = "none", "the solver limits its own drive, not a torque that is commanded"
        free = unclipped(joint.law)
        error = static_error(limited, free.torque)
        joint.approximate("effort_limit", format_quantity(joint.limit, joint.unit), clip, why, error)
        limited = free
    if joint.actuator.level is Level.DC_MOTOR:
        asked = joint.curve_text(joint.law, joint.speed_unit)
        joint.lose_line(asked, clip, why, joint.law, limited.torque)
    names = joint.dialect.limits
    note = joint.note(joint.actuator.effort_limit) if known else "unknown: the USD's own"
    fields = [CfgField(names.solver_effort, joint.limit if known else None, note, scalar=not known)]
    fields += [*_solver_velocity(joint), *gain_fields(joint), *joint_fields(joint)]
    no_delay(joint, "the solver's drive has no delay")
    no_command_path(joint)
    return IMPLICIT, fields


def _custom(joint: IsaacJoint) -> tuple[str, list[CfgField]]:
    actuator, law = joint.actuator, joint.law
    fields = [joint.known("effort_limit", actuator.effort_limit)]
    if actuator.level is Level.DC_MOTOR and actuator.curve is not None:
        for name in ("drive_torque", "brake_torque", "knee_speed", "no_load_speed"):
            quantity = getattr(actuator.curve, name)
            fields.append(joint.known(name, quantity))
    elif actuator.level is Level.DC_MOTOR:
        assert actuator.stall_torque is not None and actuator.no_load_speed is not None
        fields.append(joint.known("stall_torque", actuator.stall_torque))
        fields.append(joint.known("no_load_speed", actuator.no_load_speed))
    fields += [*_solver_velocity(joint), *gain_fields(joint), *joint_fields(joint)]
    filtered = law.filter_cutoff is not None
    # A stated 0 beside others' biases is a number like them.
    if stated(actuator.encoder_bias) and actuator.command is Command.POSITION:
        fields.append(joint.known("encoder_bias", actuator.encoder_bias))
    if filtered or law.command_range is not None:
        fields.append(CfgField("command", actuator.command.value, scalar=True))
    if actuator.command_range is not None:
        for name, end in zip(("command_low", "command_high"), actuator.command_range, strict=True):
            if end.known:
                fields.append(joint.known(name, end))
    steps = lags(joint, filtered=filtered)
    if steps[1]:
        fields += lag_fields(joint, steps)
    if filtered:
        assert actuator.filter_cutoff is not None
        fields.append(joint.known("filter_cutoff", actuator.filter_cutoff))
        fields.append(CfgField("physics_dt", joint.step, "s", scalar=True))
    return CUSTOM, fields


def _net(joint: IsaacJoint) -> tuple[str, list[CfgField]]:
    assert joint.network is not None
    file, stride = joint.network
    manifest = file.manifest
    line = lined(joint.law)
    lstm = manifest.kind == "lstm"
    if line.stall_torque is None:
        joint.remarks.append("No torque-speed line is known: it is put out of the way.")
        line = replace(line, stall_torque=OUT_OF_THE_WAY, no_load_speed=OUT_OF_THE_WAY)
    else:
        _one_line(joint, line, "ActuatorNetLSTM" if lstm else "ActuatorNetMLP")
    fields = [CfgField("network_file", file.name, scalar=True, file=True)]
    if not lstm:
        fields += [
            CfgField("pos_scale", manifest.position_scale, scalar=True),
            CfgField("vel_scale", manifest.velocity_scale, scalar=True),
            CfgField("torque_scale", manifest.torque_scale, scalar=True),
            CfgField("input_order", file.input_order, scalar=True),
            CfgField("input_idx", [tap * stride for tap in manifest.taps], "physics steps back", scalar=True),
        ]
    if manifest.initial_history == "first_sample" and not lstm and any(manifest.taps):
        joint.approximate(
            "network.initial_history",
            "the first sample",
            "zeros",
            "ActuatorNetMLP clears its history at a reset",
            2.0 * line.effort_limit,
        )
    fields += [*_limits(joint, line.effort_limit, line), *joint_fields(joint, summed=False)]
    no_delay(joint, "the network's class has no delay")
    no_command_path(joint)
    return ("ActuatorNetLSTM" if lstm else "ActuatorNetMLP"), fields


def _limits(joint: IsaacJoint, limit: float, line: TorqueLaw | None = None) -> list[CfgField]:
    """Limits of an explicit group, with a torque-speed line or without."""
    names, actuator = joint.dialect.limits, joint.actuator
    note = joint.note(actuator.effort_limit)
    if limit != joint.limit:
        note = f"{joint.unit}; the curve's drive torque"
    fields = [CfgField(names.effort, limit, note)]
    if line is not None:
        assert line.stall_torque is not None and line.no_load_speed is not None
        torque, speed = f"{joint.unit} at standstill", f"{joint.speed_unit} at no torque"
        if actuator.curve is not None:
            torque += "; the line through knee and no-load speed"
        elif actuator.stall_torque is not None and actuator.stall_torque.known:
            torque += f"; {origin_of(actuator.stall_torque)}"
        source = actuator.curve.no_load_speed if actuator.curve is not None else actuator.no_load_speed
        if source is not None and source.known:
            speed += f"; {origin_of(source)}"
        per_group = not joint.dialect.dict_saturation
        fields.append(CfgField("saturation_effort", line.stall_torque, torque, scalar=per_group))
        fields.append(CfgField(names.velocity, line.no_load_speed, speed))
    if joint.dialect.solver_limit:
        fields.append(CfgField(names.solver_effort, limit, f"{joint.unit}; the solver clips too"))
    return fields + _solver_velocity(joint)


def _solver_velocity(joint: IsaacJoint) -> list[CfgField]:
    quantity = joint.actuator.velocity_limit
    if not quantity.known:
        return []
    if joint.dialect.backend == "newton":
        why = "MuJoCo has no speed limit of a joint"
        joint.no_velocity_limit(why, "a field that the solver does not read")
    return [joint.known(joint.dialect.limits.solver_velocity, quantity)]


def _one_line(joint: IsaacJoint, line: TorqueLaw, cls: str) -> None:
    """Report what a class with one torque-speed line loses of the law, as one loss.

    Args:
        joint: The joint.
        line: The line that it gets.
        cls: The class.
    """
    emitted: Torque = line.torque
    text = (
        f"{joint.curve_text(line, joint.speed_unit)}, cut at {format_quantity(line.effort_limit, joint.unit)}"
    )
    reasons = []
    if joint.law.curve is not None:
        reasons.append(f"{cls} has one line for driving and braking")
    if cls == "ActuatorNetLSTM":
        emitted = at_standstill(line)
        text = f"a clip at {format_quantity(float(emitted(math.inf, 0.0, 0.0)), joint.unit)}"
        reasons.append(f"{cls} clips as if the joint stood still")
    elif not joint.dialect.four_quadrants:
        emitted = two_quadrants(line)
        text += " and at 0: no braking torque is forced above no-load speed"
        reasons.append(f"{cls} of Isaac Lab {joint.dialect.text} ends its limits at 0")
    if reasons:
        asked = joint.curve_text(joint.law, joint.speed_unit)
        joint.lose_line(asked, text, "; ".join(reasons), joint.law, emitted)
