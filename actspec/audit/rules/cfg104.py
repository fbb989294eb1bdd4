from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding
from actspec.audit.rule import RuleOver
from actspec.audit.rules.config_classes import NO_STOCK_CLASSES, StockClass, stock_groups
from actspec.diagnostics import Severity
from actspec.readings.artifact import ActuatorGroup, Framework, RobotConfig

_Subject = tuple[RobotConfig, ActuatorGroup, StockClass]


class RequiredFieldMissing(RuleOver[_Subject]):
    code = "CFG104"
    name = "required-field-missing"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    needs = NO_STOCK_CLASSES

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for _, config, group, stock in stock_groups(case):
            yield config, group, stock

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Find what is missing."""
        config, group, stock = subject
        told = any(note.where in (group.name, f"actuators.{group.name}") for note in config.notes)
        alone = len(config.groups) == 1 and group.name == config.name
        missing = sorted(stock.required - set(group.settings))
        if missing and not told and not alone:
            yield Finding(
                self.code,
                f"this {group.cls} has no {' and no '.join(missing)}: it cannot be made",
                group.span,
                help="None takes the USD's value" if _takes_none(config, missing) else None,
            )


def _takes_none(config: RobotConfig, missing: list[str]) -> bool:
    return config.framework is Framework.ISAACLAB and set(missing) <= {"stiffness", "damping"}
