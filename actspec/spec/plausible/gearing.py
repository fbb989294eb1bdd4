"""Corrections of what stands between a motor and its joints: stages, numbers of motors, reductions."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace

from actspec.diagnostics import Path
from actspec.spec.plausible.drive import Drive, gear_of, number, stage_path
from actspec.spec.plausible.motors import relations
from actspec.spec.plausible.relations import RARE, Repair
from actspec.spec.plausible.slips import inertias, multiplied, stage_slips


def stages_repaired(drive: Drive) -> Iterator[Repair]:
    """Corrections of the stages of the gearbox, and of the transmissions to the joints."""
    gearbox = drive.motor.gearbox or ()
    for index, stage in enumerate(gearbox):
        for other, help, rare in stage_slips(stage):
            stages = (*gearbox[:index], other, *gearbox[index + 1 :])
            motor = drive.motor.model_copy(update={"gearbox": stages})
            place = stage_path(stage, ("motors", drive.name, "gearbox", index))
            yield Repair(tuple(relations(replace(drive, motor=motor))), (place,), help, rare)
        if number(stage.inertia) and stage.inertia is not None:
            for factor, help, rare in inertias(stage.inertia):
                other = stage.model_copy(update={"inertia": multiplied(stage.inertia, factor)})
                stages = (*gearbox[:index], other, *gearbox[index + 1 :])
                motor = drive.motor.model_copy(update={"gearbox": stages})
                place = ("motors", drive.name, "gearbox", index, "inertia")
                yield Repair(tuple(relations(replace(drive, motor=motor))), (place,), help, rare)
    for train in {train.root: train for train in drive.trains.values()}.values():
        for index, stage in enumerate(train.stages):
            for other, help, rare in stage_slips(stage):
                stages = (*train.stages[:index], other, *train.stages[index + 1 :])
                trains = {
                    key: replace(same, stages=stages) if same.root == train.root else same
                    for key, same in drive.trains.items()
                }
                after = tuple(relations(replace(drive, trains=trains)))
                yield Repair(after, (train.place(index),), help, rare)
        for first, second in itertools.combinations(range(len(train.stages)), 2):
            one, two = train.stages[first], train.stages[second]
            if one.radius is None or two.radius is None:
                continue
            stages = tuple(
                stage.model_copy(update={"radius": {first: two, second: one}.get(index, stage).radius})
                for index, stage in enumerate(train.stages)
            )
            trains = {
                key: replace(same, stages=stages) if same.root == train.root else same
                for key, same in drive.trains.items()
            }
            places = (train.place(first), train.place(second))
            help = f"are the two radii, {one.radius.written} and {two.radius.written}, exchanged?"
            yield Repair(tuple(relations(replace(drive, trains=trains))), places, help)


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
        same = gear is not None and math.isclose(gear, motors, rel_tol=0.05)
        help = "is it the gear ratio" if same else "did you mean 1"
        help += "? motors_per_joint is how many motors drive one joint together"
        yield Repair(tuple(relations(changed)), (place,), help)


def reductions_repaired(drive: Drive) -> Iterator[Repair]:
    """A reduction from the motor to the joint whose point is in the wrong place."""
    reductions = {item.reduced: item.reduction for item in drive.limits if item.reduced is not None}
    reductions |= {item.reduced: item.reduction for item in drive.witnesses if item.reduced is not None}
    for place, size in reductions.items():
        for power in (-2, -1, 1, 2):
            factor = 10.0**power
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
            help = f"did you mean {size * factor:.4g}? reduction is turns of the motor's output in one of the joint"
            yield Repair(after, (place,), help, RARE)
