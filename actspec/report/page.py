"""What every page has: one file with everything in it, no script, nothing fetched, for phones and the dark too."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape

from actspec.diagnostics import SEVERITIES, Diagnostic, one_line
from actspec.resources import data_path


def whole(title: str, body: Iterable[str], styles: Iterable[str] = ()) -> str:
    """A page as text, ending in a line break.

    Args:
        title: In the browser's head, plain text.
        body: Lines of HTML.
        styles: CSS beside that of all reports.
    """
    style = data_path("templates", "report/report.css").read_text(encoding="utf-8")
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="generator" content="actspec">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        # A second lock: should a name ever slip through unescaped, it can load and run nothing.
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">\n"
        f"<title>{plain(title)}</title>\n<style>\n{''.join((style, *styles))}</style>\n</head>\n"
        f"<body>\n{chr(10).join(body)}\n</body>\n</html>\n"
    )


def plain(text: str) -> str:
    """Text of a stranger's file as HTML that shows it as it is."""
    return escape(one_line(text))


def fold(title: str, lines: Iterable[str], *, shown: bool) -> Iterator[str]:
    """What can be folded away."""
    yield f"<details{' open' * shown}><summary>{plain(title)}</summary>"
    yield from lines
    yield "</details>"


def articles(findings: Sequence[Diagnostic]) -> Iterator[str]:
    """Diagnostics, the worst first."""
    for item in sorted(findings, key=lambda item: -SEVERITIES.index(item.severity)):
        severity = item.severity.value
        where = f"<strong>{plain(item.where)}</strong>: " if item.where else ""
        yield f'<article class="{severity}">'
        if item.span is not None:
            yield f'<p class="place">{plain(str(item.span))}</p>'
        yield f'<p><span class="severity">{severity}</span> {plain(item.code)} {where}{plain(item.message)}</p>'
        if item.help:
            yield f"<p>Help: {plain(item.help)}</p>"
        yield "</article>"


def figure(
    picture: str,
    title: str,
    words: str = "",
    table: Iterable[str] = (),
    *,
    kind: str = "",
    joints: Iterable[str] = (),
) -> Iterator[str]:
    """A picture with its caption.

    Args:
        picture: Of `plot`.
        title: What it shows.
        words: What it says, for those who cannot see it too.
        table: Its numbers, as HTML.
        kind: Of figure, for programs.
        joints: That it shows, for programs.
    """
    below = f"<p>{plain(words)}</p>" if words else ""
    names = " ".join(plain(name) for name in joints)
    told = f' data-figure="{plain(kind)}" data-joints="{names}"' if kind else ""
    yield f"<figure{told}><figcaption>{plain(title)}</figcaption>{picture}{below}"
    yield from table
    yield "</figure>"


CARDS = ' class="cards"'
"""Of a table whose rows are cards on a phone, where the page has the styles for it."""


def head_of(title: str, cards: bool) -> str:
    """The attribute of a cell that has the name of its column, which a card shows."""
    return f' data-head="{plain(title)}"' if cards else ""


def plain_table(
    heads: Sequence[str], rows: Iterable[Sequence[str]], right: Sequence[int] = (), *, cards: bool = False
) -> Iterator[str]:
    """A table of plain text.

    Args:
        heads: Over the columns.
        rows: Cells.
        right: Columns that stand right.
        cards: Whether a row is a card on a phone, its first cell the title.
    """
    names = [head_of(head, cards) for head in heads]
    shown = "".join(f"<th>{plain(head)}</th>" for head in heads)
    yield f'<div class="wide"><table{CARDS * cards}><tr>{shown}</tr>'
    for row in rows:
        cells = (f"<td{' class=n' * (i in right)}{names[i]}>{plain(cell)}</td>" for i, cell in enumerate(row))
        yield f"<tr>{''.join(cells)}</tr>"
    yield "</table></div>"
