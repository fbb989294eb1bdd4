"""Corrections of what stands between a motor and its joints: stages, numbers of motors, reductions."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from actspec.diagnostics import Path
from actspec.ir import JointActuator
from actspec.spec.document import SourceMap
from actspec.spec.gears import Stage
from actspec.spec.models import SpecModel
from actspec.spec.plausible.drive import Drive, gear_of, number, stage_path, turns_of
from actspec.spec.plausible.groups import MULTIPLIERS, layers
from actspec.spec.plausible.motors import is_said, relations
from actspec.spec.plausible.relations import RARE, Repair
from actspec.spec.plausible.slips import inertias, multiplied, stage_slips
from actspec.spec.plausible.table import Doubt, at
from actspec.units import format_quantity

TWICE = 5.0
"""A reduction from which on it is the motor's gear once more if the two are equal. Published reductions: to 2.2; a belt
of 3 or 4 behind a gear of 3 or 4 is built."""
SAME_GEAR = 0.01
"""They are equal by this part: one of the two may be rounded."""
COPIED = -3.0
"""What it costs that the gear stands twice, as `RARE`: the same number again is no accident, however usual the figures
are without either."""
COUNTED_TWICE = {
    key: f"is the gear counted twice? Then remove this: {MULTIPLIERS[key]}, behind its own gear"
    for key in ("reduction", "transmission")
}
MOST_MOTORS = 8
"""Of one joint. Published: 2; chosen: slews of large machines have 8."""
SEVERAL_MOTORS = 3
"""Motors of one joint from which on they are those of all joints if they are as many."""


def stages_repaired(drive: Drive) -> Iterator[Repair]:
    """Corrections of the stages of the gearbox, and of the transmissions to the joints."""
    gearbox = drive.motor.gearbox or ()
    root: Path = ("motors", drive.name, "gearbox")
    for index, stages, help, rare in _other_stages(gearbox):
        motor = drive.motor.model_copy(update={"gearbox": stages})
        place = stage_path(gearbox[index], (*root, index))
        yield Repair(tuple(relations(replace(drive, motor=motor))), (place,), help, rare)
    for index, stage in enumerate(gearbox):
        if number(stage.inertia) and stage.inertia is not None:
            for factor, help, rare in inertias(stage.inertia):
                other = stage.model_copy(update={"inertia": multiplied(stage.inertia, factor)})
                stages = (*gearbox[:index], other, *gearbox[index + 1 :])
                motor = drive.motor.model_copy(update={"gearbox": stages})
                yield Repair(
                    tuple(relations(replace(drive, motor=motor))), ((*root, index, "inertia"),), help, rare
                )
    for train in {train.root: train for train in drive.trains.values()}.values():
        for index, stages, help, rare in _other_stages(train.stages):
            after = tuple(relations(_with_stages(drive, train.root, stages)))
            yield Repair(after, (train.place(index),), help, rare)
        for first, second in itertools.combinations(range(len(train.stages)), 2):
            one, two = train.stages[first], train.stages[second]
            if one.radius is None or two.radius is None:
                continue
            stages = tuple(
                stage.model_copy(update={"radius": {first: two, second: one}.get(index, stage).radius})
                for index, stage in enumerate(train.stages)
            )
            places = (train.place(first), train.place(second))
            help = f"are the two radii, {one.radius.written} and {two.radius.written}, exchanged?"
            yield Repair(tuple(relations(_with_stages(drive, train.root, stages))), places, help)


def _other_stages(stages: Sequence[Stage]) -> Iterator[tuple[int, tuple[Stage, ...], str, float]]:
    """Stages with one of them the wrong way round, in another unit or left out; which, what was meant, its cost."""
    for index, stage in enumerate(stages):
        for other, help, rare in stage_slips(stage):
            yield index, (*stages[:index], other, *stages[index + 1 :]), help, rare
        before = stages[index - 1].ratio if index else None
        if stage.ratio is not None and before is not None and stage.ratio.value == before.value:
            # Two equal stages are built as well.
            yield index, (*stages[:index], *stages[index + 1 :]), "is this stage written twice?", RARE


def _with_stages(drive: Drive, root: Path, stages: tuple[Stage, ...]) -> Drive:
    """The drive with other stages where those of a train are written."""
    trains = {
        key: replace(train, stages=stages) if train.root == root else train
        for key, train in drive.trains.items()
    }
    return replace(drive, trains=trains)


def counts_repaired(drive: Drive) -> Iterator[Repair]:
    """One motor in place of many."""
    gear = gear_of(drive.motor)
    counted = {item.counted: item.motors for item in drive.limits if item.counted is not None}
    counted |= {item.counted: item.motors for item in drive.witnesses if item.counted is not None}
    for place, motors in counted.items():

        def one(path: Path, place: Path = place) -> bool:
            return path[:2] == place[:2]

        changed = replace(
            drive,
            witnesses=tuple(
                replace(item, motors=1) if item.counted == place else item for item in drive.witnesses
            ),
            limits=tuple(replace(item, motors=1) if one(item.path) else item for item in drive.limits),
            trains={
                key: replace(train, motors=1) if one(key) else train for key, train in drive.trains.items()
            },
        )
        yield Repair(tuple(relations(changed)), (place,), _one_motor(gear, motors))


def reductions_repaired(drive: Drive) -> Iterator[Repair]:
    """A reduction from the motor to the joint that is the gear's again, or whose point is in the wrong place."""
    gear = gear_of(drive.motor)
    reductions = {item.reduced: item.reduction for item in drive.limits if item.reduced is not None}
    reductions |= {item.reduced: item.reduction for item in drive.witnesses if item.reduced is not None}
    for place, size in reductions.items():
        slips = [
            (10.0**power, f"did you mean {size * 10.0**power:.4g}? {MULTIPLIERS['reduction']}", RARE)
            for power in (-2, -1, 1, 2)
        ]
        if _is_gear_again(gear, size):
            slips.append((1.0 / size, COUNTED_TWICE["reduction"], COPIED))
        for factor, help, rare in slips:
            limits = tuple(
                replace(item, reduction=item.reduction * factor) if item.reduced == place else item
                for item in drive.limits
            )
            witnesses = tuple(
                replace(item, factor=item.factor * (1.0 / factor if item.speed else factor))
                if item.reduced == place and item.factor is not None
                else item
                for item in drive.witnesses
            )
            after = tuple(relations(replace(drive, limits=limits, witnesses=witnesses)))
            yield Repair(after, (place,), help, rare)
    for root, train in {train.root: train for train in drive.trains.values()}.items():
        turns = _plain_turns(train.stages)
        if root[-1] == "transmission" and turns and _is_gear_again(gear, turns):
            *others, last = train.stages
            ratio = None if last.ratio is None else multiplied(last.ratio, 1.0 / turns)
            stages = (*others, last.model_copy(update={"ratio": ratio}))
            after = tuple(relations(_with_stages(drive, root, stages)))
            yield Repair(after, (root,), COUNTED_TWICE["transmission"], COPIED)


def gear_forgotten(drive: Drive, moved: Callable[[Sequence[Path], float, str], Repair]) -> Iterator[Repair]:
    """A gear where the motor has none, if effort and speed of the robot's file both ask for one."""
    if number(drive.motor.gear_ratio) != 1.0 or drive.trains:
        # Behind a direct drive it is the transmission's.
        return
    asked = [
        (relation.code, relation.value)
        for relation in relations(drive)
        if relation.witnessed and relation.broken and relation.path[0] == "motors"
    ]
    weak = [1.0 / value for code, value in asked if code == "SPEC187" and value < 1.0]
    if weak and any(code == "SPEC184" and value > 1.0 for code, value in asked):
        gear = min(weak)
        help = "is a gear forgotten? gear_ratio is rotor turns in one output turn"
        yield replace(moved([("gear_ratio",)], gear, help), fitted=True)


def multiplier_doubts(
    drive: Drive, model: SpecModel, joints: Sequence[JointActuator], spans: SourceMap
) -> Iterator[Doubt]:
    """A gear that is stated in the motor and again as a reduction, and the motors of the whole robot at one joint.

    A robot's file that has about such a torque says that it is right.

    Args:
        drive: The motor, with the limits that the robot's file states.
        model: The spec.
        joints: The resolved spec; none: whatever the robot is.
        spans: Where the spec says what it says.
    """
    if any(item.witnessed and is_said(item) for item in relations(drive)):
        return
    gear = gear_of(drive.motor)
    for path, fields, group in layers(model):
        if (fields.motor or group.motor) != drive.name:
            continue
        size, key = number(fields.reduction), "reduction"
        if size is None and fields.transmission:
            size, key = _plain_turns(fields.transmission), "transmission"
        if gear is not None and size is not None and _is_gear_again(gear, size):
            field = "gearbox" if drive.motor.gearbox else "gear_ratio"
            own: Path = ("motors", drive.name, field)
            stated, again, turned = (format_quantity(one, "", 4) for one in (gear, size, gear * size))
            message = (
                f"{again} turns of the motor's output in one of the joint, and the motor's own {field} is "
                f"{stated} ({spans.value(own)}): {turned} turns of the rotor"
            )
            yield at(spans, "SPEC182", message, (*path, key), COUNTED_TWICE[key], own)
        count = fields.motors_per_joint or 1
        mine = [joint for joint in joints if joint.group == path[1] and joint.motor == drive.name]
        every = [joint for joint in joints if joint.motor is not None]
        if count > MOST_MOTORS or (count >= SEVERAL_MOTORS and count in (len(mine), len(every))):
            message = f"{count} motors '{drive.name}' drive one joint"
            if mine:
                message += f", and {count * len(mine)} the {len(mine)} joints of {path[1]}"
            yield at(spans, "SPEC182", message, (*path, "motors_per_joint"), _one_motor(gear, count))


def _is_gear_again(gear: float | None, reduction: float | None) -> bool:
    """Whether a reduction is the motor's own gear."""
    if gear is None or reduction is None:
        return False
    return reduction >= TWICE and math.isclose(gear, reduction, rel_tol=SAME_GEAR)


def _plain_turns(stages: Sequence[Stage]) -> float | None:
    """Turns of the motor's output in one of the joint, where each stage is stated as a ratio."""
    return turns_of(stages) if all(stage.ratio for stage in stages) else None


def _one_motor(gear: float | None, motors: int) -> str:
    """What is meant by so many motors of one joint."""
    same = gear is not None and math.isclose(gear, motors, rel_tol=0.05)
    help = "is it the gear ratio" if same else "did you mean 1"
    return f"{help}? {MULTIPLIERS['motors_per_joint']}"
