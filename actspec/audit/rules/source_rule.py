"""What the SRC rules have in common."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding
from actspec.audit.rule import RuleInParts
from actspec.audit.rules.source_pairs import (
    Disagreement,
    compared,
    disagreements,
)
from actspec.diagnostics import Severity
from actspec.readings.compare import angle_slip
from actspec.readings.fields import FIELDS
from actspec.units import format_quantity


def shown(value: float | None, unit: str) -> str:
    """A figure for a message, three digits."""
    return format_quantity(value, unit, 3)


class SourceRule(RuleInParts):
    """What the rules of this family have in common."""

    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    options: ClassVar[dict[str, float]] = {"tolerance": 0.01}
    groups: ClassVar[tuple[tuple[str, ...], ...]]
    """Fields that are compared; of those in one tuple the first that a file states."""

    def lacks(self, case: Case) -> str:
        """What no two files state."""
        return f"no two files of one robot state {self.needs}"

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        """Compare the files of each robot."""
        tolerance = self.option(case, "tolerance")
        findings = [
            self.finding(case, found)
            for fields in self.groups
            for found in disagreements(case, fields, tolerance)
            if not self.is_explained(case, found, tolerance)
        ]
        if findings or any(compared(case, fields) for fields in self.groups):
            yield self.without_told(case, findings) if findings else ()

    def without_told(self, case: Case, findings: list[Finding]) -> list[Finding]:
        """Findings without those that another rule has at the same place and joint, and says more about."""
        return findings

    def is_explained(self, case: Case, found: Disagreement, tolerance: float) -> bool:
        """Whether another rule says more about it, or it is none."""
        return angle_slip(found.ratio, tolerance)

    def consequence(self, case: Case, found: Disagreement) -> str:
        """What it does to the robot, with a number."""
        raise NotImplementedError

    def severity_of(self, case: Case, found: Disagreement) -> tuple[Severity, Confidence]:
        """By what the files are."""
        return self.severity, self.confidence

    def finding(self, case: Case, found: Disagreement) -> Finding:
        """The finding of one joint, at the file that departs."""
        mine, theirs = found.mine, found.theirs
        severity, confidence = self.severity_of(case, found)
        if found.variant:
            severity, confidence = Severity.INFO, Confidence.LOW
        other = found.others[0].file
        return Finding(
            self.code,
            f"the {FIELDS[found.field].noun} is {shown(mine.value, mine.unit)} here and "
            f"{shown(theirs.value, theirs.unit)} in {other}{found.times}: {self.consequence(case, found)}",
            mine.place,
            found.rows[0].joint,
            mine.value,
            mine.unit or None,
            expected=theirs.value,
            help=f"find out which is right, and write it in both, or set this aside with the reason: {other} may be "
            "of another variant",
            related=(theirs.place,),
            severity=severity,
            confidence=confidence,
        )
