"""What is different between two files in effective dynamics: figures of each joint, and the robot's steps."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from actspec.audit.build import case_of
from actspec.audit.case import Case
from actspec.audit.read import read_files
from actspec.diagnostics import AuditError, Collector, Span, listed, one_line
from actspec.fields import DAMPING_PARTS, FIELDS, Role
from actspec.readings.artifact import FileKind, FileReading
from actspec.readings.compare import EXACT, Deviation, Figure, compare, ratio_of, same
from actspec.readings.dynamics import SETTING_NOUNS, JointDynamics, RobotDynamics, dynamics_of
from actspec.readings.versions import Versions

SAME_INERTIA = 1e-6
"""Largest relative difference of equal inertia of the links. Chosen: engines of other versions compute it from the
same file to 1e-7."""

EFFECTS = ("natural_frequency", "damping_ratio")
"""What follows from the other figures and the links, and is reported beside them."""


@dataclass(frozen=True, slots=True)
class Change:
    """One figure that is another one.

    Attributes:
        joint: Whose; "" for the whole robot.
        field: Of `FIELDS` or `SETTING_NOUNS`, or `control`, `network`.
        noun: The field in words.
        old: Before, in `unit`; None is unknown, or that there was none.
        new: After.
        unit: SI unit; "" where there is none.
        old_place: Where it was written; None when nowhere.
        new_place: Where it is.
    """

    joint: str
    field: str
    noun: str
    old: float | str | None
    new: float | str | None
    unit: str
    old_place: Span | None = None
    new_place: Span | None = None

    @property
    def ratio(self) -> float | None:
        """New over old; None where that says nothing."""
        if isinstance(self.old, str) or isinstance(self.new, str):
            return None
        return ratio_of(self.new, self.old)


@dataclass(frozen=True, slots=True)
class Difference:
    """Two robots.

    Attributes:
        old: Before.
        new: After.
        added: Joints that only the new one has.
        removed: Joints that only the old one has.
        changes: Robot first, then by joint; without those of joints that were added or removed.
        effects: What follows for joints with changes.
    """

    old: RobotDynamics
    new: RobotDynamics
    added: tuple[str, ...]
    removed: tuple[str, ...]
    changes: tuple[Change, ...]
    effects: tuple[Change, ...]

    @property
    def same(self) -> bool:
        """Whether nothing changed."""
        return not (self.added or self.removed or self.changes)


def compare_files(
    old: str,
    new: str,
    versions: Versions,
    robot: str | None = None,
    texts: Mapping[str, str] | None = None,
) -> tuple[Difference, ...]:
    """What is different between two files, robot by robot.

    Args:
        old: The file before.
        new: The file after.
        versions: What the files are meant for.
        robot: Only the robot of this name, where a file has several; None: all.
        texts: Path to what the user called it, for messages.

    Raises: AuditError: a file cannot be read, or it is not known which robots of two files are the same.
    """
    readings = read_all(tuple(dict.fromkeys((old, new))), texts or {})
    case = case_of(readings, versions, {})
    before, after = ([i for i, a in enumerate(case.artifacts) if a.path == path] for path in (old, new))
    pairs = _pairs(case, before, after, robot, tuple((texts or {}).get(path, path) for path in (old, new)))
    dynamics = [dynamics_of(artifact, case.rows_of(i)) for i, artifact in enumerate(case.artifacts)]
    return tuple(compare_robots(dynamics[one], dynamics[other]) for one, other in pairs)


def one_robot(case: Case, spec: int, other: int, robot: str | None) -> tuple[int, int]:
    """Which robot of a spec and of a file, both at the beginning of a case, are one.

    Args:
        case: The spec, the file, and what else describes the robot.
        spec: How many artifacts the spec has.
        other: How many the file has.
        robot: As in `compare_files`.

    Raises: AuditError: it is not known which.
    """
    ours, theirs = list(range(spec)), list(range(spec, spec + other))
    texts = (case.artifacts[ours[0]].path, case.artifacts[theirs[0]].path)
    return _pairs(case, ours, theirs, robot, texts)[0]


def read_all(paths: Sequence[str], texts: Mapping[str, str]) -> tuple[FileReading, ...]:
    """Read files of which each must be readable.

    Args:
        paths: Files.
        texts: Path to what the user called it.

    Raises: AuditError: one of them is not.
    """
    out = Collector()
    for path in paths:
        if os.path.isdir(path):
            out.error("DIF001", "is a folder: name the files", span=Span(texts.get(path, path)))
    out.raise_if_failed(AuditError)
    readings = read_files(paths)
    for reading in readings:
        shown = texts.get(reading.path, reading.path)
        if not reading.readable:
            reason = reading.reason or ""
            for path, text in texts.items():
                reason = reason.replace(path, text)
            place = (
                reading.place if reading.place.path != reading.path else replace(reading.place, path=shown)
            )
            out.error("DIF001", f"cannot be read: {one_line(reason)}", span=place)
        elif not reading.artifacts:
            out.error("DIF001", "describes no robot", span=Span(shown))
    out.raise_if_failed(AuditError)
    return readings


def _pairs(
    case: Case, old: list[int], new: list[int], robot: str | None, texts: tuple[str, ...]
) -> list[tuple[int, int]]:
    """Which robots of two files are one: by name, or because there is one only."""
    if robot is not None:
        old, new = (_named(case, found, robot, text) for found, text in zip((old, new), texts, strict=True))
    if len(old) == len(new) == 1:
        return [(old[0], new[0])]
    names = {case.artifacts[i].name: i for i in new}
    pairs = [(i, names[case.artifacts[i].name]) for i in old if case.artifacts[i].name in names]
    if pairs:
        return pairs
    # One robot beside several: the one that its joints and its name belong to.
    for few, many in ((old, new), (new, old)):
        if len(few) == 1:
            fitting = [i for i in many if i in case.robot_of(few[0]).artifacts]
            if len(fitting) == 1:
                return [(few[0], fitting[0]) if few is old else (fitting[0], few[0])]
    found = "; ".join(
        f"{one_line(text)} has {listed(one_line(case.artifacts[i].name) for i in indices)}"
        for indices, text in zip((old, new), texts, strict=True)
    )
    message = f"it is not known which robots are the same: {found}"
    raise AuditError.of("DIF003", message, help="name one with --robot NAME")


def _named(case: Case, indices: list[int], robot: str, text: str) -> list[int]:
    """The robot of that name; the only one of a file has any."""
    found = [i for i in indices if case.artifacts[i].name == robot]
    if found or len(indices) == 1:
        return found or indices
    names = listed(one_line(case.artifacts[i].name) for i in indices)
    raise AuditError.of("DIF003", f"has no robot {robot!r}", Span(text), help=f"it has {names}")


def compare_robots(old: RobotDynamics, new: RobotDynamics, tolerance: float = EXACT) -> Difference:
    """Compare two robots.

    Between files of one kind, a figure that one of them lacks has changed. Between kinds it says nothing: a URDF has
    no gains, and what drives a motor's or a bare joint's position is in another file.

    Args:
        old: Before.
        new: After.
        tolerance: Largest relative difference of equal figures.
    """
    changes = list(_settings(old, new, tolerance))
    effects: list[Change] = []
    for name, after in new.joints.items():
        before = old.joints.get(name)
        if before is None:
            continue
        found = list(_joint(before, after, old.kind, new.kind, tolerance))
        changes += found
        if found:
            effects += _effects(before, after)
    return Difference(
        old,
        new,
        tuple(name for name in new.joints if name not in old.joints),
        tuple(name for name in old.joints if name not in new.joints),
        tuple(changes),
        tuple(effects),
    )


def _settings(old: RobotDynamics, new: RobotDynamics, tolerance: float) -> Iterator[Change]:
    for name, noun in SETTING_NOUNS.items():
        before, after = old.settings.get(name), new.settings.get(name)
        if (before is None or after is None) and old.kind is not new.kind:
            continue
        if isinstance(before, str) or isinstance(after, str) or not same(before, after, tolerance):
            if before == after:
                continue
            unit = "s" if name in ("physics_dt", "control_dt") else ""
            yield Change("", name, noun, before, after, unit)


def _joint(
    old: JointDynamics, new: JointDynamics, old_kind: FileKind, new_kind: FileKind, tolerance: float
) -> Iterator[Change]:
    alike = old_kind is new_kind
    if alike and old.control != new.control:
        yield Change(new.joint, "control", "drive", old.control, new.control, "", old.place, new.place)
    fields = [
        name for name in FIELDS if alike or (states(old, name, old_kind) and states(new, name, new_kind))
    ]
    found = [_change(new.joint, item) for item in compare(new.figures, old.figures, fields, tolerance)]
    parts = [(change.old, change.new) for change in found if change.field in DAMPING_PARTS]
    # A total that is its only part says nothing new.
    yield from (
        change for change in found if change.field != "total_damping" or (change.old, change.new) not in parts
    )
    if alike and old.network != new.network:
        yield Change(new.joint, "network", "network", old.network, new.network, "", old.place, new.place)
    # Over the poses, of which a spec takes more than a model.
    if alike and old.inertia is not None and new.inertia is not None:
        unit = new.figures["armature"].unit
        largest = max(abs(end) for end in (*old.inertia, *new.inertia))
        for name, low, high in zip(("inertia_min", "inertia_max"), old.inertia, new.inertia, strict=True):
            if abs(high - low) > SAME_INERTIA * largest:
                yield Change(new.joint, name, FIELDS[name].noun, low, high, unit)


def _change(joint: str, item: Deviation) -> Change:
    new, old = item.figure, item.reference
    unit = next((figure.unit for figure in (new, old) if figure is not None), "")
    places = (None if figure is None else figure.place for figure in (old, new))
    return Change(joint, item.field, FIELDS[item.field].noun, item.expected, item.value, unit, *places)


def states(joint: JointDynamics, name: str, kind: FileKind) -> bool:
    """Whether a file states what a figure of another kind of file can be compared with.

    Args:
        joint: Of the file.
        name: Field of `FIELDS`.
        kind: What the file is.
    """
    figure: Figure | None = joint.figures.get(name)
    if figure is None or figure.value is None:
        return False
    if joint.control in ("none", "motor") and FIELDS[name].role in (Role.DRIVE, Role.TOTAL, Role.COMMAND):
        return False
    return figure.stated or not (joint.control == "none" or kind is FileKind.URDF)


def _effects(old: JointDynamics, new: JointDynamics) -> Iterator[Change]:
    for name in EFFECTS:
        before: float | None = getattr(old, name)
        after: float | None = getattr(new, name)
        if before is not None and after is not None and not same(before, after, SAME_INERTIA):
            field = FIELDS[name]
            yield Change(new.joint, name, field.noun, before, after, field.unit(None))
