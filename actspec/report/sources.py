"""The text around a place, of files that were read as models and of no other."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Iterator

from actspec.diagnostics import Span, one_line
from actspec.readings.artifact import FileReading

WIDEST = 140
"""Chosen: characters of an excerpt; longer lines are cut around the place."""


class Sources:
    """Lines of the audited files. A file that could not be read as a model has none."""

    def __init__(self, files: Iterable[FileReading]) -> None:
        self._data = {file.path: file.data for r in files if r.readable for file in r.files}
        self._lines: dict[str, list[str]] = {}

    def line(self, span: Span) -> str | None:
        """The line that a place is on, without its break; None when it is not known."""
        if span.path not in self._data or span.line < 1:
            return None
        if span.path not in self._lines:
            text = self._data[span.path].decode("utf-8-sig", "replace")
            if "\r" in text:
                text = text.replace("\r\n", "\n").replace("\r", "\n")
            self._lines[span.path] = text.split("\n")
        lines = self._lines[span.path]
        return lines[span.line - 1] if span.line <= len(lines) else None

    def excerpt(self, span: Span) -> Iterator[str]:
        """A place's line with its number, and a caret under its column; nothing when the line is not known."""
        text = self.line(span)
        if text is None:
            return
        shown, column = _window(text, span.column)
        number = str(span.line)
        margin = " " * len(number)
        yield f"{margin} |"
        yield f"{number} | {shown}".rstrip()
        if column:
            yield f"{margin} | {' ' * _width(shown[: column - 1])}^"


def _window(text: str, column: int) -> tuple[str, int]:
    """At most `WIDEST` characters around a column, safe to print, and the column in them (0: none)."""
    first = 0
    if len(text) > WIDEST:
        first = min(max(column - 1 - WIDEST // 2, 0), len(text) - WIDEST)
    cut = text[first : first + WIDEST].replace("\t", " ")
    left = "..." if first else ""
    right = "..." if first + WIDEST < len(text) else ""
    at = column - 1 - first
    if not 0 <= at <= len(cut) or not column:
        return left + one_line(cut) + right, 0
    before = left + one_line(cut[:at])
    return before + one_line(cut[at:]) + right, len(before) + 1


def _width(text: str) -> int:
    """Columns that text takes on a terminal."""
    if text.isascii():
        return len(text)
    return sum(
        0 if unicodedata.combining(c) else 2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in text
    )
