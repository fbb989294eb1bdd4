"""One line a finding; equal findings of many joints are one."""

from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.outcome import Report
from actspec.audit.report import ReportOptions
from actspec.audit.report.groups import told
from actspec.audit.report.style import Style
from actspec.audit.report.text import around


def render(report: Report, options: ReportOptions) -> str:
    """The report with one line a finding."""
    return around(report, options, _findings(report, Style(options.colour)))


def _findings(report: Report, style: Style) -> Iterator[str]:
    for group in told(report.findings):
        yield style.headline(group)
