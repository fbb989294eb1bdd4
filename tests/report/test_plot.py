"""Pictures: places worked out by hand, peaks that stay, and names that are text."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from actspec.report.axes import Axis, log_ticks, ticks
from actspec.report.plot import Band, Bars, Chart, Line, Mark, Points, Rule, svg, thinned
from actspec.report.row_pictures import Interval, intervals

X, Y = Axis("time", "s"), Axis("position", "rad")


def drawn(*marks: Mark, x: Axis = X, y: Axis = Y) -> tuple[ElementTree.Element, float, float]:
    """The window in which marks are drawn, with its width and height."""
    picture = ElementTree.fromstring(svg(Chart("t", x, y, marks)))
    field = picture.find("svg")
    assert field is not None
    _, _, wide, high = (float(part) for part in field.attrib["viewBox"].split())
    return field, wide, high


def places(path: str) -> list[list[tuple[int, int]]]:
    """The lines of a path: absolute begin, then ways."""
    found = []
    for part in re.findall(r"M[^M]*", path):
        numbers = [int(n) for n in re.findall(r"-?\d+", part)]
        at = (numbers[0], numbers[1])
        line = [at]
        for a, b in zip(numbers[2::2], numbers[3::2], strict=False):
            at = (at[0] + a, at[1] + b)
            line.append(at)
        found.append(line)
    return found


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        (0.0, 1.0, [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]),
        # 7.1 over 5 ways is 1.42: the next round one is 2.
        (-0.1, 7.0, [0.0, 2.0, 4.0, 6.0]),
        (-3e-4, 3e-4, [-2e-4, 0.0, 2e-4]),
    ],
)
def test_ticks_are_round(low: float, high: float, expected: list[float]) -> None:
    """1, 2 or 5 times a power of ten, at most six."""
    assert ticks(low, high) == pytest.approx(expected, abs=1e-12)


def test_log_ticks() -> None:
    """2 and 5 where there is room; decades alone where there is not; ordinary ticks within a decade."""
    assert log_ticks(0.5, 20.0) == pytest.approx([0.5, 1, 2, 5, 10, 20])
    assert log_ticks(1e-3, 1e3) == pytest.approx([1e-3, 1e-2, 0.1, 1, 10, 100, 1000])
    assert log_ticks(11.0, 13.0) == pytest.approx(ticks(11.0, 13.0, 8))


def test_a_line_is_where_its_numbers_are() -> None:
    """Low left to high right; y grows upwards. A quarter of the axis is a quarter of the width."""
    y = Axis("position", "rad", low=0.0, high=10.0)
    line = Line(np.array([0.0, 1.0, 4.0]), np.array([0.0, 10.0, 5.0]))
    field, wide, high = drawn(line, y=y)
    (mine,) = places(field[0].attrib["d"])
    expected = [(0, high), (wide / 4, 0), (wide, high / 2)]
    assert np.abs(np.array(mine) - expected).max() <= 1


def test_logarithmic_axes() -> None:
    """1 of 0.1 to 10 is in the middle; what is not above 0 is left out."""
    x = Axis("frequency", "Hz", log=True)
    line = Line(np.array([-1.0, 0.1, 1.0, 10.0]), np.array([0.0, 0.0, 1.0, 2.0]))
    field, wide, _ = drawn(line, x=x)
    (mine,) = places(field[0].attrib["d"])
    assert np.abs(np.array([p[0] for p in mine]) - [0, wide / 2, wide]).max() <= 1


def test_what_is_no_number_interrupts() -> None:
    """Two lines beside a NaN; stairs hold a value until the next."""
    x = np.arange(5.0)
    field, wide, _ = drawn(Line(x, np.array([0.0, 1.0, np.nan, 1.0, 0.0])))
    assert [len(line) for line in places(field[0].attrib["d"])] == [2, 2]
    field, wide, high = drawn(Line(x[:2], np.array([0.0, 1.0]), stairs=True), y=Axis("", low=0.0, high=1.0))
    (mine,) = places(field[0].attrib["d"])
    assert mine == [(0, round(high)), (round(wide), round(high)), (round(wide), 0)]


def test_peaks_stay() -> None:
    """One row of a hundred thousand is 5: it is among the few that are drawn."""
    x = np.arange(100_000.0)
    y = np.sin(x / 3e4)
    y[54_321], y[54_400] = 5.0, -7.0
    few, kept = thinned(x, y, 400)
    assert len(few) <= 800
    assert (kept.max(), kept.min()) == (5.0, -7.0)
    assert np.all(np.diff(few) > 0)
    # Little is drawn as it is.
    assert (
        thinned(x[:1000], y[:1000], 400)[0] is not None and len(thinned(x[:1000], y[:1000], 400)[0]) == 1000
    )


def test_points_of_one_place_are_one() -> None:
    """Ten thousand readings at two places."""
    x, y = np.repeat([0.0, 1.0], 5000), np.repeat([0.0, 2.0], 5000)
    field, _, _ = drawn(Points(x, y))
    assert field[0].attrib["d"].count("h0") == 2


def test_bars_and_bands_and_rules() -> None:
    """Bars stand on the axis: a third is a third as high as the highest; a rule goes all across."""
    bars = Bars(np.array([0.0, 1.0, 2.0]), np.array([1.0, 3.0]))
    field, wide, high = drawn(bars, Rule(1.5, upright=False), y=Axis("rows", low=0.0, high=3.0))
    assert field[0].attrib["d"] == (
        f"M0 {high:.0f}V{2 * high / 3:.0f}H{wide / 2:.0f}V{high:.0f}M{wide / 2:.0f} {high:.0f}V0H{wide:.0f}V{high:.0f}"
    )
    assert field[1].attrib["d"] == f"M0 {high / 2:.0f}H{wide:.0f}"
    x = np.arange(3.0)
    field, _, _ = drawn(Band(x, x - 1, x + 1))
    (mine,) = places(field[0].attrib["d"].replace("z", ""))
    assert len(mine) == 6


def test_small_numbers_have_a_prefix() -> None:
    """0.0005 rad is half a mrad; the unit of a gain has a power of ten."""
    small = Line(np.arange(3.0), np.array([0.0, 5e-4, 1e-3]))
    text = svg(Chart("t", X, Axis("error", "rad"), [small]))
    assert "error [mrad]" in text and ">1.0<" in text
    text = svg(Chart("t", X, Axis("b", "N*m*s/rad"), [small]))
    assert "b [1e-3 N*m*s/rad]" in text


def test_intervals_show_what_has_no_value() -> None:
    """In words, beside the spec's; value and interval of the others in order."""
    rows = [Interval("hip", 2.0, 1.0, 3.0, other=4.0), Interval("calf", None, other=0.5, note="not told")]
    text = intervals("kp", Axis("kp", "N*m/rad"), rows)
    assert ">not told<" in text and text.count("diamond") == 3
    picture = ElementTree.fromstring(text)
    (bar,) = [part for part in picture if part.get("class") == "c0 thick"]
    low, high = (float(n) for n in re.findall(r"M([\d.]+) [\d.]+v", bar.attrib["d"])[:2])
    (dot,) = picture.findall("circle")
    assert float(dot.attrib["cx"]) == pytest.approx((low + high) / 2, abs=0.11)


def test_names_are_text() -> None:
    """A title, a label and a name that would be markup."""
    bad = "</svg><script>alert(1)</script>\"'"
    texts = [
        svg(Chart(bad, Axis(bad, bad), Axis(bad), [Line(np.arange(3.0), np.arange(3.0), bad)])),
        intervals(bad, Axis(bad), [Interval(bad, None, other=1.0, note=bad)], other=bad),
    ]
    for text in texts:
        picture = ElementTree.fromstring(text)
        assert not [part for part in picture.iter() if part.tag == "script"]
        assert "alert(1)" in "".join(picture.itertext())


@pytest.mark.parametrize("values", [[], [np.nan, np.nan], [2.0, 2.0], [0.0, 0.0], [-1e300, 1e300]])
def test_nothing_to_draw_is_drawn(values: list[float]) -> None:
    """Empty, all alike, not a number, or huge: a picture all the same."""
    y = np.array(values)
    x = np.arange(float(len(y)))
    for mark in (Line(x, y, "a"), Points(x, y, "b"), Band(x, y, y, "c")):
        ElementTree.fromstring(svg(Chart("t", X, Y, [mark])))
        ElementTree.fromstring(svg(Chart("t", Axis("f", "Hz", log=True), Axis("g", log=True), [mark])))
