"""The elements of one XML file with their byte offsets, as expat tells them.

What expat refuses is refused, with the place and a way out, even where MuJoCo reads it: MuJoCo's parser takes
a bare `&`, `<` in a value and `--` in a comment.
"""

from __future__ import annotations

import re
from xml.parsers import expat

from actspec.diagnostics import Diagnostic, Severity, Span
from actspec.robot.view import ModelFile
from actspec.robot.xml_errors import Malformed, check_encoding, explain, place_of
from actspec.robot.xml_tree import Element

MOST_DEPTH = 200
"""Chosen: elements inside one another, through includes; MuJoCo's parser stops at 500 in one file."""

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
    return _elements(file, index, MOST_DEPTH - depth)


def _elements(file: ModelFile, index: int, deepest: int) -> list[Element]:
    """The elements; what is not well-formed, has a DOCTYPE or is nested deeper than that is refused."""
    data = file.data
    # One character a byte, so that offsets are those of the file.
    text = data.decode("latin-1")
    found: list[Element] = []
    open_: list[Element] = []
    # The declared encoding has been judged; MuJoCo reads UTF-8 whatever is declared, and so does this.
    parser = expat.ParserCreate("utf-8")

    def doctype(*_: object) -> None:
        message = "the file has a DOCTYPE, which can define entities and name other files"
        # expat calls at the end of the name.
        place = place_of(file.path, data, data.rfind(b"<!DOCTYPE", 0, parser.CurrentByteIndex + 1))
        help = "delete it; MJCF and URDF need none"
        raise Malformed(Diagnostic("ROBOT005", Severity.ERROR, message, "", place, help), None)

    def start(tag: str, values: dict[str, str]) -> None:
        element = Element(tag, text, index, parser.CurrentByteIndex, parser.CurrentLineNumber, values)
        if open_:
            open_[-1].children.append(element)
        if len(open_) >= deepest:
            message = f"more than {MOST_DEPTH} elements inside one another"
            place = place_of(file.path, data, element.start)
            raise Malformed(Diagnostic("ROBOT002", Severity.ERROR, message, "", place), found[0].tag)
        open_.append(element)
        found.append(element)

    def end(_: str) -> None:
        open_.pop().close = parser.CurrentByteIndex

    parser.StartDoctypeDeclHandler = doctype
    parser.StartElementHandler = start
    parser.EndElementHandler = end
    try:
        parser.Parse(data, True)
    except expat.ExpatError as err:
        root = found[0].tag if found else None
        inside = (open_[-1].tag, open_[-1].line) if open_ else None
        message, help = explain(err.code, data, parser.ErrorByteIndex, inside)
        place = Span(file.path, err.lineno, err.offset + 1)
        raise Malformed(Diagnostic("ROBOT004", Severity.ERROR, message, "", place, help), root) from err
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
