"""The table of units, and the reader of their syntax; see the package."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import NamedTuple

from actspec.diagnostics import one_line, shortened
from actspec.units.kinds import Kind

_MAX_DEPTH = 8  # parentheses
_MAX_POWER = 6
_MAX_TOTAL_POWER = 12  # of one dimension in a whole unit

Dims = tuple[int, int, int, int, int, int]
"""Powers of m, kg, s, A, rad and cycle."""


class Unit(NamedTuple):
    """A unit as num/den * pi**pi in SI, with its dimensions."""

    num: int
    den: int
    pi: int
    dims: Dims

    def power(self, n: int) -> Unit:
        num, den = (self.num, self.den) if n >= 0 else (self.den, self.num)
        m, kg, s, a, rad, cycle = (d * n for d in self.dims)
        return Unit(num ** abs(n), den ** abs(n), self.pi * n, (m, kg, s, a, rad, cycle))

    def in_si(self, number: float) -> float:
        """`number` of this unit in SI, rounded once but for pi; infinite beyond the floats."""
        p, q = number.as_integer_ratio()
        try:
            value = (p * self.num) / (q * self.den)
        except OverflowError:
            return math.copysign(math.inf, number)
        power = math.pi ** abs(self.pi)
        return value * power if self.pi >= 0 else value / power

    def times(self, other: Unit) -> Unit:
        m, kg, s, a, rad, cycle = (x + y for x, y in zip(self.dims, other.dims, strict=True))
        num, den = self.num * other.num, self.den * other.den
        common = math.gcd(num, den)
        return Unit(num // common, den // common, self.pi + other.pi, (m, kg, s, a, rad, cycle))


ONE: Dims = (0, 0, 0, 0, 0, 0)
G0 = (980665, 100000)  # standard gravity, exact by definition [m/s^2]
_FORCE: Dims = (1, 1, -2, 0, 0, 0)
_SPEED: Dims = (0, 0, -1, 0, 1, 0)


def _build_table() -> dict[str, Unit]:
    prefixes = {"u": (1, 10**6), "m": (1, 1000), "c": (1, 100), "k": (1000, 1), "M": (10**6, 1)}
    table: dict[str, Unit] = {}

    def add(name: str, dims: Dims, num: int = 1, den: int = 1, pi: int = 0, prefixed: str = "") -> None:
        table[name] = Unit(num, den, pi, dims)
        for p in prefixed:
            up, down = prefixes[p]
            table[p + name] = Unit(num * up, den * down, pi, dims)

    # No mega: `MN` for `mN` would be a factor of a billion.
    add("m", (1, 0, 0, 0, 0, 0), prefixed="umck")
    add("g", (0, 1, 0, 0, 0, 0), den=1000, prefixed="mk")
    add("s", (0, 0, 1, 0, 0, 0), prefixed="um")
    add("A", (0, 0, 0, 1, 0, 0), prefixed="umk")
    add("rad", (0, 0, 0, 0, 1, 0), prefixed="um")
    add("Hz", (0, 0, -1, 0, 0, 1), prefixed="Mmk")
    add("N", _FORCE, prefixed="umk")
    add("Nm", (2, 1, -2, 0, 0, 0), prefixed="umk")
    add("V", (2, 1, -3, -1, 0, 0), prefixed="umk")
    add("Ohm", (2, 1, -3, -2, 0, 0), prefixed="umk")
    add("ohm", (2, 1, -3, -2, 0, 0), prefixed="umk")
    add("deg", (0, 0, 0, 0, 1, 0), den=180, pi=1)
    add("arcmin", (0, 0, 0, 0, 1, 0), den=10800, pi=1)
    add("rev", (0, 0, 0, 0, 1, 0), num=2, pi=1)
    add("turn", (0, 0, 0, 0, 1, 0), num=2, pi=1)
    add("rpm", _SPEED, den=30, pi=1, prefixed="k")
    add("min", (0, 0, 1, 0, 0, 0), num=60)
    add("h", (0, 0, 1, 0, 0, 0), num=3600)
    add("in", (1, 0, 0, 0, 0, 0), num=254, den=10**4)
    add("ft", (1, 0, 0, 0, 0, 0), num=3048, den=10**4)
    # Pound 0.45359237 kg and ounce 1/16 of it, exact by the agreement of 1959.
    g0, g0_den = G0
    add("kgf", _FORCE, num=g0, den=g0_den)
    add("gf", _FORCE, num=g0, den=g0_den * 1000)
    add("lbf", _FORCE, num=45359237 * g0, den=10**8 * g0_den)
    add("oz", _FORCE, num=45359237 * g0, den=16 * 10**8 * g0_den)
    add("ozf", _FORCE, num=45359237 * g0, den=16 * 10**8 * g0_den)
    add("%", ONE, den=100)
    return table


TABLE = _build_table()

_SUPERSCRIPT = re.compile("[⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺]+")
_SUPERSCRIPT_PLAIN = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")
# Escapes where two characters look the same: minus, micro and mu, Ohm and Omega, four dots.
_CHARACTERS = {
    0x2212: "-", 0xB5: "u", 0x3BC: "u", 0x2126: "Ohm", 0x3A9: "Ohm", 0xB0: "deg",
    0xB7: "*", 0x22C5: "*", 0x2219: "*", 0x2022: "*", 0xD7: "*",
}  # fmt: skip
_TOKEN = re.compile(r"(\s*)(?:([A-Za-z%]+)|([0-9]+)|(\*\*|[*/^()+-]))")


def in_ascii(text: str) -> str:
    """The text in ASCII spelling: `N·m²` becomes `N*m^2`."""
    powers = _SUPERSCRIPT.sub(lambda m: "^" + m.group().translate(_SUPERSCRIPT_PLAIN), text)
    return powers.translate(_CHARACTERS).strip()


class BadUnit(Exception):
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
            rest = text[at:].lstrip(" ")
            if rest[0] == "." and rest[1:].lstrip(" ")[:1].isalpha() and at:
                raise BadUnit("units are multiplied by `*`, not by `.`")
            raise BadUnit(f"unexpected `{one_line(rest[:1])}`")
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

    def read(self) -> Unit:
        unit = self.product(0)
        if self.tokens[self.at].kind != "end":
            raise BadUnit(f"unexpected `{self.tokens[self.at].text}`")
        return unit

    def product(self, depth: int) -> Unit:
        # `10 /s` starts with the slash.
        unit = Unit(1, 1, 0, ONE) if self.tokens[self.at].text == "/" else self.factor(depth)
        divided = False
        while True:
            token = self.tokens[self.at]
            if token.text in ("*", "/"):
                self.at += 1
                divided = divided or token.text == "/"
                unit = _bounded(unit.times(self.factor(depth).power(1 if token.text == "*" else -1)))
            elif token.kind in ("name", "number") or token.text == "(":
                if divided:
                    raise BadUnit("a space after `/` can be read two ways, use `*` and parentheses")
                if not token.spaced and token.text != "(":
                    raise BadUnit(f"unexpected `{token.text}`")
                unit = _bounded(unit.times(self.factor(depth)))
            else:
                return unit

    def factor(self, depth: int) -> Unit:
        token = self.tokens[self.at]
        self.at += 1
        if token.text == "(":
            if depth == _MAX_DEPTH:
                raise BadUnit("too many parentheses")
            unit = self.product(depth + 1)
            if self.tokens[self.at].text != ")":
                raise BadUnit("`)` is missing")
            self.at += 1
        elif token.kind == "name":
            if token.text not in TABLE:
                raise BadUnit(f"unknown unit `{shortened(token.text)}`", token.text)
            unit = TABLE[token.text]
        elif token.text == "1":
            unit = Unit(1, 1, 0, ONE)
        elif token.kind == "end":
            raise BadUnit("the unit ends too early")
        else:
            raise BadUnit(f"unexpected `{shortened(token.text)}`")
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
            raise BadUnit(f"a power is a whole number up to {_MAX_POWER}")
        self.at += 1
        if closing:
            if self.tokens[self.at].text != ")":
                raise BadUnit("`)` is missing")
            self.at += 1
        return -int(token.text) if sign == "-" else int(token.text)


def _bounded(unit: Unit) -> Unit:
    """The same unit, unless it is one that only a hostile file would have."""
    powers = max(map(abs, (*unit.dims, unit.pi)))
    if powers > _MAX_TOTAL_POWER or max(unit.num.bit_length(), unit.den.bit_length()) > 512:
        raise BadUnit("too complicated")
    return unit


def read_unit(text: str) -> Unit:
    """Read a unit from its ASCII spelling.

    Raises:
        BadUnit: it is none.
    """
    return _Reader(text).read()


DIMS_OF: dict[Kind, tuple[Dims, Dims]] = {
    kind: (read_unit(kind.rotary_unit).dims, read_unit(kind.linear_unit).dims) for kind in Kind
}
"""Dimensions of each kind at a hinge and at a slide."""
