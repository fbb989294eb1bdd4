"""What commands print: diagnostics and JSON; plain where the output is no terminal."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Sequence
from typing import Any, TextIO

from actspec.diagnostics import Diagnostic, Severity

COLOURS = {Severity.ERROR: "31", Severity.WARNING: "33", Severity.INFO: "36"}

OUTPUT = {"audit": "report", "rule": "rules"}
"""Commands whose machine output has another name."""

WRITING = ("compile", "import", "init", "lock")
"""Commands whose work are files, all or none. Of an audit some fixes may be written when another one cannot be."""


def colour(text: str, code: str, stream: TextIO) -> str:
    """Text in an ANSI colour on a terminal without NO_COLOR, else as it is."""
    if os.environ.get("NO_COLOR") or not stream.isatty():
        return text
    return f"\x1b[{code}m{text}\x1b[0m"


def print_diagnostics(diagnostics: Iterable[Diagnostic], stream: TextIO | None = None) -> None:
    """Print diagnostics, by default to stderr."""
    out = sys.stderr if stream is None else stream
    for item in diagnostics:
        text = str(item)
        print(text.replace(item.code, colour(item.code, COLOURS[item.severity], out), 1), file=out)


def print_failure(diagnostics: Sequence[Diagnostic], output_format: str, command: str) -> None:
    """Print why a command could not run."""
    if output_format == "json":
        name = OUTPUT.get(command, command)
        print_json({"format": f"actspec-{name}/1", "diagnostics": [record(item) for item in diagnostics]})
        return
    print_diagnostics(diagnostics)
    errors = sum(item.severity is Severity.ERROR for item in diagnostics)
    rest = "; nothing was written" if command in WRITING else ""
    print(f"{errors} error{'s' * (errors != 1)}{rest}", file=sys.stderr)


def record(item: Diagnostic) -> dict[str, Any]:
    """A diagnostic as machine output has it."""
    return {
        "code": item.code,
        "severity": item.severity.value,
        "file": item.span.path if item.span is not None else None,
        "line": item.span.line or None if item.span is not None else None,
        "column": item.span.column or None if item.span is not None else None,
        "where": item.where or None,
        "message": item.message,
        "help": item.help,
    }


def print_json(data: Any) -> None:
    """Print machine output to stdout; NaN and infinity are refused, they are no JSON."""
    print(json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False))
