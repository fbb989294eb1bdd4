from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.configs import groups_of
from actspec.audit.rules.joints import friction_unit
from actspec.readings.artifact import Framework, Setting
from actspec.readings.ledger import LedgerRow
from actspec.readings.versions import Versions, friction_unit_of, has_dynamic
from actspec.units import format_number

_Subject = tuple[Versions, LedgerRow, Setting, Setting, float, float]


class DynamicAboveStatic(RuleOver[_Subject]):
    code = "FRC103"
    name = "dynamic-above-static-friction"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    needs = "no Isaac Lab configuration with friction and dynamic_friction in force"

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for group in groups_of(case, Framework.ISAACLAB):
            versions = case.versions_of(group.artifact)
            silent = friction_unit_of(versions) is not None and not has_dynamic(versions)
            static, dynamic = group.written("friction"), group.written("dynamic_friction")
            if static is None or dynamic is None or silent:
                continue
            for row in group.rows:
                still, moving = group.number(static, row.joint), group.number(dynamic, row.joint)
                if still is None or moving is None:
                    continue
                yield versions, row, static, dynamic, still, moving

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Compare the two."""
        versions, row, static, dynamic, still, moving = subject
        if moving > still:
            yield Finding(
                self.code,
                f"dynamic_friction {format_number(moving, 3)} is above friction {format_number(still, 3)}, the "
                "static part: PhysX asks for the opposite",
                dynamic.span,
                row.joint,
                moving,
                friction_unit(row, versions),
                still,
                help=f"friction={format_number(moving, 3)} and dynamic_friction={format_number(still, 3)}, or "
                "both alike for plain Coulomb friction",
                related=(static.span,),
            )
