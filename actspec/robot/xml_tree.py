"""An MJCF or URDF as elements that know their bytes."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from actspec.diagnostics import Span
from actspec.robot.view import ModelFile


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
    return text if text.isascii() else text.encode("latin-1").decode()


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
