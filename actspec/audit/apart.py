"""A function in a process of its own, so that what ends the process ends nothing else."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from actspec.audit.workers import TIME_LIMIT, death, process_context

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

_T = TypeVar("_T")


class LostError(Exception):
    """The process ended, or was ended, before it had an answer; the text says how."""


class Apart(Generic[_T]):
    """A function that is called in another process, one for all calls until a call ends it."""

    def __init__(self, function: Callable[..., _T], limit: float = TIME_LIMIT) -> None:
        """Begin with the first call.

        Args:
            function: Of a module, so that a spawned process finds it.
            limit: Most time for one call [s].
        """
        self._function = function
        self._limit = limit
        self._process: BaseProcess | None = None
        self._pipe: Connection[Any, Any] | None = None

    def __enter__(self) -> Apart[_T]:
        """The same."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the process."""
        self._stop()

    def __call__(self, *arguments: object) -> _T:
        """Call the function.

        Raises: LostError: the call ended the process, took too long, or raised an exception.
        """
        if self._pipe is None:
            self._start()
        assert self._pipe is not None and self._process is not None
        try:
            self._pipe.send(arguments)
            if self._pipe.poll(self._limit):
                answer, fault = self._pipe.recv()
                if fault is None:
                    return answer  # type: ignore[no-any-return]
                raise LostError(fault)
            reason = f"MuJoCo took longer than {self._limit:g} s for it"
        except (EOFError, OSError):
            reason = death(self._process)
        self._stop()
        raise LostError(reason)

    def _start(self) -> None:
        context = process_context()
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, self._pipe, self._function), daemon=True)
        self._process.start()
        theirs.close()

    def _stop(self) -> None:
        if self._process is not None and self._pipe is not None:
            self._process.kill()
            self._process.join()
            self._pipe.close()
        self._process = self._pipe = None


def _serve(
    pipe: Connection[Any, Any], parents: Connection[Any, Any], function: Callable[..., object]
) -> None:
    # The parent decides what an interrupt means, and ends its process.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.environ.setdefault("MUJOCO_GL", "disable")
    # A forked process has inherited it, a spawned one a copy.
    parents.close()
    with suppress(EOFError):
        while True:
            arguments = pipe.recv()
            answer: tuple[object, str | None]
            try:
                answer = function(*arguments), None
            except MemoryError:
                answer = None, "there is not enough memory for it"
            except Exception as err:
                answer = None, f"a fault of actspec; please report it: {type(err).__name__}: {err}"
            pipe.send(answer)
