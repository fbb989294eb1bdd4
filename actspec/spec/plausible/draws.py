"""Ranges of randomisation that nobody draws from: factors, values in place of the nominal one, errors of an encoder."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

from actspec.diagnostics import Path, alternatives
from actspec.fields import BY_SPEC, FRICTION_SHARE, LARGEST_FACTOR, largest_factor
from actspec.ir import JointActuator, Origin, Quantity
from actspec.spec.document import SourceMap
from actspec.spec.models import Actuators, Randomize, SpecModel
from actspec.spec.plausible.relations import DEGREE, POINT
from actspec.spec.plausible.table import Doubt, Found, at, shown
from actspec.spec.rules.groups import RANDOMIZED_KINDS, range_of
from actspec.spec.values import Fault, SpecValue
from actspec.units import Kind, format_quantity

DIGIT = 50.0
"""Above it two factors are in per cent, below it they are without their points."""
ABOUT_NOMINAL = 2.0
"""The mean of a gaussian is about the nominal value by this factor. Chosen."""
VALUES = 3.0
"""Above it both ends of a range of factors may be values. Published: 3 is the most that a factor is."""
OFF = {"rad": 0.25, "m": 0.1}
"""Largest error of an encoder [rad or m]. Published: 0.02 rad."""


def draw_doubts(
    group: Actuators, path: Path, limit: float | None, drawn: bool, spans: SourceMap
) -> Iterator[Doubt]:
    """What can hardly be right about the ranges of a group.

    Args:
        group: The group.
        path: Where it stands.
        limit: Effort limit of a hinge [N*m]; None: unknown, doubted itself, or of a slide.
        drawn: A target draws from them, and tells of values below 0 itself (RND004).
        spans: Where the spec says it.
    """
    for field, entry in group.randomize.items():
        place = (*path, "randomize", field)
        found = list(_drawn(entry, field, place, group, spans))
        if not drawn:
            found += _negative(entry, field, place, group, spans)
        yield from found
        rub = _dry(field, group)
        takes = limit and rub is not None and (rub.value or 0.0) >= FRICTION_SHARE * limit
        # Where the nominal friction takes the limit it is told itself, and may be the wrong one.
        if not found and not takes:
            replaced = list(_replaced(entry, field, place, group, spans))
            yield from replaced or _rubbing(entry, field, place, limit, rub, spans)


def _operation(entry: Randomize) -> str:
    """Which of the three a range is stated for."""
    return "scale" if entry.scale is not None else "add" if entry.add is not None else "abs"


def _drawn(entry: Randomize, field: str, path: Path, group: Actuators, spans: SourceMap) -> Iterator[Doubt]:
    """A range of factors as per cent, or of an encoder's errors in degrees."""
    if entry.from_ is not None or (entry.scale is None and field != "encoder_bias"):
        return
    operation = _operation(entry)
    pair = range_of(entry, field)
    ends = () if isinstance(pair, Fault) else pair
    factors = entry.scale is not None
    most = largest_factor(field)
    wrong = [
        (index, end)
        for index, end in enumerate(ends)
        if ((end.value or 0.0) > most if factors else is_off(end))
    ]
    least = min((end.value or 0.0 for end in ends), default=0.0)
    if factors and not wrong and entry.distribution != "gaussian" and least > VALUES:
        # That the nominal value is in the range which it would be multiplied by is no accident.
        values = _values(ends, entry, field, group, most)
        wrong = list(enumerate(ends)) if values is not None and values[1] is not None else []
    if not wrong:
        return
    far = [end for _, end in wrong]
    first, second = (*path, operation, wrong[0][0]), (*path, operation, wrong[-1][0])
    if not factors:
        yield off(far, first, (second,), spans)
        return
    what = "factors" if len(far) > 1 else "a factor"
    message = f"{what} of {_all(end.written for end in far)} on the nominal value"
    percent = len(far) > 1 and any((end.value or 0.0) > DIGIT for end in far)
    # One end alone has its point in the wrong place: without that it is near 1.
    by = 100.0 if percent else 10.0 ** round(math.log10(far[-1].value or 1.0))
    if not percent and len(ends) == 2 and (ends[0].value or 0.0) > (far[-1].value or 0.0) / by:
        # One end alone in its place would leave the range the wrong way round.
        far = list(ends)
    told = [(end.value or 0.0) / by for end in far]
    sound = _is_around([*((end.value or 0.0) for end in ends[: 2 - len(far)]), *told], entry)
    help = f"did you mean {_numbers(told)}?" if sound else POINT
    if percent:
        help = f"is it in %? Then write {_numbers(told)}"
    if most < LARGEST_FACTOR:
        message += f": no motor gives {most:g} times its torque"
        help = POINT if (far[-1].value or 0.0) <= LARGEST_FACTOR else help
    values = _values(ends, entry, field, group, most)
    if values is not None:
        own, meant = values
        same = meant is not None and _numbers(meant) == _numbers(told)
        help = alternatives([own, help]) if sound and not same else own
    yield at(spans, "SPEC188", message, first, help, second)


def _values(
    ends: Sequence[SpecValue], entry: Randomize, field: str, group: Actuators, most: float
) -> tuple[str, list[float] | None] | None:
    """Factors that are values: the help, and what they are of the nominal one, if that is known; None: they are none.

    A factor of 1 or less is one.
    """
    kind = RANDOMIZED_KINDS[field]
    if kind is Kind.RATIO or not kind.bare or (ends[0].value or 0.0) <= 1.0:
        return None
    nominal = _nominal(field, group)
    sizes = [end.value or 0.0 for end in ends]
    if nominal is None or not nominal.value:
        return f"are they values? Then write `abs: [{', '.join(f'{size:g}' for size in sizes)}]`", None
    factors = [size / nominal.value for size in sizes]
    if not _is_around(factors, entry) or max(factors) > most:
        return None
    written = ", ".join(format_quantity(size, nominal.unit) for size in sizes)
    scale = ", ".join(f"{factor:.4g}" for factor in factors)
    return f"are they values? Then write `abs: [{written}]`, or `scale: [{scale}]`", factors


def _is_around(factors: Sequence[float], entry: Randomize) -> bool:
    """Whether factors leave the nominal value in the range, or of a gaussian its mean about there."""
    if entry.distribution == "gaussian":
        return 1.0 / ABOUT_NOMINAL <= factors[0] <= ABOUT_NOMINAL
    return factors[0] <= 1.0 <= factors[-1]


def _replaced(
    entry: Randomize, field: str, path: Path, group: Actuators, spans: SourceMap
) -> Iterator[Doubt]:
    """A range in place of a nominal value, all of it far from that."""
    pair = None if entry.abs is None else range_of(entry, field)
    if not isinstance(pair, tuple):
        return
    gaussian = entry.distribution == "gaussian"
    low, high = (pair[0], pair[0]) if gaussian else pair
    nominal = _nominal(field, group)
    if nominal is None or low.value is None or high.value is None:
        return
    bare = low.linear is None and high.linear is None
    written = low.written if gaussian else f"{low.written} to {high.written}"
    most = largest_factor(field) if bare else None
    found = _far(low.value, high.value, nominal.value, low.unit, gaussian, most)
    if found is not None:
        far, help = found
        message = f"{written} in place of the nominal {nominal.written} is {far}"
        first, second = (*path, "abs", 0), (*path, "abs", 0 if gaussian else 1)
        place = (*path[:-2], *field.split("."))
        yield at(spans, "SPEC188", message, first, help, second, place)


def _far(
    low: float, high: float, nominal: float | None, unit: str, gaussian: bool, most: float | None
) -> tuple[str, str] | None:
    """How far values in place of a nominal one are from it, and what was meant; None: they may be meant.

    Args:
        low: The lower end, of a gaussian the mean.
        high: The upper end, of a gaussian the mean.
        nominal: The nominal value; None: unknown.
        unit: Of the ends.
        gaussian: Whether it is one.
        most: The largest that a factor is; None: the ends have a unit, and are none.
    """
    if not nominal or nominal < 0.0 or not 0.0 < low <= high:
        return None
    factors = low / nominal, high / nominal
    if factors[1] >= 1.0 / LARGEST_FACTOR and factors[0] <= LARGEST_FACTOR:
        return None
    ten = 10.0 ** round(math.log10(math.sqrt(factors[0] * factors[1])))
    help = "look for a wrong unit, or another joint's range"
    if most is not None and low < 1.0 < high <= most:
        help = f"are they factors? Then write `scale: [{low:g}, {high:g}]`"
    elif gaussian or low <= nominal * ten <= high:
        # What leaves the nominal out again is not meant.
        meant = (format_quantity(end / ten, unit, 4) for end in (low, high)[: 2 - gaussian])
        help = f"did you mean {_all(meant)}?"
    return f"{' to '.join(format_quantity(factor, '', 3) for factor in factors)} times as much", help


def _nominal(field: str, group: Actuators) -> SpecValue | None:
    """The number of a group that a range is about; None where it is none, or follows from others."""
    nominal: Any = group
    for part in field.split("."):
        nominal = None if nominal is None else getattr(nominal, part, None)
    return nominal if isinstance(nominal, SpecValue) else None


def _negative(
    entry: Randomize, field: str, path: Path, group: Actuators, spans: SourceMap
) -> Iterator[Doubt]:
    """Offsets that bring a number below 0 which has no sign; a gaussian's tail is told where it is drawn from."""
    pair, nominal = None if entry.add is None else range_of(entry, field), _nominal(field, group)
    if not isinstance(pair, tuple) or entry.distribution == "gaussian" or field == "encoder_bias":
        return
    if nominal is None or nominal.value is None:
        return
    least = nominal.value + min(end.value or 0.0 for end in pair)
    if least < 0.0:
        yield _below(field, least, pair[0].unit, nominal.written, path, spans)


def _below(field: str, least: float, unit: str, nominal: str, path: Path, spans: SourceMap) -> Doubt:
    message = f"{field} is drawn below 0: {format_quantity(least, unit, 4)}"
    help = f"the nominal is {nominal}: raise the low end"
    return at(spans, "SPEC188", message, (*path, "add", 0), help, (*path, "add", 1))


def drawn_found(joint: JointActuator, model: SpecModel, spans: SourceMap) -> Iterator[Found]:
    """Offsets and values as above about a number that follows from others, as an armature does from its motor."""
    for entry in joint.randomize:
        field = BY_SPEC.get(entry.field)
        nominal = None if field is None else getattr(joint, field.ir, None)
        if not isinstance(nominal, Quantity) or nominal.value is None or nominal.origin is Origin.AUTHORED:
            continue
        path = ("actuators", joint.group, "randomize", entry.field)
        derived, gaussian = nominal.origin is Origin.DERIVED, entry.distribution == "gaussian"
        doubt: Doubt | None = None
        size = 1.0
        if entry.operation == "abs" and derived:
            high, unit = entry.low if gaussian else entry.high, nominal.unit if entry.has_unit else ""
            most = None if unit else largest_factor(entry.field)
            found = _far(entry.low, high, nominal.value, nominal.unit, gaussian, most)
            if found is not None:
                written = " to ".join(
                    format_quantity(end, unit, 4) for end in (entry.low, high)[: 2 - gaussian]
                )
                message = f"{written} in place of the nominal {shown(nominal)} is {found[0]}"
                doubt = at(spans, "SPEC188", message, (*path, "abs", 0), found[1])
                size = max(high / nominal.value, nominal.value / entry.low)
        elif entry.operation == "add" and not (gaussian or entry.field == "encoder_bias" or is_drawn(model)):
            least = nominal.value + entry.low
            if least < 0.0:
                doubt, size = _below(entry.field, least, nominal.unit, shown(nominal), path, spans), -least
        if doubt is not None:
            judged = (*doubt.judged, nominal.span)
            yield Found(replace(doubt, judged=judged), joint.joint, size, derived)


def is_drawn(model: SpecModel) -> bool:
    """Whether a target draws from the ranges."""
    return any((target.target or name) == "randomization" for name, target in model.targets.items())


def _dry(field: str, group: Actuators) -> SpecValue | None:
    """The nominal dry friction of a field; without a break-away friction that is the kinetic one."""
    friction = group.friction if field in ("friction.coulomb", "friction.static") else None
    if friction is None:
        return None
    return friction.static if field == "friction.static" and friction.static is not None else friction.coulomb


def _rubbing(
    entry: Randomize, field: str, path: Path, limit: float | None, own: SpecValue | None, spans: SourceMap
) -> Iterator[Doubt]:
    """A range of dry friction that reaches the effort limit of a hinge [N*m], by whichever operation."""
    if field not in ("friction.coulomb", "friction.static") or not limit or entry.from_ is not None:
        return
    pair = range_of(entry, field)
    if not isinstance(pair, tuple):
        return
    # Of a gaussian the mean.
    index = 0 if entry.distribution == "gaussian" or (pair[0].value or 0.0) > (pair[1].value or 0.0) else 1
    end, drawn = pair[index], pair[index].value or 0.0
    nominal = None if own is None else own.value
    operation = _operation(entry)
    if end.linear or (nominal is None and operation != "abs"):
        return
    most = {"scale": drawn * (nominal or 0.0), "add": drawn + (nominal or 0.0), "abs": drawn}[operation]
    if most < limit:
        return
    how = (
        ""
        if operation == "abs"
        else f", {end.written} {'more than' if operation == 'add' else 'times'} the nominal"
    )
    how += "" if own is None or not how else f" {own.written},"
    message = (
        f"a dry friction of up to {format_quantity(most, 'N*m', 4)}{how} is not below the effort limit of "
        f"{format_quantity(limit, 'N*m', 4)}: the drive cannot move the joint"
    )
    milli = _all(format_quantity((item.value or 0.0) / 1000.0, end.unit, 4) for item in pair[: index + 1])
    help = None if operation == "scale" else f"is it in m{end.unit} ({milli})?"
    yield at(spans, "SPEC188", message, (*path, operation, index), help, (*path, operation, 0))


def is_off(bias: SpecValue) -> bool:
    """Whether no encoder is that wrong."""
    return abs(bias.value or 0.0) > OFF.get(bias.unit, math.inf)


def off(ends: Sequence[SpecValue], path: Path, others: tuple[Path, ...], spans: SourceMap) -> Doubt:
    """An encoder that is off by far."""
    help = None
    if ends[0].unit == "rad" and "deg" not in ends[0].written:
        degrees = max(abs(end.value or 0.0) for end in ends) * DEGREE <= OFF["rad"]
        words, short = ("degrees", "deg") if degrees else ("arcmin", "arcmin")
        help = f"is it in {words}? Then write {_all(f'{end.value:g} {short}' for end in ends)}"
    message = f"an encoder that is off by {_all(end.written for end in ends)}"
    return at(spans, "SPEC188", message, path, help, *others)


def _all(texts: Iterable[str]) -> str:
    return " and ".join(texts)


def _numbers(numbers: Iterable[float]) -> str:
    return _all(f"{number:.4g}" for number in numbers)
