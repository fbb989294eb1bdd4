from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding
from actspec.audit.rule import RuleOver
from actspec.audit.rules.joint_units import shown, unit
from actspec.diagnostics import Severity
from actspec.readings.artifact import FileKind
from actspec.readings.ledger import LedgerRow
from actspec.robot.view import ActuatorView


class NegativeGain(RuleOver[LedgerRow]):
    code = "SGN101"
    name = "negative-drive-gain"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    needs = "no drive with a gain among the files"

    def subjects(self, case: Case) -> Iterator[LedgerRow]:
        for row in case.rows:
            if row.kp is None and row.kd is None:
                continue
            yield row

    def judge(self, case: Case, row: LedgerRow) -> Iterator[Finding]:
        """Find negative kp and kd."""
        springs = {a.span for a in _actuators(case) if a.control == "position" and a.gain == 0.0}
        if row.span in springs:
            return
        if row.kp is not None and row.kp < 0.0:
            yield self._finding(row, "kp", row.kp, "it pushes the joint away from its target")
        if row.kd is not None and row.kd < 0.0:
            yield self._finding(row, "kd", row.kd, "it drives every motion on instead of braking it")

    def _finding(self, row: LedgerRow, field: str, value: float, effect: str) -> Finding:
        return Finding(
            self.code,
            f"{field} is {shown(row, field, value)}: {effect}",
            row.place(field),
            row.joint,
            value,
            unit(row, field),
            -value,
            'gains are positive; in biasprm the feedback stands with a minus: biasprm="0 -kp -kd"',
        )


def _actuators(case: Case) -> Iterator[ActuatorView]:
    for _, artifact in case.of_kind(FileKind.MJCF):
        if artifact.robot is not None:
            yield from artifact.robot.actuators
