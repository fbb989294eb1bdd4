from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

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
from actspec.robot.view import ActuatorView, RobotView
from actspec.robot.xml_edit import format_number


class SignTakenAsRatio(Rule):
    code = "SGN102"
    name = "kv-sign-taken-as-dampratio"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    fix = Safety.UNSAFE
    options: ClassVar[dict[str, float]] = {"plausible": 3.0}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find positive third numbers."""
        for found in written_actuators(case, b"biasprm", which=_states_no_ratio):
            text = found.text
            ratio = text.bias[2]
            servo = text.gain_type == "fixed" and text.bias_type == "affine" and text.gain[0] == -text.bias[1]
            if not (servo and ratio > 0.0 and text.gain[0] > 0.0):
                continue
            compiled = found.view.gear != 0.0 and _has_inertia(found)
            kd = f" of {found.view.kd / found.view.gear**2:.3g}" if compiled else ""
            absurd = ratio >= self.option(case, "plausible")
            yield Finding(
                self.code,
                f"the third number of biasprm is {ratio:.3g}, above 0: MuJoCo takes it for a damping ratio and works "
                f"out a kv{kd} from the inertia, instead of a kv of {ratio:.3g}",
                place_of(found, "biasprm"),
                joint_of(found),
                ratio,
                "1",
                -ratio,
                f"write -{ratio:.3g} for a velocity gain; for a damping ratio write the kv that it gives, because its "
                "meaning depends on MuJoCo's version",
                fix=_bias_fix(found, ratio),
                severity=Severity.ERROR if absurd else self.severity,
                confidence=Confidence.HIGH if absurd else self.confidence,
            )
        if not drives_in_mjcf(case):
            yield Skipped(self.code, NO_ACTUATORS)


def _has_inertia(found: WrittenActuator) -> bool:
    """Whether the compiled kv is that of the robot, and not of one without its meshes."""
    robot = found.artifact.robot
    return robot is not None and (robot.inertia is not None or robot.joint_inertia is not None)


def _bias_fix(found: WrittenActuator, ratio: float) -> Fix | None:
    """The third number with a minus; none where a default class states it or the file is included twice."""
    attribute = found.element.attributes.get("biasprm")
    parts = attribute.value.split() if attribute is not None else []
    if attribute is None or len(parts) < 3 or found.document.is_repeated(found.element):
        return None
    parts[2] = f"-{format_number(ratio)}"
    path = found.document.files[found.element.file].path
    edit = TextEdit(path, attribute.value_start, attribute.value_end, " ".join(parts).encode())
    return Fix(f'Set biasprm to "{" ".join(parts)}"', Safety.UNSAFE, (edit,), ("actuator_biasprm",))


def _states_no_ratio(_: RobotView, view: ActuatorView) -> bool:
    return view.tag == "general" and "dampratio" not in view.stated
