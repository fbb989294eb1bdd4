from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.source_rule import shown
from actspec.audit.rules.spec_pairs import NO_SPEC, SpecJoint, counted_twice, spec_joints
from actspec.readings.compare import times
from actspec.readings.dynamics import figure


class DampingCountedTwice(RuleOver[SpecJoint]):
    code = "DMP201"
    name = "damping-counted-twice-against-spec"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    paired = True
    needs = NO_SPEC
    options: ClassVar[dict[str, float]] = {"tolerance": 0.01}

    def subjects(self, case: Case) -> Iterator[SpecJoint]:
        yield from spec_joints(case)

    def judge(self, case: Case, joint: SpecJoint) -> Iterator[Finding]:
        """Compare total damping with the spec's."""
        extra = counted_twice(joint, self.option(case, "tolerance"))
        if extra is None or joint.spec.total_damping is None:
            return
        first, unit = joint.rows[0], figure(joint.rows, "kd").unit
        total = joint.spec.total_damping + extra
        passive = total - (figure(joint.rows, "kd").value or 0.0)
        yield Finding(
            self.code,
            f"damping is counted twice: the drive's kd is {shown(figure(joint.rows, 'kd').value, unit)} and the "
            f"joint's own damping {shown(passive, unit)}, together {shown(total, unit)}, and the spec says kd "
            f"{shown(joint.spec.kd, unit)} and viscous friction {shown(joint.spec.joint_damping, unit)}"
            f"{times(total, joint.spec.total_damping)}",
            first.place("joint_damping"),
            first.joint,
            total,
            unit,
            expected=joint.spec.total_damping,
            help=f"leave {shown(joint.spec.joint_damping, unit)} in the joint's damping",
            related=(joint.spec.place("kd"), joint.spec.place("joint_damping")),
        )
