"""Markdown for a comment on a pull request: findings as a table, the ledger folded away."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from actspec.audit.outcome import Report
from actspec.diagnostics import Severity, listed, many
from actspec.report import ReportOptions
from actspec.report.findings import FindingGroup, for_people
from actspec.report.ledger import Sheet, comparisons, ledger_sheets
from actspec.report.tables import escaped, markdown_table
from actspec.report.text import (
    NOUNS,
    aside,
    counted,
    files_counted,
    left_out,
    of_folder,
    remarks,
    worst_first,
)

LONGEST = 60_000
"""Characters. Source: a GitHub comment takes 65 536; this leaves room for words around it."""


def render(report: Report, options: ReportOptions) -> str:
    """The report as Markdown; what does not fit into a comment is counted."""
    groups = worst_first(for_people(report.at_or_above(options.least)))
    notes = "; ".join((files_counted(report), *aside(report), *of_folder(report)))
    text = f"### actspec audit: {counted(groups)} in {notes}\n"
    for block in (
        _findings(groups),
        tuple(left_out(report, options.least)),
        _problems(report, options.least),
        _comparison(report),
        _ledger(report),
        _skipped(report),
    ):
        text += _fitting("\n".join(block), LONGEST - len(text))
    return text


def _fitting(block: str, room: int) -> str:
    """A block, or as many of its lines as there is room for."""
    if not block:
        return ""
    if len(block) + 2 <= room:
        return f"\n{block}\n"
    lines = block.split("\n")
    closing = "\n</details>" if lines[-1] == "</details>" else ""
    kept: list[str] = []
    for line in lines:
        if sum(map(len, kept)) + len(kept) + len(line) > room - 200:
            break
        kept.append(line)
    return "\n" + "\n".join(kept) + f"\n\n{len(lines) - len(kept)} more lines do not fit here.{closing}\n"


def _findings(groups: Sequence[FindingGroup]) -> Iterator[str]:
    rows: list[list[str]] = [["", "rule", "place", "joints", "finding"]]
    for group in groups:
        item, finding = group.first, group.first.finding
        text = escaped(finding.message + group.besides(4))
        if finding.help:
            text += f"<br>*{escaped(finding.help)}*"
        rule, joints = f"{finding.code}<br>{escaped(item.name)}", escaped(listed(group.joints, 4))
        rows.append([NOUNS[item.severity], rule, escaped(str(finding.span)), joints, text])
    if rows[1:]:
        yield from markdown_table(rows)


def _problems(report: Report, least: Severity) -> Iterator[str]:
    for item in remarks(report, least):
        place = f"{item.span}: " if item.span is not None else ""
        where = f"{item.where}: " if item.where else ""
        yield f"- **{item.code}** {escaped(place + where + item.message)}"


def _comparison(report: Report) -> Iterator[str]:
    for found in comparisons(report.case):
        sheet = found.sheet(found.sources)
        if sheet is not None:
            yield f"<details><summary>{escaped(sheet.title)}</summary>"
            yield ""
            yield from _table(sheet)
            yield ""
            yield "</details>"


def _table(sheet: Sheet, right: int | None = None) -> list[str]:
    rows = (sheet.titles(), *sheet.cells(most=4))
    return markdown_table([[escaped(cell) for cell in row] for row in rows], right)


def _ledger(report: Report) -> Iterator[str]:
    sheets = list(ledger_sheets(report.case))
    if not sheets:
        return
    yield "<details><summary>Ledger: what acts on each joint</summary>"
    for sheet in sheets:
        yield ""
        yield f"**{escaped(sheet.title)}**"
        yield ""
        yield from _table(sheet, right=2)
        for note in sheet.notes:
            yield ""
            yield escaped(note)
    yield ""
    yield "</details>"


def _skipped(report: Report) -> Iterator[str]:
    if not report.skipped:
        return
    count, reasons = report.did_not_apply()
    yield f"<details><summary>{many(count, 'rule')} did not apply</summary>"
    yield ""
    for reason, codes in reasons.items():
        yield f"- {escaped(reason)}: {', '.join(codes)}"
    yield ""
    yield "</details>"
