"""Which model a part belongs to: what includes or attaches it, beside it, in two folders above and in its project."""

from __future__ import annotations

import itertools
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

from actspec.diagnostics import Diagnostic, Severity, Span, listed, one_line
from actspec.files import FAULTS, read_regular
from actspec.readings.artifact import FileReading, without_comments

_PART_ROOT = b"<mujocoinclude"

_INCLUDED, _ATTACHED = (
    re.compile(rb"""<%s\s[^<>]*?\bfile\s*=\s*["']([^"'<>]*)["']""" % tag) for tag in (b"include", b"model")
)
_MOST_FILES = 200
"""Files of a folder that are looked at. Chosen: a folder of MuJoCo's menagerie has ten."""
_MOST_BYTES = 4 * 1024 * 1024
"""Chosen: larger than any MJCF that includes."""
_MOST_TOGETHER = 32 * 1024 * 1024
"""Chosen: bytes of all files that are looked at, read in a tenth of a second."""
_FOLDERS_ABOVE = 2
"""Chosen: `robot.xml` beside `parts/legs/left.xml`."""
_ROOTS = (".git", "package.xml", "pyproject.toml", "setup.py")
"""What a project's folder has, a repository before a package in it: without one nobody says how far `../../shared` is
from its robots."""
_MOST_ABOVE = 8
"""Folders above a part that may be its project's. Chosen: twice those of MuJoCo's menagerie or of a ROS package."""
_MOST_FOLDERS = 500
"""Chosen: folders of a project that are looked at; listed in some 0.1 s."""


def including(path: str) -> str | None:
    """What to import in place of a part of a model: the files that include or attach it; None: there is none."""
    return _wholes(path, _Around(path), (_INCLUDED, _ATTACHED))


def as_part(path: str) -> Diagnostic | None:
    """What an MJCF without <compiler> that is read alone has otherwise in the models that it is a part of.

    An include takes angles, classes and limits from around it. What is attached keeps those of its own file: measured
    with MuJoCo 3.2.7 and 4.0.0, radians, `autolimits="false"` and damping 1 of the model that attaches leave degrees,
    a limit and damping 7 of the attached one as they are, and the time step is the former's.

    Args:
        path: An MJCF.
    """
    around = _Around(path)
    if whole := _wholes(path, around, (_INCLUDED,)):
        stated = "angles, classes and limits that are stated there are not read"
        message = f"has no <compiler>, and is a part of {whole}: {stated}"
        help = "import the whole model instead"
        return Diagnostic("DRF013", Severity.WARNING, message, "", Span(path), help)
    if whole := _wholes(path, around, (_ATTACHED,)):
        message = (
            f"{whole} attaches it: angles, classes and limits are those of this file there too, the names of its "
            f"joints may get a prefix, and the time step is that of {whole}"
        )
        return Diagnostic("DRF013", Severity.INFO, message, "", Span(path))
    return None


class _Around:
    """The MJCF files around a part, by path, without comments: read once, and those of its project where asked for."""

    def __init__(self, path: str) -> None:
        self._above = _above(path)

    @cached_property
    def near(self) -> Mapping[str, bytes]:
        return dict(_texts(self._above[: _FOLDERS_ABOVE + 1]))

    @cached_property
    def in_project(self) -> Mapping[str, bytes]:
        return dict(_texts([*self._above[: _FOLDERS_ABOVE + 1], *_project(self._above)]))


def _wholes(path: str, around: _Around, ways: Sequence[re.Pattern[bytes]]) -> str | None:
    """The files that name a part in one of some ways.

    Of files that are parts themselves, the models that these belong to. Links are passed over: they lead elsewhere.

    Args:
        path: An MJCF.
        around: It.
        ways: What finds the names of files in a text.
    """
    return listed(_found(path, ways, around.near) or _found(path, ways, around.in_project)) or None


def _found(path: str, ways: Sequence[re.Pattern[bytes]], texts: Mapping[str, bytes]) -> list[str]:
    """As `_wholes`, among some files."""
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
                found[one_line(one)] = None
    return sorted(found)


def whole_of(reading: FileReading) -> str | None:
    """What to import in place of a part of a model that is no model alone; None for what may be no part."""
    whole = including(reading.path)
    if whole is not None:
        return f"it is a part of {whole}: import the whole model"
    if any(_PART_ROOT in without_comments(file.data) for file in reading.files[:1]):
        return "it is a part of a model: import the file that includes it"
    return None


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


def _above(path: str) -> list[str]:
    """The folder of a file and those above it."""
    folder = os.path.dirname(path)
    return [os.path.normpath(os.path.join(folder, *[os.pardir] * steps)) for steps in range(_MOST_ABOVE + 1)]


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
