from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.finding import quoted
from actspec.audit.rule import Case, Confidence, Finding, Rule, Severity
from actspec.diagnostics import Span


class RefusedModel(Rule):
    code = "AUD020"
    name = "refused-model"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding]:
        # In a folder it may be for another MuJoCo, or whole where it is installed: AUD013 says it.
        for file in case.files:
            for artifact in file.refused_models:
                yield Finding(
                    self.code,
                    f"the model does not compile, and is judged from its text alone: {artifact.text_only}",
                    artifact.refused_at or Span(file.path),
                    about=" ".join(quoted(artifact.text_only or "")),
                )
