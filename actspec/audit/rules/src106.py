from __future__ import annotations

from collections.abc import Iterable, Iterator

from actspec.audit.case import Case, runs
from actspec.audit.finding import Confidence, Finding
from actspec.audit.rules.joints import is_left_at_zero, starts_there_alone
from actspec.audit.rules.sided import robots_of_one_side
from actspec.audit.rules.source_blame import POSE, Disagreement
from actspec.audit.rules.source_pairs import compared, disagreements
from actspec.audit.rules.source_rule import (
    SourceRule,
    at_what_is_edited,
    is_of_one_training,
    is_of_run,
    shown,
)
from actspec.diagnostics import Severity
from actspec.readings.artifact import FileKind


class ActionOrPose(SourceRule):
    code = "SRC106"
    name = "action-or-pose-disagrees"
    noted_in_folders = True
    confidence = Confidence.HIGH
    groups = (("action_scale",), ("default_position",))
    needs = "an action scale or default position of one joint"

    def lacks(self, case: Case) -> str:
        """What a deploy file and a configuration do not state both."""
        return f"no deploy file and configuration of one robot state {self.needs}"

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        """Compare deploy files with the training configuration, and that with what a run recorded."""
        kinds = (FileKind.DEPLOY, *((None,) if case.once(runs) else ()))
        if any(compared(case, fields, kind) for fields in self.groups for kind in kinds):
            yield self._departing(case)

    def _departing(self, case: Case) -> Iterator[Finding]:
        tolerance = self.option(case, "tolerance")
        for fields, absolute in zip(self.groups, (0.0, POSE), strict=True):
            robots = case.once(robots_of_one_side)
            for found in disagreements(case, fields, tolerance, absolute, robots):
                if "default_position" in fields and any(
                    starts_there_alone(case, row) for row in (*found.rows, *found.others)
                ):
                    continue
                kinds = {case.artifacts[rows[0].artifact].kind for rows in (found.rows, found.others)}
                if kinds == {FileKind.DEPLOY, FileKind.CFG} or is_of_run(case, found):
                    yield self.finding(case, at_what_is_edited(case, found))

    def severity_of(self, case: Case, found: Disagreement) -> tuple[Severity, Confidence]:
        """A note where the robot has policies of several trainings, and beside a run: one may train otherwise."""
        if not is_of_run(case, found) and is_of_one_training(case, found):
            return self.severity, self.confidence
        return Severity.INFO, Confidence.MEDIUM

    def consequence(self, case: Case, found: Disagreement) -> str:
        """How far the joint goes."""
        mine, theirs = found.mine, found.theirs
        assert mine.value is not None and theirs.value is not None
        if found.field == "action_scale":
            times = "0" if found.ratio is None else f"{abs(found.ratio):.3g}"
            sign = ", the other way" if found.ratio is not None and found.ratio < 0.0 else ""
            beside = "here" if is_of_run(case, found) else "as in training"
            return f"the same action moves the command {times} times as far {beside}{sign}"
        sides = (found.rows, "here"), (found.others, "there")
        at = next((where for rows, where in sides if is_left_at_zero(case, rows[0])), None)
        left = "" if at is None else f" (no key of joint_pos is for the joint {at})"
        return f"every command is {shown(mine.value - theirs.value, mine.unit)} off{left}"
