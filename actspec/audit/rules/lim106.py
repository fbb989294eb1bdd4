from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import chain

from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.configs import (
    EXPLICIT,
    IMPLICIT,
    Group,
    groups_of,
    major_version,
)
from actspec.audit.rules.joints import shown, unit
from actspec.readings.artifact import Framework, Setting
from actspec.units import format_number


class TwoLimits(RuleInParts):
    code = "LIM106"
    name = "model-and-solver-limit-disagree"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    needs = "no Isaac Lab cfg with a stock actuator class among the files"

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        """Compare the two limits of each group."""
        for group in groups_of(case, Framework.ISAACLAB, IMPLICIT):
            # In 3.0 both names are aliases of one field.
            quantities = ("effort", "velocity") if major_version(case.versions.isaaclab) < 3 else ()
            yield chain.from_iterable(
                self._implicit(group, f"{quantity}_limit", f"{quantity}_limit_sim") for quantity in quantities
            )
        for group in groups_of(case, Framework.ISAACLAB, EXPLICIT):
            yield self._explicit(group, "effort_limit", "effort_limit_sim")
            yield self._explicit(group, "actuator_effort_limit", "joint_effort_limit")

    def _implicit(self, group: Group, first: str, second: str) -> Iterator[Finding]:
        one, two = group.written(first), group.written(second)
        if one is None or two is None or one.unknown is not None or two.unknown is not None:
            return
        if one.value == two.value:
            return
        for joint in group.joints:
            yield Finding(
                self.code,
                f"{first} ({_text(one)}) and {second} ({_text(two)}) are both set and differ: Isaac Lab 2.x raises "
                "ValueError when it builds this implicit group",
                two.span,
                joint,
                help=f"leave {first} out: the solver's limit is the one that an implicit drive has",
                related=(one.span,),
                severity=Severity.ERROR,
                about=f"{first} {_text(one)} {second} {_text(two)}",
            )

    def _explicit(self, group: Group, own: str, solver: str) -> Iterator[Finding]:
        one, two = group.written(own), group.written(solver)
        if one is None or two is None:
            return
        for row in group.rows:
            limit, clamp = group.number(one, row.joint), group.number(two, row.joint)
            if limit is None or clamp is None or clamp >= limit:
                continue
            least = shown(row, "effort_limit", clamp)
            yield Finding(
                self.code,
                f"the model clips at {shown(row, 'effort_limit', limit)} and the solver again at {least}: the joint "
                f"never gets more than {least}, and the model reports what it does not get",
                two.span,
                row.joint,
                clamp,
                unit(row, "effort_limit"),
                limit,
                f"set {solver} to {own} or more",
                (one.span,),
            )


def _text(setting: Setting) -> str:
    value = setting.value
    if isinstance(value, Mapping):
        numbers = sorted(
            {format_number(number) for number in value.values() if isinstance(number, int | float)}, key=float
        )
        return f"by pattern: {', '.join(numbers)}"
    return format_number(value) if isinstance(value, int | float) else str(value)
