"""Limits that the robot's file states, as witnesses of the figures of its motors."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

from actspec.diagnostics import Span
from actspec.ir import JointActuator, JointKind, Origin, Quantity
from actspec.spec.document import SourceMap
from actspec.spec.models import SpecModel
from actspec.spec.plausible.groups import drives_of
from actspec.spec.plausible.motors import Drive, Witness, output_of
from actspec.spec.plausible.repairs import witness_doubts
from actspec.spec.plausible.table import Doubt


def file_doubts(
    joints: Sequence[JointActuator], model: SpecModel, spans: SourceMap, reported: Collection[str]
) -> Iterator[Doubt]:
    """Figures of motors that the limits of the robot's file contradict.

    Args:
        joints: The resolved spec.
        model: The spec.
        spans: Where it says what it says.
        reported: Sections of the spec that have doubts already, such as `motors.hip`.
    """
    for drive in drives_of(model):
        driven = [joint for joint in joints if joint.motor == drive.name and joint.kind is JointKind.HINGE]
        told = {f"motors.{drive.name}", *(f"actuators.{joint.group}" for joint in driven)}
        if told.isdisjoint(reported):
            witnesses = tuple(
                witness for joint in driven for witness in _witnesses(joint, drive, model, spans)
            )
            yield from witness_doubts(replace(drive, witnesses=witnesses), spans)


def _witnesses(joint: JointActuator, drive: Drive, model: SpecModel, spans: SourceMap) -> Iterator[Witness]:
    """The limits that the file states of a joint; what drives several joints at once is not compared."""
    group = model.actuators.get(joint.group)
    if group is None or group.transmission is not None or joint.motor_line is None:
        return
    output, line = output_of(drive.name, drive.motor), joint.motor_line
    torques = [joint.peak_torque, joint.continuous_torque, line.stall_torque]
    speed = line.no_load_speed
    if line.curve is not None:
        torques.append(line.curve.drive_torque)
        speed = line.curve.no_load_speed
    most = max((torque.value or 0.0 for torque in torques if torque is not None), default=0.0)
    fast = 0.0 if speed is None else speed.value or 0.0
    efforts, speeds = _of_file(joint.effort_limit), _of_file(joint.velocity_limit)
    if efforts == speeds:
        # An exporter's own.
        return
    paths = {spans.value(limit.path): limit.path for limit in drive.limits}
    for value, is_speed, at_joint, at_output, stated in (
        (efforts, False, most, output.torque, joint.effort_limit),
        (speeds, True, fast, output.speed, joint.velocity_limit),
    ):
        if value is not None:
            factor = at_joint / at_output if at_joint and at_output else None
            yield Witness(joint.joint, value, is_speed, factor, _path(paths, stated))


def _path(paths: dict[Span, tuple[str | int, ...]], stated: Quantity) -> tuple[str | int, ...] | None:
    return None if stated.span is None else paths.get(stated.span)


def _of_file(limit: Quantity) -> float | None:
    """What the robot's file states of a limit; None: nothing, or a placeholder, which is 0 or a power of ten."""
    stated = next((one for one in (limit, *limit.lost) if one.origin is Origin.MODEL), None)
    value = None if stated is None else stated.value
    if not value or not 0.0 < value < math.inf or math.log10(value).is_integer():
        return None
    return value
