"""The intermediate representation: what each joint's actuator is, in SI units, joint side.

`resolve` (from a spec) and `lift` (from a foreign file) both end here, and every target and
rule starts here. After this point there are no unit strings, no patterns and no `None` that
means "default": an absent number is a `Quantity` of origin `unknown`, or the field is `None`
because the joint has no such thing (an ideal PD has no torque-speed line).

All torques are [N*m] for a hinge and [N] for a slide, speeds [rad/s] or [m/s], and so on;
`JointActuator.kind` says which. Every figure is at the joint: gear, reduction and
parallel motors are already in it.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from dataclasses import field as dataclass_field
from enum import Enum
from functools import lru_cache

from actspec.diagnostics import Diagnostic, Span
from actspec.joints import InertiaRange as InertiaRange
from actspec.joints import JointKind as JointKind
from actspec.units import format_number


class Origin(str, Enum):
    """Where a number comes from, strongest first."""

    AUTHORED = "authored"
    """Written in the spec."""
    IDENTIFIED = "identified"
    """Fitted by an identification experiment."""
    DERIVED = "derived"
    """Computed from other numbers of the spec; the formula says how."""
    MODEL = "model"
    """The robot file's own value."""
    DEFAULT = "default"
    """The engine's or actspec's default: nobody measured it."""
    UNKNOWN = "unknown"
    """Nobody says."""


class Level(str, Enum):
    """Model level of an actuator."""

    IDEAL_PD = "ideal_pd"
    DC_MOTOR = "dc_motor"
    ACTUATOR_NET = "actuator_net"


class Command(str, Enum):
    """What the command means."""

    POSITION = "position"
    VELOCITY = "velocity"
    EFFORT = "effort"


@dataclass(frozen=True, slots=True)
class Quantity:
    """One number with everything that is known about it.

    Attributes:
        value: The number in `unit`; None is unknown, which is not zero.
        unit: SI unit as text, e.g. `N*m/rad`.
        origin: Where the number comes from.
        source: Key of the spec's `sources`, or a file; None when none is named.
        span: Where it is written; None when it is written nowhere.
        std: Standard deviation in `unit`; None when unknown.
        note: The author's remark.
        formula: For a derived number, how it was computed, with the figures.
        lost: Candidates that precedence passed over, strongest first.
    """

    value: float | None
    unit: str
    origin: Origin
    source: str | None = None
    span: Span | None = None
    std: float | None = None
    note: str | None = None
    formula: str | None = None
    lost: tuple[Quantity, ...] = ()

    @property
    def known(self) -> bool:
        """Whether there is a number."""
        return self.value is not None

    def require(self) -> float:
        """The number, where the caller has made sure that there is one.

        Raises:
            ValueError: the quantity is unknown.
        """
        if self.value is None:
            raise ValueError("the quantity is unknown")
        return self.value

    def losing(self, *others: Quantity) -> Quantity:
        """The same quantity with `others` recorded as passed over."""
        return replace(self, lost=(*self.lost, *others))


def stated(
    value: float, unit: str, span: Span, *, note: str | None = None, formula: str | None = None
) -> Quantity:
    """A number that a file states at `span`, or that follows from one by `formula`."""
    return Quantity(value + 0.0, unit, Origin.MODEL, source=span.path, span=span, note=note, formula=formula)


@lru_cache(maxsize=1024)
def assumed(value: float, unit: str, note: str) -> Quantity:
    """What an engine takes where the file is silent; `note` says whose default it is."""
    return Quantity(value, unit, Origin.DEFAULT, note=note)


def unknown(unit: str, note: str | None = None, span: Span | None = None) -> Quantity:
    """A number that nobody tells; with a place where the file writes something else."""
    source = None if span is None else span.path
    return Quantity(None, unit, Origin.UNKNOWN, source=source, span=span, note=note)


def tidy(value: float) -> float:
    """A computed number to 12 significant digits, so that 81 x 0.000111842 is 0.009059202 in every file.

    Chosen: a relative change of 5e-13 at most, a thousandth of what any target is checked to.
    """
    return float(f"{value:.12g}")


@dataclass(frozen=True, slots=True)
class AsymmetricCurve:
    """Torque-speed curve with different drive and brake torque, joint side.

    Attributes:
        drive_torque: Torque available when torque and speed have the same sign [N*m or N].
        brake_torque: Torque available when they have not [N*m or N].
        knee_speed: Speed up to which the full torque is available [rad/s or m/s].
        no_load_speed: Speed at which no torque is left [rad/s or m/s].
    """

    drive_torque: Quantity
    brake_torque: Quantity
    knee_speed: Quantity
    no_load_speed: Quantity


@dataclass(frozen=True, slots=True)
class MotorLine:
    """A motor's torque-speed line and bandwidth as its datasheet has them, joint side, whatever the joint's level.

    Attributes:
        stall_torque: At zero speed [N*m or N]; None: the motor has none.
        no_load_speed: At zero torque [rad/s or m/s]; likewise.
        curve: Asymmetric curve in place of the line; None without one.
        bandwidth: Frequency that the drive follows [Hz]; None: none is stated.
    """

    stall_torque: Quantity | None
    no_load_speed: Quantity | None
    curve: AsymmetricCurve | None
    bandwidth: Quantity | None


@dataclass(frozen=True, slots=True)
class Delay:
    """Delay of the command.

    Attributes:
        nominal: [s].
        low: Lower end of the range [s]; equal to `nominal` without a range.
        high: Upper end of the range [s]; equal to `nominal` without a range.
        sampling: `episode` (drawn at reset, then held) or `step` (drawn anew every physics step).
    """

    nominal: Quantity
    low: float
    high: float
    sampling: str


@dataclass(frozen=True, slots=True)
class Randomization:
    """One domain-randomisation range of one joint.

    Attributes:
        field: `kp`, `kd`, `gains`, `strength`, `effort_limit`, `armature`, `friction.coulomb`, ...
        operation: `scale` (factor), `add` (offset) or `abs` (replacement).
        low: Lower end, or the mean of a gaussian; SI units or a factor.
        high: Upper end, or the standard deviation of a gaussian.
        distribution: `uniform`, `log_uniform` or `gaussian`.
        when: `startup`, `reset` or `interval`.
        every: Interval range [s] for `interval`; None otherwise.
        per: `joint`, `group` or `env`: what shares one draw.
        span: Where it is written.
        has_unit: The ends are written with a unit, so that they are no factors.
    """

    field: str
    operation: str
    low: float
    high: float
    distribution: str
    when: str
    every: tuple[float, float] | None
    per: str
    span: Span | None
    has_unit: bool = dataclass_field(default=False, compare=False)

    @property
    def words(self) -> str:
        """`scale 0.9 to 1.1 (uniform, at reset, per joint)`."""
        ends = f"{format_number(self.low)} to {format_number(self.high)}"
        every = "" if self.every is None else " every {} to {} s".format(*map(format_number, self.every))
        return f"{self.operation} {ends} ({self.distribution}, at {self.when}{every}, per {self.per})"


@dataclass(frozen=True, slots=True)
class Network:
    """An actuator network, by file; paths are absolute or relative to the working folder.

    Attributes:
        file: The network itself; None: those that the manifest names.
        manifest: Its manifest; None: none is named. One of the two is there.
        span: Where it is written.
        stated: What a configuration states of the manifest, as JSON; "" where it states nothing.
        lacking: Keys of a manifest that it does not state.
    """

    file: str | None
    manifest: str | None
    span: Span | None = None
    stated: str = ""
    lacking: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Base name by which it is shown."""
        return os.path.basename(self.file or self.manifest or "")


@dataclass(frozen=True, slots=True)
class DeltaAction:
    """A network that corrects the policy's commands, by its manifest; it concerns the whole robot."""

    manifest: str
    span: Span | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class JointActuator:
    """The actuator of one joint, joint side, SI.

    Attributes:
        joint: Name of the joint.
        kind: hinge or slide.
        group: Name of the spec's actuator group.
        pattern: The author's pattern that selected the joint.
        motor: Name of the spec's motor, or of those of its linkage; None without one.
        level: Model level.
        command: What the command means.
        kp: Drive stiffness [N*m/rad or N/m]; None unless command is position.
        kd: Drive velocity gain [N*m*s/rad or N*s/m]; None when command is effort.
        effort_limit: Clamp of the drive's torque, L [N*m or N].
        velocity_limit: The joint's or solver's speed limit [rad/s or m/s].
        stall_torque: Torque-speed line at zero speed [N*m or N]; None without a line.
        no_load_speed: Torque-speed line at zero torque [rad/s or m/s]; None without a line.
        curve: Asymmetric curve in place of the line; None without one.
        motor_line: The motor's torque-speed line, acting at `dc_motor` alone; None without a motor; information.
        peak_torque: The motor's short-time torque [N*m or N]; information.
        continuous_torque: The motor's thermal torque [N*m or N]; information.
        armature: Inertia added to the joint [kg*m^2 or kg].
        reflected_inertia: Rotor inertia seen at the joint [kg*m^2 or kg]; unknown without rotor data.
        gear: Speed of the motor's rotor over that of the joint [-, or rad/m at a slide]; None without a gear.
        torque_constant: Torque at the joint per current of one motor [N*m/A or N/A]; None where the motor states none,
            and behind a linkage.
        friction_coulomb: Kinetic dry friction [N*m or N].
        friction_static: Break-away friction [N*m or N]; None: equal to coulomb.
        friction_viscous: Passive viscous friction [N*m*s/rad or N*s/m].
        stribeck_velocity: [rad/s or m/s]; None: no Stribeck effect.
        filter_cutoff: First-order low-pass on the command [Hz]; None without a filter.
        command_range: Clamp of the command, low and high, in the command's unit; None: no clamp.
        delay: Delay of the command; None without one.
        encoder_bias: Added to the true position by the encoder, q_measured = q + bias [rad or m].
        action_scale: Action unit to command unit; None when not stated.
        default_position: Default pose of the joint [rad or m].
        position_range: The joint's own range, low and high [rad or m]; None: unlimited.
        network: Actuator network of level actuator_net.
        randomize: Domain-randomisation ranges.
        inertia_held: M_jj, other joints held, armature included; None when the model does not say.
        inertia_free: 1/(M^-1)_jj, other joints free, armature included; None likewise.
        span: Where the group is written.
    """

    joint: str
    kind: JointKind
    group: str
    pattern: str
    motor: str | None = None
    level: Level
    command: Command
    kp: Quantity | None
    kd: Quantity | None
    effort_limit: Quantity
    velocity_limit: Quantity
    stall_torque: Quantity | None = None
    no_load_speed: Quantity | None = None
    curve: AsymmetricCurve | None = None
    motor_line: MotorLine | None = None
    peak_torque: Quantity
    continuous_torque: Quantity
    armature: Quantity
    reflected_inertia: Quantity
    gear: float | None = None
    torque_constant: Quantity | None = None
    friction_coulomb: Quantity
    friction_static: Quantity | None = None
    friction_viscous: Quantity
    stribeck_velocity: Quantity | None = None
    filter_cutoff: Quantity | None = None
    command_range: tuple[Quantity, Quantity] | None = None
    delay: Delay | None = None
    encoder_bias: Quantity
    action_scale: Quantity | None = None
    default_position: Quantity
    position_range: tuple[float, float] | None = None
    network: Network | None = None
    randomize: tuple[Randomization, ...] = ()
    inertia_held: InertiaRange | None = None
    inertia_free: InertiaRange | None = None
    span: Span | None = None

    def quantities(self) -> Iterator[tuple[str, Quantity]]:
        """Every number that there is, by name: the fields, then the parts of curve, delay and range."""
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, Quantity):
                yield field.name, value
        if self.curve is not None:
            for part in fields(self.curve):
                yield f"curve.{part.name}", getattr(self.curve, part.name)
        if self.delay is not None:
            yield "delay", self.delay.nominal
        if self.command_range is not None:
            yield "command_range.low", self.command_range[0]
            yield "command_range.high", self.command_range[1]


_BOUND = re.compile(r"\b(?:up to|at most) ([0-9]+(?:\.[0-9]+)?) ?(N\*m|N·m|Nm|N)(?![\w*·/])")
ROUNDED = 1.1
"""A figure over the bound that a reason states for it: reasons round."""


@dataclass(frozen=True, slots=True)
class Approximation:
    """What a target cannot express of one joint, or a spec of its robot.

    Attributes:
        target: Name of the target in the spec; `spec` for what the spec simplifies itself, for every target.
        joint: The joint; "" when it concerns the whole robot.
        field: What it is called, e.g. `command_filter`.
        asked: What the spec asks for, with unit.
        emitted: What is taken instead.
        why: Reason.
        max_torque_error: Largest difference in torque that it can make [N*m or N]; None when the
            loss is not one of torque.
        unit: Unit of `max_torque_error`.
        at: Where that is, of a torque-speed line: `driving at 20.9 rad/s`; "" where it is not told.
        beyond: Largest difference above the motor's no-load speed [N*m or N], of such a line; None: of another loss.
    """

    target: str
    joint: str
    field: str
    asked: str
    emitted: str
    why: str
    max_torque_error: float | None
    unit: str = "N*m"
    at: str = ""
    beyond: float | None = None

    @property
    def key(self) -> str:
        """Name under which `accept` takes it."""
        return f"{self.target}.{self.field}"

    @property
    def open(self) -> bool:
        """Whether the spec says of armature or friction that nobody knows it: no target can be held to a number."""
        return self.asked == "unknown" and self.field.startswith(("armature", "friction."))

    def within(self, reason: str) -> bool:
        """Whether it is as small as the reason says for which `accept` takes it, as in "up to 82 N*m".

        A reason without such a torque takes it whatever its size is.
        """
        stated = [float(size) for size, unit in _BOUND.findall(reason) if (unit == "N") is (self.unit == "N")]
        return not stated or (self.max_torque_error or 0.0) <= ROUNDED * max(stated)


@dataclass(frozen=True, slots=True)
class Source:
    """Where numbers come from, as the spec's `sources` lists it."""

    key: str
    title: str
    url: str | None = None
    page: str | None = None
    commit: str | None = None
    accessed: str | None = None
    note: str | None = None


def whole_steps(period: float | None, step: float | None) -> int | None:
    """Physics steps in a control period [s]; None where they are no whole number, or one is unknown.

    Periods are quoted with three digits: 16.7 ms are two steps of 8.33 ms.
    """
    if not period or not step:
        return None
    count = round(period / step)
    return count if count and abs(period / step - count) <= min(3e-3 * count, 0.01) else None


@dataclass(frozen=True, slots=True)
class ActuatorSet:
    """All actuators of one robot; the compiler's IR.

    Attributes:
        robot: Name of the robot.
        joints: One entry a managed joint, in the robot's joint order.
        unmanaged: Joints that the spec leaves as they are, in the robot's joint order.
        default_pose: The author's patterns of the default pose, in order.
        physics_dt: Simulation step [s].
        decimation: Physics steps in one control step; None when not stated.
        control_dt: Time from one action to the next [s], where it is stated itself.
        delta_action: Robot-wide delta action; None without one.
        accept: Approximations taken knowingly: (`target.field`, reason).
        sources: What the `source` keys mean.
        spec_sha256: Hash of the spec's text and of what it includes.
        diagnostics: Warnings and notes of `resolve`.
        approximations: What the spec simplifies before any target does: linkages, levers.
        variant: Name of the spec's variant; None where it has no names for them.
    """

    robot: str
    joints: tuple[JointActuator, ...]
    unmanaged: tuple[str, ...]
    physics_dt: Quantity
    decimation: int | None = None
    delta_action: DeltaAction | None = None
    accept: tuple[tuple[str, str], ...] = ()
    sources: tuple[Source, ...] = ()
    spec_sha256: str = ""
    diagnostics: tuple[Diagnostic, ...] = ()
    default_pose: tuple[str, ...] = ()
    approximations: tuple[Approximation, ...] = ()
    variant: str | None = None
    control_dt: Quantity | None = None

    @property
    def title(self) -> str:
        """The robot, with its variant where it has one."""
        return self.robot + (f" ({self.variant})" if self.variant else "")

    @property
    def assumed_step(self) -> str:
        """Whose physics step it is where nobody states one; "" where somebody does."""
        stated = self.physics_dt.origin is not Origin.DEFAULT
        return "" if stated else "MuJoCo's default: neither the spec nor its model states one"

    @property
    def control_period(self) -> float | None:
        """Time from one action to the next [s]; None where nobody states it: steps of a default are no rate."""
        if self.control_dt is not None and self.control_dt.known:
            return self.control_dt.value
        step = None if self.assumed_step else self.physics_dt.value
        return None if step is None or self.decimation is None else step * self.decimation

    @property
    def spec_lines(self) -> tuple[str, ...]:
        """Which spec this is of, and which variant, for the heads of files."""
        return (f"spec sha256 {self.spec_sha256}", *((f"variant {self.variant}",) if self.variant else ()))

    def joint(self, name: str) -> JointActuator | None:
        """The actuator of a joint, or None if the spec does not manage it."""
        return next((j for j in self.joints if j.joint == name), None)
