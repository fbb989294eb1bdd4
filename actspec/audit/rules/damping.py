"""DMP: damping counted twice."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

from actspec.diagnostics import Diagnostic, Severity, listed
from actspec.ir import ActuatorSet, JointActuator, Origin
from actspec.units import format_quantity

MODEL_SHARE = 0.10
"""Passive damping that the file brings along is reported above this share of kd. Source: DESIGN section 4."""


def model_damping_beside_kd(actuators: ActuatorSet) -> Iterator[Diagnostic]:
    """DMP001: the file's own joint damping adds to the spec's kd.

    The spec states kd and leaves the passive part to the file. Published files often keep their
    drive's D gain in joint damping, where it then counts a second time, outside the torque limit.
    """

    def suspect(actuator: JointActuator) -> bool:
        kd, viscous = actuator.kd, actuator.friction_viscous
        # With kd 0 the drive has none, and the file's is counted once.
        if kd is None or not kd.value or viscous.value is None:
            return False
        return (
            kd.origin in (Origin.AUTHORED, Origin.DERIVED, Origin.IDENTIFIED)
            and viscous.origin is Origin.MODEL
            and viscous.value > MODEL_SHARE * kd.value
        )

    found = [actuator for actuator in actuators.joints if suspect(actuator)]

    def key(actuator: JointActuator) -> tuple[str, float, float]:
        assert actuator.kd is not None
        return actuator.group, actuator.kd.require(), actuator.friction_viscous.require()

    for (group, kd, viscous), members_iter in groupby(sorted(found, key=key), key=key):
        members = list(members_iter)
        first = members[0]
        assert first.kd is not None
        unit = first.kd.unit
        yield Diagnostic(
            "DMP001",
            Severity.WARNING,
            f"damping may be counted twice: the drive has kd {format_quantity(kd, unit)}, and the robot's file adds "
            f"{format_quantity(viscous, unit)} of joint damping that the spec does not mention; together "
            f"{format_quantity(kd + viscous, unit)} ({listed([m.joint for m in members])})",
            f"actuators.{group}",
            first.friction_viscous.span,
            f"state friction: {{viscous: ...}} in the group: `0` if the file's damping was the drive's, "
            f"`{format_quantity(viscous, unit)}` if it is the bearing's",
        )
