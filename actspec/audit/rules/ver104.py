from __future__ import annotations

import math
from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.cfg_groups import IMPLICIT, Group, groups_of
from actspec.audit.rules.joint_units import shown
from actspec.diagnostics import Severity
from actspec.readings.artifact import Framework, Setting
from actspec.readings.versions import release


class ImplicitVelocityLimit(Rule):
    code = "VER104"
    name = "implicit-velocity-limit-ignored"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find limits without effect."""
        named = case.versions.isaaclab
        if named is not None and release(named) >= (3,):
            yield Skipped(self.code, "Isaac Lab 3.0 reads the limit under another name")
            return
        looked = False
        for group in groups_of(case, Framework.ISAACLAB, IMPLICIT):
            looked = True
            setting = group.written("velocity_limit")
            if setting is None or group.written("velocity_limit_sim", "joint_velocity_limit") is not None:
                continue
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
                )
        if not looked:
            yield Skipped(self.code, "no implicit drives of Isaac Lab among the files")

    def _limit(self, group: Group, setting: Setting, joint: str) -> str:
        number = group.number(setting, joint)
        if number is None:
            return (
                f"velocity_limit (which could not be read: {setting.unknown})"
                if setting.unknown
                else "velocity_limit"
            )
        row = next((row for row in group.rows if row.joint == joint), None)
        return f"velocity_limit {shown(row, 'velocity_limit', number) if row else f'{number:.3g}'}"
