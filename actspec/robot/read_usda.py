"""Read a layer of USD's text form (`.usda`), as far as overlays of a robot's stage go.

Nothing is followed: references, payloads, sublayers and inherits are listed in `UsdaLayer.unfollowed`. Variants, time
samples and connections are refused.
Source: USD 26.8; tests/frameworks/test_usda.py holds the reader to it, statement by statement.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace

from actspec.diagnostics import RobotError, Span, one_line, shortened
from actspec.robot.usda import Asset, UsdaAttribute, UsdaLayer, UsdaPrim, Value
from actspec.robot.usda_scan import NOT_READ, SYNTAX, TOO_MUCH, Scanner, Token, refusal
from actspec.robot.usda_values import PLAIN, WORDS, fitted, number

MAX_BYTES = 1024 * 1024
"""Largest layer. Chosen: an overlay of 40 joints has 40 kB; meshes are in other layers."""
MAX_ITEMS = 50_000
"""Most prims, attributes and paths together. Chosen: likewise, a hundred times."""
MAX_PATH = 2048
"""Longest path [characters]. Chosen: as deep as prims go, with names of eight letters."""
MAX_DEPTH = 256
"""Deepest prim. Chosen: a prim is nested in those of the bodies above it, and a chain may have a hundred."""
MAX_NESTING = 32
"""Deepest value. Chosen: an array of tuples has 2."""

VERSIONS = ("1.0", "1.1")
"""Of the text form; 1.1 adds splines, which are refused as time samples are."""

SPECIFIERS = ("def", "over", "class")
_LIST_EDITS = ("prepend", "append", "add", "delete", "reorder")
_COMPOSITION = (
    *("references", "payload", "inherits", "specializes", "subLayers", "variants", "variantSets"),
    "relocates",
)
_PAIRS = {"(": ")", "[": "]", "{": "}"}
_QUALIFIERS = ("custom", "uniform", "varying", "config")
_NAMES = r"[^\W\d]\w*(?:/[^\W\d]\w*)*"
_PATH = re.compile(
    rf"""(?:(?P<root>/{_NAMES})|(?P<up>(?:\.\./)*)(?P<names>{_NAMES})|(?P<above>\.\.(?:/\.\.)*)|(?=\.\w))
    (?P<property>\.[^\W\d][\w:]*)?""",
    re.VERBOSE,
)


def read_usda(data: bytes, path: str) -> UsdaLayer:
    """Read a layer.

    Args:
        data: The file.
        path: Its name, for places.

    Raises: RobotError: it is no layer in text form, or has something that is not read; the first such place.
    """
    whole = Span(path)
    if data.startswith(b"PXR-USDC") or data.startswith(b"PK\x03\x04"):
        message = f"a {'binary layer' if data.startswith(b'PXR') else 'package'} of USD, and only its text form is read"
        raise refusal(NOT_READ, message, whole, "write it as text, e.g. with usdcat -o FILE.usda")
    if len(data) > MAX_BYTES:
        raise refusal(TOO_MUCH, f"the layer has {len(data)} bytes, more than {MAX_BYTES}", whole)
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as err:
        line = data[: err.start].count(b"\n") + 1
        message = f"the file is not UTF-8: byte 0x{data[err.start]:02x}"
        raise refusal(SYNTAX, message, Span(path, line)) from err
    first, _, _ = text.partition("\n")
    words = first.split()
    if words[:1] != ["#usda"]:
        message = f"a layer in text form begins with '#usda 1.0', got '{shortened(first.strip())}'"
        raise refusal(SYNTAX, message, Span(path, 1))
    if words[1:2] not in ([version] for version in VERSIONS):
        message = f"a version that is not known: '{shortened(first.strip())}'"
        raise refusal(NOT_READ, message, Span(path, 1), f"known: {', '.join(VERSIONS)}")
    return _Parser(Scanner(text, path, len(first))).layer()


@dataclass(slots=True)
class _ListEdits:
    """What a layer does to a list that weaker layers may have too."""

    edits: dict[str, tuple[str, ...]] = field(default_factory=dict)

    def edit(self, word: str, items: tuple[str, ...]) -> None:
        """Take a statement: `word` is "" where it states the whole list, which puts edits out of force, and they it."""
        if word == "":
            self.edits.clear()
        else:
            self.edits.pop("", None)
        self.edits[word] = items

    def result(self) -> tuple[str, ...]:
        """What the list is where no weaker layer has one; deleted items are theirs."""
        found = self.edits.get("", ())
        for word in ("add", "prepend", "append"):
            items = self.edits.get(word, ())
            others = tuple(item for item in found if item not in items)
            if word == "add":
                found += tuple(item for item in items if item not in found)
            else:
                found = items + others if word == "prepend" else others + items
        return found


@dataclass(slots=True)
class _Open:
    """A prim whose contents are being read."""

    path: str
    specifier: str
    type: str
    span: Span
    active: bool
    apis: _ListEdits = field(default_factory=_ListEdits)
    attributes: dict[str, UsdaAttribute] = field(default_factory=dict)
    targets: dict[str, _ListEdits] = field(default_factory=dict)

    def prim(self) -> UsdaPrim:
        attributes = {
            name: replace(found, value=self.targets[name].result()) if name in self.targets else found
            for name, found in self.attributes.items()
        }
        return UsdaPrim(
            self.path, self.specifier, self.type, self.apis.result(), attributes, self.active, self.span
        )


class _Parser:
    """The grammar, one statement after the other; prims are on a stack, values are nested."""

    def __init__(self, scanner: Scanner) -> None:
        self._in = scanner
        self._prims: dict[str, UsdaPrim | None] = {}
        self._unfollowed: list[tuple[str, Span]] = []
        self._items = 0

    def layer(self) -> UsdaLayer:
        if self._in.take("("):
            self._metadata(None)
        stack: list[_Open] = []
        while self._in.token.kind != "end" or stack:
            token = self._in.token
            word = token.text if token.kind == "word" else ""
            if stack and self._in.take("}"):
                done = stack.pop()
                self._prims[done.path] = done.prim()
                if not self._in.token.first:
                    raise self._in.unexpected("a new line")
            elif word in SPECIFIERS:
                stack.append(self._open(stack))
            elif word == "variantSet":
                raise self._in.error(token, NOT_READ, "a variantSet, which is not read")
            elif word and stack:
                self._property(stack[-1])
            elif word == "reorder":
                self._in.next()
                self._reordered()
            else:
                raise self._in.unexpected("an attribute, a prim or '}'" if stack else "def, over or class")
        prims = {path: prim for path, prim in self._prims.items() if prim is not None}
        return UsdaLayer(self._in.path, prims, tuple(self._in.head), tuple(self._unfollowed))

    def _open(self, stack: list[_Open]) -> _Open:
        start = self._in.next()
        above = stack[-1] if stack else None
        kind = ""
        if self._in.token.kind == "word":
            kind = self._on_this_line("the prim's type").text
        name = self._on_this_line("the prim's name in quotes", "string")
        if not name.text.isidentifier():
            message = f"'{shortened(name.text)}' is no name of a prim"
            raise self._in.error(name, SYNTAX, message, "a name has letters, digits and _")
        if len(stack) >= MAX_DEPTH:
            raise self._in.error(start, TOO_MUCH, f"prims are nested deeper than {MAX_DEPTH}")
        path = f"{above.path if above else ''}/{name.text}"
        if path in self._prims:
            raise self._in.error(name, SYNTAX, f"the layer has the prim {shortened(path)} already")
        self._count(start, path)
        # Its place in the file's order.
        self._prims[path] = None
        made = _Open(path, start.text, kind, self._in.span(start), above.active if above else True)
        if self._in.take("("):
            self._metadata(made)
        self._in.mark("{")
        return made

    def _count(self, token: Token, path: str) -> None:
        """One more thing that is kept, and the path that it has."""
        self._items += 1
        if self._items > MAX_ITEMS:
            raise self._in.error(token, TOO_MUCH, f"more than {MAX_ITEMS} prims, attributes and paths")
        if len(path) > MAX_PATH:
            raise self._in.error(token, TOO_MUCH, f"a path of more than {MAX_PATH} characters")

    def _metadata(self, prim: _Open | None) -> None:
        """What is in parentheses behind a prim or an attribute, or at the layer's head."""
        while not self._in.take(")"):
            if self._in.token.kind == "string":
                # A remark.
                self._in.next()
                self._ended(")")
                continue
            edit = self._in.next().text if self._in.at(*_LIST_EDITS) else ""
            wanted = "a name of metadata, or ')'"
            key = self._on_this_line(wanted) if edit else self._in.expect("word", wanted)
            if key.text in _COMPOSITION:
                self._unfollowed.append((key.text, self._in.span(key)))
            self._equals()
            if prim is not None and key.text == "apiSchemas":
                prim.apis.edit(edit, self._schemas())
            elif prim is not None and key.text == "active":
                prim.active = bool(self._typed("bool", key.text)) and prim.active
            else:
                self._skip()
            self._ended(")")

    def _schemas(self) -> tuple[str, ...]:
        start = self._in.token
        found = self._value(0)
        if found is None:
            return ()
        if not isinstance(found, tuple) or not all(isinstance(name, str) for name in found):
            raise self._in.error(start, SYNTAX, "apiSchemas is a list of names in quotes")
        return self._distinct(start, tuple(map(str, found)))

    def _property(self, prim: _Open) -> None:
        start = self._in.token
        edit = self._in.next().text if self._in.at(*_LIST_EDITS) else ""
        if edit == "reorder" and not self._in.at("rel"):
            self._reordered()
            return
        while self._in.at(*_QUALIFIERS):
            self._in.next()
        kind = self._in.expect("word", "the type of an attribute").text
        if self._in.take("["):
            self._in.mark("]")
            kind += "[]"
        name = self._on_this_line("the name of an attribute")
        bare, _, part = name.text.partition(".")
        if part:
            message = f"{shortened(part)} of {shortened(bare)}, and only plain values are read"
            raise self._in.error(name, NOT_READ, message)
        old = prim.attributes.get(bare)
        if old is not None and old.type != kind:
            message = f"{shortened(bare)} is of type {kind} here and {old.type} in line {old.span.line}"
            raise self._in.error(name, SYNTAX, message)
        if edit and kind != "rel":
            raise self._in.error(start, SYNTAX, f"{edit} is for relationships and metadata, got a {kind}")
        value: Value = () if kind == "rel" else None
        stated = self._in.at("=")
        if stated:
            self._equals()
            if kind == "rel":
                prim.targets.setdefault(bare, _ListEdits()).edit(edit, self._targets(prim.path))
            else:
                value = self._typed(kind, bare)
        if not self._in.token.first and self._in.take("("):
            self._metadata(None)
        self._ended("")
        self._count(name, bare)
        if stated or old is None:
            prim.attributes[bare] = UsdaAttribute(kind, bare, value, self._in.span(start))

    def _reordered(self) -> None:
        """An order of prims or properties: no meaning here."""
        self._in.expect("word", "what is reordered")
        self._equals()
        self._skip()
        self._ended("")

    def _equals(self) -> None:
        if self._in.token.first:
            raise self._in.unexpected("'='")
        self._in.mark("=")
        if self._in.token.first:
            raise self._in.unexpected("a value")

    def _ended(self, closing: str) -> None:
        """A statement ends with its line, one `;`, or the parenthesis that it is in."""
        token = self._in.token
        if not (self._in.take(";") or token.first or self._in.at(closing)):
            raise self._in.unexpected("a new line")

    def _on_this_line(self, what: str, kind: str = "word") -> Token:
        if self._in.token.first:
            raise self._in.unexpected(what)
        return self._in.expect(kind, what)

    def _targets(self, prim: str) -> tuple[str, ...]:
        start = self._in.token
        if self._in.take("None"):
            return ()
        if not self._in.take("["):
            return (self._target(prim),)
        found = []
        while not self._in.take("]"):
            found.append(self._target(prim))
            if not self._in.take(","):
                self._in.mark("]")
                break
        return self._distinct(start, tuple(found))

    def _target(self, prim: str) -> str:
        """A path, from the root on."""
        token = self._in.expect("path", "a path in < >")
        match = _PATH.fullmatch(token.text)
        names = prim.split("/")[1:]
        up = 0 if match is None else (match["up"] or match["above"] or "").count("..")
        if match is None or up >= len(names) + bool(match["names"]):
            raise self._in.error(token, SYNTAX, f"<{shortened(token.text)}> is no path of a prim or property")
        path = token.text
        if not match["root"]:
            below = [match["names"]] if match["names"] else []
            path = "/" + "/".join([*names[: len(names) - up], *below]) + (match["property"] or "")
        self._count(token, path)
        return path

    def _distinct(self, start: Token, items: tuple[str, ...]) -> tuple[str, ...]:
        if len(set(items)) < len(items):
            raise self._in.error(start, SYNTAX, "the list has the same item twice")
        return items

    def _typed(self, kind: str, name: str) -> Value:
        """A value that has to fit its type, where that is one of the plain ones."""
        start = self._in.token
        value = self._value(0)
        plain = kind.removesuffix("[]")
        array = plain != kind
        if value is None:
            return None
        if array != isinstance(value, tuple) and (array or plain in PLAIN):
            raise self._wrong(start, kind, name)
        found = [fitted(plain, item) for item in (value if array and isinstance(value, tuple) else (value,))]
        if None in found:
            raise self._wrong(start, kind, name)
        return tuple(found) if array else found[0]

    def _wrong(self, start: Token, kind: str, name: str) -> RobotError:
        message = f"{shortened(name)} is of type {kind}, got {shortened(one_line(start.text))}"
        return self._in.error(start, SYNTAX, message)

    def _value(self, depth: int) -> Value:
        token = self._in.token
        if token.text in ("(", "[") and token.kind == "mark":
            return self._several(depth)
        if token.kind in ("end", "mark"):
            raise self._in.unexpected("a value")
        self._in.next()
        if token.kind == "number":
            return number(token.text)
        if token.kind == "asset":
            return Asset(token.text)
        if token.kind == "word" and token.text in WORDS:
            return WORDS[token.text]
        if token.kind == "word":
            raise self._in.error(token, SYNTAX, f"a value belongs here, got '{shortened(token.text)}'")
        return token.text

    def _several(self, depth: int) -> Value:
        """An array or a tuple."""
        token = self._in.next()
        if depth >= MAX_NESTING:
            raise self._in.error(token, TOO_MUCH, f"values are nested deeper than {MAX_NESTING}")
        closing = _PAIRS[token.text]
        found = []
        while not self._in.take(closing):
            found.append(self._value(depth + 1))
            if not self._in.take(","):
                self._in.mark(closing)
                break
        return tuple(found)

    def _skip(self) -> None:
        """A value of metadata that nobody asks for: one token, or all between brackets."""
        start = self._in.token
        expected: list[str] = []
        while True:
            token = self._in.token
            mark = token.text if token.kind == "mark" else ""
            closing = expected[-1:] == [mark]
            wrong = mark not in _PAIRS and not closing and (not expected or mark in _PAIRS.values())
            if token.kind == "end" or (mark and wrong):
                raise self._in.unexpected(f"'{expected[-1]}'" if expected else "a value")
            self._in.next()
            if mark in _PAIRS:
                expected.append(_PAIRS[mark])
                if len(expected) > MAX_NESTING:
                    raise self._in.error(start, TOO_MUCH, f"values are nested deeper than {MAX_NESTING}")
            elif closing:
                expected.pop()
            if not expected and not self._continues(token):
                return

    def _continues(self, token: Token) -> bool:
        """Whether a reference goes on: `@file@</prim> (offset = 1)`."""
        coming = self._in.token
        if coming.first or token.kind not in ("asset", "path"):
            return False
        return self._in.at("(") or (token.kind == "asset" and coming.kind == "path")
