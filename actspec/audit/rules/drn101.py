from __future__ import annotations

import math
from collections.abc import Iterator

from actspec.audit.drawn import rows_in
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.randomized import (
    FIELDS,
    about_range,
    ends,
    nominal,
    range_unit,
    ranges,
    whose,
    written,
)
from actspec.readings.artifact import RandomizedRange, RobotConfig
from actspec.readings.ledger import LedgerRow
from actspec.units import format_quantity

_AROUND_ZERO = ("encoder_bias", "joint_default_pos")
"""Fields whose nominal value is 0."""

_PASSIVE = ("friction", "joint_damping", "armature")
"""Fields that are often 0 in a model, and supplied by an add range alone."""


_Subject = tuple[int, RobotConfig, RandomizedRange]


class RangeExcludesNominal(RuleOver[_Subject]):
    code = "DRN101"
    name = "range-excludes-nominal"
    noted_in_folders = True
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    written_over = frozenset({"draws"})
    needs = "no configuration randomises actuators"

    def subjects(self, case: Case) -> Iterator[_Subject]:
        yield from ranges(case)

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Hold each range against what it surrounds."""
        index, config, one = subject
        low, high = ends(one)
        if one.operation in ("scale", "add"):
            neutral = 1.0 if one.operation == "scale" else 0.0
            supplied = one.operation == "add" and one.field in _PASSIVE and low > 0.0
            if not low <= neutral <= high and not supplied:
                yield Finding(
                    self.code,
                    f"{one.field} is randomised by {one.operation} {written(low, high)}, which leaves out "
                    f"{neutral:g}: no environment has the nominal value",
                    one.span,
                    about=about_range(one),
                )
        elif one.operation == "abs" and one.field in _AROUND_ZERO and not low <= 0.0 <= high:
            yield Finding(
                self.code,
                f"{one.field} is randomised from {written(low, high)}, which leaves out 0: no environment has the "
                "nominal value",
                one.span,
                about=about_range(one),
            )
        elif one.operation == "abs":
            yield from self._absolute(case, index, config, one)

    def _absolute(
        self, case: Case, index: int, config: RobotConfig, one: RandomizedRange
    ) -> Iterator[Finding]:
        low, high = ends(one)
        for row in rows_in(case, index, one):
            value = nominal(case, config, row, one)
            if value is None or not math.isfinite(value) or low <= value <= high:
                continue
            unit = range_unit(config, row, one)
            yield Finding(
                self.code,
                f"{one.field} is randomised from {written(low, high, unit)}, which leaves out "
                f"{whose(row, one)} {format_quantity(value, unit, 3)}: no environment has the nominal value",
                one.span,
                row.joint,
                value,
                unit,
                related=(row.span,),
                # A 0 that a model does not state is nobody's.
                severity=Severity.INFO
                if value == 0.0 and one.field in _PASSIVE and not _is_stated(row, one)
                else None,
            )


def _is_stated(row: LedgerRow, one: RandomizedRange) -> bool:
    field = FIELDS.get(one.field)
    return field is None or field in row.stated
