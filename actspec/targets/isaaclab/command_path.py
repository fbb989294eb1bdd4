"""Delay, filter, clamp and encoder bias: the fields of those that a class has, the size of those that it has not."""

from __future__ import annotations

from dataclasses import replace

from actspec.ir import Command
from actspec.laws import delay_steps
from actspec.targets.approximation import command_range_error, held_step_error, static_error
from actspec.targets.isaaclab.context import Field, Joint
from actspec.targets.python_text import provenance
from actspec.units import format_quantity


def lags(joint: Joint, *, filtered: bool) -> tuple[int, int]:
    """Least and largest lag in physics steps, with what is lost; 0 and 0 without a delay."""
    delay = joint.actuator.delay
    if delay is None or delay.high == 0.0:
        return 0, 0
    ranged = delay.low != delay.high
    if ranged and joint.dialect.lag_range:
        low, high = delay_steps(delay.low, joint.step), delay_steps(delay.high, joint.step)
        worst = max(abs(low.loss), abs(high.loss))
        if worst > 1e-9:
            joint.approximate(
                "delay.range",
                f"{delay.low * 1e3:g} to {delay.high * 1e3:g} ms",
                f"{joint.ms(low.steps)} to {joint.ms(high.steps)}",
                f"a delay is a whole number of physics steps; at most {worst * 1e3:g} ms off",
                held_step_error(joint.law, filtered=filtered, late=worst),
            )
        if delay.sampling != "episode" and low.steps != high.steps:
            joint.approximate(
                "delay.sampling",
                f"drawn each {delay.sampling}",
                "drawn at each reset",
                "Isaac Lab draws lags at a reset",
                held_step_error(joint.law, filtered=filtered, late=delay.high - delay.low),
            )
        return low.steps, high.steps
    nominal = delay.nominal.value if ranged else delay.high
    if nominal is None:
        joint.approximate(
            "delay.range",
            f"{delay.low * 1e3:g} to {delay.high * 1e3:g} ms, drawn each {delay.sampling}",
            "none",
            f"the actuators of Isaac Lab {joint.dialect.text} have one fixed delay, and the nominal is unknown",
            held_step_error(joint.law, filtered=filtered, late=delay.high),
        )
        return 0, 0
    steps, loss = delay_steps(nominal, joint.step)
    if abs(loss) > 1e-9:
        joint.approximate(
            "delay",
            f"{nominal * 1e3:g} ms",
            joint.ms(steps),
            f"a delay is a whole number of physics steps; {abs(loss) * 1e3:g} ms "
            f"{'more' if loss > 0 else 'less'} than asked",
            held_step_error(joint.law, filtered=filtered, late=abs(loss)),
        )
    if ranged:
        reach = max(abs(steps * joint.step - end) for end in (delay.low, delay.high))
        joint.approximate(
            "delay.range",
            f"{delay.low * 1e3:g} to {delay.high * 1e3:g} ms, drawn each {delay.sampling}",
            joint.ms(steps),
            f"the actuators of Isaac Lab {joint.dialect.text} have one fixed delay; at most "
            f"{reach * 1e3:g} ms off",
            held_step_error(joint.law, filtered=filtered, late=reach),
        )
    return steps, steps


def lag_fields(joint: Joint, steps: tuple[int, int]) -> list[Field]:
    """Least and largest lag of a class that delays."""
    delay = joint.actuator.delay
    assert delay is not None
    first = f"physics steps of {joint.step * 1e3:g} ms"
    if delay.nominal.known:
        first += f"; {provenance(delay.nominal)}"
    return [
        Field("min_delay", steps[0], first, scalar=True),
        Field("max_delay", steps[1], f"{steps[1] * joint.step * 1e3:g} ms", scalar=True),
    ]


def no_delay(joint: Joint, why: str) -> None:
    """Report the delay as lost, if there is one."""
    delay = joint.actuator.delay
    if delay is None or delay.high == 0.0:
        return
    asked = "unknown" if delay.nominal.value is None else f"{delay.nominal.value * 1e3:g} ms"
    if delay.low != delay.high:
        asked += f" ({delay.low * 1e3:g} to {delay.high * 1e3:g} ms)"
    joint.approximate("delay", asked, "none", why, joint.lost_step())


def no_filter(joint: Joint) -> None:
    """Report the command filter as lost, if there is one."""
    cutoff = joint.actuator.filter_cutoff
    if cutoff is None or not cutoff.known:
        return
    joint.approximate(
        "command_filter",
        f"{cutoff.require():g} Hz",
        "none",
        "no stock class filters the command",
        joint.lost_step(),
    )


def no_bias(joint: Joint) -> None:
    """Report the encoder bias as lost, if it does anything."""
    bias = joint.actuator.encoder_bias
    if not bias.value or (joint.network is None and joint.actuator.command is not Command.POSITION):
        return
    error = 2.0 * joint.limit
    if not joint.opaque:
        error = static_error(joint.law, replace(joint.law, encoder_bias=0.0).torque)
    joint.approximate(
        "encoder_bias",
        format_quantity(bias.value, bias.unit),
        "none",
        "no stock class has an encoder bias",
        error,
    )


def no_range(joint: Joint) -> None:
    """Report the clamp of the command as lost, if there is one."""
    ends = joint.actuator.command_range
    if ends is None or not any(end.known for end in ends):
        return
    error = 2.0 * joint.limit
    if not joint.opaque:
        error = command_range_error(joint.law, joint.actuator.position_range)
    low, high = (format_quantity(end.value, end.unit) for end in ends)
    joint.approximate("command_range", f"{low} to {high}", "none", "no stock class clamps the command", error)
