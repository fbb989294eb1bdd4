"""A spec and what it includes, as plain data with the place of every key and value; and what it may include."""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

from actspec.diagnostics import Collector, Path, Place, Span, SpecError, did_you_mean, dotted, nearest
from actspec.files import is_imported, leads_into
from actspec.spec.variants import chosen, split
from actspec.spec.yaml_text import MAX_BYTES, cut, got, read_file, too_large
from actspec.spec.yaml_text import is_spec as says_spec
from actspec.spec.yaml_tree import MAX_ALIASES, MAX_DEPTH, MAX_ERRORS, MAX_NODES, Node, Scalar, parse

__all__ = [
    "INCLUDED_KEYS",
    "MAX_ALIASES",
    "MAX_BYTES",
    "MAX_DEPTH",
    "MAX_ERRORS",
    "MAX_INCLUDES",
    "MAX_NODES",
    "Breaches",
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

    __slots__ = ("root",)

    def __init__(self, root: Node) -> None:
        self.root = root

    def value(self, path: Path) -> Span:
        """Place of the value at `path`; an alias is where it stands, what is inside it at its anchor."""
        return self._find(path)[1].span

    def key(self, path: Path) -> Span:
        """Place of the key at `path`; for an item of a list, of the item."""
        return self._find(path)[0]

    def written(self, path: Path) -> str | None:
        """The digits of the number at `path`, as `-0` and `05` are written; None for another value."""
        return self._find(path)[1].text

    def _find(self, path: Path) -> tuple[Span, Node]:
        node, key = self.root, self.root.span
        for part in path:
            held = node.value
            if isinstance(held, dict) and isinstance(part, str) and part in held:
                key, node = held[part]
            elif isinstance(held, list) and type(part) is int and 0 <= part < len(held):
                node = held[part]
                key = node.span
        return key, node


@dataclass(frozen=True, slots=True)
class Breaches:
    """Takes what is wrong in a document, with its place; what aliases repeat, once.

    Attributes:
        spans: Where what is written.
        collector: Takes the diagnostics.
        left_out: Sections and named parts about which nothing is said.
    """

    spans: SourceMap
    collector: Collector
    left_out: frozenset[Path] = frozenset()

    def error(
        self, code: str, message: str, path: Path, help: str | None = None, *, key: bool = False
    ) -> None:
        """Add an error at a value, or at its key."""
        if path[:1] in self.left_out or path[:2] in self.left_out:
            return
        span = self.spans.key(path) if key else self.spans.value(path)
        if all((item.code, item.message, item.span) != (code, message, span) for item in self.collector):
            self.collector.error(code, message, where=dotted(path), span=span, help=help)


@dataclass(frozen=True, slots=True)
class Document:
    """A spec's text as plain data.

    Attributes:
        path: The file as the user named it.
        data: Dicts with string keys, lists, str, int, float, bool, None; `include` is resolved away.
        spans: Where each key and value is written.
        text_sha256: Hash of the spec's bytes, then of each include's name and bytes, in order, then of the
            variant's name; without includes it is the hash of the file.
        includes: The included files as the spec names them.
        variant: The variant that was asked for; None for the spec itself.
    """

    path: str
    data: dict[str, Any]
    spans: SourceMap
    text_sha256: str
    includes: tuple[str, ...]
    variant: str | None = None

    def with_key(self, key: str, meant: str) -> Document:
        """The document with what stands under `key` at its top under `meant`, beside what stands there."""
        root = self.spans.root
        assert isinstance(root.value, dict)
        entries = {meant if name == key else name: entry for name, entry in root.value.items()}
        (place, node), (_, other) = root.value[key], root.value.get(meant, (None, None))
        if isinstance(node.value, dict) and other is not None and isinstance(other.value, dict):
            node = Node(node.span, {**other.value, **node.value})
        entries[meant] = (place, node)
        renamed = Node(root.span, entries)
        plain = _plain(renamed)
        assert isinstance(plain, dict)
        return replace(self, data=plain, spans=SourceMap(renamed))


def load_document(path: str, *, is_spec: bool = False) -> Document:
    """Read a spec and what it includes.

    Args:
        path: The file, or `FILE#VARIANT`.
        is_spec: Whether it must be a spec; of one that is another file, nothing but that is told.

    Raises:
        SpecError: with every error of the text; reading stops only where the text has no meaning.
    """
    collector = Collector()
    file, variant = split(path)
    data = read_file(file, Span(file), collector)
    return _document(data, file, os.path.dirname(file) or os.curdir, collector, variant, is_spec)


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


def _document(
    data: bytes | None,
    path: str,
    base: str | None,
    collector: Collector,
    variant: str | None = None,
    is_spec: bool = False,
) -> Document:
    root = None if data is None else parse(data, path, collector)
    if data is None or root is None:
        if data and is_spec and not says_spec(data) and not path.lower().endswith((".yaml", ".yml")):
            # What is wrong with it as YAML is of no use.
            help = "a spec begins with `actspec: 1`, and is YAML"
            raise SpecError.of("SPEC104", "this is no spec: it has no key `actspec`", Span(path), help=help)
        raise SpecError(collector.sorted())
    assert isinstance(root.value, dict)
    if is_spec and _is_other(root.value):
        form = root.value["format"][1].value if "format" in root.value else None
        what = f"its `format` is {got(form)}" if form else "it has no key `actspec`, and no `actuators`"
        help = "a spec begins with `actspec: 1`; `validate --skip-other` passes over files that are none"
        raise SpecError.of("SPEC104", f"this is no spec: {what}", root.span, help=help)
    digest = hashlib.sha256(data)
    names: list[str] = []
    merged = Node(root.span, {key: entry for key, entry in root.value.items() if key != "include"})
    if "include" in root.value:
        read = {os.path.realpath(path)}
        for index, (name, span) in enumerate(included_names(root.value["include"][1], collector)):
            place = path_inside(name, base, collector.at(f"include[{index}]", span), INCLUDE)
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
            at = collector.at(f"include[{index}]", span)
            if part is not None and check_included(part, at, name, collector):
                merge(merged, part, collector)
    if variant is not None:
        own = merged
        merged = chosen(own, variant, path, collector)
        if merged is own:
            variant = None
        else:
            digest.update(b"\0#" + variant.encode("utf-8", "surrogateescape"))
    collector.raise_if_failed(SpecError)
    plain = _plain(merged)
    assert isinstance(plain, dict)
    return Document(path, plain, SourceMap(merged), digest.hexdigest(), tuple(names), variant)


def _is_other(top: Iterable[str]) -> bool:
    """Whether a file with these keys at its top is neither a spec that lacks some, nor a part of one."""
    keys = list(islice(top, 100))
    return not {*keys} <= {*INCLUDED_KEYS} and not any(nearest(key.lower(), _SPEC_KEYS) for key in keys)


_SPEC_KEYS = ("actspec", "actuators")
"""Keys that other files do not have."""


def _plain(node: Node) -> Any:
    """Plain data, each alias a copy of its own; the depth was bounded before."""
    held = node.value
    if isinstance(held, dict):
        return {key: _plain(value) for key, (_, value) in held.items()}
    if isinstance(held, list):
        return [_plain(item) for item in held]
    return held


MAX_INCLUDES = 64
"""Most included files. Chosen: one a motor, with room."""
INCLUDED_KEYS = ("motors", "sources")
"""What an included file may hold."""

_SECTIONS = ("robot", "timing", "actuators", "targets")
"""Sections that only a spec has; one alone in an included file was put into the wrong file."""

_URL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+://.*|file:.*", re.S)
_DRIVE = re.compile(r"[A-Za-z]:.*", re.S)


def included_names(node: Node, collector: Collector) -> list[tuple[str, Span]]:
    """The names under `include`, all of them checked to be text."""
    if not isinstance(node.value, list):
        text = node.value if isinstance(node.value, str) else "motors.yaml"
        help = f"write `include: [{cut(text)}]`"
        collector.error("SPEC012", "must be a list of file names", where="include", span=node.span, help=help)
        return []
    if len(node.value) > MAX_INCLUDES:
        message = f"{len(node.value)} files are included, at most {MAX_INCLUDES} are read"
        help = "put the motors into fewer files"
        collector.error("SPEC012", message, where="include", span=node.span, help=help)
        return []
    names = []
    for index, item in enumerate(node.value):
        if isinstance(item.value, str) and item.value:
            names.append((item.value, item.span))
        else:
            message = "must be a file name, as text"
            collector.error("SPEC012", message, where=f"include[{index}]", span=item.span)
    return names if len(names) == len(node.value) else []


INCLUDE = "an include is a relative path inside the folder of the spec, such as motors/unitree.yaml"


def path_inside(name: str, base: str | None, place: Place, help: str) -> tuple[str, str] | None:
    """The path for messages and the real path of a file that a spec names, if that is inside the folder of the spec.

    Args:
        name: As written.
        base: The folder; None: the spec has none.
        place: Gets the error.
        help: What may stand there.
    """
    problem = None
    real = ""
    if base is None:
        problem = "a text without a folder cannot include files"
    elif _URL.fullmatch(name):
        problem = "is a URL, and only files are read"
    elif name.startswith(("/", "\\")) or _DRIVE.fullmatch(name):
        problem = "is an absolute path"
    elif "\\" in name:
        problem = "has a backslash; folders are separated by `/`"
    elif is_imported(name):
        problem = "has a name that Python imports"
    elif _climbs(name):
        problem = "leaves the folder of the spec by `..`"
    else:
        root = os.path.realpath(base)
        real = os.path.realpath(os.path.join(root, name))
        if real != root and not leads_into(real, [root]):
            problem = "leaves the folder of the spec by a symbolic link"
    if problem is None:
        return os.path.normpath(os.path.join(base or "", name)), real
    place.error("SPEC013", f"'{cut(name)}' {problem}" if base is not None else problem, help)
    return None


def _climbs(name: str) -> bool:
    depth = 0
    for part in name.split("/"):
        depth += -1 if part == ".." else part not in ("", ".")
        if depth < 0:
            return True
    return False


def check_included(root: Node, place: Place, name: str, collector: Collector) -> bool:
    """An included file holds motors and sources by name, and nothing else.

    Args:
        root: The file.
        place: The include; gets the error of a whole spec.
        name: The file, as the include names it.
        collector: Gets the error of each other key.

    Returns: Whether it is no whole spec, so that its motors and sources may be added.
    """
    assert isinstance(root.value, dict)
    sections = [key for key in root.value if key in _SECTIONS]
    if len(sections) > 1:
        keys = ", ".join(f"`{key}`" for key in sections)
        message = (
            f"'{cut(name)}' is a whole spec, with {keys}; an included file holds `motors` and `sources` only"
        )
        place.error("SPEC014", message, "put its `motors` into a file of their own, and include that in both")
        return False
    for key, (span, node) in root.value.items():
        if key == "include":
            message = "an included file cannot include another"
            collector.error("SPEC014", message, where=key, span=span, help="include both files in the spec")
        elif key not in INCLUDED_KEYS:
            message = f"an included file cannot hold '{cut(key)}', only `motors` and `sources`"
            help = did_you_mean(key, INCLUDED_KEYS, "move it into the spec")
            collector.error("SPEC014", message, where=cut(key), span=span, help=help)
        elif not isinstance(node.value, dict) and node.value is not None:
            collector.error("SPEC014", f"`{key}` must be a mapping of names", where=key, span=node.span)
    return True


def merge(into: Node, part: Node, collector: Collector) -> None:
    """Add an included file's motors and sources; a name that is there already is an error."""
    assert isinstance(into.value, dict) and isinstance(part.value, dict)
    for section in INCLUDED_KEYS:
        if section not in part.value:
            continue
        key_span, added = part.value[section]
        own_span, own = into.value.get(section, (key_span, Node(added.span, None)))
        if not isinstance(added.value, dict) or not (own.value is None or isinstance(own.value, dict)):
            continue
        names = dict(own.value or {})
        for name, entry in added.value.items():
            if name in names:
                collector.error(
                    "SPEC015",
                    f"'{cut(name)}' is defined twice, first at {names[name][0]}",
                    where=f"{section}.{cut(name)}",
                    span=entry[0],
                    help="rename one of the two, or remove it",
                )
            else:
                names[name] = entry
        into.value[section] = (own_span, Node(own.span, names))
