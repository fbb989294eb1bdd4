"""A difference in words, and as machine output."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from actspec.audit.difference import Change, Difference
from actspec.diagnostics import Span, listed, one_line
from actspec.fields import FIELDS, Role
from actspec.report.terminal import json_number
from actspec.units import format_number

_NO_RATIO = ("encoder_bias", "command_low", "command_high", "natural_frequency", "damping_ratio")
"""What is measured from a zero that means nothing, or is rough; so are poses."""

_MAY_LACK = frozenset({"network", *(field.name for field in FIELDS.values() if field.optional)})
"""What a joint need not have, beside drive and command, so that a file without it has none of it."""


def report_lines(found: Sequence[Difference], old: str, new: str) -> Iterator[str]:
    """The differences of two files as text.

    Args:
        found: One a robot.
        old: What the old file is called.
        new: What the new file is called.
    """
    changed = [item for item in found if not item.same]
    for item in changed:
        yield f"{one_line(old)} -> {one_line(new)} ({one_line(item.new.name)})"
        yield from lines(item)
    if not changed:
        yield "no change in effective dynamics"


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
    for joints, texts in _by_joints(found):
        yield f"{indent}{listed(map(one_line, joints))}:"
        for line in (*texts, *_effects(found, joints)):
            yield f"{indent}  {line}"


def words(change: Change) -> str:
    """`total damping 4 -> 22 N*m*s/rad (x5.5)`."""
    field = FIELDS.get(change.field)
    optional = change.field in _MAY_LACK or (field and field.role in (Role.DRIVE, Role.COMMAND))
    absent = "none" if optional else "unknown"
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
        "old": change.old if isinstance(change.old, str) else json_number(change.old),
        "new": change.new if isinstance(change.new, str) else json_number(change.new),
        "unit": change.unit or None,
        "ratio": change.ratio,
        "old_line": _line(change.old_place),
        "new_line": _line(change.new_place),
        "words": words(change),
    }


def _line(place: Span | None) -> int | None:
    return None if place is None else place.line or None


def _by_joints(found: Difference) -> list[tuple[list[str], tuple[str, ...]]]:
    """Joints with equal changes, and those changes in words."""
    by_joint: dict[str, list[str]] = {}
    for change in found.changes:
        if change.joint:
            by_joint.setdefault(change.joint, []).append(words(change))
    merged: dict[tuple[str, ...], list[str]] = {}
    for joint, texts in by_joint.items():
        merged.setdefault(tuple(texts), []).append(joint)
    return [(joints, texts) for texts, joints in merged.items()]


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
    low, high = format_number(min(numbers), 2), format_number(max(numbers), 2)
    return low if low == high else f"{low} to {high}"


def _shown(value: float | str | None, absent: str, digits: int = 6) -> str:
    if value is None:
        return absent
    if isinstance(value, str):
        # A network's hash says no more with 64 digits than with 12.
        return one_line(value[:12] if len(value) == 64 else value)
    if math.isinf(value):
        return "none"
    return format_number(value, digits)


def _ratio(change: Change) -> str:
    ratio = change.ratio
    field = FIELDS.get(change.field)
    if ratio is None or change.field in _NO_RATIO or (field and field.role is Role.POSE):
        return ""
    if 0.5 <= ratio <= 2.0:
        percent = (ratio - 1.0) * 100.0
        return f" ({'+' * (percent > 0.0)}{format_number(percent, 3)} %)"
    return f" (x{format_number(ratio, 3)})"
