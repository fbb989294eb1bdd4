"""Delay, filter, bias and clamp of the command: Newton has a fixed delay, a drive's bias is a constant torque."""

from __future__ import annotations

from actspec.laws import delay_steps
from actspec.targets.newton.context import Joint
from actspec.targets.newton.usda import Attribute
from actspec.targets.python_text import provenance
from actspec.units import format_quantity


def delay_attributes(joint: Joint) -> list[Attribute]:
    """`newton:delaySteps`, in physics steps; empty without a delay."""
    delay = joint.actuator.delay
    if delay is None or delay.high == 0.0:
        return []
    asked_range = f"{delay.low * 1e3:g} to {delay.high * 1e3:g} ms, drawn each {delay.sampling}"
    ranged = delay.low != delay.high
    nominal = delay.nominal.value if ranged else delay.high
    if nominal is None:
        why = "a NewtonActuator has one fixed delay, and the nominal is unknown"
        joint.approximate("delay.range", asked_range, "none", why, joint.late)
        return []
    steps, loss = delay_steps(nominal, joint.step)
    emitted = f"{steps} step{'' if steps == 1 else 's'} of {joint.step * 1e3:g} ms"
    if abs(loss) > 1e-9:
        joint.approximate(
            "delay",
            f"{nominal * 1e3:g} ms",
            emitted,
            f"a delay is a whole number of steps; {abs(loss) * 1e3:g} ms {'more' if loss > 0 else 'less'} than asked",
            joint.late,
        )
    if ranged:
        reach = max(abs(steps * joint.step - end) for end in (delay.low, delay.high))
        why = f"a NewtonActuator has one fixed delay; at most {reach * 1e3:g} ms off"
        joint.approximate("delay.range", asked_range, emitted, why, joint.late)
    if steps == 0:
        return []
    notes = [f"steps of {joint.step * 1e3:g} ms: {nominal * 1e3:g} ms"]
    notes += [provenance(delay.nominal)] if delay.nominal.known else []
    return [Attribute("int", "newton:delaySteps", str(steps), ", ".join(notes))]


def no_command_path(joint: Joint) -> None:
    """Report filter and clamp of the command, and a network's bias, as lost where there are any."""
    joint.no_filter("a NewtonActuator has no filter on its command")
    bias = joint.law.encoder_bias
    if joint.learned and bias != 0.0:
        joint.approximate(
            "encoder_bias",
            format_quantity(bias, joint.actuator.encoder_bias.unit),
            "none",
            "a network's position error has no bias",
            joint.both_limits,
        )
    joint.no_range("a NewtonActuator does not clamp its command")
