from __future__ import annotations

import math
from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding
from actspec.audit.rule import RuleOver
from actspec.audit.rules.joint_units import unit
from actspec.diagnostics import Severity
from actspec.readings.artifact import FileKind
from actspec.readings.ledger import LedgerRow


class NoLimit(RuleOver[tuple[set[str], LedgerRow]]):
    code = "LIM101"
    name = "no-limit-of-any-kind"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    needs = "no MJCF with actuators on joints among the files"

    def subjects(self, case: Case) -> Iterator[tuple[set[str], LedgerRow]]:
        for index, _ in case.of_kind(FileKind.MJCF):
            limited = _limited_elsewhere(case, index)
            for row in case.rows_of(index):
                if row.control == "none" or not row.joint:
                    continue
                yield limited, row

    def judge(self, case: Case, subject: tuple[set[str], LedgerRow]) -> Iterator[Finding]:
        """Find actuators of MJCF files without any clamp."""
        limited, row = subject
        if row.effort_limit == math.inf and row.joint not in limited and not _is_bounded(row):
            yield Finding(
                self.code,
                "no force range, joint limit or control range limits this actuator: it gives every "
                f"{unit(row, 'effort_limit')} that it is asked for",
                row.span,
                row.joint,
                help="add actuatorfrcrange to the joint, or forcerange to the actuator",
            )


def _is_bounded(row: LedgerRow) -> bool:
    """Whether the voltage of a dcmotor bounds its torque, or the actuator is no motor that could give any."""
    # Only a dcmotor whose control is its voltage has back-EMF beside no other gain.
    voltage = row.stall_torque is not None or (bool(row.back_emf) and row.command_range is not None)
    return voltage if row.control == "dcmotor" else row.control == "other" and row.kd is None


def _limited_elsewhere(case: Case, artifact: int) -> set[str]:
    """Joints that a configuration of the same robot limits."""
    others = [i for i in case.robot_of(artifact).artifacts if case.artifacts[i].kind is FileKind.CFG]
    rows = [row for other in others for row in case.rows_of(other)]
    return {row.joint for row in rows if row.effort_limit is not None and row.effort_limit < math.inf}
