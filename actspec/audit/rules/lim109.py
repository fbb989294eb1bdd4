from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import by_joint, is_nobodys, partner_rows, shown
from actspec.readings.artifact import FileKind, Framework
from actspec.readings.ledger import LedgerRow


class SetpointsClipped(RuleOver[list["_Clipped"]]):
    code = "LIM109"
    name = "command-range-clips-torque"
    severity = Severity.INFO
    confidence = Confidence.MEDIUM
    needs = "no MJCF with a limited position servo and a control range among the files"
    options: ClassVar[dict[str, float]] = {"share": 0.5}

    def subjects(self, case: Case) -> Iterable[list[_Clipped]]:
        found: dict[int, list[_Clipped]] = {}
        for (index, _), rows in by_joint(case, FileKind.MJCF).items():
            row = rows[0]
            command, joint, limit, kp = row.command_range, row.position_range, row.effort_limit, row.kp
            if len(rows) > 1 or row.control != "position" or command is None or joint is None:
                continue
            if limit is None or kp is None or not 0.0 < limit < math.inf or kp <= 0.0:
                continue
            clipped = found.setdefault(index, [])
            span = joint[1] - joint[0]
            inside = command[0] >= joint[0] - _FITS * span and command[1] <= joint[1] + _FITS * span
            one = _Clipped(row, command, limit, limit / kp, span)
            nobodys = is_nobodys(row, "effort_limit")
            if (
                inside
                and not nobodys
                and one.reach >= self.option(case, "share") * span
                and not _driven_elsewhere(case, row)
            ):
                clipped.append(one)
        return found.values()

    def judge(self, case: Case, clipped: list[_Clipped]) -> Iterator[Finding]:
        """One finding a file, at the softest servo."""
        if clipped:
            worst = max(clipped, key=lambda one: one.reach / one.span)
            row = worst.row
            low, high = (shown(row, "default_position", end) for end in worst.command)
            yield Finding(
                self.code,
                f"{len(clipped)} soft {'servo has' if len(clipped) == 1 else 'servos have'} no targets beyond the "
                f"range of the joint. {row.joint}, the softest, has {low} ... {high}, and needs targets "
                f"{shown(row, 'default_position', worst.reach)} from the joint for its "
                f"{shown(row, 'effort_limit', worst.limit, 4)}: nearer to an end it has less towards it, at the end "
                "nothing",
                row.place("command_range"),
                help="let targets go beyond the range by effort limit / kp on each side, or leave the clip out",
                about=f"{row.joint} {low} {high}",
            )


@dataclass(frozen=True, slots=True)
class _Clipped:
    """A servo whose targets end with its joint's range.

    Attributes:
        row: Its row.
        command: Range of its targets [rad or m].
        limit: Effort limit [N*m or N].
        reach: Distance from target to joint that gives the full torque [rad or m].
        span: Length of the joint's range [rad or m].
    """

    row: LedgerRow
    command: tuple[float, float]
    limit: float
    reach: float
    span: float


_FITS = 0.02
"""Share of the range by which a control range may exceed it and still end with it. Chosen: rounding of the figures."""


def _driven_elsewhere(case: Case, row: LedgerRow) -> bool:
    """Whether a configuration's own drive stands in for the file's servo."""
    for other in partner_rows(case, row, FileKind.CFG):
        config = case.artifacts[other.artifact].config
        if config is not None and config.framework is Framework.MJLAB and "kp" in other.stated:
            return True
    return False
