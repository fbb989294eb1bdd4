from __future__ import annotations

from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.rules.source_pairs import Disagreement, SourceRule, shown


class Armature(SourceRule):
    code = "SRC104"
    name = "armature-disagrees"
    options: ClassVar[dict[str, float]] = {"tolerance": 0.05}
    groups = (("armature",),)
    needs = "an armature of one joint"

    def consequence(self, case: Case, found: Disagreement) -> str:
        """How much inertia."""
        assert found.mine.value is not None and found.theirs.value is not None
        change = shown(abs(found.mine.value - found.theirs.value), found.mine.unit)
        more = "more" if found.mine.value > found.theirs.value else "less"
        return f"every torque has {change} {more} to turn"
