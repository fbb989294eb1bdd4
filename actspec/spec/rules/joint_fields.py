"""Rules of the fields that a group states and an override may state anew."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from actspec.diagnostics import nearest
from actspec.spec.fields import CommandRange, SpecDelay
from actspec.spec.models import Actuators, CommandFilter, Friction, Motor, Tunable
from actspec.spec.paths import Path
from actspec.spec.rules.breaches import Breaches
from actspec.spec.rules.gears import check_stages
from actspec.spec.values import SpecValue
from actspec.units import Kind

IDENTIFY = "add `identified: results/FILE.yaml` to the group"
"""What to write where an identified number is asked for."""

COMMANDED = {"position": Kind.POSITION, "velocity": Kind.SPEED, "effort": Kind.TORQUE}
"""Quantity kind of each command."""


def check_joint_fields(
    path: Path,
    fields: Tunable,
    group: Actuators,
    motors: Mapping[str, Motor],
    breaches: Breaches,
    *,
    linked: bool,
) -> None:
    """The fields fit the group's command, its motor and each other.

    Args:
        path: Where they are written.
        fields: The group's own, or an override's.
        group: The group.
        motors: The spec's motors.
        breaches: Takes what is wrong.
        linked: Whether a linkage names motors of some of the group's joints.
    """
    if fields.motor is not None and fields.motor not in motors:
        guess = nearest(fields.motor, sorted(motors))
        breaches.error(
            "SPEC141",
            f"no motor is named '{fields.motor}'",
            (*path, "motor"),
            f"did you mean '{guess}'?" if guess else "add it to `motors`",
        )
    _check_command(path, fields, group.command, breaches)
    _check_gears(path, fields, group, breaches)
    motor = motors.get(fields.motor or group.motor or "")
    if motor is not None or not linked:
        _check_from_motor(path, fields, motor, breaches)
    if fields.friction is not None:
        _check_friction((*path, "friction"), fields.friction, breaches)
    if group.identified is None:
        _check_unidentified(path, fields, breaches)


def _check_command(path: Path, fields: Tunable, command: str, breaches: Breaches) -> None:
    """Gains and range mean something with the command."""
    for gain, commands in (("kp", ("velocity", "effort")), ("kd", ("effort",))):
        if getattr(fields, gain) is not None and command in commands:
            breaches.error(
                "SPEC142",
                f"`{gain}` has no meaning with `command: {command}`",
                (*path, gain),
                "remove it"
                if command == "velocity"
                else "remove it: with `command: effort` the command is the torque, the gains are the caller's",
            )
    limits, wanted = fields.command_range, COMMANDED[command]
    if isinstance(limits, CommandRange) and limits.kind not in (None, wanted):
        breaches.error(
            "SPEC148",
            f"the command is a {wanted.noun} (`command: {command}`), its range "
            f"[{limits.low.written}, {limits.high.written}] is not",
            (*path, "command_range"),
            f"a {wanted.noun} is in {wanted.rotary_unit} (hinge) or {wanted.linear_unit} (slide)",
        )


def _check_gears(path: Path, fields: Tunable, group: Actuators, breaches: Breaches) -> None:
    """The way from motor to joint is stated once."""
    if fields.transmission is not None:
        check_stages((*path, "transmission"), fields.transmission, breaches)
        for index, stage in enumerate(fields.transmission):
            if stage.efficiency is not None and stage.efficiency.value is None:
                breaches.error(
                    "SPEC131",
                    "the torque passes this stage, but its `efficiency` is unknown",
                    (*path, "transmission", index, "efficiency"),
                    "state it, or remove it to take 1",
                )
    for key, other in (("transmission", "reduction"), ("reduction", "transmission")):
        stated = getattr(fields, other) is not None or getattr(group, other) is not None
        if getattr(fields, key) is not None and stated:
            breaches.error(
                "SPEC137",
                f"`{key}` and `{other}` both say what is between the motor's output and the joint",
                (*path, key),
                "write the reduction as a stage of the transmission: `{ratio: 2}`",
            )
            return


def _check_from_motor(path: Path, fields: Tunable, motor: Motor | None, breaches: Breaches) -> None:
    """What is to be the motor's is known of the motor."""
    bandwidth = None if motor is None or motor.bandwidth is None else motor.bandwidth.value
    if fields.command_filter == "from_motor" and bandwidth is None:
        breaches.error(
            "SPEC143",
            "`command_filter: from_motor` needs the motor's `bandwidth`",
            (*path, "command_filter"),
            "state the motor's bandwidth, or write command_filter: {cutoff: 30 Hz}",
        )
    if not isinstance(fields.effort_limit, str):
        return
    if motor is None:
        breaches.error(
            "SPEC144",
            f"`effort_limit: {fields.effort_limit}` needs a motor",
            (*path, "effort_limit"),
            "add `motor: NAME`, or write a torque here",
        )
    elif not _states_torque(motor, fields.effort_limit):
        breaches.error(
            "SPEC144",
            f"{fields.effort_limit}_torque of the motor is not known",
            (*path, "effort_limit"),
            f"state {fields.effort_limit}_torque of the motor, or a torque here",
        )


def _states_torque(motor: Motor, which: str) -> bool:
    """Whether `continuous` or `peak` torque is known; an authored `unknown` says that it is not."""
    stated = motor.continuous_torque if which == "continuous" else motor.peak_torque
    if stated is not None:
        return stated.value is not None
    current = motor.nominal_current if which == "continuous" else motor.peak_current
    return all(part is not None and part.value is not None for part in (motor.torque_constant, current))


def _check_friction(path: Path, friction: Friction, breaches: Breaches) -> None:
    if friction.static is None or friction.coulomb is None:
        return
    static, coulomb = friction.static.value, friction.coulomb.value
    if static is not None and coulomb is not None and static < coulomb:
        breaches.error(
            "SPEC145",
            f"static friction {friction.static.written} is below coulomb friction {friction.coulomb.written}",
            (*path, "static"),
            "break-away friction is at least the kinetic one; are the two swapped?",
        )


def _check_unidentified(path: Path, fields: Tunable, breaches: Breaches) -> None:
    """Without results no field is `identified`."""
    values: dict[Path, Any] = {
        (field,): getattr(fields, field) for field in ("kp", "kd", "armature", "encoder_bias")
    }
    if fields.friction is not None:
        for part in ("coulomb", "viscous", "static", "stribeck_velocity"):
            values["friction", part] = getattr(fields.friction, part)
    if isinstance(fields.delay, SpecDelay):
        values["delay",] = fields.delay.nominal
    if isinstance(fields.command_filter, CommandFilter):
        values["command_filter", "cutoff"] = fields.command_filter.cutoff
    for at, value in values.items():
        if isinstance(value, SpecValue) and value.identified:
            breaches.error(
                "SPEC146",
                "asks for the identified value, but the group names no results",
                (*path, *at),
                IDENTIFY,
            )
