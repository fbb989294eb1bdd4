"""Which configurations of legged_gym are tasks that programs register, and whether a task takes its gains."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from actspec.readings.artifact import FileReading, Framework

_REGISTERED = re.compile(rb"\.register\((?:[^()]|\([^()]*\))*\)")
"""A task that legged_gym runs by its name. Source: legged_gym, task_registry.register(name, class, config, ...)."""

_CLASS = re.compile(rb"^[ \t]*class[ \t]+(\w+)[ \t]*\(([^()]*)\)", re.MULTILINE)
"""A class and its bases."""

_LAW = re.compile(
    rb"^([ \t]+)def[ \t]+_compute_torques\b[^\n]*\n((?:\1[ \t]+[^\n]*\n|[ \t]*\n)*)", re.MULTILINE
)
"""What a task of legged_gym makes of gains and actions, and how far it goes."""

_GAINS = (b"p_gains", b"d_gains")
"""What legged_gym's own law takes of the configuration."""


def tasks(
    members: Mapping[str, FileReading], programs: Mapping[str, bytes]
) -> tuple[dict[str, frozenset[bytes]], dict[str, frozenset[bytes]]]:
    """Of classes of legged_gym, by path: those that are no task, nor the base of one, where programs register others.

    And those of tasks alone whose torques are not made of a configuration's gains.
    """
    own = {
        path: {
            artifact.config.name.encode()
            for artifact in reading.artifacts
            if artifact.config is not None and artifact.config.framework is Framework.LEGGED_GYM
        }
        for path, reading in members.items()
    }
    registered = [
        re.findall(rb"\w+", call[0]) for text in programs.values() for call in _REGISTERED.finditer(text)
    ]
    if set().union(*registered).isdisjoint(set().union(*own.values())):
        return {}, {}
    bases: dict[bytes, list[bytes]] = {}
    laws: dict[bytes, bool] = {}
    for text in programs.values():
        classes = list(_CLASS.finditer(text))
        for found, following in zip(classes, [*classes[1:], None], strict=False):
            bases.setdefault(found[1], []).extend(re.findall(rb"\w+", found[2]))
            law = _LAW.search(text, found.end(), following.start() if following else len(text))
            if law and b"super()" not in law[2]:
                laws[found[1]] = laws.get(found[1], False) or any(name in law[2] for name in _GAINS)
    run: set[bytes] = set()
    by_gains: set[bytes] = set()
    for words in registered:
        names = [name for word in words for name in _lineage(word, bases)]
        run |= set(names)
        # The environment is the first that has a law, or inherits one.
        if next((laws[name] for name in names if name in laws), True):
            by_gains |= set(names)
    return (
        {path: frozenset(names - run) for path, names in own.items() if names - run},
        {path: others for path, names in own.items() if (others := frozenset(names & run - by_gains))},
    )


def _lineage(name: bytes, bases: Mapping[bytes, Sequence[bytes]]) -> list[bytes]:
    """A class and its bases, the closest first."""
    found = [name]
    for each in found:
        found += [base for base in bases.get(each, ()) if base not in found]
    return found
