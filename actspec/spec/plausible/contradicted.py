"""What the robot's file contradicts where no slip explains it: a torque, a speed, the length of a transmission."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from actspec.ir import JointActuator
from actspec.spec.document import SourceMap
from actspec.spec.gears import Stage
from actspec.spec.models import SpecModel
from actspec.spec.plausible.drive import Drive, Train, output_of
from actspec.spec.plausible.driven import WITNESS
from actspec.spec.plausible.motors import relations
from actspec.spec.plausible.relations import Relation
from actspec.spec.plausible.slips import amount_of
from actspec.spec.plausible.table import Doubt, at
from actspec.spec.plausible.witnesses import limits_of_file
from actspec.spec.rules.motors import stage_ratio
from actspec.spec.values import SpecValue
from actspec.units import format_quantity

ONE_POWER = 1.05
"""Force and speed of a file are those of the motor behind another length if their product agrees by this factor."""
OTHER_LENGTH = 1.5
"""So many times off a length is told then. Chosen: a diameter for a radius is 2."""
DIAMETER = 1.03
"""It is twice the radius by this factor."""


def contradictions(
    drive: Drive, joints: Sequence[JointActuator], model: SpecModel, spans: SourceMap
) -> Iterator[Doubt]:
    """What the file contradicts by far about a motor, all of whose figures agree with each other.

    Args:
        drive: The motor, with the limits that the robot's file states.
        joints: The resolved spec.
        model: The spec.
        spans: Where it says what it says.
    """
    told = [item for item in relations(drive) if item.witnessed and item.path[0] == "motors"]
    lengths = list(_lengths(drive, told, spans))
    if lengths:
        yield from lengths
        return
    output = output_of(drive.name, drive.motor)
    groups = dict.fromkeys(joint.group for joint in joints if joint.motor == drive.name)
    for speed, place in ((False, output.torque_path), (True, output.speed_path)):
        found = {
            witness.joint: (item, witness.value)
            for witness in drive.witnesses
            if witness.speed == speed
            for item in told
            if item.path == place and item.about.startswith(f"witness {witness.joint} ")
        }
        # One figure for the joints of several motors is often an exporter's.
        if len(model.motors) > 1 and len(_stated(joints, speed)) == 1:
            continue
        wrong: dict[str, Relation] = {}
        for group in groups:
            mine = [joint for joint in joints if joint.group == group and joint.motor == drive.name]
            if all(
                joint.joint in found and _is_contradicted(joint, *found[joint.joint], speed) for joint in mine
            ):
                wrong[group] = found[mine[0].joint][0]
        for group, item in wrong.items():
            where, help = item.path, "one of the two is wrong, and no usual slip makes them agree"
            if len(wrong) < len(groups) and model.actuators[group].motor == drive.name:
                # For its other joints the motor is right.
                where, help = ("actuators", group, "motor"), "is another motor meant here?"
            yield at(spans, item.code, item.message, where, help, item.path, *item.others)
            if where == item.path:
                break


def _stated(joints: Sequence[JointActuator], speed: bool) -> set[float | None]:
    """The limits that the file states of joints with a motor."""
    return {limits_of_file(joint)[speed] for joint in joints if joint.motor is not None}


def _is_contradicted(joint: JointActuator, relation: Relation, stated: float, speed: bool) -> bool:
    """Whether motor and file cannot both be right.

    A speed of the file that is below the motor's is often chosen, and so is a torque, unless the spec itself gives the
    joint far more. A figure of one digit may be anybody's guess.
    """
    if f"{stated:.2e}"[1:4] == ".00":
        return False
    if relation.value <= 1.0 / WITNESS:
        return True
    limit = joint.effort_limit.value
    return (
        not speed
        and relation.path[-1] == "peak_torque"
        and relation.value >= WITNESS
        and limit is not None
        and limit / stated >= WITNESS
    )


def _lengths(drive: Drive, told: Sequence[Relation], spans: SourceMap) -> Iterator[Doubt]:
    """Lengths with which force and speed are both as many times off, the one above and the other below."""
    for key, train in drive.trains.items():
        lengths = [index for index, stage in enumerate(train.stages) if stage_ratio(stage) is None]
        if len(lengths) != 1:
            continue
        off: list[tuple[str, float]] = []
        for joint in dict.fromkeys(item.joint for item in drive.witnesses if item.train == key):
            ours = [item for item in told if item.about.startswith(f"witness {joint} ")]
            speeds = [item.value for item in ours if item.code == "SPEC184"]
            forces = [item.value for item in ours if item.code == "SPEC187"]
            one_power = speeds and forces and 1.0 / ONE_POWER <= speeds[0] * forces[0] <= ONE_POWER
            off.append((joint, math.sqrt(speeds[0] / forces[0]) if one_power else 1.0))
        factors = [factor for _, factor in off]
        if (
            factors
            and max(factors) <= ONE_POWER * min(factors)
            and not 1.0 / OTHER_LENGTH < factors[0] < OTHER_LENGTH
        ):
            yield _other_length(drive, train, lengths[0], *off[0], spans)


def _other_length(
    drive: Drive, train: Train, index: int, joint: str, factor: float, spans: SourceMap
) -> Doubt:
    stage: Stage = train.stages[index]
    place = train.place(index)
    given: SpecValue = getattr(stage, str(place[-1]))
    size, unit = amount_of(given)
    meant = f"{size / factor:.3g} {unit or given.unit}"
    output = output_of(drive.name, drive.motor)
    said = " and ".join(
        format_quantity(item.value, item.unit, 4) for item in drive.witnesses if item.joint == joint
    )
    own = (
        f"{format_quantity((output.torque or 0.0) * train.torque, 'N', 4)} and "
        f"{format_quantity((output.speed or 0.0) / train.speed, 'm/s', 4)}"
    )
    message = (
        f"behind a {place[-1]} of {given.written} the motor '{drive.name}' gives {own}; the robot's file gives the "
        f"joint '{joint}' {said}"
    )
    if place[-1] == "radius" and 2.0 / DIAMETER <= factor <= 2.0 * DIAMETER:
        help = f"is it the diameter? Then the radius is {meant}: with it force and speed both agree"
    else:
        help = f"did you mean {meant}? With it force and speed both agree"
    return at(spans, "SPEC187", message, place, help, output.torque_path, output.speed_path)
