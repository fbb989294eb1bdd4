"""Markdown for a comment on a pull request: findings as a table, the ledger folded away."""

from __future__ import annotations

import re
from collections.abc import Iterator

from actspec.audit.outcome import Report
from actspec.diagnostics import Severity, listed, one_line
from actspec.report import ReportOptions
from actspec.report.columns import cell
from actspec.report.compare import comparisons
from actspec.report.findings import told
from actspec.report.ledger import ledger_tables
from actspec.report.text import counted, many

LONGEST = 60_000
"""Characters. Source: a GitHub comment takes 65 536; this leaves room for words around it."""

_SIGNS = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.INFO: "remark"}


def render(report: Report, options: ReportOptions) -> str:
    """The report as Markdown; what does not fit into a comment is counted."""
    read = sum(file.readable for file in report.case.files)
    text = f"### actspec audit: {counted(report)} in {many(read, 'file')}\n"
    for block in (
        _findings(report),
        _problems(report),
        _comparison(report),
        _ledger(report),
        _skipped(report),
    ):
        text += _fitting("\n".join(block), LONGEST - len(text))
    return text


def escaped(text: str) -> str:
    """Text of a stranger's file as it is: no markup, no HTML, nobody notified, nothing linked."""
    text = re.sub(r"([\\`*_\[\]|~$])", r"\\\1", one_line(text))
    text = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    # Services link names, issues and addresses in the finished text, where only a gap of no width stops them.
    text = re.sub(r"([@#])(?=\w)", r"\1&#8203;", text)
    return text.replace("://", ":&#8203;//").replace("www.", "www&#8203;.")


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


def _row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def _findings(report: Report) -> Iterator[str]:
    groups = told(report.findings)
    if not groups:
        return
    yield _row("", "rule", "place", "joints", "finding")
    yield _row("---", "---", "---", "---", "---")
    for group in groups:
        item, finding = group.first, group.first.finding
        text = escaped(finding.message + group.others(4) + group.elsewhere(4)) + (
            f"<br>*{escaped(finding.help)}*" if finding.help else ""
        )
        rule = f"{finding.code}<br>{escaped(item.name)}"
        yield _row(
            _SIGNS[item.severity], rule, escaped(str(finding.span)), escaped(listed(group.joints, 4)), text
        )


def _problems(report: Report) -> Iterator[str]:
    for item in report.told():
        place = f"{item.span}: " if item.span is not None else ""
        where = f"{item.where}: " if item.where else ""
        yield f"- **{item.code}** {escaped(place + where + item.message)}"


def _comparison(report: Report) -> Iterator[str]:
    for found in comparisons(report.case):
        lines = [line for line in found.lines if line.differs]
        if not lines:
            continue
        yield f"<details><summary>{escaped(found.robot)}: where the files disagree</summary>"
        yield ""
        yield _row("field", "joints", *map(escaped, found.sources), "ratio")
        yield _row(*("---" for _ in range(len(found.sources) + 3)))
        for line in lines:
            title = f"{line.column.title} [{line.unit}]" if line.unit else line.column.title
            yield _row(
                escaped(title), escaped(listed(line.joints, 4)), *map(cell, line.values), line.shown_ratio
            )
        yield ""
        yield "</details>"


def _ledger(report: Report) -> Iterator[str]:
    tables = list(ledger_tables(report.case))
    if not tables:
        return
    yield "<details><summary>Ledger: what acts on each joint</summary>"
    for found in tables:
        units = (column.unit(found.kind) for column in found.columns)
        titles = (
            f"{c.title} [{unit}]" if unit else c.title for c, unit in zip(found.columns, units, strict=True)
        )
        yield ""
        yield f"**{escaped(found.title)}**" + (f" (0 for all: {', '.join(found.zero)})" if found.zero else "")
        yield ""
        yield _row("joints", "control", *map(escaped, titles))
        yield _row("---", "---", *("---:" for _ in found.columns))
        for joints, control, cells in found.rows:
            yield _row(escaped(listed(joints, 4)), escaped(control), *cells)
        if found.legend:
            yield ""
            yield escaped(found.legend)
    yield ""
    yield "</details>"


def _skipped(report: Report) -> Iterator[str]:
    if not report.skipped:
        return
    by_reason: dict[str, list[str]] = {}
    for item in report.skipped:
        by_reason.setdefault(item.reason, []).append(item.code)
    count = len({item.code for item in report.skipped})
    yield f"<details><summary>Skipped for lack of input: {many(count, 'rule')}</summary>"
    yield ""
    for reason, codes in by_reason.items():
        yield f"- {escaped(reason)}: {', '.join(codes)}"
    yield ""
    yield "</details>"
