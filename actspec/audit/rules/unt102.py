from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import by_joint, partner_rows, shown
from actspec.audit.rules.unt101 import is_degrees_of
from actspec.diagnostics import Span
from actspec.ir import JointKind
from actspec.readings.artifact import FileKind
from actspec.readings.ledger import LedgerRow
from actspec.units import format_number


class TorqueAsTarget(RuleOver[tuple[LedgerRow, tuple[float, float]]]):
    code = "UNT102"
    name = "torque-left-in-command-range"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    noted_in_folders = True
    paired = True
    needs = "no MJCF with a position servo and a control range among the files"
    options: ClassVar[dict[str, float]] = {"least": 3.2}

    def subjects(self, case: Case) -> Iterator[tuple[LedgerRow, tuple[float, float]]]:
        for rows in by_joint(case, FileKind.MJCF).values():
            for row in rows:
                command = row.command_range
                if row.control != "position" or command is None or row.kind is not JointKind.HINGE:
                    continue
                yield row, command

    def judge(self, case: Case, subject: tuple[LedgerRow, tuple[float, float]]) -> Iterator[Finding]:
        """Compare control ranges of servos with torque limits."""
        row, command = subject
        high = command[1]
        if not math.isclose(-command[0], high, rel_tol=1e-6) or high < self.option(case, "least"):
            return
        own = row.position_range
        # In degrees or radians as it is written: whichever is meant, it is a range of the joint (UNT101).
        if own is not None and (
            math.isclose(own[1], high, rel_tol=0.02)
            or is_degrees_of(command, own)
            or is_degrees_of(own, command)
        ):
            return
        limit = self._place(case, row, high)
        if limit is not None:
            yield Finding(
                self.code,
                f"the control range of this position servo, +-{format_number(high, 4)} rad, is its torque limit of "
                f"{shown(row, 'effort_limit', high)}: a position was meant",
                row.place("command_range"),
                row.joint,
                high,
                "rad",
                help="leave ctrlrange out, or set it to the joint's range and effort limit / kp beyond",
                related=() if limit == row.place("command_range") else (limit,),
            )

    def _place(self, case: Case, row: LedgerRow, limit: float) -> Span | None:
        """Where the same number stands as a torque limit."""
        for one in (row, *partner_rows(case, row)):
            if one.effort_limit is not None and math.isclose(one.effort_limit, limit, rel_tol=1e-3):
                return one.place("effort_limit")
        return None
