from __future__ import annotations

from actspec.audit.case import Case
from actspec.audit.finding import Confidence
from actspec.audit.rules.joints import limit_of
from actspec.audit.rules.source_blame import Disagreement
from actspec.audit.rules.source_rule import SourceRule, shown
from actspec.diagnostics import Severity
from actspec.readings.artifact import FileKind
from actspec.readings.compare import angle_slip

_UNFELT = 0.02
"""Share of the effort limit below which nobody acts on dry friction. Chosen: identified figures are that far apart; the
0.2 N*m that vendors write to every joint are 0.6 % at a leg of an A1, and 4 % at a wrist of a G1."""


class Friction(SourceRule):
    code = "SRC105"
    name = "friction-disagrees"
    noted_in_folders = True
    groups = (("frictionloss",), ("joint_damping",))
    needs = "a friction of one joint"

    def is_none(self, case: Case, found: Disagreement, tolerance: float) -> bool:
        """A URDF's damping, which is not one thing to its readers, what an exporter writes, and degrees."""
        for rows, figure in ((found.rows, found.mine), (found.others, found.theirs)):
            urdf = case.artifacts[rows[0].artifact].kind is FileKind.URDF
            if urdf and (found.field == "joint_damping" or not figure.value):
                return True
        return found.field == "joint_damping" and angle_slip(found.ratio, tolerance)

    def severity_of(self, case: Case, found: Disagreement) -> tuple[Severity, Confidence]:
        """A note where the difference is nothing beside what the motor gives."""
        change = abs((found.mine.value or 0.0) - (found.theirs.value or 0.0))
        limit = limit_of(case, found.rows[0])
        small = found.field == "frictionloss" and limit is not None and change < _UNFELT * limit
        return Severity.INFO if small else self.severity, self.confidence

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
