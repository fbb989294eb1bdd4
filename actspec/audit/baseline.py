"""Known findings in a file: hidden as long as they are there, reported when they have gone."""

from __future__ import annotations

import json
import math
import os
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from actspec.audit.finding import Finding
from actspec.audit.outcome import Means, Reported, Suppressed
from actspec.audit.places import json_fault, json_places
from actspec.audit.selection import is_diagnostic
from actspec.diagnostics import SEVERITIES, AuditError, Diagnostic, Severity, Span, shell_word
from actspec.files import NotRegular, TooLarge, json_of, name_in_file, read_regular
from actspec.owned import put_file

FORMAT = "actspec-baseline/1"

MOST_BYTES = 64 << 20
"""Chosen: about 300 000 entries."""

_OF_RUNS = ("AUD007", "AUD011", "AUD021", "AUD023")
"""What is said of a run, and not of a file."""

_MOST = 1e300
"""Numbers beyond are no floats."""

SAME = 0.01
"""Chosen: figures that depend on inertia differ by less from one release of MuJoCo to the next."""


@dataclass(frozen=True, slots=True)
class Entry:
    """Findings that are the same one, wherever in the file they stand and however they are worded.

    Attributes:
        code: Of the rule.
        file: Relative to the baseline's folder, with `/`.
        joint: Joint; "" when a file is concerned.
        value: The figure that is wrong [unit], to four digits; None where there is none, or the baseline has none.
        unit: Of the figure; None without one.
        expected: What the rule holds it to, likewise: where that changes, the same figure is wrong in another way.
        about: What else tells it from others: a key, a pattern, a field (`Finding.about`); None where the baseline
            has none.
        severity: As it was reported; None where the baseline does not say. What is worse by now is reported again.
    """

    code: str
    file: str
    joint: str
    value: float | None = None
    unit: str | None = None
    expected: float | None = None
    about: str | None = None
    severity: Severity | None = None

    def covers(self, other: Entry) -> bool:
        """Whether a finding is this one: a figure that has changed makes another one of it."""
        if (self.code, self.file, self.joint) != (other.code, other.file, other.joint):
            return False
        # Entries of earlier releases do not say it.
        if self.about is not None and self.about != other.about:
            return False
        if self.value is None:
            return True
        figures = [(self.value, other.value)]
        # Entries of earlier releases do not say what the figure was held to.
        figures += [(self.expected, other.expected)] if self.expected is not None else []
        return self.unit == other.unit and all(
            its is not None and mine is not None and math.isclose(mine, its, rel_tol=SAME)
            for mine, its in figures
        )


@dataclass(frozen=True, slots=True)
class Baseline:
    """A baseline, read.

    Attributes:
        entries: With their counts.
        driven: MJCF, as an entry's file, to the joints that its actuators drove.
    """

    entries: Counter[Entry]
    driven: Mapping[str, frozenset[str]]


def entry_of(finding: Finding, folder: str) -> Entry:
    """The entry that a finding belongs to; its file relative to a folder."""
    value = _figure(finding.value)
    return Entry(
        finding.code,
        name_in_file(relative_path(finding.span.path, folder)),
        finding.joint,
        value,
        None if value is None else finding.unit or None,
        None if value is None else _figure(finding.expected),
        name_in_file(finding.about) or None,
    )


def _figure(value: float | None) -> float | None:
    """To four digits; None for what is no number."""
    return None if value is None or not math.isfinite(value) else float(f"{value:.4g}")


def entry_about(item: Diagnostic, folder: str) -> Entry | None:
    """The entry of a warning about a file beside its findings, as that only its text is judged; None: it has none."""
    settable = is_diagnostic(item.code) and item.code not in _OF_RUNS
    if item.severity is not Severity.WARNING or item.span is None or not settable:
        return None
    return Entry(item.code, name_in_file(relative_path(item.span.path, folder)), item.where)


def relative_path(path: str, folder: str) -> str:
    """A path relative to a folder, with `/`; absolute where they share no drive."""
    try:
        relative = os.path.relpath(os.path.realpath(path), os.path.realpath(folder or "."))
    except ValueError:
        relative = os.path.realpath(path)
    return relative.replace(os.sep, "/")


def baseline_text(
    findings: Iterable[Reported],
    path: str,
    said: Iterable[Diagnostic] = (),
    kept: Mapping[Entry, int] | None = None,
    driven: Mapping[str, Iterable[str]] | None = None,
) -> str:
    """The baseline that hides these findings.

    Args:
        findings: To be hidden.
        path: Where it will stand.
        said: What is said of files beside them; of it the warnings are hidden.
        kept: Entries of the one before it that stay, none of which is about these findings, with their counts.
        driven: As `Baseline.driven`.
    """
    folder = os.path.dirname(path)
    counts = Counter(
        replace(entry_of(reported.finding, folder), severity=reported.severity) for reported in findings
    )
    counts.update(filter(None, (entry_about(item, folder) for item in said)))
    counts.update(kept or {})
    records = [_record(entry, counts[entry]) for entry in sorted(counts, key=_place)]
    lines = ",\n".join("    " + json_of(record, indent=None) for record in records)
    body = f"[\n{lines}\n  ]" if records else "[]"
    drives = [{"file": file, "joints": sorted(joints)} for file, joints in sorted((driven or {}).items())]
    lines = ",\n".join("    " + json_of(drive, indent=None) for drive in drives)
    more = f',\n  "driven": [\n{lines}\n  ]' if drives else ""
    return f'{{\n  "format": "{FORMAT}",\n  "findings": {body}{more}\n}}\n'


def _record(entry: Entry, count: int) -> dict[str, Any]:
    figure: dict[str, Any] = {} if entry.value is None else {"value": entry.value, "unit": entry.unit or ""}
    held_to = {} if entry.expected is None else {"expected": entry.expected}
    about = {} if entry.about is None else {"about": entry.about}
    severity = {} if entry.severity is None else {"severity": entry.severity.value}
    at = {"code": entry.code, "file": entry.file, "joint": entry.joint}
    return {**at, **about, **figure, **held_to, **severity, "count": count}


def _place(entry: Entry) -> tuple[object, ...]:
    figures = (entry.value or 0.0, entry.value is None, entry.expected or 0.0, entry.expected is None)
    severity = "" if entry.severity is None else entry.severity.value
    return entry.code, entry.file, entry.joint, entry.about or "", entry.unit or "", *figures, severity


def write_baseline(
    findings: Iterable[Reported],
    path: str,
    said: Iterable[Diagnostic] = (),
    *,
    kept: Mapping[Entry, int] | None = None,
    driven: Mapping[str, Iterable[str]] | None = None,
    force: bool = False,
) -> None:
    """Write the baseline that hides these findings; see `baseline_text`.

    Raises:
        AuditError: the file cannot be written.
        EmitError: there is another file, and not `force`.
    """
    try:
        data = baseline_text(findings, path, said, kept, driven).encode()
        put_file(path, data, force=force)
    except (OSError, ValueError) as err:
        reason = (getattr(err, "strerror", None) or str(err)).lower()
        raise _error("AUD006", f"the baseline cannot be written: {reason}", path) from err


def read_baseline(path: str, former: Mapping[str, str]) -> Baseline:
    """Read a baseline.

    Args:
        path: The file.
        former: Codes of rules that are gone to those that took their place.

    Raises: AuditError: the file cannot be read or is no baseline.
    """
    try:
        raw = read_regular(path, MOST_BYTES)
        text = raw.decode("utf-8")
        data: Any = json.loads(text)
    except (NotRegular, TooLarge) as err:
        raise _error("AUD005", f"the baseline cannot be read: {err}", path) from err
    except OSError as err:
        # The settings name it before there is one; what is typed after `audit` is the user's.
        write = f"`actspec audit FILE --write-baseline {shell_word(path)}` writes it; until then all is shown"
        help = write if isinstance(err, FileNotFoundError) else None
        reason = (err.strerror or str(err)).lower()
        raise _error("AUD005", f"the baseline cannot be read: {reason}", path, help) from err
    except (ValueError, RecursionError) as err:
        at, why_not = json_fault(raw, err)
        raise _error("AUD005", f"this is not JSON in UTF-8: {why_not}", path, at=at) from err
    found = data.get("format") if isinstance(data, dict) else None
    if found != FORMAT:
        newer = isinstance(found, str) and found.startswith("actspec-baseline/")
        message = (
            "the baseline is of another version of actspec" if newer else "this is no baseline of actspec"
        )
        at = json_places(text, [("format",)]).get(("format",), (1, 1))
        raise _error("AUD005", message, path, f"write it again with --write-baseline {path}", at)
    entries: Counter[Entry] = Counter()
    records = data.get("findings")
    for index, record in enumerate(records if isinstance(records, list) else [None]):
        known: dict[str, Any] = record if isinstance(record, dict) else {}
        texts: list[Any] = [known.get("code"), known.get("file"), known.get("joint")]
        texts += [known.get("unit", ""), known.get("about", "")]
        count, value, expected = known.get("count"), known.get("value"), known.get("expected")
        severity = known.get("severity")
        if (
            not all(isinstance(text, str) for text in texts)
            or severity not in (None, *(one.value for one in Severity))
            or not isinstance(count, int)
            or not 0 < count < _MOST
            or not all(
                figure is None or (isinstance(figure, (int, float)) and abs(figure) < _MOST)
                for figure in (value, expected)
            )
        ):
            message = "an entry of the baseline is not as actspec writes it"
            places = json_places(text, [("findings",), ("findings", index)])
            at = places.get(("findings", index), places.get(("findings",), (1, 1)))
            raise _error("AUD005", message, path, f"write it again with --write-baseline {path}", at)
        # Entries of earlier releases have the hash of a message in place of a figure.
        code, file, joint, unit, about = texts
        was = None if severity is None else Severity(severity)
        entry = Entry(former.get(code, code), file, joint, value, unit or None, expected, about or None, was)
        entries[entry] += count
    driven: dict[str, frozenset[str]] = {}
    drives = data.get("driven", [])
    for index, drive in enumerate(drives if isinstance(drives, list) else [None]):
        file, joints = (
            (drive.get(key) for key in ("file", "joints")) if isinstance(drive, dict) else (None, None)
        )
        if (
            not isinstance(file, str)
            or not isinstance(joints, list)
            or not all(isinstance(one, str) for one in joints)
        ):
            message = "the driven joints of a file are not as actspec writes them"
            places = json_places(text, [("driven",), ("driven", index)])
            at = places.get(("driven", index), places.get(("driven",), (1, 1)))
            raise _error("AUD005", message, path, f"write it again with --write-baseline {path}", at)
        driven[file] = driven.get(file, frozenset()) | frozenset(joints)
    return Baseline(entries, driven)


def apply_baseline(
    found: Sequence[Reported], entries: Counter[Entry], folder: str
) -> tuple[tuple[Reported, ...], tuple[Suppressed, ...], Counter[Entry]]:
    """Set known findings aside.

    Args:
        found: Findings in their order.
        entries: The baseline.
        folder: Its folder.

    Returns: findings that stay, those set aside, and entries that no finding belongs to any more.
    """
    owned = [entry_of(reported.finding, folder) for reported in found]
    known, left = _matched([reported.severity for reported in found], owned, entries)
    kept, suppressed = [], []
    for number, reported in enumerate(found):
        entry = known.get(number)
        if entry is None or _is_worse(reported.severity, entry.severity):
            kept.append(reported)
        else:
            suppressed.append(Suppressed(reported, Means.BASELINE))
    return tuple(kept), tuple(suppressed), left


def _matched(
    severities: Sequence[Severity], owned: Sequence[Entry], entries: Counter[Entry]
) -> tuple[dict[int, Entry], Counter[Entry]]:
    """The entry of each finding that has one, by the finding's number, and the entries that are left.

    To each its own first, so that a baseline covers all that it was written of: figures of two findings may be as near
    as one figure in two releases. Then an entry that is not milder, those that say most, the nearest.
    """
    left, known = Counter(entries), dict[int, Entry]()
    for number, own in enumerate(owned):
        itself = replace(own, severity=severities[number])
        if left[itself] > 0:
            left[itself] -= 1
            known[number] = itself
    left = +left
    by_place: dict[tuple[str, str, str], list[Entry]] = {}
    for entry in left:
        by_place.setdefault((entry.code, entry.file, entry.joint), []).append(entry)
    pairs = []
    for number, own in enumerate(owned):
        for entry in by_place.get((own.code, own.file, own.joint), ()) if number not in known else ():
            if entry.covers(own):
                pairs.append((_distance(severities[number], own, entry), number, entry))
    for _, number, entry in sorted(pairs, key=lambda pair: pair[0]):
        if number not in known and left[entry] > 0:
            left[entry] -= 1
            known[number] = entry
    return known, +left


def _distance(severity: Severity, own: Entry, entry: Entry) -> tuple[bool | float, ...]:
    """How far an entry that covers a finding is from it: what counts most stands first."""
    is_it = replace(entry, severity=None) == own
    says_less = entry.about is None, entry.value is None, entry.expected is None
    off = sum(
        abs(its - mine) / max(abs(its), abs(mine))
        for its, mine in ((entry.value, own.value), (entry.expected, own.expected))
        if its is not None and mine is not None and its != mine
    )
    worse = _is_worse(severity, entry.severity)
    return not is_it, worse, *says_less, entry.severity not in (None, severity), off


def _is_worse(now: Severity, was: Severity | None) -> bool:
    return was is not None and SEVERITIES.index(now) > SEVERITIES.index(was)


def _error(
    code: str, message: str, path: str, help: str | None = None, at: tuple[int, int] = (0, 0)
) -> AuditError:
    return AuditError([Diagnostic(code, Severity.ERROR, message, "", Span(path, *at), help)])
