"""A bar on stderr for work that takes longer than a moment, on a terminal only."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

QUIET = 2.0
"""Seconds without a bar: most runs are over by then."""
_EVERY = 0.1
_TICK = 0.5
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
