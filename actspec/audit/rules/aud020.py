from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.finding import quoted
from actspec.audit.rule import Case, Confidence, Finding, Rule, Severity
from actspec.diagnostics import Span, one_line


class RefusedModel(Rule):
    code = "AUD020"
    name = "refused-model"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding]:
        # In a folder it may be for another MuJoCo, or whole where it is installed: AUD013 says it.
        for file in case.files:
            for artifact in file.refused_models:
                message, help, severity = "the model does not compile in the installed MuJoCo", None, None
                if file.whole is not None:
                    whole = one_line(file.whole)
                    message, severity = (
                        f"the model compiles only in {whole}, which includes it",
                        Severity.INFO,
                    )
                    help = f"audit {whole} in its place"
                yield Finding(
                    self.code,
                    f"{message}, and is judged from its text alone: {artifact.text_only}",
                    artifact.refused_at or Span(file.path),
                    about=" ".join(quoted(artifact.text_only or "")),
                    help=help,
                    severity=severity,
                )
