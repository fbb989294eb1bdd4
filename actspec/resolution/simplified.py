"""What resolving a linkage or a lever takes for something simpler, with its size."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from actspec.diagnostics import listed
from actspec.ir import Approximation, JointActuator, Quantity
from actspec.spec.rules.robot import SPEC_ITSELF
from actspec.units import format_number, format_quantity

if TYPE_CHECKING:
    from actspec.resolution.linkage import LinkedMotors
    from actspec.resolution.motor import JointMotor

NEGLIGIBLE = 1e-9
"""Differences below this share are rounding. Chosen: as what targets are checked to."""

TORQUES = {"continuous_torque": "continuous", "peak_torque": "peak", "stall_torque": "stall"}
"""Torque of a motor to its word."""


def simplifications(
    joints: Sequence[JointActuator], motors: Mapping[str, JointMotor], linkages: Sequence[LinkedMotors]
) -> tuple[Approximation, ...]:
    """Everything that the spec itself approximates, levers by joint, then linkages in the spec's order.

    Args:
        joints: The resolved joints.
        motors: Joint to its motor, where it has one.
        linkages: The linkages.
    """
    by_name = {joint.joint: joint for joint in joints}
    found = [
        _loss(
            joint,
            "lever_arm",
            "an arm that changes with the joint's angle",
            f"{' and '.join(motors[joint.joint].arms)} at every angle",
            "one pose is stated; a linkage with a table says what the others are",
            None,
        )
        for joint in joints
        if joint.joint in motors and motors[joint.joint].arms
    ]
    for linkage in linkages:
        members = [by_name[name] for name in linkage.joints]
        if linkage.used is None:
            found += _factor(linkage, members)
        else:
            figure = _figure(linkage, members)
            found += [*_limits(linkage, members, figure), *_coupling(linkage, members)]
            found += _pose(linkage, members, figure)
    return tuple(found)


def _factor(linkage: LinkedMotors, members: Sequence[JointActuator]) -> Iterator[Approximation]:
    """A plain factor: nobody has computed the linkage."""
    for joint in members:
        yield _loss(
            joint,
            "linkage_factor",
            f"the linkage {linkage.name}",
            f"every joint by itself {format_quantity(linkage.factor, '')} x all of its motors, at every pose",
            "no Jacobian is stated; with several joints at their limits the motors would be used several times",
            None,
        )


def _limits(
    linkage: LinkedMotors, members: Sequence[JointActuator], figure: str | None
) -> Iterator[Approximation]:
    """Limits joint by joint, where the motors' torques are shared."""
    assert linkage.used is not None
    rows = linkage.used.torques
    if all(sum(entry != 0.0 for entry in row) == 1 for row in rows):
        return
    motors = [None if figure is None else _torque(motor, figure) for motor in linkage.motors]
    own = [joint.effort_limit.value for joint in members]
    if not all(motors) or None in own:
        for joint in members:
            yield _loss(
                joint,
                "linkage_limits",
                "a limit that the joints share",
                "a limit of each joint",
                "simulators limit every joint by itself; the torques are not all known",
                None,
            )
        return
    limits = [limit for limit in own if limit is not None]
    torques = [torque for torque in motors if torque is not None]
    word = TORQUES[figure or ""]
    if linkage.together:
        for index, joint in enumerate(members):
            alone = linkage.alone(torques, rows, index)
            if alone > limits[index] * (1.0 + NEGLIGIBLE):
                yield _loss(
                    joint,
                    "linkage_limits",
                    f"{format_quantity(alone, joint.effort_limit.unit)} while the others need nothing",
                    "a share of it that all joints can have at once",
                    "`limits: together`; simulators limit every joint by itself",
                    alone - limits[index],
                )
        return
    over = max(
        sum(abs(entry) * limit for entry, limit in zip(row, limits, strict=True)) / torque
        for row, torque in zip(rows, torques, strict=True)
    )
    if over <= 1.0 + NEGLIGIBLE:
        return
    for index, joint in enumerate(members):
        others = [other.joint for other in members if other is not joint]
        yield _loss(
            joint,
            "linkage_limits",
            f"{format_quantity(limits[index], joint.effort_limit.unit)} that it shares with {listed(others)}",
            "a limit of each joint by itself",
            f"with all at their limits the motors need {format_number(over)} times their {word} torque; "
            "`limits: together` has what all can have at once",
            limits[index] * (1.0 - 1.0 / over),
        )


def _coupling(linkage: LinkedMotors, members: Sequence[JointActuator]) -> Iterator[Approximation]:
    """Inertia between the joints, which an armature cannot hold."""
    inertias = [
        linkage.at_joint(index, joint.kind).reflected_inertia.value for index, joint in enumerate(members)
    ]
    for index, joint in enumerate(members):
        between = {}
        for other in range(len(members)):
            shared = None if other == index else linkage.coupling(index, other)
            one, two = inertias[index], inertias[other]
            if shared is None or one is None or two is None:
                continue
            if abs(shared) > NEGLIGIBLE * (one * two) ** 0.5:
                between[other] = shared
        if not between:
            continue
        parts = [
            f"{format_quantity(shared, joint.armature.unit)} with {members[other].joint}"
            for other, shared in between.items()
        ]
        limits = {other: members[other].effort_limit.value for other in between}
        size = None
        if all(limit is not None for limit in limits.values()):
            size = sum(
                abs(shared) * (limits[other] or 0.0) / (inertias[other] or 1.0)
                for other, shared in between.items()
            )
        yield _loss(
            joint,
            "linkage_inertia",
            ", ".join(parts),
            "none: each joint has its own armature",
            "an armature is a diagonal; sized by the other joint's limit on its armature alone",
            size,
        )


def _pose(
    linkage: LinkedMotors, members: Sequence[JointActuator], figure: str | None
) -> Iterator[Approximation]:
    """One pose's Jacobian at every pose."""
    if linkage.everywhere:
        return
    for index, joint in enumerate(members):
        if not linkage.table:
            yield _loss(
                joint,
                "linkage_pose",
                "a Jacobian that changes with the pose",
                "that of one pose",
                "one is stated; a table says what the others are, `at: any` that there are none",
                None,
            )
            continue
        here = linkage.at_joint(index, joint.kind)
        poses = [linkage.at_joint(index, joint.kind, geometry) for geometry in linkage.table]
        torques = [None if figure is None else _torque(motor, figure) for motor in poses]
        known = [torque for torque in torques if torque is not None]
        own = None if figure is None else _torque(here, figure)
        asked, emitted = [], []
        for name, unit, values, value in (
            ("limit", joint.effort_limit.unit, known, own),
            (
                "armature",
                joint.armature.unit,
                [m.reflected_inertia.require() for m in poses if m.reflected_inertia.known],
                here.reflected_inertia.value,
            ),
        ):
            if values and value is not None and max(values) - min(values) > NEGLIGIBLE * max(values):
                asked.append(f"{name} {format_number(min(values))} to {format_quantity(max(values), unit)}")
                emitted.append(f"{name} {format_quantity(value, unit)}")
        if asked:
            yield _loss(
                joint,
                "linkage_pose",
                f"{', '.join(asked)} over {len(poses)} poses",
                ", ".join(emitted),
                "no target has a transmission that changes with the pose",
                None if own is None else max(abs(torque - own) for torque in known),
            )


def _figure(linkage: LinkedMotors, members: Sequence[JointActuator]) -> str | None:
    """The torque of the motors that the joints' limits are made of; else the strongest that is known."""
    for name in TORQUES:
        at_joints = [
            _torque(linkage.at_joint(index, joint.kind), name) for index, joint in enumerate(members)
        ]
        if None not in at_joints and at_joints == [joint.effort_limit.value for joint in members]:
            return name
    for name in ("peak_torque", "stall_torque", "continuous_torque"):
        if all(_torque(motor, name) is not None for motor in linkage.motors):
            return name
    return None


def _torque(motor: JointMotor, name: str) -> float | None:
    """A torque of a motor; of an asymmetric curve the drive torque is the stall torque."""
    found: Quantity | None = getattr(motor, name)
    if found is None and motor.curve is not None and name == "stall_torque":
        found = motor.curve.drive_torque
    return None if found is None else found.value


def _loss(
    joint: JointActuator, field: str, asked: str, emitted: str, why: str, error: float | None
) -> Approximation:
    size = error if error is not None and math.isfinite(error) else None
    return Approximation(SPEC_ITSELF, joint.joint, field, asked, emitted, why, size, joint.effort_limit.unit)
