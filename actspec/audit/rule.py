"""The form of a rule, and the list of all rules."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Safety, Skipped
from actspec.diagnostics import Severity

HEADINGS = ("What it does", "Why it matters", "Example", "Use instead", "Limits", "Source")
"""Sections of a rule's docstring, in this order; `Limits` may be left out."""


class Rule:
    """One rule. Its docstring is its page: a title line, then the sections of `HEADINGS`.

    Attributes:
        code: Family letters and number; for ever.
        name: What the files do, in words with hyphens: `joint-damping-beside-kv`.
        severity: Unless the finding or the configuration says otherwise.
        confidence: Likewise.
        fix: Whether it offers a fix; None: never.
        options: Its options and their defaults.
        paired: Whether another file of the robot can give it a finding in a model that the model by itself would not
            get.
    """

    code: ClassVar[str]
    name: ClassVar[str]
    severity: ClassVar[Severity]
    confidence: ClassVar[Confidence]
    fix: ClassVar[Safety | None] = None
    options: ClassVar[dict[str, float]] = {}
    paired: ClassVar[bool] = False

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find, or say why nothing could be looked at.

        Args:
            case: What to judge.
        """
        raise NotImplementedError

    def option(self, case: Case, name: str) -> float:
        """An option of this rule as configured."""
        return case.option(self.code, name, self.options[name])


def sections(rule: type[Rule]) -> dict[str, str]:
    """A rule's page: heading to text; the title line under "".

    Raises: ValueError: the docstring has no title, or a heading is missing or out of order.
    """
    from inspect import getdoc

    text = getdoc(rule) or ""
    title, _, rest = text.partition("\n")
    parts = re.split(r"^## (.+)$", rest, flags=re.MULTILINE)
    found = {"": title.strip()}
    found.update({parts[i].strip(): parts[i + 1].strip("\n") for i in range(1, len(parts), 2)})
    wanted = [heading for heading in HEADINGS if heading in found or heading != "Limits"]
    if not title or [key for key in found if key] != wanted:
        raise ValueError(f"{rule.code}: a rule's docstring has a title and the sections {', '.join(wanted)}")
    return found
