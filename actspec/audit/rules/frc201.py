from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.source_rule import shown
from actspec.audit.rules.spec_pairs import NO_SPEC, SpecJoint, spec_joints, unit_confused


class FrictionUnitOfSpec(RuleOver[SpecJoint]):
    code = "FRC201"
    name = "friction-unit-mismatch-against-spec"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    paired = True
    needs = NO_SPEC
    options: ClassVar[dict[str, float]] = {"tolerance": 0.01}

    def subjects(self, case: Case) -> Iterator[SpecJoint]:
        yield from spec_joints(case)

    def judge(self, case: Case, joint: SpecJoint) -> Iterator[Finding]:
        """Compare dry friction with the spec's."""
        found = unit_confused(case, joint, self.option(case, "tolerance"))
        wanted = joint.wanted("frictionloss")
        if found is None or wanted is None:
            return
        mine, text = found
        yield Finding(
            self.code,
            f"the dry friction {text}",
            mine.place,
            joint.rows[0].joint,
            mine.value,
            mine.unit or "1",
            expected=wanted.value if mine.unit else None,
            help=f"write {shown(wanted.value, wanted.unit)}"
            if mine.unit
            else f"leave it out and calibrate a coefficient for {shown(wanted.value, wanted.unit)}, or use Isaac "
            "Sim 5",
            related=(wanted.place,),
        )
