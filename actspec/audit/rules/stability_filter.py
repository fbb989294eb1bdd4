"""STB: a filter that the simulation's step is too long for."""

from __future__ import annotations

import math
from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.actuator_texts import written_actuators
from actspec.diagnostics import Severity
from actspec.readings.artifact import FileKind
from actspec.robot.view import ActuatorView, RobotView
from actspec.units import format_quantity


class FilterFasterThanStep(Rule):
    """A command filter is faster than the simulation's step.

    ## What it does
    Reports actuators of an MJCF whose filter has a time constant below the file's time step. With `dyntype="filter"`
    it is an error up to half a step, because the activation then swings or grows without end; with `filterexact` and
    `timeconst` it is a remark.

    ## Why it matters
    `filter` takes Euler steps: a' = a + h/tau (u - a). At tau = h/2 the activation of a step of 1 goes 2, 0, 2, 0 for
    ever, below that it grows without bound. `filterexact` is right at any step, but filters nothing any more: what is
    left is one step of delay.

    ## Example
    ```xml
    <mujoco>
      <option timestep="0.01"/>
      <worldbody>
        <body>
          <joint name="knee"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <general joint="knee" dyntype="filter" dynprm="0.005"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <option timestep="0.002"/>
      <worldbody>
        <body>
          <joint name="knee"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <general joint="knee" dyntype="filterexact" dynprm="0.005"/>
      </actuator>
    </mujoco>
    ```

    ## Source
    MuJoCo 4.0, measured with h 10 ms and a step of 1: `filter` with tau 5 ms gives 2 0 2 0, with 4 ms 2.5 -1.25 4.4
    -4.1, with 6 ms 1.67 0.56 1.3; `filterexact` with 5 ms gives 0.865 0.982.
    """

    code = "STB103"
    name = "filter-faster-than-step"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare time constants with the step."""
        looked = False
        for _, artifact in case.of_kind(FileKind.MJCF):
            robot = artifact.robot
            filtered = robot is not None and any(actuator.time_constant > 0.0 for actuator in robot.actuators)
            looked = looked or filtered
        for found in written_actuators(case, which=_is_fast):
            view, tau = found.view, found.view.time_constant
            assert found.artifact.robot is not None and found.artifact.robot.timestep is not None
            step = found.artifact.robot.timestep
            exact = found.text.dynamics_type == "filterexact"
            swings = tau <= step / 2.0
            if exact:
                what = f"it passes {-math.expm1(-step / tau):.0%} of a change in one step and hardly filters"
            elif swings:
                what = "its activation swings without end, a' = a + h/tau (u - a)"
            else:
                what = f"its activation overshoots by {step / tau - 1.0:.0%} of a change"
            yield Finding(
                self.code,
                f"the filter's time constant of {format_quantity(tau * 1e3, 'ms', 3)} is shorter than the step of "
                f"{format_quantity(step * 1e3, 'ms', 3)}: {what}",
                view.span,
                view.target if view.transmission in ("joint", "jointinparent") else "",
                tau,
                "s",
                help="shorten the timestep, or leave the filter out"
                if exact
                else 'write dyntype="filterexact", or shorten the timestep',
                severity=Severity.INFO if exact else Severity.ERROR if swings else self.severity,
            )
        if not looked:
            yield Skipped(self.code, "no MJCF with a filtered actuator among the files")


def _is_fast(robot: RobotView, view: ActuatorView) -> bool:
    """Whether a filter is faster than the file's step."""
    step = robot.timestep
    return step is not None and 0.0 < view.time_constant < step and "time_constant" not in view.unknown


RULES: tuple[type[Rule], ...] = (FilterFasterThanStep,)
