"""Git submodules that are not checked out, from `.gitmodules`, which is read as text; git is not run."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass

from actspec.diagnostics import shell_word
from actspec.files import FAULTS, in_repository, read_regular

NOT_CHECKED_OUT = "ROBOT010"
"""Code of a file in one."""

_PATH = re.compile(rb"""^[ \t]*path[ \t]{0,9}=[ \t]{0,9}"?([^"\r\n]{1,999}?)"?[ \t]{0,9}\r?$""", re.MULTILINE)
_MOST_BYTES = 1024 * 1024
"""Chosen: a repository with a hundred submodules has 20 kB."""


@dataclass(frozen=True, slots=True)
class Submodule:
    """A submodule without its files.

    Attributes:
        root: The folder of `.gitmodules`, as a user would name it.
        path: Of the submodule, from there.
    """

    root: str
    path: str

    def __str__(self) -> str:
        return f"{self.path!r} is a git submodule that is not checked out"

    @property
    def help(self) -> str:
        """The command that gets its files."""
        where = "" if self.root in ("", os.curdir) else f" -C {shell_word(self.root)}"
        return f"git{where} submodule update --init {shell_word(self.path)}"


def not_checked_out(beside: str, path: str) -> Submodule | None:
    """The submodule that a file which is not there belongs to; None: it is in none, or that one has files.

    Args:
        beside: The file that names it: `.gitmodules` is in its folder or above, in the same repository.
        path: Of the file that is not there.
    """
    for folder in in_repository(beside):
        try:
            data = read_regular(os.path.join(folder, ".gitmodules"), _MOST_BYTES)
        except FAULTS:
            continue
        inside = os.path.relpath(os.path.abspath(path), os.path.abspath(folder)).replace(os.sep, "/")
        for name in (os.fsdecode(found) for found in _PATH.findall(data)):
            own = name.rstrip("/")
            # git takes no path that leads out of the repository.
            if (
                own
                and os.pardir not in own.split("/")
                and inside.startswith(f"{own}/")
                and _has_nothing(os.path.join(folder, own))
            ):
                return Submodule(folder, own)
        return None
    return None


def of_missing(message: str, path: str, help: str | None = None) -> tuple[str, str | None]:
    """What is said of a named file that is not there, and its help: with the submodule that it belongs to, if any.

    Args:
        message: What is said of any.
        path: The file, or `FOLDER/*`.
        help: Of one in no submodule.
    """
    submodule = not_checked_out(path, path)
    return (message, help) if submodule is None else (f"{message}: {submodule}", submodule.help)


def _has_nothing(folder: str) -> bool:
    """Whether it is not there, or empty, as git leaves it."""
    try:
        return not os.listdir(folder)
    except FileNotFoundError:
        return True
    except (OSError, ValueError):
        return False
