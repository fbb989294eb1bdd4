"""FRC: friction that the drive cannot overcome, and friction that nobody has."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from os.path import basename
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.ledger import LedgerRow
from actspec.audit.rule import Rule
from actspec.audit.rules.friction import MILLI
from actspec.audit.rules.joint_units import shown, unit
from actspec.audit.rules.partners import by_joint, partner_rows
from actspec.diagnostics import Severity
from actspec.readings.artifact import FileKind
from actspec.readings.pair import Robot


class FrictionNotBelowEffort(Rule):
    """Dry friction is as large as what the drive can give.

    ## What it does
    Reports joints whose dry friction is the effort limit or more. Where the file that has the friction has no limit,
    the least limit of the robot's other files counts.

    ## Why it matters
    The drive cannot move the joint. Such a figure is nearly always in another unit: mN*m, or a dimensionless
    coefficient from a simulator that has those.

    ## Example
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="finger" frictionloss="50"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <motor joint="finger" forcerange="-5 5" forcelimited="true"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="finger" frictionloss="0.05"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <motor joint="finger" forcerange="-5 5" forcelimited="true"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    A brake, or a joint that is locked on purpose, looks the same. An effort limit of 0 is not judged here.

    ## Source
    MuJoCo documentation, XML reference: `frictionloss` is a force. Chosen: at the limit itself, where no reading of
    the figures lets the joint move.
    """

    code = "FRC101"
    name = "friction-not-below-effort"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    paired = True

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare dry friction with the effort limit."""
        looked = False
        for rows in by_joint(case).values():
            row = rows[0]
            friction = row.frictionloss
            if friction is None or "frictionloss" not in row.stated:
                continue
            limiting = _limiting(case, row)
            if limiting is None or limiting.effort_limit is None:
                continue
            looked = True
            limit = limiting.effort_limit
            if friction < limit:
                continue
            where = "" if limiting.file == row.file else f" in {basename(limiting.file)}"
            yield Finding(
                self.code,
                f"the dry friction of {shown(row, 'effort_limit', friction)} is not below the effort limit of "
                f"{shown(row, 'effort_limit', limit)}{where}: the drive cannot move the joint",
                row.place("frictionloss"),
                row.joint,
                friction,
                unit(row, "frictionloss"),
                help=f"is it in m{unit(row, 'frictionloss')} ({shown(row, 'frictionloss', friction / MILLI)}), or a "
                "dimensionless coefficient?",
                related=(limiting.place("effort_limit"),),
            )
        if not looked:
            yield Skipped(self.code, "no joint with dry friction and an effort limit among the files")


class NoFrictionAnywhere(Rule):
    """No driven joint of the robot has any friction.

    ## What it does
    Remarks robots whose driven joints have neither dry nor viscous friction in any of the files. Driven joints are
    those with an actuator in an MJCF, in a group of a configuration, or, where no file has either, those with an
    effort limit in a URDF. Silent where a configuration or spec supplies friction.

    ## Why it matters
    Every geared joint loses torque. A policy that is trained without meets friction first on the robot: small
    commands do nothing there, and what was damped only by the drive's kd is damped twice as much.

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
        <motor joint="knee" forcerange="-30 30" forcelimited="true"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee" damping="0.05" frictionloss="0.2"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <motor joint="knee" forcerange="-30 30" forcelimited="true"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    What a USD has is not read. Randomisation that sets friction counts as friction.

    ## Source
    Chosen. Published figures for joints of legged robots: 0.1 to 1 N*m dry, 0.01 to 0.1 N*m*s/rad viscous (the MJCF
    and URDF of Unitree's A1, Go1, Go2 and G1). unitreerobotics/unitree_ros#130 shows what goes wrong without.
    """

    code = "FRC105"
    name = "no-friction-anywhere"
    severity = Severity.INFO
    confidence = Confidence.MEDIUM

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Look for friction of driven joints in all files of each robot."""
        looked = False
        for robot in case.robots:
            rows = [row for index in robot.artifacts for row in case.rows_of(index) if row.joint]
            models = [
                row for row in rows if case.artifacts[row.artifact].kind in (FileKind.MJCF, FileKind.URDF)
            ]
            driven = _driven(case, rows)
            first = next((row for row in models if row.joint in driven), None)
            if first is None:
                continue
            looked = True
            if all(_frictionless(case, row) for row in rows if row.joint in driven) and not _elsewhere(
                case, robot
            ):
                others = {row.artifact: row.span for row in reversed(models) if row.joint in driven}
                who = (
                    f"none of the {len(driven)} driven joints"
                    if len(driven) > 1
                    else "not even the one driven joint"
                )
                yield Finding(
                    self.code,
                    f"{who} has dry or viscous friction in any file of the robot: "
                    "what is trained on it meets friction first on the real one",
                    first.span,
                    help="measure the torque at several constant speeds: its offset is the dry, its slope the "
                    "viscous friction",
                    related=tuple(span for index, span in sorted(others.items()) if index != first.artifact),
                    confidence=self.confidence
                    if any(row.control != "none" for row in rows)
                    else Confidence.LOW,
                )
        if not looked:
            yield Skipped(self.code, "no MJCF or URDF with driven joints among the files")


class ViscousTakesTheLimit(Rule):
    """The viscous friction of a configuration takes what the drive can give.

    ## What it does
    Reports joints where the passive viscous friction that a configuration, deploy file or spec states, times the
    joint's speed limit (or no-load speed), is `share` of the effort limit or more (default 0.5). DMP103 looks at
    models likewise.

    ## Why it matters
    Passive friction acts behind every torque limit: the drive spends its torque against it, and the joint does not
    get faster than effort limit / friction. The slope of a torque-speed line belongs to the motor, where a DC motor
    class has it already.

    ## Example
    ```python robot_cfg.py
    from isaaclab.actuators import IdealPDActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": IdealPDActuatorCfg(
                joint_names_expr=[".*"],
                effort_limit=33.5,
                velocity_limit_sim=21.0,
                stiffness=25.0,
                damping=0.5,
                viscous_friction=1.6,
            )
        }
    )
    ```

    ## Use instead
    ```python robot_cfg.py
    from isaaclab.actuators import IdealPDActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": IdealPDActuatorCfg(
                joint_names_expr=[".*"],
                effort_limit=33.5,
                velocity_limit_sim=21.0,
                stiffness=25.0,
                damping=0.5,
                viscous_friction=0.016,
            )
        }
    )
    ```

    ## Limits
    Joints without a known speed are not judged.

    ## Source
    Chosen: half the effort limit is beyond any bearing or gearbox; as in DMP103. 33.5 N*m / 21 rad/s = 1.6 N*m*s/rad
    is the slope of the A1's torque-speed line.
    """

    code = "FRC106"
    name = "viscous-takes-the-limit"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    paired = True
    options: ClassVar[dict[str, float]] = {"share": 0.5}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare viscous friction at the joint's speed with the limit."""
        looked = False
        for rows in by_joint(case, FileKind.CFG, FileKind.DEPLOY, FileKind.SPEC).values():
            row = rows[0]
            viscous = row.joint_damping
            limiting = _limiting(case, row)
            speed = min(filter(None, map(_speed, (row, *partner_rows(case, row)))), default=None)
            if viscous is None or "joint_damping" not in row.stated or limiting is None or speed is None:
                continue
            limit = limiting.effort_limit
            assert limit is not None
            looked = True
            if viscous * speed < self.option(case, "share") * limit:
                continue
            yield Finding(
                self.code,
                f"the viscous friction of {shown(row, 'kd', viscous)} takes "
                f"{shown(row, 'effort_limit', viscous * speed)} at the joint's "
                f"{shown(row, 'velocity_limit', speed)}, of an effort limit of {shown(row, 'effort_limit', limit)}",
                row.place("joint_damping"),
                row.joint,
                viscous,
                unit(row, "joint_damping"),
                help=f"is it in m{unit(row, 'kd')} ({shown(row, 'kd', viscous / MILLI)})? The slope of the "
                "torque-speed line belongs to the motor, not to friction",
                related=(limiting.place("effort_limit"),),
            )
        if not looked:
            yield Skipped(
                self.code, "no configuration or spec with viscous friction, effort limit and speed limit"
            )


def _limiting(case: Case, row: LedgerRow) -> LedgerRow | None:
    """The row whose finite effort limit holds for the joint: its own, else the least of the other files."""
    if _finite(row.effort_limit) is not None:
        return row
    others = [other for other in partner_rows(case, row) if _finite(other.effort_limit) is not None]
    return min(others, key=lambda other: other.effort_limit or 0.0, default=None)


def _finite(limit: float | None) -> float | None:
    return limit if limit is not None and 0.0 < limit < math.inf else None


def _speed(row: LedgerRow) -> float | None:
    return _finite(row.velocity_limit) or _finite(row.no_load_speed)


def _driven(case: Case, rows: Sequence[LedgerRow]) -> set[str]:
    """Joints with an actuator in any file; without any, those that a URDF gives an effort."""
    found = {row.joint for row in rows if row.control != "none"}
    if found:
        return found
    urdf = [row for row in rows if case.artifacts[row.artifact].kind is FileKind.URDF]
    return {row.joint for row in urdf if row.effort_limit is not None and row.effort_limit > 0.0}


def _frictionless(case: Case, row: LedgerRow) -> bool:
    """Whether a row has no friction; what a configuration does not say is none of its own."""
    parts = (row.frictionloss, row.joint_damping, row.actuator_damping)
    if case.artifacts[row.artifact].kind in (FileKind.CFG, FileKind.DEPLOY):
        stated = {"frictionloss", "joint_damping"} & row.stated
        return not any(parts) and all(getattr(row, field) is not None for field in stated)
    return not any(parts) and None not in (row.frictionloss, row.joint_damping)


def _elsewhere(case: Case, robot: Robot) -> bool:
    """Whether a configuration of the robot supplies friction that the ledger does not carry."""
    for index in robot.artifacts:
        config = case.artifacts[index].config
        if config is None:
            continue
        if any(one.field in ("friction", "joint_damping") for one in config.randomize):
            return True
        for group in config.groups:
            settings = (group.settings.get("friction"), group.settings.get("dynamic_friction"))
            if any(one is not None and (one.unknown or one.value) for one in settings):
                return True
    return False


RULES: tuple[type[Rule], ...] = (FrictionNotBelowEffort, NoFrictionAnywhere, ViscousTakesTheLimit)
