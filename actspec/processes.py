"""Functions called in other processes, so that a crash, a hang or a lack of memory costs one call and no more.

`IsolatedCall` is one such process, `Pool` several of them at work on many tasks. Their processes end with this
one, however it ends: by `with`, an interrupt, or a signal that nobody can catch.
"""

from __future__ import annotations

import faulthandler
import os
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from actspec.files import note, noting
from actspec.guest import MOST_MEMORY, MOST_TIME, end_with_parent

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

TIME_LIMIT = MOST_TIME
"""Seconds for one call."""

_GRACE = 5
"""Chosen: seconds beyond the limit in which the parent has ended a process that hangs, if it still can."""

_T = TypeVar("_T")


class LostError(Exception):
    """A call has no answer: it ended its process or took too long; the text says which."""


class FaultError(LostError):
    """The function raised an exception, and would again."""


class IsolatedCall(Generic[_T]):
    """A function that is called in another process, one for all calls until a call ends it."""

    def __init__(
        self, function: Callable[..., _T], limit: float = TIME_LIMIT, library: str = "MuJoCo"
    ) -> None:
        """Nothing is started before the first call.

        Args:
            function: Of a module, so that a spawned process finds it. Its answers can be pickled.
            limit: Most time for one call [s].
            library: What the call is made for, and is at fault where it ends the process.
        """
        self._function = function
        self._limit = limit
        self._library = library
        self._until = 0.0
        self._process: BaseProcess | None = None
        self._pipe: Connection[Any, Any] | None = None

    def __enter__(self) -> IsolatedCall[_T]:
        """The same."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the process, whatever it is doing."""
        if self._process is not None and self._pipe is not None:
            self._process.kill()
            self._process.join()
            self._process.close()
            self._pipe.close()
        self._process = self._pipe = None

    def __call__(self, *arguments: object) -> _T:
        """Call the function and wait for its answer.

        Raises: LostError: there is none.
        """
        self.begin(arguments)
        return self.answer()

    def begin(self, arguments: tuple[object, ...]) -> None:
        """Call the function and do not wait."""
        pipe = self._pipe or self._start()
        self._until = time.monotonic() + self._limit
        with suppress(OSError):  # the process has died; `answer` says so
            pipe.send(arguments)

    def answer(self) -> _T:
        """Wait for the answer to the call that was begun.

        Raises:
            LostError: there is none; the next call has a new process.
            ImportError: a library that it needs cannot be imported, in this process neither.
        """
        assert self._pipe is not None and self._process is not None
        try:
            if self._pipe.poll(max(self._until - time.monotonic(), 0.0)):
                answer, fault, read = self._pipe.recv()
                note(read)
                if fault is None:
                    return answer  # type: ignore[no-any-return]
                if isinstance(fault, ImportError):
                    raise fault
                raise FaultError(fault)
            reason = f"{self._library} took longer than {self._limit:g} s for it"
        except (EOFError, OSError):
            reason = _death(self._process, self._library)
        self.__exit__()
        raise LostError(reason)

    def _start(self) -> Connection[Any, Any]:
        import multiprocessing
        import warnings

        # Elsewhere a fork is not safe; nor is one beside other threads of Python, which may hold a lock.
        forks = sys.platform.startswith("linux") and threading.active_count() == 1
        context: Any = multiprocessing.get_context("fork" if forks else "spawn")
        pipe, theirs = context.Pipe()
        process = context.Process(
            target=_serve, args=(theirs, pipe, self._function, self._limit), daemon=True
        )
        with warnings.catch_warnings():
            # Python 3.12 warns of threads that numpy's linear algebra has started, which is made for forks.
            warnings.simplefilter("ignore", DeprecationWarning)
            process.start()
        theirs.close()
        self._process, self._pipe = process, pipe
        return pipe  # type: ignore[no-any-return]


class Pool(Generic[_T]):
    """Processes that are at work on many calls of one function, from the start."""

    def __init__(
        self,
        function: Callable[..., _T],
        tasks: Sequence[tuple[object, ...]],
        jobs: int | None = None,
        limit: float = TIME_LIMIT,
    ) -> None:
        """Start them.

        Args:
            function: As of `IsolatedCall`.
            tasks: The arguments of each call; they are begun in this order.
            jobs: Processes at most; default: one a core that this process may run on.
            limit: Most time for one call [s].
        """
        self._waiting = deque(enumerate(tasks))
        self._count = len(tasks)
        number = min(len(tasks), cores() if jobs is None else max(jobs, 1))
        self._idle = [IsolatedCall(function, limit) for _ in range(number)]
        self._busy: dict[Connection[Any, Any], tuple[int, IsolatedCall[_T]]] = {}
        self._fill()

    def __enter__(self) -> Pool[_T]:
        """The same."""
        return self

    def __exit__(self, *_: object) -> None:
        """End them, whatever they are doing."""
        for call in (*self._idle, *(call for _, call in self._busy.values())):
            call.__exit__()

    def add(self, *arguments: object) -> int:
        """One more call, before those that wait; also while `results` is walked through.

        Returns: Its index.
        """
        self._waiting.appendleft((self._count, arguments))
        self._count += 1
        return self._count - 1

    def results(self) -> Iterator[tuple[int, _T | LostError]]:
        """Wait for the answers.

        Yields: Index of a task and its answer, or why it has none, as they come.
        """
        from multiprocessing.connection import wait

        while self._busy or self._waiting:
            self._fill()
            until = min(call._until for _, call in self._busy.values())
            ready = set(wait(list(self._busy), max(until - time.monotonic(), 0.0)))
            now = time.monotonic()
            done = [pipe for pipe, (_, call) in self._busy.items() if pipe in ready or call._until < now]
            for pipe in done:
                index, call = self._busy.pop(pipe)
                answer: _T | LostError
                try:
                    answer = call.answer()
                except LostError as err:
                    answer = err
                self._idle.append(call)
                self._fill()
                yield index, answer

    def _fill(self) -> None:
        while self._idle and self._waiting:
            call = self._idle.pop()
            index, arguments = self._waiting.popleft()
            call.begin(arguments)
            assert call._pipe is not None
            self._busy[call._pipe] = index, call


def cores() -> int:
    """Cores that this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _serve(
    pipe: Connection[Any, Any],
    parents: Connection[Any, Any],
    function: Callable[..., object],
    limit: float,
) -> None:
    """The life of another process."""
    # Who called says how this process ended, and needs no stack of it.
    faulthandler.disable()
    # The parent decides what an interrupt means, and ends its processes.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    alarm = _end_with_parent()
    _limit_memory()
    # One process a core is all the parallelism that there is to have, and nothing is drawn.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("MUJOCO_GL", "disable")
    # A forked process has inherited it, a spawned one a copy.
    parents.close()
    with suppress(EOFError, BrokenPipeError):
        while True:
            arguments = pipe.recv()
            alarm(int(limit) + _GRACE)
            answer: tuple[object, str | ImportError | None]
            read: set[str] = set()
            try:
                with noting() as read:
                    answer = function(*arguments), None
            except ImportError as err:
                from actspec.libraries import missing_package

                # Named here, where the stack still tells what was imported.
                answer = None, ImportError(str(err), name=missing_package(err))
            except MemoryError:
                answer = None, "there is not enough memory for it"
            except Exception as err:
                fault = f"a fault of actspec, not of the file; please report it: {type(err).__name__}: {err}"
                answer = None, fault
            alarm(0)
            pipe.send((*answer, read))


def _end_with_parent() -> Callable[[int], object]:
    """Have the system end this process when its parent is killed while this one hangs; else the closed pipe does.

    Returns: Sets the time [s] after which the system ends this process, for systems that cannot do better.
    """
    if sys.platform.startswith("linux"):
        end_with_parent()
    if not hasattr(signal, "alarm"):
        return lambda _: None
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    return signal.alarm


def _limit_memory() -> None:
    """Have the system refuse this process more memory than a file is worth; not on Windows."""
    with suppress(ImportError, OSError, ValueError):
        import resource

        _, most = resource.getrlimit(resource.RLIMIT_DATA)
        bound = MOST_MEMORY if most == resource.RLIM_INFINITY else min(MOST_MEMORY, most)
        resource.setrlimit(resource.RLIMIT_DATA, (bound, most))


def _death(process: BaseProcess, library: str) -> str:
    """How a process ended whose pipe has closed."""
    process.join(1.0)
    code = process.exitcode
    if code is None or code >= 0:
        return f"{library} ended the process that read it"
    if -code == getattr(signal, "SIGKILL", None):
        return f"the process that read it was killed (signal {-code}), perhaps for its use of memory"
    return f"{library} crashed on it (signal {-code})"
