"""What a list of patterns selects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from actspec.diagnostics import listed
from actspec.patterns.pattern import PatternError, match_names, quoted
from actspec.patterns.suggest import suggest_pattern


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
