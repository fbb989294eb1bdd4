"""The figures of a joint: one row each, with name, words, unit and what they are.

Readers, rules, targets, verify, `diff` and the reports ask this table; nobody writes a second one. A figure has three
names: in readings, ledger and JSON (`Field.name`), in the IR (`Field.ir`, an attribute of `ir.JointActuator`) and in
the spec (`Field.spec`, also the name of its approximations).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType

from actspec.joints import JointKind
from actspec.units import Kind

PLACEHOLDER = 1e5
"""A limit from which on it is nobody's number [N*m, N, rad/s or m/s]. Chosen: far above every joint of a legged
machine; the placeholders in published files are 1e6 (the drive limit of Isaac Sim), 1e9 and 3.4e38."""


class Role(Enum):
    """What a figure is, which decides who may state it and with what it is compared."""

    DRIVE = "drive"
    """Of the active drive: only whoever drives the joint states it."""
    LIMIT = "limit"
    """A bound of torque or speed: the least of several counts."""
    PASSIVE = "passive"
    """Acts on the joint whoever drives it, outside every clamp."""
    COMMAND = "command"
    """Between the policy and the drive: delay, filter, clamp, bias, scale."""
    POSE = "pose"
    """Positions of the joint itself."""
    TOTAL = "total"
    """The sum of figures of other origins; nobody states it."""
    DERIVED = "derived"
    """Follows from the others and the links; nobody states it."""


@dataclass(frozen=True, slots=True)
class Field:
    """One figure of a joint.

    Attributes:
        name: In readings, ledger and JSON.
        noun: In a sentence: `the dry friction`.
        title: Over a column.
        role: What it is.
        kind: Kind of quantity, which decides the unit at a hinge and at a slide; None: `fixed`.
        fixed: Unit that does not depend on the joint; "" without a unit.
        ir: Attribute or part in `ir.JointActuator`; "" where the IR has no such number.
        spec: Name in a spec and of its approximations; "" where the spec has no such key.
        summed: Whether it adds up over the actuators of a joint.
    """

    name: str
    noun: str
    title: str
    role: Role
    kind: Kind | None = None
    fixed: str = ""
    ir: str = ""
    spec: str = ""
    summed: bool = False

    def unit(self, joint: JointKind | None) -> str:
        """SI unit at a joint; one of unknown kind is taken for a hinge, as nearly all are."""
        if self.kind is None:
            return self.fixed
        return self.kind.linear_unit if joint is JointKind.SLIDE else self.kind.rotary_unit


def _drive(
    name: str, noun: str, title: str, kind: Kind, ir: str = "", spec: str = "", summed: bool = False
) -> Field:
    return Field(name, noun, title, Role.DRIVE, kind, "", ir, spec, summed)


def _limit(name: str, noun: str, kind: Kind, ir: str = "", spec: str = "") -> Field:
    return Field(name, noun, noun, Role.LIMIT, kind, "", ir, spec)


def _passive(
    name: str, noun: str, title: str, kind: Kind, ir: str = "", spec: str = "", summed: bool = False
) -> Field:
    return Field(name, noun, title, Role.PASSIVE, kind, "", ir, spec, summed)


def _command(name: str, noun: str, kind: Kind | None, fixed: str, ir: str, spec: str) -> Field:
    return Field(name, noun, noun, Role.COMMAND, kind, fixed, ir, spec)


def _pose(name: str, noun: str, title: str, ir: str, spec: str) -> Field:
    return Field(name, noun, title, Role.POSE, Kind.POSITION, "", ir, spec)


def _derived(name: str, noun: str, title: str, kind: Kind | None, fixed: str = "") -> Field:
    return Field(name, noun, title, Role.DERIVED, kind, fixed)


_TABLE = (
    _drive("kp", "stiffness kp", "kp", Kind.STIFFNESS, "kp", "kp", summed=True),
    _drive("kd", "drive gain kd", "kd", Kind.VELOCITY_GAIN, "kd", "kd", summed=True),
    _passive(
        "joint_damping",
        "joint damping",
        "joint damping",
        Kind.VELOCITY_GAIN,
        "friction_viscous",
        "friction.viscous",
    ),
    _passive("actuator_damping", "actuator damping", "actuator damping", Kind.VELOCITY_GAIN, summed=True),
    _drive("back_emf", "back-EMF", "back-EMF", Kind.VELOCITY_GAIN, summed=True),
    Field("total_damping", "total damping", "total damping", Role.TOTAL, Kind.VELOCITY_GAIN),
    _passive(
        "frictionloss", "dry friction", "frictionloss", Kind.TORQUE, "friction_coulomb", "friction.coulomb"
    ),
    _passive(
        "friction_static",
        "break-away friction",
        "break-away friction",
        Kind.TORQUE,
        "friction_static",
        "friction.static",
    ),
    _passive(
        "stribeck_velocity",
        "Stribeck velocity",
        "Stribeck velocity",
        Kind.SPEED,
        "stribeck_velocity",
        "friction.stribeck_velocity",
    ),
    Field("friction_setting", "friction as written", "friction as written", Role.PASSIVE),
    Field(
        "dynamic_friction_setting", "dynamic friction as written", "dynamic friction as written", Role.PASSIVE
    ),
    _passive("spring", "joint stiffness", "joint stiffness", Kind.STIFFNESS),
    _limit("effort_limit", "effort limit", Kind.TORQUE, "effort_limit", "effort_limit"),
    _limit("solver_effort_limit", "effort limit of the solver", Kind.TORQUE),
    _limit("velocity_limit", "velocity limit", Kind.SPEED, "velocity_limit", "velocity_limit"),
    _limit("stall_torque", "stall torque", Kind.TORQUE, "stall_torque", "torque_speed_curve"),
    _limit("no_load_speed", "no-load speed", Kind.SPEED, "no_load_speed", "torque_speed_curve"),
    _limit(
        "curve.drive_torque",
        "drive torque of the curve",
        Kind.TORQUE,
        "curve.drive_torque",
        "torque_speed_curve",
    ),
    _limit(
        "curve.brake_torque",
        "brake torque of the curve",
        Kind.TORQUE,
        "curve.brake_torque",
        "torque_speed_curve",
    ),
    _limit(
        "curve.knee_speed", "knee speed of the curve", Kind.SPEED, "curve.knee_speed", "torque_speed_curve"
    ),
    _passive("armature", "armature", "armature", Kind.INERTIA, "armature", "armature"),
    _derived("inertia_min", "least inertia of the links", "inertia min", Kind.INERTIA),
    _derived("inertia_max", "largest inertia of the links", "inertia max", Kind.INERTIA),
    _derived("inertia_free_min", "least free inertia", "free inertia min", Kind.INERTIA),
    _derived("natural_frequency", "natural frequency", "natural frequency", None, "rad/s"),
    _derived("damping_ratio", "damping ratio", "damping ratio", None),
    _derived("stability", "h kd/I", "h kd/I", None),
    _command("delay", "delay", None, "s", "delay", "delay"),
    _command("delay_nominal", "delay", None, "s", "delay", "delay"),
    _command("delay_low", "least delay", None, "s", "", "delay.range"),
    _command("delay_high", "largest delay", None, "s", "", "delay.range"),
    _command("filter_cutoff", "cutoff of the command filter", None, "Hz", "filter_cutoff", "command_filter"),
    _command("command_low", "least command", None, "", "command_range.low", "command_range"),
    _command("command_high", "largest command", None, "", "command_range.high", "command_range"),
    _pose("position_low", "lower position limit", "lower position limit", "", ""),
    _pose("position_high", "upper position limit", "upper position limit", "", ""),
    _command("encoder_bias", "encoder bias", Kind.POSITION, "", "encoder_bias", "encoder_bias"),
    _command("action_scale", "action scale", Kind.POSITION, "", "action_scale", "action_scale"),
    _pose("default_position", "default position", "default pose", "default_position", "default_pose"),
)

FIELDS: Mapping[str, Field] = MappingProxyType({field.name: field for field in _TABLE})
"""Name to field, in the order in which they are shown."""

BY_IR: Mapping[str, Field] = MappingProxyType({field.ir: field for field in _TABLE if field.ir})
"""Attribute of `ir.JointActuator` to its field."""

DAMPING_PARTS = ("kd", "joint_damping", "actuator_damping")
"""Origins of damping: each has its own clamp and its own way of integration."""

LIMITS = frozenset(field.name for field in _TABLE if field.role is Role.LIMIT)
"""What bounds torque or speed: 0 and a placeholder are nobody's numbers there."""


def unit_of(name: str, joint: JointKind | None) -> str:
    """SI unit of a field at a joint; "" for what has none."""
    field = FIELDS.get(name)
    return "" if field is None else field.unit(joint)


def is_placeholder(limit: float) -> bool:
    """Whether a limit is nobody's number, because no motor reaches it."""
    return abs(limit) >= PLACEHOLDER
