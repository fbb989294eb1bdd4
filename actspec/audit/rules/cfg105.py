from __future__ import annotations

from collections.abc import Iterator, Mapping

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.configs import FRAMEWORKS, NO_STOCK_CLASSES, stock_groups
from actspec.readings.artifact import ActuatorGroup, Framework, RobotConfig
from actspec.readings.versions import is_native
from actspec.simulators.classes import StockClass

_Subject = tuple[RobotConfig, ActuatorGroup, StockClass]


class ScalarGivenDict(RuleOver[_Subject]):
    code = "CFG105"
    name = "scalar-field-given-a-dict"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    needs = NO_STOCK_CLASSES

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for _, config, group, stock in stock_groups(case):
            yield config, group, stock

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Find dicts."""
        config, group, stock = subject
        named = case.versions.isaaclab
        for name, setting in group.settings.items():
            if not isinstance(setting.value, Mapping) or name not in stock.fields - stock.mappable:
                continue
            if name == "motor_params":
                continue
            isaac = config.framework is Framework.ISAACLAB
            later = isaac and name == "saturation_effort"
            if later and is_native(case.versions):
                continue
            where = "Isaac Lab 2.x" if later else FRAMEWORKS[config.framework]
            yield Finding(
                self.code,
                f"{name} of {group.cls} is one number for the whole group in {where}, and is given "
                f"{len(setting.value)} by joint: it cannot be made",
                setting.span,
                help="make a group for each value",
                severity=Severity.WARNING if later and named is None else None,
                about=name,
            )
