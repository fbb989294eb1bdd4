"""What is said of one joint: spec, results, motor, robot file.

Patterns put a joint in a group, whose fields it has, with the overrides of the joint laid over.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Collector, Diagnostic, Path, Severity, Span, dotted, listed, nearest
from actspec.fields import BY_SPEC, FRICTION, unit_of_kind
from actspec.ir import Command, JointKind, Level, Origin, Quantity, tidy
from actspec.patterns import PatternError, apart, is_slip, match_names, suggest_pattern
from actspec.resolution.quantities import Reports, choose, conflict, written
from actspec.robot.view import JointView, RobotView
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


def stated_of(spec: Spec, binding: Binding, breaches: Breaches, reports: Reports) -> Stated:
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
    _check_units(found, reports)
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


def _check_units(stated: Stated, reports: Reports) -> None:
    """A hinge takes rad, a slide m: refuse the other one's unit."""

    def check(field: str, value: SpecValue, path: Path) -> None:
        _check_unit(stated, value, f"{field} is given as {value.written}", path, reports)

    for field, (value, path) in stated.fields.items():
        if isinstance(value, SpecValue) and value.value is not None:
            check(field, value, path)
        if isinstance(value, DerivedGain):
            for key, number in value.numbers.items():
                check(f"{key} of {field}", number, (*path, key))
            if isinstance(value.inertia, SpecValue):
                check(f"inertia of {field}", value.inertia, (*path, "inertia"))
        if isinstance(value, CommandRange):
            check(field, value.high if value.low.linear is None else value.low, path)


def _check_unit(
    stated: Stated, value: SpecValue, given: str, path: Path, reports: Reports, help: str = UNITS_OF_JOINTS
) -> None:
    """Refuse a number that is in the other kind of joint's unit; `given` says what it is said to be."""
    if value.linear is not None and value.linear is not (stated.kind is JointKind.SLIDE):
        message = f"{given}, which does not fit a {stated.kind.value} joint"
        span = stated.spec.span(*path)
        reports.error("RES001", stated.binding.joint.name, message, dotted(path), span, help)


@dataclass(frozen=True, slots=True)
class Binding:
    """A managed joint with its group.

    Attributes:
        joint: The joint.
        group: Name of its group.
        pattern: The pattern of the group that matched it.
        overrides: Patterns of the group's overrides that match it.
    """

    joint: JointView
    group: str
    pattern: str
    overrides: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Bindings:
    """All joints, managed and not, in the robot's order."""

    managed: tuple[Binding, ...]
    unmanaged: tuple[str, ...]
    """Joints left as they are: by `robot.unmanaged`, or in no group and without an actuator."""
    default_pose: dict[str, str]
    """Joint to the pattern of `default_pose` that matches it."""
    failed: bool
    """Whether a joint may be unmanaged by a wrong pattern."""


def bind(spec: Spec, robot: RobotView, breaches: Breaches) -> Bindings:
    """Match every pattern of the spec; what is wrong is reported."""
    joints = [joint for joint in robot.joints if joint.kind in (JointKind.HINGE, JointKind.SLIDE)]
    matcher = _Matcher(spec, robot, [joint.name for joint in joints], breaches)
    model = spec.model
    owner: dict[str, tuple[str, str, int]] = {}
    broken: set[str] = set()
    twice: dict[tuple[str, int, str, str, int], list[str]] = {}
    for name, group in model.actuators.items():
        for index, pattern in enumerate(group.joints):
            path: Path = ("actuators", name, "joints", index)
            found = matcher.match(pattern, path)
            if not found:
                broken.add(name)
            for joint in found:
                if joint in owner and owner[joint][0] != name:
                    twice.setdefault((name, index, *owner[joint]), []).append(joint)
                owner.setdefault(joint, (name, pattern, index))
    for (name, index, other, other_pattern, other_index), both in twice.items():
        # Those in no group are told when it is known which group has these.
        matcher.failed = True
        what = f"joint '{both[0]}' is" if len(both) == 1 else f"joints {listed(both)} are"
        breaches.error(
            "BIND002",
            f"the {what} in two groups: '{name}' by '{model.actuators[name].joints[index]}' and '{other}' by "
            f"'{other_pattern}' ({spec.span('actuators', other, 'joints', other_index)})",
            ("actuators", name, "joints", index),
            "make the patterns disjoint; to change one field of some joints use `overrides`",
        )
    unmanaged: dict[str, str] = {}
    for index, pattern in enumerate(model.robot.unmanaged):
        path = ("robot", "unmanaged", index)
        for joint in matcher.match(pattern, path):
            unmanaged.setdefault(joint, pattern)
            if joint in owner:
                breaches.error(
                    "BIND003",
                    f"the joint '{joint}' is unmanaged by '{pattern}' and in the group '{owner[joint][0]}'",
                    path,
                    "narrow one of the two patterns",
                )
    overrides: dict[tuple[str, str], list[str]] = {}
    for name, group in model.actuators.items():
        # Of a group with a wrong pattern it is not known which joints it lacks.
        members = None if name in broken else [joint for joint, held in owner.items() if held[0] == name]
        scope = "" if members is None else f"of the group '{name}'"
        for pattern in group.overrides:
            path = ("actuators", name, "overrides", pattern)
            for joint in matcher.match(pattern, path, names=members, scope=scope, key=True):
                overrides.setdefault((name, joint), []).append(pattern)
    pose: dict[str, str] = {}
    for pattern in model.robot.default_pose:
        path = ("robot", "default_pose", pattern)
        for joint in matcher.match(pattern, path, key=True):
            if joint in pose:
                breaches.error(
                    "BIND004",
                    f"the joint '{joint}' has two default positions, by '{pose[joint]}' and '{pattern}'",
                    path,
                    "make the patterns disjoint",
                    key=True,
                )
            pose.setdefault(joint, pattern)
    matcher.report()
    loose = [joint.name for joint in joints if joint.name not in owner and joint.name not in unmanaged]
    if loose and not matcher.failed:
        _report_loose(spec, robot, loose, {name: held[0] for name, held in owner.items()}, breaches.collector)
    managed = tuple(
        Binding(
            joint,
            owner[joint.name][0],
            owner[joint.name][1],
            tuple(overrides.get((owner[joint.name][0], joint.name), ())),
        )
        for joint in joints
        if joint.name in owner
    )
    unmanaged_joints = tuple(joint.name for joint in joints if joint.name not in owner)
    return Bindings(managed, unmanaged_joints, pose, matcher.failed)


def _report_loose(
    spec: Spec, robot: RobotView, loose: Sequence[str], groups: Mapping[str, str], collector: Collector
) -> None:
    """Joints in no group: an error where the file drives them, else said once.

    Only an MJCF with actuators can say that a joint has none; of another file the spec must.

    Args:
        spec: The spec.
        robot: Its robot.
        loose: The joints.
        groups: Group of each other joint.
        collector: Takes what is reported.
    """
    driven = {
        actuator.target for actuator in robot.actuators if actuator.transmission in ("joint", "jointinparent")
    }
    forgotten = [name for name in loose if not driven or name in driven]
    passive = [name for name in loose if name not in forgotten]
    span = spec.document.spans.key(("actuators",))
    for names, severity in ((forgotten, Severity.ERROR), (passive, Severity.INFO)):
        if not names:
            continue
        error = severity is Severity.ERROR
        like = {nearest(name, list(groups)) for name in names}
        akin = sorted(name for name in like if name is not None)
        one_group = len({groups[name] for name in akin}) == 1 and None not in like
        hint = f" (`{groups[akin[0]]}` has {listed(akin)})" if one_group else ""
        collector.add(
            Diagnostic(
                "BIND005" if error else "BIND007",
                severity,
                f"{len(names)} joint{'s' * (len(names) > 1)} of '{robot.name}' in no group"
                f"{'' if error else ' and without an actuator in the model: left as they are'}: {listed(names)}",
                "actuators",
                span,
                f"add them to a group{hint}, or to robot.unmanaged to leave them as they are"
                if error
                else None,
            )
        )


MANY = 3
"""Patterns that match nothing, from which on they may have one cause. Chosen: two are slips."""
MOST_SUGGESTIONS = 20
"""Patterns for which the nearest right one is looked for, which may take 50 ms each."""


@dataclass(frozen=True, slots=True)
class _Miss:
    """A pattern that matches nothing.

    Attributes:
        pattern: Its text.
        path: Where it stands.
        names: The joints that it was held to.
        scope: What they are joints of; "" for those of the robot.
        key: Whether it is a key.
    """

    pattern: str
    path: Path
    names: Sequence[str]
    scope: str
    key: bool


class _Matcher:
    """Matches patterns, and reports in the end those that match nothing."""

    def __init__(self, spec: Spec, robot: RobotView, names: Sequence[str], breaches: Breaches) -> None:
        self.spec = spec
        self.robot = robot
        self.names = names
        self.breaches = breaches
        self.failed = False
        self._matched: set[str] = set()
        self._missed: list[_Miss] = []
        self._suggestions = MOST_SUGGESTIONS

    def match(
        self,
        pattern: str,
        path: Path,
        names: Sequence[str] | None = None,
        scope: str = "",
        *,
        key: bool = False,
    ) -> tuple[str, ...]:
        names = self.names if names is None else names
        try:
            found = match_names(pattern, names)
        except PatternError as err:
            self.failed = True
            self.breaches.error("SPEC122", err.message, path, err.help, key=key)
            return ()
        if found:
            self._matched.add(pattern)
        else:
            self.failed = True
            self._missed.append(_Miss(pattern, path, names, scope, key))
        return found

    def report(self) -> None:
        """Report each pattern that matches nothing, or once that the model is another robot's."""
        missed = list(dict.fromkeys(miss.pattern for miss in self._missed))
        count, all_of_them = len(missed), len({*missed, *self._matched})
        robot = f"'{self.robot.name}'"
        if missed and not self.names:
            message = f"{robot} has no hinge or slide joint with a name, and the spec has patterns of joints"
            have = "name a model that has joints"
            if self.robot.path.endswith(".xacro"):
                have = "expand it first, and name what that writes: `xacro ROBOT.urdf.xacro -o ROBOT.urdf`"
        elif self._is_another(count):
            many = f"{count} of the spec's {all_of_them} patterns match no joint"
            message = (
                f"{'no pattern of the spec matches a joint' if count == all_of_them else many} of {robot}: the "
                "model is another robot's, or its joints have other names"
            )
            have = f"it has the joints {listed(self.names, 4)}"
        else:
            for miss in self._missed:
                self._report_one(miss)
            return
        without = listed([f"'{pattern}'" for pattern in missed], 4)
        path = ("robot", "joints" if self.spec.model.robot.model == "none" else "model")
        self.breaches.error("BIND001", message, path, f"{have}; the patterns without a match: {without}")

    def _is_another(self, missed: int) -> bool:
        """Whether the model is another robot's: more than a third of what puts joints into groups has none at all."""
        if missed < MANY:
            return False
        groups = {pattern for group in self.spec.model.actuators.values() for pattern in group.joints}
        joints = [joint.name for joint in self.robot.joints]
        strange = 0
        for number, pattern in enumerate(sorted(groups - self._matched)):
            with suppress(PatternError):
                if len(apart(pattern)) == 1 and not match_names(pattern, joints):
                    strange += number >= MOST_SUGGESTIONS or not is_slip(pattern, joints)
        return 3 * strange > len(groups)

    def _report_one(self, miss: _Miss) -> None:
        pattern, names, scope = miss.pattern, miss.names, miss.scope
        try:
            elsewhere = set(match_names(pattern, [joint.name for joint in self.robot.joints]))
        except PatternError:
            # It is safe to match against the group's joints, not against all of them.
            elsewhere = set()
        others = [joint for joint in self.robot.joints if joint.name in elsewhere]
        guess = None
        parts = apart(pattern)
        if self._suggestions and len(parts) == 1:
            self._suggestions -= 1
            guess = suggest_pattern(pattern, names)
        if len(parts) > 1 and not miss.key:
            written = ", ".join(f'"{part}"' for part in parts)
            help: str | None = f"a comma in a text ends no pattern: write `[{written}]`"
        elif others and others[0].kind not in (JointKind.HINGE, JointKind.SLIDE):
            kind = others[0].kind.value
            help = f"'{others[0].name}' is a {kind} joint; only hinge and slide joints have actuators here"
        elif others and scope:
            help = f"it matches {listed([j.name for j in others])}, outside the group"
        elif guess is not None:
            help = f"did you mean '{guess}'? (matches {listed(match_names(guess, names))})"
        else:
            help = f"joints: {listed(names)}"
        self.breaches.error(
            "BIND001",
            f"the pattern '{pattern}' matches no joint {scope or f'of {self.robot.name!r}'}",
            miss.path,
            help,
            key=miss.key,
        )


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
