"""What each joint's drive becomes in MuJoCo.

By level and command, for a version:

- ideal_pd: `<position>` or `<velocity>` with forcerange, `<motor>` for effort; all exact.
- dc_motor: `<dcmotor>`, which is the law itself from 3.12 on (all commands) and in 3.7 to 3.11
  (position only); before, and for the rest, a clip at the effort limit alone.
- actuator_net: `<motor>`; the network runs outside and writes torque.
Torque limits are kept first, then delay, then the filter. What a drive cannot hold is recorded by `_lose`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum

from actspec.diagnostics import Collector
from actspec.ir import Command, JointActuator, Level, Quantity
from actspec.laws import TorqueLaw, delay_steps
from actspec.readings.joint import JointReading
from actspec.resolution.quantities import Reports, finite_limit
from actspec.robot.view import JointView
from actspec.simulate.excitation import speed_scale
from actspec.simulators import text_of
from actspec.simulators.mujoco import NATIVE_DELAY, DcMotorDialect, MujocoDialect
from actspec.targets.base import Approximation
from actspec.targets.kit.joint import JointEmission, JointLosses
from actspec.targets.kit.sizes import boxed, held_step_error, lined
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
class TorqueSpeedLine:
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
        step: Simulation step [s].
        kp: [N*m/rad or N/m]; 0 unless it is a position drive.
        kd: [N*m*s/rad or N*s/m]; 0 for effort.
        offset: Constant force, -kp * encoder bias [N*m or N].
        effort_limit: forcerange is -+ this [N*m or N]; None: no clamp.
        line: Torque-speed line of a dcmotor.
        time_constant: Of the command filter [s]; 0 without.
        delay_steps: Delay of the command in steps; 0 without.
        control_range: For `ctrlrange`; None leaves it empty.
        control_limited: Whether the command is clamped to it.
        group: Actuator group, kept from a replaced actuator.
        user: User data, kept likewise.
    """

    joint: str
    name: str
    form: Form
    command: Command
    step: float
    kp: float = 0.0
    kd: float = 0.0
    offset: float = 0.0
    effort_limit: float | None = None
    line: TorqueSpeedLine | None = None
    time_constant: float = 0.0
    delay_steps: int = 0
    control_range: tuple[float, float] | None = None
    control_limited: bool = False
    group: int = 0
    user: tuple[float, ...] = ()

    @property
    def delay(self) -> float:
        """Delay in seconds, a whole number of steps."""
        return self.delay_steps * self.step


FORMS = {Command.POSITION: Form.POSITION, Command.VELOCITY: Form.VELOCITY, Command.EFFORT: Form.MOTOR}
"""Element of each command, but for a dcmotor."""


def drive_of(
    actuator: JointActuator,
    joint: JointView,
    reading: JointReading,
    dialect: MujocoDialect,
    step: float,
    target: str,
    collector: Collector,
    reports: Reports,
) -> tuple[Drive, tuple[Approximation, ...]] | None:
    """Choose the drive of one joint, with what it loses; None after an error.

    Args:
        actuator: What the spec asks for.
        joint: The robot's joint.
        reading: What the file says of it; its gains and limit serve where the spec says `unknown`.
        dialect: MuJoCo version that is written.
        step: Simulation step [s].
        target: Name of the target, for approximations.
        collector: Takes errors of this joint alone.
        reports: Takes errors that other joints of its group may have too.
    """
    learned = actuator.level is Level.ACTUATOR_NET
    known = actuator if learned else _with_own_gains(actuator, reading, reports)
    if known is None:
        return None
    try:
        emission = JointEmission(known, dialect, step, target, collector)
        if learned:
            _lose_network(emission)
            return _network_drive(actuator, step), tuple(emission.lost)
        drive = _law_drive(known, emission.law, joint, dialect, step)
        _lose(emission, drive)
        return drive, tuple(emission.lost)
    except ValueError as err:
        # The law itself says which number it lacks.
        collector.at(f"actuators.{actuator.group}", actuator.span).error("MJC018", str(err))
        return None


def _with_own_gains(actuator: JointActuator, reading: JointReading, reports: Reports) -> JointActuator | None:
    """Fill unknown gains and limit from the file's own servo; report what nobody knows."""
    servos, own_limit = reading.servos, finite_limit(reading.drive_limit)
    filled: dict[str, Quantity] = {}
    complete = True
    for field, needed in (
        ("kp", actuator.command is Command.POSITION),
        ("kd", actuator.command is not Command.EFFORT),
    ):
        quantity: Quantity | None = getattr(actuator, field)
        if not needed or (quantity is not None and quantity.known):
            continue
        found = reading.servo_gain(field).value
        if not servos or found is None or (field == "kp" and found == 0.0):
            complete = False
            why = (
                "the file alone does not tell that of its servo"
                if found is None
                else "the file has no servo to keep"
            )
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
    if not actuator.effort_limit.known and own_limit is not None and own_limit.known:
        filled["effort_limit"] = replace(actuator.effort_limit, value=own_limit.value)
    return replace(actuator, **filled) if filled else actuator  # type: ignore[arg-type]


def _network_drive(actuator: JointActuator, step: float) -> Drive:
    """A plain motor: the network's torque is its control."""
    limit = actuator.effort_limit.value
    return Drive(
        joint=actuator.joint,
        name=actuator.joint,
        form=Form.MOTOR,
        command=Command.EFFORT,
        step=step,
        effort_limit=limit,
        control_range=None if limit is None else (-limit, limit),
    )


def _law_drive(
    actuator: JointActuator, law: TorqueLaw, joint: JointView, dialect: MujocoDialect, step: float
) -> Drive:
    """The drive that holds most of a torque law."""
    form, limit, line = form_of(actuator, dialect), actuator.effort_limit.value, None
    if form is Form.DCMOTOR:
        line = _line(law)
        if law.curve is not None:
            limit = lined(law).effort_limit
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


def form_of(actuator: JointActuator, dialect: MujocoDialect) -> Form:
    """The element that a version has for a drive."""
    if actuator.level is Level.ACTUATOR_NET:
        return Form.MOTOR
    takes = dialect.dcmotor is DcMotorDialect.TORQUE or (
        dialect.dcmotor is DcMotorDialect.VOLTAGE and actuator.command is Command.POSITION
    )
    return Form.DCMOTOR if takes and actuator.level is Level.DC_MOTOR else FORMS[actuator.command]


def _line(law: TorqueLaw) -> TorqueSpeedLine:
    """The torque-speed line; of a curve its drive side, the line through knee and no-load speed."""
    law = lined(law)
    assert law.stall_torque is not None and law.no_load_speed is not None
    return TorqueSpeedLine(law.stall_torque, law.no_load_speed)


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


def _lose(joint: JointEmission[MujocoDialect], drive: Drive) -> None:
    """Record what a drive cannot hold of what the spec asks for."""
    _lose_line(joint, drive)
    law, dialect, dcmotor = joint.law, joint.dialect, drive.form is Form.DCMOTOR
    if dcmotor:
        joint.no_bias("dcmotor has no constant term")
    since = text_of(NATIVE_DELAY)
    joint.one_delay(
        "a MuJoCo model has one fixed delay",
        lambda steps: joint.ms(steps) if steps else "none",
        lambda late: held_step_error(law, filtered=not dcmotor, late=late),
        off=False,
        none=""
        if dialect.native_delay
        else f"MuJoCo {dialect.text} has no actuator delay ({since} and later have)",
    )
    if dcmotor:
        joint.no_filter("dcmotor takes no filter on its command; the torque-speed line is kept instead")
    _lose_passive(joint)


def _lose_line(joint: JointEmission[MujocoDialect], drive: Drive) -> None:
    """The torque-speed line without a dcmotor, and the asymmetric curve with one."""
    law, dialect = joint.law, joint.dialect
    if joint.actuator.level is not Level.DC_MOTOR:
        return
    if drive.line is None:
        version = f"MuJoCo {dialect.text}"
        joint.lose_line(
            joint.curve_text(law),
            f"a clip at {format_quantity(joint.actuator.effort_limit.value, joint.unit)}",
            f"{version} has no dcmotor"
            if dialect.dcmotor is DcMotorDialect.NONE
            else f"the dcmotor of {version} takes position commands only",
            law,
            boxed(law).torque,
        )
    elif law.curve is not None:
        joint.drive_side("dcmotor has one line for driving and braking")


def _lose_passive(joint: JointLosses) -> None:
    """Static friction and Stribeck (MuJoCo's frictionloss is one number), and the speed limit."""
    one_number = "frictionloss is one number for sticking and sliding"
    joint.no_break_away(joint.torque(0.0), one_number, "MuJoCo has no Stribeck effect")
    joint.no_velocity_limit("MuJoCo has no speed limit of a joint")


def _lose_network(joint: JointEmission[MujocoDialect]) -> None:
    """What a plain motor and the runtime lose of an actuator network."""
    actuator = joint.actuator
    joint.approximate(
        "network",
        actuator.network.name if actuator.network is not None else "a network",
        "<motor>, its control is the torque",
        "MuJoCo runs no network: the runtime computes the torque and writes it",
        None,
    )
    own = "a network holds what the logged drive did, its delay and filter too; the runtime adds none"
    if actuator.delay is not None and actuator.delay.nominal.value:
        asked = format_quantity(actuator.delay.nominal.value * 1e3, "ms")
        joint.approximate("delay", asked, "none", own, joint.late)
    joint.no_filter(own)
    joint.no_range("the runtime takes any command")
    _lose_passive(joint)
