"""Globs over paths, in time that no glob can blow up."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence


def matches(glob: str, path: str) -> bool:
    """Whether a path (with `/`) fits a glob; a glob without `/` is held against the last part alone.

    `*` and `?` stand for anything but `/`, `**` for anything.
    """
    if "/" not in glob:
        path = path.rpartition("/")[2]
    # All places of the glob at once, character by character: a regular expression of many stars takes forever.
    found = re.findall(r"\*\*/|\*\*|.", glob, re.DOTALL)
    parts = [part for one in found for part in (("", one) if one == "**/" else (one,))]
    places = _with_skips({0}, parts)
    for char in path:
        places = _with_skips(
            {after for place in places if place < len(parts) for after in _after(place, parts[place], char)},
            parts,
        )
    return len(parts) in places


def _with_skips(places: set[int], parts: Sequence[str]) -> set[int]:
    """Places in a glob, and those that are reached from them without a character."""
    found: set[int] = set()
    waiting = list(places)
    while waiting:
        place = waiting.pop()
        if place in found:
            continue
        found.add(place)
        if place == len(parts):
            continue
        if parts[place] == "":  # before `**/`: folders, or none
            waiting += [place + 1, place + 2]
        elif parts[place] in ("*", "**"):
            waiting.append(place + 1)
    return found


def _after(place: int, part: str, char: str) -> Iterator[int]:
    """Places in a glob after a character."""
    if part == "**/":
        yield place
        if char == "/":
            yield place + 1
    elif part in ("*", "**"):
        if char != "/" or part == "**":
            yield place
    elif part == char or (part == "?" and char != "/"):
        yield place + 1
