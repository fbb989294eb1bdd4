"""Derivations as they are written."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic_core import PydanticCustomError

from actspec.spec.fields import DerivedGain, GainField
from actspec.spec.values import Number, SpecValue
from actspec.units import Kind

KP = GainField(
    Number(Kind.STIFFNESS, at_least=0.0, identified=True), ("torque_at_error", "natural_frequency")
)
KD = GainField(Number(Kind.VELOCITY_GAIN, at_least=0.0, identified=True), ("damping_ratio",))


def test_a_number_is_no_derivation() -> None:
    """Without `derive`, the field is a number, `identified` or `unknown`."""
    plain, fitted = KP("25 N*m/rad"), KP("identified")
    assert isinstance(plain, SpecValue) and isinstance(fitted, SpecValue)
    assert (plain.value, fitted.identified) == (25.0, True)


def test_torque_at_error() -> None:
    """It has no inertia."""
    found = KP({"derive": "torque_at_error", "fraction": "60 %", "error": "0.1 rad"})
    assert isinstance(found, DerivedGain)
    assert (found.numbers["fraction"].value, found.numbers["error"].value, found.inertia) == (0.6, 0.1, None)


@pytest.mark.parametrize(
    ("inertia", "expected"),
    [
        pytest.param("reflected", "reflected", id="reflected"),
        pytest.param("joint", "joint", id="joint"),
        pytest.param("100 g*cm^2", 1e-5, id="text"),
        pytest.param(0.01, 0.01, id="number"),
        pytest.param({"value": 0.01}, 0.01, id="mapping"),
    ],
)
def test_inertia(inertia: Any, expected: str | float) -> None:
    """A derivation names its inertia: one of two words, or a number."""
    found = KD({"derive": "damping_ratio", "ratio": 2, "inertia": inertia})
    assert isinstance(found, DerivedGain)
    assert (found.inertia.value if isinstance(found.inertia, SpecValue) else found.inertia) == expected


@pytest.mark.parametrize(
    ("field", "given", "message", "help", "at"),
    [
        pytest.param(
            KP, {"derive": "natural_freqency"}, "no derivation is named natural_freqency",
            "did you mean 'natural_frequency'?", ("derive",), id="misspelt",
        ),
        pytest.param(
            KD, {"derive": "natural_frequency"}, "'natural_frequency' does not derive a velocity gain",
            "known here: damping_ratio", ("derive",), id="of the other gain",
        ),
        pytest.param(
            KD, {"derive": "damping_ratio"}, "the derivation 'damping_ratio' needs ratio and inertia",
            "write for instance `{derive: damping_ratio, ratio: 0.25, inertia: reflected}`", (), id="missing",
        ),
        pytest.param(
            KP, {"derive": "natural_frequency", "frequency": 10, "inertia": "joint"},
            "10 has no unit, and a frequency needs one", "write `10 Hz`", ("frequency",), id="bare frequency",
        ),
        pytest.param(
            KP, {"derive": "torque_at_error", "fraction": "unknown", "error": "1 rad"},
            "a ratio is needed here, got `unknown`", "write for instance `0.25`", ("fraction",), id="unknown",
        ),
        pytest.param(
            KD, {"derive": "damping_ratio", "ratio": 1, "inertia": {"value": "unknown"}},
            "an inertia is needed here, got `unknown`", "write for instance `0.01 kg*m^2`", ("inertia", "value"),
            id="unknown inertia",
        ),
        pytest.param(
            KD, {"derive": "damping_ratio", "ratio": 1, "inertia": "held"},
            "must be `reflected`, `joint` or an inertia, got held",
            "`reflected` is the rotor's inertia seen at the joint, `joint` the robot's M_jj", ("inertia",), id="word",
        ),
        pytest.param(
            KP, {"derive": "torque_at_error", "fraction": 0, "error": "1 rad"}, "must be > 0, got 0", None,
            ("fraction",), id="zero",
        ),
    ],
)  # fmt: skip
def test_refused(field: GainField, given: Any, message: str, help: str | None, at: tuple[str, ...]) -> None:
    """Each refusal says what is wrong with which key."""
    with pytest.raises(PydanticCustomError) as caught:
        field(given)
    context = dict(caught.value.context or {})
    assert (context["message"], context["help"], tuple(context["at"])) == (message, help, at)
