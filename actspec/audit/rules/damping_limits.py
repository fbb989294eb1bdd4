"""DMP: damping and what the motor can give."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.ledger import LedgerRow
from actspec.audit.rule import Rule
from actspec.audit.rules.damping_parts import Parts, parts_by_joint
from actspec.audit.rules.joint_units import shown, unit
from actspec.diagnostics import Severity
from actspec.readings.artifact import FileKind


class DampingOutsideClamp(Rule):
    """Damping that no limit clamps takes a large share of what the motor can give.

    ## What it does
    Reports joints where passive damping times the joint's speed limit is `share` of the effort limit or more (default
    0.5). Speed and effort limits may come from any file of the robot. Where no file has a speed, hinges whose damping
    takes the whole effort limit at `speed` rad/s or less (default 2) are remarked.

    ## Why it matters
    Joint damping acts after the torque limit. The motor spends its torque against it, and the joint cannot be driven
    faster than effort limit / damping, however fast the real one is. When the joint is flung, it brakes harder than
    the motor could.

    ## Example
    ```xml
    <robot name="arm">
      <link name="base"/>
      <link name="forearm"/>
      <joint name="elbow" type="revolute">
        <parent link="base"/>
        <child link="forearm"/>
        <axis xyz="0 1 0"/>
        <limit lower="-2" upper="0" effort="18" velocity="20"/>
        <dynamics damping="1"/>
      </joint>
    </robot>
    ```

    ## Use instead
    ```xml
    <robot name="arm">
      <link name="base"/>
      <link name="forearm"/>
      <joint name="elbow" type="revolute">
        <parent link="base"/>
        <child link="forearm"/>
        <axis xyz="0 1 0"/>
        <limit lower="-2" upper="0" effort="18" velocity="20"/>
        <dynamics damping="0.05"/>
      </joint>
    </robot>
    ```

    ## Limits
    Some files write the motor's torque-speed line as joint damping. That line bends every torque, braking ones too;
    a `<dcmotor>`, or the DC motor class of a framework, bends only what the motor gives.

    ## Source
    MuJoCo 4.0, measured: a motor of 18 N*m on a joint with damping 1 N*m*s/rad ends at 18 rad/s. Chosen: half the
    effort limit is beyond any bearing; joints of legged machines run at 10 to 40 rad/s, of arms
    and servos at 2 to 7.
    """

    code = "DMP103"
    name = "damping-outside-the-clamp"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    options: ClassVar[dict[str, float]] = {"share": 0.5, "speed": 2.0}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare damping times speed with the limit."""
        looked = False
        everything = case.joints
        speeds: dict[tuple[int, str], float | None] = {}
        for (artifact, joint), rows in everything.items():
            if case.artifacts[artifact].kind not in (FileKind.MJCF, FileKind.URDF):
                continue
            row = rows[0]
            actuators = [item.actuator_damping or 0.0 for item in rows]
            damping = None if row.joint_damping is None else row.joint_damping + sum(actuators)
            if damping is None:
                continue
            own = _finite(row.effort_limit)
            if damping <= 0.0:
                looked = looked or own is not None
                continue
            files = case.robot_of(artifact).artifacts
            limit = own or min(
                filter(
                    None,
                    (
                        _finite(row.effort_limit)
                        for file in files
                        if file != artifact
                        for row in everything.get((file, joint), ())
                    ),
                ),
                default=None,
            )
            if limit is None:
                continue
            looked = True
            # One for all files of the robot.
            key = files[0], joint
            if key not in speeds:
                every = (_speed(row) for file in files for row in everything.get((file, joint), ()))
                speeds[key] = min(filter(None, every), default=None)
            speed = speeds[key]
            if speed is not None and damping * speed >= self.option(case, "share") * limit:
                yield self._known(row, damping, limit, speed)
            elif (
                speed is None
                and unit(row, "velocity_limit") == "rad/s"
                and limit <= damping * self.option(case, "speed")
            ):
                yield self._slow(row, damping, limit)
        if not looked:
            yield Skipped(self.code, "no joint with damping and an effort limit among the files")

    def _known(self, row: LedgerRow, damping: float, limit: float, speed: float) -> Finding:
        left = limit - damping * speed
        effect = (
            f"leaves {shown(row, 'effort_limit', left)} to drive the joint"
            if left > 0.0
            else f"keeps the joint below {shown(row, 'velocity_limit', limit / damping)}"
        )
        return Finding(
            self.code,
            f"at the joint's {shown(row, 'velocity_limit', speed)} the damping of {shown(row, 'kd', damping)} takes "
            f"{shown(row, 'effort_limit', damping * speed)} of an effort limit of {shown(row, 'effort_limit', limit)}, "
            f"outside every clamp: that {effect}",
            row.place("joint_damping"),
            row.joint,
            damping,
            unit(row, "kd"),
            help=_HELP,
            related=(row.span,),
        )

    def _slow(self, row: LedgerRow, damping: float, limit: float) -> Finding:
        return Finding(
            self.code,
            f"the damping of {shown(row, 'kd', damping)}, which no limit clamps, takes the whole effort limit of "
            f"{shown(row, 'effort_limit', limit)} at {shown(row, 'velocity_limit', limit / damping)}: the joint cannot "
            "be driven faster",
            row.place("joint_damping"),
            row.joint,
            damping,
            unit(row, "kd"),
            help=_HELP,
            related=(row.span,),
            severity=Severity.INFO,
            confidence=Confidence.LOW,
        )


_HELP = (
    "leave only friction in the joint's damping; a D gain belongs to the drive (kv), a torque-speed line to a "
    "dcmotor or a DC motor class"
)


def _finite(limit: float | None) -> float | None:
    return limit if limit is not None and 0.0 < limit < math.inf else None


def _speed(row: LedgerRow) -> float | None:
    """The joint's top speed: its limit, or the end of its torque-speed line."""
    return _finite(row.velocity_limit) or _finite(row.no_load_speed)


class DampingInThreePlaces(Rule):
    """Damping is counted thrice, or the motor's own slope once more.

    ## What it does
    Reports joints of an MJCF where the drive's velocity gain, the joint's `damping` and the actuator's `damping`
    (MuJoCo 3.7 and later) each are a tenth of the sum or more; and, in all files, joint damping that is within
    `near` (default 0.25, relative) of the slope of the motor's torque-speed line where that line acts already:
    the back-EMF of a dcmotor, or stall torque / no-load speed of a dcmotor or a DC motor class.

    ## Why it matters
    A motor's torque falls with speed because of back-EMF. Written as joint damping too, the fall counts twice: with
    equal slopes the joint reaches half its no-load speed.

    ## Example
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee" damping="2"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <dcmotor joint="knee" nominal="24 20 10" ctrlrange="-24 24"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee" damping="0.05"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <dcmotor joint="knee" nominal="24 20 10" ctrlrange="-24 24"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    A slope that stands only in the joint damping is not seen here; see DMP103.

    ## Source
    MuJoCo 4.0, measured: `nominal="24 20 10"` at 24 V runs at 10 rad/s, and at 5 rad/s with joint damping
    20/10 = 2 N*m*s/rad. Case: bit-bots/bitbots_main#906, a datasheet's slope as joint damping.
    """

    code = "DMP104"
    name = "damping-counted-thrice"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    options: ClassVar[dict[str, float]] = {"near": 0.25}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find three places, and slopes that are there twice."""
        looked = False
        everything = case.once(parts_by_joint)
        for key, rows in case.joints.items():
            row, parts = rows[0], everything[key]
            slope = _slope(rows)
            mjcf = case.artifacts[row.artifact].kind is FileKind.MJCF
            if row.joint_damping is None or not (slope or (mjcf and parts is not None and parts.kd > 0.0)):
                continue
            looked = True
            if slope is not None and abs(row.joint_damping - slope) <= self.option(case, "near") * slope:
                yield self._twice(row, row.joint_damping, slope)
            elif mjcf and parts is not None and parts.in_three_places:
                yield self._thrice(row, parts)
        if not looked:
            yield Skipped(
                self.code, "no drive with a velocity gain, and no torque-speed line, among the files"
            )

    def _thrice(self, row: LedgerRow, parts: Parts) -> Finding:
        return Finding(
            self.code,
            f"the drive brakes with {shown(row, 'kd', parts.kd)}, the joint's damping with "
            f"{shown(row, 'kd', parts.joint)} and the actuator's with {shown(row, 'kd', parts.actuator)}: together "
            f"{shown(row, 'kd', parts.total)}, of which {shown(row, 'kd', parts.passive)} are outside any torque limit",
            row.place("actuator_damping"),
            row.joint,
            parts.total,
            unit(row, "kd"),
            help="keep the D gain in kv and all friction in the joint's damping",
            related=(row.place("joint_damping"),),
        )

    def _twice(self, row: LedgerRow, damping: float, slope: float) -> Finding:
        left = slope / (slope + damping)
        return Finding(
            self.code,
            f"the joint damping of {shown(row, 'kd', damping)} is the slope of the motor's torque-speed line "
            f"({shown(row, 'kd', slope)}), which acts already: the joint reaches {left:.0%} of its no-load speed",
            row.place("joint_damping"),
            row.joint,
            damping,
            unit(row, "kd"),
            help="leave only the friction of the bearings in the joint damping",
            related=(row.span,),
            confidence=Confidence.HIGH,
        )


def _slope(rows: Sequence[LedgerRow]) -> float | None:
    """Fall of the joint's torque over speed that its motors have of themselves; None or above 0."""
    slope = sum(row.back_emf or 0.0 for row in rows)
    for row in rows:
        if row.stall_torque and row.no_load_speed:
            slope += row.stall_torque / row.no_load_speed
    return slope if 0.0 < slope < math.inf else None


RULES: tuple[type[Rule], ...] = (DampingOutsideClamp, DampingInThreePlaces)
