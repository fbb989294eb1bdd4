"""A model's files as one text, with a table from its lines to those of the author's files.

MuJoCo's own in-memory includes are found by base name alone, so `a/leg.xml` and `b/leg.xml`
collide, and it reports every error in one as "line 0".
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

from actspec.diagnostics import Diagnostic, RobotError, Severity, Span
from actspec.robot.view import ModelFile

MOST_COPIES = 100_000
"""Chosen: nested `replicate` counts beyond this exhaust the memory before MuJoCo can refuse them."""

_MARKS = (b"<include", b"<replicate", b"<flexcomp", b"<model")
"""What makes more of a file than its text."""


@dataclass(frozen=True, slots=True)
class SplicedText:
    """One text with every include in its place.

    Attributes:
        data: The text, UTF-8, without a byte order mark.
        starts: First line of each piece in `data`, from 1, ascending.
        origins: File and its line that the piece begins with.
        opened: `file` of each element that MuJoCo opens while it parses, with its tag.
    """

    data: bytes
    starts: tuple[int, ...]
    origins: tuple[tuple[str, int], ...]
    opened: tuple[tuple[str, str], ...]

    def span(self, line: int) -> Span:
        """The author's line for a line of `data`; the main file for line 0."""
        index = bisect_right(self.starts, line) - 1
        path, first = self.origins[max(index, 0)]
        if line < 1:
            return Span(self.origins[0][0])
        return Span(path, first + line - self.starts[index])


def splice(files: Sequence[ModelFile], *, parsed: bool = False) -> SplicedText:
    """Put the text of every include in the place of its element.

    Args:
        files: The main file, then its includes in document order, as `read_model_files` gives them.
        parsed: `parse_document` has taken these very files, so that a plain one needs no second look.

    Raises: RobotError: a file is not UTF-8 or not well-formed, holds a DOCTYPE, has an include
        without its file, or replicates beyond `MOST_COPIES`.
    """
    if parsed and len(files) == 1 and not any(mark in files[0].data for mark in _MARKS):
        data = files[0].data.removeprefix(b"\xef\xbb\xbf") + b"\n"
        return SplicedText(data, (1,), ((files[0].path, 1),), ())
    pieces: list[bytes] = []
    starts: list[int] = []
    origins: list[tuple[str, int]] = []
    opened: list[tuple[str, str]] = []
    rest = iter(files[1:])
    line = 1

    def put(piece: bytes, path: str, first: int) -> None:
        nonlocal line
        starts.append(line)
        origins.append((path, first))
        pieces.append(piece)
        line += piece.count(b"\n")

    def put_file(file: ModelFile, whole: bool, depth: int) -> None:
        if depth > 64:
            raise _error(file.path, 0, "includes are nested more than 64 deep")
        data = file.data.removeprefix(b"\xef\xbb\xbf")
        marks = _marks(file.path, data)
        opened.extend(marks.opened)
        begin, end = (0, len(data)) if whole else marks.inner
        for at, to in marks.includes:
            put(data[begin:at] + b"\n", file.path, 1 + data.count(b"\n", 0, begin))
            included = next(rest, None)
            if included is None:
                raise _error(file.path, 1 + data.count(b"\n", 0, at), "an include has no file")
            put_file(included, False, depth + 1)
            begin = to
        put(data[begin:end] + b"\n", file.path, 1 + data.count(b"\n", 0, begin))

    put_file(files[0], True, 0)
    return SplicedText(b"".join(pieces), tuple(starts), tuple(origins), tuple(opened))


@dataclass(slots=True)
class _Marks:
    inner: tuple[int, int]
    includes: list[tuple[int, int]]
    opened: list[tuple[str, str]]


def _marks(path: str, data: bytes) -> _Marks:
    """Byte offsets of a file's root content and of its include elements."""
    from xml.parsers import expat

    parser = expat.ParserCreate("utf-8")
    marks = _Marks((0, 0), [], [])
    depth = 0
    copies = [1]
    include_at = 0
    includes = True

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth, include_at, includes
        at = parser.CurrentByteIndex
        if depth == 0:
            marks.inner = (_tag_end(data, at), 0)
            # A URDF has no includes, whatever its tags are called.
            includes = tag != "robot"
        elif tag == "include" and includes:
            include_at = at
        elif tag == "replicate":
            copies.append(copies[-1] * _count(attributes.get("count", "")))
            if copies[-1] > MOST_COPIES:
                raise _error(path, parser.CurrentLineNumber, f"more than {MOST_COPIES} copies by replicate")
        elif attributes.get("file") and tag in ("flexcomp", "model"):
            marks.opened.append((tag, attributes["file"]))
        depth += 1

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        at = parser.CurrentByteIndex
        if depth == 0:
            # A root `<mujoco/>` ends where it starts: there is nothing inside.
            marks.inner = (marks.inner[0], max(marks.inner[0], at))
        elif tag == "include" and includes:
            # At the end of `<include/>` expat stands behind it already; at that of `</include>` before it.
            closing = data.startswith(b"</include", at)
            marks.includes.append((include_at, _tag_end(data, at) if closing else at))
        elif tag == "replicate":
            copies.pop()

    def doctype(*_: object) -> None:
        raise _error(path, parser.CurrentLineNumber, "a DOCTYPE is refused")

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.StartDoctypeDeclHandler = doctype
    try:
        data.decode("utf-8")
        parser.Parse(data, True)
    except UnicodeDecodeError as err:
        place = data.count(b"\n", 0, err.start) + 1
        raise _error(path, place, "the file is not UTF-8, which is all that MuJoCo reads") from err
    except expat.ExpatError as err:
        raise _error(path, err.lineno, f"not well-formed XML: {err}") from err
    return marks


def _tag_end(data: bytes, at: int) -> int:
    """Offset after the tag that starts at `at`; a quoted `>` does not end it."""
    found = re.compile(rb"""<(?:[^<>"']|"[^"]*"|'[^']*')*>""").match(data, at)
    return found.end() if found else at


def _count(text: str) -> int:
    try:
        return max(int(text), 1)
    except ValueError:
        return 1


def _error(path: str, line: int, message: str, help: str | None = None) -> RobotError:
    return RobotError([Diagnostic("ROBOT110", Severity.ERROR, message, "", Span(path, line), help)])
