"""The layout of a spec: what stands at another indentation, below another key or with another mark than it was meant.

One mistake of layout makes many errors further on, none of which names it. So these are found first, and alone.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, is_dataclass, replace
from itertools import pairwise
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel

from actspec.diagnostics import Path, listed, many, nearest
from actspec.spec.document import Document
from actspec.spec.gears import Linkage
from actspec.spec.models import Actuators, Motor, Robot, Source, SpecModel, Target, Timing, Tunable
from actspec.spec.values import VALUE_KEYS, short
from actspec.units.explain import of_comma

_NAMED: dict[str, tuple[type[BaseModel], str]] = {
    "actuators": (Actuators, "group"),
    "motors": (Motor, "motor"),
    "sources": (Source, "source"),
    "linkages": (Linkage, "linkage"),
    "targets": (Target, "target"),
}
"""Sections that hold things by name: what these are, and the word for one."""
_FLAT: dict[str, type[BaseModel]] = {"robot": Robot, "timing": Timing}
"""Sections that hold their keys themselves."""
_GEARED = frozenset(("jacobian", "table", "factor"))
"""What a linkage has one of."""
_IN_A_VALUE = frozenset((*VALUE_KEYS, "derive", "nominal", "range", "sampling"))
"""Keys below a field that holds a number, derived gains and delays among them."""

_NO_SPACE = re.compile(r"([A-Za-z_][A-Za-z_0-9-]*):(\S.*)", re.DOTALL)
_NO_COLON = re.compile(r"([A-Za-z_][A-Za-z_0-9.-]*)\s+([\[{].*)", re.DOTALL)
_NO_COLON_IN_BRACES = re.compile(r"([A-Za-z_][A-Za-z_0-9.-]*)\s+([-+.]?\d.*)", re.DOTALL)
_BY_PATTERN = (("default_pose",), ("overrides",))
"""Ends of paths of what holds joints by name or pattern."""
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


def misplaced(document: Document, more: Iterable[str] = ()) -> tuple[Misplaced, ...]:
    """Mistakes of layout, each once.

    Args:
        document: What was read.
        more: Sections that are there because of other files.
    """
    data = document.data
    lost = (*_headers_lost(data, frozenset(more)), *_inside_another(data))
    told = {item.path[:2] for item in lost}
    rest = (
        *_quoted(document),
        *_sections(data),
        *_at_the_edge(data),
        *_dedented(data, ()),
        *_cut_apart(data, (), document),
    )
    return (*lost, *(item for item in rest if item.path[:2] not in told))


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
        if key == "version" and "actspec" not in data:
            meant = "actspec"
        elif meant is None and key not in tops and isinstance(value, Mapping) and "actspec" in data:
            # `drives:` or `groups:`, of which each entry tells what they are.
            of = {section_of(item) for item in value.values() if isinstance(item, Mapping)}
            meant = next(iter(of)) if len(of) == 1 and not of & data.keys() else None
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
        marks = own & {"joints", "level"} if section == "actuators" else own
        lost = next((name for name in held if name in tops and not _is_entry(held[name], marks)), None)
        if lost == section:
            yield Misplaced(
                f"the line `{section}:` is there twice", (section, section), "remove one of the two"
            )
        elif lost is not None:
            yield _indented(lost, (section, lost))
        else:
            yield from _beside(held, section, own, marks, word)
            if section == "actuators":
                yield from _without_pattern(held)
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


def _headers_lost(data: Mapping[str, Any], more: frozenset[str]) -> Iterator[Misplaced]:
    """Groups, motors and so on in another section, which the lines of their own have become a part of."""
    tops = fields_of(SpecModel)
    models = {name: model for name, (model, _) in _NAMED.items()} | {"variants": SpecModel}
    for section in (*models, *_FLAT, "accept"):
        held = data.get(section)
        if not isinstance(held, Mapping):
            continue
        beside = fields_of(model_at(SpecModel, (section,)))
        found: dict[str, list[str]] = {}
        for name, value in held.items():
            of = None if name in beside | tops else _section_of(name, value, fields_of(models.get(section)))
            if of is not None and of != section and of not in held:
                found.setdefault(of, []).append(name)
        for of, names in found.items():
            one = len(names) == 1
            what = f"{_shown(names)} belong{'s' * one} to `{of}`" if of not in _NAMED else _are(names, of)
            message = f"{what}, and stand{'s' * one} in `{section}`"
            if data.get(of) and of not in more:
                help = f"move {'it' if one else 'them'} below `{of}:`"
            else:
                message += f": the line `{of}:` is missing above"
                help = f"write `{of}:` at the left edge, above `{short(names[0])}`"
            yield Misplaced(message, (section, names[0]), help)


def _shown(names: Iterable[str]) -> str:
    return listed([f"`{short(name)}`" for name in names], 4)


def _are(names: Sequence[str], section: str) -> str:
    """That these are what a section holds by name."""
    word = _NAMED[section][1]
    one = len(names) == 1
    return f"{_shown(names)} {f'is a {word} by what it holds' if one else f'are {word}s by what they hold'}"


def _section_of(name: str, value: Any, own: frozenset[str]) -> str | None:
    """The section that an entry is of by what it holds; None: the one that it stands in, or none.

    Args:
        name: Of the entry.
        value: What it holds.
        own: Fields of the entries where it stands.
    """
    if not isinstance(value, Mapping):
        if name in fields_of(Timing):
            return "timing"
        return "accept" if isinstance(value, str) and "." in name and own else None
    if "joints" in value:
        # A field of another section in it is a mistake of its own.
        if value.keys() & _GEARED:
            return "linkages"
        return "actuators" if "level" in value or "joints" not in own else None
    return None if value.keys() & own - {"note"} else section_of(value)


def is_section(name: str) -> bool:
    """Whether a spec has a section called so."""
    return name in fields_of(SpecModel)


def word_for(section: str, key: str) -> str | None:
    """The word for what a section holds by name, if the key is one of its fields."""
    model, word = _NAMED.get(section, (None, ""))
    return word if key in fields_of(model) else None


def section_of(keys: Iterable[str], names: Iterable[str] = ()) -> str | None:
    """The section whose entries have these keys; None: several, or none.

    Args:
        keys: Of one entry, or of several.
        names: Of the entries, which in `robot` and `timing` are keys themselves.
    """
    flat = [section for section, model in _FLAT.items() if fields_of(model) & {*names}]
    if flat:
        return flat[0]
    known = {name: len(fields_of(model) & {*keys}) for name, (model, _) in _NAMED.items()}
    known["variants"] = len(fields_of(SpecModel) & {*keys})
    if not {"joints", "level"} & {*keys}:
        # Words of simulators are a group's fields, and are written into motors.
        known.pop("actuators")
    if not _GEARED & {*keys}:
        known.pop("linkages")
    best = [name for name, count in known.items() if count and count == max(known.values())]
    return best[0] if len(best) == 1 else None


def _inside_another(data: Mapping[str, Any]) -> Iterator[Misplaced]:
    """A group below a field of another, a motor below one of another and so on."""
    for section, (model, _) in _NAMED.items():
        held = data.get(section)
        own = fields_of(model)
        for name, entry in held.items() if isinstance(held, Mapping) else ():
            others = isinstance(entry, Mapping) and name != section
            inner = [key for key in entry if key not in own] if others else []
            found = [key for key in inner if _is_entry(entry[key], own) and section_of(entry[key]) == section]
            if found:
                message = f"{_are(found, section)}, and stand{'s' * (len(found) == 1)} inside `{short(name)}`"
                help = f"indent `{short(found[0])}:` as `{short(name)}:`, and what is below it with it"
                yield Misplaced(message, (section, name, found[0]), help)


def _at_the_edge(data: Mapping[str, Any]) -> Iterator[Misplaced]:
    """Groups, motors and so on that stand beside their section, which holds others, or which is missing."""
    tops = fields_of(SpecModel)
    lost: dict[str, list[str]] = {}
    for key, value in data.items():
        if key in tops:
            continue
        if "robot" not in data and "actspec" in data and key in fields_of(Robot):
            lost.setdefault("robot", []).append(key)
        if not isinstance(value, Mapping) or not value:
            continue
        of = [name for name, (model, _) in _NAMED.items() if not value.keys() - fields_of(model)]
        if len(of) == 1 and of[0] not in data:
            lost.setdefault(of[0], []).append(key)
        elif len(of) == 1 and isinstance(data.get(of[0]), Mapping):
            word = _NAMED[of[0]][1]
            message = (
                f"`{short(key)}` stands at the left edge, and by what it holds it is a {word} of `{of[0]}`"
            )
            yield Misplaced(
                message, (key,), f"indent it, and what is below it, as the other {word}s of `{of[0]}`"
            )
    for section, names in lost.items():
        one = len(names) == 1
        message = (
            f"{_shown(names)} belong{'s' * one} to `{section}`, and stand{'s' * one} at the left edge: the line "
            f"`{section}:` is missing above"
        )
        help = f"write `{section}:` above, and indent {'it' if one else 'them'} below it"
        yield Misplaced(message, (names[0],), help)


def fields_of(model: type[BaseModel] | None) -> frozenset[str]:
    """Keys of a model as a spec writes them; of None none."""
    return frozenset(_annotations(model)) if model is not None else frozenset()


def model_at(root: type[BaseModel], path: Path) -> type[BaseModel] | None:
    """The model that describes the mapping at `path`."""
    if path[:1] == ("variants",) and len(path) > 1 and root is SpecModel:
        # A variant is a part of a spec.
        path = path[2:]
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
    models = [part for part in arguments if _is_model(part) or is_dataclass(part)]
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


def _beside(
    held: Mapping[str, Any], section: str, fields: frozenset[str], marks: frozenset[str], word: str
) -> Iterator[Misplaced]:
    """Fields of a group, motor or source that stand where its name should.

    Args:
        held: What the section holds.
        section: Its name.
        fields: Those of one entry.
        marks: Those by which one is told.
        word: For one.
    """
    names = list(held)
    stray = [key for key in names if key in fields and not _is_entry(held[key], marks)]
    if not stray:
        return
    owner = next((key for key in names if held[key] is None and key not in fields), None)
    above = names[: names.index(stray[0])]
    shown, one = listed([f"`{key}`" for key in stray], 4), len(stray) == 1
    they, what, them = ("it is", "a field", "it") if one else ("they are", "fields", "them")
    if owner is not None:
        message = f"{shown} stand{'s' * one} beside `{owner}`, which is empty: {they} {what} of that {word}"
        help = f"indent {them} below `{owner}:`"
    else:
        message = f"{shown} {they.split()[1]} {what} of a {word}, and `{section}` holds {word}s by name"
        name = "such as `legs:`, " if word == "group" else ""
        help = f"write a name above {them}, {name}and indent {them} below it"
        if above and (marks == fields or not marks & {*stray}):
            into = f"indent {them} into the {word} that {they} for"
            help = f"{into}; or {help}" if marks == fields else into
    yield Misplaced(message, (section, stray[0]), help)


def _without_pattern(groups: Mapping[str, Any]) -> Iterator[Misplaced]:
    """Fields that stand in `overrides` itself, without the joints that they are for."""
    fields = fields_of(Tunable)
    for name, group in groups.items():
        held = group.get("overrides") if isinstance(group, Mapping) else None
        for key, value in held.items() if isinstance(held, Mapping) else ():
            if key in fields and not _is_entry(value, fields):
                message = f"`{key}` stands in `overrides` itself, which holds fields by joint or pattern"
                help = f'write the pattern above, such as `".*_knee": {{{key}: ...}}`'
                yield Misplaced(message, ("actuators", name, "overrides", key), help)
                break


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


def _quoted(document: Document) -> Iterator[Misplaced]:
    """Values in typographic quotes, which are a part of them: the first, for one editor writes them all."""
    found = [(path, text) for path, text in _texts(document.data, ()) if _TYPOGRAPHIC.fullmatch(text)]
    for path, text in found[:1]:
        more = f", here and at {many(len(found) - 1, 'more place')}" if len(found) > 1 else ""
        message = f"the quotes of `{short(text)}` are typographic, which are letters to YAML{more}"
        yield Misplaced(message, path, f'write `"{short(text[1:-1])}"`', key=False)


_TYPOGRAPHIC = re.compile(
    "[\u201c-\u201f\u00ab\u00bb].*[\u201c-\u201f\u00ab\u00bb\"]|[\u2018-\u201b].*[\u2018-\u201b']", re.DOTALL
)


def _texts(node: Any, path: Path) -> Iterator[tuple[Path, str]]:
    """Texts that are no sentences, with their places."""
    if isinstance(node, str):
        yield path, node
    elif isinstance(node, (Mapping, list)):
        for key, value in node.items() if isinstance(node, Mapping) else enumerate(node):
            if key not in _TEXTS and path[:1] != ("accept",):
                yield from _texts(value, (*path, key))


def _cut_apart(node: Any, path: Path, document: Document) -> Iterator[Misplaced]:
    """Values in [ ] and { } that a comma inside a number, or a colon without a space, has cut apart."""
    if isinstance(node, Mapping):
        last: tuple[str, Any] | None = None
        for key, value in node.items():
            space = _NO_SPACE.fullmatch(key) if value is None else None
            bracket = _NO_COLON.fullmatch(key)
            lacks = _NO_COLON_IN_BRACES.fullmatch(key) if value is None else None
            if value is None and last is not None and _is_whole(last[1]) and _DIGITS.fullmatch(key):
                at = (*path, last[0])
                yield _comma(f"{document.spans.written(at)},{key}", at)
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
            elif value is None and last is None and _NUMBER.fullmatch(key) and path[-1:] not in _BY_PATTERN:
                cut = [other for other in node if other is not key and _DIGITS.fullmatch(other)]
                parts = [short(key), *map(short, cut[:1])]
                if len(node) == len(parts):
                    message = f"`{{{','.join(parts)}}}` is a mapping, and a number stands in it without a key"
                    yield Misplaced(
                        message, path, f"write `{path[-1]}: {'.'.join(parts)}` without {{ }}", key=False
                    )
                elif _is_value(node):
                    name = "nominal" if node.keys() & {"range", "sampling"} else "value"
                    message = f"`{','.join(parts)}` stands where a key must"
                    yield Misplaced(message, (*path, key), f"write `{name}: {'.'.join(parts)}`")
            elif space is not None:
                message = f"`{short(key)}` has no space behind its colon, and is one word"
                yield Misplaced(message, (*path, key), f"write `{space[1]}: {short(space[2])}`")
            else:
                yield from _cut_apart(value, (*path, key), document)
            last = key, value
    elif isinstance(node, list) and path[-1:] not in _BY_PATTERN:
        found = _cut_in_list(node, path, document)
        if found is not None:
            yield found
        else:
            for index, item in enumerate(node):
                yield from _cut_apart(item, (*path, index), document)


def _cut_in_list(node: list[Any], path: Path, document: Document) -> Misplaced | None:
    """A list of more numbers than it must have, because of commas inside them."""
    spans, wanted = document.spans, _length(path, document.data)
    if len(node) <= (wanted or 2):
        return None
    at: list[Path] = [(*path, index) for index in range(len(node))]
    texts = [spans.written(place) or str(item) for place, item in zip(at, node, strict=True)]
    if not all(map(_NUMBER.fullmatch, texts)):
        return None
    # A comma of the list mostly has a space behind it, one inside a number never.
    glued = [
        _is_whole(one)
        and _DIGITS.fullmatch(after) is not None
        and there == replace(here, column=here.column + len(before) + 1)
        for one, (before, after), (here, there) in zip(
            node, pairwise(texts), pairwise(map(spans.value, at)), strict=False
        )
    ]
    numbers: list[str] = []
    index = 0
    while index < len(node):
        joined = glued[index : index + 1] == [True]
        if not joined and index and glued[index - 1]:
            # Of three without a space two are one, and nothing tells which.
            return None
        numbers.append(",".join(texts[index : index + 1 + joined]))
        index += 1 + joined
    if len(numbers) == len(node) or wanted not in (None, len(numbers)):
        return None
    return _comma(f"[{', '.join(numbers)}]", path)


_PAIRS = frozenset(("scale", "add", "abs", "range", "every", "command_range"))
"""Keys of lists of two numbers."""


def _length(path: Path, data: Mapping[str, Any]) -> int | None:
    """How many numbers a list has: as a pair, as the pose of a linkage or as a row of its Jacobian; None: any."""
    if path[-1] in _PAIRS:
        return 2
    if path[0] != "linkages" or (path[-1] != "at" and path[-2:-1] != ("jacobian",)):
        return None
    linkage = data["linkages"][path[1]]
    joints = linkage.get("joints") if isinstance(linkage, Mapping) else None
    return len(joints) if isinstance(joints, list) else None


def _is_text_on(text: Any, rest: str) -> bool:
    """Whether what stands behind a text and a comma is the rest of it, and no key with its value."""
    first = next(iter(rest.split()), "")
    return isinstance(text, str) and first.partition(":")[0] not in _IN_A_VALUE | fields_of(Source)


def _is_value(node: Mapping[str, Any]) -> bool:
    """Whether a mapping has a key of those that stand beside a number, and not the number's own."""
    return bool(node.keys() & _IN_A_VALUE) and not node.keys() & {"value", "nominal"}


def _is_whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _comma(given: str, path: Path) -> Misplaced:
    message = f"{short(given)}: a comma inside a number, which ends it in [ ] and {{ }}"
    meant = re.sub(r",(?! )", ".", given)
    return Misplaced(message, path, of_comma(given, meant), False, "SPEC110")
