"""A bar on stderr for work that takes longer than a moment, on a terminal only."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

QUIET = 2.0
"""Seconds without a bar: most runs are over by then."""
_EVERY = 0.1
_WIDTH = 30


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

    def step(self, done: int, total: int) -> None:
        """Say how far the work is."""
        now = self._clock()
        if now - self._from < QUIET or now - self._drawn_at < _EVERY or not sys.stderr.isatty():
            return
        self._drawn, self._drawn_at = True, now
        filled = _WIDTH * done // max(total, 1)
        bar = "#" * filled + "." * (_WIDTH - filled)
        print(f"\r{self._doing} [{bar}] {done}/{total}", end="", file=sys.stderr, flush=True)

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._drawn:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)
