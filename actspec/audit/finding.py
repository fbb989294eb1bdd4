"""What a rule finds: a finding, or that it could not look; and the edits that would put it right."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from enum import Enum

from actspec.diagnostics import Severity, Span


class Confidence(str, Enum):
    """How sure a rule is that its finding is a fault and not a choice."""

    HIGH = "high"
    """The files contradict themselves, each other or the engine."""
    MEDIUM = "medium"
    """Seldom wanted."""
    LOW = "low"
    """Worth a look."""


class Safety(str, Enum):
    """Whether a fix can be applied without asking."""

    SAFE = "safe"
    """What the engine computes stays the same, or the file says plainly what is meant."""
    UNSAFE = "unsafe"
    """The robot behaves otherwise afterwards."""


@dataclass(frozen=True, slots=True)
class TextEdit:
    """One replacement in one file.

    Attributes:
        path: The file, as in `FileReading.files`.
        start: First byte.
        end: Just after the last byte.
        new: What stands there then.
    """

    path: str
    start: int
    end: int
    new: bytes


@dataclass(frozen=True, slots=True)
class Fix:
    """Edits that put a finding right, applied all or none.

    Attributes:
        title: What the fix does: `Set forcerange to -33.5 33.5`.
        safety: Whether it needs consent.
        edits: In one or several files; they do not overlap.
        fields: Names of the compiled model's fields that may change: (`actuator_forcerange`, ...).
    """

    title: str
    safety: Safety
    edits: tuple[TextEdit, ...]
    fields: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that a rule found.

    The message does not name the joint, so that reports can put equal findings of many joints together.

    Attributes:
        code: Of the rule.
        message: What is wrong and what it does to the robot, with figures and units; one sentence.
        span: The place that decides.
        joint: Joint that it concerns; "" when it concerns a file.
        joints: Joints of that file that it is about where it is not that one alone, for counts.
        fields: Figures of the joint that it is about, names in `FIELDS`: what two rules say of one figure is one fault.
        value: The figure that is wrong [unit]; None where there is none.
        unit: Unit of `value` and `expected`; None without a value.
        expected: What it should be, in `unit`; None when nobody knows.
        help: The nearest right answer.
        related: Other places that the finding is about (the other file of a disagreement).
        fix: None: no automatic fix.
        about: What tells it from others of its rule about this joint or file where `value` does not: a key, a pattern,
            a field, figures as written. Baselines hold it, so it has no words of the message and no line.
        names: What else it is called in settings: code and name of the reader's remark that it reports.
        noted_in_folders: Whether it is a note in a file that was met in a folder, where those of its rule are not all.
        severity: Where it differs from the rule's own; None: the rule's.
        confidence: Likewise.
    """

    code: str
    message: str
    span: Span
    joint: str = ""
    joints: tuple[str, ...] = field(default=(), kw_only=True)
    fields: tuple[str, ...] = field(default=(), kw_only=True)
    about: str = field(default="", kw_only=True)
    names: tuple[str, ...] = field(default=(), kw_only=True)
    noted_in_folders: bool = field(default=False, kw_only=True)
    value: float | None = None
    unit: str | None = None
    expected: float | None = None
    help: str | None = None
    related: tuple[Span, ...] = ()
    fix: Fix | None = None
    severity: Severity | None = None
    confidence: Confidence | None = None


@dataclass(frozen=True, slots=True)
class Skipped:
    """A rule that had no input to judge.

    Attributes:
        code: Of the rule.
        reason: What it lacks: `no Isaac Lab cfg among the files`.
    """

    code: str
    reason: str


def quoted(message: str) -> tuple[str, ...]:
    """Names that stand in quotes in the message of a reader or of MuJoCo, whose other words are not a rule's."""
    return tuple(re.findall(r"'([^']+)'", message))
