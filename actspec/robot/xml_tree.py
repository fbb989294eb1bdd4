"""An MJCF or URDF as elements that know their bytes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

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


@dataclass(frozen=True, slots=True, eq=False)
class Element:
    """One element; compared by identity.

    Attributes:
        tag: Tag, with its prefix.
        attributes: By name, in the author's order.
        file: Index into `XmlDocument.files`.
        start: The `<` of the start tag [byte].
        open_end: Just after the `>` of the start tag.
        end: Just after the whole element; `open_end` for `<a/>`.
        self_closing: Whether it is written `<a/>`.
        line: Line of `start`, from 1.
        column: Column of `start` in characters, from 1.
        children: Child elements; in the place of an include those of the included root, which are
            in another file.
    """

    tag: str
    attributes: Mapping[str, Attribute]
    file: int
    start: int
    open_end: int
    end: int
    self_closing: bool
    line: int
    column: int
    children: tuple[Element, ...]

    def get(self, name: str, default: str | None = None) -> str | None:
        """Value of an attribute, or `default`."""
        found = self.attributes.get(name)
        return default if found is None else found.value


@dataclass(frozen=True, slots=True)
class Include:
    """One include.

    Attributes:
        element: The `<include>`, in the including file; it is no child of its parent.
        name: Its `file` attribute.
        index: The included file, in `XmlDocument.files`.
    """

    element: Element
    name: str
    index: int


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
        return Span(self.files[element.file].path, element.line, element.column)

    def is_repeated(self, element: Element) -> bool:
        """Whether the element's file is included more than once: an edit would then count twice."""
        path = self.files[element.file].path
        return sum(file.path == path for file in self.files) > 1
