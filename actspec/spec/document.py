"""A spec and what it includes, as plain data with the place of every key and value."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from typing import Any

from actspec.diagnostics import Collector, Span, SpecError
from actspec.spec.include import (
    INCLUDED_KEYS,
    MAX_INCLUDES,
    check_included,
    included_names,
    merge,
    path_inside,
)
from actspec.spec.paths import Path
from actspec.spec.read import MAX_BYTES, read_file, too_large
from actspec.spec.yaml_text import cut
from actspec.spec.yaml_tree import MAX_ALIASES, MAX_DEPTH, MAX_ERRORS, MAX_NODES, Node, Scalar, parse

__all__ = [
    "INCLUDED_KEYS",
    "MAX_ALIASES",
    "MAX_BYTES",
    "MAX_DEPTH",
    "MAX_ERRORS",
    "MAX_INCLUDES",
    "MAX_NODES",
    "Document",
    "Scalar",
    "SourceMap",
    "document_from_text",
    "load_document",
]


class SourceMap:
    """Where each key and value of a document is written.

    A path is a tuple of keys and indices. Components that have no node (a discriminator tag of
    a pydantic location, a missing key) are passed over, so the answer is the nearest place.
    """

    __slots__ = ("_root",)

    def __init__(self, root: Node) -> None:
        self._root = root

    def value(self, path: Path) -> Span:
        """Place of the value at `path`; an alias is where it stands, what is inside it at its anchor."""
        return self._find(path)[1]

    def key(self, path: Path) -> Span:
        """Place of the key at `path`; for an item of a list, of the item."""
        return self._find(path)[0]

    def _find(self, path: Path) -> tuple[Span, Span]:
        node, key = self._root, self._root.span
        for part in path:
            held = node.value
            if isinstance(held, dict) and isinstance(part, str) and part in held:
                key, node = held[part]
            elif isinstance(held, list) and type(part) is int and 0 <= part < len(held):
                node = held[part]
                key = node.span
        return key, node.span


@dataclass(frozen=True, slots=True)
class Document:
    """A spec's text as plain data.

    Attributes:
        path: The file as the user named it.
        data: Dicts with string keys, lists, str, int, float, bool, None; `include` is resolved away.
        spans: Where each key and value is written.
        text_sha256: Hash of the spec's bytes, then of each include's name and bytes, in order;
            without includes it is the hash of the file.
        includes: The included files as the spec names them.
    """

    path: str
    data: dict[str, Any]
    spans: SourceMap
    text_sha256: str
    includes: tuple[str, ...]


def load_document(path: str) -> Document:
    """Read a spec and what it includes.

    Raises:
        SpecError: with every error of the text; reading stops only where the text has no meaning.
    """
    collector = Collector()
    data = read_file(path, Span(path), collector)
    return _document(data, path, os.path.dirname(path) or os.curdir, collector)


def document_from_text(text: str | bytes, path: str = "<text>", base: str | None = None) -> Document:
    """Read a spec from memory.

    Args:
        text: The spec.
        path: The name for messages.
        base: Folder that `include` is relative to; None: including is an error.

    Raises:
        SpecError: with every error of the text.
    """
    data = text.encode("utf-8", "surrogatepass") if isinstance(text, str) else text
    collector = Collector()
    if len(data) > MAX_BYTES:
        message, help, code = too_large("the text", len(data))
        collector.error(code, message, span=Span(path), help=help)
        raise SpecError(collector.sorted())
    return _document(data, path, base, collector)


def _document(data: bytes | None, path: str, base: str | None, collector: Collector) -> Document:
    root = None if data is None else parse(data, path, collector)
    if data is None or root is None:
        raise SpecError(collector.sorted())
    assert isinstance(root.value, dict)
    digest = hashlib.sha256(data)
    names: list[str] = []
    merged = Node(root.span, {key: entry for key, entry in root.value.items() if key != "include"})
    if "include" in root.value:
        read = {os.path.realpath(path)}
        for index, (name, span) in enumerate(included_names(root.value["include"][1], collector)):
            place = path_inside(name, base, index, span, collector)
            if place is None:
                continue
            shown, real = place
            if real in read:
                collector.error(
                    "SPEC013",
                    f"'{cut(name)}' is included a second time",
                    where=f"include[{index}]",
                    span=span,
                    help="name each file once, and the spec itself not at all",
                )
                continue
            read.add(real)
            more = read_file(shown, span, collector, real=real, where=f"include[{index}]")
            if more is None:
                continue
            # NUL is refused in every file and name, so it separates without ambiguity.
            digest.update(b"\0" + name.encode("utf-8", "surrogateescape") + b"\0" + more)
            names.append(name)
            part = parse(more, shown, collector, included=True)
            if part is not None:
                check_included(part, collector)
                merge(merged, part, collector)
    collector.raise_if_failed(SpecError)
    plain = _plain(merged)
    assert isinstance(plain, dict)
    return Document(path, plain, SourceMap(merged), digest.hexdigest(), tuple(names))


def _plain(node: Node) -> Any:
    """Plain data, each alias a copy of its own; the depth was bounded before."""
    held = node.value
    if isinstance(held, dict):
        return {key: _plain(value) for key, (_, value) in held.items()}
    if isinstance(held, list):
        return [_plain(item) for item in held]
    return held
