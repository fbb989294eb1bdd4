"""STB: what the simulation's step is too long for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.ledger import LedgerRow
from actspec.audit.rule import Rule
from actspec.audit.rules.joint_units import shown
from actspec.audit.rules.partners import by_joint, partner_rows
from actspec.audit.rules.stability import LIMIT
from actspec.diagnostics import Severity
from actspec.readings.artifact import FileKind, Framework
from actspec.robot.view import RobotView

RINGING = 1.5
"""From here a swing of the speed loses half or less with a step. Chosen: below, it is over after a few steps."""

RUNGE_KUTTA = 2.785
"""h kd/I at which the fourth-order Runge-Kutta step diverges: |1 - z + z^2/2 - z^3/6 + z^4/24| = 1.

Source: MuJoCo 4.0 agrees: 2.7 decays, 2.9 grows.
"""

_EXPLICIT_CLASSES = ("ideal_pd", "dc_motor", "network")


@dataclass(frozen=True, slots=True)
class _Drive:
    """What a step does to a joint that is let go with some speed.

    Attributes:
        step: h [s].
        kp: Of all drives.
        explicit: Damping that is taken from the speed before the step.
        implicit: Damping that is taken from the speed after it.
    """

    step: float
    kp: float
    explicit: float
    implicit: float

    def figure(self, inertia: float) -> float:
        """h kd/I + h^2 kp/(2 I), with joint damping on both sides where it is implicit; 2 is the limit.

        Source: v' = v - h (kp x + (kd + d) v)/(I + h d), x' = x + h v'; as `stability.LIMIT`, with I + h d for I.
        """
        force = self.step * (self.explicit + self.implicit) + self.step**2 * self.kp / 2.0
        return force / (inertia + self.step * self.implicit)


class ExplicitVelocityGain(Rule):
    """An MJCF's drive is too stiff for its step under an explicit integrator.

    ## What it does
    Takes h kd/I + h^2 kp/(2 I) of every driven joint of an MJCF with the Euler or RK4 integrator, where h is the
    file's time step and I the joint's inertia with the other joints free. Under Euler it remarks from `near` (default
    1), warns from 1.5 and calls it an error from 2 on, if that is so in the reference pose; under RK4 it speaks above
    2.785.

    ## Why it matters
    Euler takes `kv` from the speed before the step. At 1 a step takes the whole speed away, above it the speed
    changes its sign with every step, and from 2 on it grows: the joint chatters between its torque limits, or the
    simulation ends in NaN.

    ## Example
    ```xml
    <mujoco>
      <option timestep="0.01"/>
      <worldbody>
        <body>
          <joint name="knee" armature="0.01"/>
          <inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
        </body>
      </worldbody>
      <actuator>
        <position joint="knee" kp="100" kv="5"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <option timestep="0.01" integrator="implicitfast"/>
      <worldbody>
        <body>
          <joint name="knee" armature="0.01"/>
          <inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
        </body>
      </worldbody>
      <actuator>
        <position joint="knee" kp="100" kv="5"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    The figure of one joint is the least that the whole robot has: joints together may be worse. Code that sets step
    or integrator itself is not seen, but for mjlab, beside which the rule is silent.

    ## Source
    MuJoCo 3.7, 3.11 and 4.0, measured: h kv/I = 1.99 decays, 2.01 grows; with h kd/I = 1.5, kp 9900 decays and 10100
    does not (limit 10000). Joint damping is implicit under Euler unless `eulerdamp` is off: with h kv/I = 2.3, damping
    60 holds it (figure 1.81) and 20 does not (2.08).
    """

    code = "STB101"
    name = "kv-under-euler"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    options: ClassVar[dict[str, float]] = {"near": 1.0}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find drives that the step is too long for."""
        looked = False
        for (index, joint), rows in by_joint(case, FileKind.MJCF).items():
            artifact = case.artifacts[index]
            robot = artifact.robot
            least = rows[0].inertia_free_min
            if robot is None or rows[0].control == "none" or least is None or least <= 0.0:
                continue
            looked = True
            drive = _drive_of(robot, rows)
            if drive is None:
                continue
            if robot.integrator == "RK4":
                drive = _Drive(drive.step, 0.0, drive.explicit, 0.0)
            figure = drive.figure(least)
            limit = LIMIT if robot.integrator == "Euler" else RUNGE_KUTTA
            threshold = self.option(case, "near") if robot.integrator == "Euler" else limit
            if drive.explicit > 0.0 and figure >= threshold and not _runs_in_mjlab(case, rows[0]):
                yield self._finding(rows[0], robot, drive, figure, limit, _reference(robot, joint))
        if not looked:
            yield Skipped(self.code, "no MJCF with drives on joints of known inertia among the files")

    def _finding(
        self,
        row: LedgerRow,
        robot: RobotView,
        drive: _Drive,
        figure: float,
        limit: float,
        reference: float | None,
    ) -> Finding:
        beyond = figure >= limit
        sure = beyond and reference is not None and drive.figure(reference) >= limit
        what = "makes the speed grow with every step" if beyond else "turns the speed round with every step"
        return Finding(
            self.code,
            f"{robot.integrator} takes the damping of {shown(row, 'kd', drive.explicit)} explicitly: with a step of "
            f"{drive.step * 1e3:g} ms it {what} (h kd/I + h^2 kp/2I = {figure:.3g}, limit {limit:g})",
            row.place("kd"),
            row.joint,
            figure,
            "1",
            help='set integrator="implicitfast", or a shorter timestep, or state the true armature',
            severity=Severity.ERROR if sure else self.severity if figure >= RINGING else Severity.INFO,
            confidence=self.confidence if beyond else Confidence.MEDIUM,
        )


def _drive_of(robot: RobotView, rows: Sequence[LedgerRow]) -> _Drive | None:
    """The drives of a joint under an explicit integrator; None under another, or with something unknown."""
    if robot.integrator not in ("Euler", "RK4") or robot.timestep is None:
        return None
    kp = [row.kp for row in rows if row.kp is not None]
    kd = [row.kd for row in rows if row.kd is not None]
    actuator = [row.actuator_damping for row in rows if row.actuator_damping is not None]
    joint = rows[0].joint_damping
    if joint is None or min(len(kp), len(kd), len(actuator)) < len(rows):
        return None
    passive = joint + sum(actuator)
    if robot.integrator == "Euler" and robot.eulerdamp:
        return _Drive(robot.timestep, sum(kp), sum(kd), passive)
    return _Drive(robot.timestep, sum(kp), sum(kd) + passive, 0.0)


def _reference(robot: RobotView, joint: str) -> float | None:
    """Free inertia in the reference pose."""
    found = (robot.joint_inertia or {}).get(joint)
    return None if found is None else found.free.reference


def _runs_in_mjlab(case: Case, row: LedgerRow) -> bool:
    """Whether an mjlab configuration of the robot decides on step and integrator."""
    for other in partner_rows(case, row, FileKind.CFG):
        config = case.artifacts[other.artifact].config
        if config is not None and config.framework is Framework.MJLAB:
            return True
    return False


class ExplicitDrive(Rule):
    """A configuration's explicit drive is unstable at its own step.

    ## What it does
    Takes h kd/I + h^2 kp/(2 I) of explicit actuator classes (ideal PD, DC motor; P control of legged_gym), where the
    configuration states the physics step and a model of the robot gives the inertia with the other joints free. It
    remarks from `near` (default 1) and warns from 1.5; above 2, where the speed grows, its confidence is high.

    ## Why it matters
    An explicit class computes the torque from the speed before the step. Above 1 the speed changes its sign with
    every step, from 2 on it grows until the torque limit holds it: the joint buzzes, and the policy learns to live
    with that. This is why explicit classes are given up for implicit ones, and the motor model is lost.

    ## Example
    ```xml leg.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="knee_joint"/>
          <inertial pos="0 0 0" mass="1" diaginertia="0.005 0.005 0.005"/>
        </body>
      </worldbody>
    </mujoco>
    ```
    ```python leg_config.py
    class LegCfg(LeggedRobotCfg):
        class control(LeggedRobotCfg.control):
            control_type = "P"
            stiffness = {"joint": 40.0}
            damping = {"joint": 2.5}
            decimation = 4

        class sim:
            dt = 0.005
    ```

    ## Use instead
    ```python leg_config.py
    class LegCfg(LeggedRobotCfg):
        class control(LeggedRobotCfg.control):
            control_type = "P"
            stiffness = {"joint": 40.0}
            damping = {"joint": 0.5}
            decimation = 4

        class sim:
            dt = 0.005
    ```

    ## Limits
    The model's pose range is not the motion's: the least inertia may be one that is never met, and a foot on the ground
    has the robot's. So it is no error: published policies run beyond the limit (unitree_rl_gym, the H1_2's ankle roll:
    3.0) and live with the buzz. A network's own damping is unknown, and not judged.

    ## Source
    The law of STB101; MuJoCo 4.0 with explicit torques, measured. Reports: isaac-sim/IsaacLab#2497 (explicit models
    unstable at kd above 0.5 with 4 ms), mujocolab/mjlab#518.
    """

    code = "STB102"
    name = "explicit-cfg-drive-unstable"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    options: ClassVar[dict[str, float]] = {"near": 1.0}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find explicit drives that the step is too long for."""
        looked = False
        for rows in by_joint(case, FileKind.CFG).values():
            row = rows[0]
            config = case.artifacts[row.artifact].config
            step = config.physics_dt if config is not None else None
            inertia = row.inertia_free_min
            explicit = row.control in _EXPLICIT_CLASSES and len(rows) == 1
            if not explicit or step is None or row.kd is None or inertia is None or inertia <= 0.0:
                continue
            looked = True
            drive = _Drive(step, row.kp or 0.0, row.kd, max(row.joint_damping or 0.0, 0.0))
            figure = drive.figure(inertia)
            if row.kd <= 0.0 or figure < self.option(case, "near"):
                continue
            beyond = figure >= LIMIT
            what = (
                "makes the speed grow with every step" if beyond else "turns the speed round with every step"
            )
            yield Finding(
                self.code,
                f"the drive ({row.control}) takes kd {shown(row, 'kd', row.kd)} explicitly: with a step of "
                f"{step * 1e3:g} ms it {what} (h kd/I + h^2 kp/2I = {figure:.3g}, limit {LIMIT:g})",
                row.place("kd"),
                row.joint,
                figure,
                "1",
                help="state the true armature, shorten the step, lower kd, or use an implicit class",
                severity=self.severity if figure >= RINGING else Severity.INFO,
                confidence=Confidence.HIGH if beyond else self.confidence,
            )
        if not looked:
            yield Skipped(
                self.code,
                "no configuration with explicit drives, its physics step and a model that gives inertia",
            )


RULES: tuple[type[Rule], ...] = (ExplicitVelocityGain, ExplicitDrive)
