"""Workers forked from a process that has imported MuJoCo for all of them.

The import goes on beside what the caller has to import itself, and is done once for all workers.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from actspec.audit.artifact import FileReading
from actspec.audit.workers import TIME_LIMIT, Read, Task, Workers, process_context, start_quietly

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

_INDEX_BYTES = 4


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
        self._pipe, theirs = context.Pipe(duplex=False)
        arguments = (theirs, self._pipe, self._tasks, jobs, read, prepare, limit)
        # It has children of its own, which a daemon may not have.
        self._process = context.Process(target=_serve, args=arguments)
        start_quietly(self._process)
        theirs.close()

    def __enter__(self) -> PreparedWorkers:
        """The same."""
        return self

    def __exit__(self, *_: object) -> None:
        """End it and its workers, whatever they are doing."""
        self.end()
        self._process.join()
        self._pipe.close()

    def end(self) -> None:
        """As of `Workers`."""
        self._process.terminate()

    def results(self) -> Iterator[tuple[int, FileReading]]:
        """As of `Workers`; what the process has not read when it dies is read by workers of this one."""
        left = {task.index: task for task in self._tasks}
        try:
            while left:
                data = self._pipe.recv_bytes()
                index = int.from_bytes(data[:_INDEX_BYTES], "little")
                del left[index]
                yield index, pickle.loads(memoryview(data)[_INDEX_BYTES:])
        except (EOFError, OSError):
            with Workers(tuple(left.values()), self._jobs, self._read, self._limit) as workers:
                yield from workers.results()


def _serve(
    pipe: Connection[Any, Any],
    parents: Connection[Any, Any],
    tasks: Sequence[Task],
    jobs: int | None,
    read: Read,
    prepare: Callable[[], None],
    limit: float,
) -> None:
    """The process's life."""
    # The caller decides what an interrupt means, and ends this process, which then ends its workers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    parents.close()
    # One process a core is all the parallelism that there is to have; nothing is drawn.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("MUJOCO_GL", "disable")
    prepare()
    with Workers(tasks, jobs, read, limit) as workers:
        for index, data in workers.packed():
            try:
                pipe.send_bytes(index.to_bytes(_INDEX_BYTES, "little") + data)
            except BrokenPipeError:
                return
