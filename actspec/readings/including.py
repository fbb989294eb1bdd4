"""Which model a part belongs to: what includes or attaches it, beside it, below it, above it and in its project; and
what of an audit is a part that is judged in its includer."""

from __future__ import annotations

import itertools
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

from actspec.diagnostics import Span
from actspec.files import FAULTS, above, folders_in, place_of, read_regular
from actspec.readings.artifact import FileReading, without_comments

INCLUDED, ATTACHED = (
    re.compile(rb"""<%s\s[^<>]*?\bfile\s*=\s*["']([^"'<>]*)["']""" % tag) for tag in (b"include", b"model")
)
MOST_WHOLES = 4
"""Chosen: of the models that include a part, those that are tried whether they compile; a robot has a few scenes."""
_MOST_FILES = 200
"""Files of a folder that are looked at. Chosen: a folder of MuJoCo's menagerie has ten."""
_MOST_BYTES = 4 * 1024 * 1024
"""Chosen: larger than any MJCF that includes."""
_MOST_TOGETHER = 32 * 1024 * 1024
"""Chosen: bytes of all files that are looked at, read in a tenth of a second."""
_FOLDERS_ABOVE = 2
"""Chosen: `robot.xml` beside `parts/legs/left.xml`."""
_FOLDERS_BELOW = 2
"""Chosen: `scenes/flat/scene.xml` beside `robot.xml`, or beside the folder that has it."""
_ROOTS = (".git", "package.xml", "pyproject.toml", "setup.py")
"""What a project's folder has, a repository before a package in it: without one nobody says how far `../../shared` is
from its robots."""
_MOST_FOLDERS = 500
"""Chosen: folders of a project, or beside a part, that are looked at; listed in some 0.1 s."""


class Around:
    """The MJCF files around a part, by path, without comments: read once, and the further ones where asked for."""

    def __init__(self, path: str) -> None:
        """Of a part, an MJCF."""
        self._path = path
        self._above = above(path)

    def wholes(self, *ways: re.Pattern[bytes]) -> list[str]:
        """The files that name the part, as a user would name them, sorted; none where none is found.

        Of files that are parts themselves, the models that these belong to. Links are passed over: they lead elsewhere.

        Args:
            ways: `INCLUDED`, `ATTACHED` or both.
        """
        return (
            _found(self._path, ways, self._near)
            or _found(self._path, ways, self._round)
            or _found(self._path, ways, self._in_project)
        )

    @cached_property
    def _near(self) -> Mapping[str, bytes]:
        return dict(_texts(self._nearest))

    @cached_property
    def _round(self) -> Mapping[str, bytes]:
        return dict(_texts([*self._nearest, *itertools.islice(_beside(self._above), _MOST_FOLDERS)]))

    @cached_property
    def _in_project(self) -> Mapping[str, bytes]:
        return dict(_texts([*self._nearest, *_project(self._above)]))

    @property
    def _nearest(self) -> Sequence[str]:
        return self._above[: _FOLDERS_ABOVE + 1]


def _found(path: str, ways: Sequence[re.Pattern[bytes]], texts: Mapping[str, bytes]) -> list[str]:
    """As `wholes`, among some files."""
    named = {one: frozenset(_named(one, text, ways)) for one, text in texts.items()}
    found: dict[str, None] = {}
    pending, seen = [os.path.abspath(path)], set()
    while pending:
        part = pending.pop()
        seen.add(part)
        for one in texts:
            if part not in named[one] or os.path.abspath(one) in seen:
                continue
            wholes = [other for other in texts if os.path.abspath(one) in named[other] and other != one]
            if wholes and b"<compiler" not in texts[one]:
                pending.append(os.path.abspath(one))
            else:
                found[one] = None
    return sorted(found)


def _texts(folders: Sequence[str]) -> Iterator[tuple[str, bytes]]:
    """Path, as a user would name it, and text without comments of the MJCF files that may include a part."""
    left, seen = _MOST_TOGETHER, set()
    for folder in folders:
        where = os.path.abspath(folder)
        if where in seen:
            continue
        seen.add(where)
        try:
            names = sorted(name for name in os.listdir(where) if name.lower().endswith((".xml", ".mjcf")))
        except (OSError, ValueError):
            continue
        for name in names[:_MOST_FILES]:
            one = os.path.normpath(os.path.join(folder, name))
            try:
                data = b"" if os.path.islink(one) else read_regular(one, min(_MOST_BYTES, left))
            except FAULTS:
                continue
            left -= len(data)
            if b"<mujoco" in data:
                yield one, without_comments(data)


def _beside(above: Sequence[str]) -> Iterator[str]:
    """Folders below that of a part, then those beside it and below them."""
    for top in above[:2]:
        if os.path.dirname(os.path.abspath(top)) == os.path.abspath(top):
            # What is beside a folder of the whole machine belongs to nobody's model.
            return
        level = [top]
        for _ in range(_FOLDERS_BELOW):
            level = [inner for one in level[:_MOST_FOLDERS] for inner in folders_in(one)]
            yield from level


def _project(above: Sequence[str]) -> Iterator[str]:
    """All folders of a project, where one of some folders is its own; nothing where none is."""
    roots = (one for mark in _ROOTS for one in above if os.path.lexists(os.path.join(one, mark)))
    for where, inner, _ in itertools.islice(os.walk(next(roots, os.devnull)), _MOST_FOLDERS):
        inner[:] = sorted(name for name in inner if not name.startswith("."))
        yield where


def _named(path: str, text: bytes, ways: Sequence[re.Pattern[bytes]]) -> Iterator[str]:
    """Files that an MJCF names as its parts; each is looked up in the folder of the model."""
    folder = os.path.dirname(os.path.abspath(path))
    for name in (name for way in ways for name in way.findall(text)):
        yield os.path.normpath(os.path.join(folder, os.fsdecode(name)))


def place_of_include(whole: FileReading, part: str) -> Span:
    """Where a model includes a part; the model as a whole where a part of it does."""
    for file in whole.files[:1]:
        for found in INCLUDED.finditer(file.data):
            if os.path.normpath(os.path.join(os.path.dirname(file.path), os.fsdecode(found[1]))) == part:
                return Span(file.path, *place_of(file.data, found.start()))
    return Span(whole.path)


def without_fragments(readings: Sequence[FileReading]) -> tuple[FileReading, ...]:
    """The readings without parts that another one includes: they are judged there.

    A part is an MJCF that MuJoCo refuses alone, or that has no `<compiler>`: angles, classes and limits may then be its
    includer's. Any other that MuJoCo takes alone stays, whoever includes it: it is a model. What MuJoCo refuses alone
    is also left to an includer that cannot be read, of which that is said. What cannot be read alone is left to one
    that reads it: what a part includes lies where its includer looks.

    Args:
        readings: All of one audit.
    """
    included: dict[str, bool] = {}
    for reading in readings:
        for part in reading.files:
            if part.include:
                path = os.path.realpath(part.path)
                included[path] = included.get(path, False) or bool(reading.artifacts)
        if not reading.artifacts:
            for path in _named_by_includes(reading):
                included.setdefault(os.path.realpath(path), False)
    if not included:
        return tuple(readings)
    return tuple(
        replace(reading, included=True) if os.path.realpath(reading.path) in included else reading
        for reading in readings
        if not _is_judged_elsewhere(reading, included)
    )


def _named_by_includes(reading: FileReading) -> Iterator[str]:
    """Files that an MJCF which could not be put together includes, from its text."""
    for file in reading.files[:1]:
        if b"<mujoco" in file.data:
            for name in INCLUDED.findall(without_comments(file.data)):
                yield os.path.join(os.path.dirname(reading.path), os.fsdecode(name))


def _is_judged_elsewhere(reading: FileReading, included: Mapping[str, bool]) -> bool:
    """Whether a file is a part of others, by the included files' paths to whether one of them could be read."""
    read_there = included.get(os.path.realpath(reading.path))
    if read_there is None or not reading.artifacts:
        return bool(read_there)
    # MuJoCo takes nothing of it, or another file has its compiler.
    return all(one.text_only is not None or (read_there and one.may_be_part) for one in reading.artifacts)
