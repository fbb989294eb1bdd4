"""Colours of a terminal, and how places and severities look in text."""

from __future__ import annotations

from dataclasses import dataclass

from actspec.diagnostics import Severity, one_line
from actspec.report.findings import Group

_COLOURS = {Severity.ERROR: "31", Severity.WARNING: "33", Severity.INFO: "36"}
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
        """Text that may be passed over."""
        return self.paint(text, _FAINT)

    def bold(self, text: str) -> str:
        """Text that catches the eye."""
        return self.paint(text, _BOLD)

    def severity(self, text: str, severity: Severity) -> str:
        """Text in the colour of a severity."""
        return self.paint(text, _COLOURS[severity])

    def headline(self, group: Group) -> str:
        """`path:line:col: CODE [severity] joints: message`."""
        item = group.first
        code = self.severity(item.finding.code, item.severity)
        place = self.bold(str(item.finding.span))
        return f"{place}: {code} [{item.severity.value}] {one_line(group.headline())}"
