"""What one audit found, with nothing left to a rule's defaults; every report is written from it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from os.path import basename

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.diagnostics import SEVERITIES, Diagnostic, Severity, Span, listed
from actspec.patterns import recased
from actspec.readings.artifact import STEP_OF_WHAT, Artifact, FileKind, FileReading, Robot
from actspec.readings.body import SHARE, Figures, figures_of, share_a_body
from actspec.readings.called import distinctive, telling
from actspec.readings.joint_names import fits, has_joints, joint_names, matching, says_something
from actspec.readings.motor_names import names_wanted
from actspec.robot.view import RobotView

CONFIDENCES = (Confidence.LOW, Confidence.MEDIUM, Confidence.HIGH)
"""From the least to the surest."""

UNKNOWN = frozenset({"AUD015", "CFG001", "CFG003", "DEPLOY002", "DEPLOY009", STEP_OF_WHAT})
"""Codes of information about figures that no rule looks at, or that are not compared."""


LOST_FILE = "AUD021"
"""Code of a file that the baseline has findings of and that is not there."""

LOST_DRIVE = "AUD023"
"""Code of joints that had an actuator when the baseline was written."""

_COUNTED = frozenset({LOST_FILE, LOST_DRIVE})
"""The remarks that an exit code counts."""

NO_BASELINE = "AUD005"
"""Code of a baseline that is not there, or cannot be read."""

_OF_NAMED = frozenset({"DEPLOY004", STEP_OF_WHAT})
"""Remarks that are none in a folder, where a file may be somebody else's."""


@dataclass(frozen=True, slots=True)
class Reported:
    """A finding as it is reported.

    Attributes:
        finding: As the rule found it.
        name: Of the rule.
        severity: After the settings, and after what explains it.
        confidence: The finding's, else the rule's.
        cause: The finding that explains this one, which is a note for that; None: it stands for itself.
        of_folder: Whether it is a note for that its file was met in a folder, and more of one that is named.
    """

    finding: Finding
    name: str
    severity: Severity
    confidence: Confidence
    cause: Finding | None = None
    of_folder: bool = False


class Means(str, Enum):
    """How a finding was set aside."""

    INLINE = "inline"
    IGNORE = "ignore"
    SETTING = "per-file-ignores"
    BASELINE = "baseline"
    CONFIDENCE = "min-confidence"


@dataclass(frozen=True, slots=True)
class Suppressed:
    """A finding that was set aside.

    Attributes:
        reported: The finding.
        means: How.
        reason: In the words of who did it; "" where none is asked for.
    """

    reported: Reported
    means: Means
    reason: str = ""


def codes_run(
    rules: Iterable[type[Rule]], skipped: Iterable[Skipped], problems: Iterable[Diagnostic]
) -> frozenset[str]:
    """Codes of the rules that ran to their end, and had input."""
    idle = {item.code for item in skipped} | {item.where for item in problems}
    return frozenset(rule.code for rule in rules) - idle


@dataclass(frozen=True, slots=True)
class Report:
    """What an audit found.

    Attributes:
        case: What was judged: files, ledger, robots.
        rules: Rules that were asked for, by code.
        findings: By file, line, code and joint.
        suppressed: Findings that were set aside, in the same order.
        skipped: Rules that had no input.
        problems: Errors of actspec itself (a rule that broke off), and notes such as stale baseline entries.
        quiet: Of `diagnostics` those that the settings ignore.
        excluded: How many files and how many folders were passed over.
        not_read: Of each file in a folder that describes a robot and is not read, what it is: `xacro`.
    """

    case: Case
    rules: tuple[type[Rule], ...]
    findings: tuple[Reported, ...]
    suppressed: tuple[Suppressed, ...] = ()
    skipped: tuple[Skipped, ...] = ()
    problems: tuple[Diagnostic, ...] = ()
    quiet: frozenset[Diagnostic] = frozenset()
    excluded: tuple[int, int] = (0, 0)
    not_read: tuple[str, ...] = ()

    @property
    def misnamed(self) -> bool:
        """Whether something that was named is not there: a file, or the baseline."""
        lost = any(item.code == NO_BASELINE for item in self.problems)
        return lost or any(file.names_nothing for file in self.case.files)

    @property
    def complete(self) -> bool:
        """Whether all that was named is there, and every rule ran to its end. What cannot be read is a finding."""
        return not self.misnamed and not any(item.severity is Severity.ERROR for item in self.problems)

    def did_not_apply(self) -> tuple[int, dict[str, list[str]]]:
        """How many rules had no input, and the reasons with the codes of their rules."""
        reasons: dict[str, list[str]] = {}
        for item in self.skipped:
            reasons.setdefault(item.reason, []).append(item.code)
        return len({item.code for item in self.skipped}), reasons

    def at_or_above(self, severity: Severity | None) -> tuple[Reported, ...]:
        """Findings of at least this severity; none for None."""
        if severity is None:
            return ()
        least = SEVERITIES.index(severity)
        return tuple(found for found in self.findings if SEVERITIES.index(found.severity) >= least)

    def fails(self, severity: Severity | None) -> bool:
        """Whether there is a finding of at least this severity, or a file or a drive lost that the baseline has."""
        lost = severity is not None and SEVERITIES.index(severity) <= SEVERITIES.index(Severity.WARNING)
        return bool(self.at_or_above(severity)) or (
            lost and any(item.code in _COUNTED for item in self.problems)
        )

    @property
    def ran(self) -> frozenset[str]:
        """Codes of rules that ran to their end, and had input."""
        return codes_run(self.rules, self.skipped, self.problems)

    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """What readers and rules have to say; why a file could not be read, and what is not taken, are findings."""
        found: list[Diagnostic] = []
        for file in self.case.files:
            found += (
                item
                for item in file.said
                if (file.readable or file.names_nothing or item.severity is not Severity.ERROR)
                and item not in file.not_taken
                and not (file.in_folder and item.code in _OF_NAMED)
            )
            found += _from_text(file)
        said = (*found, *self.case.once(_unpaired), *self.problems)
        return tuple(item for item in said if item not in self.quiet)

    def for_people(self, least: Severity = Severity.INFO) -> tuple[Diagnostic, ...]:
        """What of it people read: mere information is for programs, but not what nobody looked at.

        Args:
            least: Least severity.
        """
        return tuple(
            item
            for item in self.diagnostics()
            if (item.severity is not Severity.INFO or item.code in UNKNOWN)
            and SEVERITIES.index(item.severity) >= SEVERITIES.index(least)
        )


def _from_text(file: FileReading) -> Iterator[Diagnostic]:
    """Why a file was judged from its text alone, where that is no finding (AUD020); for a URDF without a mass, and a
    part of a model, that is no loss.
    """
    told: dict[Diagnostic, None] = {}
    for artifact in file.artifacts:
        if artifact.text_only is None or artifact in file.refused_models:
            continue
        if file.kind is FileKind.URDF and not any(b"<inertial" in part.data for part in file.files):
            message, severity = "no link has a mass, so what needs inertia is not judged", Severity.INFO
        else:
            message = (
                f"read from its text alone, so what needs its inertia is not judged: {artifact.text_only}"
            )
            whole = artifact.is_refused and (file.in_folder or not file.included)
            severity = Severity.WARNING if whole or artifact.kind is FileKind.URDF else Severity.INFO
        told[Diagnostic("AUD013", severity, message, "", artifact.refused_at or Span(file.path))] = None
    yield from told


def _unpaired(case: Case) -> tuple[Diagnostic, ...]:
    """AUD015 of all robots: what was said is asked for several times."""
    return tuple(_of_unpaired(case))


def _of_unpaired(case: Case) -> Iterator[Diagnostic]:
    """What has the joints of a model and is not compared with it: by its name it is in a robot that has no model, or it
    is another model that somebody named.
    """
    models = {
        index: frozenset(joint_names(artifact) or ())
        for index, artifact in enumerate(case.artifacts)
        if artifact.robot is not None
    }
    named: list[int] = []
    for robot in case.robots:
        own = [index for index in robot.artifacts if index in models]
        if not own:
            yield from _without_a_model(case, robot, models)
            continue
        mine = next((index for index in own if models[index] and not case.is_met(index)), None)
        # A variant of a spec is held to its own model.
        if mine is not None and all(case.artifacts[index].model is None for index in robot.artifacts):
            yield from _beside_a_model(
                case, mine, [other for other in named if models[other] == models[mine]]
            )
            yield from _of_other_joints(
                case, mine, [other for other in named if models[other] != models[mine]]
            )
            named.append(mine)


def _without_a_model(case: Case, robot: Robot, models: Mapping[int, frozenset[str]]) -> Iterator[Diagnostic]:
    """Configurations, deploy files and specs of a robot without a model that have the joints of another one's."""
    for its, member in ((index, case.artifacts[index]) for index in robot.artifacts):
        own = frozenset(joint_names(member) or ())
        # Lists without names fit each model of so many joints; in a folder, of many robots of a family.
        by_number = member.kind is FileKind.DEPLOY and not own and not says_something(member.config)
        words = frozenset() if case.is_met(its) else distinctive(member)
        modelled = [
            case.artifacts[index].path
            for index, joints in models.items()
            if (own and len(own & joints) >= SHARE * len(own))
            or (
                not own
                and (
                    words & distinctive(case.artifacts[index]) if by_number else says_something(member.config)
                )
                and fits(member.config, sorted(joints))
            )
        ]
        near = modelled or _trained_with(case, robot, its)
        if member.config is not None and near:
            deploy = member.kind is FileKind.DEPLOY
            # A configuration's patterns say nothing of keys, which may be parts of names.
            keyed = not own and not modelled
            what = "this" if deploy else f"`{member.name}`"
            yield _not_compared(
                case,
                what,
                near,
                "several robots are called so"
                if by_number
                else "it has no list of joint names"
                if keyed
                else "no name shows that it is the same robot",
                # Others of one file may be compared.
                Span(member.path) if deploy else member.config.span,
                f"add {names_wanted(member.config.motors)}"
                if by_number
                else f"add joint_names: [...] with its {len(member.config.groups)} joints"
                if keyed
                else f"write the robot's name into {'the file' if deploy else 'this configuration'}'s name",
            )
        elif member.config is not None and not case.is_met(its):
            yield from _in_other_letters(case, member, models)


def _trained_with(case: Case, robot: Robot, its: int) -> list[str]:
    """Of a deploy file that somebody named and that is with no other file, the named configurations of its joints."""
    config = case.artifacts[its].config
    if (
        config is None
        or case.is_met(its)
        or not all(case.artifacts[i].kind is FileKind.DEPLOY for i in robot.artifacts)
    ):
        return []
    keys = frozenset(key for one in config.groups for key in one.joints or () if key != ".*")
    found = []
    for index, other in enumerate(case.artifacts):
        if other.config is None or other.kind is FileKind.DEPLOY or case.is_met(index):
            continue
        known = frozenset(joint_names(other) or ())
        if has_joints(other, keys) or (keys and len(keys & known) >= SHARE * len(keys)):
            found.append(other.path)
    return list(dict.fromkeys(found))


def _in_other_letters(
    case: Case, member: Artifact, models: Mapping[int, frozenset[str]]
) -> Iterator[Diagnostic]:
    """A configuration or deploy file that somebody named, whose names are a model's but for capital letters."""
    config = member.config
    assert config is not None
    written = joint_names(member) or [pattern for group in config.groups for pattern in group.joints or ()]
    for index, joints in models.items():
        names = sorted(joints)
        same = any(matching(config.framework, name, names) for name in written)
        right = {} if same else {name: recased(name, names) for name in written}
        known = {name: other for name, other in right.items() if other is not None}
        if known and len(known) >= SHARE * len(right):
            yield _not_compared(
                case,
                "this" if member.kind is FileKind.DEPLOY else f"`{member.name}`",
                [case.artifacts[index].path],
                "its names have other capital letters",
                Span(member.path) if member.kind is FileKind.DEPLOY else config.span,
                f"if it is the same robot, write {listed([f'{name!r}' for name in known.values()], 4)}",
            )


_ALIKE = "if it is the same robot, call its joints alike in both"


def _lower(names: Iterable[str]) -> frozenset[str]:
    return frozenset(name.lower() for name in names)


def _are_recased(one: frozenset[str], other: frozenset[str]) -> bool:
    """Whether models have the same joints where capital letters are small ones, most of the smaller one's."""
    least = SHARE * min(len(one), len(other))
    return len(one & other) < least <= len(_lower(one) & _lower(other))


def _of_letters(theirs: frozenset[str], own: frozenset[str]) -> str:
    """In which letters names differ, with the first joint that is spelt otherwise; patterns have no names of joints."""
    mine = {name.lower(): name for name in own}
    first = min((name for name in theirs if mine.get(name.lower(), name) != name), default=None)
    example = f" (`{mine[first.lower()]}` here, `{first}` there)" if first is not None else ""
    return f"names differ in capital letters{example}, which MuJoCo, Isaac Lab and mjlab tell apart"


def _beside_a_model(case: Case, mine: int, others: Sequence[int]) -> Iterator[Diagnostic]:
    """A model that somebody named, and others with its joints, where names or bodies allow that they are one robot."""
    artifact = case.artifacts[mine]
    figures = figures_of(artifact.robot) if others else {}
    near = [
        case.artifacts[other].path
        for other in others
        if telling(artifact.name) & telling(case.artifacts[other].name)
        or share_a_body(figures, figures_of(case.artifacts[other].robot), names=True)
    ]
    if near:
        yield _not_compared(
            case,
            "this",
            near,
            "names, ranges and masses do not show that it is the same robot",
            Span(artifact.path),
            "if it is, write one name in both (`<mujoco model>`, `<robot name>`); "
            f"`actspec diff {near[0]} {artifact.path}` compares them as they are",
        )


def _of_other_joints(case: Case, mine: int, others: Sequence[int]) -> Iterator[Diagnostic]:
    """A model that somebody named, and others of one name inside whose joints turn as far and are called otherwise."""

    def ranges(artifact: Artifact) -> list[tuple[float, ...]]:
        """However the joints are called; of the order of a tree no two writers have the same idea."""
        found = figures_of(artifact.robot).get("range", {}).values()
        return sorted(tuple(round(end, 2) for end in each) for each in found)

    artifact = case.artifacts[mine]
    name = telling(artifact.name)
    joints = {index: frozenset(joint_names(case.artifacts[index]) or ()) for index in (mine, *others)}
    spelt = [
        index
        for index in others
        if name
        and name == telling(case.artifacts[index].name)
        and _are_recased(joints[mine], joints[index])
        and share_a_body(
            *(_in_small_letters(case.artifacts[each].robot) for each in (mine, index)), names=True
        )
    ]
    if spelt:
        why = _of_letters(joints[spelt[0]], joints[mine])
        paths = [case.artifacts[index].path for index in spelt]
        # Somebody named both, and what is wrong in one of them stays untold.
        yield replace(
            _not_compared(case, "this", paths, why, Span(artifact.path), _ALIKE), severity=Severity.WARNING
        )
    alike = [
        other
        for other in others
        if name and name == telling(case.artifacts[other].name) and other not in spelt
    ]
    own = ranges(artifact) if alike else []
    near = [other for other in alike if own and ranges(case.artifacts[other]) == own]
    if near:
        lost = sorted(joints[near[0]] - joints[mine])
        which = listed(lost, 3) if len(lost) < len(joints[near[0]]) else "them"
        paths = [case.artifacts[other].path for other in near]
        yield _not_compared(case, "this", paths, f"it calls {which} otherwise", Span(artifact.path), _ALIKE)


def _in_small_letters(robot: RobotView | None) -> Figures:
    return {
        kind: {joint.lower(): values for joint, values in joints.items()}
        for kind, joints in figures_of(robot).items()
    }


def _not_compared(case: Case, what: str, near: Sequence[str], why: str, place: Span, help: str) -> Diagnostic:
    files = Counter(basename(file.path) for file in case.files)
    names = [path if files[basename(path)] > 1 else basename(path) for path in near]
    with_it = "it" if len(near) == 1 else "them"
    message = f"{what} has the joints of {listed(names, 2)}, and is not compared with {with_it}: {why}"
    return Diagnostic("AUD015", Severity.INFO, message, "", place, help)
