"""The long run: executions in processes of their own, counted, with every failure by its number.

    python -m tests.fuzz --seconds 600 --seed 7                  # everything
    python -m tests.fuzz --seconds 600 --seed 7 --kind spec
    python -m tests.fuzz --seed 7 --kind spec --number 1234      # one execution again, in full

`--kind` takes a kind, or one of read, whole and mujoco, which are groups of kinds. Exit code 1: something failed.
A process that MuJoCo ends is one failure and no more; the audit has a process between, where this has a stand-in.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import re
import resource
import sys
import tempfile
import time
from collections import Counter
from multiprocessing.connection import Connection
from pathlib import Path

from tests.fuzz.scenes import GROUPS, KINDS, make
from tests.fuzz.trial import Trial, readers, renew, run

MEMORY = 2**30
"""Most memory that an execution may take beside what the process has [bytes]."""

_BATCH = 500
"""Executions of one process: a leak is not taken for a large file."""

_HANGS = 120.0
"""Seconds without a word after which a process hangs in code that is not Python."""


def main() -> int:
    """Run what the command line asks for."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz")
    parser.add_argument(
        "--kind", action="append", choices=[*GROUPS, *KINDS], help="may be repeated; default: all"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=60.0, help="wall time")
    parser.add_argument("--start", type=int, default=0, help="the first number")
    parser.add_argument("--number", type=int, help="only this execution, and show it")
    arguments = parser.parse_args()
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    kinds = [kind for name in arguments.kind or GROUPS for kind in GROUPS.get(name, (name,))]
    with tempfile.TemporaryDirectory() as parent:
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
        renew(sound, folder)
        if arguments.number is not None:
            with readers():
                return _show(run(kinds[0], arguments.seed, arguments.number, sound, folder))
        return _count(kinds, arguments, sound, folder)


def _show(trial: Trial) -> int:
    print(f"actspec {trial.line}\n--- {trial.path}\n{trial.data.decode('utf-8', 'backslashreplace')[:20000]}")
    print(f"--- exit code {trial.code}\n{trial.out[:5000]}{trial.err[:5000]}")
    print("\n".join(f"--- failed: {failure}" for failure in trial.failures))
    return bool(trial.failures)


def _count(kinds: list[str], arguments: argparse.Namespace, sound: Path, folder: Path) -> int:
    until = time.monotonic() + arguments.seconds
    executions: Counter[str] = Counter()
    codes: Counter[int | None] = Counter()
    failed: Counter[tuple[str, str]] = Counter()
    number = arguments.start
    while time.monotonic() < until:
        ours, theirs = multiprocessing.get_context("fork").Pipe(duplex=False)
        work = (theirs, kinds, arguments.seed, number, sound, folder, until)
        process = multiprocessing.get_context("fork").Process(target=_serve, args=work)
        process.start()
        theirs.close()
        begun: tuple[str, int] | None = None
        while True:
            try:
                if not ours.poll(_HANGS):
                    process.kill()
                    raise EOFError
                word = ours.recv()
            except EOFError:
                break
            if len(word) == 2:
                begun = word
                continue
            code, failures = word[2:]
            begun = None
            executions[word[0]] += 1
            codes[code] += 1
            for failure in failures:
                _tell(failed, word[0], word[1], failure)
            number = max(number, word[1])
        process.join()
        if begun is not None:
            executions[begun[0]] += 1
            _tell(failed, *begun, f"the process ended: {process.exitcode}")
            renew(sound, folder)
        number = (begun[1] if begun else number) + 1
    print("\n| kind | executions | failures |\n|---|---:|---:|")
    for kind in kinds:
        print(f"| {kind} | {executions[kind]} | {sum(n for (k, _), n in failed.items() if k == kind)} |")
    print(f"| all | {sum(executions.values())} | {sum(failed.values())} |")
    print(f"exit codes: {', '.join(f'{code}: {count}' for code, count in codes.most_common())}")
    return bool(failed)


def _tell(failed: Counter[tuple[str, str]], kind: str, number: int, failure: str) -> None:
    """The first of each sort at once."""
    sort = kind, re.sub(r"'.*?'|\d+", "_", failure)[:90]
    if sort not in failed:
        print(f"--kind {kind} --number {number}: {ascii(failure)[:300]}", flush=True)
    failed[sort] += 1


def _serve(
    pipe: Connection, kinds: list[str], seed: int, number: int, sound: Path, folder: Path, until: float
) -> None:
    """The life of another process: executions one after the other."""
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, resource.RLIM_INFINITY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # what MuJoCo writes there itself
    with readers():
        for step in range(number, number + _BATCH):
            if time.monotonic() > until:
                return
            kind = kinds[step % len(kinds)]
            pipe.send((kind, step))
            trial = run(kind, seed, step, sound, folder)
            pipe.send((kind, step, trial.code, trial.failures))


if __name__ == "__main__":
    sys.exit(main())
