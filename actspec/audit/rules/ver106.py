from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

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
from actspec.robot.mjcf_actuator_text import numbers
from actspec.robot.xml_tree import Element
from actspec.units import format_number, format_quantity


class GainsOfAnotherTag(RuleInParts):
    code = "VER106"
    name = "gains-of-another-tag"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    needs = NO_ACTUATORS

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        if drives_in_mjcf(case):
            yield self._changed(case)

    def _changed(self, case: Case) -> Iterator[Finding]:
        """Resolve the classes by both rules."""
        meant = mujoco_of(case.versions)
        # Classes of the servo's own tag alone are the same in every release, and lose nothing.
        tags = [b"<" + tag.encode() for tag in _FOLLOWED]
        for found in written_actuators(case, b"<default", two_of=tags):
            tag = found.element.tag
            chain = tuple(one for elements in found.classes for one in elements)
            if tag not in _SERVOS or not {one.tag for one in chain} <= _FOLLOWED:
                continue
            own = found.text.control(tag)
            new = (own.kp, own.kd)
            old = _before_3_16(chain, found.element)
            if old is None or any(not math.isfinite(gain) for gain in (*new, *old)):
                continue
            lost = _lost(found)
            if old == new and lost is None:
                continue
            yield self._finding(found, old, new, lost, meant)

    def _finding(
        self,
        found: WrittenActuator,
        old: tuple[float, float],
        new: tuple[float, float],
        lost: tuple[Element, str] | None,
        meant: Meant | None,
    ) -> Finding:
        tag = found.element.tag
        slide = drives_kind(found, JointKind.SLIDE)
        if old != new:
            text = (
                f"this {tag} takes gains from a class of another kind of actuator: {_shown(old, slide)} up to MuJoCo "
                f"3.15 and {_shown(new, slide)} from 3.16 on"
            )
        else:
            text = (
                f"this {tag} has {_shown(new, slide)}, because another kind of actuator follows in the class"
            )
        span = found.view.span
        if lost is not None:
            owner, stated = lost
            text += f"; the {stated} of the class is lost"
            span = found.document.span(owner)
        known = meant is not None and lost is None
        return Finding(
            self.code,
            text,
            span,
            found.joint,
            help=f"write the gains at the {tag}, or give it a class with a {tag} alone",
            related=(found.view.span,) if span != found.view.span else (),
            severity=Severity.INFO if known else self.severity,
            fields=("kp", "kd"),
        )


_SERVOS = ("position", "velocity", "intvelocity")

_FOLLOWED = frozenset({*_SERVOS, "motor"})


def _before_3_16(chain: tuple[Element, ...], element: Element) -> tuple[float, float] | None:
    """kp and kd of a servo by the rule of 3.3 to 3.15: one actuator, changed by each element in turn."""
    gain, stiffness, damping = 1.0, 0.0, 0.0
    for one in (*chain, element):
        if "dampratio" in one.attributes:
            return None
        kp, kv = (next(iter(numbers(one.get(name), 1)), None) for name in ("kp", "kv"))
        if one.tag == "motor":
            gain = 1.0
        elif one.tag == "velocity":
            gain = gain if kv is None else kv
            stiffness, damping = 0.0, gain
        else:
            gain = stiffness = gain if kp is None else kp
            damping = damping if kv is None else kv
    return stiffness, damping


def _lost(found: WrittenActuator) -> tuple[Element, str] | None:
    """A gain of the servo's own kind that its class states and that does not come through, with its element."""
    tag, text = found.element.tag, found.text
    actual = {"kp": text.gain[0], "kv": text.gain[0] if tag == "velocity" else -text.bias[2]}
    for name in ("kv",) if tag == "velocity" else ("kp", "kv"):
        if name in found.element.attributes:
            continue
        chain = [one for elements in found.classes for one in elements if one.tag == tag]
        owner = next((one for one in reversed(chain) if name in one.attributes), None)
        stated = numbers(owner.get(name), 1) if owner is not None else ()
        if owner is not None and stated and math.isfinite(stated[0]) and stated[0] != actual[name]:
            return owner, f"{name} {format_number(stated[0], 3)}"
    return None


def _shown(gains: tuple[float, float], slide: bool) -> str:
    units = ("N/m", "N*s/m") if slide else ("N*m/rad", "N*m*s/rad")
    kp, kd = (format_quantity(gain, unit, 3) for gain, unit in zip(gains, units, strict=True))
    return f"kp {kp} and kv {kd}" if gains[0] else f"kv {kd}"
