"""SPC: figures of a file that depart from the robot's spec."""

from __future__ import annotations

from actspec.audit.case import Case
from actspec.audit.rule import Rule
from actspec.audit.rules.spec_pairs import SpecJoint, SpecRule, counted_twice, is_sum, unit_confused
from actspec.ir import Level


class SpecGain(SpecRule):
    """A file drives a joint with other gains than the spec.

    ## What it does
    Compares kp and kd that a file states with those of the spec. Several actuators of one joint count together; what
    an MJCF's servo leaves out is 0.

    ## Why it matters
    The spec is what was reviewed. A file with other gains is another controller, whatever was trained or identified
    with the spec's.

    ## Example
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
    ```
    ```yaml leg_deploy.yaml
    joint_names: [knee_joint]
    kp: [100]
    kd: [4]
    ```

    ## Use instead
    ```yaml leg_deploy.yaml
    joint_names: [knee_joint]
    kp: [150]
    kd: [4]
    ```

    ## Limits
    An actuator network has no gains. A kd that the model's damping repeats is for DMP201. A configuration that has no
    field for passive damping may add it to kd, as `actspec compile` does there.

    ## Source
    Chosen: equal within 1 %; what `actspec compile` writes agrees to all digits.
    """

    code = "SPC101"
    name = "gain-departs-from-spec"
    fields = ("kp", "kd")

    def is_told_elsewhere(self, case: Case, joint: SpecJoint, field: str, tolerance: float) -> bool:
        """A network, or damping counted twice."""
        if joint.actuator.level is Level.ACTUATOR_NET:
            return True
        return field == "kd" and (is_sum(joint, tolerance) or counted_twice(joint, tolerance) is not None)


class SpecLimit(SpecRule):
    """A file limits a joint otherwise than the spec.

    ## What it does
    Compares effort limit, velocity limit, and the ends of a torque-speed line (stall torque, no-load speed) that a
    file states with those of the spec. An MJCF's servo without a force range has no limit.

    ## Why it matters
    With more torque or speed than the spec the simulated joint does what the real one cannot; with less it never
    learns what the real one can.

    ## Example
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
    ```
    ```yaml leg_deploy.yaml
    joint_names: [knee_joint]
    kp: [150]
    kd: [4]
    effort_limit: [300]
    ```

    ## Use instead
    ```yaml leg_deploy.yaml
    joint_names: [knee_joint]
    kp: [150]
    kd: [4]
    effort_limit: [139]
    ```

    ## Limits
    Limits that a file leaves to others are not compared.

    ## Source
    Chosen: as SPC101.
    """

    code = "SPC102"
    name = "limit-departs-from-spec"
    fields = ("effort_limit", "velocity_limit", "stall_torque", "no_load_speed")


class SpecPassive(SpecRule):
    """A joint's armature or friction is not the spec's.

    ## What it does
    Compares armature, dry friction and passive damping that a file states with those of the spec. What an MJCF with
    servos leaves out is 0.

    ## Why it matters
    The same gains on another armature give another frequency and damping ratio; friction that is not the spec's is
    torque that the drive spends, or does not.

    ## Example
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
        armature: 0.01 kg*m^2
    ```
    ```xml leg.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="knee_joint" armature="0.03"/>
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
          <joint name="knee_joint" armature="0.01"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
    </mujoco>
    ```

    ## Limits
    Damping that repeats kd is for DMP201, friction in another unit for FRC201. Isaac Lab's `friction` is compared
    where the versions say that it is N*m.

    ## Source
    Chosen: as SPC101.
    """

    code = "SPC103"
    name = "armature-or-friction-departs-from-spec"
    fields = ("armature", "frictionloss", "joint_damping")

    def is_told_elsewhere(self, case: Case, joint: SpecJoint, field: str, tolerance: float) -> bool:
        """Damping counted twice, or a unit."""
        if field == "joint_damping":
            return counted_twice(joint, tolerance) is not None
        return field == "frictionloss" and unit_confused(case, joint, tolerance) is not None


class SpecCommand(SpecRule):
    """What happens to an action on its way to a joint is not what the spec says.

    ## What it does
    Compares delay, action scale and default position that a file states with those of the spec.

    ## Why it matters
    The command is default position + scale * action, some time later. A policy learns all three.

    ## Example
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
        action_scale: 0.5
    ```
    ```yaml leg_deploy.yaml
    joint_names: [knee_joint]
    kp: [150]
    action_scale: [0.25]
    ```

    ## Use instead
    ```yaml leg_deploy.yaml
    joint_names: [knee_joint]
    kp: [150]
    action_scale: [0.5]
    ```

    ## Limits
    A delay that is drawn from a range has no single figure, and is not compared.

    ## Source
    Chosen: equal within 1 %, or within 1e-3 s, rad or m.
    """

    code = "SPC104"
    name = "command-path-departs-from-spec"
    fields = ("delay", "action_scale", "default_position")
    absolute = 1e-3


RULES: tuple[type[Rule], ...] = (SpecGain, SpecLimit, SpecPassive, SpecCommand)
