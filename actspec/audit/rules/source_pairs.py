"""Figures of one joint that two files of a robot state and that differ, and which of the files is held to the other."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache

from actspec.audit.case import Case
from actspec.audit.known import KnownRobot, likenesses, same
from actspec.diagnostics import Span
from actspec.joints import JointKind
from actspec.readings.artifact import FileKind, Robot
from actspec.readings.compare import Figure, times
from actspec.readings.dynamics import figure
from actspec.readings.ledger import LedgerRow
from actspec.readings.pair import LIKENESS, SHARE, agreement, are_one_body, joint_names, last_numbers, series

_Stated = tuple[str, float]
"""Name of the field that a file states, and its value."""

_StatedBy = Mapping[int, Mapping[str, _Stated]]
"""What the artifacts of a robot state, by joint."""

SAME = 0.01
"""Chosen: figures of two motors that agree so far are one, as `tolerance` of the rules."""

GRAVE = 2.0
"""From here a limit that differs is an error. Chosen: revisions and safety margins of one motor stay below."""

POSE = 0.01
"""Chosen: rad or m up to which two default positions are one, half a degree."""

_PUBLISHED = {"effort_limit": "effort", "velocity_limit": "velocity"}
"""Figures that makers publish of their robots, and what they are in the table of known ones."""

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
        both_published: Whether the robot's maker publishes both figures.
        copy: Whether an earlier file departs in the same way.
    """

    rows: Sequence[LedgerRow]
    others: Sequence[LedgerRow]
    field: str
    mine: Figure
    theirs: Figure
    variant: bool
    one_machine: bool
    published: str = ""
    both_published: bool = False
    copy: bool = False

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
    with any of them is right; else the nearest is named: with the same joints, by the same name, the first. Of files
    that somebody named a deploy file is held to each configuration: one of another file that agrees, which may be the
    last that was not changed, does not speak for the others. Of a known
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
        if len(robot.artifacts) < 2:
            continue
        stated = {index: _stated_joints(case, index, fields) for index in robot.artifacts}
        every = tuple(_of_robot(case, robot, stated, tolerance, absolute))
        # What runs a policy against what trained it first: a third file must not take the place of that.
        every = tuple(sorted(every, key=lambda found: not _is_training(case, found)))
        by_kinds = _stated_by_kinds(case, stated) if every else {}
        holders = _holders(case, stated) if every else {}
        for found in every:
            wrong = _by_what_is_published(case, found)
            if not wrong.published:
                wrong = _by_range(case, wrong) or _by_kinds(case, wrong, by_kinds)
            # Several files may be right beside one that is not.
            at = (wrong.rows[0].artifact, wrong.rows[0].joint)
            if wrong is found or at not in blamed:
                yield wrong
            blamed.add(at)
            for copy in _copies(case, wrong, holders):
                at = (copy.rows[0].artifact, copy.rows[0].joint)
                if at not in blamed:
                    yield copy
                blamed.add(at)


def _holders(case: Case, stated: _StatedBy) -> dict[tuple[FileKind, str, _Stated], list[int]]:
    """The artifacts that state a figure, by kind of file, joint and figure."""
    found: dict[tuple[FileKind, str, _Stated], list[int]] = {}
    for index, joints in stated.items():
        for joint, figure_of in joints.items():
            found.setdefault((case.artifacts[index].kind, joint, figure_of), []).append(index)
    return found


def _copies(
    case: Case, wrong: Disagreement, holders: Mapping[tuple[FileKind, str, _Stated], Sequence[int]]
) -> Iterator[Disagreement]:
    """The same of other files of the kind that have the figure of the one that departs."""
    mine = wrong.rows[0]
    if wrong.mine.value is None:
        return
    key = case.artifacts[mine.artifact].kind, mine.joint, (wrong.field, wrong.mine.value)
    for index in holders.get(key, ()):
        if case.artifacts[index].path != mine.file:
            rows = case.joints[index, mine.joint]
            yield replace(wrong, rows=rows, mine=figure(rows, wrong.field), copy=True)


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


def _by_range(case: Case, found: Disagreement) -> Disagreement | None:
    """Turned where only the other file's default position is one that the joint cannot take; None: that tells nobody.

    Only in files that are named: what is found in folders is as it was judged (docs/survey.md).
    """
    if found.field != "default_position" or _is_met(case, found):
        return None
    joint = found.rows[0].joint
    ranges = {
        row.position_range
        for index in case.robot_of(found.rows[0].artifact).artifacts
        for row in case.joints.get((index, joint), ())
        if row.position_range is not None
    }
    mine, theirs = (
        bool(ranges) and all(not low - POSE <= (side.value or 0.0) <= high + POSE for low, high in ranges)
        for side in (found.mine, found.theirs)
    )
    if mine == theirs:
        return None
    return found if mine else found.turned


def _is_met(case: Case, found: Disagreement) -> bool:
    """Whether one of the two files was met in a folder."""
    return any(case.is_met(rows[0].artifact) for rows in (found.rows, found.others))


def _is_training(case: Case, found: Disagreement) -> bool:
    """Whether the files are a deploy file and a training configuration, and somebody named both."""
    kinds = {case.artifacts[rows[0].artifact].kind for rows in (found.rows, found.others)}
    return kinds == {FileKind.CFG, FileKind.DEPLOY} and not _is_met(case, found)


def _by_kinds(
    case: Case, found: Disagreement, stated: Mapping[str, Mapping[FileKind, set[float]]]
) -> Disagreement:
    """Turned where files of more kinds have the figure of the departing one than the other's; or where no
    kind has either, but more are near it: of 52, 60 and 520 the last is the odd one.

    Files of one kind are not counted: copies of a URDF are as old as the first.
    """
    kinds = stated.get(found.rows[0].joint, {}).values()

    def count(near: Callable[[float, float], bool]) -> tuple[int, int]:
        mine, theirs = (
            sum(any(near(each, side.value or 0.0) for each in values) for values in kinds)
            for side in (found.mine, found.theirs)
        )
        return mine, theirs

    mine, theirs = count(lambda one, other: math.isclose(one, other, rel_tol=SAME))
    if mine != theirs:
        return found.turned if mine > theirs else found
    if found.ratio is None:
        # Nothing is near 0.
        return found
    mine, theirs = count(
        lambda one, other: one * other > 0.0 and max(abs(one), abs(other)) < GRAVE * min(abs(one), abs(other))
    )
    return found.turned if mine > theirs else found


def _stated_by_kinds(case: Case, stated: _StatedBy) -> dict[str, dict[FileKind, set[float]]]:
    """What the files that are run state, by joint and kind of file."""
    found: dict[str, dict[FileKind, set[float]]] = {}
    for index, joints in stated.items():
        for joint, (name, value) in joints.items():
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
    said: _StatedBy,
    tolerance: float,
    absolute: float,
) -> Iterator[Disagreement]:
    stated = _departing(said)
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
    one_machine = cache(lambda one, other: is_one_machine(case, one, other))

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
                every = kinds == (FileKind.CFG,) and not case.is_met(index)
                if kinds is None:
                    # Whoever wrote two artifacts in one file knows of both.
                    if own.paths.get(mine[1], set()) - {path}:
                        break
                    held = [each for each in own.members if case.artifacts[each[0]].path != path]
                else:
                    known = [everything[k, joint] for k in kinds if (k, joint) in everything]
                    if not every and any(mine[1] in each.paths for each in known):
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
                alike = {
                    case.artifacts[theirs[0]].path for theirs in held if agree((index, mine), theirs, joint)
                }
                if not held or (alike and not every):
                    break
                nearest = min(held, key=lambda each: distance(index, each[0]))
                for other, theirs in _of_other_files(case, held, alike) if alike else [nearest]:
                    variant = kinds is None or distance(index, other)[1]
                    rows, others = case.joints[index, joint], case.joints[other, joint]
                    figures = figure(rows, mine[0]), figure(others, theirs[0])
                    yield Disagreement(rows, others, mine[0], *figures, variant, one_machine(index, other))
                break
            own.add(case, index, mine)


def _of_other_files(
    case: Case, held: Sequence[tuple[int, _Stated]], alike: Collection[str]
) -> list[tuple[int, _Stated]]:
    """Of each file that somebody named the first that states a figure, without the files in `alike`.

    Whoever wrote two configurations in one file knows of both.
    """
    found: dict[str, tuple[int, _Stated]] = {}
    for index, stated in held:
        path = case.artifacts[index].path
        if path not in alike and not case.is_met(index):
            found.setdefault(path, (index, stated))
    return list(found.values())


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


def _departing(stated: _StatedBy) -> _StatedBy:
    """What each artifact of a robot states, by joint, of the joints on which not all agree to the last digit."""
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

    Nothing for a spec, or of a joint of which two groups of a configuration make an error.
    """
    kind = case.artifacts[index].kind
    if kind is FileKind.SPEC or case.once(_stated_fields)[index].isdisjoint(fields):
        return {}
    found = {}
    for joint, rows in case.joints_by_artifact.get(index, {}).items():
        if len(rows) > 1 and kind is FileKind.CFG:
            # Actuators of one joint add up in an MJCF; of a configuration's groups none has it (ORD103).
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
    return idle, are_variants(case, one, other), -named, len(stems) > 1


def are_variants(case: Case, one: int, other: int) -> bool:
    """Whether two models have different joints."""
    names = case.once(_joint_sets)
    if case.artifacts[one].robot is None or names[one] is None or names[other] is None:
        return False
    return names[one] != names[other]


def _joint_sets(case: Case) -> list[frozenset[str] | None]:
    """The joints that each artifact names."""
    found = [joint_names(artifact) for artifact in case.artifacts]
    return [None if names is None else frozenset(names) for names in found]


def is_one_machine(case: Case, one: int, other: int) -> bool:
    """Whether nothing speaks against one machine: models tell by what their links weigh and how far joints turn.

    `g1.urdf` and `g1.xml` of one folder are two descriptions of one, where half of the figures agree.
    """
    here, there = case.artifacts[one].robot, case.artifacts[other].robot
    names = {os.path.splitext(case.artifacts[index].path)[0] for index in (one, other)}
    share = LIKENESS if len(names) == 1 else SHARE
    return here is None or there is None or are_one_body(here, there, share)
