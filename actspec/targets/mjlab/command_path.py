"""Delay, filter, bias and clamp: a delay is steps of the simulation, the others mjlab's actuators have not."""

from __future__ import annotations

from dataclasses import replace

from actspec.ir import Command
from actspec.laws import delay_steps
from actspec.targets.approximation import static_error
from actspec.targets.mjlab.context import Field, Joint
from actspec.targets.python_text import provenance, py
from actspec.units import format_quantity

HELD = "10**9"
"""Steps between two draws of a lag: longer than any episode, so that it is drawn once after each reset."""


def delay_fields(joint: Joint) -> tuple[Field, ...]:
    """`delay_*`, in steps of the simulation."""
    delay = joint.actuator.delay
    if delay is None:
        return ()
    (low, late), (high, later) = (delay_steps(end, joint.step) for end in (delay.low, delay.high))
    origin = [provenance(delay.nominal)] if delay.nominal.known else []
    losses: tuple[float, ...]
    if delay.low == delay.high:
        field, asked, losses = "delay", f"{delay.low * 1e3:g} ms", (late,)
        note = [asked, *origin]
    else:
        field, asked, losses = "delay.range", f"{delay.low * 1e3:g} to {delay.high * 1e3:g} ms", (late, later)
        note = [asked, f"drawn each {delay.sampling}", *origin]
    got = f"{low}" if low == high else f"{low} to {high}"
    if any(abs(loss) > 1e-9 for loss in losses):
        said = " and ".join(f"{abs(x) * 1e3:g} ms {'more' if x > 0 else 'less'}" for x in losses if x)
        joint.approximate(
            field,
            asked,
            f"{got} step{'' if got == '1' else 's'} of {joint.step * 1e3:g} ms",
            f"a delay is a whole number of steps; {said} than asked",
            joint.late,
        )
    if high == 0:
        return ()
    fields = [
        Field("delay_min_lag", py(low), f"steps of {joint.step * 1e3:g} ms: {', '.join(note)}"),
        Field("delay_max_lag", py(high)),
    ]
    if low != high and delay.sampling == "episode":
        fields += [
            Field("delay_update_period", HELD, "drawn at a reset, then held"),
            Field("delay_per_env_phase", "False"),
        ]
    return tuple(fields)


def no_command_path(joint: Joint) -> None:
    """Report filter, bias and clamp of the command as lost, where there are any."""
    actuator, law = joint.actuator, joint.law
    joint.no_filter("mjlab's actuators have no filter on the command")
    if law.encoder_bias != 0.0 and actuator.command is Command.POSITION:
        bias = format_quantity(law.encoder_bias, actuator.encoder_bias.unit)
        joint.approximate(
            "encoder_bias",
            bias,
            "none",
            f"mjlab's actuators have no bias; an event {joint.dialect.bias_event} with the range "
            f"({law.encoder_bias:g}, {law.encoder_bias:g}) sets it",
            joint.both_limits if joint.learned else static_error(law, replace(law, encoder_bias=0.0).torque),
        )
    joint.no_range("mjlab's actuators do not clamp the command; its action term can (`clip`)")
