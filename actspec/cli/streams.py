"""Where commands print: nothing in what they say can steer a terminal, and a stream that fails ends the run.

A reader that has gone (`| head`) has what it wanted: the run goes on without it, to its files and its exit code.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO, cast

from actspec.diagnostics import one_line
from actspec.files import why

_OWN = re.compile(r"(\x1b\[(?:0|1|2|31|33|36)m|\r|\x1b\[K)")
"""What commands say to a terminal themselves: the colours of `actspec.report.tables`, and the bar of progress."""


class StreamError(Exception):
    """What a command has to say cannot be written; the text says why."""


class Printed:
    """A standard stream that shows text as it is, and no control character of a stranger's name or file.

    Line breaks and tabs pass, and on a terminal the colours and the bar that commands draw. What the stream's
    encoding lacks is escaped too.
    """

    def __init__(self, stream: TextIO | None, needed: bool) -> None:
        """
        Args:
            stream: Where text goes; None: it was closed before the process began.
            needed: Whether a run whose text cannot be written has failed; else the text is lost.
        """
        self._stream = stream
        self._needed = needed
        self._terminal = stream is not None and stream.isatty()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def isatty(self) -> bool:
        """Whether somebody looks at it."""
        return self._terminal and self._stream is not None

    def write(self, text: str) -> int:
        """Write text.

        Raises:
            StreamError: it cannot be written, though it is needed and somebody reads.
        """
        if self._stream is not None:
            with self._faults():
                self._stream.write(self._shown(text))
        elif self._needed:
            raise StreamError("the output cannot be written: it is closed")
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        """Write texts, one after the other."""
        for line in lines:
            self.write(line)

    def flush(self) -> None:
        """Hand over what was written; a stream that is closed has nothing."""
        if self._stream is not None:
            with self._faults():
                self._stream.flush()

    def _shown(self, text: str) -> str:
        if not text.isprintable():
            parts = _OWN.split(text) if self._terminal else [text]
            # Every second part is one of our own.
            parts[::2] = ["\n".join(map(_line, part.split("\n"))) for part in parts[::2]]
            text = "".join(parts)
        encoding = getattr(self._stream, "encoding", None) or "utf-8"
        return text if text.isascii() else text.encode(encoding, "backslashreplace").decode(encoding)

    @contextmanager
    def _faults(self) -> Iterator[None]:
        try:
            yield
        except (OSError, ValueError) as err:  # ValueError: it has been closed
            # What it holds goes nowhere, or the end of the process would fail on it once more.
            with suppress(OSError, ValueError, AttributeError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), cast(TextIO, self._stream).fileno())
            self._stream = None
            self._needed = self._needed and not isinstance(err, BrokenPipeError)
            if self._needed:
                raise StreamError(f"the output cannot be written: {why(err)}") from err


@contextmanager
def printing() -> Iterator[None]:
    """Print through `Printed` from here on."""
    before = sys.stdout, sys.stderr
    sys.stdout = cast(TextIO, Printed(sys.stdout, needed=True))
    sys.stderr = cast(TextIO, Printed(sys.stderr, needed=False))
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def _line(text: str) -> str:
    return text if text.isprintable() else "\t".join(one_line(part) for part in text.split("\t"))
