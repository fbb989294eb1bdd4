from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.actuator_texts import (
    NO_ACTUATORS,
    drives_in_mjcf,
    joint_of,
    place_of,
    written_actuators,
)
from actspec.diagnostics import Severity
from actspec.ir import JointKind
from actspec.robot.view import ActuatorView, JointView


class GainIsNotBias(Rule):
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
                place_of(found, "gainprm", "biasprm"),
                joint_of(found),
                view.gain,
                "N*m/rad" if joint is None or joint.kind is not JointKind.SLIDE else "N/m",
                kp,
                "gainprm and the second number of biasprm are kp and -kp",
                severity=Severity.ERROR if plain else self.severity,
                confidence=Confidence.HIGH if plain else self.confidence,
            )
        if not drives_in_mjcf(case):
            yield Skipped(self.code, NO_ACTUATORS)


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


def _is_off(view: ActuatorView, relative: float) -> bool:
    """Whether a servo's gain is not its stiffness."""
    if view.control != "position" or {"kp", "gain", "gear"} & view.unknown or view.offset:
        return False
    if view.transmission not in ("joint", "jointinparent") or not view.gear:
        return False
    kp = view.kp / view.gear**2
    return kp > 0.0 and view.gain != 0.0 and abs(view.gain - kp) > relative * kp
