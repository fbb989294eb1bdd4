"""Checks of timing and of groups that need no robot: times, dry friction, effort limits, kp beside kd, ranges."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import Any

from actspec.diagnostics import Path, dotted
from actspec.spec.document import SourceMap
from actspec.spec.fields import DerivedGain, SpecDelay
from actspec.spec.models import Actuators, CommandFilter, Randomize, SpecModel, Tunable
from actspec.spec.plausible.gains import Gains, derived_doubts, gain_words
from actspec.spec.plausible.motors import NEVER_GEARED_UP, Drive, Limit
from actspec.spec.plausible.table import Doubt, at
from actspec.spec.rules.groups import range_of
from actspec.spec.values import Fault, SpecValue
from actspec.units import format_quantity

STEP = (20e-6, 50e-3)
"""Simulation step [s]."""
CONTROL_PERIOD = (20e-6, 0.5)
"""[s]."""
DELAY = (0.0, 0.25)
"""[s]."""
CUTOFF = (0.2, 5e3)
"""[Hz]."""
BANDWIDTH = (0.5, 20e3)
"""[Hz]."""
WRONG_BY = 10.0
"""A time outside of its bounds by this factor is an error."""
FRICTION_SHARE = 0.5
"""Of the effort limit."""
FRICTION_STOPS = 2.0
"""Times the effort limit: an error."""
FACTOR = 10.0
"""Largest factor of a range of randomisation. Published: 3, on kd."""
DIGIT = 50.0
"""Above it a factor is in per cent, below it one without its point."""
OFF = {"rad": 0.25, "m": 0.1}
"""Largest error of an encoder [rad or m]. Published: 0.02 rad."""


def time_doubts(model: SpecModel, spans: SourceMap) -> Iterator[Doubt]:
    """Time step, control period, delays, cutoffs and bandwidths."""
    step = model.timing.physics_dt
    if step is not None and step.value is not None:
        path: Path = ("timing", "physics_dt")
        yield from _time(step, path, STEP, "a simulation step", spans)
        period = step.value * (model.timing.decimation or 1)
        if step.value <= STEP[1] and period > CONTROL_PERIOD[1]:
            message = (
                f"{model.timing.decimation} steps of {step.written} are a control period of {period:g} s"
            )
            yield at(spans, "SPEC186", message, ("timing", "decimation"), None, path)
    for name, motor in model.motors.items():
        if motor.bandwidth is not None:
            path = ("motors", name, "bandwidth")
            yield from _time(motor.bandwidth, path, BANDWIDTH, "the bandwidth of a drive", spans)
    for group_path, fields, _ in _layers(model):
        delay, cutoff = fields.delay, fields.command_filter
        if isinstance(delay, SpecDelay):
            path = (*group_path, "delay")
            ends = [] if delay.range is None else [(delay.range[1], (*path, "range", 1))]
            plain = _is_plain(path, spans)
            for value, place in [(delay.nominal, path if plain else (*path, "nominal")), *ends]:
                yield from _time(value, place, DELAY, "a delay of the command", spans)
        if isinstance(cutoff, CommandFilter):
            path = (*group_path, "command_filter", "cutoff")
            yield from _time(cutoff.cutoff, path, CUTOFF, "the cutoff of a command", spans)


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
    milli = value.unit == "s" and low <= value.value / 1000.0 <= high
    yield at(
        spans,
        "SPEC186",
        f"{value.written} is no usual size of {what}: {_usual(low, value.unit)} to {_usual(high, value.unit)}",
        path,
        f"did you mean {value.value:g} ms?" if milli else None,
        error=value.value > WRONG_BY * high or value.value < low / WRONG_BY,
    )


def _usual(bound: float, unit: str) -> str:
    """A bound as one writes it: 20 us, 50 ms, 5 kHz."""
    for size, prefix in ((1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "u")):
        if bound >= size:
            return format_quantity(bound / size, f"{prefix}{unit}", 3)
    return f"0 {unit}"


def _layers(model: SpecModel) -> Iterator[tuple[Path, Tunable, Actuators]]:
    """Each group's own fields, then those of each override."""
    for name, group in model.actuators.items():
        path: Path = ("actuators", name)
        yield path, group, group
        for pattern, override in group.overrides.items():
            yield (*path, "overrides", pattern), override, group


def drives_of(model: SpecModel) -> Iterator[Drive]:
    """Every motor, with the limits of the joints that it drives.

    Behind a transmission nothing is compared, nor by a reduction that is doubted itself.
    """
    limits: dict[str, list[Limit]] = {}
    for path, fields, group in _layers(model):
        name = fields.motor or group.motor
        if name is None or (fields.transmission or group.transmission) is not None:
            continue
        reduction = fields.reduction or group.reduction
        if reduction is not None and _is_geared_up(reduction):
            continue
        for field in ("effort_limit", "velocity_limit"):
            value = getattr(fields, field)
            if isinstance(value, SpecValue):
                factor = None if reduction is None else reduction.value
                count = fields.motors_per_joint or group.motors_per_joint or 1
                limits.setdefault(name, []).append(Limit(value, (*path, field), factor or 1.0, count))
    for name, motor in model.motors.items():
        yield Drive(name, motor, tuple(limits.get(name, ())))


def group_doubts(model: SpecModel, spans: SourceMap, doubted: Collection[str]) -> Iterator[Doubt]:
    """What can hardly be right about groups; an override's fields are judged with those of its group.

    Args:
        model: What the spec says.
        spans: Where it says it.
        doubted: Places of limits that are doubted themselves, and tell nothing of gains.
    """
    for path, fields, group in _layers(model):
        base: Path = path[:2]

        def stated(
            key: str, path: Path = path, base: Path = base, fields: Any = fields, group: Any = group
        ) -> tuple[Any, Path, bool]:
            """A field of the layer, else of the group; where; and whether it is the layer's."""
            own = getattr(fields, key)
            return (
                (own, (*path, key), True) if own is not None else (getattr(group, key), (*base, key), False)
            )

        limit, limit_path, own_limit = stated("effort_limit")
        friction, friction_path, own_friction = stated("friction")
        if friction is not None and (own_limit or own_friction) and isinstance(limit, SpecValue):
            coulomb: SpecValue | None = friction.coulomb
            if coulomb is not None and coulomb.value is not None and limit.value is not None:
                place = (*friction_path, "coulomb")
                yield from _friction(coulomb, place, limit, limit_path, spans)
        kp, kp_path, own_kp = stated("kp")
        kd, kd_path, own_kd = stated("kd")
        for gain, place, own in ((kp, kp_path, own_kp), (kd, kd_path, own_kd)):
            if own and isinstance(gain, DerivedGain):
                yield from derived_doubts(gain, place, spans)
        if (own_kp or own_kd) and isinstance(kp, SpecValue) and isinstance(kd, SpecValue):
            sound = isinstance(limit, SpecValue) and not limit.linear and dotted(limit_path) not in doubted
            known = limit.value if sound else None
            viscous = 0.0 if friction is None or friction.viscous is None else friction.viscous.value or 0.0
            driven = stated("motor")[0] in model.motors
            force = "N" if kp.linear or kd.linear else "N*m"
            found = gain_words(Gains(kp.value or 0.0, kd.value or 0.0, viscous, known, driven, force))
            if found is not None:
                field, message, help = found
                places = (kp_path, kd_path) if field == "kp" else (kd_path, kp_path)
                yield at(spans, "SPEC192", message, places[0], help, places[1])
        bias = fields.encoder_bias
        if bias is not None and _is_off(bias):
            yield _off([bias], (*path, "encoder_bias"), (), spans)
        reduction = fields.reduction
        if reduction is not None and _is_geared_up(reduction):
            yield _geared_up(reduction, (*path, "reduction"), spans)
    for name, group in model.actuators.items():
        for field, entry in group.randomize.items():
            yield from _drawn(entry, field, ("actuators", name, "randomize", field), spans)


def _is_geared_up(reduction: SpecValue) -> bool:
    """Whether the joint turns faster than the output of its motor."""
    return bool(reduction.value) and (reduction.value or 0.0) < 1.0


def _geared_up(reduction: SpecValue, path: Path, spans: SourceMap) -> Doubt:
    """A joint that turns faster than the output of its motor; published: 1.5 (knees of Go1 and Go2)."""
    inverse = format_quantity(1.0 / (reduction.value or 1.0), "", 3)
    return at(
        spans,
        "SPEC182",
        f"{reduction.written} turns of the motor's output in one turn of the joint: the joint turns {inverse} times as "
        "fast",
        path,
        f"did you mean {inverse}? reduction is turns of the motor's output in one turn of the joint",
        error=(reduction.value or 1.0) < NEVER_GEARED_UP,
    )


def _drawn(entry: Randomize, field: str, path: Path, spans: SourceMap) -> Iterator[Doubt]:
    """A range of factors as per cent, or of an encoder's errors in degrees."""
    if entry.from_ is not None or (entry.scale is None and field != "encoder_bias"):
        return
    operation = "scale" if entry.scale is not None else "add" if entry.add is not None else "abs"
    pair = range_of(entry, field)
    ends = () if isinstance(pair, Fault) else pair
    factors = entry.scale is not None
    wrong = [
        (index, end)
        for index, end in enumerate(ends)
        if ((end.value or 0.0) > FACTOR if factors else _is_off(end))
    ]
    if not wrong:
        return
    far = [end for _, end in wrong]
    first, second = (*path, operation, wrong[0][0]), (*path, operation, wrong[-1][0])
    if not factors:
        yield _off(far, first, (second,), spans)
        return
    what = "factors" if len(far) > 1 else "a factor"
    message = f"{what} of {_all(end.written for end in far)} on the nominal value"
    percent = any((end.value or 0.0) > DIGIT for end in far)
    meant = _all(f"{(end.value or 0.0) / (100.0 if percent else 10.0):g}" for end in far)
    help = f"is it in %? Then write {meant}" if percent else f"did you mean {meant}?"
    yield at(spans, "SPEC188", message, first, help, second)


def _is_off(bias: SpecValue) -> bool:
    """Whether no encoder is that wrong."""
    return abs(bias.value or 0.0) > OFF.get(bias.unit, math.inf)


def _off(ends: Sequence[SpecValue], path: Path, others: tuple[Path, ...], spans: SourceMap) -> Doubt:
    """An encoder that is off by far."""
    help = None
    if ends[0].unit == "rad" and "deg" not in ends[0].written:
        help = f"is it in degrees? Then write {_all(f'{end.value:g} deg' for end in ends)}"
    message = f"an encoder that is off by {_all(end.written for end in ends)}"
    return at(spans, "SPEC188", message, path, help, *others)


def _all(texts: Iterable[str]) -> str:
    return " and ".join(texts)


def _friction(
    coulomb: SpecValue, path: Path, limit: SpecValue, limit_path: Path, spans: SourceMap
) -> Iterator[Doubt]:
    """Dry friction against the effort limit, both stated."""
    assert coulomb.value is not None and limit.value is not None
    found = friction_words(coulomb.value, coulomb.unit, limit.value, limit.unit)
    if found is not None:
        message, help, error = found
        yield at(spans, "FRC101", message, path, help, limit_path, error=error)


def friction_words(coulomb: float, unit: str, limit: float, limit_unit: str) -> tuple[str, str, bool] | None:
    """What dry friction implies: message, help, whether it is an error; None where it is a small part of the limit."""
    if coulomb < FRICTION_SHARE * limit:
        return None
    shown, most = format_quantity(coulomb, unit), format_quantity(limit, limit_unit)
    if coulomb < limit:
        message = (
            f"the dry friction of {shown} takes {100 * coulomb / limit:.0f} % of the effort limit of {most}"
        )
    else:
        message = f"the dry friction of {shown} is not below the effort limit of {most}"
        message += ": the drive cannot move the joint"
    help = f"is it in m{unit} ({format_quantity(coulomb / 1000, unit)}), or a dimensionless coefficient?"
    return message, help, coulomb >= FRICTION_STOPS * limit
