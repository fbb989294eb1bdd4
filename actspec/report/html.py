"""The report of an audit as one page."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Sequence
from html import escape

import actspec
from actspec.audit.outcome import Report
from actspec.audit.pages import page
from actspec.audit.rule import Rule
from actspec.diagnostics import SEVERITIES, Severity, Span, listed, many
from actspec.readings.artifact import FileReading
from actspec.report import ReportOptions
from actspec.report.findings import FindingGroup, for_people
from actspec.report.ledger import comparisons, ledger_sheets, sheet_table
from actspec.report.page import fold, plain, whole
from actspec.report.sources import Sources
from actspec.report.text import aside, counted, worst_first

_MOST_OPEN = 8
"""So many files or tables are shown, more are folded away. Chosen: they fit on a screen."""


def render(report: Report, options: ReportOptions) -> str:
    """The report as one page."""
    groups = worst_first(for_people(report.at_or_above(options.least)))
    body = (
        *_head(report, options, groups),
        *_findings(report, groups),
        *_comparisons(report),
        *_ledger(report),
        *_files(report),
        *_rules(report, options),
        f'<p class="faint">actspec {escape(actspec.__version__)}</p>',
    )
    return whole(f"actspec audit: {counted(groups)}", body)


def _head(report: Report, options: ReportOptions, groups: Sequence[FindingGroup]) -> Iterator[str]:
    yield f"<h1>actspec audit: {plain(counted(groups))}</h1>"
    problems = report.for_people(options.least)
    if problems:
        lines = "".join(f"<li>{plain(str(item).partition(chr(10))[0])}</li>" for item in problems)
        yield f"<ul>{lines}</ul>"
    counts = Counter((item.severity, item.finding.code, item.name) for item in (g.first for g in groups))
    if counts:
        heads = "<th>rule</th><th>severity</th><th>findings</th>"
        yield f'<div class="wide"><table><tr>{heads}</tr>'
        for (severity, code, name), count in sorted(counts.items(), key=_worst_first):
            yield (
                f'<tr class="{severity.value}"><td>{_link(code)} {plain(name)}</td>'
                f'<td class="severity">{severity.value}</td><td class="n">{count}</td></tr>'
            )
        yield "</table></div>"
    left = "; ".join(aside(report))
    if left:
        yield f'<p class="faint">Not shown: {plain(left)}.</p>'


def _worst_first(entry: tuple[tuple[Severity, str, str], int]) -> tuple[int, int, str]:
    (severity, code, _), count = entry
    return -SEVERITIES.index(severity), -count, code


def _link(code: str) -> str:
    return f'<a href="#rule-{plain(code)}">{plain(code)}</a>'


def _state(file: FileReading) -> str:
    return "read" if file.reason is None else f"not read: {file.told}"


def _files(report: Report) -> Iterator[str]:
    files = report.case.files
    if files:
        yield "<h2>Files</h2>"
        unread = sum(not file.readable for file in files)
        title = many(len(files), "file") + (f", {unread} not read" if unread else "")
        yield from fold(title, _file_table(files), shown=len(files) <= _MOST_OPEN)


def _file_table(files: Sequence[FileReading]) -> Iterator[str]:
    yield '<div class="wide"><table><tr><th>file</th><th>kind</th><th>robots</th><th>state</th></tr>'
    for file in files:
        names = ", ".join(artifact.name for artifact in file.artifacts)
        kind = file.kind.value if file.kind is not None else ""
        yield (
            f'<tr><td class="long">{plain(file.path)}</td><td>{plain(kind)}</td><td>{plain(names)}</td>'
            f'<td class="long">{plain(_state(file))}</td></tr>'
        )
    yield "</table></div>"


def _findings(report: Report, groups: Sequence[FindingGroup]) -> Iterator[str]:
    sources = Sources(report.case.files)
    if groups:
        yield "<h2>Findings</h2>"
    for group in groups:
        yield from _finding(group, sources)


def _finding(group: FindingGroup, sources: Sources) -> Iterator[str]:
    item, finding = group.first, group.first.finding
    severity = item.severity.value
    yield f'<article class="{severity}">'
    rule = f"{_link(finding.code)} {plain(item.name)}"
    yield f'<p class="place">{plain(str(finding.span))}</p>'
    yield f'<p><span class="severity">{severity}</span> {rule}, {item.confidence.value} confidence</p>'
    joints = f"<strong>{plain(listed(group.joints, 12))}</strong>: " if group.joints else ""
    yield f"<p>{joints}{plain(finding.message + group.besides(4))}</p>"
    yield from _excerpt(finding.span, sources)
    also_on = group.also_on(12)
    if also_on:
        yield f'<p class="faint">{also_on}</p>'
    if len(group.copies) > 2:
        yield f'<p class="place">{group.how} in {plain(listed([str(span) for span in group.copies], 12))}</p>'
    if finding.help:
        yield f"<p>Help: {plain(finding.help)}</p>"
    for span in group.related()[:4]:
        yield f'<p class="place">see {plain(str(span))}</p>'
        yield from _excerpt(span, sources)
    yield "</article>"


def _excerpt(span: Span, sources: Sources) -> Iterator[str]:
    lines = list(sources.excerpt(span))[1:]
    if lines:
        yield f"<pre>{escape(chr(10).join(lines))}</pre>"


def _comparisons(report: Report) -> Iterator[str]:
    found = list(comparisons(report.case))
    if found:
        yield "<h2>Joint by file</h2>"
    for comparison in found:
        # Paths are long: the folders that they share stand once.
        folder = _shared_folder(comparison.sources)
        names = [source.removeprefix(folder) for source in comparison.sources]
        below = f'<p class="faint">below {plain(folder)}</p>' if folder else ""
        for differs in (True, False):
            sheet = comparison.sheet(names, differs)
            if sheet is not None:
                title = sheet.title if differs else f"{sheet.title} ({many(len(sheet.rows), 'line')})"
                yield from fold(title, sheet_table(sheet, "file", below), shown=differs)


def _shared_folder(paths: Sequence[str]) -> str:
    """The folder that all are in, with a `/` at its end; "" when there is none to speak of."""
    try:
        folder = os.path.commonpath([os.path.dirname(path) for path in paths])
    except ValueError:  # absolute and relative ones, or several drives
        return ""
    return os.path.join(folder, "") if folder.strip(os.sep) else ""


def _ledger(report: Report) -> Iterator[str]:
    sheets = list(ledger_sheets(report.case))
    if sheets:
        yield "<h2>Ledger: what acts on each joint</h2>"
    for sheet in sheets:
        yield from fold(sheet.title, sheet_table(sheet), shown=len(sheets) <= _MOST_OPEN)


def _rules(report: Report, options: ReportOptions) -> Iterator[str]:
    found = {item.finding.code for item in report.at_or_above(options.least)}
    rules = [rule for rule in report.rules if rule.code in found]
    if rules:
        yield "<h2>Rules</h2>"
    for rule in rules:
        yield from _rule(rule)
    if report.skipped:
        count, reasons = report.did_not_apply()
        title = f"{many(count, 'rule')} did not apply"
        lines = "".join(f"<li>{plain(reason)}: {', '.join(codes)}</li>" for reason, codes in reasons.items())
        yield from fold(title, iter((f"<ul>{lines}</ul>",)), shown=False)


def _rule(rule: type[Rule]) -> Iterator[str]:
    # A link to what is inside opens it, one to the fold itself does not.
    text = f'<pre id="rule-{plain(rule.code)}">{escape(page(rule))}</pre>'
    yield from fold(f"{rule.code} {rule.name}", iter((text,)), shown=False)
