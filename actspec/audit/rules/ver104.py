from __future__ import annotations

import math
from collections.abc import Iterator

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.configs import IMPLICIT, Group, groups_of
from actspec.fields import PLACEHOLDER_SPEED
from actspec.readings.artifact import Framework
from actspec.readings.versions import is_native


class ImplicitVelocityLimit(RuleOver[Group]):
    code = "VER104"
    name = "implicit-velocity-limit-ignored"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    needs = "no implicit drives of Isaac Lab among the files"

    def subjects(self, case: Case) -> Iterator[Group]:
        if not _renamed(case):
            yield from groups_of(case, Framework.ISAACLAB, IMPLICIT)

    def lacks(self, case: Case) -> str:
        """A version, or drives."""
        return "Isaac Lab 3.0 reads the limit under another name" if _renamed(case) else self.needs

    def judge(self, case: Case, group: Group) -> Iterator[Finding]:
        """Find limits without effect."""
        setting = group.written("velocity_limit")
        if setting is None or group.written("velocity_limit_sim", "joint_velocity_limit") is not None:
            return
        for joint in group.joints:
            if group.number(setting, joint) == math.inf:
                continue
            yield Finding(
                self.code,
                "velocity_limit is ignored for an implicit drive: the joint keeps the USD's speed limit",
                setting.span,
                joint,
                help="write velocity_limit_sim if the solver is to enforce it, or leave it out",
                # What no joint reaches was no limit before.
                fields=("velocity_limit",),
                severity=Severity.INFO
                if (group.number(setting, joint) or 0.0) >= PLACEHOLDER_SPEED
                else None,
            )


def _renamed(case: Case) -> bool:
    """Whether the files are meant for a version in which the field is another one."""
    return is_native(case.versions)
