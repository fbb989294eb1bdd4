"""The elements of one XML file with their byte offsets.

expat says whether it is XML, and one pattern then finds the tags: expat's calls to Python for each of them
take twice as long. What expat refuses is refused, with the place and a way out, even where MuJoCo reads
it: MuJoCo's parser takes a bare `&`, `<` in a value and `--` in a comment.
"""

from __future__ import annotations

import re
from contextlib import suppress
from xml.parsers import expat

from actspec.diagnostics import Diagnostic, Severity, Span
from actspec.robot.view import ModelFile
from actspec.robot.xml_errors import Malformed, check_encoding, explain, place_of
from actspec.robot.xml_tree import Element, as_unicode

MOST_DEPTH = 200
"""Chosen: elements inside one another, through includes; MuJoCo's parser stops at 500 in one file."""

_MARKUP = re.compile(
    r"""<(?:([^\s/>!?][^\s/>]*)[^"'>]*(?:"[^"]*"[^"'>]*|'[^']*'[^"'>]*)*>|(/)[^>]*>"""
    r"""|!--.*?-->|!\[CDATA\[.*?\]\]>|\?.*?\?>)""",
    re.ASCII | re.DOTALL,
)
"""A start tag (group 1: its name), an end tag (group 2), or what has no element in it; in a well-formed text."""


_TAG_OR_TEXT = re.compile(rb"<(?:!--.*?-->|!\[CDATA\[.*?\]\]>|\?.*?\?>|([^!?/]))", re.DOTALL)
"""What has no element in it, or the beginning of a start tag (group 1)."""


def scan(file: ModelFile, index: int, depth: int, before: int, most: int) -> list[Element]:
    """Elements of one file in document order, the root first.

    Args:
        file: To be scanned.
        index: Its place among the model's files.
        depth: Elements that the root is inside of.
        before: Elements of the files before it.
        most: Elements that the model may have.

    Raises: Malformed: it is no XML that is read here.
    """
    data = file.data
    check_encoding(file.path, data)
    # Counted before anything is made of them: two million take seconds. A file has no more tags than bytes.
    count = _start_tags(data, most - before) if len(data) > most - before else 0
    if count > most - before:
        have = f"{before} elements before, and this file {count}" if before else f"{count} elements"
        message = f"the model has {have}, which is more than {most}"
        raise Malformed(Diagnostic("ROBOT002", Severity.ERROR, message, "", Span(file.path)), None)
    _check(file)
    # One character a byte, so that offsets are those of the file.
    text = data.decode("latin-1")
    plain = text.isascii()
    breaks = text
    if text.count("\r") != text.count("\r\n"):
        # A lone carriage return ends a line, too.
        breaks = text.replace("\r\n", " \n").replace("\r", "\n")
    found: list[Element] = []
    open_: list[Element] = []
    line, counted = 1, 0
    for markup in _MARKUP.finditer(text):
        if markup.lastindex == 1:
            start, close = markup.span()
            if len(open_) + depth >= MOST_DEPTH:
                message = f"more than {MOST_DEPTH} elements inside one another"
                place = place_of(file.path, data, start)
                raise Malformed(Diagnostic("ROBOT002", Severity.ERROR, message, "", place), found[0].tag)
            line += breaks.count("\n", counted, start)
            counted = start
            tag = markup[1] if plain else as_unicode(markup[1])
            element = Element(tag, text, index, start, markup.end(1), close, close, line, [])
            found.append(element)
            if open_:
                open_[-1].children.append(element)
            if text[close - 2] != "/":
                open_.append(element)
        elif markup.lastindex == 2:
            open_.pop().end = markup.end()
    return found


def _start_tags(data: bytes, enough: int) -> int:
    """How many start tags a file has; what has no tag in it is left out where that may decide."""
    # `<` begins start tags, end tags and what has no tag in it, and stands nowhere else in a well-formed text.
    count = data.count(b"<") - data.count(b"</")
    if count <= enough:
        return count
    count = 0
    for markup in _TAG_OR_TEXT.finditer(data):
        count += markup.lastindex is not None
    return count


def _check(file: ModelFile) -> None:
    """Refuse what is not well-formed, and a DOCTYPE."""
    data = file.data
    # The declared encoding has been judged; MuJoCo reads UTF-8 whatever is declared, and so does this.
    parser = expat.ParserCreate("utf-8")

    def doctype(*_: object) -> None:
        message = "the file has a DOCTYPE, which can define entities and name other files"
        # expat calls at the end of the name.
        place = place_of(file.path, data, data.rfind(b"<!DOCTYPE", 0, parser.CurrentByteIndex + 1))
        help = "delete it; MJCF and URDF need none"
        raise Malformed(Diagnostic("ROBOT005", Severity.ERROR, message, "", place, help), None)

    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(data, True)
    except expat.ExpatError as err:
        root, inside = _opened(data)
        message, help = explain(err.code, data, parser.ErrorByteIndex, inside)
        place = Span(file.path, err.lineno, err.offset + 1)
        raise Malformed(Diagnostic("ROBOT004", Severity.ERROR, message, "", place, help), root) from err


def _opened(data: bytes) -> tuple[str | None, tuple[str, int] | None]:
    """The root's tag, and tag and line of the element that is open where a text stops being well-formed."""
    parser = expat.ParserCreate("utf-8")
    roots: list[str] = []
    open_: list[tuple[str, int]] = []

    def start(tag: str, _: object) -> None:
        roots.append(tag)
        open_.append((tag, parser.CurrentLineNumber))

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: open_.pop()
    with suppress(expat.ExpatError):
        parser.Parse(data, True)
    return next(iter(roots), None), (open_[-1] if open_ else None)
