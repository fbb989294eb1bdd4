from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.configs import LAGS, is_whole
from actspec.readings.artifact import ActuatorGroup, FileKind, Framework, RobotConfig, Setting
from actspec.readings.versions import is_native

_Subject = tuple[RobotConfig, ActuatorGroup, Setting]


class DelayRangeLost(RuleOver[_Subject]):
    code = "DLY103"
    name = "delay-range-lost"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    written_over = frozenset({"actuators", "lags"})
    needs = "no configuration with delays among the files"

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for _, artifact in case.of_kind(FileKind.CFG):
            config = artifact.config
            if config is None or config.framework not in LAGS:
                continue
            for group in config.groups:
                most = group.settings.get(LAGS[config.framework][1])
                if most is None:
                    continue
                yield config, group, most

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Compare the ends."""
        config, group, most = subject
        yield from self._group(case, config, group, most)

    def _group(
        self, case: Case, config: RobotConfig, group: ActuatorGroup, most: Setting
    ) -> Iterator[Finding]:
        names = LAGS[config.framework]
        least = group.settings.get(names[0])
        low, high = 0.0 if least is None else least.number, most.number
        if high is None or not is_whole(high) or not is_whole(low or 0.0):
            # A delay that is none is DLY101's.
            return
        span = (least or most).span
        if low is not None and low > high:
            then = (
                "the first reset raises an error"
                if config.framework is Framework.ISAACLAB
                else "the cfg raises an error when it is made"
            )
            yield Finding(
                self.code,
                f"{names[0]} is {low:g} steps and {names[1]} {high:g}: {then}",
                span,
                value=low,
                unit="1",
                expected=high,
                help=f"{names[0]} is at most {names[1]}",
            )
            return
        named = case.versions.isaaclab
        if config.framework is Framework.ISAACLAB:
            if low is not None and low < high and is_native(case.versions):
                yield Finding(
                    self.code,
                    f"Isaac Lab {named} ignores {names[0]}: every environment gets a delay of {high:g} steps, not "
                    f"{low:g} to {high:g}",
                    span,
                    value=low,
                    unit="1",
                    expected=high,
                    help="set use_newton_actuators=False, or train with one delay and say so",
                    severity=Severity.WARNING,
                )
        elif (
            high > 0.0 and (hold := group.settings.get("delay_hold_prob")) is not None and hold.number == 1.0
        ):
            yield Finding(
                self.code,
                f"with delay_hold_prob 1 the lag is never drawn: it stays 0, not {low or 0:g} to {high:g} steps",
                hold.span,
                help="for one lag an episode: delay_update_period=10**9 and delay_per_env_phase=False",
                severity=Severity.WARNING,
                about="delay_hold_prob",
            )
