"""What every page has: one file with everything in it, no script, nothing fetched, for phones and the dark too."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from html import escape

from actspec.diagnostics import one_line
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
