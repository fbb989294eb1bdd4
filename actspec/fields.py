"""The figures of a joint: one row each, with name, words, unit and what they are.

Readers, rules, targets, verify, `diff` and the reports ask this table; nobody writes a second one. A figure has three
names: in readings, ledger and JSON (`Field.name`), in the IR (`Field.ir`, an attribute of `ir.JointActuator`) and in
the spec (`Field.spec`, also the name of its approximations).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from functools import cache
from types import MappingProxyType

from actspec.joints import JointKind
from actspec.units import Kind

PLACEHOLDER = 1e5
"""A limit from which on it is nobody's number [N*m, N, rad/s or m/s]. Chosen: far above every joint of a legged
machine; the placeholders in published files are 1e6 (the drive limit of Isaac Sim), 1e9 and 3.4e38."""


PLACEHOLDER_SPEED = 100.0
"""A speed limit from which on it is no evidence of what a joint does [rad/s or m/s]. Chosen: joints behind a gear reach
40 rad/s, direct drives 60; published placeholders are 100, 1000 and 10000, on every joint alike."""

PLACEHOLDER_SPEEDS = (1e3, 1e4)
"""Speed limits of a hinge that are nobody's number below `PLACEHOLDER` [rad/s]: as rpm they would be none of a joint
either."""

GRAVITY = 9.81
LONGEST_LEVER = 4.0
"""Effort limit over the weight of the robot that no robot has [m]. Published: 1.55 (Z1 arm), 0.9 (A2), 0.59 (H1)."""

FRICTION_SHARE = 0.5
"""Dry friction over the effort limit from which too little is left to drive the joint. Published: to 0.42, of a mobile
base."""
LARGEST_FACTOR = 10.0
"""Of a range of randomisation. Published: 3, on kd."""
STRONGER = 3.0
"""The same of what a motor gives. Published: 1.25; chosen: no batch of motors and batteries has twice the torque."""


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
        heading: Over a column, where that is not the noun.
        role: What it is.
        kind: Kind of quantity, which decides the unit at a hinge and at a slide; None: `fixed`.
        fixed: Unit that does not depend on the joint; "" without a unit.
        ir: Attribute or part in `ir.JointActuator`; "" where the IR has no such number.
        spec: Name in a spec and of its approximations; "" where the spec has no such key.
        summed: Whether it adds up over the actuators of a joint.
        optional: Whether a joint need not have such a thing: without it there is none, and it is not unknown.
        drawn: Place in the order of drawing, from 1; 0: a spec gives it no range of its own.
        fitted: Whether identification may give it.
    """

    name: str
    noun: str
    heading: str
    role: Role
    kind: Kind | None = None
    fixed: str = ""
    ir: str = ""
    spec: str = ""
    summed: bool = False
    optional: bool = False
    drawn: int = 0
    fitted: bool = False

    @property
    def title(self) -> str:
        """Over a column."""
        return self.heading or self.noun

    def unit(self, joint: JointKind | None) -> str:
        """SI unit at a joint; one of unknown kind is taken for a hinge, as nearly all are."""
        if self.kind is None:
            return self.fixed
        return unit_of_kind(self.kind, joint)


_TABLE = (
    Field(
        "kp", "stiffness kp", "kp", Role.DRIVE, Kind.STIFFNESS, "", "kp", "kp",
        summed=True, drawn=1, fitted=True,
    ),
    Field("command_gain", "command gain over kp", "", Role.COMMAND, spec="kp"),
    Field("gear", "gear", "", Role.COMMAND),
    Field("torque_per_control", "torque per control (gear x gain)", "", Role.COMMAND, Kind.TORQUE),
    Field(
        "kd", "drive gain kd", "kd", Role.DRIVE, Kind.VELOCITY_GAIN, "", "kd", "kd",
        summed=True, drawn=2, fitted=True,
    ),
    Field(
        "joint_damping", "joint damping", "", Role.PASSIVE, Kind.VELOCITY_GAIN, "",
        "friction_viscous", "friction.viscous", drawn=7, fitted=True,
    ),
    Field("actuator_damping", "actuator damping", "", Role.PASSIVE, Kind.VELOCITY_GAIN, summed=True),
    Field("back_emf", "back-EMF", "", Role.DRIVE, Kind.VELOCITY_GAIN, summed=True),
    Field("total_damping", "total damping", "", Role.TOTAL, Kind.VELOCITY_GAIN),
    Field(
        "frictionloss", "dry friction", "frictionloss", Role.PASSIVE, Kind.TORQUE, "",
        "friction_coulomb", "friction.coulomb", drawn=5, fitted=True,
    ),
    Field(
        "friction_static", "break-away friction", "", Role.PASSIVE, Kind.TORQUE, "",
        "friction_static", "friction.static", optional=True, drawn=6, fitted=True,
    ),
    Field(
        "stribeck_velocity", "Stribeck velocity", "", Role.PASSIVE, Kind.SPEED, "",
        "stribeck_velocity", "friction.stribeck_velocity", optional=True, drawn=8, fitted=True,
    ),
    Field("friction_setting", "friction as written", "", Role.PASSIVE),
    Field("dynamic_friction_setting", "dynamic friction as written", "", Role.PASSIVE),
    Field("spring", "joint stiffness", "", Role.PASSIVE, Kind.STIFFNESS, optional=True),
    Field(
        "effort_limit", "effort limit", "", Role.LIMIT, Kind.TORQUE, "", "effort_limit", "effort_limit", drawn=3
    ),
    Field("solver_effort_limit", "effort limit of the solver", "", Role.LIMIT, Kind.TORQUE),
    Field("velocity_limit", "velocity limit", "", Role.LIMIT, Kind.SPEED, "", "velocity_limit", "velocity_limit"),
    Field(
        "stall_torque", "stall torque", "", Role.LIMIT, Kind.TORQUE, "",
        "stall_torque", "torque_speed_curve", optional=True,
    ),
    Field(
        "no_load_speed", "no-load speed", "", Role.LIMIT, Kind.SPEED, "",
        "no_load_speed", "torque_speed_curve", optional=True,
    ),
    Field(
        "curve.drive_torque", "drive torque of the curve", "", Role.LIMIT, Kind.TORQUE, "",
        "curve.drive_torque", "torque_speed_curve", optional=True,
    ),
    Field(
        "curve.brake_torque", "brake torque of the curve", "", Role.LIMIT, Kind.TORQUE, "",
        "curve.brake_torque", "torque_speed_curve", optional=True,
    ),
    Field(
        "curve.knee_speed", "knee speed of the curve", "", Role.LIMIT, Kind.SPEED, "",
        "curve.knee_speed", "torque_speed_curve", optional=True,
    ),
    Field(
        "curve.no_load_speed", "no-load speed of the curve", "", Role.LIMIT, Kind.SPEED, "",
        "curve.no_load_speed", "torque_speed_curve", optional=True,
    ),
    Field("armature", "armature", "", Role.PASSIVE, Kind.INERTIA, "", "armature", "armature", drawn=4, fitted=True),
    Field("inertia_min", "least inertia of the links", "inertia min", Role.DERIVED, Kind.INERTIA),
    Field("inertia_max", "largest inertia of the links", "inertia max", Role.DERIVED, Kind.INERTIA),
    Field("inertia_free_min", "least free inertia", "free inertia min", Role.DERIVED, Kind.INERTIA),
    Field("inertia_free_max", "largest free inertia", "free inertia max", Role.DERIVED, Kind.INERTIA),
    Field("natural_frequency", "natural frequency", "", Role.DERIVED, None, "rad/s"),
    Field("damping_ratio", "damping ratio", "", Role.DERIVED),
    Field("stability", "h kd/I", "", Role.DERIVED),
    Field("delay", "delay", "", Role.COMMAND, Kind.TIME, "", "delay", "delay", drawn=10),
    Field("delay_nominal", "delay", "", Role.COMMAND, Kind.TIME, "", "delay", "delay"),
    Field("delay_low", "least delay", "", Role.COMMAND, Kind.TIME, "", "", "delay.range"),
    Field("delay_high", "largest delay", "", Role.COMMAND, Kind.TIME, "", "", "delay.range"),
    Field("delay_low_steps", "least delay", "", Role.COMMAND, None, "physics steps"),
    Field("delay_high_steps", "largest delay", "", Role.COMMAND, None, "physics steps"),
    Field(
        "filter_cutoff", "cutoff of the command filter", "", Role.COMMAND, Kind.FREQUENCY, "",
        "filter_cutoff", "command_filter",
    ),
    Field("command_low", "least command", "", Role.COMMAND, None, "", "command_range.low", "command_range"),
    Field("command_high", "largest command", "", Role.COMMAND, None, "", "command_range.high", "command_range"),
    Field("position_low", "lower position limit", "", Role.POSE, Kind.POSITION, optional=True),
    Field("position_high", "upper position limit", "", Role.POSE, Kind.POSITION, optional=True),
    Field(
        "encoder_bias", "encoder bias", "", Role.COMMAND, Kind.POSITION, "",
        "encoder_bias", "encoder_bias", drawn=9, fitted=True,
    ),
    Field("action_scale", "action scale", "", Role.COMMAND, Kind.POSITION, "", "action_scale", "action_scale"),
    Field(
        "default_position", "default position", "default pose", Role.POSE, Kind.POSITION, "",
        "default_position", "default_pose",
    ),
)  # fmt: skip


FIELDS: Mapping[str, Field] = MappingProxyType({field.name: field for field in _TABLE})
"""Name to field, in the order in which they are shown."""

BY_IR: Mapping[str, Field] = MappingProxyType({field.ir: field for field in _TABLE if field.ir})
"""Attribute of `ir.JointActuator` to its field."""

BY_SPEC: Mapping[str, Field] = MappingProxyType(
    {field.spec: field for field in reversed(_TABLE) if field.spec}
)
"""Name in a spec to its field, of several the first."""

FRICTION = tuple(
    sorted(
        (field for field in _TABLE if field.spec.startswith("friction.")),
        key=lambda field: (field.optional, field.spec),
    )
)
"""The parts of `friction` in a spec, those first that every joint has."""

COMMANDED: Mapping[str, Kind] = {"position": Kind.POSITION, "velocity": Kind.SPEED, "effort": Kind.TORQUE}
"""What each command is."""

DAMPING_PARTS = ("kd", "joint_damping", "actuator_damping")
"""Origins of damping: each has its own clamp and its own way of integration."""

LIMITS = frozenset(field.name for field in _TABLE if field.role is Role.LIMIT)
"""What bounds torque or speed: 0 and a placeholder are nobody's numbers there."""


def unit_of_kind(kind: Kind, joint: JointKind | None) -> str:
    """SI unit of a quantity kind at a joint; one of unknown kind is taken for a hinge."""
    return kind.linear_unit if joint is JointKind.SLIDE else kind.rotary_unit


@dataclass(frozen=True, slots=True)
class Units:
    """SI units of one kind of joint: `N*m` or `N`, `rad/s` or `m/s`, and so on."""

    torque: str
    speed: str
    position: str
    stiffness: str
    velocity_gain: str
    inertia: str


@cache
def units_of(joint: JointKind) -> Units:
    """The units of a hinge or a slide."""
    kinds = (Kind.TORQUE, Kind.SPEED, Kind.POSITION, Kind.STIFFNESS, Kind.VELOCITY_GAIN, Kind.INERTIA)
    return Units(*(unit_of_kind(kind, joint) for kind in kinds))


def unit_of(name: str, joint: JointKind | None, command: str = "") -> str:
    """SI unit of a field at a joint; "" for what has none.

    Args:
        name: Of the field.
        joint: The joint's kind; None: unknown.
        command: What its command is, a key of `COMMANDED`, whose unit the action scale has; "": unknown.
    """
    field = FIELDS.get(name)
    if field is None:
        return ""
    if name == "action_scale" and command:
        return unit_of_kind(COMMANDED[command], joint)
    return field.unit(joint)


def largest_factor(spec: str) -> float:
    """The largest factor that is drawn on a field, by its name in a spec."""
    return STRONGER if spec in ("strength", "effort_limit") else LARGEST_FACTOR


def is_power_of_ten(figure: float) -> bool:
    """Whether a figure above 0 is a power of ten, as those are that stand for none."""
    return math.log10(figure).is_integer()


def is_placeholder(limit: float) -> bool:
    """Whether a limit is nobody's number, because no motor reaches it."""
    return abs(limit) >= PLACEHOLDER and not is_of_a_machine(abs(limit))


def is_of_a_machine(effort: float) -> bool:
    """Whether an effort above every motor's may be a cylinder's at its lever [N*m or N], as 179800 N*m at a boom.

    Below a million, and three digits or more, which nobody types for none, but for nines.
    """
    nearest = float(f"{effort:.1e}")
    stated = not math.isclose(effort, nearest, rel_tol=1e-4)
    return PLACEHOLDER <= effort < 10.0 * PLACEHOLDER and stated
