"""Contradictions of a motor's figures that no slip explains: the one number that contradicts all others, else each."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace

from actspec.diagnostics import Path, alternatives
from actspec.spec.document import SourceMap
from actspec.spec.models import Motor
from actspec.spec.plausible.drive import Drive, figure_at, number, with_figure
from actspec.spec.plausible.motors import relations
from actspec.spec.plausible.relations import RARE, Relation, Repair, explanation
from actspec.spec.plausible.slips import multiplied, slips_of
from actspec.spec.plausible.table import Doubt

FIGURES = (
    "stall_torque",
    "peak_torque",
    "continuous_torque",
    "no_load_speed",
    "gear_ratio",
    "efficiency",
    "torque_constant",
    "peak_current",
    "nominal_current",
    "nominal_voltage",
    "rotor_inertia",
    "reflected_inertia",
)
"""Figures of a motor that are one number."""
MOST_POWERS = 12
"""Powers of ten that the one number may be off which contradicts all others."""


def unexplained(drive: Drive, broken: Sequence[Relation], spans: SourceMap) -> Iterator[Doubt]:
    """What is told of relations that are broken and that no correction explains.

    Args:
        drive: The motor, with the limits of its joints.
        broken: The relations.
        spans: Where the figures are written.
    """
    odd = _odd(drive)
    if odd is not None:
        help = "all other figures agree with each other: look for a wrong unit or power of ten"
        help = alternatives(_in_other_units(drive, odd)) or help
        yield explanation([Repair((), (odd,), help)], broken, spans)
        return
    for relation in _first(broken, drive.sure):
        placed = _placed(relation, drive.motor, spans)
        yield explanation([Repair((), (relation.path,), placed)], [relation], spans)


def _in_other_units(drive: Drive, path: Path) -> Iterator[str]:
    """Readings of a no-load speed in another unit, with which all figures agree."""
    speed = figure_at(drive.motor, path[2:]) if path[-1] == "no_load_speed" else None
    for factor, help, rare in () if speed is None else slips_of(speed, speed=True):
        motor = with_figure(drive.motor, path[2:], multiplied(speed, factor))
        if rare < RARE and not any(relation.broken for relation in relations(replace(drive, motor=motor))):
            yield help


def _odd(drive: Drive) -> Path | None:
    """The one number with which, were it of another size, all figures would agree; None: there is none, or several."""
    if drive.trains or drive.motor.gearbox:
        # Any of their stages may be the one.
        return None
    found = [
        path
        for path, sizes in _other_sizes(drive)
        if path not in drive.sure
        and any(not any(relation.broken for relation in relations(other)) for other in sizes)
    ]
    return found[0] if len(found) == 1 else None


def _other_sizes(drive: Drive) -> Iterator[tuple[Path, Iterator[Drive]]]:
    """Each figure of the motor and limit of its joints, with the drives in which it has another size."""
    factors = [10.0 ** (power / 2.0) for power in range(-2 * MOST_POWERS, 2 * MOST_POWERS + 1)]
    for field in FIGURES:
        value = figure_at(drive.motor, (field,))
        if value is not None and number(value):
            motors = (with_figure(drive.motor, (field,), multiplied(value, factor)) for factor in factors)
            yield ("motors", drive.name, field), (replace(drive, motor=motor) for motor in motors)
    for index, limit in enumerate(drive.limits):
        before, after = drive.limits[:index], drive.limits[index + 1 :]
        if number(limit.value):
            limits = (replace(limit, value=multiplied(limit.value, factor)) for factor in factors)
            yield limit.path, (replace(drive, limits=(*before, other, *after)) for other in limits)


def _placed(relation: Relation, motor: Motor, spans: SourceMap) -> str | None:
    """The help of a relation, with where the figures stand that it names."""
    help = relation.help
    if help is None:
        return None
    for path in relation.others:
        name = str(path[-1])
        own = path[:-1] == ("motors", relation.path[1]) and name != relation.path[-1]
        if own and getattr(motor, name, None) is not None:
            help = help.replace(f"{name} or", f"{name} ({spans.value(path)}) or")
    return help


def _first(broken: Iterable[Relation], sure: Collection[Path]) -> Iterator[Relation]:
    """Of relations that see the same mistake the first: all but those of torques take gear, side and torque.

    What is beyond any motor, and a number that the author is sure of, hides only what follows from it.
    """
    seen: set[object] = set()
    alone: set[Path] = set()
    for relation in broken:
        key: object = relation.path
        if relation.code not in ("SPEC135", "SPEC180"):
            key = "constant" if relation.code == "SPEC181" else "output"
        if key in seen or not alone.isdisjoint((relation.path, *relation.others)):
            continue
        if relation.code == "SPEC183" or relation.path in sure:
            alone.add(relation.path)
        else:
            seen.add(key)
        yield relation
