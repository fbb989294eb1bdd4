"""What happens to a joint's command before the drive: range, delay, filter."""

from __future__ import annotations

from dataclasses import replace

from actspec.ir import Command, Delay, Origin, Quantity
from actspec.resolution.inputs import JointInputs
from actspec.resolution.quantities import choose, written
from actspec.spec.fields import CommandRange, SpecDelay
from actspec.spec.models import CommandFilter
from actspec.spec.rules.joint_fields import COMMANDED
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
