"""Errors about joints: the same one of several joints is told once, with their names."""

from __future__ import annotations

from dataclasses import dataclass, field

from actspec.diagnostics import Collector, Span, listed


@dataclass(slots=True)
class Reports:
    """Collects errors of single joints until all joints are through."""

    joints: dict[tuple[str, str, str, Span | None, str | None], list[str]] = field(default_factory=dict)
    """Code, message, where, span and help, to the joints concerned."""

    def error(
        self, code: str, joint: str, message: str, where: str, span: Span | None, help: str | None
    ) -> None:
        """Note that something is wrong with a joint."""
        named = self.joints.setdefault((code, message, where, span, help), [])
        if joint not in named:
            named.append(joint)

    def tell(self, collector: Collector) -> None:
        """Hand everything noted to the collector."""
        for (code, message, where, span, help), named in self.joints.items():
            collector.error(code, f"{listed(named)}: {message}", where=where, span=span, help=help)
        self.joints.clear()
