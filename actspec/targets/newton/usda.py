"""USD's text form: names, strings and nested prims.

Names come from strangers. A name becomes part of the text only where `is_identifier` or `prim_path` has taken
it; everything else is a string literal or a comment.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from actspec.diagnostics import one_line

MAX_PATH = 1024
"""Longest path of a prim that is taken [characters]. Chosen: real ones have some dozens a level."""

_ASCII = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def is_identifier(name: str) -> bool:
    """Whether a name can be a prim's as it is, in every version of USD."""
    return _ASCII.fullmatch(name) is not None


def prim_path(text: str) -> tuple[str, ...] | None:
    """The names on an absolute path `/World/Robot`, or None if it is not a valid USD prim path.

    Names outside of ASCII are taken as USD 24.03 and later take them.
    """
    if not text.startswith("/") or len(text) > MAX_PATH:
        return None
    parts = tuple(text[1:].split("/"))
    return parts if all(part.isidentifier() for part in parts) else None


def path_text(parts: Sequence[str]) -> str:
    """`/World/Robot`."""
    return "/" + "/".join(parts)


def string(text: str) -> str:
    """Text of any origin as a string literal on one line."""
    safe = one_line(text).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{safe}"'


def asset(name: str) -> str:
    """A file beside the layer as an asset path; `@` in a name is escaped by the longer delimiter."""
    safe = one_line(name)
    if "@" not in safe:
        return f"@./{safe}@"
    escaped = safe.replace("@@@", r"\@@@")
    return f"@@@./{escaped}@@@"


@dataclass(frozen=True, slots=True)
class UsdAttribute:
    """One line of a prim: an attribute or relationship.

    Attributes:
        type: `float`, `int`, `rel`, `asset`, ...
        name: Its name.
        text: Its value as USD text.
        note: Unit and origin; "" without.
    """

    type: str
    name: str
    text: str
    note: str = ""


@dataclass(frozen=True, slots=True)
class Prim:
    """A prim that the layer says something of.

    Attributes:
        path: Names from the root of the stage on.
        specifier: `over`, or `def TYPE`.
        apis: API schemas to apply, in order.
        attributes: Its lines.
        comments: Lines above it.
        active: False: the prim and all below it are switched off.
    """

    path: tuple[str, ...]
    specifier: str = "over"
    apis: tuple[str, ...] = ()
    attributes: tuple[UsdAttribute, ...] = ()
    comments: tuple[str, ...] = ()
    active: bool = True


@dataclass(slots=True)
class _Node:
    """A place in the tree while it is put together."""

    prim: Prim | None = None
    children: dict[str, _Node] = field(default_factory=dict)


def prim_lines(prims: Iterable[Prim]) -> Iterator[str]:
    """All prims as one text, those on the way to them as bare overs."""
    root = _Node()
    for prim in prims:
        node = root
        for name in prim.path:
            node = node.children.setdefault(name, _Node())
        assert node.prim is None, path_text(prim.path)
        node.prim = prim
    for name, node in root.children.items():
        yield ""
        yield from _lines(name, node, "")


def _lines(name: str, node: _Node, indent: str) -> Iterator[str]:
    prim = node.prim or Prim(())
    inner = f"{indent}    "
    yield from (f"{indent}# {one_line(comment)}".rstrip() for comment in prim.comments)
    metadata = [] if prim.active else [f"{inner}active = false"]
    if prim.apis:
        listing = ", ".join(string(api) for api in prim.apis)
        metadata.append(f"{inner}prepend apiSchemas = [{listing}]")
    yield f"{indent}{prim.specifier} {string(name)}" + (" (" if metadata else "")
    if metadata:
        yield from (*metadata, f"{indent})")
    yield f"{indent}{{"
    for attribute in prim.attributes:
        note = f"  # {one_line(attribute.note)}" if attribute.note else ""
        yield f"{inner}{attribute.type} {attribute.name} = {attribute.text}{note}"
    first = not prim.attributes
    for child, below in node.children.items():
        if not first:
            yield ""
        first = False
        yield from _lines(child, below, inner)
    yield f"{indent}}}"
