from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import shown, unit
from actspec.diagnostics import Span
from actspec.readings.artifact import FileKind
from actspec.readings.ledger import LedgerRow

_Subject = tuple[LedgerRow, str, float]

_GAINS = {
    "kp": "it pushes the joint away from its target",
    "kd": "it drives every motion on instead of braking it",
}
_PASSIVE = {
    "joint_damping": "it feeds energy into every motion",
    "actuator_damping": "it feeds energy into every motion",
    "frictionloss": "it pushes a moving joint on",
    "armature": "it takes inertia away from the links",
}

_FASTEST = 10.0
"""Speed up to which dry friction outweighs a negative damping where no motion gains energy [rad/s or m/s]. Chosen: most
joints are slower."""


class NegativeFigure(RuleOver[_Subject]):
    code = "SGN101"
    name = "negative-gain-or-passive-value"
    aliases: ClassVar[dict[str, str]] = {"SGN101": "negative-drive-gain", "SGN105": "negative-passive-value"}
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    needs = "no drive with a gain, and no stated damping, friction or armature, among the files"

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for row in case.rows:
            for field in (*_GAINS, *_PASSIVE):
                value: float | None = getattr(row, field)
                if value is not None and (field in _GAINS or field in row.stated):
                    yield row, field, value
        # A sign is wrong whichever joint it is of.
        for index, artifact in case.of_kind(FileKind.DEPLOY):
            nameless = artifact.config.nameless if artifact.config is not None else {}
            for field, entries in nameless.items():
                for entry in entries:
                    if (gain := entry.number) is not None:
                        yield LedgerRow(artifact.path, index, entry.span, "", "", "ideal_pd"), field, gain

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Find gains and passive values below 0."""
        row, field, value = subject
        if value >= 0.0:
            return
        if field in _GAINS:
            if row.span in case.once(_springs):
                return
            text = f"{field} is {shown(row, field, value)}: {_GAINS[field]}"
            help = 'gains are positive; in biasprm the feedback stands with a minus: biasprm="0 -kp -kd"'
        else:
            if "damping" in field and (row.artifact, row.joint) in case.once(_with_polynomial):
                return
            noun = field.replace("_", " ")
            text = f"the {noun} of {shown(row, field, value)} is negative: {_PASSIVE[field]}"
            help = "write it without the minus, or leave it out"
        # A least-squares fit of dry and viscous friction together gives such a damping.
        outweighed = "damping" in field and (row.frictionloss or 0.0) >= -value * _FASTEST
        severity = Severity.INFO if outweighed else None
        yield Finding(
            self.code,
            text,
            row.place(field),
            row.joint,
            value,
            unit(row, field),
            -value,
            help,
            fields=(field,),
            severity=severity,
        )


def _springs(case: Case) -> set[Span]:
    """Places of servos without a gain: passive springs."""
    return {
        actuator.span
        for _, artifact in case.of_kind(FileKind.MJCF)
        if artifact.robot is not None
        for actuator in artifact.robot.actuators
        if actuator.control == "position" and actuator.gain == 0.0
    }


def _with_polynomial(case: Case) -> set[tuple[int, str]]:
    """Joints with damping terms of higher order, their own or an actuator's."""
    found = set()
    for index, artifact in case.of_kind(FileKind.MJCF):
        if artifact.robot is not None:
            found |= {(index, joint.name) for joint in artifact.robot.joints if any(joint.damping_polynomial)}
            found |= {(index, act.target) for act in artifact.robot.actuators if any(act.damping[1:])}
    return found
