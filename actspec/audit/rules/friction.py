"""FRC: friction in a wrong unit."""

from __future__ import annotations

from collections.abc import Iterator

from actspec.diagnostics import Diagnostic, Severity
from actspec.ir import ActuatorSet
from actspec.units import format_quantity

MILLI = 1000.0


def implausible_friction(actuators: ActuatorSet) -> Iterator[Diagnostic]:
    """FRC001 and FRC002: friction that the drive could not overcome is a wrong unit, not a joint.

    FRC001: dry friction at or above the effort limit. FRC002: viscous friction that takes the whole
    effort limit before half the no-load (or limit) speed.
    """
    said: set[tuple[str, str, float]] = set()
    for actuator in actuators.joints:
        limit = actuator.effort_limit.value
        coulomb, viscous = actuator.friction_coulomb, actuator.friction_viscous
        if limit is None:
            continue
        unit = actuator.effort_limit.unit
        if coulomb.value is not None and coulomb.value >= limit:
            key = ("FRC001", actuator.group, coulomb.value)
            if key not in said:
                said.add(key)
                yield Diagnostic(
                    "FRC001",
                    Severity.WARNING,
                    f"{actuator.joint}: dry friction {format_quantity(coulomb.value, unit)} is not below the "
                    f"effort limit {format_quantity(limit, unit)}: the joint could never move",
                    f"actuators.{actuator.group}.friction.coulomb",
                    coulomb.span,
                    f"is it in m{unit} ({format_quantity(coulomb.value / MILLI, unit)}), or a dimensionless "
                    "coefficient?",
                )
        line = actuator.curve.no_load_speed if actuator.curve is not None else actuator.no_load_speed
        speed = (line if line is not None else actuator.velocity_limit).value
        if viscous.value is None or speed is None or viscous.value * speed / 2.0 < limit:
            continue
        key = ("FRC002", actuator.group, viscous.value)
        if key not in said:
            said.add(key)
            yield Diagnostic(
                "FRC002",
                Severity.WARNING,
                f"{actuator.joint}: viscous friction {format_quantity(viscous.value, viscous.unit)} takes "
                f"{format_quantity(viscous.value * speed / 2.0, unit)} at "
                f"{format_quantity(speed / 2.0, actuator.velocity_limit.unit)}, half the joint's speed; the effort "
                f"limit is {format_quantity(limit, unit)}",
                f"actuators.{actuator.group}.friction.viscous",
                viscous.span,
                f"is it in m{viscous.unit} ({format_quantity(viscous.value / MILLI, viscous.unit)})? The slope of the "
                "torque-speed line belongs to the motor, not to friction",
            )
