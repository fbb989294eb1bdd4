from __future__ import annotations

from actspec.audit.case import Case
from actspec.audit.finding import Finding
from actspec.audit.rules.gea101 import HiddenGear
from actspec.audit.rules.source_pairs import (
    TIMES,
    Disagreement,
    SourceRule,
    is_no_limit,
    is_times_off,
    ratio_of,
)
from actspec.readings.compare import hidden_gear


class EffortLimit(SourceRule):
    code = "SRC101"
    name = "effort-limit-disagrees"
    groups = (("effort_limit",),)
    needs = "an effort limit of one joint"

    def is_explained(self, case: Case, found: Disagreement, tolerance: float) -> bool:
        """A placeholder, or the other half of a gear."""
        if is_no_limit(found):
            return True
        return hidden_gear(found.ratio, ratio_of(found, "velocity_limit", "no_load_speed"))

    def without_reported(self, case: Case, findings: list[Finding]) -> list[Finding]:
        """A forgotten reduction says more than that the figures differ."""
        gears = {(item.span, item.joint) for item in HiddenGear().check(case) if isinstance(item, Finding)}
        return [item for item in findings if (item.span, item.joint) not in gears]

    def is_grave(self, case: Case, found: Disagreement) -> bool:
        """Twice or half the limit, or more."""
        return is_times_off(case, found)

    def consequence(self, case: Case, found: Disagreement) -> str:
        """How much torque."""
        assert found.ratio is not None
        if found.ratio >= TIMES:
            return f"the joint has {found.ratio:.3g} times the torque here"
        share = abs(found.ratio - 1.0) * 100.0
        return f"the joint has {share:.3g} % {'more' if found.ratio > 1.0 else 'less'} torque here"
