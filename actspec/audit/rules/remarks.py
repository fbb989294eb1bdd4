"""ACT: the remarks in audited files that set findings aside."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.diagnostics import Severity


class RemarkRule(Rule):
    """A rule over remarks: the engine judges them, after all other rules have run."""

    severity: ClassVar[Severity] = Severity.WARNING
    confidence: ClassVar[Confidence] = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Nothing; whether a remark was of use is known only when all rules have run."""
        return iter(())
