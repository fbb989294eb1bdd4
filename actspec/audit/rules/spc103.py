from __future__ import annotations

from actspec.audit.case import Case
from actspec.audit.rules.spec_pairs import SpecJoint, SpecRule, counted_twice, unit_confused


class SpecPassive(SpecRule):
    code = "SPC103"
    name = "armature-or-friction-departs-from-spec"
    fields = ("armature", "frictionloss", "joint_damping")

    def is_told_elsewhere(self, case: Case, joint: SpecJoint, field: str, tolerance: float) -> bool:
        """Damping counted twice, or a unit."""
        if field == "joint_damping":
            return counted_twice(joint, tolerance) is not None
        return field == "frictionloss" and unit_confused(case, joint, tolerance) is not None
