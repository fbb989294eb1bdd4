from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.actuator_texts import written_actuators
from actspec.audit.rules.joints import shown, unit
from actspec.diagnostics import Span
from actspec.fields import PLACEHOLDER
from actspec.ir import JointKind
from actspec.readings.artifact import FileKind
from actspec.readings.ledger import LedgerRow
from actspec.robot.mjcf_actuator_text import numbers

_LIMITS = ("effort_limit", "velocity_limit")
_URDF = {
    "effort_limit": "the URDF's effort is 0: MuJoCo reads it as no limit, and a tool that sets up drives from it as a "
    "joint that can give nothing",
    "velocity_limit": "the URDF's velocity is 0: MuJoCo leaves it out, and a solver that enforces it holds the joint",
}

_EMPTY_RANGE = 'forcerange="0 0" is no limit: MuJoCo takes an empty range for none'


class NoEffectiveLimit(RuleInParts):
    code = "LIM101"
    name = "no-effective-limit"
    aliases: ClassVar[dict[str, str]] = {
        "LIM101": "no-limit-of-any-kind",
        "LIM102": "limit-is-a-placeholder",
        "LIM103": "limit-of-zero",
    }
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    needs = "no file states an effort or velocity limit, and no MJCF has actuators on joints"
    options: ClassVar[dict[str, float]] = {"least": PLACEHOLDER}

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        empty = _empty_ranges(case)
        for index, _ in case.of_kind(FileKind.MJCF):
            limited = _limited_elsewhere(case, index)
            for row in case.rows_of(index):
                if row.control != "none" and row.joint:
                    free = row.effort_limit == math.inf and row.joint not in limited and row.span not in empty
                    yield self._missing(row) if free and not _is_bounded(row) else ()
        mimics = _mimics(case)
        for row in case.rows:
            if row.span in empty and row.effort_limit == math.inf:
                yield (self._zero(row, "effort_limit", _EMPTY_RANGE),)
            for field in _LIMITS:
                limit: float | None = getattr(row, field)
                if limit is not None and field in row.stated:
                    idle = (row.artifact, row.joint) in mimics or row.kp == row.kd == 0.0
                    yield self._stated(case, row, field, limit, idle)

    def _missing(self, row: LedgerRow) -> Iterator[Finding]:
        yield Finding(
            self.code,
            "no force range, joint limit or control range limits this actuator: its "
            f"{'force' if row.kind is JointKind.SLIDE else 'torque'} is unlimited",
            row.span,
            row.joint,
            help="add actuatorfrcrange to the joint, or forcerange to the actuator",
        )

    def _stated(self, case: Case, row: LedgerRow, field: str, limit: float, idle: bool) -> Iterator[Finding]:
        """A limit that a file states: so large that it is none, or 0."""
        if self.option(case, "least") <= limit < math.inf:
            yield Finding(
                self.code,
                f"the {_noun(field)} of {shown(row, field, limit, 6)} is a placeholder: no motor reaches it, and "
                "it limits nothing",
                row.place(field),
                row.joint,
                limit,
                unit(row, field),
                help=f"state the motor's {_noun(field)}",
            )
        elif limit == 0.0 and not idle:
            urdf = case.artifacts[row.artifact].kind is FileKind.URDF
            effect = _URDF[field] if urdf else f"the {_noun(field)} is 0: the drive cannot move the joint"
            yield self._zero(row, field, effect)

    def _zero(self, row: LedgerRow, field: str, message: str) -> Finding:
        return Finding(
            self.code,
            message,
            row.place(field),
            row.joint,
            0.0,
            unit(row, field),
            help=f"state the motor's {_noun(field)}",
        )


def _is_bounded(row: LedgerRow) -> bool:
    """Whether the voltage of a dcmotor bounds its torque, or the actuator is no motor that could give any."""
    # Only a dcmotor whose control is its voltage has back-EMF beside no other gain.
    voltage = row.stall_torque is not None or (bool(row.back_emf) and row.command_range is not None)
    return voltage if row.control == "dcmotor" else row.control == "other" and row.kd is None


def _limited_elsewhere(case: Case, artifact: int) -> set[str]:
    """Joints that a configuration of the same robot limits."""
    others = [i for i in case.robot_of(artifact).artifacts if case.artifacts[i].kind is FileKind.CFG]
    rows = [row for other in others for row in case.rows_of(other)]
    return {row.joint for row in rows if row.effort_limit is not None and row.effort_limit < math.inf}


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
