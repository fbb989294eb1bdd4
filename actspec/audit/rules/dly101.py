from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.actuator_texts import (
    NO_DELAY,
    WrittenActuator,
    delayed,
    is_interpolated,
    milliseconds,
    stored_samples,
)


class DelayBetweenSteps(RuleOver[tuple[WrittenActuator, float]]):
    code = "DLY101"
    name = "delay-between-steps"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    needs = NO_DELAY
    options: ClassVar[dict[str, float]] = {"share": 0.01}

    def subjects(self, case: Case) -> Iterator[tuple[WrittenActuator, float]]:
        yield from delayed(case)

    def judge(self, case: Case, subject: tuple[WrittenActuator, float]) -> Iterator[Finding]:
        """Count the steps of each delay."""
        found, step = subject
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
