"""Joints with the same figures, and which of them have one motor behind different gears."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeGuard

from actspec.diagnostics import listed
from actspec.draft.names import body_part
from actspec.draft.rows import Row, clamp_of, motor_of, network_of, randomize_of, rows_of
from actspec.draft.sources import stated
from actspec.draft.text import figure
from actspec.ir import JointActuator, JointKind
from actspec.readings.artifact import FileKind
from actspec.readings.compare import LEAST_REDUCTION

SAME_POWER = 0.005
"""Relative difference up to which two products of effort and speed are one motor's. Chosen: a quarter of what the
audit's GEA101 takes (`reductions.SAME_POWER`): that asks, this writes it down. The Go2's knees are 0.02 % apart."""

_EXACT = 1e-9
"""Relative difference up to which a line behind a reduction is the file's own."""

_PLACEHOLDER = 1e5
"""Limit from which on it is nobody's number [SI]. Chosen: as the audit's rules have it."""


@dataclass(slots=True)
class Cell:
    """Joints with the same figures.

    Attributes:
        written: All that a spec says of them: equal for cells that were told apart by limb or by limits alone.
        joints: In the robot's order.
        rows: Key to line, of the first joint; the lines of all have the same values.
        all_rows: The lines of each joint.
        clamps: Joint to its clamp.
        motor: Figures of its motor; empty: none.
        network: Flow mapping; "" without one.
        randomize: (field, flow mapping).
        limits: Torque and speed of the drive [N*m, rad/s], by the source that has both; "" as they are taken.
        base: The cell whose motor it has behind more gear; None: its own.
        ratio: Of that gear [-].
        inferred: Why it is taken for the same motor.
        lends: Whether other cells have its motor.
        maybe: Joints that may have another's motor behind more gear, and why.
    """

    written: tuple[object, ...]
    joints: list[JointActuator]
    rows: dict[str, Row]
    all_rows: list[dict[str, Row]]
    clamps: dict[str, Row | None]
    motor: dict[str, Row]
    network: str
    randomize: tuple[tuple[str, str], ...]
    limits: dict[str, tuple[float, float]]
    base: Cell | None = None
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
        """What only a group states: cells that differ in it never share one."""
        first = self.first
        return first.kind, first.level, first.command, self.network, self.randomize

    @property
    def label(self) -> str:
        """The joints, for a message."""
        return listed(self.names, 4)

    def sort(self, order: Mapping[str, int]) -> None:
        """Put the joints into an order."""
        places = sorted(range(len(self.joints)), key=lambda at: order[self.joints[at].joint])
        self.joints = [self.joints[at] for at in places]
        self.all_rows = [self.all_rows[at] for at in places]


def cells_of(joints: Sequence[JointActuator], kinds: Sequence[FileKind]) -> list[Cell]:
    """Sort joints by limb and by what their lines say.

    Joints with the same lines are told apart where a file has other limits for them, which may give a gear away.

    Args:
        joints: In the robot's order, with keys of `sources` in their quantities.
        kinds: What the files are.
    """
    cells: dict[tuple[object, ...], Cell] = {}
    speeds = any(j.velocity_limit.span is not None or stated(j.velocity_limit) for j in joints)
    for joint in joints:
        rows, motor = rows_of(joint, kinds, speeds=speeds), motor_of(joint)
        network, ranges, limits = network_of(joint), randomize_of(joint), _limits(joint)
        written = (
            *(joint.kind, joint.level, joint.command, network, ranges),
            tuple((name, row.value) for name, row in rows.items()),
            tuple((name, row.value) for name, row in motor.items()),
        )
        key = (written, body_part([joint.joint]), tuple(limits.items()))
        cell = cells.get(key)
        if cell is None:
            cell = cells[key] = Cell(written, [], rows, [], {}, motor, network, ranges, limits)
        cell.joints.append(joint)
        cell.all_rows.append(rows)
        cell.clamps[joint.joint] = clamp_of(joint)
    return list(cells.values())


def find_motors(cells: Sequence[Cell], above: Mapping[str, frozenset[str]]) -> None:
    """Let cells of one limb that have the same power, more torque and less speed share a motor.

    No number changes: a motor with a torque-speed line is shared only where the line behind the reduction is
    that of the file.

    Args:
        cells: Changed in place.
        above: Joint to those between it and the base; empty: the limbs are known by name only.
    """
    for source in dict.fromkeys(source for cell in cells for source in cell.limits):
        known = [cell for cell in cells if source in cell.limits]
        known.sort(key=lambda cell: cell.limits[source][0])
        for index, cell in enumerate(known):
            for base in known[:index]:
                if _same_motor(cell, base, source, above):
                    _share(cell, base, source)
                    break


def joined(cells: Sequence[Cell]) -> list[Cell]:
    """Cells of a limb with the same lines put together again where one motor, or none, drives them.

    Args:
        cells: With their motors found.
    """
    kept: dict[tuple[object, ...], Cell] = {}
    for cell in sorted(cells, key=lambda cell: cell.base is not None):
        key = (cell.written, body_part(cell.names), id(cell.base), cell.ratio, cell.lends)
        home = kept.setdefault(key, cell)
        if home is not cell:
            join(home, cell, cells)
    return [cell for cell in cells if any(cell is home for home in kept.values())]


def join(home: Cell, cell: Cell, cells: Iterable[Cell]) -> None:
    """Put the joints of a cell into another that says the same.

    Args:
        home: Changed in place.
        cell: What goes into it.
        cells: Others; those that have the cell's motor have that of `home`.
    """
    home.joints += cell.joints
    home.all_rows += cell.all_rows
    home.clamps.update(cell.clamps)
    home.maybe += cell.maybe
    home.lends = home.lends or cell.lends
    for other in cells:
        if other.base is cell:
            other.base = home


def one_limb(cell: Cell, other: Cell, above: Mapping[str, frozenset[str]]) -> bool:
    """Whether the joints of two cells are of the same kind of limb.

    Args:
        cell: One.
        other: The other.
        above: As in `find_motors`.
    """
    parts = body_part(cell.names), body_part(other.names)
    if None not in parts:
        return parts[0] == parts[1]
    return all(any(b in above.get(a, ()) or a in above.get(b, ()) for b in other.names) for a in cell.names)


def one_row(cell: Cell, other: Cell) -> bool:
    """Whether the joints of two cells differ in nothing but a number in their names: joint1 to joint7 of an arm."""
    stems = {re.sub(r"[0-9]+", "0", name) for name in (*cell.names, *other.names)}
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
    return limit is not None and 0.0 < limit < _PLACEHOLDER


def _same_motor(cell: Cell, base: Cell, source: str, above: Mapping[str, frozenset[str]]) -> bool:
    if cell.base is not None or cell.lends or base.base is not None or cell.maybe:
        return False
    effort, speed = cell.limits[source]
    least, fastest = base.limits[source]
    if effort < LEAST_REDUCTION * least or abs(effort * speed / (least * fastest) - 1.0) > SAME_POWER:
        return False
    return one_limb(cell, base, above)


def _share(cell: Cell, base: Cell, source: str) -> None:
    """Give a cell the base's motor, or say that it may be one."""
    effort, least = cell.limits[source][0], base.limits[source][0]
    ratio = effort / least
    power = f"{_watts(cell.limits[source])} are the {_watts(base.limits[source])} of {base.names[0]}"
    place = f" in {source}" if source else ""
    if _shares(cell, base, ratio):
        cell.base, cell.ratio, base.lends = base, ratio, True
        cell.inferred = f"inferred: {power} behind {ratio:.4g} times the gear{place}"
        return
    text = (
        f"the motor of {base.names[0]} behind {ratio:.4g} times the gear? {_watts(cell.limits[source])} are its "
        f"{_watts(base.limits[source])}{place}"
    )
    cell.maybe.append((tuple(cell.names), text))


def _shares(cell: Cell, base: Cell, ratio: float) -> bool:
    """Whether the base's motor behind the ratio has all figures of the cell's own motor."""
    if set(cell.motor) != set(base.motor):
        return False
    for name in cell.motor:
        own, other = getattr(cell.first, name).require(), getattr(base.first, name).require()
        other = other / ratio if name == "no_load_speed" else other * ratio
        if abs(own - other) > _EXACT * abs(own):
            return False
    return True


def _watts(limits: tuple[float, float]) -> str:
    effort, speed = limits
    return f"{figure(effort, 'N*m', computed=True)} x {figure(speed, 'rad/s', computed=True)}"
