from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.drawn import rows_in
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.randomized import DEVIATIONS, about_range, ends, nominal, ranges, written
from actspec.ir import JointActuator, Quantity
from actspec.readings.artifact import RandomizedRange
from actspec.readings.ledger import LedgerRow
from actspec.units import format_quantity

_Subject = tuple[RandomizedRange, LedgerRow, Quantity, float | None]


class RangeWiderThanIdentified(RuleOver[_Subject]):
    code = "DRN103"
    name = "range-wider-than-identified"
    severity = Severity.INFO
    confidence = Confidence.MEDIUM
    paired = True
    needs = "no range of a figure for which a spec states a standard deviation"
    options: ClassVar[dict[str, float]] = {"ratio": 5.0}

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for index, config, one in ranges(case):
            for row in rows_in(case, index, one):
                measured = _identified(case, row, one)
                value = nominal(case, config, row, one)
                if measured is None or measured.value is None or not measured.std:
                    continue
                if value is None and one.operation != "abs":
                    continue
                yield one, row, measured, value

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Compare ranges with deviations."""
        one, row, measured, value = subject
        found = self._judge(case, row, one, value or 0.0, measured)
        if found is not None:
            yield found

    def _judge(
        self, case: Case, row: LedgerRow, one: RandomizedRange, value: float, measured: Quantity
    ) -> Finding | None:
        low, high = ends(one)
        if one.operation == "scale":
            low, high = sorted((low * value, high * value))
        elif one.operation == "add":
            low, high = low + value, high + value
        middle, std = measured.require(), measured.std or 0.0
        ratio = (high - low) / (2.0 * DEVIATIONS * std)
        unit = measured.unit
        if low <= middle <= high and ratio < self.option(case, "ratio"):
            return None
        text = (
            f"which is {ratio:.2g} times its three deviations to either side"
            if low <= middle <= high
            else "which leaves that out"
        )
        low_, high_ = (middle - DEVIATIONS * std, middle + DEVIATIONS * std)
        return Finding(
            self.code,
            f"{one.field} was measured as {format_quantity(middle, unit, 3)} with a deviation of "
            f"{format_quantity(std, unit, 2)}, and is randomised from {written(low, high, unit)}, {text}",
            one.span,
            row.joint,
            help=f"three deviations are {written(low_, high_, unit)}",
            related=() if measured.span is None else (measured.span,),
            about=about_range(one),
        )


def _identified(case: Case, row: LedgerRow, one: RandomizedRange) -> Quantity | None:
    """The spec's figure of the randomised field."""
    for index in case.robot_of(row.artifact).artifacts:
        spec = case.artifacts[index].spec
        for joint in spec.joints if spec is not None else ():
            if joint.joint == row.joint:
                return _figure(joint, one.field)
    return None


def _figure(joint: JointActuator, field: str) -> Quantity | None:
    figures = {
        "kp": joint.kp,
        "kd": joint.kd,
        "armature": joint.armature,
        "friction": joint.friction_coulomb,
        "joint_damping": joint.friction_viscous,
        "effort_limit": joint.effort_limit,
    }
    return figures.get(field)
