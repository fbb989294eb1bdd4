from __future__ import annotations

import math
from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding
from actspec.audit.rule import RuleOver
from actspec.audit.rules.cfg_groups import (
    EXPLICIT,
    MJLAB_WITH_LINE,
    Group,
    groups_of,
    major_version,
)
from actspec.audit.rules.partners import partner_rows
from actspec.diagnostics import Severity
from actspec.readings.artifact import FileKind, Framework

_MJLAB_EXPLICIT = MJLAB_WITH_LINE | {"IdealPdActuatorCfg"}


class ExplicitWithoutLimit(RuleOver[Group]):
    code = "LIM105"
    name = "explicit-drive-without-effort-limit"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    needs = "no Isaac Lab or mjlab cfg with an explicit drive among the files"

    def subjects(self, case: Case) -> Iterator[Group]:
        yield from (
            *groups_of(case, Framework.ISAACLAB, EXPLICIT),
            *groups_of(case, Framework.MJLAB, _MJLAB_EXPLICIT),
        )

    def judge(self, case: Case, group: Group) -> Iterator[Finding]:
        """Find explicit groups without a limit."""
        if not group.complete or group.written("effort_limit", "actuator_effort_limit") is not None:
            return
        isaac = group.framework is Framework.ISAACLAB
        told = _isaac_default(case.versions.isaaclab, group) if isaac else "mjlab then takes none"
        if told is None:
            return
        limited = set() if isaac else _limited_in_mjcf(case, group)
        for joint in group.joints:
            if joint not in limited:
                name = (
                    "actuator_effort_limit" if major_version(case.versions.isaaclab) >= 3 else "effort_limit"
                )
                yield Finding(
                    self.code,
                    f"this {group.cfg.cls} sets no effort limit: {told}",
                    group.cfg.span,
                    joint,
                    help=f"set {name if isaac else 'effort_limit'} to what the motor and its drive can give",
                )


def _isaac_default(version: str | None, group: Group) -> str | None:
    """What counts in place of the missing limit; None where that is the USD's, or the solver's clamp."""
    numbers = [int(part) for part in version.split(".")] if version is not None else []
    if numbers >= [2, 3, 1]:
        return None
    solver = group.written("effort_limit_sim")
    if numbers and (numbers < [2, 3] or numbers == [2, 3, 0]):
        return (
            None
            if solver is not None
            else f"Isaac Lab {version} then clips at 1e+09 N*m, which no joint reaches"
        )
    first = "at its effort_limit_sim" if solver is not None else "at 1e+09 N*m, which no joint reaches"
    return f"Isaac Lab 2.2 and 2.3.0 then clip {first}; later versions at the limit that the USD has"


def _limited_in_mjcf(case: Case, group: Group) -> set[str]:
    """Joints of the group that an MJCF of the robot limits."""
    return {
        row.joint
        for row in group.rows
        for other in partner_rows(case, row, FileKind.MJCF)
        if other.effort_limit is not None and other.effort_limit < math.inf
    }
