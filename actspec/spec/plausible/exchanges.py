"""Two motors whose lines are exchanged: neither gives what its joints have, and each what those of the other have."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

from actspec.diagnostics import Path, alternatives
from actspec.spec.document import SourceMap
from actspec.spec.models import Motor, SpecModel
from actspec.spec.plausible.drive import Drive
from actspec.spec.plausible.driven import AGREES
from actspec.spec.plausible.groups import layers
from actspec.spec.plausible.motors import relations
from actspec.spec.plausible.relations import Relation
from actspec.spec.plausible.table import Doubt, at

MATCHES = 1.05
"""With the lines exchanged each limit is what its motor gives, by this factor: two of them are no accident."""
_LINES = ("gear_ratio", "peak_torque", "stall_torque", "continuous_torque")


@dataclass(frozen=True, slots=True)
class Exchange:
    """Two motors that are told together.

    Attributes:
        motors: Their names.
        doubt: What is told of them.
    """

    motors: frozenset[str]
    doubt: Doubt


def exchanges(drives: Sequence[Drive], model: SpecModel, spans: SourceMap) -> Iterator[Exchange]:
    """Pairs of motors with one line exchanged, or whose groups name each other's motor.

    Args:
        drives: The motors, with the limits of their joints that spec and robot's file state.
        model: The spec.
        spans: Where it says what it says.
    """
    thermal = _thermal(model)
    off = {
        drive.name: drive
        for drive in drives
        if (efforts := _efforts(drive, thermal)) and not any(_is_within(item, AGREES) for item in efforts)
    }
    for first, second in itertools.combinations(tuple(off), 2):
        if first not in off or second not in off:
            continue
        one, two = off[first], off[second]
        found = list(_exchanged(one, two, model, thermal))
        if not found:
            continue
        del off[first], off[second]
        told = [_efforts(drive, thermal)[0] for drive in (one, two)]
        help = alternatives(
            f"are {line} of '{ours[-2]}' and of '{theirs[-2]}' ({spans.value(theirs)}) exchanged?"
            for line, ours, theirs in found
        )
        where, *others = (path for _, *pair in found for path in pair)
        judged = (path for item in told for path in (item.path, *item.others))
        message = "; and ".join(item.message for item in told)
        error = any(item.error for item in told)
        doubt = at(spans, "SPEC187", message, where, help, *others, *judged, error=error)
        # What a limit of theirs is held against says nothing before the lines are right.
        held = [path for drive in (one, two) for path in (limit.path for limit in drive.limits)]
        wrong = tuple(spans.value(path) for path in (*others, *held))
        yield Exchange(frozenset((first, second)), replace(doubt, blamed=wrong))


def _exchanged(
    one: Drive, two: Drive, model: SpecModel, thermal: Collection[str]
) -> Iterator[tuple[str, Path, Path]]:
    """What may be exchanged: the field, and where the two stand."""
    for field in _LINES:
        ours, theirs = getattr(one.motor, field), getattr(two.motor, field)
        if ours is None or theirs is None or one.motor.side != two.motor.side:
            continue
        motors = (one.motor.model_copy(update={field: theirs}), two.motor.model_copy(update={field: ours}))
        if _fits(one, two, thermal, MATCHES, *motors):
            yield field, ("motors", one.name, field), ("motors", two.name, field)
    places = [
        [path for path, fields, _ in layers(model) if fields.motor == drive.name] for drive in (one, two)
    ]
    # That the one is far too weak, and the other too strong, is no accident if each is sound in the other's place.
    contradicted = all(any(item.broken for item in _efforts(drive, thermal)) for drive in (one, two))
    factor = math.inf if contradicted else MATCHES
    if all(len(paths) == 1 for paths in places) and _fits(one, two, thermal, factor, two.motor, one.motor):
        (mine,), (other,) = places
        yield "motor", (*mine, "motor"), (*other, "motor")


def _fits(one: Drive, two: Drive, thermal: Collection[str], factor: float, *motors: Motor) -> bool:
    """Whether with these motors all is sound, and every limit what its motor gives, by this factor."""
    for drive, motor in zip((one, two), motors, strict=True):
        changed = replace(drive, motor=motor)
        efforts = _efforts(changed, thermal)
        if not efforts or not all(_is_within(item, factor) for item in efforts):
            return False
        if any(item.broken for item in relations(changed)):
            return False
    return True


def _thermal(model: SpecModel) -> frozenset[str]:
    """Motors whose joints are all limited to the continuous torque."""
    limits: dict[str | None, set[object]] = {}
    for _, fields, group in layers(model):
        limit = group.effort_limit if fields.effort_limit is None else fields.effort_limit
        limits.setdefault(fields.motor or group.motor, set()).add(limit if isinstance(limit, str) else None)
    return frozenset(name for name, taken in limits.items() if name is not None and taken == {"continuous"})


def _efforts(drive: Drive, thermal: Collection[str]) -> list[Relation]:
    """What its torque makes of every limit of its joints; beside a peak the stall torque says nothing of that.

    Of a motor whose joints take the continuous torque it is that one.
    """
    if drive.name in thermal and drive.motor.continuous_torque is not None:
        motor = drive.motor.model_copy(update={"peak_torque": drive.motor.continuous_torque})
        own = _efforts(replace(drive, motor=motor), ())
        field = ("motors", drive.name, "continuous_torque")
        return [
            replace(item, path=field, message=item.message.replace("peak_torque", "continuous_torque"))
            for item in own
        ]
    known = drive.motor.peak_torque is not None
    return [
        item
        for item in relations(drive)
        if item.code == "SPEC187"
        and not (known and item.path[-1] == "stall_torque")
        and (item.about.startswith("above ") or (item.witnessed and item.path[0] == "motors"))
    ]


def _is_within(relation: Relation, factor: float) -> bool:
    return 1.0 / factor <= relation.value <= factor
