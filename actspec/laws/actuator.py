"""The law of one joint's drive, from its actuator."""

from __future__ import annotations

import math
from dataclasses import dataclass

from actspec.diagnostics import Span
from actspec.ir import AsymmetricCurve, Command, JointActuator, Level, Quantity
from actspec.laws.arrays import Array
from actspec.laws.drive import clip_asymmetric, clip_dc_motor, clip_effort, position_pd, velocity_pd


@dataclass(frozen=True, slots=True)
class TorqueLaw:
    """The law of one joint's drive, without its passive part; joint side, SI.

    Attributes:
        command: What the command means.
        kp: [N*m/rad or N/m]; 0 unless the command is a position.
        kd: [N*m*s/rad or N*s/m]; 0 for an effort command.
        effort_limit: L [N*m or N]; infinity where it is unknown.
        stall_torque: The line at zero speed [N*m or N]; None without a line.
        no_load_speed: The line at zero torque [rad/s or m/s]; None without a line.
        curve: drive_torque, brake_torque [N*m or N], knee_speed, no_load_speed [rad/s or m/s];
            None without a curve.
        encoder_bias: q_measured = q + bias [rad or m].
        filter_cutoff: [Hz]; None without a filter.
        delay: Nominal delay [s].
        command_range: Low and high, in the command's unit; None: no clamp.
    """

    command: Command
    kp: float
    kd: float
    effort_limit: float
    stall_torque: float | None
    no_load_speed: float | None
    curve: tuple[float, float, float, float] | None
    encoder_bias: float
    filter_cutoff: float | None
    delay: float
    command_range: tuple[float, float] | None = None

    def torque(self, command: Array, q: Array, qd: Array) -> Array:
        """Torque of the drive at one state, clamped; the passive part is not in it.

        Args:
            command: Effective command, after clamp, delay and filter
                [rad or m], [rad/s or m/s] or [N*m or N].
            q: True position [rad or m]; no part unless the command is a position.
            qd: Speed [rad/s or m/s].

        Returns:
            Torque [N*m or N].

        Source:
            DESIGN section 5.
        """
        if self.command is Command.POSITION:
            tau = position_pd(command, q, qd, kp=self.kp, kd=self.kd, encoder_bias=self.encoder_bias)
        elif self.command is Command.VELOCITY:
            tau = velocity_pd(command, qd, kd=self.kd)
        else:
            tau = command
        if self.curve is not None:
            drive, brake, knee, no_load = self.curve
            return clip_asymmetric(
                tau,
                qd,
                drive_torque=drive,
                brake_torque=brake,
                knee_speed=knee,
                no_load_speed=no_load,
                effort_limit=self.effort_limit,
            )
        if self.stall_torque is not None and self.no_load_speed is not None:
            return clip_dc_motor(
                tau,
                qd,
                stall_torque=self.stall_torque,
                no_load_speed=self.no_load_speed,
                effort_limit=self.effort_limit,
            )
        return clip_effort(tau, effort_limit=self.effort_limit)


def law_of(actuator: JointActuator) -> TorqueLaw:
    """The torque law of one joint's actuator.

    What is unknown: the effort limit counts as infinite; filter, delay, encoder bias and an
    end of the command range as not there, as in a target that emits nothing for them. A gain or
    a point of the torque-speed curve has no such reading.

    Args:
        actuator: From `resolve` or `lift`.

    Returns:
        The law.

    Raises:
        ValueError: level `actuator_net`; a gain, line or curve that the level needs is unknown;
            a negative limit, or a line or curve that is none.

    Source:
        DESIGN sections 4 and 5.
    """
    name = actuator.joint
    if actuator.level is Level.ACTUATOR_NET:
        raise ValueError(f"{name}: level actuator_net has no torque law here: its torque is the network's")
    kp = kd = 0.0
    if actuator.command is Command.POSITION:
        kp = _known(actuator, "kp", actuator.kp)
    if actuator.command is not Command.EFFORT:
        kd = _known(actuator, "kd", actuator.kd)
    limit = actuator.effort_limit.value
    if limit is not None and not limit >= 0:
        raise ValueError(f"{name}: effort_limit must be >= 0 {actuator.effort_limit.unit}, got {limit:g}")

    stall = no_load = None
    curve = None
    if actuator.level is Level.DC_MOTOR and actuator.curve is not None:
        curve = _curve(actuator, actuator.curve)
    elif actuator.level is Level.DC_MOTOR:
        stall = _known(actuator, "stall_torque", actuator.stall_torque)
        no_load = _known(actuator, "no_load_speed", actuator.no_load_speed)
        if not (stall > 0 and no_load > 0):
            raise ValueError(
                f"{name}: stall_torque and no_load_speed must be > 0, got {stall:g} and {no_load:g}"
            )

    ends = actuator.command_range
    return TorqueLaw(
        command=actuator.command,
        kp=kp,
        kd=kd,
        effort_limit=math.inf if limit is None else limit,
        stall_torque=stall,
        no_load_speed=no_load,
        curve=curve,
        encoder_bias=_or(actuator.encoder_bias, 0.0),
        filter_cutoff=None if actuator.filter_cutoff is None else actuator.filter_cutoff.value,
        delay=0.0 if actuator.delay is None else _or(actuator.delay.nominal, 0.0),
        command_range=None if ends is None else (_or(ends[0], -math.inf), _or(ends[1], math.inf)),
    )


def _curve(actuator: JointActuator, curve: AsymmetricCurve) -> tuple[float, float, float, float]:
    drive = _known(actuator, "curve.drive_torque", curve.drive_torque)
    brake = _known(actuator, "curve.brake_torque", curve.brake_torque)
    knee = _known(actuator, "curve.knee_speed", curve.knee_speed)
    no_load = _known(actuator, "curve.no_load_speed", curve.no_load_speed)
    if not (drive >= 0 and brake >= 0):
        raise ValueError(
            f"{actuator.joint}: curve.drive_torque and brake_torque must be >= 0, got {drive:g} and {brake:g}"
        )
    if not 0 <= knee <= no_load:
        raise ValueError(
            f"{actuator.joint}: curve.knee_speed must be from 0 to no_load_speed, "
            f"got {knee:g} with no_load_speed {no_load:g}"
        )
    return drive, brake, knee, no_load


class LackedFigure(ValueError):
    """A law lacks a figure.

    Args:
        text: The joint, and what is lacking.
        field: Its name in the spec, such as `kd`.
        span: Where the spec says that it is unknown; None: nowhere.
    """

    def __init__(self, text: str, field: str, span: Span | None) -> None:
        super().__init__(text)
        self.field = field
        self.span = span


def _known(actuator: JointActuator, field: str, quantity: Quantity | None) -> float:
    if quantity is None or quantity.value is None:
        needs = f"level {actuator.level.value} with command {actuator.command.value}"
        text = f"{actuator.joint}: {field} is unknown, {needs} needs it"
        raise LackedFigure(text, field, None if quantity is None else quantity.span)
    return quantity.value


def _or(quantity: Quantity, default: float) -> float:
    return default if quantity.value is None else quantity.value
