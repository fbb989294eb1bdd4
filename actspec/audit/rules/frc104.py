from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.configs import Group, groups_of
from actspec.audit.rules.joints import friction_unit
from actspec.readings.artifact import Framework
from actspec.readings.versions import has_dynamic
from actspec.units import format_number, format_quantity


class StaticFrictionAlone(RuleOver[Group]):
    code = "FRC104"
    name = "static-friction-alone"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    needs = "no Isaac Lab configuration with friction for a named Isaac Sim 5 or later"

    def subjects(self, case: Case) -> Iterator[Group]:
        for group in groups_of(case, Framework.ISAACLAB):
            static = group.written("friction")
            if static is None or not has_dynamic(case.versions_of(group.artifact)):
                continue
            yield group

    def judge(self, case: Case, group: Group) -> Iterator[Finding]:
        """Find groups with a static part alone."""
        if group.complete and group.written("dynamic_friction") is None:
            yield from self._alone(case, group)

    def _alone(self, case: Case, group: Group) -> Iterator[Finding]:
        static = group.written("friction")
        for row in group.rows:
            value = group.number(static, row.joint)
            if static is None or value is None or value <= 0.0:
                continue
            dimension = friction_unit(row, case.versions_of(row.artifact))
            yield Finding(
                self.code,
                f"the friction of {format_quantity(value, dimension, 3)} is static alone: without dynamic_friction it "
                "is gone as soon as the joint moves",
                static.span,
                row.joint,
                value,
                dimension,
                help=f"add dynamic_friction={format_number(value)}",
            )
