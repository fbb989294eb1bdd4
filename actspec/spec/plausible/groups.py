"""Checks of timing and of groups that need no robot: times, dry friction, effort limits, kp beside kd, ranges."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from actspec.diagnostics import Path
from actspec.spec.document import SourceMap
from actspec.spec.fields import SpecDelay
from actspec.spec.models import Actuators, CommandFilter, Randomize, SpecModel, Tunable
from actspec.spec.plausible.motors import Drive, Limit
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
FACTOR = 20.0
"""Largest factor of a range of randomisation."""
OFF = {"rad": 0.5, "m": 0.1}
"""Largest error of an encoder [rad or m]."""
LONGEST_RETURN = 1.0
"""kd over kp [s]: the time in which a joint without inertia returns."""


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
    """Every motor, with the limits of the joints that it drives; behind a transmission nothing is compared."""
    limits: dict[str, list[Limit]] = {}
    for path, fields, group in _layers(model):
        name = fields.motor or group.motor
        if name is None or (fields.transmission or group.transmission) is not None:
            continue
        reduction = fields.reduction or group.reduction
        for field in ("effort_limit", "velocity_limit"):
            value = getattr(fields, field)
            if isinstance(value, SpecValue):
                factor = None if reduction is None else reduction.value
                count = fields.motors_per_joint or group.motors_per_joint or 1
                limits.setdefault(name, []).append(Limit(value, (*path, field), factor or 1.0, count))
    for name, motor in model.motors.items():
        yield Drive(name, motor, tuple(limits.get(name, ())))


def group_doubts(model: SpecModel, spans: SourceMap) -> Iterator[Doubt]:
    """What can hardly be right about groups; an override's fields are judged with those of its group."""
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
        if (own_kp or own_kd) and isinstance(kp, SpecValue) and isinstance(kd, SpecValue):
            words = return_words(kp.value or 0.0, kd.value or 0.0, kp.written, kd.written)
            if words is not None:
                yield at(spans, "SPEC192", words[0], kp_path, words[1], kd_path)
    for name, group in model.actuators.items():
        for field, entry in group.randomize.items():
            yield from _drawn(entry, field, ("actuators", name, "randomize", field), spans)


def _drawn(entry: Randomize, field: str, path: Path, spans: SourceMap) -> Iterator[Doubt]:
    """A range of factors as per cent, or of an encoder's errors in degrees."""
    if entry.from_ is not None or (entry.scale is None and field != "encoder_bias"):
        return
    operation = "scale" if entry.scale is not None else "add" if entry.add is not None else "abs"
    pair = range_of(entry, field)
    for index, end in enumerate(() if isinstance(pair, Fault) else pair):
        place, value = (*path, operation, index), end.value or 0.0
        if entry.scale is not None and value > FACTOR:
            message = f"a factor of {end.written} on the nominal value"
            yield at(spans, "SPEC188", message, place, f"is it in %? Then write {value / 100.0:g}")
        elif entry.scale is None and abs(value) > OFF.get(end.unit, math.inf):
            message = f"an encoder that is off by {end.written}"
            help = f"is it in degrees? Then write {value:g} deg" if end.unit == "rad" else None
            yield at(spans, "SPEC188", message, place, help)


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


def return_words(kp: float, kd: float, shown_kp: str, shown_kd: str) -> tuple[str, str | None] | None:
    """What kd implies beside kp: message and help; None where a joint without inertia returns soon."""
    if not kp or kd / kp <= LONGEST_RETURN:
        return None
    message = (
        f"kd {shown_kd} beside kp {shown_kp}: the joint would take {format_quantity(kd / kp, 's', 3)} to come back to "
        "its command"
    )
    back = kp / kd <= LONGEST_RETURN / 2.0
    return message, "are the two exchanged? kp is the stiffness, kd the velocity gain" if back else None
