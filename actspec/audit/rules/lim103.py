from __future__ import annotations

import math
from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.actuator_texts import written_actuators
from actspec.audit.rules.joint_units import unit
from actspec.diagnostics import Severity, Span
from actspec.readings.artifact import FileKind
from actspec.readings.ledger import LedgerRow
from actspec.robot.mjcf_actuator_text import numbers


class ZeroLimit(Rule):
    code = "LIM103"
    name = "limit-of-zero"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find limits of 0, and ranges from 0 to 0."""
        looked = False
        mimics = _mimics(case)
        empty = _empty_ranges(case)
        for row in case.rows:
            if row.span in empty and row.effort_limit == math.inf:
                looked = True
                yield self._finding(row, "effort_limit", _EMPTY_RANGE)
            for field in ("effort_limit", "velocity_limit"):
                limit: float | None = getattr(row, field)
                if limit is None or field not in row.stated:
                    continue
                looked = True
                if limit != 0.0 or (row.artifact, row.joint) in mimics or row.kp == row.kd == 0.0:
                    continue
                yield self._finding(row, field, self._effect(case, row, field))
        if not looked:
            yield Skipped(self.code, "no file states an effort or velocity limit")

    def _effect(self, case: Case, row: LedgerRow, field: str) -> str:
        if case.artifacts[row.artifact].kind is FileKind.URDF:
            return _URDF[field]
        return f"the {_noun(field)} is 0: the drive cannot move the joint"

    def _finding(self, row: LedgerRow, field: str, message: str) -> Finding:
        return Finding(
            self.code,
            message,
            row.place(field),
            row.joint,
            0.0,
            unit(row, field),
            help=f"state the motor's {_noun(field)}",
        )


_URDF = {
    "effort_limit": "the URDF's effort is 0: MuJoCo reads it as no limit, and a tool that sets up drives from it as a "
    "joint that can give nothing",
    "velocity_limit": "the URDF's velocity is 0: MuJoCo leaves it out, and a solver that enforces it holds the joint",
}

_EMPTY_RANGE = 'forcerange="0 0" is no limit: MuJoCo takes an empty range for none'


def _noun(field: str) -> str:
    return field.replace("_", " ")


def _mimics(case: Case) -> set[tuple[int, str]]:
    """Joints that follow another one and have no motor."""
    return {
        (index, joint.name)
        for index, artifact in case.of_kind(FileKind.URDF)
        if artifact.robot is not None
        for joint in artifact.robot.joints
        if joint.mimic is not None
    }


def _empty_ranges(case: Case) -> set[Span]:
    """Places of actuators that have the range from 0 to 0 written."""
    actuators = (
        actuator
        for _, artifact in case.of_kind(FileKind.MJCF)
        if artifact.robot is not None
        for actuator in artifact.robot.actuators
    )
    if not any(actuator.force_range is None and "forcerange" in actuator.stated for actuator in actuators):
        return set()
    return {
        found.view.span
        for found in written_actuators(case, b"forcerange")
        if "forcerange" in found.element.attributes
        and numbers(found.element.attributes["forcerange"].value, 2) == (0.0, 0.0)
    }
