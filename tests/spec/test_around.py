"""What stands around a number: told as what it is, with the line to write."""

from __future__ import annotations

import pytest

from actspec.spec.around import explained
from actspec.units import Kind

BOTH = ("unknown",)


@pytest.mark.parametrize(
    ("given", "kind", "message", "help"),
    [
        ("24 V DC", Kind.VOLTAGE, "`DC` behind 24 V is no unit", 'write `{value: 24 V, note: "DC"}`'),
        (
            "9 N*m manual",
            Kind.TORQUE,
            "`manual` behind 9 N*m is no unit",
            "write `{value: 9 N*m, source: manual}`",
        ),
        (
            "9 N*m @ 24 V",
            Kind.TORQUE,
            "`@ 24 V` behind 9 N*m is no unit",
            'write `{value: 9 N*m, note: "@ 24 V"}`',
        ),
        (
            "3 +- 0.2 N*m",
            Kind.TORQUE,
            "`3 +- 0.2 N*m` is a number and its deviation",
            "write `{value: 3 N*m, std: 0.2 N*m}`, if that is one standard deviation",
        ),
        # 5 % of 4.
        (
            "4 N*m ± 5 %",
            Kind.TORQUE,
            "`4 N*m ± 5 %` is a number and its deviation",
            "write `{value: 4 N*m, std: 0.2 N*m}`, if that is one standard deviation",
        ),
        (
            "10..12 A",
            Kind.CURRENT,
            "`10..12 A` is a range, and one number is needed",
            'write `{value: 10 A, note: "10..12 A"}`, with the one of the two that holds',
        ),
        ("~370 rpm", Kind.SPEED, "`~` before 370 rpm is no part of a number", None),
        ("< -5 N*m", Kind.TORQUE, "`<` before -5 N*m is no part of a number", None),
        ("=51", Kind.RATIO, "`=` before 51 is no part of a number", "write `51`"),
        (
            "51#harmonic",
            Kind.RATIO,
            "`51#harmonic`: what stands behind 51 is no unit",
            "a comment begins with a space and `#`: write `51 # harmonic`",
        ),
        (
            "5'000 N/m",
            Kind.STIFFNESS,
            "`5'000 N/m` has a mark inside a number",
            "thousands have no mark: write `5000 N/m`",
        ),
        *(
            (
                word,
                Kind.FREQUENCY,
                f"`{word}` is no number",
                "for a figure that nobody states write `unknown`",
            )
            for word in ("n/a", "N/A", "TBD", "-", "?")
        ),
    ],
)
def test_what_is_no_part_of_a_number(given: str, kind: Kind, message: str, help: str | None) -> None:
    """Each with what to write, worked out by hand."""
    found = explained(given, kind, BOTH, False)
    assert found is not None
    assert found[0] == message
    assert help is None or found[1] == help


@pytest.mark.parametrize("given", ["- 5 N*m", "-- 5 N*m", "abc", "5 zz", "9 N.m", "10-12 A", "a..b", ""])
def test_what_is_another_mistake(given: str) -> None:
    """A sign is never taken away, and of what is no number nothing is meant."""
    assert explained(given, Kind.TORQUE, (), False) is None


def test_inside_a_mapping() -> None:
    """No second pair of braces."""
    found = explained("24 V DC", Kind.VOLTAGE, (), True)
    assert found is not None and found[1] == 'write `value: 24 V, note: "DC"`'
