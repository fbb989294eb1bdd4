"""Corrections of all torques of a motor at once, which stand in one column of a sheet and in one unit."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from actspec.diagnostics import Path, listed
from actspec.spec.models import Motor
from actspec.spec.plausible.relations import ALIKE, KGF_CM, RARE, Repair
from actspec.spec.plausible.slips import in_si, in_unit, kgf_cm, milli, multiplied, small_units, thousandth
from actspec.spec.values import SpecValue

EXACT = 1.003
"""A torque in kgf*cm, 1.02 times one with a wrong point, is told from that if it agrees with a limit by this factor."""


def is_exact(repair: Repair) -> bool:
    """Whether a torque, corrected, is just what a limit or its current says."""
    return any(
        item.code in ("SPEC181", "SPEC187")
        and not {item.path, *item.others}.isdisjoint(repair.paths)
        and 1.0 / EXACT < item.value < EXACT
        for item in repair.after
    )


def together(
    torques: Sequence[SpecValue], paths: Sequence[Path], motor: Motor, moved: Callable[..., Repair]
) -> Iterator[Repair]:
    """All torques in another unit, or ten times too large.

    Args:
        torques: The torques.
        paths: Where they stand in the motor.
        motor: The motor.
        moved: The correction of figures by a factor.
    """
    if len(torques) < 2:
        return
    first, names = torques[0], listed([str(path[-1]) for path in paths], 5)
    yield moved(paths, 1e-3, f"are {names} in {thousandth(first.unit)}? {milli(first)}")
    if not all(torque.unit == "N*m" and in_si(torque) is None for torque in torques):
        # Whoever writes mN*m read no kgf*cm.
        return
    for factor, help in small_units(first, names):
        small = moved(paths, factor, help, RARE)
        if _is_files(small):
            yield small
        elif is_exact(small):
            # By the current, whose constant is one number.
            yield replace(small, rare=RARE + ALIKE)
    # A torque constant is in N*m/A on every sheet.
    rare = RARE if motor.torque_constant is None else RARE - 0.05
    meant = in_unit(multiplied(first, 0.1))
    help = f"are {names} 10 times too large? A tenth of {in_unit(first)} is {meant}"
    tenth = moved(paths, 0.1, help, rare)
    if _is_files(tenth):
        # Of the two, 2 % apart, the file tells which.
        yield tenth
    elif is_exact(tenth):
        # So does the current, of which the point may be wrong as well: one number is likelier than several.
        yield replace(tenth, rare=RARE + ALIKE)
    else:
        yield moved(paths, KGF_CM, kgf_cm(first).replace("is it", f"are {names}"), rare)


def _is_files(repair: Repair) -> bool:
    """Whether a torque, corrected, is just what the robot's file says."""
    return any(item.witnessed and 1.0 / EXACT < item.value < EXACT for item in repair.after)
