"""One joint's actuator from everything that is said about it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from actspec.ir import InertiaRange, JointActuator, Level, MotorLine, Network, Origin, Quantity, unknown
from actspec.resolution.command_path import command_range, delay, filter_cutoff, randomizations
from actspec.resolution.gains import stiffness, velocity_gain
from actspec.resolution.motor import JointMotor
from actspec.resolution.quantities import choose, written
from actspec.resolution.stated import JointInputs
from actspec.spec.values import SpecValue
from actspec.units import Kind, format_quantity


def armature_of(inputs: JointInputs) -> Quantity:
    """Inertia that the drive adds to the joint [kg*m^2 or kg]: the motor's reflected one is derived.

    That the motor's inertia is written as unknown is no number that goes before the file's own, but it does go before
    MuJoCo's default of 0, which is nobody's.
    """
    derived, own, nobody = None, inputs.model.armature, None
    reflected = None if inputs.motor is None else inputs.motor.reflected_inertia
    if reflected is not None and reflected.known:
        derived = replace(
            reflected,
            origin=Origin.DERIVED,
            formula=reflected.formula or "reflected inertia of the motor",
        )
    elif reflected is not None and reflected.span is not None and _nobodys(own):
        why = "the motor's inertia is unknown, and the file states no armature"
        nobody = replace(reflected, unit=inputs.unit(Kind.INERTIA), note=why)
    found = inputs.number("armature", Kind.INERTIA, derived=derived, rest=(nobody, own))
    return found if found is not None else unknown(inputs.unit(Kind.INERTIA))


def _nobodys(quantity: Quantity | None) -> bool:
    """Whether the robot's file states no such number."""
    return quantity is None or quantity.origin is Origin.DEFAULT


def actuator_of(
    inputs: JointInputs,
    armature: Quantity,
    held: InertiaRange | None,
    free: InertiaRange | None,
    pose_pattern: str | None,
    network_path: Callable[[str], str],
) -> JointActuator:
    """The whole actuator, once its armature and inertia are known.

    Args:
        inputs: What is said about the joint.
        armature: From `armature_of`.
        held: Inertia with all other joints held; None: the model does not tell.
        free: Inertia with all other joints free, likewise.
        pose_pattern: Pattern of `default_pose` that names the joint.
        network_path: Path of a network's file from the one in the spec.
    """
    stated, motor = inputs.stated, inputs.motor
    _check_line(inputs)
    effort = effort_limit(inputs)
    kp = stiffness(inputs, effort, armature, held)
    kd = velocity_gain(inputs, kp, armature, held)
    line = motor if inputs.level is not Level.IDEAL_PD else None
    velocity = inputs.number("velocity_limit", Kind.SPEED, rest=(inputs.model.velocity_limit,))
    friction = _friction(inputs)
    bias = inputs.number("encoder_bias", Kind.POSITION)
    scale = stated.get("action_scale")
    network = stated.group.network
    group_path = ("actuators", stated.binding.group)
    return JointActuator(
        joint=inputs.joint.name,
        kind=inputs.kind,
        group=stated.binding.group,
        pattern=stated.binding.pattern,
        motor=None if motor is None else motor.name,
        level=inputs.level,
        command=inputs.command,
        kp=kp,
        kd=kd,
        effort_limit=effort,
        velocity_limit=velocity or unknown(inputs.unit(Kind.SPEED)),
        stall_torque=line.stall_torque if line is not None else None,
        no_load_speed=line.no_load_speed if line is not None else None,
        curve=line.curve if line is not None else None,
        motor_line=None
        if motor is None
        else MotorLine(motor.stall_torque, motor.no_load_speed, motor.curve, motor.bandwidth),
        peak_torque=motor.peak_torque if motor is not None else unknown(inputs.unit(Kind.TORQUE)),
        continuous_torque=motor.continuous_torque if motor is not None else unknown(inputs.unit(Kind.TORQUE)),
        armature=armature,
        reflected_inertia=motor.reflected_inertia
        if motor is not None
        else unknown(inputs.unit(Kind.INERTIA)),
        gear=None if motor is None else motor.gear,
        torque_constant=None if motor is None else motor.torque_constant,
        friction_coulomb=friction["coulomb"] or unknown(inputs.unit(Kind.TORQUE)),
        friction_static=friction["static"],
        friction_viscous=friction["viscous"] or unknown(inputs.unit(Kind.VELOCITY_GAIN)),
        stribeck_velocity=friction["stribeck_velocity"],
        filter_cutoff=filter_cutoff(inputs),
        command_range=command_range(inputs),
        delay=delay(inputs),
        encoder_bias=bias
        or Quantity(0.0, inputs.unit(Kind.POSITION), Origin.DEFAULT, note="no bias is stated"),
        action_scale=written(scale, "", inputs.span("action_scale"))
        if isinstance(scale, SpecValue)
        else None,
        default_position=_default_position(inputs, pose_pattern),
        position_range=inputs.joint.range,
        network=None
        if network is None
        else Network(
            None if network.file is None else network_path(network.file),
            None if network.manifest is None else network_path(network.manifest),
            stated.spec.span(*group_path, "network"),
        ),
        randomize=randomizations(inputs),
        inertia_held=held,
        inertia_free=free,
        span=stated.spec.span(*group_path),
    )


def _check_line(inputs: JointInputs) -> None:
    """Level dc_motor has its line: SPEC147 cannot see whether a joint's motors are those of a linkage."""
    motor = inputs.motor
    figures: tuple[Quantity | None, ...] = (None,)
    if motor is not None and motor.curve is not None:
        parts = motor.curve
        figures = (parts.drive_torque, parts.brake_torque, parts.knee_speed, parts.no_load_speed)
    elif motor is not None:
        figures = (motor.stall_torque, motor.no_load_speed)
    if inputs.level is Level.DC_MOTOR and not all(figure is not None and figure.known for figure in figures):
        whose = "" if motor is None else f" '{motor.name}'"
        inputs.error(
            "RES008",
            f"level dc_motor needs the torque-speed line of the motor{whose}, which is unknown",
            "motor",
            "state stall_torque and no_load_speed of each motor (or a curve of each), or use level ideal_pd",
        )


def effort_limit(inputs: JointInputs) -> Quantity:
    """L [N*m or N]: authored, else the motor's continuous, peak or stall torque, else the file's, else unknown."""
    value = inputs.stated.get("effort_limit")
    word = value if isinstance(value, str) else None
    candidates = [] if inputs.motor is None else _motor_torques(inputs.motor, word)
    if word is not None and not candidates:
        whose = "" if inputs.motor is None else f" '{inputs.motor.name}'"
        inputs.error(
            "RES008",
            f"the limit is to be the {word} torque of the motor{whose}, which is unknown",
            "effort_limit",
            f"state {word}_torque of the motor, or a torque here",
        )
    found = choose(
        inputs.stated.authored("effort_limit", Kind.TORQUE), *candidates, inputs.model.effort_limit
    )
    return found if found is not None else unknown(inputs.unit(Kind.TORQUE))


def _motor_torques(motor: JointMotor, word: str | None) -> list[Quantity]:
    """Known torques of a motor that can be the limit, the best first; only the one that `word` names."""
    named = {"continuous": motor.continuous_torque, "peak": motor.peak_torque}
    both = ", ".join(f"{name} {format_quantity(q.value, q.unit)}" for name, q in named.items())
    found = []
    for name, torque in named.items():
        if not torque.known or word not in (None, name):
            continue
        note = torque.note
        if word is None:
            note = both + (f"; {note}" if note else "")
        formula = torque.formula or f"{name}_torque of the motor"
        found.append(replace(torque, origin=Origin.DERIVED, formula=formula, note=note))
    stall = motor.curve.drive_torque if motor.curve is not None else motor.stall_torque
    if word is None and not found and stall is not None and stall.known:
        formula = stall.formula or "stall torque of the motor"
        note = "the motor states neither continuous nor peak torque"
        found.append(replace(stall, origin=Origin.DERIVED, formula=formula, note=note))
    return found


def _friction(inputs: JointInputs) -> dict[str, Quantity | None]:
    """Passive friction by part; None where nobody states it."""
    friction = {
        part: inputs.number(f"friction.{part}", kind, rest=(own,))
        for part, kind, own in (
            ("coulomb", Kind.TORQUE, inputs.model.friction_coulomb),
            ("viscous", Kind.VELOCITY_GAIN, inputs.model.friction_viscous),
            ("static", Kind.TORQUE, None),
            ("stribeck_velocity", Kind.SPEED, None),
        )
    }
    static, coulomb = friction["static"], friction["coulomb"]
    # Break-away friction is at least the kinetic one, wherever the two come from.
    if static is None or coulomb is None or None in (static.value, coulomb.value):
        return friction
    if static.require() < coulomb.require():
        inputs.error(
            "RES009",
            f"static friction {format_quantity(static.value, static.unit)} ({static.origin.value}) is below "
            f"coulomb friction {format_quantity(coulomb.value, coulomb.unit)} ({coulomb.origin.value})",
            "friction.static",
            "state both",
        )
    return friction


def _default_position(inputs: JointInputs, pattern: str | None) -> Quantity:
    unit = inputs.unit(Kind.POSITION)
    if pattern is None:
        return Quantity(0.0, unit, Origin.DEFAULT, note="no default_pose names the joint")
    spec = inputs.stated.spec
    value = spec.model.robot.default_pose[pattern]
    path = ("robot", "default_pose", pattern)
    inputs.check_unit(
        value, f"the default position is {value.written}", path, "a hinge is in rad, a slide in m"
    )
    return written(value, unit, spec.span(*path))
