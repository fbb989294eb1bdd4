"""The robot file's own values of a joint, as quantities of origin `model` or `default`."""

from __future__ import annotations

import math
from dataclasses import dataclass

from actspec.ir import JointKind, Origin, Quantity
from actspec.resolution.quantities import unit_of
from actspec.robot.view import ActuatorView, JointView, ModelFormat, RobotView
from actspec.units import Kind

SERVOS = ("position", "velocity", "dcmotor", "pid")
"""Controls whose kp and kd are a drive's gains."""


@dataclass(frozen=True, slots=True)
class ModelValues:
    """What the file says of a joint; None: it says nothing, and the format has no default.

    Attributes: as in `ir.JointActuator`. Actuator-level damping and armature (MuJoCo 3.7 and later)
    are in `friction_viscous` and `armature`, because they act on the joint.
    """

    kp: Quantity | None
    kd: Quantity | None
    effort_limit: Quantity | None
    velocity_limit: Quantity | None
    armature: Quantity | None
    friction_coulomb: Quantity | None
    friction_viscous: Quantity | None
    filter_cutoff: Quantity | None
    delay: Quantity | None


def actuators_of(robot: RobotView, joint: str) -> tuple[ActuatorView, ...]:
    """The file's actuators that drive a joint directly."""
    return tuple(
        a for a in robot.actuators if a.target == joint and a.transmission in ("joint", "jointinparent")
    )


def effort_bound(joint: JointView, actuators: tuple[ActuatorView, ...]) -> float | None:
    """Largest torque that the file lets the joint's actuators apply [N*m or N]; None: no limit."""
    total = 0.0
    for actuator in actuators:
        bounds = []
        if actuator.force_range is not None:
            bounds.append(abs(actuator.gear) * max(abs(end) for end in actuator.force_range))
        if actuator.control == "motor" and actuator.control_range is not None:
            bounds.append(
                abs(actuator.gear * actuator.gain) * max(abs(end) for end in actuator.control_range)
            )
        if not bounds:
            total = float("inf")
            break
        total += min(bounds)
    limits = [total] if actuators else []
    if joint.effort_range is not None:
        limits.append(max(abs(end) for end in joint.effort_range))
    bound = min(limits, default=float("inf"))
    return None if bound == float("inf") or bound == 0.0 else bound


def model_values(robot: RobotView, joint: JointView) -> ModelValues:
    """Read the file's values of one joint."""
    actuators = actuators_of(robot, joint.name)
    servos = [a for a in actuators if a.control in SERVOS]
    mjcf = robot.format is ModelFormat.MJCF
    place = servos[0].span if servos else joint.span

    def quantity(value: float, kind: Kind, stated: bool, at_actuator: bool = False) -> Quantity:
        unit = unit_of(kind, joint.kind if joint.kind is JointKind.SLIDE else JointKind.HINGE)
        span = place if at_actuator else joint.span
        if stated or value != 0.0:
            return Quantity(value, unit, Origin.MODEL, source=span.path, span=span)
        return Quantity(
            value, unit, Origin.DEFAULT, note=f"{robot.format.value.upper()} default, the file does not say"
        )

    kp = sum(a.kp for a in servos)
    kd = sum(a.kd for a in servos)
    effort = effort_bound(joint, actuators)
    actuator_damping = sum(a.gear**2 * a.damping[0] for a in actuators)
    actuator_armature = sum(a.gear**2 * a.armature for a in actuators)
    said = {field: field in joint.stated for field in ("damping", "armature", "frictionloss")}
    present = robot.format is not ModelFormat.NONE
    return ModelValues(
        kp=quantity(kp, Kind.STIFFNESS, True, True) if any(a.kp for a in servos) else None,
        kd=quantity(kd, Kind.VELOCITY_GAIN, True, True) if servos else None,
        effort_limit=None if effort is None else quantity(effort, Kind.TORQUE, True, bool(servos)),
        velocity_limit=None
        if joint.velocity_limit is None
        else quantity(joint.velocity_limit, Kind.SPEED, "velocity" in joint.stated),
        armature=quantity(joint.armature + actuator_armature, Kind.INERTIA, said["armature"])
        if mjcf
        else None,
        friction_coulomb=quantity(joint.frictionloss, Kind.TORQUE, said["frictionloss"]) if present else None,
        friction_viscous=quantity(joint.damping + actuator_damping, Kind.VELOCITY_GAIN, said["damping"])
        if present
        else None,
        filter_cutoff=None
        if not servos or servos[0].time_constant <= 0.0
        else Quantity(
            1.0 / (2.0 * math.pi * servos[0].time_constant),
            "Hz",
            Origin.MODEL,
            source=place.path,
            span=place,
            formula=f"1 / (2 pi {servos[0].time_constant:g} s)",
        ),
        delay=None
        if not actuators or actuators[0].delay <= 0.0
        else Quantity(
            actuators[0].delay, "s", Origin.MODEL, source=actuators[0].span.path, span=actuators[0].span
        ),
    )
