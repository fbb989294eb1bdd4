"""Strict YAML to a tree of values, each with its place.

YAML 1.2 core meaning, which PyYAML's own loaders do not give (`on` is a word, `010` is ten,
`1e-3` is a number). Built from parser events, so that a hostile file is stopped at its first
excess: nothing is constructed that was not counted before.
"""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass
from typing import Any

from actspec.diagnostics import Collector, Span, listed, many, nearest
from actspec.spec.yaml_lines import off_level
from actspec.spec.yaml_problems import plain_problem, too_deep
from actspec.spec.yaml_text import BREAK, Stop, cut, got, place, stray_character, text_of

MAX_DEPTH = 40
"""Deepest nesting of collections. Chosen: the language needs 7."""
MAX_NODES = 100_000
"""Most values and keys of a file, aliases expanded. Chosen: a spec of 100 joints has about 5000."""
MAX_ALIASES = 100
"""Most aliases in a file. Chosen: far above any spec written by hand."""
MAX_ERRORS = 50
"""Errors told about one file before reading stops."""

Scalar = str | int | float | bool | None

_INT = re.compile(r"[-+]?[0-9]+")
_OCTAL = re.compile(r"0o[0-7]+")
_HEX = re.compile(r"0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(?:inf|Inf|INF)|\.nan|\.NaN|\.NAN")
_WORDS: dict[str, bool | None] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}
_NOT_IN_VALUE = re.compile("[\0\ud800-\udfff]")
_TAG_PREFIX = "tag:yaml.org,2002:"


class Node:
    """One value: where it is, what it holds, and how large it is with its aliases expanded."""

    __slots__ = ("height", "size", "span", "text", "value")

    def __init__(self, span: Span, value: Scalar | dict[str, tuple[Span, Node]] | list[Node]) -> None:
        self.span = span
        self.value = value
        self.size = 1
        self.height = 0
        self.text: str | None = None
        """Of a number without quotes, its digits as they are written."""


def parse(data: bytes, path: str, collector: Collector, *, included: bool = False) -> Node | None:
    """The tree of one file; None where it has none, with the reason in the collector."""
    try:
        root = _Builder(path, collector).build(text_of(data, path, collector))
    except Stop:
        return None
    if root is None or (root.value is None and root.height == 0 and root.size == 0):
        help = "write `motors:` or `sources:`" if included else "`actspec init` writes a first one"
        collector.error("SPEC005", "the file is empty", span=Span(path), help=help)
        return None
    if not isinstance(root.value, dict):
        kind = "a list" if isinstance(root.value, list) else f"the value {got(root.value)}"
        help = "begin with `motors:` or `sources:`" if included else "begin with `actspec: 1`"
        collector.error("SPEC005", f"must be a mapping of keys, got {kind}", span=root.span, help=help)
        return None
    return root


@dataclass(frozen=True, slots=True)
class _Repeat:
    """A key that its mapping has already.

    Attributes:
        key: The key.
        span: Its place.
        first: Place of the other.
        where: Path of the mapping.
        header: The last key with nothing behind it, where that stands between the two, and its place.
        next: Whether it is the key below `header`.
    """

    key: str
    span: Span
    first: Span
    where: str
    header: tuple[str, Span] | None
    next: bool


class _Open:
    """A collection whose end has not come yet."""

    __slots__ = ("anchor", "flow", "key", "node", "number", "repeats", "waiting")

    def __init__(self, node: Node, anchor: str | None, flow: bool) -> None:
        self.node = node
        self.anchor = anchor
        self.flow = flow
        """Whether it stands in [ ] or { }."""
        self.repeats: list[_Repeat] = []
        self.key: tuple[str, Span] | None = None
        """The key whose value comes next; None for one that was refused."""
        self.number: Node | None = None
        """That key, where it is a number: without a value a comma may have cut it off."""
        self.waiting = False
        """Whether a value comes next, not a key."""


class _Builder:
    """Builds the tree of one file from parser events, within the limits."""

    def __init__(self, path: str, collector: Collector) -> None:
        self.path = path
        self.collector = collector
        self.errors = 0
        self.nodes = 0
        self.aliases = 0
        self.merged: int | None = None
        """Line of a merge key, which is told."""
        self.anchors: dict[str, Node | None] = {}
        self.stack: list[_Open] = []
        self.list_keys: list[tuple[Span, str]] = []
        """Keys that are lists, each with the path of its mapping: `[FR]L_hip` may be meant as a pattern."""
        self.no_text: dict[str, list[tuple[Node, str]]] = {}
        """Keys that are no text by what they are, each with the path of its mapping."""
        self.root: Node | None = None
        self.end = Span(path)
        self.lines: list[str] = []
        self.keys = 0
        self.empty: tuple[str, Span] | None = None
        """The last key outside of { } with nothing behind it, and its place."""
        self.empty_key = 0
        """The how many-th of all keys it is."""

    def build(self, text: str) -> Node | None:
        """The root; None for a text without a document."""
        import yaml

        self.end, self.lines = place(text, self.path), BREAK.split(text)
        loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)(text)
        documents = 0
        try:
            while loader.check_event():
                event = loader.get_event()
                if isinstance(event, yaml.ScalarEvent):
                    self.scalar(event)
                elif isinstance(event, yaml.AliasEvent):
                    self.alias(event)
                elif isinstance(event, yaml.MappingStartEvent):
                    self.open(event, {}, "map")
                elif isinstance(event, yaml.SequenceStartEvent):
                    self.open(event, [], "seq")
                elif isinstance(event, yaml.CollectionEndEvent):
                    self.close()
                elif isinstance(event, yaml.DocumentStartEvent):
                    documents += 1
                    if documents > 1:
                        help = "keep one; each robot has a file of its own"
                        self.fatal("SPEC005", "a second document begins here", self.span(event), help)
        except yaml.YAMLError as err:
            self.syntax(err, text)
        except (ValueError, OverflowError):
            # The pure parser's answer to an escape above U+10FFFF.
            self.fatal("SPEC004", "an escape in double quotes names no character", Span(self.path))
        finally:
            loader.dispose()
        self.tell_no_text()
        return self.root

    def at(self, mark: Any) -> Span:
        # libyaml puts the end of a text without a final line break on the line after the last.
        return min(Span(self.path, mark.line + 1, mark.column + 1), self.end)

    def span(self, event: Any) -> Span:
        return self.at(event.start_mark)

    def error(
        self, code: str, message: str, span: Span, help: str | None = None, *, where: str | None = None
    ) -> None:
        self.errors += 1
        if self.errors > MAX_ERRORS:
            self.collector.error("SPEC019", f"more than {MAX_ERRORS} errors; reading stopped here", span=span)
            raise Stop
        where = self.where() if where is None else where
        self.collector.error(code, message, where=where, span=span, help=help)

    def fatal(self, code: str, message: str, span: Span, help: str | None = None) -> None:
        self.tell_repeats()
        self.error(code, message, span, help)
        raise Stop

    def where(self) -> str:
        """Path of the value that is being read."""
        text = ""
        for frame in self.stack:
            if isinstance(frame.node.value, list):
                text += f"[{len(frame.node.value)}]"
            elif frame.waiting and frame.key is not None:
                text += f".{cut(frame.key[0])}"
        return text.lstrip(".")

    def count(self, nodes: int, span: Span) -> None:
        self.nodes += nodes
        if self.nodes > MAX_NODES:
            message = f"the file has more than {MAX_NODES} values, aliases expanded"
            self.fatal("SPEC011", message, span, "keep tables and logs in files that the spec names")

    def open(self, event: Any, value: dict[str, tuple[Span, Node]] | list[Node], tag: str) -> None:
        span = self.span(event)
        self.count(1, span)
        if len(self.stack) >= MAX_DEPTH:
            self.fatal("SPEC011", f"nested more than {MAX_DEPTH} levels deep", span)
        if event.tag not in (None, _TAG_PREFIX + tag):
            self.tag(event.tag, span)
        if event.anchor is not None:
            self.anchors[event.anchor] = None
        node = Node(span, value)
        node.height = 1
        self.stack.append(_Open(node, event.anchor, bool(event.flow_style)))

    def close(self) -> None:
        self.repeated(len(self.stack) - 1)
        frame = self.stack.pop()
        if frame.anchor is not None:
            self.anchors[frame.anchor] = frame.node
        self.add(frame.node, plain=False)

    def alias(self, event: Any) -> None:
        span = self.span(event)
        self.aliases += 1
        if self.aliases > MAX_ALIASES:
            help = "use `overrides`, or a motor by name"
            self.fatal("SPEC010", f"more than {MAX_ALIASES} aliases", span, help)
        name: str = event.anchor
        if name not in self.anchors and span.line == self.merged:
            # That it has no anchor is no second fault of the line.
            self.add(Node(span, None), plain=False)
            return
        if name not in self.anchors:
            guess = nearest(name, list(self.anchors))
            self.fatal(
                "SPEC010",
                f"the alias *{cut(name)} has no anchor &{cut(name)} above it",
                span,
                f"did you mean *{guess}?" if guess else f"a joint pattern must be quoted: '.*{cut(name)}'",
            )
        target = self.anchors[name]
        if target is None:
            message = f"the alias *{cut(name)} is recursive: it stands inside its own anchor"
            self.fatal("SPEC010", message, span, "write out what it should hold")
            return
        self.count(target.size, span)
        if len(self.stack) + target.height > MAX_DEPTH:
            self.fatal("SPEC011", f"nested more than {MAX_DEPTH} levels deep, aliases expanded", span)
        node = Node(span, target.value)
        node.size, node.height = target.size, target.height
        self.add(node, plain=False)

    def scalar(self, event: Any) -> None:
        span = self.span(event)
        self.count(1, span)
        text: str = event.value
        plain = not event.style
        inside = self.stack[-1] if self.stack else None
        is_key = inside is not None and isinstance(inside.node.value, dict) and not inside.waiting
        if _NOT_IN_VALUE.search(text):
            self.error("SPEC003", "a text may not hold NUL or half of a surrogate pair", span)
        value: Scalar = text
        if plain and inside is not None and isinstance(inside.node.value, list) and not inside.flow:
            self.item(text.split(), event.start_mark.line, event.end_mark)
        if event.tag is not None:
            value = self.tagged(event.tag, text, span)
        elif plain:
            value = self.finite(_core(text), text, span, is_key)
        node = Node(span, value)
        if plain and event.tag is None and type(value) in (int, float):
            node.text = text
        if not self.stack and plain and text == "" and event.tag is None:
            node.size = 0
        if event.anchor is not None:
            self.anchors[event.anchor] = node
        self.add(node, plain=plain and event.tag is None)

    def item(self, words: list[str], start: int, end: Any) -> None:
        """Tell an item of a list of `- ` that goes on with items of its own: further in, or a word on each line."""
        for number in range(start + 1, end.line + 1):
            found = off_level(self.lines, number)
            if found is not None:
                self.error("SPEC004", found.message, self.at(found.mark), found.help)
                return
        if end.line > start and len(words) == end.line - start + 1:
            last = words[-1]
            at = Span(self.path, end.line + 1, end.column - len(last) + 1)
            self.error(
                "SPEC004",
                "this item lacks its `- ` and goes on with the one above it",
                at,
                f"write `- {cut(last)}`",
            )

    def tagged(self, tag: str, text: str, span: Span) -> Scalar:
        """The value of a scalar with a tag: the core ones are checked, all others refused."""
        kind = tag.removeprefix(_TAG_PREFIX) if tag.startswith(_TAG_PREFIX) else None
        if kind == "str":
            return text
        if kind not in ("int", "float", "bool", "null"):
            self.tag(tag, span)
            return text
        value = self.finite(_core(text), text, span, False)
        fits = {
            "int": type(value) is int,
            "float": type(value) in (int, float),
            "bool": type(value) is bool,
            "null": value is None,
        }
        if not fits[kind]:
            self.error("SPEC008", f"!!{kind} does not fit the text {got(text)}", span, "remove the tag")
            return text
        return float(value) if kind == "float" and value is not None else value

    def finite(self, value: Scalar, text: str, span: Span, is_key: bool) -> Scalar:
        number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not is_key and number and not abs(value) <= sys.float_info.max:  # type: ignore[arg-type]
            help = "for a figure that nobody states write `unknown`; for a word, quote it"
            self.error("SPEC016", f"must be a finite number, got {cut(text)}", span, help)
        return value

    def tag(self, tag: str, span: Span) -> None:
        shown = "!!" + tag.removeprefix(_TAG_PREFIX) if tag.startswith(_TAG_PREFIX) else tag
        shown = shown if shown.startswith("!") else f"!<{shown}>"
        help = "remove it; a text that begins with ! must be quoted"
        self.error("SPEC008", f"the tag {cut(shown)} is not allowed", span, help)

    def add(self, node: Node, *, plain: bool) -> None:
        """Put a finished value where it belongs."""
        if not self.stack:
            self.root = node
            return
        frame = self.stack[-1]
        held = frame.node.value
        if isinstance(held, dict) and not frame.waiting:
            frame.key = self.key(node, held, plain)
            frame.waiting = True
            frame.node.size += 1
            return
        frame.node.size += node.size
        frame.node.height = max(frame.node.height, node.height + 1)
        if isinstance(held, list):
            held.append(node)
        elif isinstance(held, dict):
            if frame.number is not None and not (plain and node.value is None):
                frame.key = None
                self.refuse(frame.number)
            elif frame.key is not None:
                held[frame.key[0]] = (frame.key[1], node)
                if plain and node.value is None and not frame.flow:
                    self.empty, self.empty_key = frame.key, self.keys
            frame.waiting = False

    def key(self, node: Node, held: dict[str, tuple[Span, Node]], plain: bool) -> tuple[str, Span] | None:
        """The key that a node is; None after an error."""
        frame = self.stack[-1]
        frame.number = node if frame.flow and node.text is not None else None
        key = node.value if frame.number is None else node.text
        if not isinstance(key, str):
            if isinstance(key, (dict, list)):
                if isinstance(key, list):
                    self.list_keys.append((node.span, self.where()))
                    return None
                # `{{kp}}`, in a template or by a slip.
                help = "write one pair of { }" if frame.flow else "quote it"
                self.error("SPEC009", "a key must be a word, not a mapping", node.span, help)
            else:
                self.refuse(node)
            return None
        stray = stray_character(key, key=True) if plain and not key.isascii() else None
        if stray is not None:
            at = node.span
            self.fatal("SPEC003", stray[1], Span(at.path, at.line, at.column + stray[0]), stray[2])
        if key == "<<" and plain:
            help = "use `overrides` for the joints that differ, or a motor by name for what is shared"
            self.error("SPEC007", "the merge key << is not allowed", node.span, help)
            self.merged = node.span.line
            return None
        self.keys += 1
        if key in held:
            if frame.flow and key[:1].isdigit() and held[key][1].value is None:
                # `{value: 1,5 s, std: 0,5 s}` is cut by its commas, and has no two keys.
                return None
            first = held[key][0]
            header = self.empty if self.empty is not None and first < self.empty[1] else None
            repeat = _Repeat(key, node.span, first, self.where(), header, self.keys == self.empty_key + 1)
            frame.repeats.append(repeat)
            return None
        return key, node.span

    def refuse(self, key: Node) -> None:
        """Note a key that is no text."""
        value = key.value
        kind = "nothing" if value is None else "a truth value" if isinstance(value, bool) else "a number"
        self.no_text.setdefault(kind, []).append((key, self.where()))

    def tell_no_text(self) -> None:
        """Tell the keys that are no text, each kind once: a file has them by its form, not by a slip."""
        for kind, keys in self.no_text.items():
            key, where = keys[0]
            more = f", here and at {many(len(keys) - 1, 'more place')}" if len(keys) > 1 else ""
            message = f"the key {got(key.value)} reads as {kind}, and keys are text{more}"
            help = "quote it, a joint pattern that looks like a number too"
            self.error("SPEC009", message, key.span, help, where=where)
        self.no_text.clear()
        for span, where in self.list_keys:
            help = "quote it, or write a line for each"
            self.error("SPEC009", "a key must be a word, not a list", span, help, where=where)
        self.list_keys.clear()

    def tell_repeats(self) -> None:
        """Tell those of all mappings whose end has not come."""
        self.tell_no_text()
        for depth in range(len(self.stack)):
            self.repeated(depth)

    def repeated(self, depth: int) -> None:
        """Tell the repeated keys of an open mapping: those below a header that is too far in at the header."""
        frame = self.stack[depth]
        repeats, frame.repeats = frame.repeats, []
        owner = self.stack[depth - 1].key if depth else None
        below: dict[tuple[str, Span], list[_Repeat]] = {}
        for one in repeats:
            if one.header is not None and owner is not None:
                below.setdefault(one.header, []).append(one)
        told: set[Span] = set()
        if below:
            # The models take time to load, and a file that is right needs none of them here.
            from actspec.spec.shape import is_section
        for header, mine in below.items():
            if owner is None or (len(mine) == 1 and not mine[0].next and not is_section(header[0])):
                continue
            name, names = cut(header[0]), listed(dict.fromkeys(f"`{cut(one.key)}`" for one in mine), 4)
            message = f"`{name}` is empty in `{cut(owner[0])}`, and what follows is repeated there: {names}"
            help = (
                f"indent `{name}:` by {owner[1].column - 1} spaces as `{cut(owner[0])}:`, if that is its own"
            )
            self.error("SPEC006", message, header[1], help, where=mine[0].where)
            told.update(one.span for one in mine)
        rest = [one for one in repeats if one.span not in told]
        # Of a section's names already two are of another section.
        if len(rest) > (1 if depth == 1 else 2) and owner is not None:
            names = listed([f"`{cut(one.key)}`" for one in rest], 4)
            message = f"{names} are repeated in `{cut(owner[0])}`, first at {rest[0].first}"
            line = "a section" if depth == 1 else "a name"
            help = f"is the line of {line} missing above this one? Else keep one of each"
            self.error("SPEC006", message, rest[0].span, help, where=rest[0].where)
            rest = []
        for one in rest:
            message = f"the key '{cut(one.key)}' is repeated, first at {one.first}"
            more = "; what variants change stands under `variants`" if one.key == "variant" else ""
            if depth == 1 and not frame.flow:
                more = ", rename one, or write the line of the section that is missing between them"
            self.error("SPEC006", message, one.span, f"keep one of the two{more}", where=one.where)

    def syntax(self, err: Any, text: str) -> None:
        """Say in plain words what PyYAML found."""
        problem = str(getattr(err, "problem", None) or "")
        context = str(getattr(err, "context", None) or "")
        mark = getattr(err, "problem_mark", None) or getattr(err, "context_mark", None)
        start = getattr(err, "context_mark", None)
        if start is not None and "end of stream" in problem:
            mark = start
        found = plain_problem(problem, context, text, mark, start)
        span = Span(self.path) if found.mark is None else self.at(found.mark)
        # The list is told by the same place.
        self.list_keys = [held for held in self.list_keys if held[0] != span]
        self.tell_repeats()
        self.stack.clear()
        if too_deep(problem):
            self.fatal("SPEC011", f"nested more than {MAX_DEPTH} levels deep", span)
        self.fatal("SPEC004", found.message, span, found.help)


def _core(text: str) -> Scalar:
    """A plain scalar by the core schema of YAML 1.2; numbers out of range are infinite."""
    if text in _WORDS:
        return _WORDS[text]
    if text[0] not in "+-.0123456789":
        return text
    # int() of a long text is quadratic, and refuses more than 4300 digits since Python 3.11.
    too_long = len(text) > 400
    if _INT.fullmatch(text):
        return float("inf") if too_long else int(text)
    if _OCTAL.fullmatch(text):
        return float("inf") if too_long else int(text[2:], 8)
    if _HEX.fullmatch(text):
        return float("inf") if too_long else int(text[2:], 16)
    if _FLOAT.fullmatch(text):
        return float(text)
    if _NOT_FINITE.fullmatch(text):
        return float(text.replace(".", ""))
    return text
