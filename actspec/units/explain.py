"""Why a text is not a quantity of its kind, and what its author may have meant."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

from actspec.diagnostics import nearest, shortened
from actspec.units.kinds import Kind, UnitError, an, format_number, in_units
from actspec.units.reader import DIMS_OF, G0, ONE, TABLE, BadUnit, Dims, Unit, read_unit

_NOUN_OF: dict[Dims, str] = {
    **{DIMS_OF[kind][0]: kind.noun for kind in Kind},
    DIMS_OF[Kind.TORQUE][1]: "force",
    DIMS_OF[Kind.STIFFNESS][1]: "stiffness of a slide",
    DIMS_OF[Kind.VELOCITY_GAIN][1]: "velocity gain of a slide",
    DIMS_OF[Kind.INERTIA][1]: "mass",
    DIMS_OF[Kind.SPEED][1]: "speed along a line",
    DIMS_OF[Kind.POSITION][1]: "length",
}
_SPELLINGS = {
    "sec": "s", "second": "s", "seconds": "s", "msec": "ms", "usec": "us", "minute": "min", "hr": "h",
    "degree": "deg", "degrees": "deg", "radian": "rad", "radians": "rad", "rps": "rev/s", "hertz": "Hz",
    "r": "rev", "u": "rev", "rot": "rev",
    "lb": "lbf", "lbs": "lbf", "inch": "in", "foot": "ft", "feet": "ft", "meter": "m", "metre": "m",
    "newton": "N", "newtons": "N", "newtonmeter": "N*m", "newtonmeters": "N*m", "meters": "m", "metres": "m",
    "amp": "A", "amps": "A", "volt": "V", "volts": "V", "kgcm": "kgf*cm", "gcm": "gf*cm", "percent": "%",
}  # fmt: skip


_TO = re.compile(r": *([1-9][0-9]{0,8}(?:\.[0-9]{1,9})?)")
"""The second half of `9:1`."""


def unreadable(bad: BadUnit, text: str, whole: str, shown: str, kind: Kind) -> UnitError:
    """The error for a unit that is none.

    Args:
        bad: Why it is none.
        text: The unit in ASCII spelling.
        whole: The quantity as its author wrote it.
        shown: The number as its author wrote it.
        kind: What was asked for.
    """
    to = _TO.fullmatch(text) if kind is Kind.RATIO else None
    if to is not None:
        first, second = float(shown), float(to[1])
        help = f"write `{format_number(first / second)}`"
        if 0 < first < second:
            help += f", or `{format_number(second / first)}` for a gearbox that reduces the speed so"
        return UnitError(f"{shortened(whole)} is two numbers, not a ratio", help)
    meant = (
        _amperes(text, shown, kind)
        or _servo_time(text, float(shown), kind)
        or _speed_constant(text, shown, kind)
        or _did_you_mean(text, bad.unknown, shown, kind)
    )
    return UnitError(f"{shortened(whole)} is not {an(kind.noun)}: {bad.reason}", meant or in_units(kind))


_AMPERES = re.compile(r"(?<![A-Za-z])([umk]?A)(?:_| ?-? ?\(?)(?i:(rms|eff)|(pk|peak|p)|p-?p|pk-?pk)\b\)?")
"""Amperes of which the unit says how they are counted: `Arms`, `A_pk`, `A (rms)`."""
_ROOT = math.sqrt(2.0)


def _amperes(text: str, shown: str, kind: Kind) -> str | None:
    """What to write for amperes rms or peak; None: the unit does not say which they are.

    A torque constant is per ampere of the one or the other, so that no number is right for both.
    """
    match = _AMPERES.search(text)
    if match is None or kind not in (Kind.CURRENT, Kind.TORQUE_CONSTANT):
        return None
    unit, number = _AMPERES.sub(r"\1", text, count=1), float(shown)
    try:
        if read_unit(unit).dims not in DIMS_OF[kind]:
            return None
    except BadUnit:
        return None
    rms, peak = match[2] is not None, match[3] is not None
    if not rms and not peak:
        number /= 2.0  # from peak to peak

    def of(factor: float) -> str:
        return f"`{format_number(number * factor)} {shortened(unit)}`"

    if kind is Kind.TORQUE_CONSTANT:
        if not rms and not peak:
            return None
        own, other, factor = ("rms", "peak", 1 / _ROOT) if rms else ("peak", "rms", _ROOT)
        return f"write {of(1)} where the motor's currents are A {own}, {of(factor)} where they are A {other}"
    own, other, factor = ("rms", "peak", _ROOT) if rms else ("peak", "rms", 1 / _ROOT)
    return f"write {of(1)} beside a torque constant per A {own}, {of(factor)} beside one per A {other}"


_SERVO_TIME = re.compile(r"(?:s|secs?|seconds?)(?: *(?:/|per) *60 *(?:deg|degs|degrees?)?)?")
"""The time that servos take for 60 degrees, as their sheets have it: `sec/60 deg`; also without the angle."""
_SERVO_TIMES = (0.01, 1.0)
"""Such times [s]."""


def _servo_time(text: str, seconds: float, kind: Kind) -> str | None:
    """The speed of a servo whose sheet has a time for 60 degrees."""
    if kind is not Kind.SPEED or not _SERVO_TIME.fullmatch(text):
        return None
    if not _SERVO_TIMES[0] <= seconds <= _SERVO_TIMES[1]:
        return None
    speed = format_number(math.pi / 3.0 / seconds, 4)
    return f"sheets of servos have the time for 60 deg: for {format_number(seconds)} s write `{speed} rad/s`"


def _speed_constant(text: str, shown: str, kind: Kind) -> str | None:
    """What a Kv is, whose `KV` is rpm/V and no kilovolt."""
    if text.lower() != "kv" or kind not in (Kind.SPEED, Kind.TORQUE_CONSTANT):
        return None
    return _other_kind(f"{shown} rpm/V", float(shown), read_unit("rpm/V"), kind)


def _did_you_mean(text: str, unknown: str | None, shown: str, kind: Kind) -> str | None:
    """The first rewriting that is of the right kind, else the first that is a unit at all and is not only similar."""
    fallback = None
    for candidate, similar in _rewritings(text, unknown):
        try:
            unit = read_unit(candidate)
        except BadUnit:
            continue
        if unit.dims in DIMS_OF[kind]:
            rotary = unit.dims == DIMS_OF[kind][0]
            si = kind.rotary_unit if rotary else kind.linear_unit
            value = format_number(unit.in_si(float(shown)))
            same = "" if candidate == si else f" That is {value} {si}"
            return f"did you mean `{shortened(shown)} {candidate}`?{same}"
        if not similar:
            given = f"{shortened(shown)} {candidate}"
            inverse, heavy = "/" in candidate or "^-" in candidate, kind is Kind.INERTIA
            other = _other_kind(given, float(shown), unit, kind) if inverse or heavy else None
            # A pound is a mass there, and no force is meant.
            meant = other if heavy else None
            fallback = fallback or meant or f"did you mean `{candidate}`? {other or in_units(kind)}"
    return fallback


def _rewritings(text: str, unknown: str | None) -> Iterator[tuple[str, bool]]:
    """Units that may be meant, and whether they are only similar."""
    if text[-1:] in ",;.":
        text = text.rstrip(",;. ")
        yield text, False
    if _DOT.search(text):  # N.m
        text = _DOT.sub("*", text)
        yield text, False
    if "-" in text:  # oz-in, in-lb
        text = re.sub(r"(?<=[A-Za-z0-9)])\s*-\s*(?=[A-Za-z])", "*", text)
        yield text, False
    if re.search(r"[A-Za-z]-[1-9]", text):  # min-1
        text = re.sub(r"([A-Za-z])(-[1-9])", r"\1^\2", text)
        yield text, False
    if re.search(r"[A-Za-z][2-9]", text):  # kg*m2
        text = re.sub(r"([A-Za-z])([2-9])", r"\1^\2", text)
        yield text, False
    if re.search(r"/[^()]*[A-Za-z0-9] +[A-Za-z]", text):  # N*m/rad s
        head, _, tail = text.partition("/")
        yield f"{head}/({re.sub(r' +', '*', tail.strip())})", False
        yield f"{head}*{'*'.join(tail.split()[1:])}/{tail.split()[0]}", False
    if "/" not in text:  # Newton meter, in*lb
        spaced = "*".join(text.split())
        yield re.sub(r"[A-Za-z]+", lambda word: _SPELLINGS.get(word[0].lower(), word[0]), spaced), False
        yield re.sub(r"^(k?g)(?=\*[cm]?m$)", r"\1f", spaced), False  # kg-cm of a servo
    if unknown is None or len(unknown) > 12:
        return
    lower = {name.lower(): name for name in TABLE}
    words = [_SPELLINGS.get(unknown), _SPELLINGS.get(unknown.lower()), lower.get(unknown.lower())]
    if unknown[-1:] == "s" and unknown[:-1] in TABLE:  # rads, of a speed or of an angle
        words += [f"{unknown[:-1]}/s", unknown[:-1]]
    words += [
        unknown[: -len(end)]
        for end in _ENDS
        if unknown.lower().endswith(end) and unknown[: -len(end)] in TABLE
    ]
    words += [
        f"{unknown[:i]}*{unknown[i:]}"
        for i in range(1, len(unknown))
        if unknown[:i] in TABLE and unknown[i:] in TABLE
    ]
    slips = [nearest(unknown, sorted(TABLE)), nearest(unknown.lower(), sorted(TABLE))]
    if text != unknown and len(unknown) <= 2:
        # M*m/rad: one letter is wrong, and the rest tells which; SI first.
        near = [name for name in TABLE if len(name) == len(unknown) and _slip(name, unknown)]
        near.sort(key=lambda name: TABLE[name][:3] != (1, 1, 0))
        slips += near
    for word, similar in (*((word, False) for word in words), *((word, True) for word in slips)):
        if word is not None:
            if "/" in word and text != unknown:
                word = f"({word})"
            yield re.sub(rf"(?<![A-Za-z%]){re.escape(unknown)}(?![A-Za-z%])", word, text), similar


_DOT = re.compile(r"(?<=[A-Za-z0-9)])\s*\.\s*(?=[A-Za-z(])")
"""Between units, where `*` must stand."""
_ENDS = ("rms", "dc", "ac", "pk", "peak", "max")
"""Of units, in which they say which of several figures it is."""


def _slip(one: str, other: str) -> bool:
    return sum(a != b for a, b in zip(one, other, strict=True)) == 1


def mismatch(number: float, whole: str, unit: Unit, kind: Kind) -> UnitError:
    """The error for a unit of another kind."""
    given = shortened(whole)
    if unit.dims == ONE:
        message = f"{given} is dimensionless, not {an(kind.noun)}"
    elif unit.dims in _NOUN_OF and _NOUN_OF[unit.dims] != kind.noun:
        message = f"{given} is {an(_NOUN_OF[unit.dims])}, not {an(kind.noun)}"
    else:
        message = f"{given} is not {an(kind.noun)}"
    help = _other_kind(given, number, unit, kind)
    if given.endswith("kV"):
        help = _speed_constant("kV", format_number(number), kind)
    return UnitError(message, help or in_units(kind))


_PER_CM = re.compile(r"([-+.0-9eE]+) *(k?g)f? */ *([cm]?m)")
"""A torque as half of the sheets of servos have it: `9.4 kg/cm`."""
_MINUTE = re.compile(r"(?<![A-Za-z])min(?![A-Za-z])")


def _other_kind(given: str, number: float, unit: Unit, kind: Kind) -> str | None:
    """What a quantity of another kind would be as `kind`, where that has an answer."""
    si, dims = unit.in_si(number), unit.dims
    hertz, time, speed = (DIMS_OF[k][0] for k in (Kind.FREQUENCY, Kind.TIME, Kind.SPEED))
    rotary, linear = DIMS_OF[kind]
    turn = 2 * math.pi
    if kind is Kind.SPEED and dims == time and (servo := _servo_time("s", si, kind)):
        return servo
    if kind is Kind.SPEED and dims == _shift(rotary, m=-2, kg=-1, s=3, a=1):
        at_24 = f"{format_number(24 * si / turn * 60, 4)} rpm"
        return f"a speed constant times the voltage is the speed without load: at 24 V write `{at_24}`"
    if kind is Kind.TORQUE and (per := _PER_CM.fullmatch(given)):
        meant = f"{per[2]}f*{per[3]}"
        in_si = format_number(read_unit(meant).in_si(number))
        return f"sheets of servos write {per[2]}/{per[3]} for {meant}: `{per[1]} {meant}` is {in_si} N*m"
    if dims == ONE and kind is Kind.TORQUE:
        return (
            "a dimensionless friction coefficient cannot be converted to N*m without the joint load; "
            "give the friction torque in N*m (N for a slide)"
        )
    if kind is Kind.SPEED and dims == hertz:
        return f"{given} as angular speed is {format_number(turn * si)} rad/s"
    if kind is Kind.LEAD and dims == DIMS_OF[Kind.LENGTH][0]:
        # As m/rad it would be 2 pi times as much.
        return f"a lead is the travel in one turn: write `{given}/rev`"
    if kind is Kind.FREQUENCY and dims == speed:
        return f"{given} as frequency is {format_number(si / turn)} Hz"
    if kind is Kind.FREQUENCY and dims == time and si > 0:
        return (
            f"a period of {given} is {format_number(1 / si)} Hz; a first-order lag with a time constant of {given} "
            f"has its cutoff at {format_number(1 / (turn * si))} Hz"
        )
    if kind is Kind.TIME and dims == hertz and si > 0:
        return (
            f"the period of {given} is {format_number(1 / si)} s; a first-order low-pass with its cutoff at {given} "
            f"has a time constant of {format_number(1 / (turn * si))} s"
        )
    if kind is Kind.FREQUENCY and dims == _shift(ONE, s=-1):
        return f"a frequency counts cycles: write `{format_number(si)} Hz` if cycles are meant"
    if kind is Kind.TORQUE_CONSTANT and dims == _shift(rotary, rad=1, m=-4, kg=-2, s=4, a=2) and si > 0:
        return f"a speed constant of {given} is a torque constant of {format_number(1 / si)} N*m/A"
    if _MINUTE.search(given):
        # Of a shaft turns are counted: sheets write rpm so.
        if kind is Kind.SPEED and rotary == _shift(dims, rad=1):
            in_si = format_number(si * turn)
            return f"1/min of a shaft is rpm: write `{format_number(si * 60)} rpm`, which is {in_si} rad/s"
        if rotary == _shift(dims, rad=-1):
            return f"1/min of a shaft is rpm: write `{format_number(si / turn)} {kind.rotary_unit}`"
        if kind is Kind.TORQUE_CONSTANT and dims == _shift(rotary, m=-4, kg=-2, s=4, a=2) and si > 0:
            constant = format_number(1 / (turn * si))
            return f"1/min of a shaft is rpm: a speed constant of {given} is a torque constant of {constant} N*m/A"
    if kind is Kind.SPEED and dims == _shift(ONE, s=-1) and unit.num == unit.den:
        count, in_si = format_number(si), format_number(turn * si)
        return f"1/s of a shaft is rad/s or rev/s: write `{count} rad/s`, or `{count} rev/s`, which is {in_si} rad/s"
    if rotary != ONE and rotary in (_shift(dims, rad=-1), _shift(dims, rad=1)):
        return f"angle is a dimension of its own: write `{format_number(si)} {kind.rotary_unit}` if that is meant"
    if rotary == _shift(dims, s=2):
        return f"`a/b/c` is a/(b*c): write `{format_number(si)} {kind.rotary_unit}` if that is meant"
    for wanted, name in ((rotary, kind.rotary_unit), (linear, kind.linear_unit)):
        weight = si * G0[0] / G0[1]
        if not dims[1]:
            # Without a mass in it, it is no weight: s is m/s by the same rule.
            continue
        if wanted == _shift(dims, m=1, s=-2):
            return f"kg and g are masses; as a force (kgf, gf) {given} is {format_number(weight)} {name}"
        if wanted == _shift(dims, m=-1, s=2):
            mass = si * G0[1] / G0[0]
            return f"oz, lbf, kgf and gf are forces; as a mass {given} is {format_number(mass)} {name}"
    return None


def _shift(dims: Dims, *, m: int = 0, kg: int = 0, s: int = 0, a: int = 0, rad: int = 0) -> Dims:
    return (dims[0] + m, dims[1] + kg, dims[2] + s, dims[3] + a, dims[4] + rad, dims[5])


def too_long(text: str, kind: Kind) -> UnitError:
    """The error for a text beyond `MAX_LENGTH`."""
    return UnitError(f"a text of {len(text)} characters is not {an(kind.noun)}", in_units(kind))


def not_a_number(given: str, kind: Kind) -> UnitError:
    """The error for a text that does not begin as a finite number."""
    if not given.strip():
        return UnitError(f"the text is empty, {an(kind.noun)} is needed", in_units(kind))
    if given.split()[0].lower().strip("+-.") in ("nan", "inf", "infinity"):
        return UnitError(f"{shortened(given.strip())} is not a finite number, {an(kind.noun)} is needed")
    return UnitError(
        f"`{shortened(given.strip())}` does not start with a number, {an(kind.noun)} is needed",
        f"write a number and its unit, e.g. `1 {kind.rotary_unit}`"
        if kind.rotary_unit != "1"
        else in_units(kind),
    )


_THOUSANDS = re.compile(r"(?<![0-9.,])[1-9][0-9]{0,2}(?:,[0-9]{3})+(?![0-9])")


_POINTS = re.compile(r"[-+]?[1-9][0-9]{0,2}(?:\.[0-9]{3})+,[0-9]+(?![^ ]*\.)")


def decimal_comma(given: str, kind: Kind) -> UnitError:
    """The error for a number such as `0,5`."""
    text = given.strip()
    # 5.000,5
    point = (text.replace(".", "") if _POINTS.match(text) else text).replace(",", ".", 1)
    return UnitError(
        f"{shortened(text)} is not {an(kind.noun)}: a comma inside a number",
        of_comma(text, point),
    )


def of_comma(text: str, point: str) -> str:
    """What commas inside numbers may mean: decimals, and thousands where each has three digits behind it.

    Args:
        text: What was written.
        point: The same with points for the commas.
    """
    whole = _THOUSANDS.sub(lambda match: match[0].replace(",", ""), text)
    thousands = "" if re.search(",(?! )", whole) else f" (`{shortened(whole)}`)"
    return f"decimals have a point (`{shortened(point)}`), thousands no mark{thousands}"
