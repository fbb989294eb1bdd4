from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import ClassVar

from actspec.audit.finding import Fix, Safety, TextEdit
from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.actuator_texts import (
    NO_ACTUATORS,
    WrittenActuator,
    drives_in_mjcf,
    place_of,
    written_actuators,
)
from actspec.ir import JointKind
from actspec.robot.view import ActuatorView, JointView, RobotView
from actspec.robot.xml_edit import exact_number
from actspec.units import format_number, format_quantity

_FITS = 0.1
"""How far, relative to the joint's range, a control range may be from it to be it. Chosen: soft limits of 0.9."""

_MEETS = 0.01
"""The same of a scale that was worked out from the range. Chosen: figures of two digits."""


class NotTheServoMeant(RuleInParts):
    code = "SGN102"
    name = "general-is-not-the-servo-meant"
    aliases: ClassVar[dict[str, str]] = {
        "SGN102": "kv-sign-taken-as-dampratio",
        "SGN103": "gain-is-not-minus-bias",
        "SGN104": "biasprm-without-biastype",
    }
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    noted_in_folders = True
    fix = Safety.UNSAFE
    needs = NO_ACTUATORS
    options: ClassVar[dict[str, float]] = {"plausible": 3.0, "relative": 0.01}

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        if drives_in_mjcf(case):
            yield self._ratios(case)
            yield self._scaled(case)
            yield self._ignored(case)

    def _ratios(self, case: Case) -> Iterator[Finding]:
        """Positive third numbers of biasprm, which are taken for damping ratios."""
        for found in written_actuators(case, b"biasprm", which=_states_no_ratio):
            text = found.text
            ratio = text.bias[2]
            servo = text.gain_type == "fixed" and text.bias_type == "affine" and text.gain[0] == -text.bias[1]
            if not (servo and ratio > 0.0 and text.gain[0] > 0.0):
                continue
            compiled = found.view.gear != 0.0 and _has_inertia(found)
            kd = f" of {format_number(found.view.kd / found.view.gear**2, 3)}" if compiled else ""
            absurd = ratio >= self.option(case, "plausible")
            yield Finding(
                self.code,
                f"the third number of biasprm is {format_number(ratio, 3)}, above 0: MuJoCo takes it for a "
                f"damping ratio and works out a kv{kd} from the inertia, instead of a kv of "
                f"{format_number(ratio, 3)}",
                place_of(found, "biasprm"),
                found.joint,
                ratio,
                "1",
                -ratio,
                f"write -{format_number(ratio, 3)} for a velocity gain; for a damping ratio write the kv that it "
                "gives, because its meaning depends on MuJoCo's version",
                fields=("kd",),
                # Below that it may be a damping ratio, as MuJoCo takes it.
                fix=_bias_fix(found, ratio) if absurd else None,
                severity=Severity.ERROR if absurd else None,
                confidence=Confidence.HIGH if absurd else self.confidence,
            )

    def _scaled(self, case: Case) -> Iterator[Finding]:
        """Gains that are not the stiffness."""
        relative = self.option(case, "relative")
        for found in written_actuators(case, b"prm", which=lambda _, view: _is_off(view, relative)):
            view = found.view
            kp = view.kp / view.gear**2
            scale = view.gain / kp
            joint = found.artifact.robot.joint(view.target) if found.artifact.robot is not None else None
            if joint is not None and _converts(joint, view.control_range, view.gear, scale):
                continue
            plain = joint is not None and _is_range(joint, view.control_range, 1.0 / view.gear)
            # A control from -1 to 1 is an action that the gain scales, also where the joint happens to have that range.
            scaled = view.control_range == (-1.0, 1.0)
            yield Finding(
                self.code,
                f"gainprm is {format_number(view.gain, 3)} and the stiffness in biasprm "
                f"{format_number(kp, 3)}: the servo settles at {scale:.3g} times its target position",
                place_of(found, "gainprm", "biasprm"),
                found.joint,
                view.gain,
                "N*m/rad" if joint is None or joint.kind is not JointKind.SLIDE else "N/m",
                kp,
                "gainprm and the second number of biasprm are kp and -kp",
                severity=Severity.INFO if scaled else Severity.ERROR if plain else None,
                confidence=Confidence.LOW if scaled else Confidence.HIGH if plain else self.confidence,
            )

    def _ignored(self, case: Case) -> Iterator[Finding]:
        """Feedback without biastype."""
        for found in written_actuators(case, b"biasprm", which=_states_no_type):
            text = found.text
            if text.bias_type != "none" or not any(text.bias[:3]):
                continue
            if found.artifact.is_part and found.artifact.text_only is not None:
                # No model alone: what includes it may have the type in its defaults.
                continue
            servo = text.bias[1] < 0.0 and text.gain[0] == -text.bias[1]
            numbers = " ".join(format_number(number, 3) for number in text.bias[:3])
            yield Finding(
                self.code,
                f"biasprm {numbers} has no effect without biastype: this actuator is a motor that gives "
                f"{_force(found, text.gain[0])} per unit of control, whatever the joint does",
                place_of(found, "biasprm"),
                found.joint,
                help='add biastype="affine"; a motor needs no biasprm',
                fix=_type_fix(found) if servo else None,
                severity=Severity.ERROR if servo else None,
                confidence=Confidence.HIGH,
                about=numbers,
            )


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
    parts[2] = f"-{exact_number(ratio)}"
    path = found.document.files[found.element.file].path
    edit = TextEdit(path, attribute.value_start, attribute.value_end, " ".join(parts).encode())
    return Fix(f'Set biasprm to "{" ".join(parts)}"', Safety.UNSAFE, (edit,), ("actuator_biasprm",))


def _states_no_ratio(_: RobotView, view: ActuatorView) -> bool:
    return view.tag == "general" and "dampratio" not in view.stated


def _is_range(
    joint: JointView, control: tuple[float, float] | None, factor: float, within: float = _FITS
) -> bool:
    """Whether a control range times a factor is the joint's range."""
    if joint.range is None or control is None:
        return False
    span = joint.range[1] - joint.range[0]
    ends = sorted(factor * end for end in control)
    return all(
        abs(end - limit) <= within * span and math.isfinite(end)
        for end, limit in zip(ends, joint.range, strict=True)
    )


def _converts(joint: JointView, control: tuple[float, float] | None, gear: float, scale: float) -> bool:
    """Whether the scale turns a control in another unit into the joint's position."""
    if _is_range(joint, control, scale / gear, _MEETS):
        # -1 to 1 is turned into 70 degrees either way, which is as near to 1 rad as a soft limit.
        return not _is_range(joint, control, 1.0 / gear, _MEETS)
    return _is_range(joint, control, scale / gear) and not _is_range(joint, control, 1.0 / gear)


def _is_off(view: ActuatorView, relative: float) -> bool:
    """Whether a servo's gain is not its stiffness."""
    if view.control != "position" or {"kp", "gain", "gear"} & view.unknown or view.offset:
        return False
    if not view.is_direct or not view.gear:
        return False
    kp = view.kp / view.gear**2
    return kp > 0.0 and view.gain != 0.0 and abs(view.gain - kp) > relative * kp


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
