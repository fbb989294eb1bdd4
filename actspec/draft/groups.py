"""Cells of equal joints put into the groups of a spec: what differs little within a limb becomes an override."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from actspec.draft.cells import Cell, one_limb
from actspec.draft.names import group_name, joint_patterns
from actspec.draft.rows import Row, same

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
    cells: Sequence[Cell], above: Mapping[str, frozenset[str]], names: Sequence[str]
) -> list[Group]:
    """Put cells into groups, each with its name and patterns.

    Args:
        cells: With their motors found.
        above: Joint to those between it and the base.
        names: All joints that patterns are matched against, in the robot's order.

    Raises:
        PatternError: a joint's name is too long.
    """
    order = {name: place for place, name in enumerate(names)}
    groups: list[Group] = []
    for cell in sorted(cells, key=lambda cell: -len(cell.joints)):
        home = next((group for group in groups if _takes(group, cell, above, order)), None)
        if home is None:
            groups.append(Group("", [cell]))
        else:
            home.cells.append(cell)
    groups.sort(key=lambda group: min(order[name] for name in group.names))
    taken: list[str] = []
    for group in groups:
        members = sorted(group.names, key=order.__getitem__)
        group.name = group_name(members, taken)
        taken.append(group.name)
        group.patterns = joint_patterns(members, names)
    return groups


def motors_of(groups: Sequence[Group]) -> tuple[list[Motor], dict[int, str]]:
    """The motors that groups need, and the motor of each cell by its identity."""
    motors: dict[tuple[tuple[str, str], ...], Motor] = {}
    named: dict[int, str] = {}
    cells = [(group, cell) for group in groups for cell in group.cells]
    bases = {id(cell.base) for _, cell in cells if cell.base is not None}
    for group, cell in cells:
        rows = cell.motor
        inferred = not rows and id(cell) in bases
        if inferred:
            rows = {"peak_torque": cell.rows["effort_limit"]}
        if not rows or cell.base is not None:
            continue
        # Two inferred motors are never one: nobody says so.
        key = (
            *((name, row.value) for name, row in rows.items()),
            *([("", str(id(cell)))] if inferred else []),
        )
        if key not in motors:
            name = f"{group.name}_motor"
            while name in {motor.name for motor in motors.values()}:
                name += "_2"
            motors[key] = Motor(name, rows, inferred)
        named[id(cell)] = motors[key].name
    for _, cell in cells:
        if cell.base is not None:
            named[id(cell)] = named[id(cell.base)]
    for group in groups:
        group.motor = named.get(id(group.cells[0]), "")
    return list(motors.values()), named


def differing(base: Cell, cell: Cell) -> list[str]:
    """Keys of rows in which a cell differs from the group's own."""
    return list(same(base.rows, cell.rows))


def _takes(group: Group, cell: Cell, above: Mapping[str, frozenset[str]], order: Mapping[str, int]) -> bool:
    base = group.cells[0]
    if cell.kind != base.kind or not one_limb(cell, base, above):
        return False
    keys = differing(base, cell)
    if not set(keys) <= set(cell.rows) or len(keys) + _other_motor(base, cell) > MOST_DIFFERENT:
        return False
    members = sorted([*group.names, *cell.names], key=order.__getitem__)
    patterns = joint_patterns(cell.names, members)
    return len(patterns) <= MOST_PATTERNS and _patterns_stay(group, members)


def _other_motor(base: Cell, cell: Cell) -> int:
    """What another motor adds to the fields that differ; more than allowed where an override cannot name one."""
    one, other = (item.base or item for item in (base, cell))
    if one is other:
        return 0
    values = [{name: row.value for name, row in item.motor.items()} for item in (one, other)]
    if values[0] == values[1]:
        return 0
    return 1 if all(values) else MOST_DIFFERENT + 1


def _patterns_stay(group: Group, members: Sequence[str]) -> bool:
    """Whether the overrides that a group has still take few patterns among more joints."""
    return all(len(joint_patterns(cell.names, members)) <= MOST_PATTERNS for cell in group.cells[1:])
