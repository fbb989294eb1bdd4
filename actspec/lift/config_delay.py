"""The delay of a configuration's command: physics steps in the frameworks, seconds in a deploy file."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from actspec.diagnostics import Span
from actspec.ir import Delay, Quantity
from actspec.readings.artifact import ActuatorGroup, Framework, RobotConfig, Setting
from actspec.readings.quantities import stated, tidy, unknown
from actspec.readings.versions import Versions, is_native

HELD_FROM = 1_000_000
"""Steps between two draws from which on a lag is held for an episode. Chosen: hours at any physics step."""


@dataclass(frozen=True, slots=True)
class DelayReading:
    """A delay, and what a spec cannot hold of it."""

    delay: Delay | None
    notes: tuple[str, ...] = ()


def delay_of(
    config: RobotConfig,
    group: ActuatorGroup,
    versions: Versions,
    physics_dt: float | None,
    of_joint: Callable[[str, str], Quantity | None],
) -> DelayReading:
    """The delay of one joint.

    Args:
        config: The configuration.
        group: The joint's group.
        versions: Isaac Lab 3.0 has one lag, the largest.
        physics_dt: Length of a step [s]; None: unknown.
        of_joint: A setting of the joint by its name, in a unit.
    """
    if config.framework is Framework.DEPLOY:
        return _in_seconds(of_joint)
    if config.framework is Framework.MJLAB:
        low, high = (group.settings.get(f"delay_{end}_lag") for end in ("min", "max"))
        sampling, notes = _mjlab_sampling(group)
    else:
        low, high = (group.settings.get(f"{end}_delay") for end in ("min", "max"))
        sampling, notes = "episode", ()
        if is_native(versions):
            low = high
    if high is None:
        return DelayReading(None)
    most = high.number
    least = 0.0 if low is None else low.number
    if least is None or most is None:
        nothing = unknown("s", high.unknown or (low.unknown if low else None), high.span)
        return DelayReading(Delay(nothing, 0.0, 0.0, sampling))
    if most == 0.0 == least:
        return DelayReading(None)
    span = f"{most:g}" if least == most else f"{least:g} to {most:g}"
    if not _is_range(least, most):
        return DelayReading(None, (f"delay: {span} physics steps, which is none",))
    if physics_dt is None:
        note = f"{span} physics steps, whose length no file says"
        return DelayReading(Delay(unknown("s", note, high.span), 0.0, 0.0, sampling), (f"delay: {note}",))
    ends = tidy(least * physics_dt), tidy(most * physics_dt)
    formula = f"{span} steps x {physics_dt:g} s"
    if least == most:
        return DelayReading(Delay(stated(ends[1], "s", high.span, formula=formula), *ends, "episode"))
    return DelayReading(Delay(unknown("s", f"a range: {formula}", high.span), *ends, sampling), notes)


def _in_seconds(of_joint: Callable[[str, str], Quantity | None]) -> DelayReading:
    nominal, low, high = (of_joint(name, "s") for name in ("delay", "delay_low", "delay_high"))
    if nominal is None and (low is None or high is None):
        return DelayReading(None)
    ends = [end.value for end in (low, high) if end is not None and end.value is not None]
    if len(ends) != 2:
        value = 0.0 if nominal is None or nominal.value is None else nominal.value
        ends = [value, value]
    middle = ends[0] if nominal is None or nominal.value is None else nominal.value
    if not (_is_range(ends[0], middle) and _is_range(middle, ends[1])):
        return DelayReading(None, (f"delay: {middle:g} s in {ends[0]:g} to {ends[1]:g} s, which is none",))
    place: Span | None = None if high is None else high.span
    return DelayReading(Delay(nominal or unknown("s", "a range", place), ends[0], ends[1], "episode"))


def _is_range(low: float, high: float) -> bool:
    return 0.0 <= low <= high < math.inf


def _mjlab_sampling(group: ActuatorGroup) -> tuple[str, tuple[str, ...]]:
    """When mjlab draws a lag anew. Source: mjlab 1.6.0, actuator.py; without a period, in every step."""

    def number(name: str) -> float:
        setting: Setting | None = group.settings.get(name)
        return (setting.number if setting is not None else None) or 0.0

    period, hold = number("delay_update_period"), number("delay_hold_prob")
    notes = []
    if hold:
        notes.append(
            f"delay: a lag is kept with probability {hold:g} (delay_hold_prob), a spec has no word for it"
        )
    if period >= HELD_FROM:
        return "episode", tuple(notes)
    if period > 1:
        notes.append(f"delay: a lag is drawn every {period:g} steps, a spec has every step or every episode")
    return "step", tuple(notes)
