"""SGN: servos written with `gainprm` and `biasprm` that are not what they look like."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Fix, Safety, Skipped, TextEdit
from actspec.audit.rule import Rule
from actspec.audit.rules.actuator_texts import WrittenActuator, drives_in_mjcf, written_actuators
from actspec.diagnostics import Severity, Span
from actspec.ir import JointKind
from actspec.robot.view import ActuatorView, JointView, RobotView
from actspec.robot.xml_edit import format_number
from actspec.units import format_quantity

_NO_DRIVE = "no MJCF with actuators among the files"


class SignTakenAsRatio(Rule):
    """A velocity gain with the wrong sign is taken for a damping ratio.

    ## What it does
    Reports `general` actuators whose `biasprm` has a positive third number while the gain is kp: MuJoCo then reads it
    as a damping ratio and works out another kv. An error from `plausible` (default 3) on, which no damping ratio is.

    ## Why it matters
    `biasprm="0 -50 2"` looks like kv 2 and compiles without a word to kv = 2 * 2 sqrt(kp m), which for a mass of
    1 kg*m^2 is 28.3. Its value changes with the robot's pose and with MuJoCo's version.

    ## Example
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee" armature="1"/>
          <geom size="0.1" mass="0.01"/>
        </body>
      </worldbody>
      <actuator>
        <general joint="knee" gainprm="50" biastype="affine" biasprm="0 -50 2"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee" armature="1"/>
          <geom size="0.1" mass="0.01"/>
        </body>
      </worldbody>
      <actuator>
        <general joint="knee" gainprm="50" biastype="affine" biasprm="0 -50 -2"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    MuJoCo up to 3.15 saves a `dampratio` in this very form, so a small number may be meant.

    ## Source
    MuJoCo 3.7, 3.11 and 4.0, measured: with inertia 4 kg*m^2 `biasprm="0 -50 2"` compiles to kv 56.6. With
    gainprm 49 instead of 50 the number stays, as negative damping (SGN101).
    """

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
                _place(found, "biasprm"),
                _joint_name(found),
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
            yield Skipped(self.code, _NO_DRIVE)


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


class GainIsNotBias(Rule):
    """A servo settles somewhere else than it is told to.

    ## What it does
    Reports position servos on joints whose `gainprm` is not the stiffness in `biasprm`, by more than `relative`
    (default 0.01). An error where the control range is the joint's own range, so that the control is plainly meant
    as a position. Silent where there is an offset, or where the scale brings another control range (0 to 255, say)
    to the joint's range: then it is a conversion.

    ## Why it matters
    The torque is 0 at q = gain/kp * u. A gain that was changed in one place and not in the other moves every target
    by that factor.

    ## Example
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee" range="-2 2" limited="true"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <general joint="knee" gainprm="50" biastype="affine" biasprm="0 -20 -1"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee" range="-2 2" limited="true"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <general joint="knee" gainprm="50" biastype="affine" biasprm="0 -50 -1"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    Servos on tendons are not judged: their length is no joint position.

    ## Source
    MuJoCo 4.0, measured: gainprm 50 with biasprm "0 -20 -1" settles at 2.5 u. Happens when a default class's
    gain is overridden with `gainprm` alone.
    """

    code = "SGN103"
    name = "gain-is-not-minus-bias"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    options: ClassVar[dict[str, float]] = {"relative": 0.01}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare gain and stiffness."""
        relative = self.option(case, "relative")
        for found in written_actuators(case, b"prm", which=lambda _, view: _is_off(view, relative)):
            view = found.view
            kp = view.kp / view.gear**2
            scale = view.gain / kp
            joint = found.artifact.robot.joint(view.target) if found.artifact.robot is not None else None
            if joint is not None and _converts(joint, view.control_range, view.gear, scale):
                continue
            plain = joint is not None and _is_range(joint, view.control_range, 1.0 / view.gear)
            yield Finding(
                self.code,
                f"gainprm is {view.gain:.3g} and the stiffness in biasprm {kp:.3g}: the servo settles at {scale:.3g} "
                "times the position that it is told",
                _place(found, "gainprm", "biasprm"),
                _joint_name(found),
                view.gain,
                "N*m/rad" if joint is None or joint.kind is not JointKind.SLIDE else "N/m",
                kp,
                "gainprm and the second number of biasprm are kp and -kp",
                severity=Severity.ERROR if plain else self.severity,
                confidence=Confidence.HIGH if plain else self.confidence,
            )
        if not drives_in_mjcf(case):
            yield Skipped(self.code, _NO_DRIVE)


_FITS = 0.1
"""How far, relative to the joint's range, a control range may be from it to be it. Chosen: soft limits of 0.9."""


def _is_range(joint: JointView, control: tuple[float, float] | None, factor: float) -> bool:
    """Whether a control range times a factor is the joint's range."""
    if joint.range is None or control is None:
        return False
    span = joint.range[1] - joint.range[0]
    ends = sorted(factor * end for end in control)
    return all(
        abs(end - limit) <= _FITS * span and math.isfinite(end)
        for end, limit in zip(ends, joint.range, strict=True)
    )


def _converts(joint: JointView, control: tuple[float, float] | None, gear: float, scale: float) -> bool:
    """Whether the scale turns a control in another unit into the joint's position."""
    return _is_range(joint, control, scale / gear) and not _is_range(joint, control, 1.0 / gear)


class FeedbackIgnored(Rule):
    """Feedback is written, and ignored for want of `biastype`.

    ## What it does
    Reports `general` actuators with a `biasprm` and no `biastype`, neither their own nor a default class's. An error
    where the numbers are those of a position servo (`gainprm` is minus the second number).

    ## Why it matters
    `biastype` is none by default, and `biasprm` then has no effect: what looks like a servo is a motor. A target of
    1 rad is a constant torque of gainprm * 1, whatever the joint does.

    ## Example
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <general joint="knee" gainprm="50" biasprm="0 -50 -2"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <general joint="knee" gainprm="50" biastype="affine" biasprm="0 -50 -2"/>
      </actuator>
    </mujoco>
    ```

    ## Source
    MuJoCo 3.7, 3.11 and 4.0, measured: the numbers compile into `actuator_biasprm` and are not used.
    """

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
                _place(found, "biasprm"),
                _joint_name(found),
                help='add biastype="affine"; a motor needs no biasprm',
                fix=_type_fix(found),
                severity=Severity.ERROR if servo else self.severity,
            )
        if not drives_in_mjcf(case):
            yield Skipped(self.code, _NO_DRIVE)


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


def _place(found: WrittenActuator, *names: str) -> Span:
    """Where the first of the attributes stands: a default class's place, or the actuator's."""
    own = [name for name in names if name in found.element.attributes]
    if own:
        return found.view.span
    return next((found.view.places[name] for name in names if name in found.view.places), found.view.span)


def _joint_name(found: WrittenActuator) -> str:
    return found.view.target if found.view.transmission in ("joint", "jointinparent") else ""


def _states_no_ratio(_: RobotView, view: ActuatorView) -> bool:
    return view.tag == "general" and "dampratio" not in view.stated


def _states_no_type(_: RobotView, view: ActuatorView) -> bool:
    return "biastype" not in view.stated


def _is_off(view: ActuatorView, relative: float) -> bool:
    """Whether a servo's gain is not its stiffness."""
    if view.control != "position" or {"kp", "gain", "gear"} & view.unknown or view.offset:
        return False
    if view.transmission not in ("joint", "jointinparent") or not view.gear:
        return False
    kp = view.kp / view.gear**2
    return kp > 0.0 and view.gain != 0.0 and abs(view.gain - kp) > relative * kp


RULES: tuple[type[Rule], ...] = (SignTakenAsRatio, GainIsNotBias, FeedbackIgnored)
