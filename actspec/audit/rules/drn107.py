from __future__ import annotations

import os
from collections.abc import Iterator
from itertools import pairwise

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.randomized import about_range, ranges
from actspec.readings.artifact import Framework, RandomizedRange, RobotConfig
from actspec.readings.joint_names import matching

_Subject = tuple[int, RobotConfig, RandomizedRange]

_OF_MJLAB = frozenset({"asset_zoo", "envs", "tasks"})
"""Folders of mjlab's package that have configurations."""


class WrongGroupIndex(RuleOver[_Subject]):
    code = "DRN107"
    name = "actuator-names-index-groups"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    written_over = frozenset({"draws"})
    needs = "no mjlab configuration randomises gains or limits"

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for index, config, one in ranges(case):
            if config.framework is not Framework.MJLAB or one.field not in ("kp", "kd", "effort_limit"):
                continue
            if not _is_in_mjlab(one.span.path):
                yield index, config, one

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Find selections that mjlab reads otherwise."""
        index, config, one = subject
        function = "dr.effort_limits" if one.field == "effort_limit" else "dr.pd_gains"
        if one.actuators is not None and not _selects_all(case, index, config, one.actuators):
            yield Finding(
                self.code,
                f"{function} takes the numbers of the joints that actuator_names selects for numbers of actuator "
                "cfgs: other joints are randomised, or an IndexError ends the run",
                one.span,
                help="leave actuator_names out, or give actuator_ids=[number of the cfg]",
                about=about_range(one),
            )
        elif one.joints is not None and one.actuators is None and set(one.joints) != {".*"}:
            yield Finding(
                self.code,
                f"{function} does not look at joint_names: all actuators are randomised",
                one.span,
                help="give actuator_ids=[number of the cfg]",
                about=about_range(one),
            )


def _is_in_mjlab(path: str) -> bool:
    """Whether a file is in a copy of mjlab, whose owner may have mended what takes the numbers."""
    parts = os.path.abspath(path).split(os.sep)
    return any(one == "mjlab" and below in _OF_MJLAB for one, below in pairwise(parts))


def _selects_all(case: Case, index: int, config: RobotConfig, patterns: tuple[str, ...]) -> bool:
    """Whether names select every joint, or each joint is a group of its own in the joints' order."""
    if ".*" in patterns:
        return True
    joints = [row.joint for row in case.rows_of(index)]
    known = bool(set(joints) - {name for group in config.groups for name in group.joints or ()})
    if not known:
        return False
    inside = {name for pattern in patterns for name in matching(config.framework, pattern, joints)}
    groups = [row.actuator for row in case.rows_of(index)]
    return inside == set(joints) or groups == [group.name for group in config.groups]
