"""SARIF 2.1.0, as code-scanning services read it.

Columns are counted in UTF-16 code units, which is what services assume that do not read `columnKind`.
Findings that were set aside are left out: services show suppressed results as open.
"""

from __future__ import annotations

import hashlib
import os
from collections import Counter
from typing import Any
from urllib.parse import quote

import actspec
from actspec.audit.baseline import entry_of, relative_path
from actspec.audit.finding import Fix
from actspec.audit.outcome import Report
from actspec.audit.pages import family, page
from actspec.audit.rule import Rule, sections
from actspec.diagnostics import Diagnostic, Severity, Span
from actspec.report import ReportOptions
from actspec.report.findings import FindingGroup, grouped
from actspec.report.sources import Sources
from actspec.report.terminal import json_text

SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"
ROOT = "%SRCROOT%"

LEVELS = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.INFO: "note"}
_PROBLEM = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.INFO: "recommendation"}


def render(report: Report, options: ReportOptions) -> str:
    """The report as a SARIF log."""
    return json_text(record(report, options.least))


def record(report: Report, least: Severity = Severity.INFO) -> dict[str, Any]:
    """The report as a SARIF log, as data.

    Args:
        report: What was found.
        least: Least severity of its results.
    """
    sources = Sources(report.case.files)
    places = {rule.code: index for index, rule in enumerate(report.rules)}
    groups = grouped(report.at_or_above(least), by_place=True)
    return {
        "$schema": SCHEMA,
        "version": "2.1.0",
        "runs": [
            {
                "tool": {
                    "driver": {
                        "name": "actspec",
                        "semanticVersion": actspec.__version__,
                        "rules": [_rule(rule) for rule in report.rules],
                    }
                },
                "columnKind": "utf16CodeUnits",
                "originalUriBaseIds": {ROOT: {"description": {"text": "The folder that actspec ran in."}}},
                "invocations": [
                    {
                        "executionSuccessful": report.complete,
                        "toolExecutionNotifications": [
                            _notification(item, sources) for item in report.diagnostics()
                        ],
                    }
                ],
                "results": list(_results(groups, places, sources)),
            }
        ],
    }


def location(path: str) -> dict[str, Any]:
    """A file: relative to the working folder where it lies below it, with everything unusual percent-encoded."""
    relative = relative_path(path, ".")
    if relative.startswith("../") or os.path.isabs(relative):
        absolute = os.path.realpath(path).replace(os.sep, "/")
        return {"uri": "file://" + quote("/" + absolute.lstrip("/"), errors="surrogateescape")}
    return {"uri": quote(relative, errors="surrogateescape"), "uriBaseId": ROOT}


def _rule(rule: type[Rule]) -> dict[str, Any]:
    title = sections(rule)[""]
    text = page(rule)
    return {
        "id": rule.code,
        "name": "".join(word.capitalize() for word in rule.name.split("-")),
        "shortDescription": {"text": title},
        "fullDescription": {"text": " ".join(sections(rule)["What it does"].split())},
        "help": {"text": text, "markdown": text},
        "defaultConfiguration": {"level": LEVELS[rule.severity]},
        "properties": {
            "tags": [family(rule)],
            "precision": rule.confidence.value,
            "problem.severity": _PROBLEM[rule.severity],
        },
    }


def _results(
    groups: tuple[FindingGroup, ...], places: dict[str, int], sources: Sources
) -> list[dict[str, Any]]:
    seen: Counter[str] = Counter()
    found = []
    for group in groups:
        finding = group.first.finding
        # Neither lines nor words: a finding is the same one after both have changed.
        fingerprint = _hash(repr(entry_of(finding, ".")) + ",".join(group.joints))
        seen[fingerprint] += 1
        result: dict[str, Any] = {
            "ruleId": finding.code,
            "ruleIndex": places[finding.code],
            "level": LEVELS[group.first.severity],
            "message": {"text": _message(group)},
            "locations": [_location(finding.span, group.joints, sources)],
            "partialFingerprints": {"actspecFinding/v2": f"{fingerprint}:{seen[fingerprint]}"},
            "properties": {"confidence": group.first.confidence.value},
        }
        related = group.related()
        if related:
            result["relatedLocations"] = [
                {"id": index, **_location(span, (), sources)} for index, span in enumerate(related)
            ]
        fixes = [_fix(item.finding.fix) for item in group.members if item.finding.fix is not None]
        if fixes:
            result["fixes"] = fixes
        found.append(result)
    return found


def _hash(text: str) -> str:
    """16 hexadecimal digits."""
    return hashlib.sha256(text.encode("utf-8", "replace")).hexdigest()[:16]


def _message(group: FindingGroup) -> str:
    """Message and help: services show nothing else of a result."""
    text = group.headline(most=8)
    help = group.first.finding.help
    text = f"{text}."
    if help:
        text += f" {help[0].upper()}{help[1:]}{'' if help.endswith('?') else '.'}"
    # `[words](address)` is a link in SARIF, and a joint may be called that.
    return text.replace("[", "\\[").replace("]", "\\]") if "](" in text else text


def _location(span: Span, joints: tuple[str, ...], sources: Sources) -> dict[str, Any]:
    physical: dict[str, Any] = {"artifactLocation": location(span.path)}
    if span.line:
        physical["region"] = _region(span, sources)
    found: dict[str, Any] = {"physicalLocation": physical}
    if joints:
        found["logicalLocations"] = [{"name": joint, "kind": "member"} for joint in joints]
    return found


def _region(span: Span, sources: Sources) -> dict[str, Any]:
    region: dict[str, Any] = {"startLine": span.line}
    if span.column:
        line = sources.line(span)
        region["startColumn"] = span.column if line is None else _units(line[: span.column - 1]) + 1
        if line is not None:
            # The rest of the line: a place has no end.
            region["endColumn"] = max(_units(line.rstrip()), region["startColumn"]) + 1
    return region


def _units(text: str) -> int:
    """Length in UTF-16 code units."""
    return len(text.encode("utf-16-le", "surrogatepass")) // 2


def _fix(fix: Fix) -> dict[str, Any]:
    changes: dict[str, list[dict[str, Any]]] = {}
    for edit in fix.edits:
        changes.setdefault(edit.path, []).append(
            {
                "deletedRegion": {"byteOffset": edit.start, "byteLength": edit.end - edit.start},
                "insertedContent": {"text": edit.new.decode("utf-8", "replace")},
            }
        )
    return {
        "description": {"text": f"{fix.title} ({fix.safety.value})"},
        "artifactChanges": [
            {"artifactLocation": location(path), "replacements": replacements}
            for path, replacements in changes.items()
        ],
    }


def _notification(item: Diagnostic, sources: Sources) -> dict[str, Any]:
    found: dict[str, Any] = {
        "descriptor": {"id": item.code},
        "level": LEVELS[item.severity],
        "message": {"text": f"{item.where}: {item.message}" if item.where else item.message},
    }
    if item.span is not None:
        found["locations"] = [_location(item.span, (), sources)]
    return found
