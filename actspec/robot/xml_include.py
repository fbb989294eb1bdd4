"""The files that an include may name: where they are looked for, and how they are read."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence

from actspec.diagnostics import listed, nearest
from actspec.files import NotRegular, TooLarge, read_regular


class Unreadable(Exception):
    """A file cannot be read; the text says why, `help` what to do."""

    def __init__(self, message: str, help: str | None = None) -> None:
        super().__init__(message)
        self.help = help


class Missing(Unreadable):
    """There is no such file."""


def read_file(path: str, most: int) -> bytes:
    """Read a file of a model.

    Raises:
        Missing: there is no such file.
        Unreadable: it is no regular file, larger than `most` bytes, or cannot be opened.
    """
    try:
        return read_regular(path, most)
    except NotRegular as err:
        raise Unreadable(f"{path!r} is {err}") from err
    except TooLarge as err:
        raise Unreadable(f"{path!r} is larger than {most >> 20} MiB") from err
    except (FileNotFoundError, NotADirectoryError) as err:
        raise Missing(f"there is no file {path!r}") from err
    except (OSError, ValueError) as err:
        reason = getattr(err, "strerror", None) or "bad path"
        raise Unreadable(f"{path!r} cannot be read: {reason}") from err


def candidates_for(main: str, including: str, name: str) -> tuple[str, ...]:
    """Paths to try for an include, in MuJoCo's order; see `xml`.

    Args:
        main: Path of the main file.
        including: Path of the file with the include.
        name: What the include says.
    """
    name = name.replace("\\", "/")
    if os.path.isabs(name) or re.match("[A-Za-z]:", name):
        return (os.path.normpath(name),)
    folders = (os.path.dirname(main), os.path.dirname(including))
    return tuple(dict.fromkeys(os.path.normpath(os.path.join(folder, name)) for folder in folders))


def tried(name: str, candidates: Sequence[str]) -> str:
    """Say which paths were tried, and what is near them."""
    text = f"tried {listed(candidates)}"
    if os.path.isabs(name):
        text += "; an absolute path holds on one machine only"
    for candidate in candidates:
        folder, last = os.path.split(candidate)
        try:
            near = nearest(last, sorted(os.listdir(folder or ".")))
        except (OSError, ValueError):
            continue
        if near is not None:
            return f"{text}; did you mean {near!r}?"
    return text
