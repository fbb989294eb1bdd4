from __future__ import annotations

from collections.abc import Sequence

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding
from actspec.audit.known import same
from actspec.audit.rules.joints import is_nobodys, leaves_speed_open
from actspec.audit.rules.source_blame import Disagreement
from actspec.audit.rules.source_rule import (
    TIMES,
    SourceRule,
    are_alternatives,
    is_a_digit_off,
    is_no_limit,
    is_times,
    is_times_off,
)
from actspec.diagnostics import Severity
from actspec.fields import PLACEHOLDER_SPEED
from actspec.readings.artifact import FileKind
from actspec.readings.compare import Figure, angle_slip
from actspec.readings.ledger import LedgerRow
from actspec.units import format_number

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
            or any(_is_nobodys_in_a_urdf(case, rows[0]) for rows in (found.rows, found.others))
            or angle_slip(found.ratio, tolerance)
            or _least(found) >= PLACEHOLDER_SPEED
            or _is_line_beside_solver(case, found)
        )

    def findings(self, case: Case, disagreements: Sequence[Disagreement]) -> list[Finding]:
        """One each; of a placeholder beside a limit the placeholder's file departs, from the first that has one."""
        told: dict[tuple[int, str], Disagreement] = {}
        for found in disagreements:
            if _is_placeholder(found.theirs) and not _is_placeholder(found.mine):
                found = found.turned
            told.setdefault((found.rows[0].artifact, found.rows[0].joint), found)
        return super().findings(case, list(told.values()))

    def severity_of(self, case: Case, found: Disagreement) -> tuple[Severity, Confidence]:
        """A note where a file holds the joint still, where speeds are less than twice each other (solvers and safety
        settings stay below what a motor does), of a URDF's placeholder, of a motor beside a lower limit, and between
        two models of one kind, of which nobody runs both."""
        quiet = _least(found) <= _STILL or not is_times(found.ratio) or _is_quiet(case, found)
        return (Severity.INFO if quiet else self.severity), self.confidence

    def grave(self, case: Case, found: Disagreement) -> Severity | None:
        """Twice or half the limit, or more, is an error."""
        wrong = _least(found) > _STILL and is_times_off(case, found) and not _is_quiet(case, found)
        return Severity.ERROR if wrong else None

    def consequence(self, case: Case, found: Disagreement) -> str:
        """How much speed."""
        assert found.ratio is not None
        if found.ratio >= TIMES:
            return f"the joint is {format_number(found.ratio, 3)} times as fast here"
        share = abs(found.ratio - 1.0) * 100.0
        return f"the joint is {share:.3g} % {'faster' if found.ratio > 1.0 else 'slower'} here"


def _is_nobodys_in_a_urdf(case: Case, row: LedgerRow) -> bool:
    """Whether a URDF has a placeholder, which LIM101 has; a configuration that has one trains with it."""
    is_urdf = case.artifacts[row.artifact].kind is FileKind.URDF
    return is_urdf and is_nobodys(row, "velocity_limit")


def _is_placeholder(figure: Figure) -> bool:
    """Whether a speed is no evidence of what a joint does."""
    return (figure.value or 0.0) >= PLACEHOLDER_SPEED


def _is_quiet(case: Case, found: Disagreement) -> bool:
    """Whether one of two models is used, or a URDF leaves the limit to others."""
    is_urdf = case.artifacts[found.rows[0].artifact].kind is FileKind.URDF
    left = is_urdf and leaves_speed_open(case, found.rows[0], found.ratio or 0.0)
    return left or are_alternatives(case, found) or _is_motor_above_a_limit(case, found)


def _is_motor_above_a_limit(case: Case, found: Disagreement) -> bool:
    """Whether an MJCF's motor turns faster by itself than a file lets the joint, by less than a digit, and no file says
    that the motor does not.
    """
    for side in (found, found.turned):
        motor, index = side.field == "no_load_speed", side.rows[0].artifact
        of_model = motor and case.artifacts[index].kind is FileKind.MJCF
        if of_model and side.other_field == "velocity_limit" and (side.ratio or 0.0) > 1.0:
            others = set(case.robot_of(index).artifacts) - {index}
            rows = [row for other in others for row in case.joints.get((other, side.rows[0].joint), ())]
            speeds = [row.no_load_speed for row in rows if row.no_load_speed is not None]
            alike = any(same(speed, side.theirs.value or 0.0) for speed in speeds)
            return not alike and not is_a_digit_off(side.ratio)
    return False


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
