from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import by_joint, own_figure, shown, unit
from actspec.fields import PLACEHOLDER
from actspec.ir import JointKind
from actspec.readings.ledger import LedgerRow

_Subject = tuple[float, list[LedgerRow]]


class OneForAll(RuleOver[_Subject]):
    code = "GEA103"
    name = "one-armature-for-unequal-motors"
    severity = Severity.INFO
    confidence = Confidence.MEDIUM
    needs = "no file states armature and effort limit of a hinge"
    options: ClassVar[dict[str, float]] = {"ratio": 5.0}

    def subjects(self, case: Case) -> Iterator[_Subject]:
        """Group joints by armature and compare their limits."""
        groups: dict[tuple[int, float], list[LedgerRow]] = {}
        for (index, _), rows in by_joint(case).items():
            row = rows[0]
            if row.kind is JointKind.SLIDE or "armature" not in row.stated:
                continue
            limit = row.effort_limit
            if (
                row.armature
                and limit is not None
                and 0.0 < limit < PLACEHOLDER
                and "effort_limit" in row.stated
            ):
                groups.setdefault((index, row.armature), []).append(row)
        for (_, armature), joints in groups.items():
            yield armature, joints

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        armature, joints = subject
        least, most = (choose(joints, key=_effort) for choose in (min, max))
        if _effort(most) >= self.option(case, "ratio") * _effort(least):
            yield Finding(
                self.code,
                f"{shown(most, 'armature', armature)} is the armature of {len(joints)} joints whose effort limits run "
                f"from {own_figure(least, 'effort_limit')} ({least.joint}) to "
                f"{own_figure(most, 'effort_limit')} ({most.joint}): rotor and gear of so different motors "
                "seldom come to one figure",
                most.place("armature"),
                "",
                armature,
                unit(most, "armature"),
                joints=tuple(row.joint for row in joints),
                help="state rotor inertia times gear squared for each motor, or where the figure comes from",
                related=(least.place("armature"),)
                if least.place("armature") != most.place("armature")
                else (),
            )


def _effort(row: LedgerRow) -> float:
    return row.effort_limit or 0.0
