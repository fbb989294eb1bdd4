"""Delay, filter, bias and clamp of the command: Newton has a fixed delay, a drive's bias is a constant torque."""

from __future__ import annotations

from actspec.ir import Command
from actspec.laws import delay_steps
from actspec.targets.approximation import command_range_error, held_step_error
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
        joint.approximate("delay.range", asked_range, "none", why, _late(joint))
        return []
    steps, loss = delay_steps(nominal, joint.step)
    emitted = f"{steps} step{'' if steps == 1 else 's'} of {joint.step * 1e3:g} ms"
    if abs(loss) > 1e-9:
        joint.approximate(
            "delay",
            f"{nominal * 1e3:g} ms",
            emitted,
            f"a delay is a whole number of steps; {abs(loss) * 1e3:g} ms {'more' if loss > 0 else 'less'} than asked",
            _late(joint),
        )
    if ranged:
        reach = max(abs(steps * joint.step - end) for end in (delay.low, delay.high))
        why = f"a NewtonActuator has one fixed delay; at most {reach * 1e3:g} ms off"
        joint.approximate("delay.range", asked_range, emitted, why, _late(joint))
    if steps == 0:
        return []
    notes = [f"steps of {joint.step * 1e3:g} ms: {nominal * 1e3:g} ms"]
    notes += [provenance(delay.nominal)] if delay.nominal.known else []
    return [Attribute("int", "newton:delaySteps", str(steps), ", ".join(notes))]


def no_command_path(joint: Joint) -> None:
    """Report filter and clamp of the command, and a network's bias, as lost where there are any."""
    actuator, law = joint.actuator, joint.law
    if law.filter_cutoff is not None:
        joint.approximate(
            "command_filter",
            f"{law.filter_cutoff:g} Hz",
            "none",
            "a NewtonActuator has no filter on its command",
            _late(joint),
        )
    if joint.learned and law.encoder_bias != 0.0:
        joint.approximate(
            "encoder_bias",
            format_quantity(law.encoder_bias, actuator.encoder_bias.unit),
            "none",
            "a network's position error has no bias",
            joint.both_limits,
        )
    if law.command_range is not None:
        low, high = law.command_range
        unit = {
            Command.POSITION: actuator.encoder_bias.unit,
            Command.VELOCITY: actuator.velocity_limit.unit,
        }
        joint.approximate(
            "command_range",
            f"{low:g} to {high:g} {unit.get(actuator.command, joint.unit)}",
            "none",
            "a NewtonActuator does not clamp its command",
            joint.both_limits if joint.learned else command_range_error(law, actuator.position_range),
        )


def _late(joint: Joint) -> float | None:
    """Size of a command that comes too early, too late or unfiltered [N*m or N]."""
    return joint.both_limits if joint.learned else held_step_error(joint.law)
