"""Text in columns."""

from __future__ import annotations

from collections.abc import Sequence

from actspec.diagnostics import one_line


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


def _is_number(text: str) -> bool:
    if text in ("", "-", "?"):
        return True
    try:
        float(text)
    except ValueError:
        return False
    return True
