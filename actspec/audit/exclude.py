"""Which files an audit passes over, and which ones a glob names.

A folder that is excluded is not looked into. What is named on the command line is audited all the same, unless that is
refused: a hook is handed every file of a commit.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

from actspec.diagnostics import Diagnostic, Severity, Span, in_quotes

_NEAR = 0.8
"""Likeness from which a name is a glob's, misspelt. Chosen: one letter of five."""

_MOST = 20_000
"""Files and folders of a project that are looked at for a name. Chosen: a second at most."""


@dataclass(frozen=True, slots=True)
class Exclude:
    """Whether a file or folder is passed over.

    Attributes:
        globs: Globs, each with the folder that it is relative to.
        force: Whether what is named on the command line is passed over too.
        never: A path that is not.
    """

    globs: tuple[tuple[str, str], ...] = ()
    force: bool = False
    never: str | None = None

    def __call__(self, path: str, named: bool) -> bool:
        """Whether to pass over.

        Args:
            path: File or folder, as the user named it or below a folder that was named.
            named: Whether it was named; else the folders above it are not excluded.
        """
        if not self.globs or path == self.never or (named and not self.force):
            return False
        full = os.path.abspath(path)
        # Links to files are known by their own names.
        full = os.path.join(os.path.realpath(os.path.dirname(full)), os.path.basename(full))
        return any(_excludes(glob, folder, full, above=named) for glob, folder in self.globs)


def unfit(
    globs: Iterable[tuple[str, str]],
    named: Iterable[str],
    met: Iterable[str],
    places: Mapping[str, Span],
    setting: str = "exclude",
    fits: Callable[[str, str, str], bool] | None = None,
) -> Iterator[Diagnostic]:
    """Globs that fit nothing, where something has nearly their name.

    Only of folders, for a hook is handed some of the files. Near is a folder of a path that lies deeper, too. A glob
    without a near name is left alone, for what it names may not be made yet, or lie in another folder than those that
    were named.

    Args:
        globs: Globs, each with the folder that it is relative to.
        named: What the user named.
        met: Paths of all files and folders that were found, those that are passed over too.
        places: Where globs are written, those of a settings file.
        setting: What the globs are of.
        fits: Whether a glob, below a folder, fits a path; default: as of `exclude`, a file or folder.
    """
    whole = [os.path.join(os.path.realpath(path), "") for path in named if os.path.isdir(path)]
    paths = [os.path.realpath(path) for path in met] if whole else []
    for glob, folder in dict.fromkeys(globs) if whole else ():
        base = os.path.join(os.path.realpath(folder), "")
        own = [path for path in paths if path.startswith(base)]
        fit = fits or (lambda glob, folder, path: _excludes(glob, folder, path, above=False))
        if any(fit(glob, folder, path) for path in own):
            continue
        # As Windows writes paths: no file here has such a name.
        bare = os.path.normpath(glob.replace("\\", "/")).replace(os.sep, "/")
        # A folder, where files are named.
        below = f"{bare}/**" if "/" in bare else f"**/{bare}/**"
        able = [bare, *_deeper(bare, base)]
        if fits is not None:
            able += [below, *_deeper(below, base)]
        everything = any(base.startswith(path) for path in whole)
        mended = _mended(bare, base, own, everything=everything)
        if mended:
            able += [mended, f"{mended}/**"]
        near = next((one for one in able if any(fit(one, folder, path) for path in own)), None)
        if near:
            message = f"the glob {in_quotes(glob)} of {setting} fits nothing here"
            help = f"did you mean {in_quotes(near)}?"
            yield Diagnostic("AUD017", Severity.WARNING, message, span=places.get(glob), help=help)


def _deeper(glob: str, base: str) -> Iterator[str]:
    """A glob that begins with a folder that is not there, for one of its name anywhere below."""
    first, slash, _ = glob.partition("/")
    if slash and first and not any(sign in first for sign in "*?") and not os.path.lexists(base + first):
        yield f"**/{glob}"


def _mended(glob: str, base: str, own: Sequence[str], *, everything: bool) -> str | None:
    """A glob with what a part of it, that is no name there, is nearly the name of; the rest narrows it down as before.

    What is there and was not looked at is left alone, at any depth where the name may lie at any: `test` near `tests`.
    """
    names = {part for path in own for part in path[len(base) :].split(os.sep)}
    parts = glob.split("/")
    for number, part in enumerate(parts, 1):
        if part in names or any(sign in part for sign in "*?"):
            continue
        if os.path.lexists(os.path.join(base, *parts[:number])):
            return None
        near = get_close_matches(part, sorted(names), n=1, cutoff=_NEAR)
        fixed = len(parts) > 1 and not any(sign in before for before in parts[:number] for sign in "*?")
        if near and (everything or fixed or not _is_below(base, part)):
            return "/".join((*parts[: number - 1], near[0], *parts[number:]))
    return None


def _is_below(folder: str, name: str) -> bool:
    """Whether something in a folder, at any depth, has a name; or there is too much in it to tell."""
    count = 0
    for _, folders, files in os.walk(folder):
        count += len(folders) + len(files)
        if name in folders or name in files or count > _MOST:
            return True
    return False


def _excludes(glob: str, folder: str, path: str, *, above: bool) -> bool:
    glob = os.path.normpath(glob).replace(os.sep, "/")
    while True:
        try:
            relative = os.path.relpath(path, os.path.realpath(folder)).replace(os.sep, "/")
        except ValueError:  # another drive
            return False
        if glob_matches(glob, path.replace(os.sep, "/") if os.path.isabs(glob) else relative):
            return True
        # Folders above the settings have names that say nothing about what is below.
        if not above or relative.startswith("..") or "/" not in relative:
            return False
        path = os.path.dirname(path)


def glob_matches(glob: str, path: str) -> bool:
    """Whether a path (with `/`) fits a glob; a glob without `/` is held against the last part alone.

    `*` and `?` stand for anything but `/`, `**` for anything.
    """
    if "/" not in glob:
        path = path.rpartition("/")[2]
    # All places of the glob at once, character by character: a regular expression of many stars takes forever.
    found = re.findall(r"\*\*/|\*\*|.", glob, re.DOTALL)
    parts = [part for one in found for part in (("", one) if one == "**/" else (one,))]
    places = _with_skips({0}, parts)
    for char in path:
        places = _with_skips(
            {after for place in places if place < len(parts) for after in _after(place, parts[place], char)},
            parts,
        )
    return len(parts) in places


def _with_skips(places: set[int], parts: Sequence[str]) -> set[int]:
    """Places in a glob, and those that are reached from them without a character."""
    found: set[int] = set()
    waiting = list(places)
    while waiting:
        place = waiting.pop()
        if place in found:
            continue
        found.add(place)
        if place == len(parts):
            continue
        if parts[place] == "":  # before `**/`: folders, or none
            waiting += [place + 1, place + 2]
        elif parts[place] in ("*", "**"):
            waiting.append(place + 1)
    return found


def _after(place: int, part: str, char: str) -> Iterator[int]:
    """Places in a glob after a character."""
    if part == "**/":
        yield place
        if char == "/":
            yield place + 1
    elif part in ("*", "**"):
        if char != "/" or part == "**":
            yield place
    elif part == char or (part == "?" and char != "/"):
        yield place + 1
