"""DMP: a drive's velocity gain and the joint's damping in one MJCF."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from os.path import basename
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.ledger import LedgerRow
from actspec.audit.rule import Rule
from actspec.audit.rules.damping_parts import Parts, parts_by_joint, same
from actspec.audit.rules.joint_units import shown, unit
from actspec.audit.rules.partners import by_joint, partner_rows
from actspec.diagnostics import Severity
from actspec.readings.artifact import FileKind, Framework

_INTENT = (FileKind.CFG, FileKind.SPEC)


class DriveAndJointDamping(Rule):
    """A drive's velocity gain and the joint's own damping add up.

    ## What it does
    Reports joints of an MJCF whose actuators have a velocity gain (`kv`, `biasprm`, a dcmotor) and whose passive
    damping (the joint's, or the actuator's `damping`) is `share` of it or more (default 0.1). It is a remark up to
    `large` (default 0.5), and a warning from there on. Silent where a spec or a configuration of the robot states the
    passive part, and where kv and damping together are the kd that a configuration has.

    ## Why it matters
    Both brake, and the joint gets the sum. A D gain that was written once as `kv` and once as joint damping makes the
    joint twice as damped as the robot: a policy trained on it swings its legs too fast on hardware. The passive part
    also ignores the torque limit.

    ## Example
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="wrist" damping="10" armature="0.01"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <position joint="wrist" kp="20" kv="2" forcerange="-34 34"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="wrist" damping="0.05" armature="0.01"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <position joint="wrist" kp="20" kv="2" forcerange="-34 34"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    A controller plus a bearing is right: which of the two a number is, no file says. Measured friction of joints is a
    few percent of the D gain; above that, look.

    ## Source
    MuJoCo 3.7, 3.11 and 4.0, measured: F = clip(kp (u - q) - kv w) - damping w. Published cases: kv 2 with damping 10
    on one wrist of twenty-odd joints, kv 0.2 with damping 2 (enactic/openarm_mujoco#75), kv 0.6 with damping 2.94
    (bit-bots/bitbots_main#906).
    """

    code = "DMP101"
    name = "kv-and-joint-damping"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    options: ClassVar[dict[str, float]] = {"share": 0.1, "large": 0.5}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find joints with both."""
        looked = False
        everything = case.once(parts_by_joint)
        for key, rows in by_joint(case, FileKind.MJCF).items():
            parts = everything[key]
            if parts is None or parts.kd <= 0.0:
                continue
            looked = True
            if parts.passive < self.option(case, "share") * parts.kd or parts.in_three_places:
                continue
            others = list(partner_rows(case, rows[0], *_INTENT))
            if any(_declares(row, parts) for row in others):
                continue
            yield self._finding(case, rows, parts, others)
        if not looked:
            yield Skipped(self.code, "no MJCF with a drive that has a velocity gain among the files")

    def _finding(
        self, case: Case, rows: Sequence[LedgerRow], parts: Parts, others: Sequence[LedgerRow]
    ) -> Finding:
        row = rows[0]
        share = parts.passive / parts.kd
        # Back-EMF beside friction is what a motor has; DMP104 knows when they are one.
        own = parts.kd - sum(row.back_emf or 0.0 for row in rows)
        large = share >= self.option(case, "large") and own > 0.0
        intent = next((other for other in others if other.kd and same(other.kd, parts.kd)), None)
        sure = same(share, 1.0) or intent is not None
        field = "joint_damping" if parts.joint > 0.0 else "actuator_damping"
        limited = row.effort_limit is not None and row.effort_limit < math.inf
        inside, outside = (" inside the torque limit", " outside it") if limited else ("", "")
        ratio = ""
        if large and row.damping_ratio is not None and row.damping_ratio > 0.0:
            alone = row.damping_ratio * parts.kd / parts.total
            ratio = f", a damping ratio of {row.damping_ratio:.2g} instead of {alone:.2g}"
        known = "" if intent is None else f"; {basename(intent.file)} has the drive's gain alone"
        return Finding(
            self.code,
            f"the drive brakes with {shown(row, 'kd', parts.kd)}{inside} and the joint's damping with "
            f"{shown(row, 'kd', parts.passive)}{outside}: together {shown(row, 'kd', parts.total)}{ratio}{known}",
            row.place(field),
            row.joint,
            parts.passive,
            unit(row, "kd"),
            help="if the damping repeats the D gain, keep one of them; if it is measured friction, state it as "
            "friction.viscous in a spec, or set the finding aside with that reason",
            related=(row.span,),
            severity=self.severity if large else Severity.INFO,
            confidence=Confidence.LOW if not large else Confidence.HIGH if sure else self.confidence,
        )


def _declares(row: LedgerRow, parts: Parts) -> bool:
    """Whether a spec or configuration means the passive part, or the sum."""
    passive = row.joint_damping if "joint_damping" in row.stated else None
    if passive is not None and same(passive, parts.passive):
        return True
    return not passive and row.kd is not None and same(row.kd, parts.total)


class GainInJointDamping(Rule):
    """A position servo's D gain stands in the joint's damping.

    ## What it does
    Reports limited position servos of an MJCF with `kv` 0 whose joint damping is plainly the D gain: it gives a
    damping ratio of `ratio` or more (default 0.1), or, where the inertia is unknown, is `time` seconds of kp or more
    (default 0.01). A remark; a warning where a configuration or spec of the robot has a kd of the same size.

    ## Why it matters
    `kv` is inside the torque limit, joint damping is not. The real drive gives kp and kd from one torque budget; this
    joint brakes with its limit plus damping times speed. And whoever adds a controller with a kd of its own gets both.

    ## Example
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee" damping="2" armature="0.025"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <position joint="knee" kp="75" forcerange="-139 139"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <option integrator="implicitfast"/>
      <worldbody>
        <body>
          <joint name="knee" damping="0.05" armature="0.025"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <position joint="knee" kp="75" kv="2" forcerange="-139 139"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    The split is often chosen on purpose: Euler takes joint damping implicitly and kv explicitly. With `implicitfast`
    there is no need for it.

    ## Source
    MuJoCo 3.7, 3.11 and 4.0, measured: damping is applied after the clamps. Of 110 surveyed MJCF, 19 carry the D gain
    so. The ratio is chosen: bearing friction alone leaves a servo of usual stiffness below 0.1.
    """

    code = "DMP102"
    name = "kd-in-joint-damping"
    severity = Severity.INFO
    confidence = Confidence.MEDIUM
    options: ClassVar[dict[str, float]] = {"ratio": 0.1, "time": 0.01}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find servos without kv on damped joints."""
        looked = False
        everything = case.once(parts_by_joint)
        for key, rows in by_joint(case, FileKind.MJCF).items():
            row, parts = rows[0], everything[key]
            if parts is None or any(item.control != "position" for item in rows):
                continue
            kp = sum(item.kp or 0.0 for item in rows)
            limit = row.effort_limit
            if kp <= 0.0 or limit is None or limit <= 0.0:
                continue
            looked = True
            if parts.kd != 0.0 or limit == math.inf or not self._plain(case, row, parts, kp):
                continue
            others = list(partner_rows(case, row, *_INTENT, FileKind.DEPLOY))
            # DMP105 has the sum with a gain that acts on this very joint.
            if not any(_is_mjlab(case, other) and other.kd for other in others):
                yield self._finding(row, parts, limit, others)
        if not looked:
            yield Skipped(self.code, "no MJCF with limited position servos among the files")

    def _plain(self, case: Case, row: LedgerRow, parts: Parts, kp: float) -> bool:
        if row.damping_ratio is not None:
            return row.damping_ratio >= self.option(case, "ratio")
        return parts.joint >= self.option(case, "time") * kp

    def _finding(self, row: LedgerRow, parts: Parts, limit: float, others: Sequence[LedgerRow]) -> Finding:
        twin = next((o for o in others if o.kd and same(o.kd, parts.joint)), None)
        speed = 10.0 if unit(row, "velocity_limit") == "rad/s" else 1.0
        known = "" if twin is None else f"; {basename(twin.file)} has this kd inside the limit"
        return Finding(
            self.code,
            f"with kv 0, the joint damping of {shown(row, 'kd', parts.joint)} is this servo's D gain, outside "
            f"the torque limit: at {shown(row, 'velocity_limit', speed)} it brakes with "
            f"{shown(row, 'effort_limit', speed * parts.joint)} beside the {shown(row, 'effort_limit', limit)} of the "
            f"drive{known}",
            row.place("joint_damping"),
            row.joint,
            parts.joint,
            unit(row, "kd"),
            help='move it to the actuator as kv, with integrator="implicitfast", and leave the friction as damping',
            related=(row.span,),
            severity=self.severity if twin is None else Severity.WARNING,
            confidence=self.confidence if twin is None else Confidence.HIGH,
        )


def _is_mjlab(case: Case, row: LedgerRow) -> bool:
    config = case.artifacts[row.artifact].config
    return config is not None and config.framework is Framework.MJLAB


RULES: tuple[type[Rule], ...] = (DriveAndJointDamping, GainInJointDamping)
