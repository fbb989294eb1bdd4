from __future__ import annotations

import math
from collections.abc import Iterator
from os.path import basename

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import by_joint, clamp_of, partner_rows, shown, unit
from actspec.diagnostics import Span
from actspec.ir import JointKind
from actspec.readings.artifact import Artifact, FileKind
from actspec.readings.drive import largest
from actspec.readings.ledger import LedgerRow
from actspec.robot.view import ActuatorView
from actspec.units import format_number, format_quantity

_Subject = tuple[Artifact, LedgerRow]

_GEARED = ("effort_limit", "kp", "kd")
"""Figures of the joint that a gear is in."""


class JointSideBehindGear(RuleOver[_Subject]):
    code = "GEA105"
    name = "gear-with-joint-side-figures"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    noted_in_folders = True
    paired = True
    needs = "no MJCF with an actuator on a joint among the files"

    def subjects(self, case: Case) -> Iterator[_Subject]:
        """Compare figures before the gear with figures of the joint."""
        for (index, _), rows in by_joint(case, FileKind.MJCF).items():
            artifact = case.artifacts[index]
            for row in rows:
                if row.control != "none":
                    yield artifact, row

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        artifact, row = subject
        name = row.joint
        actuator = _geared(artifact, row, name)
        if actuator is None:
            return
        limit = _before_gear(actuator)
        stated = _stated_limit(case, artifact, row, limit)
        gear = abs(actuator.gear)
        if limit is not None and stated is not None:
            own = None if artifact.robot is None else clamp_of(artifact.robot.joint(name))
            clamp, makes = math.inf if own is None else own, gear * limit
            gets = min(makes, clamp)
            if _equal(gets, min(limit, clamp)):
                # The joint gets what it would get without the gear.
                return
            elsewhere = stated.path != row.file
            if elsewhere and any(_equal(one.effort_limit or 0.0, gets) for one in _not_mjcf(case, row)):
                # The file that states the same figure is the odd one, and a factor is its gear by chance.
                return
            made = format_quantity(makes, unit(row, "effort_limit"), 3)
            clamped = f", of which the joint's clamp leaves {shown(row, 'effort_limit', gets)}"
            whose = f"limit in {basename(stated.path)}" if elsewhere else "own limit"
            # Which of two files has the wrong side, neither tells.
            or_else = ": it is counted twice here, or left out there" if elsewhere else ""
            yield Finding(
                self.code,
                f"the actuator's {shown(row, 'effort_limit', limit)} are the joint's {whose}, and the gear "
                f"of {format_number(gear, 4)} makes them {made}"
                f"{clamped if gets < makes else ''}{or_else}",
                _place(actuator, "forcerange" if actuator.force_range is not None else "ctrlrange"),
                name,
                gets,
                unit(row, "effort_limit"),
                limit,
                "figures of the joint's side want gear 1; figures of the motor's side are smaller by the gear",
                (stated,),
                fields=_GEARED,
            )
        elif _targets_are_joint_side(actuator, row):
            low, high = (shown(row, "default_position", end) for end in row.command_range or ())
            yield Finding(
                self.code,
                f"the control range is the joint's range, and the gear of {format_number(gear, 4)} divides the "
                f"targets: the joint is asked for {low} ... {high} only",
                _place(actuator, "ctrlrange"),
                name,
                help="a servo with targets at the joint wants gear 1, and kp and forcerange of the joint's "
                "side",
                fields=_GEARED,
                about="ctrlrange",
            )


def _geared(artifact: Artifact, row: LedgerRow, joint: str) -> ActuatorView | None:
    """The row's actuator where it has a gear."""
    if artifact.robot is None or row.control == "none":
        return None
    for actuator in artifact.robot.actuators:
        if actuator.target == joint and actuator.span == row.span and actuator.name == row.actuator:
            geared = "gear" not in actuator.unknown and actuator.gear != 0.0
            return actuator if geared and not math.isclose(abs(actuator.gear), 1.0, rel_tol=0.1) else None
    return None


def _before_gear(actuator: ActuatorView) -> float | None:
    """The torque that the actuator is limited to, gear left out: by its force range, or by what its commands reach."""
    bounds = []
    if actuator.force_range is not None and "force_range" not in actuator.unknown:
        bounds.append(largest(actuator.force_range))
    if actuator.control == "motor" and actuator.input_range is not None and not actuator.unknown:
        bounds.append(abs(actuator.gain) * largest(actuator.input_range))
    return min(bounds, default=None)


def _stated_limit(case: Case, artifact: Artifact, row: LedgerRow, limit: float | None) -> Span | None:
    """Where the same figure stands as the joint's limit."""
    if limit is None or limit <= 1.0:
        # 1 is the full scale of a control, and 0 nothing.
        return None
    for other in partner_rows(case, row):
        if other.effort_limit is not None and _equal(other.effort_limit, limit):
            return other.place("effort_limit")
    joint = None if artifact.robot is None else artifact.robot.joint(row.joint)
    if joint is not None and joint.effort_range is not None and _equal(largest(joint.effort_range), limit):
        return joint.places.get("effort", joint.span)
    return None


def _not_mjcf(case: Case, row: LedgerRow) -> Iterator[LedgerRow]:
    """What files of other kinds say of the joint: a copy of the model would only say the same again."""
    return (one for one in partner_rows(case, row) if case.artifacts[one.artifact].kind is not FileKind.MJCF)


def _targets_are_joint_side(actuator: ActuatorView, row: LedgerRow) -> bool:
    joint, command = row.position_range, actuator.control_range
    if actuator.control != "position" or row.kind is not JointKind.HINGE or joint is None or command is None:
        return False
    span = joint[1] - joint[0]
    written = "ctrlrange" in actuator.stated and "control_range" not in actuator.unknown
    return written and all(abs(c - j) <= 0.01 * span for c, j in zip(command, joint, strict=True))


def _place(actuator: ActuatorView, attribute: str) -> Span:
    return actuator.places.get(attribute, actuator.span)


def _equal(one: float, other: float) -> bool:
    return math.isclose(one, other, rel_tol=0.01)
