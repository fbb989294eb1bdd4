"""What is different between two files in effective dynamics: figures of each joint, and the robot's steps."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from actspec.audit.build import case_of
from actspec.audit.by_key import stated_by_key
from actspec.audit.read import read_files
from actspec.audit.same_robot import of_robot, pairs_of
from actspec.diagnostics import AuditError, Collector, Span, one_line
from actspec.fields import DAMPING_PARTS, FIELDS, Role
from actspec.readings.artifact import FileKind, FileReading, Framework
from actspec.readings.compare import EXACT, Deviation, Figure, compare, ratio_of, same
from actspec.readings.dynamics import (
    OF_CONTROLS,
    ORDERS,
    SETTING_NOUNS,
    JointDynamics,
    RobotDynamics,
    dynamics_of,
    levelled,
)
from actspec.readings.including import without_fragments
from actspec.readings.named import named_as_run
from actspec.readings.versions import Versions
from actspec.spec.variants import split

SAME_INERTIA = 1e-6
"""Largest relative difference of equal inertia of the links. Chosen: engines of other versions compute it from the
same file to 1e-7."""

SAME_AXIS = 1e-3
"""Largest angle between equal axes [rad]. Chosen: six digits of a quaternion turn one by 1e-6, and nobody mounts a
motor to 0.06 deg."""

AXIS = "axis in the base's frame"
"""In words. Of files of one kind alone: exporters choose the base's frame."""

UNKNOWN, NONE, NOT_STATED, BY_KEY = "unknown", "none", "not stated", "by pattern"

_WITH_LINKS = {FileKind.MJCF, FileKind.URDF, FileKind.SPEC}
"""Kinds of files with a model, whose links have inertia."""

_DRIVES = {FileKind.SPEC, FileKind.CFG, FileKind.DEPLOY}
"""Kinds of files whose joints all have a drive."""

_UNDRIVEN = {"none", "motor", "network", "other"}
"""Controls without gains: there are none, which is not the same as unknown ones."""

EFFECTS = ("natural_frequency", "damping_ratio")
"""What follows from the other figures and the links, and is reported beside them."""


@dataclass(frozen=True, slots=True)
class Change:
    """One figure that is another one.

    Attributes:
        joint: Whose, or the pattern that it is stated for; "" for the whole robot.
        field: Of `FIELDS` or `SETTING_NOUNS`, or `control`, `network`, `randomize`, `axis`; of the whole robot also
            `order` (what stands at a place of a list of names), `entry` (a number that no figure is made from and that
            may be of a joint), `other` (any other such value), `unread`.
        noun: The field in words.
        old: Before, in `unit`; None is unknown, or that there was none.
        new: After.
        unit: SI unit; "" where there is none.
        old_place: Where it was written; None when nowhere.
        new_place: Where it is.
        absent: What None means: `unknown`, `none`, `not stated`, or `by pattern`: these are changes of their own.
    """

    joint: str
    field: str
    noun: str
    old: float | str | None
    new: float | str | None
    unit: str
    old_place: Span | None = None
    new_place: Span | None = None
    absent: str = UNKNOWN

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
        compared: How many figures were held against each other.
        left: What was not: a figure that one of two kinds of file states alone, one that is written in both and known
            in neither, and inertia of the links that is unknown or of two kinds of file.
    """

    old: RobotDynamics
    new: RobotDynamics
    added: tuple[str, ...]
    removed: tuple[str, ...]
    changes: tuple[Change, ...]
    effects: tuple[Change, ...]
    compared: int
    left: tuple[Change, ...]

    @property
    def changed(self) -> bool:
        """Whether anything did of what was compared."""
        return bool(self.added or self.removed or self.changes)

    @property
    def same(self) -> bool:
        """Whether nothing changed of what was compared; where nothing was, nobody knows."""
        nothing = bool(self.left) and not self.compared
        return not (self.changed or nothing)


def compare_files(
    old: str,
    new: str,
    versions: Versions,
    robot: str | None = None,
    texts: Mapping[str, str] | None = None,
    joints: str | None = None,
) -> tuple[Difference, ...]:
    """What is different between two files, robot by robot; of one kind of file also robots that only one of them has.

    Args:
        old: The file before.
        new: The file after.
        versions: What the files are meant for.
        robot: Only the robot of this name, which one of the files has, and each that has several; None: all.
        texts: Path to what the user called it, for messages.
        joints: File or list that names the joints; None: the files do.

    Raises: AuditError: a file cannot be read, nothing names the joints as asked, or it is not known which robots of two
        files are the same.
    """
    readings = read_all(tuple(dict.fromkeys((old, new))), texts or {})
    chosen = of_robot(readings, robot)
    names = () if joints is None else _joints(chosen, joints)
    case = case_of(chosen, versions, {}, whole=True, joints=names)
    before, after = ([i for i, a in enumerate(case.artifacts) if a.path == path] for path in (old, new))
    shown = tuple((texts or {}).get(path, path) for path in (old, new))
    pairs = pairs_of(case, before, after, robot, shown, "--robot NAME")
    dynamics = [dynamics_of(artifact, case.rows_of(i)) for i, artifact in enumerate(case.artifacts)]
    found = [compare_robots(dynamics[one], dynamics[other]) for one, other in pairs]
    by_name = all(dynamics[one].name == dynamics[other].name for one, other in pairs)
    if robot is None and by_name and dynamics[before[0]].kind is dynamics[after[0]].kind:
        # A robot that only one of the files has is all gone, or all new.
        paired = {index for pair in pairs for index in pair}
        for index in sorted({*before, *after} - paired):
            whole, none = dynamics[index], replace(dynamics[index], joints={})
            found.append(compare_robots(whole, none) if index in before else compare_robots(none, whole))
    return tuple(found)


def _joints(readings: Sequence[FileReading], named: str) -> Sequence[str]:
    # The audit, which asks for none of them, needs no yaml.
    from actspec.readings.joint_lists import named_joints, names_of

    out = Collector()
    found = named_joints([one for reading in readings for one in reading.artifacts], named, out)
    out.raise_if_failed(AuditError)
    return names_of(found.joints)


def read_all(
    paths: Sequence[str],
    texts: Mapping[str, str],
    gone: str | None = None,
    *,
    folders: bool = False,
    exclude: Callable[[str, bool], bool] | None = None,
) -> tuple[FileReading, ...]:
    """Read files of which each must be readable.

    Args:
        paths: Files.
        texts: Path to what the user called it.
        gone: What to do where there is no such file.
        folders: Take folders too, for the files in them that are of a robot and no part of another one.
        exclude: Whether to pass over a file or folder, by its path and whether it was named.

    Raises: AuditError: one of them is not.
    """
    out = Collector()
    for path in paths:
        if os.path.isdir(path) and not folders:
            shown = texts.get(path, path)
            help = named_as_run(path, shown)
            out.error("DIF001", "is a folder: name the files", span=Span(shown), help=help)
    out.raise_if_failed(AuditError)
    readings = read_files(paths, exclude=exclude)
    if folders:
        whole = {reading.path for reading in without_fragments(readings)}
        readings = tuple(one.as_named() for one in readings if not one.in_folder or one.path in whole)
    # What is wrong in a variant of a spec stands in its file.
    called = {split(path)[0]: split(text)[0] for path, text in texts.items()} | dict(texts)
    for reading in readings:
        if not reading.readable:
            reason = reading.reason or ""
            for path, text in called.items():
                reason = reason.replace(path, text)
            place = replace(reading.place, path=called.get(reading.place.path, reading.place.path))
            there = reading.kind is FileKind.SPEC or os.path.exists(reading.path)
            help = reading.help if there else gone
            empty = reading.names_nothing and os.path.isdir(reading.path)
            said = f"{'nothing to record' if empty else 'cannot be read'}: {reason}"
            out.error("DIF001", one_line(said), span=place, help=help)
        elif not reading.artifacts:
            shown = texts.get(reading.path, reading.path)
            out.error("DIF001", "describes no robot", span=Span(shown))
    out.raise_if_failed(AuditError)
    return readings


def compare_robots(old: RobotDynamics, new: RobotDynamics, tolerance: float = EXACT) -> Difference:
    """Compare two robots.

    Between files of one kind, a figure that one of them lacks has changed. Between kinds it says nothing: a URDF has
    no gains, and what drives a motor's or a bare joint's position is in another file.

    Args:
        old: Before.
        new: After.
        tolerance: Largest relative difference of equal figures.
    """
    changes = [*_settings(old, new, tolerance), *_orders(old, new)]
    compared, left = _settings_left(old, new)
    count, found_beside, left_beside = _beside(old, new, tolerance)
    compared += count
    changes += found_beside
    left += left_beside
    count, found_by_key = stated_by_key(old, new, tolerance)
    compared += count
    changes += [_by_key(*item) for item in found_by_key]
    effects: list[Change] = []
    for name, after in new.joints.items():
        before = old.joints.get(name)
        if before is None:
            continue
        before, after = levelled(before, after), levelled(after, before)
        if old.kind is new.kind:
            before, after = _zeroed(before, after), _zeroed(after, before)
        fields = _shared(before, after, old.kind, new.kind)
        found = list(_joint(before, after, fields, tolerance, alike=old.kind is new.kind))
        compared += len(fields)
        left += _left(before, after, old.kind, new.kind)
        found += _drive_gone(old, new, name)
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
        compared,
        tuple(left),
    )


def _zeroed(joint: JointDynamics, other: JointDynamics) -> JointDynamics:
    """A joint without a pose, beside one whose pose is 0: that is what every simulator takes where none is stated."""
    pose, beside = (side.figures.get("default_position") for side in (joint, other))
    if beside is None or beside.value != 0.0 or (pose is not None and pose.value is not None):
        return joint
    return replace(joint, figures={**joint.figures, "default_position": replace(beside, stated=False)})


def _settings(old: RobotDynamics, new: RobotDynamics, tolerance: float) -> Iterator[Change]:
    for name in SETTING_NOUNS:
        before, after = old.settings.get(name), new.settings.get(name)
        if not (_says(old, name) and _says(new, name)) and old.kind is not new.kind:
            continue
        if isinstance(before, str) or isinstance(after, str) or not same(before, after, tolerance):
            if before == after:
                continue
            # A step that a spec leaves to the engine is nobody's number.
            left = [_is_left(side, name) for side in (old, new)]
            absent = NOT_STATED if any(left) else UNKNOWN
            yield _setting(name, None if left[0] else before, None if left[1] else after, absent)


def _settings_left(old: RobotDynamics, new: RobotDynamics) -> tuple[int, list[Change]]:
    """How many settings both state, and those that only one of two kinds of file does."""
    names = [name for name in SETTING_NOUNS if name in old.settings or name in new.settings]
    if old.kind is new.kind:
        return len(names), []
    both, alone = 0, []
    for name in names:
        sides = [side for side in (old, new) if _says(side, name)]
        both += len(sides) == 2
        # A default of an engine is nobody's statement.
        if len(sides) == 1 and name not in sides[0].unstated:
            before, after = (side.settings[name] if side is sides[0] else None for side in (old, new))
            alone.append(_setting(name, before, after, NOT_STATED))
    return both, alone


def _says(robot: RobotDynamics, name: str) -> bool:
    """Whether a file has a setting: a model has its engine's default too, a spec leaves that to the model."""
    return name in robot.settings and not _is_left(robot, name)


def _is_left(robot: RobotDynamics, name: str) -> bool:
    return robot.kind is FileKind.SPEC and name in robot.unstated


def _orders(old: RobotDynamics, new: RobotDynamics) -> Iterator[Change]:
    """What stands at another place of a list of names, and what an actuator drives that drove something else.

    Where names came or went, which is told of the joints, the order of the others counts.
    """
    if old.kind is not new.kind or old.orders is None or new.orders is None:
        return
    told = set()
    for kind in ("ctrl", "joint_order", "sdk_order"):
        before, after = old.orders.get(kind, ()), new.orders.get(kind, ())
        if (
            not before
            or not after
            or [one for one in before if one in after] == [one for one in after if one in before]
        ):
            continue
        names = [side.orders.get("actuators", ()) for side in (old, new) if side.orders is not None]
        for place, (one, other) in enumerate(zip(before, after, strict=False)):
            if one == other:
                continue
            noun = ORDERS[kind].format(place=place, entry=place + 1)
            if kind == "ctrl" and names[0][place] and names[0][place] == names[1][place]:
                told.add(names[0][place])
                noun = f"ctrl[{place}], actuator {names[0][place]}, drives"
            yield Change("", "order", noun, one, other, "", absent=NONE)
    one_of, other_of = _driven(old), _driven(new)
    for name, target in one_of.items():
        now = other_of.get(name, target)
        # What was renamed is told as a joint that is gone and one that is new.
        if now != target and name not in told and target in new.joints and now in old.joints:
            yield Change("", "order", f"actuator {name} drives", target, now, "", absent=NONE)


def _driven(robot: RobotDynamics) -> dict[str, str]:
    """What each actuator drives, by its name."""
    orders = robot.orders or {}
    pairs = zip(orders.get("actuators", ()), orders.get("ctrl", ()), strict=False)
    return {name: target for name, target in pairs if name}


def _beside(
    old: RobotDynamics, new: RobotDynamics, tolerance: float
) -> tuple[int, list[Change], list[Change]]:
    """What no figure is made from: how many numbers are compared, those that changed, and what is not compared."""
    left = [
        Change("", "unread", what, old.unread.get(what), new.unread.get(what), "", absent="read")
        for what in dict.fromkeys((*old.unread, *new.unread))
    ]
    ours, theirs = old.entries, new.entries
    if ours is None or theirs is None:
        return 0, [], left
    if old.kind is not new.kind:
        one, other = (float(len(side)) if side else None for side in (ours, theirs))
        if ours or theirs:
            noun = "numbers whose joint it does not name"
            left.append(Change("", "entry", noun, one, other, "", absent=NOT_STATED))
        return 0, [], left
    # A lock has them by name; the file in its order.
    every = list(dict.fromkeys((*theirs, *ours)))
    changes = []
    for where in every:
        before, after = (
            side.get(where, others.get(where)) for side, others in ((ours, old.others), (theirs, new.others))
        )
        if isinstance(before, str) or isinstance(after, str):
            if before != after:
                changes.append(Change("", "entry", where, before, after, "", absent=NONE))
        elif not same(before, after, tolerance):
            changes.append(Change("", "entry", where, before, after, "", absent=NONE))
    for where in dict.fromkeys((*old.others, *new.others)):
        if where not in every and old.others.get(where) != new.others.get(where):
            left.append(
                Change("", "other", where, old.others.get(where), new.others.get(where), "", absent=NONE)
            )
    return len(every), changes, left


def _by_key(key: str, noun: str, item: Deviation, absent: str) -> Change:
    was, now = item.reference, item.figure
    unit = next(one.unit for one in (now, was) if one is not None)
    before, after = (None if one is None else one.place for one in (was, now))
    return Change(key, item.field, noun, item.expected, item.value, unit, before, after, absent)


def _setting(name: str, old: float | str | None, new: float | str | None, absent: str = UNKNOWN) -> Change:
    unit = "s" if name in ("physics_dt", "control_dt") else ""
    return Change("", name, SETTING_NOUNS[name], old, new, unit, absent=absent)


def _shared(old: JointDynamics, new: JointDynamics, old_kind: FileKind, new_kind: FileKind) -> list[str]:
    """Fields that are compared: of one kind of file all that one of them knows, of two what both state."""
    if old_kind is new_kind:
        known = {name for side in (old, new) for name, one in side.figures.items() if one.value is not None}
        # Another kind of drive lacks them, and a lock of an older actspec.
        known -= {name for name in OF_CONTROLS if not (name in old.figures and name in new.figures)}
        return [name for name in FIELDS if name in known]
    return [name for name in FIELDS if states(old, name, old_kind) and states(new, name, new_kind)]


def _joint(
    old: JointDynamics, new: JointDynamics, fields: Sequence[str], tolerance: float, *, alike: bool
) -> Iterator[Change]:
    if alike and old.control != new.control:
        yield Change(new.joint, "control", "drive", old.control, new.control, "", old.place, new.place)
    found = [_change(old, new, item) for item in compare(new.figures, old.figures, fields, tolerance)]
    parts = [(change.old, change.new) for change in found if change.field in DAMPING_PARTS]
    # A total that is its only part says nothing new.
    yield from (
        change for change in found if change.field != "total_damping" or (change.old, change.new) not in parts
    )
    if alike and old.axis is not None and new.axis is not None and not _is_one_axis(old.axis, new.axis):
        yield _axis(old, new)
    if alike and old.network != new.network:
        yield _network(old, new, NONE)
    if alike and old.ranges is not None and new.ranges is not None:
        for name in dict.fromkeys((*old.ranges, *new.ranges)):
            ends = old.ranges.get(name), new.ranges.get(name)
            if ends[0] != ends[1]:
                noun = f"randomization of {name}"
                yield Change(new.joint, "randomize", noun, *ends, "", old.place, new.place, NONE)
    # Over the poses, of which a spec takes more than a model.
    if alike and old.inertia is not None and new.inertia is not None:
        unit = new.figures["armature"].unit
        largest = max(abs(end) for end in (*old.inertia, *new.inertia))
        for name, low, high in zip(("inertia_min", "inertia_max"), old.inertia, new.inertia, strict=True):
            if abs(high - low) > SAME_INERTIA * largest:
                yield Change(new.joint, name, FIELDS[name].noun, low, high, unit)


def _drive_gone(old: RobotDynamics, new: RobotDynamics, joint: str) -> Iterator[Change]:
    """A drive that one of two kinds of file has and a model has not, where it has one for other joints.

    mjlab adds the actuators of its configuration to those of the model. Gains of 0 are no drive, where a list has a
    place for each joint.
    """
    for bare, other in ((new, old), (old, new)):
        own, theirs = bare.joints[joint], other.joints[joint]
        drives = other.kind in _DRIVES and other.framework is not Framework.MJLAB
        gains = {theirs.figures[name].value for name in ("kp", "kd") if name in theirs.figures}
        if joint in bare.undriven and drives and own.control != theirs.control and gains != {0.0}:
            was, now = old.joints[joint], new.joints[joint]
            yield Change(joint, "control", "drive", was.control, now.control, "", was.place, now.place)


def _left(old: JointDynamics, new: JointDynamics, old_kind: FileKind, new_kind: FileKind) -> Iterator[Change]:
    """What is not compared at a joint that both have."""
    alike = old_kind is new_kind
    for name, field in FIELDS.items():
        one, other = old.figures.get(name), new.figures.get(name)
        # A default of an engine is nobody's statement, and a total is what its parts are.
        stated = any(figure is not None and figure.stated for figure in (one, other))
        if not stated or field.role is Role.TOTAL:
            continue
        known = [states(old, name, old_kind), states(new, name, new_kind)]
        if alike and all(figure is not None and figure.value is None for figure in (one, other)):
            if name in old.by_key & new.by_key:
                continue
            yield _change(old, new, Deviation(name, other, one))
        elif not alike and known == [True, False]:
            yield _change(old, new, Deviation(name, None, one), NOT_STATED)
        elif not alike and known == [False, True]:
            yield _change(old, new, Deviation(name, other, None), NOT_STATED)
    of_model = alike and old_kind in (FileKind.MJCF, FileKind.URDF) and "armature" in new.figures
    if of_model and (old.axis is None or new.axis is None):
        yield _axis(old, new)
    if not alike and old.network != new.network:
        yield _network(old, new, UNKNOWN if old.network and new.network else NOT_STATED)
    of_links = {old_kind, new_kind} <= _WITH_LINKS and "armature" in new.figures
    if of_links and not (alike and old.inertia and new.inertia):
        low, high = (None if side.inertia is None else side.inertia[1] for side in (old, new))
        noun, unit = FIELDS["inertia_max"].noun, new.figures["armature"].unit
        yield Change(new.joint, "inertia_max", noun, low, high, unit)


def _is_one_axis(old: tuple[float, float, float], new: tuple[float, float, float]) -> bool:
    """Whether two unit vectors point the same way; the chord of a small angle is the angle."""
    return math.dist(old, new) <= SAME_AXIS


def _axis(old: JointDynamics, new: JointDynamics) -> Change:
    one, other = (None if side.axis is None else axis_text(side.axis) for side in (old, new))
    return Change(new.joint, "axis", AXIS, one, other, "", old.place, new.place)


def axis_text(axis: Sequence[float]) -> str:
    """`0 -1 0`: six decimals, by way of twelve, so that noise is never at the edge."""
    return " ".join(f"{round(round(part, 12), 6) + 0.0:g}" for part in axis)


def _network(old: JointDynamics, new: JointDynamics, absent: str) -> Change:
    return Change(new.joint, "network", "network", old.network, new.network, "", old.place, new.place, absent)


def _change(old: JointDynamics, new: JointDynamics, item: Deviation, absent: str | None = None) -> Change:
    figures = (item.reference, item.figure)
    unit = next((figure.unit for figure in reversed(figures) if figure is not None), "")
    field = FIELDS[item.field]
    if absent is None:
        without = old if item.expected is None else new
        undriven = field.role is Role.DRIVE and set(without.control.split("+")) <= _UNDRIVEN
        by_key = item.field in (old if item.expected is None else new).by_key
        absent = (
            BY_KEY
            if by_key
            else NONE
            if field.optional or field.role is Role.COMMAND or undriven
            else UNKNOWN
        )
    old_place, new_place = (None if figure is None else figure.place for figure in figures)
    return Change(
        new.joint, item.field, field.noun, item.expected, item.value, unit, old_place, new_place, absent
    )


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
    if kind in (FileKind.CFG, FileKind.DEPLOY) and name in ("position_low", "position_high"):
        return False  # they are those of the model beside it
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
