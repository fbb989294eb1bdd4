"""Limits that the robot's file states, as witnesses of the figures of its motors."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import replace

from actspec.diagnostics import Span
from actspec.fields import BY_IR, FRICTION_SHARE, is_placeholder, is_power_of_ten
from actspec.ir import JointActuator, JointKind, Origin, Quantity
from actspec.spec.document import SourceMap
from actspec.spec.models import Actuators, SpecModel, Tunable
from actspec.spec.plausible.drive import (
    GEARED,
    Drive,
    Witness,
    efficiency_of,
    gear_of,
    number,
    output_of,
    scaled,
)
from actspec.spec.plausible.driven import AGREES, WITNESS
from actspec.spec.plausible.groups import drives_of, reduction_of, written_numbers
from actspec.spec.plausible.relations import DEGREE, FAR_ABOVE_FILE, KGF_CM, RPM
from actspec.spec.plausible.slips import in_si, thousandth
from actspec.spec.plausible.table import Doubt, Found, Kept, in_file
from actspec.units import format_quantity

SAME = 1.03
"""A slip explains a number if it comes to the file's by this factor: kgf*cm are rounded to two digits."""
NEAR_FILE = 1.02
"""A smaller effort limit is a slip of that of the file if it comes to it by this factor."""
LEAST_REDUCTION = 1.2
"""From here on a joint is stronger than its motor by a reduction. Chosen: by less its limit may be by itself."""
SQUARED = 0.05
"""By this part the armature is the square of the torque. Chosen: either figure is rounded to two digits."""
_LIMITS = ("effort_limit", "velocity_limit")
_OF_FILE = (*_LIMITS, "kp", "kd", "armature", "friction_coulomb", "friction_viscous")


def witnessed(
    joints: Sequence[JointActuator], model: SpecModel, spans: SourceMap, kept: Kept
) -> Iterator[Drive]:
    """Every motor of a spec, with the limits that the robot's file states of its joints.

    Args:
        joints: The resolved spec.
        model: The spec.
        spans: Where it says what it says.
        kept: What the author is sure of.
    """
    for drive in drives_of(model):
        driven = [joint for joint in joints if joint.motor == drive.name and _is_compared(joint, drive)]
        found = tuple(witness for joint in driven for witness in _witnesses(joint, drive, model, spans))
        yield replace(drive, witnesses=found, sure=kept.paths, large="SPEC183" in kept.codes)


def file_doubts(joints: Sequence[JointActuator], model: SpecModel, spans: SourceMap) -> Iterator[Found]:
    """Numbers that the robot's file contradicts: it is named as their source, or they are limits far from its.

    A limit that names another source is not mistyped: Isaac Lab's hand of the Panda has 200 N of the file's 20.
    """
    name = os.path.basename(model.robot.model)
    own = {key for key, source in model.sources.items() if os.path.basename(str(source.page)) == name}
    efforts, written = [limits_of_file(joint)[0] for joint in joints], written_numbers(model, spans)
    # One figure for every joint is often an exporter's, or its user's.
    one_for_all = len(efforts) > 1 and len(set(efforts)) == 1
    for joint in joints:
        exchanged = _is_exchanged(joint)
        for field in _OF_FILE:
            if exchanged and field == "velocity_limit":
                # It is told at the effort limit.
                continue
            stated: Quantity | None = getattr(joint, field)
            if stated is None or stated.origin is not Origin.AUTHORED or not stated.value:
                continue
            said = in_file(*stated.lost)
            if said is None or not said.value or said.value * stated.value <= 0.0:
                continue
            ratio, slip = stated.value / said.value, None
            if stated.source in own:
                told = not 1.0 / WITNESS < ratio < WITNESS
                own_words = None if stated.span is None else written.get(stated.span)
                plain, given = in_si(own_words), _shown(stated)
                if (
                    own_words is not None
                    and plain is not None
                    and _is_same((plain.value or 0.0) / said.value)
                ):
                    given, slip = own_words.written, f"did you mean {plain.written}?"
                text = f"{given} names {stated.source} as its source, the robot's file, which has"
                code = "SPEC194"
            else:
                if field == "effort_limit" and not one_for_all and limits_of_file(joint)[0] is not None:
                    slip = _slip_of_effort(joint, model, ratio)
                told = field in _LIMITS and (slip is not None or _is_far(joint, field, ratio))
                text = f"{field} {_shown(stated)} is {_times(ratio)} the robot's file, which has"
                code = "SPEC184" if field == "velocity_limit" else "SPEC187"
            if told or (exchanged and field == "effort_limit"):
                where = f"actuators.{joint.group}.{BY_IR[field].spec}"
                message, help = f"{text} {_shown(said)}", slip or _meant(stated, ratio)
                size = abs(math.log(ratio))
                if exchanged and field == "effort_limit":
                    other = joint.velocity_limit
                    help = f"are effort_limit and velocity_limit ({other.span}) exchanged? The file has "
                    help += f"{_shown(said)} and {format_quantity(stated.value, other.unit, 4)}"
                yield Found(Doubt(code, message, where, stated.span, help), joint.joint, size)


def left_out_reduction(joint: JointActuator, model: SpecModel, spans: SourceMap) -> Iterator[Found]:
    """A joint that is so many times as strong as its motor, by limit, and by armature in the robot's file as many times
    squared as heavy: both are of one reduction, which the spec leaves out.
    """
    group, limit, armature = model.actuators.get(joint.group), joint.effort_limit, joint.armature
    if group is None or joint.motor is None or group.motor is None or any(map(_is_between, _layers(group))):
        return
    own, torque = armature.value, joint.peak_torque.value
    heavier, stronger = in_file(*armature.lost), in_file(limit, *limit.lost)
    if not own or not torque or heavier is None or not heavier.value or armature.origin is Origin.AUTHORED:
        return
    square = heavier.value / own
    for force in filter(None, (stronger, limit)):
        times = (force.value or 0.0) / torque
        if times > LEAST_REDUCTION and math.isclose(times**2, square, rel_tol=SQUARED):
            where = ("actuators", joint.group, "motor")
            what = "the robot's file" if force is stronger else "the spec"
            message = (
                f"{what} has an effort limit of {_shown(force)}, {times:.3g} times the motor's "
                f"{_shown(joint.peak_torque)}, and the robot's file an armature of {_shown(heavier)}, {square:.3g} "
                f"times the motor's {_shown(armature)}: as behind a reduction of {times:.3g}"
            )
            help = f"did you leave out `reduction: {times:.3g}`?"
            yield Found(
                Doubt("SPEC182", message, ".".join(where), spans.value(where), help), joint.joint, times
            )
            return


def _layers(group: Actuators) -> tuple[Tunable, ...]:
    return (group, *group.overrides.values())


def _is_between(fields: Tunable) -> bool:
    """Whether something stands between a motor and its joints."""
    return any((fields.reduction, fields.transmission, fields.motors_per_joint))


def _is_exchanged(joint: JointActuator) -> bool:
    """Whether effort and velocity limit are each the number that the file has for the other, and far from their own."""
    pairs = [(limit.value, limit.lost) for limit in (joint.effort_limit, joint.velocity_limit)]
    (effort, efforts), (speed, speeds) = pairs
    ours, theirs = (in_file(*efforts), in_file(*speeds))
    force, fast = (None if one is None else one.value for one in (ours, theirs))
    if not effort or not speed or not force or not fast or joint.effort_limit.origin is not Origin.AUTHORED:
        return False
    if joint.velocity_limit.origin is not Origin.AUTHORED or 1.0 / WITNESS < effort / force < WITNESS:
        return False
    return math.isclose(effort, fast, rel_tol=0.01) and math.isclose(speed, force, rel_tol=0.01)


def _times(ratio: float) -> str:
    return f"{format_quantity(max(ratio, 1.0 / ratio), '', 3)} times {'above' if ratio > 1.0 else 'below'}"


def _shown(quantity: Quantity) -> str:
    return format_quantity(quantity.value, quantity.unit, 4)


def _is_far(joint: JointActuator, field: str, ratio: float) -> bool:
    """Whether a limit that is so many times the file's can hardly be meant."""
    stated: Quantity = getattr(joint, field)
    efforts, speeds = limits_of_file(joint)
    if (efforts if field == "effort_limit" else speeds) is None:
        return False
    if FAR_ABOVE_FILE < ratio < math.inf and not is_power_of_ten(stated.require()):
        return True
    friction = joint.friction_coulomb
    known = in_file(friction, *friction.lost)
    bearing = None if known is None else known.value
    # Where friction does not leave the limit anything, the file tells which of the two is wrong.
    return bool(
        field == "effort_limit"
        and ratio < 1.0 / WITNESS
        and bearing
        and friction.value
        and 1.0 / AGREES < friction.value / bearing < AGREES
        and friction.value >= FRICTION_SHARE * stated.require()
    )


def _slip_of_effort(joint: JointActuator, model: SpecModel, ratio: float) -> str | None:
    """What an effort limit may be that is so many times the file's; None where it may be meant.

    A smaller limit is often the truer one: only what is the rotor's by the gear, or a power of ten, is told of it. A
    larger one is the motor's matter where its torque is known.
    """
    stated, motor = joint.effort_limit, model.motors.get(joint.motor or "")
    gear = 0.0 if motor is None or motor.side != "motor" else gear_of(motor) or 0.0
    if motor is not None and gear >= GEARED and 1.0 / NEAR_FILE < ratio * gear < NEAR_FILE:
        there = format_quantity(stated.require() * gear * efficiency_of(motor), stated.unit, 4)
        return f"is it quoted at the rotor? At the joint it is {there}, by the gear ratio of {gear:g}"
    if stated.source is not None:
        return None
    tens = round(math.log10(ratio))
    if tens < 0 and 1.0 / NEAR_FILE < ratio / 10.0**tens < NEAR_FILE:
        return _meant(stated, ratio)
    line = joint.motor_line
    known = (joint.peak_torque, joint.continuous_torque, None if line is None else line.stall_torque)
    given = any(torque is not None and torque.value for torque in known)
    above = WITNESS <= ratio < math.inf and not is_placeholder(stated.require())
    return _meant(stated, ratio) if above and not given else None


def _meant(stated: Quantity, ratio: float) -> str:
    """What is likely to be meant by a number that is so many times the file's."""
    size, unit = stated.require(), stated.unit
    slips = [(1e3, f"is it in {thousandth(unit)}")]
    if unit == "N*m":
        slips += [(1.0 / KGF_CM, "is it in kgf*cm"), (0.01 / KGF_CM, "is it in kgf*m")]
    if unit == "rad/s":
        slips = [(1.0 / DEGREE, "is it in deg/s"), (1.0 / RPM, "is it in rpm")]
    elif unit in ("N/m", "N*s/m"):
        slips.append((1e-3, "is it per mm"))
    elif "rad" in unit:
        slips += [(1.0 / DEGREE, "is it multiplied by 57.3"), (DEGREE, "is it per degree")]
    slips += [(10.0**power, "is the point in the wrong place") for power in (1, 2, 3, -1, -2, -3)]
    factor, words = min(slips, key=lambda slip: abs(math.log(ratio / slip[0])))
    if not _is_same(ratio / factor):
        return "look for a wrong unit"
    return f"{words}? Then it is {format_quantity(size / factor, unit, 4)}"


def _is_same(ratio: float) -> bool:
    return 1.0 / SAME <= ratio <= SAME


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
    efforts, speeds = limits_of_file(joint)
    paths = {spans.value(limit.path): limit.path for limit in drive.limits}
    layers = [_path(paths, limit) for limit in (joint.effort_limit, joint.velocity_limit)]
    # Of which layer its reduction is, its limits tell; without any it is the group's, where no override has its own.
    known = ((limit.reduced, limit.reduction) for limit in drive.limits if limit.path in layers)
    reduced, reduction = next(known, None) or reduction_of(joint.group, group) or (None, 1.0)
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
                reduced,
                reduction,
            )
            times = scaled(witness, drive.trains)
            if witness.factor and 0.0 < times < math.inf:
                witness = replace(witness, factor=witness.factor / times)
            else:
                witness = replace(witness, factor=None)
            yield witness


def _path(paths: dict[Span, tuple[str | int, ...]], stated: Quantity) -> tuple[str | int, ...] | None:
    return None if stated.span is None else paths.get(stated.span)


def limits_of_file(joint: JointActuator) -> tuple[float | None, float | None]:
    """Effort and velocity limit that the robot's file states; two equal ones are an exporter's own."""
    efforts, speeds = _of_file(joint.effort_limit), _of_file(joint.velocity_limit)
    return (None, None) if efforts == speeds else (efforts, speeds)


def _of_file(limit: Quantity) -> float | None:
    """What the robot's file states of a limit; None: nothing, or a placeholder, which is 0 or a power of ten."""
    stated = in_file(limit, *limit.lost)
    value = None if stated is None else stated.value
    if not value or not 0.0 < value < math.inf or is_power_of_ten(value):
        return None
    return value
