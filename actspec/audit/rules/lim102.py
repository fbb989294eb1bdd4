from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.joint_units import shown, unit
from actspec.diagnostics import Severity


class PlaceholderLimit(Rule):
    code = "LIM102"
    name = "limit-is-a-placeholder"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    options: ClassVar[dict[str, float]] = {"least": 1e5}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find limits that no motor reaches."""
        least = self.option(case, "least")
        looked = False
        for row in case.rows:
            for field in ("effort_limit", "velocity_limit"):
                limit: float | None = getattr(row, field)
                if limit is None or field not in row.stated:
                    continue
                looked = True
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
        if not looked:
            yield Skipped(self.code, "no file states an effort or velocity limit")
