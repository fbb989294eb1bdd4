from __future__ import annotations

from actspec.audit.case import Case
from actspec.audit.rules.source_pairs import Disagreement, SourceRule, shown
from actspec.readings.artifact import FileKind
from actspec.readings.compare import angle_slip


class Friction(SourceRule):
    code = "SRC105"
    name = "friction-disagrees"
    groups = (("frictionloss",), ("joint_damping",))
    needs = "a friction of one joint"

    def is_explained(self, case: Case, found: Disagreement, tolerance: float) -> bool:
        """What DMP106 reports, what an exporter writes, and degrees."""
        for rows, figure in ((found.rows, found.mine), (found.others, found.theirs)):
            urdf = case.artifacts[rows[0].artifact].kind is FileKind.URDF
            if urdf and (found.field == "joint_damping" or not figure.value):
                return True
        return found.field == "joint_damping" and angle_slip(found.ratio, tolerance)

    def consequence(self, case: Case, found: Disagreement) -> str:
        """How much torque."""
        assert found.mine.value is not None and found.theirs.value is not None
        change = abs(found.mine.value - found.theirs.value)
        more = "more" if found.mine.value > found.theirs.value else "less"
        if found.field == "frictionloss":
            return f"the joint resists with {shown(change, found.mine.unit)} {more} here"
        force = found.mine.unit.partition("*s/")[0]
        speed = "1 m/s" if force == "N" else "10 rad/s"
        amount = change * (1.0 if force == "N" else 10.0)
        return f"at {speed} the joint resists with {shown(amount, force)} {more} here"
