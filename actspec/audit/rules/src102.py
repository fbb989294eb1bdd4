from __future__ import annotations

from actspec.audit.case import Case
from actspec.audit.finding import Confidence
from actspec.audit.rules.source_pairs import Disagreement
from actspec.audit.rules.source_rule import (
    TIMES,
    SourceRule,
    are_alternatives,
    is_no_limit,
    is_times,
    is_times_off,
)
from actspec.diagnostics import Severity
from actspec.fields import PLACEHOLDER_SPEED
from actspec.readings.artifact import FileKind
from actspec.readings.compare import angle_slip

_STILL = 0.01
"""A speed limit up to which a joint is held, not driven [rad/s or m/s]. Chosen: half a turn takes it five minutes."""


class VelocityLimit(SourceRule):
    code = "SRC102"
    name = "velocity-limit-disagrees"
    noted_in_folders = True
    groups = (("velocity_limit", "no_load_speed"),)
    needs = "a speed limit of one joint"

    def is_none(self, case: Case, found: Disagreement, tolerance: float) -> bool:
        """A placeholder, or degrees; speeds that no joint reaches, both of them; a motor's speed beside a solver's."""
        return (
            is_no_limit(found)
            or angle_slip(found.ratio, tolerance)
            or _least(found) >= PLACEHOLDER_SPEED
            or _is_line_beside_solver(case, found)
        )

    def severity_of(self, case: Case, found: Disagreement) -> tuple[Severity, Confidence]:
        """A note where a file holds the joint still, where speeds are less than twice each other (solvers and safety
        settings stay below what a motor does), and between two models of one kind, which nobody runs together."""
        quiet = _least(found) <= _STILL or not is_times(found.ratio) or are_alternatives(case, found)
        return (Severity.INFO if quiet else self.severity), self.confidence

    def is_grave(self, case: Case, found: Disagreement) -> bool:
        """Twice or half the limit, or more."""
        return _least(found) > _STILL and is_times_off(case, found) and not are_alternatives(case, found)

    def consequence(self, case: Case, found: Disagreement) -> str:
        """How much speed."""
        assert found.ratio is not None
        if found.ratio >= TIMES:
            return f"the joint is {found.ratio:.3g} times as fast here"
        share = abs(found.ratio - 1.0) * 100.0
        return f"the joint is {share:.3g} % {'faster' if found.ratio > 1.0 else 'slower'} here"


def _is_line_beside_solver(case: Case, found: Disagreement) -> bool:
    """Whether of two configurations one has the end of a torque-speed line, the other a limit of the solver below
    which it changes nothing.
    """
    sides = (found.rows[0], found.others[0])
    if any(case.artifacts[row.artifact].kind is not FileKind.CFG for row in sides):
        return False
    solver = ["velocity_limit" in row.stated for row in sides]
    line, cap = (found.mine, found.theirs) if solver[1] else (found.theirs, found.mine)
    return solver[0] is not solver[1] and (line.value or 0.0) <= (cap.value or 0.0)


def _least(found: Disagreement) -> float:
    """The lower of two speed limits."""
    return min(found.mine.value or 0.0, found.theirs.value or 0.0)
