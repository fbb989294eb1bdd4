from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.joints import SLOW, acceleration, joint_pairs, own_figure, shared_joints, shown, unit
from actspec.audit.rules.sym101 import doubted_limits
from actspec.readings.ledger import LedgerRow


class MilliOrGram(RuleInParts):
    code = "UNT105"
    name = "milli-or-gram-taken-for-one"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    noted_in_folders = True
    paired = True
    needs = "no file states friction, damping or armature to compare"
    options: ClassVar[dict[str, float]] = {"least": SLOW}

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        comparable = (
            sum(bool(figure) for figure in figures) > 1
            for rows in shared_joints(case)
            for figures in zip(*map(_figures, rows), strict=True)
        )
        if any(comparable):
            yield self._between_files(case)
        for row in case.rows:
            found = _acceleration(row)
            if found is not None:
                yield self._beside_effort(case, row, found) if found < self.option(case, "least") else ()

    def _between_files(self, case: Case) -> Iterator[Finding]:
        for pair in joint_pairs(case, _figures, lambda *rows: next(_off(*rows), None) is not None):
            for field, factor, large, small in _off(*pair):
                most = getattr(large, field)
                yield Finding(
                    self.code,
                    f"the {field.replace('_', ' ')} of {shown(large, field, most)} is {factor:g} times the "
                    f"{shown(large, field, getattr(small, field))} in {small.place(field).path}: a figure in "
                    f"{_THOUSANDS[field][factor]}",
                    large.place(field),
                    large.joint,
                    most,
                    unit(large, field),
                    getattr(small, field),
                    f"write it in {unit(large, field)}",
                    (small.place(field),),
                    fields=(field,),
                )

    def _beside_effort(self, case: Case, row: LedgerRow, found: float) -> Iterator[Finding]:
        yield Finding(
            self.code,
            f"an armature of {shown(row, 'armature', row.armature)} leaves the joint's whole torque of "
            f"{own_figure(row, 'effort_limit')} an acceleration of {found:.2g} rad/s^2: it looks "
            "like another unit",
            row.place("armature"),
            row.joint,
            row.armature,
            unit(row, "armature"),
            help="1 g*cm^2 is 1e-07 kg*m^2, 1 kg*cm^2 is 0.0001 kg*m^2; at the joint, times gear squared",
            fields=("armature",),
            # It is the limit that is wrong then, which SYM101 tells.
            severity=Severity.INFO if (row.artifact, row.joint) in case.once(doubted_limits) else None,
        )


def _acceleration(row: LedgerRow) -> float | None:
    return acceleration(row, row.effort_limit, row.armature if "armature" in row.stated else None)


def outweighs(row: LedgerRow) -> bool:
    """Whether the armature that a row states leaves a hinge's whole torque less than `SLOW`."""
    found = _acceleration(row)
    return found is not None and found < SLOW


_THOUSANDS: dict[str, dict[float, str]] = {
    "frictionloss": {1e3: "mN*m"},
    "joint_damping": {1e3: "mN*m*s/rad"},
    "armature": {1e3: "g*m^2", 1e4: "kg*cm^2", 1e7: "g*cm^2"},
}
"""Field to the factors that a unit can be off by, and the unit."""


def _figures(row: LedgerRow) -> tuple[float | None, ...]:
    """What is compared of a row."""
    return tuple(getattr(row, field) if field in row.stated else None for field in _THOUSANDS)


def _off(one: LedgerRow, other: LedgerRow) -> Iterator[tuple[str, float, LedgerRow, LedgerRow]]:
    """Fields in which two rows differ by such a factor, with it and the rows, the larger figure first."""
    for field, units in _THOUSANDS.items():
        mine: float | None = getattr(one, field)
        its: float | None = getattr(other, field)
        if not mine or not its or field not in one.stated or field not in other.stated:
            continue
        large, small = (other, one) if abs(its) > abs(mine) else (one, other)
        most, least = (its, mine) if large is other else (mine, its)
        factor = next((each for each in units if math.isclose(most / least, each, rel_tol=0.005)), None)
        if factor is not None and not _is_one_digit(most):
            yield field, factor, large, small


def _is_one_digit(value: float) -> bool:
    """Whether a figure has one significant digit."""
    return float(f"{value:.0e}") == float(f"{value:.6e}")
