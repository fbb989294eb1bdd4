"""Clamps of a robot file's drives at the joint: torque and command."""

from __future__ import annotations

import math

from actspec.diagnostics import Span
from actspec.ir import Command, Quantity
from actspec.lift.quantities import Units, stated, unknown
from actspec.lift.robot_unsaid import TOLERANCE
from actspec.resolution.quantities import tidy
from actspec.robot.view import ActuatorView, JointView

_OF_FORCE = ("forcerange", "saturation", "forcelimited")
_OF_CONTROL = ("ctrlrange", "posrange", "inheritrange", "ctrllimited")


def effort_limit(joint: JointView, own: tuple[ActuatorView, ...], unit: str) -> Quantity:
    """Largest torque that the file lets the drives apply; unknown where nothing limits it.

    The least of the joint's own limit, the sum of the actuators' and the control range of a torque motor. Of a
    limit that is not symmetric, the larger end.

    Args:
        joint: The joint.
        own: Its actuators.
        unit: Of a torque there.
    """
    at_joint = joint.places.get("effort", joint.span)
    if "effort_range" in joint.unknown or any("force_range" in a.unknown for a in own):
        return unknown(unit, "the text alone does not tell", at_joint)
    candidates: list[tuple[float, Span, str | None, str | None]] = []
    if joint.effort_range is not None:
        candidates.append((_largest(joint.effort_range), at_joint, None, None))
    if own and all(a.force_range is not None for a in own):
        total = sum(abs(a.gear) * _largest(a.force_range) for a in own if a.force_range is not None)
        candidates.append((total, place(own[0], _OF_FORCE), _formula(own, total), None))
    if own and own[0].control == "motor":
        if "control_range" in own[0].unknown:
            return unknown(unit, "the text alone does not tell", own[0].span)
        ends = _torques(own[0])
        if ends is not None and (is_symmetric(ends) or not candidates):
            factor = own[0].gear * own[0].gain
            made = None if factor == 1.0 else f"{factor:g} (gear x gain)"
            said = "the range of the motor's control"
            candidates.append((_largest(ends), place(own[0], _OF_CONTROL), made, said))
    if not candidates:
        return unknown(unit, "the file has no limit")
    limit, span, formula, note = min(candidates, key=lambda one: one[0])
    if limit == 0.0:
        return unknown(unit, f"the file says 0 {unit}: nobody's number", span)
    if not math.isfinite(limit):
        return unknown(unit, "the file has no limit", span)
    return stated(limit if formula is None else tidy(limit), unit, span, note=note, formula=formula)


def command_range(
    joint: JointView, own: tuple[ActuatorView, ...], command: Command, units: Units
) -> tuple[Quantity, Quantity] | None:
    """Clamp of the command in joint units; None without one.

    A torque motor's is only one where it is inside the effort limit and not symmetric; else it says nothing, or is
    that limit.

    Args:
        joint: The joint.
        own: Its actuators.
        command: What the command means.
        units: Of the joint.
    """
    if not own:
        return None
    lead = next((a for a in own if a.control != "velocity"), own[0])
    unit = {Command.POSITION: units.position, Command.VELOCITY: units.speed, Command.EFFORT: units.torque}
    span = place(lead, _OF_CONTROL)
    if "control_range" in lead.unknown:
        hidden = unknown(unit[command], "the text alone does not tell", span)
        return hidden, hidden
    if lead.control_range is None:
        return None
    ends = tuple(sorted(end / lead.gear for end in lead.control_range))
    exact = lead.gear == 1.0
    if command is Command.EFFORT:
        torques = _torques(lead)
        bound = _force_bound(joint, own)
        assert torques is not None
        if bound is not None and torques[0] <= -bound and torques[1] >= bound:
            return None
        if lead.control == "motor" and is_symmetric(torques):
            return None
        ends, exact = torques, exact and lead.gain == 1.0
    low, high = (end if exact else tidy(end) for end in ends)
    return stated(low, unit[command], span), stated(high, unit[command], span)


def place(actuator: ActuatorView, attributes: tuple[str, ...]) -> Span:
    """Where the first of these attributes is written: in the element, or in its default class."""
    return next(
        (actuator.places[name] for name in attributes if name in actuator.places),
        actuator.span,
    )


def is_symmetric(ends: tuple[float, float]) -> bool:
    """Whether a range is the same in both directions."""
    return abs(ends[0] + ends[1]) <= TOLERANCE * _largest(ends)


def _force_bound(joint: JointView, own: tuple[ActuatorView, ...]) -> float | None:
    """The force limits alone."""
    bounds = [] if joint.effort_range is None else [_largest(joint.effort_range)]
    if all(a.force_range is not None for a in own):
        bounds.append(sum(abs(a.gear) * _largest(a.force_range) for a in own if a.force_range is not None))
    return min(bounds, default=None)


def _torques(motor: ActuatorView) -> tuple[float, float] | None:
    """What a torque motor's control range makes at the joint."""
    if motor.control_range is None:
        return None
    factor = motor.gear * (1.0 if motor.control == "dcmotor" else motor.gain)
    low, high = sorted(factor * end for end in motor.control_range)
    return low, high


def _formula(own: tuple[ActuatorView, ...], total: float) -> str | None:
    if all(abs(a.gear) == 1.0 for a in own) and len(own) == 1:
        return None
    parts = [
        f"{abs(a.gear):g} (gear) x {_largest(a.force_range):g}" for a in own if a.force_range is not None
    ]
    return " + ".join(parts)


def _largest(ends: tuple[float, float]) -> float:
    return max(abs(end) for end in ends)
