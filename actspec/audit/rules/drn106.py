from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.drawn import rows_in
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.randomized import about_range, ends, nominal, range_unit, ranges, written
from actspec.readings.artifact import Framework, RandomizedRange, RobotConfig
from actspec.units import format_number, format_quantity

_POSITIVE = ("kp", "kd", "armature", "friction", "joint_damping", "effort_limit", "strength")
"""Fields that are never negative."""


_Subject = tuple[int, RobotConfig, RandomizedRange]


class RangeInvertedOrNegative(RuleOver[_Subject]):
    code = "DRN106"
    name = "range-inverted-or-negative"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    noted_in_folders = True
    written_over = frozenset({"draws"})
    needs = "no configuration randomises actuators"

    def subjects(self, case: Case) -> Iterator[_Subject]:
        yield from ranges(case)

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Look at the ends."""
        index, config, one = subject
        if one.distribution == "gaussian":
            if one.high < 0.0:
                yield Finding(
                    self.code,
                    f"{one.field} has a deviation of {format_number(one.high)}: for `gaussian` the range is mean and "
                    "deviation",
                    one.span,
                    about=about_range(one),
                )
            return
        if one.low > one.high:
            yield Finding(
                self.code,
                f"{one.field} is randomised from {written(one.low, one.high)}: the lower end is above the upper one",
                one.span,
                help=f"({format_number(one.high)}, {format_number(one.low)})",
                severity=Severity.WARNING,
                about=about_range(one),
            )
        low, high = ends(one)
        if one.distribution == "log_uniform" and low <= 0.0:
            yield Finding(
                self.code,
                f"{one.field} is drawn log-uniformly from {written(low, high)}: the logarithm of "
                f"{format_number(low)} is not a number",
                one.span,
                about=about_range(one),
            )
        elif one.field in _POSITIVE and not _clamped(config, one):
            yield from self._negative(case, index, config, one)

    def _negative(
        self, case: Case, index: int, config: RobotConfig, one: RandomizedRange
    ) -> Iterator[Finding]:
        low, high = ends(one)
        if one.operation in ("scale", "abs"):
            if low < 0.0:
                yield Finding(
                    self.code,
                    f"{one.field} is randomised by {one.operation} {written(low, high)}, and is negative at its low "
                    "end",
                    one.span,
                    about=about_range(one),
                )
            return
        for row in rows_in(case, index, one):
            value = nominal(case, config, row, one)
            if value is not None and value + low < 0.0 <= value:
                unit = range_unit(config, row, one)
                yield Finding(
                    self.code,
                    f"{one.field} is {format_quantity(value, unit, 3)} and is randomised by add {written(low, high)}: "
                    f"it is negative down to {format_quantity(value + low, unit, 3)}",
                    one.span,
                    row.joint,
                    value + low,
                    unit,
                    help="randomise by scale",
                    related=(row.span,),
                )


def _clamped(config: RobotConfig, one: RandomizedRange) -> bool:
    return one.field == "friction" and config.framework is Framework.ISAACLAB
