"""One joint on its way into the overlay: what is asked for, what is lost, what is wrong."""

from __future__ import annotations

import math

from actspec.diagnostics import Collector
from actspec.ir import JointActuator, JointKind, Quantity
from actspec.simulators.newton import NewtonDialect
from actspec.targets.losing_joint import LosingJoint
from actspec.targets.newton.usda import Attribute
from actspec.targets.python_text import provenance, py


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


class Joint(LosingJoint):
    """A joint with its losses, and a dialect.

    Attributes:
        dialect: Newton version that is written.

    Raises: ValueError: the law lacks a number; it says which.
    """

    def __init__(
        self, actuator: JointActuator, dialect: NewtonDialect, step: float, target: str, collector: Collector
    ) -> None:
        super().__init__(actuator, step, target, collector)
        self.dialect = dialect

    @property
    def hinge(self) -> bool:
        """Whether the joint turns: USD's own attributes of it are in degrees."""
        return self.actuator.kind is JointKind.HINGE
