"""Fields of a configuration under another name: the edit of the keyword in the text."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence

from actspec.audit.case import Case
from actspec.audit.finding import Fix, Safety, TextEdit
from actspec.readings.artifact import ActuatorGroup


def renaming(case: Case, group: ActuatorGroup, old: str, new: str) -> Fix | None:
    """Rename a field where it is a keyword of the group's own class.

    Args:
        case: The case.
        group: The group.
        old: Field as written.
        new: What it is to be called; not one that the group has already.

    Returns: None where the field is set in another way, or in a text that is no keyword's value (a constant).
    """
    span = group.settings[old].span
    data = next((f.data for reading in case.files for f in reading.files if f.path == span.path), None)
    if data is None or new in group.settings:
        return None
    try:
        text = data.decode("utf-8")
        calls = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call)]
    except (SyntaxError, ValueError, RecursionError):
        return None
    lines = data.splitlines(keepends=True)
    places = [
        keyword
        for call in calls
        if _name(call.func) == group.cls
        for keyword in call.keywords
        if keyword.arg == old and (span.line, span.column) in _starts(keyword, lines)
    ]
    if len(places) != 1 or any(line.endswith(b"\r") for line in lines):
        return None
    start = sum(map(len, lines[: places[0].lineno - 1])) + places[0].col_offset
    end = start + len(old.encode())
    if data[start:end] != old.encode():
        return None
    return Fix(f"Rename {old} to {new}", Safety.SAFE, (TextEdit(span.path, start, end, new.encode()),))


def _name(function: ast.expr) -> str:
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def _starts(keyword: ast.keyword, lines: Sequence[bytes]) -> Iterator[tuple[int, int]]:
    """Where a keyword and its value begin, in characters from 1."""
    for node in (keyword, keyword.value):
        before = lines[node.lineno - 1][: node.col_offset]
        yield node.lineno, len(before.decode("utf-8", "replace")) + 1
