"""What a spec proves: damping counted twice, friction in another unit, another kind of drive."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.dynamics import figure
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.source_rule import shown
from actspec.audit.rules.spec_pairs import NO_SPEC, SpecJoint, counted_twice, spec_joints, unit_confused
from actspec.diagnostics import Severity
from actspec.ir import Command, Level
from actspec.readings.artifact import FileKind


class DampingCountedTwice(Rule):
    """The file's joint damping comes on top of a kd that the spec means to be all.

    ## What it does
    Adds up the damping of a joint (the drives' kd, joint damping, damping at the actuators) and compares the sum with
    the spec's kd and viscous friction. Reports where the drive has the spec's kd and the passive part beyond the
    spec's friction is a tenth of it or more, or where the extra is the spec's kd once more.

    ## Why it matters
    kd was written twice: in the servo and in the joint. The joint is damped by the sum, no torque limit clamps the
    passive half, and a policy trained on it expects a leg that swings as through oil.

    ## Example
    ```yaml leg.yaml
    actspec: 1
    robot: {name: leg, model: none, joints: [knee_joint]}
    actuators:
      legs:
        joints: [knee_joint]
        level: ideal_pd
        kp: 25 N*m/rad
        kd: 2 N*m*s/rad
        effort_limit: 33.5 N*m
        friction: {viscous: 0.01 N*m*s/rad}
    ```
    ```xml leg.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="knee_joint" damping="2"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <position joint="knee_joint" kp="25" kv="2" forcerange="-33.5 33.5"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml leg.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="knee_joint" damping="0.01"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <position joint="knee_joint" kp="25" kv="2" forcerange="-33.5 33.5"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    A spec that leaves viscous friction unknown proves nothing about it.

    ## Source
    MuJoCo documentation: the passive force of a joint and the force of its actuators add up. Reports:
    LeCAR-Lab/dial-mpc#1, enactic/openarm_mujoco#75.
    """

    code = "DMP201"
    name = "damping-counted-twice-against-spec"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    paired = True
    options: ClassVar[dict[str, float]] = {"tolerance": 0.01}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare total damping with the spec's."""
        looked = False
        for joint in spec_joints(case):
            looked = True
            extra = counted_twice(joint, self.option(case, "tolerance"))
            if extra is None or joint.spec.total_damping is None:
                continue
            first, unit = joint.rows[0], figure(joint.rows, "kd").unit
            total = joint.spec.total_damping + extra
            passive = total - (figure(joint.rows, "kd").value or 0.0)
            yield Finding(
                self.code,
                f"damping is counted twice: the drive's kd is {shown(figure(joint.rows, 'kd').value, unit)} and the "
                f"joint's own damping {shown(passive, unit)}, together {shown(total, unit)}, and the spec says kd "
                f"{shown(joint.spec.kd, unit)} and viscous friction {shown(joint.spec.joint_damping, unit)} "
                f"(x{total / joint.spec.total_damping:.3g})",
                first.place("joint_damping"),
                first.joint,
                total,
                unit,
                expected=joint.spec.total_damping,
                help=f"leave {shown(joint.spec.joint_damping, unit)} in the joint's damping",
                related=(joint.spec.place("kd"), joint.spec.place("joint_damping")),
            )
        if not looked:
            yield Skipped(self.code, NO_SPEC)


class FrictionUnit(Rule):
    """The file's friction is the spec's in another unit.

    ## What it does
    Reports dry friction that differs from the spec's by what a unit explains: 1000 times (mN*m, or kN*m), kgf*cm,
    kgf*m; and the spec's torque in Isaac Lab's `friction` where the named version takes a coefficient.

    ## Why it matters
    Isaac Lab's field is called friction coefficient, and is one on Isaac Sim 4.5; from 5.0 it is N*m. The same number
    is another friction in each, and none of them complains.

    ## Example
    ```sh
    actspec audit leg.yaml leg_cfg.py --target isaaclab==2.3 --target isaac_sim==4.5
    ```
    ```yaml leg.yaml
    actspec: 1
    robot: {name: leg, model: none, joints: [knee_joint]}
    actuators:
      legs:
        joints: [knee_joint]
        level: ideal_pd
        kp: 150 N*m/rad
        kd: 4 N*m*s/rad
        effort_limit: 139 N*m
        friction: {coulomb: 0.2 N*m}
    ```
    ```python leg_cfg.py
    from isaaclab.actuators import IdealPDActuatorCfg
    from isaaclab.assets import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": IdealPDActuatorCfg(
                joint_names_expr=["knee_joint"], effort_limit=139.0, stiffness=150.0, damping=4.0, friction=0.2
            )
        }
    )
    ```

    ## Use instead
    ```python leg_cfg.py
    from isaaclab.actuators import IdealPDActuatorCfg
    from isaaclab.assets import ArticulationCfg

    # friction: a coefficient here, to be calibrated for 0.2 N*m
    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": IdealPDActuatorCfg(
                joint_names_expr=["knee_joint"], effort_limit=139.0, stiffness=150.0, damping=4.0
            )
        }
    )
    ```

    ## Limits
    A calibrated coefficient cannot be told from a torque that departs from the spec: where the version takes N*m,
    SPC103 reports it.

    ## Source
    Isaac Lab 2.3.2, `ActuatorBaseCfg.friction`, and isaac-sim/IsaacLab#3461, #7412; measured on 2.2 and 2.3.
    """

    code = "FRC201"
    name = "friction-unit-mismatch-against-spec"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    paired = True
    options: ClassVar[dict[str, float]] = {"tolerance": 0.01}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare dry friction with the spec's."""
        looked = False
        for joint in spec_joints(case):
            looked = True
            found = unit_confused(case, joint, self.option(case, "tolerance"))
            wanted = joint.wanted("frictionloss")
            if found is None or wanted is None:
                continue
            mine, told = found
            yield Finding(
                self.code,
                f"the dry friction {told}",
                mine.place,
                joint.rows[0].joint,
                mine.value,
                mine.unit or "1",
                expected=wanted.value if mine.unit else None,
                help=f"write {shown(wanted.value, wanted.unit)}"
                if mine.unit
                else f"leave it out and calibrate a coefficient for {shown(wanted.value, wanted.unit)}, or use Isaac "
                "Sim 5",
                related=(wanted.place,),
            )
        if not looked:
            yield Skipped(self.code, NO_SPEC)


class SpecControl(Rule):
    """A joint has another kind of drive than the spec.

    ## What it does
    Compares what an actuator's command means, and whether a network or a torque-speed line shapes its torque, with
    the spec's `command` and `level`. A configuration whose class has no line is a warning.

    ## Why it matters
    A velocity servo is no position servo, and a drive without the motor's line gives full torque at any speed.

    ## Example
    ```yaml leg.yaml
    actspec: 1
    robot: {name: leg, model: none, joints: [knee_joint]}
    actuators:
      legs:
        joints: [knee_joint]
        level: ideal_pd
        kp: 25 N*m/rad
        kd: 2 N*m*s/rad
        effort_limit: 33.5 N*m
    ```
    ```xml leg.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="knee_joint"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <velocity joint="knee_joint" kv="2" forcerange="-33.5 33.5"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml leg.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="knee_joint"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <position joint="knee_joint" kp="25" kv="2" forcerange="-33.5 33.5"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    A motor takes any torque: what the code does that drives it is not in the file. An MJCF for a MuJoCo before 3.12
    has no line to give, so none is asked of an MJCF.

    ## Source
    Chosen.
    """

    code = "SPC105"
    name = "control-departs-from-spec"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    paired = True

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare the kinds of drive."""
        looked = False
        for joint in spec_joints(case):
            looked = True
            told = _departs(joint)
            if told is None:
                continue
            message, severity = told
            first = joint.rows[0]
            yield Finding(
                self.code,
                message,
                first.span,
                first.joint,
                help="compile the file from the spec, or correct the spec",
                related=(joint.spec.span,),
                severity=severity,
            )
        if not looked:
            yield Skipped(self.code, NO_SPEC)


_POSITION = frozenset({"position", "implicit", "ideal_pd", "dc_motor", "pid"})
_WITHOUT_LINE = frozenset({"position", "pid", "implicit", "ideal_pd"})


def _departs(joint: SpecJoint) -> tuple[str, Severity] | None:
    """What is different, and how bad; None: nothing, or nobody can tell."""
    controls = {row.control for row in joint.rows}
    command, level = joint.actuator.command, joint.actuator.level
    kp = figure(joint.rows, "kp").value
    if command is Command.POSITION and controls == {"velocity"}:
        return "the drive is a velocity servo, and the spec's command is a position", Severity.ERROR
    if command is not Command.POSITION and controls & _POSITION and kp:
        return f"the drive holds a position, and the spec's command is {command.value}", Severity.ERROR
    if "network" in controls and level is not Level.ACTUATOR_NET:
        return f"the drive is a network, and the spec's level is {level.value}", Severity.ERROR
    if level is Level.ACTUATOR_NET and controls & (_POSITION | {"dcmotor"}) and kp:
        return "the drive is a PD, and the spec's level is actuator_net", Severity.ERROR
    line = joint.actuator.stall_torque is not None or joint.actuator.curve is not None
    if level is Level.DC_MOTOR and line and controls <= _WITHOUT_LINE and joint.kind is FileKind.CFG:
        return (
            "the drive has no torque-speed line, and the spec's level is dc_motor: it gives full torque at any speed",
            Severity.WARNING,
        )
    return None


RULES: tuple[type[Rule], ...] = (DampingCountedTwice, FrictionUnit, SpecControl)
