"""What `--strict` prints: of numbers that can hardly be right, and of approximations that a spec does not accept."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from actspec.diagnostics import Diagnostic, Severity, many
from actspec.ir import Approximation
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


def refused_losses(losses: Sequence[Approximation], then: str = "") -> Iterator[str]:
    """What `--strict` prints of approximations that the spec does not accept.

    Args:
        losses: The approximations.
        then: What follows from that, after the first line.
    """
    if not losses:
        return
    keys = sorted({loss.key for loss in losses})
    yield f"--strict: {many(len(keys), 'approximation')} that the spec does not accept{then}"
    for key in keys:
        count = sum(loss.key == key for loss in losses)
        yield f"  {key} ({many(count, 'joint')})"
    yield f'  help: accept one with `accept: {{{keys[0]}: "the reason"}}` in the spec'
