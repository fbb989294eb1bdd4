"""LIM: limits that another figure of the joint overrides."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.ledger import LedgerRow
from actspec.audit.rule import Rule
from actspec.audit.rules.joint_units import shown, unit
from actspec.audit.rules.partners import partner_rows
from actspec.diagnostics import Severity, Span
from actspec.ir import JointActuator, Quantity
from actspec.readings.artifact import FileKind
from actspec.robot.view import ActuatorView, JointView


class TwoClamps(Rule):
    """An actuator and its joint have two different torque limits.

    ## What it does
    Reports joints of an MJCF with one actuator, whose `forcerange` (times gear) and `actuatorfrcrange` differ by more
    than `relative` (default 0.02); and, as a remark, motors whose control range asks for more than the joint lets
    through.

    ## Why it matters
    The smaller one binds, whichever was meant. The other reads like data in every table made from the file, and a
    policy whose actions span the control range wastes the part above the clamp.

    ## Example
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee" actuatorfrcrange="-60 60"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <position joint="knee" kp="100" forcerange="-139 139"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee" actuatorfrcrange="-60 60"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <position joint="knee" kp="100" forcerange="-60 60"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    Joints with several actuators are not judged: the joint's limit is then there to clamp their sum.

    ## Source
    MuJoCo 4.0, measured: force = gear * clip(force, forcerange), then the sum is clipped to actuatorfrcrange.
    """

    code = "LIM104"
    name = "forcerange-against-joint-limit"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    options: ClassVar[dict[str, float]] = {"relative": 0.02}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare the clamps of each joint."""
        relative = self.option(case, "relative")
        looked = False
        for row, joint, actuator in _single_drives(case):
            assert joint.effort_range is not None
            looked = True
            clamp, gear = _largest(joint.effort_range), abs(actuator.gear)
            place = joint.places.get("effort", joint.span)
            if actuator.force_range is not None:
                force = gear * _largest(actuator.force_range)
                if math.isclose(force, clamp, rel_tol=relative):
                    continue
                lower, upper = sorted((force, clamp))
                names = (
                    ("forcerange", "actuatorfrcrange")
                    if force < clamp
                    else ("actuatorfrcrange", "forcerange")
                )
                yield Finding(
                    self.code,
                    f"{names[0]} limits this joint to {shown(row, 'effort_limit', lower)}, and the {names[1]} of "
                    f"{shown(row, 'effort_limit', upper)} is never reached",
                    actuator.places.get("forcerange", actuator.span),
                    joint.name,
                    upper,
                    unit(row, "effort_limit"),
                    lower,
                    "make the two equal, or leave one out",
                    (place,),
                )
            elif actuator.control == "motor" and row.command_range is not None:
                asked = _largest(row.command_range)
                if asked > clamp * (1.0 + relative):
                    yield Finding(
                        self.code,
                        f"the control range asks for {shown(row, 'effort_limit', asked)}, and actuatorfrcrange limits "
                        f"this joint to {shown(row, 'effort_limit', clamp)}: what is above has no effect",
                        actuator.places.get("ctrlrange", actuator.span),
                        joint.name,
                        asked,
                        unit(row, "effort_limit"),
                        clamp,
                        "end the control range at the joint's limit",
                        (place,),
                        severity=Severity.INFO,
                    )
        if not looked:
            yield Skipped(
                self.code, "no MJCF with an actuatorfrcrange and one actuator on its joint among the files"
            )


def _single_drives(case: Case) -> Iterator[tuple[LedgerRow, JointView, ActuatorView]]:
    """Joints with a limit of their own and one actuator."""
    for index, artifact in case.of_kind(FileKind.MJCF):
        robot = artifact.robot
        if robot is None:
            continue
        limited = {joint.name: joint for joint in robot.joints if joint.effort_range is not None}
        for name, rows in case.joints_by_artifact.get(index, {}).items() if limited else ():
            joint = limited.get(name)
            if joint is None or "effort_range" in joint.unknown or len(rows) != 1:
                continue
            actuator = next(
                (one for one in robot.actuators if one.target == name and one.span == rows[0].span), None
            )
            if actuator is not None and not actuator.unknown & {"force_range", "gear", "control_range"}:
                yield rows[0], joint, actuator


def _largest(ends: tuple[float, float]) -> float:
    return max(abs(end) for end in ends)


class LineBelowLimit(Rule):
    """An effort limit lies above the torque-speed line.

    ## What it does
    Reports drives whose stall torque (`saturation_effort` of a DC motor class, the line of a MuJoCo `dcmotor`) is
    below their effort limit.

    ## Why it matters
    The line ends at the stall torque, at standstill; nothing above it is ever given, and from there it falls with
    speed. What is called the continuous limit never binds: usually the two figures have changed places.

    ## Example
    ```python robot_cfg.py
    from isaaclab.actuators import DCMotorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": DCMotorCfg(
                joint_names_expr=[".*"],
                effort_limit=120.0,
                saturation_effort=80.0,
                velocity_limit=7.5,
                stiffness=40.0,
                damping=5.0,
            )
        }
    )
    ```

    ## Use instead
    ```python robot_cfg.py
    from isaaclab.actuators import DCMotorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": DCMotorCfg(
                joint_names_expr=[".*"],
                effort_limit=80.0,
                saturation_effort=120.0,
                velocity_limit=7.5,
                stiffness=40.0,
                damping=5.0,
            )
        }
    )
    ```

    ## Source
    Isaac Lab 2.3.2 and mjlab 1.6.0, measured: at speed 0 the torque is clipped at the lower of the two. Reports:
    isaac-sim/IsaacLab#2103; mjlab warns of it since mujocolab/mjlab#339.
    """

    code = "LIM107"
    name = "saturation-below-limit"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare stall torque and limit."""
        looked = False
        for row in case.rows:
            stall, limit = row.stall_torque, row.effort_limit
            if stall is None or limit is None or case.artifacts[row.artifact].kind is FileKind.SPEC:
                continue
            looked = True
            if stall < limit < math.inf and not math.isclose(stall, limit, rel_tol=1e-3):
                yield Finding(
                    self.code,
                    f"the effort limit of {shown(row, 'effort_limit', limit)} is never reached: the torque-speed line "
                    f"begins at {shown(row, 'effort_limit', stall)}, at standstill",
                    row.place("stall_torque"),
                    row.joint,
                    stall,
                    unit(row, "effort_limit"),
                    help="the stall torque is the larger figure, the continuous limit the smaller one",
                    related=(row.place("effort_limit"),),
                )
        if not looked:
            yield Skipped(
                self.code, "no drive with both a torque-speed line and an effort limit among the files"
            )


class AboveDatasheet(Rule):
    """A file gives a joint more torque or speed than its motor has.

    ## What it does
    Compares limits with the motor's figures in the robot's spec: an effort limit above the motor's largest torque
    (peak, stall or curve), a torque-speed line that ends above its no-load speed, by `ratio` (default 1.1) or more.

    ## Why it matters
    The policy learns to use torque that the robot lacks. On the robot the drive cuts it off, and the motion that
    depended on it fails.

    ## Example
    ```yaml leg.yaml
    actspec: 1
    robot: {name: leg, model: leg.urdf}
    timing: {physics_dt: 5 ms}
    motors:
      knee: {side: joint, stall_torque: 33.5 N*m, no_load_speed: 21 rad/s, peak_torque: 33.5 N*m}
    actuators:
      knee: {joints: [knee_joint], motor: knee, level: dc_motor, kp: 25 N*m/rad, kd: 0.5 N*m*s/rad}
    ```
    ```xml leg.urdf
    <robot name="leg">
      <link name="base"/>
      <link name="shank"/>
      <joint name="knee_joint" type="revolute">
        <parent link="base"/>
        <child link="shank"/>
        <axis xyz="0 1 0"/>
        <limit lower="-2" upper="0" effort="100" velocity="21"/>
      </joint>
    </robot>
    ```

    ## Use instead
    ```xml leg.urdf
    <robot name="leg">
      <link name="base"/>
      <link name="shank"/>
      <joint name="knee_joint" type="revolute">
        <parent link="base"/>
        <child link="shank"/>
        <axis xyz="0 1 0"/>
        <limit lower="-2" upper="0" effort="33.5" velocity="21"/>
      </joint>
    </robot>
    ```

    ## Limits
    Placeholders (LIM102) are not judged again. A speed limit of the solver may be higher than the motor's.

    ## Source
    Chosen: 10 % covers rounding and efficiency. Reports: unitreerobotics/unitree_rl_lab#9 (300 N*m for a joint of
    139 N*m), NVlabs/GR00T-WholeBodyControl#259 (7.9 times).
    """

    code = "LIM108"
    name = "limit-above-datasheet"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    paired = True
    options: ClassVar[dict[str, float]] = {"ratio": 1.1}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare with the specs' motors."""
        ratio, looked = self.option(case, "ratio"), False
        for index, artifact in case.of_kind(FileKind.SPEC):
            assert artifact.spec is not None
            actuators = {actuator.joint: actuator for actuator in artifact.spec.joints}
            for spec in case.rows_of(index):
                torque, speed = _motor_torque(actuators[spec.joint]), actuators[spec.joint].no_load_speed
                for row in partner_rows(case, spec):
                    for field, motor, noun in (
                        ("effort_limit", torque, "torque"),
                        ("no_load_speed", speed, "no-load speed"),
                    ):
                        limit: float | None = getattr(row, field)
                        if motor is None or motor.value is None or limit is None or field not in row.stated:
                            continue
                        looked = True
                        if ratio * motor.value <= limit < _PLACEHOLDER:
                            yield self._finding(row, field, limit, motor, motor.value, noun, spec.span)
        if not looked:
            yield Skipped(
                self.code, "no spec with a motor's figures beside another file that limits the joint"
            )

    def _finding(
        self, row: LedgerRow, field: str, limit: float, motor: Quantity, most: float, noun: str, span: Span
    ) -> Finding:
        source = "" if motor.source is None else f" (source {motor.source})"
        return Finding(
            self.code,
            f"{shown(row, field, limit)} is {limit / most:.3g} times the {noun} of {shown(row, field, most)} that the "
            f"motor has by its spec{source}: the simulated robot can do what the real one cannot",
            row.place(field),
            row.joint,
            limit,
            unit(row, field),
            most,
            "set the limit to the motor's figure, or correct the spec",
            (motor.span or span,),
        )


_PLACEHOLDER = 1e5
"""Limits from here on are reported by LIM102."""


def _motor_torque(actuator: JointActuator) -> Quantity | None:
    """The largest torque that the motor is said to have."""
    curve = actuator.curve
    candidates = [actuator.peak_torque, actuator.stall_torque]
    candidates += [] if curve is None else [curve.drive_torque, curve.brake_torque]
    known = [(one.value, one) for one in candidates if one is not None and one.value is not None]
    return max(known, key=lambda pair: pair[0])[1] if known else None


RULES: tuple[type[Rule], ...] = (TwoClamps, LineBelowLimit, AboveDatasheet)
