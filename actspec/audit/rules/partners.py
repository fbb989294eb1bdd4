"""Rows of the same joint in the other files of the same robot."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

from actspec.audit.artifact import FileKind
from actspec.audit.case import Case
from actspec.audit.ledger import LedgerRow


def partner_rows(case: Case, row: LedgerRow, *kinds: FileKind) -> Iterator[LedgerRow]:
    """Rows of the row's joint in other artifacts of its robot.

    Args:
        case: The case.
        row: Of one artifact.
        kinds: Only of artifacts of these kinds; none: of all.
    """
    for other in case.robot_of(row.artifact).artifacts:
        if other != row.artifact and (not kinds or case.artifacts[other].kind in kinds):
            yield from (found for found in case.rows_of(other) if found.joint == row.joint)


def by_joint(case: Case, *kinds: FileKind) -> dict[tuple[int, str], list[LedgerRow]]:
    """Rows of each joint of each artifact, in their order; rows without a joint are left out.

    Args:
        case: The case.
        kinds: Only of artifacts of these kinds; none: of all.
    """
    found: dict[tuple[int, str], list[LedgerRow]] = {}
    for row in case.rows:
        if row.joint and (not kinds or case.artifacts[row.artifact].kind in kinds):
            found.setdefault((row.artifact, row.joint), []).append(row)
    return found


def joint_pairs(case: Case) -> Iterator[tuple[LedgerRow, LedgerRow]]:
    """The first row of each joint in each two artifacts of one robot, every pair once, in the files' order."""
    rows = {key: found[0] for key, found in by_joint(case).items()}
    joints: dict[int, list[str]] = {}
    for artifact, joint in rows:
        joints.setdefault(artifact, []).append(joint)
    for robot in case.robots:
        for one, other in combinations(robot.artifacts, 2):
            for joint in joints.get(one, ()):
                if (other, joint) in rows:
                    yield rows[one, joint], rows[other, joint]
