"""The spec language as pydantic models: what a spec may say, each field with its unit.

The docstring under a field says its unit and goes into the JSON Schema (`descriptions`). Figures are
parsed to SI here (`SpecValue`); patterns, references between sections and defaults are resolved later.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag, WithJsonSchema

from actspec.spec.fields import (
    CommandRange,
    CommandRangeField,
    DelayField,
    EffortField,
    Gain,
    GainField,
    SpecDelay,
)
from actspec.spec.gears import Linkage, Stages
from actspec.spec.values import (
    Efficiency,
    Factor,
    Inertia,
    Name,
    Number,
    Pair,
    Ratio,
    SpecValue,
    Strict,
    fault,
    short,
)
from actspec.units import Kind

SPEC_VERSION = 1
"""The number that `actspec:` carries in this version of the tool."""


def _text_version(given: Any) -> Any:
    if isinstance(given, (int, float)) and not isinstance(given, bool):
        raise fault(
            f"a version is text, got the number {given}",
            'put it in quotes, as in "3.10": without them 3.10 reads as 3.1',
        )
    return given


def _shape(given: Any) -> str:
    """Which part of a union a value is meant for."""
    return "mapping" if isinstance(given, dict) else "word"


def _filter_word(given: Any) -> Any:
    if given not in FILTER_WORDS:
        words = f"must be {{cutoff: ...}}, {' or '.join(f'`{word}`' for word in FILTER_WORDS)}"
        raise fault(f"{words}, got {short(given)}", "write for instance `{cutoff: 30 Hz}`")
    return given


def _text_or_number(given: Any) -> Any:
    return str(given) if isinstance(given, int) and not isinstance(given, bool) else given


FILTER_WORDS = ("from_motor", "none")

Version = Annotated[str, BeforeValidator(_text_version)]
Page = Annotated[str, BeforeValidator(_text_or_number), WithJsonSchema({"type": ["string", "integer"]})]

NameOrGap = Annotated[str | None, WithJsonSchema({"anyOf": [{"type": "string"}, {"const": None}]})]
GAPPED = "joint_order"
"""The list whose entries may be null; everywhere else that is a value which was forgotten."""

Torque = Annotated[SpecValue, Number(Kind.TORQUE, above=0.0)]
Speed = Annotated[SpecValue, Number(Kind.SPEED, above=0.0)]
FittedInertia = Annotated[SpecValue, Number(Kind.INERTIA, at_least=0.0, identified=True)]
FrictionTorque = Annotated[SpecValue, Number(Kind.TORQUE, at_least=0.0, identified=True)]
Viscous = Annotated[SpecValue, Number(Kind.VELOCITY_GAIN, at_least=0.0, identified=True)]
FittedAngle = Annotated[SpecValue, Number(Kind.POSITION, identified=True)]
FittedSpeed = Annotated[SpecValue, Number(Kind.SPEED, above=0.0, identified=True)]
PositiveTime = Annotated[SpecValue, Number(Kind.TIME, above=0.0)]
Frequency = Annotated[SpecValue, Number(Kind.FREQUENCY, above=0.0)]
Cutoff = Annotated[SpecValue, Number(Kind.FREQUENCY, above=0.0, identified=True)]
Kp = Annotated[
    Gain,
    GainField(
        Number(Kind.STIFFNESS, at_least=0.0, identified=True), ("torque_at_error", "natural_frequency")
    ),
]
Kd = Annotated[Gain, GainField(Number(Kind.VELOCITY_GAIN, at_least=0.0, identified=True), ("damping_ratio",))]


EffortLimit = Annotated[SpecValue | Literal["continuous", "peak"], EffortField()]
Delay = Annotated[SpecDelay, DelayField()]


class Source(Strict):
    """Where numbers come from."""

    title: Name
    """Title of the document, repository or measurement."""
    url: str | None = None
    """Address."""
    page: Page | None = None
    """Page, table, or path inside a repository."""
    commit: str | None = None
    """Commit of a repository."""
    accessed: str | None = None
    """Day on which it was read, such as 2026-10-02."""
    note: str | None = None
    """Remark."""


class ListedJoint(Strict):
    """A joint of a robot that has no model file."""

    name: Name
    """Name of the joint."""
    kind: Literal["hinge", "slide"] = "hinge"
    """Kind of the joint."""
    range: Annotated[Any, Pair(Kind.POSITION, apart=True)] = None
    """Position range, [low, high] [rad or m]."""


OneJoint = Annotated[
    Annotated[ListedJoint, Tag("mapping")] | Annotated[Name, Tag("word")], Discriminator(_shape)
]


class Robot(Strict):
    """The robot that the spec is for."""

    name: Name
    """Name of the robot; output folders and constants are named after it."""
    model: str
    """MJCF or URDF, relative to the spec's folder; or `package://DISTRIBUTION/path`; or `none`."""
    packages: dict[str, str] = Field(default_factory=dict)
    """ROS package to its folder, relative to the spec's: of meshes that a URDF names by `package://NAME/path`."""
    joints: tuple[OneJoint, ...] = ()
    """Joints in the robot's order, only with `model: none`."""
    unmanaged: tuple[str, ...] = ()
    """Patterns of joints that are left as they are."""
    default_pose: dict[str, Annotated[SpecValue, Number(Kind.POSITION)]] = Field(default_factory=dict)
    """Pattern to default position [rad or m]; the others are at 0."""


class Timing(Strict):
    """Rates of simulation and control."""

    physics_dt: PositiveTime | None = None
    """Simulation step [s]. Default: the model's own."""
    decimation: Annotated[int, Field(ge=1, le=10000, strict=True)] | None = None
    """Physics steps in one control step."""
    control_dt: PositiveTime | None = None
    """Time from one action to the next, in place of decimation [s]."""


class Curve(Strict):
    """Asymmetric torque-speed curve, on the motor's `side`."""

    drive_torque: Torque
    """Torque while torque and speed have the same sign [N*m or N]."""
    brake_torque: Torque
    """Torque while they have opposite signs [N*m or N]."""
    knee_speed: Annotated[SpecValue, Number(Kind.SPEED, at_least=0.0)]
    """Speed up to which the full torque is available [rad/s or m/s]."""
    no_load_speed: Speed
    """Speed at which no torque is left [rad/s or m/s]."""


class Motor(Strict):
    """A motor with its gearbox, as a datasheet gives it."""

    side: Literal["joint", "motor"] | None = None
    """Where torque, speed and torque constant are quoted: at the gearbox output (`joint`) or at the
    rotor (`motor`, which needs `gear_ratio`). Required as soon as one of them is given."""
    stall_torque: Torque | None = None
    """Torque-speed line at zero speed [N*m or N]."""
    no_load_speed: Speed | None = None
    """Torque-speed line at zero torque [rad/s or m/s]."""
    peak_torque: Torque | None = None
    """Limit of the drive, for a short time [N*m or N]."""
    continuous_torque: Torque | None = None
    """Thermal limit [N*m or N]."""
    curve: Curve | None = None
    """Asymmetric curve in place of the line."""
    gear_ratio: Ratio | None = None
    """Rotor turns in one output turn [-]."""
    gearbox: Stages | None = None
    """Stages of the gearbox from rotor to output, in place of `gear_ratio` and `efficiency`."""
    efficiency: Efficiency | None = None
    """Of the gearbox, 0 to 1 [-]; scales motor-side torques. Default 1."""
    torque_constant: Annotated[SpecValue, Number(Kind.TORQUE_CONSTANT, above=0.0)] | None = None
    """Torque per current [N*m/A or N/A], on the motor's `side`."""
    nominal_voltage: Annotated[SpecValue, Number(Kind.VOLTAGE, above=0.0)] | None = None
    """Supply for which stall torque and no-load speed hold [V]."""
    nominal_current: Annotated[SpecValue, Number(Kind.CURRENT, above=0.0)] | None = None
    """Continuous current [A]; with `torque_constant` it gives the continuous torque."""
    peak_current: Annotated[SpecValue, Number(Kind.CURRENT, above=0.0)] | None = None
    """Peak current [A]; with `torque_constant` it gives the peak torque."""
    rotor_inertia: Inertia | None = None
    """At the rotor, whatever `side` says [kg*m^2]."""
    reflected_inertia: Inertia | None = None
    """At the gearbox output, in place of `rotor_inertia` [kg*m^2 or kg]."""
    bandwidth: Frequency | None = None
    """Of the torque or current loop [Hz]; used only by `command_filter: from_motor`."""
    note: str | None = None
    """Remark."""


class Friction(Strict):
    """Passive friction at the joint, outside every clamp."""

    coulomb: FrictionTorque | None = None
    """Kinetic dry friction [N*m or N]."""
    viscous: Viscous | None = None
    """Passive viscous friction [N*m*s/rad or N*s/m]; never the drive's kd."""
    static: FrictionTorque | None = None
    """Break-away friction [N*m or N]. Default: equal to coulomb."""
    stribeck_velocity: FittedSpeed | None = None
    """Speed over which static falls to coulomb [rad/s or m/s]."""


class CommandFilter(Strict):
    """First-order low-pass on the command."""

    cutoff: Cutoff
    """-3 dB frequency [Hz]."""


FilterOrWord = Annotated[
    Annotated[CommandFilter, Tag("mapping")]
    | Annotated[Literal["from_motor", "none"], BeforeValidator(_filter_word), Tag("word")],
    Discriminator(_shape),
]


class NetworkFile(Strict):
    """Actuator network, level actuator_net."""

    manifest: str | None = None
    """Its manifest, relative to the spec's folder: files, inputs, scales, order, period."""
    file: str | None = None
    """The network itself, relative to the spec's folder, for every target; default: those that the manifest names,
    each target the one that it reads."""


Ends = Annotated[list[Any], Field(min_length=2, max_length=2)]


class Randomize(Strict):
    """One domain-randomisation range: exactly one of scale, add and abs, or `from: identified`."""

    scale: Annotated[Any, Pair(Kind.RATIO, ordered=False)] = None
    """Factor on the nominal value, [low, high] [-]."""
    add: Ends | None = None
    """Offset on the nominal value, [low, high] [unit of the field]."""
    abs: Ends | None = None
    """Replacement of the nominal value, [low, high] [unit of the field]."""
    from_: Literal["identified"] | None = Field(default=None, alias="from")
    """Take the range from the identification's standard deviation."""
    sigma: Factor | None = None
    """With `from: identified`: half-width in standard deviations [-]. Default 1."""
    distribution: Literal["uniform", "log_uniform", "gaussian"] = "uniform"
    """For `gaussian` the pair is (mean, standard deviation)."""
    when: Literal["startup", "reset", "interval"] = "reset"
    """When a new value is drawn."""
    every: Annotated[Any, Pair(Kind.TIME, at_least=0.0)] = None
    """With `when: interval`: time between draws, [low, high] [s]."""
    per: Literal["joint", "group", "env"] = "joint"
    """What shares one draw."""


RandomizedField = Literal[
    "kp",
    "kd",
    "gains",
    "strength",
    "effort_limit",
    "armature",
    "friction.coulomb",
    "friction.viscous",
    "friction.static",
    "friction.stribeck_velocity",
    "encoder_bias",
    "delay",
]


class Tunable(Strict):
    """Fields that a group states and that an override may state anew for some of its joints."""

    motor: Name | None = None
    """Key of `motors`."""
    reduction: Factor | None = None
    """Extra reduction from the motor's output to the joint [-]. Default 1."""
    transmission: Stages | None = None
    """Stages from the motor's output to the joint, in place of `reduction`."""
    motors_per_joint: Annotated[int, Field(ge=1, le=100, strict=True)] | None = None
    """Motors that drive the joint in parallel [-]. Default 1."""
    kp: Kp | None = None
    """Drive stiffness [N*m/rad or N/m]."""
    kd: Kd | None = None
    """Drive velocity gain [N*m*s/rad or N*s/m]."""
    effort_limit: EffortLimit | None = None
    """Clamp of the drive's torque [N*m or N], or `continuous` or `peak` of the motor."""
    velocity_limit: Speed | None = None
    """The joint's or solver's speed limit [rad/s or m/s]; another thing than `no_load_speed`."""
    armature: FittedInertia | None = None
    """Inertia added to the joint [kg*m^2 or kg]. Default: from rotor inertia and gears."""
    friction: Friction | None = None
    """Passive friction at the joint, outside every clamp."""
    command_filter: FilterOrWord | None = None
    """Low-pass on the command: {cutoff: 30 Hz}, `from_motor` (its bandwidth) or `none`."""
    command_range: Annotated[CommandRange | str, CommandRangeField()] | None = None
    """Clamp of the command: `none` (default), `joint` (its range) or [low, high], in the unit of
    `command` [rad or m; rad/s or m/s; N*m or N]."""
    delay: Delay | None = None
    """Delay of the command [s], or {nominal, range, sampling}."""
    encoder_bias: FittedAngle | None = None
    """q_measured = q + bias [rad or m]. Default 0."""
    action_scale: Annotated[SpecValue, Number(Kind.RATIO)] | None = None
    """Command per unit of action, in SI [-]."""


class Actuators(Tunable):
    """A group of joints with the same kind of actuator."""

    joints: Annotated[tuple[str, ...], Field(min_length=1)]
    """Patterns (full match) or names of the group's joints."""
    level: Literal["ideal_pd", "dc_motor", "actuator_net"]
    """Model level: `ideal_pd`, `dc_motor` or `actuator_net`."""
    command: Literal["position", "velocity", "effort"] = "position"
    """What the command is: `position` (default), `velocity` (kd only) or `effort` (a torque)."""
    network: NetworkFile | None = None
    """Network of level actuator_net."""
    identified: str | None = None
    """Results of an identification, relative to the spec's folder."""
    overrides: dict[str, Tunable] = Field(default_factory=dict)
    """Pattern to the fields that differ; at most one match a joint and field."""
    randomize: dict[RandomizedField, Randomize] = Field(default_factory=dict)
    """Domain-randomisation ranges."""
    note: str | None = None
    """Remark."""


class DeltaAction(Strict):
    """Learned correction of the policy's action, on top of any level."""

    manifest: str
    """Its manifest, relative to the spec's folder: files, columns, limit and period."""


class AnyTarget(Strict):
    """What a target of every kind may state."""

    target: str | None = None
    """Kind of the target; default: its key."""


class VersionedTarget(AnyTarget):
    """A target that is written for a version of its simulator."""

    version: Version | None = None
    """Version of the simulator or framework, in quotes."""


class IsaacSimTarget(VersionedTarget):
    """A target for Isaac Lab."""

    isaac_sim: Version | None = None
    """Isaac Sim version, for Isaac Lab."""
    backend: Literal["physx", "newton", "ovphysx"] | None = None
    """Physics backend, for Isaac Lab 3."""


ActuatorClass = Literal["auto", "implicit", "custom"]


class IsaacLabTarget(IsaacSimTarget):
    """Options of the Isaac Lab target."""

    class_: (
        Annotated[
            Annotated[dict[str, ActuatorClass], Tag("mapping")] | Annotated[ActuatorClass, Tag("word")],
            Discriminator(_shape),
        ]
        | None
    ) = Field(default=None, alias="class")
    """Kind of actuator class, or pattern of joint names to it (the others: `auto`), for Isaac Lab."""


class RandomizationTarget(IsaacSimTarget):
    """Options of the randomisation target."""

    for_: tuple[str, ...] | None = Field(default=None, alias="for")
    """Stacks to write randomisation for."""


class DeployTarget(AnyTarget):
    """Options of the deploy target."""

    joint_order: tuple[NameOrGap, ...] | None = None
    """Joint order of the robot's SDK, `null` where it numbers no joint of the spec, for deploy."""


class NewtonTarget(VersionedTarget):
    """Options of the Newton target."""

    root: str | None = None
    """Path of the robot's prim in the USD stage, for newton."""
    joint_paths: dict[str, str] | None = None
    """Pattern of joint names to the path of their prims, below `root` or absolute, for newton; `{joint}` is the
    joint's name."""


class Target(NewtonTarget, DeployTarget, RandomizationTarget, IsaacLabTarget):
    """One thing to compile to."""


KINDS: dict[str, type[AnyTarget]] = {
    "mujoco": VersionedTarget,
    "isaaclab": IsaacLabTarget,
    "mjlab": VersionedTarget,
    "deploy": DeployTarget,
    "randomization": RandomizationTarget,
    "urdf": AnyTarget,
    "newton": NewtonTarget,
}
"""Kind of target to its options.

A new target is its folder `targets/KIND/` with a function `emit` in the module `emit`, and one line here. Options that
no other target has are a class above, which becomes a base of `Target` too: spec, schema and `emit` all read that
class.
"""


VariantName = Annotated[str, Field(min_length=1, max_length=100, pattern="^[A-Za-z0-9][A-Za-z0-9_.-]*$")]


class SpecModel(Strict):
    """An actuator spec."""

    actspec: Annotated[int, Field(strict=True)]
    """Version of the spec language: 1."""
    robot: Robot
    """The robot."""
    timing: Timing = Timing()
    """Rates of simulation and control."""
    include: tuple[str, ...] = ()
    """Files with more `motors` and `sources`, inside the spec's folder."""
    sources: dict[str, Source] = Field(default_factory=dict)
    """Key to what it stands for."""
    motors: dict[str, Motor] = Field(default_factory=dict)
    """Key to motor."""
    linkages: dict[str, Linkage] = Field(default_factory=dict)
    """Name to motors that move several joints together."""
    actuators: Annotated[dict[str, Actuators], Field(min_length=1)]
    """Name to group; every actuated joint is in exactly one."""
    delta_action: DeltaAction | None = None
    """Robot-wide delta action."""
    targets: dict[str, Target] = Field(default_factory=dict)
    """Name to target."""
    accept: dict[str, str] = Field(default_factory=dict)
    """`target.field` of an approximation to the reason why it is taken."""
    variant: VariantName | None = None
    """What the spec is called as it stands, among its variants."""
    variants: dict[VariantName, dict[str, Any]] = Field(default_factory=dict)
    """Name to what is different in this variant: parts of `robot`, `motors`, `actuators` and the other sections."""
