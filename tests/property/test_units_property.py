"""Units: what must hold for every number and every spelling."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from actspec.units import (
    MAX_LENGTH,
    Kind,
    UnitError,
    convert,
    format_quantity,
    parse_quantity,
    parse_with_unit,
)

# SI factors, typed by hand: a second table, so that a slip in either shows.
FORCE = {
    "N": 1.0, "mN": 1e-3, "kN": 1e3, "uN": 1e-6, "kgf": 9.80665, "gf": 9.80665e-3,
    "lbf": 4.4482216152605, "ozf": 0.27801385095378125, "oz": 0.27801385095378125,
}  # fmt: skip
LENGTH = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "km": 1e3, "in": 0.0254, "ft": 0.3048}
ANGLE = {"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180, "rev": 2 * math.pi, "turn": 2 * math.pi}
TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0}
MASS = {"kg": 1.0, "g": 1e-3, "mg": 1e-6}

KINDS = st.sampled_from(list(Kind))
# Away from overflow and underflow, which have their own tests.
NUMBERS = st.floats(min_value=-1e30, max_value=1e30).filter(lambda x: x == 0 or abs(x) > 1e-30)
TIMES_SIGN = st.sampled_from(["*", " * ", " ", "·", "⋅", "×"])
SQUARES = st.sampled_from(["^2", "**2", "²", "^(2)"])


def units(kind: Kind) -> list[str]:
    return sorted({kind.rotary_unit, kind.linear_unit})


@given(kind=KINDS, value=NUMBERS, digits=st.integers(1, 17), data=st.data())
def test_parse_reverses_format(kind: Kind, value: float, digits: int, data: st.DataObject) -> None:
    """Reading what was written gives the number within the digits written, exactly with 17."""
    unit = data.draw(st.sampled_from(units(kind)))
    parsed = parse_quantity(format_quantity(value, unit, digits), kind)
    assert parsed.value == pytest.approx(value, rel=0.5 * 10.0 ** (1 - digits) * (1 + 1e-9), abs=0)
    if digits == 17:
        assert parsed.value == value
    if parsed.linear is not None:
        assert parsed.unit == unit


@st.composite
def spelled(draw: st.DrawFn) -> tuple[str, Kind, bool | None, float]:
    """A unit in random spelling, with its kind, its joint and its factor."""
    f, x, m = draw(st.sampled_from(sorted(FORCE))), draw(st.sampled_from(sorted(LENGTH))), draw(TIMES_SIGN)
    a, t = draw(st.sampled_from(sorted(ANGLE))), draw(st.sampled_from(sorted(TIME)))
    kg, square = draw(st.sampled_from(sorted(MASS))), draw(SQUARES)
    force, length, angle, time, mass = FORCE[f], LENGTH[x], ANGLE[a], TIME[t], MASS[kg]
    return draw(
        st.sampled_from(
            [
                (f"{f}{m}{x}", Kind.TORQUE, False, force * length),
                (f"{x}{m}{f}", Kind.TORQUE, False, force * length),
                (f, Kind.TORQUE, True, force),
                (f"{f}{m}{x}/{a}", Kind.STIFFNESS, False, force * length / angle),
                (f"{f} / {x}", Kind.STIFFNESS, True, force / length),
                (f"{f}{m}{x}{m}{t}/{a}", Kind.VELOCITY_GAIN, False, force * length * time / angle),
                (f"{f}{m}{x}/({a}/{t})", Kind.VELOCITY_GAIN, False, force * length * time / angle),
                (f"{f}/({x}/{t})", Kind.VELOCITY_GAIN, True, force * time / length),
                (f"{kg}{m}{x}{square}", Kind.INERTIA, False, mass * length * length),
                (kg, Kind.INERTIA, True, mass),
                (f"{a}/{t}", Kind.SPEED, False, angle / time),
                (f"{x}{m}{t}^-1", Kind.SPEED, True, length / time),
                (a, Kind.ANGLE, None, angle),
                (t, Kind.TIME, None, time),
                (f"{x}/{x}", Kind.RATIO, None, 1.0),
            ]
        )
    )


@given(unit=spelled(), number=NUMBERS)
def test_every_spelling_has_its_factor(unit: tuple[str, Kind, bool | None, float], number: float) -> None:
    """Any product of table units is the product of their factors, and tells hinge from slide."""
    text, kind, linear, factor = unit
    parsed = parse_with_unit(number, text, kind)
    assert parsed.value == pytest.approx(number * factor, rel=1e-14, abs=0)
    assert parsed.linear is linear
    assert parse_quantity(f"{number!r} {text}", kind) == parsed


@given(unit=spelled(), number=NUMBERS)
def test_convert_reverses_parse(unit: tuple[str, Kind, bool | None, float], number: float) -> None:
    """To SI and back is the same number but for rounding."""
    text, kind, _, _ = unit
    assert convert(parse_with_unit(number, text, kind).value, text, kind) == pytest.approx(
        number, rel=1e-14, abs=0
    )


@given(unit=spelled(), kind=KINDS, number=NUMBERS)
def test_a_unit_fits_its_kind_only(
    unit: tuple[str, Kind, bool | None, float], kind: Kind, number: float
) -> None:
    """Another kind refuses it, 0 or not; a hinge's position is an angle, and that is the only overlap."""
    text, own, _, _ = unit
    fits = kind is own or (own is Kind.ANGLE and kind is Kind.POSITION)
    try:
        parse_with_unit(number, text, kind)
    except UnitError as error:
        assert not fits
        assert error.help
    else:
        assert fits


@given(text=st.text(max_size=MAX_LENGTH + 20), kind=KINDS)
def test_any_text_is_a_quantity_or_a_unit_error(text: str, kind: Kind) -> None:
    """Nothing else is ever raised, and a value is finite."""
    for candidate in (text, f"1 {text}"):
        try:
            assert math.isfinite(parse_quantity(candidate, kind).value)
        except UnitError as error:
            assert error.message.isprintable()
            assert len(error.message) < 300


GRAMMAR = st.lists(
    st.sampled_from(
        [
            "N",
            "m",
            "rad",
            "s",
            "kg",
            "%",
            "1",
            "2",
            "zz",
            "Nmm",
            "*",
            "/",
            "^",
            "**",
            "-",
            "(",
            ")",
            " ",
            "²",
            "⁻",
            "·",
        ]
    ),
    max_size=40,
).map("".join)


@given(text=GRAMMAR, kind=KINDS)
def test_near_misses_of_the_grammar(text: str, kind: Kind) -> None:
    """Text made of the grammar's own pieces, in any order, is a quantity or a UnitError."""
    try:
        assert math.isfinite(parse_quantity(f"3{text}", kind).value)
    except UnitError as error:
        assert len(error.message) < 300


@given(
    number=st.one_of(st.integers(), st.floats(), st.booleans(), st.none(), st.text(max_size=5)), kind=KINDS
)
def test_any_value_of_yaml(number: object, kind: Kind) -> None:
    """What a YAML scalar can be, in the place of the number."""
    try:
        assert math.isfinite(parse_with_unit(number, kind.rotary_unit, kind).value)  # type: ignore[arg-type]
    except UnitError as error:
        assert error.message
