from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding
from actspec.audit.rule import RuleOver
from actspec.audit.rules.joint_units import shown, unit
from actspec.diagnostics import Severity
from actspec.readings.ledger import LedgerRow

_Subject = tuple[LedgerRow, str, float]


class PlaceholderLimit(RuleOver[_Subject]):
    code = "LIM102"
    name = "limit-is-a-placeholder"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    needs = "no file states an effort or velocity limit"
    options: ClassVar[dict[str, float]] = {"least": 1e5}

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for row in case.rows:
            for field in ("effort_limit", "velocity_limit"):
                limit: float | None = getattr(row, field)
                if limit is None or field not in row.stated:
                    continue
                yield row, field, limit

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Find limits that no motor reaches."""
        row, field, limit = subject
        least = self.option(case, "least")
        if least <= limit < math.inf:
            noun = field.replace("_", " ")
            yield Finding(
                self.code,
                f"the {noun} of {shown(row, field, limit, 6)} is a placeholder: no motor reaches it, and "
                "it limits nothing",
                row.place(field),
                row.joint,
                limit,
                unit(row, field),
                help=f"state the motor's {noun}",
            )
