"""Plain data as YAML that reads back as the same data: a spec that was changed, not written by hand."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from actspec.diagnostics import one_line
from actspec.draft.text import scalar
from actspec.robot.xml_edit import exact_number

WIDTH = 100
"""Columns up to which a collection without others in it stands on its line. Chosen: as drafts have it."""

_QUANTITY = re.compile(r"-?[0-9]+(?:\.[0-9]+)?(?:e[-+]?[0-9]+)? [A-Za-z*/^0-9]+")
"""A number with its unit, which is text to every reader of YAML."""
_WORDS = ("unknown", "none")
"""Of the language, which writes them so everywhere."""


def yaml_text(data: Mapping[str, Any], head: str = "") -> str:
    """A mapping as YAML, in its own order, a gap before each mapping at the top.

    Args:
        data: Mappings, lists, text, numbers, booleans and None.
        head: Remarks above it, a line each.
    """
    lines = [f"# {one_line(line)}".rstrip() for line in head.splitlines()]
    for key, value in data.items():
        shown = list(_entry(key, value, ""))
        if len(shown) > 1 or isinstance(value, (dict, list)):
            lines.append("")
        lines += shown
    return "\n".join(lines).lstrip("\n") + "\n"


def _entry(key: str, value: Any, indent: str) -> Iterator[str]:
    """A key with its value."""
    head = f"{indent}{scalar(key)}:"
    flow = _flow(value)
    if flow is not None and (not isinstance(value, (dict, list)) or len(head) + len(flow) < WIDTH):
        yield f"{head} {flow}"
        return
    yield head
    if isinstance(value, dict):
        for name, item in value.items():
            yield from _entry(name, item, f"{indent}  ")
    else:
        for item in value:
            # What is in a list has no block of its own: the language has no lists of large things.
            yield f"{indent}  - {_whole(item)}"


def _flow(value: Any) -> str | None:
    """A value on one line; None for a mapping that has mappings or lists of its own in it."""
    if isinstance(value, dict) and any(isinstance(item, (dict, list)) for item in value.values()):
        inner = [_flow(item) for item in value.values()]
        return _whole(value) if len(value) == 1 and None not in inner else None
    return _whole(value)


def _whole(value: Any) -> str:
    if isinstance(value, dict):
        return f"{{{', '.join(f'{scalar(key)}: {_whole(item)}' for key, item in value.items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(_whole, value))}]"
    if isinstance(value, str):
        return value if _QUANTITY.fullmatch(value) or value in _WORDS else scalar(value)
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, int):
        return str(value)
    number = exact_number(value)
    # Without a dot or an exponent it would read back as a whole number.
    return number if re.search("[.e]", number) else f"{number}.0"
