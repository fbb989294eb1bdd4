"""Figures of one joint that two files of a robot state and that differ, and what the SRC rules have in common."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding
from actspec.audit.known import KnownRobot, likenesses, same
from actspec.audit.rule import RuleInParts
from actspec.audit.rules.joints import is_called_undriven, is_exporters
from actspec.diagnostics import Severity, Span
from actspec.fields import FIELDS, LIMITS, is_placeholder
from actspec.joints import JointKind
from actspec.readings.artifact import FileKind, Framework, Robot
from actspec.readings.compare import Figure, angle_slip, times
from actspec.readings.dynamics import figure
from actspec.readings.joint import read_joint
from actspec.readings.ledger import LedgerRow
from actspec.readings.pair import agreement, are_one_body, distinctive, joint_names, last_numbers, series
from actspec.units import format_quantity

TIMES = 3.0
"""From here a ratio is given as a factor. Chosen: 200 % more is read as a factor of 2 as often as of 3."""

SMALL = 0.07
"""Up to here a limit that differs is a note. Chosen: published limits of one motor are so far apart (23.5 and 23.7 N*m,
200.43 and 200), and of a B2's calf (300 and 320), where two readers would not have acted."""

GRAVE = 2.0
"""From here a limit that differs is an error. Chosen: revisions and safety margins of one motor stay below."""

_SAME = 0.01
"""Chosen: figures of two motors that agree so far are one, as `tolerance` of the rules."""

_REVISION = re.compile(
    r"(?:(?<![A-Za-z])(?i:v|rev|version|mode|mark|mk)|(?<=[a-z])V)[_-]?\d+(?:[._]\d+)*|(?i:limit|stronger|weaker)"
)
"""A hardware's version in a name, as of `atlas_v4`, `naoV33`, `mini_mark2` and `g1_29dof_mode_13`, or limits that are
others on purpose, as of `t1_softlimit` and `robot_stronger_ankle`."""

_PUBLISHED = {"effort_limit": "effort", "velocity_limit": "velocity"}
"""Figures that makers publish of their robots, and what they are in the table of known ones."""

_FOLDERS = 4
"""Last parts of a path that may tell which revision a file is of. Chosen: of the robot, of the kind of file."""

_REFERENCES: dict[FileKind, tuple[tuple[FileKind, ...], ...]] = {
    FileKind.DEPLOY: ((FileKind.CFG,), (FileKind.URDF, FileKind.MJCF)),
    FileKind.CFG: ((FileKind.URDF, FileKind.MJCF),),
    FileKind.MJCF: ((FileKind.URDF,),),
    FileKind.URDF: (),
}
"""What a kind of file is held to, the first that states the figure; then earlier files of its own kind."""


@dataclass(frozen=True, slots=True)
class Disagreement:
    """One figure of one joint in two files.

    Attributes:
        rows: The joint's rows in the file that departs.
        others: In the file that it is held to.
        field: Name of the figure in `rows`.
        mine: The figure that departs.
        theirs: The other.
        variant: Whether the files describe variants: of the same kind, or with other joints.
        one_machine: Whether links and ranges speak of one machine, or do not speak.
        published: The known robot whose figure the other file has; "" where no such robot tells who is right.
        backed: Whether files of more kinds that are run have the other figure than this one.
        both_published: Whether the robot's maker publishes both figures.
    """

    rows: Sequence[LedgerRow]
    others: Sequence[LedgerRow]
    field: str
    mine: Figure
    theirs: Figure
    variant: bool
    one_machine: bool
    published: str = ""
    backed: bool = False
    both_published: bool = False

    @property
    def ratio(self) -> float | None:
        """How many times the other figure; None beside 0."""
        if not self.mine.value or not self.theirs.value:
            return None
        return self.mine.value / self.theirs.value

    @property
    def times(self) -> str:
        """The ratio for a message: ` (x0.517)`, or nothing."""
        return times(self.mine.value, self.theirs.value)

    @property
    def turned(self) -> Disagreement:
        """The same, with the other file as the one that departs."""
        return replace(self, rows=self.others, others=self.rows, mine=self.theirs, theirs=self.mine)


def disagreements(
    case: Case, fields: Sequence[str], tolerance: float, absolute: float = 0.0
) -> Iterator[Disagreement]:
    """Where files of one robot state different figures.

    A file is held to the URDF and MJCF of its robot, a deploy file to the training configuration. One that agrees
    with any of them is right; else the nearest is named: with the same joints, by the same name, the first. Of a known
    robot the file with the published figure is right. A figure that a file does not state is not compared.

    Args:
        case: The case.
        fields: Fields of a row; of several, the first that a file states is its figure.
        tolerance: Largest relative difference of equal figures.
        absolute: Largest absolute difference of equal figures.

    Yields: One a joint and departing file.
    """
    blamed = set()
    for robot in case.robots:
        every = tuple(_of_robot(case, robot, fields, tolerance, absolute)) if len(robot.artifacts) > 1 else ()
        stated = _stated_by_kinds(case, robot, fields) if every else {}
        for found in every:
            wrong = _by_what_is_published(case, found)
            if not wrong.published:
                wrong = _by_kinds(wrong, stated)
            # Several files may be right beside one that is not.
            at = (wrong.rows[0].artifact, wrong.rows[0].joint)
            if wrong is found or at not in blamed:
                yield wrong
            blamed.add(at)


def _by_what_is_published(case: Case, found: Disagreement) -> Disagreement:
    """Turned where the departing file has the figure that the robot's maker publishes, and the other one has not."""
    if found.field not in _PUBLISHED or found.field not in found.others[0].stated:
        return found
    mine = found.rows[0]
    joints = {
        (known.robot.name, *_published(known.robot, name, found.field))
        for known in case.once(likenesses)
        for row, names in known.joints
        # A task's configuration has the name of its task, and its robot's figures where the robot has them.
        if row.joint == mine.joint
        and (known.index == mine.artifact or row.place(found.field) == mine.place(found.field))
        for name in names
    }
    # The same for all joints that the row may be: else nobody is right or wrong by it.
    if len(joints) != 1:
        return found
    ((name, figures, one_figure),) = joints
    here, there = (any(same(each.value, figure) for figure in figures) for each in (found.mine, found.theirs))
    if here and there:
        return replace(found, both_published=True)
    if here is there or not one_figure:
        return found
    return replace(found.turned if here else found, published=name)


def _by_kinds(found: Disagreement, stated: Mapping[str, Mapping[FileKind, set[float]]]) -> Disagreement:
    """Turned where files of more kinds have the figure of the departing one than the other's.

    Files of one kind are not counted: copies of a URDF are as old as the first.
    """
    kinds = stated.get(found.rows[0].joint, {}).values()
    mine, theirs = (
        sum(any(math.isclose(each, side.value or 0.0, rel_tol=_SAME) for each in values) for values in kinds)
        for side in (found.mine, found.theirs)
    )
    if mine == theirs:
        return found
    return replace(found.turned if mine > theirs else found, backed=True)


def _stated_by_kinds(
    case: Case, robot: Robot, fields: Sequence[str]
) -> dict[str, dict[FileKind, set[float]]]:
    """What the files that are run state, by joint and kind of file."""
    found: dict[str, dict[FileKind, set[float]]] = {}
    for index in robot.artifacts:
        for joint, (name, value) in _stated_joints(case, index, fields).items():
            if not case.is_idle(_place(case.joints[index, joint], name)):
                found.setdefault(joint, {}).setdefault(case.artifacts[index].kind, set()).add(value)
    return found


def _published(robot: KnownRobot, name: str, field: str) -> tuple[frozenset[float], bool]:
    """What the maker publishes of a joint, of all variants: the figure may be all that tells them apart.

    And whether all variants have one motor there: else another figure may be of a variant that is not known.
    """
    joints = [variant[name] for variant in robot.variants.values()]
    figures = {getattr(joint, _PUBLISHED[field]) for joint in joints if joint.maker} - {None}
    also = {figure for joint in joints for figure in joint.also if field == "effort_limit"}
    return frozenset(figures | also), len(figures) == 1


def compared(case: Case, fields: Sequence[str], kind: FileKind | None = None) -> bool:
    """Whether two files of one robot state such a figure of one joint.

    Args:
        case: The case.
        fields: Fields of a row.
        kind: What the later of the two is; None: anything but a spec.
    """
    for robot in case.robots:
        seen: dict[str, set[FileKind]] = {}
        for index in robot.artifacts if len(robot.artifacts) > 1 else ():
            own = case.artifacts[index].kind
            for joint in _stated_joints(case, index, fields):
                kinds = seen.setdefault(joint, set())
                if kinds and (kind is None or (own is kind) != (kind in kinds)):
                    return True
                kinds.add(own)
    return False


_Stated = tuple[str, float]
"""Name of the field that a file states, and its value."""


@dataclass(frozen=True, slots=True)
class _Held:
    """What files of a robot state of one joint.

    Attributes:
        members: Artifact and what it states, in the files' order.
        paths: Value to the files that have it: most files agree, and are not looked at one by one.
    """

    members: list[tuple[int, _Stated]] = field(default_factory=list)
    paths: dict[float, set[str]] = field(default_factory=dict)

    def add(self, case: Case, artifact: int, found: _Stated) -> None:
        """One more."""
        self.members.append((artifact, found))
        self.paths.setdefault(found[1], set()).add(case.artifacts[artifact].path)


def _of_robot(
    case: Case,
    robot: Robot,
    fields: Sequence[str],
    tolerance: float,
    absolute: float,
) -> Iterator[Disagreement]:
    stated = _departing(case, robot, fields)
    # Most robots have files of one kind, which are only held to each other.
    kinds_here = {case.artifacts[index].kind for index in robot.artifacts}
    referred = {each for kind in kinds_here for kinds in _REFERENCES.get(kind, ()) for each in kinds}
    everything: dict[tuple[FileKind, str], _Held] = {}
    for index in robot.artifacts:
        kind = case.artifacts[index].kind
        for joint, found in stated[index].items() if kind in referred else ():
            everything.setdefault((kind, joint), _Held()).add(case, index, found)
    earlier: dict[tuple[FileKind, str], _Held] = {}
    real_path = cache(os.path.realpath)
    # Asked for every joint that departs.
    distance = cache(lambda one, other: _distance(case, one, other))
    one_machine = cache(lambda one, other: _is_one_machine(case, one, other))

    def agree(mine: tuple[int, _Stated], theirs: tuple[int, _Stated], joint: str) -> bool:
        (name, value), (other, its) = mine[1], theirs[1]
        if math.isclose(value, its, rel_tol=tolerance, abs_tol=absolute):
            return True
        places = (_place(case.joints[mine[0], joint], name), _place(case.joints[theirs[0], joint], other))
        return _is_one_place(*places, real_path)

    for index in robot.artifacts:
        kind, path = case.artifacts[index].kind, case.artifacts[index].path
        for joint, mine in stated[index].items():
            own = earlier.get((kind, joint))
            if own is None:
                own = earlier[kind, joint] = _Held()
            for kinds in (*_REFERENCES[kind], None):
                if kinds is None:
                    # Whoever wrote two artifacts in one file knows of both.
                    if own.paths.get(mine[1], set()) - {path}:
                        break
                    held = [each for each in own.members if case.artifacts[each[0]].path != path]
                else:
                    known = [everything[k, joint] for k in kinds if (k, joint) in everything]
                    if any(mine[1] in each.paths for each in known):
                        break
                    held = [member for each in known for member in each.members]
                if not held:
                    continue
                kind_here = case.joints[index, joint][0].kind
                held = [
                    each
                    for each in held
                    if _is_one_kind(kind_here, case.joints[each[0], joint][0].kind)
                    and _counts_alike(case, index, each[0], joint)
                ]
                if held and not any(agree((index, mine), theirs, joint) for theirs in held):
                    other, theirs = min(held, key=lambda each: distance(index, each[0]))
                    variant = kinds is None or distance(index, other)[1]
                    rows, others = case.joints[index, joint], case.joints[other, joint]
                    figures = figure(rows, mine[0]), figure(others, theirs[0])
                    yield Disagreement(rows, others, mine[0], *figures, variant, one_machine(index, other))
                break
            own.add(case, index, mine)


def _is_one_kind(one: JointKind | None, other: JointKind | None) -> bool:
    """Whether two joints of one name may be the same: a hinge is no slide."""
    return one is other or one is None or other is None


def _counts_alike(case: Case, one: int, other: int, joint: str) -> bool:
    """Whether the series of a numbered joint goes as far in both files: the 4th of 6 is not the 4th of 7."""
    key = series(joint)
    last = case.once(_last_numbers)
    ends = {last[index].get(key) for index in (one, other)} if key is not None else {None}
    return len(ends - {None}) < 2


def _last_numbers(case: Case) -> list[dict[tuple[str, str], int]]:
    """How far the numbered joints of each artifact go."""
    return [
        last_numbers(joint for joint in case.joints_by_artifact.get(index, {}) if artifact.robot is not None)
        for index, artifact in enumerate(case.artifacts)
    ]


def _departing(case: Case, robot: Robot, fields: Sequence[str]) -> dict[int, dict[str, _Stated]]:
    """What each artifact of a robot states, by joint, of the joints on which not all agree to the last digit."""
    stated = {index: _stated_joints(case, index, fields) for index in robot.artifacts}
    values: dict[str, set[float]] = {}
    for joints in stated.values():
        for joint, (_, value) in joints.items():
            values.setdefault(joint, set()).add(value)
    return {
        index: {joint: found for joint, found in joints.items() if len(values[joint]) > 1}
        for index, joints in stated.items()
    }


def _stated_joints(case: Case, index: int, fields: Sequence[str]) -> dict[str, _Stated]:
    """What an artifact states, by joint: field and value.

    Nothing for a spec, or of a joint that two groups of a configuration have.
    """
    kind = case.artifacts[index].kind
    if kind is FileKind.SPEC or case.once(_stated_fields)[index].isdisjoint(fields):
        return {}
    found = {}
    for joint, rows in case.joints_by_artifact.get(index, {}).items():
        if len(rows) > 1 and kind is FileKind.CFG:
            # Actuators of one joint add up in an MJCF; of a configuration's groups one wins, or none (ORD103).
            continue
        stated = _stated(rows, fields)
        if stated is not None:
            found[joint] = stated
    return found


def _stated_fields(case: Case) -> dict[int, frozenset[str]]:
    """The fields that each artifact states of any joint."""
    return {
        index: frozenset().union(*(row.stated for row in case.rows_of(index)))
        for index in range(len(case.artifacts))
    }


def _stated(rows: Sequence[LedgerRow], fields: Sequence[str]) -> _Stated | None:
    """The first of the fields that a joint's file states, and its finite value."""
    for name in fields:
        for row in rows:
            if name in row.stated:
                value = getattr(row, name) if len(rows) == 1 else figure(rows, name).value
                if value is not None and math.isfinite(value):
                    return name, value
                break
    return None


def _place(rows: Sequence[LedgerRow], name: str) -> Span:
    """Where a figure is written, as in `figure`."""
    return rows[0].place(name) if len(rows) == 1 else figure(rows, name).place


def _is_one_place(one: Span, other: Span, real_path: Callable[[str], str]) -> bool:
    """Whether a scene and the model that it includes were both named."""
    return one.line == other.line and real_path(one.path) == real_path(other.path)


def _distance(case: Case, one: int, other: int) -> tuple[bool, bool, int, bool]:
    """Sorting key of the files that another may be held to.

    What is run, of the same variant, what a configuration names, of the same name.
    """
    artifact, config = case.artifacts[other], case.artifacts[one].config
    named = 0 if config is None else agreement(config.model or "", artifact.path)
    idle = case.is_idle(Span(artifact.path) if artifact.config is None else artifact.config.span)
    stems = {os.path.splitext(os.path.basename(case.artifacts[index].path))[0] for index in (one, other)}
    return idle, _are_variants(case, one, other), -named, len(stems) > 1


def _are_variants(case: Case, one: int, other: int) -> bool:
    """Whether two models have different joints."""
    names = case.once(_joint_sets)
    if case.artifacts[one].robot is None or names[one] is None or names[other] is None:
        return False
    return names[one] != names[other]


def _joint_sets(case: Case) -> list[frozenset[str] | None]:
    """The joints that each artifact names."""
    found = [joint_names(artifact) for artifact in case.artifacts]
    return [None if names is None else frozenset(names) for names in found]


def is_no_limit(found: Disagreement) -> bool:
    """Whether one of two limits is a placeholder, an exporter's or 0, which the LIM rules report."""
    # Where both files have the effort, somebody stated it.
    efforts = {rows[0].effort_limit for rows in (found.rows, found.others)}
    if len(efforts) > 1 and any(is_exporters(rows[0]) for rows in (found.rows, found.others)):
        return True
    values = [found.mine.value or 0.0, found.theirs.value or 0.0]
    return min(values) <= 0.0 or is_placeholder(max(values))


def is_of_one_training(case: Case, found: Disagreement) -> bool:
    """Whether a deploy file runs what a configuration trains.

    Policies of a robot with several sets of gains have a training each, and which of them belongs to the configuration
    at hand, no file tells. Nor is it the file's own where no gain of any joint agrees: a project beside another one.
    """
    one, other = (case.joints_by_artifact.get(rows[0].artifact, {}) for rows in (found.rows, found.others))
    pairs = [_both(one, other, name) for name in ("kp", "kd")]
    if all(pairs) and not any(math.isclose(*pair, rel_tol=_SAME) for gains in pairs for pair in gains):
        return False
    members = case.robot_of(found.rows[0].artifact).artifacts
    gains = set()
    for index in members:
        if case.artifacts[index].kind is FileKind.DEPLOY:
            joints = case.joints_by_artifact.get(index, {})
            own = frozenset((joint, rows[0].kp, rows[0].kd) for joint, rows in joints.items() if rows[0].kp)
            gains |= {own} if own else set()
    return len(gains) < 2


def is_small(found: Disagreement) -> bool:
    """Whether two figures are so near that both are one motor's."""
    return found.ratio is not None and abs(found.ratio - 1.0) <= SMALL


def _both(
    one: Mapping[str, Sequence[LedgerRow]], other: Mapping[str, Sequence[LedgerRow]], name: str
) -> list[tuple[float, float]]:
    """What two files state of one figure, at each joint of which both do."""
    pairs = ((rows[0], other[joint][0]) for joint, rows in one.items() if joint in other)
    stated = (
        (getattr(mine, name), getattr(its, name)) for mine, its in pairs if name in mine.stated & its.stated
    )
    return [(mine, its) for mine, its in stated if mine is not None and its is not None]


def is_times_off(case: Case, found: Disagreement) -> bool:
    """Whether a limit of the hardware is `GRAVE` times the other: not one that only the range of a control makes.

    Variants that are called otherwise are held to each other where most of their joints agree: where most do not,
    they have other motors.
    """
    if not is_times(found.ratio) or any(is_of_control(case, rows) for rows in (found.rows, found.others)):
        return False
    one, other = found.rows[0].artifact, found.others[0].artifact
    if found.variant and _revision(case, one) != _revision(case, other):
        return False
    if case.is_met(one) and not (found.published or found.backed) and _are_variants(case, one, other):
        # Of files in a folder with unlike joints nobody said that they are of one robot.
        return False
    if not found.variant or distinctive(case.artifacts[one]) == distinctive(case.artifacts[other]):
        return True
    differ = []
    theirs = case.joints_by_artifact.get(other, {})
    for joint, rows in case.joints_by_artifact.get(one, {}).items():
        a, b = (figure(each, found.field).value if each else None for each in (rows, theirs.get(joint)))
        if a and b:
            differ.append(not math.isclose(a, b, rel_tol=_SAME))
    return 2 * sum(differ) < len(differ)


def _revision(case: Case, artifact: int) -> frozenset[str]:
    """The versions in the names of a file and its folders: `atlas_v3/model.urdf` and `atlas_v4/model.urdf` differ."""
    parts = os.path.abspath(case.artifacts[artifact].path).split(os.sep)
    return frozenset(found.lower() for found in _REVISION.findall("/".join(parts[-_FOLDERS:])))


def _is_one_machine(case: Case, one: int, other: int) -> bool:
    """Whether nothing speaks against one machine: models tell by what their links weigh and how far joints turn."""
    here, there = case.artifacts[one].robot, case.artifacts[other].robot
    return here is None or there is None or are_one_body(here, there)


def is_overridden(case: Case, found: Disagreement) -> bool:
    """Whether a configuration met in a folder has a figure of its own that nothing but the URDF speaks against.

    Its figure is the one that trains and was written later; the URDF has the links.
    """
    here, there = (case.artifacts[rows[0].artifact] for rows in (found.rows, found.others))
    return (
        case.is_met(found.rows[0].artifact)
        and not (found.published or found.backed)
        and (here.kind, there.kind) == (FileKind.CFG, FileKind.URDF)
    )


def are_alternatives(case: Case, found: Disagreement) -> bool:
    """Whether both files are URDFs, or both MJCF, and no maker's figure tells who is right: one of them is used."""
    one, other = (case.artifacts[rows[0].artifact].kind for rows in (found.rows, found.others))
    return one is other and one in (FileKind.URDF, FileKind.MJCF) and not found.published


def is_times(ratio: float | None) -> bool:
    """Whether one figure is `GRAVE` times the other or more."""
    return ratio is not None and ratio > 0.0 and max(ratio, 1.0 / ratio) >= GRAVE - 1e-9


def is_beyond_the_joint(case: Case, found: Disagreement) -> bool:
    """Whether an mjlab configuration states more than its MJCF gives the joint, which goes on to clamp what it gives.

    Source: mjlab 1.6.0, BuiltinPositionActuatorCfg sets forcerange and leaves actuatorfrcrange.
    """
    config = case.artifacts[found.rows[0].artifact].config
    other = case.artifacts[found.others[0].artifact]
    if config is None or config.framework is not Framework.MJLAB or other.kind is not FileKind.MJCF:
        return False
    joint = None if other.robot is None else other.robot.joint(found.rows[0].joint)
    return joint is not None and joint.effort_range is not None and (found.ratio or 0.0) > 1.0


def is_of_control(case: Case, rows: Sequence[LedgerRow]) -> bool:
    """Whether the control range of an MJCF's motors limits a joint, which is a matter of its task."""
    robot, limit = case.artifacts[rows[0].artifact].robot, rows[0].effort_limit
    if robot is None or limit is None:
        return False
    bound = read_joint(robot, rows[0].joint).force_bound.value
    return bound is not None and bound > limit * (1.0 + 1e-9)


def shown(value: float | None, unit: str) -> str:
    """A figure for a message, three digits."""
    return format_quantity(value, unit, 3)


class SourceRule(RuleInParts):
    """What the rules of this family have in common."""

    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    options: ClassVar[dict[str, float]] = {"tolerance": 0.01}
    groups: ClassVar[tuple[tuple[str, ...], ...]]
    """Fields that are compared; of those in one tuple the first that a file states."""

    def lacks(self, case: Case) -> str:
        """What no two files state."""
        return f"no two files of one robot state {self.needs}"

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        """Compare the files of each robot."""
        tolerance = self.option(case, "tolerance")
        findings = self.findings(
            case,
            [
                found
                for fields in self.groups
                for found in disagreements(case, fields, tolerance)
                if not self.is_none(case, found, tolerance)
            ],
        )
        if findings or any(compared(case, fields) for fields in self.groups):
            yield findings

    def findings(self, case: Case, disagreements: Sequence[Disagreement]) -> list[Finding]:
        """What is said of them: one each."""
        return [self.finding(case, found) for found in disagreements]

    def is_none(self, case: Case, found: Disagreement, tolerance: float) -> bool:
        """Whether one of the figures is none that anybody stated, or both are one in two units."""
        return angle_slip(found.ratio, tolerance)

    def consequence(self, case: Case, found: Disagreement) -> str:
        """What it does to the robot, with a number."""
        raise NotImplementedError

    def is_grave(self, case: Case, found: Disagreement) -> bool:
        """Whether no variant explains it: two files of one robot cannot both be right."""
        return False

    def severity_of(self, case: Case, found: Disagreement) -> tuple[Severity, Confidence]:
        """By what the files are."""
        return self.severity, self.confidence

    def finding(self, case: Case, found: Disagreement) -> Finding:
        """The finding of one joint, at the file that departs."""
        mine, theirs = found.mine, found.theirs
        severity, confidence = self.severity_of(case, found)
        idle = found.field in LIMITS and is_called_undriven(found.rows[0])
        if found.variant or not found.one_machine or idle or (found.field in LIMITS and is_small(found)):
            severity, confidence = Severity.INFO, Confidence.LOW
        # Beside a spec, which tells who is wrong, SPC101 has the error.
        beside = case.kinds_by_artifact[found.rows[0].artifact]
        if is_overridden(case, found) or found.both_published:
            severity, confidence = Severity.INFO, Confidence.LOW
        elif not idle and found.one_machine and FileKind.SPEC not in beside and self.is_grave(case, found):
            severity, confidence = Severity.ERROR, Confidence.MEDIUM
        file = found.others[0].file
        if found.published:
            advice = f"{shown(theirs.value, theirs.unit)} is published for {found.published}: write it here, or set "
            advice += "this aside with the reason"
        else:
            advice = "find out which is right, and write it in both, or set this aside with the reason: "
            advice += f"{file} may be of another variant"
        return Finding(
            self.code,
            f"the {FIELDS[found.field].noun} is {shown(mine.value, mine.unit)} here and "
            f"{shown(theirs.value, theirs.unit)} in {file}{found.times}: {self.consequence(case, found)}",
            mine.place,
            found.rows[0].joint,
            mine.value,
            mine.unit or None,
            expected=theirs.value,
            help=advice,
            related=(theirs.place,),
            severity=severity,
            confidence=confidence,
            fields=(found.field,),
        )
