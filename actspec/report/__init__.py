"""Everything that becomes text, JSON or a page. Here: the reports of an audit, `render` in the module of the format."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import SEVERITIES, Severity

if TYPE_CHECKING:
    from actspec.audit.outcome import Report

FORMATS = ("full", "concise", "json", "sarif", "github", "junit", "markdown", "html")
"""Names of `--output-format`, the default first."""


WITH_NOTES = ("json", "sarif", "html")
"""Formats that have notes too unless a least severity is asked for: whoever reads them can sort and fold."""


def least_shown(output_format: str, asked: Severity | None, fail_on: Severity | None) -> Severity:
    """Least severity that a report shows; what makes the run fail is always shown.

    Args:
        output_format: One of `FORMATS`.
        asked: By option or setting; None: by neither.
        fail_on: Least severity that makes the run fail; None: none does.
    """
    usual = Severity.INFO if output_format in WITH_NOTES else Severity.WARNING
    return min((asked or usual, fail_on or Severity.ERROR), key=SEVERITIES.index)


@dataclass(frozen=True, slots=True)
class ReportOptions:
    """How a report is to look.

    Attributes:
        colour: Colours of a terminal (full, concise).
        ledger: Print the ledger too (full, concise); markdown, html and json always have it.
        statistics: Counts by rule in place of findings (full, concise).
        chosen: Whether rules were selected: then junit says of those without input what they lack.
        fail_on: Least severity that makes a junit test case fail; None: none does.
        least: Least severity that is shown; of what is below it people read how much there is.
    """

    colour: bool = False
    ledger: bool = False
    statistics: bool = False
    chosen: bool = False
    fail_on: Severity | None = Severity.ERROR
    least: Severity = Severity.INFO


def render(report: Report, output_format: str, options: ReportOptions) -> str:
    """A report as text, ending in a line break.

    Args:
        report: What was found.
        output_format: One of `FORMATS`.
        options: How it is to look.
    """
    text: str = renderer(output_format)(report, options)
    return text


def renderer(output_format: str) -> Any:
    """What writes a format; its module is imported, while there is something else to wait for.

    Args:
        output_format: One of `FORMATS`.
    """
    if output_format in ("full", "concise"):
        return getattr(import_module("actspec.report.text"), output_format)
    return import_module(f"actspec.report.{output_format}").render
