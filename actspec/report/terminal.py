"""What commands print: diagnostics, JSON, and a progress bar; plain where the output is no terminal."""

from __future__ import annotations

import json
import math
import os
import re
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TextIO

from actspec.diagnostics import Diagnostic, Severity, many, one_line
from actspec.report.tables import COLOURED, Style

OUTPUT = {
    "ablate": "ablation",
    "audit": "report",
    "diagnose": "diagnosis",
    "report": "overview",
    "rule": "rules",
    "show": "actuators",
}
"""Commands whose machine output has another name."""

WRITING = ("ablate", "compile", "delta-train", "import", "init", "lock", "net-convert", "net-train", "sysid")
"""Commands whose work are files, all or none. Of an audit some fixes may be written when another one cannot be."""

QUIET = 2.0
"""Seconds without a bar: most runs are over by then."""
_EVERY = 0.1
_TICK = 0.5
_WIDTH = 30


def style_of(stream: TextIO) -> Style:
    """Colours on a terminal without NO_COLOR, else none."""
    return Style(stream.isatty() and not os.environ.get("NO_COLOR"))


def print_lines(lines: Iterable[str], stream: TextIO | None = None) -> None:
    """Print lines, by default to stdout; a line break inside of one, which a stranger's name may have, ends none."""
    for line in lines:
        if not line.isprintable():
            parts = COLOURED.split(line)
            line = "".join(part if COLOURED.fullmatch(part) else one_line(part) for part in parts)
        print(line, file=stream)


def print_diagnostics(diagnostics: Iterable[Diagnostic], stream: TextIO | None = None) -> None:
    """Print diagnostics, by default to stderr."""
    out = sys.stderr if stream is None else stream
    style = style_of(out)
    for item in diagnostics:
        print(str(item).replace(item.code, style.severity(item.code, item.severity), 1), file=out)


def print_failure(diagnostics: Sequence[Diagnostic], output_format: str, command: str) -> None:
    """Print why a command could not run; of `net` and `delta` with the part, as net-train."""
    if output_format == "json":
        name = OUTPUT.get(command, command)
        print_json(
            {"format": f"actspec-{name}/1", "diagnostics": [diagnostic_record(item) for item in diagnostics]}
        )
        return
    print_diagnostics(diagnostics)
    errors = sum(item.severity is Severity.ERROR for item in diagnostics)
    rest = "; nothing was written" if command in WRITING else ""
    print(f"{many(errors, 'error')}{rest}", file=sys.stderr)


def diagnostic_record(item: Diagnostic) -> dict[str, Any]:
    """A diagnostic as all machine output has it."""
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


def json_number(value: float | None) -> float | str | None:
    """A figure for JSON, which has no infinity: the text `Infinity`, which Python and JavaScript read as one."""
    if value is None or math.isnan(value):
        return None
    if math.isinf(value):
        return "Infinity" if value > 0 else "-Infinity"
    return float(value)


def json_text(data: Any) -> str:
    """Machine output in printable ASCII, whatever names hold; NaN and infinity are refused, they are no JSON."""
    # DEL is ASCII, and no character to print.
    text = json.dumps(data, indent=2, ensure_ascii=True, allow_nan=False)
    return _HALVES.sub(_whole, text).replace("\x7f", "\\u007f") + "\n"


_HALVES = re.compile(r"(\\\\|\\ud[89ab]..\\ud[c-f]..)|\\ud(?:c([89a-f].)|[89a-f]..)")
"""In JSON: what is to stay, or half a surrogate pair, which many programs refuse."""


def _whole(found: re.Match[str]) -> str:
    if found[1]:
        return found[1]
    return rf"\\x{found[2]}" if found[2] else rf"\{found[0]}"


def print_json(data: Any) -> None:
    """Print machine output to stdout."""
    sys.stdout.write(json_text(data))


class Progress:
    """Draws a bar while work is reported, and takes it away at the end.

    Args:
        doing: What is done: `reading`.
        clock: Gives the time [s].
    """

    def __init__(self, doing: str, clock: Callable[[], float] = time.monotonic) -> None:
        self._doing = doing
        self._clock = clock
        self._from = self._drawn_at = clock()
        self._drawn = False
        self._far = (0, 1)

    def step(self, done: int, total: int) -> None:
        """Say how far the work is."""
        self._far = (done, total)
        now = self._clock()
        if now - self._from < QUIET or now - self._drawn_at < _EVERY or not sys.stderr.isatty():
            return
        self._drawn, self._drawn_at = True, now
        filled = _WIDTH * done // max(total, 1)
        bar = "#" * filled + "." * (_WIDTH - filled)
        print(f"\r{self._doing} [{bar}] {done}/{total}", end="", file=sys.stderr, flush=True)

    @contextmanager
    def ticking(self) -> Iterator[None]:
        """Draw now and then by itself, because a step of the work may take long."""
        done = threading.Event()

        def tick() -> None:
            while not done.wait(_TICK):
                self.step(*self._far)

        thread = threading.Thread(target=tick, daemon=True)
        thread.start()
        try:
            yield
        finally:
            done.set()
            thread.join()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._drawn:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)
