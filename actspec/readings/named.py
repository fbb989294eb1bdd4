"""The files and folders that the user named to what is in them, read in other processes."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache

from actspec.diagnostics import Diagnostic, Severity, Span, listed, many
from actspec.files import why
from actspec.processes import FaultError, LostError, Pool
from actspec.readings.artifact import NOT_FOUND, FileKind, FileReading
from actspec.readings.including import INCLUDED, MOST_WHOLES, Around
from actspec.readings.motor_names import with_names
from actspec.readings.pins import pins_here
from actspec.readings.programs import ASIDE, Idle, files_in, idle, programs_in
from actspec.readings.read import (
    EMPTY,
    FAULT,
    PYTHON,
    ROBOT,
    ROBOT_ALONE,
    ROBOT_ROOT,
    TEMPLATE,
    XACRO,
    XACRO_FILE,
    YAML,
    nothing_to_audit,
    read_file,
)
from actspec.robot.submodules import not_checked_out, of_missing
from actspec.spec.variants import split

RECORD = "past run"
"""What else of a folder is not read: a training's own `params/env.yaml`."""

NOT_READ = {
    XACRO: XACRO_FILE,
    ".sdf": "SDF",
    **dict.fromkeys((".usd", ".usda", ".usdc", ".usdz"), "USD"),
}
"""Endings of robots that are not read, and what they are: a folder's are counted."""

_OTHER_ROBOT = re.compile(
    rb"<!DOCTYPE\s+\w+\s+PUBLIC\s"
    rb"|\A(?:\xef\xbb\xbf)?\s*(?:<\?[^>]*>\s*|<!--(?:(?!-->).)*-->\s*)*<(?!(?:mujoco|robot))[A-Za-z]",
    re.DOTALL,
)
"""The devices of a robot in YARP's own format, whose root is called as a URDF's, and worlds with robots in them."""

_ROBOT_CODE = re.compile(
    rb"\b(?:ArticulationCfg|LeggedRobotCfg)|"
    rb"^[ \t]*(?:from|import)[ \t]+[\w.]*(?:isaaclab|omni\.isaac\.lab|mjlab|legged_gym)",
    re.MULTILINE,
)
"""What a configuration imports, or derives from, that cannot be parsed. A path in a command is no import."""

_RECORDS = ("params/env.yaml", "env.yaml")
"""What a training wrote of itself, below the folder of the run or its `params`."""


@dataclass(frozen=True, slots=True)
class NamedFile:
    """A file to read.

    Attributes:
        path: As the user named it, or below the folder that the user named.
        folders: The folders that were named and that it is in, as they were named.
        named: Whether the file itself was named.
    """

    path: str
    folders: tuple[str, ...] = ()
    named: bool = False

    @property
    def folder(self) -> str | None:
        """The innermost of them, in whatever order they were named: whoever names a folder asks for what is in it."""
        return max(self.folders, key=_depth, default=None)


class PendingFiles:
    """Files that are being read, so that the caller can do something else in the meantime."""

    def __init__(
        self,
        paths: Sequence[str],
        *,
        keep_matrices: bool | None = None,
        skip_other: bool = False,
        jobs: int | None = None,
        read: Callable[[str, bool, str | None], FileReading] = read_file,
        exclude: Callable[[str, bool], bool] | None = None,
    ) -> None:
        """Begin to read.

        Files are read in other processes, so that a crash or an endless loop of MuJoCo loses only the file
        that it was on, which is then read from its text.

        Args:
            paths: Files and folders, as the user names them. A folder stands for the files in it that have
                something to audit; see `expand`.
            keep_matrices: Keep the mass matrices of robot files, which rows of a configuration are made
                from; default: where a file may be a configuration.
            skip_other: Pass over named files that have nothing to audit, as over those in a folder.
            jobs: Processes that read; default: one a core.
            read: What each is read with; a function of a module.
            exclude: As in `expand`.
        """
        self._skip_other = skip_other
        self._excluded: dict[str, bool] = {}
        self.named, self.exclude = tuple(paths), exclude
        self.met: list[str] = []
        """Files and folders that were found, those that are passed over too."""
        self.passed_over: tuple[str, ...] = ()
        """Of the files that were read, those with nothing to audit that nobody asked for; known when all are read."""
        self._not_read: dict[str, str] = {}

        def passes_over(path: str, named: bool) -> bool:
            self.met.append(path)
            if exclude is None or not exclude(path, named):
                return False
            self._excluded[path] = os.path.isdir(path)
            return True

        self._files = expand(paths, skip_other=skip_other, exclude=passes_over, not_read=self._not_read)
        # A folder of which something is left out on purpose may have nothing else.
        self._paths = tuple(path for path in paths if not any(_is_below(one, path) for one in self._excluded))
        if keep_matrices is None:
            keep_matrices = any(file.path.lower().endswith((*PYTHON, *YAML)) for file in self._files)
        self._tasks = [(file.path, keep_matrices) for file in self._files]
        self._pool = Pool(read, self._tasks, jobs)

    def __enter__(self) -> PendingFiles:
        """The same."""
        return self

    def __exit__(self, *_: object) -> None:
        """Stop reading."""
        self._pool.__exit__()

    @property
    def excluded(self) -> tuple[int, int]:
        """How many files and how many folders were passed over; what is in these is not counted."""
        folders = sum(self._excluded.values())
        return len(self._excluded) - folders, folders

    @property
    def not_read(self) -> tuple[str, ...]:
        """Of each file in the folders that describes a robot and is not read, what it is: `xacro`."""
        return tuple(self._not_read.values())

    @property
    def in_folders(self) -> frozenset[str]:
        """Those that were found in a folder that was named."""
        return frozenset(file.path for file in self._files if file.folder is not None)

    def finish(self, progress: Callable[[int, int], None] | None = None) -> tuple[FileReading, ...]:
        """Wait until all are read. A file that ended its process is read once more, from its text alone.

        Args:
            progress: Called with how many files are read, of how many.

        Returns: One reading a file, in the order of the paths; what cannot be read says why.
        """
        found: dict[int, FileReading] = {}
        again: dict[int, int] = {}
        around: dict[int, tuple[int, str]] = {}
        pins_once = cache(pins_here)
        for task, answer in self._pool.results():
            if task in around:
                index, path = around[task]
                # A file that is read from its text is none in which another one compiles.
                if isinstance(answer, FileReading) and (
                    answer.compiles or (answer.readable and not found[index].readable)
                ):
                    found[index] = replace(found[index], whole=min(path, found[index].whole or path))
                continue
            index = again.get(task, task)
            path, keep_matrices = self._tasks[index]
            if isinstance(answer, LostError):
                if task == index and not isinstance(answer, FaultError):
                    again[self._pool.add(path, keep_matrices, str(answer))] = index
                    continue
                answer = _lost(path, str(answer))
            pins = pins_once() if answer.refused_models else None
            if pins is not None:
                answer = replace(
                    answer, refused_by=pins.installed, asked=pins.older(path, self._files[index].folder)
                )
            found[index] = answer
            alone = answer.refused_models or any(item.code == NOT_FOUND for item in answer.diagnostics)
            if alone and (self._files[index].named or self._files[index].folder is None):
                wholes = Around(path).wholes(INCLUDED)[:MOST_WHOLES]
                around.update((self._pool.add(one, False, None), (index, one)) for one in wholes)
            if progress is not None:
                progress(len(found), len(self._files))
        chosen, self.passed_over = _chosen(
            self._paths, self._files, found, self._skip_other, self.exclude, self._not_read
        )
        if not chosen:
            # Globs that are too wide would be a green check of nothing.
            gone = [path for path in self.named if path not in self._paths and os.path.isdir(path)]
            chosen += [_nothing_in(path, None) for path in gone]
        return tuple(with_names(chosen))


def expand(
    paths: Sequence[str],
    *,
    skip_other: bool = False,
    exclude: Callable[[str, bool], bool] = lambda path, named: False,
    not_read: dict[str, str] | None = None,
) -> tuple[NamedFile, ...]:
    """Put the files of a folder in its place: those with a known ending, by name, folders below it too.

    Hidden files and folders are passed over, links to folders are not followed, and a file that was
    there before is not taken again. A folder that cannot be listed stands for itself.

    Args:
        paths: Files and folders, as the user names them.
        skip_other: Pass over named files with another ending too.
        exclude: Whether to pass over a file or folder, by its path and whether it was named.
        not_read: Gets the files of the folders that describe a robot and are not read, with what they are.
    """
    found: dict[str, NamedFile] = {}
    for path in paths:
        if exclude(path, True):
            continue
        if not os.path.isdir(path):
            if not skip_other or _has_known_ending(path) or not os.path.exists(path):
                # Whoever names a file and its folder asks for the file.
                found[path] = replace(found.get(path, NamedFile(path)), named=True)
            continue
        shut: list[str] = []
        for full in files_in(path, exclude, shut.append):
            kind = NOT_READ.get(os.path.splitext(full)[1].lower())
            if kind is not None and not_read is not None and not exclude(full, False):
                not_read[full] = kind
            if _has_known_ending(full) and not exclude(full, False):
                found[full] = _in(found.get(full, NamedFile(full)), path)
        found.update((inside, _in(found.get(inside, NamedFile(inside)), path)) for inside in shut)
    return tuple(found.values())


def _in(file: NamedFile, folder: str) -> NamedFile:
    return replace(file, folders=(*file.folders, folder))


def _depth(folder: str) -> int:
    """Of folders that are in each other, `.` is the outermost."""
    folder = os.path.normpath(folder)
    return 0 if folder == os.curdir else len(folder)


def _is_below(path: str, folder: str) -> bool:
    """Whether a path is a folder's, or of something in it; both as `files_in` has them, `sim/a.xml` in `.`."""
    path, folder = os.path.normpath(path), os.path.normpath(folder)
    if folder == os.curdir:
        return not os.path.isabs(path) and path.split(os.sep)[0] != os.pardir
    return path == folder or path.startswith(os.path.join(folder, ""))


def _has_known_ending(path: str) -> bool:
    return split(path)[0].lower().endswith((*ROBOT, *PYTHON, *YAML))


def _lost(path: str, reason: str) -> FileReading:
    """A file that would perhaps have been read, but for a fault; that is reported wherever the file was found."""
    fault = Diagnostic(FAULT, Severity.ERROR, f"the file cannot be read: {reason}", "", Span(path))
    return FileReading(path, None, reason, diagnostics=(fault,))


def _shut(folder: str) -> FileReading:
    """A folder that cannot be listed: nobody knows what it has."""
    try:
        os.listdir(folder)
        reason = "it was not there for a moment"
    except OSError as err:
        reason = why(err)
    return _lost(folder, f"it is a folder that cannot be listed ({reason})")


def _idle(
    concerned: Sequence[tuple[NamedFile, FileReading]], exclude: Callable[[str, bool], bool] | None
) -> Idle:
    """What nobody runs of what concerns the audit in the folders that were named."""
    inside: dict[str, dict[str, FileReading]] = {}
    for file, reading in concerned:
        if file.folder is not None:
            inside.setdefault(file.folder, {})[file.path] = reading
    each = [idle(members, programs_in(folder, exclude)) for folder, members in inside.items()]
    return Idle(
        frozenset().union(*(one.models for one in each)),
        {path: nothing for one in each for path, nothing in one.run.items()},
        frozenset().union(*(one.written for one in each)),
        {path: names for one in each for path, names in one.configs.items()},
    )


def _chosen(
    paths: Sequence[str],
    files: Sequence[NamedFile],
    found: dict[int, FileReading],
    skip_other: bool,
    exclude: Callable[[str, bool], bool] | None,
    not_read: dict[str, str],
) -> tuple[list[FileReading], tuple[str, ...]]:
    """The readings without files that have nothing to do with actuators and that nobody named; and those files."""
    chosen, passed_over = [], []
    past = {index for index, file in enumerate(files) if found[index].record and _is_past(file, skip_other)}
    not_read.update((files[index].path, RECORD) for index in sorted(past))
    unread = {index for index, file in enumerate(files) if file.folder is not None and found[index].unread}
    not_read.update((files[index].path, found[index].unread) for index in sorted(unread))
    concerned = {
        index for index in range(len(files)) if index not in past | unread and _concerns(found[index])
    }
    empty = {path for path in paths if os.path.isdir(path)}
    empty.difference_update(
        *(file.folders for index, file in enumerate(files) if index in concerned or os.path.isdir(file.path))
    )
    seen = Counter(folder for file in files for folder in file.folders)
    idle_there = _idle([(files[index], found[index]) for index in concerned], exclude)
    for index, file in enumerate(files):
        if file.folder is not None and not found[index].readable and os.path.isdir(file.path):
            chosen.append(_shut(file.path))
            continue
        # A file that is not there was named by somebody.
        named = file.named and not (skip_other and os.path.exists(file.path))
        if named or index in concerned:
            reading = found[index]
            # Of a variant that its spec does not have the reading says so.
            there = reading.kind is FileKind.SPEC or os.path.exists(file.path)
            if not reading.readable and not there:
                reading = _nothing_at(file.path)
            if file.named or file.folder is None:
                chosen.append(reading)
                continue
            chosen.append(
                replace(
                    reading,
                    in_folder=True,
                    put_aside=bool(ASIDE.search(os.path.relpath(file.path, file.folder))),
                    unnamed=file.path in idle_there.models,
                    run=file.path in idle_there.run,
                    written=idle_there.written | idle_there.run.get(file.path, frozenset()),
                    idle=idle_there.configs.get(file.path, frozenset()),
                )
            )
        elif index not in past | unread:
            passed_over.append(file.path)
    for path in dict.fromkeys(paths):
        if path in empty:
            others = [kind for each, kind in not_read.items() if _is_below(each, path)]
            chosen.append(_nothing_in(path, seen[path], others))
    return chosen, tuple(passed_over)


def _is_past(file: NamedFile, skip_other: bool) -> bool:
    """Whether a run's record says what once was: a folder may have hundreds of runs. That of the folder is of today."""
    if file.named:
        return skip_other
    inside = os.path.relpath(file.path, file.folder).replace(os.sep, "/")
    return inside not in _RECORDS


def named_as_run(folder: str, called: str) -> str | None:
    """A help for a folder where a file is asked for: the record of the run that it is; None: it is none.

    Args:
        folder: It.
        called: As the user has it.
    """
    found = next((name for name in _RECORDS if os.path.isfile(os.path.join(folder, name))), None)
    return None if found is None else f"it is the folder of a run: name {os.path.join(called, found)}"


def _nothing_at(path: str) -> FileReading:
    """A name without a file."""
    reason, help = of_missing("there is no such file or folder", path)
    fault = Diagnostic("AUD016", Severity.ERROR, reason, "", Span(path), help)
    return FileReading(path, None, reason, diagnostics=(fault,))


def _nothing_in(folder: str, count: int | None, not_read: Sequence[str] = ()) -> FileReading:
    """A folder without anything to audit, of which that is said in place of that it cannot be read.

    Args:
        folder: As it was named.
        count: Its files with a known ending; None: what it has is passed over.
        not_read: What its files are that describe a robot and are not read.
    """
    endings = ", ".join((*ROBOT, *PYTHON, *YAML))
    reason = f"it has no file that ends in {endings}"
    if count is None:
        reason = "exclude leaves out all robot files, configurations, deploy files and specs of it"
    elif count:
        files = "file that ends" if count == 1 else "files that end"
        reason = (
            f"of its {count} {files} in {endings} none is a robot file, configuration, deploy file or spec"
        )
    help = "links to folders are not followed and hidden folders are passed over; name those"
    if count == 0 and (submodule := not_checked_out(os.path.normpath(folder), os.path.join(folder, "*"))):
        reason, help = str(submodule), submodule.help
    if count is None:
        help = "take a glob out of exclude, or the folder out of the command"
    elif not_read:
        reason += f"; {counted_not_read(not_read)}"
        help = "name the env.yaml of one" if RECORD in not_read else help
        if XACRO_FILE in not_read:
            from actspec.robot.read_urdf import EXPAND as help
    return nothing_to_audit(folder, reason, help, " in this folder")


def counted_not_read(kinds: Sequence[str]) -> str:
    """How many files are not read, by what each of them is: `1 xacro file, 3 USD files not read`."""
    known = {**{kind: f"{kind} file" for kind in (*NOT_READ.values(), TEMPLATE, EMPTY)}, RECORD: RECORD}
    return (
        f"{listed(many(kinds.count(kind), word) for kind, word in known.items() if kind in kinds)} not read"
    )


def _concerns(reading: FileReading) -> bool:
    """Whether a file that was found in a folder has something to audit, or would have if it could be read."""
    if reading.artifacts or reading.kind in (FileKind.MJCF, FileKind.URDF, FileKind.SPEC):
        return True
    if any(item.code == FAULT for item in reading.diagnostics):
        return True
    if not reading.files:
        # What may not be opened can be anything that its ending says.
        return os.path.isfile(reading.path) and not os.access(reading.path, os.R_OK)
    # Of UTF-16 the letters, which are what tells.
    texts = [file.data.replace(b"\0", b"") for file in reading.files]
    lower = reading.path.lower()
    if lower.endswith(PYTHON):
        # Of one that was read it is said that it has no actuators.
        return not reading.diagnostics and any(_ROBOT_CODE.search(text) for text in texts)
    if split(lower)[0].endswith(YAML):
        from actspec.readings.deploy import names_gains

        return reading.refused is not None and not reading.without_gains and any(map(names_gains, texts))
    own = lower.endswith(ROBOT_ALONE)
    return reading.kind is None and any(
        (own or ROBOT_ROOT.search(text)) and not _OTHER_ROBOT.search(text) for text in texts
    )
