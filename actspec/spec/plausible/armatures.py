"""Checks of an armature: against the motor's inertia, effort limit and links, and the other joints of its group."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from actspec.diagnostics import Span
from actspec.ir import JointActuator, JointKind, Origin
from actspec.spec.models import Motor
from actspec.spec.plausible.drive import gear_of, number
from actspec.spec.plausible.driven import given_at
from actspec.spec.plausible.groups import turns
from actspec.spec.plausible.slips import in_si
from actspec.spec.plausible.swing import SOFT
from actspec.spec.plausible.table import Found, found_at, is_stated, shown
from actspec.spec.values import SpecValue
from actspec.units import format_quantity

OF_MOTOR = (0.3, 3.0)
"""Armature over the inertia of the motor at the joint."""
OF_MOTOR_FITTED = (0.1, 10.0)
"""The same of an identified one, which holds gears and shafts that no sheet of the motor has, and what the links'
masses are off by. Published: 2.8 to 5.7 times (fit of a Go2, in robots/SOURCES.md)."""
COUPLED = 300.0
"""The most of one where there is no model that has the links: what is coupled to the rotor may be meant. Chosen: a
propeller has 6 times its motor's, flywheels 100, and g as kg are 1000."""
ARMATURE_RATE = (5.0, 3e5)
"""Effort limit over armature [rad/s^2 or m/s^2]."""
SPIN_UP = 0.2
"""What reaches the motor's speed in this time is not too heavy, however slow [s]. Chosen: a linear servo has 4 ms."""
ROTOR_ALONE = 3e6
"""The same, of a joint with a motor whose links are not known."""
HEAVY = 50.0
"""Armature over the inertia of the links: noticed where `HEAVY_RATE` holds too."""
HEAVY_RATE = 30.0
TOO_HEAVY = 300.0
TOO_HEAVY_OF_MOTOR = 1000.0
"""The same of an armature that follows from rotor and gear, which are judged by themselves. Chosen: the flange of a
KR 210's wrist, without a tool, has 507."""
OWN_GEAR = 0.01
"""An armature is that of rotor and gear alone by this part; beside it are a reduction, more motors, stages."""
SLOW = 0.5
"""Time in which the motor's torque turns the armature to its speed [s], as of rotors in SPEC185 (published: to 0.052):
noticed where it is `DOMINANT` times the links or, of unknown ones, where kp swings it alone below `SOFT`."""
DOMINANT = 10.0
"""[-]. Published: 124 (gymnasium's ant, which has no motor); behind a gear 3 to 10 are usual."""
LARGEST_LIMIT = 700.0
"""Effort limit of a hinge [N*m]. Published: 494 (Apollo's hip) to 700 (torso of the Vega, 0.9 rad/s)."""
STRONG = 20.0
"""Effort limit [N*m] from which links that are not known, as in the text of a model, are more than `SMALL_LINK`.
Published: 20 N*m and more over the armature is 2e4 rad/s^2 at most (an AgileX Piper)."""
SMALL_LINK = 2e-3
"""Links of less are fingers, whose armature is seldom the rotor's [kg*m^2]."""
ODD = 10.0
"""An armature over that of the other joints of its group, either way. Published: to 3 (results of one motor)."""
SEVERAL = 3
"""Other joints from which they show what is usual."""


def armature_found(
    joint: JointActuator, drive: Motor | None, alone: bool, written: Mapping[Span, SpecValue]
) -> Iterator[Found]:
    """An armature against the motor's inertia, the effort limit and the links.

    Args:
        joint: The joint.
        drive: Its motor.
        alone: The robot has no model, in which the links would be.
        written: Numbers as they are written, by where.
    """
    own, held = joint.armature, joint.inertia_held
    plain = None if own.span is None else in_si(written.get(own.span))
    meant = None
    if plain is not None and plain.value is not None:
        more = plain.value - (own.value or 0.0)
        held = None if held is None else replace(held, low=held.low + more, high=held.high + more)
        meant = replace(joint, armature=replace(own, value=plain.value), inertia_held=held)
    for found in _armature_found(joint, drive, alone):
        if plain is not None and meant is not None and not any(_armature_found(meant, drive, alone)):
            help = f"did you mean {plain.written}? Or {found.doubt.help}"
            found = replace(found, doubt=replace(found.doubt, help=help))
        yield found


def _armature_found(joint: JointActuator, drive: Motor | None, alone: bool) -> Iterator[Found]:
    armature, limit = joint.armature, joint.effort_limit
    if not is_stated(armature) or not armature.value:
        return
    value, unit = armature.value, armature.unit
    motor = joint.reflected_inertia
    if armature.origin is not Origin.DERIVED and motor.value:
        ratio = value / motor.value
        fitted = armature.origin is Origin.IDENTIFIED
        low, high = OF_MOTOR_FITTED if fitted else OF_MOTOR
        high = COUPLED if alone and not fitted else high
        if not low <= ratio <= high:
            if fitted:
                help = "look for a wrong power of ten in the results, or a wrong rotor inertia or gear of the motor"
            elif ratio < 1:
                help = "is it the rotor's own, before the gear? Leave armature out: it follows from the motor"
            else:
                help = "leave armature out: it follows from the motor; or correct the one that is wrong"
            yield found_at(
                joint,
                "SPEC191",
                f"actuators.{joint.group}.armature",
                max(ratio, 1 / ratio),
                f"an armature of {shown(armature)} is {format_quantity(ratio, '', 3)} times the "
                f"{shown(motor)} that the motor has at the joint ({motor.formula or 'as stated'})",
                help,
                armature,
                motor,
            )
            return
    rate, given = limit.value / value if limit.value else None, given_at(joint)
    # What the drive gives turns it, too, where less is allowed.
    turned = None if rate is None else (given.value or 0.0) / value
    slow = turned is not None and turned < ARMATURE_RATE[0]
    links = None if joint.inertia_held is None else joint.inertia_held.high - value
    words = None
    # Rotor and gear are judged by themselves (SPEC185). What turns with an exoskeleton's joint stands in no model.
    of_rotor = drive is not None and _is_of_rotor(value, drive)
    # What has such a torque is no finger, whatever its links are.
    unknown_large = joint.inertia_held is None and (limit.value or 0.0) >= STRONG
    large = joint.kind is JointKind.HINGE and (unknown_large if links is None else links >= SMALL_LINK)
    unknown = links is None and joint.motor is not None
    line = joint.motor_line
    fast = None if line is None or line.no_load_speed is None else line.no_load_speed.value
    if turned and fast and fast < SPIN_UP * turned < SPIN_UP * ARMATURE_RATE[0]:
        return
    # A cylinder or a voice coil has no rotor that may be before a gear: what moves is stated as it is.
    rotor = drive is None or drive.rotor_inertia is not None or turns(drive)
    if rate is not None and (
        slow or (rotor and ((rate > ARMATURE_RATE[1] and large) or (rate > ROTOR_ALONE and unknown)))
    ):
        torque = (
            f"the drive's {shown(given)}"
            if slow and given is not limit
            else f"the effort limit of {shown(limit)}"
        )
        unit_of_rate = "rad/s^2" if joint.kind is JointKind.HINGE else "m/s^2"
        words = (
            f"an armature of {shown(armature)}: {torque} would turn the rotor alone with "
            f"{format_quantity(turned if slow else rate, unit_of_rate, 3)}"
        )
    elif large and links is not None:
        most = TOO_HEAVY_OF_MOTOR if armature.origin is Origin.DERIVED else TOO_HEAVY
        heavy = HEAVY if turned is not None and turned < HEAVY_RATE and not of_rotor else most
        if value >= heavy * links:
            words = (
                f"an armature of {shown(armature)} is {format_quantity(value / links, '', 3)} times the inertia of "
                f"the links that the joint moves, at most {format_quantity(links, unit, 3)}"
            )
    stall = 0.0 if line is None or line.stall_torque is None else line.stall_torque.value or 0.0
    strong, kp = max(given.value or 0.0, stall), 0.0 if joint.kp is None else joint.kp.value or 0.0
    if words is None and not of_rotor and fast and 0.0 < strong < math.inf and joint.kind is JointKind.HINGE:
        takes = value * fast / strong
        heavy = value >= DOMINANT * links if links is not None and large else 0.0 < kp < SOFT**2 * value
        if takes > SLOW and heavy:
            words = (
                f"an armature of {shown(armature)}: the motor's {format_quantity(strong, limit.unit, 4)} takes "
                f"{format_quantity(takes, 's', 3)} to turn that alone to its {format_quantity(fast, 'rad/s', 4)}"
            )
    if words is None:
        return
    much = rate is None or rate < ARMATURE_RATE[1]
    help = "is it the rotor's own, before the gear? The armature is rotor inertia x gear^2"
    if much:
        slip = "g*cm^2 as kg*m^2" if joint.kind is JointKind.HINGE else "g as kg"
        help = f"look for a wrong unit ({slip}), or a gear that is counted twice"
    elif drive is None and is_stated(limit) and (limit.value or 0.0) > LARGEST_LIMIT:
        help += f". Or is the limit wrong ({limit.span})?"
    yield found_at(
        joint,
        "SPEC191",
        f"actuators.{joint.group}.armature",
        value if much else 1 / value,
        words,
        help,
        armature,
        limit,
        motor,
        None if line is None else line.no_load_speed,
    )


def _is_of_rotor(armature: float, motor: Motor) -> bool:
    """Whether an armature is just the rotor's inertia through the motor's own gear [kg*m^2]."""
    rotor, gear = number(motor.rotor_inertia), gear_of(motor)
    return bool(rotor and gear) and math.isclose(
        armature, (rotor or 0.0) * (gear or 0.0) ** 2, rel_tol=OWN_GEAR
    )


def beside(joint: JointActuator, joints: Sequence[JointActuator]) -> Iterator[JointActuator]:
    """The other joints of its group."""
    for other in joints:
        if other.group == joint.group and other.kind is joint.kind and other is not joint:
            yield other


def odd_armature_found(joint: JointActuator, joints: Sequence[JointActuator]) -> Iterator[Found]:
    """An armature of one joint's own, far from what the others of its group have with one drive."""
    armature = joint.armature
    if not is_stated(armature) or not armature.value or armature.origin is Origin.DERIVED:
        return
    others = sorted(other.armature.value for other in beside(joint, joints) if other.armature.value)
    if len(others) < SEVERAL:
        return
    usual = others[len(others) // 2]
    ratio = armature.value / usual
    if 1.0 / ODD < ratio < ODD or not 1.0 / ODD < usual / others[0] < ODD > others[-1] / usual:
        return
    times = f"{format_quantity(max(ratio, 1.0 / ratio), '', 3)} times {'above' if ratio > 1.0 else 'below'}"
    yield found_at(
        joint,
        "SPEC191",
        f"actuators.{joint.group}.armature",
        max(ratio, 1.0 / ratio),
        f"an armature of {shown(armature)} is {times} the {format_quantity(usual, armature.unit, 4)} of the other "
        f"joints of {joint.group}, which have one drive",
        "look for a wrong power of ten or unit, or give a joint with another drive a group of its own",
        armature,
    )
