"""What the spec states of one joint: its group's fields with the overrides of the joint laid over."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Collector
from actspec.ir import JointKind, Quantity
from actspec.resolution.binding import Binding
from actspec.resolution.quantities import unit_of, written
from actspec.spec.derive import DerivedGain
from actspec.spec.fields import CommandRange
from actspec.spec.models import Actuators, Motor
from actspec.spec.paths import Path, dotted
from actspec.spec.validate import Spec
from actspec.spec.values import SpecValue
from actspec.units import Kind

if TYPE_CHECKING:
    from actspec.spec.results import JointResult

FIELDS = (
    "motor",
    "reduction",
    "transmission",
    "motors_per_joint",
    "kp",
    "kd",
    "effort_limit",
    "velocity_limit",
    "armature",
    "command_filter",
    "command_range",
    "delay",
    "encoder_bias",
    "action_scale",
)
FRICTION = ("coulomb", "viscous", "static", "stribeck_velocity")

UNITS_OF_JOINTS = "a hinge is in rad and N*m, a slide in m and N"
"""What to write where a unit does not fit the joint."""


@dataclass(frozen=True, slots=True)
class Stated:
    """Fields of one joint as the spec states them.

    Attributes:
        spec: The spec.
        binding: The joint and its group.
        group: The group.
        motor: Its motor; None without one.
        result: What identification says of the joint; None without results.
        fields: Field (`kp`, `friction.viscous`, ...) to (what is written, where).
    """

    spec: Spec
    binding: Binding
    group: Actuators
    motor: Motor | None
    result: JointResult | None
    fields: dict[str, tuple[Any, Path]]

    @property
    def kind(self) -> JointKind:
        """hinge or slide."""
        return self.binding.joint.kind

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
        return written(value, unit_of(kind, self.kind), self.spec.span(*self.path(field)))


def stated_of(spec: Spec, binding: Binding, collector: Collector) -> Stated:
    """Lay the overrides of a joint over its group's fields; two for one field are an error."""
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
                collector.error(
                    "BIND006",
                    f"two overrides of '{binding.joint.name}' state {field}: {dotted(overridden[field])} "
                    f"and {dotted(path)}",
                    where=dotted(path),
                    span=spec.span(*path),
                    help="make the patterns disjoint",
                )
            overridden[field] = path
            fields[field] = (value, path)
    motor_name = fields["motor"][0] if "motor" in fields else None
    motor = spec.model.motors.get(motor_name) if motor_name is not None else None
    result = None
    if group.identified is not None:
        result = spec.results[group.identified].joints.get(binding.joint.name)
    found = Stated(spec, binding, group, motor, result, fields)
    _check_units(found, collector)
    return found


def _lay(fields: dict[str, tuple[Any, Path]], source: Any, path: Path) -> None:
    for field in FIELDS:
        value = getattr(source, field)
        if value is not None:
            fields[field] = (value, (*path, field))
    if source.friction is not None:
        for part in FRICTION:
            value = getattr(source.friction, part)
            if value is not None:
                fields[f"friction.{part}"] = (value, (*path, "friction", part))


def _check_units(stated: Stated, collector: Collector) -> None:
    """A hinge takes rad, a slide m: refuse the other one's unit."""
    for field, (value, path) in stated.fields.items():
        if isinstance(value, SpecValue) and value.value is not None and value.linear is not None:
            _fault(stated, field, value, path, collector)
        if isinstance(value, DerivedGain):
            for key, number in value.numbers.items():
                _fault(stated, f"{key} of {field}", number, (*path, key), collector)
            if isinstance(value.inertia, SpecValue):
                _fault(stated, f"inertia of {field}", value.inertia, (*path, "inertia"), collector)
        if isinstance(value, CommandRange):
            for end in (value.low, value.high):
                _fault(stated, field, end, path, collector)


def _fault(stated: Stated, field: str, value: SpecValue, path: Path, collector: Collector) -> None:
    kind = stated.kind
    if value.linear is None or value.linear is (kind is JointKind.SLIDE):
        return
    collector.error(
        "RES001",
        f"'{stated.binding.joint.name}' is a {kind.value} joint, but {field} is given as {value.written}",
        where=dotted(path),
        span=stated.spec.span(*path),
        help=UNITS_OF_JOINTS,
    )
