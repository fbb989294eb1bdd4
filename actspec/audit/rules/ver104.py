from __future__ import annotations

import math
from collections.abc import Iterator

from actspec.audit.case import MODELS
from actspec.audit.known import likenesses, same
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.configs import IMPLICIT, Group, groups_of
from actspec.audit.rules.joints import partner_rows
from actspec.fields import PLACEHOLDER_SPEED
from actspec.readings.artifact import Framework, Setting
from actspec.readings.versions import is_native


class ImplicitVelocityLimit(RuleOver[Group]):
    code = "VER104"
    name = "implicit-velocity-limit-ignored"
    noted_in_folders = True
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
                help="write velocity_limit_sim (of Isaac Lab 2.1 on) if the solver is to enforce it, or leave it out",
                fields=("velocity_limit",),
                severity=Severity.INFO if _changes_nothing(case, group, joint, setting) else None,
            )


def _changes_nothing(case: Case, group: Group, joint: str, setting: Setting) -> bool:
    """Whether no joint reaches the limit, or the robot's USD has it too: its maker publishes it, or its URDF has it."""
    limit = group.number(setting, joint)
    if limit is None:
        return False
    published = case.once(_published).get((group.artifact, joint), ())
    # The USD was made of the robot's URDF, where that is beside it.
    row = next(row for row in group.rows if row.joint == joint) if joint and group.rows else None
    models = () if row is None else partner_rows(case, row, *MODELS)
    speeds = (*published, *(other.velocity_limit for other in models if other.velocity_limit))
    return limit >= PLACEHOLDER_SPEED or any(same(limit, speed) for speed in speeds)


def _published(case: Case) -> dict[tuple[int, str], set[float]]:
    """Speeds that makers publish, by configuration and joint."""
    found: dict[tuple[int, str], set[float]] = {}
    for known in case.once(likenesses):
        for row, names in known.joints:
            speeds = {variant[name].velocity for variant in known.robot.variants.values() for name in names}
            found[known.index, row.joint] = {speed for speed in speeds if speed is not None}
    return found


def _renamed(case: Case) -> bool:
    """Whether the files are meant for a version in which the field is another one."""
    return is_native(case.versions)
