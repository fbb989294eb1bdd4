from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.randomized import about_range, ends, ranges, written
from actspec.readings.artifact import Framework, RandomizedRange
from actspec.readings.versions import friction_unit_of
from actspec.simulators.isaaclab import FrictionUnit

SPEED = 10.0
"""Joint speed at which a consequence is given [rad/s]. Chosen: a leg's joint in a trot."""


class FrictionRangeSetsViscous(RuleOver[tuple[RandomizedRange, FrictionUnit | None]]):
    code = "DRN104"
    name = "friction-range-sets-viscous"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    written_over = frozenset({"draws"})
    needs = "no Isaac Lab configuration randomises joint friction"

    def subjects(self, case: Case) -> Iterator[tuple[RandomizedRange, FrictionUnit | None]]:
        for index, config, one in ranges(case):
            unit = friction_unit_of(case.versions_of(index))
            if one.field != "friction" or config.framework is not Framework.ISAACLAB:
                continue
            yield one, unit

    def judge(self, case: Case, subject: tuple[RandomizedRange, FrictionUnit | None]) -> Iterator[Finding]:
        """Find ranges of friction that are not scales."""
        one, unit = subject
        if one.operation == "scale" or (unit is not None and not unit.torque):
            return
        low, high = ends(one)
        low = max(low, 0.0)
        text = f"{written(low, high, 'N*m*s/rad')}, {written(SPEED * low, SPEED * high, 'N*m')} at {SPEED:g} rad/s"
        if one.operation == "add":
            text = f"{written(low, high, 'N*m*s/rad')} more"
        yield Finding(
            self.code,
            f"{'on Isaac Sim 5 and later ' if unit is None else ''}this friction range is drawn for viscous "
            f"friction as well: {text}",
            one.span,
            help='use operation "scale", with friction, dynamic_friction and viscous_friction in the actuator cfg',
            severity=Severity.INFO if unit is None else None,
            about=about_range(one),
        )
