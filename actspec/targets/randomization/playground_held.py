"""What the MuJoCo target's model has of a joint, and which ranges it can hold."""

from __future__ import annotations

from dataclasses import dataclass

from actspec.ir import Command, JointActuator, Level, Randomization
from actspec.resolution.model_values import actuators_of, effort_bound
from actspec.robot.view import RobotView
from actspec.sampling import drawn_ends, nominal_of, own_ranges, unit_of
from actspec.simulators.mujoco import DcMotorDialect, MujocoDialect
from actspec.targets.randomization.draws import draws_of, stated_range
from actspec.targets.randomization.losses import Losses
from actspec.targets.randomization.sizes import factor_lost, lost

_REASONS = {
    "friction.static": "MuJoCo's frictionloss is one number for sticking and sliding",
    "friction.stribeck_velocity": "MuJoCo has no Stribeck friction",
    "delay": "a delay is a fixed number of steps of the model",
}


@dataclass(frozen=True, slots=True)
class Held:
    """What the MuJoCo target's model has of a joint.

    Attributes:
        form: `position`, `velocity`, `motor` or `dcmotor`: the drive's element.
        limited: Whether the drive has a force limit.
        capped: Whether the joint has a force range of its own too.
        frictionloss: Its dry friction [N*m or N].
    """

    form: str
    limited: bool
    capped: bool
    frictionloss: float


def held_of(actuator: JointActuator, robot: RobotView, dialect: MujocoDialect) -> Held:
    """What the written model has of a joint; the robot's own numbers where the spec has none."""
    joint = robot.joint(actuator.joint)
    limited, coulomb = actuator.effort_limit.known, actuator.friction_coulomb.value
    # A network's motor takes no limit of the file's own servo.
    if joint is not None and not limited and actuator.level is not Level.ACTUATOR_NET:
        limited = effort_bound(joint, actuators_of(robot, joint.name)) is not None
    if coulomb is None:
        coulomb = 0.0 if joint is None else joint.frictionloss
    capped = joint is not None and joint.effort_range is not None
    return Held(_form(actuator, dialect), limited, capped, coulomb)


def _form(actuator: JointActuator, dialect: MujocoDialect) -> str:
    """`position`, `velocity`, `motor` or `dcmotor`: what the MuJoCo target writes for the drive."""
    if actuator.level is Level.ACTUATOR_NET or actuator.level is Level.IDEAL_PD:
        pass
    elif dialect.dcmotor is DcMotorDialect.TORQUE or (
        dialect.dcmotor is DcMotorDialect.VOLTAGE and actuator.command is Command.POSITION
    ):
        return "dcmotor"
    if actuator.level is Level.ACTUATOR_NET or actuator.command is Command.EFFORT:
        return "motor"
    return {Command.POSITION: "position", Command.VELOCITY: "velocity"}[actuator.command]


def kept_ranges(actuator: JointActuator, held: Held, losses: Losses) -> dict[str, Randomization]:
    """The ranges that the model can hold; the others are reported."""
    form = held.form
    kept = {}
    draws = draws_of(actuator)
    for field, entry in own_ranges(actuator).items():
        draw = draws.get(field)
        reason = _REASONS.get(field)
        if field == "encoder_bias" and form != "position":
            reason = f"a <{form}> has no constant force to shift its position with"
        if actuator.level is Level.ACTUATOR_NET and field in ("kp", "kd", "gains"):
            reason = "the network has no gains"
        if field == "effort_limit" and not held.limited:
            reason = (
                "effort_limit is unknown, so the model's drive has no limit, and a drawn one does not act"
            )
        if field == "strength" and form == "motor" and not held.limited:
            reason = "the torque comes from outside of the model, which does not limit it"
        elif field == "strength" and form == "motor":
            reason = "the torque comes from outside of the model: only its limit follows"
            error = factor_lost(actuator, entry)
            losses.add(actuator, field, _asked(entry, actuator), "a factor on the limit", reason, error)
            reason = None
        elif field == "strength" and actuator.level is Level.DC_MOTOR and form != "dcmotor":
            # The model has no line, so there is none to scale: the loss is the MuJoCo target's.
            reason = None
        if reason is not None:
            if draw is not None:
                losses.dropped(draw, reason)
            else:
                losses.add(actuator, field, _asked(entry, actuator), "none", reason, None)
            continue
        if field == "friction.coulomb" and draw is not None and held.frictionloss == 0.0:
            losses.entry(
                draw,
                entry,
                "without effect in MJX's JAX implementation",
                "it has friction at those joints alone whose frictionloss is not 0 when the model is put on the "
                "device; its Warp implementation applies it",
                lost(draw),
            )
        if field == "encoder_bias" and draw is not None:
            losses.entry(
                draw,
                entry,
                "the drive's torque is shifted, the observation is not",
                "a model holds no encoder: add the bias to the observed joint positions too",
                None,
            )
        if entry.when != "startup":
            why = "Playground randomizes a model once"
            asked = f"{_asked(entry, actuator)}, drawn at {entry.when}"
            losses.add(actuator, field, asked, "drawn at startup", why, None)
        kept[field] = entry
    return kept


def _asked(entry: Randomization, actuator: JointActuator) -> str:
    return stated_range(entry, unit_of(actuator, entry.field))


def raises_limit(actuator: JointActuator, kept: dict[str, Randomization]) -> bool:
    """Whether a limit can be drawn above the nominal."""
    for field in ("effort_limit", "strength"):
        if field in kept:
            entry, nominal = kept[field], nominal_of(actuator, field) if field == "effort_limit" else 1.0
            neutral = {"scale": 1.0, "add": 0.0, "abs": nominal}[entry.operation]
            if neutral is None or drawn_ends(entry)[1] > neutral:
                return True
    return False
