"""Rows of the ledger from robot files: a view of the readings of their joints.

A joint is one row for each actuator that drives it directly, a bare one is one row of control `none`.
What drives a tendon, a site, a body, a ball or a joint without a name has a row without a joint, without
figures at a joint, after all others. How much of it reaches a joint depends on the pose: limit, total damping and
what follows from them are unknown at a joint that it moves.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from actspec.audit.ledger import LedgerRow
from actspec.audit.rows.spec import rows_of_spec
from actspec.diagnostics import Span
from actspec.readings.artifact import Artifact
from actspec.readings.joint import (
    IMPLICIT,
    DriveReading,
    JointReading,
    joint_inertias,
    loose_actuators,
    read_joints,
)
from actspec.robot.view import ActuatorView, ModelFormat

__all__ = ["rows_of_robot", "rows_of_spec"]

_CONTROLS = {name: name for name in ("position", "velocity", "motor", "dcmotor", "pid")}


def rows_of_robot(artifact: Artifact, index: int) -> tuple[LedgerRow, ...]:
    """Rows of an MJCF or URDF.

    A dcmotor's voltage is not among the clamps of a limit: it is `stall_torque` and `no_load_speed`.

    A URDF has no actuator and no armature; an effort or velocity of 0 stays 0. Damping and friction that
    a URDF does not state are 0, as in every importer.

    An actuator that the file switches off has a row of control `other` without gains; only its damping and
    armature are in the totals.

    `default_position` is the first keyframe's. The command range of a servo is in joint position or speed,
    that of a motor in torque at the joint.

    Args:
        artifact: Of kind MJCF or URDF, with its robot.
        index: Its place in `Case.artifacts`.
    """
    robot = artifact.robot
    assert robot is not None
    posed = bool(robot.keyframes)
    found = [
        row
        for reading in read_joints(robot, joint_inertias(robot)).values()
        for row in _rows(artifact.path, index, reading, posed)
    ]
    found.extend(_loose(artifact.path, index, actuator) for actuator in loose_actuators(robot))
    return tuple(found)


def _rows(file: str, index: int, reading: JointReading, posed: bool) -> list[LedgerRow]:
    """One for each actuator, or the bare joint's."""
    mjcf = reading.format is ModelFormat.MJCF
    joint, inertia = reading.joint, reading.inertia
    implicit, places = reading.is_passive_implicit, reading.places
    shared: dict[str, Any] = {
        "file": file,
        "artifact": index,
        "span": joint.span,
        "joint": joint.name,
        "actuator": "",
        "control": "none",
        "kind": joint.kind,
        "joint_damping": reading.joint_damping.value,
        "joint_damping_clamped": False if mjcf else None,
        "joint_damping_implicit": implicit,
        "actuator_damping": 0.0 if mjcf else None,
        "actuator_damping_clamped": False if mjcf else None,
        "actuator_damping_implicit": implicit,
        "total_damping": reading.total_damping,
        "frictionloss": reading.frictionloss.value,
        "effort_limit": reading.effort_limit.value,
        "velocity_limit": joint.velocity_limit,
        "armature": reading.total_armature,
        "inertia_min": inertia.held.low if inertia is not None else None,
        "inertia_max": inertia.held.high if inertia is not None else None,
        "inertia_free_min": inertia.free.low if inertia is not None else None,
        "natural_frequency": reading.natural_frequency,
        "damping_ratio": reading.damping_ratio,
        "stability": reading.stability,
        "position_range": None if "range" in joint.unknown else joint.range,
        "default_position": joint.reference_position
        if posed and "reference_position" not in joint.unknown
        else None,
        "places": _elsewhere(places, joint.span),
        "stated": frozenset(places),
    }
    if not reading.drives:
        return [LedgerRow(**shared)]
    return [LedgerRow(**{**shared, **_of_drive(reading, drive, places)}) for drive in reading.drives]


def _of_drive(reading: JointReading, drive: DriveReading, places: Mapping[str, Span]) -> dict[str, Any]:
    """The fields in which the row of an actuator differs from that of the bare joint."""
    view = drive.view
    # The joint's own attribute keeps its place: two places state such a field.
    places = {**drive.places, **places}
    same = {
        "span": view.span,
        "actuator": view.name,
        "actuator_damping": drive.damping,
        "places": _elsewhere(places, view.span),
        "stated": frozenset(places),
    }
    if not drive.is_on:
        return {**same, "control": "other", "kp": 0.0, "kd": 0.0, "back_emf": 0.0}
    hidden = "force_range" in view.unknown or "effort_range" in reading.joint.unknown
    limit = view.force_range is not None or reading.joint.effort_range is not None
    line = view.line or (None, None)
    return {
        **same,
        "control": _CONTROLS.get(view.control, "other"),
        "kp": drive.kp.value,
        "kd": drive.kd.value,
        "kd_clamped": None if hidden else limit,
        "kd_implicit": reading.integrator in IMPLICIT if reading.integrator else None,
        "back_emf": _known(view, "back_emf"),
        "stall_torque": line[0],
        "no_load_speed": line[1],
        "delay": _known(view, "delay"),
        "command_range": drive.command_range,
    }


def _elsewhere(places: Mapping[str, Span], row: Span) -> dict[str, Span]:
    """Places that are not the row's own."""
    # Most are on the line of the row, which is then the same object, or on another line.
    return {
        name: place
        for name, place in places.items()
        if place is not row and (place.line != row.line or place != row)
    }


def _loose(file: str, index: int, actuator: ActuatorView) -> LedgerRow:
    """The row of an actuator whose joint has no name, or that drives something else."""
    return LedgerRow(
        file=file,
        artifact=index,
        span=actuator.span,
        joint="",
        actuator=actuator.name,
        control=_CONTROLS.get(actuator.control, "other"),
        drives=f"{actuator.transmission} {actuator.target}".rstrip(),
        delay=_known(actuator, "delay"),
    )


def _known(actuator: ActuatorView, name: str) -> float | None:
    """A field of an actuator; None where the text does not tell."""
    value: float = getattr(actuator, name)
    return None if name in actuator.unknown else value
