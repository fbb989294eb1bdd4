"""Findings with the text that they are about, the help, and the other places."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from actspec.audit.outcome import Report
from actspec.diagnostics import Span, listed, one_line
from actspec.report import ReportOptions
from actspec.report.findings import Group
from actspec.report.sources import Sources
from actspec.report.style import Style
from actspec.report.text import around

_MOST_JOINTS = 24
_MOST_PLACES = 8
_MOST_RELATED = 3


def render(report: Report, options: ReportOptions) -> str:
    """The report with excerpts."""
    sources = Sources(report.case.files)

    def lines_of(groups: Iterable[Group], style: Style) -> Iterator[str]:
        for group in groups:
            yield from _group(group, sources, style)
            yield ""

    return around(report, options, lines_of)


def _group(group: Group, sources: Sources, style: Style) -> Iterator[str]:
    item, finding = group.first, group.first.finding
    yield style.headline(group)
    if group.copy_of is not None:
        yield f"  = as in {style.bold(str(group.copy_of))}"
        return
    yield from _excerpt(sources, finding.span, style)
    if len(group.joints) > 2:
        yield f"  = joints: {one_line(listed(group.joints, _MOST_JOINTS))}"
    also_on = group.also_on(_MOST_PLACES)
    if also_on:
        yield f"  = {also_on}"
    if len(group.copies) > 2:
        yield f"  = the same{group.of_others} in {listed([str(span) for span in group.copies], _MOST_PLACES)}"
    if finding.help:
        yield f"  = help: {one_line(finding.help)}"
    fix = finding.fix
    if fix is not None:
        flag = "--fix" if fix.safety.value == "safe" else "--unsafe-fixes"
        yield f"  = fix: {one_line(fix.title)} ({flag})"
    related = group.related()
    if related:
        yield f"  = see {style.bold(str(related[0]))}"
        yield from _excerpt(sources, related[0], style)
    if len(related) > 1:
        yield f"  = see also {listed([str(span) for span in related[1:]], _MOST_RELATED)}"
    yield style.faint(
        f"  = rule: {item.name}, {item.confidence.value} confidence; `actspec rule {finding.code}`"
    )


def _excerpt(sources: Sources, span: Span, style: Style) -> Iterator[str]:
    for line in sources.excerpt(span):
        margin, bar, text = line.partition("|")
        yield "  " + style.faint(margin + bar) + (style.bold(text) if text.strip() == "^" else text)
