"""What happens to a joint's command before the drive: range, delay, filter.

Also the ranges that the fields of a joint are drawn from, those from the identification as numbers.
"""

from __future__ import annotations

from dataclasses import replace

from actspec.diagnostics import Path, dotted
from actspec.fields import COMMANDED
from actspec.ir import Command, Delay, Origin, Quantity, Randomization
from actspec.resolution.quantities import choose, written
from actspec.resolution.stated import JointInputs
from actspec.spec.fields import CommandRange, SpecDelay
from actspec.spec.models import CommandFilter, Randomize
from actspec.spec.rules.groups import RANDOMIZED_KINDS, UNFITTED, range_of
from actspec.units import Kind, format_quantity


def filter_cutoff(inputs: JointInputs) -> Quantity | None:
    """-3 dB frequency of the command's low-pass [Hz]; None without one."""
    value = inputs.stated.get("command_filter")
    if value == "none":
        return None
    fitted = inputs.identified("bandwidth", Kind.FREQUENCY)
    authored = derived = None
    if isinstance(value, CommandFilter):
        path = (*inputs.stated.path("command_filter"), "cutoff")
        if not value.cutoff.identified:
            authored = written(value.cutoff, "Hz", inputs.stated.spec.span(*path))
        inputs.compare("command_filter", value.cutoff, authored, fitted, word="cutoff")
    elif value == "from_motor":
        bandwidth = None if inputs.motor is None else inputs.motor.bandwidth
        if bandwidth is None or not bandwidth.known:
            whose = "" if inputs.motor is None else f" '{inputs.motor.name}'"
            inputs.error(
                "RES008",
                f"the filter is to be that of the motor{whose}, whose bandwidth is unknown",
                "command_filter",
                "state the motor's bandwidth, or write command_filter: {cutoff: 30 Hz}",
            )
        else:
            derived = replace(bandwidth, origin=Origin.DERIVED, formula="bandwidth of the motor")
    return choose(authored, fitted, derived, inputs.model.filter_cutoff)


def delay(inputs: JointInputs) -> Delay | None:
    """Delay of the command; None without one."""
    value = inputs.stated.get("delay")
    fitted = inputs.identified("delay", Kind.TIME)
    if not isinstance(value, SpecDelay):
        kept = choose(fitted, inputs.model.delay)
        return None if kept is None else Delay(kept, kept.require(), kept.require(), "episode")
    authored = None
    if not value.nominal.identified:
        authored = written(value.nominal, "s", inputs.span("delay"))
    inputs.compare("delay", value.nominal, authored, fitted)
    nominal = choose(authored, fitted, inputs.model.delay)
    if nominal is None:
        return None
    low = high = nominal.value or 0.0
    if value.range is not None:
        low, high = (end.value or 0.0 for end in value.range)
        if nominal.value is not None and not low <= nominal.value <= high:
            inputs.error(
                "RES009",
                f"the {nominal.origin.value} delay {format_quantity(nominal.value, 's')} is outside its range "
                f"[{value.range[0].written}, {value.range[1].written}]",
                "delay",
                "widen the range, or state the nominal delay",
            )
    return Delay(nominal, low, high, value.sampling)


def command_range(inputs: JointInputs) -> tuple[Quantity, Quantity] | None:
    """Clamp of the command, in the command's unit; None without one."""
    value = inputs.stated.get("command_range")
    if value is None or value == "none":
        return None
    unit = inputs.unit(COMMANDED[inputs.command.value])
    span = inputs.span("command_range")
    if value == "joint":
        joint = inputs.joint
        if joint.range is None or inputs.command is not Command.POSITION:
            inputs.error(
                "RES006",
                "`command_range: joint` needs a joint with a range and `command: position`",
                "command_range",
                "write [low, high], or none",
            )
            return None
        low, high = (
            Quantity(end, unit, Origin.MODEL, source=joint.span.path, span=joint.span) for end in joint.range
        )
        return low, high
    assert isinstance(value, CommandRange)
    return written(value.low, unit, span), written(value.high, unit, span)


def randomizations(inputs: JointInputs) -> tuple[Randomization, ...]:
    """Every range of the joint's group, in the spec's order."""
    found = []
    for field, entry in inputs.stated.group.randomize.items():
        path: Path = ("actuators", inputs.stated.binding.group, "randomize", field)
        span = inputs.stated.spec.document.spans.key(path)
        every, has_unit = None, False
        if entry.every is not None:
            every = (float(entry.every[0].value), float(entry.every[1].value))
        if entry.from_ is not None:
            fitted = _fitted(inputs, field, path)
            if fitted is None:
                continue
            operation, low, high = "abs", *_spread(fitted, field, entry)
        else:
            operation = next(key for key in ("scale", "add", "abs") if getattr(entry, key) is not None)
            low, high, has_unit = _range(inputs, field, entry, (*path, operation))
        found.append(
            Randomization(
                field,
                operation,
                low,
                high,
                entry.distribution,
                entry.when,
                every,
                entry.per,
                span,
                has_unit,
            )
        )
    return tuple(found)


def _range(inputs: JointInputs, field: str, entry: Randomize, path: Path) -> tuple[float, float, bool]:
    """The written range in SI units, and whether it has a unit."""
    ends = range_of(entry, field)
    assert isinstance(ends, tuple)
    end = ends[1] if ends[0].linear is None else ends[0]
    inputs.check_unit(end, f"the range of {field} has {end.written}", path)
    return float(ends[0].value or 0.0), float(ends[1].value or 0.0), end.linear is not None


def _fitted(inputs: JointInputs, field: str, path: Path) -> Quantity | None:
    """The fitted value that a range is taken from; None after an error."""
    fitted = None if field in UNFITTED else inputs.identified(field, RANDOMIZED_KINDS[field])
    if fitted is None or fitted.std is None:
        from actspec.resolution.identified import why_missing

        help = "write `std` there, or state the range as scale, add or abs"
        if fitted is not None:
            why = f"{fitted.span} has {format_quantity(fitted.value, fitted.unit)} without `std`"
        else:
            why, help = why_missing(inputs, field)
            help = help.replace("write the number here", "state the range as scale, add or abs")
        inputs.reports.error(
            "RES007",
            inputs.joint.name,
            f"no identified standard deviation of {field} to take the range from: {why}",
            dotted(path),
            inputs.stated.spec.span(*path),
            help,
        )
        return None
    return fitted


def _spread(fitted: Quantity, field: str, entry: Randomize) -> tuple[float, float]:
    """The fitted value -+ sigma std; for a gaussian (mean, sigma std)."""
    sigma = 1.0 if entry.sigma is None else entry.sigma.value or 1.0
    mean, half = fitted.require(), sigma * (fitted.std or 0.0)
    if entry.distribution == "gaussian":
        return mean, half
    return (mean - half if field == "encoder_bias" else max(0.0, mean - half)), mean + half
