from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.randomized import ranges
from actspec.diagnostics import Severity
from actspec.readings.artifact import Framework


class OneDrawForAll(Rule):
    code = "DRN108"
    name = "one-gaussian-draw-for-all"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find normal distributions."""
        looked = False
        for _, config, one in ranges(case):
            if config.framework is not Framework.MJLAB:
                continue
            looked = True
            if one.distribution == "gaussian":
                yield Finding(
                    self.code,
                    f"{one.field} is drawn from a normal distribution: mjlab draws one number for all joints and "
                    "environments of a call",
                    one.span,
                    help="use uniform or log_uniform",
                )
        if not looked:
            yield Skipped(self.code, "no mjlab configuration randomises actuators")
