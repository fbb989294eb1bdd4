from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.config_classes import NO_STOCK_CLASSES, stock_groups
from actspec.diagnostics import Severity
from actspec.readings.artifact import Framework, RobotConfig


class RequiredFieldMissing(Rule):
    code = "CFG104"
    name = "required-field-missing"
    severity = Severity.ERROR
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find what is missing."""
        looked = False
        for _, config, group, stock in stock_groups(case):
            looked = True
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
        if not looked:
            yield Skipped(self.code, NO_STOCK_CLASSES)


def _takes_none(config: RobotConfig, missing: list[str]) -> bool:
    return config.framework is Framework.ISAACLAB and set(missing) <= {"stiffness", "damping"}
