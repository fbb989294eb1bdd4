"""Reading a file of a stranger, and writing one so that nobody ever finds half of it."""

from __future__ import annotations

import contextlib
import os
import stat


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


def replace_file(path: str, data: bytes) -> None:
    """Write a file in one step: a crash at any moment leaves the old one whole.

    What is there and is no file of its own, as a pipe or `/dev/stdout`, is written into and stays.

    Args:
        path: Where; its folder is there.
        data: All its bytes.

    Raises:
        OSError: it cannot be written; the old file is untouched.
    """
    if os.path.exists(path) and (not os.path.isfile(path) or os.path.abspath(path).startswith("/dev/")):
        # Appended, because /dev/stdout may lead to a log.
        with open(path, "ab") as stream:
            stream.write(data)
        return
    import tempfile  # brings compression and random numbers along

    folder, name = os.path.split(path)
    handle, temporary = tempfile.mkstemp(prefix=f".{name}.", dir=folder or ".")
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        # mkstemp makes files for the owner alone; these are for everybody that the umask allows.
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, path)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
        raise
