from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.randomized import ends, nominal, ranges, rows_in, written
from actspec.diagnostics import Severity


class ScalesZero(Rule):
    code = "DRN102"
    name = "range-scales-a-zero"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    paired = True

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find scaled zeros."""
        looked = False
        for index, config, one in ranges(case):
            for row in rows_in(case, index, one):
                value = nominal(case, config, row, one)
                looked = looked or value is not None
                if value == 0.0 and one.operation == "scale":
                    yield Finding(
                        self.code,
                        f"{one.field} is scaled by {written(*ends(one))} and is 0: nothing is randomised",
                        one.span,
                        row.joint,
                        help="give it a value, or randomise by add",
                        related=(row.span,),
                    )
        if not looked:
            yield Skipped(self.code, "no configuration randomises a value that it states")
