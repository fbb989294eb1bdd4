from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.actuator_texts import (
    WrittenActuator,
    delayed,
    is_interpolated,
    milliseconds,
    stored_samples,
)
from actspec.audit.rules.configs import is_whole, lags, stock_groups
from actspec.readings.artifact import Framework, Setting
from actspec.readings.versions import is_native
from actspec.units import format_number

_SECONDS = 1.0
"""Below this a number of steps is read as seconds. Chosen: the longest delay of a drive is far below."""

_OFTEN = 0.005
"""The step of Isaac Lab's and mjlab's own tasks of legged robots [s], as an example where no file states one."""


class DelayBetweenSteps(RuleInParts):
    code = "DLY101"
    name = "delay-between-steps"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    needs = "no MJCF with a delay, and no configuration with one, among the files"
    options: ClassVar[dict[str, float]] = {"share": 0.01}

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        for found, step in delayed(case):
            yield self._of_model(case, found, step)
        for index, config, group, _ in stock_groups(case):
            for name, setting in lags(config.framework, group):
                yield self._of_config(case, index, config.framework, name, setting)

    def _of_model(self, case: Case, found: WrittenActuator, step: float) -> Iterator[Finding]:
        """Count the steps of a delay in seconds."""
        delay = found.view.delay
        steps = delay / step
        if abs(steps - round(steps)) <= self.option(case, "share") or is_interpolated(found):
            return
        kept = stored_samples(found)
        real = math.ceil(steps) if kept is None else min(math.ceil(steps), kept)
        owner = found.owner("delay") or found.element
        yield Finding(
            self.code,
            f"a delay of {milliseconds(delay)} is {steps:.3g} steps of {milliseconds(step)}: the command comes "
            f"{milliseconds(real * step)} late",
            found.document.span(owner),
            found.joint,
            delay,
            "s",
            real * step,
            'write a whole number of steps, or interp="linear"',
        )

    def _of_config(
        self, case: Case, index: int, framework: Framework, name: str, setting: Setting
    ) -> Iterator[Finding]:
        """Look at a delay that is counted in steps, which torch draws whole."""
        value = setting.number
        if value is None or value < 0.0 or is_whole(value):
            return
        if framework is Framework.MJLAB:
            then = ": the first step raises an error"
        else:
            # What Newton makes of it was not measured.
            then = "" if is_native(case.versions) else ": the first reset raises an error"
        yield Finding(
            self.code,
            f"{name} is {format_number(value)} physics steps, which is no whole number{then}",
            setting.span,
            value=value,
            unit="1",
            help=_whole(value, _step(case, index)),
            severity=Severity.ERROR if then else None,
        )


def _step(case: Case, index: int) -> float | None:
    """The physics step of a configuration's robot [s]; None: no file states it, or they state several."""
    configs = (case.artifacts[other].config for other in case.robot_of(index).artifacts)
    steps = {config.physics_dt for config in configs if config is not None} - {None}
    return steps.pop() if len(steps) == 1 else None


def _whole(value: float, step: float | None) -> str:
    """What to write: a time as steps, or one of the whole numbers beside."""
    if value >= _SECONDS:
        return f"write {math.floor(value)} or {math.ceil(value)}"
    if not step or step <= 0.0:
        often = format_number(value / _OFTEN, 3)
        return f"seconds as steps: {format_number(value)} s over the physics step, {often} of {milliseconds(_OFTEN)}"
    steps = value / step
    if is_whole(steps):
        count = round(steps)
        return f"{format_number(value)} s is {count} step{'s' * (count != 1)} of {milliseconds(step)}: write {count}"
    return f"{format_number(value)} s is {steps:.3g} steps of {milliseconds(step)}: write a whole number"
