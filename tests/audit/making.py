"""Cases and rules made by hand, for tests of what comes after reading."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.diagnostics import Severity, Span
from actspec.readings.artifact import Artifact, FileKind, FileReading, Robot
from actspec.readings.ledger import LedgerRow
from actspec.robot.view import ModelFile


def reading(path: str, data: bytes, kind: FileKind = FileKind.MJCF) -> FileReading:
    """A file that was read."""
    return FileReading(path, kind, None, (Artifact(path, kind, "leg"),), (ModelFile(path, "", data),))


def case_of(files: Mapping[str, bytes] | None = None, *rows: LedgerRow, unread: tuple[str, ...] = ()) -> Case:
    """A case of files, one robot each, and of files that could not be read."""
    readings = [reading(path, data, kind_of(path)) for path, data in (files or {}).items()]
    artifacts = tuple(artifact for item in readings for artifact in item.artifacts)
    bad = [FileReading(path, None, "there is no such file") for path in unread]
    robots = tuple(Robot("leg", (index,)) for index in range(len(artifacts)))
    return Case((*readings, *bad), artifacts, rows, robots)


def kind_of(path: str) -> FileKind:
    """By its ending."""
    kinds = {"xml": FileKind.MJCF, "urdf": FileKind.URDF, "py": FileKind.CFG, "yaml": FileKind.DEPLOY}
    return kinds[path.rpartition(".")[2]]


def row(path: str, joint: str, artifact: int = 0, **fields: Any) -> LedgerRow:
    """A ledger row."""
    fields = {"control": "motor", "actuator": "", **fields}
    return LedgerRow(path, artifact, Span(path, 1, 1), joint, **fields)


PAGE = """# LIM901 made-rule

A made rule.

## What it does

Finds what it is told to.

## Why it matters

For tests.

## Example

None.

## Use instead

None.

## Source

Chosen.
"""


def rule_of(code: str, name: str, *found: Finding | Skipped | Exception, **attributes: Any) -> type[Rule]:
    """A rule that finds what it is told to, and breaks off at an exception."""

    class Made(Rule):
        @classmethod
        def text(cls) -> str:
            return PAGE

        def check(self, case: Case) -> Iterator[Finding | Skipped]:
            for item in found:
                if isinstance(item, Exception):
                    raise item
                yield item

    Made.code, Made.name = code, name
    Made.severity = attributes.get("severity", Severity.WARNING)
    Made.confidence = attributes.get("confidence", Confidence.HIGH)
    Made.options = attributes.get("options", {})
    return Made


def finding(code: str, path: str = "a.xml", line: int = 1, column: int = 1, **fields: Any) -> Finding:
    """A finding."""
    fields = {"message": "wrong", **fields}
    return Finding(code, span=Span(path, line, column), **fields)
