"""Units: from what people write to SI floats, and the kind of quantity it is.

Angle is a dimension of its own here (rad is not 1), so `N*m`, `N*m/rad`, `N*m*s/rad` and
`N*m*s` are four different things, and a cycle is another thing than an angle: 30 Hz never
becomes 30 rad/s, nor, unasked, 188.5 rad/s.

Syntax of a unit: names joined by `*` (also a middle dot or a space) and `/`; integer powers
`^2`, `**2` or superscripts; parentheses. Operators apply from left to right, so
`a/b/c` is a/(b*c) and `N*m/rad*s` is N*m*s/rad. A space after a slash (`N*m/rad s`) reads
both ways to people and is refused. `oz`, `lbf`, `kgf` and `gf` are forces, in every place;
`kg` and `g` are masses. `Nm` is N*m.

A prefix is a whole number over a whole number, and pi is counted apart, so that `8 ms` gives
the float nearest to 0.008 and `180 deg` gives pi.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from actspec.diagnostics import nearest, one_line

MAX_LENGTH = 200
"""Longest text that is read as a quantity or unit; the files are strangers'. Chosen."""
_MAX_DEPTH = 8  # parentheses
_MAX_POWER = 6
_MAX_TOTAL_POWER = 12  # of one dimension in a whole unit
_SHOWN = 60  # characters of a stranger's text in a message

_Dims = tuple[int, int, int, int, int, int]  # m, kg, s, A, rad, cycle


class Kind(Enum):
    """What a number is: decides its units and whether it may come without one.

    Attributes:
        noun: Plain-English name, e.g. "torque"; also what `str()` gives.
        rotary_unit: SI unit at a hinge.
        linear_unit: SI unit at a slide; the same where there is only one.
        bare: Whether a number without a unit is taken as SI. 0 always is.
    """

    TORQUE = "torque", "N*m", "N", True
    STIFFNESS = "stiffness", "N*m/rad", "N/m", True
    VELOCITY_GAIN = "velocity gain", "N*m*s/rad", "N*s/m", True
    INERTIA = "inertia", "kg*m^2", "kg", True
    SPEED = "speed", "rad/s", "m/s", False
    POSITION = "position", "rad", "m", False
    ANGLE = "angle", "rad", "rad", False
    TIME = "time", "s", "s", False
    FREQUENCY = "frequency", "Hz", "Hz", False
    RATIO = "ratio", "1", "1", True
    VOLTAGE = "voltage", "V", "V", True
    CURRENT = "current", "A", "A", True
    TORQUE_CONSTANT = "torque constant", "N*m/A", "N*m/A", True
    RESISTANCE = "resistance", "Ohm", "Ohm", True

    def __init__(self, noun: str, rotary_unit: str, linear_unit: str, bare: bool) -> None:
        self.noun = noun
        self.rotary_unit = rotary_unit
        self.linear_unit = linear_unit
        self.bare = bare

    def __str__(self) -> str:
        return self.noun


@dataclass(frozen=True, slots=True)
class Parsed:
    """A quantity as read.

    Attributes:
        value: The number in SI.
        unit: SI unit as text, e.g. `N*m/rad`; the rotary one where `linear` is None.
        linear: Whether the unit given was that of a slide joint; None where it cannot tell
            (a bare number, or a kind with one unit only).
    """

    value: float
    unit: str
    linear: bool | None


class UnitError(ValueError):
    """A text is not a quantity of the kind that was asked for.

    Attributes:
        message: What is wrong, with the value, its unit and the kind.
        help: The nearest right answer; None when there is none.
    """

    def __init__(self, message: str, help: str | None = None) -> None:
        super().__init__(message)
        self.message = message
        self.help = help


def parse_quantity(given: str | int | float, kind: Kind) -> Parsed:
    """Read a number with its unit, or a bare number where `kind` allows one.

    Args:
        given: `33.5 N*m`, `-.5 rad`, `8ms`; or a number, or the text of one.
        kind: What the quantity must be.

    Returns:
        The quantity in SI.

    Raises:
        UnitError: not a finite number, an unknown unit, a unit of another kind, or no unit
            where one is needed.
    """
    if not isinstance(given, str):
        number = _finite(given, kind)
        return _bare(number, _short(number), kind)
    if len(given) > MAX_LENGTH:
        raise _too_long(given, kind)
    text = _plain(given)
    match = _NUMBER.match(text)
    if match is None:
        raise _not_a_number(given, kind)
    digits, rest = match.group(1), match.group(2)
    if _DECIMAL_COMMA.match(rest):
        raise _decimal_comma(given, kind)
    number = float(digits)
    if not math.isfinite(number) or (number == 0 and _NONZERO.match(digits)):
        raise UnitError(f"{_cut(digits)} is out of range for {_a(kind.noun)}")
    if not rest:
        return _bare(number, digits, kind)
    # The author's own unit text is shown, not its plain form.
    shown_unit = given.strip()[len(digits) :].strip()
    return _with_unit(number, digits, rest, shown_unit, kind)


def parse_with_unit(number: int | float, unit_text: str, kind: Kind) -> Parsed:
    """Read a number whose unit stands apart, as in `{value: 33.5, unit: N*m}`.

    Args:
        number: Value in `unit_text`.
        unit_text: Unit; `1` for a dimensionless number.
        kind: What the quantity must be.

    Returns:
        The quantity in SI.

    Raises:
        UnitError: as `parse_quantity`; also for an empty unit.
    """
    value = _finite(number, kind)
    text = _unit_text(unit_text, kind)
    return _with_unit(value, _short(value), text, unit_text.strip(), kind)


def convert(value_si: float, unit_text: str, kind: Kind) -> float:
    """Express an SI value in another unit of the same kind.

    Args:
        value_si: Value in the kind's rotary or linear SI unit, whichever `unit_text` belongs to.
        unit_text: The unit wanted.
        kind: What the quantity is.

    Returns:
        The value in `unit_text`; infinite if it is too large for a float.

    Raises:
        UnitError: unknown unit, or a unit of another kind.
    """
    text = _unit_text(unit_text, kind)
    unit = _evaluate_or_explain(text, unit_text.strip(), "1", kind)
    if unit.dims not in _DIMS_OF[kind]:
        raise _mismatch(1.0, "1", unit_text.strip(), unit, kind)
    if not math.isfinite(value_si):
        return float(value_si)
    return _scaled(float(value_si), unit.den, unit.num, -unit.pi)


def format_quantity(value: float | None, unit: str, digits: int = 6) -> str:
    """Write a quantity as the spec would have it.

    Args:
        value: Number in `unit`; None is unknown.
        unit: Unit text; `1` or empty for a dimensionless number.
        digits: Significant digits.

    Returns:
        `33.5 N*m`, or `unknown`.
    """
    if value is None:
        return "unknown"
    number = f"{value + 0.0:.{digits}g}"  # + 0.0: no "-0"
    return number if unit in ("", "1") else f"{number} {unit}"


# Numbers


_NUMBER = re.compile(r"\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(.*?)\s*\Z", re.DOTALL)
_DECIMAL_COMMA = re.compile(r",[0-9]")
_NONZERO = re.compile(r"[^eE]*[1-9]")
_EXAMPLES = {
    Kind.SPEED: ("rad/s", "rpm", "m/s"),
    Kind.POSITION: ("deg", "rad", "m"),
    Kind.ANGLE: ("deg", "rad"),
    Kind.TIME: ("ms", "s"),
}


def _finite(given: object, kind: Kind) -> float:
    if isinstance(given, bool) or not isinstance(given, int | float):
        shown = str(given).lower() if isinstance(given, bool) else f"{type(given).__name__} value"
        raise UnitError(f"{shown} is not a number, {_a(kind.noun)} is needed", _in_units(kind))
    try:
        number = float(given)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise UnitError(f"{_short(number)} is not a finite number, {_a(kind.noun)} is needed")
    return number


def _bare(number: float, shown: str, kind: Kind) -> Parsed:
    if not kind.bare and number != 0:
        units = _EXAMPLES.get(kind, (kind.rotary_unit,))
        examples = [f"`{_cut(shown)} {unit}`" for unit in units]
        text = " or ".join([", ".join(examples[:-1]), examples[-1]] if len(examples) > 1 else examples)
        raise UnitError(f"{_cut(shown)} has no unit, and {_a(kind.noun)} needs one", f"write {text}")
    return Parsed(number + 0.0, kind.rotary_unit, None)


def _scaled(number: float, num: int, den: int, pi: int) -> float:
    """`number * num / den * pi**pi`, rounded once but for pi; infinite beyond the floats."""
    p, q = number.as_integer_ratio()
    try:
        value = (p * num) / (q * den)
    except OverflowError:
        return math.copysign(math.inf, number)
    power = math.pi ** abs(pi)
    return value * power if pi >= 0 else value / power


# Units


class _Unit(NamedTuple):
    """A unit as num/den * pi**pi in SI, with its dimensions."""

    num: int
    den: int
    pi: int
    dims: _Dims

    def power(self, n: int) -> _Unit:
        num, den = (self.num, self.den) if n >= 0 else (self.den, self.num)
        m, kg, s, a, rad, cycle = (d * n for d in self.dims)
        return _Unit(num ** abs(n), den ** abs(n), self.pi * n, (m, kg, s, a, rad, cycle))

    def times(self, other: _Unit) -> _Unit:
        m, kg, s, a, rad, cycle = (x + y for x, y in zip(self.dims, other.dims, strict=True))
        num, den = self.num * other.num, self.den * other.den
        common = math.gcd(num, den)
        return _Unit(num // common, den // common, self.pi + other.pi, (m, kg, s, a, rad, cycle))


_ONE: _Dims = (0, 0, 0, 0, 0, 0)
_G0 = (980665, 100000)  # standard gravity, exact by definition [m/s^2]
_FORCE: _Dims = (1, 1, -2, 0, 0, 0)
_SPEED: _Dims = (0, 0, -1, 0, 1, 0)


def _build_table() -> dict[str, _Unit]:
    prefixes = {"u": (1, 10**6), "m": (1, 1000), "c": (1, 100), "k": (1000, 1)}
    table: dict[str, _Unit] = {}

    def add(name: str, dims: _Dims, num: int = 1, den: int = 1, pi: int = 0, prefixed: str = "") -> None:
        table[name] = _Unit(num, den, pi, dims)
        for p in prefixed:
            up, down = prefixes[p]
            table[p + name] = _Unit(num * up, den * down, pi, dims)

    # No mega: `MN` for `mN` would be a factor of a billion.
    add("m", (1, 0, 0, 0, 0, 0), prefixed="umck")
    add("g", (0, 1, 0, 0, 0, 0), den=1000, prefixed="mk")
    add("s", (0, 0, 1, 0, 0, 0), prefixed="um")
    add("A", (0, 0, 0, 1, 0, 0), prefixed="umk")
    add("rad", (0, 0, 0, 0, 1, 0), prefixed="um")
    add("Hz", (0, 0, -1, 0, 0, 1), prefixed="mk")
    add("N", _FORCE, prefixed="umk")
    add("Nm", (2, 1, -2, 0, 0, 0), prefixed="umk")
    add("V", (2, 1, -3, -1, 0, 0), prefixed="umk")
    add("Ohm", (2, 1, -3, -2, 0, 0), prefixed="umk")
    add("ohm", (2, 1, -3, -2, 0, 0), prefixed="umk")
    add("deg", (0, 0, 0, 0, 1, 0), den=180, pi=1)
    add("rev", (0, 0, 0, 0, 1, 0), num=2, pi=1)
    add("turn", (0, 0, 0, 0, 1, 0), num=2, pi=1)
    add("rpm", _SPEED, den=30, pi=1, prefixed="k")
    add("min", (0, 0, 1, 0, 0, 0), num=60)
    add("h", (0, 0, 1, 0, 0, 0), num=3600)
    add("in", (1, 0, 0, 0, 0, 0), num=254, den=10**4)
    add("ft", (1, 0, 0, 0, 0, 0), num=3048, den=10**4)
    # Pound 0.45359237 kg and ounce 1/16 of it, exact by the agreement of 1959.
    g0, g0_den = _G0
    add("kgf", _FORCE, num=g0, den=g0_den)
    add("gf", _FORCE, num=g0, den=g0_den * 1000)
    add("lbf", _FORCE, num=45359237 * g0, den=10**8 * g0_den)
    add("oz", _FORCE, num=45359237 * g0, den=16 * 10**8 * g0_den)
    add("ozf", _FORCE, num=45359237 * g0, den=16 * 10**8 * g0_den)
    add("%", _ONE, den=100)
    return table


_TABLE = _build_table()

_SUPERSCRIPT = re.compile("[⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺]+")
_SUPERSCRIPT_PLAIN = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")
# Escapes where two characters look the same: minus, micro and mu, Ohm and Omega, four dots.
_CHARACTERS = {
    0x2212: "-", 0xB5: "u", 0x3BC: "u", 0x2126: "Ohm", 0x3A9: "Ohm", 0xB0: "deg",
    0xB7: "*", 0x22C5: "*", 0x2219: "*", 0x2022: "*", 0xD7: "*",
}  # fmt: skip
_TOKEN = re.compile(r"(\s*)(?:([A-Za-z%]+)|([0-9]+)|(\*\*|[*/^()+-]))")


def _plain(text: str) -> str:
    """The text in ASCII spelling: `N·m²` becomes `N*m^2`."""
    powers = _SUPERSCRIPT.sub(lambda m: "^" + m.group().translate(_SUPERSCRIPT_PLAIN), text)
    return powers.translate(_CHARACTERS).strip()


class _BadUnit(Exception):
    """A unit's text cannot be read; `unknown` is the name that is not in the table."""

    def __init__(self, reason: str, unknown: str | None = None) -> None:
        super().__init__(reason)
        self.reason = reason
        self.unknown = unknown


class _Token(NamedTuple):
    kind: str  # name, number, operator, end
    text: str
    spaced: bool


def _tokens(text: str) -> Iterator[_Token]:
    at = 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise _BadUnit(f"unexpected `{one_line(text[at:].lstrip(' ')[:1])}`")
        space, name, number, operator = match.groups()
        if name:
            yield _Token("name", name, bool(space))
        elif number:
            yield _Token("number", number, bool(space))
        else:
            yield _Token("operator", operator, bool(space))
        at = match.end()
    yield _Token("end", "", False)


class _Reader:
    """Recursive descent over the tokens of one unit."""

    def __init__(self, text: str) -> None:
        self.tokens = list(_tokens(text))
        self.at = 0

    def read(self) -> _Unit:
        unit = self.product(0)
        if self.tokens[self.at].kind != "end":
            raise _BadUnit(f"unexpected `{self.tokens[self.at].text}`")
        return unit

    def product(self, depth: int) -> _Unit:
        # `10 /s` starts with the slash.
        unit = _Unit(1, 1, 0, _ONE) if self.tokens[self.at].text == "/" else self.factor(depth)
        divided = False
        while True:
            token = self.tokens[self.at]
            if token.text in ("*", "/"):
                self.at += 1
                divided = divided or token.text == "/"
                unit = _bounded(unit.times(self.factor(depth).power(1 if token.text == "*" else -1)))
            elif token.kind in ("name", "number") or token.text == "(":
                if divided:
                    raise _BadUnit("a space after `/` can be read two ways, use `*` and parentheses")
                if not token.spaced and token.text != "(":
                    raise _BadUnit(f"unexpected `{token.text}`")
                unit = _bounded(unit.times(self.factor(depth)))
            else:
                return unit

    def factor(self, depth: int) -> _Unit:
        token = self.tokens[self.at]
        self.at += 1
        if token.text == "(":
            if depth == _MAX_DEPTH:
                raise _BadUnit("too many parentheses")
            unit = self.product(depth + 1)
            if self.tokens[self.at].text != ")":
                raise _BadUnit("`)` is missing")
            self.at += 1
        elif token.kind == "name":
            if token.text not in _TABLE:
                raise _BadUnit(f"unknown unit `{_cut(token.text)}`", token.text)
            unit = _TABLE[token.text]
        elif token.text == "1":
            unit = _Unit(1, 1, 0, _ONE)
        elif token.kind == "end":
            raise _BadUnit("the unit ends too early")
        else:
            raise _BadUnit(f"unexpected `{_cut(token.text)}`")
        if self.tokens[self.at].text in ("^", "**"):
            self.at += 1
            unit = _bounded(unit.power(self.exponent()))
        return unit

    def exponent(self) -> int:
        closing = self.tokens[self.at].text == "("
        self.at += closing
        sign = self.tokens[self.at].text
        self.at += sign in ("+", "-")
        token = self.tokens[self.at]
        if token.kind != "number" or len(token.text) > 1 or int(token.text) > _MAX_POWER:
            raise _BadUnit(f"a power is a whole number up to {_MAX_POWER}")
        self.at += 1
        if closing:
            if self.tokens[self.at].text != ")":
                raise _BadUnit("`)` is missing")
            self.at += 1
        return -int(token.text) if sign == "-" else int(token.text)


def _bounded(unit: _Unit) -> _Unit:
    """The same unit, unless it is one that only a hostile file would have."""
    powers = max(map(abs, (*unit.dims, unit.pi)))
    if powers > _MAX_TOTAL_POWER or max(unit.num.bit_length(), unit.den.bit_length()) > 512:
        raise _BadUnit("too complicated")
    return unit


_DIMS_OF: dict[Kind, tuple[_Dims, _Dims]] = {
    kind: (_Reader(kind.rotary_unit).read().dims, _Reader(kind.linear_unit).read().dims) for kind in Kind
}


def _unit_text(text: object, kind: Kind) -> str:
    if not isinstance(text, str):
        got = type(text).__name__
        raise UnitError(f"the unit of {_a(kind.noun)} must be text, got {got}", _in_units(kind))
    if len(text) > MAX_LENGTH:
        raise _too_long(text, kind)
    plain = _plain(text)
    if not plain:
        raise UnitError(f"the unit of {_a(kind.noun)} is empty", _in_units(kind))
    return plain


def _with_unit(number: float, shown: str, text: str, shown_unit: str, kind: Kind) -> Parsed:
    unit = _evaluate_or_explain(text, shown_unit, shown, kind)
    rotary, linear = _DIMS_OF[kind]
    if unit.dims not in (rotary, linear):
        raise _mismatch(number, shown, shown_unit, unit, kind)
    value = _scaled(number, unit.num, unit.den, unit.pi)
    if not math.isfinite(value) or (value == 0 and number != 0):
        raise UnitError(f"{_cut(shown)} {_cut(shown_unit)} is out of range for {_a(kind.noun)}")
    if rotary == linear:
        return Parsed(value + 0.0, kind.rotary_unit, None)
    is_linear = unit.dims == linear
    return Parsed(value + 0.0, kind.linear_unit if is_linear else kind.rotary_unit, is_linear)


# Explanations


_NOUN_OF: dict[_Dims, str] = {
    **{_DIMS_OF[kind][0]: kind.noun for kind in Kind},
    _DIMS_OF[Kind.TORQUE][1]: "force",
    _DIMS_OF[Kind.STIFFNESS][1]: "stiffness of a slide",
    _DIMS_OF[Kind.VELOCITY_GAIN][1]: "velocity gain of a slide",
    _DIMS_OF[Kind.INERTIA][1]: "mass",
    _DIMS_OF[Kind.SPEED][1]: "speed along a line",
    _DIMS_OF[Kind.POSITION][1]: "length",
}
_SPELLINGS = {
    "sec": "s", "second": "s", "seconds": "s", "msec": "ms", "usec": "us", "minute": "min", "hr": "h",
    "degree": "deg", "degrees": "deg", "radian": "rad", "radians": "rad", "rps": "rev/s", "hertz": "Hz",
    "lb": "lbf", "lbs": "lbf", "inch": "in", "foot": "ft", "feet": "ft", "meter": "m", "metre": "m",
    "amp": "A", "amps": "A", "volt": "V", "volts": "V", "kgcm": "kgf*cm", "gcm": "gf*cm", "percent": "%",
}  # fmt: skip


def _evaluate_or_explain(text: str, shown_unit: str, shown: str, kind: Kind) -> _Unit:
    try:
        return _Reader(text).read()
    except _BadUnit as bad:
        where = f"{_cut(shown)} {_cut(shown_unit)}"
        raise UnitError(
            f"{where} is not {_a(kind.noun)}: {bad.reason}",
            _did_you_mean(text, bad.unknown, shown, kind) or _in_units(kind),
        ) from None


def _did_you_mean(text: str, unknown: str | None, shown: str, kind: Kind) -> str | None:
    """The first rewriting that is of the right kind, else the first that is a unit at all."""
    fallback = None
    for candidate in _rewritings(text, unknown):
        try:
            unit = _Reader(candidate).read()
        except _BadUnit:
            continue
        if unit.dims in _DIMS_OF[kind]:
            rotary = unit.dims == _DIMS_OF[kind][0]
            si = kind.rotary_unit if rotary else kind.linear_unit
            value = _short(_scaled(float(shown), unit.num, unit.den, unit.pi))
            same = "" if candidate == si else f" That is {value} {si}"
            return f"did you mean `{_cut(shown)} {candidate}`?{same}"
        fallback = fallback or f"did you mean `{candidate}`? {_in_units(kind)}"
    return fallback


def _rewritings(text: str, unknown: str | None) -> Iterator[str]:
    if "-" in text:  # oz-in
        yield re.sub(r"(?<=[A-Za-z0-9)])\s*-\s*(?=[A-Za-z])", "*", text)
    if re.search(r"[A-Za-z][2-9]", text):  # kg*m2
        text = re.sub(r"([A-Za-z])([2-9])", r"\1^\2", text)
        yield text
    if re.search(r"/[^()]*[A-Za-z0-9] +[A-Za-z]", text):  # N*m/rad s
        head, _, tail = text.partition("/")
        yield f"{head}/({re.sub(r' +', '*', tail.strip())})"
        yield f"{head}*{'*'.join(tail.split()[1:])}/{tail.split()[0]}"
    if unknown is None or len(unknown) > 12:
        return
    lower = {name.lower(): name for name in _TABLE}
    words = [_SPELLINGS.get(unknown), _SPELLINGS.get(unknown.lower()), lower.get(unknown.lower())]
    words += [
        f"{unknown[:i]}*{unknown[i:]}"
        for i in range(1, len(unknown))
        if unknown[:i] in _TABLE and unknown[i:] in _TABLE
    ]
    words += [nearest(unknown, sorted(_TABLE)), nearest(unknown.lower(), sorted(_TABLE))]
    for word in words:
        if word is not None:
            if "/" in word and text != unknown:
                word = f"({word})"
            yield re.sub(rf"(?<![A-Za-z%]){re.escape(unknown)}(?![A-Za-z%])", word, text)


def _mismatch(number: float, shown: str, shown_unit: str, unit: _Unit, kind: Kind) -> UnitError:
    given = _cut(shown) if shown_unit == "1" else f"{_cut(shown)} {_cut(shown_unit)}"
    if unit.dims == _ONE:
        message = f"{given} is dimensionless, not {_a(kind.noun)}"
    elif unit.dims in _NOUN_OF and _NOUN_OF[unit.dims] != kind.noun:
        message = f"{given} is {_a(_NOUN_OF[unit.dims])}, not {_a(kind.noun)}"
    else:
        message = f"{given} is not {_a(kind.noun)}"
    si = _scaled(number, unit.num, unit.den, unit.pi)
    return UnitError(message, _other_kind(given, si, unit.dims, kind) or _in_units(kind))


def _other_kind(given: str, si: float, dims: _Dims, kind: Kind) -> str | None:
    """What a quantity of another kind would be as `kind`, where that has an answer."""
    hertz, time = _DIMS_OF[Kind.FREQUENCY][0], _DIMS_OF[Kind.TIME][0]
    rotary, linear = _DIMS_OF[kind]
    turn = 2 * math.pi
    if dims == _ONE and kind is Kind.TORQUE:
        return (
            "a dimensionless friction coefficient cannot be converted to N*m without the joint load; "
            "give the friction torque in N*m (N for a slide)"
        )
    if kind is Kind.SPEED and dims == hertz:
        return f"{given} as angular speed is {_short(turn * si)} rad/s"
    if kind is Kind.FREQUENCY and dims == _SPEED:
        return f"{given} as frequency is {_short(si / turn)} Hz"
    if kind is Kind.FREQUENCY and dims == time and si > 0:
        return (
            f"a period of {given} is {_short(1 / si)} Hz; a first-order lag with a time constant of {given} "
            f"has its cutoff at {_short(1 / (turn * si))} Hz"
        )
    if kind is Kind.TIME and dims == hertz and si > 0:
        return (
            f"the period of {given} is {_short(1 / si)} s; a first-order low-pass with its cutoff at {given} "
            f"has a time constant of {_short(1 / (turn * si))} s"
        )
    if kind is Kind.FREQUENCY and dims == _shift(_ONE, s=-1):
        return f"cycles are counted apart: write `{_short(si)} Hz` if they are meant"
    if kind is Kind.TORQUE_CONSTANT and dims == _shift(rotary, rad=1, m=-4, kg=-2, s=4, a=2) and si > 0:
        return f"a speed constant of {given} is a torque constant of {_short(1 / si)} N*m/A"
    if rotary != _ONE and rotary in (_shift(dims, rad=-1), _shift(dims, rad=1)):
        return f"angle is a dimension of its own: write `{_short(si)} {kind.rotary_unit}` if that is meant"
    if rotary == _shift(dims, s=2):
        return f"`a/b/c` is a/(b*c): write `{_short(si)} {kind.rotary_unit}` if that is meant"
    for wanted, unit in ((rotary, kind.rotary_unit), (linear, kind.linear_unit)):
        weight = si * _G0[0] / _G0[1]
        if wanted == _shift(dims, m=1, s=-2):
            return f"kg and g are masses; as a force (kgf, gf) {given} is {_short(weight)} {unit}"
        if wanted == _shift(dims, m=-1, s=2):
            mass = si * _G0[1] / _G0[0]
            return f"oz, lbf, kgf and gf are forces; as a mass {given} is {_short(mass)} {unit}"
    return None


def _shift(dims: _Dims, *, m: int = 0, kg: int = 0, s: int = 0, a: int = 0, rad: int = 0) -> _Dims:
    return (dims[0] + m, dims[1] + kg, dims[2] + s, dims[3] + a, dims[4] + rad, dims[5])


def _too_long(text: str, kind: Kind) -> UnitError:
    return UnitError(f"a text of {len(text)} characters is not {_a(kind.noun)}", _in_units(kind))


def _not_a_number(given: str, kind: Kind) -> UnitError:
    if not given.strip():
        return UnitError(f"the text is empty, {_a(kind.noun)} is needed", _in_units(kind))
    if given.split()[0].lower().strip("+-.") in ("nan", "inf", "infinity"):
        return UnitError(f"{_cut(given)} is not a finite number, {_a(kind.noun)} is needed")
    return UnitError(
        f"`{_cut(given)}` does not start with a number, {_a(kind.noun)} is needed",
        f"write a number and its unit, e.g. `1 {kind.rotary_unit}`" if kind.rotary_unit != "1" else None,
    )


def _decimal_comma(given: str, kind: Kind) -> UnitError:
    return UnitError(
        f"{_cut(given)} is not {_a(kind.noun)}: a comma inside a number",
        f"decimals have a point (`{_cut(given.strip().replace(',', '.', 1))}`), thousands no mark",
    )


def _in_units(kind: Kind) -> str:
    if kind is Kind.RATIO:
        return "a ratio is a bare number or in %"
    if kind.rotary_unit == kind.linear_unit:
        return f"{_a(kind.noun)} is in {kind.rotary_unit}"
    return f"{_a(kind.noun)} is in {kind.rotary_unit} (hinge) or {kind.linear_unit} (slide)"


def _a(noun: str) -> str:
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def _short(number: float) -> str:
    return f"{number:.6g}"


def _cut(text: str) -> str:
    text = one_line(text.strip())
    return text if len(text) <= _SHOWN else text[: _SHOWN - 3] + "..."
