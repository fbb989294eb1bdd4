"""Workers forked from a process that has imported MuJoCo for all of them.

The import goes on beside what the caller has to import itself, and is done once for all workers. What they read
goes straight to the caller; the process between only says who reads what, and what becomes of those that die.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any, cast

from actspec.audit.workers import (
    TIME_LIMIT,
    Read,
    Task,
    Workers,
    be_a_reader,
    message,
    process_context,
    received,
    start_quietly,
    workers_for,
)
from actspec.readings.artifact import FileReading

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

_LOOK = 1.0
"""Chosen: seconds without a result after which it is looked whether the process is still there."""


class PreparedWorkers:
    """As `Workers`, which are those of another process; where forks are safe."""

    def __init__(
        self,
        tasks: Sequence[Task],
        jobs: int | None,
        read: Read,
        prepare: Callable[[], None],
        limit: float = TIME_LIMIT,
    ) -> None:
        """Start the process.

        Args:
            tasks: As of `Workers`, and so are the others.
            jobs: Likewise.
            read: Likewise.
            prepare: What is done before the workers are forked; it does not fail.
            limit: Likewise.
        """
        self._tasks = tuple(tasks)
        self._read = read
        self._jobs = jobs
        self._limit = limit
        context = process_context()
        # One from each worker; the first is the process's own, for what its workers did not send.
        ends = [context.Pipe(duplex=False) for _ in range(1 + workers_for(tasks, jobs))]
        self._pipes: list[Connection[Any, Any]] = [ours for ours, _ in ends]
        theirs = [their for _, their in ends]
        arguments = (theirs, self._pipes, self._tasks, jobs, read, prepare, limit)
        # It has children of its own, which a daemon may not have.
        self._process = context.Process(target=_serve, args=arguments)
        start_quietly(self._process)
        # Here and there, whoever comes first: it and its workers are ended together, as a group.
        with suppress(OSError):
            os.setpgid(self._process.pid, self._process.pid)
        self._complete = False
        for pipe in theirs:
            pipe.close()

    def __enter__(self) -> PreparedWorkers:
        """The same."""
        return self

    def __exit__(self, *_: object) -> None:
        """End it and its workers, whatever they are doing."""
        # Who has read everything ends by itself, and the times of its workers are counted as ours.
        self._process.join(_LOOK if self._complete else 0.0)
        if not self._complete or self._process.exitcode is None:
            with suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)
        self._process.join()
        for pipe in self._pipes:
            pipe.close()

    def results(self) -> Iterator[tuple[int, FileReading]]:
        """As of `Workers`; what is not read when the process dies is read by workers of this one."""
        from selectors import EVENT_READ, DefaultSelector

        left = {task.index: task for task in self._tasks}
        # `multiprocessing.connection.wait` makes a selector anew for each of hundreds of readings.
        with DefaultSelector() as selector:
            for pipe in self._pipes:
                selector.register(pipe, EVENT_READ)
            while left and selector.get_map():
                ready = selector.select(_LOOK)
                # Its pipes may be held open by a worker that is never done.
                if not ready and not self._process.is_alive():
                    break
                for key, _ in ready:
                    pipe = cast("Connection[Any, Any]", key.fileobj)
                    try:
                        index, reading = received(pipe.recv_bytes())
                    except (EOFError, OSError):
                        selector.unregister(pipe)
                        continue
                    # A worker that dies before it has said that it is done has its file read again.
                    if left.pop(index, None) is not None:
                        yield index, reading
        self._complete = not left
        if left:
            with Workers(tuple(left.values()), self._jobs, self._read, self._limit) as workers:
                yield from workers.results()


def _serve(
    pipes: Sequence[Connection[Any, Any]],
    parents: Sequence[Connection[Any, Any]],
    tasks: Sequence[Task],
    jobs: int | None,
    read: Read,
    prepare: Callable[[], None],
    limit: float,
) -> None:
    """The process's life."""
    be_a_reader()
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    os.setpgid(0, 0)
    for parent in parents:
        parent.close()
    prepare()
    own, *outlets = pipes
    with suppress(BrokenPipeError), Workers(tasks, jobs, read, limit, outlets) as workers:
        for index, data in workers.packed():
            if data:
                own.send_bytes(message(index, data))
