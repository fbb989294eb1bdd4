"""Remarks in the audited files that set findings aside: `actspec: ignore[CODE] reason`.

A remark is called unused only where no selection of the files has a use for it. A hook sees the files of a commit, a
run over the folder all of them: another file of the robot may silence a rule on a line, or make it speak. A remark that
one of the two needs must not be called unused by the other.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

from actspec.audit.case import Case
from actspec.audit.comments import comments
from actspec.audit.finding import Finding, Skipped
from actspec.audit.outcome import Means, Reported, Suppressed
from actspec.audit.rule import Rule
from actspec.audit.selection import guess, strength
from actspec.diagnostics import Diagnostic, Severity, Span, nearest, shortened
from actspec.readings.artifact import FileKind, FileReading
from actspec.readings.read import FAULT

REMARKS = {"ACT001": "ignore-without-reason", "ACT002": "unused-ignore", "ACT003": "unknown-ignore"}
"""What is said of remarks: codes, with the names by which they are selected as well."""

FIRST_LINES = 10
"""An `ignore-file` further down speaks about nothing. Chosen: a reader sees it without scrolling."""

_OF_UNREAD = {FAULT, "unreadable-file"}
"""What a remark in a file that cannot be read may set aside."""

_REMARK = re.compile(r"\s*actspec:\s*([A-Za-z][\w-]*)(?:\s*(\[)([^\]]*)\])?\s*(.*)", re.DOTALL)

_WORDS = ("ignore", "ignore-file")

_NEAR = 0.75
"""Likeness from which another word is a slip. Chosen: two letters exchanged; `note` is none."""


@dataclass(frozen=True, slots=True)
class Ignore:
    """One remark.

    Attributes:
        span: Where its comment begins.
        codes: Codes or names of rules, as written.
        reason: Why, in the author's words; "" when none is given.
        whole_file: Whether it speaks about the whole file.
        first: First line that it speaks about; 0: none.
        last: Last such line.
        word: `ignore` or `ignore-file`; another one is a slip.
    """

    span: Span
    codes: tuple[str, ...]
    reason: str
    whole_file: bool
    first: int
    last: int
    word: str

    @property
    def placed(self) -> bool:
        """Whether it stands where it speaks about a line at all."""
        return self.span.line <= FIRST_LINES if self.whole_file else self.first > 0

    def covers(self, line: int) -> bool:
        """Whether it speaks about a line."""
        return self.placed and (self.whole_file or self.first <= line <= self.last)


def ignores_of(
    files: Iterable[FileReading], real_path: Callable[[str], str]
) -> dict[str, tuple[Ignore, ...]]:
    """Remarks of every file, by its real path; a file that is included twice counts once.

    Args:
        files: What was read.
        real_path: `os.path.realpath`, or one that remembers.
    """
    found: dict[str, tuple[Ignore, ...]] = {}
    for reading in files:
        for file in reading.files:
            key = real_path(file.path)
            if key not in found:
                # Most files have none, and are not scanned.
                there = b"actspec:" in file.data
                own = _ignores(file.path, file.data) if there else ()
                # Of a file that no rule has looked at nobody knows whether its other remarks are of use.
                found[key] = tuple(one for one in own if reading.readable or _OF_UNREAD & {*one.codes})
    return found


def _ignores(path: str, data: bytes) -> Iterator[Ignore]:
    for comment in comments(path, data):
        remark = _REMARK.match(comment.text)
        if remark is None:
            continue
        word = remark[1]
        span, lines = Span(path, comment.line, comment.column), (comment.first, comment.last)
        if word in _WORDS:
            codes = tuple(code.strip() for code in (remark[3] or "").split(",") if code.strip())
            reason = " ".join(remark[4].split()).lstrip("-:– ")
            yield Ignore(span, codes, reason, word == "ignore-file", *lines, word)
        elif remark[2] or get_close_matches(word.lower(), _WORDS, n=1, cutoff=_NEAR):
            # Without brackets and of another word it is a sentence.
            yield Ignore(span, (), "", False, *lines, word)


@dataclass(frozen=True, slots=True)
class Sorted:
    """Findings after the remarks.

    Attributes:
        kept: Those that stay.
        suppressed: Those that a remark sets aside.
        unused: Remarks with those of their codes that set nothing aside.
    """

    kept: tuple[Reported, ...]
    suppressed: tuple[Suppressed, ...]
    unused: tuple[tuple[Ignore, str], ...]


def set_aside(
    found: Sequence[Reported],
    ignores: Mapping[str, tuple[Ignore, ...]],
    real_path: Callable[[str], str],
    names: Mapping[str, Sequence[str]],
) -> Sorted:
    """Put findings aside that a remark with a reason names.

    Args:
        found: All findings.
        ignores: From `ignores_of`.
        real_path: Likewise.
        names: Code of each rule to its code and all that it is called.
    """
    kept, suppressed = [], []
    used: set[tuple[Ignore, str]] = set()
    for reported in found:
        span = reported.finding.span
        matching = [
            (ignore, code)
            for ignore in ignores.get(real_path(span.path), ())
            if ignore.reason and ignore.covers(span.line)
            for code in ignore.codes
            if code in names[reported.finding.code]
        ]
        if matching:
            used.update(matching)
            suppressed.append(Suppressed(reported, Means.INLINE, matching[0][0].reason))
        else:
            kept.append(reported)
    unused = tuple(
        (ignore, code)
        for group in ignores.values()
        for ignore in group
        for code in ignore.codes
        if ignore.reason and (ignore, code) not in used
    )
    return Sorted(tuple(kept), tuple(suppressed), unused)


def without_reason(ignores: Iterable[Ignore]) -> Iterator[Diagnostic]:
    """ACT001: remarks that give no reason."""
    for ignore in ignores:
        if ignore.codes and not ignore.reason:
            yield _warning(
                "ACT001",
                "this ignore gives no reason, and is not followed",
                ignore,
                f"say why: `actspec: ignore[{shortened(', '.join(ignore.codes))}] the reason`",
            )


def unused(ignores: Iterable[tuple[Ignore, str]]) -> Iterator[Diagnostic]:
    """ACT002: remarks that set nothing aside.

    Args:
        ignores: From `actspec.audit.ignores.certainly_unused`.
    """
    for ignore, code in ignores:
        message, help = f"this ignore of {code} sets nothing aside", "remove it"
        if ignore.whole_file and not ignore.placed:
            message = f"this ignore-file stands below line {FIRST_LINES}, and is not followed"
            help = "move it to the top of the file"
        elif not ignore.placed:
            help = "put it on the line of the finding, or alone on the line before"
        yield _warning("ACT002", message, ignore, help)


def unknown(ignores: Iterable[Ignore], rules: Sequence[type[Rule]]) -> Iterator[Diagnostic]:
    """ACT003: remarks that name no rule, or one that is not there, or are none."""
    known = {name for rule in rules for name in (rule.code, *rule.names())} | {*REMARKS, *REMARKS.values()}
    for ignore in ignores:
        if ignore.word not in _WORDS:
            message = f"'{shortened(ignore.word)}' is no word that actspec knows here, and is not followed"
            word = nearest(ignore.word.lower(), _WORDS) or _WORDS[0]
            yield _warning("ACT003", message, ignore, f"did you mean `actspec: {word}[CODE] the reason`?")
        elif not ignore.codes:
            message, help = (
                "this ignore names no rule, and is not followed",
                "write `actspec: ignore[CODE] the reason`",
            )
            yield _warning("ACT003", message, ignore, help)
        for code in ignore.codes:
            if code not in known:
                near = guess(code, rules)
                message = f"this ignore names '{shortened(code)}', and no rule has this code or name"
                advice = near and f"did you mean '{near}'?"
                if near and near not in known:
                    # A family, or all of them: whoever reads the reason must know which fault it speaks about.
                    own = next((rule.code for rule in rules if strength(near, rule.code)), None)
                    advice = f"an ignore names single rules: write the code of one, such as {own}"
                yield _warning("ACT003", message, ignore, advice)


def _warning(code: str, message: str, ignore: Ignore, help: str | None) -> Diagnostic:
    return Diagnostic(code, Severity.WARNING, message, "", ignore.span, help)


Looked = Callable[[type[Rule], Sequence[FileReading]], tuple[Sequence[Finding], Sequence[Skipped]] | None]
"""Lets one rule look at a selection of the files: what it found and what it lacked; None when it broke off."""

_MODELS = (FileKind.MJCF, FileKind.URDF)
"""Files whose ledger rows need no other file; those of a configuration have its model's joints and inertia."""


def certainly_unused(
    unused: Iterable[tuple[Ignore, str]],
    rules: Mapping[str, type[Rule]],
    case: Case,
    whole: Collection[str],
    looked: Looked,
) -> Iterator[tuple[Ignore, str]]:
    """Of remarks that set nothing aside in this run, those that would in none with fewer or more of the files.

    What a rule that judges a file by itself finds there is found without the other files at most. Of a rule that also
    compares files nobody knows which others there are unless a folder was named: then the file by itself, with each
    other one of its robot, with all, and with all but one are looked at.

    Args:
        unused: Remarks with those of their codes or names that set nothing aside.
        rules: Code and name to the rule, for rules that ran and had input.
        case: The whole case.
        whole: Files that were found in a folder, so that the others of their robot are among the files.
        looked: How one rule looks at a selection.
    """
    for ignore, code in unused:
        rule = rules.get(code)
        if rule is None:
            continue
        # What speaks about no line is of no use to anybody.
        if not ignore.placed or _useless(ignore, rule, case, whole, looked):
            yield ignore, code


def _useless(ignore: Ignore, rule: type[Rule], case: Case, whole: Collection[str], looked: Looked) -> bool:
    own = os.path.realpath(ignore.span.path)
    homes = [reading for reading in case.files if any(os.path.realpath(f.path) == own for f in reading.files)]
    for home in homes:
        if not rule.paired and home.kind in _MODELS:
            selections = _selections(case, home, ())
        elif home.path not in whole:
            return False
        else:
            selections = _selections(case, home, _partners(case, home))
        for number, selection in enumerate(selections):
            seen = looked(rule, selection)
            if seen is None:
                return False
            found, skipped = seen
            # The last one has the most: a rule that lacks its input there says nothing about the remark.
            if number == len(selections) - 1 and skipped:
                return False
            if any(ignore.covers(f.span.line) and os.path.realpath(f.span.path) == own for f in found):
                return False
    return True


def _partners(case: Case, home: FileReading) -> list[FileReading]:
    """The other files that describe the robots of one."""
    mine = {index for index, artifact in enumerate(case.artifacts) if artifact.path == home.path}
    paths = {
        case.artifacts[other].path
        for robot in case.robots
        if mine & set(robot.artifacts)
        for other in robot.artifacts
    }
    return [reading for reading in case.files if reading.path in paths and reading is not home]


def _selections(
    case: Case, home: FileReading, others: Sequence[FileReading]
) -> list[tuple[FileReading, ...]]:
    """A file by itself, with each other file, with all but one, with all; each in the order of the case."""
    chosen = [(), *((one,) for one in others)]
    if len(others) > 2:
        chosen += [tuple(other for other in others if other is not one) for one in others]
    if len(others) > 1:
        chosen.append(tuple(others))
    return [tuple(reading for reading in case.files if reading is home or reading in some) for some in chosen]
