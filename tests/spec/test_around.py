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
        # The amplitude of a sine is sqrt 2 of its rms: 16.97056.
        *(
            (
                f"24 A{text}",
                Kind.CURRENT,
                f"`{text.strip(' ,')}` behind 24 A is no unit",
                "write `peak_current: 24 A`; if it is the amplitude of a sine, `16.9706 A` beside a torque "
                "constant per A rms",
            )
            for text in (" peak", " (peak)", ", peak")
        ),
        ("24 A max", Kind.CURRENT, "`max` behind 24 A is no unit", "write `peak_current: 24 A`"),
        ("9 A cont.", Kind.CURRENT, "`cont.` behind 9 A is no unit", "write `nominal_current: 9 A`"),
        ("9 A rated", Kind.CURRENT, "`rated` behind 9 A is no unit", "write `nominal_current: 9 A`"),
        (
            "24 A (peak), 10 s",
            Kind.CURRENT,
            "`(peak), 10 s` behind 24 A is no unit",
            'write `{value: 24 A, note: "(peak), 10 s"}`',
        ),
        (
            "9 N*m stall",
            Kind.TORQUE,
            "`stall` behind 9 N*m is no unit",
            'write `{value: 9 N*m, note: "stall"}`',
        ),
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


@pytest.mark.parametrize(
    ("given", "kind", "help"),
    [
        # pi is 3.14159265.
        ("pi/2 rad", Kind.POSITION, "write `1.5708 rad`"),
        ("1/20", Kind.RATIO, "write `0.05`, or `20` for a gearbox that reduces the speed so"),
        ("20/1", Kind.RATIO, "write `20`"),
        ("-pi/2 rad", Kind.POSITION, "write `-1.5708 rad`"),
        ("0.5*pi rad", Kind.POSITION, "write `1.5708 rad`"),
        ("pi", Kind.ANGLE, "write `3.14159 rad`"),
        ("2 pi", Kind.POSITION, "write `6.28319 rad`"),
        ("np.pi / 2", Kind.POSITION, "write `1.5708 rad`"),
        ("90*π/180", Kind.POSITION, "write `1.5708 rad`"),
        ("2*pi*10 rad/s", Kind.SPEED, "write `62.8319 rad/s`"),
        ("10/4 rad/s", Kind.SPEED, "write `2.5 rad/s`"),
        ("50/20", Kind.RATIO, "write `2.5`"),
        ("6.4*10^-5 kg*m^2", Kind.INERTIA, "write `6.4e-05 kg*m^2`"),
        ("6.4×10⁻⁵ kg·m²", Kind.INERTIA, "write `6.4e-05 kg*m^2`"),
        ("6.4 x 10^-5 kgm2", Kind.INERTIA, "did you mean `6.4e-05 kg*m^2`?"),
        ("6.4 x 10-5 kg*m^2", Kind.INERTIA, "write `6.4e-5 kg*m^2`"),
        ("6.4 e-5 kg*m^2", Kind.INERTIA, "write `6.4e-5 kg*m^2`"),
    ],
)
def test_a_number_that_is_to_be_worked_out(given: str, kind: Kind, help: str) -> None:
    """What it makes, and nothing that is a part of it."""
    found = explained(given, kind, BOTH, False)
    assert found is not None and found[1] == help


@pytest.mark.parametrize(
    "given",
    [
        "1/2pi rad",
        "pi/2 + 0.1 rad",
        "-pi -2 rad",
        "pi/2 deg",
        "2*pi/0 rad",
        "9*10^99*10^99*10^99*10^99 rad",
        "sqrt(2) rad",
        "2 x 10 rad",
        "(pi/2) rad",
    ],
)
def test_a_factor_is_no_remark(given: str) -> None:
    """What is left without it is another number."""
    assert explained(given, Kind.POSITION, (), False) is None


def test_inside_a_mapping() -> None:
    """No second pair of braces."""
    found = explained("24 V DC", Kind.VOLTAGE, (), True)
    assert found is not None and found[1] == 'write `value: 24 V, note: "DC"`'
