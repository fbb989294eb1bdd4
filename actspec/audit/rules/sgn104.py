from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Fix, Safety, Skipped, TextEdit
from actspec.audit.rule import Rule
from actspec.audit.rules.actuator_texts import (
    NO_ACTUATORS,
    WrittenActuator,
    drives_in_mjcf,
    joint_of,
    place_of,
    written_actuators,
)
from actspec.diagnostics import Severity
from actspec.ir import JointKind
from actspec.robot.view import ActuatorView, RobotView
from actspec.units import format_quantity


class FeedbackIgnored(Rule):
    code = "SGN104"
    name = "biasprm-without-biastype"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    fix = Safety.UNSAFE

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find inert feedback."""
        for found in written_actuators(case, b"biasprm", which=_states_no_type):
            text = found.text
            if text.bias_type != "none" or not any(text.bias[:3]):
                continue
            servo = text.bias[1] < 0.0 and text.gain[0] == -text.bias[1]
            numbers = " ".join(f"{number:.3g}" for number in text.bias[:3])
            yield Finding(
                self.code,
                f"biasprm {numbers} has no effect without biastype: this actuator is a motor that gives "
                f"{_force(found, text.gain[0])} per unit of control, whatever the joint does",
                place_of(found, "biasprm"),
                joint_of(found),
                help='add biastype="affine"; a motor needs no biasprm',
                fix=_type_fix(found),
                severity=Severity.ERROR if servo else self.severity,
            )
        if not drives_in_mjcf(case):
            yield Skipped(self.code, NO_ACTUATORS)


def _type_fix(found: WrittenActuator) -> Fix | None:
    attribute = found.element.attributes.get("biasprm")
    if attribute is None or found.document.is_repeated(found.element):
        return None
    path = found.document.files[found.element.file].path
    edit = TextEdit(path, attribute.start, attribute.start, b'biastype="affine" ')
    return Fix('Add biastype="affine"', Safety.UNSAFE, (edit,), ("actuator_biastype",))


def _force(found: WrittenActuator, gain: float) -> str:
    """Torque at the joint per unit of control; a tendon's force before any joint."""
    joint = None if found.artifact.robot is None else found.artifact.robot.joint(found.view.target)
    hinge = joint is not None and joint.kind is JointKind.HINGE
    return format_quantity(abs(found.view.gear) * gain, "N*m" if hinge else "N", 3)


def _states_no_type(_: RobotView, view: ActuatorView) -> bool:
    return "biastype" not in view.stated
