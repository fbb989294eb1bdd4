"""One joint on its way into the overlay: what is asked for, what is lost, what is wrong."""

from __future__ import annotations

import math
from dataclasses import replace

from actspec.diagnostics import Collector
from actspec.ir import Command, JointActuator, JointKind, Level, Quantity
from actspec.laws import TorqueLaw, law_of
from actspec.targets.base import Approximation
from actspec.targets.newton.usda import Attribute
from actspec.targets.newton.versions import NewtonDialect
from actspec.targets.python_text import provenance, py
from actspec.units import format_quantity


def number(name: str, quantity: Quantity, what: str = "") -> Attribute:
    """A known number as an attribute, with unit and origin behind it.

    Args:
        name: Of the attribute.
        quantity: The number.
        what: What it is, where the name does not say.
    """
    return given(name, quantity.require(), quantity.unit, what, provenance(quantity))


def given(name: str, value: float, *notes: str) -> Attribute:
    """A number as an attribute, infinity included."""
    text = py(value) if math.isfinite(value) else ("inf" if value > 0 else "-inf")
    return Attribute("float", name, text, ", ".join(note for note in notes if note))


class Joint:
    """A joint and a dialect, with the losses that gather as attributes are chosen.

    Attributes:
        actuator: What the spec asks for.
        dialect: Newton version that is written.
        step: Physics step [s].
        collector: Takes errors.
        where: The group's place in the spec.
        unit: Unit of a torque here.
        law: What Newton is held to; of a network, the clip of its torque.
        lost: What the overlay cannot hold.

    Raises: ValueError: the law lacks a number; it says which.
    """

    def __init__(
        self,
        actuator: JointActuator,
        dialect: NewtonDialect,
        step: float,
        target: str,
        collector: Collector,
    ) -> None:
        self.actuator = actuator
        self.dialect = dialect
        self.step = step
        self.collector = collector
        self.where = f"actuators.{actuator.group}"
        self.unit = actuator.effort_limit.unit
        self.law = _law(actuator)
        self.lost: list[Approximation] = []
        self._target = target

    @property
    def learned(self) -> bool:
        """Whether a network makes the torque."""
        return self.actuator.level is Level.ACTUATOR_NET

    @property
    def hinge(self) -> bool:
        """Whether the joint turns: USD's own attributes of it are in degrees."""
        return self.actuator.kind is JointKind.HINGE

    def approximate(self, field: str, asked: str, emitted: str, why: str, error: float | None) -> None:
        """Record a loss; see `Approximation`."""
        self.lost.append(
            Approximation(self._target, self.actuator.joint, field, asked, emitted, why, error, self.unit)
        )

    def torque(self, value: float) -> str:
        """A torque with its unit."""
        return format_quantity(value, self.unit)

    @property
    def both_limits(self) -> float | None:
        """From one limit to the other [N*m or N]: what a network answers to a command is not known here."""
        limit = self.law.effort_limit
        return 2.0 * limit if math.isfinite(limit) else None


def _law(actuator: JointActuator) -> TorqueLaw:
    """The joint's law; of a network, the clip of its torque, which is then the command."""
    if actuator.level is not Level.ACTUATOR_NET:
        return law_of(actuator)
    line = (actuator.stall_torque, actuator.no_load_speed)
    known = all(part is not None and part.known for part in line)
    level = Level.DC_MOTOR if known or actuator.curve is not None else Level.IDEAL_PD
    return law_of(replace(actuator, level=level, command=Command.EFFORT, kp=None, kd=None))
