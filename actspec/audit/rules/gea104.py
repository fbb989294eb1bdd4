from __future__ import annotations

from collections.abc import Iterator, Sequence

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import by_joint, partner_rows, unit
from actspec.ir import JointKind
from actspec.readings.artifact import FileKind, Framework
from actspec.readings.ledger import LedgerRow

_Subject = tuple[Sequence[LedgerRow], LedgerRow, list[LedgerRow], list[LedgerRow], LedgerRow]


class NoArmature(RuleOver[_Subject]):
    code = "GEA104"
    name = "armature-missing"
    severity = Severity.INFO
    confidence = Confidence.MEDIUM
    paired = True
    needs = "no MJCF with a driven hinge among the files"

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for rows in by_joint(case, FileKind.MJCF).values():
            row = rows[0]
            others = list(partner_rows(case, row, FileKind.CFG, FileKind.SPEC))
            drives = [other for other in others if _drives_mjcf(case, other)]
            drive = row if row.control != "none" else next(iter(drives), None)
            if drive is None or row.kind is JointKind.SLIDE or row.armature is None:
                continue
            yield rows, row, others, drives, drive

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Find driven joints that nothing but their links resists."""
        rows, row, others, drives, drive = subject
        if row.armature != 0.0 or any(other.armature for other in others):
            return
        servo = any(one.kp for one in (*rows, *drives))
        yield Finding(
            self.code,
            "this driven joint has no armature: only its links resist",
            row.place("armature"),
            row.joint,
            0.0,
            unit(row, "armature"),
            help="armature is rotor inertia times gear squared; a direct drive has its rotor's",
            related=() if drive is row else (drive.span,),
            confidence=self.confidence if servo else Confidence.LOW,
        )


def _drives_mjcf(case: Case, row: LedgerRow) -> bool:
    """Whether a configuration's drive acts on the MJCF's own joints, as mjlab's do."""
    config = case.artifacts[row.artifact].config
    return config is not None and config.framework is Framework.MJLAB
