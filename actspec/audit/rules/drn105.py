from __future__ import annotations

import math
from collections.abc import Iterator

from actspec.audit.drawn import rows_in
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import shown
from actspec.audit.rules.randomized import about_range, ends, ranges
from actspec.readings.artifact import Framework, RandomizedRange
from actspec.readings.ledger import LedgerRow

_Subject = tuple[RandomizedRange, LedgerRow, float]


class EffortRangeCapped(RuleOver[_Subject]):
    code = "DRN105"
    name = "effort-range-above-one-is-capped"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    written_over = frozenset({"draws"})
    needs = "no mjlab configuration randomises an effort limit that it states"

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for index, config, one in ranges(case):
            if one.field != "effort_limit" or config.framework is not Framework.MJLAB:
                continue
            for row in rows_in(case, index, one):
                limit = row.effort_limit
                if limit is None or math.isinf(limit):
                    continue
                yield one, row, limit

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Find ranges that raise a compiled limit."""
        one, row, limit = subject
        high = ends(one)[1] * limit if one.operation == "scale" else ends(one)[1]
        if row.control in ("ideal_pd", "dc_motor", "network") and high > limit:
            yield Finding(
                self.code,
                f"the effort limit is drawn up to {shown(row, 'effort_limit', high)}, and the compiled model "
                f"caps it at {shown(row, 'effort_limit', limit)}",
                one.span,
                row.joint,
                help="set effort_limit to the highest value, and scale down from there",
                related=(row.place("effort_limit"),),
                about=about_range(one),
            )
