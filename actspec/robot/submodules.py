"""Git submodules that are not checked out, from `.gitmodules`, which is read as text, and MuJoCo Menagerie where it is
not cloned; git is not run."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass

from actspec.diagnostics import in_quotes, shell_word
from actspec.files import FAULTS, in_repository, read_regular

NOT_CHECKED_OUT = "ROBOT010"
"""Code of a file in one."""

_PATH = re.compile(rb"""^[ \t]*path[ \t]{0,9}=[ \t]{0,9}"?([^"\r\n]{1,999}?)"?[ \t]{0,9}\r?$""", re.MULTILINE)
_MOST_BYTES = 1024 * 1024
"""Chosen: a repository with a hundred submodules has 20 kB."""


_MENAGERIE = "mujoco_menagerie"
_CLONED_FROM = "https://github.com/google-deepmind/mujoco_menagerie"
"""What models of many repositories include, by the name that its clone has, and git ignores."""


@dataclass(frozen=True, slots=True)
class NotThere:
    """A submodule, or a clone of MuJoCo Menagerie, without its files.

    Attributes:
        text: What it is.
        help: The command that gets its files.
    """

    text: str
    help: str

    def __str__(self) -> str:
        return self.text


def not_checked_out(beside: str, path: str) -> NotThere | None:
    """What a file which is not there belongs to; None: it is in none, or that one has files.

    Args:
        beside: The file that names it: `.gitmodules` is in its folder or above, in the same repository.
        path: Of the file that is not there.
    """
    return _submodule(beside, path) or _menagerie(beside, path)


def _submodule(beside: str, path: str) -> NotThere | None:
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
                where = "" if folder in ("", os.curdir) else f" -C {shell_word(folder)}"
                command = f"git{where} submodule update --init {shell_word(own)}"
                return NotThere(f"{in_quotes(own)} is a git submodule that is not checked out", command)
        return None
    return None


def _menagerie(beside: str, path: str) -> NotThere | None:
    before, name, inside = os.path.normpath(path).replace(os.sep, "/").partition(f"{_MENAGERIE}/")
    where = before + _MENAGERIE
    # An absolute path is of one machine, unless the files are named so.
    own = os.path.isabs(path) == os.path.isabs(beside) and (not before or before.endswith("/"))
    # Where it lies in another folder, the path is wrong.
    places = (where, *(os.path.join(folder, _MENAGERIE) for folder in in_repository(beside)))
    if not (name and inside and own and all(map(_has_nothing, places))):
        return None
    command = f"git clone {_CLONED_FROM} {shell_word(where)}"
    return NotThere(f"MuJoCo Menagerie is not cloned at {in_quotes(where)}", command)


def of_missing(message: str, path: str, help: str | None = None) -> tuple[str, str | None]:
    """What is said of a named file that is not there, and its help: with what it belongs to, if anything.

    Args:
        message: What is said of any.
        path: The file, or `FOLDER/*`.
        help: Of one that belongs to nothing.
    """
    absent = not_checked_out(path, path)
    return (message, help) if absent is None else (f"{message}: {absent}", absent.help)


def _has_nothing(folder: str) -> bool:
    """Whether it is not there, or empty, as git leaves it."""
    try:
        return not os.listdir(folder)
    except FileNotFoundError:
        return True
    except (OSError, ValueError):
        return False
