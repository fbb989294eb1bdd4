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
from actspec.readings.isaaclab import has_curve
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
        for group in groups_of(case, Framework.ISAACLAB):
            if has_curve(group.cfg):
                yield self._curve(group)

    def _implicit(self, group: Group, first: str, second: str) -> Iterator[Finding]:
        one, two = group.written(first), group.written(second)
        if one is None or two is None or one.unknown is not None or two.unknown is not None:
            return
        if one.value == two.value:
            return
        units = {row.joint: unit(row, first) for row in group.rows}
        for joint in group.joints:
            yield Finding(
                self.code,
                f"{first} ({_text(one)}) and {second} ({_text(two)}) are both set and differ: Isaac Lab 2.x raises "
                "ValueError when it builds this implicit group",
                two.span,
                joint,
                group.number(two, joint),
                units.get(joint),
                group.number(one, joint),
                help=f"leave {first} out: the solver's limit is the one that an implicit drive has",
                related=(one.span,),
                severity=Severity.ERROR,
                fields=(first,),
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

    def _curve(self, group: Group) -> Iterator[Finding]:
        """Of unitree_rl_lab's class, whose limits are Y1 and Y2: a note where the joint only brakes with less."""
        drive, solver = group.written("Y1"), group.written("effort_limit_sim", "joint_effort_limit")
        brake = group.written("Y2", "Y1")
        if drive is None or brake is None or solver is None:
            return
        for row in group.rows:
            limits = [group.number(one, row.joint) for one in (drive, brake)]
            clamp = group.number(solver, row.joint)
            known = [limit for limit in limits if limit is not None]
            if clamp is None or len(known) < 2 or clamp >= max(known):
                continue
            least, *ends = (shown(row, "effort_limit", one) for one in (clamp, *known))
            brakes = clamp >= known[0]
            yield Finding(
                self.code,
                f"the model drives with {ends[0]} and brakes with {ends[1]} (Y1, Y2), and the solver clips at {least}: "
                f"the joint never {'brakes with' if brakes else 'gets'} more than {least}, and the model reports what "
                "it does not get",
                solver.span,
                row.joint,
                clamp,
                unit(row, "effort_limit"),
                max(known),
                f"set the solver's limit to {shown(row, 'effort_limit', max(known))} or more",
                (drive.span, brake.span),
                severity=Severity.INFO if brakes else None,
            )


def _text(setting: Setting) -> str:
    value = setting.value
    if isinstance(value, Mapping):
        numbers = sorted(
            {format_number(number) for number in value.values() if isinstance(number, int | float)}, key=float
        )
        return f"by pattern: {', '.join(numbers)}"
    return format_number(value) if isinstance(value, int | float) else str(value)
