"""The long run: executions in processes of their own, counted, with every failure by its number.

    python -m tests.fuzz --seconds 600 --seed 7                  # everything
    python -m tests.fuzz --kind parse --seed 7 --count 100000    # parsers alone
    python -m tests.fuzz --seed 7 --kind spec --number 1234      # one execution again, in full

`--kind` takes a kind, or one of parse, read, whole and mujoco, which are groups of kinds. Exit code 1: something
failed. A process that MuJoCo ends is one failure and no more; the audit has a process between, where this has a
stand-in.
"""

from __future__ import annotations

import argparse
import gc
import mmap
import multiprocessing
import os
import re
import resource
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path

from tests.fuzz import parsers
from tests.fuzz.scenes import GROUPS, KINDS, make
from tests.fuzz.trial import limited, prepare, readers, renew, run

MEMORY = 2**30
"""Most memory that an execution may take beside what the process has [bytes]."""

_BATCH = 5000
"""Executions of one process: a leak is not taken for a large file."""

_HANGS = 120.0
"""Seconds without a word after which a process hangs in code that is not Python."""

_Execute = Callable[[str, int], tuple[int | None, tuple[str, ...]]]
"""Kind and number to exit code and failures."""


def main() -> int:
    """Run what the command line asks for."""
    groups: dict[str, list[str]] = {"parse": list(parsers.PARSERS)} | {
        name: list(kinds) for name, kinds in GROUPS.items()
    }
    every = [*parsers.PARSERS, *KINDS]
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz")
    parser.add_argument(
        "--kind", action="append", choices=[*groups, *every], help="may be repeated; default: all"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=60.0, help="wall time")
    parser.add_argument("--count", type=int, help="executions, in place of a time")
    parser.add_argument("--start", type=int, default=0, help="the first number")
    parser.add_argument("--number", type=int, help="only this execution, and show it")
    arguments = parser.parse_args()
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ["LANGUAGE"] = "C"  # else argparse looks for translations of every word
    kinds = [kind for name in arguments.kind or groups for kind in groups.get(name, [name])]
    memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
    with tempfile.TemporaryDirectory(dir=memory) as parent:
        sound, folder, scratch = (Path(parent, name) for name in ("sound", "work", "scratch"))
        for made in (sound, folder, scratch):
            made.mkdir()
        tempfile.tempdir = str(scratch)
        os.chdir(sound)
        with open(os.devnull, "w") as nowhere:
            out, err, sys.stdout, sys.stderr = sys.stdout, sys.stderr, nowhere, nowhere
            try:
                make(sound)
            finally:
                sys.stdout, sys.stderr = out, err
        os.chdir(folder)
        prepare(sound)
        renew(sound, folder)
        texts = parsers.seeds(sound) if any(kind in parsers.PARSERS for kind in kinds) else {}
        if texts:
            parsers.prepare(Path(parent, "parse"))
        if arguments.number is not None:
            with readers():
                return _show(kinds[0], arguments.seed, arguments.number, texts, sound, folder)
        return _count(kinds, arguments, partial(_execute, arguments.seed, texts, sound, folder))


def _execute(
    seed: int, texts: dict[str, tuple[str, ...]], sound: Path, folder: Path, kind: str, number: int
) -> tuple[int | None, tuple[str, ...]]:
    if kind not in texts:
        os.chdir(folder)
        trial = run(kind, seed, number, sound, folder)
        return trial.code, trial.failures
    os.chdir(folder.parent / "parse")
    return parsers.run(kind, parsers.changed(kind, seed, number, texts[kind]))


def _show(
    kind: str, seed: int, number: int, texts: dict[str, tuple[str, ...]], sound: Path, folder: Path
) -> int:
    if kind in texts:
        data = parsers.changed(kind, seed, number, texts[kind])
        print(f"--- {kind}\n{data.decode('utf-8', 'backslashreplace')[:20000]}")
        with limited():
            code, failures = _execute(seed, texts, sound, folder, kind, number)
        print(f"--- code {code}")
    else:
        trial = run(kind, seed, number, sound, folder)
        failures = trial.failures
        print(f"actspec {trial.line}\n--- {trial.path}")
        print(trial.data.decode("utf-8", "backslashreplace")[:20000])
        print(f"--- exit code {trial.code}\n{trial.out[:5000]}{trial.err[:5000]}")
    print("\n".join(f"--- failed: {failure}" for failure in failures))
    return bool(failures)


class _Page:
    """Figures that a process leaves where its parent sees them, however it ends.

    Attributes:
        CODES: Exit codes that are counted, by their place.
    """

    CODES = (0, 1, 2, None)

    def __init__(self) -> None:
        self._page = memoryview(mmap.mmap(-1, 64)).cast("q")

    @property
    def begun(self) -> int:
        """The number that is being executed, or was last."""
        return self._page[0]

    @begun.setter
    def begun(self, number: int) -> None:
        self._page[0] = number

    def end(self, code: int | None) -> None:
        """One execution has ended."""
        self._page[1 + (self.CODES.index(code) if code in self.CODES else 3)] += 1

    def codes(self) -> dict[int | None, int]:
        """Executions by their code."""
        return dict(zip(self.CODES, self._page[1:5], strict=True))


def _count(kinds: list[str], arguments: argparse.Namespace, execute: _Execute) -> int:
    began = time.monotonic()
    until = began + (arguments.seconds if arguments.count is None else float("inf"))
    number, last = arguments.start, arguments.start + (arguments.count or sys.maxsize)
    failed: Counter[tuple[str, str]] = Counter()
    page, spent = _Page(), 0.0
    # Without it each process would look for garbage among what all of them have.
    gc.collect()
    gc.freeze()
    while number < last and time.monotonic() < until:
        ours, theirs = multiprocessing.get_context("fork").Pipe(duplex=False)
        page.begun = number
        work = (theirs, page, kinds, execute, range(number, min(number + _BATCH, last)), until)
        process = multiprocessing.get_context("fork").Process(target=_serve, args=work)
        process.start()
        theirs.close()
        ended, before, seen = False, -1, time.monotonic()
        with ours:
            while True:
                try:
                    if ours.poll(1.0):
                        word = ours.recv()
                        if word is None:
                            ended = True
                        else:
                            _tell(failed, *word)
                except EOFError:
                    break
                if page.begun != before:
                    before, seen = page.begun, time.monotonic()
                elif time.monotonic() - seen > _HANGS:
                    process.kill()
        process.join()
        if not ended:
            kind = kinds[page.begun % len(kinds)]
            if not (kind in parsers.PARSERS and parsers.PARSERS[kind].guest):
                _tell(failed, kind, page.begun, f"the process ended: {process.exitcode}")
            page.end(None)
        number = page.begun + 1
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = used.ru_utime + used.ru_stime
    executions = Counter(kinds[n % len(kinds)] for n in range(arguments.start, number))
    print("\n| kind | executions | failures |\n|---|---:|---:|")
    for kind in kinds:
        print(f"| {kind} | {executions[kind]} | {sum(n for (k, _), n in failed.items() if k == kind)} |")
    print(f"| all | {executions.total()} | {sum(failed.values())} |")
    print(f"exit codes: {', '.join(f'{code}: {count}' for code, count in page.codes().items())}")
    print(f"{time.monotonic() - began:.0f} s, {spent:.0f} s of a processor")
    return bool(failed)


def _tell(failed: Counter[tuple[str, str]], kind: str, number: int, failure: str) -> None:
    """The first of each sort at once."""
    sort = kind, re.sub(r"'.*?'|\d+", "_", failure)[:90]
    if sort not in failed:
        print(f"--kind {kind} --number {number}: {ascii(failure)[:300]}", flush=True)
    failed[sort] += 1


def _serve(
    pipe: Connection, page: _Page, kinds: list[str], execute: _Execute, numbers: range, until: float
) -> None:
    """The life of another process: executions one after the other."""
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, resource.RLIM_INFINITY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # what MuJoCo writes there itself
    with readers(), limited():
        for number in numbers:
            page.begun = number
            kind = kinds[number % len(kinds)]
            code, failures = execute(kind, number)
            page.end(code)
            for failure in failures:
                pipe.send((kind, number, failure))
            if time.monotonic() > until:
                break
    pipe.send(None)


if __name__ == "__main__":
    sys.exit(main())
