"""Patterns put every joint of the robot into one group, or into none."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple

from actspec.diagnostics import Collector, Diagnostic, Path, Severity, listed, nearest
from actspec.patterns import PatternError, apart, is_slip, match_names, recased, suggest_pattern
from actspec.robot.view import JointView, RobotView
from actspec.spec.document import Breaches
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
    failed: bool
    """Whether a joint may be unmanaged by a wrong pattern."""


class _Place(NamedTuple):
    """A pattern of a group."""

    group: str
    number: int
    pattern: str

    @property
    def path(self) -> Path:
        """Where it is written."""
        return ("actuators", self.group, "joints", self.number)


def bind(spec: Spec, robot: RobotView, breaches: Breaches) -> Bindings:
    """Match every pattern of the spec; what is wrong is reported."""
    joints = robot.scalar_joints
    matcher = _Matcher(spec, robot, [joint.name for joint in joints], breaches)
    model = spec.model
    owner: dict[str, _Place] = {}
    had: dict[_Place, tuple[str, ...]] = {}
    broken: set[str] = set()
    twice: dict[_Place, dict[_Place, list[str]]] = {}
    doubtful: set[str] = set()
    for name, group in model.actuators.items():
        for index, pattern in enumerate(group.joints):
            place = _Place(name, index, pattern)
            found = had[place] = matcher.match(pattern, ("actuators", name, "joints", index))
            if not found:
                broken.add(name)
            for joint in found:
                other = owner.setdefault(joint, place)
                if other.group == name:
                    continue
                # The one that takes all of the other's joints, and more, is the greedy one; else the second.
                first = set(had[other]) > set(found)
                if not first and not set(found) > set(had[other]):
                    # Nothing tells which of the groups is meant.
                    doubtful.add(joint)
                greedy, narrow = (other, place) if first else (place, other)
                owner[joint] = narrow
                twice.setdefault(greedy, {}).setdefault(narrow, []).append(joint)
    unmanaged: dict[str, Path] = {}
    clashes: dict[Path, list[str]] = {}
    for index, pattern in enumerate(model.robot.unmanaged):
        path: Path = ("robot", "unmanaged", index)
        for joint in matcher.match(pattern, path):
            unmanaged.setdefault(joint, path)
            if joint in owner:
                doubtful.add(joint)
                if owner[joint] not in twice:
                    clashes.setdefault(path, []).append(joint)
    for greedy, others in twice.items():
        # Those in no group are told when it is known which group has these.
        matcher.failed = True
        elsewhere = {joint for one, names in had.items() if one.group != greedy.group for joint in names}
        left = [joint for joint in had[greedy] if owner[joint] == greedy]
        alone = [joint for joint in left if joint not in elsewhere]
        _report_twice(spec, greedy, others, alone, unmanaged, breaches)
        kinds = {joint.kind for joint in joints if joint.name in left}
        if len(kinds) > 1:
            # Of hinges and slides it cannot have both.
            doubtful.update(left)
    for path, both in clashes.items():
        groups = listed(dict.fromkeys(f"'{owner[joint].group}'" for joint in both))
        breaches.error(
            "BIND003",
            f"{_the_joints(both)} unmanaged by '{model.robot.unmanaged[int(path[-1])]}' and in the "
            f"group{'s' * (',' in groups)} {groups}",
            path,
            "narrow one of the two patterns",
        )
    overrides: dict[tuple[str, str], list[str]] = {}
    for name, group in model.actuators.items():
        # Of a group with a wrong pattern it is not known which joints it lacks.
        members = None if name in broken else [joint for joint, held in owner.items() if held.group == name]
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
    matcher.report({*owner, *unmanaged})
    loose = [joint.name for joint in joints if joint.name not in owner and joint.name not in unmanaged]
    if loose and not matcher.failed:
        _report_loose(
            spec, robot, loose, {name: held.group for name, held in owner.items()}, breaches.collector
        )
    mine = {name: held for name, held in owner.items() if name not in doubtful}
    managed = tuple(
        Binding(
            joint,
            mine[joint.name].group,
            mine[joint.name].pattern,
            tuple(overrides.get((mine[joint.name].group, joint.name), ())),
        )
        for joint in joints
        if joint.name in mine
    )
    unmanaged_joints = tuple(joint.name for joint in joints if joint.name not in mine)
    return Bindings(managed, unmanaged_joints, pose, matcher.failed or bool(doubtful))


def _the_joints(names: Sequence[str]) -> str:
    return f"the joint '{names[0]}' is" if len(names) == 1 else f"the joints {listed(names)} are"


def _report_twice(
    spec: Spec,
    greedy: _Place,
    others: Mapping[_Place, Sequence[str]],
    alone: Sequence[str],
    unmanaged: Mapping[str, Path],
    breaches: Breaches,
) -> None:
    """A pattern that takes joints of other groups, once, with the unmanaged joints that it takes as well.

    Args:
        spec: The spec.
        greedy: The pattern.
        others: The patterns whose joints it takes, and which.
        alone: The joints that it alone has.
        unmanaged: Where each unmanaged joint is said to be so.
        breaches: Takes what is reported.
    """
    groups: dict[str, list[_Place]] = {}
    for other in others:
        groups.setdefault(other.group, []).append(other)
    ours = []
    for name, places in groups.items():
        patterns = listed((f"'{one.pattern}'" for one in places), 4)
        ours.append(f"'{name}' by {patterns} ({spec.span(*places[0].path)})")
    both = [joint for names in others.values() for joint in names]
    message = (
        f"{_the_joints(both)} in two groups: '{greedy.group}' by '{greedy.pattern}' and {', '.join(ours)}"
    )
    left = [joint for joint in alone if joint in unmanaged]
    if left:
        message += f"; {listed(left)} unmanaged ({spec.span(*unmanaged[left[0]])}) and in it too"
    rest = [joint for joint in alone if joint not in unmanaged]
    help = f"narrow it to {listed(rest, 4)}, in no other group" if rest else "make the patterns disjoint"
    breaches.error(
        "BIND002", message, greedy.path, f"{help}; to change one field of some joints use `overrides`"
    )


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
    driven = {actuator.target for actuator in robot.actuators if actuator.is_direct}
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
MOST_ENDS = 8
"""Beginnings and ends of names, the most frequent, that patterns may lack."""
MOST_SUGGESTIONS = 20
"""Patterns for which the nearest right one is looked for, which may take 50 ms each."""


@dataclass(frozen=True, slots=True, eq=False)
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
        self._beside: dict[Path, list[str]] = {}

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
        self._beside.setdefault(path[:-1], []).append(pattern)
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

    def report(self, placed: Collection[str]) -> None:
        """Report each pattern that matches nothing, or once that the model is another robot's.

        Args:
            placed: The joints that are in a group, or unmanaged.
        """
        missed = list(dict.fromkeys(miss.pattern for miss in self._missed))
        count, all_of_them = len(missed), len({*missed, *self._matched})
        renamed, how = self._renamed()
        robot = f"'{self.robot.name}'"
        if missed and not self.names:
            message = f"{robot} has no hinge or slide joint with a name, and the spec has patterns of joints"
            have = "name a model that has joints"
            if self.robot.path.endswith(".xacro"):
                have = "expand it first, and name what that writes: `xacro ROBOT.urdf.xacro -o ROBOT.urdf`"
        elif self._is_another(count, renamed):
            many = f"{count} of the spec's {all_of_them} patterns match no joint"
            message = (
                f"{'no pattern of the spec matches a joint' if count == all_of_them else many} of {robot}: the "
                "model is another robot's, or its joints have other names"
            )
            have = f"it has the joints {listed(self.names, 4)}"
        else:
            if renamed:
                self._report_renamed(renamed, how)
            others = [miss for miss in self._missed if miss not in renamed]
            strange = [misses for misses in self._mappings(others) if self._is_strange(misses)]
            for misses in strange:
                self._report_mapping(misses)
            told = {miss for misses in strange for miss in misses}
            for miss in others:
                if miss not in told:
                    self._report_one(miss, placed)
            return
        without = listed([f"'{pattern}'" for pattern in missed], 4)
        path = ("robot", "joints" if self.spec.model.robot.model == "none" else "model")
        self.breaches.error("BIND001", message, path, f"{have}; the patterns without a match: {without}")

    def _is_another(self, missed: int, renamed: Collection[_Miss]) -> bool:
        """Whether the model is another robot's: more than a third of what puts joints into groups has none at all.

        Args:
            missed: How many patterns match nothing.
            renamed: Those of which it is known what they mean.
        """
        if missed < MANY:
            return False
        groups = {pattern for group in self.spec.model.actuators.values() for pattern in group.joints}
        joints = [joint.name for joint in self.robot.joints]
        known = {miss.pattern for miss in renamed}
        strange = 0
        for number, pattern in enumerate(sorted(groups - self._matched - known)):
            with suppress(PatternError):
                if len(_parts(pattern, self.names)) == 1 and not match_names(pattern, joints):
                    strange += number >= MOST_SUGGESTIONS or not is_slip(pattern, joints)
        return 3 * strange > len(groups)

    def _mappings(self, missed: Sequence[_Miss]) -> Iterable[list[_Miss]]:
        """Keys without a match, those of each mapping that has no other together."""
        found: dict[Path, list[_Miss]] = {}
        for miss in missed:
            if miss.key:
                found.setdefault(miss.path[:-1], []).append(miss)
        return [misses for path, misses in found.items() if len(misses) == len(self._beside[path])]

    def _is_strange(self, misses: Sequence[_Miss]) -> bool:
        """Whether keys, too many to be slips, are names of no joint of the robot, nor nearly."""
        joints = [joint.name for joint in self.robot.joints]
        strange = 0
        for number, miss in enumerate(misses):
            with suppress(PatternError):
                known = match_names(miss.pattern, joints)
                near = number < MOST_SUGGESTIONS and is_slip(miss.pattern, joints)
                strange += not known and not near
        return strange >= MANY and strange == len(misses)

    def _report_mapping(self, misses: Sequence[_Miss]) -> None:
        path = misses[0].path[:-1]
        self.breaches.error(
            "BIND001",
            f"none of the {len(misses)} patterns matches a joint of {self.robot.name!r}: its joints have other names",
            path,
            f"it has the joints {listed(self.names, 4)}; the patterns without a match: "
            + listed([f"'{miss.pattern}'" for miss in misses], 4),
            key=True,
        )

    def _renamed(self) -> tuple[dict[_Miss, str], str]:
        """Several patterns that match joints but for one thing, each with the one that does, and what that is."""
        few = self._missed[:MOST_SUGGESTIONS]
        found = {miss: recased(miss.pattern, miss.names) for miss in few}
        cased = {miss: right for miss, right in found.items() if right is not None}
        if len(cased) > 1:
            return cased, "have other capital letters"
        words = [name.split("_") for name in self.names if "_" in name]
        ends = [("", f"_{last}") for *_, last in words] + [(f"{first}_", "") for first, *_ in words]
        best: dict[_Miss, str] = {}
        how = ""
        for (before, behind), _ in Counter(ends).most_common(MOST_ENDS):
            # A choice would have the end in one of its parts, and a repeat may be meant as a glob.
            whole = {
                miss: before + miss.pattern + behind
                for miss in few
                if "|" not in miss.pattern and not miss.pattern.endswith(("*", "+", "?", "}"))
            }
            fits = {miss: text for miss, text in whole.items() if _matches(text, miss.names)}
            if len(fits) > len(best) and len({miss.pattern for miss in fits}) > 1:
                best, how = (
                    fits,
                    f"for them begin with '{before}'" if before else f"for them end in '{behind}'",
                )
        return best, how

    def _report_renamed(self, renamed: Mapping[_Miss, str], how: str) -> None:
        """Say once how the names differ, with the whole list as it is to be, where all stand in one."""
        first = next(iter(renamed))
        written = listed(dict.fromkeys(f"'{miss.pattern}'" for miss in renamed), 4)
        right = list(dict.fromkeys(renamed.values()))
        if len({miss.path[:-1] for miss in renamed}) == 1 and not first.key:
            meant = {miss.pattern: text for miss, text in renamed.items()}
            whole = (meant.get(pattern, pattern) for pattern in self._beside[first.path[:-1]])
            items = dict.fromkeys(text if text.isidentifier() else f'"{text}"' for text in whole)
            help = f"write [{', '.join(items)}]"
        else:
            lines = listed(map(str, sorted({self.spec.span(*miss.path).line for miss in renamed})))
            quoted = listed(f"'{pattern}'" for pattern in right)
            help = f"write {quoted} (line{'s' * (',' in lines)} {lines})"
        both = f"s {written} match" if right[1:] else f" {written} matches"
        self.breaches.error(
            "BIND001",
            f"the pattern{both} no joint of {self.robot.name!r}, whose names {how}: {listed(self.names, 4)}",
            first.path,
            help,
            key=first.key,
        )

    def _report_one(self, miss: _Miss, placed: Collection[str]) -> None:
        pattern, names, scope = miss.pattern, miss.names, miss.scope
        try:
            elsewhere = set(match_names(pattern, [joint.name for joint in self.robot.joints]))
        except PatternError:
            # It is safe to match against the group's joints, not against all of them.
            elsewhere = set()
        others = [joint for joint in self.robot.joints if joint.name in elsewhere]
        guess = None
        parts = _parts(pattern, names)
        if self._suggestions and len(parts) == 1:
            self._suggestions -= 1
            guess = suggest_pattern(pattern, names)
        if len(parts) > 1 and not miss.key:
            written = ", ".join(f'"{part}"' for part in parts)
            mark = "comma" if "," in pattern else "space"
            help: str | None = f"a {mark} in a text ends no pattern: write `[{written}]`"
        elif others and not others[0].kind.is_scalar:
            kind = others[0].kind.value
            help = f"'{others[0].name}' is a {kind} joint; only hinge and slide joints have actuators here"
        elif others and scope:
            help = f"it matches {listed([j.name for j in others])}, outside the group"
            loose = [joint.name for joint in others if joint.name not in placed]
            if loose:
                those = "that is" if len(others) == 1 else f"{listed(loose)} {'are' if loose[1:] else 'is'}"
                help += f"; {those} in no group: missing from `joints` here?"
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


def _parts(text: str, names: Sequence[str]) -> tuple[str, ...]:
    """Patterns that one text has: with commas between them, or with spaces where each matches one of the names."""
    words = text.split()
    return tuple(words) if all(_matches(word, names) for word in words) else apart(text)


def _matches(pattern: str, names: Sequence[str]) -> bool:
    """Whether a text is a pattern that matches one of the names."""
    try:
        return bool(match_names(pattern, names))
    except PatternError:
        return False
