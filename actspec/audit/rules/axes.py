"""How the axes of two joints lie to each other: unit vectors in the frame of a robot's base."""

from __future__ import annotations

import math
from collections.abc import Sequence

_TILTED = math.radians(30.0)
"""Least angle between two axes that are not parallel [rad]. Chosen: files draw a joint some degrees apart, and frames
differ by quarter turns."""


def angle(one: Sequence[float], other: Sequence[float]) -> float:
    """Between two axes [rad]."""
    return math.acos(max(-1.0, min(1.0, sum(a * b for a, b in zip(one, other, strict=True)))))


def are_opposite(one: Sequence[float], other: Sequence[float]) -> bool:
    """Whether two axes point against each other."""
    return angle(one, other) >= math.pi - _TILTED


def are_parallel(one: Sequence[float], other: Sequence[float]) -> bool:
    """Whether two axes lie alike, whichever way they point."""
    return angle(one, other) <= _TILTED or are_opposite(one, other)
