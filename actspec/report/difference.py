"""A difference in words, and as machine output."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Sequence
from typing import Any

from actspec.audit.difference import NOT_STATED, SAME_AXIS, Change, Difference
from actspec.diagnostics import Span, listed, many, one_line, shortened
from actspec.fields import FIELDS, Role
from actspec.report.terminal import json_number
from actspec.units import format_number

_SIGNED = ("gear", "torque_per_control", "command_gain")
"""Figures between a control and the joint, whose sign is a direction."""

_NO_RATIO = ("encoder_bias", "command_low", "command_high", "natural_frequency", "damping_ratio")
"""What is measured from a zero that means nothing, or is rough; so are poses."""

_OF_INDICES = re.compile(r"map|idx|ind(?:ex|ices)|ids|order", re.IGNORECASE)
"""Keys of lists whose numbers are places: twice a place is none."""
_MOST_TEXT = 200
"""Chosen: letters of a value that is a text; what actspec says of drawn ranges takes less."""


def report_lines(found: Sequence[Difference], old: str, new: str) -> Iterator[str]:
    """The differences of two files as text.

    Args:
        found: One a robot.
        old: What the old file is called.
        new: What the new file is called.
    """
    told = [item for item in found if not item.same or item.left]
    for item in told:
        yield f"{one_line(old)} -> {one_line(new)} ({shortened(item.new.name)})"
        yield from lines(item)
        yield from _left_lines(item, one_line(old), one_line(new))
    if not told:
        yield "no change in effective dynamics"


def _left_lines(found: Difference, old: str, new: str) -> Iterator[str]:
    """What was not compared; a line a figure, with how many joints have it."""
    if not found.left:
        return
    if not found.compared:
        yield "  nothing was compared: no figure is stated by both"
    elif found.same:
        count = many(found.compared, "figure")
        yield f"  no change in {count}" + (" that both state" if found.old.kind is not found.new.kind else "")
    patterns = found.old.patterns | found.new.patterns
    for name, side in ((old, "old"), (new, "new")):
        alone = [item for item in found.left if item.absent == NOT_STATED and getattr(item, side) is not None]
        if alone:
            which = "which is" if len(alone) == 1 else "which are"
            yield f"  only {name} states {many(len(alone), 'figure')}, {which} not compared:"
            yield from _by_field(alone, side, patterns)
    others: dict[str, list[Change]] = {}
    for item in found.left:
        if item.field == "unread":
            # Of a class itself it is what is not written there.
            part = "a part of " * (item.noun in (found.old.name, found.new.name))
            yield f"  not compared: {part}{one_line(item.noun)}, {_unread(item)}"
        elif item.field == "other":
            yield f"  not compared: {one_line(words(item))}"
        elif item.absent != NOT_STATED:
            others.setdefault(item.noun, []).append(item)
    for noun, items in others.items():
        unknown = any(item.old is None or item.new is None for item in items)
        why = "unknown" if unknown else "not comparable between two kinds of file"
        yield f"  not compared: {noun} at {counted([item.joint for item in items], patterns)}, {why}"


def _unread(item: Change) -> str:
    """Why something is not read: `not known without running it: X comes from Y`; of one file alone, of which."""
    if item.old == item.new:
        return str(item.new)
    return "; ".join(
        f"in the {side} file {value}" for side, value in (("old", item.old), ("new", item.new)) if value
    )


def counted(joints: Sequence[str], patterns: Collection[str]) -> str:
    """`12 joints`, `3 patterns of joints`: how many joints a pattern selects nobody knows without the robot."""
    several = sum(joint in patterns for joint in joints)
    parts = [many(len(joints) - several, "joint")] if several < len(joints) or not joints else []
    if several:
        parts.append(f"{several} {'pattern' if several == 1 else 'patterns'} of joints")
    return " and ".join(parts)


def _by_field(alone: Sequence[Change], side: str, patterns: Collection[str]) -> Iterator[str]:
    """`armature 0.1 kg*m^2 (19 joints)`, `stiffness kp 20 to 150 N*m/rad (12 joints)`."""
    fields: dict[str, list[Change]] = {}
    for change in alone:
        fields.setdefault(change.field, []).append(change)
    for changes in fields.values():
        values = [getattr(change, side) for change in changes]
        texts = dict.fromkeys(_shown(value, "") for value in values)
        if len(texts) > 1 and all(isinstance(value, float) for value in values):
            texts = dict.fromkeys([_shown(min(values), ""), _shown(max(values), "")])
        first = changes[0]
        unit = f" {first.unit}" if first.unit and any(map(_has_unit, values)) else ""
        where = f" ({counted([one.joint for one in changes], patterns)})" if first.joint else ""
        yield f"    {first.noun} {' to '.join(texts)}{unit}{where}"


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
        what = "joints added" if found.old.joints else "robot added, with joints"
        yield f"{indent}{what}: {listed(map(shortened, found.added))}"
    if found.removed:
        what = "joints removed" if found.new.joints else "robot removed, with joints"
        yield f"{indent}{what}: {listed(map(shortened, found.removed))}"
    for joints, texts in _by_joints(found):
        yield f"{indent}{listed(map(shortened, joints))}:"
        for line in (*texts, *_effects(found, joints)):
            yield f"{indent}  {line}"


def words(change: Change) -> str:
    """`total damping 4 -> 22 N*m*s/rad (x5.5)`."""
    absent = change.absent
    old, new = (_shown(value, absent) for value in (change.old, change.new))
    if old == new:
        old, new = (_shown(value, absent, 10) for value in (change.old, change.new))
    unit = f" {change.unit}" if change.unit else ""
    if _has_unit(change.new):
        new += unit
    elif _has_unit(change.old):
        old += unit
    return f"{change.noun} {old} -> {new}{_ratio(change)}{_reversal(change)}"


def _reversal(change: Change) -> str:
    """What a figure that has changed its sign does to the joint."""
    if change.field == "axis":
        ends = [
            [] if side is None else [float(part) for part in str(side).split()]
            for side in (change.old, change.new)
        ]
        opposite = math.dist(ends[0], [-part for part in ends[1]]) <= SAME_AXIS if all(ends) else False
        return ": its positive positions, speeds and torques are the other way" if opposite else ""
    if change.field in _SIGNED and change.ratio is not None and change.ratio < 0.0:
        return ": a positive control drives the joint the other way"
    return ""


def _has_unit(value: float | str | None) -> bool:
    return isinstance(value, float) and math.isfinite(value)


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
        "compared": found.compared,
        "not_compared": [_change(change) for change in found.left],
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
        return shortened(value[:12] if len(value) == 64 else value, _MOST_TEXT)
    if math.isinf(value):
        return "none"
    return format_number(value, digits)


def _ratio(change: Change) -> str:
    ratio = change.ratio
    field = FIELDS.get(change.field)
    if ratio is None or ratio < 0.0 or change.field in _NO_RATIO or (field and field.role is Role.POSE):
        return ""
    if change.field == "other" or (change.field == "entry" and _OF_INDICES.search(change.noun)):
        return ""
    if 0.5 <= ratio <= 2.0:
        percent = (ratio - 1.0) * 100.0
        return f" ({'+' * (percent > 0.0)}{format_number(percent, 3)} %)"
    return f" (x{format_number(ratio, 3)})"
