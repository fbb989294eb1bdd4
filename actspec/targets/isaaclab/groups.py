"""From drives to the groups of a cfg: which joints share one, what it is called, scalar or dict."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from actspec.targets.isaaclab.context import Field
from actspec.targets.isaaclab.drive import Drive
from actspec.targets.python_text import grouped, joint_patterns


@dataclass(frozen=True, slots=True)
class Entry:
    """One key of a dict: a pattern, its number and what stands behind it."""

    key: str
    value: float
    note: str


@dataclass(frozen=True, slots=True)
class Keyword:
    """One keyword of a cfg, a scalar or a dict over all of the group's joints.

    Attributes:
        name: Keyword.
        value: The scalar; of no meaning where there are entries.
        entries: The dict; empty for a scalar.
        note: What stands behind the keyword; empty where the entries have notes of their own.
        file: The value is a file beside the module.
    """

    name: str
    value: float | str | list[int] | None
    entries: tuple[Entry, ...]
    note: str
    file: bool


@dataclass(frozen=True, slots=True)
class Group:
    """One group of joints.

    Attributes:
        name: Its key.
        cls: Name of the class without `Cfg`.
        patterns: Expressions that match its joints, each once.
        keywords: The rest of the cfg.
        remarks: Comments.
        drives: Its joints.
    """

    name: str
    cls: str
    patterns: tuple[str, ...]
    keywords: tuple[Keyword, ...]
    remarks: tuple[str, ...]
    drives: tuple[Drive, ...]


def groups_of(drives: Sequence[Drive], names: Sequence[str]) -> tuple[Group, ...]:
    """Split the spec's groups where a cfg takes one value, and merge the rest.

    Args:
        drives: One a joint, in the robot's order.
        names: All of the robot's joints.
    """
    found: list[Group] = []
    taken: set[str] = set()
    for spec_group, members in grouped(drives, lambda drive: drive.actuator.group):
        parts = [part for _, part in grouped(members, _shared)]
        for label, part in zip(_labels(spec_group, parts), parts, strict=True):
            name, number = label, 2
            while name in taken:
                name, number = f"{label}_{number}", number + 1
            taken.add(name)
            found.append(_group(name, part, names))
    return tuple(found)


def _shared(drive: Drive) -> tuple[object, ...]:
    """What all joints of a group must have in common; `None` fits in no dict."""
    fields = tuple((f.name, repr(f.value) if f.scalar or f.value is None else "") for f in drive.fields)
    return (drive.cls, fields)


def _labels(name: str, parts: Sequence[Sequence[Drive]]) -> list[str]:
    """Names of a split group's parts: with the words that all of a part's joints have and no other's."""
    if len(parts) == 1:
        return [name]
    words = [[_words(drive.actuator.joint) for drive in part] for part in parts]
    labels = []
    for index, mine in enumerate(words):
        others = [
            word for other, part in enumerate(words) if other != index for joint in part for word in joint
        ]
        common = [word for word in mine[0] if all(word in joint for joint in mine) and word not in others]
        labels.append("_".join([name, *common]))
    return labels


def _words(joint: str) -> list[str]:
    return [word for word in re.split(r"[^A-Za-z0-9]+", joint) if word]


def _group(name: str, drives: Sequence[Drive], names: Sequence[str]) -> Group:
    keywords = []
    for index, first in enumerate(drives[0].fields):
        members = [(drive, drive.fields[index]) for drive in drives]
        keywords.append(_keyword(first, members, names))
    remarks = tuple(dict.fromkeys(remark for drive in drives for remark in drive.remarks))
    patterns = joint_patterns([drive.actuator for drive in drives], names)
    return Group(name, drives[0].cls, patterns, tuple(keywords), remarks, tuple(drives))


def _keyword(first: Field, members: list[tuple[Drive, Field]], names: Sequence[str]) -> Keyword:
    notes = list(dict.fromkeys(field.note for _, field in members))
    note = notes[0] if len(notes) == 1 else ""
    if all(field.value == first.value for _, field in members):
        return Keyword(first.name, first.value, (), note or "; ".join(filter(None, notes)), first.file)
    entries = []
    for (value, own), part in grouped(members, lambda member: (member[1].value, member[1].note)):
        assert isinstance(value, int | float)
        for pattern in joint_patterns([drive.actuator for drive, _ in part], names):
            entries.append(Entry(pattern, value, "" if note else own))
    return Keyword(first.name, None, tuple(entries), note, first.file)
