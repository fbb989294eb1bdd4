"""What text is made of: columns, counts with their nouns, colours of a terminal."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from actspec.diagnostics import Severity, one_line

COLOURED = re.compile(r"(\x1b\[(?:0|1|2|31|33|36)m)")
"""What a painted text has around it."""
COLOURS = {Severity.ERROR: "31", Severity.WARNING: "33", Severity.INFO: "36"}
_BOLD, _FAINT = "1", "2"


@dataclass(frozen=True, slots=True)
class Style:
    """How text is painted.

    Attributes:
        colour: Whether at all.
    """

    colour: bool

    def paint(self, text: str, code: str) -> str:
        """Text in an ANSI colour."""
        return f"\x1b[{code}m{text}\x1b[0m" if self.colour else text

    def faint(self, text: str) -> str:
        """Text that matters less."""
        return self.paint(text, _FAINT)

    def bold(self, text: str) -> str:
        """Text that catches the eye."""
        return self.paint(text, _BOLD)

    def severity(self, text: str, severity: Severity) -> str:
        """Text in the colour of a severity."""
        return self.paint(text, COLOURS[severity])


def table(rows: Sequence[Sequence[str]], indent: str = "  ", headings: int = 1) -> list[str]:
    """Rows as aligned columns, the first `headings` rows the heading; columns of numbers stand right."""
    if not rows:
        return []
    cells = [[one_line(cell) for cell in row] for row in rows]
    widths = [max(len(row[column]) for row in cells) for column in range(len(cells[0]))]
    right = [
        all(_is_number(row[column]) for row in cells[headings:]) and len(cells) > headings
        for column in range(len(widths))
    ]
    lines = []
    for row in cells:
        parts = [
            cell.rjust(width) if on_right else cell.ljust(width)
            for cell, width, on_right in zip(row, widths, right, strict=True)
        ]
        lines.append((indent + "  ".join(parts)).rstrip())
    return lines


def markdown_table(rows: Sequence[Sequence[str]], right: int | None = None) -> list[str]:
    """Rows of text that is Markdown already as a table, the first the heading.

    Args:
        rows: Cells.
        right: Columns from this one on stand right; None: no column does.
    """
    count = len(rows[0])
    rule = ["---" if right is None or place < right else "---:" for place in range(count)]
    return [f"| {' | '.join(row)} |" for row in (rows[0], rule, *rows[1:])]


def escaped(text: str) -> str:
    """Text of a stranger's file as Markdown shows it as it is: no markup, no HTML, nobody notified, nothing linked."""
    text = re.sub(r"([\\`*_\[\]|~$])", r"\\\1", one_line(text))
    text = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    # Services link names, issues and addresses in the finished text, where only a gap of no width stops them.
    text = re.sub(r"([@#])(?=\w)", r"\1&#8203;", text)
    return text.replace("://", ":&#8203;//").replace("www.", "www&#8203;.")


def code(text: str) -> str:
    """A command as Markdown shows it, whatever backticks its names have."""
    text = one_line(text)
    fence = "`" * (1 + max(map(len, re.findall("`+", text)), default=0))
    return f"{fence}{text}{fence}" if len(fence) == 1 else f"{fence} {text} {fence}"


def _is_number(text: str) -> bool:
    if text in ("", "-", "?"):
        return True
    try:
        float(text)
    except ValueError:
        return False
    return True


def percent(share: float | None) -> str:
    """A share in percent with two digits, more where it is above 100; `-` where it is unknown."""
    if share is None:
        return "-"
    value = 100.0 * share
    return f"{value:.2g} %" if abs(value) < 99.5 else f"{value:.0f} %"
