"""Which joint belongs to which group: patterns against the robot's joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from actspec.diagnostics import Collector, Diagnostic, Severity, listed
from actspec.ir import JointKind
from actspec.patterns import PatternError, match_names, suggest_pattern
from actspec.robot.view import JointView, RobotView
from actspec.spec.paths import Path, dotted
from actspec.spec.validate import Spec


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


def bind(spec: Spec, robot: RobotView, collector: Collector) -> Bindings:
    """Match every pattern of the spec; breaches go to the collector."""
    joints = [joint for joint in robot.joints if joint.kind in (JointKind.HINGE, JointKind.SLIDE)]
    matcher = _Matcher(spec, robot, [joint.name for joint in joints], collector)
    model = spec.model
    owner: dict[str, tuple[str, str, int]] = {}
    for name, group in model.actuators.items():
        for index, pattern in enumerate(group.joints):
            path: Path = ("actuators", name, "joints", index)
            for joint in matcher.match(pattern, path):
                if joint in owner and owner[joint][0] != name:
                    other, other_pattern, other_index = owner[joint]
                    place = spec.span("actuators", other, "joints", other_index)
                    collector.error(
                        "BIND002",
                        f"the joint '{joint}' is in two groups: '{name}' by '{pattern}' and '{other}' by "
                        f"'{other_pattern}' ({place})",
                        where=dotted(path),
                        span=spec.span(*path),
                        help="make the patterns disjoint; to change one field of some joints use `overrides`",
                    )
                owner.setdefault(joint, (name, pattern, index))
    unmanaged: dict[str, str] = {}
    for index, pattern in enumerate(model.robot.unmanaged):
        path = ("robot", "unmanaged", index)
        for joint in matcher.match(pattern, path):
            unmanaged.setdefault(joint, pattern)
            if joint in owner:
                collector.error(
                    "BIND003",
                    f"the joint '{joint}' is unmanaged by '{pattern}' and in the group '{owner[joint][0]}'",
                    where=dotted(path),
                    span=spec.span(*path),
                    help="narrow one of the two patterns",
                )
    overrides: dict[tuple[str, str], list[str]] = {}
    for name, group in model.actuators.items():
        members = [joint for joint, (other, _, _) in owner.items() if other == name]
        for pattern in group.overrides:
            path = ("actuators", name, "overrides", pattern)
            for joint in matcher.match(
                pattern, path, names=members, scope=f"of the group '{name}'", key=True
            ):
                overrides.setdefault((name, joint), []).append(pattern)
    pose: dict[str, str] = {}
    for pattern in model.robot.default_pose:
        path = ("robot", "default_pose", pattern)
        for joint in matcher.match(pattern, path, key=True):
            if joint in pose:
                collector.error(
                    "BIND004",
                    f"the joint '{joint}' has two default positions, by '{pose[joint]}' and '{pattern}'",
                    where=dotted(path),
                    span=spec.document.spans.key(path),
                    help="make the patterns disjoint",
                )
            pose.setdefault(joint, pattern)
    loose = [joint.name for joint in joints if joint.name not in owner and joint.name not in unmanaged]
    if loose and not matcher.failed:
        _report_loose(spec, robot, loose, collector)
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
    return Bindings(managed, tuple(joint.name for joint in joints if joint.name not in owner), pose)


def _report_loose(spec: Spec, robot: RobotView, loose: Sequence[str], collector: Collector) -> None:
    """Joints in no group: an error where the file drives them, else said once.

    Only an MJCF with actuators can say that a joint has none; of another file the spec must.
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
        collector.add(
            Diagnostic(
                "BIND005" if error else "BIND007",
                severity,
                f"{len(names)} joint{'s' * (len(names) > 1)} of '{robot.name}' in no group"
                f"{'' if error else ' and without an actuator in the model: left as they are'}: {listed(names)}",
                "actuators",
                span,
                "add them to a group, or to robot.unmanaged to leave them as they are" if error else None,
            )
        )


class _Matcher:
    """Matches patterns and reports those that match nothing."""

    def __init__(self, spec: Spec, robot: RobotView, names: Sequence[str], collector: Collector) -> None:
        self.spec = spec
        self.robot = robot
        self.names = names
        self.collector = collector
        self.failed = False

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
        spans = self.spec.document.spans
        span = spans.key(path) if key else spans.value(path)
        try:
            found = match_names(pattern, names)
        except PatternError as err:
            self.failed = True
            self.collector.error("SPEC122", err.message, where=dotted(path), span=span, help=err.help)
            return ()
        if found:
            return found
        self.failed = True
        try:
            elsewhere = set(match_names(pattern, [joint.name for joint in self.robot.joints]))
        except PatternError:
            # It is safe to match against the group's joints, not against all of them.
            elsewhere = set()
        others = [joint for joint in self.robot.joints if joint.name in elsewhere]
        guess = suggest_pattern(pattern, names)
        if others and others[0].kind not in (JointKind.HINGE, JointKind.SLIDE):
            help: str | None = (
                f"'{others[0].name}' is a {others[0].kind.value} joint; only hinge and slide joints have actuators here"
            )
        elif others and scope:
            help = f"it matches {listed([j.name for j in others])}, outside the group"
        elif guess is not None:
            help = f"did you mean '{guess}'? (matches {listed(match_names(guess, names))})"
        else:
            help = f"joints: {listed(names)}" if names else "it has no hinge or slide joint with a name"
        self.collector.error(
            "BIND001",
            f"the pattern '{pattern}' matches no joint {scope or f'of {self.robot.name!r}'}",
            where=dotted(path),
            span=span,
            help=help,
        )
        return ()
