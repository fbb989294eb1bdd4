from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from os.path import basename
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.damping_parts import INTENT, Parts, parts_by_joint, same
from actspec.audit.rules.joints import by_joint, effort_noun, partner_rows, shown, unit
from actspec.readings.artifact import FileKind, Framework
from actspec.readings.ledger import LedgerRow

_Subject = tuple[float, float, LedgerRow, Parts]


class GainInJointDamping(RuleOver[_Subject]):
    code = "DMP102"
    name = "kd-in-joint-damping"
    severity = Severity.INFO
    confidence = Confidence.MEDIUM
    needs = "no MJCF with limited position servos among the files"
    options: ClassVar[dict[str, float]] = {"ratio": 0.1, "time": 0.01}

    def subjects(self, case: Case) -> Iterator[_Subject]:
        everything = case.once(parts_by_joint)
        for key, rows in by_joint(case, FileKind.MJCF).items():
            row, parts = rows[0], everything[key]
            if parts is None or any(item.control != "position" for item in rows):
                continue
            kp = sum(item.kp or 0.0 for item in rows)
            limit = row.effort_limit
            if kp <= 0.0 or limit is None or limit <= 0.0:
                continue
            yield kp, limit, row, parts

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Find servos without kv on damped joints."""
        kp, limit, row, parts = subject
        if parts.kd != 0.0 or limit == math.inf or not self._plain(case, row, parts, kp):
            return
        others = list(partner_rows(case, row, *INTENT, FileKind.DEPLOY))
        # DMP105 has the sum with a gain that acts on this very joint.
        if not any(_is_mjlab(case, other) and other.kd for other in others):
            yield self._finding(row, parts, limit, others)

    def _plain(self, case: Case, row: LedgerRow, parts: Parts, kp: float) -> bool:
        if row.damping_ratio is not None:
            return row.damping_ratio >= self.option(case, "ratio")
        return parts.joint >= self.option(case, "time") * kp

    def _finding(self, row: LedgerRow, parts: Parts, limit: float, others: Sequence[LedgerRow]) -> Finding:
        twin = next((o for o in others if o.kd and same(o.kd, parts.joint)), None)
        speed = 10.0 if unit(row, "velocity_limit") == "rad/s" else 1.0
        known = "" if twin is None else f"; {basename(twin.file)} has this kd inside the limit"
        return Finding(
            self.code,
            f"with kv 0, the joint damping of {shown(row, 'kd', parts.joint)} is this servo's D gain, outside "
            f"the {effort_noun(row)} limit: at {shown(row, 'velocity_limit', speed)} it brakes with "
            f"{shown(row, 'effort_limit', speed * parts.joint)} beside the {shown(row, 'effort_limit', limit)} of the "
            f"drive{known}",
            row.place("joint_damping"),
            row.joint,
            parts.joint,
            unit(row, "kd"),
            help='move it to the actuator as kv, with integrator="implicitfast", and leave the friction as damping',
            related=(row.span,),
            severity=self.severity if twin is None else Severity.WARNING,
            noted_in_folders=True,
            confidence=self.confidence if twin is None else Confidence.HIGH,
        )


def _is_mjlab(case: Case, row: LedgerRow) -> bool:
    config = case.artifacts[row.artifact].config
    return config is not None and config.framework is Framework.MJLAB
