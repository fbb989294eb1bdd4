from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.joints import SPEEDS, joint_pairs, shown, unit
from actspec.diagnostics import Span
from actspec.fields import PLACEHOLDER, PLACEHOLDER_SPEEDS, is_power_of_ten
from actspec.ir import JointKind
from actspec.readings.compare import RPM
from actspec.readings.ledger import LedgerRow
from actspec.units import format_number

_MM = 1e3


class SpeedInRpm(RuleInParts):
    code = "UNT104"
    name = "speed-in-rpm"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    noted_in_folders = True
    paired = True
    needs = "no file states the speed of a hinge"
    options: ClassVar[dict[str, float]] = {"relative": 0.005, "least": 150.0}

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        """Compare speeds with other files', and with what joints do."""
        reported: set[tuple[Span, str]] = set()
        relative = self.option(case, "relative")

        def in_rpm(one: LedgerRow, other: LedgerRow) -> list[tuple[LedgerRow, str, float, float, Span]]:
            slides = JointKind.SLIDE in (one.kind, other.kind)
            if slides and one.kind is not other.kind:
                return []
            return [
                (mine, *ratio)
                for mine, its in ((one, other), (other, one))
                for ratio in _speed_ratios(mine, its)
                if math.isclose(ratio[1] / ratio[2], _MM if slides else RPM, rel_tol=relative)
                # 1000 m/s for 1 is a placeholder.
                and not (slides and is_power_of_ten(ratio[1]))
            ]

        for one, other in joint_pairs(case, _speed_figures, lambda one, other: bool(in_rpm(one, other))):
            for mine, field, limit, right, place in in_rpm(one, other):
                reported.add((mine.place(field), mine.joint))
                slides = mine.kind is JointKind.SLIDE
                factor, name = ("1000", "mm/s") if slides else ("9.55", "rpm")
                si = format_number(limit / (_MM if slides else RPM), 3)
                found = Finding(
                    self.code,
                    f"{shown(mine, field, limit, 4)} is {factor} times the {shown(mine, field, right, 4)} in "
                    f"{place.path}: a figure in {name}",
                    mine.place(field),
                    mine.joint,
                    limit,
                    unit(mine, field),
                    right,
                    f"{format_number(limit, 4)} {name} is {si} {unit(mine, field)}",
                    (place,),
                    fields=(field,),
                )
                yield (found,)
        for row in case.rows:
            for field in SPEEDS:
                speed: float | None = getattr(row, field)
                if speed is None or field not in row.stated or row.kind is JointKind.SLIDE:
                    continue
                known = (row.place(field), row.joint) in reported or speed % 10.0 != 0.0
                # LIM101 has them.
                nobodys = field == "velocity_limit" and speed in PLACEHOLDER_SPEEDS
                yield () if known or nobodys else self._alone(case, row, field, speed)

    def _alone(self, case: Case, row: LedgerRow, field: str, speed: float) -> Iterator[Finding]:
        if self.option(case, "least") <= speed < PLACEHOLDER:
            yield Finding(
                self.code,
                f"{shown(row, field, speed, 4)} is more than a joint behind a gear turns; "
                f"{format_number(speed, 4)} rpm would be {format_number(speed / RPM, 3)} rad/s",
                row.place(field),
                row.joint,
                speed,
                unit(row, field),
                help="speeds are in rad/s",
                severity=Severity.INFO,
                confidence=Confidence.LOW,
            )


def _speed_figures(row: LedgerRow) -> tuple[object, ...]:
    """What is compared of a row."""
    return row.kind, *(getattr(row, name) if name in row.stated else None for name in SPEEDS)


def _speed_ratios(one: LedgerRow, other: LedgerRow) -> Iterator[tuple[str, float, float, Span]]:
    """Speeds of one row, each with those of the other: field, the two values, and where the other stands."""
    for field in SPEEDS:
        mine: float | None = getattr(one, field)
        for name in SPEEDS:
            its: float | None = getattr(other, name)
            if mine and its and math.isfinite(mine) and field in one.stated and name in other.stated:
                yield field, mine, its, other.place(name)
