"""Checks of kp and kd at joints: by the effort limit, the inertia and the speed that the joint has, and alone."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from actspec.fields import is_power_of_ten
from actspec.ir import Command, JointActuator, JointKind, Origin, Quantity
from actspec.spec.plausible.commands import own_speed
from actspec.spec.plausible.driven import AGREES
from actspec.spec.plausible.gains import (
    PLACEHOLDER_RETURN,
    RETURN,
    SERVO_ERROR,
    STIFF_RETURN,
    STIFF_SERVO_RETURN,
    STRONG,
    Gains,
    gain_words,
)
from actspec.spec.plausible.relations import DEGREE, POINT
from actspec.spec.plausible.swing import (
    ROTOR_ERROR,
    SOFT,
    SOFT_GEARED,
    STIFFEST_SERVO,
    damping_words,
    frequency_words,
    is_short,
    slack_words,
)
from actspec.spec.plausible.table import Found, found_at, in_file, is_files, is_stated, shown
from actspec.units import format_quantity

SLOWEST_SPIN_UP = 0.052
"""Time in which a motor turns its own rotor to its speed [s]. Published: 0.005 (Go2) to 0.052 (STS3215)."""
GEAR_TOO_LARGE = "is a gear too large?"
"""How what is asked of a gear begins."""
LEAST_SPEED = {JointKind.HINGE: 1e-2, JointKind.SLIDE: 1e-3}
"""Effort limit over a kd without kp [rad/s or m/s]: a smaller error of speed asks for all of it. Published: 0.15, of
servos with a kp 0.07."""
TRAVELS, TRAVELS_OF_SERVO = 25.0, 150.0
"""Effort limit over kp of a slide over its travel: with a motor, or where it swings below `SOFT`; and else. Published:
17 (fingers of an X5, 15 N and 20 N/m), without a motor to 60 (fingers of a Panda, 240 N and 100 N/m)."""
PER_MM = 1e3
"""A gain per metre over the same per millimetre."""
LEAST_DAMPING = 1e-4
"""A kd whose kp nobody states over the effort limit of a strong hinge [s/rad]. Published: 6.7e-3 (ANYmal D)."""
CLEAR = 3.0
"""What is offered for such a kd is inside of these bounds by this factor."""
LEAST_SHARE = 1e-3
"""Of the effort limit that a drive of speeds asks for at rest when the fastest is commanded. Chosen."""


def gains_found(joint: JointActuator) -> Iterator[Found]:
    """What is found of kp and kd.

    Args:
        joint: A joint of a resolved spec.
    """
    kp, kd = joint.kp, joint.kd
    if joint.command is Command.EFFORT or joint.network is not None:
        return
    known = None if kp is None else kp.value
    if kp is not None and known == 0.0:
        yield from _no_drive(joint, kp)
    elif kp is not None and known:
        yield from _both(joint, kp)
    elif kd is not None and kd.value and is_stated(kd):
        yield from _alone(joint, kd)


def _no_drive(joint: JointActuator, kp: Quantity) -> Iterator[Found]:
    """A drive of positions whose gains are both 0."""
    kd = joint.kd
    if joint.command is not Command.POSITION or not is_stated(kp):
        return
    if kd is None or kd.value != 0.0:
        return
    message = f"kp {shown(kp)} and kd {shown(kd)}: whatever the command is, the drive gives no torque"
    help = "write `command: effort` where the command is a torque, and list joints that nothing drives as unmanaged"
    yield found_at(joint, "SPEC192", f"actuators.{joint.group}.kp", 1.0, message, help, kp, kd)


def _alone(joint: JointActuator, kd: Quantity) -> Iterator[Found]:
    """A kd without a kp, or beside one that is unknown, by what it gives at the speeds that the joint has."""
    limit, hinge, size = joint.effort_limit, joint.kind is JointKind.HINGE, kd.require()
    where, most = f"actuators.{joint.group}.kd", limit.value or 0.0
    if 0.0 < most < math.inf and most / size < LEAST_SPEED[joint.kind] and not _is_placeholder(joint, kd):
        reached = format_quantity(most / size, joint.velocity_limit.unit, 3)
        message = f"kd {shown(kd)} asks for the effort limit of {shown(limit)} at a speed of {reached}"
        meant = _slip(joint, kd, DEGREE, "is it multiplied by 57.3? Without that it is")
        yield found_at(joint, "SPEC192", where, size, message, meant, kd, limit)
        return
    speed = own_speed(joint)
    speed = joint.velocity_limit if speed is None or not speed.value else speed
    fast, friction = speed.value or 0.0, joint.friction_coulomb
    if joint.command is not Command.VELOCITY:
        if hinge and STRONG <= most < math.inf and size < LEAST_DAMPING * most:
            message = f"kd {shown(kd)} is hardly any damping beside the effort limit of {shown(limit)}"
            meant = _slip(joint, kd, 1.0 / DEGREE, "is it per degree? Per radian it is")
            yield found_at(joint, "SPEC192", where, 1.0 / size, message, meant, kd, limit)
        return
    torque, rub = size * fast, friction.value or 0.0
    if not 0.0 < fast < math.inf or torque >= max(rub, LEAST_SHARE * most if most < math.inf else 0.0):
        return
    given = format_quantity(torque, limit.unit, 3)
    message = f"kd {shown(kd)} gives {given} at rest where {shown(speed)} are commanded"
    message += (
        f": the joint's own dry friction of {shown(friction)} holds it"
        if torque < rub
        else f", of an effort limit of {shown(limit)}"
    )
    meant = _slip(joint, kd, 1.0 / DEGREE, "is it per degree? Per radian it is")
    yield found_at(joint, "SPEC192", where, 1.0 / size, message, meant, kd, friction, speed, limit)


def _slip(joint: JointActuator, kd: Quantity, factor: float, words: str) -> str:
    """What a kd may have been, if that is well inside of the joint's own bounds; else that its point may be wrong."""
    meant = kd.require() * factor
    well = replace(kd, value=meant / CLEAR if factor > 1.0 else meant * CLEAR)
    # What was multiplied by 57.3 is hardly a multiple of 100.
    round_number = factor < 1.0 and kd.require() % 100.0 == 0.0
    if joint.kind is not JointKind.HINGE or round_number or any(_alone(joint, well)):
        return POINT
    return f"{words} {format_quantity(meant, kd.unit, 4)}. Or {POINT}"


def _is_placeholder(joint: JointActuator, gain: Quantity) -> bool:
    """Whether a gain is what simulators have for a rigid joint; who states friction as well describes a real one."""
    if joint.motor is not None:
        return False
    return is_files(gain) or (is_power_of_ten(gain.require()) and not _is_real(joint))


def _is_real(joint: JointActuator) -> bool:
    """Whether a joint's own drive is described, and not only a simulator's servo: it has a motor, or dry friction."""
    return joint.motor is not None or (
        is_stated(joint.friction_coulomb) and bool(joint.friction_coulomb.value)
    )


def _noticed_softness(joint: JointActuator) -> float:
    """Times `LARGEST_ERROR` from which on a kp is too soft; never by a limit that is often nobody's, a power of ten."""
    size = joint.effort_limit.value or 0.0
    if joint.motor is None and 100.0 <= size < math.inf and is_power_of_ten(size):
        return math.inf
    return 1.0 if _is_real(joint) else SERVO_ERROR


def _both(joint: JointActuator, kp: Quantity) -> Iterator[Found]:
    """kp and kd by each other, natural frequency and damping ratio."""
    kd, held, limit = joint.kd, joint.inertia_held, joint.effort_limit
    if not (is_stated(kp) or is_stated(kd)) or joint.command is not Command.POSITION:
        return
    active, speed = None if kd is None else kd.value, own_speed(joint)
    if speed is None and is_stated(joint.velocity_limit):
        # As slow as its motor, which nobody describes.
        speed = joint.velocity_limit
    gains = Gains(
        kp.require(),
        active,
        joint.friction_viscous.value or 0.0,
        limit.value if joint.kind is JointKind.HINGE or is_stated(limit) else None,
        joint.motor is not None,
        _noticed_return(joint, kp),
        joint.kind,
        _noticed_softness(joint),
        None if speed is None else speed.value,
        joint.armature.value or 0.0,
    )
    places = {"kp": kp.span, "kd": None if kd is None else kd.span}
    if joint.kind is JointKind.SLIDE and gain_words(replace(gains, limit=None), places) is None:
        # By the travel, which is known here, the same is told sooner and better than by the error alone.
        far = list(_by_travel(joint, gains))
        yield from far
        if far:
            return
    found: tuple[str, str, str | None, float] | None = None
    if (alone := gain_words(gains, places)) is not None:
        found = (*alone, abs(math.log(max(active or 0.0, 1e-9) / kp.require())))
    elif held is not None and joint.kind is JointKind.HINGE and held.reference > 0.0:
        found = _by_inertia(joint, gains, held.reference)
        rotor = _unstated_rotor(joint)
        # What the armature that is missing may explain is no matter of the gains.
        if found is not None and rotor and not _by_inertia(joint, gains, held.reference + rotor):
            found = None
    if found is None:
        return
    field, message, help, size = found
    figures = {"kp": kp, "kd": kd, "friction.viscous": joint.friction_viscous}
    # What nobody wrote is told at what somebody did.
    field = next(name for name in (field, "kp", "kd") if is_stated(figures[name]))
    number, other = figures[field], kd if field == "kp" else kp
    assert number is not None
    where = f"actuators.{joint.group}.{field}"
    yield found_at(joint, "SPEC192", where, size, message, help, number, other, limit, joint.armature)


def _by_inertia(joint: JointActuator, gains: Gains, inertia: float) -> tuple[str, str, str, float] | None:
    """Which of kp, kd and friction makes a motion that no hinge of that inertia [kg*m^2] has; message, help, size."""
    kp, kd = joint.kp, joint.kd
    if kp is None:
        return None
    words = None
    if joint.motor is not None or _is_of_degrees(kp, kd):
        # Without a motor they may be a simulator's own servos, of any stiffness, but hardly just 57.3 times others.
        words = _by_frequency(kp, kd, joint, replace(gains, driven=True), inertia)
    elif _noticed_softness(joint) < math.inf:
        words = slack_words(gains, inertia, _is_real(joint))
    if words is not None:
        return "kp", *words
    damped = damping_words(gains, inertia)
    if damped is None:
        return None
    # Friction is no simulator's servo's.
    of_kd = damped[0] == "kd"
    judged = kd if of_kd else joint.friction_viscous
    if judged is None or not is_stated(judged) or (of_kd and joint.motor is None):
        return None
    return "kd" if of_kd else "friction.viscous", *damped[1:]


def _unstated_rotor(joint: JointActuator) -> float:
    """What a motor of which nobody states an inertia may have at its joint [kg*m^2]; 0: it is stated, or unknown."""
    speed, limit = own_speed(joint), joint.effort_limit.value or 0.0
    fast = 0.0 if speed is None else speed.value or 0.0
    if joint.motor is None or joint.armature.value or is_stated(joint.armature):
        return 0.0
    return limit * SLOWEST_SPIN_UP / fast if fast > 0.0 and 0.0 < limit < math.inf else 0.0


def _by_travel(joint: JointActuator, gains: Gains) -> Iterator[Found]:
    """A slide that needs an error of many times its travel for its effort limit."""
    kp, kd, limit, ends, held = (
        joint.kp,
        joint.kd,
        joint.effort_limit,
        joint.position_range,
        joint.inertia_held,
    )
    if kp is None or gains.limit is None or not 0.0 < gains.limit < math.inf or ends is None or is_files(kp):
        return
    travel, error = ends[1] - ends[0], gains.limit / gains.kp
    swing = math.sqrt(gains.kp / held.reference) if held is not None and held.reference > 0.0 else None
    slow = swing is not None and swing < SOFT
    most = TRAVELS if joint.motor is not None or slow else TRAVELS_OF_SERVO
    if not 0.0 < most * travel < error or _noticed_softness(joint) == math.inf:
        return
    times = (
        f"{format_quantity(error, 'm', 3)}, {format_quantity(error / travel, '', 3)} times the joint's travel"
    )
    path = f"actuators.{joint.group}"
    if swing is not None and swing * math.sqrt(PER_MM) > STIFFEST_SERVO:
        # Per metre no joint would swing as fast.
        message = f"an effort limit of {shown(limit)}: kp {gains.shown_kp} asks for it at an error of {times}"
        help = "look for a wrong unit or power of ten"
        yield found_at(joint, "SPEC192", f"{path}.effort_limit", error / travel, message, help, limit, kp, kd)
        return
    message = f"kp {gains.shown_kp} needs an error of {times}, for the effort limit of {shown(limit)}"
    help = f"is kp per mm? Per metre it is {format_quantity(PER_MM * gains.kp, kp.unit, 4)}"
    if gains.kd and kd is not None:
        both = [format_quantity(PER_MM * gain.require(), gain.unit, 4) for gain in (kp, kd)]
        help = f"are kp and kd per mm? Per metre they are {' and '.join(both)}"
    if not slow:
        # By its own mass the joint is as quick as others.
        help = f"one of 2 numbers is wrong. kp: {help}. Or the effort limit ({limit.span}): look for a wrong unit"
    number, other = (kp, kd) if is_stated(kp) or kd is None else (kd, kp)
    where = f"{path}.{'kp' if number is kp else 'kd'}"
    yield found_at(joint, "SPEC192", where, error / travel, message, help, number, other, limit)


def _noticed_return(joint: JointActuator, kp: Quantity) -> float:
    """kd over kp below which a stiff joint is noticed [s]; 0: never, where the robot's file has that kp."""
    if joint.motor is not None:
        return STIFF_RETURN
    if is_files(kp):
        return 0.0
    return PLACEHOLDER_RETURN if _is_placeholder(joint, kp) else STIFF_SERVO_RETURN


def _is_of_degrees(kp: Quantity, kd: Quantity | None) -> bool:
    """Whether kp and kd are both 57.3 times a number of two digits, and neither is such a number."""
    sizes = [0.0 if gain is None else gain.value or 0.0 for gain in (kp, kd)]
    return all(size > 0.0 and is_short(size * DEGREE) and not is_short(size) for size in sizes)


def _is_said(limit: Quantity) -> bool:
    """Whether the robot's file has about the effort limit that the motor gives."""
    said = in_file(*limit.lost)
    return said is not None and limit.require() / AGREES < (said.value or 0.0) < limit.require() * AGREES


def _by_frequency(
    kp: Quantity, kd: Quantity | None, joint: JointActuator, gains: Gains, inertia: float
) -> tuple[str, str, float] | None:
    """Message, help and size where the natural frequency is no joint's."""
    stiffness, armature = kp.require(), joint.armature
    rotor = (armature.value or 0.0) if armature.origin is Origin.DERIVED else 0.0
    words = frequency_words(gains, inertia, joint.friction_coulomb.value or 0.0, rotor)
    if words is None:
        return None
    message, help, size = words
    links = inertia - (armature.value or 0.0)
    if SOFT**2 * inertia <= stiffness < SOFT_GEARED**2 * inertia and _is_said(joint.effort_limit):
        return None
    if stiffness < SOFT_GEARED**2 * inertia:
        if armature.origin is Origin.DERIVED and stiffness > SOFT**2 * links:
            gear = f"{GEAR_TOO_LARGE} {shown(armature)} of the inertia is the armature: {armature.formula}"
            # What is hardly anything but the rotor is hardly the links'.
            help = f"{gear}. Or {help}" if rotor > ROTOR_ERROR[0] * links else f"{help}. Or {gear}"
    elif help != POINT and kd is not None and kd.value and kd.value > RETURN[1] * stiffness * DEGREE:
        # Alone kp would be too soft for that kd.
        both = [format_quantity(gain.require() * DEGREE, gain.unit, 4) for gain in (kp, kd)]
        help = f"are kp and kd multiplied by 57.3? Without that they are {' and '.join(both)}"
    return message, help, size
