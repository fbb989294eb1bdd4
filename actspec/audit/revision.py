"""Files as a git revision has them, laid out in a folder so that includes, models and imports are found.

Nothing of the repository runs: blobs are read by their hash, without filters, text conversion or hooks.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import PurePosixPath

from actspec.diagnostics import AuditError, Span, shortened
from actspec.files import in_common

_TAKEN = (
    ".xml",
    ".urdf",
    ".mjcf",
    ".xacro",
    ".yaml",
    ".yml",
    ".py",
    ".json",
    ".toml",
    ".pt",
    ".pt2",
    ".onnx",
)
"""Files that robot files read, meshes left out: those are large, and need not be there."""

_MOST_FILE_BYTES = 32 << 20
_MOST_BYTES = 256 << 20
"""Chosen: the largest robot files have some MB; a repository of robots some 10 MB without meshes."""

_SECONDS = 60.0
_REGULAR = ("100644", "100755")


@dataclass(frozen=True, slots=True)
class Revision:
    """One file of a revision.

    Attributes:
        text: As the user wrote it: `HEAD~1:robot.xml`.
        path: Where the file lies now.
        folder: The folder that stands for the repository.
        commit: Hash of the commit.
    """

    text: str
    path: str
    folder: str
    commit: str


def names_revision(text: str) -> bool:
    """Whether an argument is `REVISION:PATH`; a file of that name goes first."""
    return ":" in text and not os.path.lexists(text)


def lay_out(text: str, folder: str) -> Revision:
    """Lay out the files of a revision.

    The path is taken from the root of the repository, as git takes it; from the working folder where it begins with
    `./` or `../`, or where the root has no such file.

    Args:
        text: `REVISION:PATH`.
        folder: An empty folder to lay them out in.

    Raises: AuditError: there is no such revision or file, or no git.
    """
    name, _, path = text.partition(":")
    if not name or name.startswith("-"):
        raise _error(text, f"names no revision: {shortened(name)!r}", "for example HEAD~1:robot.xml")
    if not path:
        raise _error(text, "names no file of the revision", f"for example {name}:robot.xml")
    commit = _git(text, "rev-parse", "--verify", "--quiet", "--end-of-options", f"{name}^{{commit}}")
    if commit is None:
        if _git(text, "rev-parse", "--git-dir") is None:
            raise _error(text, "is neither a file nor a revision: this folder is in no git repository")
        raise _error(text, f"git knows no revision {shortened(name)!r}", "`git log --oneline` lists them")
    digest = commit.decode("ascii", "replace").strip()
    prefix = (_git(text, "rev-parse", "--show-prefix") or b"").decode("utf-8", "surrogateescape").rstrip("\n")
    listing = _git(text, "ls-tree", "-r", "-l", "-z", "--full-tree", digest)
    entries = list(_entries(listing or b""))
    modes = {entry.path: entry.mode for entry in entries}
    chosen = _chosen(path, prefix, modes)
    if chosen is None:
        near = _near(path, modes)
        raise _error(text, "the revision has no such file", f"did you mean {name}:{near}?" if near else None)
    if modes[chosen] not in _REGULAR:
        raise _error(text, "is a link or a submodule there, not a file")
    _write(text, entries, chosen, folder)
    return Revision(text, os.path.join(folder, *PurePosixPath(chosen).parts), folder, digest)


@dataclass(frozen=True, slots=True)
class _Entry:
    """One line of `git ls-tree`."""

    mode: str
    digest: str
    size: int
    path: str


def _entries(listing: bytes) -> Iterator[_Entry]:
    for line in listing.split(b"\0"):
        head, tab, name = line.partition(b"\t")
        parts = head.split()
        if tab and len(parts) == 4:
            mode, _, digest, size = (part.decode("ascii", "replace") for part in parts)
            number = int(size) if size.isdecimal() else 0
            yield _Entry(mode, digest, number, name.decode("utf-8", "surrogateescape"))


def _chosen(path: str, prefix: str, modes: dict[str, str]) -> str | None:
    """The path from the root of the repository."""
    here = os.path.normpath(os.path.join(prefix, path)).replace(os.sep, "/")
    return next((found for found in (path, here) if found in modes), None)


def _near(path: str, modes: Iterable[str]) -> str | None:
    """The file of the revision that ends as the path does."""
    wanted = path.split("/")[::-1]

    def alike(known: str) -> int:
        return in_common(wanted, known.split("/")[::-1])

    best = max(modes, key=alike, default="")
    return best if best and alike(best) else None


def _write(text: str, entries: list[_Entry], main: str, folder: str) -> None:
    """Write the files that a reader may ask for."""
    wanted: list[_Entry] = []
    total = 0
    for entry in sorted(entries, key=lambda entry: entry.path != main):
        taken = entry.path == main or entry.path.lower().endswith(_TAKEN)
        parts = PurePosixPath(entry.path).parts
        inside = bool(parts) and not os.path.isabs(entry.path) and not {"..", ".git"} & set(parts)
        if not taken or not inside or entry.mode not in _REGULAR or entry.size > _MOST_FILE_BYTES:
            continue
        total += entry.size
        if total > _MOST_BYTES:
            break
        wanted.append(entry)
    blobs = _git(text, "cat-file", "--batch", given="".join(f"{entry.digest}\n" for entry in wanted).encode())
    start = 0
    for entry in wanted:
        # HASH blob SIZE, a newline, the bytes, a newline.
        end = (blobs or b"").find(b"\n", start)
        header = (blobs or b"")[start:end].split()
        if blobs is None or end < 0 or len(header) != 3 or header[1] != b"blob":
            raise _error(text, f"git cannot read {shortened(entry.path)!r} of the revision")
        size = int(header[2])
        target = os.path.join(folder, *PurePosixPath(entry.path).parts)
        try:
            os.makedirs(os.path.dirname(target), exist_ok=True)
            with open(target, "xb") as stream:
                stream.write(blobs[end + 1 : end + 1 + size])
        except OSError as err:
            if entry.path == main:
                raise _error(text, f"cannot be laid out: {err.strerror}") from err
        start = end + 1 + size + 1


def _git(text: str, *arguments: str, given: bytes | None = None) -> bytes | None:
    """What git prints; None when it fails."""
    # No question, no download of what a partial clone lacks, no lock.
    quiet = {"GIT_TERMINAL_PROMPT": "0", "GIT_NO_LAZY_FETCH": "1", "GIT_OPTIONAL_LOCKS": "0"}
    try:
        done = subprocess.run(
            ["git", "--no-pager", *arguments],
            input=given if given is not None else b"",
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, **quiet},
            timeout=_SECONDS,
            check=False,
        )
    except FileNotFoundError as err:
        raise _error(text, "is not a file, and git is not installed, so it cannot be a revision") from err
    except (OSError, ValueError, subprocess.SubprocessError) as err:
        raise _error(text, f"git could not run: {type(err).__name__}") from err
    return done.stdout if done.returncode == 0 else None


def _error(text: str, message: str, help: str | None = None) -> AuditError:
    return AuditError.of("DIF002", message, Span(text), help=help)
