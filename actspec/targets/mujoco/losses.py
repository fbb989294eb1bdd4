"""What a MuJoCo drive cannot hold of what the spec asks for, and how much torque that makes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain

from actspec.ir import Command, JointActuator, Level
from actspec.laws import TorqueLaw, delay_steps
from actspec.simulators.mujoco import DcMotorDialect, MujocoDialect
from actspec.targets.approximation import held_step_error, static_error
from actspec.targets.base import Approximation
from actspec.targets.mujoco.drive import Drive, Form
from actspec.units import format_quantity

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
