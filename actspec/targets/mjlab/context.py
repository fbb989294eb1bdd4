"""One joint on its way into a cfg: what is asked for, what is lost, what is wrong."""

from __future__ import annotations

from dataclasses import dataclass, replace

from actspec.diagnostics import Collector
from actspec.ir import Command, JointActuator, Level, Quantity
from actspec.laws import TorqueLaw, law_of
from actspec.robot.view import JointView
from actspec.targets.base import Approximation
from actspec.targets.mjlab.versions import MjlabDialect
from actspec.targets.python_text import provenance, py
from actspec.units import format_quantity


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


class Joint:
    """A joint and a dialect, with the losses that gather as fields are chosen.

    Attributes:
        actuator: What the spec asks for.
        view: The robot's joint; None where the spec names no model.
        dialect: mjlab version that is written.
        step: Simulation step [s].
        collector: Takes errors.
        where: The group's place in the spec.
        unit: Unit of a torque here.
        law: What mjlab is held to; of a network, the clip of its torque.
        lost: What the class cannot hold.

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
        self.actuator = actuator
        self.view = view
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

    def approximate(self, field: str, asked: str, emitted: str, why: str, error: float | None) -> None:
        """Record a loss; see `Approximation`."""
        self.lost.append(
            Approximation(self._target, self.actuator.joint, field, asked, emitted, why, error, self.unit)
        )

    def torque(self, value: float) -> str:
        """A torque with its unit."""
        return format_quantity(value, self.unit)


def _law(actuator: JointActuator) -> TorqueLaw:
    """The joint's law; of a network, the clip of its torque, which is then the command."""
    if actuator.level is not Level.ACTUATOR_NET:
        return law_of(actuator)
    line = (actuator.stall_torque, actuator.no_load_speed)
    known = all(part is not None and part.known for part in line)
    level = Level.DC_MOTOR if known or actuator.curve is not None else Level.IDEAL_PD
    return law_of(replace(actuator, level=level, command=Command.EFFORT, kp=None, kd=None))
