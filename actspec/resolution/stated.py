"""What is said of one joint: spec, results, motor, robot file.

A joint has the fields of its group, with its overrides laid over.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Path, Span, dotted, listed
from actspec.fields import BY_SPEC, FRICTION, unit_of_kind
from actspec.ir import Command, JointKind, Level, Origin, Quantity, tidy
from actspec.resolution.binding import Binding
from actspec.resolution.quantities import Reports, choose, conflict, written
from actspec.robot.view import JointView
from actspec.spec.document import Breaches
from actspec.spec.fields import CommandRange, DerivedGain
from actspec.spec.models import Actuators, Motor, Tunable
from actspec.spec.validate import Spec
from actspec.spec.values import SpecValue
from actspec.units import Kind

if TYPE_CHECKING:
    from actspec.resolution.motor import JointMotor
    from actspec.resolution.quantities import ModelValues
    from actspec.spec.results import JointResult, ResultsFile


FIELDS = tuple(name for name in Tunable.model_fields if name != "friction")
"""What a group states of its joints; its friction by part."""

UNITS_OF_JOINTS = "a hinge is in rad and N*m, a slide in m and N; each kind has a group of its own"
"""What to write where a unit does not fit the joint."""


@dataclass(frozen=True, slots=True)
class Stated:
    """Fields of one joint as the spec states them.

    Attributes:
        spec: The spec.
        binding: The joint and its group.
        group: The group.
        motor: Its motor; None without one.
        results: The group's results file; None without one.
        fields: Field (`kp`, `friction.viscous`, ...) to (what is written, where).
    """

    spec: Spec
    binding: Binding
    group: Actuators
    motor: Motor | None
    results: ResultsFile | None
    fields: dict[str, tuple[Any, Path]]

    @property
    def kind(self) -> JointKind:
        """hinge or slide."""
        return self.binding.joint.kind

    @property
    def result(self) -> JointResult | None:
        """What identification says of the joint; None: nothing."""
        return None if self.results is None else self.results.model.joints.get(self.binding.joint.name)

    def result_span(self, *path: str | int) -> Span | None:
        """Where the results file says something of the joint; None without a file."""
        if self.results is None:
            return None
        return self.results.document.spans.value(("joints", self.binding.joint.name, *path))

    def get(self, field: str) -> Any:
        """What is written, or None."""
        return self.fields[field][0] if field in self.fields else None

    def path(self, field: str) -> Path:
        """Where a field is written; the group where it is not."""
        return self.fields[field][1] if field in self.fields else ("actuators", self.binding.group)

    def authored(self, field: str, kind: Kind) -> Quantity | None:
        """The written number; None when nothing, or the word `identified`, is written."""
        value = self.get(field)
        if not isinstance(value, SpecValue) or value.identified:
            return None
        return written(value, unit_of_kind(kind, self.kind), self.spec.span(*self.path(field)))


def stated_of(spec: Spec, binding: Binding, mixed: bool, breaches: Breaches, reports: Reports) -> Stated:
    """Lay the overrides of a joint over its group's fields; two for one field are an error.

    Args:
        spec: The spec.
        binding: The joint and its group.
        mixed: The group has both hinges and slides.
        breaches: Takes what concerns this joint alone.
        reports: Takes what may concern others in the same way.
    """
    name = binding.group
    group = spec.model.actuators[name]
    fields: dict[str, tuple[Any, Path]] = {}
    _lay(fields, group, ("actuators", name))
    overridden: dict[str, Path] = {}
    for pattern in binding.overrides:
        layer: dict[str, tuple[Any, Path]] = {}
        _lay(layer, group.overrides[pattern], ("actuators", name, "overrides", pattern))
        for field, (value, path) in layer.items():
            if field in overridden:
                breaches.error(
                    "BIND006",
                    f"two overrides of '{binding.joint.name}' state {field}: {dotted(overridden[field])} "
                    f"and {dotted(path)}",
                    path,
                    "make the patterns disjoint",
                )
            overridden[field] = path
            fields[field] = (value, path)
    motor_name = fields["motor"][0] if "motor" in fields else None
    motor = spec.model.motors.get(motor_name) if motor_name is not None else None
    results = None if group.identified is None else spec.results[group.identified]
    found = Stated(spec, binding, group, motor, results, fields)
    _check_units(found, reports, mixed)
    return found


def _lay(fields: dict[str, tuple[Any, Path]], source: Any, path: Path) -> None:
    for field in FIELDS:
        value = getattr(source, field)
        if value is not None:
            fields[field] = (value, (*path, field))
    if source.friction is not None:
        for part in FRICTION:
            key = part.spec.partition(".")[2]
            value = getattr(source.friction, key)
            if value is not None:
                fields[part.spec] = (value, (*path, "friction", key))


def _check_units(stated: Stated, reports: Reports, mixed: bool) -> None:
    """A hinge takes rad, a slide m: refuse the other one's unit.

    Several in a group that has joints of both kinds are right for the others: then it is the joint that is wrong there.
    """
    unfit = [item for item in _numbers(stated) if not _fits(stated, item[1])]
    name, kind = stated.binding.joint.name, stated.kind.value
    if mixed and len(unfit) > 1:
        number = stated.group.joints.index(stated.binding.pattern)
        path: Path = ("actuators", stated.binding.group, "joints", number)
        figures = listed([f"{field} {value.written}" for field, value, _ in unfit], 2)
        message = f"{len(unfit)} numbers of its group do not fit a {kind} joint: {figures}"
        reports.error("RES001", name, message, dotted(path), stated.spec.span(*path), UNITS_OF_JOINTS)
        return
    for field, value, path in unfit:
        _check_unit(stated, value, f"{field} is given as {value.written}", path, reports)


def _numbers(stated: Stated) -> Iterator[tuple[str, SpecValue, Path]]:
    """The numbers that are stated of a joint, with what they are and where they stand."""
    for field, (value, path) in stated.fields.items():
        if isinstance(value, SpecValue) and value.value is not None:
            yield field, value, path
        if isinstance(value, DerivedGain):
            for key, number in value.numbers.items():
                yield f"{key} of {field}", number, (*path, key)
            if isinstance(value.inertia, SpecValue):
                yield f"inertia of {field}", value.inertia, (*path, "inertia")
        if isinstance(value, CommandRange):
            yield field, value.high if value.low.linear is None else value.low, path


def _fits(stated: Stated, value: SpecValue) -> bool:
    """Whether a number has no unit, or one of the joint's kind."""
    return value.linear is None or value.linear is (stated.kind is JointKind.SLIDE)


def _check_unit(
    stated: Stated, value: SpecValue, given: str, path: Path, reports: Reports, help: str = UNITS_OF_JOINTS
) -> None:
    """Refuse a number that is in the other kind of joint's unit; `given` says what it is said to be."""
    if not _fits(stated, value):
        message = f"{given}, which does not fit a {stated.kind.value} joint"
        span = stated.spec.span(*path)
        reports.error("RES001", stated.binding.joint.name, message, dotted(path), span, help)


FITTED = tuple(spec for spec, field in BY_SPEC.items() if field.fitted)
"""Fields that identification results may hold, beside the delay and the bandwidth."""


FITTED_AS = {"command_filter": "bandwidth"}
"""Field of a spec to its name in results, where the two differ."""


@dataclass(frozen=True, slots=True)
class JointInputs:
    """What is said about one joint.

    Attributes:
        stated: What spec and results state.
        model: What the robot's file states.
        motor: Its motor, at the joint; None without one.
        command: What is commanded.
        level: How much of the drive is modelled.
        breaches: Takes what concerns this joint alone.
        reports: Takes what may concern others in the same way.
        uncompiled: Whether only a compilation of the model tells inertia.
    """

    stated: Stated
    model: ModelValues
    motor: JointMotor | None
    command: Command
    level: Level
    breaches: Breaches
    reports: Reports
    uncompiled: bool = False

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
        return unit_of_kind(kind, self.kind)

    def derived(self, field: str, kind: Kind, value: float, formula: str) -> Quantity:
        """A number that follows from others [SI]; `formula` says how."""
        unit, span = self.unit(kind), self.span(field)
        return Quantity(tidy(value), unit, Origin.DERIVED, span=span, formula=formula)

    def error(self, code: str, message: str, field: str, help: str | None = None) -> None:
        """Report a fault of a field."""
        self.reports.error(
            code, self.joint.name, message, dotted(self.stated.path(field)), self.span(field), help
        )

    def check_unit(self, value: SpecValue, given: str, path: Path, help: str = UNITS_OF_JOINTS) -> None:
        """Refuse a number that is in the other kind of joint's unit.

        Args:
            value: The number.
            given: What it is said to be: "kp is given as 5 N/m".
            path: Where it is written.
            help: Units of the two kinds.
        """
        _check_unit(self.stated, value, given, path, self.reports, help)

    def identified(self, field: str, kind: Kind) -> Quantity | None:
        """The fitted value of a field, or None."""
        result = self.stated.result
        if result is None:
            return None
        value = getattr(result.friction, field.partition(".")[2]) if "." in field else getattr(result, field)
        if not isinstance(value, SpecValue) or value.value is None:
            return None
        file, span = str(self.stated.group.identified), self.stated.result_span(*field.split("."))
        if value.linear is not None and value.linear is not (self.kind is JointKind.SLIDE):
            name = self.joint.name
            self.breaches.collector.at(f"joints.{name}.{field}", span).error(
                "RES001",
                f"'{name}' is a {self.kind.value} joint, but its {field} is {value.written}",
                UNITS_OF_JOINTS,
            )
        found = written(value, self.unit(kind), span, Origin.IDENTIFIED)
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
            from actspec.resolution.identified import why_missing

            fitted_field = FITTED_AS.get(field, field)
            why, help = why_missing(self, fitted_field)
            self.error("RES002", f"{field} is to be the identified value, but {why}", field, help)
        apart = conflict(authored, fitted)
        if apart is not None:
            self.breaches.collector.at(dotted(self.stated.path(field)), self.span(field)).warning(
                "RES010",
                f"{self.joint.name}: {field}: {apart}",
                "the authored value is used; to use the fitted one write "
                f"`{word or field.split('.')[-1]}: identified`",
            )


def joint_inputs(
    stated: Stated,
    model: ModelValues,
    motor: JointMotor | None,
    breaches: Breaches,
    reports: Reports,
    uncompiled: bool = False,
) -> JointInputs:
    """Gather what is said about a joint.

    Args: as the fields of `JointInputs`.
    """
    command, level = Command(stated.group.command), Level(stated.group.level)
    return JointInputs(stated, model, motor, command, level, breaches, reports, uncompiled)
