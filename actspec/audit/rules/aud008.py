from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.finding import quoted
from actspec.audit.rule import Case, Confidence, Finding, Rule, Severity
from actspec.diagnostics import Span
from actspec.readings.artifact import FileKind, FileReading


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
        # A spec is nobody's but the user's, wherever it lies.
        named = not file.in_folder or file.kind is FileKind.SPEC
        # A file that was lost to a fault of actspec would have been read wherever it lies.
        lost = any(item.code == self.code for item in errors)
        reasons = [item for item in errors if item.code != self.code]
        # In a folder it may be no robot, a template, or whole at its destination; whoever loads it is told at once.
        severity = None if named or lost else Severity.INFO
        # Of a file that somebody has in a folder, one reason is enough to pass over it or to look at it.
        for item in reasons if named else reasons[:1]:
            where = f"{item.where}: " if item.where else ""
            count = len(reasons) - 1
            more = f"{count} more reason{'s' * (count != 1)}: audit the file by its name"
            help = item.help if named or len(reasons) == 1 else more
            yield Finding(
                self.code,
                f"the file cannot be read: {where}{item.message} ({item.code})",
                item.span or Span(file.path),
                help=help,
                severity=severity,
                about=" ".join((item.code, *quoted(item.message))),
            )
        if lost or not errors:
            message = f"the file cannot be read: {file.reason}"
            yield Finding(self.code, message, file.place, severity=severity, about=" ".join(quoted(message)))
