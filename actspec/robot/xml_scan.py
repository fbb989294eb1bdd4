"""The elements of one XML file with their byte offsets, from expat.

What expat refuses is refused, with the place and a way out, even where MuJoCo reads it: MuJoCo's
parser takes a bare `&`, `<` in a value and `--` in a comment.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from xml.parsers import expat

from actspec.diagnostics import Diagnostic, Severity, Span
from actspec.robot.view import ModelFile
from actspec.robot.xml_errors import Malformed, check_encoding, explain, place_of
from actspec.robot.xml_tree import Attribute, Element

MOST_DEPTH = 200
"""Chosen: elements inside one another, through includes; MuJoCo's parser stops at 500 in one file."""

_ATTRIBUTE = re.compile(rb"""\s*([^\s=]+)\s*=\s*(?:"([^"]*)"|'([^']*)')""")


@dataclass(slots=True)
class Raw:
    """An element while its file is being scanned; children and file are not known yet.

    `parent` is its parent's place in the list, -1 for the root; `depth` counts itself and the elements around it.
    """

    parent: int
    depth: int
    tag: str
    attributes: dict[str, Attribute]
    start: int
    open_end: int
    end: int
    self_closing: bool
    line: int
    column: int

    def finish(self, file: int, children: tuple[Element, ...]) -> Element:
        """The element, in a file of the model and with its children."""
        return Element(
            self.tag,
            self.attributes,
            file,
            self.start,
            self.open_end,
            self.end,
            self.self_closing,
            self.line,
            self.column,
            children,
        )


def scan(file: ModelFile, depth: int, before: int, most: int) -> list[Raw]:
    """Elements of one file in document order, the root first.

    Args:
        file: To be scanned.
        depth: Elements that the root is inside of.
        before: Elements of the files before it.
        most: Elements that the model may have.

    Raises: Malformed: it is no XML that is read here.
    """
    data = file.data
    check_encoding(file.path, data)
    # The declared encoding has been judged; MuJoCo reads UTF-8 whatever is declared, and so does this.
    parser = expat.ParserCreate("utf-8")
    parser.ordered_attributes = True
    raws: list[Raw] = []
    open_: list[int] = []
    match = _ATTRIBUTE.match

    def refuse(code: str, message: str, help: str | None, at: int | None = None) -> Malformed:
        place = place_of(file.path, data, parser.CurrentByteIndex if at is None else at)
        root = raws[0].tag if raws else None
        return Malformed(Diagnostic(code, Severity.ERROR, message, "", place, help), root)

    def start(tag: str, pairs: list[str]) -> None:
        if len(open_) + depth >= MOST_DEPTH:
            raise refuse("ROBOT002", f"more than {MOST_DEPTH} elements inside one another", None)
        if before + len(raws) >= most:
            raise refuse("ROBOT002", f"the model has more than {most} elements", None)
        at = parser.CurrentByteIndex
        position = at + 1 + (len(tag) if tag.isascii() else len(tag.encode()))
        attributes: dict[str, Attribute] = {}
        for i in range(0, len(pairs), 2):
            found = match(data, position)
            # expat has checked the tag, so the pattern cannot fail here.
            assert found is not None
            position = found.end()
            first, last = found.span(found.lastindex or 0)
            attributes[pairs[i]] = Attribute(pairs[i], pairs[i + 1], found.start(1), position, first, last)
        close = data.index(b">", position)
        raws.append(
            Raw(
                open_[-1] if open_ else -1,
                len(open_) + depth + 1,
                tag,
                attributes,
                at,
                close + 1,
                close + 1,
                data[close - 1] == 0x2F,
                parser.CurrentLineNumber,
                parser.CurrentColumnNumber + 1,
            )
        )
        open_.append(len(raws) - 1)

    def end(tag: str) -> None:
        raw = raws[open_.pop()]
        if not raw.self_closing:
            raw.end = data.index(b">", parser.CurrentByteIndex) + 1

    def doctype(*_: object) -> None:
        raise refuse(
            "ROBOT005",
            "the file has a DOCTYPE, which can define entities and name other files",
            "delete it; MJCF and URDF need none",
            # expat calls at the end of the name.
            data.rfind(b"<!DOCTYPE", 0, parser.CurrentByteIndex + 1),
        )

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(data, True)
    except expat.ExpatError as err:
        opened = raws[open_[-1]] if open_ else None
        inside = (opened.tag, opened.line) if opened is not None else None
        message, help = explain(err.code, data, parser.ErrorByteIndex, inside)
        place = Span(file.path, err.lineno, err.offset + 1)
        root = raws[0].tag if raws else None
        raise Malformed(Diagnostic("ROBOT004", Severity.ERROR, message, "", place, help), root) from err
    return raws
