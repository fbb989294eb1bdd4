"""An MJCF or URDF as elements that know their bytes, as expat tells them.

What expat refuses is refused, with the place and a way out, even where MuJoCo's parser takes it: a bare `&`, `<` in a
value. What changes nothing in what MuJoCo makes of a file is read as it reads it: `--` in a comment, no space between
two attributes, white space before the declaration, elements or closing tags behind the root, and NUL bytes at the end.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

from actspec import files
from actspec.diagnostics import Collector, Diagnostic, Severity, Span
from actspec.robot.view import ModelFile
from actspec.robot.xml_reasons import READ_BY_MUJOCO, explain


@dataclass(frozen=True, slots=True)
class Attribute:
    """One attribute; offsets are bytes of the file that its element is in.

    Attributes:
        name: Name, with its prefix.
        value: Value as XML means it: references resolved, line breaks and tabs as spaces.
        start: First byte of the name.
        end: Just after the closing quote.
        value_start: Just after the opening quote.
        value_end: The closing quote.
    """

    name: str
    value: str
    start: int
    end: int
    value_start: int
    value_end: int


NUMBER = re.compile(r"[+-]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|inf(?:inity)?)", re.IGNORECASE)
"""A number in an attribute; MuJoCo takes `nan` too, and nothing here does."""

_ATTRIBUTE = re.compile(r"""\s*([^\s=]+)\s*=\s*(?:"([^"]*)"|'([^']*)')""", re.ASCII)
_START_TAG = re.compile(r"""<[^"'>]*(?:"[^"]*"[^"'>]*|'[^']*'[^"'>]*)*>""", re.ASCII)
"""A start tag in a well-formed text."""


@dataclass(slots=True, eq=False)
class Element:
    """One element; compared by identity, and not changed once its document is there.

    It is not frozen because hundreds are made for a file, of which few are looked at: where its tags end,
    its column and span are worked out when they are asked for.

    Attributes:
        tag: Tag, with its prefix.
        text: The file that it is in, well-formed, one character a byte.
        file: Index into `XmlDocument.files`.
        start: The `<` of the start tag [byte].
        line: Line of `start`, from 1.
        values: Attribute to value, as XML means it, in the author's order; not to be changed.
        close: The `<` of the end tag; just after `<a/>` [byte].
        children: Child elements; in the place of an include those of the included root, which are
            in another file.
    """

    tag: str
    text: str = field(repr=False)
    file: int
    start: int
    line: int
    values: dict[str, str]
    close: int = -1
    children: list[Element] = field(default_factory=list)
    _open_end: int = field(default=-1, init=False, repr=False)
    _span: Span | None = field(default=None, init=False, repr=False)

    @property
    def attributes(self) -> dict[str, Attribute]:
        """By name, in the author's order, with their places in the text; `values` is at hand without a look there."""
        found: dict[str, Attribute] = {}
        position = self.name_end
        for name, value in self.values.items():
            match = _ATTRIBUTE.match(self.text, position)
            # expat has checked the tag, so the pattern cannot fail here.
            assert match is not None
            position = match.end()
            found[name] = Attribute(name, value, match.start(1), position, *match.span(match.lastindex or 0))
        return found

    @property
    def name_end(self) -> int:
        """Just after the tag's name."""
        return self.start + 1 + len(self.tag.encode())

    @property
    def open_end(self) -> int:
        """Just after the `>` of the start tag."""
        if self._open_end < 0:
            found = _START_TAG.match(self.text, self.start)
            # expat has checked the tag, so the pattern cannot fail here.
            assert found is not None
            self._open_end = found.end()
        return self._open_end

    @property
    def end(self) -> int:
        """Just after the whole element; `open_end` for `<a/>`."""
        text, close = self.text, self.close
        # The quick way for `<a b="1"/>`, without a look at its attributes.
        if text[close - 2] == "/" and text.find(">", self.start, close - 1) < 0:
            return close
        return self.open_end if self.self_closing else text.index(">", close) + 1

    @property
    def self_closing(self) -> bool:
        """Whether it is written `<a/>`."""
        return self.text[self.open_end - 2] == "/"

    @property
    def column(self) -> int:
        """Column of `start` in characters, from 1."""
        text, start = self.text, self.start
        begin = text.rfind("\n", 0, start) + 1
        begin = max(text.rfind("\r", begin, start) + 1, begin)
        before = text[begin:start]
        return (start - begin if before.isascii() else len(as_unicode(before).removeprefix("\ufeff"))) + 1

    def get(self, name: str, default: str | None = None) -> str | None:
        """Value of an attribute, or `default`."""
        return self.values.get(name, default)


def as_unicode(text: str) -> str:
    """What UTF-8 means that is held with one character a byte."""
    return text if text.isascii() else text.encode("latin-1").decode("utf-8", "replace")


@dataclass(frozen=True, slots=True)
class Include:
    """One include.

    Attributes:
        element: The `<include>`, in the including file; it is no child of its parent.
        name: Its `file` attribute.
        index: The included file, in `XmlDocument.files`.
        root: Its root, whose children stand in the place of `element`.
    """

    element: Element
    name: str
    index: int
    root: Element


@dataclass(frozen=True, slots=True)
class XmlDocument:
    """A model's files, parsed.

    Attributes:
        files: The main file, then one entry for every include, each followed by its own includes.
        root: Root of the main file.
        includes: In the order of `files[1:]`.
    """

    files: tuple[ModelFile, ...]
    root: Element
    includes: tuple[Include, ...]

    def sections(self, tag: str) -> tuple[Element, ...]:
        """Children of the root with that tag, through includes, in document order."""
        return tuple(child for child in self.root.children if child.tag == tag)

    def keyframes(self) -> tuple[Element, ...]:
        """The keys of all keyframes, in document order."""
        every = (child for section in self.sections("keyframe") for child in section.children)
        return tuple(child for child in every if child.tag == "key")

    def walk(self, *tags: str) -> Iterator[Element]:
        """All elements (or those with one of the tags), the root too, depth first in document order."""
        stack = [self.root]
        while stack:
            element = stack.pop()
            if not tags or element.tag in tags:
                yield element
            stack.extend(reversed(element.children))

    def span(self, element: Element) -> Span:
        """Where an element starts."""
        if element._span is None:
            element._span = Span(self.files[element.file].path, element.line, element.column)
        return element._span

    def is_repeated(self, element: Element) -> bool:
        """Whether the element's file is included more than once: an edit would then count twice."""
        path = self.files[element.file].path
        return sum(file.path == path for file in self.files) > 1


_COMMENTS = re.compile(r"(?:\s|<!--.*?-->)*[\s\0]*", re.DOTALL)
_CLOSING = re.compile(r"(?:\s|<!--.*?-->|</[^<>]*>)*[\s\0]*", re.DOTALL)


def report_behind(document: XmlDocument, out: Collector) -> None:
    """Report what follows the root of a file and is no comment: MuJoCo takes nothing from it."""
    for root in (document.root, *(include.root for include in document.includes)):
        comments = _COMMENTS.match(root.text, root.end)
        if comments is not None and comments.end() < len(root.text):
            file = document.files[root.file]
            place = place_of(file.path, file.data, comments.end())
            # A closing tag too many is none of anybody's figures.
            closing = _CLOSING.match(root.text, comments.end())
            alone = closing is not None and closing.end() == len(root.text)
            report = out.info if alone else out.warning
            message = "MuJoCo reads nothing of what follows the root element, and other readers of XML refuse the file"
            help = f"delete it, or move </{root.tag}> behind it"
            report("ROBOT009", message, span=place, help=help)


MOST_DEPTH = 200
"""Chosen: elements inside one another, through includes; MuJoCo's parser stops at 500 in one file."""


MOST_ATTRIBUTES = 1000
"""Chosen: of one element. MJCF knows a tenth of it; MuJoCo's parser compares each with all others."""


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
    check_encoding(file.path, file.data)
    data = legible(file.data)
    try:
        return _scan(file, _Lenient(data), index, depth, before, most)
    except Malformed as err:
        lenient = _as_mujoco_reads(data) if err.diagnostic.code == NOT_XML else None
        if lenient is None or lenient.data == data:
            raise
    return _scan(file, lenient, index, depth, before, most)


def _scan(
    file: ModelFile, lenient: _Lenient, index: int, depth: int, before: int, most: int
) -> list[Element]:
    data = file.data
    # One character a byte, so that offsets are those of the file.
    text = data.decode("latin-1")
    found: list[Element] = []
    open_: list[Element] = []
    # The declared encoding has been judged; MuJoCo reads UTF-8 whatever is declared, and so does this.
    parser = expat.ParserCreate("utf-8")

    def at() -> int:
        return lenient.place(parser.CurrentByteIndex)

    def doctype(_: str, *more: str | int | None) -> None:
        if may_define(*more):
            message = "the file has a DOCTYPE, which can define entities and name other files"
            # expat calls at the end of the name.
            place = place_of(file.path, data, data.rfind(b"<!DOCTYPE", 0, at() + 1))
            help = "delete it; MJCF and URDF need none"
            raise Malformed(Diagnostic("ROBOT005", Severity.ERROR, message, "", place, help), None)

    def start(tag: str, values: dict[str, str]) -> None:
        element = Element(tag, text, index, at(), parser.CurrentLineNumber, values)
        if before + len(found) >= most:
            behind = f": {before} before this file" if before else ""
            message = f"the model has more than {most} elements{behind}"
            raise Malformed(Diagnostic("ROBOT002", Severity.ERROR, message, "", Span(file.path)), None)
        if len(values) > MOST_ATTRIBUTES:
            message = f"the element has more than {MOST_ATTRIBUTES} attributes"
            place = place_of(file.path, data, element.start)
            raise Malformed(Diagnostic("ROBOT002", Severity.ERROR, message, "", place), None)
        if open_:
            open_[-1].children.append(element)
        if depth + len(open_) >= MOST_DEPTH:
            message = f"more than {MOST_DEPTH} elements inside one another"
            place = place_of(file.path, data, element.start)
            raise Malformed(Diagnostic("ROBOT002", Severity.ERROR, message, "", place), found[0].tag)
        open_.append(element)
        found.append(element)

    def end(_: str) -> None:
        open_.pop().close = at()

    parser.StartDoctypeDeclHandler = doctype
    parser.StartElementHandler = start
    parser.EndElementHandler = end
    try:
        parser.Parse(lenient.data, True)
    except expat.ExpatError as err:
        if found and not open_ and _is_behind(data[found[0].end :]):
            return found
        root = found[0].tag if found else None
        inside = (open_[-1].tag, open_[-1].line) if open_ else None
        code, byte = err.code, lenient.place(parser.ErrorByteIndex)
        if b"<" not in data and (words := data.lstrip()):
            # Where expat stops tells nothing of a text.
            code, byte = expat.errors.codes[expat.errors.XML_ERROR_SYNTAX], len(data) - len(words)
        message, help = explain(code, data, byte, inside)
        place = place_of(file.path, data, byte)
        raise Malformed(Diagnostic(NOT_XML, Severity.ERROR, message, "", place, help), root) from err
    return found


def may_define(*doctype: str | int | None) -> bool:
    """Whether a DOCTYPE can define entities, or name a file that does, as expat tells it; `<!DOCTYPE robot>` cannot."""
    return doctype != (None, None, 0)


NOT_XML = "ROBOT004"
_BOM = b"\xef\xbb\xbf"
_DECLARED = re.compile(rb"""<\?xml\b[^>]*?\bencoding\s*=\s*["']([A-Za-z][A-Za-z0-9._-]*)["']""")


_DECLARATIONS = (b"<!DOCTYPE", b"<!ENTITY", b"<!ELEMENT", b"<!ATTLIST", b"<!NOTATION", b"<![")
"""What expat knows, which is refused or read by itself."""

_LATE = re.compile(rb"\s+<\?xml\b[^>]*\?>")
_TAG = re.compile(rb"""<[^<>"']*(?:(?:"[^"<]*"|'[^'<]*')[^<>"']*)*>""")
_VALUE = re.compile(rb"""(?:"[^"]*"|'[^']*')((?=[^\s"'/>?]))?""")
"""A value in quotes; the group is there where something touches it."""


@dataclass(frozen=True, slots=True)
class _Lenient:
    """A file as expat takes it.

    Attributes:
        data: With spaces for comments that have `--`, for tags that begin with `<!` and are nothing, for text before
            the root and for a declaration behind white space, and with one between attributes that touch.
        added: Places in `data` of the latter, in order.
    """

    data: bytes
    added: tuple[int, ...] = ()

    def place(self, at: int) -> int:
        """A place of `data` in the file."""
        return at - bisect_left(self.added, at)


def _as_mujoco_reads(data: bytes) -> _Lenient:
    """Mend what MuJoCo reads and expat does not, without a change of what the file says; in one pass."""
    late = _LATE.match(data)
    parts: list[bytes] = []
    added: list[int] = []
    last = 0
    if late is not None:
        parts.append(_blank(late[0]))
        last = late.end()
    at = data.find(b"<", last)
    if last == 0 and at > 0 and data[:at].removeprefix(_BOM).strip() and not data.startswith(b"<?xml", at):
        # MuJoCo passes over text before the root, as over any between elements.
        parts.append(_blank(data[:at]))
        last = at
    while at >= 0:
        if data.startswith(b"<!--", at):
            end = data.find(b"-->", at + 4)
            if end < 0:
                break
            if data.find(b"--", at + 4, end + 2) < end:
                parts += [data[last : at + 4], _blank(data[at + 4 : end])]
                last = end
            at = data.find(b"<", end)
            continue
        if data.startswith(b"<!", at) and not data.startswith(_DECLARATIONS, at):
            # `<!-\\- a comment, almost -\\->`: MuJoCo reads it as nothing, as far as its first `>`.
            end = data.find(b">", at) + 1
            if end == 0:
                break
            parts += [data[last:at], _blank(data[at:end])]
            last = end
            at = data.find(b"<", end)
            continue
        tag = _TAG.match(data, at)
        for value in _VALUE.finditer(data, at, tag.end()) if tag is not None else ():
            if value[1] is None:
                continue
            parts += [data[last : value.end()], b" "]
            last = value.end()
            added.append(last + len(added))
        at = data.find(b"<", at + 1 if tag is None else tag.end())
    return _Lenient(b"".join([*parts, data[last:]]), tuple(added))


def _is_behind(rest: bytes) -> bool:
    """Whether MuJoCo reads a file with this behind its root, and reads nothing of it: tags alone, no text between.

    It stops at a closing tag that nothing opens, whatever is behind that. Measured with 4.0.
    """
    rest = rest.rstrip(b"\0 \t\r\n")  # It reads as far as the first NUL.
    text: list[str] = []
    depth = 0

    def start(*_: object) -> None:
        nonlocal depth
        depth += 1

    def end(_: str) -> None:
        nonlocal depth
        depth -= 1

    parser = expat.ParserCreate("utf-8")
    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CharacterDataHandler = lambda data: text.append(data) if depth == 1 else None
    # MuJoCo takes any for a declaration, which has to come first.
    parser.ProcessingInstructionHandler = lambda *_: text.append("<?")
    try:
        # A DOCTYPE is no XML inside an element, and nor are entities.
        parser.Parse(b"<behind-the-root>" + rest + b"</behind-the-root>", True)
    except expat.ExpatError as err:
        mismatch = expat.errors.codes[expat.errors.XML_ERROR_TAG_MISMATCH]
        if err.code != mismatch or depth != 1:
            return False
    return not "".join(text).strip()


def _blank(text: bytes) -> bytes:
    return re.sub(rb"[^\n]", b" ", text)


class Malformed(Exception):
    """A file is refused.

    Attributes:
        diagnostic: Why.
        root: Its root's tag, if it got that far; tells whether the file may be spoken about.
    """

    def __init__(self, diagnostic: Diagnostic, root: str | None) -> None:
        super().__init__(str(diagnostic))
        self.diagnostic = diagnostic
        self.root = root


_SINGLE_BYTES = re.compile(r"iso[-_]?8859[-_]\d{1,2}|windows[-_]?125\d|cp125\d|latin[-_]?1", re.IGNORECASE)
"""Encodings in which each byte is a character, and those of ASCII are ASCII's, as CAD programs declare them."""


def check_encoding(path: str, data: bytes) -> None:
    """Refuse what readers of XML do not all take for the same.

    MuJoCo takes the bytes as they are, whatever is declared, and refuses UTF-16: measured with 4.0, by tinyxml2, which
    urdfdom reads with too. So a file that declares another encoding is read where only comments and text have more than
    ASCII. What is no UTF-8 and declares nothing else is refused.

    Raises: Malformed: with the first byte at fault.
    """
    help = 'save the file as UTF-8 and declare encoding="utf-8"'
    if data.startswith((b"\xff\xfe", b"\xfe\xff")) or b"\0" in data[:2]:
        place = Span(path, 1)
        help += " (MuJoCo does not read it either)"
        raise Malformed(
            Diagnostic("ROBOT003", Severity.ERROR, "the file is UTF-16 or UTF-32", "", place, help), None
        )
    if data.isascii():
        return
    body = data.removeprefix(_BOM)
    declared = _DECLARED.match(body)
    name = declared[1].decode("ascii") if declared is not None else "utf-8"
    help += READ_BY_MUJOCO
    if name.lower().replace("-", "").replace("_", "") == "utf8":
        try:
            data.decode("utf-8")
        except UnicodeDecodeError as err:
            message = f"the file is not UTF-8: byte 0x{data[err.start]:02x}"
            place = place_of(path, data, err.start)
            raise Malformed(Diagnostic("ROBOT003", Severity.ERROR, message, "", place, help), None) from err
        return
    whole = _SINGLE_BYTES.fullmatch(name) is None
    first = next(iter(_beyond_ascii(body, whole)), None)
    if first is not None:
        place = place_of(path, data, first + len(data) - len(body))
        message = f"the file declares encoding {name!r} and has a character that is not ASCII"
        raise Malformed(Diagnostic("ROBOT003", Severity.ERROR, message, "", place, help), None)


_MARKUP = re.compile(rb"<!--.*?(?:-->|\Z)|<\?.*?(?:\?>|\Z)|<(?:[^<>\"']|\"[^\"]*\"|'[^']*')*", re.DOTALL)
_BEYOND = re.compile(rb"[\x80-\xff]")


def _beyond_ascii(data: bytes, whole: bool) -> Iterator[int]:
    """Where bytes are that are not ASCII: in tags, or anywhere."""
    tags = (tag.span() for tag in _MARKUP.finditer(data) if not tag[0].startswith((b"<!--", b"<?")))
    for low, high in [(0, len(data))] if whole else tags:
        yield from (one.start() for one in _BEYOND.finditer(data, low, high))


def legible(data: bytes) -> bytes:
    """A file of which `check_encoding` has taken the encoding, as UTF-8 with each byte in its place: what is none, in
    comments and text, is a question mark.
    """
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return _BEYOND.sub(b"?", data)
    return data


def place_of(path: str, data: bytes, at: int) -> Span:
    """Line and column, in characters, of a byte."""
    return Span(path, *files.place_of(data, at))
