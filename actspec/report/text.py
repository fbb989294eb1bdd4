"""Text for people: findings with or without excerpts, and around them the ledger, counts and the summary."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

from actspec.audit.outcome import SEVERITIES, Means, Report
from actspec.diagnostics import Severity, Span, listed, one_line
from actspec.report import ReportOptions
from actspec.report.findings import FindingGroup, for_people
from actspec.report.ledger import ledger_lines
from actspec.report.sources import Sources
from actspec.report.tables import Style, many, table

MOST_REASONS = 3
"""Reasons why rules did not apply that are reported. Chosen: who asks for a few rules wants to know why one is silent,
who asks for all wants the findings; the formats for programs have them all."""

_MOST_JOINTS = 24
_MOST_PLACES = 8
_MOST_RELATED = 3

NOUNS = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.INFO: "note"}

_MEANS = {
    Means.INLINE: "ignored in the files",
    Means.SETTING: "by per-file-ignores",
    Means.BASELINE: "in the baseline",
    Means.CONFIDENCE: "below --min-confidence",
}


def concise(report: Report, options: ReportOptions) -> str:
    """The report with one line a finding."""
    return _whole(report, options, None)


def full(report: Report, options: ReportOptions) -> str:
    """The report with the text that each finding is about, the help, and the other places."""
    return _whole(report, options, Sources(report.case.files))


def _whole(report: Report, options: ReportOptions, sources: Sources | None) -> str:
    style = Style(options.colour)
    lines: list[str] = []
    if options.ledger:
        lines += [*ledger_lines(report.case, style), ""]
    groups = for_people(report.findings)
    if options.statistics:
        lines += statistics(report)
    else:
        for group in groups:
            lines.append(headline(group, style))
            if sources is not None:
                lines += [*_details(group, sources, style), ""]
    return "".join(f"{line}\n" for line in (*lines, *summary(report, style, groups)))


def headline(group: FindingGroup, style: Style) -> str:
    """`path:line:col: CODE [severity] joints: message`."""
    item = group.first
    code = style.severity(item.finding.code, item.severity)
    return (
        f"{style.bold(str(item.finding.span))}: {code} [{item.severity.value}] {one_line(group.headline())}"
    )


def _details(group: FindingGroup, sources: Sources, style: Style) -> Iterator[str]:
    item, finding = group.first, group.first.finding
    if group.copy_of is not None:
        yield f"  = same as {style.bold(str(group.copy_of))}"
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


def statistics(report: Report) -> list[str]:
    """Counts by rule, the most frequent first."""
    counts = Counter((item.finding.code, item.name, item.severity.value) for item in report.findings)
    rows = sorted(counts.items(), key=lambda entry: (-entry[1], entry[0]))
    return table([(str(count), *key) for key, count in rows], "", headings=0)


def summary(report: Report, style: Style, groups: Sequence[FindingGroup]) -> Iterator[str]:
    """How much was found and set aside, and which rules did not apply.

    Args:
        report: What was found.
        style: How it is to look.
        groups: The findings as they are shown.
    """
    count, reasons = report.did_not_apply()
    if len(reasons) <= MOST_REASONS:
        for reason, codes in reasons.items():
            yield style.faint(f"{listed(codes)} did not apply: {one_line(reason)}")
    else:
        yield style.faint(f"{many(count, 'rule')} did not apply; --select CODE reports why")
    aside = Counter(item.means for item in report.suppressed)
    notes = [f"{aside[means]} {text}" for means, text in _MEANS.items() if aside[means]]
    unread = sum(not file.readable for file in report.case.files)
    if unread:
        notes.insert(0, f"{many(unread, 'file')} could not be read")
    read = many(len(report.case.files) - unread, "file")
    yield f"{counted(groups)} in {read}" + "".join(f"; {text}" for text in notes)


def counted(groups: Iterable[FindingGroup]) -> str:
    """`2 errors, 1 warning affecting 13 joints`; `no findings`.

    Args:
        groups: The findings as they are shown: what is equal for many joints counts once.
    """
    counts: Counter[Severity] = Counter()
    joints: set[str] = set()
    for group in groups:
        counts[group.first.severity] += 1
        joints.update(item.finding.joint for item in (*group.members, *group.alike) if item.finding.joint)
    parts = [many(counts[severity], NOUNS[severity]) for severity in reversed(SEVERITIES) if counts[severity]]
    affected = f" affecting {many(len(joints), 'joint')}" if joints else ""
    return ", ".join(parts) + affected if parts else "no findings"
