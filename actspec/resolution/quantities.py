"""Numbers as written and as the robot file has them become quantities with origin; the precedence between them.

Also errors about joints: the same one of several joints is reported once, with their names.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from actspec.diagnostics import Collector, Span, listed
from actspec.ir import Origin, Quantity, tidy
from actspec.readings.joint import JointReading
from actspec.robot.view import ModelFormat
from actspec.spec.values import SpecValue
from actspec.units import format_number, format_quantity

Factor = tuple[float, str]
"""A number that scales another, and its name in formulas, e.g. (9.0, "gear_ratio")."""

CONFLICT_STD = 3.0
"""Authored and identified apart by more than this many std are reported (DESIGN: precedence)."""


def written(value: SpecValue, unit: str, span: Span | None, origin: Origin = Origin.AUTHORED) -> Quantity:
    """A number of the spec (or of a results file) as a quantity; `unknown` keeps its place."""
    return Quantity(
        value.value,
        unit,
        Origin.UNKNOWN if value.value is None else origin,
        source=value.source,
        span=span,
        std=value.std,
        note=value.note,
    )


def scaled(quantity: Quantity, factors: Sequence[Factor], divide: bool = False) -> Quantity:
    """A quantity times (or divided by) named factors; factors of 1 leave it as it is.

    Args:
        quantity: What is scaled; unknown stays unknown.
        factors: What it is scaled by.
        divide: Divide instead.
    """
    used = [(number, name) for number, name in factors if number != 1.0]
    if quantity.value is None or not used:
        return quantity
    value = quantity.value
    for number, _ in used:
        # A product of ratios below the smallest float is 0: a speed divided by it is out of range (RES011).
        value = value * number if not divide else value / number if number else math.inf
    formula = format_quantity(quantity.value, quantity.unit) + in_words(used, divide)
    std = quantity.std
    if std is not None:
        std = std * abs(value / quantity.value) if quantity.value else std
    return replace(quantity, value=tidy(value), std=std, origin=Origin.DERIVED, formula=formula)


def in_words(factors: Sequence[Factor], divide: bool = False) -> str:
    """Factors as formulas have them, ` x 9 (gear_ratio)`; those of 1 are left out."""
    sign = "/" if divide else "x"
    return "".join(f" {sign} {format_number(number)} ({name})" for number, name in factors if number != 1.0)


def choose(*candidates: Quantity | None) -> Quantity | None:
    """The first candidate, with the known ones after it recorded as passed over.

    `unknown` written by the author is a candidate like any other and stops the fall-through.
    """
    present = [candidate for candidate in candidates if candidate is not None]
    if not present:
        return None
    winner, *others = present
    return winner.losing(*(other for other in others if other.known))


def conflict(authored: Quantity | None, identified: Quantity | None) -> str | None:
    """What to say when an authored and an identified number cannot both be right."""
    if authored is None or identified is None or authored.value is None or identified.value is None:
        return None
    std = max(identified.std or 0.0, authored.std or 0.0)
    apart = abs(authored.value - identified.value)
    if std <= 0.0 or apart <= CONFLICT_STD * std:
        return None
    return (
        f"authored {format_quantity(authored.value, authored.unit)} and identified "
        f"{format_quantity(identified.value, identified.unit)} are {apart / std:.1f} std apart "
        f"(std {format_quantity(std, identified.unit)})"
    )


@dataclass(slots=True)
class Reports:
    """Collects errors of single joints until all joints are through."""

    joints: dict[tuple[str, str, str, Span | None, str | None], list[str]] = field(default_factory=dict)
    """Code, message, where, span and help, to the joints concerned."""

    def error(
        self, code: str, joint: str, message: str, where: str, span: Span | None, help: str | None
    ) -> None:
        """Note that something is wrong with a joint."""
        named = self.joints.setdefault((code, message, where, span, help), [])
        if joint not in named:
            named.append(joint)

    def tell(self, collector: Collector) -> None:
        """Hand everything noted to the collector."""
        for (code, message, where, span, help), named in self.joints.items():
            collector.at(where, span).error(code, f"{listed(named)}: {message}", help)
        self.joints.clear()


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
