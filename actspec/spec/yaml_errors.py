"""What PyYAML says of a text that is no YAML, in plain words."""

from __future__ import annotations

from typing import Any

from actspec.spec.yaml_text import BREAK

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


def plain_problem(problem: str, context: str, text: str, mark: Any) -> tuple[str, str | None]:
    """Message and help for an error.

    Args:
        problem: What PyYAML found.
        context: What it was reading.
        text: The file.
        mark: PyYAML's place of the error; None: unknown.
    """
    lines = BREAK.split(text)
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
