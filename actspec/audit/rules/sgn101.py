from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import shown, unit
from actspec.diagnostics import Span
from actspec.fields import FIELDS
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
    "friction_static": "it pushes a joint that stands",
    "friction_setting": "it pushes a moving joint on",
    "dynamic_friction_setting": "it pushes a moving joint on",
}
_WITHIN = "nothing lies within it"
_LIMITS = {
    "effort_limit": "a drive that is clamped to it gives one torque whatever the command",
    "solver_effort_limit": _WITHIN,
    "stall_torque": "on a line from there the drive gives one torque whatever the command",
    "no_load_speed": "on a line to there the drive gives one torque whatever the command",
    "velocity_limit": _WITHIN,
}
_WRITTEN = (FileKind.CFG, FileKind.DEPLOY)
"""Files whose limits are one number, for both directions. A URDF's below 0 and a range of MuJoCo's that is turned round
are AUD022's."""

_FASTEST = 10.0
"""Speed up to which dry friction outweighs a negative damping where no motion gains energy [rad/s or m/s]. Chosen: most
joints are slower."""


class NegativeFigure(RuleOver[_Subject]):
    code = "SGN101"
    name = "negative-gain-or-passive-value"
    aliases: ClassVar[dict[str, str]] = {"SGN101": "negative-drive-gain", "SGN105": "negative-passive-value"}
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    needs = (
        "no drive with a gain, no limit in a configuration or deploy file, and no stated damping, friction or "
        "armature, among the files"
    )

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for row in case.rows:
            written = case.artifacts[row.artifact].kind in _WRITTEN
            taken = set()
            for field in (*_GAINS, *_PASSIVE, *(_LIMITS if written else ())):
                value = getattr(row, field, row.more.get(field))
                if value is None or not (field in _GAINS or field in row.stated or field in row.more):
                    continue
                # What is written once may be two figures: Isaac Lab's friction, and a limit of drive and solver.
                if not written or row.place(field) not in taken:
                    yield row, field, value
                taken.add(row.place(field))
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
        if not value < 0.0:
            return
        severity = None
        kind = case.artifacts[row.artifact].kind
        if (
            kind is FileKind.DEPLOY
            and row.kp is not None
            and row.kd is not None
            and max(row.kp, row.kd) < 0.0
        ):
            # Once for the joint, its limit too.
            if field != "kp":
                return
            text = (
                f"kp is {shown(row, 'kp', row.kp)} and kd {shown(row, 'kd', row.kd)}: both push the joint on"
            )
            help = "is the minus its motor's direction? Give angle and torque that sign, as gains have none"
            severity = Severity.WARNING
        elif field in _GAINS:
            if row.span in case.once(_springs):
                return
            text = f"{field} is {shown(row, field, value)}: {_GAINS[field]}"
            help = 'gains are positive; in biasprm the feedback stands with a minus: biasprm="0 -kp -kd"'
        elif field in _LIMITS:
            # What a solver does with it, nobody has measured.
            effect = _WITHIN if row.control == "implicit" else _LIMITS[field]
            text = f"the {FIELDS[field].noun} is {shown(row, field, value)}, below 0: {effect}"
            without = (
                "leave it out, if there is to be none" if value == -1.0 else "write it without the minus"
            )
            help = f"{without}: a limit holds in both directions"
        else:
            if "damping" in field and (row.artifact, row.joint) in case.once(_with_polynomial):
                return
            noun = field.removesuffix("_setting").replace("_", " ")
            # Other simulators of a URDF may drop it.
            where = "in MuJoCo " if kind is FileKind.URDF else ""
            text = f"the {noun} of {shown(row, field, value)} is negative: {where}{_PASSIVE[field]}"
            help = "write it without the minus, or leave it out"
        # A least-squares fit of dry and viscous friction together gives such a damping.
        outweighed = "damping" in field and (row.frictionloss or 0.0) >= -value * _FASTEST
        severity = Severity.INFO if outweighed else severity
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
