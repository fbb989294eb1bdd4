from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.damping_parts import Parts, parts_by_joint
from actspec.audit.rules.joints import effort_noun, shown, unit
from actspec.readings.artifact import FileKind
from actspec.readings.ledger import LedgerRow

_Subject = tuple[float | None, bool, LedgerRow, Parts | None, float]


class DampingInThreePlaces(RuleOver[_Subject]):
    code = "DMP104"
    name = "damping-counted-three-times"
    noted_in_folders = True
    aliases: ClassVar[dict[str, str]] = {"DMP104": "damping-counted-thrice"}
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    needs = "no drive with a velocity gain, and no torque-speed line, among the files"
    options: ClassVar[dict[str, float]] = {"near": 0.25}

    def subjects(self, case: Case) -> Iterator[_Subject]:
        everything = case.once(parts_by_joint)
        for key, rows in case.joints.items():
            row, parts = rows[0], everything[key]
            slope = _slope(rows)
            mjcf = case.artifacts[row.artifact].kind is FileKind.MJCF
            if row.joint_damping is None or not (slope or (mjcf and parts is not None and parts.kd > 0.0)):
                continue
            yield slope, mjcf, row, parts, row.joint_damping

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Find three places, and slopes that are there twice."""
        slope, mjcf, row, parts, damping = subject
        if slope is not None and abs(damping - slope) <= self.option(case, "near") * slope:
            yield self._twice(row, damping, slope)
        elif mjcf and parts is not None and parts.in_three_places:
            yield self._three_times(row, parts)

    def _three_times(self, row: LedgerRow, parts: Parts) -> Finding:
        return Finding(
            self.code,
            f"the drive brakes with {shown(row, 'kd', parts.kd)}, the joint's damping with "
            f"{shown(row, 'kd', parts.joint)} and the actuator's with {shown(row, 'kd', parts.actuator)}: together "
            f"{shown(row, 'kd', parts.total)}, of which {shown(row, 'kd', parts.passive)} are outside any "
            f"{effort_noun(row)} limit",
            row.place("actuator_damping"),
            row.joint,
            parts.total,
            unit(row, "kd"),
            help="keep the D gain in kv and all friction in the joint's damping",
            related=(row.place("joint_damping"),),
        )

    def _twice(self, row: LedgerRow, damping: float, slope: float) -> Finding:
        left = slope / (slope + damping)
        return Finding(
            self.code,
            f"the joint damping of {shown(row, 'kd', damping)} is the slope of the motor's torque-speed line "
            f"({shown(row, 'kd', slope)}), which acts already: the joint reaches {left:.0%} of its no-load speed",
            row.place("joint_damping"),
            row.joint,
            damping,
            unit(row, "kd"),
            help="leave only the friction of the bearings in the joint damping",
            related=(row.span,),
            confidence=Confidence.HIGH,
        )


def _slope(rows: Sequence[LedgerRow]) -> float | None:
    """Fall of the joint's torque over speed that its motors have of themselves; None or above 0."""
    slope = sum(row.back_emf or 0.0 for row in rows)
    # Each row has the line of all of them.
    slope += next(
        (row.stall_torque / row.no_load_speed for row in rows if row.stall_torque and row.no_load_speed), 0.0
    )
    return slope if 0.0 < slope < math.inf else None
