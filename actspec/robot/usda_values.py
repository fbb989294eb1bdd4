"""Values of USD attributes: what a text stands for, and what a type takes."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping

from actspec.robot.usda import Asset, Value

_FLOATS = {
    "float": 3.4028235e38,
    "double": sys.float_info.max,
    "timecode": sys.float_info.max,
    "half": 65504.0,
}
"""Type to its largest number; a larger one is infinite."""
_INTEGERS = {
    "int": (-(2**31), 2**31 - 1),
    "int64": (-(2**63), 2**63 - 1),
    "uint": (0, 2**32 - 1),
    "uint64": (0, 2**64 - 1),
    "uchar": (0, 255),
}
NUMERIC = (*_FLOATS, *_INTEGERS)
"""Types of one number."""
PLAIN = (*NUMERIC, "bool", "string", "token", "asset")
"""Types whose values are held to them."""

WORDS: Mapping[str, Value] = {
    "inf": math.inf,
    "nan": math.nan,
    "true": True,
    "false": False,
    "None": None,
}
"""Words that are values."""


def number(text: str) -> float | int:
    """As an int where it is written as one, and no longer than any that a type holds."""
    return int(text) if text.lstrip("-").isdigit() and len(text) <= 20 else float(text)


def fitted(kind: str, item: Value) -> Value:
    """A value as USD takes it for a type; None where it does not fit."""
    figure = item if isinstance(item, int | float) and not isinstance(item, bool) else None
    if kind in _FLOATS:
        if figure is None or abs(figure) <= _FLOATS[kind]:
            return None if figure is None else float(figure)
        return math.nan if math.isnan(figure) else math.copysign(math.inf, figure)
    if kind in _INTEGERS:
        low, high = _INTEGERS[kind]
        # A fraction is cut off.
        return int(figure) if figure is not None and low <= figure <= high else None
    if kind == "bool":
        return item if isinstance(item, bool) else None if figure is None else figure != 0
    if kind in ("string", "token"):
        return item if isinstance(item, str) else None
    if kind == "asset":
        return item if isinstance(item, Asset) else None
    return item
