"""One joint on its way into a cfg: what is asked for, what is lost, what is wrong."""

from __future__ import annotations

from dataclasses import dataclass

from actspec.diagnostics import Collector
from actspec.ir import JointActuator, Quantity
from actspec.robot.view import JointView
from actspec.simulators.mjlab import MjlabDialect
from actspec.targets.losing_joint import LosingJoint
from actspec.targets.python_text import provenance, py


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a cfg.

    Attributes:
        name: Its name.
        text: Its value as Python.
        note: Unit and origin; "" without.
    """

    name: str
    text: str
    note: str = ""


def number(name: str, quantity: Quantity, what: str = "") -> Field:
    """A known number as a field, with unit and origin behind it.

    Args:
        name: Of the field.
        quantity: The number.
        what: What it is, where the name does not say.
    """
    about = [quantity.unit, *([what] if what else []), provenance(quantity)]
    return Field(name, py(quantity.require()), ", ".join(about))


class Joint(LosingJoint):
    """A joint with its losses, and a dialect.

    Attributes:
        view: The robot's joint; None where the spec names no model.
        dialect: mjlab version that is written.

    Raises: ValueError: the law lacks a number; it says which.
    """

    def __init__(
        self,
        actuator: JointActuator,
        view: JointView | None,
        dialect: MjlabDialect,
        step: float,
        target: str,
        collector: Collector,
    ) -> None:
        super().__init__(actuator, step, target, collector)
        self.view = view
        self.dialect = dialect
