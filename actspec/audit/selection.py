"""Which rules a selector names: a code, the beginning of one, a rule's name, or `ALL`."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from actspec.audit.rule import Rule
from actspec.diagnostics import nearest

ALL = "ALL"

NOT_JUDGED = "AUD"
"""The family of rules over files that no other rule, or not every one, can look at."""

DIAGNOSTICS = {
    "AUD007": "stale-baseline-entry",
    "AUD011": "fix-not-made",
    "AUD013": "judged-from-text-alone",
    "AUD015": "not-compared",
    "AUD021": "lost-file",
    "AUD023": "lost-drive",
    "CFG001": "unknown-without-running",
    "CFG003": "no-number-in-a-configuration",
    "CFG004": "refused-by-the-framework",
    "DEPLOY001": "list-length",
    "DEPLOY002": "list-without-names",
    "DEPLOY003": "no-number",
    "DEPLOY004": "stands-twice",
    "DEPLOY005": "step-of-what",
    "DEPLOY006": "joint-misspelt",
    "DEPLOY007": "two-default-positions",
    "DEPLOY008": "no-motor-of-its-own",
    "DEPLOY009": "gains-of-standing-up",
    "DEPLOY010": "action-of-other-joints",
}
"""What is said of files beside findings: codes that can be ignored, with names. So can those of robot files."""


def is_diagnostic(selector: str) -> bool:
    """Whether a selector names what is said of files beside findings."""
    if re.fullmatch(r"ROBOT\d{0,3}", selector):
        return True
    return any(strength(selector, *entry) > 1 for entry in DIAGNOSTICS.items())


def strength(selector: str, code: str, *names: str) -> int:
    """How closely a selector names a rule: 0 not at all, 1 as one of all, more for a longer beginning.

    Args:
        selector: Code, beginning of a code, name or `ALL`.
        code: Of the rule.
        names: What else it is called, as `Rule.names`.
    """
    if selector == ALL:
        return 1
    if selector == code or selector in names:
        return 100
    return 1 + len(selector) if selector and code.startswith(selector) else 0


def is_selected(code: str, names: Sequence[str], select: Iterable[str], ignore: Iterable[str]) -> bool:
    """Whether something with this code is asked for. The closer selector wins, `ignore` where both are equally close.

    Args:
        code: Of a rule or a diagnostic.
        names: What else it is called.
        select: Selectors of what is asked for.
        ignore: Selectors of what is not.
    """
    wanted, unwanted = (
        max((strength(selector, code, *names) for selector in selectors), default=0)
        for selectors in (select, ignore)
    )
    return wanted > unwanted


def selected(
    rules: Sequence[type[Rule]], select: Sequence[str], ignore: Sequence[str]
) -> tuple[type[Rule], ...]:
    """Rules that are to run.

    Args:
        rules: All rules.
        select: Selectors of rules to run.
        ignore: Selectors of rules not to run.
    """
    return tuple(rule for rule in rules if is_selected(rule.code, rule.names(), select, ignore))


def guess(selector: str, rules: Sequence[type[Rule]]) -> str | None:
    """The nearest code, family or name to a selector that names no rule."""
    upper = selector.upper()
    families = sorted({rule.code.rstrip("0123456789") for rule in rules})
    codes = [*families, *(code for rule in rules for code in (rule.code, *rule.aliases)), ALL]
    if upper in codes:
        return upper
    names = [name for rule in rules for name in (rule.name, *rule.aliases.values())]
    return nearest(selector.lower().replace("_", "-"), names) or nearest(upper, codes)
