"""Putting files in place: all of a run or none, each whole at any moment, and what a kill leaves is finished.

Every file is written beside its place first. Then a journal says what is to be moved where, and the files are
moved. A run that fails takes its moves back. One that is killed leaves the journal, and the next run that writes
into the folder finishes the moves (`finish`); without a journal, or with one file alone, it had moved nothing, and
its files go.
"""

from __future__ import annotations

import json
import os
import re
import stat
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from errno import EACCES, EEXIST, EISDIR, ENOENT
from typing import Any

_LEFT = re.compile(r"\.(?P<run>[0-9a-f]{16})\.\d{1,6}\.actspec-(?:new|old)")
_JOURNAL = re.compile(r"\.(?P<run>[0-9a-f]{16})\.actspec-journal")
_MOST_JOURNAL = 1 << 20
"""Bytes of a journal that are read."""
_STREAMS = ("/dev/stdout", "/dev/stderr", "/dev/fd/", "/proc/self/fd/")
"""They may lead to a log, which is appended to."""


@dataclass(frozen=True, slots=True)
class _Move:
    """One file beside its place.

    Attributes:
        place: Where it goes; no link.
        new: The file.
        old: A second name of what is there now; None: nothing is there, or one file alone is moved.
        was: Device-independent signs of what is there now: inode, size and time; None: nothing is there.
    """

    place: str
    new: str
    old: str | None
    was: tuple[int, int, int] | None


def place(files: Sequence[tuple[str, bytes]]) -> None:
    """Put files in place, all or none; their folders are made.

    A link stays a link, and what it leads to is written. A file keeps its mode; one that nobody may write stays as
    it is. Pipes, devices and the process's own streams are appended to, after all files.

    Args:
        files: Path and bytes of each.

    Raises:
        OSError: one cannot be written; `filename` is its path. Nothing has changed.
        ValueError: a path cannot be one, as with NUL. Nothing has changed.
    """
    plain: list[tuple[str, bytes]] = []
    streams: list[tuple[str, bytes]] = []
    for path, data in files:
        (streams if is_stream(path) else plain).append((path, data))
    targets = [os.path.realpath(path) for path, _ in plain]
    taken: set[str] = set()
    for (path, _), target in zip(plain, targets, strict=True):
        # Names that differ by case alone are one on many file systems.
        if target.casefold() in taken:
            raise OSError(EEXIST, "is written twice in one run", path)
        taken.add(target.casefold())
    folders = tuple(dict.fromkeys(os.path.dirname(target) for target in targets))
    finish(targets)
    run = os.urandom(8).hex()
    with ExitStack() as undo, ExitStack() as left:
        for (path, _), target in zip(plain, targets, strict=True):
            with _named(path):
                _make_folder(os.path.dirname(target), undo)
        # Before anything is beside its place, so that nobody takes it for what a kill has left.
        records = {folder: left.enter_context(_journal(folder, run)) for folder in folders}
        moves = []
        for number, ((path, data), target) in enumerate(zip(plain, targets, strict=True)):
            beside = os.path.join(os.path.dirname(target), f".{run}.{number}.actspec-")
            with _named(path):
                moves.append(_beside(target, data, beside, left, several=len(files) > 1))
        # One file alone is there or not: there is nothing to finish, and what stood there before is what was.
        for folder, write in records.items() if len(moves) > 1 else ():
            with _named(folder):
                write([move for move in moves if os.path.dirname(move.place) == folder])
        with ExitStack() as moved:
            for move, (path, _) in zip(moves, plain, strict=True):
                with _named(path):
                    os.replace(move.new, move.place)
                moved.callback(_take_back, move)
            for path, data in streams:
                with _named(path), open(path, "ab") as stream:
                    stream.write(data)
            moved.pop_all()
            undo.pop_all()


def replace_file(path: str, data: bytes) -> None:
    """Put one file in place; its folder is there. See `place`."""
    if not os.path.isdir(os.path.dirname(os.path.realpath(path)) or "."):
        raise FileNotFoundError(ENOENT, os.strerror(ENOENT), path)
    place([(path, data)])


def finish(paths: Iterable[str]) -> None:
    """Finish what a killed run has left beside files, or take it away where it had not begun to move any.

    Runs that still go on are left alone.

    Args:
        paths: Files that are about to be written.
    """
    for folder in dict.fromkeys(_folder_of(path) for path in paths):
        try:
            names = sorted(os.listdir(folder))
        except OSError:
            continue
        left = [found for name in names if (found := _LEFT.fullmatch(name))]
        journals = {found["run"]: name for name in names if (found := _JOURNAL.fullmatch(name))}
        for run in sorted({found["run"] for found in left} | set(journals)):
            own = [found[0] for found in left if found["run"] == run]
            journal = os.path.join(folder, journals[run]) if run in journals else None
            with suppress(OSError):
                _finish(folder, own, journal)


def _finish(folder: str, left: list[str], journal: str | None) -> None:
    with ExitStack() as held:
        if journal is not None:
            stream = held.enter_context(open(journal, "rb"))
            if not _lock(stream.fileno()):
                return
            for name, new, was in _moves_of(stream.read(_MOST_JOURNAL)):
                target = os.path.join(folder, name)
                # What somebody has changed since stays.
                if new in left and _signs(target) == was:
                    os.replace(os.path.join(folder, new), target)
        for name in left:
            _remove(os.path.join(folder, name))
        if journal is not None:
            _remove(journal)


def _moves_of(data: bytes) -> Iterator[tuple[str, str, tuple[int, int, int] | None]]:
    """Moves of a journal that is whole: name of the place, of the file beside it, and what was there."""
    with suppress(ValueError, KeyError, TypeError, RecursionError):
        entries: Any = json.loads(data)["moves"]
        for entry in entries:
            name, new, was = entry["name"], entry["new"], entry["was"]
            if isinstance(name, str) and os.path.basename(name) == name and name not in ("", ".", ".."):
                yield name, new, None if was is None else tuple(was)


@contextmanager
def _journal(folder: str, run: str) -> Iterator[Callable[[Sequence[_Move]], None]]:
    """A folder's journal, locked as long as the run goes on, and what writes it."""
    path = os.path.join(folder, f".{run}.actspec-journal")
    with _named(folder):
        stream = open(path, "xb")  # noqa: SIM115 - closed below
    with stream:
        try:
            _lock(stream.fileno())

            def write(moves: Sequence[_Move]) -> None:
                record = [
                    {"name": os.path.basename(move.place), "new": os.path.basename(move.new), "was": move.was}
                    for move in moves
                ]
                stream.write(json.dumps({"moves": record}).encode("ascii"))
                stream.flush()
                os.fsync(stream.fileno())

            yield write
        finally:
            _remove(path)


def _beside(target: str, data: bytes, beside: str, left: ExitStack, *, several: bool) -> _Move:
    """Write a file beside its place, with the mode that it will have there."""
    was = _signs(target)
    mask = os.umask(0)
    os.umask(mask)
    mode = 0o666 & ~mask
    if was is not None:
        there = os.stat(target)
        if stat.S_ISDIR(there.st_mode):
            raise IsADirectoryError(EISDIR, "a folder", target)
        mode = stat.S_IMODE(there.st_mode)
        if not mode & 0o222 or not os.access(target, os.W_OK):
            raise PermissionError(EACCES, "it is read-only", target)
    new = f"{beside}new"
    left.callback(_remove, new)
    handle = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_CLOEXEC", 0), 0o600)
    with os.fdopen(handle, "wb") as stream:
        stream.write(data)
        stream.flush()
        os.fsync(stream.fileno())
    os.chmod(new, mode)
    old = None
    if was is not None:
        with suppress(OSError):
            os.chown(new, there.st_uid, there.st_gid)
            os.chmod(new, mode)
        if several:
            old = f"{beside}old"
            left.callback(_remove, old)
            _second_name(target, old)
    return _Move(target, new, old, was)


def _second_name(path: str, other: str) -> None:
    """Keep a file under another name too; where the file system has no links, a copy."""
    try:
        os.link(path, other)
    except OSError:
        import shutil

        shutil.copy2(path, other)


def _take_back(move: _Move) -> None:
    with suppress(OSError):
        if move.old is not None:
            os.replace(move.old, move.place)
        elif move.was is None:
            os.unlink(move.place)


def _make_folder(folder: str, undo: ExitStack) -> None:
    missing = []
    while folder and not os.path.isdir(folder):
        missing.append(folder)
        folder = os.path.dirname(folder)
    for one in reversed(missing):
        os.mkdir(one)
        undo.callback(_remove_folder, one)


def _remove(path: str) -> None:
    with suppress(OSError):
        os.unlink(path)


def _remove_folder(path: str) -> None:
    with suppress(OSError):
        os.rmdir(path)


@contextmanager
def _named(path: str) -> Iterator[None]:
    """Have an error name the file that the caller knows, not the one beside it."""
    try:
        yield
    except OSError as err:
        raise type(err)(err.errno, err.strerror or str(err), path) from err


def _folder_of(path: str) -> str:
    try:
        return os.path.dirname(os.path.realpath(path))
    except ValueError:  # it cannot be a path, and says so where it is written
        return ""


def is_stream(path: str) -> bool:
    """Whether a path is a pipe, a device or a stream of the process: it is appended to, and nothing in it is lost."""
    # Of what lies below /dev only streams: /dev/shm has files like others.
    if os.path.abspath(path).startswith(_STREAMS):
        return True
    return os.path.exists(path) and not os.path.isfile(path) and not os.path.isdir(path)


def _signs(path: str) -> tuple[int, int, int] | None:
    try:
        info = os.stat(path)
    except FileNotFoundError:
        return None
    return info.st_ino, info.st_size, info.st_mtime_ns


def _lock(handle: int) -> bool:
    """Whether nobody else has a file locked, which is locked now as long as it is open."""
    try:
        import fcntl
    except ImportError:  # Windows: whether the run goes on cannot be told
        return False
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True
