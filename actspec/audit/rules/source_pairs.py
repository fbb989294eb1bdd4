"""Figures of one joint that two files of a robot state and that differ, and which of the files is held to the other."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache

from actspec.audit.case import Case
from actspec.audit.rules.joints import is_left_at_zero
from actspec.audit.rules.same_joint import is_one_joint
from actspec.audit.rules.sided import are_of_two_sides
from actspec.audit.rules.source_blame import (
    SAME,
    Disagreement,
    by_kinds,
    by_sense,
    by_what_is_published,
    is_met,
    is_of_spec,
)
from actspec.diagnostics import Span
from actspec.joints import JointKind
from actspec.readings.artifact import FileKind, Robot
from actspec.readings.body import LIKENESS, SHARE, are_one_body
from actspec.readings.called import agreement
from actspec.readings.compare import Figure
from actspec.readings.dynamics import figure
from actspec.readings.joint_names import joint_names
from actspec.readings.ledger import LedgerRow

_Stated = tuple[str, float]
"""Name of the field that a file states, and its value."""

_StatedBy = Mapping[int, Mapping[str, _Stated]]
"""What the artifacts of a robot state, by joint."""

_REFERENCES: dict[FileKind, tuple[tuple[FileKind, ...], ...]] = {
    FileKind.DEPLOY: ((FileKind.CFG,), (FileKind.URDF, FileKind.MJCF)),
    FileKind.CFG: ((FileKind.URDF, FileKind.MJCF),),
    FileKind.MJCF: ((FileKind.URDF,),),
    FileKind.URDF: (),
}
"""What a kind of file is held to, the first that states the figure; then earlier files of its own kind."""


def disagreements(
    case: Case,
    fields: Sequence[str],
    tolerance: float,
    absolute: float = 0.0,
    robots: Sequence[Robot] | None = None,
) -> Iterator[Disagreement]:
    """Where files of one robot state different figures.

    A file is held to the URDF and MJCF of its robot, a deploy file to the training configuration. One that agrees
    with any of them is right; else the nearest is named: with the same joints, by the same name, the first. Of files
    that somebody named a deploy file is held to each configuration: one of another file that agrees, which may be the
    last that was not changed, does not speak for the others. Beside what its run recorded it is held to that alone.
    Of a known robot the file with the published figure is right. A figure that a file does not state is not compared,
    nor two of which a spec has one: what it says of the other file is SPC101's.

    Args:
        case: The case.
        fields: Fields of a row; of several, the first that a file states is its figure.
        tolerance: Largest relative difference of equal figures.
        absolute: Largest absolute difference of equal figures.
        robots: Whose files are held to each other; None: the case's.

    Yields: One a joint and departing file.
    """
    blamed = set()
    for robot in case.robots if robots is None else robots:
        if len(robot.artifacts) < 2:
            continue
        stated = {index: _stated_joints(case, index, fields) for index in robot.artifacts}
        every = tuple(_of_robot(case, robot, stated, tolerance, absolute))
        # What runs a policy against what trained it first: a third file must not take the place of that.
        every = tuple(sorted(every, key=lambda found: not _is_training(case, found)))
        every = tuple(found for found in every if not is_of_spec(case, robot, found))
        kinds = _stated_by_kinds(case, stated) if every else {}
        holders = _holders(case, stated) if every else {}
        for found in every:
            wrong = by_what_is_published(case, found)
            if not (wrong.published or wrong.beyond_published):
                # What other runs recorded says nothing of this one.
                as_is = wrong if found.others[0].artifact in case.runs_of(found.rows[0].artifact) else None
                wrong = by_sense(case, wrong) or as_is or by_kinds(case, wrong, kinds)
            wrong = replace(wrong, also=tuple(_beside_others(case, wrong, stated, kinds)))
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
        # Beside its own run it may be right.
        is_its = wrong.others[0].artifact in (case.runs_of(index) or (wrong.others[0].artifact,))
        if case.artifacts[index].path != mine.file and is_its:
            rows = case.joints[index, mine.joint]
            yield replace(wrong, rows=rows, mine=figure(rows, wrong.field), copy=True)


def _beside_others(
    case: Case, wrong: Disagreement, stated: _StatedBy, stated_by: Mapping[str, Mapping[FileKind, set[float]]]
) -> Iterator[Disagreement]:
    """The same beside each other file that has the figure to which one is held, of files that somebody named.

    Only where files of all kinds but that one's have it: else files go along with each figure, and which of them are of
    one variant nobody knows. And where the models among them are of one machine.
    """
    mine, joint = wrong.rows[0].artifact, wrong.rows[0].joint
    if case.is_met(mine) or wrong.mine.value is None or wrong.theirs.value is None:
        return
    own = case.artifacts[mine].kind

    def has(value: float, figure: Figure) -> bool:
        return math.isclose(value, figure.value or 0.0, rel_tol=SAME)

    kinds = stated_by.get(joint, {})
    if any(kind is not own and any(has(value, wrong.mine) for value in each) for kind, each in kinds.items()):
        return
    if any(has(value, wrong.theirs) for value in kinds.get(own, ())):
        return
    others = [
        (index, its[joint])
        for index, its in stated.items()
        if joint in its
        and case.artifacts[index].kind is not own
        and has(its[joint][1], wrong.theirs)
        and not case.is_met(index)
        and is_one_joint(case, mine, index, joint)
        and _is_one_kind(wrong.rows[0].kind, case.joints[index, joint][0].kind)
    ]
    if not all(is_one_machine(case, mine, index) for index, _ in others):
        return
    for index, (name, _) in others:
        if index != wrong.others[0].artifact:
            rows = case.joints[index, joint]
            variant = are_variants(case, mine, index)
            yield replace(
                wrong,
                others=rows,
                other_field=name,
                theirs=figure(rows, name),
                variant=variant,
                one_machine=True,
            )


def _is_training(case: Case, found: Disagreement) -> bool:
    """Whether the files are a deploy file and a training configuration, and somebody named both."""
    kinds = {case.artifacts[rows[0].artifact].kind for rows in (found.rows, found.others)}
    return kinds == {FileKind.CFG, FileKind.DEPLOY} and not is_met(case, found)


def _stated_by_kinds(case: Case, stated: _StatedBy) -> dict[str, dict[FileKind, set[float]]]:
    """What the files that are run state, by joint and kind of file."""
    found: dict[str, dict[FileKind, set[float]]] = {}
    for index, joints in stated.items():
        for joint, (name, value) in joints.items():
            if not case.is_idle(_place(case.joints[index, joint], name)):
                found.setdefault(joint, {}).setdefault(case.artifacts[index].kind, set()).add(value)
    return found


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
        # A bound in decimals is in no binary figure: -0.302 and -0.312 are 0.01 apart.
        if math.isclose(value, its, rel_tol=tolerance, abs_tol=absolute * (1.0 + 1e-9)):
            return True
        places = (_place(case.joints[mine[0], joint], name), _place(case.joints[theirs[0], joint], other))
        return _is_one_place(*places, real_path)

    for index in robot.artifacts:
        kind, path = case.artifacts[index].kind, case.artifacts[index].path
        trained = case.runs_of(index)
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
                    held = [member for each in known for member in each.members]
                    own_run = [member for member in held if member[0] in trained]
                    held = own_run or held
                    if not own_run and not every and any(mine[1] in each.paths for each in known):
                        break
                if not held:
                    continue
                kind_here = case.joints[index, joint][0].kind
                held = [
                    each
                    for each in held
                    if _is_one_kind(kind_here, case.joints[each[0], joint][0].kind)
                    and is_one_joint(case, index, each[0], joint)
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
                    yield Disagreement(
                        rows, others, mine[0], theirs[0], *figures, variant, one_machine(index, other)
                    )
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
        if stated is None and "default_position" in fields and is_left_at_zero(case, rows[0]):
            stated = "default_position", 0.0
        if stated is not None:
            found[joint] = stated
    return found


def _stated_fields(case: Case) -> dict[int, frozenset[str]]:
    """The fields that each artifact states of any joint."""
    return {
        index: frozenset().union(*(_said(row) for row in case.rows_of(index)))
        for index in range(len(case.artifacts))
    }


def _said(row: LedgerRow) -> frozenset[str]:
    """The fields that a file states of a joint: a servo of its speed alone says that nothing holds its position."""
    return row.stated | {"kp"} if row.control == "velocity" and row.kp == 0.0 else row.stated


def _stated(rows: Sequence[LedgerRow], fields: Sequence[str]) -> _Stated | None:
    """The first of the fields that a joint's file states, and its finite value."""
    for name in fields:
        for row in rows:
            if name in _said(row):
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


def is_one_machine(case: Case, one: int, other: int, least: float = SHARE) -> bool:
    """Whether nothing speaks against one machine: models tell by what their links weigh and how far joints turn.

    `g1.urdf` and `g1.xml` of one folder are two descriptions of one, where half of the figures agree. A left arm and a
    right one turn as far, each its own way, and have the same motors.

    Args:
        case: The case.
        one: An artifact.
        other: Another one.
        least: Share of the figures of two models of other names that must agree.
    """
    here, there = case.artifacts[one].robot, case.artifacts[other].robot
    names = {os.path.splitext(case.artifacts[index].path)[0] for index in (one, other)}
    share = LIKENESS if len(names) == 1 else least
    mirrored = are_of_two_sides(case, one, other)
    return here is None or there is None or are_one_body(here, there, share, mirrored=mirrored)
