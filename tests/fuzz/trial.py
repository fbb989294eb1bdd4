"""One execution: a changed file, a command that reads it, and what of that counts as a failure."""

from __future__ import annotations

import ast
import io
import json
import os
import random
import re
import shutil
import signal
import sys
import tempfile
import unicodedata
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from types import FrameType

from lxml import etree

from actspec.cli import main as command
from actspec.cli.main import main
from actspec.robot.usda import read_usda
from actspec.verify import readback
from tests.fuzz.mutation import MARKER, mutated
from tests.fuzz.scenes import KINDS, ROOT
from tests.in_process import in_process

TIME = 10.0
"""Most processor time of one execution [s]."""

_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
_CHANGES = frozenset(
    ("rename", "remove", "mkdir", "rmdir", "link", "symlink", "chmod", "chown", "truncate", "utime")
)
# A fork is no program: actspec's own readers of models are forks.
_STARTS = (
    "subprocess.",
    "os.system",
    "os.exec",
    "os.posix_spawn",
    "os.startfile",
    "urllib.",
    "ftplib.",
    "http.",
)
_NETWORK = ("connect", "bind", "sendto", "sendmsg", "getaddrinfo", "gethostbyname")
_LIBRARY_WARNS = re.compile(r"^\S+:\d+: \w*Warning: ", re.MULTILINE)


class TooLong(BaseException):
    """The time is over; nothing that catches exceptions catches it."""


@dataclass(slots=True)
class Watch:
    """What a run does beside computing, as Python's audit events tell it.

    Attributes:
        folder: Where it may write, beside `scratch`; None: nobody looks.
        scratch: Where temporary folders are made, which must be gone at the end; "": nowhere.
        written: What it wrote there.
        forbidden: What it did elsewhere, started or connected to.
    """

    folder: str | None = None
    scratch: str = ""
    written: list[str] = field(default_factory=list)
    forbidden: list[str] = field(default_factory=list)

    def __call__(self, event: str, arguments: tuple[object, ...]) -> None:
        """Take note of an event, as `sys.addaudithook` calls it."""
        if self.folder is None:
            return
        if event == "open":
            path, mode, flags = arguments
            writes = any(letter in mode for letter in "wax+") if isinstance(mode, str) else _sets(flags)
            if writes and not isinstance(path, int):
                self._place(event, path)
        elif event.startswith("os.") and event[3:] in _CHANGES:
            for path in arguments[: 2 if event in ("os.rename", "os.link") else 1]:
                self._place(event, path)
        elif event.startswith(_STARTS) or event.removeprefix("socket.") in _NETWORK:
            self.forbidden.append(f"{event} {arguments!r:.200}")

    def _place(self, event: str, path: object) -> None:
        if not isinstance(path, str | bytes | os.PathLike):
            return
        place = os.path.realpath(os.fsdecode(path))
        if place == self.folder or place.startswith(f"{self.folder}{os.sep}"):
            self.written.append(place)
        elif place != os.devnull and not (self.scratch and place.startswith(f"{self.scratch}{os.sep}")):
            self.forbidden.append(f"{event} {place}")


def _sets(flags: object) -> bool:
    return isinstance(flags, int) and bool(flags & _WRITES)


@lru_cache(maxsize=1)
def watch() -> Watch:
    """The one of this process: a hook stays until its end."""
    found = Watch()
    sys.addaudithook(found)
    return found


@dataclass(frozen=True, slots=True)
class Trial:
    """An execution.

    Attributes:
        line: The command line.
        path: The changed file.
        data: What it holds.
        code: Exit code; None: an exception came out.
        failures: What counts as one, "" none.
    """

    line: str
    path: str
    data: bytes
    code: int | None
    out: str
    err: str
    failures: tuple[str, ...]


def run(kind: str, seed: int, number: int, sound: Path, folder: Path) -> Trial:
    """Execute.

    Args:
        kind: One of `KINDS`.
        seed, number: Decide file, changes and command.
        sound: A folder that `tests.fuzz.scenes.make` filled.
        folder: Its copy, the working folder; put right again afterwards.
    """
    choice = random.Random(f"{seed}/{kind}/{number}")
    chosen = KINDS[kind]
    path, donor = choice.choice(chosen.paths), choice.choice(chosen.paths)
    line = choice.choice(chosen.runs).replace("@", path)
    data = mutated(_text(sound / path), _text(sound / donor), chosen.format, choice)
    (folder / path).write_bytes(data)
    watching = watch()
    watching.written, watching.forbidden, watching.scratch = [], [], os.path.realpath(tempfile.gettempdir())
    scratch = set(os.listdir(watching.scratch))
    out, err, failures = io.StringIO(), io.StringIO(), []
    code: int | None = None
    try:
        with redirect_stdout(out), redirect_stderr(err), limited():
            watching.folder = os.path.realpath(folder)
            code = main(line.split())
    except SystemExit as stop:
        code = stop.code if isinstance(stop.code, int) else None
    except TooLong:
        failures.append(f"more than {TIME:g} s of processor time")
    except BaseException as fault:
        failures.append(f"{type(fault).__name__} came out: {fault!s:.200}")
    finally:
        watching.folder = None
    if not failures:
        failures += _told(line, code, out.getvalue(), err.getvalue())
    failures += watching.forbidden
    written = sorted({place for place in watching.written if os.path.isfile(place)})
    if code in (0, 1):
        failures += [fault for place in written if (fault := _wrong(Path(place), sound, folder, path))]
    if left := set(os.listdir(watching.scratch)) - scratch:
        failures.append(f"left among temporary files: {sorted(left)}")
    if (folder / "MUJOCO_LOG.TXT").exists():
        failures.append("MUJOCO_LOG.TXT in the working folder")
        (folder / "MUJOCO_LOG.TXT").unlink()
    for place in {*watching.written, os.path.join(os.path.realpath(folder), path)}:
        _put_right(place, sound, folder)
    return Trial(line, path, data, code, out.getvalue(), err.getvalue(), tuple(failures))


@contextmanager
def readers() -> Iterator[None]:
    """Files are read in this process, but for USD, whose library ends it over many of them."""
    with in_process():
        readback.read_usda = read_usda  # `in_process` puts back what it found
        yield


def _put_right(place: str, sound: Path, folder: Path) -> None:
    """Make one place of the working folder what it is in the sound one."""
    name = os.path.relpath(place, os.path.realpath(folder))
    before, now = sound / name, folder / name
    if now.is_dir() and not before.is_dir():
        shutil.rmtree(now)
    elif before.is_dir():
        if not now.is_dir():
            shutil.copytree(before, now)
    elif before.exists():
        now.parent.mkdir(parents=True, exist_ok=True)
        now.unlink(missing_ok=True)
        shutil.copyfile(before, now)
    else:
        now.unlink(missing_ok=True)


def prepare(sound: Path) -> None:
    """Do once, before processes are made, what every execution would do again."""
    _called(sound)
    # What commands take is the same every time; a thousand lines of it are no execution.
    command.parser = lru_cache(command.parser)


def renew(sound: Path, folder: Path) -> None:
    """Make the working folder what the sound one is; itself it stays."""
    for entry in folder.iterdir():
        if entry.is_dir() and not entry.is_symlink():
            shutil.rmtree(entry)
        else:
            entry.unlink()
    shutil.copytree(sound, folder, dirs_exist_ok=True)


@lru_cache(maxsize=64)
def _text(path: Path) -> str:
    return path.read_text("utf-8")


@contextmanager
def limited() -> Iterator[None]:
    """Processor time of what runs in it ends with `TooLong`; see `TIME`."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise TooLong

    before, cached = signal.signal(signal.SIGPROF, stop), sys.dont_write_bytecode
    sys.dont_write_bytecode = True  # Python's own files beside a module are none of the run's
    signal.setitimer(signal.ITIMER_PROF, TIME)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
        sys.dont_write_bytecode = cached


def _told(line: str, code: int | None, out: str, err: str) -> Iterator[str]:
    """What is wrong with exit code and words."""
    if code not in (0, 1, 2):
        yield f"exit code {code}"
    for sign in ("a fault of actspec", "Traceback (most recent call last)", "ENV002", "RecursionError"):
        if sign in out + err:
            at = (out + err).index(sign)
            yield (out + err)[at : at + 200].partition("\n")[0]
    for stream in (out, err):
        odd = {
            letter for letter in set(stream) - {"\n", "\t"} if unicodedata.category(letter) in ("Cc", "Cs")
        }
        if odd:
            yield f"printed as they are: {sorted(map(ascii, odd))}"
    if warned := _LIBRARY_WARNS.search(err):
        yield f"a library's own words: {err[warned.start() :].partition(chr(10))[0]:.200}"
    form = line.partition("--output-format ")[2].partition(" ")[0]
    if out or code in (0, 1):
        try:
            if form in ("json", "sarif"):
                json.loads(out, parse_constant=_no_number)
            elif form == "junit" and code != 2:
                etree.fromstring(out.encode())
        except (ValueError, etree.XMLSyntaxError) as fault:
            yield f"{form} that does not parse: {fault}"


def _no_number(text: str) -> None:
    raise ValueError(f"{text} is no JSON")


def _wrong(place: Path, sound: Path, folder: Path, changed: str) -> str:
    """What is wrong with a file that was written."""
    name = place.relative_to(os.path.realpath(folder)).as_posix()
    if name == changed:
        return ""  # a stranger's file with a fix in it
    data = place.read_bytes()
    try:
        if place.suffix == ".py":
            return _code(name, ast.parse(data), sound)
        if place.suffix in (".json", ".lock"):
            json.loads(data, parse_constant=_no_number)
        elif place.suffix in (".xml", ".urdf"):
            # An author's declaration stays, and MuJoCo reads UTF-8 whatever is declared.
            etree.fromstring(data, etree.XMLParser(encoding="utf-8"))
    except (ValueError, SyntaxError) as fault:
        return f"{name} does not parse: {fault!s:.200}"
    return ""


def _code(name: str, tree: ast.AST, sound: Path) -> str:
    """A name of the input that has become code."""
    known = _called(sound)
    for node in ast.walk(tree):
        words = {value for _, value in ast.iter_fields(node) if isinstance(value, str)}
        if MARKER in words and not isinstance(node, ast.Constant):
            return f"{name}: {MARKER} is code: {ast.unparse(node):.100}"
        if isinstance(node, ast.Call) and ast.unparse(node.func) not in known:
            return f"{name}: calls what no sound file calls: {ast.unparse(node.func):.100}"
    return ""


@lru_cache(maxsize=4)
def _called(sound: Path) -> frozenset[str]:
    """What the configurations call that actspec writes of sound specs."""
    files = (*sound.glob("*out/**/*.py"), *(ROOT / "tests" / "golden").glob("**/*.py"))
    calls = (
        node
        for path in files
        for node in ast.walk(ast.parse(path.read_bytes()))
        if isinstance(node, ast.Call)
    )
    return frozenset(ast.unparse(node.func) for node in calls)
