from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding
from actspec.audit.rule import RuleOver
from actspec.audit.rules.cfg_groups import (
    MJLAB_WITH_LINE,
    WITH_LINE,
    Group,
    groups_of,
)
from actspec.diagnostics import Severity
from actspec.readings.artifact import Framework


class NoLine(RuleOver[Group]):
    code = "LIM110"
    name = "torque-speed-line-without-a-figure"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    needs = "no Isaac Lab or mjlab cfg with a torque-speed line among the files"

    def subjects(self, case: Case) -> Iterator[Group]:
        yield from (
            *groups_of(case, Framework.ISAACLAB, WITH_LINE),
            *groups_of(case, Framework.MJLAB, MJLAB_WITH_LINE),
        )

    def judge(self, case: Case, group: Group) -> Iterator[Finding]:
        """Find classes with half a line."""
        if not group.complete:
            return
        missing = []
        if group.written("velocity_limit", "actuator_velocity_limit") is None:
            missing.append("velocity_limit")
        if group.written("saturation_effort") is None:
            missing.append("saturation_effort")
        for joint in group.joints if missing else ():
            yield Finding(
                self.code,
                f"this {group.cfg.cls} sets no {' and no '.join(missing)}: it cannot be built without its "
                "torque-speed line",
                group.cfg.span,
                joint,
                help="velocity_limit is the speed at which no torque is left, saturation_effort the torque at "
                "standstill",
            )
