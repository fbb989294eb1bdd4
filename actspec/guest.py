"""A command in a watched process: a library that crashes, loops or takes memory ends with a sentence and exit code 2.

On Linux `watch` forks the bare process before anything is imported, which takes some milliseconds; elsewhere the
command runs where it is. What MuJoCo does with a model is `at_work`, which limits its processor time and memory.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

MOST_MEMORY = 4 << 30
"""Chosen: bytes of the process while MuJoCo is at work; the largest model known takes 0.2 GB."""

MOST_TIME = 60.0
"""Chosen: time for one model [s]; the slowest real file takes 0.1 s."""

MOST_WAIT = 300.0
"""Chosen: wall time for one model [s], for what waits and does not work."""

_PACE = 0.05
"""Chosen: seconds between two looks at the memory."""

_MOST_NAME = 4000

_TOLD = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGPIPE", "SIGUSR1", "SIGUSR2")
"""Signals that somebody sends: the watcher passes them on, or ends as they mean."""


class _Shared:
    """What the watched process tells its watcher, in memory that both have."""

    page: memoryview | None = None
    owner = 0


def watch(run: Callable[[], int], lost: Callable[[str], int]) -> int:
    """Run a command in a process of its own.

    Args:
        run: The command; returns the exit code.
        lost: Called with a sentence where the process was ended; returns the exit code.

    Returns: The exit code, in both processes.
    """
    if not (sys.platform.startswith("linux") and hasattr(os, "pidfd_open")):
        return run()
    from mmap import mmap
    from select import POLLIN, poll

    page = memoryview(mmap(-1, _MOST_NAME + 2))
    parent = os.getpid()
    # A signal that comes between the fork and the handlers waits.
    told = {getattr(signal, name) for name in _TOLD}
    before = signal.pthread_sigmask(signal.SIG_BLOCK, told)
    child = os.fork()
    if child == 0:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        _Shared.page, _Shared.owner = page, os.getpid()
        end_with_parent()
        if os.getppid() != parent:
            os._exit(1)  # it has ended before
        return run()
    for number in told - {signal.SIGINT, signal.SIGQUIT, signal.SIGPIPE}:
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, lambda number, _: os.kill(child, number))
    # A terminal sends these two to both processes: the command decides.
    for number in (signal.SIGINT, signal.SIGQUIT):
        signal.signal(number, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_SETMASK, before)
    handle = os.pidfd_open(child)
    waiting = poll()
    waiting.register(handle, POLLIN)
    reason = ""
    while not waiting.poll(_PACE * 1e3):
        if page[0] and not reason and _memory(child) > MOST_MEMORY:
            reason = f"took more than {MOST_MEMORY >> 30} GiB of memory"
            os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    if not os.WIFSIGNALED(status):
        return os.WEXITSTATUS(status)
    number = os.WTERMSIG(status)
    if number in told:
        signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)
    return lost(_sentence(page, number, reason))


@contextmanager
def at_work(model: str = "") -> Iterator[None]:
    """MuJoCo is at work on a model: in a watched process its time and memory are limited.

    Args:
        model: The file, for the sentence; "": the same as before.
    """
    page = _Shared.page
    if page is None or _Shared.owner != os.getpid() or page[0]:
        yield
        return
    if model:
        name = os.fsencode(model)[:_MOST_NAME]
        page[1 : 1 + len(name)] = name
        page[1 + len(name)] = 0
    page[0] = 1
    signal.setitimer(signal.ITIMER_PROF, MOST_TIME)
    signal.setitimer(signal.ITIMER_REAL, MOST_WAIT)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.setitimer(signal.ITIMER_REAL, 0)
        page[0] = 0


def _sentence(page: memoryview, number: int, reason: str) -> str:
    """How the process ended, and on which model."""
    name = os.fsdecode(bytes(page[1:]).split(b"\0")[0])
    who = "MuJoCo" if page[0] else "a library"
    if not reason and number == signal.SIGPROF:
        reason = f"took more than {MOST_TIME:g} s of processor time"
    elif not reason and number == signal.SIGALRM:
        reason = f"did not answer for {MOST_WAIT:g} s"
    elif not reason and number == signal.SIGKILL:
        return "the process was killed (signal 9), perhaps for its use of memory" + (name and f"; {name}")
    reason = reason or f"crashed (signal {number})"
    if name:
        return f"{who} {reason} on {name}" if page[0] else f"{who} {reason}; the last model was {name}"
    return f"{who} {reason}"


def _memory(process: int) -> int:
    """Bytes of a process in memory; 0 where it cannot be told."""
    with suppress(OSError, ValueError, IndexError), open(f"/proc/{process}/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    return 0


def end_with_parent() -> None:
    """Have the system end this process when its parent ends, however that does; on Linux."""
    with suppress(ImportError, OSError, AttributeError):
        import ctypes

        set_signal_of_parents_death = 1  # PR_SET_PDEATHSIG in <linux/prctl.h>
        ctypes.CDLL(None).prctl(set_signal_of_parents_death, signal.SIGKILL)
