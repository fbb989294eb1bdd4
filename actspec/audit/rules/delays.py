"""DLY: delays that are not what they say."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Fix, Safety, Skipped, TextEdit
from actspec.audit.rule import Rule
from actspec.audit.rules.actuator_texts import WrittenActuator, written_actuators
from actspec.diagnostics import Severity
from actspec.readings.artifact import ActuatorGroup, FileKind, Framework, RobotConfig, Setting
from actspec.readings.versions import release
from actspec.robot.mjcf_actuator_text import numbers
from actspec.robot.xml_edit import format_number
from actspec.units import format_quantity

_NONE = "no MJCF with a delay among the files"

_ALMOST = 1e-6
"""Steps by which a delay may miss a whole number of them. Chosen: far above rounding, far below any delay."""


class DelayBetweenSteps(Rule):
    """A delay is no whole number of steps.

    ## What it does
    Reports actuators of an MJCF whose `delay` is not a multiple of the timestep, beyond `share` of a step (default
    0.01). Silent with `interp="linear"` or `"cubic"`, which give times between the steps.

    ## Why it matters
    Without interpolation MuJoCo rounds up: 5 ms at a step of 2 ms are 6 ms. Whoever changes the timestep changes the
    delay.

    ## Example
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
        <motor joint="knee" delay="0.005" nsample="3"/>
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
        <motor joint="knee" delay="0.006" nsample="3"/>
      </actuator>
    </mujoco>
    ```

    ## Source
    MuJoCo 3.5, 3.11 and 4.0, measured: a delay of 2.5 steps comes 3 steps late.
    """

    code = "DLY101"
    name = "delay-between-steps"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    options: ClassVar[dict[str, float]] = {"share": 0.01}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Count the steps of each delay."""
        looked = False
        for found, step in _delayed(case):
            looked = True
            delay = found.view.delay
            steps = delay / step
            if abs(steps - round(steps)) <= self.option(case, "share") or _is_interpolated(found):
                continue
            kept = _samples(found)
            real = math.ceil(steps) if kept is None else min(math.ceil(steps), kept)
            owner = found.owner("delay") or found.element
            yield Finding(
                self.code,
                f"a delay of {_ms(delay)} is {steps:.3g} steps of {_ms(step)}: the command comes "
                f"{_ms(real * step)} late",
                found.document.span(owner),
                found.joint,
                delay,
                "s",
                real * step,
                'write a whole number of steps, or interp="linear"',
            )
        if not looked:
            yield Skipped(self.code, _NONE)


class SamplesDoNotFit(Rule):
    """The stored samples are not those of the delay.

    ## What it does
    Reports actuators of an MJCF whose `nsample` is less than the steps of their `delay`: an error. Where it is more,
    and the delay is a whole number of steps, a remark.

    ## Why it matters
    The history holds `nsample` commands; a longer delay is cut to it without a word. With more samples than steps, the
    command is sometimes one step later, because whether a stored time is old enough is a matter of its last digit. With
    exactly as many, the delay is exact.

    ## Example
    ```xml
    <mujoco>
      <option timestep="0.005"/>
      <worldbody>
        <body>
          <joint name="knee"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <motor joint="knee" delay="0.02" nsample="2"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <option timestep="0.005"/>
      <worldbody>
        <body>
          <joint name="knee"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <motor joint="knee" delay="0.02" nsample="4"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    More samples than steps are wanted where a program changes the delay at run time.

    ## Source
    MuJoCo 3.5, 3.11 and 4.0, measured: delay 0.04 at 0.01 with 3 samples comes 3 steps late; with 6 samples for 5 steps
    of 0.002 the lag is 5 or 6, and with 5 it is 5 over 15000 steps.
    """

    code = "DLY102"
    name = "nsample-does-not-fit-delay"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    fix = Safety.UNSAFE

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare samples and steps."""
        looked = False
        for found, step in _delayed(case):
            looked = True
            kept = _samples(found)
            if kept is None or kept < 1:
                continue
            delay = found.view.delay
            exact = delay / step
            steps = math.ceil(exact - _ALMOST)
            samples = f"{kept} sample{'s' * (kept != 1)}"
            owner = found.owner("nsample") or found.element
            if kept < steps:
                yield Finding(
                    self.code,
                    f"{samples} cannot hold a delay of {_ms(delay)}, {steps} steps of {_ms(step)}: the command "
                    f"comes {_ms(kept * step)} late",
                    found.document.span(owner),
                    found.joint,
                    float(kept),
                    "1",
                    float(steps),
                    f'nsample="{steps}"',
                    fix=_samples_fix(found, steps),
                )
            elif kept > steps and abs(exact - steps) <= _ALMOST and not _is_interpolated(found):
                yield Finding(
                    self.code,
                    f"with {samples} for a delay of {steps} steps the command comes {steps} or {steps + 1} steps "
                    f"late, by rounding: {_ms(delay)} or {_ms(delay + step)}",
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
        if not looked:
            yield Skipped(self.code, _NONE)


def _delayed(case: Case) -> Iterator[tuple[WrittenActuator, float]]:
    """Actuators with a delay, and their step [s]."""
    for found in written_actuators(case, b"delay"):
        step = found.artifact.robot.timestep if found.artifact.robot is not None else None
        # The text alone does not know a delay without nsample, which MuJoCo refuses.
        if step is not None and step > 0.0 and found.view.delay > 0.0 and "delay" not in found.view.unknown:
            yield found, step


def _samples(found: WrittenActuator) -> int | None:
    owner = found.owner("nsample")
    value = numbers(owner.get("nsample"), 1) if owner is not None else ()
    return int(value[0]) if value and math.isfinite(value[0]) else None


def _is_interpolated(found: WrittenActuator) -> bool:
    owner = found.owner("interp")
    return owner is not None and owner.get("interp") != "zoh"


def _samples_fix(found: WrittenActuator, steps: int) -> Fix | None:
    attribute = found.element.attributes.get("nsample")
    if attribute is None or found.document.is_repeated(found.element):
        return None
    path = found.document.files[found.element.file].path
    edit = TextEdit(path, attribute.value_start, attribute.value_end, format_number(steps).encode())
    # What the histories of other actuators hold stays, but they move.
    fields = ("actuator_history", "actuator_historyadr", "nhistory")
    return Fix(f'Set nsample="{steps}"', Safety.UNSAFE, (edit,), fields)


def _ms(seconds: float) -> str:
    return format_quantity(1000.0 * seconds, "ms", 3)


_ENDS = {
    Framework.ISAACLAB: ("min_delay", "max_delay"),
    Framework.MJLAB: ("delay_min_lag", "delay_max_lag"),
}


class DelayRangeLost(Rule):
    """A range of delays is empty, or is not drawn from.

    ## What it does
    Reports actuator groups of Isaac Lab and mjlab whose least delay is greater than the greatest, where 3.0 or later of
    Isaac Lab is named and the two differ, and mjlab groups that hold their lag with probability 1.

    ## Why it matters
    An empty range raises an error when the robot is made (mjlab) or first reset (Isaac Lab). Isaac Lab 3.0 runs its
    explicit drives as Newton actuators, which have one delay, the greatest: every environment gets it, and a policy
    that was to learn a range of delays learns one. A lag that is held with probability 1 stays 0 for ever.

    ## Example
    ```python robot_cfg.py
    from isaaclab.actuators import DelayedPDActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": DelayedPDActuatorCfg(
                joint_names_expr=[".*"], effort_limit=45.0, stiffness=60.0, damping=1.5, min_delay=4, max_delay=0
            )
        }
    )
    ```

    ## Use instead
    ```python robot_cfg.py
    from isaaclab.actuators import DelayedPDActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": DelayedPDActuatorCfg(
                joint_names_expr=[".*"], effort_limit=45.0, stiffness=60.0, damping=1.5, min_delay=0, max_delay=4
            )
        }
    )
    ```

    ## Limits
    For Isaac Lab 3.0 its default `use_newton_actuators=True` is assumed.

    ## Source
    Isaac Lab 2.3.2, actuator_pd.py (`torch.randint` at reset) and the documentation of 3.0 (read, not run);
    mjlab 1.6.0, actuator/actuator.py and utils/buffers/delay_buffer.py, measured.
    """

    code = "DLY103"
    name = "delay-range-lost"
    severity = Severity.ERROR
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare the ends."""
        looked = False
        for _, artifact in case.of_kind(FileKind.CFG):
            config = artifact.config
            if config is None or config.framework not in _ENDS:
                continue
            for group in config.groups:
                most = group.settings.get(_ENDS[config.framework][1])
                if most is None:
                    continue
                looked = True
                yield from self._group(case, config, group, most)
        if not looked:
            yield Skipped(self.code, "no configuration with delays among the files")

    def _group(
        self, case: Case, config: RobotConfig, group: ActuatorGroup, most: Setting
    ) -> Iterator[Finding]:
        names = _ENDS[config.framework]
        least = group.settings.get(names[0])
        low, high = 0.0 if least is None else least.number, most.number
        if high is None:
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
            if low is not None and low < high and named is not None and release(named) >= (3,):
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
            )


RULES: tuple[type[Rule], ...] = (DelayBetweenSteps, SamplesDoNotFit, DelayRangeLost)
