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
from actspec.spec.plausible.relations import Repair, explained, explanation
from actspec.spec.plausible.repairs import repairs_of
from actspec.spec.plausible.slips import multiplied, tens
from actspec.spec.plausible.table import Doubt
from actspec.units import format_quantity

HARDLY_A_GEAR = 0.3
"""What a ratio below `GEARED` costs beside another, as `RARE`: behind 14 turns a small servo is faster than most."""


def rubbed_doubts(drive: Drive, spans: SourceMap) -> Iterator[Doubt]:
    """What several frictions of a motor's joints contradict together, and which alone explains them.

    One of them alone may be wrong itself: it is told of the joints.

    Args:
        drive: The motor, with the friction of its joints.
        spans: Where the figures are written.
    """
    before = list(relations(drive))
    spoiled = [relation for relation in before if relation.spoiled]
    if len({relation.path for relation in spoiled}) < 2:
        return
    # Where it is the gear, the nearest one is meant.
    freed = gears_freed(drive)[:1] or explained(before, _freed(drive))
    freed = [repair for repair in freed if drive.sure.isdisjoint(repair.paths)]
    if not freed:
        return
    worst = max(spoiled, key=lambda item: item.value if item.code == "FRC101" else 0.0)
    (rub,) = (rub.value for rub in drive.rubs if rub.path == worst.path)
    there = format_quantity((rub.value or 0.0) / worst.value, rub.unit, 4)
    frictions = listed([f"{item.path[-1]} ({spans.value(item.path)})" for item in spoiled], 4)
    value = figure_at(drive.motor, ("gear_ratio",))
    code, behind = "FRC101", ""
    if value is not None and freed[0].paths == (_gear(drive),):
        code, behind = "SPEC182", f"behind {value.written} turns "
    kinds = listed(
        ["dry" if code == "FRC101" else "viscous" for code in sorted({item.code for item in spoiled})], 2
    )
    message = f"{behind}the joint's limit is {there}, and {kinds.replace(', ', ' and ')} friction take too much of it: "
    doubt = explanation(freed, spoiled, spans)
    help = doubt.help or ""
    if code == "FRC101":
        help += f"{'' if help.endswith('?') else '.'} Or are the frictions in another unit?"
    yield replace(
        doubt,
        code=code,
        message=message + frictions,
        help=help,
        error=worst.value >= FRICTION_STOPS,
        judged=tuple(spans.value(item.path) for item in spoiled),
        blamed=tuple(spans.value(item.path) for item in spoiled),
    )


def _gear(drive: Drive) -> Path:
    """Where the gear ratio of a motor is written."""
    return ("motors", drive.name, "gear_ratio")


def _freed(drive: Drive) -> list[Repair]:
    """Corrections that leave the motor's torque to it beside its joints' friction."""
    return [
        repair
        for repair in repairs_of(drive)
        if not any(relation.broken or relation.spoiled for relation in repair.after)
    ]


def gears_freed(drive: Drive) -> list[Repair]:
    """Corrections of the gear ratio, nearest first, that leave the motor's torque to it beside its joints' friction.

    None where another number of the motor explains that, too.
    """
    freed = _freed(drive)
    return freed if all(repair.paths == (_gear(drive),) for repair in freed) else []


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
