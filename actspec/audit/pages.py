"""Rules explained: one page each, from the file beside its module, and an index of all."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import Any

from actspec.audit.rule import Rule, sections
from actspec.diagnostics import listed

INDEX = "README.md"

FAMILIES = {
    "AUD": "files that are not judged",
    "CFG": "configurations",
    "DLY": "delays",
    "DMP": "damping",
    "DRN": "randomisation ranges",
    "FRC": "friction",
    "GEA": "gears and inertia",
    "KNW": "robots whose figures are published",
    "LIM": "limits",
    "NET": "actuator networks",
    "ORD": "joint order",
    "PRV": "where figures come from",
    "SGN": "signs",
    "SPC": "departures from the spec",
    "SRC": "files that disagree",
    "STB": "numerical stability",
    "SYM": "left and right",
    "UNT": "units",
    "VER": "what a version changes",
}
"""Family letters to what they are about."""


def family(rule: type[Rule]) -> str:
    """The letters of a rule's code."""
    return rule.code.rstrip("0123456789")


def page(rule: type[Rule]) -> str:
    """A rule's page as Markdown."""
    found = sections(rule)
    head = f"# {rule.code} {rule.name}\n\n{found.pop('')}\n\n"
    facts = f"{rule.severity.value}, {rule.confidence.value} confidence"
    if rule.fix is not None:
        facts += f", {rule.fix.value} fix"
    if rule.noted_in_folders:
        facts += "; in a folder a note, save an error of one file alone"
        facts += " and a model that a program there names" if rule.counts_where_run else ""
    body = "".join(f"\n## {heading}\n\n{text.strip()}\n" for heading, text in found.items())
    return f"{head}{facts[0].upper()}{facts[1:]}.\n{_options(rule)}{_aliases(rule)}{body}"


def _options(rule: type[Rule]) -> str:
    if not rule.options:
        return ""
    values = ", ".join(f"`{name} = {value:g}`" for name, value in rule.options.items())
    return f"\nOptions, under `[tool.actspec.audit.rules.{rule.code}]`: {values}.\n"


def _aliases(rule: type[Rule]) -> str:
    if not rule.aliases:
        return ""
    former = listed([f"{code} {name}" for code, name in rule.aliases.items()], len(rule.aliases))
    return f"\nFormerly also {former}: these codes and names still select it.\n"


def index(rules: Sequence[type[Rule]]) -> str:
    """The index of all rules as Markdown.

    Args:
        rules: By code.
    """
    text = "# Rules of `actspec audit`\n\n`actspec rule CODE` prints a page.\n"
    for letters, members in groupby(rules, key=family):
        text += f"\n## {letters}: {FAMILIES[letters]}\n\n| code | name | | severity | confidence | fix |\n"
        text += "|---|---|---|---|---|---|\n"
        for rule in members:
            cells = (
                f"[{rule.code}]({rule.code.lower()}.md)",
                rule.name,
                sections(rule)[""].replace("|", "\\|"),
                rule.severity.value,
                rule.confidence.value,
                rule.fix.value if rule.fix is not None else "",
            )
            text += "| " + " | ".join(cells) + " |\n"
    return text


def record(rule: type[Rule]) -> dict[str, Any]:
    """A rule for programs."""
    found = sections(rule)
    return {
        "code": rule.code,
        "name": rule.name,
        "aliases": dict(rule.aliases),
        "title": found.pop(""),
        "severity": rule.severity.value,
        "confidence": rule.confidence.value,
        "fix": rule.fix.value if rule.fix is not None else None,
        "options": rule.options,
        "sections": {heading: text.strip() for heading, text in found.items()},
    }
