"""What stands around the findings in text: files that could not be read, the ledger, counts, the summary."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator

from actspec.audit.outcome import SEVERITIES, Means, Report
from actspec.diagnostics import Severity, listed, one_line
from actspec.report import ReportOptions
from actspec.report.findings import Group, told
from actspec.report.ledger import ledger_lines
from actspec.report.style import Style
from actspec.report.tables import table

MOST_REASONS = 3
"""Reasons for skipping rules that are told. Chosen: who asks for a few rules wants to know why one is silent, who asks
for all wants the findings; the formats for programs have them all."""

_MEANS = {
    Means.INLINE: "ignored in the files",
    Means.SETTING: "by per-file-ignores",
    Means.BASELINE: "in the baseline",
    Means.CONFIDENCE: "below --min-confidence",
}


def around(
    report: Report, options: ReportOptions, lines_of: Callable[[Iterable[Group], Style], Iterable[str]]
) -> str:
    """A whole text report.

    Args:
        report: What was found.
        options: How it is to look.
        lines_of: Gives the lines of the findings.
    """
    style = Style(options.colour)
    lines: list[str] = []
    if options.ledger:
        lines += [*ledger_lines(report.case, style), ""]
    groups = told(report.findings)
    lines += statistics(report) if options.statistics else lines_of(groups, style)
    return "".join(f"{line}\n" for line in (*lines, *summary(report, style, len(groups))))


def statistics(report: Report) -> list[str]:
    """Counts by rule, the most frequent first."""
    counts = Counter((item.finding.code, item.name, item.severity.value) for item in report.findings)
    rows = sorted(counts.items(), key=lambda entry: (-entry[1], entry[0]))
    return table([(str(count), *key) for key, count in rows], "", headings=0)


def summary(report: Report, style: Style, entries: int) -> Iterator[str]:
    """How much was found, set aside and skipped.

    Args:
        report: What was found.
        style: How it is to look.
        entries: As what the findings are told: one is of one joint, what is equal is one entry.
    """
    skipped: dict[str, list[str]] = {}
    for item in report.skipped:
        skipped.setdefault(item.reason, []).append(item.code)
    if len(skipped) <= MOST_REASONS:
        for reason, codes in skipped.items():
            yield style.faint(f"skipped {listed(codes)}: {one_line(reason)}")
    else:
        count = len({item.code for item in report.skipped})
        yield style.faint(
            f"skipped {many(count, 'rule')} for lack of input; what one of them lacks: --select CODE"
        )
    aside = Counter(item.means for item in report.suppressed)
    notes = [f"{aside[means]} {text}" for means, text in _MEANS.items() if aside[means]]
    unread = sum(not file.readable for file in report.case.files)
    if unread:
        notes.insert(0, f"{many(unread, 'file')} could not be read")
    read = many(len(report.case.files) - unread, "file")
    joined = f" ({entries} entr{'y' if entries == 1 else 'ies'})" if entries < len(report.findings) else ""
    yield f"{counted(report)}{joined} in {read}" + "".join(f"; {text}" for text in notes)


def counted(report: Report) -> str:
    """`2 errors, 1 warning`; `no findings`."""
    counts = Counter(item.severity for item in report.findings)
    nouns = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.INFO: "remark"}
    parts = [many(counts[severity], nouns[severity]) for severity in reversed(SEVERITIES) if counts[severity]]
    return ", ".join(parts) or "no findings"


def many(count: int, noun: str) -> str:
    """A count with its noun."""
    return f"{count} {noun}{'s' * (count != 1)}"
