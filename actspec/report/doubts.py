"""Numbers of a spec that can hardly be right: which of the diagnostics they are, and what `--strict` prints of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from actspec.diagnostics import Diagnostic, Severity, many
from actspec.spec.plausible import BY_CODE


def doubts(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Warnings of the checks of numbers; an error stops every command anyway."""
    return [item for item in diagnostics if item.code in BY_CODE and item.severity is Severity.WARNING]


def refusal(found: Sequence[Diagnostic]) -> Iterator[str]:
    """What `--strict` prints where there are such numbers."""
    if not found:
        return
    yield f"--strict: {many(len(found), 'number')} that can hardly be right"
    yield (
        "  help: correct them; or keep one with `sure: true` beside its `value`, or all of a check with "
        f'`accept: {{spec.{found[0].code}: "the reason"}}`'
    )
