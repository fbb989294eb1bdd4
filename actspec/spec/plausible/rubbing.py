"""Gears that the friction of the joints contradicts."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace

from actspec.diagnostics import Path, listed
from actspec.spec.document import SourceMap
from actspec.spec.plausible.drive import GEARED, Drive, figure_at, number, with_figure
from actspec.spec.plausible.groups import FRICTION_STOPS
from actspec.spec.plausible.motors import relations
from actspec.spec.plausible.relations import Repair
from actspec.spec.plausible.repairs import repairs_of
from actspec.spec.plausible.slips import multiplied, tens
from actspec.spec.plausible.table import Doubt, at
from actspec.units import format_quantity

HARDLY_A_GEAR = 0.3
"""What a ratio below `GEARED` costs beside another, as `RARE`: behind 14 turns a small servo is faster than most."""


def rubbed_doubts(drive: Drive, spans: SourceMap) -> Iterator[Doubt]:
    """A gear that both dry and viscous friction of its joints contradict, and which alone explains both.

    One of the two alone may be wrong itself: it is told of the joints.

    Args:
        drive: The motor, with the friction of its joints.
        spans: Where the figures are written.
    """
    spoiled = [relation for relation in relations(drive) if relation.spoiled]
    if len({relation.code for relation in spoiled}) < 2:
        return
    freed = gears_freed(drive)
    if not freed or not drive.sure.isdisjoint(freed[0].paths):
        return
    value = figure_at(drive.motor, ("gear_ratio",))
    worst = max(spoiled, key=lambda item: item.value if item.code == "FRC101" else 0.0)
    dry = next(rub.value for rub in drive.rubs if rub.path == worst.path)
    there = format_quantity((dry.value or 0.0) / worst.value, dry.unit, 4)
    frictions = listed([f"{item.path[-1]} ({spans.value(item.path)})" for item in spoiled], 4)
    turns = "" if value is None else value.written
    message = f"behind {turns} turns the joint's limit is {there}, and dry and viscous friction take too much of it: "
    message += frictions
    doubt = at(
        spans,
        "SPEC182",
        message,
        freed[0].paths[0],
        freed[0].help,
        *(item.path for item in spoiled),
        error=worst.value >= FRICTION_STOPS,
    )
    yield replace(doubt, blamed=tuple(spans.value(item.path) for item in spoiled))


def gears_freed(drive: Drive) -> list[Repair]:
    """Corrections of the gear ratio, nearest first, that leave the motor's torque to it beside its joints' friction.

    None where another number of the motor explains that, too.
    """
    gear: Path = ("motors", drive.name, "gear_ratio")
    freed = [
        repair
        for repair in repairs_of(drive)
        if not any(relation.broken or relation.spoiled for relation in repair.after)
    ]
    return freed if all(repair.paths == (gear,) for repair in freed) else []


def next_gear(drive: Drive) -> Repair | None:
    """The gear ratio with its point one place further, if that leaves the motor's torque to it; None: it does not."""
    ratio, freed = drive.motor.gear_ratio, gears_freed(drive)
    if ratio is None or not freed:
        return None
    return freed[0] if freed[0].help in [help for _, help, _ in tens(ratio)][:2] else None


def likelier_gear(drive: Drive) -> Repair | None:
    """The gear ratio with its point one place further, if then no friction is too large and all figures more usual.

    Beside a gear that is hardly one others are about as usual.
    """
    ratio, path = drive.motor.gear_ratio, ("gear_ratio",)
    size = number(ratio)
    if ratio is None or not size or size == 1.0 or drive.motor.gearbox is not None:
        return None
    now = sum(relation.excess for relation in relations(drive))
    for factor, help, _ in itertools.islice(tens(ratio), 2):
        motor = with_figure(drive.motor, path, multiplied(ratio, factor))
        after = tuple(relations(replace(drive, motor=motor)))
        if any(relation.broken or relation.spoiled for relation in after):
            continue
        excess = sum(relation.excess for relation in after)
        if excess < now + (size < GEARED) * HARDLY_A_GEAR:
            return Repair(after, (("motors", drive.name, *path),), help)
    return None
