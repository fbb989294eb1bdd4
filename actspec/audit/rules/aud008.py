from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.rule import Case, Confidence, Finding, Rule, Severity
from actspec.diagnostics import Span
from actspec.readings.artifact import FileReading


class Unreadable(Rule):
    code = "AUD008"
    name = "unreadable-file"
    severity = Severity.ERROR
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding]:
        for file in case.files:
            if not file.readable and not file.names_nothing:
                yield from self._of(file)

    def _of(self, file: FileReading) -> Iterator[Finding]:
        """What is wrong with the file, each at its place; the reader's reason where nothing has one."""
        errors = [item for item in file.diagnostics if item.severity is Severity.ERROR]
        # A file that was lost to a fault of actspec would have been read wherever it lies.
        lost = any(item.code == self.code for item in errors)
        severity = Severity.WARNING if file.in_folder and not lost else None
        for item in errors:
            if item.code != self.code:
                where = f"{item.where}: " if item.where else ""
                yield Finding(
                    self.code,
                    f"the file cannot be read: {where}{item.message} ({item.code})",
                    item.span or Span(file.path),
                    help=item.help,
                    severity=severity,
                )
        if lost or not errors:
            message = f"the file cannot be read: {file.reason}"
            yield Finding(self.code, message, Span(file.path), severity=severity)
