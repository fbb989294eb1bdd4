"""What each joint's drive becomes in MuJoCo.

By level and command, for a version:

- ideal_pd: `<position>` or `<velocity>` with forcerange, `<motor>` for effort; all exact.
- dc_motor: `<dcmotor>`, which is the law itself from 3.12 on (all commands) and in 3.7 to 3.11
  (position only); before, and for the rest, a clip at the effort limit alone.
- actuator_net: `<motor>`; the network runs outside and writes torque.
Torque limits are kept first, then delay, then the filter. What a drive cannot hold is in `losses`.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum
from itertools import chain

from actspec.diagnostics import Collector
from actspec.ir import Command, JointActuator, Level, Quantity
from actspec.laws import TorqueLaw, delay_steps, law_of
from actspec.resolution.quantities import Reports
from actspec.robot.view import ActuatorView, JointView
from actspec.simulators.mujoco import DcMotorDialect, MujocoDialect
from actspec.targets.base import Approximation
from actspec.targets.kit.sizes import held_step_error, speed_scale, static_error
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


FORMS = {Command.POSITION: Form.POSITION, Command.VELOCITY: Form.VELOCITY, Command.EFFORT: Form.MOTOR}
"""Element of each command, but for a dcmotor."""


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
    reports: Reports,
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
        collector: Takes errors of this joint alone.
        reports: Takes errors that other joints of its group may have too.

    Returns: None when an error was reported.
    """
    if actuator.level is Level.ACTUATOR_NET:
        return DriveResult(_network_drive(actuator, step), network_losses(actuator, target))
    known = _with_own_gains(actuator, own, own_limit, reports)
    if known is None:
        return None
    try:
        law = law_of(known)
        drive = _law_drive(known, law, joint, dialect, step)
        return DriveResult(drive, law_losses(known, law, drive, dialect, target))
    except ValueError as err:
        # The law itself says which number it lacks.
        collector.error("MJC018", str(err), where=f"actuators.{actuator.group}", span=actuator.span)
        return None


def _with_own_gains(
    actuator: JointActuator, own: tuple[ActuatorView, ...], own_limit: float | None, reports: Reports
) -> JointActuator | None:
    """Fill unknown gains and limit from the file's own servo; report what nobody knows."""
    servos = [a for a in own if a.control in ("position", "dcmotor", "pid", "velocity")]
    filled: dict[str, Quantity] = {}
    complete = True
    for field, needed in (
        ("kp", actuator.command is Command.POSITION),
        ("kd", actuator.command is not Command.EFFORT),
    ):
        quantity: Quantity | None = getattr(actuator, field)
        if not needed or (quantity is not None and quantity.known):
            continue
        found = sum(getattr(a, field) for a in servos)
        untold = any(field in a.unknown for a in servos)
        if not servos or untold or (field == "kp" and found == 0.0):
            complete = False
            why = "the file alone does not tell its servo's" if untold else "the file has no servo to keep"
            reports.error(
                "MJC001",
                actuator.joint,
                f"{field} is unknown, and MuJoCo needs a number: {why}",
                f"actuators.{actuator.group}.{field}",
                (quantity.span if quantity is not None else None) or actuator.span,
                f"state {field}, or use `command: effort` and leave the gains to the caller",
            )
            continue
        assert quantity is not None
        filled[field] = replace(quantity, value=found)
    if not complete:
        return None
    if not actuator.effort_limit.known and own_limit is not None:
        filled["effort_limit"] = replace(actuator.effort_limit, value=own_limit)
    return replace(actuator, **filled) if filled else actuator  # type: ignore[arg-type]


def _network_drive(actuator: JointActuator, step: float) -> Drive:
    """A plain motor: the network's torque is its control."""
    limit = actuator.effort_limit.value
    return Drive(
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
        step=step,
        control_range=None if limit is None else (-limit, limit),
        control_limited=False,
    )


def _law_drive(
    actuator: JointActuator, law: TorqueLaw, joint: JointView, dialect: MujocoDialect, step: float
) -> Drive:
    """The drive that holds most of a torque law."""
    form, limit, line = FORMS[actuator.command], actuator.effort_limit.value, None
    if actuator.level is Level.DC_MOTOR and _has_dcmotor(dialect, law.command):
        form, line = Form.DCMOTOR, _line(law)
        if law.curve is not None:
            limit = min(law.effort_limit, law.curve[0])
    offset = 0.0
    if law.encoder_bias != 0.0 and form is Form.POSITION:
        offset = -law.kp * law.encoder_bias
    time_constant = 0.0
    if law.filter_cutoff is not None and form is not Form.DCMOTOR:
        time_constant = 1.0 / (2.0 * math.pi * law.filter_cutoff)
    steps = 0
    if actuator.delay is not None and actuator.delay.nominal.value is not None:
        steps, _ = delay_steps(actuator.delay.nominal.value, step)
    control_range, limited = _control_range(actuator, law, joint, limit)
    return Drive(
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
        delay_steps=steps if dialect.native_delay else 0,
        step=step,
        control_range=control_range,
        control_limited=limited,
    )


def _has_dcmotor(dialect: MujocoDialect, command: Command) -> bool:
    """Whether the version's dcmotor takes the command."""
    return dialect.dcmotor is DcMotorDialect.TORQUE or (
        dialect.dcmotor is DcMotorDialect.VOLTAGE and command is Command.POSITION
    )


def _line(law: TorqueLaw) -> Line:
    """The torque-speed line; of a curve its drive side, the line through knee and no-load speed."""
    if law.curve is not None:
        drive, _, knee, no_load = law.curve
        return Line(drive / (1.0 - knee / no_load), no_load)
    assert law.stall_torque is not None and law.no_load_speed is not None
    return Line(law.stall_torque, law.no_load_speed)


def _control_range(
    actuator: JointActuator, law: TorqueLaw, joint: JointView, limit: float | None
) -> tuple[tuple[float, float] | None, bool]:
    """The command's clamp, or where a viewer's slider should end; and whether it clamps."""
    if actuator.command_range is not None:
        low, high = (end.require() for end in actuator.command_range)
        return (low, high), True
    if law.command is Command.POSITION:
        if joint.range is None:
            return None, False
        reach = limit / law.kp if limit is not None and law.kp > 0.0 else 0.0
        low, high = joint.range
        # It clamps nothing: four digits are enough for a slider.
        return (round(low - reach, 4), round(high + reach, 4)), False
    if law.command is Command.EFFORT:
        return (None if limit is None else (-limit, limit)), False
    scale = speed_scale(law) if math.isfinite(law.effort_limit) else None
    return (None if scale is None else (-scale, scale)), False


Loss = tuple[str, str, str, str, float | None]
"""Field, what is asked for, what is emitted, why, and the largest difference in torque."""


def law_losses(
    actuator: JointActuator, law: TorqueLaw, drive: Drive, dialect: MujocoDialect, target: str
) -> tuple[Approximation, ...]:
    """What a drive loses of a torque law.

    Args:
        actuator: What the spec asks for.
        law: Its law.
        drive: What it becomes.
        dialect: MuJoCo version that is written.
        target: Name of the target.
    """
    found = chain(
        _line_losses(actuator, law, drive, dialect),
        _bias_losses(actuator, law, drive),
        _delay_losses(actuator, law, drive, dialect),
        _filter_losses(law, drive),
        _passive_losses(actuator),
    )
    return _approximations(found, actuator, target)


def network_losses(actuator: JointActuator, target: str) -> tuple[Approximation, ...]:
    """What a plain motor loses of an actuator network."""
    network: Loss = (
        "network",
        os.path.basename(actuator.network.file) if actuator.network is not None else "a network",
        "<motor>, its control is the torque",
        "MuJoCo runs no network: the runtime computes the torque and writes it",
        None,
    )
    return _approximations(chain([network], _passive_losses(actuator)), actuator, target)


def _approximations(
    losses: Iterator[Loss], actuator: JointActuator, target: str
) -> tuple[Approximation, ...]:
    unit = actuator.effort_limit.unit
    return tuple(Approximation(target, actuator.joint, *loss, unit) for loss in losses)


def _line_losses(
    actuator: JointActuator, law: TorqueLaw, drive: Drive, dialect: MujocoDialect
) -> Iterator[Loss]:
    """The torque-speed line without a dcmotor, and the asymmetric curve with one."""
    if actuator.level is not Level.DC_MOTOR:
        return
    field, unit = "torque_speed_curve", actuator.effort_limit.unit
    if drive.line is None:
        clipped = replace(law, stall_torque=None, no_load_speed=None, curve=None)
        version = f"MuJoCo {dialect.text}"
        yield (
            field,
            _asked_line(actuator, law),
            f"a clip at {format_quantity(actuator.effort_limit.value, unit)}",
            f"{version} has no dcmotor"
            if dialect.dcmotor is DcMotorDialect.NONE
            else f"the dcmotor of {version} takes position commands only",
            static_error(law, clipped.torque),
        )
    elif law.curve is not None:
        # The drive has the drive side of the curve, cut at the smaller of L and the full torque.
        stall, no_load = drive.line.stall_torque, drive.line.no_load_speed
        limit = min(law.effort_limit, law.curve[0])
        symmetric = replace(law, curve=None, stall_torque=stall, no_load_speed=no_load, effort_limit=limit)
        yield (
            field,
            _asked_line(actuator, law),
            f"line from {stall:g} to {no_load:g}, cut at {limit:g}",
            "dcmotor has one line for driving and braking",
            static_error(law, symmetric.torque),
        )


def _asked_line(actuator: JointActuator, law: TorqueLaw) -> str:
    unit = actuator.effort_limit.unit
    if law.curve is not None:
        full, brake, knee, no_load = law.curve
        return (
            f"curve: drive {format_quantity(full, unit)}, brake {format_quantity(brake, unit)}, "
            f"knee {knee:g}, no load {no_load:g}"
        )
    return (
        f"line from {format_quantity(law.stall_torque, unit)} to "
        f"{format_quantity(law.no_load_speed, actuator.velocity_limit.unit)}"
    )


def _bias_losses(actuator: JointActuator, law: TorqueLaw, drive: Drive) -> Iterator[Loss]:
    if law.encoder_bias != 0.0 and law.command is Command.POSITION and drive.form is Form.DCMOTOR:
        yield (
            "encoder_bias",
            format_quantity(law.encoder_bias, actuator.encoder_bias.unit),
            "none",
            "dcmotor has no constant term",
            static_error(law, replace(law, encoder_bias=0.0).torque),
        )


def _delay_losses(
    actuator: JointActuator, law: TorqueLaw, drive: Drive, dialect: MujocoDialect
) -> Iterator[Loss]:
    delay, filtered = actuator.delay, drive.form is not Form.DCMOTOR
    if delay is None:
        return
    nominal = delay.nominal.value
    if nominal is None:
        if delay.high > 0.0:
            yield (
                "delay.range",
                f"{delay.low * 1e3:g} to {delay.high * 1e3:g} ms, drawn each {delay.sampling}",
                "none",
                "a MuJoCo model has one fixed delay, and the nominal is unknown",
                held_step_error(law, filtered=filtered, late=delay.high),
            )
        return
    steps, loss = delay_steps(nominal, drive.step)
    asked = f"{nominal * 1e3:g} ms"
    emitted = "none"
    if drive.delay_steps:
        plural = "" if drive.delay_steps == 1 else "s"
        emitted = f"{drive.delay * 1e3:g} ms ({drive.delay_steps} step{plural} of {drive.step * 1e3:g} ms)"
    if steps and not drive.delay_steps:
        yield (
            "delay",
            asked,
            emitted,
            f"MuJoCo {dialect.text} has no actuator delay (3.5 and later have)",
            held_step_error(law, filtered=filtered, late=steps * drive.step),
        )
    elif abs(loss) > 1e-9:
        yield (
            "delay",
            asked,
            emitted,
            f"a delay is a whole number of steps; {abs(loss) * 1e3:g} ms "
            f"{'more' if loss > 0 else 'less'} than asked",
            held_step_error(law, filtered=filtered, late=abs(loss)),
        )
    if delay.low != delay.high:
        reach = max(abs(drive.delay - end) for end in (delay.low, delay.high))
        yield (
            "delay.range",
            f"{delay.low * 1e3:g} to {delay.high * 1e3:g} ms, drawn each {delay.sampling}",
            emitted,
            "a MuJoCo model has one fixed delay",
            held_step_error(law, filtered=filtered, late=reach),
        )


def _filter_losses(law: TorqueLaw, drive: Drive) -> Iterator[Loss]:
    if law.filter_cutoff is not None and drive.form is Form.DCMOTOR:
        yield (
            "command_filter",
            f"{law.filter_cutoff:g} Hz",
            "none",
            "dcmotor takes no filter on its command; the torque-speed line is kept instead",
            held_step_error(law),
        )


def _passive_losses(actuator: JointActuator) -> Iterator[Loss]:
    """Static friction and Stribeck (MuJoCo's frictionloss is one number), and the speed limit."""
    unit = actuator.effort_limit.unit
    coulomb = actuator.friction_coulomb.value or 0.0
    static = actuator.friction_static.value if actuator.friction_static is not None else None
    stribeck = actuator.stribeck_velocity
    if static is not None and static > coulomb:
        yield (
            "friction.static",
            format_quantity(static, unit),
            format_quantity(coulomb, unit),
            "frictionloss is one number for sticking and sliding",
            static - coulomb,
        )
        if stribeck is not None and stribeck.known:
            yield (
                "friction.stribeck_velocity",
                format_quantity(stribeck.value, stribeck.unit),
                "none",
                "MuJoCo has no Stribeck effect",
                static - coulomb,
            )
    limit = actuator.velocity_limit
    if limit.known:
        yield (
            "velocity_limit",
            format_quantity(limit.value, limit.unit),
            "none",
            "MuJoCo has no speed limit of a joint",
            None,
        )
