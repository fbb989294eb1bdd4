"""The robot file's own values of a joint, on which a spec falls back: a view of the joint's reading."""

from __future__ import annotations

import math
from dataclasses import dataclass

from actspec.ir import Quantity
from actspec.readings.joint import JointReading
from actspec.robot.view import ModelFormat


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


def model_values(reading: JointReading) -> ModelValues:
    """What a spec takes from the robot file where it says nothing itself.

    Drives that the file switches off give no gain, limit, filter or delay; their damping and armature act all the same.
    """
    mjcf = reading.format is ModelFormat.MJCF
    present = reading.format is not ModelFormat.NONE
    servos, first = reading.servos, next(iter(reading.acting), None)
    kp = reading.servo_gain("kp") if servos else None
    return ModelValues(
        kp=None if kp is None or kp.value == 0.0 else kp,
        kd=reading.servo_gain("kd") if servos else None,
        effort_limit=finite_limit(reading.drive_limit),
        velocity_limit=None if reading.joint.velocity_limit is None else reading.velocity_limit,
        armature=reading.armature if mjcf else None,
        friction_coulomb=reading.frictionloss if present else None,
        friction_viscous=reading.friction_viscous if present else None,
        filter_cutoff=servos[0].filter_cutoff if servos else None,
        delay=first.delay if first is not None else None,
    )


def finite_limit(limit: Quantity) -> Quantity | None:
    """A limit that limits; None for no limit, 0 (nobody's number) and where the format has none."""
    if limit.value is None:
        return None if limit.span is None else limit
    return None if limit.value == 0.0 or not math.isfinite(limit.value) else limit
