"""The layout of a spec: what stands at another indentation, below another key or with another mark than it was meant.

One mistake of layout makes many errors further on, none of which names it. So these are found first, and alone.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, is_dataclass
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel

from actspec.diagnostics import Path, listed, nearest
from actspec.spec.gears import Linkage
from actspec.spec.models import Actuators, Motor, Source, SpecModel, Target
from actspec.spec.values import VALUE_KEYS, short

_NAMED: dict[str, tuple[type[BaseModel], str]] = {
    "actuators": (Actuators, "group"),
    "motors": (Motor, "motor"),
    "sources": (Source, "source"),
    "linkages": (Linkage, "linkage"),
    "targets": (Target, "target"),
}
"""Sections that hold things by name: what these are, and the word for one."""
_IN_A_VALUE = frozenset((*VALUE_KEYS, "derive", "nominal", "range", "sampling"))
"""Keys below a field that holds a number, derived gains and delays among them."""

_NO_SPACE = re.compile(r"([A-Za-z_][A-Za-z_0-9-]*):(\S.*)", re.DOTALL)
_NO_COLON = re.compile(r"([A-Za-z_][A-Za-z_0-9.-]*)\s+([\[{].*)", re.DOTALL)
_NO_COLON_IN_BRACES = re.compile(r"([A-Za-z_][A-Za-z_0-9.-]*)\s+([-+.]?\d.*)", re.DOTALL)
_TEXTS = ("title", "note", "page")
"""Keys of texts that are read by people."""
_NUMBER = re.compile(r"[-+.]?\d.*", re.DOTALL)
_DIGITS = re.compile(r"[0-9]+(?:\s*[A-Za-z%°µ].*)?", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Misplaced:
    """One mistake of layout.

    Attributes:
        message: What is wrong.
        path: Where.
        help: What to write.
        key: Whether it is the key at `path`, not its value.
        code: Of the diagnostic.
    """

    message: str
    path: Path
    help: str
    key: bool = True
    code: str = "SPEC107"


def misplaced(data: Mapping[str, Any]) -> tuple[Misplaced, ...]:
    """Mistakes of layout, each once.

    Args:
        data: The document.
    """
    return (*_sections(data), *_at_the_edge(data), *_dedented(data, ()), *_cut_apart(data, ()))


def misspelt(data: Mapping[str, Any], more: Iterable[str]) -> tuple[tuple[str, str], ...]:
    """Sections under a name that is nearly theirs, such as `motor:`, and the name that is.

    Args:
        data: The document.
        more: Sections that are there already, and to which others may be added.
    """
    # Of a file that is no spec nothing is meant.
    tops = fields_of(SpecModel) if "actspec" in data else frozenset(("actspec",))
    found = []
    for key, value in data.items():
        meant = None if key in tops else nearest(key.lower(), sorted(tops - (data.keys() - {*more})))
        if meant is not None and isinstance(value, int if meant == "actspec" else Mapping):
            found.append((key, meant))
    return tuple(found)


def _sections(data: Mapping[str, Any]) -> Iterator[Misplaced]:
    tops = fields_of(SpecModel)
    for section, (model, word) in _NAMED.items():
        held = data.get(section)
        if isinstance(held, list) and held and all(isinstance(item, Mapping) for item in held):
            yield from _dashed(held, section, word)
        if not isinstance(held, Mapping):
            continue
        own = fields_of(model)
        lost = next((name for name in held if name in tops and not _is_entry(held[name], own)), None)
        if lost is not None:
            yield _indented(lost, (section, lost))
        else:
            yield from _beside(held, section, own, word)
    if isinstance(data.get("variant"), Mapping) and "variants" not in data:
        message = "`variant` names the variant that the spec itself is, and this holds variants"
        yield Misplaced(message, ("variant",), "write `variants:`")
    for section in ("robot", "timing", "accept"):
        held = data.get(section)
        if isinstance(held, Mapping):
            own = fields_of(model_at(SpecModel, (section,)))
            for name in held:
                if name in tops and name not in own:
                    yield _indented(name, (section, name))


def _at_the_edge(data: Mapping[str, Any]) -> Iterator[Misplaced]:
    """Groups, motors and so on that stand beside their section, which holds others."""
    tops = fields_of(SpecModel)
    for key, value in data.items():
        if key in tops or not isinstance(value, Mapping) or not value:
            continue
        of = [name for name, (model, _) in _NAMED.items() if not value.keys() - fields_of(model)]
        if len(of) == 1 and isinstance(data.get(of[0]), Mapping):
            word = _NAMED[of[0]][1]
            message = (
                f"`{short(key)}` stands at the left edge, and by what it holds it is a {word} of `{of[0]}`"
            )
            yield Misplaced(
                message, (key,), f"indent it, and what is below it, as the other {word}s of `{of[0]}`"
            )


def fields_of(model: type[BaseModel] | None) -> frozenset[str]:
    """Keys of a model as a spec writes them; of None none."""
    return frozenset(_annotations(model)) if model is not None else frozenset()


def model_at(root: type[BaseModel], path: Path) -> type[BaseModel] | None:
    """The model that describes the mapping at `path`."""
    node: Any = root
    for part in path:
        node = _unwrapped(node)
        if _is_model(node):
            node = _annotations(node).get(str(part))
        elif get_origin(node) in (dict, list, tuple):
            arguments = get_args(node)
            node = arguments[1] if get_origin(node) is dict else arguments[0]
        else:
            return None
    node = _unwrapped(node)
    return node if _is_model(node) else None


def _annotations(model: type[BaseModel]) -> dict[str, Any]:
    return {info.alias or name: info.annotation for name, info in model.model_fields.items()}


def _is_model(node: Any) -> bool:
    return isinstance(node, type) and issubclass(node, BaseModel)


def _unwrapped(node: Any) -> Any:
    """The annotation without Annotated and Optional; of a union, its first model."""
    while hasattr(node, "__metadata__"):
        node = node.__origin__
    if get_origin(node) is None or get_origin(node) in (dict, list, tuple, Literal):
        return node
    arguments = [_unwrapped(part) for part in get_args(node) if part is not type(None)]
    models = [part for part in arguments if _is_model(part)]
    nested = [part for part in arguments if get_origin(part) is not None]
    return (models or nested or arguments or [node])[0]


def _indented(name: str, path: Path) -> Misplaced:
    message = f"`{name}` is a section of the spec, and by its indentation it is a part of `{path[0]}`"
    return Misplaced(message, path, f"move `{name}:` to the left edge, and what is below it with it")


def _dedented(node: Any, path: Path) -> Iterator[Misplaced]:
    """Names that stand beside the key that they belong below, which is empty."""
    if isinstance(node, Mapping):
        model = model_at(SpecModel, path) if None in node.values() else None
        if model is not None:
            yield from _behind_an_empty_key(node, path, model)
    entries = node.items() if isinstance(node, Mapping) else enumerate(node)
    for key, value in entries:
        if isinstance(value, (Mapping, list)):
            yield from _dedented(value, (*path, key))


def _behind_an_empty_key(node: Mapping[str, Any], path: Path, model: type[BaseModel]) -> Iterator[Misplaced]:
    own = _annotations(model)
    behind: dict[str, list[str]] = {}
    owner = None
    for key, value in node.items():
        if key in own:
            owner = key if value is None else None
        elif owner is not None and _belongs(key, value, _unwrapped(own[owner]), own):
            behind.setdefault(owner, []).append(key)
    for owner, found in behind.items():
        names, one = listed([f"`{short(name)}`" for name in found]), len(found) == 1
        stand = f"{names} stand{'s' * one}"
        if path:
            message = f"{stand} beside `{owner}`, which is empty, and belong{'s' * one} below it"
            help = f"indent {'it' if one else 'them'} below `{owner}:`"
        else:
            message = f"{stand} at the left edge, and `{owner}` above is empty"
            help = f"indent what belongs to `{owner}` by two spaces"
        yield Misplaced(message, (*path, found[0]), help)


def _belongs(key: str, value: Any, held: Any, beside: Iterable[str]) -> bool:
    """Whether a key that is unknown where it stands is one of what a field holds, by the field's annotation."""
    if get_origin(held) is not dict:
        return key in fields_of(held) if _is_model(held) else is_dataclass(held) and key in _IN_A_VALUE
    name, part = map(_unwrapped, get_args(held))
    if get_origin(name) is Literal:
        return key in get_args(name)
    return (isinstance(value, Mapping) or not _is_model(part)) and nearest(key, sorted(beside)) is None


def _beside(held: Mapping[str, Any], section: str, fields: frozenset[str], word: str) -> Iterator[Misplaced]:
    """Fields of a group, motor or source that stand where its name should."""
    stray = [key for key, value in held.items() if key in fields and not _is_entry(value, fields)]
    owner = next((key for key, value in held.items() if value is None and key not in fields), None)
    if len(stray) < (1 if owner is not None else 2):
        return
    names = listed([f"`{key}`" for key in stray], 4)
    if owner is not None:
        they = "it is a field" if len(stray) == 1 else "they are fields"
        message = (
            f"{names} stand{'s' * (len(stray) == 1)} beside `{owner}`, which is empty: {they} of that {word}"
        )
        help = f"indent {'it' if len(stray) == 1 else 'them'} below `{owner}:`"
    else:
        message = f"{names} are fields of a {word}, and `{section}` holds {word}s by name"
        name = "such as `legs:`, " if word == "group" else ""
        help = f"write a name above them, {name}and indent them below it"
    yield Misplaced(message, (section, stray[0]), help)


def _is_entry(value: Any, fields: frozenset[str]) -> bool:
    """Whether a value may be a group, motor or source that is called as a field is."""
    return isinstance(value, Mapping) and bool(fields & value.keys())


def _dashed(held: list[Any], section: str, word: str) -> Iterator[Misplaced]:
    """A list of groups, motors or sources, which are a mapping by name."""
    named = next((item["name"] for item in held if isinstance(item, Mapping) and item.get("name")), None)
    alone = next((key for item in held if isinstance(item, Mapping) for key in item), word)
    name = short(named if isinstance(named, str) else alone)
    yield Misplaced(
        f"`{section}` is a list (`- `), and must hold each {word} by its name",
        (section,),
        f"write `{name}:` without `- `, and its fields indented below it",
        key=True,
    )


def _cut_apart(node: Any, path: Path) -> Iterator[Misplaced]:
    """Values in [ ] and { } that a comma inside a number, or a colon without a space, has cut apart."""
    if isinstance(node, Mapping):
        last: tuple[str, Any] | None = None
        for key, value in node.items():
            space = _NO_SPACE.fullmatch(key) if value is None else None
            bracket = _NO_COLON.fullmatch(key)
            lacks = _NO_COLON_IN_BRACES.fullmatch(key) if value is None else None
            if value is None and last is not None and _is_whole(last[1]) and _DIGITS.fullmatch(key):
                yield _comma(f"{last[1]},{key}", f"{last[1]}.{key}", (*path, last[0]))
            elif value is None and last is not None and last[0] in _TEXTS and _is_text_on(last[1], key):
                message = f"the comma behind `{short(last[1])}` ends the text of `{last[0]}`"
                whole = short(f"{last[1]}, {key}".replace('"', "'"))
                yield Misplaced(message, (*path, key), f'quote it: write `{last[0]}: "{whole}"`')
            elif bracket is not None:
                rest = f"{bracket[1]}: {bracket[2]}: {value}"
                yield Misplaced(f"`{bracket[1]}` has no `:`", (*path, key), f"write `{short(rest)}`")
            elif lacks is not None:
                help = f"write `{lacks[1]}: {short(lacks[2])}`"
                yield Misplaced(f"`{lacks[1]}` has no `:`", (*path, key), help)
            elif value is None and last is None and _NUMBER.fullmatch(key) and _is_value(node):
                name = "nominal" if node.keys() & {"range", "sampling"} else "value"
                message = f"`{short(key)}` stands where a key must"
                yield Misplaced(message, (*path, key), f"write `{name}: {short(key)}`")
            elif space is not None:
                message = f"`{short(key)}` has no space behind its colon, and is one word"
                yield Misplaced(message, (*path, key), f"write `{space[1]}: {short(space[2])}`")
            else:
                yield from _cut_apart(value, (*path, key))
            last = key, value
    elif isinstance(node, list):
        pairs = list(itertools.pairwise(node))
        cut = [
            i
            for i, (a, b) in enumerate(pairs)
            if _is_whole(a) and isinstance(b, str) and _DIGITS.fullmatch(b)
        ]
        if cut and len(node) > 2:
            first, second = pairs[cut[0]]
            yield _comma(f"{first},{second}", f"{first}.{second}", (*path, cut[0]))
        else:
            for index, item in enumerate(node):
                yield from _cut_apart(item, (*path, index))


def _is_text_on(text: Any, rest: str) -> bool:
    """Whether what stands behind a text and a comma is the rest of it, and no key with its value."""
    first = next(iter(rest.split()), "")
    return isinstance(text, str) and first.partition(":")[0] not in _IN_A_VALUE | fields_of(Source)


def _is_value(node: Mapping[str, Any]) -> bool:
    """Whether a mapping has a key of those that stand beside a number, and not the number's own."""
    return bool(node.keys() & _IN_A_VALUE) and not node.keys() & {"value", "nominal"}


def _is_whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _comma(given: str, meant: str, path: Path) -> Misplaced:
    message = f"{short(given)}: a comma inside a number, which ends it in [ ] and {{ }}"
    return Misplaced(
        message, path, f"decimals have a point (`{short(meant)}`), thousands no mark", False, "SPEC110"
    )
