from __future__ import annotations

from collections.abc import Iterable, Iterator

from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.configs import CLASSES, FRAMEWORKS, NO_STOCK_CLASSES, misspelt, stock_groups
from actspec.diagnostics import listed, shortened
from actspec.readings.artifact import ActuatorGroup, Framework, RobotConfig
from actspec.simulators import before, release
from actspec.simulators.classes import COMMON, StockClass
from actspec.simulators.mjlab import COMMON_FIELDS


class UnknownField(RuleInParts):
    code = "CFG103"
    name = "unknown-field-or-class"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    written_over = frozenset({"classes"})
    needs = NO_STOCK_CLASSES

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        """Hold fields against the classes."""
        for _, config, group, stock in stock_groups(case):
            yield self._unknown(case, config, group, stock)
        for found in self._misspelt(case):
            yield (found,)

    def _unknown(
        self, case: Case, config: RobotConfig, group: ActuatorGroup, stock: StockClass
    ) -> Iterator[Finding]:
        meant = misspelt(config.framework, group)
        for name, setting in group.settings.items():
            if name in meant:
                near = meant[name]
                yield Finding(
                    self.code,
                    f"{group.cls} has no field {shortened(name)!r}",
                    setting.span,
                    help=f"did you mean {near!r}?" if near else f"it has {listed(sorted(stock.fields), 30)}",
                    about=name,
                )
            elif _later(case, config, group, name):
                yield Finding(
                    self.code,
                    f"mjlab {case.versions.mjlab} has no {name} in {group.cls}: it came with 1.3",
                    setting.span,
                    about=name,
                )

    def _misspelt(self, case: Case) -> Iterator[Finding]:
        """Names of one framework's class in the other's spelling."""
        for artifact in case.artifacts:
            config = artifact.config
            if config is None or config.framework not in CLASSES:
                continue
            known = CLASSES[config.framework]
            spelt = {name.lower(): name for name in known}
            for group in config.groups:
                right = spelt.get(group.cls.lower())
                if right is not None and right != group.cls and group.is_stock:
                    yield Finding(
                        self.code,
                        f"{FRAMEWORKS[config.framework]} has no class {group.cls}",
                        group.span,
                        help=f"did you mean {right}?",
                        about=group.cls,
                    )


def _later(case: Case, config: RobotConfig, group: ActuatorGroup, name: str) -> bool:
    named = case.versions.mjlab
    if config.framework is not Framework.MJLAB or named is None or "base_cfg" in group.settings:
        return False
    return name in COMMON and before(release(named), COMMON_FIELDS)
