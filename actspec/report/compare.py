"""Joint by source by field: every value that files give for one robot, and how far apart they are."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from actspec.audit.case import Case
from actspec.audit.ledger import LedgerRow
from actspec.readings.artifact import Artifact
from actspec.report.columns import COLUMNS, Column, cell, number

SAME = 1.005
"""A ratio up to here is rounding. Chosen: files write three digits."""

COMPARED = tuple(
    column
    for column in COLUMNS
    if column.field
    in (
        "kp",
        "kd",
        "joint_damping",
        "total_damping",
        "frictionloss",
        "effort_limit",
        "velocity_limit",
        "armature",
        "action_scale",
        "default_position",
    )
)
"""What files can state; what is computed from a model alone is not compared."""


@dataclass(frozen=True, slots=True)
class Line:
    """One field of joints that have the same values in every source.

    Attributes:
        joints: Their names.
        column: The field.
        unit: Of the values.
        values: One a source; None is unknown.
        ratio: Largest over smallest magnitude; None when fewer than two are known; inf beside 0 or no limit.
    """

    joints: tuple[str, ...]
    column: Column
    unit: str
    values: tuple[float | None, ...]
    ratio: float | None

    @property
    def differs(self) -> bool:
        """Whether sources disagree."""
        return self.ratio is not None and self.ratio > SAME

    @property
    def shown_ratio(self) -> str:
        """The ratio for people."""
        return cell(self.ratio)


@dataclass(frozen=True, slots=True)
class Comparison:
    """One robot.

    Attributes:
        robot: Its name.
        sources: Its artifacts, as headings.
        lines: By field, then by joint.
    """

    robot: str
    sources: tuple[str, ...]
    lines: tuple[Line, ...]


def comparisons(case: Case) -> Iterator[Comparison]:
    """Robots that more than one source describes."""
    for robot in case.robots:
        if len(robot.artifacts) > 1:
            sources = tuple(_title(case.artifacts[index]) for index in robot.artifacts)
            lines = tuple(_lines([case.rows_of(index) for index in robot.artifacts]))
            if lines:
                yield Comparison(robot.name, sources, lines)


def _title(artifact: Artifact) -> str:
    named = artifact.config is not None and artifact.name not in ("", artifact.path)
    return f"{artifact.path} ({artifact.name})" if named else artifact.path


def _lines(sources: Sequence[Sequence[LedgerRow]]) -> Iterator[Line]:
    joints = dict.fromkeys(row.joint for rows in sources for row in rows if row.joint)
    for column in COMPARED:
        merged: dict[tuple[str, tuple[float | None, ...]], list[str]] = {}
        for joint in joints:
            own = [[row for row in rows if row.joint == joint] for rows in sources]
            values = tuple(_value(rows, column) for rows in own)
            if sum(value is not None for value in values) > 1:
                kind = next((row.kind for rows in own for row in rows if row.kind is not None), None)
                merged.setdefault((column.unit(kind), values), []).append(joint)
        for (unit, values), names in merged.items():
            yield Line(tuple(names), column, unit, values, _ratio(values))


def _value(rows: Sequence[LedgerRow], column: Column) -> float | None:
    """Of a joint in one source; of several actuators the first that says.

    A joint without actuator leaves its limit, and the passive figures that it does not state, to whoever drives
    it; it and a motor leave the gains to a controller outside of the file, which is not a gain of 0.
    """
    return next((value for row in rows if (value := _said(row, column)) is not None), None)


def _said(row: LedgerRow, column: Column) -> float | None:
    value = number(row, column)
    if column.field in ("kp", "kd", "total_damping") and row.control in ("none", "motor"):
        return None
    bare = row.control == "none" and column.field not in row.stated
    return None if bare and value in (0.0, math.inf) else value


def _ratio(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    sizes = [abs(value) for value in known]
    if len(known) < 2:
        return None
    if max(known) == min(known):
        return 1.0
    if min(known) < 0.0 < max(known) or min(sizes) == 0.0 or math.isinf(max(sizes)):
        return math.inf
    return max(sizes) / min(sizes)
