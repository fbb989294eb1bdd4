"""Round trip: does the written model act on each joint as the spec says?

The written files are read again by the reader of foreign files, and what acts on the joint is
compared with the spec: damping by its parts, friction in N*m, armature, limit, stiffness. What an
approximation states is not asked for.
"""

from __future__ import annotations

from collections.abc import Iterator

from actspec.diagnostics import Diagnostic, Severity
from actspec.ir import ActuatorSet, Command, JointActuator, Level
from actspec.resolution.model_values import actuators_of, effort_bound
from actspec.robot.view import RobotView
from actspec.units import format_quantity

TOLERANCE = 1e-9
"""Relative; the numbers pass through text with 17 digits, and through R and K of a dcmotor."""


def check_readback(actuators: ActuatorSet, written: RobotView) -> Iterator[Diagnostic]:
    """Compare what the written model does with what the spec asks for; each difference is an error.

    Codes: DMP002 damping counted twice or lost, FRC003 friction in another unit or lost,
    RTP001 stiffness, RTP002 armature, RTP003 effort limit, RTP004 number of drives.
    """
    for actuator in actuators.joints:
        joint = written.joint(actuator.joint)
        assert joint is not None
        own = actuators_of(written, actuator.joint)

        def fault(code: str, message: str, actuator: JointActuator = actuator) -> Diagnostic:
            return Diagnostic(
                code,
                Severity.ERROR,
                f"{actuator.joint}: {message}",
                f"actuators.{actuator.group}",
                actuator.span,
                "this is an error of the compiler: please report it with the spec and the model",
            )

        if len(own) != 1:
            yield fault("RTP004", f"the written model has {len(own)} drives on the joint, not one")
            continue
        kd_unit, torque_unit = actuator.friction_viscous.unit, actuator.effort_limit.unit
        at_actuator = own[0].gear ** 2 * own[0].damping[0]
        total = own[0].kd + joint.damping + at_actuator
        kd = actuator.kd.value if actuator.kd is not None and actuator.command is not Command.EFFORT else 0.0
        kd = 0.0 if actuator.level is Level.ACTUATOR_NET else kd
        viscous = actuator.friction_viscous.value
        if kd is not None and viscous is not None and _apart(total, kd + viscous):
            yield fault(
                "DMP002",
                f"damping is {format_quantity(total, kd_unit)} in the written model (drive "
                f"{own[0].kd:g}, joint {joint.damping:g}, actuator {at_actuator:g}), the spec asks for "
                f"{format_quantity(kd + viscous, kd_unit)} (kd {kd:g}, viscous {viscous:g})",
            )
        coulomb = actuator.friction_coulomb.value
        if coulomb is not None and _apart(joint.frictionloss, coulomb):
            yield fault(
                "FRC003",
                f"frictionloss is {format_quantity(joint.frictionloss, torque_unit)} in the written model, the spec "
                f"asks for {format_quantity(coulomb, torque_unit)}",
            )
        kp = actuator.kp.value if actuator.kp is not None else 0.0
        if actuator.level is Level.ACTUATOR_NET or actuator.command is not Command.POSITION:
            kp = 0.0
        if kp is not None and _apart(own[0].kp, kp):
            yield fault(
                "RTP001", f"stiffness is {own[0].kp:g} in the written model, the spec asks for {kp:g}"
            )
        armature = actuator.armature.value
        found = joint.armature + own[0].gear ** 2 * own[0].armature
        if armature is not None and _apart(found, armature):
            yield fault(
                "RTP002", f"armature is {found:g} in the written model, the spec asks for {armature:g}"
            )
        limit = actuator.effort_limit.value
        bound = effort_bound(joint, own)
        if limit is not None and own[0].control == "motor" and actuator.command_range is not None:
            # A clamped torque command is a limit of its own; `effort_bound` counts that of a plain motor.
            limit = min(limit, max(abs(end.value or 0.0) for end in actuator.command_range))
        if limit is not None and actuator.curve is None and (bound is None or _apart(bound, limit)):
            yield fault(
                "RTP003", f"the effort limit is {bound} in the written model, the spec asks for {limit:g}"
            )


def _apart(found: float, asked: float) -> bool:
    return abs(found - asked) > TOLERANCE * max(abs(found), abs(asked), 1.0)
