"""What the programs of a folder name of its models and configurations: what they do not, beside others, nobody runs."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from actspec.files import NotRegular, TooLarge, read_regular
from actspec.readings.artifact import FileKind, FileReading

_MODEL_ENDING = re.compile(rb"\.(?:urdf|xml|mjcf)\b")
_MODEL_NAME = re.compile(rb"[\w.+-]+\.(?:urdf|xml|mjcf)")
_MADE = rb"\{[^{}\n]*\}|%[sd]|\*"
_BEFORE_ENDING = re.compile(rb"""(\+\s*f?["'])?((?:[\w.+-]|""" + _MADE + rb")*)$")
"""What a name begins with, and whether something is put before that when the program runs: robot + "_v2"."""

_MOST_NAME = 200
"""Chosen: bytes before the ending of a name that are looked at."""

_MOST_PROGRAM = 1024 * 1024
"""Chosen: bytes of a program that are looked through."""

_COMMENT = re.compile(rb"^[ \t]*#[^\n]*", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Idle:
    """What nobody runs.

    Attributes:
        models: Paths of models that no program names, nor a model that one names, where programs name others.
        configs: Path to the configurations that stand there alone, where a program imports another one of the file.
    """

    models: frozenset[str] = frozenset()
    configs: Mapping[str, frozenset[str]] = field(default_factory=dict)


def idle(members: Mapping[str, FileReading], programs: tuple[str, ...]) -> Idle:
    """What nothing in a folder names.

    Args:
        members: Path to what was read, for all files of the folder that may have to do with a robot.
        programs: Endings of files that run or set up something.
    """
    if any(reading.kind is FileKind.SPEC for reading in members.values()):
        # A spec is there for every file of its robot.
        return Idle()
    models = {
        path: name
        for path, reading in members.items()
        # A name with a space or beyond ASCII is not found again in a program. What cannot be read has no kind.
        if (reading.kind in (FileKind.MJCF, FileKind.URDF) or (reading.kind is None and not reading.readable))
        and _MODEL_NAME.fullmatch(name := os.fsencode(os.path.basename(path)))
    }
    configs = {path: names for path, reading in members.items() if (names := _configs(reading))}
    if not models and not configs:
        return Idle()
    texts: dict[str, bytes] = {}
    for path in members:
        if path.lower().endswith(programs):
            texts[path] = _COMMENT.sub(b"", _read(path))
    return Idle(_idle_models(models, texts.values()), _idle_configs(configs, texts))


def _idle_models(models: Mapping[str, bytes], programs: Iterable[bytes]) -> frozenset[str]:
    known = set(models.values())
    named: set[bytes] = set()
    for text in programs:
        for name in _names(text):
            if name.fullmatch(b""):
                # It may be any of them.
                return frozenset()
            named |= {model for model in known if name.fullmatch(model)}
    if not named:
        return frozenset()
    paths: dict[bytes, list[str]] = {}
    for path, model in models.items():
        paths.setdefault(model, []).append(path)
    # What a named scene includes is run.
    left = list(named)
    while left:
        for path in paths[left.pop()]:
            found = {name + ending for _, name, ending in _written(_read(path))} & known
            left += found - named
            named |= found
    return frozenset(path for path, name in models.items() if name not in named)


def _names(text: bytes) -> Iterator[re.Pattern[bytes]]:
    """Names of models in a program, one that is put together when it runs as a pattern; `.*` may be any."""
    for added, name, ending in _written(text):
        parts = re.split(_MADE, name)
        made = (b".*" if added else b"") + b".*".join(map(re.escape, parts))
        yield re.compile(b".*" if not any(parts) and made else made + re.escape(ending))


def _written(text: bytes) -> Iterator[tuple[bool, bytes, bytes]]:
    """Names of models as they are written, up to the ending, and whether something is put before them."""
    for ending in _MODEL_ENDING.finditer(text):
        at = ending.start()
        found = _BEFORE_ENDING.search(text[max(at - _MOST_NAME, 0) : at])
        # It matches the empty text too.
        assert found is not None
        yield found[1] is not None, found[2], ending[0]


def _configs(reading: FileReading) -> frozenset[bytes]:
    """Constants and classes of a Python file that set up a robot."""
    if reading.kind is not FileKind.CFG:
        return frozenset()
    names = (artifact.config.name for artifact in reading.artifacts if artifact.config is not None)
    return frozenset(name.encode() for name in names if name.isidentifier())


def _idle_configs(
    configs: Mapping[str, frozenset[bytes]], programs: Mapping[str, bytes]
) -> dict[str, frozenset[str]]:
    every = frozenset().union(*configs.values()) if configs else frozenset()
    if not every:
        return {}
    # Whole words, each name that is not part of a longer one.
    pattern = re.compile(rb"(?<![\w])(?:" + b"|".join(map(re.escape, sorted(every))) + rb")(?![\w])")
    counts = {path: Counter(pattern.findall(text)) for path, text in programs.items()}
    result = {}
    for path, names in configs.items():
        elsewhere = {name for other, count in counts.items() if other != path for name in count}
        alone = {name for name in names - elsewhere if counts.get(path, Counter())[name] == 1}
        if names & elsewhere and alone:
            result[path] = frozenset(name.decode() for name in alone)
    return result


def _read(path: str) -> bytes:
    try:
        return read_regular(path, _MOST_PROGRAM)
    except (OSError, ValueError, NotRegular, TooLarge):
        return b""
