from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.finding import quoted
from actspec.audit.rule import Case, Confidence, Finding, Rule, Severity
from actspec.audit.selection import DIAGNOSTICS
from actspec.diagnostics import Span
from actspec.readings.artifact import FileKind


class NotTaken(Rule):
    code = "AUD022"
    name = "not-taken"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding]:
        # In a folder, of a file that no program names, it is a remark.
        for file in case.files:
            for item in file.not_taken:
                # Of a URDF it is a joint, of a deploy file a key.
                joint = item.where if file.kind is FileKind.URDF else ""
                key = "" if joint else item.where
                yield Finding(
                    self.code,
                    f"{key}: {item.message} ({item.code})" if key else f"{item.message} ({item.code})",
                    item.span or Span(file.path),
                    joint,
                    help=item.help,
                    about=" ".join((item.code, *filter(None, (key,)), *quoted(item.message))),
                    names=tuple(filter(None, (item.code, DIAGNOSTICS.get(item.code)))),
                )
