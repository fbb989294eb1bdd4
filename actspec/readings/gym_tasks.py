"""Which configurations of legged_gym are tasks that programs register."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from actspec.readings.artifact import FileReading, Framework

_REGISTERED = re.compile(rb"\.register\((?:[^()]|\([^()]*\))*\)")
"""A task that legged_gym runs by its name. Source: legged_gym, task_registry.register(name, class, config, ...)."""

_CLASS = re.compile(rb"^[ \t]*class[ \t]+(\w+)[ \t]*\(([^()]*)\)", re.MULTILINE)
"""A class and its bases."""


def no_tasks(
    members: Mapping[str, FileReading], programs: Mapping[str, bytes]
) -> dict[str, frozenset[bytes]]:
    """Classes of legged_gym, by path, that are no task, nor the base of one, where programs register others."""
    own = {
        path: {
            artifact.config.name.encode()
            for artifact in reading.artifacts
            if artifact.config is not None and artifact.config.framework is Framework.LEGGED_GYM
        }
        for path, reading in members.items()
    }
    registered = {
        name
        for text in programs.values()
        for call in _REGISTERED.finditer(text)
        for name in re.findall(rb"\w+", call[0])
    }
    if registered.isdisjoint(set().union(*own.values())):
        return {}
    bases: dict[bytes, list[bytes]] = {}
    for text in programs.values():
        for found in _CLASS.finditer(text):
            bases.setdefault(found[1], []).extend(re.findall(rb"\w+", found[2]))
    run = _lineage(registered, bases)
    return {path: frozenset(names - run) for path, names in own.items() if names - run}


def _lineage(names: Iterable[bytes], bases: Mapping[bytes, Sequence[bytes]]) -> frozenset[bytes]:
    """Classes with all their bases."""
    found = list(names)
    known = set(found)
    for each in found:
        added = [base for base in bases.get(each, ()) if base not in known]
        found += added
        known.update(added)
    return frozenset(known)
