"""Axes of two joints: one bound for all rules that ask whether they lie alike."""

from __future__ import annotations

import math

import pytest

from actspec.audit.rules.axes import angle, are_opposite, are_parallel


@pytest.mark.parametrize(
    ("degrees", "parallel", "opposite"),
    [
        (0, True, False),
        (29, True, False),
        (31, False, False),
        (90, False, False),
        (149, False, False),
        (151, True, True),
    ],
)
def test_axes_some_degrees_apart(degrees: float, parallel: bool, opposite: bool) -> None:
    one, other = (0.0, 0.0, 1.0), (math.sin(math.radians(degrees)), 0.0, math.cos(math.radians(degrees)))
    assert angle(one, other) == pytest.approx(math.radians(degrees))
    assert (are_parallel(one, other), are_opposite(one, other)) == (parallel, opposite)


def test_axes_longer_by_a_rounding_are_one() -> None:
    # 1.0000001^2 is above 1, which no cosine is.
    assert angle((0.0, 0.0, 1.0000001), (0.0, 0.0, 1.0000001)) == 0.0
