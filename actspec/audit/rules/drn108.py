from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.randomized import about_range, ranges
from actspec.readings.artifact import Framework, RandomizedRange


class OneDrawForAll(RuleOver[RandomizedRange]):
    code = "DRN108"
    name = "one-gaussian-draw-for-all"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    written_over = frozenset({"draws"})
    needs = "no mjlab configuration randomises actuators"

    def subjects(self, case: Case) -> Iterator[RandomizedRange]:
        for _, config, one in ranges(case):
            if config.framework is not Framework.MJLAB:
                continue
            yield one

    def judge(self, case: Case, one: RandomizedRange) -> Iterator[Finding]:
        """Find normal distributions."""
        if one.distribution == "gaussian":
            yield Finding(
                self.code,
                f"{one.field} is drawn from a normal distribution: mjlab draws one number for all joints and "
                "environments of a call",
                one.span,
                help="use uniform or log_uniform",
                about=about_range(one),
            )
