"""`actspec-report/1`: the audit for programs. SI units at the joint; null is unknown; `Infinity` is no limit."""

from __future__ import annotations

from typing import Any

from actspec.audit.outcome import Report, Reported
from actspec.diagnostics import Severity, one_line
from actspec.readings.artifact import FileReading
from actspec.readings.ledger import LedgerRow
from actspec.report import ReportOptions
from actspec.report.findings import counts, for_people
from actspec.report.ledger import JSON_FIELDS, JSON_FLAGS
from actspec.report.terminal import diagnostic_record, json_number, json_text

FORMAT = "actspec-report/1"


def render(report: Report, options: ReportOptions) -> str:
    """The report as one JSON object."""
    return json_text(record(report, options.least))


def record(report: Report, least: Severity = Severity.INFO) -> dict[str, Any]:
    """The report as data.

    Args:
        report: What was found.
        least: Least severity of its findings.
    """
    return {
        "format": FORMAT,
        "files": [_file(file) for file in report.case.files],
        "ledger": [_row(row) for row in report.case.rows],
        "findings": [_finding(item) for item in report.at_or_above(least)],
        "shown_as": counts(for_people(report.at_or_above(least)))._asdict(),
        "skipped": [{"code": item.code, "reason": item.reason} for item in report.skipped],
        "diagnostics": [diagnostic_record(item) for item in report.diagnostics()],
    }


def _file(file: FileReading) -> dict[str, Any]:
    reason = None if file.reason is None else one_line(file.reason)
    kind = None if file.kind is None else file.kind.value
    return {"path": file.path, "kind": kind, "readable": file.readable, "reason": reason}


def _row(row: LedgerRow) -> dict[str, Any]:
    return {
        "file": row.file,
        "line": row.span.line or None,
        "joint": row.joint,
        "actuator": row.actuator,
        "control": row.control,
        "drives": row.drives or None,
        **{field: json_number(getattr(row, field)) for field in JSON_FIELDS},
        **{field: getattr(row, field) for field in JSON_FLAGS},
    }


def _finding(item: Reported) -> dict[str, Any]:
    finding = item.finding
    return {
        "code": finding.code,
        "name": item.name,
        "severity": item.severity.value,
        "confidence": item.confidence.value,
        "file": finding.span.path,
        "line": finding.span.line or None,
        "column": finding.span.column or None,
        "joint": finding.joint or None,
        "message": finding.message,
        "value": json_number(finding.value),
        "unit": finding.unit,
        "expected": json_number(finding.expected),
        "help": finding.help,
        "fix": finding.fix.safety.value if finding.fix is not None else None,
        "explained_by": item.cause.code if item.cause is not None else None,
    }
