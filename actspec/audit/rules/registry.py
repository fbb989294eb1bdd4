"""All rules of the audit, by code."""

from __future__ import annotations

from actspec.audit.rule import Rule


def all_rules() -> tuple[type[Rule], ...]:
    """Every rule, by code."""
    families: tuple[tuple[type[Rule], ...], ...] = ()
    return tuple(sorted((rule for family in families for rule in family), key=lambda rule: rule.code))
