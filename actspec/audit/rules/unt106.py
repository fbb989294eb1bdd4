from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from operator import itemgetter
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import clamp_of, finite, is_exporters, is_nobodys, partner_rows, shown, unit
from actspec.diagnostics import Span
from actspec.fields import PLACEHOLDER
from actspec.ir import JointKind
from actspec.readings.artifact import FileKind
from actspec.readings.drive import largest
from actspec.readings.ledger import LedgerRow
from actspec.robot.view import ActuatorView, JointView

_SEVERAL = 2
"""Motors whose range is an angle, from which it is no chance. Chosen: of 2877 MJCF of strangers that have control
ranges two have one such motor, by chance, and none has two."""

_HALF_TURN = 0.01
"""Chosen: 3.14 and 3.15 are pi, rounded [rad]."""

_OWN = "the joint's range"

_Motor = tuple[LedgerRow, JointView, ActuatorView]


class AngleAsTorque(RuleOver[Sequence[_Motor]]):
    code = "UNT106"
    name = "angle-left-in-torque-command"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    noted_in_folders = True
    paired = True
    needs = "no MJCF with a control range of motors that pass it on as torque among the files"
    options: ClassVar[dict[str, float]] = {"times": 2.0}

    def subjects(self, case: Case) -> Iterator[Sequence[_Motor]]:
        """The motors of each model, as far as their control is their torque."""
        for index, artifact in case.of_kind(FileKind.MJCF):
            robot = artifact.robot
            if robot is None:
                continue
            views = {view.span: view for view in robot.actuators}
            motors = []
            for row in case.rows_of(index):
                joint, view = robot.joint(row.joint) if row.joint else None, views.get(row.span)
                if joint is not None and view is not None and _passes_on(row, view):
                    motors.append((row, joint, view))
            if motors:
                yield motors

    def judge(self, case: Case, motors: Sequence[_Motor]) -> Iterator[Finding]:
        """Compare the ranges of a model's motors with angles."""
        angles = [(row, joint, view, angle) for row, joint, view in motors if (angle := _angle(row))]
        if len(angles) < _SEVERAL or 2 * len(angles) < len(motors):
            return
        # One range for all may be their torque, by chance; several that each are the joint's own are not.
        own = {row.command_range for row, _, _, angle in angles if angle == _OWN}
        for row, joint, view, angle in angles:
            assert row.command_range is not None
            bound, stated = largest(row.command_range), _limit(case, row, joint, view)
            if stated is None:
                told = angle == _OWN and len(own) >= _SEVERAL
                others, share = ", as of others of this file", "at most"
            else:
                told = stated[0] >= self.option(case, "times") * bound
                whose = "its" if stated[1].path == row.place("command_range").path else "the"
                others, share = "", f"of {whose} {shown(row, 'effort_limit', stated[0])}"
                if whose == "the":
                    share += f" that {stated[1].path} gives it"
            if told:
                yield Finding(
                    self.code,
                    f"the control range of this motor is {angle} in rad{others}: the joint gets "
                    f"{shown(row, 'effort_limit', bound)} {share}",
                    row.place("command_range"),
                    row.joint,
                    bound,
                    unit(row, "effort_limit"),
                    None if stated is None else stated[0],
                    "end ctrlrange at the joint's torque; targets in rad are for a position servo",
                    () if stated is None else (stated[1],),
                    confidence=Confidence.MEDIUM if stated is None else None,
                    fields=("effort_limit",),
                )


def _passes_on(row: LedgerRow, view: ActuatorView) -> bool:
    """Whether a hinge gets the control as its torque, within a range."""
    known = not view.unknown & {"gain", "gear", "control_range"}
    one = known and math.isclose(abs(view.gain * view.gear), 1.0, rel_tol=0.01)
    return one and row.control == "motor" and row.kind is JointKind.HINGE and row.command_range is not None


def _angle(row: LedgerRow) -> str:
    """What angle a control range is, in words; "" for none. 1 is the full scale of a control."""
    assert row.command_range is not None
    low, high = row.command_range
    if largest(row.command_range) == 1.0:
        return ""
    if row.position_range is not None:
        span = row.position_range[1] - row.position_range[0]
        ends = zip(row.command_range, row.position_range, strict=True)
        if span > 0.0 and all(abs(mine - its) <= 0.01 * span for mine, its in ends):
            return _OWN
    return "half a turn to both sides" if max(abs(high - math.pi), abs(low + math.pi)) <= _HALF_TURN else ""


def _limit(case: Case, row: LedgerRow, joint: JointView, view: ActuatorView) -> tuple[float, Span] | None:
    """What else limits the joint's torque, and where: the model itself, else another file."""
    force = None if "force_range" in view.unknown or view.force_range is None else largest(view.force_range)
    stated = (
        (finite(clamp_of(joint)), joint.places.get("effort", joint.span)),
        (finite(force), view.places.get("forcerange", view.span)),
    )
    own = [(limit, place) for limit, place in stated if limit is not None and limit < PLACEHOLDER]
    if own:
        return min(own, key=itemgetter(0))
    for other in partner_rows(case, row):
        limit = finite(other.effort_limit)
        # The same motor as a scene or a copy of the model has it says nothing else.
        if other.control == row.control and other.command_range == row.command_range:
            continue
        if limit is not None and not is_exporters(other) and not is_nobodys(other, "effort_limit"):
            return limit, other.place("effort_limit")
    return None
