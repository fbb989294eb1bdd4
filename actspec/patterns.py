"""Joint patterns: regular expressions of strangers, matched as Isaac Lab and mjlab do (`re.fullmatch`).

A pattern goes to the targets as text, and they hand it to Python's `re`, which has no time limit.
So it is not enough that a pattern is answered fast here: it must be cheap in `re` itself. The
pattern is parsed first, what can explode is refused, and the steps that `re` may take on
the longest name are bounded before the match starts.
"""

from __future__ import annotations

import importlib
import re
import sys
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from actspec.diagnostics import listed, shortened

MAX_PATTERN = 256
"""Longest pattern [characters]. Chosen: design section 4; the longest in the field's cfgs has about 80."""
MAX_NAME = 512
"""Longest joint name that is matched [characters]. Chosen: names in robot files have at most about 60."""
MAX_STEPS = 50_000_000
"""Most steps of `re` for one pattern over all names. Chosen: 0.2 s, at up to 4 ns a step as measured."""
MAX_REPEAT = 1000
"""Largest stated number of repetitions. Chosen: above the longest name, so none is needed."""

_SUGGESTED_NAMES = 512
_SUGGESTED_RUNS = 8
_SUGGESTED_TRIES = 24
_SUGGESTED_CELLS = 300_000
_SIMPLER = "write a simpler pattern: one `.*` per gap, no repeat inside a repeat; or list the joints by name"


class PatternError(ValueError):
    """A pattern is refused.

    Attributes:
        message: What is wrong, with the pattern.
        help: The nearest right answer; None when there is none.
    """

    def __init__(self, message: str, help: str | None = None) -> None:
        super().__init__(message)
        self.message = message
        self.help = help


@dataclass(frozen=True, slots=True)
class Pattern:
    """A pattern that was parsed and found harmless.

    Attributes:
        text: As the author wrote it.
        compiled: The same for `re`.
        tree: Its parse tree, from which the work is bounded.
    """

    text: str
    compiled: re.Pattern[str]
    tree: Any

    def match(self, names: Sequence[str]) -> tuple[str, ...]:
        """The names that the pattern matches as a whole, in their order.

        Raises:
            PatternError: the match could take too long, or a name is too long.
        """
        longest = max(map(len, names), default=0)
        if longest > MAX_NAME:
            raise PatternError(f"a joint's name has {longest} characters, at most {MAX_NAME} are matched")
        if _steps(self.tree, longest, MAX_STEPS // max(1, len(names))) is None:
            raise PatternError(
                f"the pattern {_quoted(self.text)} could take too long (catastrophic backtracking)", _SIMPLER
            )
        return tuple(name for name in names if self.compiled.fullmatch(name) is not None)


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


def compile_pattern(text: str) -> Pattern:
    """Parse a pattern and refuse what is wrong, unsupported or could hang.

    Raises:
        PatternError: with the position in the pattern where there is one.
    """
    if not text:
        raise PatternError("the pattern is empty", "`.*` matches every joint")
    if len(text) > MAX_PATTERN:
        raise PatternError(
            f"the pattern has {len(text)} characters, at most {MAX_PATTERN} are allowed",
            "split it into several patterns",
        )
    try:
        with warnings.catch_warnings():
            # A warning is about syntax whose meaning differs between Python versions.
            warnings.simplefilter("error")
            tree = _parser().parse(text)
            compiled = re.compile(text)
    except re.error as err:
        at = "" if err.pos is None else f" at character {err.pos + 1}"
        message = f"{_quoted(text)} is not a regular expression: {err.msg}{at}"
        raise PatternError(message, _glob_help(text)) from err
    except Warning as err:
        raise PatternError(
            f"{_quoted(text)} is read differently by different Python versions: {err}",
            "escape `[`, `-`, `&`, `|`, `~` in a class by `\\`; put flags first",
        ) from err
    except (OverflowError, RecursionError) as err:
        raise PatternError(f"{_quoted(text)} is not a usable regular expression: {err}", _SIMPLER) from err
    _refuse(tree, text)
    return Pattern(text, compiled, tree)


def match_names(pattern: str, names: Sequence[str]) -> tuple[str, ...]:
    """The names that a pattern matches as a whole, in the order of the names.

    Raises:
        PatternError: the pattern is refused, or could take too long on these names.
    """
    return compile_pattern(pattern).match(names)


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
                message = f"pattern {_quoted(text)} matches no joint"
                problems.append(PatternProblem(index, text, message, _unmatched_help(text, names)))
        except PatternError as err:
            problems.append(PatternProblem(index, text, err.message, err.help))
        by_pattern.append(found)
    selected = {name for found in by_pattern for name in found}
    return Matches(tuple(name for name in names if name in selected), tuple(by_pattern), tuple(problems))


def covering_pattern(pattern_list: Sequence[str], wanted: set[str], names: Sequence[str]) -> bool:
    """Whether the patterns together match exactly the wanted names and no other.

    Raises:
        PatternError: a pattern is refused.
    """
    return {name for pattern in pattern_list for name in match_names(pattern, names)} == wanted


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
    for candidate in [_from_glob(pattern), *close, *longer, *far]:
        if candidate == pattern:
            continue
        try:
            # All names, not the few: the caller matches a suggestion against them without a guard.
            if match_names(candidate, names):
                return candidate
        except PatternError:
            continue
    return None


def _unmatched_help(pattern: str, names: Sequence[str]) -> str:
    guess = suggest_pattern(pattern, names)
    if guess is not None:
        return f"did you mean {_quoted(guess)}? (matches {listed(match_names(guess, names))})"
    return f"the joints are: {listed(names)}" if names else "there are no joints"


def _parser() -> Any:
    """The parser of `re`; its module moved in Python 3.11, and typeshed knows only the old name."""
    return importlib.import_module("re._parser" if sys.version_info >= (3, 11) else "sre_parse")


def _refuse(tree: Any, text: str) -> None:
    """Refuse backreferences, what Python 3.10 does not know, and repeats inside repeats."""
    for op, value in tree:
        name = str(op)
        if name in ("GROUPREF", "GROUPREF_EXISTS"):
            raise PatternError(f"{_quoted(text)} refers back to a group, which patterns may not", _SIMPLER)
        if name in ("POSSESSIVE_REPEAT", "ATOMIC_GROUP"):
            raise PatternError(
                f"{_quoted(text)} has a possessive repeat or an atomic group, unknown to Python 3.10",
                "write the plain repeat",
            )
        if name in ("MAX_REPEAT", "MIN_REPEAT"):
            low, high, body = value
            finite = int(high) != int(_parser().MAXREPEAT)
            if low > MAX_REPEAT or (finite and high > MAX_REPEAT):
                raise PatternError(f"{_quoted(text)} repeats more than {MAX_REPEAT} times", _SIMPLER)
            if high > 1 and (_has_choice_of_length(body) or body.getwidth()[0] == 0):
                raise PatternError(
                    f"{_quoted(text)} has a repeat inside a repeat, which can take forever"
                    " (catastrophic backtracking)",
                    _SIMPLER,
                )
        for inner in _inner(op, value):
            _refuse(inner, text)


def _inner(op: Any, value: Any) -> Iterable[Any]:
    """The sequences inside a node of the parse tree."""
    name = str(op)
    if name in ("MAX_REPEAT", "MIN_REPEAT"):
        return (value[2],)
    if name == "SUBPATTERN":
        return (value[3],)
    if name == "BRANCH":
        return tuple(value[1])
    if name in ("ASSERT", "ASSERT_NOT"):
        return (value[1],)
    return ()


def _has_choice_of_length(tree: Any) -> bool:
    """Whether a repeat of variable length is somewhere inside."""
    return any(
        (str(op) in ("MAX_REPEAT", "MIN_REPEAT") and value[0] != value[1])
        or any(_has_choice_of_length(inner) for inner in _inner(op, value))
        for op, value in tree
    )


def _steps(tree: Any, length: int, most: int) -> int | None:
    """Upper bound of the steps that backtracking takes on a name of `length`; None above `most`.

    Counts the paths by which the matcher can reach each position, as if every character class
    matched every character; each path that arrives at a node is one step there.
    """
    counter = _Counter(most)
    try:
        counter.sequence(tree, [1] + [0] * length)
    except _TooMany:
        return None
    return counter.steps


class _TooMany(Exception):
    pass


class _Counter:
    def __init__(self, most: int) -> None:
        self.most = most
        self.steps = 0

    def spend(self, paths: list[int]) -> int:
        arriving = sum(paths)
        self.steps += arriving
        if self.steps > self.most:
            raise _TooMany
        return arriving

    def sequence(self, tree: Any, paths: list[int]) -> list[int]:
        """Number of paths at each position after the sequence, from those before it."""
        for op, value in tree:
            if not self.spend(paths):
                break
            paths = self.node(op, value, paths)
        return paths

    def node(self, op: Any, value: Any, paths: list[int]) -> list[int]:
        name = str(op)
        if name in ("LITERAL", "NOT_LITERAL", "ANY", "IN"):
            return [0, *paths[:-1]]
        if name == "SUBPATTERN":
            return self.sequence(value[3], paths)
        if name == "BRANCH":
            total = [0] * len(paths)
            for alternative in value[1]:
                total = [a + b for a, b in zip(total, self.sequence(alternative, paths), strict=True)]
            return total
        if name in ("MAX_REPEAT", "MIN_REPEAT"):
            return self.repeat(value, paths)
        if name in ("ASSERT", "ASSERT_NOT"):
            self.sequence(value[1], paths)
        return paths

    def repeat(self, value: Any, paths: list[int]) -> list[int]:
        low, high, body = value
        total = list(paths) if low == 0 else [0] * len(paths)
        done = 0
        while done < high and self.spend(paths):
            paths = self.sequence(body, paths)
            done += 1
            if done >= low:
                total = [a + b for a, b in zip(total, paths, strict=True)]
        return total


_GLOB = re.compile(r"[\w*?./-]*[*?][\w*?./-]*")
_TOKEN = re.compile(
    r"\\."  # an escape
    r"|\[\^?\]?(?:\\.|[^\]\\])*\]"  # a class
    r"|\{[\d,]*\}"  # a repeat
    r"|\(\?(?:P?<\w*[!=]?>?|[:=!])?"  # a group's head
    r"|[A-Za-z0-9_/-]+"  # a literal part
    r"|.",
    re.S,
)


def _from_glob(pattern: str) -> str:
    """The pattern with each bare `*` and `?` read as a glob has it."""
    if not _GLOB.fullmatch(pattern):
        return pattern
    return re.sub(r"(?<!\.)([*?])", lambda m: ".*" if m[1] == "*" else ".", pattern)


def _glob_help(pattern: str) -> str:
    glob = _from_glob(pattern)
    if glob != pattern:
        return f"patterns are regular expressions, not globs: write {_quoted(glob)}"
    return "a pattern is a Python regular expression that matches the whole name, such as '.*_hip_joint'"


def _respelt(pattern: str, names: Sequence[str]) -> list[tuple[str, int]]:
    """The pattern with one literal part respelt from a name, and the change; the smallest first."""
    if len(pattern) > MAX_PATTERN:
        return []
    runs = [m for m in _TOKEN.finditer(pattern) if m[0][0] in "_/-" or m[0][0].isalnum()]
    runs = sorted(runs, key=lambda m: -len(m[0]))[:_SUGGESTED_RUNS]
    found: dict[str, int] = {}
    cells = 0
    for run in runs:
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


def _quoted(text: str) -> str:
    return f"'{shortened(text, 80)}'"
