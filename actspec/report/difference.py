"""A difference in words, and as machine output."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from actspec.audit.difference import Change, Difference
from actspec.diagnostics import Span, listed, one_line

_NO_RATIO = frozenset(
    {
        "default_position",
        "encoder_bias",
        "position_low",
        "position_high",
        "command_low",
        "command_high",
        "natural_frequency",
        "damping_ratio",
    }
)
"""What is measured from a zero that means nothing, or is rough."""

_OPTIONAL = frozenset(
    {
        "kp",
        "kd",
        "back_emf",
        "spring",
        "friction_static",
        "stribeck_velocity",
        "stall_torque",
        "no_load_speed",
        "delay",
        "delay_low",
        "delay_high",
        "filter_cutoff",
        "command_low",
        "command_high",
        "position_low",
        "position_high",
        "encoder_bias",
        "action_scale",
        "network",
    }
)
"""What a joint need not have, so that a file that says nothing has none of it."""


def lines(found: Difference, indent: str = "  ") -> Iterator[str]:
    """One paragraph a group of joints with equal changes.

    Args:
        found: The difference.
        indent: Before each line.
    """
    for change in found.changes:
        if not change.joint:
            yield f"{indent}{words(change)}"
    if found.added:
        yield f"{indent}joints added: {listed(map(one_line, found.added))}"
    if found.removed:
        yield f"{indent}joints removed: {listed(map(one_line, found.removed))}"
    for joints, told in _groups(found):
        yield f"{indent}{listed(map(one_line, joints))}:"
        for line in (*told, *_effects(found, joints)):
            yield f"{indent}  {line}"


def words(change: Change) -> str:
    """`total damping 4 -> 22 N*m*s/rad (x5.5)`."""
    absent = "none" if change.field in _OPTIONAL else "unknown"
    old, new = (_shown(value, absent) for value in (change.old, change.new))
    if old == new:
        old, new = (_shown(value, absent, 10) for value in (change.old, change.new))
    unit = (
        f" {change.unit}"
        if change.unit and isinstance(change.new, float) and math.isfinite(change.new)
        else ""
    )
    return f"{change.noun} {old} -> {new}{unit}{_ratio(change)}"


def record(found: Difference, old: str, new: str) -> dict[str, Any]:
    """A difference as machine output has it; null is unknown, the text `Infinity` no limit.

    Args:
        found: The difference.
        old: What the old file is called.
        new: What the new file is called.
    """
    return {
        "old": {"file": old, "kind": found.old.kind.value, "robot": found.old.name},
        "new": {"file": new, "kind": found.new.kind.value, "robot": found.new.name},
        "added": list(found.added),
        "removed": list(found.removed),
        "changes": [_change(change) for change in found.changes],
        "effects": [_change(change) for change in found.effects],
    }


def _change(change: Change) -> dict[str, Any]:
    return {
        "joint": change.joint or None,
        "field": change.field,
        "old": _number(change.old),
        "new": _number(change.new),
        "unit": change.unit or None,
        "ratio": change.ratio,
        "old_line": _line(change.old_place),
        "new_line": _line(change.new_place),
        "words": words(change),
    }


def _number(value: float | str | None) -> float | str | None:
    if isinstance(value, float) and not math.isfinite(value):
        return "Infinity" if value > 0.0 else "-Infinity"
    return value


def _line(place: Span | None) -> int | None:
    return None if place is None else place.line or None


def _groups(found: Difference) -> list[tuple[list[str], list[str]]]:
    """Joints with equal changes, and those changes in words."""
    told: dict[str, list[str]] = {}
    for change in found.changes:
        if change.joint:
            told.setdefault(change.joint, []).append(words(change))
    groups: dict[tuple[str, ...], list[str]] = {}
    for joint, texts in told.items():
        groups.setdefault(tuple(texts), []).append(joint)
    return [(joints, list(texts)) for texts, joints in groups.items()]


def _effects(found: Difference, joints: Sequence[str]) -> Iterator[str]:
    """What follows, as ranges over the joints of a group."""
    by_field: dict[str, list[Change]] = {}
    for change in found.effects:
        if change.joint in joints:
            by_field.setdefault(change.field, []).append(change)
    for changes in by_field.values():
        unit = f" {changes[0].unit}" if changes[0].unit else ""
        ends = (_range([c.old for c in changes]), _range([c.new for c in changes]))
        if ends[0] != ends[1]:
            yield f"{changes[0].noun} {ends[0]} -> {ends[1]}{unit}"


def _range(values: Sequence[float | str | None]) -> str:
    numbers = [value for value in values if isinstance(value, float)]
    low, high = f"{min(numbers):.2g}", f"{max(numbers):.2g}"
    return low if low == high else f"{low} to {high}"


def _shown(value: float | str | None, absent: str, digits: int = 6) -> str:
    if value is None:
        return absent
    if isinstance(value, str):
        # A network's hash says no more with 64 digits than with 12.
        return one_line(value[:12] if len(value) == 64 else value)
    if math.isinf(value):
        return "none"
    return f"{value + 0.0:.{digits}g}"


def _ratio(change: Change) -> str:
    ratio = change.ratio
    if ratio is None or change.field in _NO_RATIO:
        return ""
    if 0.5 <= ratio <= 2.0:
        return f" ({(ratio - 1.0) * 100.0:+.3g} %)"
    return f" (x{ratio:.3g})"
