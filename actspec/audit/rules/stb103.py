from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.actuator_texts import written_actuators
from actspec.readings.artifact import FileKind
from actspec.robot.view import ActuatorView, RobotView
from actspec.units import format_quantity


class FilterFasterThanStep(RuleInParts):
    code = "STB103"
    name = "filter-faster-than-step"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    needs = "no MJCF with a filtered actuator among the files"

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        """Compare time constants with the step."""
        robots = (artifact.robot for _, artifact in case.of_kind(FileKind.MJCF))
        if any(actuator.time_constant > 0.0 for robot in robots if robot for actuator in robot.actuators):
            yield self._fast(case)

    def _fast(self, case: Case) -> Iterator[Finding]:
        for found in written_actuators(case, which=_is_fast):
            view, tau = found.view, found.view.time_constant
            assert found.artifact.robot is not None and found.artifact.robot.timestep is not None
            step = found.artifact.robot.timestep
            exact = found.text.dynamics_type == "filterexact"
            swings = tau <= step / 2.0
            if exact:
                what = f"it passes {-math.expm1(-step / tau):.0%} of a change in one step and hardly filters"
            elif swings:
                what = "its activation oscillates undamped, a' = a + h/tau (u - a)"
            else:
                what = f"its activation overshoots by {step / tau - 1.0:.0%} of a change"
            yield Finding(
                self.code,
                f"the filter's time constant of {format_quantity(tau * 1e3, 'ms', 3)} is shorter than the step of "
                f"{format_quantity(step * 1e3, 'ms', 3)}: {what}",
                view.span,
                view.target if view.is_direct else "",
                tau,
                "s",
                help="shorten the timestep, or leave the filter out"
                if exact
                else 'write dyntype="filterexact", or shorten the timestep',
                severity=Severity.INFO if exact else Severity.ERROR if swings else self.severity,
            )


def _is_fast(robot: RobotView, view: ActuatorView) -> bool:
    """Whether a filter is faster than the file's step."""
    step = robot.timestep
    return step is not None and 0.0 < view.time_constant < step and "time_constant" not in view.unknown
