"""Files read in other processes, one a core, so that a crash of MuJoCo loses one file only.

A process gets two files ahead at most and answers in their order, so the one that it was on when it
died is known.
"""

from __future__ import annotations

import copyreg
import gc
import io
import os
import pickle
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields
from functools import lru_cache
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Diagnostic, Severity, Span
from actspec.readings.artifact import FileReading

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

TIME_LIMIT = 60.0
"""Chosen: seconds for one file; the slowest real one takes 0.1 s."""

FAULT = "AUD008"
"""Code of a file that was lost to a fault, and not for what is in it."""

_AHEAD = 2
"""Files that a process holds: the one that it is on and the next, so that it never waits for the parent."""


@dataclass(frozen=True, slots=True)
class Task:
    """One file to read.

    Attributes:
        index: Its place among the results.
        path: As the user named it.
        keep_matrices: As in `readers.robot.read_robot`.
        refusal: Likewise; set when a process died on the file.
    """

    index: int
    path: str
    keep_matrices: bool
    refusal: str | None = None


Read = Callable[[Task], FileReading]
"""What a worker does with a task; a function of a module, so that a spawned process finds it."""


class Workers:
    """Processes that read files, at work from the start.

    A file on which a process dies, or that takes too long, is read once more, with the reason in `refusal`.
    """

    def __init__(
        self,
        tasks: Sequence[Task],
        jobs: int | None,
        read: Read,
        limit: float = TIME_LIMIT,
        outlets: Sequence[Connection[Any, Any]] = (),
    ) -> None:
        """Start them.

        Args:
            tasks: The files; they are begun in this order.
            jobs: Processes at most; default: one a core that this process may run on.
            read: What is done with each.
            limit: Most time for one file [s].
            outlets: Where the first workers, one each, send what they read in place of here: `message`s; then closed.
        """
        self._waiting = deque(tasks)
        self._read = read
        self._limit = limit
        self._workers: list[_Worker] = []
        for number in range(workers_for(tasks, jobs)):
            outlet = outlets[number] if number < len(outlets) else None
            self._workers.append(_start(read, self._workers, outlet, outlets[number + 1 :]))
            if outlet is not None:
                outlet.close()
            self._fill()

    def __enter__(self) -> Workers:
        """The same."""
        return self

    def __exit__(self, *_: object) -> None:
        """End them, whatever they are doing."""
        for worker in self._workers:
            worker.stop()
        self._workers.clear()

    def results(self) -> Iterator[tuple[int, FileReading]]:
        """Wait for what they read.

        Yields: Index and reading, as they are done.
        """
        for index, data in self.packed():
            yield index, pickle.loads(data)

    def packed(self) -> Iterator[tuple[int, bytes]]:
        """As `results`, with readings that are still pickled; b"": it has gone through an outlet."""
        if not self._workers:
            return
        from multiprocessing.connection import wait

        while self._waiting or any(worker.tasks for worker in self._workers):
            self._fill()
            busy = [worker for worker in self._workers if worker.tasks]
            timeout = max(min(worker.since for worker in busy) + self._limit - time.monotonic(), 0.0)
            ready = set(wait([worker.pipe for worker in busy], timeout))
            for worker in busy:
                if worker.pipe in ready:
                    done = worker.answer()
                    if done is not None:
                        yield done
                        continue
                    fault = death(worker.process)
                elif time.monotonic() - worker.since > self._limit:
                    fault = f"MuJoCo took longer than {self._limit:g} s for it"
                else:
                    continue
                lost = self._stop(worker)
                if lost.refusal is None:
                    self._waiting.appendleft(Task(lost.index, lost.path, lost.keep_matrices, fault))
                else:
                    yield lost.index, pickled(_lost(lost.path, lost.refusal))
                if self._waiting:
                    self._workers.append(_start(self._read, self._workers))
        # Not waited for: what they hold is freed while the caller goes on.
        for worker in self._workers:
            worker.process.kill()

    def _fill(self) -> None:
        for worker in self._workers:
            worker.fill(self._waiting, len(self._workers))

    def _stop(self, worker: _Worker) -> Task:
        """End a worker.

        Returns: The task that it was on; the others that it had wait again.
        """
        worker.stop()
        self._workers.remove(worker)
        lost = worker.tasks.popleft()
        self._waiting.extendleft(reversed(worker.tasks))
        return lost


def workers_for(tasks: Sequence[Task], jobs: int | None) -> int:
    """How many workers there are for some tasks, as in `Workers`."""
    return min(len(tasks), max(jobs, 1) if jobs is not None else cores())


def cores() -> int:
    """Cores that this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@dataclass(slots=True, eq=False)
class _Worker:
    """A process with the files that it has been given."""

    process: BaseProcess
    pipe: Connection[Any, Any]
    since: float
    tasks: deque[Task] = field(default_factory=deque)

    def fill(self, waiting: deque[Task], workers: int) -> None:
        """Give it files; towards the end only one, so that no other worker runs dry."""
        while waiting and len(self.tasks) < (_AHEAD if len(waiting) > workers else 1):
            if not self.tasks:
                self.since = time.monotonic()
            self.tasks.append(waiting.popleft())
            with suppress(OSError):  # it has died; `answer` will tell
                self.pipe.send(self.tasks[-1])

    def answer(self) -> tuple[int, bytes] | None:
        """What it has read, pickled; None: it is dead."""
        try:
            data: bytes = self.pipe.recv_bytes()
        except (EOFError, OSError):
            return None
        self.since = time.monotonic()
        return self.tasks.popleft().index, data

    def stop(self) -> None:
        """End it."""
        self.process.kill()
        self.process.join()
        self.pipe.close()


def _start(
    read: Read,
    others: Sequence[_Worker],
    outlet: Connection[Any, Any] | None = None,
    outlets: Sequence[Connection[Any, Any]] = (),
) -> _Worker:
    """A new process. Where it is forked it inherits the pipes and outlets of the others, and closes them.

    Whoever holds an outlet of another open keeps it from ending with its worker.
    """
    context = process_context()
    ours, theirs = context.Pipe()
    forked = context.get_start_method() == "fork"
    inherited = [*(worker.pipe for worker in others), ours, *outlets] if forked else []
    process = context.Process(target=_serve, args=(theirs, inherited, read, outlet), daemon=True)
    start_quietly(process)
    theirs.close()
    return _Worker(process, ours, time.monotonic())


def start_quietly(process: BaseProcess) -> None:
    """Start a process."""
    import warnings

    with warnings.catch_warnings():
        # Python 3.12 warns of threads that numpy's linear algebra has started, which is made for forks.
        warnings.simplefilter("ignore", DeprecationWarning)
        process.start()


def process_context() -> Any:
    """How processes are started: forked where that is safe, which is quicker."""
    import multiprocessing

    # Elsewhere a fork is not safe; nor is one beside other threads of Python, which may hold a lock.
    forks = sys.platform.startswith("linux") and threading.active_count() == 1
    return multiprocessing.get_context("fork" if forks else "spawn")


def be_a_reader() -> None:
    """What holds for every process that reads, or forks those that do."""
    # The parent decides what an interrupt means, and ends its processes.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # One process a core is all the parallelism that there is to have; numpy is not loaded yet. Nothing is drawn.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("MUJOCO_GL", "disable")


def _serve(
    pipe: Connection[Any, Any],
    inherited: Sequence[Connection[Any, Any]],
    read: Read,
    outlet: Connection[Any, Any] | None,
) -> None:
    """A worker's life."""
    be_a_reader()
    # What a file leaves behind is freed by reference counting; a cycle now and then does not hurt.
    gc.set_threshold(200_000)
    for other in inherited:
        other.close()
    while True:
        try:
            task: Task = pipe.recv()
        except EOFError:
            return
        try:
            reading = read(task)
        except MemoryError:
            reading = _lost(task.path, "there is not enough memory to read it")
        except Exception as err:
            reason = f"a fault of actspec, not of the file; please report it: {type(err).__name__}: {err}"
            reading = _lost(task.path, reason)
        data = pickled(reading)
        if outlet is not None:
            try:
                outlet.send_bytes(message(task.index, data))
            except BrokenPipeError:
                return
            data = b""
        pipe.send_bytes(data)


_INDEX_BYTES = 4


def message(index: int, data: bytes) -> bytes:
    """A pickled reading with its place among the results."""
    return index.to_bytes(_INDEX_BYTES, "little") + data


def received(data: bytes) -> tuple[int, FileReading]:
    """What a `message` says."""
    return int.from_bytes(data[:_INDEX_BYTES], "little"), pickle.loads(memoryview(data)[_INDEX_BYTES:])


def pickled(item: object, *many: type) -> bytes:
    """Something for the parent, in a third of the time that dataclasses with slots take by themselves.

    Args:
        item: With nothing in it that cannot be pickled.
        many: Dataclasses beside those of a reading of which there are many in it.
    """
    buffer = io.BytesIO()
    pickler = pickle.Pickler(buffer, pickle.HIGHEST_PROTOCOL)
    pickler.dispatch_table = {**copyreg.dispatch_table, **_by_fields(many)}
    pickler.dump(item)
    return buffer.getvalue()


@lru_cache(maxsize=8)
def _by_fields(many: tuple[type, ...]) -> dict[type, Callable[[Any], tuple[type, tuple[Any, ...]]]]:
    """Classes of which there are many, with a function that takes one apart for its constructor."""
    from actspec.diagnostics import Diagnostic, Span
    from actspec.joints import InertiaRange
    from actspec.readings.artifact import Artifact
    from actspec.robot.view import ActuatorView, JointInertia, JointView, ModelFile, RobotView

    of_readings = (
        ActuatorView, Artifact, Diagnostic, FileReading, InertiaRange, JointInertia, JointView, ModelFile,
        RobotView, Span,
    )  # fmt: skip
    return {
        cls: _taking_apart(cls, attrgetter(*(one.name for one in fields(cls))))
        for cls in (*of_readings, *many)
    }


def _taking_apart(cls: type, values: Any) -> Callable[[Any], tuple[type, tuple[Any, ...]]]:
    return lambda item: (cls, values(item))


def _lost(path: str, reason: str) -> FileReading:
    """A file that would perhaps have been read, but for a fault; that is told wherever the file was found."""
    fault = Diagnostic(FAULT, Severity.ERROR, f"the file cannot be read: {reason}", "", Span(path))
    return FileReading(path, None, reason, diagnostics=(fault,))


def death(process: BaseProcess) -> str:
    """How a process ended whose pipe has closed."""
    process.join(1.0)
    code = process.exitcode
    if code is None or code >= 0:
        return "MuJoCo ended the process that read it"
    if -code == getattr(signal, "SIGKILL", None):
        return f"the process that read it was killed (signal {-code}), perhaps for its use of memory"
    return f"MuJoCo crashed on it (signal {-code})"
