"""Reading a file of a stranger."""

from __future__ import annotations

import json
import os
import re
import stat
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import takewhile
from typing import Any

from actspec.diagnostics import bytes_escaped


class NotRegular(Exception):
    """What a path names is no regular file; the text says what it is.

    Attributes:
        folder: Whether it is a folder.
    """

    def __init__(self, folder: bool) -> None:
        super().__init__("a folder" if folder else "not a regular file")
        self.folder = folder


class TooLarge(Exception):
    """A file has more bytes than are read.

    Attributes:
        size: Bytes that it has at least.
    """

    def __init__(self, size: int) -> None:
        super().__init__(f"{size} bytes")
        self.size = size


FAULTS = (NotRegular, TooLarge, OSError, ValueError)
"""What reading or writing a file can end in."""


def why(fault: Exception) -> str:
    """The reason of one of `FAULTS`, in words: `a folder`, `permission denied`."""
    return (getattr(fault, "strerror", None) or str(fault)).lower()


def place_of(data: bytes, at: int) -> tuple[int, int]:
    """Line and column of a byte in a text of UTF-8, from 1; columns count characters, also behind a lone return."""
    before = data[max(data.rfind(b"\n", 0, at), data.rfind(b"\r", 0, at)) + 1 : at]
    return data.count(b"\n", 0, at) + 1, len(before.decode("utf-8-sig", "replace")) + 1


_IMPORTED = (".py", ".pyc", ".pyo", ".pyw", ".pyi", ".so", ".pyd", ".dll", ".dylib")


def is_imported(name: str) -> bool:
    """Whether Python would run a file of this name, in the folder of a configuration or elsewhere.

    Windows drops dots and blanks at the end, and what follows a colon.
    """
    return os.path.basename(name).partition(":")[0].rstrip(". ").lower().endswith(_IMPORTED)


_CHANGED: dict[str, bytes] = {}


@contextmanager
def changed(files: Mapping[str, bytes]) -> Iterator[None]:
    """Read files as they would be after changes that are not written.

    Args:
        files: Real path to bytes.
    """
    _CHANGED.update(files)
    try:
        yield
    finally:
        _CHANGED.clear()


_READ: list[set[str]] = []


@contextmanager
def noting() -> Iterator[set[str]]:
    """Note which files are read, so that none of them is replaced; without it nothing is noted.

    What is read within another one is not noted there.

    Yields: Their absolute paths.
    """
    read: set[str] = set()
    _READ.append(read)
    try:
        yield read
    finally:
        _READ.pop()


def note(paths: Iterable[str]) -> None:
    """Note files that something else has read: a library, another process."""
    if _READ:
        _READ[-1].update(map(os.path.abspath, paths))


def was_read(path: str) -> bool:
    """Whether a file that is there was noted as read, under whatever name."""
    if not _READ or not os.path.exists(path):
        return False
    return any(os.path.exists(one) and os.path.samefile(one, path) for one in _READ[-1])


def name_in_file(path: str) -> str:
    """A path as files of actspec have it, in plain Unicode: a byte that is not UTF-8 is `\\xff`.

    A backslash that would read as such a byte is `\\x5c`, so that no two paths have one name. Windows has no such
    bytes, and backslashes between folders.
    """
    return path if os.sep != "/" else bytes_escaped(_LIKE_BYTE.sub(r"\\x5c", path))


def path_of_name(name: str) -> str:
    """The path that `name_in_file` has given this name."""
    return name if os.sep != "/" else _NAMED_BYTE.sub(_byte, name)


def _byte(found: re.Match[str]) -> str:
    return "\\" if found[1] == "5c" else chr(0xDC00 + int(found[1], 16))


_NAMED_BYTE = re.compile(r"\\x(5c|[89a-f][0-9a-f])")
_LIKE_BYTE = re.compile(r"\\(?=x(?:5c|[89a-f][0-9a-f]))")


def in_common(one: Sequence[object], other: Sequence[object]) -> int:
    """How many items two rows have in common, from the first on: folders of two paths, say."""
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(one, other, strict=False)))


MOST_ABOVE = 8
"""Folders above a file that may be its project's. Chosen: twice those of MuJoCo's menagerie or of a ROS package."""


def above(path: str) -> list[str]:
    """The folder of a file and those above it, as a user would name them."""
    folder = os.path.dirname(path)
    return [os.path.normpath(os.path.join(folder, *[os.pardir] * steps)) for steps in range(MOST_ABOVE + 1)]


def in_repository(path: str) -> Iterator[str]:
    """Those of them that are of the file's repository, where one of them is the repository's own; else all."""
    for folder in above(path):
        yield folder
        if os.path.lexists(os.path.join(folder, ".git")):
            return
        if os.path.dirname(os.path.abspath(folder)) == os.path.abspath(folder):
            return


def leads_into(path: str, roots: Iterable[str]) -> bool:
    """Whether a path leads to what is in one of some folders, whatever `..` and links are on the way.

    Args:
        path: As a stranger may have written it.
        roots: Real paths of the folders.
    """
    try:
        real = os.path.realpath(path)
    except (OSError, ValueError):  # NUL in it
        return False
    return any(real.startswith(os.path.join(root, "")) for root in roots)


def folders_in(folder: str) -> list[str]:
    """The folders of a folder, as a user would name them, without hidden ones and links."""
    try:
        with os.scandir(folder or os.curdir) as entries:
            names = [
                one.name
                for one in entries
                if not one.name.startswith(".") and one.is_dir(follow_symlinks=False)
            ]
    except (OSError, ValueError):
        return []
    return [os.path.normpath(os.path.join(folder, name)) for name in sorted(names)]


def json_of(data: Any, *, indent: int | None = 2, sort_keys: bool = False) -> str:
    """JSON to be kept in a file: Unicode, but nothing that cannot be printed; NaN and infinity are refused."""
    text = json.dumps(data, indent=indent, sort_keys=sort_keys, ensure_ascii=False, allow_nan=False)
    if text.isprintable():
        return text
    return "".join(c if c == "\n" or c.isprintable() else json.dumps(c)[1:-1] for c in text)


def read_regular(path: str, most: int) -> bytes:
    """Read a regular file; never waits on a pipe or device.

    Args:
        path: Where.
        most: Largest size [bytes].

    Raises:
        NotRegular: it is a folder, pipe, device or socket.
        TooLarge: it is larger than `most`.
        OSError: it cannot be opened or read.
        ValueError: the path cannot be one, as with NUL.
    """
    note([path])
    if _CHANGED and os.path.realpath(path) in _CHANGED:
        data = _CHANGED[os.path.realpath(path)]
        if len(data) > most:
            raise TooLarge(len(data))
        return data
    flags = os.O_RDONLY
    for name in ("O_NONBLOCK", "O_NOCTTY", "O_CLOEXEC", "O_BINARY"):
        flags |= getattr(os, name, 0)
    # Looked at before it is opened, because opening a device may do something; and after.
    _refuse_irregular(os.stat(path))
    with open(os.open(path, flags), "rb") as stream:
        info = os.fstat(stream.fileno())
        _refuse_irregular(info)
        data = b""
        if info.st_size <= most:
            data = stream.read(info.st_size + 1)
        if len(data) > info.st_size:
            # It has grown after fstat, or the system does not tell its size; the read is bounded too.
            data += stream.read(most + 1 - len(data))
    size = max(info.st_size, len(data))
    if size > most:
        raise TooLarge(size)
    return data


def _refuse_irregular(info: os.stat_result) -> None:
    if not stat.S_ISREG(info.st_mode):
        raise NotRegular(stat.S_ISDIR(info.st_mode))
