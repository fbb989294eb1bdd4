"""What one joint becomes in Newton: the attributes of its prim, a NewtonActuator, and what they cannot hold.

- position: `NewtonPDControlAPI`, the command is `control.joint_target_q`;
- velocity: the same without kp, the command is `control.joint_target_qd`;
- effort: the same without gains, the command is `control.joint_act`;
- actuator_net: `NewtonNeuralControlAPI`.
The clamp is `NewtonDCMotorClampingAPI`, whose formula is the law's, or `NewtonMaxEffortClampingAPI`.
"""

from __future__ import annotations

from dataclasses import dataclass

from actspec.diagnostics import Collector
from actspec.ir import JointActuator
from actspec.simulators.newton import NewtonDialect
from actspec.targets.base import Approximation
from actspec.targets.newton.command_path import delay_attributes, no_command_path
from actspec.targets.newton.context import Joint
from actspec.targets.newton.drive import clamps, gain_attributes
from actspec.targets.newton.network import network_attributes
from actspec.targets.newton.passive import joint_prim
from actspec.targets.newton.usda import Attribute

Schemas = tuple[tuple[str, ...], tuple[Attribute, ...]]
"""API schemas of a prim, and its attributes."""


@dataclass(frozen=True, slots=True)
class Driven:
    """One joint in Newton's words.

    Attributes:
        actuator: What it is of.
        joint: What its own prim gets.
        drive: What the NewtonActuator has, other than its target.
        lost: What they cannot hold.
        network: Name and bytes of its network file; None without one.
    """

    actuator: JointActuator
    joint: Schemas
    drive: Schemas
    lost: tuple[Approximation, ...]
    network: tuple[str, bytes] | None


def driven(
    actuator: JointActuator, dialect: NewtonDialect, step: float, target: str, collector: Collector
) -> Driven | None:
    """Choose schemas and attributes for one joint; None after an error.

    Args:
        actuator: What the spec asks for.
        dialect: Newton version that is written.
        step: Physics step [s].
        target: Name of the target, for approximations.
        collector: Takes errors.
    """
    try:
        return _choose(Joint(actuator, dialect, step, target, collector))
    except ValueError as err:
        # The law itself says which number it lacks, or that a delay is too long.
        collector.error("NWT001", str(err), where=f"actuators.{actuator.group}", span=actuator.span)
        return None


def _choose(joint: Joint) -> Driven | None:
    network = None
    if joint.learned:
        found = network_attributes(joint)
        if found is None:
            return None
        control, (attributes, network) = "NewtonNeuralControlAPI", found
    else:
        control, attributes = "NewtonPDControlAPI", gain_attributes(joint)
    clamping, limits = clamps(joint)
    delay = delay_attributes(joint)
    apis = (control, *clamping, *(["NewtonActuatorDelayAPI"] if delay else []))
    own, about = joint_prim(joint)
    no_command_path(joint)
    return Driven(
        joint.actuator,
        (own, tuple(about)),
        (apis, (*attributes, *limits, *delay)),
        tuple(joint.lost),
        network,
    )
