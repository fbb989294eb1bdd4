"""kp and kd of a joint: stated, identified, derived from other numbers, or the robot file's."""

from __future__ import annotations

import math

from actspec.ir import Command, InertiaRange, Level, Origin, Quantity, unknown
from actspec.resolution.stated import JointInputs
from actspec.spec.fields import DerivedGain
from actspec.spec.values import SpecValue
from actspec.units import Kind, format_number, format_quantity


def stiffness(
    inputs: JointInputs, effort: Quantity, armature: Quantity, held: InertiaRange | None
) -> Quantity | None:
    """kp [N*m/rad or N/m]; None where the command is no position, and for a network that states none.

    Args:
        inputs: What is said about the joint.
        effort: Its effort limit.
        armature: Its armature.
        held: Its inertia with all other joints held; None: the model does not tell.
    """
    if inputs.command is not Command.POSITION:
        return None
    gain = inputs.stated.get("kp")
    derived = None
    if isinstance(gain, DerivedGain):
        if _waits(inputs, "kp"):
            return unknown(inputs.unit(Kind.STIFFNESS))
        if gain.method == "torque_at_error":
            derived = _torque_at_error(inputs, gain, effort)
        else:
            derived = _natural_frequency(inputs, gain, _inertia(inputs, gain, armature, held, "kp"))
        if derived is None:
            return unknown(inputs.unit(Kind.STIFFNESS))
    if inputs.level is Level.ACTUATOR_NET:
        return inputs.number("kp", Kind.STIFFNESS, derived=derived)
    return _gain(
        inputs,
        "kp",
        Kind.STIFFNESS,
        derived,
        inputs.model.kp,
        "no position servo",
        "write kp: 25 N*m/rad (or {derive: ...}), or `unknown` to leave the file's actuator alone",
    )


def velocity_gain(
    inputs: JointInputs, kp: Quantity | None, armature: Quantity, held: InertiaRange | None
) -> Quantity | None:
    """kd [N*m*s/rad or N*s/m]; None where the command is the effort, and for a network that states none.

    Args:
        inputs: What is said about the joint.
        kp: Its stiffness; None where it has none.
        armature: Its armature.
        held: Its inertia with all other joints held; None: the model does not tell.
    """
    if inputs.command is Command.EFFORT:
        return None
    gain = inputs.stated.get("kd")
    derived = None
    if isinstance(gain, DerivedGain):
        if _waits(inputs, "kd") or (kp is not None and _waits(inputs, "kp")):
            return unknown(inputs.unit(Kind.VELOCITY_GAIN))
        derived = _damping_ratio(inputs, gain, kp, _inertia(inputs, gain, armature, held, "kd"))
        if derived is None:
            return unknown(inputs.unit(Kind.VELOCITY_GAIN))
    if inputs.level is Level.ACTUATOR_NET:
        return inputs.number("kd", Kind.VELOCITY_GAIN, derived=derived)
    return _gain(
        inputs,
        "kd",
        Kind.VELOCITY_GAIN,
        derived,
        inputs.model.kd,
        "no servo",
        "write kd: 0.5 N*m*s/rad (or {derive: ...}), 0, or `unknown` to leave the file's actuator alone",
    )


def _gain(
    inputs: JointInputs,
    field: str,
    kind: Kind,
    derived: Quantity | None,
    own: Quantity | None,
    lacking: str,
    help: str,
) -> Quantity:
    """A gain by precedence, the file's own last; an error where nobody states it."""
    found = inputs.number(field, kind, derived=derived, rest=(own,))
    if found is not None:
        return found
    stated = inputs.stated.get(field)
    # A missing identified value is reported as that.
    if not (isinstance(stated, SpecValue) and stated.identified):
        message = f"{field} is not stated, and the robot's file has {lacking} to take it from"
        inputs.error("RES005", message, field, help)
    return unknown(inputs.unit(kind))


def _torque_at_error(inputs: JointInputs, gain: DerivedGain, effort: Quantity) -> Quantity | None:
    """kp = fraction effort_limit / error; None after an error."""
    fraction, error = _given(gain, "fraction"), _given(gain, "error")
    if not effort.known:
        message = "kp is derived from effort_limit, which is unknown"
        inputs.error("RES004", message, "kp", "state effort_limit")
        return None
    limit = format_quantity(effort.value, effort.unit)
    formula = f"{format_number(fraction)} x {limit} (effort_limit) / "
    formula += format_quantity(error, inputs.unit(Kind.POSITION))
    return inputs.derived("kp", Kind.STIFFNESS, fraction * effort.require() / error, formula)


Inertia = tuple[float, str] | None
"""Inertia that a derived gain names, with its name for the formula; None after an error."""


def _natural_frequency(inputs: JointInputs, gain: DerivedGain, inertia: Inertia) -> Quantity | None:
    """kp = I (2 pi frequency)^2; None after an error."""
    if inertia is None:
        return None
    frequency = _given(gain, "frequency")
    # As a product: a power of floats raises where a product is infinite.
    omega = 2.0 * math.pi * frequency
    formula = f"{inertia[1]} x (2 pi {format_quantity(frequency, 'Hz')})^2"
    return inputs.derived("kp", Kind.STIFFNESS, inertia[0] * omega * omega, formula)


def _damping_ratio(
    inputs: JointInputs, gain: DerivedGain, kp: Quantity | None, inertia: Inertia
) -> Quantity | None:
    """kd = 2 ratio sqrt(kp I); None after an error."""
    if inertia is None:
        return None
    if kp is None or not kp.known:
        why = "unknown" if kp is not None else "not there with `command: velocity`"
        help = "state kp" if kp is not None else "write kd: 0.5 N*m*s/rad"
        inputs.error("RES004", f"kd is derived from kp, which is {why}", "kd", help)
        return None
    ratio, root = _given(gain, "ratio"), math.sqrt(kp.require() * inertia[0])
    formula = f"2 x {format_number(ratio)} x sqrt({format_quantity(kp.value, kp.unit)} (kp) x {inertia[1]})"
    return inputs.derived("kd", Kind.VELOCITY_GAIN, 2.0 * ratio * root, formula)


def _given(gain: DerivedGain, key: str) -> float:
    """A number of a derivation; the spec language takes no `unknown` there."""
    value = gain.numbers[key].value
    assert value is not None
    return value


def _waits(inputs: JointInputs, field: str) -> bool:
    """Whether a gain is derived from an inertia that a compilation of the model will tell."""
    gain = inputs.stated.get(field)
    return inputs.uncompiled and isinstance(gain, DerivedGain) and gain.inertia == "joint"


def _inertia(
    inputs: JointInputs, gain: DerivedGain, armature: Quantity, held: InertiaRange | None, field: str
) -> Inertia:
    """The inertia of the drive or of the joint, or a number."""
    unit = inputs.unit(Kind.INERTIA)
    if isinstance(gain.inertia, SpecValue):
        assert gain.inertia.value is not None
        return gain.inertia.value, format_quantity(gain.inertia.value, unit)
    if gain.inertia == "joint":
        if held is None:
            message = f"{field} is derived from the joint's inertia, which the model does not give"
            inputs.error("RES003", message, field, "use `inertia: reflected` or state the inertia")
            return None
        return held.reference, f"{format_quantity(held.reference, unit)} (inertia held, reference pose)"
    if inputs.motor is not None and inputs.motor.reflected_inertia.known:
        value = inputs.motor.reflected_inertia.require()
        return value, f"{format_quantity(value, unit)} (reflected inertia)"
    if armature.known and armature.origin in (Origin.AUTHORED, Origin.IDENTIFIED):
        value = armature.require()
        return value, f"{format_quantity(value, unit)} (armature, {armature.origin.value})"
    inputs.error(
        "RES003",
        f"{field} is derived from the reflected inertia, which is not stated",
        field,
        "give the motor rotor_inertia and gear_ratio (or reflected_inertia), or name the inertia: "
        "{inertia: 0.01 kg*m^2}",
    )
    return None
