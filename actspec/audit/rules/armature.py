"""GEA: armature that is missing, or one for all joints."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.ledger import LedgerRow
from actspec.audit.rule import Rule
from actspec.audit.rules.joint_units import shown, unit
from actspec.audit.rules.partners import by_joint, partner_rows
from actspec.diagnostics import Severity
from actspec.ir import JointKind
from actspec.readings.artifact import FileKind, Framework


class OneForAll(Rule):
    """One armature stands on joints of very different motors.

    ## What it does
    Reports an armature that a file gives to hinges whose effort limits differ by `ratio` (default 5) or more.

    ## Why it matters
    Armature comes from a motor's rotor and gear. One number for a knee and a wrist is a number that steadies the
    simulation, not a property of the robot: where it is too large the joint is sluggish, where it is too small it is
    easier to move than the real one.

    ## Example
    ```xml
    <mujoco>
      <default>
        <joint armature="0.01"/>
      </default>
      <worldbody>
        <body>
          <joint name="knee"/>
          <geom size="0.1"/>
          <body pos="0 0 -0.2">
            <joint name="wrist"/>
            <geom size="0.1"/>
          </body>
        </body>
      </worldbody>
      <actuator>
        <motor joint="knee" forcerange="-139 139"/>
        <motor joint="wrist" forcerange="-5 5"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee" armature="0.0251"/>
          <geom size="0.1"/>
          <body pos="0 0 -0.2">
            <joint name="wrist" armature="0.00425"/>
            <geom size="0.1"/>
          </body>
        </body>
      </worldbody>
      <actuator>
        <motor joint="knee" forcerange="-139 139"/>
        <motor joint="wrist" forcerange="-5 5"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    Unequal motors can have equal armature: more gear on a small rotor. The rule asks, it does not know.

    ## Source
    Chosen: the published armatures of the Unitree G1 differ by 7 between joints whose limits differ by 28. Questions:
    unitreerobotics/unitree_rl_mjlab#51, InternRobotics/HoST#38.
    """

    code = "GEA103"
    name = "one-armature-for-unequal-motors"
    severity = Severity.INFO
    confidence = Confidence.MEDIUM
    options: ClassVar[dict[str, float]] = {"ratio": 5.0}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Group joints by armature and compare their limits."""
        looked = False
        groups: dict[tuple[int, float], list[LedgerRow]] = {}
        for (index, _), rows in by_joint(case).items():
            row = rows[0]
            if row.kind is JointKind.SLIDE or "armature" not in row.stated:
                continue
            limit = row.effort_limit
            if (
                row.armature
                and limit is not None
                and 0.0 < limit < _PLACEHOLDER
                and "effort_limit" in row.stated
            ):
                looked = True
                groups.setdefault((index, row.armature), []).append(row)
        for (_, armature), joints in groups.items():
            least, most = (choose(joints, key=_effort) for choose in (min, max))
            if _effort(most) < self.option(case, "ratio") * _effort(least):
                continue
            yield Finding(
                self.code,
                f"{shown(most, 'armature', armature)} is the armature of {len(joints)} joints whose effort limits run "
                f"from {shown(least, 'effort_limit', _effort(least))} ({least.joint}) to "
                f"{shown(most, 'effort_limit', _effort(most))} ({most.joint}): rotor and gear of so different motors "
                "seldom come to one figure",
                most.place("armature"),
                "",
                armature,
                unit(most, "armature"),
                help="state rotor inertia times gear squared for each motor, or where the figure comes from",
                related=(least.place("armature"),)
                if least.place("armature") != most.place("armature")
                else (),
            )
        if not looked:
            yield Skipped(self.code, "no file states armature and effort limit of a hinge")


_PLACEHOLDER = 1e5


def _effort(row: LedgerRow) -> float:
    return row.effort_limit or 0.0


class NoArmature(Rule):
    """A driven joint of an MJCF has no armature.

    ## What it does
    Reports driven hinges whose armature is 0 in the MJCF and in no configuration or spec of the robot. A warning for
    servos whose natural frequency on the links' inertia alone is `frequency` (default 30 Hz) or more, a remark for
    other servos and for motors. Nobody can tell direct drives: set the finding aside with that reason.

    ## Why it matters
    Behind a gear of 10 to 100 the rotor is a large part of the inertia at the joint, at ankles and wrists nearly all
    of it. Without it such a joint moves at once, high gains ring or diverge at the step of the simulation, and the
    policy learns on a joint that the robot does not have.

    ## Example
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="ankle"/>
          <geom size="0.05" mass="0.5"/>
        </body>
      </worldbody>
      <actuator>
        <position joint="ankle" kp="40" kv="1" forcerange="-50 50"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="ankle" armature="0.0072"/>
          <geom size="0.05" mass="0.5"/>
        </body>
      </worldbody>
      <actuator>
        <position joint="ankle" kp="40" kv="1" forcerange="-50 50"/>
      </actuator>
    </mujoco>
    ```

    ## Source
    MuJoCo: 0 by default. Chosen: 30 Hz is three times the recipe for position loops of legged robots (10 Hz). Of 110
    MJCF of vendors and training code 29 have driven joints without armature, damping and friction;
    unitreerobotics/unitree_ros#130.
    """

    code = "GEA104"
    name = "armature-missing"
    severity = Severity.INFO
    confidence = Confidence.MEDIUM
    paired = True
    options: ClassVar[dict[str, float]] = {"frequency": 30.0}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find driven joints that nothing but their links resists."""
        looked = False
        for rows in by_joint(case, FileKind.MJCF).values():
            row = rows[0]
            others = list(partner_rows(case, row, FileKind.CFG, FileKind.SPEC))
            drives = [other for other in others if _drives_mjcf(case, other)]
            drive = row if row.control != "none" else next(iter(drives), None)
            if drive is None or row.kind is JointKind.SLIDE or row.armature is None:
                continue
            looked = True
            if row.armature != 0.0 or any(other.armature for other in others):
                continue
            kp = max((one.kp or 0.0 for one in (*rows, *drives)), default=0.0)
            inertia = row.inertia_free_min
            text = "this driven joint has no armature: only its links resist"
            stiff = False
            if kp > 0.0 and inertia is not None and inertia > 0.0:
                frequency = math.sqrt(kp / inertia) / (2.0 * math.pi)
                stiff = frequency >= self.option(case, "frequency")
                if stiff:
                    # Left and right differ in the third digit.
                    gain = shown(drive, "kp", kp)
                    text += f", and its kp of {gain} gives it a natural frequency of {frequency:.2g} Hz"
            yield Finding(
                self.code,
                text,
                row.place("armature"),
                row.joint,
                0.0,
                unit(row, "armature"),
                help="armature is rotor inertia times gear squared; a direct drive has its rotor's",
                related=() if drive is row else (drive.span,),
                severity=Severity.WARNING if stiff else self.severity,
                confidence=self.confidence if kp > 0.0 else Confidence.LOW,
            )
        if not looked:
            yield Skipped(self.code, "no MJCF with a driven hinge among the files")


def _drives_mjcf(case: Case, row: LedgerRow) -> bool:
    """Whether a configuration's drive acts on the MJCF's own joints, as mjlab's do."""
    config = case.artifacts[row.artifact].config
    return config is not None and config.framework is Framework.MJLAB


RULES: tuple[type[Rule], ...] = (OneForAll, NoArmature)
