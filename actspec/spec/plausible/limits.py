"""Checks of the effort and velocity limits of joints by weight, power, inertia and gains; which of the two is wrong."""

from __future__ import annotations

import math
from collections.abc import Iterator

from actspec.diagnostics import alternatives, listed
from actspec.fields import FRICTION_SHARE, GRAVITY, LONGEST_LEVER, is_power_of_ten
from actspec.ir import JointActuator, JointKind, Origin
from actspec.spec.models import Motor
from actspec.spec.plausible.armatures import ARMATURE_RATE, LARGEST_LIMIT
from actspec.spec.plausible.commands import own_speed
from actspec.spec.plausible.drive import gear_of, number
from actspec.spec.plausible.driven import FASTEST_SLIDE
from actspec.spec.plausible.motors import FASTEST_BY_TORQUE
from actspec.spec.plausible.relations import DEGREE, KGF_CM, POINT, RPM
from actspec.spec.plausible.slips import servo_time
from actspec.spec.plausible.table import Found, found_at, in_file, is_files, is_stated, shown
from actspec.units import format_quantity

FASTEST_LIMIT = 200.0
"""Velocity limit of a hinge [rad/s]. Published: to 200 (gripper of the reBot), 110 at 26 N*m (Qinglong)."""
HOPELESS_SPEED = 3.0
"""Times what no joint of such a torque comes to: it is told though the robot's file says it as well."""
TIMES_WEIGHT = 75.0
"""Effort limit of a slide over the weight of the robot. Published: 37 (three linear axes), of robots 21 (roller screws
of a leg) and 18 (lift of an OpenArm); chosen: an electric gripper alone has 170."""
HOPELESS_LEVER = 10.0
"""An error from this many times the bound on."""
USUAL_SPEED = (0.3, 50.0)
"""Velocity limits that are nobody's slip [rad/s]. Published: to 37."""
USUAL_ARMATURE = 3e-3
"""An armature of so much is no rotor's alone, beside an effort limit above `LARGEST_LIMIT` [kg*m^2]."""

SLOW_SPEED = 0.3
"""No-load speed of a motor without a stated gear, below which gains are asked [rad/s]. Chosen: large arms have 1."""
SPIN_UP = 2e-3
"""Time to that speed by the motor's own inertia, from which on it is right [s]. Published: 0.005 to 0.052."""
SLOW_RETURN = 1.5
"""Effort limit over kp, over that speed [s]. Published: to 0.1 (legs); chosen: a slow joint has a stiff drive."""
NO_SPEED = 0.02
"""Below it no joint of a robot moves: a turn takes 5 minutes [rad/s]."""
ABOUT_FILE = 5.0
"""The robot's file has about such a speed by this factor."""
SERVO_SUPPLY = 8.4
SERVO_TORQUE = 10.0
"""A motor of two cells or less [V] and of less torque [N*m] is a servo, and none is slower than `SLOW_SPEED`. Chosen:
their sheets have 0.05 to 0.3 s for 60 deg, and 8 N*m at most."""
GEARED_SUPPLY = 14.8
"""The same of four cells or less [V], of a servo whose gear and rotor are stated."""
SPUN_UP = 5e-4
"""Time in which its torque turns its rotor to that speed [s], below which that is none. Published: 5e-3 to 0.052."""
LEVER = 1.8
"""Effort limit over the robot's weight [m]. Published: to 1.7 (Aloha), but for a UR10's 330 N*m on a UR3 (3.2)."""
RATE = 3.1e4
"""Effort limit over armature [rad/s^2]. Published, of 20 N*m and more: to 3e4 (H1)."""
ERROR = (3.5e-3, 4.0)
"""Effort limit over kp [rad]. Published: to 3.4, with 10 (fingers) and 25 (ankles of the Berkeley humanoid)."""
POWER = 9e3
"""Effort limit times velocity limit [W]. Published: to 8410 (hips of the GR1)."""
TOGETHER = 3
"""Of these four, from which on they tell that the limit is wrong. Published, of 6051 hinges: one."""


def _by_weight(joint: JointActuator, mass: float | None, linkage: str | None) -> Iterator[Found]:
    """An effort limit that would hold the whole robot on a lever which no robot has, or lift it many times over.

    Args:
        joint: A joint with a motor: others may be toys. gymnasium's ant has 150 N*m and less than 1 kg.
        mass: Of the whole robot [kg]; None: unknown, or it is no robot.
        linkage: That drives the joint.
    """
    limit, slides = joint.effort_limit, joint.kind is JointKind.SLIDE
    if not mass or not joint.kind.is_scalar or not limit.value or not is_stated(limit):
        return
    most = TIMES_WEIGHT if slides else LONGEST_LEVER
    size = limit.value / (mass * GRAVITY)
    if not most < size < math.inf:
        return
    robot = f"the whole robot, {format_quantity(mass, 'kg', 3)},"
    message, causes = f"hold {robot} on a lever of {format_quantity(size, 'm', 3)}", "gear_ratio or side"
    if slides:
        message, causes = (
            f"lift {robot} {format_quantity(size, '', 2)} times over",
            "lead, radius or gear_ratio",
        )
    yield found_at(
        joint,
        "SPEC183",
        f"actuators.{joint.group}.effort_limit",
        size,
        f"an effort limit of {shown(limit)} would {message}",
        f"look for a wrong unit, {causes}" + (f", or at the linkage '{linkage}'" if linkage else ""),
        limit,
        error=size > HOPELESS_LEVER * most,
    )


def _by_all(joint: JointActuator, mass: float | None) -> Iterator[Found]:
    """An effort limit of a hinge without a motor that its other figures contradict together.

    Args:
        joint: The joint.
        mass: Of the whole robot [kg]; None: unknown, or it is no robot.
    """
    limit = joint.effort_limit
    size = limit.value
    if joint.kind is not JointKind.HINGE or not is_stated(limit) or is_files(limit):
        return
    if not size or size == math.inf:
        return
    against = _against(joint, size, mass)
    weak = _too_weak(joint, size)
    if not weak and not (len(against) >= TOGETHER or (size > LARGEST_LIMIT and _is_gross(joint, size))):
        return
    yield found_at(
        joint,
        "SPEC183",
        f"actuators.{joint.group}.effort_limit",
        max(size, 1.0 / size),
        f"an effort limit of {shown(limit)} means {listed(against or weak, 4)}: no robot has such figures",
        _meant(joint, size, mass),
        limit,
        joint.armature,
        joint.kp,
        joint.velocity_limit,
    )


def _against(joint: JointActuator, size: float, mass: float | None) -> list[str]:
    """What an effort limit [N*m] makes with other figures that no published robot has."""
    found = []
    speed, armature, kp = joint.velocity_limit, joint.armature, joint.kp
    if speed.value and is_stated(speed) and not is_power_of_ten(speed.value) and size * speed.value > POWER:
        power = format_quantity(size * speed.value / 1e3, "kW", 3)
        found.append(f"{power} at the velocity limit of {shown(speed)}")
    if armature.value and is_stated(armature) and size / armature.value > RATE:
        rate = format_quantity(size / armature.value, "rad/s^2", 3)
        found.append(f"{rate} for the armature of {shown(armature)} alone")
    if kp is not None and kp.value and is_stated(kp) and size / kp.value > ERROR[1]:
        found.append(f"an error of {format_quantity(size / kp.value, 'rad', 3)} with kp {shown(kp)}")
    if mass and size / (mass * GRAVITY) > LEVER:
        lever = format_quantity(size / (mass * GRAVITY), "m", 3)
        found.append(f"a lever of {lever} for the whole robot, {format_quantity(mass, 'kg', 3)}")
    return found


def _too_weak(joint: JointActuator, size: float) -> list[str]:
    """What an effort limit [N*m] is too small for: the armature and kp, where both say so."""
    armature, kp = joint.armature, joint.kp
    if not armature.value or not is_stated(armature) or kp is None or not kp.value or not is_stated(kp):
        return []
    if size / armature.value >= ARMATURE_RATE[0] or size / kp.value >= ERROR[0]:
        return []
    return [
        f"{format_quantity(size / armature.value, 'rad/s^2', 3)} for the armature of {shown(armature)} alone",
        f"an error of {format_quantity(size / kp.value, 'rad', 3)} with kp {shown(kp)}",
    ]


def _is_gross(joint: JointActuator, size: float) -> bool:
    """Whether one figure of a usual size is impossible beside an effort limit [N*m] that no hinge has."""
    speed, armature = joint.velocity_limit, joint.armature
    if (
        speed.value
        and is_stated(speed)
        and FASTEST_BY_TORQUE / math.sqrt(size) < speed.value <= USUAL_SPEED[1]
    ):
        return True
    return bool(
        armature.value
        and is_stated(armature)
        and armature.value >= USUAL_ARMATURE
        and size / armature.value > ARMATURE_RATE[1]
    )


def _meant(joint: JointActuator, size: float, mass: float | None) -> str:
    """What an effort limit may have been, with which no other figure is odd."""

    def fits(other: float) -> bool:
        kp, friction = joint.kp, joint.friction_coulomb.value or 0.0
        soft = kp is None or not kp.value or ERROR[0] <= other / kp.value
        return (
            soft
            and friction < FRICTION_SHARE * other
            and not _against(joint, other, mass)
            and not _too_weak(joint, other)
        )

    units = ((1e-3, "mN*m"), (KGF_CM, "kgf*cm"))
    readings = [
        f"is it in {unit}? Then it is {format_quantity(float(f'{size * factor:.4g}'), 'N*m', 4)}"
        for factor, unit in units
        if fits(size * factor)
    ]
    points = [power for power in (-1, -2, -3, 1, 2, 3) if fits(size * 10.0**power)]
    if points and not (points == [-3] and readings):
        only = f"did you mean {format_quantity(size * 10.0 ** points[0], 'N*m', 4)}?"
        readings.append(only if len(points) == 1 else POINT)
    return alternatives(readings) or "look for a wrong unit"


def velocity_found(joint: JointActuator) -> Iterator[Found]:
    """A velocity limit beyond any joint's, where no motor's speed stands: with one it is judged by that.

    What the robot's file says as well is not mistyped here, unless no joint comes near it, and powers of ten are
    placeholders.
    """
    limit, force, own = joint.velocity_limit, joint.effort_limit, own_speed(joint)
    fast = limit.value
    if own is not None and own.value:
        return
    if not fast or limit.origin is not Origin.AUTHORED or is_power_of_ten(fast):
        return
    hinge = joint.kind is JointKind.HINGE
    strong = force.value if hinge and force.value and force.value < math.inf else 0.0
    most = FASTEST_BY_TORQUE / math.sqrt(strong) if strong else math.inf
    if fast <= min(most, FASTEST_LIMIT if hinge else FASTEST_SLIDE):
        return
    if is_files(limit) and fast <= HOPELESS_SPEED * most:
        return
    words = f"a velocity limit of {shown(limit)}"
    if fast > most:
        power = f"{strong * fast / 1000.0:.3g} kW"
        words += f" is {power} beside the effort limit of {shown(force)}: no joint of such a torque is nearly as fast"
    else:
        words += f": the fastest {joint.kind.value}s of robots have {'200 rad/s' if hinge else '10 m/s'}"
    slips = [(DEGREE, "deg/s"), (RPM, "rpm")] if hinge else [(1e-3, "mm/s")]
    least, usual = USUAL_SPEED if hinge else (0.0, 5.0)
    readings = [
        f"is it in {unit}? Then it is {format_quantity(fast * factor, limit.unit, 4)}"
        for factor, unit in slips
        if least <= fast * factor <= min(0.5 * most, usual)
    ]
    help = alternatives(readings) or "look for a wrong unit"
    # One of the two is of no usual size, or nothing tells which it is.
    sure = fast > USUAL_SPEED[1] and strong <= LARGEST_LIMIT
    if fast > most and is_stated(force) and not sure:
        help = f"one of 2 numbers is wrong. velocity_limit: {help}"
        help += f"{'' if help.endswith('?') else '.'} Or effort_limit ({force.span}): look for a wrong unit"
    yield found_at(
        joint,
        "SPEC184",
        f"actuators.{joint.group}.velocity_limit",
        fast,
        words,
        help,
        limit,
        force if fast > most else None,
    )


def slow_found(joint: JointActuator, motor: Motor | None) -> Iterator[Found]:
    """A no-load speed with which the joint of a robot cannot do what its gains ask for.

    Of a motor whose gear is stated the speed of the rotor is judged, and here only a servo's whose rotor says that it
    is faster; a file with about such a speed says it as well.

    Args:
        joint: A joint with a motor.
        motor: The motor.
    """
    speed, limit, kp = own_speed(joint), joint.effort_limit, joint.kp
    if motor is None or joint.kind is not JointKind.HINGE or speed is None:
        return
    fast, most, said = (
        speed.value or 0.0,
        limit.value or 0.0,
        in_file(*joint.velocity_limit.lost, joint.velocity_limit),
    )
    if not 0.0 < fast < SLOW_SPEED or not 0.0 < most < LARGEST_LIMIT:
        return
    if said is not None and said.value and said.value < ABOUT_FILE * fast:
        return
    turned = (joint.reflected_inertia.value or 0.0) * fast / most
    if turned > SPIN_UP:
        # A heavy motor is as slow as that.
        return
    volts = number(motor.nominal_voltage) or 0.0
    geared = gear_of(motor) is not None
    small = 0.0 < volts <= (GEARED_SUPPLY if geared else SERVO_SUPPLY) and most < SERVO_TORQUE
    timed = servo_time(fast)
    if geared and not (small and timed and 0.0 < turned < SPUN_UP):
        return
    error = 0.0 if kp is None or not kp.value else most / kp.value
    if fast < NO_SPEED:
        message = f"a no-load speed of {shown(speed)}: one turn takes {format_quantity(2.0 * math.pi / fast, 's', 3)}"
    elif error > SLOW_RETURN * fast:
        message = (
            f"a no-load speed of {shown(speed)}: the joint takes {format_quantity(error / fast, 's', 3)} for the "
            f"{format_quantity(error, 'rad', 3)} at which kp {shown(kp) if kp is not None else ''} asks for the effort "
            f"limit of {shown(limit)}"
        )
    elif small:
        supply = motor.nominal_voltage.written if motor.nominal_voltage is not None else ""
        message = (
            f"a no-load speed of {shown(speed)} of a motor of {supply} and {shown(limit)}: usual servos turn "
            "with 3 rad/s or more"
        )
    else:
        return
    help = "look for a wrong unit, or the point in the wrong place"
    if timed is not None:
        help = f"{timed[1]}; or {help}"
    where = f"motors.{joint.motor}.{'no_load_speed' if motor.curve is None else 'curve.no_load_speed'}"
    yield found_at(
        joint, "SPEC184", where, 1.0 / fast, message, help, speed, kp if fast >= NO_SPEED else None
    )


def levers_of(
    joint: JointActuator, mass: float | None, body: float | None, linkage: str | None
) -> Iterator[Found]:
    """What is found of an effort limit by the weight of the robot and by all other figures together.

    Args:
        joint: The joint.
        mass: Of the whole robot [kg]; None: unknown, or there are too few hinges for one.
        body: The same for slides.
        linkage: That drives the joint.
    """
    if joint.motor is None:
        yield from _by_all(joint, mass)
    else:
        yield from _by_weight(joint, body if joint.kind is JointKind.SLIDE else mass, linkage)
