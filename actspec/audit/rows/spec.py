"""Rows of the ledger from a resolved spec."""

from __future__ import annotations

import math
from typing import Any

from actspec.audit.ledger import LedgerRow
from actspec.diagnostics import Span
from actspec.ir import Command, JointActuator, Level, Origin, Quantity
from actspec.readings.artifact import Artifact

_CONTROLS = {Level.IDEAL_PD: "ideal_pd", Level.DC_MOTOR: "dc_motor", Level.ACTUATOR_NET: "network"}

_FIELDS = {
    "kp": "kp",
    "kd": "kd",
    "joint_damping": "friction_viscous",
    "frictionloss": "friction_coulomb",
    "effort_limit": "effort_limit",
    "velocity_limit": "velocity_limit",
    "stall_torque": "stall_torque",
    "no_load_speed": "no_load_speed",
    "armature": "armature",
    "action_scale": "action_scale",
    "default_position": "default_position",
}
"""Field of a row to that of the actuator."""

_STATED = (Origin.AUTHORED, Origin.IDENTIFIED, Origin.DERIVED)


def rows_of_spec(artifact: Artifact, index: int) -> tuple[LedgerRow, ...]:
    """One row for each joint that the spec manages, in the robot's order.

    The spec's viscous friction is joint damping, and there is no damping at the actuator. How a target
    integrates kd the spec does not say, so there is no `stability`.

    Args:
        artifact: Of kind spec, with its actuators.
        index: Its place in `Case.artifacts`.
    """
    assert artifact.spec is not None
    return tuple(_row(artifact.path, index, actuator) for actuator in artifact.spec.joints)


def _row(path: str, index: int, actuator: JointActuator) -> LedgerRow:
    values: dict[str, Any] = {}
    places: dict[str, Span] = {}
    stated = set()
    quantities: dict[str, Quantity | None] = {
        field: getattr(actuator, name) for field, name in _FIELDS.items()
    }
    quantities["delay"] = actuator.delay.nominal if actuator.delay is not None else None
    if actuator.command_range is not None:
        quantities["command_range"] = actuator.command_range[0]
    for field, quantity in quantities.items():
        values[field] = quantity.value if quantity is not None else None
        if quantity is not None and quantity.origin in _STATED:
            stated.add(field)
        if quantity is not None and quantity.span is not None:
            places[field] = quantity.span
    values.pop("command_range", None)
    kp, viscous = values["kp"], values["joint_damping"]
    # With command effort there is no drive gain at all, which is not the same as an unknown one.
    kd = 0.0 if actuator.kd is None else values["kd"]
    total = None if kd is None or viscous is None else kd + viscous
    held = actuator.inertia_held
    frequency = ratio = None
    if kp is not None and kp > 0.0 and held is not None and held.reference > 0.0:
        frequency = math.sqrt(kp / held.reference)
        ratio = None if total is None else total / (2.0 * math.sqrt(kp * held.reference))
    limit = values["effort_limit"]
    effort = actuator.command is Command.EFFORT
    return LedgerRow(
        file=path,
        artifact=index,
        span=actuator.span or Span(path),
        joint=actuator.joint,
        actuator=actuator.group,
        control="motor" if effort and actuator.level is Level.IDEAL_PD else _CONTROLS[actuator.level],
        kind=actuator.kind,
        kd_clamped=None if limit is None else math.isfinite(limit),
        joint_damping_clamped=False,
        actuator_damping=0.0,
        actuator_damping_clamped=False,
        back_emf=0.0,
        total_damping=total,
        inertia_min=held.low if held is not None else None,
        inertia_max=held.high if held is not None else None,
        inertia_free_min=actuator.inertia_free.low if actuator.inertia_free is not None else None,
        natural_frequency=frequency,
        damping_ratio=ratio,
        command_range=_range(actuator),
        position_range=actuator.position_range,
        places=places,
        stated=frozenset(stated),
        **values,
    )


def _range(actuator: JointActuator) -> tuple[float, float] | None:
    if actuator.command_range is None:
        return None
    low, high = (end.value for end in actuator.command_range)
    return None if low is None or high is None else (low, high)
