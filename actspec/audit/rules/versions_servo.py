"""VER: servos of an MJCF whose gains depend on MuJoCo's version."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Fix, Safety, Skipped, TextEdit
from actspec.audit.rule import Rule
from actspec.audit.rules.actuator_texts import WrittenActuator, drives_in_mjcf, written_actuators
from actspec.diagnostics import Severity
from actspec.ir import JointKind
from actspec.readings.versions import Meant, mujoco_of
from actspec.robot.mjcf_actuator_text import numbers
from actspec.robot.view import JointView
from actspec.robot.xml_edit import format_number
from actspec.robot.xml_tree import Element
from actspec.units import format_quantity

_CHANGED = (3, 15)
"""Release since which a damping ratio is resolved with the inertia of a joint whose neighbours are free."""


class RatioChangedMeaning(Rule):
    """A `dampratio` is another `kv` from MuJoCo 3.15 on.

    ## What it does
    Reports servos with a `dampratio` whose velocity gain differs by `change` or more (default 0.01) between MuJoCo
    up to 3.14 and from 3.15 on, with both figures. A remark where a version is named, because one of them is meant.

    ## Why it matters
    The older releases resolve the ratio with the joint's inertia while the others are held, the newer ones with that
    while they are free, which is smaller: on a leg the same file loses a quarter to a half of its damping, without a
    word. A policy trained on one release meets another robot on the next.

    ## Example
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="hip" axis="0 1 0"/>
          <geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.05" mass="2"/>
          <body pos="0 0 -0.5">
            <joint name="knee" axis="0 1 0"/>
            <geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.04" mass="1"/>
          </body>
        </body>
      </worldbody>
      <actuator>
        <position joint="hip" kp="50" dampratio="1"/>
        <position joint="knee" kp="50" dampratio="1"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="hip" axis="0 1 0"/>
          <geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.05" mass="2"/>
          <body pos="0 0 -0.5">
            <joint name="knee" axis="0 1 0"/>
            <geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.04" mass="1"/>
          </body>
        </body>
      </worldbody>
      <actuator>
        <position joint="hip" kp="50" kv="8.09"/>
        <position joint="knee" kp="50" kv="2.28"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    Without the masses (mesh files that are not there, a file that MuJoCo refuses), and for servos on tendons and sites,
    the figures are unknown; the finding is then a remark. The fix writes the figure of 3.15 and later, unless an older
    version is named.

    ## Source
    MuJoCo 3.7, 3.15 and 4.0, measured: kv = 2 ratio sqrt(kp m), with m the diagonal of M up to 3.14 and 1 over that of
    the inverse of M from 3.15 on, both at qpos0.
    """

    code = "VER101"
    name = "dampratio-changed-meaning"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    fix = Safety.UNSAFE
    options: ClassVar[dict[str, float]] = {"change": 0.01}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
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
            unit = "N*s/m" if _joint(found, JointKind.SLIDE) else "N*m*s/rad"
            newer = meant is None or not meant.before(_CHANGED)
            chosen = new if newer else old
            yield Finding(
                self.code,
                f"dampratio {found.text.bias[2]:.3g} is kv {format_quantity(old, unit, 3)} up to MuJoCo 3.14 and "
                f"{format_quantity(new, unit, 3)} from 3.15 on: {100 * change:.0f} % less damping from the same file",
                found.document.span(owner),
                found.joint,
                old if newer else new,
                unit,
                chosen,
                help=f'write kv="{chosen:.3g}" and no dampratio, which is what '
                f"{meant.text if meant is not None else 'MuJoCo 3.15 and later'} makes of it"
                + ("" if meant is not None else "; tell the audit which version it is meant for"),
                fix=_kv_fix(found, owner, chosen, safe=meant is not None and newer),
                severity=self.severity if meant is None else Severity.INFO,
            )
        if not drives_in_mjcf(case):
            yield Skipped(self.code, "no MJCF with actuators among the files")

    def _unknown(self, found: WrittenActuator, meant: Meant | None) -> Finding:
        owner = found.owner("dampratio") or found.element
        return Finding(
            self.code,
            f"what kv dampratio {found.text.bias[2]:.3g} becomes changed in MuJoCo 3.15, and cannot be computed here",
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
    if joint is None or joint.zero_inertia is None or view.transmission not in ("joint", "jointinparent"):
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
    text = f'kv="{format_number(kv)}"'.encode()
    if owner is element:
        attribute = element.attributes["dampratio"]
        edit = TextEdit(path, attribute.start, attribute.end, text)
    else:
        after_tag = element.start + 1 + len(element.tag)
        edit = TextEdit(path, after_tag, after_tag, b" " + text)
    safety = Safety.SAFE if safe else Safety.UNSAFE
    return Fix(f'Write kv="{kv:.3g}" for the dampratio', safety, (edit,), ("actuator_biasprm",))


def _joint(found: WrittenActuator, kind: JointKind) -> bool:
    robot = found.artifact.robot
    joint: JointView | None = robot.joint(found.view.target) if robot is not None else None
    return joint is not None and joint.kind is kind


class GainsOfAnotherTag(Rule):
    """Gains in a default class belong to another kind of actuator.

    ## What it does
    Reports servos (`position`, `velocity`, `intvelocity`) that take gains from a default class which holds another
    kind of actuator: where MuJoCo up to 3.15 and from 3.16 on make different gains of them, and where the class states
    a gain of the servo's own kind that a later element in the class undoes. A remark where a version is named and only
    the other versions differ.

    ## Why it matters
    A class holds one actuator, and every element in it changes that one. `<position kp="7"/><motor/>` in one class
    leaves a `position` of that class with kp 1. Up to 3.15 the gains also went from any kind to any other: a
    `velocity` in a class with `position kp="7"` had kv 7, and has kv 1 since. The file loads either way.

    ## Example
    ```xml
    <mujoco>
      <default>
        <default class="wheel">
          <position kp="7" kv="2"/>
        </default>
      </default>
      <worldbody>
        <body>
          <joint name="wheel"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <velocity joint="wheel" class="wheel"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <default>
        <default class="wheel">
          <velocity kv="2"/>
        </default>
      </default>
      <worldbody>
        <body>
          <joint name="wheel"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <velocity joint="wheel" class="wheel"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    Classes with `general` or other elements than the servos and `motor` are not followed, nor is a servo that states
    its gains itself.

    ## Source
    MuJoCo 3.3, 3.7, 3.11, 3.15, 3.16 and 4.0, measured over all pairs of servos in one class and in a class below
    another; google-deepmind/mujoco#3561.
    """

    code = "VER106"
    name = "gains-of-another-tag"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
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
        if not drives_in_mjcf(case):
            yield Skipped(self.code, "no MJCF with actuators among the files")

    def _finding(
        self,
        found: WrittenActuator,
        old: tuple[float, float],
        new: tuple[float, float],
        lost: tuple[Element, str] | None,
        meant: Meant | None,
    ) -> Finding:
        tag = found.element.tag
        slide = _joint(found, JointKind.SLIDE)
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
            return owner, f"{name} {stated[0]:.3g}"
    return None


def _shown(gains: tuple[float, float], slide: bool) -> str:
    units = ("N/m", "N*s/m") if slide else ("N*m/rad", "N*m*s/rad")
    kp, kd = (format_quantity(gain, unit, 3) for gain, unit in zip(gains, units, strict=True))
    return f"kp {kp} and kv {kd}" if gains[0] else f"kv {kd}"


RULES: tuple[type[Rule], ...] = (RatioChangedMeaning, GainsOfAnotherTag)
