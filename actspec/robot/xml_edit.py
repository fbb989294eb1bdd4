"""Edits of MJCF and URDF text that leave every other byte as the author wrote it.

Edits name elements of one parsed document and are all applied at once, so no edit sees another's
result. New text gets the file's line ending and the indentation of its neighbours. Comments are
never deleted, but those inside an element that is removed or replaced.
"""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from actspec.robot.view import ModelFile
from actspec.robot.xml_tree import Element, XmlDocument

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_.:-]*")
_ESCAPES = {"&": "&amp;", "<": "&lt;", ">": "&gt;", "\n": "&#10;", "\r": "&#13;", "\t": "&#9;"}
_QUOTES = {'"': "&quot;", "'": "&apos;"}
_BREAK = re.compile(rb"\r\n|\n|\r")
_BOM = b"\xef\xbb\xbf"


@dataclass(frozen=True, slots=True)
class SetAttribute:
    """Set an attribute; one that is not there comes after the last.

    Attributes:
        element: Of the document that is edited; also an `Include.element`.
        name: Attribute.
        value: Plain text, escaped by the edit; None deletes the attribute, if it is there.
    """

    element: Element
    name: str
    value: str | None


@dataclass(frozen=True, slots=True)
class ReplaceElement:
    """Put XML text in the place of an element; further lines get the indentation of its first."""

    element: Element
    text: str


@dataclass(frozen=True, slots=True)
class RemoveElement:
    """Remove an element, and its lines if nothing else is on them.

    MuJoCo refuses an included file that is left without elements.
    """

    element: Element


@dataclass(frozen=True, slots=True)
class InsertBefore:
    """Put XML text before an element, on lines of its own where the element begins its line."""

    element: Element
    text: str


@dataclass(frozen=True, slots=True)
class AppendChild:
    """Put XML text after the last child of an element; `<a/>` is opened for it."""

    element: Element
    text: str


Edit = SetAttribute | ReplaceElement | RemoveElement | InsertBefore | AppendChild


def escape_attribute(value: str, quote: str = '"') -> str:
    """Escape a value to stand between `quote`s and come back the same.

    Raises: ValueError: the value has a character that XML cannot hold.
    """
    for character in value:
        code = ord(character)
        if (code < 32 and character not in "\t\n\r") or 0xD800 <= code <= 0xDFFF or code in (0xFFFE, 0xFFFF):
            raise ValueError(f"XML cannot hold {value!r}")
    table = {**_ESCAPES, quote: _QUOTES[quote]}
    return "".join(table.get(character, character) for character in value)


def exact_number(x: float) -> str:
    """Shortest text that reads back as the same double: `25`, `0.1`, `1e-05`.

    Raises: ValueError: not finite.
    """
    if not math.isfinite(x):
        raise ValueError(f"not a finite number: {x!r}")
    return repr(float(x)).removesuffix(".0")


def apply_edits(document: XmlDocument, edits: Sequence[Edit]) -> tuple[ModelFile, ...]:
    """Apply edits to the text of a document's files.

    Args:
        document: Parsed; the elements of the edits are its own.
        edits: In any order; only insertions at the same place keep theirs. The same edit twice is
            one, but for insertions.

    Returns: The files, in order; one whose bytes do not change is the same object.

    Raises:
        ValueError: two edits contradict each other, or one is inside an element that another removes
            or replaces; an element is not of this document, or in a file that is included twice;
            the root is removed; a name or value cannot be written in XML.
    """
    if not edits:
        return document.files
    plans = _plan(document, edits)
    files = list(document.files)
    for index in {plan.element.file for plan in plans}:
        file = files[index]
        own = [plan for plan in plans if plan.element.file == index]
        data = _File(file.data, own).edited()
        if data != file.data:
            files[index] = replace(file, data=data)
    return tuple(files)


@dataclass(slots=True)
class _Plan:
    """All that is to be done to one element."""

    element: Element
    attributes: dict[str, str | None] = field(default_factory=dict)
    replacement: str | None = None
    removed: bool = False
    before: list[str] = field(default_factory=list)
    appended: list[str] = field(default_factory=list)


def _plan(document: XmlDocument, edits: Sequence[Edit]) -> list[_Plan]:
    known = {id(element) for element in document.walk()}
    known.update(id(include.element) for include in document.includes)
    plans: dict[int, _Plan] = {}
    for edit in edits:
        element = edit.element
        if id(element) not in known:
            raise ValueError(f"<{element.tag}> is not of this document")
        if document.is_repeated(element):
            raise ValueError(f"<{element.tag}> is in a file that is included more than once")
        plan = plans.setdefault(id(element), _Plan(element))
        if isinstance(edit, SetAttribute):
            if edit.name not in element.values and not _NAME.fullmatch(edit.name):
                raise ValueError(f"not the name of an attribute: {edit.name!r}")
            if plan.attributes.setdefault(edit.name, edit.value) != edit.value:
                raise ValueError(f"<{element.tag} {edit.name}> is set to two values")
        elif isinstance(edit, ReplaceElement):
            if plan.replacement not in (None, edit.text):
                raise ValueError(f"<{element.tag}> is replaced by two texts")
            plan.replacement = edit.text
        elif isinstance(edit, RemoveElement):
            if element is document.root:
                raise ValueError("the root cannot be removed")
            plan.removed = True
        elif isinstance(edit, InsertBefore):
            plan.before.append(edit.text)
        else:
            plan.appended.append(edit.text)
    for plan in plans.values():
        if plan.removed or plan.replacement is not None:
            _check_gone(document, plan, plans)
    return list(plans.values())


def _check_gone(document: XmlDocument, plan: _Plan, plans: dict[int, _Plan]) -> None:
    """Refuse other edits of an element that is to go, and edits inside it, through includes too."""
    gone = plan.element
    if (plan.removed and plan.replacement is not None) or plan.attributes or plan.appended:
        raise ValueError(f"<{gone.tag}> is removed or replaced, and edited as well")
    inside = list(gone.children)
    while inside:
        element = inside.pop()
        inside.extend(element.children)
        if id(element) in plans:
            raise ValueError(f"<{element.tag}> is edited inside <{gone.tag}>, which is removed or replaced")
    for include in document.includes:
        element = include.element
        nested = element.file == gone.file and gone.start < element.start < gone.end
        if nested and id(element) in plans:
            raise ValueError(f"an include is edited inside <{gone.tag}>, which is removed or replaced")


class _File:
    """The edits of one file, turned into patches of its bytes."""

    def __init__(self, data: bytes, plans: Sequence[_Plan]) -> None:
        self.data = data
        self.plans = plans
        found = _BREAK.search(data)
        self.newline = found[0].decode() if found is not None else "\n"
        self.step = "\t" if data.count(b"\n\t") > data.count(b"\n ") else "  "
        self.deletions: list[tuple[int, int]] = []
        # (start, end, text), the text taking the place of the bytes.
        self.patches: list[tuple[int, int, bytes]] = []
        self.removed = {plan.element.start: plan.element.end for plan in plans if plan.removed}

    def edited(self) -> bytes:
        for plan in self.plans:
            element = plan.element
            if plan.before:
                self._insert_before(element, plan.before)
            if plan.removed:
                self.deletions.append(self._lines_of(element))
            elif plan.replacement is not None:
                text = self._lines(plan.replacement, self._indent(element.start))
                self.patches.append((element.start, element.end, text.encode()))
            else:
                self._set_attributes(element, plan.attributes)
                if plan.appended:
                    self._append(element, plan.appended)
        return self._patched()

    def _patched(self) -> bytes:
        """Deletions united, then everything in order of place; insertions before what starts there."""
        united: list[tuple[int, int, bytes]] = []
        for start, end in sorted(self.deletions):
            if united and start <= united[-1][1]:
                united[-1] = (united[-1][0], max(end, united[-1][1]), b"")
            else:
                united.append((start, end, b""))
        pieces: list[bytes] = []
        done = 0
        for start, end, text in sorted([*self.patches, *united], key=lambda patch: patch[:2]):
            pieces.append(self.data[done:start])
            pieces.append(text)
            # An insertion inside a deleted stretch of white space lands at its end.
            done = max(done, end)
        pieces.append(self.data[done:])
        return b"".join(pieces)

    def _lines(self, text: str, indent: str) -> str:
        """Text with the file's line ending, its further lines indented."""
        lines = textwrap.dedent(re.sub(r"\r\n?", "\n", text)).strip().split("\n")
        return self.newline.join([lines[0], *(indent + line if line.strip() else "" for line in lines[1:])])

    def _blank_before(self, at: int) -> int:
        """First byte of the blanks before `at`."""
        while at > 0 and self.data[at - 1] in b" \t":
            at -= 1
        return at

    def _blank_after(self, at: int) -> int:
        """Just after the blanks from `at` on."""
        while at < len(self.data) and self.data[at] in b" \t":
            at += 1
        return at

    def _begins_line(self, at: int) -> bool:
        return at == 0 or self.data[at - 1] in b"\r\n" or (at == 3 and self.data.startswith(_BOM))

    def _ends_line(self, at: int) -> bool:
        return at == len(self.data) or self.data[at] in b"\r\n"

    def _after_break(self, at: int) -> int:
        """Just after the line break at `at`; `at` at the end of the file."""
        if self.data[at : at + 2] == b"\r\n":
            return at + 2
        return min(at + 1, len(self.data))

    def _indent(self, at: int) -> str:
        """The white space that begins the line of `at`."""
        start = max(self.data.rfind(b"\n", 0, at), self.data.rfind(b"\r", 0, at)) + 1
        return self.data[start : min(self._blank_after(start), at)].decode()

    def _lines_of(self, element: Element) -> tuple[int, int]:
        """Bytes to delete with an element: itself, and its lines if only removed elements share them."""
        first = self._blank_before(element.start)
        last = self._blank_after(element.end)
        # The first removed element of a line takes those behind it along.
        while last in self.removed:
            last = self._blank_after(self.removed[last])
        begins, ends = self._begins_line(first), self._ends_line(last)
        if begins and ends:
            return first, self._after_break(last)
        if begins:
            return element.start, last
        return self._blank_before(element.start) if ends else element.start, element.end

    def _insert_before(self, element: Element, texts: Sequence[str]) -> None:
        indent = self._indent(element.start)
        at = self._blank_before(element.start)
        if self._begins_line(at):
            text = "".join(indent + self._lines(text, indent) + self.newline for text in texts)
        else:
            at = element.start
            text = "".join(self._lines(text, indent) for text in texts)
        self.patches.append((at, at, text.encode()))

    def _set_attributes(self, element: Element, wanted: dict[str, str | None]) -> None:
        new: list[str] = []
        quote = '"'
        at = element.start + 1 + len(element.tag.encode())
        for attribute in element.attributes.values():
            quote = chr(self.data[attribute.value_end])
            before, at = at, attribute.end
            if attribute.name not in wanted:
                continue
            value = wanted[attribute.name]
            if value is None:
                self.deletions.append(self._attribute_bytes(before, attribute.start, attribute.end))
            elif value != attribute.value:
                text = escape_attribute(value, quote)
                self.patches.append((attribute.value_start, attribute.value_end, text.encode()))
        for name, value in wanted.items():
            if name not in element.values and value is not None:
                new.append(f" {name}={quote}{escape_attribute(value, quote)}{quote}")
        if new:
            self.patches.append((at, at, "".join(new).encode()))

    def _attribute_bytes(self, before: int, start: int, end: int) -> tuple[int, int]:
        """Bytes to delete with an attribute: its line if it has one, else the space before it."""
        first, last = self._blank_before(start), self._blank_after(end)
        if not (self._begins_line(first) and self._ends_line(last)):
            return before, end
        # From the break that begins the line up to the one that ends it.
        first -= 2 if self.data[first - 2 : first] == b"\r\n" else 1
        return first, last

    def _append(self, element: Element, texts: Sequence[str]) -> None:
        own = self._indent(element.start)
        indent = self._child_indent(element, own)
        lines = "".join(indent + self._lines(text, indent) + self.newline for text in texts)
        if element.self_closing:
            start = self._blank_before(element.open_end - 2)
            text = f">{self.newline}{lines}{own}</{element.tag}>"
            self.patches.append((start, element.open_end, text.encode()))
            return
        close = self.data.rindex(b"</", element.open_end, element.end)
        content = self.data[element.open_end : close]
        line = self._blank_before(close)
        if self._begins_line(line):
            self.patches.append((line, line, lines.encode()))
        elif not content.strip():
            self.patches.append((element.open_end, close, f"{self.newline}{lines}{own}".encode()))
        elif b"\n" in content or b"\r" in content:
            self.patches.append((close, close, f"{self.newline}{lines}{own}".encode()))
        else:
            inline = "".join(self._lines(text, indent) for text in texts)
            self.patches.append((close, close, inline.encode()))

    def _child_indent(self, element: Element, own: str) -> str:
        """Indentation of a new child: as the last child that begins a line, else one step deeper."""
        for child in reversed(element.children):
            if child.file == element.file and self._begins_line(self._blank_before(child.start)):
                return self._indent(child.start)
        return own + self.step
