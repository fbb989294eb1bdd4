from __future__ import annotations

import math
from collections.abc import Iterator

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.configs import IMPLICIT, Group, groups_of
from actspec.audit.rules.joints import shown
from actspec.fields import PLACEHOLDER_SPEED
from actspec.readings.artifact import Framework, Setting
from actspec.readings.versions import is_native
from actspec.units import format_number


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
                f"{self._limit(group, setting, joint)} is ignored for an implicit drive: the joint keeps the USD's "
                "speed limit",
                setting.span,
                joint,
                help="write velocity_limit_sim if the solver is to enforce it, or leave it out",
                # What no joint reaches was no limit before.
                severity=Severity.INFO
                if (group.number(setting, joint) or 0.0) >= PLACEHOLDER_SPEED
                else None,
            )

    def _limit(self, group: Group, setting: Setting, joint: str) -> str:
        number = group.number(setting, joint)
        if number is None:
            return (
                f"velocity_limit (which could not be read: {setting.unknown})"
                if setting.unknown
                else "velocity_limit"
            )
        row = next((row for row in group.rows if row.joint == joint), None)
        return f"velocity_limit {shown(row, 'velocity_limit', number) if row else format_number(number, 3)}"


def _renamed(case: Case) -> bool:
    """Whether the files are meant for a version in which the field is another one."""
    return is_native(case.versions)
