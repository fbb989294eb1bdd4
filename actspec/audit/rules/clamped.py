"""What the clamped command of a servo bounds, and what limits its joint far below that."""

from __future__ import annotations

import math
from dataclasses import dataclass

from actspec.audit.case import MODELS, Case
from actspec.audit.known import likenesses
from actspec.audit.rule import Confidence
from actspec.audit.rules.joints import (
    effort_noun,
    folders_in_common,
    is_exporters,
    own_figure,
    partner_rows,
    shown,
)
from actspec.audit.rules.unt101 import ranges_in_doubt
from actspec.diagnostics import Span
from actspec.fields import PLACEHOLDER
from actspec.readings.ledger import LedgerRow, bound_of_command
from actspec.robot.view import ActuatorView

TIMES = 5.0
"""How far a clamped command's bound is above another file's limit. Chosen: it is met at the end of the range alone, and
where it was 1.3 to 2.4 times the limit nobody acted on it (docs/survey.md)."""


@dataclass(frozen=True, slots=True)
class Bounded:
    """What bounds a servo that nothing but its command limits.

    Attributes:
        effect: The bound, in words, with what limits the joint far below it.
        lower: The row that does; None: none, or a published figure.
        confidence: That the bound is none of the motor's; None where nothing tells that.
    """

    effect: str
    lower: LedgerRow | None
    confidence: Confidence | None

    @property
    def related(self) -> tuple[Span, ...]:
        """Where the lower limit is written."""
        return () if self.lower is None else (self.lower.place("effort_limit"),)


def bound_of(row: LedgerRow, view: ActuatorView) -> tuple[float | None, str]:
    """As `bound_of_command`: the largest torque, and how it comes about in words."""
    found = bound_of_command(row, view)
    if found is None:
        return None, ""
    gain, reach = found
    field, of, name = (
        ("kd", "velocity_limit", "kv") if row.control == "velocity" else ("kp", "default_position", "kp")
    )
    return gain * reach, f"{name} {shown(row, field, gain)} x {shown(row, of, reach)}"


def by_command(case: Case, row: LedgerRow, view: ActuatorView | None, bound: float, how: str) -> Bounded:
    """What a clamped command or activation bounds, and what limits the joint far below: another file, or what is
    published.
    """
    clamped = "command" if input_of(view) == "ctrl" else "activation"
    noun = effort_noun(row)
    if is_in_doubt(case, row):
        effect = (
            f"the {noun} that its clamped {clamped} allows is unknown: a range is in the wrong unit (UNT101)"
        )
        return Bounded(effect, None, None)
    effect = f"its clamped {clamped} bounds its {noun} at {shown(row, 'effort_limit', bound)} ({how})"
    if row.position_range is None and row.control != "velocity":
        effect += f" inside the {clamped}'s range"
    partners = (other for other in partner_rows(case, row, *MODELS) if not is_exporters(other))
    others = (other for other in partners if 0.0 < (other.effort_limit or 0.0) < PLACEHOLDER)
    # The largest limit of those files that lie nearest.
    nearest = max(
        others,
        key=lambda other: (folders_in_common(row, other), other.effort_limit or 0.0),
        default=None,
    )
    if nearest is not None:
        if bound < TIMES * (nearest.effort_limit or 0.0):
            return Bounded(effect, None, None)
        limit = own_figure(nearest, "effort_limit", 6)
        there = nearest.place("effort_limit").path
        return Bounded(f"{effect}, and {there} limits the joint to {limit}", nearest, Confidence.HIGH)
    name, published = case.once(_published).get((row.artifact, row.joint), ("", math.inf))
    if bound < TIMES * published:
        return Bounded(effect, None, None)
    limit = shown(row, "effort_limit", published, 6)
    return Bounded(f"{effect}, and {limit} is published for {name}", None, Confidence.MEDIUM)


def input_of(view: ActuatorView | None) -> str:
    """What the gain of an actuator multiplies, by the word of the file: `ctrl` or `act`."""
    return "act" if view is not None and view.input == "activation" else "ctrl"


def is_in_doubt(case: Case, row: LedgerRow) -> bool:
    """Whether the range of a joint or of its command is in another unit than it is read in."""
    places = (row.place(field).path for field in ("position_range", "command_range"))
    return any((path, row.joint) in case.once(ranges_in_doubt) for path in places)


def _published(case: Case) -> dict[tuple[int, str], tuple[str, float]]:
    """Joints of known robots: the robot's name, and the most that is published of the joint [N*m or N]."""
    return {
        (one.index, row.joint): (one.robot.name, max(max(one.robot.efforts(name)) for name in names))
        for one in case.once(likenesses)
        for row, names in one.joints
    }
