"""Joints with the same figures, and which of them have one motor behind different gears."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from actspec.audit.artifact import FileKind
from actspec.audit.rules.reductions import LEAST
from actspec.draft.names import body_part
from actspec.draft.rows import Row, clamp_of, motor_of, network_of, randomize_of, rows_of
from actspec.draft.values import figure
from actspec.ir import JointActuator, JointKind

SAME_POWER = 0.005
"""Relative difference up to which two products of effort and speed are one motor's. Chosen: a quarter of what the
audit's GEA101 takes (`reductions.SAME_POWER`): that asks, this writes it down. The Go2's knees are 0.02 % apart."""

_EXACT = 1e-9
"""Relative difference up to which a line behind a reduction is the file's own."""


@dataclass(slots=True)
class Cell:
    """Joints with the same figures.

    Attributes:
        joints: In the robot's order.
        rows: Key to line, of the first joint; the lines of all have the same values.
        all_rows: The lines of each joint.
        clamps: Joint to its clamp.
        motor: Figures of its motor; empty: none.
        network: Flow mapping; "" without one.
        randomize: (field, flow mapping).
        base: The cell whose motor it has behind more gear; None: its own.
        ratio: Of that gear [-].
        inferred: Why it is taken for the same motor.
    """

    joints: list[JointActuator]
    rows: dict[str, Row]
    all_rows: list[dict[str, Row]]
    clamps: dict[str, Row | None]
    motor: dict[str, Row]
    network: str
    randomize: tuple[tuple[str, str], ...]
    base: Cell | None = None
    ratio: float = 1.0
    inferred: str = ""
    maybe: str = field(default="")

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


def cells_of(joints: Sequence[JointActuator], kinds: Sequence[FileKind]) -> list[Cell]:
    """Sort joints by what their lines say.

    Args:
        joints: In the robot's order, with keys of `sources` in their quantities.
        kinds: What the files are.
    """
    cells: dict[tuple[object, ...], Cell] = {}
    for joint in joints:
        rows, motor = rows_of(joint, kinds), motor_of(joint)
        network, ranges = network_of(joint), randomize_of(joint)
        key = (
            *(joint.kind, joint.level, joint.command, network, ranges),
            tuple((name, row.value) for name, row in rows.items()),
            tuple((name, row.value) for name, row in motor.items()),
        )
        cell = cells.get(key)
        if cell is None:
            cell = cells[key] = Cell([], rows, [], {}, motor, network, ranges)
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
    limits = [(cell, found) for cell in cells if (found := _limits(cell)) is not None]
    limits.sort(key=lambda entry: entry[1][0])
    for index, (cell, (effort, speed)) in enumerate(limits):
        for base, (least, fastest) in limits[:index]:
            ratio = effort / least
            if base.base is not None or ratio < LEAST:
                continue
            if abs(effort * speed / (least * fastest) - 1.0) > SAME_POWER or not one_limb(cell, base, above):
                continue
            told = (
                f"inferred: {_watts(effort, speed)} are the {_watts(least, fastest)} of "
                f"{base.names[0]} behind {ratio:.4g} times the gear"
            )
            if _shares(cell, base, ratio):
                cell.base, cell.ratio, cell.inferred = base, ratio, told
            else:
                cell.maybe = told.replace("inferred: ", "one motor? ")
            break


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


def _limits(cell: Cell) -> tuple[float, float] | None:
    """Effort limit [N*m] and speed [rad/s] of a hinge's cell; None where a file lacks one."""
    first = cell.first
    effort = first.stall_torque or first.effort_limit
    speed = first.no_load_speed or first.velocity_limit
    if first.kind is not JointKind.HINGE or first.curve is not None or "reflected_inertia" in cell.motor:
        return None
    if not effort.value or not speed.value or "unknown" in (cell.rows["effort_limit"].value,):
        return None
    return (effort.value, speed.value) if 0.0 < effort.value < 1e5 and 0.0 < speed.value < 1e5 else None


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


def _watts(effort: float, speed: float) -> str:
    return f"{figure(effort, 'N*m', computed=True)} x {figure(speed, 'rad/s', computed=True)}"
