"""Work on all cores, by forked copies of this process, which have everything that it has."""

from __future__ import annotations

import pickle
import signal
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from actspec.audit.workers import pickled, process_context, start_quietly

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

_T = TypeVar("_T")


def spread(work: Callable[[int], _T], count: int, jobs: int) -> list[_T]:
    """Do something for every number below `count`.

    Where a fork is not safe all of it is done here, and so is the share of a process that dies.

    Args:
        work: What is done; changes nothing. Its results can be pickled.
        count: How often.
        jobs: Processes, this one among them.

    Returns: The results, in order.
    """
    context = process_context()
    jobs = max(1, min(jobs, count)) if context.get_start_method() == "fork" else 1
    helpers: list[_Helper[_T]] = []
    try:
        for first in range(1, jobs):
            # Numbers side by side are often alike, and take as long.
            helpers.append(_Helper.start(context, work, range(first, count, jobs)))
        found = {number: work(number) for number in range(0, count, jobs)}
        for helper in helpers:
            results = helper.results()
            if results is None:
                results = [work(number) for number in helper.share]
            found.update(zip(helper.share, results, strict=True))
    finally:
        for helper in helpers:
            helper.stop()
    return [found[number] for number in range(count)]


@dataclass(frozen=True, slots=True)
class _Helper(Generic[_T]):
    """A process with its share."""

    process: BaseProcess
    pipe: Connection[Any, Any]
    share: Sequence[int]

    @staticmethod
    def start(context: Any, work: Callable[[int], _T], share: Sequence[int]) -> _Helper[_T]:
        """Begin."""
        ours, theirs = context.Pipe(duplex=False)
        process = context.Process(target=_serve, args=(theirs, work, share), daemon=True)
        start_quietly(process)
        theirs.close()
        return _Helper(process, ours, share)

    def results(self) -> list[_T] | None:
        """Wait for its results; None: it has died."""
        try:
            found: list[_T] = pickle.loads(self.pipe.recv_bytes())
        except (EOFError, OSError):
            return None
        return found

    def stop(self) -> None:
        """End it."""
        self.process.kill()
        self.process.join()
        self.pipe.close()


def _serve(pipe: Connection[Any, Any], work: Callable[[int], _T], share: Sequence[int]) -> None:
    """A helper's life."""
    # The parent decides what an interrupt means, and ends its helpers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # What goes wrong here goes wrong in the parent again, which tells it.
    with suppress(Exception):
        pipe.send_bytes(pickled([work(number) for number in share]))
