"""Text for people: findings with or without excerpts, and around them the ledger, counts and the summary."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from actspec.audit.outcome import Means, Report
from actspec.diagnostics import SEVERITIES, Diagnostic, Severity, Span, listed, many, one_line
from actspec.readings.named import counted_not_read
from actspec.report import ReportOptions
from actspec.report.findings import MOST_ALIKE, FindingGroup, counts, for_people
from actspec.report.ledger import ledger_lines
from actspec.report.sources import Sources
from actspec.report.tables import Style, table

MOST_REASONS = 3
"""Reasons why rules did not apply that are reported. Chosen: who asks for a few rules wants to know why one is silent,
who asks for all wants the findings; the formats for programs have them all."""

_MOST_JOINTS = 24
_MOST_PLACES = 8
_MOST_RELATED = 3

_AS_NAMED = "--as-named judges a folder of your own"

NOUNS = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.INFO: "note"}

_MEANS = {
    Means.INLINE: "ignored in the files",
    Means.IGNORE: "by ignore",
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
    groups = worst_first(for_people(report.at_or_above(options.least)))
    if options.statistics:
        groups = for_people(report.findings)
        lines += statistics(groups)
    else:
        for group in groups:
            lines.append(headline(group, style))
            if sources is not None:
                lines += [*_details(group, sources, style), ""]
        lines += [style.faint(line) for line in left_out(report, options.least)]
    lines += summary(report, style, groups, options)
    return "".join(f"{line}\n" for line in lines)


def worst_first(groups: Iterable[FindingGroup]) -> tuple[FindingGroup, ...]:
    """Errors, then warnings, then notes, each in the order of the report."""
    return tuple(sorted(groups, key=lambda group: -SEVERITIES.index(group.first.severity)))


def left_out(report: Report, least: Severity) -> Iterator[str]:
    """How much is not severe enough to be shown, in one line; nothing where all is shown.

    Of a folder much is a note that would be more of a file that was named: the line says how to have it so.

    Args:
        report: What was found.
        least: Least severity that is shown.
    """
    below = [item for item in report.findings if SEVERITIES.index(item.severity) < SEVERITIES.index(least)]
    found = [(group.first.severity, group.first.finding.code) for group in for_people(below)]
    shown = set(joined(report.for_people(least)))
    found += [(item.severity, item.code) for item in joined(report.for_people()) if item not in shown]
    counts = Counter(severity for severity, _ in found)
    parts = []
    for severity in reversed(SEVERITIES):
        codes = Counter(code for other, code in found if other is severity)
        if codes:
            names = listed(code for code, _ in sorted(codes.items(), key=lambda entry: (-entry[1], entry[0])))
            parts.append(f"{many(counts[severity], NOUNS[severity])} ({names})")
    if parts:
        shows = f"{', '.join(parts)}: --notes shows {'it' if sum(counts.values()) == 1 else 'them'}"
        if any(report.case.is_met_at(item.finding.span) for item in below):
            shows += f"; {_AS_NAMED}"
        more = sorted({item.finding.code for item in below if item.of_folder})
        yield f"{shows}, where those of {listed(more)} can be errors or warnings" if more else shows


def headline(group: FindingGroup, style: Style) -> str:
    """`path:line:col: CODE [severity] joints: message`."""
    item = group.first
    code = style.severity(item.finding.code, item.severity)
    return (
        f"{style.bold(str(item.finding.span))}: {code} [{item.severity.value}] {one_line(group.headline())}"
    )


def _details(group: FindingGroup, sources: Sources, style: Style) -> Iterator[str]:
    item, finding = group.first, group.first.finding
    yield from _excerpt(sources, finding.span, style)
    if len(group.joints) > 2:
        yield f"  = joints: {one_line(listed(group.joints, _MOST_JOINTS))}"
    also_on = group.also_on(_MOST_PLACES)
    if also_on:
        yield f"  = {also_on}"
    if len(group.copies) > 2:
        yield f"  = {group.how} in {listed([str(span) for span in group.copies], _MOST_PLACES)}"
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


def statistics(groups: Iterable[FindingGroup]) -> list[str]:
    """Counts by rule, the worst first, of those the most frequent.

    Args:
        groups: The findings as they would be shown.
    """
    found = Counter(
        (group.first.finding.code, group.first.name, group.first.severity.value) for group in groups
    )
    severities = [severity.value for severity in reversed(SEVERITIES)]
    rows = sorted(found.items(), key=lambda entry: (severities.index(entry[0][2]), -entry[1], entry[0]))
    return table([(str(count), *key) for key, count in rows], "", headings=0)


def summary(
    report: Report, style: Style, groups: Sequence[FindingGroup], options: ReportOptions
) -> Iterator[str]:
    """How much was found and set aside, and which rules did not apply.

    Args:
        report: What was found.
        style: How it is to look.
        groups: The findings as they are shown.
        options: Who asks for all rules need not read which had nothing to judge.
    """
    count, reasons = report.did_not_apply() if options.chosen else (0, {})
    if len(reasons) <= MOST_REASONS:
        for reason, codes in reasons.items():
            yield style.faint(f"{listed(codes)} did not apply: {one_line(reason)}")
    else:
        yield style.faint(f"{many(count, 'rule')} did not apply; --select CODE reports why")
    notes = [*aside(report), *of_folder(report)]
    gone = sum(file.names_nothing for file in report.case.files)
    if gone:
        notes.insert(0, f"nothing to audit at {many(gone, 'path')}")
    # A warning about a file as a whole is none of a rule's.
    told = sum(item.severity is Severity.WARNING for item in joined(report.for_people(options.least)))
    if told:
        notes.insert(0, f"{many(told, 'warning')} about files")
    found = counted(groups)
    if report.findings and not groups:
        found = "no errors" if told else "no errors or warnings"
    yield f"{found} in {files_counted(report)}" + "".join(f"; {text}" for text in notes)


def aside(report: Report) -> Iterator[str]:
    """How many findings were set aside and how, and what was not looked at: `14 in the baseline`."""
    counts = Counter(item.means for item in report.suppressed)
    yield from (f"{counts[means]} {text}" for means, text in _MEANS.items() if counts[means])
    parts = zip(report.excluded, ("file", "folder"), strict=True)
    left = " and ".join(many(count, noun) for count, noun in parts if count)
    if left:
        yield f"{left} left out by exclude"
    if report.not_read:
        yield counted_not_read(report.not_read)


def of_folder(report: Report) -> Iterator[str]:
    """How to have a folder without findings judged as one's own: files are put together then that are not before.

    Where it has some, the line that counts its notes says so.
    """
    case = report.case
    met = any(map(case.is_met, range(len(case.artifacts))))
    if met and not any(case.is_met_at(item.finding.span) for item in report.findings):
        yield _AS_NAMED


def files_counted(report: Report) -> str:
    """How many files were there, and how many of them could not be read: `3 files, 1 of which could not be read`."""
    there = [file for file in report.case.files if not file.names_nothing]
    unread = sum(not file.readable for file in there)
    text = many(len(there), "file")
    if not unread:
        return text
    if unread < len(there):
        return f"{text}, {unread} of which could not be read"
    return f"{text}, none of which could be read" if unread > 1 else f"{text}, which could not be read"


def counted(groups: Iterable[FindingGroup]) -> str:
    """`2 errors, 1 warning affecting 13 joints`; of a configuration whose joints nobody names, `2 patterns of joints`.

    Args:
        groups: The findings as they are shown: what is equal for many joints counts once.
    """
    found = counts(groups)
    of_each = zip((found.errors, found.warnings, found.notes), reversed(SEVERITIES), strict=True)
    parts = [many(count, NOUNS[severity]) for count, severity in of_each if count]
    affected = [many(found.joints, "joint")] if found.joints else []
    affected += [f"{many(found.patterns, 'pattern')} of joints"] if found.patterns else []
    return ", ".join(parts) + (f" affecting {' and '.join(affected)}" if affected else "") or "no findings"


def joined(items: Iterable[Diagnostic]) -> Iterator[Diagnostic]:
    """What readers and rules have to say, the same of many joints once."""
    groups: dict[tuple[object, ...], list[Diagnostic]] = {}
    for item in items:
        place = item.span.path if item.span is not None and item.where else item.span
        groups.setdefault((item.code, place, item.message, item.help, not item.where), []).append(item)
    for group in groups.values():
        yield replace(group[0], where=listed(dict.fromkeys(item.where for item in group)))


def remarks(report: Report, least: Severity) -> Iterator[Diagnostic]:
    """What readers and rules have to say: of one code and many files the first, and which others there are.

    Args:
        report: What was found.
        least: Least severity that is shown; with notes each remark is shown by itself.
    """
    by_code: dict[tuple[str, Severity], list[Diagnostic]] = {}
    for item in joined(report.for_people(least)):
        by_code.setdefault((item.code, item.severity), []).append(item)
    for (_, severity), items in by_code.items():
        if len(items) <= MOST_ALIKE or severity is Severity.ERROR or least is Severity.INFO:
            yield from items
            continue
        places = listed(dict.fromkeys(item.span.path for item in items[1:] if item.span is not None), 3)
        more = f" ({len(items) - 1} more of {items[0].code} in {places}: --notes shows them)"
        yield replace(items[0], message=items[0].message + more)
