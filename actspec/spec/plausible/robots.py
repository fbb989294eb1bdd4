"""Checks of a joint's limits by those of the robot's other joints."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from actspec.diagnostics import Path, Span, dotted
from actspec.fields import is_power_of_ten
from actspec.ir import JointActuator, JointKind, Origin, Quantity
from actspec.spec.document import SourceMap
from actspec.spec.models import SpecModel
from actspec.spec.plausible.armatures import LARGEST_LIMIT
from actspec.spec.plausible.commands import own_speed
from actspec.spec.plausible.drive import stage_path
from actspec.spec.plausible.driven import AGREES, is_round
from actspec.spec.plausible.slips import in_si, lengths
from actspec.spec.plausible.table import Found, found_at, is_files, is_stated, shown
from actspec.spec.values import SpecValue
from actspec.units import format_quantity

FAR_ABOVE_OTHERS = 8.0
"""An effort limit above `LARGEST_LIMIT` over that of every other hinge. Published, of 355 robots with two: only
placeholders (1000 and 50000 N*m)."""
HELD_AT = 3.0
"""Error at which kp asks for it [rad]. Published: to 3.4, of no limit of that size."""
SLOWEST = 1.0
"""Velocity limit in another unit [rad/s], below which it is one of its robot's by the number."""
FASTER = 5.0
"""The limits of all other joints over it, from which on it is one of them by about its number."""
ROUNDED = 0.01
"""It is the motor's speed by its number if they differ by no more than this part."""


def odd_limit_found(
    joint: JointActuator, joints: Sequence[JointActuator], model: SpecModel, spans: SourceMap
) -> Iterator[Found]:
    """An effort limit that no hinge has, many times those of the robot's others, and that its own kp hardly asks for.

    Args:
        joint: The joint.
        joints: Those of the robot.
        model: The spec.
        spans: Where it says what it says.
    """
    limit, kp = joint.effort_limit, joint.kp
    size, others = limit.value or 0.0, _limits_beside(joint, joints)
    if (
        not others
        or kp is None
        or not kp.value
        or not is_stated(kp)
        or not is_stated(limit)
        or is_files(limit)
    ):
        return
    if not LARGEST_LIMIT < size < math.inf or is_power_of_ten(size) or joint.kind is not JointKind.HINGE:
        return
    most, error = max(others), size / kp.value
    if size < FAR_ABOVE_OTHERS * most or error < HELD_AT:
        return
    message = (
        f"an effort limit of {shown(limit)} is {format_quantity(size / most, '', 2)} times that of every other hinge, "
        f"at most {format_quantity(most, limit.unit, 4)}, and kp {shown(kp)} asks for it at an error of "
        f"{format_quantity(error, 'rad', 3)}"
    )
    where, number, help = (
        f"actuators.{joint.group}.effort_limit",
        limit,
        "look for a wrong unit or power of ten",
    )
    tenth = size / 10.0 <= AGREES * most
    if tenth and joint.motor is None:
        help = f"did you mean {format_quantity(size / 10.0, limit.unit, 4)}?"
    arm = _arm_of(joint, model)
    if arm is not None:
        path, value = arm
        tens = [words for factor, words, rare in lengths(value) if rare and factor == 0.1]
        where, number = dotted(path), replace(limit, span=spans.value(path))
        help = tens[0] if tens and tenth else "look for a wrong unit"
        help = f"one of 2 numbers is wrong. {path[-1]}: {help}{'' if help.endswith('?') else '.'} "
        help += f"Or the motor's torque ({limit.span}): look for a wrong unit or power of ten"
    yield found_at(joint, "SPEC183", where, size / most, message, help, number, kp)


def _limits_beside(joint: JointActuator, joints: Sequence[JointActuator]) -> list[float]:
    """Effort limits of the hinges of other groups that the spec has: of a file's one figure may be for all [N*m]."""
    return [
        other.effort_limit.value
        for other in joints
        if other.kind is JointKind.HINGE and other.group != joint.group
        if is_stated(other.effort_limit) and other.effort_limit.value and other.effort_limit.value < math.inf
    ]


def _arm_of(joint: JointActuator, model: SpecModel) -> tuple[Path, SpecValue] | None:
    """The lever arm or radius of the transmission to a joint, and where it is; None: there is none."""
    for index, stage in enumerate(model.actuators[joint.group].transmission or ()):
        value = stage.lever_arm or stage.radius
        if value is not None:
            return stage_path(stage, ("actuators", joint.group, "transmission", index)), value
    return None


def other_unit_found(
    joint: JointActuator, joints: Sequence[JointActuator], written: Mapping[Span, SpecValue]
) -> Iterator[Found]:
    """A velocity limit in deg/s or rpm that by its number is what the joint's motor or other joints have in rad/s.

    Args:
        joint: The joint.
        joints: Those of the robot.
        written: Numbers as they are written, by where.
    """
    limit = joint.velocity_limit
    own = None if limit.span is None else written.get(limit.span)
    plain, size = in_si(own), limit.value or 0.0
    if (
        own is None
        or plain is None
        or joint.kind is not JointKind.HINGE
        or limit.origin is not Origin.AUTHORED
    ):
        return
    if not 0.0 < size < SLOWEST or is_files(limit):
        return
    says = _says(joint, joints, written, size, plain.value or 0.0)
    if says is not None:
        message = f"a velocity limit of {own.written}, {shown(limit)}: {says}"
        where = f"actuators.{joint.group}.velocity_limit"
        yield found_at(joint, "SPEC184", where, 1.0 / size, message, f"did you mean {plain.written}?", limit)


def _says(
    joint: JointActuator,
    joints: Sequence[JointActuator],
    written: Mapping[Span, SpecValue],
    size: float,
    meant: float,
) -> str | None:
    """What says that a velocity limit is so large in rad/s, and not its size; None where nothing does."""
    others = [
        (other.joint, limit)
        for other in joints
        if other.kind is JointKind.HINGE and other.group != joint.group
        if (limit := other.velocity_limit).value
    ]
    motor = own_speed(joint)
    if motor is not None and math.isclose(motor.value or 0.0, meant, rel_tol=ROUNDED):
        return f"the motor '{joint.motor}' ends at {shown(motor)}"
    same = next((item for item in others if math.isclose(item[1].require(), meant, rel_tol=1e-6)), None)
    if same is None and not is_round(meant):
        # Nobody chooses three digits where all others are in rad/s and far above it: it is about one of them.
        far = all(_is_plain(limit, written) and limit.require() > FASTER * size for _, limit in others)
        near = (item for item in others if 1.0 / AGREES < meant / item[1].require() < AGREES)
        same = next(near, None) if far else None
    return None if same is None else f"{same[0]} has {shown(same[1])}"


def _is_plain(limit: Quantity, written: Mapping[Span, SpecValue]) -> bool:
    """Whether the spec states a limit in rad/s."""
    own = None if limit.span is None else written.get(limit.span)
    return own is not None and in_si(own) is None
