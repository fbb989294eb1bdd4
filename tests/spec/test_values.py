"""Numbers as a spec writes them: kinds, units, words, bounds, and what is said of wrong ones."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic_core import PydanticCustomError

from actspec.spec.fields import CommandRange, CommandRangeField, DelayField, EffortField
from actspec.spec.values import Number, Pair, SpecValue, short
from actspec.units import Kind

TORQUE = Number(Kind.TORQUE, above=0.0)


def said(parse: Any, given: Any) -> tuple[str, str | None, tuple[str | int, ...]]:
    """Message, help and place of a refusal."""
    with pytest.raises(PydanticCustomError) as caught:
        parse(given)
    context = dict(caught.value.context or {})
    return context["message"], context["help"], tuple(context["at"])


@pytest.mark.parametrize(
    ("given", "value", "unit", "linear"),
    [
        pytest.param("33.5 N*m", 33.5, "N*m", False, id="text"),
        pytest.param("33500 mN*m", 33.5, "N*m", False, id="milli"),
        pytest.param("33.5", 33.5, "N*m", None, id="bare text"),
        pytest.param(33.5, 33.5, "N*m", None, id="bare number"),
        pytest.param("200 N", 200.0, "N", True, id="force"),
        pytest.param({"value": "33.5 N*m"}, 33.5, "N*m", False, id="mapping"),
        pytest.param({"value": 335, "unit": "kgf*cm"}, 32.8522775, "N*m", False, id="unit apart"),
        pytest.param(
            {"value": "335", "unit": "kgf*cm"}, 32.8522775, "N*m", False, id="unit apart, number as text"
        ),
        pytest.param("unknown", None, "N*m", None, id="unknown"),
        pytest.param(
            {"value": "unknown", "note": "asked twice"}, None, "N*m", None, id="unknown with a note"
        ),
    ],
)
def test_a_torque(given: Any, value: float | None, unit: str, linear: bool | None) -> None:
    """Text, number, mapping, unknown."""
    found = TORQUE(given)
    assert found.value == pytest.approx(value) if value is not None else found.value is None
    assert (found.unit, found.linear) == (unit, linear)


def test_everything_that_a_value_may_carry() -> None:
    """Source, std and note stay with the number; std is in the number's own unit."""
    found = TORQUE({"value": 33500, "unit": "mN*m", "source": "manual", "std": 500, "note": "at 24 V"})
    assert found == SpecValue(33.5, "N*m", False, "33500 mN*m", "manual", 0.5, "at 24 V")


def test_std_with_a_unit_of_its_own() -> None:
    """A std may carry its unit: 500 mN*m beside a value in N*m."""
    assert TORQUE({"value": "33.5 N*m", "std": "500 mN*m"}).std == 0.5


@pytest.mark.parametrize(
    ("number", "given", "message", "help", "at"),
    [
        pytest.param(TORQUE, 0, "must be > 0 N*m, got 0 N*m", None, (), id="zero"),
        pytest.param(
            Number(Kind.INERTIA, at_least=0.0),
            "-100 g*cm^2",
            "must be >= 0 kg*m^2, got -1e-05 kg*m^2",
            None,
            (),
            id="negative",
        ),
        pytest.param(
            Number(Kind.RATIO, above=0.0, at_most=1.0),
            85,
            "must be <= 1, got 85",
            "did you mean `85 %`? That is 0.85",
            (),
            id="percent",
        ),
        pytest.param(
            Number(Kind.RATIO, above=0.0, at_most=1.0), 1.23, "must be <= 1, got 1.23", None, (), id="no percent"
        ),
        # 0.05 x 6 N*m.
        pytest.param(
            TORQUE,
            {"value": "6 N*m", "std": "5 %"},
            "5 % is dimensionless, not a torque",
            "5 % of the value is `0.3 N*m`",
            ("std",),
            id="std in percent",
        ),
        pytest.param(TORQUE, True, "must be a torque, got true", "write for instance `33.5 N*m`", (), id="bool"),
        pytest.param(TORQUE, None, "must be a torque, got null", "write for instance `33.5 N*m`", (), id="null"),
        pytest.param(
            Number(Kind.INERTIA), [1], "must be an inertia, got [1]", "write `1` without [ ]", (), id="list"
        ),
        pytest.param(
            TORQUE, "identified", "a torque is needed here, got `identified`", "write for instance `33.5 N*m`", (),
            id="not identifiable",
        ),
        pytest.param(
            Number(Kind.RATIO, unknown=False), "unknown", "a ratio is needed here, got `unknown`",
            "write for instance `0.25`", (), id="must be known",
        ),
        pytest.param(
            TORQUE, {"vlaue": 3}, "unknown key 'vlaue' in a value", "did you mean 'value'?", ("vlaue",), id="key"
        ),
        pytest.param(
            TORQUE, {"unit": "N*m"}, "a value needs its key 'value'", "write {value: 33.5 N*m, source: ...}", (),
            id="no value",
        ),
        pytest.param(
            TORQUE, {"value": "3 N*m", "unit": "N*m"},
            "the unit stands twice, in `value: 3 N*m` and in `unit: N*m`", "remove `unit`", ("unit",), id="unit twice",
        ),
        pytest.param(
            TORQUE, {"value": 3, "source": 4}, "must be text, got 4", 'write "4" in quotes', ("source",), id="source"
        ),
        pytest.param(
            TORQUE, {"value": 3, "std": -1}, "must be >= 0 N*m, got -1 N*m", None, ("std",), id="negative std"
        ),
        pytest.param(
            TORQUE, {"value": "3 N*m", "std": "1 N"}, "is in N, but the value is in N*m", "write it in N*m", ("std",),
            id="std of a slide",
        ),
        pytest.param(
            Number(Kind.SPEED), "30 Hz", "30 Hz is a frequency, not a speed",
            "30 Hz as angular speed is 188.496 rad/s", (), id="Hz for rad/s",
        ),
        pytest.param(
            Number(Kind.TIME), 5, "5 has no unit, and a time needs one", "write `5 ms` or `5 s`", (), id="bare time"
        ),
    ],
)  # fmt: skip
def test_refused(number: Number, given: Any, message: str, help: str | None, at: tuple[str, ...]) -> None:
    """Each refusal has the value with its unit, the nearest right answer, and the place below the field."""
    assert said(number, given) == (message, help, at)


def test_pair() -> None:
    """Two numbers in order, or a word where the field has one."""
    low, high = Pair(Kind.POSITION)(["-90 deg", 0])
    assert isinstance(low, SpecValue) and isinstance(high, SpecValue)
    assert (low.value, high.value) == (pytest.approx(-1.5707963267948966), 0.0)
    assert Pair(Kind.POSITION, words=("none",))("none") == "none"


@pytest.mark.parametrize(
    ("given", "message", "at"),
    [
        pytest.param("1 rad", "must be [low, high], each a position, got 1 rad", (), id="scalar"),
        pytest.param(["1 rad"], "must be [low, high], each a position, got ['1 rad']", (), id="one"),
        pytest.param(
            ["1 rad", "-1 rad"], "the range is the wrong way round: 1 rad is above -1 rad", (), id="inverted"
        ),
        pytest.param(["0 rad", "1 m"], "the ends are in two units, 0 rad and 1 m", (), id="two units"),
        pytest.param([0, 1], "1 has no unit, and a position needs one", (1,), id="bare"),
        pytest.param([0, "unknown"], "a position is needed here, got `unknown`", (1,), id="unknown"),
    ],
)
def test_pair_refused(given: Any, message: str, at: tuple[int, ...]) -> None:
    """The end that is wrong is named by its index."""
    found = said(Pair(Kind.POSITION), given)
    assert (found[0], found[2]) == (message, at)


def test_effort_words() -> None:
    """An effort limit is a torque or one of two words."""
    assert EffortField()("peak") == "peak"
    found = EffortField()("20 N*m")
    assert isinstance(found, SpecValue) and found.value == 20.0
    assert said(EffortField(), "continous")[1] == "did you mean 'continuous'?"
    assert said(EffortField(), "peak_torque")[1] == "did you mean 'peak'?"
    assert said(EffortField(), "rated_torque")[1] == "did you mean 'continuous'?"


@pytest.mark.parametrize(
    ("given", "kind"),
    [
        pytest.param(["-1 rad", "1 rad"], Kind.POSITION, id="position"),
        pytest.param(["-60 rpm", "1 rad/s"], Kind.SPEED, id="speed"),
        pytest.param([-5, 5], Kind.TORQUE, id="bare numbers can only be torques"),
    ],
)
def test_command_range_kind(given: Any, kind: Kind) -> None:
    """The unit tells what the command is."""
    found = CommandRangeField()(given)
    assert isinstance(found, CommandRange)
    assert found.kind is kind


@pytest.mark.parametrize(
    ("given", "message", "at"),
    [
        pytest.param(
            {"nominal": "5 ms", "rnage": []}, "unknown key 'rnage' in a delay", ("rnage",), id="key"
        ),
        pytest.param({"range": [0, "5 ms"]}, "a delay needs its key 'nominal'", (), id="no nominal"),
        pytest.param(
            {"nominal": "5 ms", "range": [0, "4 ms"]},
            "the nominal delay 5 ms is outside its range [0, 4 ms]",
            ("range",),
            id="outside",
        ),
        pytest.param(
            {"nominal": "5 ms", "sampling": []},
            "must be `episode` or `step`, got []",
            ("sampling",),
            id="sampling",
        ),
        pytest.param({"nominal": 5}, "5 has no unit, and a time needs one", ("nominal",), id="bare"),
        pytest.param("-1 ms", "must be >= 0 s, got -0.001 s", (), id="negative"),
    ],
)
def test_delay_refused(given: Any, message: str, at: tuple[str, ...]) -> None:
    """A delay names the key that is wrong."""
    found = said(DelayField(), given)
    assert (found[0], found[2]) == (message, at)


def test_short_is_yaml() -> None:
    """What a message quotes is written as YAML has it, and cut."""
    assert [short(x) for x in (True, None, "a", 1.5, "x" * 61)] == [
        "true",
        "null",
        "a",
        "1.5",
        "x" * 57 + "...",
    ]
