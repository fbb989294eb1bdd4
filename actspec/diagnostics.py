"""Diagnostics: what actspec says about a file, and the exit codes it says it with.

One `Diagnostic` serves spec errors, robot errors, emission errors and findings.
A stage collects all of its diagnostics before it stops (`Collector`).
"""

from __future__ import annotations

import difflib
import re
import shlex
from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from typing_extensions import Self

EXIT_CLEAN = 0
"""Nothing to report."""
EXIT_FINDINGS = 1
"""Findings, stale output, or approximations under `--strict`."""
EXIT_FAILED = 2
"""The work could not be done: bad file, bad option."""


class Severity(str, Enum):
    """How bad a diagnostic is; `error` stops the stage."""

    ERROR = "error"
    WARNING = "warning"
    INFO = "info"


SEVERITIES = (Severity.INFO, Severity.WARNING, Severity.ERROR)
"""From the least to the worst."""


@dataclass(frozen=True, slots=True, order=True)
class Span:
    """A place in a file.

    Attributes:
        path: The file as the user named it.
        line: Line, from 1; 0 means the file as a whole.
        column: Column, from 1; 0 means the line as a whole.
    """

    path: str
    line: int = 0
    column: int = 0

    def __str__(self) -> str:
        text = one_line(self.path)
        if self.line:
            text += f":{self.line}"
            if self.column:
                text += f":{self.column}"
        return text


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One thing to say about one place.

    Attributes:
        code: Stable code, family letters and number, e.g. `SPEC012`.
        severity: error, warning or info.
        message: What is wrong, with the value and its unit; one sentence.
        where: Path inside the file (`actuators.legs.kp`) or the joint's name; may be empty.
        span: File, line and column; None when no file is concerned.
        help: The nearest right answer; None when there is none.
    """

    code: str
    severity: Severity
    message: str
    where: str = ""
    span: Span | None = None
    help: str | None = None

    def __str__(self) -> str:
        place = f"{self.span}: " if self.span is not None else ""
        where = f" {one_line(self.where)}" if self.where else ""
        kind = "" if self.severity is Severity.ERROR else f" [{self.severity.value}]"
        text = f"{place}{self.code}{kind}{where}: {one_line(self.message)}"
        if self.help:
            text += f"\n  help: {one_line(self.help)}"
        return text


class ActspecError(Exception):
    """A stage could not be done; carries every diagnostic of that stage.

    Attributes:
        diagnostics: All diagnostics of the stage, warnings included, in order.
    """

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics: tuple[Diagnostic, ...] = tuple(diagnostics)
        super().__init__("\n".join(str(d) for d in self.diagnostics))

    @classmethod
    def of(
        cls, code: str, message: str, span: Span | None = None, *, where: str = "", help: str | None = None
    ) -> Self:
        """The error of a stage that has one diagnostic."""
        return cls([Diagnostic(code, Severity.ERROR, message, where, span, help)])


class SpecError(ActspecError):
    """The spec's text is not a valid spec (load, validate)."""


class RobotError(ActspecError):
    """The robot's model could not be found, read or understood."""


class ResolveError(ActspecError):
    """The spec does not fit the robot."""


class EmitError(ActspecError):
    """A target cannot be written."""


class AuditError(ActspecError):
    """The audit cannot start: its settings, its baseline or its options are wrong."""


class TooManyErrors(SpecError, RobotError, ResolveError, EmitError, AuditError):
    """A stage has stopped at so many errors; it may be any."""


MOST_ERRORS = 1000
"""Of one stage. Chosen: nobody reads more, and a file with more has one cause."""


@dataclass(slots=True)
class Collector:
    """Collects the diagnostics of one stage, so that all are shown at once."""

    items: list[Diagnostic] = field(default_factory=list)
    _known: set[Diagnostic] = field(default_factory=set, repr=False)
    _errors: int = 0

    def add(self, diagnostic: Diagnostic) -> None:
        """Add a ready diagnostic, unless the very same one is there already.

        Raises: TooManyErrors: it is the last of `MOST_ERRORS`.
        """
        if diagnostic in self._known:
            return
        self._known.add(diagnostic)
        self.items.append(diagnostic)
        self._errors += diagnostic.severity is Severity.ERROR
        if self._errors == MOST_ERRORS:
            message = f"stopped at {MOST_ERRORS} errors"
            raise TooManyErrors(
                [*self.items, Diagnostic("ENV004", Severity.ERROR, message, "", diagnostic.span)]
            )

    def error(
        self, code: str, message: str, *, where: str = "", span: Span | None = None, help: str | None = None
    ) -> None:
        """Add an error."""
        self.add(Diagnostic(code, Severity.ERROR, message, where, span, help))

    def warning(
        self, code: str, message: str, *, where: str = "", span: Span | None = None, help: str | None = None
    ) -> None:
        """Add a warning."""
        self.add(Diagnostic(code, Severity.WARNING, message, where, span, help))

    def info(
        self, code: str, message: str, *, where: str = "", span: Span | None = None, help: str | None = None
    ) -> None:
        """Add a piece of information."""
        self.add(Diagnostic(code, Severity.INFO, message, where, span, help))

    def at(self, where: str = "", span: Span | None = None) -> Place:
        """What is reported of one place goes here."""
        return Place(self, where, span)

    def forget(self, codes: Container[str], where: Container[str] | None = None, path: str = "") -> None:
        """Take back what was reported under these codes, where more is known now and it is judged again.

        Args:
            codes: Of what.
            where: Only of these parts or joints; None: of all.
            path: Only of this file; "": of all.
        """
        self.items = [
            item
            for item in self.items
            if item.code not in codes
            or (where is not None and item.where not in where)
            or (path and (item.span is None or item.span.path != path))
        ]
        self._known = set(self.items)
        self._errors = sum(item.severity is Severity.ERROR for item in self.items)

    @property
    def failed(self) -> bool:
        """Whether an error is among the items."""
        return any(d.severity is Severity.ERROR for d in self.items)

    def raise_if_failed(self, error: type[ActspecError]) -> None:
        """Raise `error` with all items if one of them is an error."""
        if self.failed:
            raise error(self.sorted())

    def sorted(self) -> tuple[Diagnostic, ...]:
        """All items by file, line and column; those without a place last."""
        return tuple(sorted(self.items, key=lambda d: (d.span is None, d.span or Span(""), d.code)))

    def __iter__(self) -> Iterator[Diagnostic]:
        return iter(self.items)


@dataclass(frozen=True, slots=True)
class Place:
    """A part of a spec or a model, and who collects what is reported of it.

    Attributes:
        collector: Takes the diagnostics.
        where: The part, for people: `actuators.legs.kp`, or a joint.
        span: Where it is written; None: nowhere.
    """

    collector: Collector
    where: str = ""
    span: Span | None = None

    def error(self, code: str, message: str, help: str | None = None) -> None:
        """Add an error."""
        self.collector.error(code, message, where=self.where, span=self.span, help=help)

    def warning(self, code: str, message: str, help: str | None = None) -> None:
        """Add a warning."""
        self.collector.warning(code, message, where=self.where, span=self.span, help=help)

    def info(self, code: str, message: str, help: str | None = None) -> None:
        """Add a piece of information."""
        self.collector.info(code, message, where=self.where, span=self.span, help=help)


def one_line(text: str) -> str:
    """Make text from a stranger's file safe to print: one line, no control characters."""
    if text.isprintable():
        return text
    text = bytes_escaped(text)
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def in_quotes(text: str) -> str:
    """Text from a stranger's file as it stands there, in quotes: `repr` would double each backslash of a path."""
    quote = '"' if "'" in text else "'"
    return f"{quote}{one_line(text)}{quote}"


def shell_word(text: str) -> str:
    """A name as a shell takes it, on one line and printable, to paste."""
    quoted = shlex.quote(text)
    if quoted.isprintable():
        return quoted
    inside = text.replace("\\", "\\\\").replace("'", "\\'")
    return f"$'{one_line(inside)}'"


def bytes_escaped(text: str) -> str:
    """Text in which bytes of a file's name that are not UTF-8, to Python half surrogate pairs, stand as `\\xff`."""
    return _BYTE.sub(lambda found: f"\\x{ord(found[0]) - 0xDC00:02x}", text)


_BYTE = re.compile("[\udc80-\udcff]")


def shortened(text: str, most: int = 60) -> str:
    """Text from a stranger's file for a message: safe to print, and at most `most` characters."""
    text = one_line(text[: most + 1])
    return text if len(text) <= most else text[: most - 3] + "..."


def listed(names: Iterable[str], most: int = 8) -> str:
    """Names in the given order, at most `most`, then how many more."""
    all_names = list(names)
    text = ", ".join(all_names[:most])
    if len(all_names) > most:
        text += f" and {len(all_names) - most} more"
    return text


def alternatives(readings: Iterable[str]) -> str:
    """What a number may be meant as, one after the other: "did you mean 3 rpm? Or did you mean 0.3 rad/s?"."""
    return "; or ".join(readings).replace("?; or ", "? Or ")


def many(count: int, noun: str) -> str:
    """A count with its noun: `1 joint`, `2 joints`."""
    return f"{count} {noun}{'s' * (count != 1)}"


def nearest(name: str, known: Sequence[str]) -> str | None:
    """The known name that is nearest to a misspelt one, or None if none is near."""
    spelt = name.lower().replace("-", "_")
    cased = [other for other in known if other.lower().replace("-", "_") == spelt]
    if cased:
        return cased[0]
    if len(known) > _MOST_COMPARED:
        # Of many those that share most pairs of letters: to compare all of them takes a second a hundred names.
        pairs = _pairs(name)
        known = sorted(known, key=lambda other: -len(pairs & _pairs(other)))[:_MOST_COMPARED]
    found = difflib.get_close_matches(name, known, n=1, cutoff=0.6)
    return found[0] if found else None


_MOST_COMPARED = 50


@lru_cache(maxsize=1 << 14)
def _pairs(name: str) -> frozenset[str]:
    """Pairs of neighbouring letters."""
    return frozenset(map("".join, pairwise(name)))


def did_you_mean(name: str, known: Sequence[str], otherwise: str | None = None) -> str | None:
    """The help for a misspelt name: the nearest known one, else `otherwise`."""
    guess = nearest(name, known)
    return otherwise if guess is None else f"did you mean '{guess}'?"


Path = tuple[str | int, ...]
"""Keys and indices from the top."""


def dotted(path: Path) -> str:
    """`('actuators', 'legs', 'joints', 0)` as `actuators.legs.joints[0]`."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            text += f".{part}" if text else part
    return text
