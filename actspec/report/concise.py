"""One line a finding; equal findings of many joints are one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from actspec.audit.outcome import Report
from actspec.report import ReportOptions
from actspec.report.findings import Group
from actspec.report.style import Style
from actspec.report.text import around


def render(report: Report, options: ReportOptions) -> str:
    """The report with one line a finding."""
    return around(report, options, _lines)


def _lines(groups: Iterable[Group], style: Style) -> Iterator[str]:
    return (style.headline(group) for group in groups)
