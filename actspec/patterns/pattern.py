"""One pattern: parsed, refused where it could hang, matched."""

from __future__ import annotations

import importlib
import re
import sys
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from actspec.diagnostics import shortened

MAX_PATTERN = 256
"""Longest pattern [characters]. Chosen: design section 4; the longest in the field's cfgs has about 80."""
MAX_NAME = 512
"""Longest joint name that is matched [characters]. Chosen: names in robot files have at most about 60."""
MAX_STEPS = 50_000_000
"""Most steps of `re` for one pattern over all names. Chosen: 0.2 s, at up to 4 ns a step as measured."""
MAX_REPEAT = 1000
"""Largest stated number of repetitions. Chosen: above the longest name, so none is needed."""
MAX_WRITTEN = 256
"""Most names that a pattern writes out. Chosen: above the joints of any robot, so that more are any name."""
MAX_CLASS = 8
"""Most characters of a class that writes them out. Chosen: `[1-8]` are eight joints, `[1-9]` is any digit."""
KEPT = 4096
"""Patterns, and bounds of their work, that are kept: rules ask for the same ones again and again. Chosen."""
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


class NoExpression(PatternError):
    """A text that is no regular expression: whoever matches with `re` refuses it, too."""


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
        if _hangs(self.text, longest, MAX_STEPS // max(1, len(names))):
            raise PatternError(
                f"the pattern {quoted(self.text)} could take too long (catastrophic backtracking)", _SIMPLER
            )
        return tuple(name for name in names if self.compiled.fullmatch(name) is not None)


@lru_cache(maxsize=KEPT)
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
        message = f"{quoted(text)} is not a regular expression: {err.msg}{at}"
        raise NoExpression(message, _glob_help(text)) from err
    except Warning as err:
        raise PatternError(
            f"{quoted(text)} is read differently by different Python versions: {err}",
            "escape `[`, `-`, `&`, `|`, `~` in a class by `\\`; put flags first",
        ) from err
    except (OverflowError, RecursionError) as err:
        raise PatternError(f"{quoted(text)} is not a usable regular expression: {err}", _SIMPLER) from err
    _refuse(tree, text)
    return Pattern(text, compiled, tree)


@lru_cache(maxsize=KEPT)
def _hangs(text: str, length: int, most: int) -> bool:
    """Whether a pattern that is not refused could take more steps than `most` on a name of a length."""
    return steps(compile_pattern(text).tree, length, most) is None


def match_names(pattern: str, names: Sequence[str]) -> tuple[str, ...]:
    """The names that a pattern matches as a whole, in the order of the names.

    Raises:
        PatternError: the pattern is refused, or could take too long on these names.
    """
    return compile_pattern(pattern).match(names)


@lru_cache(maxsize=KEPT)
def written_out(pattern: str) -> tuple[str, ...]:
    """The names that a pattern writes out, `joint1` to `joint7` of `joint[1-7]`; none where it matches any number.

    Raises:
        PatternError: the pattern is refused.
    """
    found = compile_pattern(pattern)
    return () if found.compiled.flags & re.IGNORECASE else tuple(dict.fromkeys(_written(found.tree) or ()))


def _written(tree: Any) -> list[str] | None:
    """Every text that a parse tree matches; None where they are many, or depend on more than the text."""
    found = [""]
    for op, value in tree:
        name = str(op)
        parts: list[str] | None = None
        if name == "LITERAL":
            parts = [chr(value)]
        elif name == "IN":
            parts = _in_class(value)
        elif name == "SUBPATTERN" and not value[1] and not value[2]:
            parts = _written(value[3])
        elif name == "BRANCH":
            each = [_written(branch) for branch in value[1]]
            parts = None if None in each else [text for texts in each for text in texts or ()]
        elif name in ("MAX_REPEAT", "MIN_REPEAT") and value[1] == 1:
            body = _written(value[2])
            parts = body if body is None or value[0] == 1 else ["", *body]
        if parts is None or len(found) * len(parts) > MAX_WRITTEN:
            return None
        found = [before + part for before in found for part in parts]
    return found


def _in_class(items: Any) -> list[str] | None:
    """The characters of a class; None where it has more than it writes out."""
    found: list[str] = []
    for op, value in items:
        if str(op) == "LITERAL":
            found.append(chr(value))
        elif str(op) == "RANGE" and value[1] - value[0] < MAX_CLASS:
            found += map(chr, range(value[0], value[1] + 1))
        else:
            return None
    return found if len(found) <= MAX_CLASS else None


def covering_pattern(pattern_list: Sequence[str], wanted: set[str], names: Sequence[str]) -> bool:
    """Whether the patterns together match exactly the wanted names and no other.

    Raises:
        PatternError: a pattern is refused.
    """
    return {name for pattern in pattern_list for name in match_names(pattern, names)} == wanted


_GLOB = re.compile(r"[\w*?./-]*[*?][\w*?./-]*")


def from_glob(pattern: str) -> str:
    """The pattern with each bare `*` and `?` read as a glob has it."""
    if not _GLOB.fullmatch(pattern):
        return pattern
    return re.sub(r"(?<!\.)([*?])", lambda m: ".*" if m[1] == "*" else ".", pattern)


def _glob_help(pattern: str) -> str:
    glob = from_glob(pattern)
    if glob != pattern:
        return f"patterns are regular expressions, not globs: write {quoted(glob)}"
    return "a pattern is a Python regular expression that matches the whole name, such as '.*_hip_joint'"


def _parser() -> Any:
    """The parser of `re`; its module moved in Python 3.11, and typeshed knows only the old name."""
    return importlib.import_module("re._parser" if sys.version_info >= (3, 11) else "sre_parse")


def _refuse(tree: Any, text: str) -> None:
    """Refuse backreferences, what Python 3.10 does not know, and repeats inside repeats."""
    for op, value in tree:
        name = str(op)
        if name in ("GROUPREF", "GROUPREF_EXISTS"):
            raise PatternError(f"{quoted(text)} refers back to a group, which patterns may not", _SIMPLER)
        if name in ("POSSESSIVE_REPEAT", "ATOMIC_GROUP"):
            raise PatternError(
                f"{quoted(text)} has a possessive repeat or an atomic group, unknown to Python 3.10",
                "write the plain repeat",
            )
        if name in ("MAX_REPEAT", "MIN_REPEAT"):
            low, high, body = value
            finite = int(high) != int(_parser().MAXREPEAT)
            if low > MAX_REPEAT or (finite and high > MAX_REPEAT):
                raise PatternError(f"{quoted(text)} repeats more than {MAX_REPEAT} times", _SIMPLER)
            if high > 1 and (_has_choice_of_length(body) or body.getwidth()[0] == 0):
                raise PatternError(
                    f"{quoted(text)} has a repeat inside a repeat, which can take forever"
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


def quoted(text: str) -> str:
    """A pattern for a message."""
    return f"'{shortened(text, 80)}'"


def steps(tree: Any, length: int, most: int) -> int | None:
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
