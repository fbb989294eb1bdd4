"""What one joint's actuator becomes in mjlab: a class, its fields, and what it cannot hold.

- ideal_pd: `BuiltinPositionActuatorCfg`, `BuiltinVelocityActuatorCfg` or `BuiltinMotorActuatorCfg`; exact.
- dc_motor: `DcMotorActuatorCfg`, whose clip is the law's, for every command: a velocity command has no
  stiffness, an effort command no gains at all. `BuiltinDcMotorActuatorCfg` is not used: the gains of its
  MuJoCo are in volts, and mjlab's randomisation of them inverts kd.
- actuator_net: `LearnedMlpActuatorCfg`.
Delays are steps of the simulation; there is no filter, no bias and no clamp of the command.
"""

from __future__ import annotations

from dataclasses import dataclass

from actspec.diagnostics import Collector
from actspec.ir import Command, JointActuator, Level
from actspec.robot.view import JointView
from actspec.simulators.mjlab import MjlabDialect
from actspec.targets.base import Approximation
from actspec.targets.mjlab.command_path import delay_fields, no_command_path
from actspec.targets.mjlab.context import Field, Joint
from actspec.targets.mjlab.drive import gain_fields, limit_fields, line_fields
from actspec.targets.mjlab.network import network_fields
from actspec.targets.mjlab.passive import passive_fields


@dataclass(frozen=True, slots=True)
class Cfg:
    """One joint's actuator in mjlab's words.

    Attributes:
        actuator: What it is of.
        kind: Class.
        fields: Without names of joints and delay.
        delay: `delay_*` fields; empty without.
        lost: What the class cannot hold.
        network: Name and bytes of its network file; None without one.
    """

    actuator: JointActuator
    kind: str
    fields: tuple[Field, ...]
    delay: tuple[Field, ...]
    lost: tuple[Approximation, ...]
    network: tuple[str, bytes] | None = None

    @property
    def explicit(self) -> bool:
        """Whether its torque is computed before the step; mjlab's default integrator takes a builtin one implicitly."""
        return not self.kind.startswith("Builtin")

    @property
    def key(self) -> tuple[object, ...]:
        """What joints that share one cfg have in common."""
        said = tuple((field.name, field.text) for field in (*self.fields, *self.delay))
        return (self.actuator.group, self.kind, said, self.network)


def cfg_of(
    actuator: JointActuator,
    joint: JointView | None,
    dialect: MjlabDialect,
    step: float,
    target: str,
    collector: Collector,
) -> Cfg | None:
    """Choose class and fields for one joint; None after an error.

    Args:
        actuator: What the spec asks for.
        joint: The robot's joint; None where the spec names no model.
        dialect: mjlab version that is written.
        step: Simulation step [s].
        target: Name of the target, for approximations.
        collector: Takes errors.
    """
    try:
        return _choose(Joint(actuator, joint, dialect, step, target, collector))
    except ValueError as err:
        # The law itself says which number it lacks, or that a delay is too long.
        collector.error("MJL001", str(err), where=f"actuators.{actuator.group}", span=actuator.span)
        return None


def _choose(joint: Joint) -> Cfg | None:
    actuator, law = joint.actuator, joint.law
    network: tuple[str, bytes] | None = None
    if joint.learned:
        found = network_fields(joint)
        if found is None:
            return None
        kind = "LearnedMlpActuatorCfg"
        more, network = found
        fields = [*line_fields(joint), *more]
    elif actuator.level is Level.DC_MOTOR:
        kind, fields = "DcMotorActuatorCfg", [*gain_fields(joint, always=True), *line_fields(joint)]
    elif actuator.command is Command.EFFORT:
        kind, fields = "BuiltinMotorActuatorCfg", limit_fields(joint, law.effort_limit, required=True)
    elif actuator.command is Command.VELOCITY and joint.dialect.velocity_unclamped:
        kind = "BuiltinVelocityActuatorCfg"
        fields = [*gain_fields(joint), *limit_fields(joint, law.effort_limit)]
    elif law.kp > 0.0:
        kind = "BuiltinPositionActuatorCfg"
        fields = [*gain_fields(joint), *limit_fields(joint, law.effort_limit)]
    else:
        # mjlab divides by the stiffness of a position actuator, and its older velocity one clamps the speed.
        kind = "IdealPdActuatorCfg"
        fields = [*gain_fields(joint, always=True), *limit_fields(joint, law.effort_limit)]
    fields += passive_fields(joint)
    delay = delay_fields(joint)
    no_command_path(joint)
    if joint.collector.failed:
        return None
    return Cfg(actuator, kind, tuple(fields), delay, tuple(joint.lost), network)
