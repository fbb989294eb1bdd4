"""The damping of one joint of an MJCF, by where it comes from."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from actspec.audit.case import Case
from actspec.audit.rules.joints import partner_rows
from actspec.readings.artifact import FileKind
from actspec.readings.ledger import LedgerRow

INTENT = (FileKind.CFG, FileKind.SPEC)

SAME = 0.05
"""Relative difference up to which two figures are taken for one. Chosen: rounding of published gains."""

THIRD = 0.1
"""Least share of the total for a part to count as one of three. Chosen: as DMP101's `share`."""


@dataclass(frozen=True, slots=True)
class Parts:
    """The damping of one joint by origin, all its drives together [N*m*s/rad or N*s/m].

    Attributes:
        kd: Of the drives.
        joint: Of the joint.
        actuator: At the actuators (MuJoCo 3.7 and later), gear squared.
    """

    kd: float
    joint: float
    actuator: float

    @property
    def passive(self) -> float:
        """What no torque limit clamps."""
        return self.joint + self.actuator

    @property
    def total(self) -> float:
        """What the joint gets."""
        return self.kd + self.passive

    @property
    def in_three_places(self) -> bool:
        """Whether each of the three counts."""
        return min(self.kd, self.joint, self.actuator) >= THIRD * self.total > 0.0


def parts_by_joint(case: Case) -> dict[tuple[int, str], Parts | None]:
    """The parts of each joint of each artifact, as in `Case.joints`; None when one is unknown or negative."""
    return {key: _parts_of(rows) for key, rows in case.joints.items()}


def _parts_of(rows: Sequence[LedgerRow]) -> Parts | None:
    joint = rows[0].joint_damping
    if joint is None or joint < 0.0:
        return None
    kd = actuator = 0.0
    for row in rows:
        if row.kd is None or row.actuator_damping is None or row.kd < 0.0 or row.actuator_damping < 0.0:
            return None
        kd += row.kd
        actuator += row.actuator_damping
    return Parts(kd, joint, actuator)


def same(one: float, other: float) -> bool:
    """Whether two figures are one, but for rounding."""
    return math.isclose(one, other, rel_tol=SAME)


def first_rows(case: Case, row: LedgerRow, *kinds: FileKind) -> Iterator[LedgerRow]:
    """Rows of the same joint in the robot's other files, one each file."""
    seen = set()
    for other in partner_rows(case, row, *kinds):
        if other.artifact not in seen:
            seen.add(other.artifact)
            yield other
