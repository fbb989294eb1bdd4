from __future__ import annotations

from actspec.audit.case import Case
from actspec.audit.rules.spec_pairs import SpecJoint, SpecRule, counted_twice, is_sum
from actspec.ir import Level


class SpecGain(SpecRule):
    code = "SPC101"
    name = "gain-departs-from-spec"
    fields = ("kp", "kd")

    def is_told_elsewhere(self, case: Case, joint: SpecJoint, field: str, tolerance: float) -> bool:
        """A network, or damping counted twice."""
        if joint.actuator.level is Level.ACTUATOR_NET:
            return True
        return field == "kd" and (is_sum(joint, tolerance) or counted_twice(joint, tolerance) is not None)
