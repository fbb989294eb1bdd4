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
    drives_kind,
    written_actuators,
)
from actspec.ir import JointKind
from actspec.readings.versions import Meant, mujoco_of
from actspec.robot.xml_edit import exact_number
from actspec.robot.xml_tree import Element
from actspec.simulators.mujoco import DAMPRATIO_FREE
from actspec.units import format_number, format_quantity

_FELT = 0.25
"""Change of damping from which it is a warning. Chosen: policies are trained with gains drawn from 0.8 to 1.2."""


class RatioChangedMeaning(RuleInParts):
    code = "VER101"
    name = "dampratio-changed-meaning"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    noted_in_folders = True
    fix = Safety.UNSAFE
    needs = NO_ACTUATORS
    options: ClassVar[dict[str, float]] = {"change": 0.01}

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        if drives_in_mjcf(case):
            yield self._changed(case)

    def _changed(self, case: Case) -> Iterator[Finding]:
        """Compare both meanings."""
        meant = mujoco_of(case.versions)
        for found in written_actuators(case, b"dampratio"):
            owner = found.owner("dampratio")
            if owner is None or not found.text.bias[2] > 0.0:
                continue
            gains = _gains(found)
            if gains is None:
                yield self._unknown(found, meant)
                continue
            old, new = gains
            change = abs(new - old) / max(old, new)
            if change < self.option(case, "change"):
                continue
            unit = "N*s/m" if drives_kind(found, JointKind.SLIDE) else "N*m*s/rad"
            newer = meant is None or not meant.before(DAMPRATIO_FREE)
            chosen = new if newer else old
            yield Finding(
                self.code,
                f"dampratio {format_number(found.text.bias[2], 3)} is kv {format_quantity(old, unit, 3)} up to "
                f"MuJoCo 3.14 and {format_quantity(new, unit, 3)} from 3.15 on: "
                f"{100 * change:.0f} % less damping from the same file",
                found.document.span(owner),
                found.joint,
                old if newer else new,
                unit,
                chosen,
                help=f'write kv="{format_number(chosen)}" and no dampratio, which is what '
                f"{meant.text if meant is not None else 'MuJoCo 3.15 and later'} makes of it"
                + ("" if meant is not None else "; tell the audit which version it is meant for"),
                # Which of the two is right nobody knows who does not know the version.
                fix=None if meant is None else _kv_fix(found, owner, chosen, safe=newer),
                severity=self.severity if meant is None and change >= _FELT else Severity.INFO,
            )

    def _unknown(self, found: WrittenActuator, meant: Meant | None) -> Finding:
        owner = found.owner("dampratio") or found.element
        return Finding(
            self.code,
            f"what kv dampratio {format_number(found.text.bias[2], 3)} becomes changed in MuJoCo 3.15, and "
            "cannot be computed here",
            found.document.span(owner),
            found.joint,
            help="write kv and no dampratio",
            severity=Severity.INFO,
            confidence=Confidence.MEDIUM if meant is None else Confidence.LOW,
        )


def _gains(found: WrittenActuator) -> tuple[float, float] | None:
    """kv up to 3.14 and from 3.15 on, actuator side; None where a mass or kp is unknown."""
    view, robot = found.view, found.artifact.robot
    joint = robot.joint(view.target) if robot is not None else None
    if joint is None or joint.zero_inertia is None or not view.is_direct:
        return None
    if {"kp", "gear"} & view.unknown or not view.gear or view.kp <= 0.0:
        return None
    # From 3.7 on an actuator's own armature is in both inertias already.
    held, free = joint.zero_inertia
    ratio = 2.0 * found.text.bias[2] / view.gear**2
    old, new = ratio * math.sqrt(view.kp * held), ratio * math.sqrt(view.kp * free)
    return (old, new) if new > 0.0 else None


def _kv_fix(found: WrittenActuator, owner: Element, kv: float, *, safe: bool) -> Fix | None:
    element, document = found.element, found.document
    if document.is_repeated(element):
        return None
    path = document.files[element.file].path
    text = f'kv="{exact_number(kv)}"'.encode()
    if owner is element:
        attribute = element.attributes["dampratio"]
        edit = TextEdit(path, attribute.start, attribute.end, text)
    else:
        after_tag = element.start + 1 + len(element.tag)
        edit = TextEdit(path, after_tag, after_tag, b" " + text)
    safety = Safety.SAFE if safe else Safety.UNSAFE
    return Fix(f'Write kv="{format_number(kv)}" for the dampratio', safety, (edit,), ("actuator_biasprm",))
