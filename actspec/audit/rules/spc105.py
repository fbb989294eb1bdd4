from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import is_driven_by_mjlab, undriven_joints
from actspec.audit.rules.spec_pairs import NO_SPEC, SpecJoint, spec_joints
from actspec.ir import Command, Level
from actspec.readings.artifact import FileKind
from actspec.readings.dynamics import figure


class SpecControl(RuleOver[SpecJoint]):
    code = "SPC105"
    name = "control-departs-from-spec"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    paired = True
    needs = NO_SPEC

    def subjects(self, case: Case) -> Iterator[SpecJoint]:
        yield from spec_joints(case)

    def judge(self, case: Case, joint: SpecJoint) -> Iterator[Finding]:
        """Compare the kinds of drive."""
        departs = _without_a_drive(case, joint) or _departs(joint)
        if departs is None:
            return
        message, severity = departs
        first = joint.rows[0]
        yield Finding(
            self.code,
            message,
            first.span,
            first.joint,
            help="compile the file from the spec, or correct the spec",
            related=(joint.spec.span,),
            severity=severity,
            about=" ".join(sorted({row.control for row in joint.rows})),
        )


_POSITION = frozenset({"position", "implicit", "ideal_pd", "dc_motor", "pid"})

_WITHOUT_LINE = frozenset({"position", "pid", "implicit", "ideal_pd"})


def _without_a_drive(case: Case, joint: SpecJoint) -> tuple[str, Severity] | None:
    """Of a joint that no actuator drives, in a model where others have one: what is wrong, and how bad.

    An included part need not have all actuators, and mjlab adds those of its configuration.
    """
    first = joint.rows[0]
    if first.control != "none" or not (joint.spec.kp or joint.spec.kd):
        return None
    if first.joint not in case.once(undriven_joints).get(first.artifact, ()) or is_driven_by_mjlab(
        case, first
    ):
        return None
    return "no actuator drives this joint, though others have one, and the spec's has a drive", Severity.ERROR


def _departs(joint: SpecJoint) -> tuple[str, Severity] | None:
    """What is different, and how bad; None: nothing, or nobody can tell."""
    controls = {row.control for row in joint.rows}
    command, level = joint.actuator.command, joint.actuator.level
    kp = figure(joint.rows, "kp").value
    if command is Command.POSITION and controls == {"velocity"}:
        return "the drive is a velocity servo, and the spec's command is a position", Severity.ERROR
    if command is not Command.POSITION and controls & _POSITION and kp:
        return f"the drive holds a position, and the spec's command is {command.value}", Severity.ERROR
    if "network" in controls and level is not Level.ACTUATOR_NET:
        return f"the drive is a network, and the spec's level is {level.value}", Severity.ERROR
    if level is Level.ACTUATOR_NET and controls & (_POSITION | {"dcmotor"}) and kp:
        return "the drive is a PD, and the spec's level is actuator_net", Severity.ERROR
    line = joint.actuator.stall_torque is not None or joint.actuator.curve is not None
    if level is Level.DC_MOTOR and line and controls <= _WITHOUT_LINE and joint.kind is FileKind.CFG:
        return (
            "the drive has no torque-speed line, and the spec's level is dc_motor: it gives full torque at any speed",
            Severity.WARNING,
        )
    return None
