from __future__ import annotations

import math
from collections.abc import Iterator

from actspec.audit.finding import Fix, Safety, TextEdit
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.actuator_texts import (
    NO_DELAY,
    WrittenActuator,
    delayed,
    is_interpolated,
    milliseconds,
    stored_samples,
)
from actspec.robot.xml_edit import exact_number

_ALMOST = 1e-6
"""Steps by which a delay may miss a whole number of them. Chosen: far above rounding, far below any delay."""


class SamplesDoNotFit(RuleOver[tuple[WrittenActuator, float]]):
    code = "DLY102"
    name = "nsample-does-not-fit-delay"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    fix = Safety.UNSAFE
    needs = NO_DELAY

    def subjects(self, case: Case) -> Iterator[tuple[WrittenActuator, float]]:
        yield from delayed(case)

    def judge(self, case: Case, subject: tuple[WrittenActuator, float]) -> Iterator[Finding]:
        """Compare samples and steps."""
        found, step = subject
        kept = stored_samples(found)
        if kept is None or kept < 1:
            return
        delay = found.view.delay
        exact = delay / step
        steps = math.ceil(exact - _ALMOST)
        samples = f"{kept} sample{'s' * (kept != 1)}"
        owner = found.owner("nsample") or found.element
        if kept < steps:
            yield Finding(
                self.code,
                f"{samples} cannot hold a delay of {milliseconds(delay)}, {steps} steps of "
                f"{milliseconds(step)}: the command comes {milliseconds(kept * step)} late",
                found.document.span(owner),
                found.joint,
                float(kept),
                "1",
                float(steps),
                f'nsample="{steps}"',
                fix=_samples_fix(found, steps),
            )
        elif kept > steps and abs(exact - steps) <= _ALMOST and not is_interpolated(found):
            yield Finding(
                self.code,
                f"with {samples} for a delay of {steps} steps the command comes {steps} or {steps + 1} steps "
                f"late, by rounding: {milliseconds(delay)} or {milliseconds(delay + step)}",
                found.document.span(owner),
                found.joint,
                float(kept),
                "1",
                float(steps),
                f'nsample="{steps}" makes it exact',
                fix=_samples_fix(found, steps),
                severity=Severity.INFO,
                confidence=Confidence.MEDIUM,
            )


def _samples_fix(found: WrittenActuator, steps: int) -> Fix | None:
    attribute = found.element.attributes.get("nsample")
    if attribute is None or found.document.is_repeated(found.element):
        return None
    path = found.document.files[found.element.file].path
    edit = TextEdit(path, attribute.value_start, attribute.value_end, exact_number(steps).encode())
    # What the histories of other actuators hold stays, but they move.
    fields = ("actuator_history", "actuator_historyadr", "nhistory")
    return Fix(f'Set nsample="{steps}"', Safety.UNSAFE, (edit,), fields)
