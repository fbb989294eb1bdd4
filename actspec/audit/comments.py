"""Comments of XML, YAML and Python files, and the lines that each one speaks about.

A comment speaks about the line that it ends a statement or an element on; one that stands alone speaks
about the next line of text (YAML, Python) or the next element's start tag (XML).
"""

from __future__ import annotations

import contextlib
import io
import re
import tokenize
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any
from xml.parsers import expat

from actspec.robot.xml_tree import may_define

_XML_START = re.compile(rb"(?:\xef\xbb\xbf)?\s*<[!?A-Za-z_]")


@dataclass(frozen=True, slots=True)
class Comment:
    """One comment.

    Attributes:
        line: Line that it begins on, from 1.
        column: Column that it begins at, from 1.
        text: Without its marks.
        first: First line that it speaks about; 0: it speaks about none.
        last: Last such line.
    """

    line: int
    column: int
    text: str
    first: int = 0
    last: int = 0


def comments(path: str, data: bytes) -> tuple[Comment, ...]:
    """Comments of a file, in order; those after an error of its syntax are not seen.

    Args:
        path: Its name, which tells Python from YAML.
        data: Its bytes.
    """
    if _XML_START.match(data):
        return _in_xml(data)
    text = data.decode("utf-8-sig", "replace")
    return tuple(_in_python(text) if path.endswith(".py") else _in_yaml(text))


class _Stop(Exception):
    """A DOCTYPE that could define entities: nothing of it is read."""


def _in_xml(data: bytes) -> tuple[Comment, ...]:
    parser = expat.ParserCreate("utf-8")
    found: list[Comment] = []
    waiting: list[int] = []
    tag = (0, 0)  # lines of the start tag that was last

    def start(name: str, attributes: Any) -> None:
        nonlocal tag
        at, line = parser.CurrentByteIndex, parser.CurrentLineNumber
        tag = (line, line + data.count(b"\n", at, _tag_end(data, at)))
        for index in waiting:
            found[index] = replace(found[index], first=tag[0], last=tag[1])
        waiting.clear()

    def end(name: str) -> None:
        # What stands alone before an end tag speaks about nothing.
        waiting.clear()

    def comment(text: str) -> None:
        line, column = parser.CurrentLineNumber, parser.CurrentColumnNumber + 1
        at = parser.CurrentByteIndex
        before = data[data.rfind(b"\n", 0, at) + 1 : at]
        alone = not re.sub(rb"<!--.*?-->", b"", before).strip()
        if alone:
            waiting.append(len(found))
            found.append(Comment(line, column, text))
        elif tag[1] == line:
            found.append(Comment(line, column, text, *tag))
        else:
            found.append(Comment(line, column, text, line, line))

    def doctype(_: str, *more: Any) -> None:
        if may_define(*more):
            raise _Stop

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CommentHandler = comment
    parser.StartDoctypeDeclHandler = doctype
    with contextlib.suppress(expat.ExpatError, _Stop):
        parser.Parse(data, True)
    return tuple(found)


def _tag_end(data: bytes, at: int) -> int:
    """End of the start tag that begins at a byte; `>` may stand in quotes."""
    found = re.compile(rb"""<(?:[^"'>]|"[^"]*"|'[^']*')*""").match(data, at)
    return found.end() if found else at


def _in_python(text: str) -> Iterator[Comment]:
    quiet = (tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER)
    waiting: list[Comment] = []
    try:
        for token in tokenize.generate_tokens(io.StringIO(text).readline):
            row, column = token.start
            if token.type == tokenize.COMMENT:
                comment = Comment(row, column + 1, token.string[1:])
                if token.line[:column].strip():
                    yield replace(comment, first=row, last=row)
                else:
                    waiting.append(comment)
            elif token.type not in quiet:
                yield from (replace(comment, first=row, last=row) for comment in waiting)
                waiting.clear()
    except (tokenize.TokenError, SyntaxError, ValueError):
        pass
    yield from waiting


def _in_yaml(text: str) -> Iterator[Comment]:
    inside = _scalars(text)
    waiting: list[Comment] = []
    for row, line in enumerate(re.split("\r\n|\r|\n", text), 1):
        start = _comment_start(line, inside.get(row, []))
        if line[:start].strip():
            yield from (replace(comment, first=row, last=row) for comment in waiting)
            waiting.clear()
        if start < len(line):
            comment = Comment(row, start + 1, line[start + 1 :])
            if line[:start].strip():
                yield replace(comment, first=row, last=row)
            else:
                waiting.append(comment)
    yield from waiting


def _comment_start(line: str, scalars: list[tuple[int, int]]) -> int:
    """Column from 0 of the `#` that begins a comment; the line's length without one."""
    for found in re.finditer(r"(?:^|(?<=[ \t]))#", line):
        if not any(first <= found.start() < last for first, last in scalars):
            return found.start()
    return len(line)


def _scalars(text: str) -> dict[int, list[tuple[int, int]]]:
    """Row to the columns from 0 that belong to scalars."""
    import yaml

    loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    found: dict[int, list[tuple[int, int]]] = {}
    try:
        for token in yaml.scan(text, Loader=loader):
            if not isinstance(token, yaml.ScalarToken):
                continue
            first, last = token.start_mark, token.end_mark
            for row in range(first.line, last.line + 1):
                left = first.column if row == first.line else 0
                right = last.column if row == last.line else 1 << 30
                found.setdefault(row + 1, []).append((left, right))
    except (yaml.YAMLError, RecursionError):
        pass
    return found
