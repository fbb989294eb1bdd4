from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import by_joint, partner_rows, shown, unit
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
    options: ClassVar[dict[str, float]] = {"frequency": 30.0}

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
        kp = max((one.kp or 0.0 for one in (*rows, *drives)), default=0.0)
        inertia = row.inertia_free_min
        text = "this driven joint has no armature: only its links resist"
        stiff = False
        if kp > 0.0 and inertia is not None and inertia > 0.0:
            frequency = math.sqrt(kp / inertia) / (2.0 * math.pi)
            stiff = frequency >= self.option(case, "frequency")
            if stiff:
                # Left and right differ in the third digit.
                gain = shown(drive, "kp", kp)
                text += f", and its kp of {gain} gives it a natural frequency of {frequency:.2g} Hz"
        yield Finding(
            self.code,
            text,
            row.place("armature"),
            row.joint,
            0.0,
            unit(row, "armature"),
            help="armature is rotor inertia times gear squared; a direct drive has its rotor's",
            related=() if drive is row else (drive.span,),
            severity=Severity.WARNING if stiff else self.severity,
            confidence=self.confidence if kp > 0.0 else Confidence.LOW,
        )


def _drives_mjcf(case: Case, row: LedgerRow) -> bool:
    """Whether a configuration's drive acts on the MJCF's own joints, as mjlab's do."""
    config = case.artifacts[row.artifact].config
    return config is not None and config.framework is Framework.MJLAB
