"""Layers of USD's text form (`.usda`), as far as overlays of a robot's stage go, read by `usd-core`.

One layer is read as it stands, and no stage is made of it: references, payloads, sublayers and inherits are not
followed, and no other file is opened. Variants, time samples and connections are refused. USD crashes on
text that is nested deeply enough, so it reads in another process.
Source: usd-core 26.11.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

from actspec.diagnostics import Diagnostic, RobotError, Severity, Span, one_line, shortened
from actspec.files import place_of
from actspec.libraries import extra_line
from actspec.processes import IsolatedCall, LostError

MAX_BYTES = 1024 * 1024
"""Largest layer. Chosen: an overlay of 40 joints has 40 kB; meshes are in other layers."""
TIME_LIMIT = 20.0
"""Chosen: seconds for one layer; one of 40 joints takes 0.4 s, USD's import included."""

SYNTAX = "USDA001"
"""The text is not of the form."""
NOT_READ = "USDA002"
"""USD has a meaning for it that is not read here."""
LOST = "USDA003"
"""It is too large, or USD breaks off on it."""
MISSING = "USDA004"
"""`usd-core` is not installed."""

NUMERIC = ("float", "double", "half", "timecode", "int", "int64", "uint", "uint64", "uchar")
"""Types of one number."""


@dataclass(frozen=True, slots=True)
class Asset:
    """A file that an attribute names, as written."""

    path: str


Value = float | int | bool | str | Asset | tuple["Value", ...] | None


@dataclass(frozen=True, slots=True)
class UsdaAttribute:
    """An attribute or relationship of a prim.

    Attributes:
        type: `float`, `token[]`, ...; `rel` of a relationship.
        name: With its namespaces, `newton:kp`.
        value: Arrays and tuples as a tuple, of a relationship its paths as texts; None: it has none, or is blocked.
            Numbers of single precision have the fewest digits that stand for them.
        span: Where it is written.
    """

    type: str
    name: str
    value: Value
    span: Span


@dataclass(frozen=True, slots=True)
class UsdaPrim:
    """A prim as far as one layer has it.

    Attributes:
        path: `/World/Robot`.
        specifier: `def`, `over` or `class`.
        type: `NewtonActuator`, ...; "" where the layer does not say.
        apis: API schemas that the layer applies, the strongest first.
        attributes: By name.
        active: False: the layer switches it off, or a prim above it.
        span: Where it is written.
    """

    path: str
    specifier: str
    type: str
    apis: tuple[str, ...]
    attributes: Mapping[str, UsdaAttribute]
    active: bool
    span: Span

    @property
    def name(self) -> str:
        """The last name of its path."""
        return self.path.rpartition("/")[2]


@dataclass(frozen=True, slots=True)
class UsdaLayer:
    """One file.

    Attributes:
        path: The file as the user named it.
        prims: By path, in the file's order.
    """

    path: str
    prims: Mapping[str, UsdaPrim]


def read_usda(data: bytes, path: str) -> UsdaLayer:
    """Read a layer, in another process.

    Args:
        data: The file.
        path: Its name, for places.

    Raises: RobotError: `usd-core` is not installed; the file is no layer in text form, has something that is not
        read, or USD breaks off on it.
    """
    if find_spec("pxr") is None:
        message = "a .usda layer is read with usd-core, which is not installed"
        raise _refusal(MISSING, message, Span(path), extra_line("usd"))
    if len(data) > MAX_BYTES:
        raise _refusal(LOST, f"the layer has {len(data)} bytes, more than {MAX_BYTES}", Span(path))
    with IsolatedCall(_read, TIME_LIMIT, "USD") as call:
        try:
            found = call(data, path)
        except LostError as err:
            raise _refusal(LOST, str(err), Span(path)) from err
    if isinstance(found, Diagnostic):
        raise RobotError([found])
    return found


def _read(data: bytes, path: str) -> UsdaLayer | Diagnostic:
    """In the other process, whose warnings nobody wants."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    try:
        return layer_of(data, path)
    except RobotError as err:
        return err.diagnostics[0]


def layer_of(data: bytes, path: str) -> UsdaLayer:
    """Read a layer that nobody hostile has written, in this process.

    Raises: RobotError: as `read_usda`.
    """
    from pxr import Sdf, Tf

    if not data.startswith(b"#usda "):
        binary = data.startswith((b"PXR-USDC", b"PK\x03\x04"))
        message = "a layer in text form begins with '#usda 1.0'" + (
            ", and this one is binary" if binary else ""
        )
        raise _refusal(
            SYNTAX, message, Span(path, 1, 1), "usdcat -o FILE.usda writes it as text" if binary else None
        )
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as err:
        message = f"the file is not UTF-8: byte 0x{data[err.start]:02x}"
        raise _refusal(SYNTAX, message, Span(path, *place_of(data, err.start))) from err
    # Anonymous: it has no folder from which another file could be named.
    layer = Sdf.Layer.CreateAnonymous(".usda")
    try:
        layer.ImportFromString(text)
    except Tf.ErrorException as err:
        raise _syntax(str(err), text, path) from err
    places = dict(_places(text, path))
    prims: dict[str, UsdaPrim] = {}
    stack = [(spec, True) for spec in reversed(list(layer.rootPrims))]
    while stack:
        spec, on = stack.pop()
        prim = _prim(spec, on, path, places)
        prims[prim.path] = prim
        stack += [(child, prim.active) for child in reversed(list(spec.nameChildren))]
    return UsdaLayer(path, prims)


def _prim(spec: Any, on: bool, path: str, places: Mapping[tuple[str, str], Span]) -> UsdaPrim:
    from pxr import Sdf

    where = str(spec.path)
    if spec.variantSets:
        message = f"{shortened(where)} has a variantSet, which is not read"
        raise _refusal(NOT_READ, message, places.get((where, ""), Span(path)))
    attributes = {}
    for item in spec.attributes:
        span = places.get((where, item.name), Span(path))
        for key, word in (
            ("timeSamples", "timeSamples"),
            ("connectionPaths", "connect"),
            ("spline", "spline"),
        ):
            if item.HasInfo(key):
                message = f"{word} of {shortened(item.name)}, and only plain values are read"
                raise _refusal(NOT_READ, message, span)
        kind = str(item.typeName)
        attributes[item.name] = UsdaAttribute(kind, item.name, _value(item.default, kind), span)
    for item in spec.relationships:
        targets = item.GetInfo("targetPaths").ApplyOperations([]) if item.HasInfo("targetPaths") else []
        span = places.get((where, item.name), Span(path))
        attributes[item.name] = UsdaAttribute("rel", item.name, tuple(map(str, targets)), span)
    apis = spec.GetInfo("apiSchemas").ApplyOperations([]) if spec.HasInfo("apiSchemas") else ()
    word = {Sdf.SpecifierDef: "def", Sdf.SpecifierOver: "over"}.get(spec.specifier, "class")
    span = places.get((where, ""), Span(path))
    return UsdaPrim(where, word, spec.typeName, tuple(apis), attributes, bool(spec.active) and on, span)


def _value(value: Any, kind: str) -> Value:
    import numpy as np
    from pxr import Sdf

    if value is None or isinstance(value, Sdf.ValueBlock):
        return None
    if isinstance(value, Sdf.AssetPath):
        return Asset(value.path)
    if isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        single = np.float16 if kind.startswith("half") else np.float32
        return value if kind.startswith(("double", "timecode")) else float(str(single(value)))
    try:
        return tuple(_value(item, kind) for item in value)
    except TypeError:  # a quaternion, a time code
        return str(value)


_TOKEN = re.compile(
    r'''"""(?:\\.|[^\\])*?"""|\'\'\'(?:\\.|[^\\])*?\'\'\'|"(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*\''''
    r"|@@@.*?@@@|@[^@\n]*@|<[^>\n]*>|(?:#|//)[^\n]*|/\*.*?\*/|\w[\w:.]*|[^\S\n]+|.",
    re.DOTALL,
)


def _places(text: str, path: str) -> Iterator[tuple[tuple[str, str], Span]]:
    """Where the statements of a layer that USD has taken begin: of (prim, attribute), and of (prim, "")."""
    prims = [""]
    coming, inside, line, begin = "", 0, 1, 0
    words: list[tuple[str, Span]] = []
    for match in _TOKEN.finditer(text):
        token = match[0]
        if token in "([":
            inside += 1
        elif token in ")]":
            inside -= 1
        elif not inside:
            if token == "{":
                prims.append(coming)
            elif token == "}":
                prims.pop()
            elif re.match(r"\w", token):
                words.append((token, Span(path, line, match.start() - begin + 1)))
            elif token[0] in "\"'" and words and words[0][0] in ("def", "over", "class"):
                coming = f"{prims[-1]}/{token[1:-1]}"
                yield (coming, ""), words[0][1]
                words = []
            elif token == "=" and words:
                yield (prims[-1], words[-1][0].partition(".")[0]), words[0][1]
                words = []
            elif token in "\n;":
                words = []
        if "\n" in token:
            line += token.count("\n")
            begin = match.start() + token.rindex("\n") + 1


_PLACED = re.compile(r":(\d{1,7}):(\d{1,7}): ")


def _syntax(error: str, text: str, path: str) -> RobotError:
    """What USD says against a layer: its own words, and the place that they name or show."""
    texts = re.split(r"Error in '[^']*' at line \d+ in file \S+ : '", error)[1:] or [error]
    first = re.sub(r"\s*'\s*\Z", "", texts[0])
    placed = _PLACED.match(first)
    reason = one_line(first[placed.end() :] if placed else first).partition(" in </")[0]
    span = Span(path)
    shown = reason.rpartition(" at '")[2].removesuffix("'").strip()
    control = re.search(r"control character 0x([0-9a-f]{2})\b", reason)
    # What it says first often has its place only where it is said again.
    if place := next((found for found in map(_PLACED.match, texts) if found), None):
        span = Span(path, int(place[1]), int(place[2]))
    elif shown and text.count(shown) == 1:
        span = _at(text, text.index(shown), path)
    elif control and (letter := chr(int(control[1], 16))) in text:
        span = _at(text, text.index(letter), path)
    # Names of its grammar's templates say nothing to anybody.
    reason = re.sub(r"pxrInternal[^',]*::|, pxrInternal.*?(?= at ')", "", reason)
    return _refusal(SYNTAX, f"USD refuses the layer: {shortened(reason, 200)}", span)


def _at(text: str, index: int, path: str) -> Span:
    return Span(path, text.count("\n", 0, index) + 1, index - text.rfind("\n", 0, index))


def _refusal(code: str, message: str, span: Span, help: str | None = None) -> RobotError:
    return RobotError([Diagnostic(code, Severity.ERROR, message, "", span, help)])
