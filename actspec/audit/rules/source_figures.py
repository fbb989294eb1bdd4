"""SRC: gains, armatures and friction on which files of one robot do not agree."""

from __future__ import annotations

import math
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence
from actspec.audit.rule import Rule
from actspec.audit.rules.source_pairs import Disagreement, unit_slip
from actspec.audit.rules.source_rule import SourceRule, shown
from actspec.diagnostics import Severity
from actspec.readings.artifact import FileKind


class Gain(SourceRule):
    """Files of one robot drive a joint with different gains.

    ## What it does
    Compares kp and kd: of a deploy file with the training configuration, of a training configuration with the drives
    of the robot's MJCF. Several actuators of one joint count together.

    ## Why it matters
    A policy's actions are positions, and kp makes torque of them: with 1.5 times kp the same action pushes 1.5 times
    as hard. Robots that shake on deployment often run with other gains than they were trained with.

    ## Example
    ```python leg_cfg.py
    from isaaclab.actuators import IdealPDActuatorCfg
    from isaaclab.assets import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": IdealPDActuatorCfg(
                joint_names_expr=["knee_joint"], effort_limit=139.0, stiffness=150.0, damping=4.0
            )
        }
    )
    ```
    ```yaml leg_deploy.yaml
    joint_names: [knee_joint]
    kp: [300]
    kd: [4]
    ```

    ## Use instead
    ```yaml leg_deploy.yaml
    joint_names: [knee_joint]
    kp: [150]
    kd: [4]
    ```

    ## Limits
    Gains that were retuned on the machine are a choice: set the finding aside with the reason. An MJCF with motors
    has no gains to compare.

    ## Source
    Reports: InternRobotics/OpenHomie#14 (150 and 100), google-deepmind/mujoco_playground#109. Chosen: equal within
    1 %.
    """

    code = "SRC103"
    name = "gain-disagrees"
    groups = (("kp",), ("kd",))
    lacks = "a gain of one joint"

    def consequence(self, case: Case, found: Disagreement) -> str:
        """What the joint does then."""
        ratio = found.ratio
        if ratio is None or ratio < 0.0:
            return "one of them has no such gain"
        if found.field == "kp":
            return (
                f"the same command error gives {ratio:.3g} times the torque, and the joint swings "
                f"{math.sqrt(ratio):.3g} times as fast"
            )
        return f"the drive brakes {ratio:.3g} times as hard at the same speed"

    def severity_of(self, case: Case, found: Disagreement) -> tuple[Severity, Confidence]:
        """What the policy trained with and what runs it should be one; an MJCF is often only where it is tried."""
        kinds = {case.artifacts[rows[0].artifact].kind for rows in (found.rows, found.others)}
        if kinds == {FileKind.CFG, FileKind.DEPLOY}:
            return Severity.WARNING, Confidence.HIGH
        return Severity.INFO, Confidence.MEDIUM


class Armature(SourceRule):
    """Files of one robot give a joint different armatures.

    ## What it does
    Compares the armatures that the files of one robot state. A file that states none is not compared: a
    configuration often supplies what the model leaves bare.

    ## Why it matters
    The armature is the rotor as the joint feels it, and in small joints most of the inertia. With another one the same
    gains give another frequency and another damping ratio, so a policy meets another robot.

    ## Example
    ```xml leg.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="knee" armature="0.01"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
    </mujoco>
    ```
    ```python leg_cfg.py
    from isaaclab.actuators import IdealPDActuatorCfg
    from isaaclab.assets import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": IdealPDActuatorCfg(
                joint_names_expr=["knee"], effort_limit=139.0, stiffness=150.0, damping=4.0, armature=0.03
            )
        }
    )
    ```

    ## Use instead
    ```python leg_cfg.py
    from isaaclab.actuators import IdealPDActuatorCfg
    from isaaclab.assets import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": IdealPDActuatorCfg(
                joint_names_expr=["knee"], effort_limit=139.0, stiffness=150.0, damping=4.0, armature=0.01
            )
        }
    )
    ```

    ## Limits
    As SRC101.

    ## Source
    Of eight published descriptions of one G1 knee, armatures run from 0.001 to 0.03 kg*m^2. Reports:
    unitreerobotics/unitree_rl_mjlab#51, isaac-sim/IsaacLab#5115. Chosen: equal within 5 %, because rotor inertias
    are seldom known better.
    """

    code = "SRC104"
    name = "armature-disagrees"
    options: ClassVar[dict[str, float]] = {"tolerance": 0.05}
    groups = (("armature",),)
    lacks = "an armature of one joint"

    def consequence(self, case: Case, found: Disagreement) -> str:
        """How much inertia."""
        assert found.mine.value is not None and found.theirs.value is not None
        change = shown(abs(found.mine.value - found.theirs.value), found.mine.unit)
        more = "more" if found.mine.value > found.theirs.value else "less"
        return f"every torque has {change} {more} to turn"


class Friction(SourceRule):
    """Files of one robot give a joint different friction.

    ## What it does
    Compares dry friction and passive joint damping that the files of one robot state. Isaac Lab's `friction` is
    compared where the versions say that it is N*m.

    ## Why it matters
    Friction that only one of them has is torque that the policy has not learnt to spend, or a joint that coasts where
    the real one stops.

    ## Example
    ```xml leg.urdf
    <robot name="leg">
      <link name="base"/>
      <link name="shank"/>
      <joint name="knee" type="revolute">
        <parent link="base"/>
        <child link="shank"/>
        <axis xyz="0 1 0"/>
        <limit lower="-2" upper="0" effort="139" velocity="20"/>
        <dynamics friction="0.2"/>
      </joint>
    </robot>
    ```
    ```xml leg.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="knee" frictionloss="1"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
    </mujoco>
    ```

    ## Use instead
    ```xml leg.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="knee" frictionloss="0.2"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
    </mujoco>
    ```

    ## Limits
    As SRC101. The damping of a URDF is for DMP106, and its friction of 0 is what exporters write: it is not compared.

    ## Source
    isaac-sim/IsaacLab#1325, leggedrobotics/pace-sim2real#14. Chosen: equal within 1 %.
    """

    code = "SRC105"
    name = "friction-disagrees"
    groups = (("frictionloss",), ("joint_damping",))
    lacks = "a friction of one joint"

    def is_explained(self, case: Case, found: Disagreement, tolerance: float) -> bool:
        """What DMP106 reports, what an exporter writes, and degrees."""
        for rows, figure in ((found.rows, found.mine), (found.others, found.theirs)):
            urdf = case.artifacts[rows[0].artifact].kind is FileKind.URDF
            if urdf and (found.field == "joint_damping" or not figure.value):
                return True
        return found.field == "joint_damping" and unit_slip(found.ratio, tolerance)

    def consequence(self, case: Case, found: Disagreement) -> str:
        """How much torque."""
        assert found.mine.value is not None and found.theirs.value is not None
        change = abs(found.mine.value - found.theirs.value)
        more = "more" if found.mine.value > found.theirs.value else "less"
        if found.field == "frictionloss":
            return f"the joint resists with {shown(change, found.mine.unit)} {more} here"
        force = found.mine.unit.partition("*s/")[0]
        speed = "1 m/s" if force == "N" else "10 rad/s"
        amount = change * (1.0 if force == "N" else 10.0)
        return f"at {speed} the joint resists with {shown(amount, force)} {more} here"


RULES: tuple[type[Rule], ...] = (Gain, Armature, Friction)
