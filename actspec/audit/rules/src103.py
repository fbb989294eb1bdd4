from __future__ import annotations

import math

from actspec.audit.case import Case
from actspec.audit.finding import Confidence
from actspec.audit.rules.source_pairs import Disagreement
from actspec.audit.rules.source_rule import SourceRule, is_of_one_training
from actspec.diagnostics import Severity
from actspec.readings.artifact import FileKind
from actspec.units import format_number


class Gain(SourceRule):
    code = "SRC103"
    name = "gain-disagrees"
    groups = (("kp",), ("kd",))
    # As the others of two files: which of a stranger's deploy files runs the policy is not seen.
    noted_in_folders = True
    needs = "a gain of one joint"

    def consequence(self, case: Case, found: Disagreement) -> str:
        """What the joint does then."""
        ratio = found.ratio
        if ratio is None or ratio < 0.0:
            return "one of them has no such gain"
        if found.field == "kp":
            return (
                f"the same command error gives {format_number(ratio, 3)} times the torque, and the joint swings "
                f"{math.sqrt(ratio):.3g} times as fast"
            )
        return f"the drive brakes {format_number(ratio, 3)} times as hard at the same speed"

    def severity_of(self, case: Case, found: Disagreement) -> tuple[Severity, Confidence]:
        """What the policy trained with and what runs it should be one; an MJCF is often only where it is tried."""
        kinds = {case.artifacts[rows[0].artifact].kind for rows in (found.rows, found.others)}
        if kinds == {FileKind.CFG, FileKind.DEPLOY} and is_of_one_training(case, found):
            return Severity.WARNING, Confidence.HIGH
        return Severity.INFO, Confidence.MEDIUM
