"""Colours of the pages against their grounds, by WCAG 2.1's formula: letters 4.5, lines and points 3."""

from __future__ import annotations

import re

import pytest

from actspec.resources import data_path


def css() -> str:
    return "".join(
        data_path("templates", f"report/{name}.css").read_text("utf-8") for name in ("report", "plot")
    )


def colours(dark: bool) -> dict[str, tuple[int, ...]]:
    """The palette: of the light, with what the dark says otherwise."""
    parts = re.findall(r"(@media \(prefers-color-scheme: dark\) \{ )?:root \{([^}]*)\}", css())
    found: dict[str, tuple[int, ...]] = {}
    for media, body in parts:
        if dark or not media:
            for name, value in re.findall(r"--([a-z0-9]+):\s*#([0-9a-f]{6})", body):
                found[name] = tuple(int(value[k : k + 2], 16) for k in (0, 2, 4))
    return found


def luminance(colour: tuple[float, ...]) -> float:
    parts = [c / 255 for c in colour]
    linear = [c / 12.92 if c <= 0.03928 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(colour: tuple[float, ...], ground: tuple[float, ...]) -> float:
    light, dark = sorted((luminance(colour), luminance(ground)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def test_the_formula() -> None:
    """Black on white is 21; #767676 on white is the well-known last grey of 4.5."""
    assert contrast((0, 0, 0), (255, 255, 255)) == pytest.approx(21.0)
    assert contrast((0x76,) * 3, (255,) * 3) == pytest.approx(4.54, abs=0.01)


@pytest.mark.parametrize("dark", [False, True])
def test_letters_and_lines(dark: bool) -> None:
    """Also of the points and broad lines that let others through."""
    found = colours(dark)
    assert found["ground"] == ((13, 17, 23) if dark else (255, 255, 255))
    for ground in ("ground", "soft"):
        for name in ("text", "faint", "error", "warning", "info"):
            assert contrast(found[name], found[ground]) >= 4.5, (name, ground)
    thin = min(float(share) for share in re.findall(r"stroke-opacity: (\.\d+)", css()))
    assert thin < 1.0
    for name in ("c0", "c1", "c2", "c3", "c4"):
        seen = tuple(thin * a + (1.0 - thin) * b for a, b in zip(found[name], found["ground"], strict=True))
        assert contrast(seen, found["ground"]) >= 3.0, name
