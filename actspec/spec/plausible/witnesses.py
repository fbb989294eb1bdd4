"""Limits that the robot's file states, as witnesses of the figures of its motors."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

from actspec.diagnostics import Span
from actspec.ir import JointActuator, JointKind, Origin, Quantity
from actspec.spec.document import SourceMap
from actspec.spec.models import SpecModel
from actspec.spec.plausible.drive import Drive, Witness, number, output_of, scaled
from actspec.spec.plausible.driven import AGREES
from actspec.spec.plausible.groups import drives_of
from actspec.spec.plausible.relations import DEGREE, FAR_ABOVE_FILE
from actspec.spec.plausible.repairs import witness_doubts
from actspec.spec.plausible.table import Doubt
from actspec.units import format_quantity


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
        driven = [joint for joint in joints if joint.motor == drive.name and _is_compared(joint, drive)]
        told = {f"motors.{drive.name}", *(f"actuators.{joint.group}" for joint in driven)}
        if told.isdisjoint(reported):
            witnesses = tuple(
                witness for joint in driven for witness in _witnesses(joint, drive, model, spans)
            )
            yield from witness_doubts(replace(drive, witnesses=witnesses), spans)


def limit_doubts(joints: Sequence[JointActuator]) -> Iterator[Doubt]:
    """Limits that the spec states far above those of the robot's file, with a motor or without.

    Isaac Lab's hand of the Panda has 200 N of the file's 20, and limits are stated where a file has small
    placeholders: a factor of ten tells nothing. A power of ten is a placeholder in the spec, too.
    """
    for joint in joints:
        efforts, speeds = _of_file(joint.effort_limit), _of_file(joint.velocity_limit)
        if efforts == speeds:
            continue
        for field, stated, value in (
            ("effort_limit", joint.effort_limit, efforts),
            ("velocity_limit", joint.velocity_limit, speeds),
        ):
            size = stated.value
            if not value or not size or stated.origin is not Origin.AUTHORED or stated.span is None:
                continue
            ratio = size / value
            if not FAR_ABOVE_FILE < ratio < math.inf or math.log10(size).is_integer():
                continue
            yield Doubt(
                "SPEC184" if field == "velocity_limit" else "SPEC187",
                f"{joint.joint}: {field} {format_quantity(size, stated.unit, 4)} is {format_quantity(ratio, '', 3)} "
                f"times the {format_quantity(value, stated.unit, 4)} of the robot's file",
                f"actuators.{joint.group}.{field}",
                stated.span,
                _meant(stated, ratio),
            )


def _meant(stated: Quantity, ratio: float) -> str:
    """What is likely to be meant by a limit that is so many times the file's."""
    size, unit = stated.require(), stated.unit
    slips = [(1e3, f"is it in m{unit}"), (100.0, "is the point in the wrong place")]
    if unit == "rad/s":
        slips = [(1.0 / DEGREE, "is it in deg/s")]
    for factor, words in slips:
        if factor / AGREES <= ratio <= factor * AGREES:
            return f"{words}? Then it is {format_quantity(size / factor, unit, 4)}"
    return "look for a wrong unit"


def _is_compared(joint: JointActuator, drive: Drive) -> bool:
    """Whether the figures of a motor that turns are at the joint's by its gears."""
    return joint.kind is JointKind.HINGE or bool(drive.trains)


def _witnesses(joint: JointActuator, drive: Drive, model: SpecModel, spans: SourceMap) -> Iterator[Witness]:
    """The limits that the file states of a joint; what drives several joints at once is not compared."""
    group = model.actuators.get(joint.group)
    if group is None or joint.motor_line is None:
        return
    output, line = output_of(drive.name, drive.motor), joint.motor_line
    torques = [joint.peak_torque, joint.continuous_torque, line.stall_torque]
    speed = line.no_load_speed
    if line.curve is not None:
        torques.append(line.curve.drive_torque)
        speed = line.curve.no_load_speed
    if number(drive.motor.peak_torque):
        # As in `Output`.
        torques = [joint.peak_torque]
    most = max((torque.value or 0.0 for torque in torques if torque is not None), default=0.0)
    fast = 0.0 if speed is None else speed.value or 0.0
    efforts, speeds = _of_file(joint.effort_limit), _of_file(joint.velocity_limit)
    if efforts == speeds:
        # An exporter's own.
        return
    paths = {spans.value(limit.path): limit.path for limit in drive.limits}
    here = [key for key in drive.trains if key[:2] == ("actuators", joint.group)]
    count, counted = group.motors_per_joint or 1, ("actuators", joint.group, "motors_per_joint")
    if len(here) > 1 or any(other.motors_per_joint or other.motor for other in group.overrides.values()):
        # Of which layer the joint is, is not told here.
        here, count = [], 1
    for value, is_speed, at_joint, at_output, stated in (
        (efforts, False, most, output.torque, joint.effort_limit),
        (speeds, True, fast, output.speed, joint.velocity_limit),
    ):
        if value is not None:
            witness = Witness(
                joint.joint,
                value,
                stated.unit,
                is_speed,
                at_joint / at_output if at_joint and at_output else None,
                _path(paths, stated),
                here[0] if here else None,
                count,
                counted if count > 1 else None,
            )
            times = scaled(witness, drive.trains)
            if witness.factor and 0.0 < times < math.inf:
                witness = replace(witness, factor=witness.factor / times)
            else:
                witness = replace(witness, factor=None)
            yield witness


def _path(paths: dict[Span, tuple[str | int, ...]], stated: Quantity) -> tuple[str | int, ...] | None:
    return None if stated.span is None else paths.get(stated.span)


def _of_file(limit: Quantity) -> float | None:
    """What the robot's file states of a limit; None: nothing, or a placeholder, which is 0 or a power of ten."""
    stated = next((one for one in (limit, *limit.lost) if one.origin is Origin.MODEL), None)
    value = None if stated is None else stated.value
    if not value or not 0.0 < value < math.inf or math.log10(value).is_integer():
        return None
    return value
