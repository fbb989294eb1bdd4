"""What one joint's actuator becomes in mjlab: a class, its fields, and what it cannot hold.

- ideal_pd: `BuiltinPositionActuatorCfg`, `BuiltinVelocityActuatorCfg` or `BuiltinMotorActuatorCfg`; exact.
- dc_motor: `DcMotorActuatorCfg`, whose clip is the law's, for every command: a velocity command has no
  stiffness, an effort command no gains at all. `BuiltinDcMotorActuatorCfg` is not used: the gains of its
  MuJoCo are in volts, and mjlab's randomisation of them inverts kd.
- actuator_net: `LearnedMlpActuatorCfg`.
Delays are steps of the simulation; there is no filter, no bias and no clamp of the command.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from actspec.diagnostics import Collector
from actspec.fields import BY_IR
from actspec.ir import ActuatorSet, Command, JointActuator, Level, Quantity
from actspec.laws import delay_steps
from actspec.robot.view import JointView, ModelFormat, RobotView
from actspec.simulators import text_of
from actspec.simulators.mjlab import COMMON_FIELDS, MjlabDialect
from actspec.targets.base import Approximation
from actspec.targets.kit.joint import JointEmission, joint_by_joint
from actspec.targets.kit.network import NetworkWithManifest, read_networks
from actspec.targets.kit.python_text import origin_of, py, stated
from actspec.units import format_quantity

OF_A_JOINT = ("MJL001", "MJL002", "MJL003")
"""Errors that several joints of a group can have: said once, with their names."""


@dataclass(frozen=True, slots=True)
class JointCfg:
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
    fields: tuple[CfgField, ...]
    delay: tuple[CfgField, ...]
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
    view: JointView | None,
    dialect: MjlabDialect,
    step: float,
    target: str,
    collector: Collector,
    network: NetworkWithManifest | None,
) -> JointCfg | None:
    """Choose class and fields for one joint; None after an error.

    Args: as of `JointEmission`, and
        view: The robot's joint; None where the spec names no model.
        network: Of level actuator_net; None after an error.

    Raises: ValueError: the law lacks a number, or a delay is too long; it says which.
    """
    joint = JointEmission(actuator, dialect, step, target, collector)
    law = joint.law
    if joint.learned:
        if network is None:
            return None
        kind = "LearnedMlpActuatorCfg"
        fields = [*line_fields(joint), *network_fields(joint, network)]
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
    fields += passive_fields(joint, view)
    delay = delay_fields(joint)
    no_command_path(joint)
    if joint.collector.failed:
        return None
    file = None if network is None else (network.name, network.data)
    return JointCfg(actuator, kind, tuple(fields), delay, tuple(joint.lost), file)


def cfgs_of(
    actuators: ActuatorSet, robot: RobotView, dialect: MjlabDialect, target: str, collector: Collector
) -> list[JointCfg]:
    """What every joint's actuator becomes, in the robot's order; not all after an error.

    Args: as of `cfg_of`.
    """
    step, described = actuators.physics_dt.require(), robot.format is not ModelFormat.NONE
    networks = read_networks(actuators, "torchscript", collector)

    def cfg(actuator: JointActuator, own: Collector) -> JointCfg | None:
        view = robot.joint(actuator.joint) if described else None
        network = networks.get(actuator.network)
        return cfg_of(actuator, view, dialect, step, target, own, network)

    return joint_by_joint(actuators, cfg, OF_A_JOINT, collector)


@dataclass(frozen=True, slots=True)
class CfgField:
    """One field of a cfg.

    Attributes:
        name: Its name.
        text: Its value as Python.
        note: Unit and origin; "" without.
    """

    name: str
    text: str
    note: str = ""


def number(name: str, quantity: Quantity, what: str = "") -> CfgField:
    """A known number as a field, with unit and origin behind it.

    Args:
        name: Of the field.
        quantity: The number.
        what: What it is, where the name does not say.
    """
    about = [quantity.unit, *([what] if what else []), origin_of(quantity)]
    return CfgField(name, py(quantity.require()), ", ".join(about))


MjlabJoint = JointEmission[MjlabDialect]

NO_LINE = 1e9
"""Stall torque and no-load speed that leave only effort_limit [N*m, rad/s], where a class must have a line."""


def gain_fields(joint: MjlabJoint, *, always: bool = False) -> list[CfgField]:
    """Stiffness and damping, mjlab's names of kp and kd; `always`: 0 where the law has none."""
    found = []
    for name, quantity in (("stiffness", joint.actuator.kp), ("damping", joint.actuator.kd)):
        if quantity is not None and quantity.known:
            found.append(number(name, quantity))
        elif always:
            found.append(CfgField(name, "0.0"))
    return found


def limit_fields(joint: MjlabJoint, limit: float, *, required: bool = False) -> list[CfgField]:
    """`effort_limit`; left out where nobody knows it and the class takes that."""
    asked = joint.actuator.effort_limit
    if math.isfinite(limit):
        if asked.value == limit:
            return [number("effort_limit", asked)]
        return [CfgField("effort_limit", py(limit), f"{joint.unit}, the curve's")]
    if required:
        joint.collector.at(
            f"actuators.{joint.actuator.group}.effort_limit", asked.span or joint.actuator.span
        ).error(
            "MJL002",
            "effort_limit is unknown, and the class that mjlab has for it needs a number",
            "state effort_limit, or peak_torque of the motor",
        )
    return []


def line_fields(joint: MjlabJoint) -> list[CfgField]:
    """Limit and torque-speed line."""
    actuator, law = joint.actuator, joint.law
    if law.curve is not None:
        line = joint.drive_side("mjlab has one line for driving and braking")
        assert line.stall_torque is not None and line.no_load_speed is not None
        speed = f"{actuator.velocity_limit.unit}, no-load speed"
        through = f"{joint.unit}, of the line through the curve's knee"
        return [
            *limit_fields(joint, line.effort_limit),
            CfgField("saturation_effort", py(line.stall_torque), through),
            CfgField("velocity_limit", py(line.no_load_speed), speed),
        ]
    limit = limit_fields(joint, law.effort_limit, required=True)
    if law.stall_torque is None:
        why = "no torque-speed line: effort_limit alone"
        names = ("saturation_effort", "velocity_limit")
        return [*limit, *(CfgField(name, py(NO_LINE), why) for name in names)]
    assert actuator.stall_torque is not None and actuator.no_load_speed is not None
    return [
        *limit,
        number("saturation_effort", actuator.stall_torque, "at standstill"),
        number("velocity_limit", actuator.no_load_speed, "no-load speed"),
    ]


HELD = "10**9"
"""Steps between two draws of a lag: longer than any episode, so that it is drawn once after each reset."""


def delay_fields(joint: MjlabJoint) -> tuple[CfgField, ...]:
    """`delay_*`, in steps of the simulation."""
    delay = joint.actuator.delay
    if delay is None:
        return ()
    (low, late), (high, later) = (delay_steps(end, joint.step) for end in (delay.low, delay.high))
    origin = [origin_of(delay.nominal)] if delay.nominal.known else []
    losses: tuple[float, ...]
    if delay.low == delay.high:
        field, asked, losses = "delay", f"{delay.low * 1e3:g} ms", (late,)
        note = [asked, *origin]
    else:
        field, asked, losses = "delay.range", f"{delay.low * 1e3:g} to {delay.high * 1e3:g} ms", (late, later)
        note = [asked, f"drawn each {delay.sampling}", *origin]
    got = f"{low}" if low == high else f"{low} to {high}"
    if any(abs(loss) > 1e-9 for loss in losses):
        said = " and ".join(f"{abs(x) * 1e3:g} ms {'more' if x > 0 else 'less'}" for x in losses if x)
        joint.approximate(
            field,
            asked,
            f"{got} step{'' if got == '1' else 's'} of {joint.step * 1e3:g} ms",
            f"a delay is a whole number of steps; {said} than asked",
            joint.late,
        )
    if high == 0:
        return ()
    fields = [
        CfgField("delay_min_lag", py(low), f"steps of {joint.step * 1e3:g} ms: {', '.join(note)}"),
        CfgField("delay_max_lag", py(high)),
    ]
    if low != high and delay.sampling == "episode":
        fields += [
            CfgField("delay_update_period", HELD, "drawn at a reset, then held"),
            CfgField("delay_per_env_phase", "False"),
        ]
    return tuple(fields)


def no_command_path(joint: MjlabJoint) -> None:
    """Report filter, bias and clamp of the command as lost, where there are any."""
    bias = joint.law.encoder_bias
    joint.no_filter("mjlab's actuators have no filter on the command")
    joint.no_bias(
        f"mjlab's actuators have no bias; an event {joint.dialect.bias_event} with the range "
        f"({bias:g}, {bias:g}) sets it"
    )
    joint.no_range("mjlab's actuators do not clamp the command; its action term can (`clip`)")


def passive_fields(joint: MjlabJoint, view: JointView | None) -> list[CfgField]:
    """Armature and friction of the joint; what the spec does not state keeps the model's."""
    actuator = joint.actuator
    fields = []
    for name, quantity, own in (
        ("armature", actuator.armature, None if view is None else view.armature),
        ("frictionloss", actuator.friction_coulomb, None if view is None else view.frictionloss),
    ):
        if stated(quantity):
            fields.append(number(name, quantity))
        elif not joint.dialect.keeps_model and own:
            fields.append(CfgField(name, py(own), f"{quantity.unit}, the model's own, else it would be 0"))
    viscous = actuator.friction_viscous
    if stated(viscous):
        own_viscous = 0.0 if view is None else view.damping
        if joint.dialect.viscous_damping:
            fields.append(number("viscous_damping", viscous))
        elif view is None or viscous.require() != own_viscous:
            joint.no_viscous(
                f"mjlab {joint.dialect.text} has no viscous_damping ({text_of(COMMON_FIELDS)} and later have)",
                "the model's own" if view is None else format_quantity(own_viscous, viscous.unit),
                None if view is None else own_viscous,
            )
    joint.no_break_away(
        "the model's own",
        "frictionloss is one number for sticking and sliding",
        "MuJoCo has no Stribeck effect",
    )
    joint.no_velocity_limit("mjlab has no speed limit of a joint; its velocity_limit is the no-load speed")
    return fields


_OF_MODEL = {"armature": "armature", "friction_coulomb": "frictionloss", "friction_viscous": "damping"}
"""Attribute of `JointActuator` to that of a model's joint, which acts where mjlab is given no number."""


def own_passive(robot: RobotView, joint: str, name: str) -> str:
    """What acts of an armature or a friction that the spec says is unknown, in words.

    Args:
        robot: The robot.
        joint: Name of the joint.
        name: Attribute of `JointActuator`.
    """
    view, own = robot.joint(joint), _OF_MODEL[name]
    if robot.format is ModelFormat.NONE or view is None or own in view.unknown:
        return "the model's own"
    value = getattr(view, own)
    stands = "the model's own" if value or own in view.stated else "MuJoCo's default"
    return f"{format_quantity(value, BY_IR[name].unit(view.kind))}, {stands}"


def network_fields(joint: MjlabJoint, network: NetworkWithManifest) -> list[CfgField]:
    """Fields of the network."""
    actuator, step = joint.actuator, joint.step * 1e3
    # Told of a joint, so that one fault of several is one message.
    network = replace(network, place=replace(network.place, collector=joint.collector))
    manifest, taps = network.manifest, network.manifest.taps
    network.check_command(actuator.group, actuator.command, "MJL003", "mjlab's network takes position errors")
    if manifest.kind != "mlp":
        network.place.error(
            "MJL004",
            f"mjlab has no actuator class for a network of kind {manifest.kind}",
            "its LearnedMlpActuatorCfg takes an mlp; Isaac Lab has a class for an lstm",
        )
    if taps != tuple(range(len(taps))):
        network.place.error(
            "MJL005",
            f"mjlab gives a network the samples 0 to n - 1 in this order, got taps {list(taps)}",
            f"train on taps {list(range(len(taps)))}",
        )
    stride = network.stride(joint.step)
    if stride is not None and stride != 1 and len(taps) > 1:
        network.place.error(
            "MJL006",
            f"mjlab samples a network's history at every physics step, {step:g} ms, and its taps are "
            f"{stride * step:g} ms apart",
            f"train at {step:g} ms, or set timing.physics_dt to {stride * step:g} ms",
        )
    if manifest.initial_history != "first_sample" and len(taps) > 1:
        joint.approximate(
            "network.initial_history",
            manifest.initial_history,
            "first_sample",
            "mjlab fills a network's history with its first sample after a reset",
            joint.both_limits,
        )
    return [
        CfgField("network_file", f"str(FOLDER / {py(network.name)})"),
        CfgField("pos_scale", py(manifest.position_scale), "of target - measured"),
        CfgField("vel_scale", py(manifest.velocity_scale)),
        CfgField("torque_scale", py(manifest.torque_scale)),
        CfgField("input_order", py(network.input_order)),
        CfgField("history_length", py(len(taps)), f"every {step:g} ms"),
    ]
