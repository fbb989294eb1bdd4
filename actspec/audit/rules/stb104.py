from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.spc106 import stated_periods
from actspec.diagnostics import Span
from actspec.readings.artifact import FileKind
from actspec.units import format_quantity


class StepTooLong(RuleOver[tuple[float, Span]]):
    code = "STB104"
    name = "step-too-long"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    needs = "no MJCF or configuration that states a physics step among the files"
    options: ClassVar[dict[str, float]] = {"longest": 0.1}

    def subjects(self, case: Case) -> Iterator[tuple[float, Span]]:
        """The physics step of each file that states one."""
        places = set()
        for index, _ in case.of_kind(FileKind.MJCF, FileKind.CFG):
            found = stated_periods(case, index).get("physics_dt")
            # A scene and the model that it includes have one.
            if found is not None and found[1] not in places:
                places.add(found[1])
                yield found

    def judge(self, case: Case, subject: tuple[float, Span]) -> Iterator[Finding]:
        """Compare it with the longest that anybody simulates with."""
        step, place = subject
        if step <= self.option(case, "longest"):
            return
        if step in _RATES:
            help = f"is it a rate? The step of {step:g} Hz is {format_quantity(1e3 / step, 'ms', 4)}"
        elif step >= 1.0:
            help = f"did you mean {format_quantity(step, 'ms', 4)}? Then write {format_quantity(step * 1e-3, '', 4)}"
        else:
            help = "look for the point in the wrong place: it is in seconds"
        yield Finding(
            self.code,
            f"the physics step is {format_quantity(step, 's', 4)}: no motion of a joint is in steps of this length",
            place,
            value=step,
            unit="s",
            help=help,
        )


_RATES = frozenset((50, 60, 100, 120, 200, 240, 250, 400, 500, 1000))
"""Rates of simulations as they are quoted [Hz]."""
