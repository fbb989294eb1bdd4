"""Joints with the same figures, and the groups of a spec that they are put into.

What differs little within a limb becomes an override; classes with the same power behind different gears share a motor.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeGuard

from actspec.diagnostics import listed
from actspec.draft.names import given_name, group_name, joint_patterns, one_pattern, parts_of_body
from actspec.draft.rows import Row, clamp_of, motor_of, network_of, randomize_of, rows_of
from actspec.draft.sources import stated
from actspec.draft.text import figure
from actspec.fields import PLACEHOLDER
from actspec.ir import JointActuator, JointKind
from actspec.readings.artifact import FileKind
from actspec.readings.compare import EXACT, LEAST_REDUCTION, SAME_POWER, near
from actspec.units import format_number

MOST_DIFFERENT = 2
"""Fields in which joints of one group may differ. Chosen: a knee has another limit and speed; what differs in more
has a drive of its own, and reads better whole."""

MOST_PATTERNS = 2
"""Patterns that an override may take. Chosen: with more than these a group of its own is shorter."""


_MOST_TIMES = 8.0
"""Ratio of torques up to which joints without gains are one group. Chosen: the G1's wrists have a fifth of its elbows'
torque and nearly their gains, the Panda's 1 / 7.25 of its shoulder's and the same gains in Isaac Lab."""


@dataclass(slots=True)
class DraftGroup:
    """A group of a spec.

    Attributes:
        name: Its key.
        classes: The first is the group's own; the others are overrides of it.
        patterns: Of all its joints.
        motor: Key of its motor; "" without one.
    """

    name: str
    classes: list[JointClass]
    patterns: tuple[str, ...] = ()
    motor: str = ""

    @property
    def names(self) -> list[str]:
        """Names of all its joints."""
        return [name for cls in self.classes for name in cls.names]


@dataclass(slots=True)
class DraftMotor:
    """A motor of a spec.

    Attributes:
        name: Its key.
        rows: Figure to line.
        inferred: Whether no file says that it is one motor.
    """

    name: str
    rows: dict[str, Row] = field(default_factory=dict)
    inferred: bool = False


def groups_of(
    joints: Sequence[JointActuator],
    kinds: Sequence[FileKind],
    above: Mapping[str, frozenset[str]],
    names: Sequence[str],
    robot: str,
) -> list[DraftGroup]:
    """Sort joints into the groups that read best, each with its name and patterns.

    Limb by limb, and then equal joints of several limbs together, unless one of the limbs has exceptions: so one
    motor in hips, waist and shoulders stays one group, and knees and ankles do not become exceptions of a group
    that has half of the arms in it.

    Args:
        joints: In the robot's order, with keys of `sources` in their quantities.
        kinds: What the files are.
        above: Joint to those between it and the base.
        names: All joints that patterns are matched against, in the robot's order.
        robot: Its name.

    Raises:
        PatternError: a joint's name is too long.
    """
    order = {name: place for place, name in enumerate(names)}
    classes = joint_classes_of(joints, kinds)
    find_motors(classes, above)
    groups = [
        group
        for limb in _grouped(joined(classes), above, order)
        for part in _for_one_gain(limb.classes)
        for group in (_grouped(part, above, order) if len(part) < len(limb.classes) else [limb])
    ]
    groups = _without_twins(groups, order)
    groups.sort(key=lambda group: min(order[name] for name in group.names))
    given = {joint.joint: joint.group for joint in joints}
    taken: list[str] = []
    for group in groups:
        members = sorted(group.names, key=order.__getitem__)
        own = given_name(members, given, robot)
        group.name = own if own and own not in taken else group_name(members, taken, above, given, robot)
        taken.append(group.name)
        group.patterns = joint_patterns(members, names)
    return groups


def motors_of(groups: Sequence[DraftGroup]) -> tuple[list[DraftMotor], dict[int, str]]:
    """The motors that groups need, and the motor of each joint class by its identity."""
    classes = [cls for group in groups for cls in group.classes]
    users: dict[tuple[object, ...], list[JointClass]] = {}
    for cls in classes:
        lender = cls.base or cls
        if lender.motor or lender.lends:
            # Two inferred motors are never one: nobody says so.
            figures = tuple((name, row.value) for name, row in lender.motor.items()) or (id(lender),)
            users.setdefault(figures, []).append(cls)
    motors: list[DraftMotor] = []
    named: dict[int, str] = {}
    for own in users.values():
        lender = own[0].base or own[0]
        rows = lender.motor or {"peak_torque": lender.rows["effort_limit"]}
        name = _motor_name(own, groups, [motor.name for motor in motors])
        motors.append(DraftMotor(name, rows, not lender.motor))
        named.update({id(cls): name for cls in own})
    for group in groups:
        group.motor = named.get(id(group.classes[0]), "")
    return motors, named


def _motor_name(users: Sequence[JointClass], groups: Sequence[DraftGroup], taken: Sequence[str]) -> str:
    """After the group whose joints it drives, else after those joints."""
    home = next(group for group in groups if any(cls is users[0] for cls in group.classes))
    alone = all(any(cls is user for user in users) for cls in home.classes)
    stem = home.name if alone else group_name([name for cls in users for name in cls.names], ())
    name = f"{stem}_motor"
    while name in taken:
        name += "_2"
    return name


def _grouped(
    classes: Sequence[JointClass], above: Mapping[str, frozenset[str]], order: Mapping[str, int]
) -> list[DraftGroup]:
    """Put classes into groups: the largest first, what differs little within a limb as its override."""
    for cls in classes:
        cls.sort(order)
    groups: list[DraftGroup] = []
    for cls in sorted(classes, key=lambda cls: -len(cls.joints)):
        home = next((group for group in groups if _takes(group, cls, above, order)), None)
        if home is None:
            groups.append(DraftGroup("", [cls]))
        elif _twins(home.classes[0], cls):
            join(home.classes[0], cls, classes)
            home.classes[0].sort(order)
        else:
            home.classes.append(cls)
    return groups


def _for_one_gain(classes: list[JointClass]) -> list[list[JointClass]]:
    """Classes that one kp and kd can be for: as they are where files state gains, else by part and by torque.

    Who fills in the gains states them once for a group. Torques are cut where they are farthest apart.
    """
    if not all(_without_gains(cls) for cls in classes):
        return [classes]
    found: list[list[JointClass]] = []
    for wheels in (False, True):
        own = [cls for cls in classes if _is_wheel(cls) == wheels]
        found.append([cls for cls in own if cls.torque is None])
        found += _near_torques(sorted((cls for cls in own if cls.torque is not None), key=_torque))
    return [[cls for cls in classes if any(cls is one for one in part)] for part in found if part]


def _near_torques(classes: list[JointClass]) -> list[list[JointClass]]:
    """Classes in the order of their torques, cut at the largest ratio until no part has more than `_MOST_TIMES`."""
    torques = [_torque(cls) for cls in classes]
    if not torques or torques[-1] <= _MOST_TIMES * torques[0]:
        return [classes]
    cut = max(range(1, len(torques)), key=lambda at: torques[at] / torques[at - 1])
    return _near_torques(classes[:cut]) + _near_torques(classes[cut:])


def _torque(cls: JointClass) -> float:
    assert cls.torque is not None
    return cls.torque


def _told(one: JointClass) -> bool:
    """Whether equal figures tell that two limbs are equal: without gains a torque does."""
    return one.torque is not None or not _without_gains(one)


def _is_wheel(cls: JointClass) -> bool:
    return cls.part == "wheels"


def _without_gains(cls: JointClass) -> bool:
    """Whether nobody states a gain that the drive needs."""
    rows = [cls.rows[key] for key in ("kp", "kd") if key in cls.rows]
    return bool(rows) and all(row.value == "unknown" for row in rows)


def _without_twins(groups: Sequence[DraftGroup], order: Mapping[str, int]) -> list[DraftGroup]:
    """Groups of equal joints that no override has joined, as one."""
    kept: list[DraftGroup] = []
    every = [cls for group in groups for cls in group.classes]
    for group in groups:
        cls = group.classes[0]
        alike = [other for other in kept if len(other.classes) == 1 and _twins(other.classes[0], cls)]
        twin = alike[0] if alike and _told(cls) else None
        if twin is None or len(group.classes) > 1:
            kept.append(group)
        else:
            join(twin.classes[0], cls, every)
            twin.classes[0].sort(order)
    return kept


def _twins(one: JointClass, other: JointClass) -> bool:
    motors = [(id(cls.base), cls.ratio, cls.lends) for cls in (one, other)]
    if _without_gains(one) and _is_wheel(one) != _is_wheel(other):
        return False
    return one.written == other.written and motors[0] == motors[1]


def differing(base: JointClass, cls: JointClass) -> list[str]:
    """Keys of rows in which a joint class differs from the group's own."""
    one, other = base.rows, cls.rows
    keys = dict.fromkeys((*one, *other))
    return [key for key in keys if key not in one or key not in other or one[key].value != other[key].value]


def _takes(
    group: DraftGroup, cls: JointClass, above: Mapping[str, frozenset[str]], order: Mapping[str, int]
) -> bool:
    base = group.classes[0]
    if cls.kind != base.kind or not (one_limb(cls, base, above) or one_row(cls, base)):
        return False
    # A torso and fingers are each in one chain with what is between them, and no limb together.
    if any(_two_limbs(cls.part, other.part) for other in group.classes):
        return False
    keys = differing(base, cls)
    if not set(keys) <= set(cls.rows) or len(keys) + _other_motor(base, cls) > MOST_DIFFERENT:
        return False
    members = sorted([*group.names, *cls.names], key=order.__getitem__)
    return all(len(one_pattern(other.names, members)) <= MOST_PATTERNS for other in (*group.classes[1:], cls))


def _other_motor(base: JointClass, cls: JointClass) -> int:
    """What another motor adds to the fields that differ; more than allowed where an override cannot name one."""
    one, other = (item.base or item for item in (base, cls))
    if one is other:
        return 0
    if one.lends or other.lends:
        # An override names a motor; it cannot say that there is none.
        return 1 if other.lends or other.motor else MOST_DIFFERENT + 1
    values = [{name: row.value for name, row in item.motor.items()} for item in (one, other)]
    if values[0] == values[1]:
        return 0
    return 1 if all(values) else MOST_DIFFERENT + 1


_ONE_MOTOR = SAME_POWER / 4
"""Relative difference up to which two products of effort and speed are one motor's. Chosen: a quarter of what the
audit's GEA101 takes: that asks, this writes it down. The Go2's knees are 0.02 % apart."""


@dataclass(slots=True)
class JointClass:
    """Joints with the same figures.

    Attributes:
        written: All that a spec says of them: equal for classes that were told apart by limb or by limits alone.
        part: Of the body; None: of several, or unknown.
        joints: In the robot's order.
        rows: Key to line, of the first joint; the lines of all have the same values.
        all_rows: The lines of each joint.
        clamps: Joint to its clamp.
        motor: Figures of its motor; empty: none.
        network: Flow mapping; "" without one.
        randomize: (field, flow mapping).
        limits: Torque and speed of the drive [N*m, rad/s], by the source that has both; "" as they are taken.
        base: The class whose motor it has behind more gear; None: its own.
        ratio: Of that gear [-].
        inferred: Why it is taken for the same motor.
        lends: Whether other classes have its motor.
        maybe: Joints that may have another's motor behind more gear, and why.
    """

    written: tuple[object, ...]
    part: str | None
    joints: list[JointActuator]
    rows: dict[str, Row]
    all_rows: list[dict[str, Row]]
    clamps: dict[str, Row | None]
    motor: dict[str, Row]
    network: str
    randomize: tuple[tuple[str, str], ...]
    limits: dict[str, tuple[float, float]]
    base: JointClass | None = None
    ratio: float = 1.0
    inferred: str = ""
    lends: bool = False
    maybe: list[tuple[tuple[str, ...], str]] = field(default_factory=list)

    @property
    def first(self) -> JointActuator:
        """The first joint."""
        return self.joints[0]

    @property
    def names(self) -> list[str]:
        """Names of the joints."""
        return [joint.joint for joint in self.joints]

    @property
    def kind(self) -> tuple[object, ...]:
        """What only a group states: classes that differ in it never share one."""
        first = self.first
        return first.kind, first.level, first.command, self.network, self.randomize

    @property
    def torque(self) -> float | None:
        """What bounds the torque of its joints [N*m or N]; None where no file has a number that bounds it."""
        limit = self.first.effort_limit.value
        return limit if _real(limit) else None

    @property
    def label(self) -> str:
        """The joints, for a message."""
        return listed(self.names, 4)

    def sort(self, order: Mapping[str, int]) -> None:
        """Put the joints into an order."""
        places = sorted(range(len(self.joints)), key=lambda at: order[self.joints[at].joint])
        self.joints = [self.joints[at] for at in places]
        self.all_rows = [self.all_rows[at] for at in places]


def joint_classes_of(joints: Sequence[JointActuator], kinds: Sequence[FileKind]) -> list[JointClass]:
    """Sort joints by limb and by what their lines say.

    Joints with the same lines are told apart where a file has other limits for them, which may give a gear away.

    Args:
        joints: In the robot's order, with keys of `sources` in their quantities.
        kinds: What the files are.
    """
    classes: dict[tuple[object, ...], JointClass] = {}
    parts = parts_of_body(joint.joint for joint in joints)
    speeds = any(j.velocity_limit.span is not None or stated(j.velocity_limit) for j in joints)
    for joint in joints:
        rows, motor = rows_of(joint, kinds, speeds=speeds), motor_of(joint)
        network, ranges, limits = network_of(joint), randomize_of(joint), _limits(joint)
        written = (
            *(joint.kind, joint.level, joint.command, network, ranges),
            tuple((name, row.value) for name, row in rows.items()),
            tuple((name, row.value) for name, row in motor.items()),
        )
        part = parts[joint.joint]
        key = (written, part, tuple(limits.items()))
        cls = classes.get(key)
        if cls is None:
            cls = classes[key] = JointClass(written, part, [], rows, [], {}, motor, network, ranges, limits)
        cls.joints.append(joint)
        cls.all_rows.append(rows)
        cls.clamps[joint.joint] = clamp_of(joint)
    return list(classes.values())


def find_motors(classes: Sequence[JointClass], above: Mapping[str, frozenset[str]]) -> None:
    """Let classes of one limb that have the same power, more torque and less speed share a motor.

    No number changes: a motor with a torque-speed line is shared only where the line behind the reduction is
    that of the file.

    Args:
        classes: Changed in place.
        above: Joint to those between it and the base; empty: the limbs are known by name only.
    """
    for source in dict.fromkeys(source for cls in classes for source in cls.limits):
        known = [cls for cls in classes if source in cls.limits]
        known.sort(key=lambda cls: cls.limits[source][0])
        for index, cls in enumerate(known):
            for base in known[:index]:
                if _same_motor(cls, base, source, above):
                    _share(cls, base, source)
                    break


def joined(classes: Sequence[JointClass]) -> list[JointClass]:
    """Joint classes of a limb with the same lines put together again where one motor, or none, drives them.

    Args:
        classes: With their motors found.
    """
    kept: dict[tuple[object, ...], JointClass] = {}
    for cls in sorted(classes, key=lambda cls: cls.base is not None):
        key = (cls.written, cls.part, id(cls.base), cls.ratio, cls.lends)
        home = kept.setdefault(key, cls)
        if home is not cls:
            join(home, cls, classes)
    return [cls for cls in classes if any(cls is home for home in kept.values())]


def join(home: JointClass, cls: JointClass, classes: Iterable[JointClass]) -> None:
    """Put the joints of a class into another that says the same.

    Args:
        home: Changed in place.
        cls: What goes into it.
        classes: Others; those that have the class's motor have that of `home`.
    """
    home.part = home.part if home.part == cls.part else None
    home.joints += cls.joints
    home.all_rows += cls.all_rows
    home.clamps.update(cls.clamps)
    home.maybe += cls.maybe
    home.lends = home.lends or cls.lends
    for other in classes:
        if other.base is cls:
            other.base = home


def one_limb(cls: JointClass, other: JointClass, above: Mapping[str, frozenset[str]]) -> bool:
    """Whether the joints of two classes are of the same kind of limb.

    Args:
        cls: One.
        other: The other.
        above: As in `find_motors`.
    """
    part, another = cls.part, other.part
    if _two_limbs(part, another):
        return False
    if part is not None and part == another:
        return True
    return all(any(b in above.get(a, ()) or a in above.get(b, ()) for b in other.names) for a in cls.names)


def _two_limbs(part: str | None, another: str | None) -> bool:
    """Whether two parts of a body are different limbs; a wheel at a leg is of the leg."""
    return None not in (part, another) and part != another and {part, another} != {"legs", "wheels"}


def one_row(cls: JointClass, other: JointClass) -> bool:
    """Whether the joints of two classes differ in nothing but a number in their names: joint1 to joint7 of an arm."""
    stems = {re.sub(r"[0-9]+", "0", name) for name in (*cls.names, *other.names)}
    return len(stems) == 1


def _limits(joint: JointActuator) -> dict[str, tuple[float, float]]:
    """Effort limit [N*m] and speed [rad/s] of a hinge, as they are taken and as each file has them.

    A file that does not speak against a figure is taken to have it.
    """
    if joint.kind is not JointKind.HINGE or joint.curve is not None or joint.reflected_inertia.known:
        return {}
    if not _real(joint.effort_limit.value):
        return {}
    taken = joint.stall_torque or joint.effort_limit, joint.no_load_speed or joint.velocity_limit
    both = joint.effort_limit, joint.velocity_limit
    pairs = {"": (taken[0].value, taken[1].value)}
    files = [{q.source: q.value for q in (*one.lost, one) if q.source is not None} for one in both]
    for source in {**files[0], **files[1]}:
        effort, speed = (own.get(source, one.value) for own, one in zip(files, both, strict=True))
        pairs[source] = (effort, speed)
    return {
        source: (effort, speed) for source, (effort, speed) in pairs.items() if _real(effort) and _real(speed)
    }


def _real(limit: float | None) -> TypeGuard[float]:
    return limit is not None and 0.0 < limit < PLACEHOLDER


def _same_motor(cls: JointClass, base: JointClass, source: str, above: Mapping[str, frozenset[str]]) -> bool:
    if cls.base is not None or cls.lends or base.base is not None or cls.maybe:
        return False
    effort, speed = cls.limits[source]
    least, fastest = base.limits[source]
    if effort < LEAST_REDUCTION * least or abs(effort * speed / (least * fastest) - 1.0) > _ONE_MOTOR:
        return False
    return one_limb(cls, base, above)


def _share(cls: JointClass, base: JointClass, source: str) -> None:
    """Give a class the base's motor, or say that it may be one."""
    effort, least = cls.limits[source][0], base.limits[source][0]
    ratio = effort / least
    power = f"{_watts(cls.limits[source])} are the {_watts(base.limits[source])} of {base.names[0]}"
    place = f" in {source}" if source else ""
    if _shares(cls, base, ratio):
        cls.base, cls.ratio, base.lends = base, ratio, True
        cls.inferred = f"inferred: {power} behind {format_number(ratio, 4)} times the gear{place}"
        return
    text = (
        f"the motor of {base.names[0]} behind {format_number(ratio, 4)} times the gear? "
        f"{_watts(cls.limits[source])} are its {_watts(base.limits[source])}{place}"
    )
    cls.maybe.append((tuple(cls.names), text))


def _shares(cls: JointClass, base: JointClass, ratio: float) -> bool:
    """Whether the base's motor behind the ratio has all figures of the class's own motor."""
    if set(cls.motor) != set(base.motor):
        return False
    for name in cls.motor:
        own, other = getattr(cls.first, name).require(), getattr(base.first, name).require()
        other = other / ratio if name == "no_load_speed" else other * ratio
        if not near(own, other, EXACT):
            return False
    return True


def _watts(limits: tuple[float, float]) -> str:
    effort, speed = limits
    return f"{figure(effort, 'N*m', computed=True)} x {figure(speed, 'rad/s', computed=True)}"
