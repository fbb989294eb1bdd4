"""What the programs of a folder name of its models and configurations: what they do not, beside others, nobody runs."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from actspec.files import NotRegular, TooLarge, in_common, in_repository, read_regular
from actspec.readings.artifact import FileKind, FileReading
from actspec.readings.gym_tasks import no_tasks
from actspec.readings.idle_configs import configs_in, folders_of, idle_configs, stem_of
from actspec.readings.loads import what_loads
from actspec.readings.written_over import (
    GAZEBO,
    Loader,
    nothing_to,
    poses_alone,
    simulators_of,
    works_on_files,
    written_over,
)

_HASH = re.compile(rb"^[ \t]*#[^\n]*", re.MULTILINE)
_SLASHES = re.compile(rb"/\*.*?\*/|(?<![:\w\"'])//[^\n]*", re.DOTALL)
_MARKUP = re.compile(rb"<!--.*?-->", re.DOTALL)

_COMMENTS: dict[str, re.Pattern[bytes]] = {
    **dict.fromkeys(
        (".py", ".ipynb", ".jl", ".yaml", ".yml", ".toml", ".cfg", ".ini", ".sh", ".bash"), _HASH
    ),
    **dict.fromkeys(
        (".c", ".cc", ".cpp", ".cxx", ".h", ".hh", ".hpp", ".hxx", ".cu", ".rs", ".js", ".ts", ".json"),
        _SLASHES,
    ),
    **dict.fromkeys((".launch", ".xacro", ".sdf", ".world"), _MARKUP),
}
"""Endings of files that run or set up something, and what a comment looks like in them."""

_NO_PROGRAMS = ("setup.py", "setup.cfg", "pyproject.toml", "mkdocs.yml")
"""They name what they install or show, all of it."""

_EXPORTED = frozenset(("display.launch", "gazebo.launch"))
"""Written by a CAD exporter beside its URDF, both of them, and run by nobody who has written another program.

Source: SolidWorks to URDF exporter."""

_MODEL_NAME = re.compile(rb"[\w.+-]+\.(?:urdf|xml|mjcf)")
_REFERENCE = re.compile(rb"\.(?:(?:urdf|xml|mjcf)\.(?=xacro))?(urdf|xml|mjcf|usd[acz]?|xacro)\b")
_ENDINGS = (b"urdf", b"xml", b"mjcf")
"""Of models that are read."""

_EVERY = b".*"
_MADE = rb"\{[^{}\n]*\}|%[sd]|\*"
_BEFORE_ENDING = re.compile(rb"""(\+\s*f?["'])?((?:[\w.+/\\-]|""" + _MADE + rb")*)$")
"""What a name begins with, and whether something is put before that when the program runs: robot + "_v2"."""

_JOINED = re.compile(rb"""["']\s*\)?\s*[,/]\s*f?["']""")
"""Between the parts of a path: os.path.join("dog", "scene.xml"), ROOT / "dog" / "scene.xml", join(at("x"), "a.xml")."""

_FOUND = re.compile(rb"\$\(find(?:-pkg-share)?\s+([\w.-]+)\)")
"""A package's folder in a launch file or xacro."""

_LOOKED_FOR = re.compile(rb"""-i?name\s+(["'])[^"'\n]*\1""")
"""A pattern of the command `find`, which runs nothing."""

_OWN = re.compile(rb"""\A\s*\{\s*"format"\s*:\s*"actspec-""")
"""How a baseline, lock or report of actspec begins: it names what was audited, and runs nothing."""

_MOST_NAME = 200
"""Chosen: bytes before the ending of a name that are looked at."""

_MOST_PROGRAM = 1024 * 1024
"""Chosen: bytes of a program that are looked through."""

_NOT_THERE = re.compile(r"the include cannot be followed: there is no (?:file|folder) '([^']*)'")

_BRINGS = re.compile(
    rb"\b(?:from_xml_(?:string|path)|MjSpec\.from_(?:string|file))\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*,\s*"
    rb"(?:(?:assets|include)\s*=(?!\s*(?:None\b|\{\s*\}))|(?:\w+\.)?(?i:\w*assets)\b(?![\"'/]|\s*=))"
    rb"|[\"'][ \t]*<include[ \t]+file=\\?[\"'][^\"'\n]*[{%]"
)
_ARCHIVES = (".zip", ".tar", ".tar.gz", ".tgz", ".7z", ".rar")

_OF_ANY_ROBOT = frozenset(
    (
        b"",
        b"assets",
        b"description",
        b"mjcf",
        b"model",
        b"models",
        b"mujoco",
        b"robot",
        b"robots",
        b"urdf",
        b"xml",
        b"xmls",
    )
)
"""Names of folders that do not tell a robot."""

ASIDE = re.compile(
    r"(?<![a-z])(?:archived?|before|old|bak|backup|copy|deprecated|legacy|obsolete|retired|unused|debug|dump|error)(?![a-z])"
    r"|(?:^|[/\\])(?:third[_-]?party|(?:site|dist)-packages|3rd[_-]?party|externals?|vendor|tests?|test_?(?:data|assets)|fixtures|attic|te?mp|(?:inverse_?)?kinematics|ik|\w*pinocchio)[/\\]"
    r"|_test\.(?:xml|urdf|mjcf)$"
    # No program can import it: `leg_cfg (1).py`, a copy that an editor made.
    r"|\s[^/\\]*\.py$",
    re.IGNORECASE,
)
"""Words by which files and folders say that nobody runs them on a robot, or steps them at all."""


@dataclass(frozen=True, slots=True)
class Idle:
    """What nobody runs.

    Attributes:
        models: Paths of models that no program names, nor a model that one names, where programs name others; a program
            that only asks where the links are counts for nothing.
        run: Paths of the models that they write out, and of those that these name; each with what is nothing to the
            simulators of the programs that name it.
        written: Figures of models that programs write over.
        configs: Path to the configurations that stand there alone, where a program imports others.
    """

    models: frozenset[str] = frozenset()
    run: Mapping[str, frozenset[str]] = field(default_factory=dict)
    written: frozenset[str] = frozenset()
    configs: Mapping[str, frozenset[str]] = field(default_factory=dict)


def files_in(
    folder: str,
    exclude: Callable[[str, bool], bool] | None,
    refused: Callable[[str], None] = lambda path: None,
) -> Iterator[str]:
    """Files of a folder and of those below it, by name; hidden ones are passed over, links to folders not followed.

    Args:
        folder: As the user named it.
        exclude: Whether to pass over a folder below it, by its path and whether it was named.
        refused: Gets a folder that cannot be listed.
    """
    for inside, folders, names in os.walk(folder, onerror=lambda err: refused(str(err.filename))):
        # `sim/a.xml` and not `./sim/a.xml`, as what it includes or imports is named.
        inside = os.path.normpath(inside) if os.path.normpath(folder) == os.curdir else inside
        folders[:] = sorted(
            name
            for name in folders
            if not (
                name.startswith(".") or (exclude is not None and exclude(os.path.join(inside, name), False))
            )
        )
        for name in sorted(names):
            if not name.startswith("."):
                yield name if inside == os.curdir else os.path.join(inside, name)


def programs_in(folder: str, exclude: Callable[[str, bool], bool] | None) -> tuple[str, ...]:
    """Files of a folder that may run or set up something, but for those that call themselves old or a test.

    Args:
        folder: As the user named it.
        exclude: As in `files_in`.
    """
    return tuple(
        path
        for path in files_in(folder, exclude)
        if os.path.splitext(path)[1].lower() in (*_COMMENTS, ".xml")
        and os.path.basename(path) not in _NO_PROGRAMS
        and not ASIDE.search(os.path.relpath(path, folder))
    )


def idle(members: Mapping[str, FileReading], programs: Sequence[str]) -> Idle:
    """What nothing in a folder names.

    Args:
        members: Path to what was read, for all files of the folder that may have to do with a robot.
        programs: Files of the folder that may run or set up something; an XML file that is none is passed over.
    """
    if any(reading.kind is FileKind.SPEC for reading in members.values()):
        # A spec is there for every file of its robot.
        return Idle()
    models = {
        path
        for path, reading in members.items()
        # What cannot be read has no kind.
        if reading.kind in (FileKind.MJCF, FileKind.URDF) or (reading.kind is None and not reading.readable)
    }
    configs = {path: names for path, reading in members.items() if (names := configs_in(reading))}
    if not models and not configs:
        return Idle()
    kinds = {path: reading.kind for path, reading in members.items()}
    texts = dict(_texts(path for path in programs if kinds.get(path) not in (FileKind.MJCF, FileKind.URDF)))
    others = any(True for path, text in texts.items() if path not in configs for _ in _names(text))
    alone = idle_configs(configs, texts, others)
    for path, names in no_tasks(members, texts).items():
        alone[path] = alone.get(path, frozenset()) | names
    # A configuration that nobody runs runs no model.
    running = {
        path: text for path, text in texts.items() if alone.get(path) != configs.get(path, frozenset())
    }
    own = _Models(models, running)
    run, surely = own.run(), own.surely_run()
    # A list of what is there, or of what a run wrote, is of no simulator.
    of = {path: simulators_of(text) for path, text in texts.items() if not path.endswith(".json")}
    # Gazebo reads no MJCF.
    whose = {path: of.get(path, frozenset()) - {GAZEBO} for path in running.keys() - own.still - own.exported}
    handed = frozenset().union(*(whose[path] for path in whose.keys() & own.nameless))
    # One that names its own models takes no other's, unless there is nobody else.
    takers = handed or frozenset().union(*whose.values())
    loaders = {
        path: Loader.of(texts[path], of.get(path, frozenset()))
        for path in frozenset().union(*surely.values())
    }
    by = {path: [loaders[program] for program in sorted(programs)] for path, programs in surely.items()}
    return Idle(
        frozenset() if run is None else frozenset(models) - run,
        {
            # Of a URDF nobody guesses who takes it.
            path: nothing_to(each, takers if kinds[path] is not FileKind.URDF else frozenset())
            for path, each in by.items()
            if not _is_brought(members[path], each, _around(surely[path], texts), texts.values())
        },
        written_over(
            [text for path, text in texts.items() if path not in own.exported],
            frozenset().union(*(each for path, each in of.items() if path not in own.exported)),
        ),
        {path: frozenset(name.decode() for name in names) for path, names in alone.items()},
    )


def _texts(programs: Iterable[str]) -> Iterator[tuple[str, bytes]]:
    """Programs without their comments; of XML files those of a launch, and nothing that actspec wrote."""
    for path in programs:
        text = _read(path)
        ending = os.path.splitext(path)[1].lower()
        if _OWN.match(text):
            continue
        if ending == ".ipynb":
            text = _code(text)
        if ending != ".xml":
            yield path, _COMMENTS[ending].sub(b"", text)
        elif b"<launch" in text:
            yield path, _MARKUP.sub(b"", text)


def _code(notebook: bytes) -> bytes:
    """The code of a notebook's cells, without what these have printed; of what is no notebook all of it."""
    try:
        cells = json.loads(notebook)["cells"]
        return "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code").encode()
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return notebook


@dataclass(frozen=True, slots=True)
class _Name:
    """A name of a model, as a file has it.

    Attributes:
        stem: Of the file without its ending; None where nothing of it is written down.
        literal: Whether all of it is.
        ending: Of a model, a USD or a xacro, without the dot.
        folders: What is written before it, the closest folder first.
    """

    stem: re.Pattern[bytes] | None
    literal: bytes | None
    ending: bytes
    folders: tuple[bytes, ...]


def _names(text: bytes) -> Iterator[_Name]:
    """What looks like a name of a model; a part that is put together when the program runs is a pattern."""
    text = _FOUND.sub(rb"\1", _JOINED.sub(b"/", _LOOKED_FOR.sub(b"", text)))
    for ending in _REFERENCE.finditer(text):
        at = ending.start()
        found = _BEFORE_ENDING.search(text[max(at - _MOST_NAME, 0) : at])
        # It matches the empty text too.
        assert found is not None
        *before, stem = re.split(rb"[/\\]+", found[2])
        folders = []
        for name in reversed(before):
            if name in (b"", b".", b"..") or re.search(_MADE, name):
                break
            folders.append(name)
        added = found[1] is not None and not before
        parts = re.split(_MADE, stem)
        literal = stem if len(parts) == 1 and not added else None
        pattern = (_EVERY if added else b"") + _EVERY.join(map(re.escape, parts))
        # Of a glob it is every one.
        tells = any(parts) or b"*" in stem
        if literal != b"":
            yield _Name(re.compile(pattern) if tells else None, literal, ending[1], tuple(folders))


class _Models:
    """The models of a folder and what its programs name of them."""

    def __init__(self, paths: Collection[str], programs: Mapping[str, bytes]) -> None:
        self.paths, self.programs, self.still = paths, programs, poses_alone(programs)
        self.by_stem: dict[bytes, list[str]] = {}
        self.parts: dict[str, frozenset[str]] = {}
        for path in sorted(paths):
            self.by_stem.setdefault(stem_of(path), []).append(path)

    def run(self) -> frozenset[str] | None:
        """Those that may be named to be run; None where no program names a model or a USD."""
        named: set[str] = set()
        others = False
        for program, names in self._named.items():
            for name in names if program not in self.exported else ():
                others = others or (name.ending.startswith(b"usd") and program.endswith(".py"))
                meant = self._meant(name, program)
                if program not in self.still:
                    named.update(meant)
                others = others or bool(meant)
        named |= self._spelt_out()
        if not named and not others:
            named = {
                path
                for program in self.exported
                for name in self._named[program]
                for path in self._meant(name, program)
            }
            if not named:
                return None
        return self._with_parts(named)

    def surely_run(self) -> dict[str, frozenset[str]]:
        """Those that a program writes out to be run, by a name that no other model there has, with these programs.

        Not what is made of a USD or a xacro that one names, which may have been written before, nor what it opens as
        text, only speaks of, or works on and does not simulate, nor a model of elsewhere.
        """
        by: dict[str, set[str]] = {}
        for program, text in self.programs.items():
            # Of thousands of programs few name a model.
            if not self._named[program] or program in self.still | self.exported or works_on_files(text):
                continue
            for name in _names(what_loads(os.path.splitext(program)[1].lower(), text)):
                if (
                    name.literal is not None
                    and name.ending in _ENDINGS
                    and len(meant := self._meant(name, program)) == 1
                    and _may_be(meant[0], name.folders)
                ):
                    by.setdefault(meant[0], set()).add(program)
        found: dict[str, frozenset[str]] = {}
        for path, programs in by.items():
            for part in self._with_parts([path]):
                found[part] = found.get(part, frozenset()) | programs
        return found

    @cached_property
    def nameless(self) -> frozenset[str]:
        """Programs that name no model themselves."""
        return frozenset(program for program, names in self._named.items() if not names)

    @cached_property
    def _named(self) -> dict[str, tuple[_Name, ...]]:
        """What looks like the name of a model in each program."""
        return {program: tuple(_names(text)) for program, text in self.programs.items()}

    def _with_parts(self, named: Collection[str]) -> frozenset[str]:
        """Models with what they include: of a scene that is run these are, too."""
        found = set(named)
        left = sorted(found)
        while left:
            more = self._parts(left.pop()) - found
            left += sorted(more)
            found |= more
        return frozenset(found)

    def _parts(self, path: str) -> frozenset[str]:
        """The models that a model's own file names."""
        if path not in self.parts:
            names = _names(_MARKUP.sub(b"", _read(path)))
            self.parts[path] = frozenset(part for name in names for part in self._meant(name, path))
        return self.parts[path]

    @cached_property
    def exported(self) -> frozenset[str]:
        """Launch files that an exporter wrote."""
        return frozenset(path for path in self.programs if self._is_exported(path))

    def _is_exported(self, program: str) -> bool:
        """Whether a launch file is one of the two that an exporter wrote."""
        folder, name = os.path.split(program)
        return name in _EXPORTED and all(os.path.join(folder, other) in self.programs for other in _EXPORTED)

    def _spelt_out(self) -> set[str]:
        """Models with a space in their name, or a letter beyond ASCII, that a program has."""
        unusual = {path: os.fsencode(os.path.basename(path)) for path in self.paths}
        return {
            path
            for path, name in unusual.items()
            if not _MODEL_NAME.fullmatch(name) and any(name in text for text in self.programs.values())
        }

    def _meant(self, name: _Name, by: str) -> Sequence[str]:
        """The models that a name in a file may stand for."""
        if name.literal is not None:
            found = self.by_stem.get(name.literal, [])
        elif name.stem is not None:
            found = [
                path for stem, paths in self.by_stem.items() if name.stem.fullmatch(stem) for path in paths
            ]
            if name.stem.pattern == _EVERY and not name.folders:
                found = [path for path in found if self._may_be_globbed(path, by)]
        else:
            # It may be any of which the programs speak.
            found = [path for stem, paths in self.by_stem.items() if stem in self.words for path in paths]
        if name.ending in _ENDINGS:
            ending = "." + name.ending.decode()
            found = [path for path in found if path.endswith(ending)]
        elif name.ending == b"xacro" and name.literal is not None and not by.endswith(".xacro"):
            found = [*found, *self._made_of(name)]
        return _closest(found, name.folders, by, self.words) if len(found) > 1 else found

    def _may_be_globbed(self, path: str, by: str) -> bool:
        """Whether a glob of which no folder is written may be of a model's: one that its program names, or its own."""
        if stem_of(path) in self.words or os.path.dirname(path) == os.path.dirname(by):
            return True
        named = self._word.findall(self.programs.get(by, b""))
        return any(folder in named for folder in folders_of(path))

    def _made_of(self, name: _Name) -> list[str]:
        """URDFs beside a xacro: they were made of it."""
        assert name.literal is not None
        file = name.literal + b".xacro"
        beside = {
            os.path.dirname(path) for path in self.programs if os.fsencode(os.path.basename(path)) == file
        }
        return [path for path in self.paths if path.endswith(".urdf") and os.path.dirname(path) in beside]

    @cached_property
    def _word(self) -> re.Pattern[bytes]:
        """The names of models and of their folders."""
        known = {*self.by_stem, *(name for path in self.paths for name in folders_of(path))} - {b""}
        return re.compile(
            rb"(?<!\w)(?:" + b"|".join(map(re.escape, sorted(known, key=len, reverse=True))) + rb")(?!\w)"
        )

    @cached_property
    def words(self) -> frozenset[bytes]:
        """Of the names of models and of their folders, those of which programs speak that may run one."""
        texts = (text for program, text in self.programs.items() if program not in self.still)
        return frozenset(word for text in texts for word in self._word.findall(text))


def _closest(
    paths: Sequence[str], folders: Sequence[bytes], by: str, words: Collection[bytes]
) -> Sequence[str]:
    """Of models with one name those that are meant: by the folders that stand before it, else by where it is used."""
    agree = {path: in_common(folders_of(path), folders) for path in paths}
    most = max(agree.values())
    if most:
        paths = [path for path in paths if agree[path] == most]
        if any(name not in _OF_ANY_ROBOT for name in folders[:most]):
            return paths
    beside = [path for path in paths if os.path.dirname(path) == os.path.dirname(by)]
    return beside or [path for path in paths if _own_folder(path) in words] or paths


def _around(programs: Collection[str], texts: Mapping[str, bytes]) -> Iterator[bytes]:
    """The programs in the folders of some, and above these: of another package's they use nothing."""
    folders = {os.path.dirname(path) for path in programs}
    for path, text in texts.items():
        own = os.path.dirname(path)
        if any(folder == own or folder.startswith(os.path.join(own, "")) for folder in folders):
            yield text


def _is_brought(
    reading: FileReading, loaders: Collection[Loader], around: Iterable[bytes], texts: Collection[bytes]
) -> bool:
    """Whether a program may bring what a model includes and nobody finds: it speaks of it, or has the suite's files.

    Or it hands files to MuJoCo beside the model, or writes what includes them, or hands on the model's text: of that
    MuJoCo looks in the folder that the program works in. Or a step of the set-up does, for what git ignores.
    """
    missing = _NOT_THERE.search(reading.reason or "")
    if missing is None:
        return False
    if all(one.reads for one in loaders) or _is_ignored(reading.path, missing[1]):
        return True
    if any(map(_BRINGS.search, around)) or any(
        os.path.exists(os.path.join(os.path.dirname(reading.path), missing[1] + ending))
        for ending in _ARCHIVES
    ):
        return True
    if missing[1] == "./common":
        return any(b"dm_control.suite" in text for text in texts)
    name = os.path.basename(missing[1])
    wanted = re.compile(rb"(?<![\w.-])" + re.escape(os.fsencode(name)))
    return "." in name and any(map(wanted.search, texts))


def _is_ignored(path: str, name: str) -> bool:
    """Whether git ignores a file or folder that a model names, by a line with the name of it or of a folder of it."""
    names = {part for part in re.split(r"[/\\]", name) if part not in ("", os.curdir, os.pardir)}
    files = (_read(os.path.join(folder, ".gitignore")) for folder in in_repository(path))
    lines = (os.fsdecode(line.strip(b"/* \t")) for text in files for line in text.splitlines())
    return any(os.path.basename(line) in names for line in lines)


def _may_be(path: str, folders: Sequence[bytes]) -> bool:
    """Whether a model is in a folder of its name, where one tells the robot: a menagerie's go2.xml is another one."""
    own, telling = folders_of(path), [name for name in folders if name.lower() not in _OF_ANY_ROBOT]
    return not telling or in_common(own, folders) > 0 or any(name in own for name in telling)


def _own_folder(path: str) -> bytes:
    """The closest folder that may tell the robot."""
    return next((name for name in folders_of(path) if name.lower() not in _OF_ANY_ROBOT), b"")


def _read(path: str) -> bytes:
    try:
        return read_regular(path, _MOST_PROGRAM)
    except (OSError, ValueError, NotRegular, TooLarge):
        return b""
