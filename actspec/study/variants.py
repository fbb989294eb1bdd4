"""A joint's actuator with less of its model: PD and limit, that with one further effect, and all of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from actspec.ir import Command, Delay, JointActuator, Level, Origin, Quantity, assumed

NAMES = ("ideal_pd", "filter", "delay", "dc_motor", "network", "spec")
"""Variants, in the order in which they are shown."""

NO_NETWORK = "the spec has no network"


@dataclass(frozen=True, slots=True)
class Assumed:
    """Figures of options, for specs that do not state them.

    Attributes:
        cutoff: Of a first-order low-pass on the command [Hz]; None: none is given.
        delay: Of the command [s]; None: none is given.
    """

    cutoff: float | None = None
    delay: float | None = None


@dataclass(frozen=True, slots=True)
class Missing:
    """A variant that a joint does not have.

    Attributes:
        joint: Its name.
        variant: Of `NAMES`.
        reason: Why.
    """

    joint: str
    variant: str
    reason: str


def variants_of(
    actuator: JointActuator, given: Assumed = Assumed()
) -> tuple[dict[str, JointActuator], tuple[Missing, ...]]:
    """The variants of one joint, by name in the order of `NAMES`, and those it lacks.

    A figure that the spec lacks comes from `given`, never from a default. Friction, armature and limit are the spec's
    in all of them.
    """
    found: dict[str, JointActuator] = {}
    missing = []
    for name in NAMES:
        made = _MAKE[name](actuator, given)
        if isinstance(made, str):
            missing.append(Missing(actuator.joint, name, made))
        else:
            found[name] = made
    return found, tuple(missing)


def lined(actuator: JointActuator) -> JointActuator | None:
    """A joint with its motor's torque-speed line, whatever its level; None: the line is not known."""
    fields = _line(actuator, Assumed())
    return None if isinstance(fields, str) else replace(actuator, **fields)


def _bare(actuator: JointActuator, given: Assumed) -> JointActuator | str:
    """PD and limit."""
    lacking = [
        name
        for name, gain, needed in (
            ("kp", actuator.kp, actuator.command is Command.POSITION),
            ("kd", actuator.kd, actuator.command is not Command.EFFORT),
        )
        if needed and (gain is None or gain.value is None)
    ]
    return f"{' and '.join(lacking)} unknown" if lacking else _stripped(actuator)


def _stripped(actuator: JointActuator) -> JointActuator:
    """Gains and limit alone."""
    bias = replace(actuator.encoder_bias, value=0.0) if actuator.encoder_bias.known else actuator.encoder_bias
    return replace(
        actuator,
        level=Level.IDEAL_PD,
        network=None,
        stall_torque=None,
        no_load_speed=None,
        curve=None,
        filter_cutoff=None,
        delay=None,
        command_range=None,
        encoder_bias=bias,
    )


def _with(change: Callable[[JointActuator, Assumed], Mapping[str, Any] | str]) -> Any:
    """PD and limit with a change; a text says what it lacks."""

    def make(actuator: JointActuator, given: Assumed) -> JointActuator | str:
        bare = _bare(actuator, given)
        if isinstance(bare, str):
            return bare
        fields = change(actuator, given)
        return fields if isinstance(fields, str) else replace(bare, **fields)

    return make


def _filter(actuator: JointActuator, given: Assumed) -> Mapping[str, Any] | str:
    own = actuator.filter_cutoff
    if own is not None and own.known:
        return {"filter_cutoff": own}
    if given.cutoff is None:
        return "the spec has no filter: --filter 30Hz"
    return {"filter_cutoff": _option(given.cutoff, "Hz", "--filter")}


def _delay(actuator: JointActuator, given: Assumed) -> Mapping[str, Any] | str:
    own = actuator.delay
    if own is not None and own.nominal.known:
        nominal = own.nominal
    elif given.delay is None:
        return "the spec has no delay: --delay 10ms"
    else:
        nominal = _option(given.delay, "s", "--delay")
    value = nominal.require()
    return {"delay": Delay(nominal, value, value, "episode")}


def _option(value: float, unit: str, option: str) -> Quantity:
    return replace(assumed(value, unit, option), origin=Origin.AUTHORED, source=option)


def _line(actuator: JointActuator, given: Assumed) -> Mapping[str, Any] | str:
    line = actuator.motor_line
    if line is None:
        return "the spec names no motor, and so no torque-speed line"
    if line.curve is not None:
        return {"level": Level.DC_MOTOR, "curve": line.curve}
    if (
        line.stall_torque is None
        or line.no_load_speed is None
        or not (line.stall_torque.known and line.no_load_speed.known)
    ):
        return f"the torque-speed line of motor '{actuator.motor}' is unknown"
    return {"level": Level.DC_MOTOR, "stall_torque": line.stall_torque, "no_load_speed": line.no_load_speed}


def _network(actuator: JointActuator, given: Assumed) -> JointActuator | str:
    if actuator.level is not Level.ACTUATOR_NET or actuator.network is None:
        return NO_NETWORK
    return replace(_stripped(actuator), level=Level.ACTUATOR_NET, network=actuator.network)


def _whole(actuator: JointActuator, given: Assumed) -> JointActuator | str:
    lacking = _bare(actuator, given) if actuator.level is not Level.ACTUATOR_NET else actuator
    return lacking if isinstance(lacking, str) else actuator


_MAKE: Mapping[str, Callable[[JointActuator, Assumed], JointActuator | str]] = {
    "ideal_pd": _bare,
    "filter": _with(_filter),
    "delay": _with(_delay),
    "dc_motor": _with(_line),
    "network": _network,
    "spec": _whole,
}
