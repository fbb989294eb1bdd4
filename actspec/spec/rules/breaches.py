"""How a breach of a rule is told."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector
from actspec.patterns import PatternError, compile_pattern
from actspec.spec.paths import Path, dotted

if TYPE_CHECKING:
    from actspec.spec.document import SourceMap


@dataclass(frozen=True, slots=True)
class Breaches:
    """Takes breaches with their place.

    Attributes:
        spans: Where what is written.
        collector: Takes the diagnostics.
        left_out: Sections and named parts about which nothing is said.
    """

    spans: SourceMap
    collector: Collector
    left_out: frozenset[Path]

    def error(
        self, code: str, message: str, path: Path, help: str | None = None, *, key: bool = False
    ) -> None:
        """Add a breach at a value, or at its key."""
        if path[:1] in self.left_out or path[:2] in self.left_out:
            return
        span = self.spans.key(path) if key else self.spans.value(path)
        self.collector.error(code, message, where=dotted(path), span=span, help=help)


def check_pattern(pattern: str, path: Path, breaches: Breaches, *, key: bool = False) -> None:
    """A joint pattern can be matched."""
    try:
        compile_pattern(pattern)
    except PatternError as err:
        breaches.error("SPEC122", err.message, path, err.help, key=key)


def is_folder_name(name: str) -> bool:
    """Whether a name is safe as a folder on every system and as part of an identifier."""
    return (
        name != "" and name.isascii() and all(c.isalnum() or c in "-_." for c in name) and name[0] not in ".-"
    )
