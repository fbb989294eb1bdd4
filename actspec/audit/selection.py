"""Which rules a selector names: a code, the beginning of one, a rule's name, or `ALL`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from actspec.audit.rule import Rule
from actspec.diagnostics import nearest

ALL = "ALL"


def strength(selector: str, code: str, name: str) -> int:
    """How closely a selector names a rule: 0 not at all, 1 as one of all, more for a longer beginning.

    Args:
        selector: Code, beginning of a code, name or `ALL`.
        code: Of the rule.
        name: Of the rule.
    """
    if selector == ALL:
        return 1
    if selector in (code, name):
        return 100
    return 1 + len(selector) if selector and code.startswith(selector) else 0


def _closest(selectors: Iterable[str], rule: type[Rule]) -> int:
    return max((strength(selector, rule.code, rule.name) for selector in selectors), default=0)


def selected(
    rules: Sequence[type[Rule]], select: Sequence[str], ignore: Sequence[str]
) -> tuple[type[Rule], ...]:
    """Rules that are to run. The closer selector wins, `ignore` where both are equally close.

    Args:
        rules: All rules.
        select: Selectors of rules to run.
        ignore: Selectors of rules not to run.
    """
    return tuple(rule for rule in rules if _closest(select, rule) > _closest(ignore, rule))


def guess(selector: str, rules: Sequence[type[Rule]]) -> str | None:
    """The nearest code, family or name to a selector that names no rule."""
    upper = selector.upper()
    families = sorted({rule.code.rstrip("0123456789") for rule in rules})
    codes = [*families, *(rule.code for rule in rules), ALL]
    if upper in codes:
        return upper
    names = [rule.name for rule in rules]
    return nearest(selector.lower().replace("_", "-"), names) or nearest(upper, codes)
