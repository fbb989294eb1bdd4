"""The form of a rule, and its page."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import ClassVar, Generic, TypeVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Safety, Skipped
from actspec.diagnostics import Severity

__all__ = [
    "HEADINGS",
    "Case",
    "Confidence",
    "Finding",
    "Rule",
    "RuleInParts",
    "RuleOver",
    "Severity",
    "sections",
]
"""With what every rule is written with."""

T = TypeVar("T")

HEADINGS = ("What it does", "Why it matters", "Example", "Use instead", "Limits", "Source")
"""Sections of a rule's page, in this order; `Limits` may be left out."""


class Rule:
    """One rule. Its page stands beside its module, as `CODE.md` in lower case.

    Attributes:
        code: Family letters and number; for ever.
        name: What the files do, in words with hyphens: `joint-damping-beside-kv`.
        aliases: Codes of rules that this one took the place of, with their names; they select it as its own code does.
        severity: Unless the finding or the configuration says otherwise.
        confidence: Likewise.
        fix: Whether it offers a fix; None: never.
        options: Its options and their defaults.
        noted_in_folders: Whether its findings are notes in a file that was met in a folder, and not named: of those in
            strangers' folders too few were worth acting on (docs/survey.md). An error of one file alone stays one.
        counts_where_run: Whether those of a model that a program of the folder names are none.
        written_over: Figures of a model or a configuration on which it leans; where a program of the
            folder writes over one of them, its findings are notes.
        paired: Whether another file of the robot can give it a finding in a model that the model by itself would not
            get.
    """

    code: ClassVar[str]
    name: ClassVar[str]
    severity: ClassVar[Severity]
    confidence: ClassVar[Confidence]
    fix: ClassVar[Safety | None] = None
    aliases: ClassVar[Mapping[str, str]] = {}
    options: ClassVar[dict[str, float]] = {}
    noted_in_folders: ClassVar[bool] = False
    counts_where_run: ClassVar[bool] = False
    written_over: ClassVar[frozenset[str]] = frozenset()
    paired: ClassVar[bool] = False

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find, or say why nothing could be looked at.

        Args:
            case: What to judge.
        """
        raise NotImplementedError

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """What it is called besides its code: its name, then codes and names of the rules that it took the place of."""
        return (cls.name, *cls.aliases, *cls.aliases.values())

    @classmethod
    def text(cls) -> str:
        """The text of its page."""
        module = Path(sys.modules[cls.__module__].__file__ or "")
        return module.with_name(f"{cls.code.lower()}.md").read_text(encoding="utf-8")

    def option(self, case: Case, name: str) -> float:
        """An option of this rule as configured."""
        return case.option(self.code, name, self.options[name])


class RuleOver(Rule, Generic[T]):
    """A rule that judges one thing after the other, and declares what those are.

    Attributes:
        needs: What the files lack where there is nothing to judge: `no MJCF with a delay among the files`.
    """

    needs: ClassVar[str]

    def subjects(self, case: Case) -> Iterable[T]:
        """What is judged, as far as the files have all that this takes."""
        raise NotImplementedError

    def judge(self, case: Case, subject: T) -> Iterator[Finding]:
        """Find what is wrong with one of the subjects."""
        raise NotImplementedError

    def lacks(self, case: Case) -> str:
        """Why there are no subjects."""
        return self.needs

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Judge every subject; where there is none, say what the files lack."""
        looked = False
        for subject in self.subjects(case):
            looked = True
            yield from self.judge(case, subject)
        if not looked:
            yield Skipped(self.code, self.lacks(case))


class RuleInParts(RuleOver[Iterable[Finding]]):
    """A rule that looks at things of several kinds: each subject is what it found at one of them, often nothing."""

    def judge(self, case: Case, subject: Iterable[Finding]) -> Iterator[Finding]:
        """What was found there."""
        yield from subject


def sections(rule: type[Rule]) -> dict[str, str]:
    """A rule's page: heading to text; the title line under "".

    The lines between title and first heading are those that `actspec.audit.pages` makes of the attributes.

    Raises: ValueError: the page has no title, or a heading is missing or out of order.
    """
    head, *parts = re.split(r"^## (.+)$", rule.text(), flags=re.MULTILINE)
    title = head.partition("\n\n")[2].partition("\n\n")[0].strip()
    found = {"": title} | {parts[i].strip(): parts[i + 1].strip("\n") for i in range(0, len(parts), 2)}
    wanted = [heading for heading in HEADINGS if heading in found or heading != "Limits"]
    if not title or [key for key in found if key] != wanted:
        raise ValueError(f"{rule.code}: a rule's page has a title and the sections {', '.join(wanted)}")
    return found
