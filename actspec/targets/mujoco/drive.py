"""What each joint's drive becomes in MuJoCo: a `Drive`, and what it cannot hold.

By level and command, for a version:

- ideal_pd: `<position>` or `<velocity>` with forcerange, `<motor>` for effort; all exact.
- dc_motor: `<dcmotor>`, which is the law itself from 3.12 on (all commands) and in 3.7 to 3.11
  (position only); before, and for the rest, a clip at the effort limit alone.
- actuator_net: `<motor>`; the network runs outside and writes torque.
Torque limits are kept first, then delay, then the filter.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

from actspec.diagnostics import Collector
from actspec.ir import Command, JointActuator, Level, Quantity
from actspec.laws import TorqueLaw, delay_steps, law_of
from actspec.robot.view import ActuatorView, JointView
from actspec.targets.approximation import held_step_error, speed_scale, static_error
from actspec.targets.base import Approximation
from actspec.targets.versions import DcMotorDialect, MujocoDialect
from actspec.units import format_quantity

VOLTAGE = 24.0
"""Voltage of the emitted dcmotor [V]. Chosen: any number gives the same torque, it cancels."""


class Form(str, Enum):
    """MuJoCo element that a drive becomes."""

    POSITION = "position"
    VELOCITY = "velocity"
    MOTOR = "motor"
    DCMOTOR = "dcmotor"


@dataclass(frozen=True, slots=True)
class Line:
    """Torque-speed line of a dcmotor, joint side: torque at zero speed, speed at zero torque."""

    stall_torque: float
    no_load_speed: float


@dataclass(frozen=True, slots=True)
class Drive:
    """One actuator to write; joint side, gear 1, SI.

    Attributes:
        joint: The joint it drives.
        name: Its name.
        form: Element.
        command: What its control means.
        kp: [N*m/rad or N/m]; 0 unless it is a position drive.
        kd: [N*m*s/rad or N*s/m]; 0 for effort.
        offset: Constant force, -kp * encoder bias [N*m or N].
        effort_limit: forcerange is -+ this [N*m or N]; None: no clamp.
        line: Torque-speed line of a dcmotor.
        time_constant: Of the command filter [s]; 0 without.
        delay_steps: Delay of the command in steps; 0 without.
        step: Simulation step [s].
        control_range: For `ctrlrange`; None leaves it empty.
        control_limited: Whether the command is clamped to it.
        group: Actuator group, kept from a replaced actuator.
        user: User data, kept likewise.
    """

    joint: str
    name: str
    form: Form
    command: Command
    kp: float
    kd: float
    offset: float
    effort_limit: float | None
    line: Line | None
    time_constant: float
    delay_steps: int
    step: float
    control_range: tuple[float, float] | None
    control_limited: bool
    group: int = 0
    user: tuple[float, ...] = ()

    @property
    def delay(self) -> float:
        """Delay in seconds, a whole number of steps."""
        return self.delay_steps * self.step


@dataclass(frozen=True, slots=True)
class DriveResult:
    """A drive with what it lost."""

    drive: Drive
    approximations: tuple[Approximation, ...]


def drive_of(
    actuator: JointActuator,
    joint: JointView,
    own: tuple[ActuatorView, ...],
    own_limit: float | None,
    dialect: MujocoDialect,
    step: float,
    target: str,
    collector: Collector,
) -> DriveResult | None:
    """Choose the drive of one joint.

    Args:
        actuator: What the spec asks for.
        joint: The robot's joint.
        own: The file's own actuators on it; their gains serve where the spec says `unknown`.
        own_limit: The file's own effort limit [N*m or N]; None: none.
        dialect: MuJoCo version that is written.
        step: Simulation step [s].
        target: Name of the target, for approximations.
        collector: Takes errors.

    Returns: None when an error was reported.
    """
    known = _with_own_gains(actuator, own, own_limit, collector)
    if known is None:
        return None
    try:
        return _Chooser(known, joint, dialect, step, target).choose()
    except ValueError as err:
        # The law itself says which number it lacks.
        collector.error("MJC018", str(err), where=f"actuators.{actuator.group}", span=actuator.span)
        return None


def _with_own_gains(
    actuator: JointActuator, own: tuple[ActuatorView, ...], own_limit: float | None, collector: Collector
) -> JointActuator | None:
    """Fill unknown gains and limit from the file's own servo; report what nobody knows."""
    if actuator.level is Level.ACTUATOR_NET:
        return actuator
    servos = [a for a in own if a.control in ("position", "dcmotor", "pid", "velocity")]
    filled: dict[str, Quantity] = {}
    for field, needed in (
        ("kp", actuator.command is Command.POSITION),
        ("kd", actuator.command is not Command.EFFORT),
    ):
        quantity: Quantity | None = getattr(actuator, field)
        if not needed or (quantity is not None and quantity.known):
            continue
        found = sum(getattr(a, field) for a in servos)
        if not servos or (field == "kp" and found == 0.0):
            collector.error(
                "MJC001",
                f"{actuator.joint}: {field} is unknown, and MuJoCo needs a number: the file has no servo to keep",
                where=f"actuators.{actuator.group}.{field}",
                span=(quantity.span if quantity is not None else None) or actuator.span,
                help=f"state {field}, or use `command: effort` and leave the gains to the caller",
            )
            return None
        assert quantity is not None
        filled[field] = replace(quantity, value=found)
    if not actuator.effort_limit.known and own_limit is not None:
        filled["effort_limit"] = replace(actuator.effort_limit, value=own_limit)
    return replace(actuator, **filled) if filled else actuator  # type: ignore[arg-type]


class _Chooser:
    def __init__(
        self, actuator: JointActuator, joint: JointView, dialect: MujocoDialect, step: float, target: str
    ) -> None:
        self.actuator = actuator
        self.joint = joint
        self.dialect = dialect
        self.step = step
        self.target = target
        self.lost: list[Approximation] = []
        self.torque_unit = actuator.effort_limit.unit
        self.law: TorqueLaw | None = None if actuator.level is Level.ACTUATOR_NET else law_of(actuator)

    def approximate(self, field: str, asked: str, emitted: str, why: str, error: float | None) -> None:
        self.lost.append(
            Approximation(
                self.target, self.actuator.joint, field, asked, emitted, why, error, self.torque_unit
            )
        )

    def choose(self) -> DriveResult:
        actuator = self.actuator
        forms = {Command.POSITION: Form.POSITION, Command.VELOCITY: Form.VELOCITY, Command.EFFORT: Form.MOTOR}
        form = forms[actuator.command]
        limit = actuator.effort_limit.value
        line = None
        if self.law is None:
            return self.network()
        law = self.law
        if actuator.level is Level.DC_MOTOR:
            form, line = self.dc_motor(form, law)
            if form is Form.DCMOTOR and law.curve is not None:
                limit = min(law.effort_limit, law.curve[0])
        offset = 0.0
        if law.encoder_bias != 0.0 and actuator.command is Command.POSITION:
            if form is Form.DCMOTOR:
                self.approximate(
                    "encoder_bias",
                    format_quantity(law.encoder_bias, actuator.encoder_bias.unit),
                    "none",
                    "dcmotor has no constant term",
                    self.error_of(law, replace(law, encoder_bias=0.0).torque),
                )
            else:
                offset = -law.kp * law.encoder_bias
        steps = self.delay(law, form)
        time_constant = self.filter(law, form)
        self.passive()
        control_range, limited = self.control_range(law, limit)
        drive = Drive(
            joint=actuator.joint,
            name=actuator.joint,
            form=form,
            command=actuator.command,
            kp=law.kp,
            kd=law.kd,
            offset=offset,
            effort_limit=limit,
            line=line,
            time_constant=time_constant,
            delay_steps=steps,
            step=self.step,
            control_range=control_range,
            control_limited=limited,
        )
        return DriveResult(drive, tuple(self.lost))

    def network(self) -> DriveResult:
        """A plain motor: the network's torque is its control."""
        actuator = self.actuator
        limit = actuator.effort_limit.value
        self.approximate(
            "network",
            actuator.network.file if actuator.network is not None else "a network",
            "<motor>, its control is the torque",
            "MuJoCo runs no network: the runtime computes the torque and writes it",
            None,
        )
        self.passive()
        drive = Drive(
            joint=actuator.joint,
            name=actuator.joint,
            form=Form.MOTOR,
            command=Command.EFFORT,
            kp=0.0,
            kd=0.0,
            offset=0.0,
            effort_limit=limit,
            line=None,
            time_constant=0.0,
            delay_steps=0,
            step=self.step,
            control_range=None if limit is None else (-limit, limit),
            control_limited=False,
        )
        return DriveResult(drive, tuple(self.lost))

    def dc_motor(self, form: Form, law: TorqueLaw) -> tuple[Form, Line | None]:
        """`<dcmotor>` where the version and the command allow it, else a clip at the limit."""
        version = f"MuJoCo {self.dialect.text}"
        clipped = replace(law, stall_torque=None, no_load_speed=None, curve=None)
        if law.curve is not None:
            drive, brake, knee, no_load = law.curve
            unit = self.torque_unit
            asked = (
                f"curve: drive {format_quantity(drive, unit)}, brake {format_quantity(brake, unit)}, "
                f"knee {knee:g}, no load {no_load:g}"
            )
            line = Line(drive / (1.0 - knee / no_load), no_load)
        else:
            assert law.stall_torque is not None and law.no_load_speed is not None
            asked = (
                f"line from {format_quantity(law.stall_torque, self.torque_unit)} to "
                f"{format_quantity(law.no_load_speed, self.speed_unit())}"
            )
            line = Line(law.stall_torque, law.no_load_speed)
        native = self.dialect.dcmotor is DcMotorDialect.TORQUE or (
            self.dialect.dcmotor is DcMotorDialect.VOLTAGE and law.command is Command.POSITION
        )
        field = "torque_speed_curve"
        if not native:
            why = (
                f"{version} has no dcmotor"
                if self.dialect.dcmotor is DcMotorDialect.NONE
                else f"the dcmotor of {version} takes position commands only"
            )
            self.approximate(
                field,
                asked,
                f"a clip at {format_quantity(self.actuator.effort_limit.value, self.torque_unit)}",
                why,
                self.error_of(law, clipped.torque),
            )
            return form, None
        if law.curve is not None:
            # The line through knee and no-load speed is the drive side of the curve, cut at L.
            limit = min(law.effort_limit, law.curve[0])
            symmetric = replace(
                law,
                curve=None,
                stall_torque=line.stall_torque,
                no_load_speed=line.no_load_speed,
                effort_limit=limit,
            )
            self.approximate(
                field,
                asked,
                f"line from {line.stall_torque:g} to {line.no_load_speed:g}, cut at {limit:g}",
                "dcmotor has one line for driving and braking",
                self.error_of(law, symmetric.torque),
            )
        return Form.DCMOTOR, line

    def error_of(self, law: TorqueLaw, emitted: Callable[[Any, Any, Any], Any]) -> float:
        return static_error(law, emitted)

    def speed_unit(self) -> str:
        return self.actuator.velocity_limit.unit

    def delay(self, law: TorqueLaw, form: Form) -> int:
        delay = self.actuator.delay
        if delay is None or delay.nominal.value is None:
            return 0
        nominal = delay.nominal.value
        steps, loss = delay_steps(nominal, self.step)
        filtered = form is not Form.DCMOTOR
        asked = f"{nominal * 1e3:g} ms"
        if steps and not self.dialect.native_delay:
            self.approximate(
                "delay",
                asked,
                "none",
                f"MuJoCo {self.dialect.text} has no actuator delay (3.5 and later have)",
                held_step_error(law, filtered=filtered, late=steps * self.step),
            )
            steps = 0
        elif abs(loss) > 1e-9:
            self.approximate(
                "delay",
                asked,
                self.delay_text(steps),
                f"a delay is a whole number of steps; {abs(loss) * 1e3:g} ms "
                f"{'more' if loss > 0 else 'less'} than asked",
                held_step_error(law, filtered=filtered, late=abs(loss)),
            )
        if delay.low != delay.high:
            reach = max(abs(steps * self.step - end) for end in (delay.low, delay.high))
            self.approximate(
                "delay.range",
                f"{delay.low * 1e3:g} to {delay.high * 1e3:g} ms, drawn each {delay.sampling}",
                self.delay_text(steps),
                "a MuJoCo model has one fixed delay",
                held_step_error(law, filtered=filtered, late=reach),
            )
        return steps

    def delay_text(self, steps: int) -> str:
        return (
            f"{steps * self.step * 1e3:g} ms ({steps} steps of {self.step * 1e3:g} ms)" if steps else "none"
        )

    def filter(self, law: TorqueLaw, form: Form) -> float:
        if law.filter_cutoff is None:
            return 0.0
        time_constant = 1.0 / (2.0 * math.pi * law.filter_cutoff)
        if form is Form.DCMOTOR:
            self.approximate(
                "command_filter",
                f"{law.filter_cutoff:g} Hz",
                "none",
                "dcmotor takes no filter on its command; the torque-speed line is kept instead",
                held_step_error(law),
            )
            return 0.0
        return time_constant

    def passive(self) -> None:
        """Static friction and Stribeck: MuJoCo's frictionloss is one number."""
        actuator = self.actuator
        coulomb = actuator.friction_coulomb.value or 0.0
        static = actuator.friction_static.value if actuator.friction_static is not None else None
        if static is not None and static != coulomb:
            self.approximate(
                "friction.static",
                format_quantity(static, self.torque_unit),
                format_quantity(coulomb, self.torque_unit),
                "frictionloss is one number for sticking and sliding",
                static - coulomb,
            )
        elif (
            actuator.stribeck_velocity is not None and actuator.stribeck_velocity.known and static is not None
        ):
            self.approximate("friction.stribeck_velocity", "a Stribeck curve", "none", "MuJoCo has none", 0.0)
        if actuator.velocity_limit.known:
            self.approximate(
                "velocity_limit",
                format_quantity(actuator.velocity_limit.value, actuator.velocity_limit.unit),
                "none",
                "MuJoCo has no speed limit of a joint",
                None,
            )

    def control_range(self, law: TorqueLaw, limit: float | None) -> tuple[tuple[float, float] | None, bool]:
        """The command's clamp, or where a viewer's slider should end."""
        asked = self.actuator.command_range
        if asked is not None:
            low, high = asked[0].require(), asked[1].require()
            return (low, high), True
        if law.command is Command.POSITION:
            if self.joint.range is None:
                return None, False
            reach = limit / law.kp if limit is not None and law.kp > 0.0 else 0.0
            low, high = self.joint.range
            # It clamps nothing: four digits are enough for a slider.
            return (round(low - reach, 4), round(high + reach, 4)), False
        if law.command is Command.EFFORT:
            return (None if limit is None else (-limit, limit)), False
        scale = speed_scale(law) if math.isfinite(law.effort_limit) else None
        return (None if scale is None else (-scale, scale)), False
