"""Checks of times that need no robot: steps, control periods, delays, cutoffs and bandwidths."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator

from actspec.diagnostics import Path, alternatives
from actspec.spec.document import SourceMap
from actspec.spec.fields import CONTROL_PERIOD, STEP, SpecDelay
from actspec.spec.models import Actuators, CommandFilter, SpecModel
from actspec.spec.plausible.groups import layers
from actspec.spec.plausible.slips import amount_of
from actspec.spec.plausible.table import Doubt, at
from actspec.spec.rules.groups import range_of
from actspec.spec.values import SpecValue
from actspec.units import format_quantity

LEGS_RATE = 20.0
"""Rate of a policy that walks [Hz]. Published: 20 (A1, "A Walk in the Park"), 50 of nearly all, to 200."""
NO_LEGS_RATE = 10.0
"""Below it no legs are controlled, whatever the step; from it to `LEGS_RATE` only a rate in place of steps is told."""
RATES = frozenset((25, 30, 40, 50, 60, 100, 120, 200, 250, 400, 500))
"""Rates of policies as they are quoted [Hz]."""
_LEGS = re.compile(r"(?<![a-z])(?:legs?|kn|kfe|hfe|haa)(?![a-z])|knee|calf|shank|thigh|ankle", re.IGNORECASE)
"""What joints and groups of legs are called. An arm may be controlled at 3 Hz (RT-1): nothing tells a slip there."""
DELAY = (20e-6, 0.25)
"""[s]. Of a step of 2 ms the least is the hundredth from which on `compile` tells what is lost."""
CUTOFF = (0.2, 5e3)
"""[Hz]."""
BANDWIDTH = (2.0, 20e3)
"""Of the torque or current loop [Hz]. Chosen: drives with springs and with air have 3 Hz and more, and
0.5 to 1.5 are of a current loop in kHz."""
STEP_RATES = frozenset((100, 120, 200, 240, 250, 400, 500, 1000))
"""Rates of simulations as they are quoted [Hz]."""
ROUNDED = 1.0 - 1e-9
"""Times that differ by less are the same."""
WRONG_BY = 10.0
"""A time outside of its bounds by this factor is an error."""


def time_doubts(model: SpecModel, spans: SourceMap, joints: Iterable[str] = ()) -> Iterator[Doubt]:
    """Time step, control period, delays, cutoffs and bandwidths.

    Args:
        model: What the spec says.
        spans: Where it says it.
        joints: Names of the robot's joints, as far as they are known.
    """
    step = model.timing.physics_dt
    if step is not None and step.value is not None:
        yield from _time(step, ("timing", "physics_dt"), STEP, "a simulation step", spans)
        if step.value <= STEP[1]:
            yield from _control(step, model, joints, spans)
    control = model.timing.control_dt
    if control is not None:
        yield from _time(control, ("timing", "control_dt"), CONTROL_PERIOD, "a control period", spans)
    for name, motor in model.motors.items():
        if motor.bandwidth is not None:
            path: Path = ("motors", name, "bandwidth")
            yield from _time(motor.bandwidth, path, BANDWIDTH, "the bandwidth of a drive", spans)
    for group_path, fields, group in layers(model):
        delay, cutoff = fields.delay, fields.command_filter
        if isinstance(delay, SpecDelay):
            path = (*group_path, "delay")
            ends = [] if delay.range is None else [(delay.range[1], (*path, "range", 1))]
            plain = _is_plain(path, spans)
            drawn = list(_drawn_delay(group, (*group_path, "randomize", "delay"))) if fields is group else []
            for value, place in [(delay.nominal, path if plain else (*path, "nominal")), *ends, *drawn]:
                late = list(_time(value, place, DELAY, "a delay of the command", spans))
                yield from late
                if late:
                    # The range is about it.
                    break
        if fields is group:
            yield from _too_often(model, group, (*group_path, "randomize"), spans)
        if isinstance(cutoff, CommandFilter):
            path = (*group_path, "command_filter", "cutoff")
            yield from _time(cutoff.cutoff, path, CUTOFF, "the cutoff of a command", spans)


def _drawn_delay(group: Actuators, path: Path) -> Iterator[tuple[SpecValue, Path]]:
    """Times that are drawn, or added to the nominal one, the largest first; of factors others judge."""
    entry = group.randomize.get("delay")
    pair = (
        None
        if entry is None or entry.from_ is not None or entry.scale is not None
        else range_of(entry, "delay")
    )
    if entry is not None and isinstance(pair, tuple):
        operation = "abs" if entry.add is None else "add"
        ends = [(end, (*path, operation, index)) for index, end in enumerate(pair)]
        if operation == "add":
            # A difference may be below 0, or as small as one likes.
            ends = [(end, place) for end, place in ends if (end.value or 0.0) >= DELAY[0]]
        yield from sorted(ends, key=lambda end: -(end[0].value or 0.0))


def _too_often(model: SpecModel, group: Actuators, path: Path, spans: SourceMap) -> Iterator[Doubt]:
    """Draws in shorter intervals than commands; 0 is a draw at each command."""
    step, decimation = model.timing.physics_dt, model.timing.decimation
    if step is None or step.value is None or decimation is None:
        return
    period = step.value * decimation
    for field, entry in group.randomize.items():
        if entry.every is None or not 0.0 < (entry.every[1].value or 0.0) < period * ROUNDED:
            continue
        low, high = entry.every
        message = (
            f"a draw after every {low.written} to {high.written}, in less than the control period of "
            f"{format_quantity(1e3 * period, 'ms', 4)}"
        )
        ends = [format_quantity(1e3 * (end.value or 0.0), "s", 4) for end in entry.every]
        help = f"did you mean [{', '.join(ends)}]? `when: reset` draws once an episode"
        place = (*path, field, "every")
        yield at(spans, "SPEC186", message, (*place, 1), help, (*place, 0), ("timing", "decimation"))


def _control(step: SpecValue, model: SpecModel, joints: Iterable[str], spans: SourceMap) -> Iterator[Doubt]:
    """A control period that nothing is controlled with, or no legs are, such as a rate in Hz as a number of steps."""
    decimation = model.timing.decimation or 1
    period = (step.value or 0.0) * decimation
    if not period:
        return
    rate = 1.0 / period
    # Of 5 ms 50 steps are 4 Hz, and 4 steps 50 Hz.
    turned = round(rate) if decimation in RATES and math.isclose(rate, round(rate), rel_tol=1e-6) else 0
    if period > CONTROL_PERIOD[1]:
        most = f"a control period of {period:g} s: {_usual(CONTROL_PERIOD[1], 's')} at most"
    elif rate < (LEGS_RATE if turned else NO_LEGS_RATE) and _has_legs(model, joints):
        most = f"a policy of {format_quantity(rate, 'Hz', 3)}: legs have {LEGS_RATE:g} Hz and more"
    else:
        return
    help = "decimation is the number of simulation steps in one control step"
    help = f"did you mean {turned} ({decimation} Hz)? {help}" if turned else f"{help}, such as 4"
    path: Path = ("timing", "decimation")
    message = f"{decimation} steps of {step.written} are {most}"
    yield at(spans, "SPEC186", message, path, help, ("timing", "physics_dt"))


def _has_legs(model: SpecModel, joints: Iterable[str]) -> bool:
    """Whether groups, patterns or joints are called like those of legs."""
    patterns = (
        pattern for group in model.actuators.values() for pattern in (*group.joints, *group.overrides)
    )
    return any(
        _LEGS.search(name) for name in (*model.actuators, *patterns, *model.robot.default_pose, *joints)
    )


def _is_plain(path: Path, spans: SourceMap) -> bool:
    """Whether a delay is one number, not {nominal, range}."""
    return spans.value((*path, "nominal")) == spans.value(path)


def _time(
    value: SpecValue, path: Path, bounds: tuple[float, float], what: str, spans: SourceMap
) -> Iterator[Doubt]:
    """A time or frequency outside of its bounds; 0 is none."""
    low, high = bounds
    if value.value is None or value.value == 0.0 or low <= value.value <= high:
        return
    yield at(
        spans,
        "SPEC186",
        f"{value.written} is no usual size of {what}: {_usual(low, value.unit)} to {_usual(high, value.unit)}",
        path,
        alternatives(_meant(value, bounds)) or "look for a wrong unit, or the point in the wrong place",
        # A delay of nearly none is as harmless as none.
        error=value.value > WRONG_BY * high or (value.value < low / WRONG_BY and bounds is not DELAY),
    )


def _meant(value: SpecValue, bounds: tuple[float, float]) -> Iterator[str]:
    """What a time or frequency outside of its bounds may have been."""
    size, (low, high) = value.value or 0.0, bounds
    if value.unit == "Hz":
        amount, unit = amount_of(value)
        if unit == "mHz":
            # Nobody's filter or drive has millihertz.
            units = ((1e3, "kHz"), (1.0, "Hz"))
            yield from (
                f"did you mean {amount:g} {name}?" for by, name in units if low <= by * amount <= high
            )
            return
        # Of a low-pass the time constant is quoted as well; the higher of the two is the more usual one.
        readings = [
            (1e3 * size, "is it in kHz"),
            (0.5 / math.pi / size, f"is it a time constant of {size:g} s"),
        ]
        for meant, words in sorted(readings, reverse=True) if size < low else ():
            if low <= meant <= high:
                yield f"{words}? Then it is {format_quantity(meant, 'Hz', 4)}"
        return
    amount, _ = amount_of(value)
    rated = bounds is STEP and amount in STEP_RATES and size > high
    if rated:
        yield f"is it a rate? The step of {amount:g} Hz is {format_quantity(1e3 / amount, 'ms', 4)}"
    # Of less than a second the thousandth is no usual time. A step has its point in the wrong place then.
    meant = size * (1e3 if size < low else 1e-3 if size >= 1.0 else 0.1 if bounds is STEP else math.inf)
    if low <= meant <= high and not (rated and math.isclose(meant * amount, 1.0)):
        yield f"did you mean {format_quantity(meant * 1e3, 'ms', 4)}?"


def _usual(bound: float, unit: str) -> str:
    """A bound as one writes it: 20 us, 50 ms, 5 kHz."""
    for size, prefix in ((1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "u")):
        if bound >= size:
            return format_quantity(bound / size, f"{prefix}{unit}", 3)
    return f"0 {unit}"
