"""What the targets that write Python text share: literals, comments, names, patterns, grouping.

Names and notes come from strangers. They reach the text as literals (`py`) or behind a `#`
(`comment_lines`), and never otherwise.
"""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from functools import cache
from keyword import iskeyword
from typing import TYPE_CHECKING, Any, TypeVar

from actspec.diagnostics import one_line
from actspec.ir import JointActuator, Origin, Quantity
from actspec.patterns import PatternError, match_names

if TYPE_CHECKING:
    from jinja2 import Environment

T = TypeVar("T")
K = TypeVar("K")

WIDTH = 120
"""Columns of the text, as the frameworks' own code has."""

DIGITS = 12
"""Of a number: they hide the last bit of an arithmetic, and a step of 1/60 s is read back as what it was."""


@cache
def environment(kind: str) -> Environment:
    """The templates of `templates/<kind>`: a value that is missing is an error, `py` writes literals."""
    import jinja2

    from actspec.resources import data_path

    found = jinja2.Environment(
        loader=jinja2.FileSystemLoader(str(data_path("templates", kind))),
        undefined=jinja2.StrictUndefined,
        # Not HTML: values come as literals or comments.
        autoescape=False,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    found.filters["py"] = py
    return found


def py(value: Any) -> str:
    """A value as a Python literal on one line, in double quotes where it is text.

    Raises:
        ValueError: a number that is not finite, or a type that has no literal.
    """
    if value is None or isinstance(value, bool):
        return repr(value)
    if isinstance(value, str):
        return _text(str(value))
    if isinstance(value, int):
        return repr(int(value))
    if isinstance(value, float):
        number = float(value)
        if not math.isfinite(number):
            raise ValueError(f"{number!r} cannot be written")
        # -0.0 is 0.0.
        return repr(float(f"{number:.{DIGITS}g}") + 0.0)
    if isinstance(value, tuple):
        return f"({', '.join(map(py, value))}{',' if len(value) == 1 else ''})"
    if isinstance(value, list):
        return f"[{', '.join(map(py, value))}]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{py(key)}: {py(item)}" for key, item in value.items()) + "}"
    raise ValueError(f"no literal for {type(value).__name__}")


def _text(text: str) -> str:
    literal = repr(text)
    if literal.startswith("'") and '"' not in literal:
        return f'"{literal[1:-1]}"'
    return literal


def identifier(name: str, *, fallback: str = "robot") -> str:
    """A name as an ASCII identifier: what cannot stand in one becomes `_`."""
    found = re.sub(r"[^A-Za-z0-9_]+", "_", name).strip("_")
    if not found:
        return fallback
    if found[0].isdigit() or iskeyword(found):
        return f"{fallback}_{found}"
    return found


def free_name(name: str, taken: Collection[str]) -> str:
    """The name, or where it is taken the first free one of `name_2`, `name_3`, ..."""
    found, count = name, 1
    while found in taken:
        count += 1
        found = f"{name}_{count}"
    return found


def comment_lines(text: str, *, indent: str = "", hang: str = "", width: int = WIDTH) -> list[str]:
    """Text of any origin as `#` lines, wrapped; it cannot end its comment.

    Args:
        text: One paragraph; empty: an empty comment line.
        indent: Before the `#`.
        hang: More indent of the lines that continue it.
        width: Columns.
    """
    head = f"{indent}# "
    wrapped = textwrap.wrap(
        one_line(text),
        width - len(head),
        subsequent_indent=hang,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [f"{head}{line}".rstrip() for line in wrapped or [""]]


def import_lines(module: str, names: Sequence[str], *, indent: str = "    ", width: int = WIDTH) -> list[str]:
    """An import, on one line where it fits."""
    line = f"from {module} import {', '.join(names)}"
    if len(line) <= width:
        return [line]
    return [f"from {module} import (", *(f"{indent}{name}," for name in names), ")"]


def keyword_lines(
    keyword: str, values: list[str] | tuple[str, ...], indent: str, *, step: str = "    ", width: int = WIDTH
) -> list[str]:
    """A keyword with texts, on one line where it fits, else one text a line."""
    line = f"{indent}{keyword}={py(values)},"
    if len(line) <= width:
        return [line]
    begin, end = "[]" if isinstance(values, list) else "()"
    rows = (f"{indent}{step}{py(value)}," for value in values)
    return [f"{indent}{keyword}={begin}", *rows, f"{indent}{end},"]


def module_name(robot: str) -> str:
    """Name of a robot's module: `unitree_a1_cfg`."""
    return f"{identifier(robot).lower()}_cfg"


def section_lines(
    sections: Iterable[tuple[str, Iterable[str]]], *, bullet: str, hang: str, width: int = WIDTH
) -> Iterator[str]:
    """Headings with their lines as `#` lines, an empty one before each heading.

    Args:
        sections: Heading and lines.
        bullet: Before each line.
        hang: Indent of the lines that continue it.
        width: Columns.
    """
    for heading, lines in sections:
        yield "#"
        yield from comment_lines(heading, width=width)
        for line in lines:
            yield from comment_lines(f"{bullet}{line}", hang=hang, width=width)


def joint_patterns(
    actuators: Sequence[JointActuator], names: Sequence[str], first: Sequence[str] = ()
) -> tuple[str, ...]:
    """Patterns that match exactly these actuators' joints, each joint once.

    The author's patterns where all that they match is meant and not matched before, the rest joint by
    joint, escaped.

    Args:
        actuators: The joints that are meant.
        names: All of the robot's joints.
        first: More patterns of the author, tried before those of the joints' groups.
    """
    left = {actuator.joint for actuator in actuators}
    found = []
    for pattern in dict.fromkeys((*first, *(actuator.pattern for actuator in actuators))):
        try:
            matched = set(match_names(pattern, names))
        except PatternError:
            continue
        if matched and matched <= left:
            left -= matched
            found.append(pattern)
    found += [re.escape(actuator.joint) for actuator in actuators if actuator.joint in left]
    return tuple(found)


def grouped(items: Iterable[T], key: Callable[[T], K]) -> list[tuple[K, list[T]]]:
    """Items with the same key together, in the order of their first."""
    found: dict[K, list[T]] = {}
    for item in items:
        found.setdefault(key(item), []).append(item)
    return list(found.items())


def stated(quantity: Quantity | None) -> bool:
    """Whether somebody says this number: not unknown, and not an engine's default."""
    return quantity is not None and quantity.known and quantity.origin is not Origin.DEFAULT


def origin_of(quantity: Quantity) -> str:
    """Where a number comes from, short enough to stand behind it: `authored, a1_urdf`."""
    parts = [quantity.origin.value]
    if quantity.source and quantity.origin is not Origin.MODEL:
        parts.append(quantity.source)
    if quantity.std is not None:
        parts.append(f"std {quantity.std:g} {quantity.unit}")
    return one_line(", ".join(parts))
