"""YAML that every reader takes alike: quoting, numbers and lists over several lines."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from actspec.diagnostics import one_line

WIDTH = 100
"""Columns of a list."""

_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_WORDS = frozenset({"y", "n", "yes", "no", "on", "off", "true", "false", "null", "none", "nan", "inf"})
_ESCAPES = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\r": "\\r", "\t": "\\t"}


def scalar(value: str | float | int | None) -> str:
    """A value on one line, the same to a reader of YAML 1.1 and of 1.2; None is `null`."""
    if value is None:
        return "null"
    if isinstance(value, str):
        if _PLAIN.fullmatch(value) and value.lower() not in _WORDS:
            return value
        return '"' + "".join(_ESCAPES.get(c) or (c if " " <= c <= "~" else _escape(c)) for c in value) + '"'
    if isinstance(value, int):
        return str(value)
    # Twelve digits hide the last bit of an arithmetic; -0.0 is 0.0.
    text = repr(float(f"{value:.12g}") + 0.0)
    if text in ("inf", "-inf"):
        return text.replace("inf", ".inf")
    # YAML 1.1 takes 1e-05 for a word.
    return text.replace("e", ".0e") if "e" in text and "." not in text else text


def _escape(character: str) -> str:
    code = ord(character)
    if code < 0x100:
        return f"\\x{code:02x}"
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def flow(values: Iterable[str | float | int | None]) -> list[str]:
    """A flow list as lines, broken between entries only; the first is to follow its key."""
    items = [scalar(value) for value in values]
    one = f"[{', '.join(items)}]"
    if len(one) <= WIDTH - 24:
        return [one]
    lines, line = ["["], "   "
    for item in items:
        if len(line) + len(item) + 2 > WIDTH and line.strip():
            lines.append(line)
            line = "   "
        line += f" {item},"
    return [*lines, line, "  ]"]


def comment(text: str) -> str:
    """Text of any origin behind a `#`: it cannot end its line."""
    return one_line(text)


def entry(key: str, values: Sequence[str | float | int | None], indent: str = "") -> list[str]:
    """`key: [...]` as lines."""
    first, *rest = flow(values)
    return [f"{indent}{key}: {first}", *(f"{indent}{line}" for line in rest)]
