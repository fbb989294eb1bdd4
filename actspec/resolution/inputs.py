"""What is said about one joint: spec, results, motor, robot file; and how its faults are told."""

from __future__ import annotations

from dataclasses import dataclass, replace

from actspec.diagnostics import Collector, Span
from actspec.ir import Command, JointKind, Level, Origin, Quantity
from actspec.resolution.model_values import ModelValues
from actspec.resolution.motor import JointMotor
from actspec.resolution.quantities import choose, conflict, unit_of, written
from actspec.resolution.reports import Reports
from actspec.resolution.stated import UNITS_OF_JOINTS, Stated
from actspec.robot.view import JointView
from actspec.spec.paths import Path, dotted
from actspec.spec.values import SpecValue
from actspec.units import Kind

FITTED = (
    "kp",
    "kd",
    "armature",
    "encoder_bias",
    "friction.coulomb",
    "friction.viscous",
    "friction.static",
    "friction.stribeck_velocity",
)
"""Fields that identification results may hold, beside the delay and the bandwidth."""


@dataclass(frozen=True, slots=True)
class JointInputs:
    """What is said about one joint.

    Attributes:
        stated: What spec and results state.
        model: What the robot's file states.
        motor: Its motor, at the joint; None without one.
        command: What is commanded.
        level: How much of the drive is modelled.
        collector: Takes what concerns this joint alone.
        reports: Takes what may concern others in the same way.
    """

    stated: Stated
    model: ModelValues
    motor: JointMotor | None
    command: Command
    level: Level
    collector: Collector
    reports: Reports

    @property
    def joint(self) -> JointView:
        """The robot's joint."""
        return self.stated.binding.joint

    @property
    def kind(self) -> JointKind:
        """hinge or slide."""
        return self.stated.kind

    def span(self, field: str) -> Span:
        """Where a field is written; the group where it is not."""
        return self.stated.spec.span(*self.stated.path(field))

    def unit(self, kind: Kind) -> str:
        """SI unit of a quantity kind at this joint."""
        return unit_of(kind, self.kind)

    def error(self, code: str, message: str, field: str, help: str | None = None) -> None:
        """Report a fault of a field."""
        self.reports.error(
            code, self.joint.name, message, dotted(self.stated.path(field)), self.span(field), help
        )

    def check_unit(self, value: SpecValue, but: str, path: Path, help: str = UNITS_OF_JOINTS) -> None:
        """Refuse a number that is in the other kind of joint's unit.

        Args:
            value: The number.
            but: What it is said to be, behind "'hip' is a hinge joint, but".
            path: Where it is written.
            help: Units of the two kinds.
        """
        if value.linear is None or value.linear is (self.kind is JointKind.SLIDE):
            return
        self.collector.error(
            "RES001",
            f"'{self.joint.name}' is a {self.kind.value} joint, but {but}",
            where=dotted(path),
            span=self.stated.spec.span(*path),
            help=help,
        )

    def identified(self, field: str, kind: Kind) -> Quantity | None:
        """The fitted value of a field, or None."""
        result = self.stated.result
        if result is None:
            return None
        value = getattr(result.friction, field.partition(".")[2]) if "." in field else getattr(result, field)
        if not isinstance(value, SpecValue) or value.value is None:
            return None
        file = str(self.stated.group.identified)
        path = ("actuators", self.stated.binding.group, "identified")
        self.check_unit(value, f"{file} gives its {field} as {value.written}", path)
        found = written(value, self.unit(kind), self.stated.spec.span(*path), Origin.IDENTIFIED)
        return replace(found, source=found.source or file)

    def number(
        self,
        field: str,
        kind: Kind,
        *,
        derived: Quantity | None = None,
        rest: tuple[Quantity | None, ...] = (),
    ) -> Quantity | None:
        """A field by the precedence authored > identified > derived > rest; None when nobody states it."""
        authored = self.stated.authored(field, kind)
        fitted = self.identified(field, kind) if field in FITTED else None
        self.compare(field, self.stated.get(field), authored, fitted)
        return choose(authored, fitted, derived, *rest)

    def compare(
        self,
        field: str,
        value: object,
        authored: Quantity | None,
        fitted: Quantity | None,
        word: str | None = None,
    ) -> None:
        """Report an identified number that is asked for and missing, or far from the authored one.

        Args:
            field: The field.
            value: What is written.
            authored: The written number.
            fitted: The identified one.
            word: Key to write `identified` at; default: the field's own.
        """
        if isinstance(value, SpecValue) and value.identified and fitted is None:
            self.error(
                "RES002",
                f"{field} is to be the identified value, but the results have none",
                field,
                f"see {self.stated.group.identified}, or write the number here",
            )
        apart = conflict(authored, fitted)
        if apart is not None:
            self.collector.warning(
                "RES010",
                f"{self.joint.name}: {field}: {apart}",
                where=dotted(self.stated.path(field)),
                span=self.span(field),
                help="the authored value is used; to use the fitted one write "
                f"`{word or field.split('.')[-1]}: identified`",
            )


def joint_inputs(
    stated: Stated, model: ModelValues, motor: JointMotor | None, collector: Collector, reports: Reports
) -> JointInputs:
    """Gather what is said about a joint.

    Args: as the fields of `JointInputs`.
    """
    command, level = Command(stated.group.command), Level(stated.group.level)
    return JointInputs(stated, model, motor, command, level, collector, reports)
