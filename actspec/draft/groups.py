"""Cells of equal joints put into the groups of a spec: what differs little within a limb becomes an override."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from actspec.draft.cells import Cell, cells_of, find_motors, join, joined, one_limb, one_row
from actspec.draft.names import given_name, group_name, joint_patterns, one_pattern
from actspec.draft.rows import Row, same
from actspec.ir import JointActuator
from actspec.readings.artifact import FileKind

MOST_DIFFERENT = 2
"""Fields in which joints of one group may differ. Chosen: a knee has another limit and speed; what differs in more
has a drive of its own, and reads better whole."""

MOST_PATTERNS = 2
"""Patterns that an override may take. Chosen: with more than these a group of its own is shorter."""


@dataclass(slots=True)
class Group:
    """A group of a spec.

    Attributes:
        name: Its key.
        cells: The first is the group's own; the others are overrides of it.
        patterns: Of all its joints.
        motor: Key of its motor; "" without one.
    """

    name: str
    cells: list[Cell]
    patterns: tuple[str, ...] = ()
    motor: str = ""

    @property
    def names(self) -> list[str]:
        """Names of all its joints."""
        return [name for cell in self.cells for name in cell.names]


@dataclass(slots=True)
class Motor:
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
) -> list[Group]:
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
    cells = cells_of(joints, kinds)
    find_motors(cells, above)
    groups = _without_twins(_grouped(joined(cells), above, order), order)
    groups.sort(key=lambda group: min(order[name] for name in group.names))
    given = {joint.joint: joint.group for joint in joints}
    taken: list[str] = []
    for group in groups:
        members = sorted(group.names, key=order.__getitem__)
        own = given_name(members, given, robot)
        group.name = own if own and own not in taken else group_name(members, taken)
        taken.append(group.name)
        group.patterns = joint_patterns(members, names)
    return groups


def motors_of(groups: Sequence[Group]) -> tuple[list[Motor], dict[int, str]]:
    """The motors that groups need, and the motor of each cell by its identity."""
    cells = [cell for group in groups for cell in group.cells]
    users: dict[tuple[object, ...], list[Cell]] = {}
    for cell in cells:
        lender = cell.base or cell
        if lender.motor or lender.lends:
            # Two inferred motors are never one: nobody says so.
            figures = tuple((name, row.value) for name, row in lender.motor.items()) or (id(lender),)
            users.setdefault(figures, []).append(cell)
    motors: list[Motor] = []
    named: dict[int, str] = {}
    for own in users.values():
        lender = own[0].base or own[0]
        rows = lender.motor or {"peak_torque": lender.rows["effort_limit"]}
        name = _motor_name(own, groups, [motor.name for motor in motors])
        motors.append(Motor(name, rows, not lender.motor))
        named.update({id(cell): name for cell in own})
    for group in groups:
        group.motor = named.get(id(group.cells[0]), "")
    return motors, named


def _motor_name(users: Sequence[Cell], groups: Sequence[Group], taken: Sequence[str]) -> str:
    """After the group whose joints it drives, else after those joints."""
    home = next(group for group in groups if any(cell is users[0] for cell in group.cells))
    alone = all(any(cell is user for user in users) for cell in home.cells)
    stem = home.name if alone else group_name([name for cell in users for name in cell.names], ())
    name = f"{stem}_motor"
    while name in taken:
        name += "_2"
    return name


def _grouped(
    cells: Sequence[Cell], above: Mapping[str, frozenset[str]], order: Mapping[str, int]
) -> list[Group]:
    """Put cells into groups: the largest first, what differs little within a limb as its override."""
    for cell in cells:
        cell.sort(order)
    groups: list[Group] = []
    for cell in sorted(cells, key=lambda cell: -len(cell.joints)):
        home = next((group for group in groups if _takes(group, cell, above, order)), None)
        if home is None:
            groups.append(Group("", [cell]))
        elif _twins(home.cells[0], cell):
            join(home.cells[0], cell, cells)
            home.cells[0].sort(order)
        else:
            home.cells.append(cell)
    return groups


def _without_twins(groups: Sequence[Group], order: Mapping[str, int]) -> list[Group]:
    """Groups of equal joints that no override has joined, as one."""
    kept: list[Group] = []
    every = [cell for group in groups for cell in group.cells]
    for group in groups:
        cell = group.cells[0]
        twin = next((other for other in kept if len(other.cells) == 1 and _twins(other.cells[0], cell)), None)
        if twin is None or len(group.cells) > 1:
            kept.append(group)
        else:
            join(twin.cells[0], cell, every)
            twin.cells[0].sort(order)
    return kept


def _twins(one: Cell, other: Cell) -> bool:
    motors = [(id(cell.base), cell.ratio, cell.lends) for cell in (one, other)]
    return one.written == other.written and motors[0] == motors[1]


def differing(base: Cell, cell: Cell) -> list[str]:
    """Keys of rows in which a cell differs from the group's own."""
    return list(same(base.rows, cell.rows))


def _takes(group: Group, cell: Cell, above: Mapping[str, frozenset[str]], order: Mapping[str, int]) -> bool:
    base = group.cells[0]
    if cell.kind != base.kind or not (one_limb(cell, base, above) or one_row(cell, base)):
        return False
    keys = differing(base, cell)
    if not set(keys) <= set(cell.rows) or len(keys) + _other_motor(base, cell) > MOST_DIFFERENT:
        return False
    members = sorted([*group.names, *cell.names], key=order.__getitem__)
    return all(len(one_pattern(other.names, members)) <= MOST_PATTERNS for other in (*group.cells[1:], cell))


def _other_motor(base: Cell, cell: Cell) -> int:
    """What another motor adds to the fields that differ; more than allowed where an override cannot name one."""
    one, other = (item.base or item for item in (base, cell))
    if one is other:
        return 0
    if one.lends or other.lends:
        # An override names a motor; it cannot say that there is none.
        return 1 if other.lends or other.motor else MOST_DIFFERENT + 1
    values = [{name: row.value for name, row in item.motor.items()} for item in (one, other)]
    if values[0] == values[1]:
        return 0
    return 1 if all(values) else MOST_DIFFERENT + 1
