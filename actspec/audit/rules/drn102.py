from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.drawn import rows_in
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.randomized import FIELDS, about_range, ends, nominal, ranges, written
from actspec.readings.artifact import RandomizedRange
from actspec.readings.ledger import LedgerRow

_Subject = tuple[RandomizedRange, LedgerRow, float]

_WRITTEN = {
    "armature": frozenset({"actuators", "armatures"}),
    "friction": frozenset({"actuators", "friction"}),
    "joint_damping": frozenset({"damping"}),
    "effort_limit": frozenset({"actuators", "efforts"}),
}
"""By a range's field, what programs write over that put another figure than 0 there (`readings/written_over.py`)."""


class ScalesZero(RuleOver[_Subject]):
    code = "DRN102"
    name = "range-scales-a-zero"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    written_over = frozenset({"draws"})
    paired = True
    needs = "no configuration randomises a value that it states"

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for index, config, one in ranges(case):
            for row in rows_in(case, index, one):
                value = nominal(case, config, row, one)
                if value is not None:
                    yield one, row, value

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        one, row, value = subject
        if value == 0.0 and one.operation == "scale":
            yield Finding(
                self.code,
                f"{one.field} is scaled by {written(*ends(one))} and is 0: nothing is randomised",
                one.span,
                row.joint,
                help="give it a value, or randomise by add",
                related=(row.span,),
                # A drive by torque or by speed has no such gain.
                severity=Severity.INFO if one.field in ("kp", "kd") else None,
                noted_in_folders=not _WRITTEN.get(one.field, frozenset()).isdisjoint(
                    case.written(row.place(FIELDS[one.field]), row.joint)
                ),
                about=about_range(one),
            )
