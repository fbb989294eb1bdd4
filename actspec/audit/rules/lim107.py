from __future__ import annotations

import math
from collections.abc import Iterator

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import is_nobodys, own_figure, shown, unit
from actspec.readings.artifact import FileKind
from actspec.readings.ledger import LedgerRow

_Subject = tuple[LedgerRow, float, float]


class LineBelowLimit(RuleOver[_Subject]):
    code = "LIM107"
    name = "saturation-below-limit"
    noted_in_folders = True
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    needs = "no drive with both a torque-speed line and an effort limit among the files"

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for row in case.rows:
            stall, limit = row.stall_torque, row.effort_limit
            if stall is None or limit is None or case.artifacts[row.artifact].kind is FileKind.SPEC:
                continue
            yield row, stall, limit

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Compare stall torque and limit."""
        row, stall, limit = subject
        nobodys = limit == math.inf or is_nobodys(row, "effort_limit")
        if stall < limit and not nobodys and not math.isclose(stall, limit, rel_tol=1e-3):
            yield Finding(
                self.code,
                f"the effort limit of {own_figure(row, 'effort_limit')} is never reached by what drives the joint: "
                f"the torque-speed line begins at {shown(row, 'effort_limit', stall)}, at standstill",
                row.place("stall_torque"),
                row.joint,
                stall,
                unit(row, "effort_limit"),
                help="the stall torque is the larger figure, the continuous limit the smaller one",
                related=(row.place("effort_limit"),),
                fields=("stall_torque",),
            )
