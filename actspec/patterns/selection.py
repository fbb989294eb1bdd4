"""What a list of patterns selects, and the nearest pattern that matches something for one that matches nothing."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass

from actspec.diagnostics import listed
from actspec.patterns.pattern import MAX_NAME, MAX_PATTERN, PatternError, from_glob, match_names, quoted


@dataclass(frozen=True, slots=True)
class PatternProblem:
    """A pattern of a list that cannot be used.

    Attributes:
        index: Its place in the list.
        pattern: Its text.
        message: What is wrong.
        help: The nearest right answer; None when there is none.
    """

    index: int
    pattern: str
    message: str
    help: str | None


@dataclass(frozen=True, slots=True)
class Matches:
    """What a list of patterns selects.

    Attributes:
        names: Every name that at least one pattern matches, in the order of the names.
        by_pattern: For each pattern of the list, in order, the names that it matches.
        problems: Patterns that are refused or match nothing.
    """

    names: tuple[str, ...]
    by_pattern: tuple[tuple[str, ...], ...]
    problems: tuple[PatternProblem, ...] = ()


def resolve_patterns(patterns: Sequence[str], names: Sequence[str]) -> Matches:
    """Match a list of patterns, each of which must match at least one name.

    Refused and unmatched patterns are all in `Matches.problems`, so that the caller can report
    each at its own place.
    """
    by_pattern: list[tuple[str, ...]] = []
    problems: list[PatternProblem] = []
    for index, text in enumerate(patterns):
        found: tuple[str, ...] = ()
        try:
            found = match_names(text, names)
            if not found:
                message = f"pattern {quoted(text)} matches no joint"
                problems.append(PatternProblem(index, text, message, _unmatched_help(text, names)))
        except PatternError as err:
            problems.append(PatternProblem(index, text, err.message, err.help))
        by_pattern.append(found)
    selected = {name for found in by_pattern for name in found}
    return Matches(tuple(name for name in names if name in selected), tuple(by_pattern), tuple(problems))


def _unmatched_help(pattern: str, names: Sequence[str]) -> str:
    guess = suggest_pattern(pattern, names)
    if guess is not None:
        return f"did you mean {quoted(guess)}? (matches {listed(match_names(guess, names))})"
    return f"the joints are: {listed(names)}" if names else "there are no joints"


def apart(text: str) -> tuple[str, ...]:
    """Patterns that one text has with commas between them, those in brackets of a pattern left alone."""
    parts = [""]
    depth = 0
    for token in _TOKEN.finditer(text):
        depth += (token[0][0] == "(") - (token[0] == ")")
        if token[0] == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += token[0]
    return tuple(stripped for part in parts if (stripped := part.strip()))


_SUGGESTED_NAMES = 512
_SUGGESTED_RUNS = 8
_SUGGESTED_TRIES = 24
_SUGGESTED_CELLS = 300_000
_TOKEN = re.compile(
    r"\\."  # an escape
    r"|\[\^?\]?(?:\\.|[^\]\\])*\]"  # a class
    r"|\{[\d,]*\}"  # a repeat
    r"|\(\?(?:P?<\w*[!=]?>?|[:=!])?"  # a group's head
    r"|[A-Za-z0-9_/-]+"  # a literal part
    r"|.",
    re.S,
)


def suggest_pattern(pattern: str, names: Sequence[str]) -> str | None:
    """The nearest pattern that matches a name, for one that matches none; None if none is near.

    Tried in order: the reading as a glob; one letter of a literal part changed; `.*` before or after
    the pattern; a literal part replaced by the most similar part of a name.
    """
    few = [name for name in names[:_SUGGESTED_NAMES] if len(name) <= MAX_NAME]
    longer = []
    if "|" not in pattern and any(c.isalnum() for c in pattern):
        longer = [f".*{pattern}", f"{pattern}.*", f".*{pattern}.*"]
    respelt = _respelt(pattern, few)
    close = [text for text, distance in respelt if distance <= 1]
    far = [text for text, distance in respelt if distance > 1]
    for candidate in [from_glob(pattern), *close, *longer, *far]:
        if candidate == pattern:
            continue
        try:
            # All names, not the few: the caller matches a suggestion against them without a guard.
            if match_names(candidate, names):
                return candidate
        except PatternError:
            continue
    return None


def is_slip(pattern: str, names: Sequence[str]) -> bool:
    """Whether a pattern that matches none of the names does so with one letter more, less or other, or as a glob."""
    few = [name for name in names[:_SUGGESTED_NAMES] if len(name) <= MAX_NAME]
    close = (text for text, distance in _respelt(pattern, few) if distance <= 1)
    for candidate in (from_glob(pattern), *close):
        with suppress(PatternError):
            if match_names(candidate, few):
                return True
    return False


def recased(pattern: str, names: Sequence[str]) -> str | None:
    """The pattern with other capital and small letters that matches a name, for one that matches none."""
    few = [name for name in names[:_SUGGESTED_NAMES] if len(name) <= MAX_NAME]
    plain = next((name for name in few if name.lower() == pattern.lower()), None)
    if plain is not None:
        return plain
    for candidate in (
        _each_part(pattern, str.lower),
        _each_part(pattern, str.upper),
        *_one_recased(pattern, few),
    ):
        with suppress(PatternError):
            if match_names(candidate, few):
                return candidate
    return None


def _each_part(pattern: str, change: Callable[[str], str]) -> str:
    """A pattern with its literal parts changed: neither escapes nor classes."""
    return _TOKEN.sub(lambda token: change(token[0]) if _is_literal(token[0]) else token[0], pattern)


def _is_literal(token: str) -> bool:
    return token[0] in "_/-" or token[0].isalnum()


def _one_recased(pattern: str, names: Sequence[str]) -> list[str]:
    """The pattern with one literal part in the letters that it has in a name.

    Found without distances: an audit asks this of each configuration beside each model.
    """
    found: set[str] = set()
    for run in _literal_runs(pattern):
        start, end = "\\A" * (run.start() == 0), "\\Z" * (run.end() == len(pattern))
        want = re.compile(start + re.escape(run[0]) + end, re.IGNORECASE)
        parts = {hit[0] for name in names for hit in want.finditer(name)} - {run[0]}
        found |= {pattern[: run.start()] + part + pattern[run.end() :] for part in parts}
    return sorted(found)[:_SUGGESTED_TRIES]


def _literal_runs(pattern: str) -> list[re.Match[str]]:
    """The literal parts of a pattern, the longest first."""
    if len(pattern) > MAX_PATTERN:
        return []
    runs = [m for m in _TOKEN.finditer(pattern) if _is_literal(m[0])]
    return sorted(runs, key=lambda m: -len(m[0]))[:_SUGGESTED_RUNS]


def _respelt(pattern: str, names: Sequence[str]) -> list[tuple[str, int]]:
    """The pattern with one literal part respelt from a name, and the change; the smallest first."""
    found: dict[str, int] = {}
    cells = 0
    for run in _literal_runs(pattern):
        anchored = (run.start() == 0, run.end() == len(pattern))
        for name in names:
            cells += len(run[0]) * len(name)
            if cells > _SUGGESTED_CELLS:
                break
            distance, part = _nearest_part(run[0], name, *anchored)
            if distance <= (len(run[0]) + 1) // 3 and part != run[0]:
                candidate = pattern[: run.start()] + part + pattern[run.end() :]
                found[candidate] = min(distance, found.get(candidate, distance))
    return sorted(found.items(), key=lambda item: (item[1], item[0]))[:_SUGGESTED_TRIES]


def _nearest_part(run: str, name: str, from_start: bool, to_end: bool) -> tuple[int, str]:
    """The part of a name with the least edit distance to `run`, case aside, and that distance.

    The part starts where the name does if `from_start`, and ends where it does if `to_end`.
    """
    low = name.lower() if len(name.lower()) == len(name) else name
    # Row i holds, for each end j in the name, (distance of run[:i] to the best part, its start).
    row = [(j if from_start else 0, 0 if from_start else j) for j in range(len(low) + 1)]
    for i, want in enumerate(run.lower(), 1):
        last, row = row, [(i, 0)]
        for j, have in enumerate(low, 1):
            row.append(
                min(
                    (last[j - 1][0] + (want != have), last[j - 1][1]),
                    (last[j][0] + 1, last[j][1]),
                    (row[j - 1][0] + 1, row[j - 1][1]),
                )
            )
    end = len(low) if to_end else min(range(len(row)), key=lambda j: (row[j][0], -j))
    return row[end][0], name[row[end][1] : end]
