"""The spec's text: strict YAML to plain data, with the place of every key and value.

YAML 1.2 core meaning, which PyYAML's own loaders do not give (`on` is a word, `010` is ten,
`1e-3` is a number). Built from parser events, so that a hostile file is stopped at its first
excess: nothing is constructed that was not counted before.
"""

from __future__ import annotations

import hashlib
import os
import re
import stat
import sys
from dataclasses import dataclass
from typing import Any

from actspec.diagnostics import Collector, Span, SpecError, listed, nearest, one_line

MAX_BYTES = 1024 * 1024
"""Largest file [bytes]. Chosen: a hand-written spec has a few kilobytes."""
MAX_DEPTH = 40
"""Deepest nesting of collections. Chosen: the language needs 7."""
MAX_NODES = 100_000
"""Most values and keys of a file, aliases expanded. Chosen: a spec of 100 joints has about 5000."""
MAX_ALIASES = 100
"""Most aliases in a file. Chosen: far above any spec written by hand."""
MAX_INCLUDES = 64
"""Most included files. Chosen: one a motor, with room."""
MAX_ERRORS = 50
"""Errors told about one file before reading stops."""
INCLUDED_KEYS = ("motors", "sources")
"""What an included file may hold."""

YamlPath = tuple[str | int, ...]
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
_BREAK = re.compile(r"\r\n|\r|\n")
_FORBIDDEN = re.compile(
    "[^\t\n\r\x20-\x7e\xa0-\u2027\u202a-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]"
)
_NOT_IN_VALUE = re.compile("[\0\ud800-\udfff]")
_TAG_PREFIX = "tag:yaml.org,2002:"
_URL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+://.*|file:.*", re.S)
_DRIVE = re.compile(r"[A-Za-z]:.*", re.S)


class _Node:
    """One value: where it is, what it holds, and how large it is with its aliases expanded."""

    __slots__ = ("height", "size", "span", "value")

    def __init__(self, span: Span, value: Scalar | dict[str, tuple[Span, _Node]] | list[_Node]) -> None:
        self.span = span
        self.value = value
        self.size = 1
        self.height = 0


class SourceMap:
    """Where each key and value of a document is written.

    A path is a tuple of keys and indices. Components that have no node (a discriminator tag of
    a pydantic location, a missing key) are passed over, so the answer is the nearest place.
    """

    __slots__ = ("_root",)

    def __init__(self, root: _Node) -> None:
        self._root = root

    def value(self, path: YamlPath) -> Span:
        """Place of the value at `path`; an alias is where it stands, what is inside it at its anchor."""
        return self._find(path)[1]

    def key(self, path: YamlPath) -> Span:
        """Place of the key at `path`; for an item of a list, of the item."""
        return self._find(path)[0]

    def _find(self, path: YamlPath) -> tuple[Span, Span]:
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
    data = _read_file(path, Span(path), collector)
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
        message, help, code = _too_large("the text", len(data))
        collector.error(code, message, span=Span(path), help=help)
        raise SpecError(collector.sorted())
    return _document(data, path, base, collector)


def _document(data: bytes | None, path: str, base: str | None, collector: Collector) -> Document:
    root = None if data is None else _parse(data, path, collector)
    if data is None or root is None:
        raise SpecError(collector.sorted())
    assert isinstance(root.value, dict)
    digest = hashlib.sha256(data)
    names: list[str] = []
    merged = _Node(root.span, {key: entry for key, entry in root.value.items() if key != "include"})
    if "include" in root.value:
        read = {os.path.realpath(path)}
        for index, (name, span) in enumerate(_included_names(root.value["include"][1], collector)):
            place = _inside(name, base, index, span, collector)
            if place is None:
                continue
            shown, real = place
            if real in read:
                collector.error(
                    "SPEC013",
                    f"'{_short(name)}' is included a second time",
                    where=f"include[{index}]",
                    span=span,
                    help="name each file once, and the spec itself not at all",
                )
                continue
            read.add(real)
            more = _read_file(shown, span, collector, real=real, where=f"include[{index}]")
            if more is None:
                continue
            # NUL is refused in every file and name, so it separates without ambiguity.
            digest.update(b"\0" + name.encode("utf-8", "surrogateescape") + b"\0" + more)
            names.append(name)
            part = _parse(more, shown, collector, included=True)
            if part is not None:
                _merge(merged, part, collector)
    collector.raise_if_failed(SpecError)
    plain = _plain(merged)
    assert isinstance(plain, dict)
    return Document(path, plain, SourceMap(merged), digest.hexdigest(), tuple(names))


def _plain(node: _Node) -> Any:
    """Plain data, each alias a copy of its own; the depth was bounded before."""
    held = node.value
    if isinstance(held, dict):
        return {key: _plain(value) for key, (_, value) in held.items()}
    if isinstance(held, list):
        return [_plain(item) for item in held]
    return held


# --- files ---------------------------------------------------------------------------------------


class _Unreadable(Exception):
    def __init__(self, message: str, help: str | None, code: str = "SPEC001") -> None:
        super().__init__(message)
        self.code = code
        self.message = message
        self.help = help


def _read_file(
    path: str, span: Span, collector: Collector, *, real: str | None = None, where: str = ""
) -> bytes | None:
    """The bytes of a file (`real`, called `path` in messages); None after an error at `span`."""
    try:
        return _bytes_of(real or path, path)
    except _Unreadable as err:
        collector.error(err.code, err.message, where=where, span=span, help=err.help)
    return None


def _bytes_of(real: str, path: str) -> bytes:
    shown = f"'{_short(path)}'"
    # Without O_NONBLOCK, opening a named pipe would wait for its writer for ever.
    flags = os.O_RDONLY
    for flag in ("O_NONBLOCK", "O_BINARY", "O_CLOEXEC"):
        flags |= getattr(os, flag, 0)
    try:
        if os.path.isdir(real):
            raise _Unreadable(f"{shown} is a folder", "name the YAML file in it")
        with open(os.open(real, flags), "rb") as file:
            info = os.fstat(file.fileno())
            if not stat.S_ISREG(info.st_mode):
                raise _Unreadable(f"{shown} is not a regular file", None)
            # The file may grow after fstat, so the read is bounded too.
            data = b"" if info.st_size > MAX_BYTES else file.read(MAX_BYTES + 1)
            size = max(info.st_size, len(data))
    except (FileNotFoundError, NotADirectoryError) as err:
        raise _Unreadable(f"there is no file {shown}", _nearby(path)) from err
    except PermissionError as err:
        raise _Unreadable(f"{shown} may not be read", "check its permissions") from err
    except (OSError, ValueError) as err:
        reason = getattr(err, "strerror", None) or str(err)
        raise _Unreadable(f"{shown} cannot be read: {reason}", None) from err
    if size > MAX_BYTES:
        raise _Unreadable(*_too_large(shown, size))
    return data


def _too_large(name: str, size: int) -> tuple[str, str, str]:
    return (
        f"{name} is too large, got {size} bytes, at most {MAX_BYTES} bytes are read",
        "a spec is written by hand; keep logs, tables and networks in files that it names",
        "SPEC002",
    )


def _nearby(path: str) -> str | None:
    """What there is in the folder of a missing file."""
    folder, name = os.path.split(path)
    try:
        with os.scandir(folder or os.curdir) as entries:
            found = sorted(e.name for e in entries if e.name.endswith((".yaml", ".yml")))
    except (OSError, ValueError):
        return f"there is no folder '{_short(folder)}' either" if folder else None
    guess = nearest(name, found)
    if guess is not None:
        return f"did you mean '{os.path.join(folder, guess)}'?"
    if found:
        return f"the folder has {listed(found)}"
    return "the folder has no .yaml file; `actspec init` writes one"


# --- includes ------------------------------------------------------------------------------------


def _included_names(node: _Node, collector: Collector) -> list[tuple[str, Span]]:
    """The names under `include`, all of them checked to be text."""
    if not isinstance(node.value, list):
        text = node.value if isinstance(node.value, str) else "motors.yaml"
        help = f"write `include: [{_short(text)}]`"
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


def _inside(
    name: str, base: str | None, index: int, span: Span, collector: Collector
) -> tuple[str, str] | None:
    """The include's path for messages and its real path, if that is inside the folder of the spec."""
    problem = None
    real = ""
    if base is None:
        problem = "a text without a folder cannot include files"
    elif _URL.fullmatch(name):
        problem = "is a URL; only files are included"
    elif name.startswith(("/", "\\")) or _DRIVE.fullmatch(name):
        problem = "is an absolute path"
    elif "\\" in name:
        problem = "has a backslash; folders are separated by `/`"
    elif _climbs(name):
        problem = "leaves the folder of the spec by `..`"
    else:
        root = os.path.realpath(base)
        real = os.path.realpath(os.path.join(root, name))
        if os.path.commonpath([root, real]) != root:
            problem = "leaves the folder of the spec by a symbolic link"
    if problem is None:
        return os.path.normpath(os.path.join(base or "", name)), real
    collector.error(
        "SPEC013",
        f"'{_short(name)}' {problem}" if base is not None else problem,
        where=f"include[{index}]",
        span=span,
        help="an include is a relative path inside the folder of the spec, such as motors/unitree.yaml",
    )
    return None


def _climbs(name: str) -> bool:
    depth = 0
    for part in name.split("/"):
        depth += -1 if part == ".." else part not in ("", ".")
        if depth < 0:
            return True
    return False


def _check_included(root: _Node, collector: Collector) -> None:
    """An included file holds motors and sources by name, and nothing else."""
    assert isinstance(root.value, dict)
    for key, (span, node) in root.value.items():
        if key == "include":
            message = "an included file cannot include another"
            collector.error("SPEC014", message, where=key, span=span, help="include both files in the spec")
        elif key not in INCLUDED_KEYS:
            message = f"an included file cannot hold '{_short(key)}', only `motors` and `sources`"
            collector.error("SPEC014", message, where=_short(key), span=span, help="move it into the spec")
        elif not isinstance(node.value, dict) and node.value is not None:
            collector.error("SPEC014", f"`{key}` must be a mapping of names", where=key, span=node.span)


def _merge(into: _Node, part: _Node, collector: Collector) -> None:
    """Add an included file's motors and sources; a name that is there already is an error."""
    assert isinstance(into.value, dict) and isinstance(part.value, dict)
    for section in INCLUDED_KEYS:
        if section not in part.value:
            continue
        key_span, added = part.value[section]
        own_span, own = into.value.get(section, (key_span, _Node(added.span, None)))
        if not isinstance(added.value, dict) or not (own.value is None or isinstance(own.value, dict)):
            continue
        names = dict(own.value or {})
        for name, entry in added.value.items():
            if name in names:
                collector.error(
                    "SPEC015",
                    f"'{_short(name)}' is defined twice, first at {names[name][0]}",
                    where=f"{section}.{_short(name)}",
                    span=entry[0],
                    help="rename one of the two, or remove it",
                )
            else:
                names[name] = entry
        into.value[section] = (own_span, _Node(own.span, names))


# --- text ----------------------------------------------------------------------------------------


class _Stop(Exception):
    """The text has no further meaning; what is wrong is in the collector."""


def _parse(data: bytes, path: str, collector: Collector, *, included: bool = False) -> _Node | None:
    """The tree of one file; None where it has none, with the reason in the collector."""
    try:
        root = _Builder(path, collector).build(_text(data, path, collector))
    except _Stop:
        return None
    if root is None or (root.value is None and root.height == 0 and root.size == 0):
        help = "write `motors:` or `sources:`" if included else "`actspec init` writes a first one"
        collector.error("SPEC005", "the file is empty", span=Span(path), help=help)
        return None
    if not isinstance(root.value, dict):
        kind = "a list" if isinstance(root.value, list) else f"the value {_got(root.value)}"
        help = "begin with `motors:` or `sources:`" if included else "begin with `actspec: 1`"
        collector.error("SPEC005", f"must be a mapping of keys, got {kind}", span=root.span, help=help)
        return None
    if included:
        _check_included(root, collector)
    return root


def _text(data: bytes, path: str, collector: Collector) -> str:
    """Decode, and refuse what PyYAML's two parsers or YAML's two versions read differently."""
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        message = "the file is UTF-16, not UTF-8"
        collector.error("SPEC003", message, span=Span(path, 1, 1), help="save it as UTF-8")
        raise _Stop
    data = data.removeprefix(b"\xef\xbb\xbf")
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as err:
        span = _place(data[: err.start].decode("utf-8"), path)
        message = f"the file is not UTF-8, got the byte 0x{data[err.start]:02x}"
        collector.error("SPEC003", message, span=span, help="save it as UTF-8")
        raise _Stop from None
    bad = _FORBIDDEN.search(text)
    if bad is not None:
        message = f"the character U+{ord(bad[0]):04X} is not allowed"
        help = f"remove it; inside double quotes it can be written as an escape, \\u{ord(bad[0]):04x}"
        collector.error(
            "SPEC003",
            message,
            span=_place(text[: bad.start()], path),
            help=help if ord(bad[0]) else "a text file has no NUL; is this another kind of file?",
        )
        raise _Stop
    if "\t" in text:
        _refuse_tab(text, path, collector)
    for number, line in enumerate(_BREAK.split(text), 1):
        if line.startswith("%"):
            if re.fullmatch(r"%YAML +1\.2 *(#.*)?", line):
                continue
            help = "remove it; the text is always read as YAML 1.2"
            message = f"the directive {_got(line)} is not allowed"
            collector.error("SPEC008", message, span=Span(path, number, 1), help=help)
            raise _Stop
        if line.strip() and not line.lstrip().startswith("#"):
            break
    return text


def _refuse_tab(text: str, path: str, collector: Collector) -> None:
    """Only comments may hold tabs: elsewhere their meaning differs from parser to parser."""
    for number, line in enumerate(_BREAK.split(text), 1):
        tab = line.find("\t")
        comment = re.search(r"(?:^|\s)#", line)
        if tab >= 0 and (comment is None or tab <= comment.start()):
            help = "use spaces; inside double quotes write \\t"
            collector.error("SPEC003", "a tab is not allowed", span=Span(path, number, tab + 1), help=help)
            raise _Stop


def _place(before: str, path: str) -> Span:
    lines = _BREAK.split(before)
    return Span(path, len(lines), len(lines[-1]) + 1)


class _Open:
    """A collection whose end has not come yet."""

    __slots__ = ("anchor", "key", "node", "waiting")

    def __init__(self, node: _Node, anchor: str | None) -> None:
        self.node = node
        self.anchor = anchor
        self.key: tuple[str, Span] | None = None
        """The key whose value comes next; None for one that was refused."""
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
        self.anchors: dict[str, _Node | None] = {}
        self.stack: list[_Open] = []
        self.root: _Node | None = None
        self.end = Span(path)

    def build(self, text: str) -> _Node | None:
        """The root; None for a text without a document."""
        import yaml

        self.end = _place(text, self.path)
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
        return self.root

    def at(self, mark: Any) -> Span:
        # libyaml puts the end of a text without a final line break on the line after the last.
        return min(Span(self.path, mark.line + 1, mark.column + 1), self.end)

    def span(self, event: Any) -> Span:
        return self.at(event.start_mark)

    def error(self, code: str, message: str, span: Span, help: str | None = None) -> None:
        self.errors += 1
        if self.errors > MAX_ERRORS:
            self.collector.error("SPEC019", f"more than {MAX_ERRORS} errors; reading stopped here", span=span)
            raise _Stop
        self.collector.error(code, message, where=self.where(), span=span, help=help)

    def fatal(self, code: str, message: str, span: Span, help: str | None = None) -> None:
        self.error(code, message, span, help)
        raise _Stop

    def where(self) -> str:
        """Path of the value that is being read."""
        text = ""
        for frame in self.stack:
            if isinstance(frame.node.value, list):
                text += f"[{len(frame.node.value)}]"
            elif frame.waiting and frame.key is not None:
                text += f".{_short(frame.key[0])}"
        return text.lstrip(".")

    def count(self, nodes: int, span: Span) -> None:
        self.nodes += nodes
        if self.nodes > MAX_NODES:
            message = f"the file has more than {MAX_NODES} values, aliases expanded"
            self.fatal("SPEC011", message, span, "keep tables and logs in files that the spec names")

    def open(self, event: Any, value: dict[str, tuple[Span, _Node]] | list[_Node], tag: str) -> None:
        span = self.span(event)
        self.count(1, span)
        if len(self.stack) >= MAX_DEPTH:
            self.fatal("SPEC011", f"nested more than {MAX_DEPTH} levels deep", span)
        if event.tag not in (None, _TAG_PREFIX + tag):
            self.tag(event.tag, span)
        if event.anchor is not None:
            self.anchors[event.anchor] = None
        node = _Node(span, value)
        node.height = 1
        self.stack.append(_Open(node, event.anchor))

    def close(self) -> None:
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
        if name not in self.anchors:
            guess = nearest(name, list(self.anchors))
            self.fatal(
                "SPEC010",
                f"the alias *{_short(name)} has no anchor &{_short(name)} above it",
                span,
                f"did you mean *{guess}?" if guess else f"a joint pattern must be quoted: '.*{_short(name)}'",
            )
        target = self.anchors[name]
        if target is None:
            message = f"the alias *{_short(name)} is recursive: it stands inside its own anchor"
            self.fatal("SPEC010", message, span, "write out what it should hold")
            return
        self.count(target.size, span)
        if len(self.stack) + target.height > MAX_DEPTH:
            self.fatal("SPEC011", f"nested more than {MAX_DEPTH} levels deep, aliases expanded", span)
        node = _Node(span, target.value)
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
        if event.tag is not None:
            value = self.tagged(event.tag, text, span)
        elif plain:
            value = self.finite(_core(text), text, span, is_key)
        node = _Node(span, value)
        if not self.stack and plain and text == "" and event.tag is None:
            node.size = 0
        if event.anchor is not None:
            self.anchors[event.anchor] = node
        self.add(node, plain=plain and event.tag is None)

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
            self.error("SPEC008", f"!!{kind} does not fit the text {_got(text)}", span, "remove the tag")
            return text
        return float(value) if kind == "float" and value is not None else value

    def finite(self, value: Scalar, text: str, span: Span, is_key: bool) -> Scalar:
        number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not is_key and number and not abs(value) <= sys.float_info.max:  # type: ignore[arg-type]
            help = "for a figure that nobody states write `unknown`; for a word, quote it"
            self.error("SPEC016", f"must be a finite number, got {_short(text)}", span, help)
        return value

    def tag(self, tag: str, span: Span) -> None:
        shown = "!!" + tag.removeprefix(_TAG_PREFIX) if tag.startswith(_TAG_PREFIX) else tag
        shown = shown if shown.startswith("!") else f"!<{shown}>"
        help = "remove it; a text that begins with ! must be quoted"
        self.error("SPEC008", f"the tag {_short(shown)} is not allowed", span, help)

    def add(self, node: _Node, *, plain: bool) -> None:
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
            if frame.key is not None:
                held[frame.key[0]] = (frame.key[1], node)
            frame.waiting = False

    def key(self, node: _Node, held: dict[str, tuple[Span, _Node]], plain: bool) -> tuple[str, Span] | None:
        """The key that a node is; None after an error."""
        key = node.value
        if not isinstance(key, str):
            if isinstance(key, (dict, list)):
                self.error("SPEC009", "a key must be a word, not a list or mapping", node.span, "quote it")
            else:
                kind = "nothing" if key is None else "a truth value" if isinstance(key, bool) else "a number"
                message = f"the key {_got(key)} reads as {kind}, and keys are text"
                help = "quote it, a joint pattern that looks like a number too"
                self.error("SPEC009", message, node.span, help)
            return None
        if key == "<<" and plain:
            help = "use `overrides` for the joints that differ, or a motor by name for what is shared"
            self.error("SPEC007", "the merge key << is not allowed", node.span, help)
            return None
        if key in held:
            message = f"the key '{_short(key)}' is repeated, first at {held[key][0]}"
            self.error("SPEC006", message, node.span, "keep one of the two")
            return None
        return key, node.span

    def syntax(self, err: Any, text: str) -> None:
        """Say in plain words what PyYAML found."""
        problem = str(getattr(err, "problem", None) or "")
        context = str(getattr(err, "context", None) or "")
        mark = getattr(err, "problem_mark", None) or getattr(err, "context_mark", None)
        message, help = _plain_problem(problem, context, text, mark)
        start = getattr(err, "context_mark", None)
        if start is not None and "end of stream" in problem:
            mark = start
        elif start is not None and "flow" in context:
            help = f"it begins at {self.at(start)}"
        span = Span(self.path) if mark is None else self.at(mark)
        self.stack.clear()
        self.fatal("SPEC004", message, span, help)


_QUOTE = "quote text that begins with one of [ ] { } * & ! | > % @ `"
_SINGLE = "put text with backslashes into single quotes"
_PROBLEMS: tuple[tuple[str, str, str | None], ...] = (
    (
        "mapping values are not allowed",
        "a `: ` is not expected here",
        "check the indentation, or quote the text",
    ),
    ("could not find expected ':'", "this key has no `:`", "write `key: value`; check the indentation"),
    (
        "unknown escape character",
        "this backslash begins no escape of double quotes",
        "put a pattern into single quotes, such as '\\d+'",
    ),
    ("invalid Unicode", "an escape in double quotes names no character", None),
    ("hexdecimal", "an escape in double quotes lacks digits", _SINGLE),
    ("hexadecimal", "an escape in double quotes lacks digits", _SINGLE),
    ("unexpected end of stream", "this quote is never closed", "close it"),
    ("node content", "a value is expected here", None),
    ("<document start>", "the text goes on after its end", "check the indentation; begin with `actspec: 1`"),
    ("',' or ']'", "a list in [ ] lacks a `,` or its `]`", None),
    ("',' or '}'", "a mapping in { } lacks a `,` or its `}`", None),
)


def _plain_problem(problem: str, context: str, text: str, mark: Any) -> tuple[str, str | None]:
    lines = _BREAK.split(text)
    at = ""
    if mark is not None and mark.line < len(lines):
        at = lines[mark.line][mark.column : mark.column + 1]
    if "cannot start any token" in problem:
        return f"a value cannot begin with {at or 'this character'}", _QUOTE
    if "alias" in context:
        help = "a joint pattern must be quoted: '.*_hip_joint'"
        return "`*` begins an alias here, and this is no alias", help
    if "anchor" in context:
        return "`&` begins an anchor here, and this is no anchor", "quote the text"
    for part, message, advice in _PROBLEMS:
        if part in problem:
            return message, advice
    if "block collection" in context:
        return "a list item must begin with `- ` at the indentation of its list", _QUOTE
    if "block mapping" in context:
        return "a key is expected here, at the indentation of its mapping", _QUOTE
    return f"not valid YAML: {problem or 'no reason given'}" + (f", {context}" if context else ""), None


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


def _got(value: object) -> str:
    """A value for a message: quoted if it is text."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return str(value).lower()
    return f"'{_short(value)}'" if isinstance(value, str) else _short(str(value))


def _short(text: str) -> str:
    text = one_line(text[:200])
    return text if len(text) <= 80 else text[:77] + "..."
