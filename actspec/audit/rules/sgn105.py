from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding
from actspec.audit.rule import RuleOver
from actspec.audit.rules.joint_units import shown, unit
from actspec.diagnostics import Severity
from actspec.readings.artifact import FileKind
from actspec.readings.ledger import LedgerRow

_Subject = tuple[LedgerRow, str, str, float]


class NegativePassiveValue(RuleOver[_Subject]):
    code = "SGN105"
    name = "negative-passive-value"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    needs = "no file states damping, friction or armature of a joint"

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for row in case.rows:
            for field, effect in _EFFECTS.items():
                value: float | None = getattr(row, field)
                if value is None or field not in row.stated:
                    continue
                yield row, field, effect, value

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Find passive values below 0."""
        row, field, effect, value = subject
        polynomial = _with_polynomial(case)
        if value >= 0.0 or ("damping" in field and (row.artifact, row.joint) in polynomial):
            return
        yield Finding(
            self.code,
            f"the {field.replace('_', ' ')} of {shown(row, field, value)} is negative: {effect}",
            row.place(field),
            row.joint,
            value,
            unit(row, field),
            -value,
            "write it without the minus, or leave it out",
        )


_EFFECTS = {
    "joint_damping": "it feeds energy into every motion",
    "actuator_damping": "it feeds energy into every motion",
    "frictionloss": "it pushes a moving joint on",
    "armature": "it takes inertia away from the links",
}


def _with_polynomial(case: Case) -> set[tuple[int, str]]:
    """Joints with damping terms of higher order, their own or an actuator's."""
    found = set()
    for index, artifact in case.of_kind(FileKind.MJCF):
        if artifact.robot is not None:
            found |= {(index, joint.name) for joint in artifact.robot.joints if any(joint.damping_polynomial)}
            found |= {(index, act.target) for act in artifact.robot.actuators if any(act.damping[1:])}
    return found
