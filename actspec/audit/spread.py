"""Work on all cores, by forked copies of this process, which have everything that it has."""

from __future__ import annotations

import os
import pickle
import signal
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from actspec.audit.workers import pickled, process_context, start_quietly

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

_T = TypeVar("_T")


def spread(work: Callable[[int], _T], count: int, jobs: int, many: tuple[type, ...] = ()) -> list[_T]:
    """Do something for every number below `count`.

    Each process takes the next number when it is done with one. Where a fork is not safe all of it is done
    here, and so is what a process that dies had taken.

    Args:
        work: What is done; changes nothing. Its results can be pickled.
        count: How often; those that take long come first.
        jobs: Processes, this one among them.
        many: Dataclasses of which there are many in the results; see `pickled`.

    Returns: The results, in order.
    """
    context = process_context()
    jobs = max(1, min(jobs, count)) if context.get_start_method() == "fork" else 1
    if jobs == 1 or count > _MOST:
        return [work(number) for number in range(count)]
    waiting, fill = os.pipe()
    helpers: list[_Helper[_T]] = []
    try:
        # What is in a pipe is taken by one reader, and once all is taken and nobody can write there is an end.
        with os.fdopen(fill, "wb") as stream:
            stream.write(b"".join(number.to_bytes(_BYTES, "little") for number in range(count)))
        for _ in range(1, jobs):
            helpers.append(_Helper.start(context, work, waiting, many))
        found = _taken(work, waiting)
        for helper in helpers:
            found.update(helper.results())
    finally:
        for helper in helpers:
            helper.stop()
        os.close(waiting)
    return [found[number] if number in found else work(number) for number in range(count)]


_BYTES = 2
"""Of a number in the pipe."""
_MOST = 2048
"""Numbers at most, so that they fit into one page, which is the least that a pipe holds; there are some 30."""


def _taken(work: Callable[[int], _T], waiting: int) -> dict[int, _T]:
    """Do what is taken from a pipe with numbers until it is empty."""
    found = {}
    while data := os.read(waiting, _BYTES):
        number = int.from_bytes(data, "little")
        found[number] = work(number)
    return found


@dataclass(frozen=True, slots=True)
class _Helper(Generic[_T]):
    """A process that takes numbers."""

    process: BaseProcess
    pipe: Connection[Any, Any]

    @staticmethod
    def start(context: Any, work: Callable[[int], _T], waiting: int, many: tuple[type, ...]) -> _Helper[_T]:
        """Begin."""
        ours, theirs = context.Pipe(duplex=False)
        process = context.Process(target=_serve, args=(theirs, work, waiting, many), daemon=True)
        start_quietly(process)
        theirs.close()
        return _Helper(process, ours)

    def results(self) -> dict[int, _T]:
        """Wait for its results; none if it has died."""
        try:
            found: dict[int, _T] = pickle.loads(self.pipe.recv_bytes())
        except (EOFError, OSError):
            return {}
        return found

    def stop(self) -> None:
        """End it."""
        self.process.kill()
        self.process.join()
        self.pipe.close()


def _serve(
    pipe: Connection[Any, Any], work: Callable[[int], _T], waiting: int, many: tuple[type, ...]
) -> None:
    """A helper's life."""
    # The parent decides what an interrupt means, and ends its helpers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # What goes wrong here goes wrong in the parent again, which tells it.
    with suppress(Exception):
        pipe.send_bytes(pickled(_taken(work, waiting), *many))
