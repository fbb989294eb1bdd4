"""Where the keys and items of a TOML or JSON text are written, which their readers do not tell.

Both walks are for texts that have been parsed, and for messages alone: no value comes from here.
"""

from __future__ import annotations

import json
import re
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator

from actspec.diagnostics import Path, one_line, shortened
from actspec.files import place_of

Places = dict[Path, tuple[int, int]]
"""Keys and indices from the top, to line and column, from 1."""

_SPACE = re.compile(r"[ \t\n\r]*")
_DIGITS = re.compile(rb"[0-9]{4301}")
_DEEP = 100
"""Chosen: brackets within each other, of which the last is named where a parser gives up."""
_DECODER = json.JSONDecoder()
_TOML = re.compile(
    r'"""(?:[^\\]|\\.)*?"{3,5}|'
    + r"'''.*?'{3,5}"
    + r'|"(?:[^"\\]|\\.)*"|'
    + r"'[^']*'|#[^\n]*|\n|[{}\[\],=.]"
    r"|[^\s\"'{}\[\],=.#]+",
    re.DOTALL,
)
_BARE = re.compile(r"[A-Za-z0-9_-]+")


def json_places(text: str, wanted: Iterable[Path]) -> Places:
    """Where some keys and items of a JSON text stand; of a key that is there twice, the last."""
    found: Places = {}
    starts: dict[Path, int] = {}
    _walk_json(text, _space(text, 0), (), {*wanted}, starts)
    place_at = _places_in(text)
    for path, at in starts.items():
        found[path] = place_at(at)
    return found


def json_fault(data: bytes, fault: Exception) -> tuple[tuple[int, int], str]:
    """Where a text is no JSON, and why.

    Args:
        data: Its bytes.
        fault: What reading it ended in.
    """
    if isinstance(fault, UnicodeDecodeError):
        return place_of(data, fault.start), f"the byte 0x{data[fault.start]:02x}"
    if isinstance(fault, json.JSONDecodeError):
        return (fault.lineno, fault.colno), fault.msg[:1].lower() + fault.msg[1:]
    return _other_fault(data, fault)


def toml_fault(data: bytes, fault: Exception) -> tuple[tuple[int, int], str]:
    """Where a text of UTF-8 is no TOML, and why; as `json_fault`."""
    told = re.fullmatch(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", str(fault), re.DOTALL)
    if told is None:
        return _other_fault(data, fault)
    at = (int(told[2]), int(told[3])) if told[2] else place_of(data, max(len(data.rstrip()) - 1, 0))
    return at, one_line(told[1][:1].lower() + told[1][1:])


def _other_fault(data: bytes, fault: Exception) -> tuple[tuple[int, int], str]:
    """Of what Python's parsers say no place: nested too deeply, or a whole number of over 4300 digits."""
    if isinstance(fault, RecursionError):
        depth = 0
        for match in re.finditer(rb"[\[{]|[\]}]", data):
            depth += 1 if match[0] in b"[{" else -1
            if depth > _DEEP:
                return place_of(data, match.start()), "it is nested too deeply"
        return (0, 0), "it is nested too deeply"
    long = _DIGITS.search(data)
    if long is None:
        return (0, 0), one_line(str(fault))
    return place_of(data, long.start()), "a number has over 4300 digits"


def _walk_json(text: str, at: int, path: Path, wanted: set[Path], found: dict[Path, int]) -> int:
    """Look for paths in the value at a character; values that hold none are parsed at once. Gives its end."""
    kind, index = text[at : at + 1], 0
    if kind not in ("{", "["):
        return _DECODER.raw_decode(text, at)[1]
    deeper = {part[: len(path) + 1] for part in wanted if part[: len(path)] == path}
    at = _space(text, at + 1)
    while text[at] not in "}]":
        begin, key = at, index
        if kind == "{":
            key, at = _DECODER.raw_decode(text, at)
            at = _space(text, _space(text, at) + 1)  # :
        own = (*path, key)
        if own in wanted:
            found[own] = begin
        end = _walk_json(text, at, own, wanted, found) if own in deeper else _DECODER.raw_decode(text, at)[1]
        at = _space(text, end)
        index += 1
        if text[at] == ",":
            at = _space(text, at + 1)
    return at + 1


def _space(text: str, at: int) -> int:
    """The first character from here on that is no white space."""
    found = _SPACE.match(text, at)
    return at if found is None else found.end()


def toml_places(text: str) -> Places:
    """Where each key, table and item of a TOML text stands; of a table that several headers open, the first."""
    found: Places = {}
    place_at = _places_in(text)
    walk = _Toml([(match[0], match.start()) for match in _TOML.finditer(text)])
    for path, at in walk.document():
        found.setdefault(path, place_at(at))
    return found


def _places_in(text: str) -> Callable[[int], tuple[int, int]]:
    """Line and column of a character."""
    ends = [match.start() for match in re.finditer("\n", text)]

    def place_at(at: int) -> tuple[int, int]:
        line = bisect_right(ends, at - 1)
        return line + 1, at - (ends[line - 1] if line else -1)

    return place_at


class _Toml:
    """Walks the tokens of a TOML text."""

    def __init__(self, tokens: list[tuple[str, int]]) -> None:
        self.tokens = [token for token in tokens if not token[0].startswith("#")]
        self.at = 0
        self.counts: dict[Path, int] = {}

    def document(self) -> Iterator[tuple[Path, int]]:
        """Each path with the character that it begins at."""
        table: Path = ()
        while self.at < len(self.tokens):
            token, _ = self.tokens[self.at]
            if token == "\n":
                self.at += 1
            elif token == "[":
                several = self._next(1) == "["
                self.at += 2 if several else 1
                keys = [*self._keys()]
                self.at += 2 if several else 1
                table = ()
                for index, (key, at) in enumerate(keys):
                    table = (*table, key)
                    yield table, at
                    if several and index == len(keys) - 1:
                        self.counts[table] = self.counts.get(table, -1) + 1
                    if table in self.counts:
                        # What follows is of the last table of an array.
                        table = (*table, self.counts[table])
                        yield table, at
            else:
                yield from self._entry(table)

    def _entry(self, table: Path) -> Iterator[tuple[Path, int]]:
        """A key, dotted perhaps, with its value."""
        for key, at in self._keys():
            table = (*table, key)
            yield table, at
        self.at += 1  # =
        yield from self._value(table)

    def _value(self, path: Path) -> Iterator[tuple[Path, int]]:
        token = self._next(0)
        if token not in ("[", "{"):
            # Numbers and dates may hold dots: to the end of the value.
            while self._next(0) not in (",", "]", "}", "\n", ""):
                self.at += 1
            return
        self.at += 1
        index = 0
        while (inner := self._next(0)) not in ("]", "}", ""):
            if inner in (",", "\n"):
                self.at += 1
            elif token == "{":
                yield from self._entry(path)
            else:
                yield (*path, index), self.tokens[self.at][1]
                yield from self._value((*path, index))
                index += 1
        self.at += 1

    def _keys(self) -> Iterator[tuple[str, int]]:
        """The parts of a dotted key."""
        while True:
            token, at = self.tokens[self.at]
            yield _key(token), at
            self.at += 1
            if self._next(0) != ".":
                return
            self.at += 1

    def _next(self, ahead: int) -> str:
        at = self.at + ahead
        return self.tokens[at][0] if at < len(self.tokens) else ""


def _key(token: str) -> str:
    """A key as it is meant: bare, or a string."""
    if _BARE.fullmatch(token) or len(token) < 2:
        return token
    if token[0] == "'":
        return token[1:-1]
    eight = re.sub(r"\\U([0-9A-Fa-f]{8})", lambda found: chr(int(found[1], 16)), token)
    try:
        return str(json.loads(eight, strict=False))
    except ValueError:
        return token[1:-1]


def shown(path: Path) -> str:
    """A path as TOML writes it: `audit.per-file-ignores."*.py"`."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            safe = shortened(part)
            text += ("." if text else "") + (safe if _BARE.fullmatch(part) else f'"{safe}"')
    return text
