"""Checks of kp and kd by each other and by the effort limit; what needs the joint's inertia is in `joints`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Path, Span, alternatives, dotted
from actspec.fields import Units, units_of
from actspec.joints import JointKind
from actspec.spec.plausible.relations import ALIKE, DEGREE, RARE, Relation, Repair, explained
from actspec.spec.plausible.swing import is_short
from actspec.spec.plausible.table import Doubt, at
from actspec.units import format_quantity

if TYPE_CHECKING:
    from actspec.spec.document import SourceMap
    from actspec.spec.fields import DerivedGain

RETURN = (5e-4, 1.0)
"""kd over kp [s]: the time in which a joint without inertia returns."""
USUAL_RETURN = (0.005, 0.25)
RETURN_RATIO = 4.0
"""Damping ratio by the armature alone up to which a joint may take longer: it is as slow by its own inertia. Published:
2.5 (the fingers of Meta-World's Sawyer: 100 kg, 400 N/m and 1000 N*s/m, 2.5 s). Chosen: a little more."""
LEAST_RETURN = 3e-4
"""The same of kd alone, where it is not 0 [s]: a joint that swings with 200 rad/s and a damping ratio of 0.03 has it.
Published: 7e-3."""
LEAST_ERROR = 0.015
"""Effort limit over kp [rad]: noticed where kd over kp is below `STIFF_RETURN`. Chosen: stiff arms have 0.006, at
0.05 s."""
STIFF_RETURN = 2e-3
"""[s]. A joint that swings with 100 rad/s and a damping ratio of 0.1 has it."""
STIFF_SERVO_RETURN = 1e-4
"""The same without a motor [s]. Published, of the 0.015 rad: 4e-4 (an so101 with 1600 N*m/rad and 3.35 N*m), from
damping of the joint; but for stiffnesses of 1e5 and 1e7, which are placeholders of a rigid joint (2e-5, agibot)."""
PLACEHOLDER_RETURN = 2e-6
"""The same of a rigid joint's stiffness, as simulators have it [s]."""
STRONG = 10.0
"""Effort limit [N*m] from which a joint moves more than a finger: fingers have links so light that they need no kd."""
SOFT_ERROR = 0.3
"""Effort limit over kp [rad], from which on a strong joint is no stiff servo: legs have 0.36 to 2.2."""
SOFT_RETURN = (1e-3, 5e-3)
"""kd over kp, and with friction, of such a joint [s]: noticed where both are below. Published: 7.1e-3 (an ANYmal D),
and 1e-2 without a motor; 0.03 / 57.3 is 5e-4."""
FIRM_ERROR = 0.03
"""Effort limit over kp of a strong joint [rad]: noticed where kd and friction over kp are below `FIRM_RETURN`, with a
motor or without. Multiplied by 57.3, the 0.36 to 1.7 of legs are in it."""
FIRM_RETURN = 8e-4
"""[s]. Published, of the 0.03 rad: 1.9e-3 (Talos with 10000 N*m/rad and 100 N*m); 0.03 / 57.3 is 5e-4."""
LARGEST_ERROR = {JointKind.HINGE: 50.0, JointKind.SLIDE: 10.0}
"""Effort limit over kp [rad or m]: where the drive gives all that it has. Published: 0.21 to 2.2, without a motor to
25, and of slides to 0.375 m."""
SERVO_ERROR = 20.0
"""Times as much of servos of which nobody states motor or friction. Published: 250 rad (fingers of a Robotiq gripper
with 0.2 N*m/rad and 50 N*m, a spring in a linkage)."""
USUAL_ERROR = (0.06, 10.0)
USUAL_ERRORS = {JointKind.HINGE: USUAL_ERROR, JointKind.SLIDE: (1e-3, 1.0)}
USUAL_SPEED = (2.5, 300.0)
"""Effort limit over kd of a hinge [rad/s]: where kd alone asks for all of it. Between two explanations it decides.
Published: 3.5 to 148, and of a simulator's own servos from 0.07 on."""
OWN_SPEED = 0.2
"""The least that is usual of that over the joint's own speed, where the joint is slow. Chosen: a strain wave drive of
4.2 rad/s with 0.08 s of kd over kp has 0.22."""
LEAST_KNOWN_ERROR = 2e-3
"""Effort limit over kp of a weak joint whose kd nobody states [rad]. Published: 3.5e-3."""
LEAST_SLIDE_ERROR = 1e-4
"""The same of a slide [m]: noticed where kd over kp is below `STIFF_SERVO_RETURN`. Published: 0.02."""
FREQUENCY = (0.15, 100.0)
"""Natural frequency that a kp is derived from [Hz]. Chosen: mjlab's is 10, the stiffest published servo has 236."""
RATIO = (0.015, 60.0)
"""Damping ratio. Published: 0.064 to 12."""


FRACTION = (1e-3, 5.0)
"""Part of the effort limit at an error. Chosen: per cent are 10 and more."""
RADIANS = 1.0
"""Largest error that a kp is derived from [rad] and that is not asked for degrees. Chosen: limit over kp is 0.21 to 2.2
rad."""
LARGEST_OWN_ERROR = {JointKind.HINGE: math.pi, JointKind.SLIDE: 1.0}
"""Error that a kp is derived from [rad or m]. Chosen: no hinge is half a turn off, and mm are a thousand times more."""
_NO_UNITS = Units("", "", "", "", "", "")
_ANY = (0.0, math.inf)
_WHOLE = (1.0, math.inf)
"""Of a figure as a part of its bound."""


@dataclass(frozen=True, slots=True)
class Gains:
    """Gains of one hinge or slide.

    Attributes:
        kp: [N*m/rad or N/m].
        kd: [N*m*s/rad or N*s/m]; None: unknown.
        viscous: Friction [N*m*s/rad or N*s/m].
        limit: Effort limit [N*m or N]; None: unknown.
        driven: A motor is stated. Without one they may be a simulator's own servos, of nearly any stiffness.
        stiff: kd over kp below which a limit that is reached at `LEAST_ERROR` is noticed [s]; 0: never.
        kind: Of the joint.
        soft: Times `LARGEST_ERROR` from which on a kp is noticed.
        speed: That the motor lets the joint have [rad/s]; None: unknown.
        armature: [kg*m^2 or kg]; 0: unknown.
        known: Whether the kind is known; else it is taken for a hinge, without units and without what degrees explain.
    """

    kp: float
    kd: float | None
    viscous: float
    limit: float | None
    driven: bool
    stiff: float
    kind: JointKind
    soft: float = 1.0
    speed: float | None = None
    armature: float = 0.0
    known: bool = True

    @property
    def units(self) -> Units:
        """Of what is said of it."""
        return units_of(self.kind) if self.known else _NO_UNITS

    @property
    def shown_kp(self) -> str:
        """As one writes it."""
        return format_quantity(self.kp, self.units.stiffness, 4)

    @property
    def shown_kd(self) -> str:
        """As one writes it."""
        return format_quantity(self.kd, self.units.velocity_gain, 4)


def gain_words(gains: Gains, places: Mapping[str, Span | None]) -> tuple[str, str, str | None] | None:
    """Which of kp and kd cannot be right, message and help; None where both may be.

    Args:
        gains: The two.
        places: Where they are written, by `kp` and `kd`.
    """
    before = list(_relations(gains))
    broken = [relation for relation in before if relation.broken]
    if not broken:
        return None
    best = explained(before, _repairs(gains))
    if not best:
        return _by_size(gains, broken[0].message, places)
    (place,) = best[0].paths[0]
    mine = [repair.help for repair in best if repair.paths == best[0].paths and repair.help is not None]
    help = alternatives(mine)
    rivals = [repair for repair in best if repair.paths != best[0].paths]
    if place == "kd" and not rivals:
        rivals = _exchange_as_good(gains, broken[0])
    if gains.limit is None and best[0].help in _degrees(gains):
        # The effort limit would tell which of the two it is.
        slips = ("given per degree", "multiplied by 57.3")
        first, second = slips if broken[0].about == "slow" else slips[::-1]
        help, place = f"is kp {first}, or kd{_there(places, 'kd')} {second}?", "kp"
    elif rivals:
        (other,) = rivals[0].paths[0]
        help = f"one of 2 numbers is wrong. {place}: {help}{'' if help.endswith('?') else '.'} "
        help += f"Or {other}{_there(places, str(other))}: {rivals[0].help}"
    return str(place), broken[0].message, help


def _by_size(gains: Gains, message: str, places: Mapping[str, Span | None]) -> tuple[str, str, str]:
    """Of two gains that no usual slip explains the one whose own size is odd beside the effort limit; else both."""
    help, limit, usual = "look for a wrong unit or power of ten", gains.limit or 0.0, USUAL_ERRORS[gains.kind]
    if not gains.kd:
        return "kp", message, help
    odd = [
        field
        for field, size, (least, most) in (("kp", gains.kp, usual), ("kd", gains.kd, USUAL_SPEED))
        if not least <= limit / size <= most
    ]
    if len(odd) == 1 and gains.kind is JointKind.HINGE:
        return odd[0], message, help
    return "kp", message, f"one of 2 numbers is wrong, kp or kd{_there(places, 'kd')}: {help}"


def _there(places: Mapping[str, Span | None], field: str) -> str:
    return "" if places.get(field) is None else f" ({places[field]})"


def _relations(gains: Gains) -> Iterator[Relation]:
    if not gains.kp:
        return
    hinge, kd = gains.kind is JointKind.HINGE, gains.kd
    back, damped = (kd or 0.0) / gains.kp, ((kd or 0.0) + gains.viscous) / gains.kp
    pair = f"kd {gains.shown_kd} beside kp {gains.shown_kp}"
    hardly = f"{pair}: hardly any damping, kd/kp is {format_quantity(1000.0 * back, 'ms', 3)}"
    if kd:
        # Inertia makes it slower.
        at_least = "" if gains.armature else "at least "
        slow = f"{pair}: the joint would take {at_least}{format_quantity(back, 's', 3)} to come back to its command"
        # kd is 2 I w times the damping ratio, and kp I w^2.
        heavy = 2.0 * RETURN_RATIO * math.sqrt(gains.armature / gains.kp)
        yield _relation(back, (0.0, max(RETURN[1], heavy)), USUAL_RETURN, slow, "slow")
        yield _relation(damped, (RETURN[0] if gains.driven else 0.0, math.inf), _ANY, hardly, "undamped")
        if gains.driven:
            yield _relation(back, (LEAST_RETURN, math.inf), _ANY, hardly, "undamped by kd")
    if not gains.limit or gains.limit == math.inf:
        return
    units = gains.units
    error = gains.limit / gains.kp
    limit, shown = format_quantity(gains.limit, units.torque, 4), format_quantity(error, units.position, 3)
    largest = f"kp {gains.shown_kp} needs an error of {shown} for the effort limit of {limit}"
    yield _relation(
        error, (0.0, gains.soft * LARGEST_ERROR[gains.kind]), USUAL_ERRORS[gains.kind], largest, "error"
    )
    if kd and hinge:
        # Any may be; of two explanations it tells which.
        usual = (min(USUAL_SPEED[0], OWN_SPEED * (gains.speed or math.inf)), USUAL_SPEED[1])
        yield _relation(gains.limit / kd, _ANY, usual, "", "speed")
    # Each of these is broken where both of its figures are below their bounds.
    strong = hinge and gains.limit >= STRONG
    if strong and error >= SOFT_ERROR and kd:
        part = max(back / SOFT_RETURN[0], damped / SOFT_RETURN[1])
        yield _relation(part, _WHOLE, _WHOLE, hardly, "undamped and soft")
    stiff = f"kp {gains.shown_kp} asks for the effort limit of {limit} at an error of {shown}"
    servo = gains.stiff > PLACEHOLDER_RETURN
    if servo and kd is None and hinge:
        least = LEAST_ERROR if strong else LEAST_KNOWN_ERROR
        yield _relation(error, (least, math.inf), _ANY, stiff, "stiff")
    elif gains.stiff and damped:
        stiff += f", with kd {gains.shown_kd}"
        if strong and servo:
            yield _relation(max(error / FIRM_ERROR, damped / FIRM_RETURN), _WHOLE, _WHOLE, stiff, "firm")
        least, prompt = (LEAST_ERROR, gains.stiff) if hinge else (LEAST_SLIDE_ERROR, STIFF_SERVO_RETURN)
        yield _relation(max(error / least, damped / min(prompt, gains.stiff)), _WHOLE, _WHOLE, stiff, "stiff")


def _relation(
    value: float, bounds: tuple[float, float], usual: tuple[float, float], message: str, about: str
) -> Relation:
    return Relation("SPEC192", value, bounds, usual, message, ("kp",), None, about=about)


def _repairs(gains: Gains) -> Iterator[Repair]:
    kp, kd = gains.kp, gains.kd
    yield from _exchanged(gains)
    for field in ("kp", "kd") if kd else ("kp",):
        factors = [(10.0**power, "did you mean {}?", RARE) for power in (-4, -3, -2, -1, 1, 2, 3, 4)]
        if gains.kind is JointKind.SLIDE:
            factors.append((1e3, f"is {field} per mm? Per metre it is {{}}", 0.0))
        for factor, words, rare in factors:
            other = _changed(gains, **{field: factor})
            meant = other.shown_kp if field == "kp" else other.shown_kd
            yield Repair(tuple(_relations(other)), ((field,),), words.format(meant), rare)
    if gains.kind is JointKind.SLIDE:
        if kd:
            both = _changed(gains, kp=1e3, kd=1e3)
            help = f"are kp and kd per mm? Per metre they are {both.shown_kp} and {both.shown_kd}"
            yield Repair(tuple(_relations(both)), (("kp",),), help)
        return
    if not gains.known:
        return
    slips = [
        ("kp", _changed(gains, kp=1.0 / DEGREE), "is kp per degree? Per radian it is {0.shown_kp}"),
        ("kp", _changed(gains, kp=DEGREE), "is kp multiplied by 57.3? Without that it is {0.shown_kp}"),
    ]
    if kd:
        slips += [
            ("kd", _changed(gains, kd=DEGREE), "is kd multiplied by 57.3? Without that it is {0.shown_kd}"),
            ("kd", _changed(gains, kd=1.0 / DEGREE), "is kd per degree? Per radian it is {0.shown_kd}"),
            (
                "kp",
                _changed(gains, kp=1.0 / DEGREE, kd=1.0 / DEGREE),
                "are kp and kd per degree? Per radian they are {0.shown_kp} and {0.shown_kd}",
            ),
        ]
    for field, other, help in slips:
        size = (kp if field == "kp" else kd) or 0.0
        rare = _rarely_multiplied(size) if size and "57.3" in help else 0.0
        yield Repair(tuple(_relations(other)), ((field,),), help.format(other), rare)


def _exchanged(gains: Gains) -> Iterator[Repair]:
    """The two in each other's place."""
    if gains.kd:
        exchanged = tuple(_relations(replace(gains, kp=gains.kd, kd=gains.kp)))
        # Without an effort limit only what comes to usual gains tells an exchange from another slip.
        rare = RARE * (gains.limit is None and any(relation.excess for relation in exchanged))
        help = "are the two exchanged? kp is the stiffness, kd the velocity gain"
        yield Repair(exchanged, (("kp",),), help, rare)


def _exchange_as_good(gains: Gains, broken: Relation) -> list[Repair]:
    """An exchange with which a joint of too large a kd is as damped as others, and about as stiff.

    None where kd is a short number but for 57.3. Of a joint whose speed is unknown kd may take the limit at any.
    """
    kd = gains.kd or 0.0
    if broken.about != "slow" or (is_short(kd * DEGREE) and not is_short(kd)):
        return []
    return [
        repair
        for repair in _exchanged(gains)
        if not any(
            item.broken or (item.excess > ALIKE and (item.about != "speed" or gains.speed is not None))
            for item in repair.after
        )
    ]


def _rarely_multiplied(size: float) -> float:
    """What it costs that a gain was multiplied by 57.3, as `RARE`: it is hardly a multiple of 100 then, and has rarely
    two digits."""
    if size % 100.0 == 0.0:
        return RARE + ALIKE
    return ALIKE if is_short(size) and not is_short(size * DEGREE) else 0.0


def _changed(gains: Gains, kp: float = 1.0, kd: float = 1.0) -> Gains:
    """With its gains so many times as large."""
    return replace(gains, kp=kp * gains.kp, kd=None if gains.kd is None else kd * gains.kd)


def _degrees(gains: Gains) -> frozenset[str | None]:
    """What is said of one gain per degree or times 57.3."""
    return frozenset(
        repair.help
        for repair in _repairs(gains)
        if repair.help is not None and ("per degree" in repair.help or "57.3" in repair.help)
        if not repair.help.startswith("are")
    )


def blamed(gain: DerivedGain, path: Path, doubt: Doubt, spans: SourceMap) -> Doubt:
    """A doubt about a derived gain, told of the number that it is derived by."""
    numbers = gain.numbers
    if gain.method == "torque_at_error":
        error = numbers["error"]
        size = error.value or 0.0
        key, help = "error", "look for a wrong unit: kp is fraction x effort_limit / error"
        if error.written.endswith("deg") and size / DEGREE <= RADIANS:
            help = f"is it in rad? Then write {size / DEGREE:.4g} rad"
        elif error.written.endswith("rad") and size > RADIANS:
            help = f"is it in degrees? Then write {size:g} deg"
    elif gain.method == "natural_frequency":
        key, help = "frequency", _in_hertz(numbers["frequency"].value or 0.0)
    else:
        key, help = "ratio", "look for the point in the wrong place: kd is 2 x ratio x sqrt(kp x inertia)"
    place = (*path, key)
    judged = (*doubt.judged, doubt.span)
    return replace(doubt, where=dotted(place), span=spans.value(place), help=help, judged=judged)


def _in_hertz(frequency: float) -> str:
    """What a natural frequency that is none may have been [Hz]."""
    by = 2.0 * math.pi if frequency <= 2.0 * math.pi * FREQUENCY[1] else 1e3
    meant = format_quantity(frequency / by, "Hz", 4)
    return f"is it in rad/s? Then it is {meant}" if by < 1e3 else f"did you mean {meant}?"


def derived_doubts(gain: DerivedGain, path: Path, spans: SourceMap) -> Iterator[Doubt]:
    """A natural frequency, a damping ratio or a part of the effort limit that no joint has."""
    error = gain.numbers.get("error")
    most = LARGEST_OWN_ERROR[JointKind.SLIDE if error is not None and error.linear else JointKind.HINGE]
    if error is not None and error.value and error.value > most:
        message = f"{error.written} is no usual error at which a kp gives its part of the effort limit"
        unit, short = ("mm", "mm") if error.linear else ("degrees", "deg")
        meant = f"is it in {unit}? Then write {error.value:g} {short}"
        yield at(spans, "SPEC192", message, (*path, "error"), meant)
    for key, bounds, what, percent in (
        ("frequency", FREQUENCY, "a natural frequency", False),
        ("ratio", RATIO, "a damping ratio", True),
        ("fraction", FRACTION, "a part of the effort limit", True),
    ):
        value = gain.numbers.get(key)
        if value is None or not value.value or bounds[0] <= value.value <= bounds[1]:
            continue
        help = (
            f"is it in %? {value.value:g} % is {value.value / 100:g}" if percent and value.value > 1 else None
        )
        if key == "frequency" and value.value > bounds[1]:
            help = _in_hertz(value.value)
        usual = f"{bounds[0]:g} to {format_quantity(bounds[1], value.unit)}"
        message = f"{value.written} is no usual size of {what}: {usual}"
        yield at(spans, "SPEC192", message, (*path, key), help)
