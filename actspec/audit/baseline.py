"""Known findings in a file: hidden as long as they are there, reported when they have gone."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from actspec.audit.finding import Finding
from actspec.audit.outcome import Means, Reported, Suppressed
from actspec.diagnostics import AuditError, Diagnostic, Severity, Span
from actspec.files import NotRegular, TooLarge, read_regular, replace_file

FORMAT = "actspec-baseline/1"

MOST_BYTES = 64 << 20
"""Chosen: about 300 000 entries."""

_PLACE = re.compile(r"(\.(?:xml|mjcf|urdf|xacro|py|ya?ml|json)):\d+(?::\d+)?\b|\blines? \d+")
"""A line and column behind a file's name, or in words."""


@dataclass(frozen=True, slots=True, order=True)
class Entry:
    """Findings that are the same one, wherever in the file they stand now.

    Attributes:
        code: Of the rule.
        file: Relative to the baseline's folder, with `/`.
        joint: Joint; "" when a file is concerned.
        hash: Of the message without places.
    """

    code: str
    file: str
    joint: str
    hash: str


def stable_hash(message: str) -> str:
    """Hash of a message without its line numbers: 16 hexadecimal digits."""
    return hashlib.sha256(_PLACE.sub(r"\1", message).encode("utf-8", "replace")).hexdigest()[:16]


def entry_of(finding: Finding, folder: str) -> Entry:
    """The entry that a finding belongs to; its file relative to a folder."""
    return Entry(
        finding.code, relative_path(finding.span.path, folder), finding.joint, stable_hash(finding.message)
    )


def relative_path(path: str, folder: str) -> str:
    """A path relative to a folder, with `/`; absolute where they share no drive."""
    try:
        relative = os.path.relpath(os.path.realpath(path), os.path.realpath(folder or "."))
    except ValueError:
        relative = os.path.realpath(path)
    return relative.replace(os.sep, "/")


def baseline_text(findings: Iterable[Reported], path: str) -> str:
    """The baseline that hides these findings.

    Args:
        findings: To be hidden.
        path: Where it will stand.
    """
    folder = os.path.dirname(path)
    counts = Counter(entry_of(reported.finding, folder) for reported in findings)
    records = [
        {"code": e.code, "file": e.file, "joint": e.joint, "hash": e.hash, "count": counts[e]}
        for e in sorted(counts)
    ]
    lines = ",\n".join("    " + json.dumps(record, ensure_ascii=False) for record in records)
    body = f"[\n{lines}\n  ]" if records else "[]"
    return f'{{\n  "format": "{FORMAT}",\n  "findings": {body}\n}}\n'


def write_baseline(findings: Iterable[Reported], path: str) -> None:
    """Write the baseline that hides these findings.

    Raises: AuditError: the file cannot be written.
    """
    try:
        replace_file(path, baseline_text(findings, path).encode("utf-8", "surrogatepass"))
    except (OSError, ValueError) as err:
        reason = (getattr(err, "strerror", None) or str(err)).lower()
        raise _error("AUD006", f"the baseline cannot be written: {reason}", path) from err


def read_baseline(path: str, former: Mapping[str, str]) -> Counter[Entry]:
    """Entries of a baseline with their counts.

    Args:
        path: The file.
        former: Codes of rules that are gone to those that took their place.

    Raises: AuditError: the file cannot be read or is no baseline.
    """
    try:
        data: Any = json.loads(read_regular(path, MOST_BYTES).decode("utf-8"))
    except (NotRegular, TooLarge) as err:
        raise _error("AUD005", f"the baseline cannot be read: {err}", path) from err
    except OSError as err:
        help = f"write it with --write-baseline {path}" if isinstance(err, FileNotFoundError) else None
        reason = (err.strerror or str(err)).lower()
        raise _error("AUD005", f"the baseline cannot be read: {reason}", path, help) from err
    except (ValueError, RecursionError) as err:
        raise _error("AUD005", "this is not JSON in UTF-8", path) from err
    found = data.get("format") if isinstance(data, dict) else None
    if found != FORMAT:
        newer = isinstance(found, str) and found.startswith("actspec-baseline/")
        message = (
            "the baseline is of another version of actspec" if newer else "this is no baseline of actspec"
        )
        raise _error("AUD005", message, path, f"write it again with --write-baseline {path}")
    entries: Counter[Entry] = Counter()
    records = data.get("findings")
    for record in records if isinstance(records, list) else [None]:
        known = record if isinstance(record, dict) else {}
        texts: list[Any] = [known.get(key) for key in ("code", "file", "joint", "hash")]
        count = known.get("count")
        if not isinstance(count, int) or count < 1 or not all(isinstance(text, str) for text in texts):
            message = "an entry of the baseline is not as actspec writes it"
            raise _error("AUD005", message, path, f"write it again with --write-baseline {path}")
        entries[Entry(former.get(texts[0], texts[0]), *texts[1:])] += count
    return entries


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
    left = Counter(entries)
    kept, suppressed = [], []
    for reported in found:
        entry = entry_of(reported.finding, folder)
        if left[entry] > 0:
            left[entry] -= 1
            suppressed.append(Suppressed(reported, Means.BASELINE))
        else:
            kept.append(reported)
    return tuple(kept), tuple(suppressed), +left


def _error(code: str, message: str, path: str, help: str | None = None) -> AuditError:
    return AuditError([Diagnostic(code, Severity.ERROR, message, "", Span(path), help)])
