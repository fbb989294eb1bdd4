"""Checks of kp and kd by each other and by the effort limit; what needs the joint's inertia is in `joints`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Path, dotted
from actspec.fields import units_of
from actspec.joints import JointKind
from actspec.spec.plausible.relations import ALIKE, DEGREE, RARE, Relation, Repair, explained
from actspec.spec.plausible.table import Doubt, at
from actspec.units import format_quantity

if TYPE_CHECKING:
    from actspec.spec.document import SourceMap
    from actspec.spec.fields import DerivedGain

RETURN = (5e-4, 1.0)
"""kd over kp [s]: the time in which a joint without inertia returns."""
USUAL_RETURN = (0.005, 0.25)
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
LARGEST_ERROR = 50.0
"""Effort limit over kp [rad]: where the drive gives all that it has. Published: 0.21 to 2.2, without a motor to 25."""
USUAL_ERROR = (0.06, 10.0)
FREQUENCY = (0.15, 100.0)
"""Natural frequency that a kp is derived from [Hz]. Chosen: mjlab's is 10, the stiffest published servo has 236."""
RATIO = (0.015, 60.0)
"""Damping ratio. Published: 0.064 to 12."""


FRACTION = (1e-3, 5.0)
"""Part of the effort limit at an error. Chosen: per cent are 10 and more."""
RADIANS = 1.0
"""Largest error that a kp is derived from [rad]. Chosen: limit over kp is 0.21 to 2.2 rad."""
_ANY = (0.0, math.inf)
_WHOLE = (1.0, math.inf)
"""Of a figure as a part of its bound."""


@dataclass(frozen=True, slots=True)
class Gains:
    """Gains of one hinge or slide.

    Attributes:
        kp: [N*m/rad or N/m].
        kd: [N*m*s/rad or N*s/m].
        viscous: Friction [N*m*s/rad or N*s/m].
        limit: Effort limit of a hinge [N*m]; None: unknown, or of a slide.
        driven: A motor is stated. Without one they may be a simulator's own servos, of nearly any stiffness.
        stiff: kd over kp below which a limit that is reached at `LEAST_ERROR` is noticed [s]; 0: never.
        kind: Of the joint.
    """

    kp: float
    kd: float
    viscous: float
    limit: float | None
    driven: bool
    stiff: float
    kind: JointKind

    @property
    def shown_kp(self) -> str:
        """As one writes it."""
        return format_quantity(self.kp, units_of(self.kind).stiffness, 4)

    @property
    def shown_kd(self) -> str:
        """As one writes it."""
        return format_quantity(self.kd, units_of(self.kind).velocity_gain, 4)


def gain_words(gains: Gains) -> tuple[str, str, str | None] | None:
    """Which of kp and kd cannot be right, message and help; None where both may be."""
    before = list(_relations(gains))
    broken = [relation for relation in before if relation.broken]
    if not broken:
        return None
    best = explained(before, _repairs(gains))
    if not best:
        return "kp", broken[0].message, None
    (place,) = best[0].paths[0]
    help = "; or ".join(repair.help for repair in best if repair.help is not None)
    if gains.limit is None and best[0].help in _degrees(gains):
        # The effort limit would tell which of the two it is.
        slow = broken[0].about == "slow"
        help = (
            "is kp given per degree, or kd multiplied by 57.3?"
            if slow
            else "is kp multiplied by 57.3, or kd given per degree?"
        )
        place = "kp"
    return str(place), broken[0].message, help


def _relations(gains: Gains) -> Iterator[Relation]:
    if not gains.kp:
        return
    back, damped = gains.kd / gains.kp, (gains.kd + gains.viscous) / gains.kp
    pair = f"kd {gains.shown_kd} beside kp {gains.shown_kp}"
    hardly = f"{pair}: hardly any damping, kd/kp is {format_quantity(1000.0 * back, 'ms', 3)}"
    if gains.kd:
        slow = f"{pair}: the joint would take {format_quantity(back, 's', 3)} to come back to its command"
        yield _relation(back, (0.0, RETURN[1]), USUAL_RETURN, slow, "slow")
        yield _relation(damped, (RETURN[0] if gains.driven else 0.0, math.inf), _ANY, hardly, "undamped")
        if gains.driven:
            yield _relation(back, (LEAST_RETURN, math.inf), _ANY, hardly, "undamped by kd")
    if not gains.limit or gains.limit == math.inf:
        return
    error = gains.limit / gains.kp
    limit, shown = format_quantity(gains.limit, "N*m", 4), format_quantity(error, "rad", 3)
    largest = f"kp {gains.shown_kp} needs an error of {shown} for the effort limit of {limit}"
    most = LARGEST_ERROR if gains.driven else math.inf
    yield _relation(error, (0.0, most), USUAL_ERROR, largest, "error")
    # Each of these is broken where both of its figures are below their bounds.
    strong = gains.limit >= STRONG
    if strong and error >= SOFT_ERROR and gains.kd:
        part = max(back / SOFT_RETURN[0], damped / SOFT_RETURN[1])
        yield _relation(part, _WHOLE, _WHOLE, hardly, "undamped and soft")
    if gains.stiff and damped:
        stiff = (
            f"kp {gains.shown_kp} asks for the effort limit of {limit} at an error of {shown}, with kd "
            f"{gains.shown_kd}"
        )
        if strong:
            yield _relation(max(error / FIRM_ERROR, damped / FIRM_RETURN), _WHOLE, _WHOLE, stiff, "firm")
        yield _relation(max(error / LEAST_ERROR, damped / gains.stiff), _WHOLE, _WHOLE, stiff, "stiff")


def _relation(
    value: float, bounds: tuple[float, float], usual: tuple[float, float], message: str, about: str
) -> Relation:
    return Relation("SPEC192", value, bounds, usual, message, ("kp",), None, about=about)


def _repairs(gains: Gains) -> Iterator[Repair]:
    kp, kd = gains.kp, gains.kd
    exchanged = "are the two exchanged? kp is the stiffness, kd the velocity gain"
    yield Repair(tuple(_relations(replace(gains, kp=kd, kd=kp))), (("kp",),), exchanged)
    for field in ("kp", "kd"):
        factors = [(10.0**power, "did you mean {}?", RARE) for power in (-4, -3, -2, -1, 1, 2, 3, 4)]
        if gains.kind is JointKind.SLIDE:
            factors.append((1e3, f"is {field} per mm? Per metre it is {{}}", 0.0))
        for factor, words, rare in factors:
            other = replace(gains, kp=factor * kp) if field == "kp" else replace(gains, kd=factor * kd)
            meant = other.shown_kp if field == "kp" else other.shown_kd
            yield Repair(tuple(_relations(other)), ((field,),), words.format(meant), rare)
    if gains.kind is JointKind.SLIDE:
        return
    # What was multiplied by 57.3 is hardly a multiple of 100.
    for field, other, help in (
        ("kp", replace(gains, kp=kp / DEGREE), "is kp per degree? Per radian it is {0.shown_kp}"),
        ("kp", replace(gains, kp=kp * DEGREE), "is kp multiplied by 57.3? Without that it is {0.shown_kp}"),
        ("kd", replace(gains, kd=kd * DEGREE), "is kd multiplied by 57.3? Without that it is {0.shown_kd}"),
        ("kd", replace(gains, kd=kd / DEGREE), "is kd per degree? Per radian it is {0.shown_kd}"),
        (
            "kp",
            replace(gains, kp=kp / DEGREE, kd=kd / DEGREE),
            "are kp and kd per degree? Per radian they are {0.shown_kp} and {0.shown_kd}",
        ),
    ):
        size = kp if field == "kp" else kd
        rare = RARE + ALIKE if "57.3" in help and size and size % 100.0 == 0.0 else 0.0
        yield Repair(tuple(_relations(other)), ((field,),), help.format(other), rare)


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
