"""Checks of kp and kd by how the joint's inertia swings with them: natural frequency and damping ratio."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from actspec.fields import units_of
from actspec.spec.plausible.relations import DEGREE, POINT
from actspec.units import format_quantity

if TYPE_CHECKING:
    from actspec.spec.plausible.gains import Gains

TOO_SOFT = 1.0
SOFT = 6.0
"""Natural frequency [rad/s], where the limit needs an error above `SOFT_ERROR`. Published: 6.2 and up, with the
links."""
SOFT_GEARED = 15.0
"""The same where an error is noticed by `ROTOR_ERROR`: a leg of 20 to 75 rad/s swings with 2 to 12 behind ten times the
gear, which gives ten times the torque and a hundred times the rotor."""
SOFT_ERROR = 10.0
"""Effort limit over kp [rad]: noticed where the natural frequency is below `SOFT`, or dry friction holds the joint.
Published, with a motor: to 2.2."""
ROTOR_ERROR = (10.0, 4.0)
"""Rotor behind its gear over the links [-], from which on an error above the second [rad] is noticed there, where kd
over kp is at most `SLACK_RETURN`. Published: 3 to 10 times; errors to 3.4, with a motor to 2.2."""
HELD_ERROR = 0.1
"""Dry friction over kp [rad]: noticed where viscous friction is above kd and the natural frequency below `SOFT`.
Chosen: arms are held within 0.003 rad, legs within 0.03."""
SLACK = ((10.0, 10.0), (5.0, 5.0))
"""Effort limit over kp [rad] above which, and natural frequency [rad/s] below which, a drive without a motor is as weak
that both gains may be per degree. Published, of 11577 drives: 22 rad at 13 rad/s (wrist of a YAM), 7.5 at 10, 5.7 at
9.6, 4 at 6.4, and below that to 1.6; but for 400 N*m beside 20 N*m/rad without friction (an early Prestoe)."""
SLACK_SERVO = ((25.0, math.inf), (10.0, 2.0))
"""Effort limit over kp [rad] above which, and kp [N*m/rad] below which, so is one of which nobody states friction
either, where it swings below `SLACK_SWING` and kd over kp is at most `SLACK_RETURN`. Published, of 6575 hinges of 1887
imported specs and the 11577 drives: 120 rad at 14 rad/s (ankle of a GR1T2), 25 at 16, 22 at 13, 8.8 at 2.7 (torso of a
Vega), and the Prestoe's 20."""
SLACK_SWING = 10.0
"""Natural frequency [rad/s]."""
SLACK_RETURN = 0.1
"""[s]. Legs have 0.01 to 0.05; the low gains beside a whole-body controller's torques have 0.2 and more."""
STIFF = 150.0
"""Natural frequency [rad/s]: noticed where the limit needs an error below `STIFF_ERROR`."""
STIFF_ERROR = 0.06
"""[rad]."""
FIRM = (500.0, 0.5, 3.0)
"""Natural frequency [rad/s] to which, and damping ratios [-] between which, a joint with a motor may be as stiff as
that if both gains have two digits, as of machines. Times 57.3 they have more; kp alone makes a tenth of the ratio."""
STIFF_LINK = 1e-3
"""Joints of less are fingers, which are stiff for their inertia [kg*m^2]."""
DIGITS = 1e-3
"""A number has two digits by this part."""
STIFFEST_SERVO = 3000.0
"""Natural frequency from which on also what may be a simulator's own servo, without a motor, is noticed [rad/s].
Published, of 2223 hinges: 5.9 to 719 (arms of a G1 that Isaac Lab holds with 3000 N*m/rad)."""
DAMPING_RATIO = (0.015, 60.0)
"""kd and viscous friction over 2 sqrt(kp I)."""


def frequency_words(
    gains: Gains, inertia: float, dry: float = 0.0, rotor: float = 0.0
) -> tuple[str, str, float] | None:
    """Message, help and size where the natural frequency of a hinge is no joint's; None where it may be one's.

    Args:
        gains: Of the hinge.
        inertia: With the other joints held, armature included [kg*m^2].
        dry: Friction [N*m].
        rotor: What of the inertia is a rotor's behind its gear [kg*m^2].
    """
    unit = units_of(gains.kind)
    frequency = math.sqrt(gains.kp / inertia)
    error = None if gains.limit is None else gains.limit / gains.kp
    message = _swing(gains, inertia)
    heavy = inertia >= STIFF_LINK
    heavier, most = ROTOR_ERROR
    geared = rotor > heavier * (inertia - rotor) and 0.0 < (gains.kd or 0.0) <= SLACK_RETURN * gains.kp
    slack = error is not None and error > (most if geared else SOFT_ERROR)
    tight = error is not None and error < STIFF_ERROR
    soft = frequency < TOO_SOFT and (gains.driven or heavy)
    held = is_held(gains.kp, gains.kd, dry, gains.viscous)
    if held:
        message += f"; the dry friction of {format_quantity(dry, unit.torque, 4)} alone holds it within "
        message += format_quantity(dry / gains.kp, unit.position, 3)
    low = SOFT_GEARED if geared and slack else SOFT
    if soft or (gains.driven and frequency < low and (slack or held)):
        degrees = format_quantity(gains.kp / DEGREE, unit.stiffness, 4)
        help = f"is it per degree? Per radian it is {degrees}, and kd 57.3 times as well"
        if tight and gains.limit is not None:
            # Stiff enough for the limit, it is the motor that cannot turn that inertia.
            pull = format_quantity(gains.limit / inertia, "rad/s^2", 3)
            help = f"the effort limit gives this inertia {pull} at most: one may be another robot's, or in another unit"
        return message, help, 1 / frequency
    stiff = (
        tight and frequency > STIFF and not _is_firm(gains, inertia)
        if gains.driven
        else frequency > STIFFEST_SERVO
    )
    if heavy and stiff:
        without = replace(gains, kp=gains.kp * DEGREE)
        help = f"is it multiplied by 57.3? Without that it is {without.shown_kp}"
        return message, POINT if without.kp > STIFF**2 * inertia else help, frequency
    return None


def is_held(kp: float, kd: float | None, dry: float, viscous: float) -> bool:
    """Whether friction holds a joint farther from its command than gains let it that are per radian."""
    return dry / kp > HELD_ERROR and (kd or 0.0) < viscous


def is_short(size: float) -> bool:
    """Whether a number has two digits at most."""
    return math.isclose(float(f"{size:.1e}"), size, rel_tol=DIGITS)


def _is_firm(gains: Gains, inertia: float) -> bool:
    """Whether a joint of that inertia [kg*m^2] is stiff and damped as a machine's, by gains that are no slip's."""
    kd = gains.kd or 0.0
    most, low, high = FIRM
    ratio = kd / (2.0 * math.sqrt(gains.kp * inertia))
    fits = gains.kp <= most**2 * inertia and low <= ratio <= high
    return fits and is_short(gains.kp) and is_short(kd)


def slack_words(gains: Gains, inertia: float, rubs: bool) -> tuple[str, str, float] | None:
    """Message, help and size where a hinge without a motor is so weak that its gains are per degree; None: it is not.

    Args:
        gains: Of the hinge.
        inertia: With the other joints held, armature included [kg*m^2].
        rubs: Whether its dry friction is stated; else it may be a simulator's own servo.
    """
    if inertia < STIFF_LINK or gains.limit is None:
        return None
    frequency, error = math.sqrt(gains.kp / inertia), gains.limit / gains.kp
    if rubs:
        weak = any(error > most and frequency < least for most, least in SLACK)
    else:
        weak = any(error > most and gains.kp < least for most, least in SLACK_SERVO)
        weak = weak and frequency < SLACK_SWING and 0.0 < (gains.kd or 0.0) <= SLACK_RETURN * gains.kp
    if not weak:
        return None
    unit = units_of(gains.kind)
    kp = format_quantity(gains.kp / DEGREE, unit.stiffness, 4)
    help = f"is it per degree? Per radian it is {kp}"
    if gains.kd:
        kd = format_quantity(gains.kd / DEGREE, unit.velocity_gain, 4)
        help = f"are kp and kd per degree? Per radian they are {kp} and {kd}"
    return _swing(gains, inertia), help, 1.0 / frequency


def _swing(gains: Gains, inertia: float) -> str:
    """What a kp makes of the joint's inertia [kg*m^2]."""
    message = (
        f"kp {gains.shown_kp} makes {format_quantity(math.sqrt(gains.kp / inertia), 'rad/s', 3)} of the joint's "
        f"{format_quantity(inertia, units_of(gains.kind).inertia, 3)}"
    )
    if gains.limit is not None:
        error = format_quantity(gains.limit / gains.kp, units_of(gains.kind).position, 3)
        message += f", and needs an error of {error} for the effort limit"
    return message


def damping_words(
    gains: Gains, inertia: float, friction: str = "the viscous friction"
) -> tuple[str, str, str, float] | None:
    """Which of `kd` and `viscous` makes a damping ratio that no hinge has, with message, help and size.

    Args:
        gains: Of the hinge.
        inertia: With the other joints held, armature included [kg*m^2].
        friction: What the file calls `gains.viscous`.

    Returns: None where the damping ratio may be one's.
    """
    unit = units_of(gains.kind)
    if not gains.kd or (not gains.driven and inertia < STIFF_LINK):
        return None
    own, both = (
        damping / (2.0 * math.sqrt(gains.kp * inertia)) for damping in (gains.kd, gains.kd + gains.viscous)
    )
    with_inertia = f"with the joint's {format_quantity(inertia, unit.inertia, 3)}"
    if own <= DAMPING_RATIO[1] < both and gains.viscous > gains.kd:
        message = (
            f"{friction} of {format_quantity(gains.viscous, unit.velocity_gain, 4)} beside kp {gains.shown_kp} makes a "
            f"damping ratio of {format_quantity(both, '', 2)} {with_inertia}; kd {gains.shown_kd} alone makes "
            f"{format_quantity(own, '', 2)}"
        )
        help = f"is it in m{unit.velocity_gain}, times 57.3, or the point in the wrong place?"
        return "viscous", message, help, both
    if own <= DAMPING_RATIO[1] and both >= DAMPING_RATIO[0]:
        return None
    message = (
        f"kd {gains.shown_kd} beside kp {gains.shown_kp} gives a damping ratio of {format_quantity(own, '', 2)} "
        f"{with_inertia}"
    )
    per = "per degree? Per radian it is " if own < 1 else "multiplied by 57.3? Without that it is "
    meant = gains.kd / DEGREE if own < 1 else gains.kd * DEGREE
    help = f"is kd {per}{format_quantity(meant, unit.velocity_gain, 4)}"
    return "kd", message, help, max(own, 1 / own)
