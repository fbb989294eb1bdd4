from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import own_figure, shown, unit
from actspec.readings.artifact import FileKind
from actspec.readings.drive import largest
from actspec.readings.ledger import LedgerRow
from actspec.robot.view import ActuatorView, JointView

_Subject = tuple[LedgerRow, JointView, ActuatorView]


class TwoClamps(RuleOver[_Subject]):
    code = "LIM104"
    name = "forcerange-against-joint-limit"
    severity = Severity.INFO
    confidence = Confidence.HIGH
    needs = "no MJCF with an actuatorfrcrange and one actuator on its joint among the files"
    options: ClassVar[dict[str, float]] = {"relative": 0.02}

    def subjects(self, case: Case) -> Iterator[_Subject]:
        yield from _single_drives(case)

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Compare the clamps of each joint."""
        row, joint, actuator = subject
        assert joint.effort_range is not None
        relative = self.option(case, "relative")
        clamp, gear = largest(joint.effort_range), abs(actuator.gear)
        place = joint.places.get("effort", joint.span)
        if actuator.force_range is not None:
            force = gear * largest(actuator.force_range)
            if math.isclose(force, clamp, rel_tol=relative):
                return
            lower, upper = sorted((force, clamp))
            names = (
                ("forcerange", "actuatorfrcrange") if force < clamp else ("actuatorfrcrange", "forcerange")
            )
            yield Finding(
                self.code,
                f"{names[0]} limits this joint to {own_figure(row, 'effort_limit')}, and the {names[1]} of "
                f"{shown(row, 'effort_limit', upper)} is never reached",
                actuator.places.get("forcerange", actuator.span),
                joint.name,
                upper,
                unit(row, "effort_limit"),
                lower,
                "make the two equal, or leave one out",
                (place,),
            )
        elif actuator.control == "motor" and row.command_range is not None:
            asked = largest(row.command_range)
            if asked > clamp * (1.0 + relative):
                yield Finding(
                    self.code,
                    f"the control range asks for {shown(row, 'effort_limit', asked)}, and actuatorfrcrange limits "
                    f"this joint to {shown(row, 'effort_limit', clamp)}: what is above has no effect",
                    actuator.places.get("ctrlrange", actuator.span),
                    joint.name,
                    asked,
                    unit(row, "effort_limit"),
                    clamp,
                    "end the control range at the joint's limit",
                    (place,),
                )


def _single_drives(case: Case) -> Iterator[tuple[LedgerRow, JointView, ActuatorView]]:
    """Joints with a limit of their own and one actuator."""
    for index, artifact in case.of_kind(FileKind.MJCF):
        robot = artifact.robot
        if robot is None:
            continue
        limited = {joint.name: joint for joint in robot.joints if joint.effort_range is not None}
        for name, rows in case.joints_by_artifact.get(index, {}).items() if limited else ():
            joint = limited.get(name)
            if joint is None or "effort_range" in joint.unknown or len(rows) != 1:
                continue
            actuator = next(
                (one for one in robot.actuators if one.target == name and one.span == rows[0].span), None
            )
            if actuator is not None and not actuator.unknown & {"force_range", "gear", "control_range"}:
                yield rows[0], joint, actuator
