"""The layout of a spec: what stands at another indentation, below another key or with another mark than it was meant.

One mistake of layout makes many errors further on, none of which names it. So these are found first, and alone.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from actspec.diagnostics import Path, listed
from actspec.spec.models import Actuators, Motor, Source, SpecModel
from actspec.spec.values import short

_NAMED: dict[str, tuple[type[BaseModel], str]] = {
    "actuators": (Actuators, "group"),
    "motors": (Motor, "motor"),
    "sources": (Source, "source"),
}
"""Sections that hold things by name: what these are, and the word for one."""

_NO_SPACE = re.compile(r"([A-Za-z_][A-Za-z_0-9-]*):(\S.*)", re.DOTALL)
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
    return (*_sections(data), *_cut_apart(data, ()))


def _sections(data: Mapping[str, Any]) -> Iterator[Misplaced]:
    tops = _fields(SpecModel)
    yield from _at_the_edge(data, tops)
    for section, (model, word) in _NAMED.items():
        held = data.get(section)
        if isinstance(held, list) and held and all(isinstance(item, Mapping) for item in held):
            yield from _dashed(held, section, word)
        if not isinstance(held, Mapping):
            continue
        own = _fields(model)
        lost = next((name for name in held if name in tops and not _is_entry(held[name], own)), None)
        if lost is not None:
            yield _indented(lost, (section, lost))
        else:
            yield from _beside(held, section, own, word)
    for section in ("robot", "timing"):
        held = data.get(section)
        if isinstance(held, Mapping):
            own = _fields(SpecModel.model_fields[section].annotation)
            for name in held:
                if name in tops and name not in own:
                    yield _indented(name, (section, name))


def _fields(model: Any) -> frozenset[str]:
    while not (isinstance(model, type) and issubclass(model, BaseModel)):
        model = next(part for part in model.__args__ if part is not type(None))
    return frozenset(info.alias or name for name, info in model.model_fields.items())


def _indented(name: str, path: Path) -> Misplaced:
    message = f"`{name}` is a section of the spec, and by its indentation it is a part of `{path[0]}`"
    return Misplaced(message, path, f"move `{name}:` to the left edge, and what is below it with it")


def _at_the_edge(data: Mapping[str, Any], tops: frozenset[str]) -> Iterator[Misplaced]:
    """Names that stand at the left edge behind their section, which is empty."""
    section, found = None, list[str]()
    for key, value in (*data.items(), ("actspec", None)):
        if key in tops:
            if section is not None and found:
                what = f"{listed([f'`{name}`' for name in found])} stand{'s' * (len(found) == 1)}"
                yield Misplaced(
                    f"{what} at the left edge, and `{section}` above is empty",
                    (found[0],),
                    f"indent what belongs to `{section}` by two spaces",
                )
            section, found = (key if value is None and key in _NAMED else None), []
        elif section is not None and isinstance(value, Mapping):
            found.append(key)


def _beside(held: Mapping[str, Any], section: str, fields: frozenset[str], word: str) -> Iterator[Misplaced]:
    """Fields of a group, motor or source that stand where its name should."""
    stray = [key for key, value in held.items() if key in fields and not _is_entry(value, fields)]
    if len(stray) < 2:
        return
    owner = next((key for key, value in held.items() if value is None and key not in fields), None)
    names = listed([f"`{key}`" for key in stray], 4)
    if owner is not None:
        message = f"{names} stand beside `{owner}`, which is empty: they are fields of that {word}"
        help = f"indent them below `{owner}:`"
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
            if value is None and last is not None and _is_whole(last[1]) and _DIGITS.fullmatch(key):
                yield _comma(f"{last[1]},{key}", f"{last[1]}.{key}", (*path, last[0]))
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


def _is_whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _comma(given: str, meant: str, path: Path) -> Misplaced:
    message = f"{short(given)}: a comma inside a number, which ends it in [ ] and {{ }}"
    return Misplaced(
        message, path, f"decimals have a point (`{short(meant)}`), thousands no mark", False, "SPEC110"
    )
