"""Which MuJoCo a project asks for: what it requires, builds with and imports, as text, of which nothing is run."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass

from actspec.diagnostics import Span
from actspec.files import FAULTS, folders_in, in_repository, place_of, read_regular
from actspec.simulators import Release, release

_REQUIREMENTS = re.compile(
    r"[\w.-]*requirements[\w.-]*\.(?:txt|in)|setup\.(?:py|cfg)|pyproject\.toml"
    r"|[\w.-]*(?:conda|env(?:ironment)?)[\w.-]*\.ya?ml",
    re.IGNORECASE,
)
"""Files in which a project says what it needs."""
_BUILDING = re.compile(r"CMakeLists\.txt|(?:GNU)?makefile", re.IGNORECASE)
"""Files that say which folder of a release a program is built with."""

_MOST_FILES = 200
"""Files of a folder that are looked at. Chosen: as of models around a part."""
_MOST_FOLDERS = 50
"""Folders beside a file's own that are looked at in each folder above it. Chosen: packages of a large repository."""
_MOST_BYTES = 1024 * 1024
"""Chosen: larger than any list of requirements, and than nearly all programs."""
_MOST_CLAUSES = 8
"""Clauses of a requirement. Chosen: `>=2.1,<2.2` has two."""

_REMARK = re.compile(rb"(?:^|(?<=\s))#[^\n]*", re.MULTILINE)
_VERSION = rb"\d[\w.*+!-]{0,40}"
_BLANK = rb"[ \t]{0,9}"
_CLAUSES = rb"(?:(?:===?|~=|!=|[<>]=?|[\^~])%b%b%b,?%b){1,%d}" % (
    _BLANK,
    _VERSION,
    _BLANK,
    _BLANK,
    _MOST_CLAUSES,
)
_REQUIRED = re.compile(
    rb"""(?:^[ \t]*(?:-[ \t]+)?|["'])(?P<name>(?:free-)?mujoco[-_.]py|mujoco|dm[-_]control)(?![\w.-])"""
    rb"""(?:\[[^\]\n]{0,99}\])?"""
    rb"""%(blank)b(?:\(?(?P<clauses>%(clauses)b)|=%(blank)b(?P<conda>%(version)b)"""
    # Poetry has the version as the key's value.
    rb"""|=%(blank)b(?:\{[^}\n]{0,99}?\bversion%(blank)b=%(blank)b)?["'](?P<poetry>%(clauses)b|%(version)b)["']"""
    # The key of a list of extras asks for nothing.
    rb"""|["'](?!%(blank)b[:=])|(?=[\r\n;@,]|\Z))"""
    % {b"blank": _BLANK, b"clauses": _CLAUSES, b"version": _VERSION},
    re.MULTILINE | re.IGNORECASE,
)
_CLAUSE = re.compile(r"(===?|~=|!=|[<>]=?|[\^~])\s*(\d+(?:\.\d+)*)")
_IMPORT = re.compile(
    rb"^[ \t]*(?:import[ \t]+(?:[\w.]+(?:[ \t]+as[ \t]+\w+)?[ \t]*,[ \t]*)*|from[ \t]+)"
    rb"(?P<name>mujoco(?:_py)?|gym\.envs\.mujoco)\b",
    re.MULTILINE,
)
_BUILT_WITH = re.compile(
    rb"(?<![\w.-])(?P<name>mujoco(?:[-_]?(?P<version>\d{1,3}(?:\.\d{1,3}){1,2})|(?P<digits>\d{3})))(?!\w|\.\d)",
    re.IGNORECASE,
)
"""A folder of a release, as its archive has it: `mujoco-2.3.1`, and `mujoco210` until 2.1.0."""


@dataclass(frozen=True, slots=True)
class Asked:
    """What a project asks for that an installed MuJoCo is too new for.

    Attributes:
        place: Where it says so.
        text: `mujoco==2.3.7`, `mujoco_py<2.0`; of a program `mujoco_py`; of what it is built with `mujoco-2.3.1`.
        verb: How: `asks for`, `imports` or `builds with`.
    """

    place: Span
    text: str
    verb: str

    @property
    def told(self) -> str:
        """`requirements.txt:3 asks for mujoco==2.3.7, which may take it`."""
        # Source: the releases of mujoco-py, 1.50 to 2.1.2.14; their build looks for MuJoCo 1.50, 2.0 and 2.1.0.
        # Source: gym 0.26 is the first whose environments have MuJoCo's own bindings.
        whose = "whose MuJoCo, 2.1 or older," if _is_wrapper(self.text) else "which"
        whose = "whose MuJoCo" if _is_suite(self.text) else whose
        return f"{self.place} {self.verb} {self.text}, {whose} may take it"


@dataclass(frozen=True, slots=True)
class _Said:
    """One statement: `clauses` are as pip writes them, "" without a version; `text` is what is told."""

    place: Span
    name: str
    clauses: str
    text: str
    verb: str

    @property
    def asked(self) -> Asked:
        return Asked(self.place, self.text, self.verb)


class Pins:
    """What the folders of an audit ask for; each is looked at once."""

    def __init__(self, installed: Release) -> None:
        """Of the MuJoCo that is installed, with all its numbers."""
        self.installed = installed
        self._folders: dict[str, tuple[_Said, ...]] = {}
        self._inner: dict[str, tuple[_Said, ...]] = {}

    def older(self, path: str, named: str | None = None) -> Asked | None:
        """What a file's project asks for that the installed MuJoCo is too new for; None: nothing says so.

        The nearest folder with a version decides, from the file's own up to its repository's. What asks for mujoco_py
        has one of MuJoCo's first releases, unless something on the way asks for, or imports, MuJoCo itself.

        Where these say nothing, what is required in the folders beside them counts, of the same repository or named
        folder, if all that is required there is too old: a repository of several packages has the models in one.

        Args:
            path: The file as the user named it.
            named: The folder that the user named and that it is in; None: the file itself.
        """
        itself = False
        folders = list(in_repository(path))
        repository = os.path.lexists(os.path.join(folders[-1], ".git"))
        if (
            named is not None
            and not repository
            and os.path.abspath(named) not in map(os.path.abspath, folders)
        ):
            # A model may lie deeper in it than one looks up.
            folders.append(named)
        for folder in folders:
            said = self._in(folder)
            own = [one for one in said if not _is_wrapper(one.name)]
            versions = [one for one in own if one.clauses]
            # dm_control comes with a MuJoCo of its day, unless another is asked for.
            versions = [one for one in versions if not _is_suite(one.name)] or versions
            if versions:
                old = (one for one in versions if _is_older(one.clauses, self.installed))
                return next((one.asked for one in old), None)
            itself = itself or bool(own)
            wrapper = next((one for one in said if _is_wrapper(one.name)), None)
            if wrapper is not None and not itself:
                return wrapper.asked
        if not repository:
            # What is beside them up there is somebody's other projects.
            paths = [os.path.abspath(one) for one in folders]
            root = "" if named is None else os.path.abspath(named)
            folders = folders[: paths.index(root) + 1] if root in paths else []
        for folder in folders[1:]:
            if beside := self._beside(folder):
                all_old = all(_is_older(one.clauses, self.installed) for one in beside)
                return beside[0].asked if all_old else None
        return None

    def _beside(self, folder: str) -> tuple[_Said, ...]:
        """The versions of MuJoCo itself that are required in the folders of one, but for submodules: other projects."""
        where = os.path.abspath(folder)
        if where not in self._inner:
            self._inner[where] = tuple(
                said
                for one in folders_in(folder)[:_MOST_FOLDERS]
                if not os.path.lexists(os.path.join(one, ".git"))
                for said in _statements(one, programs=False)
                if said.clauses and not _is_wrapper(said.name)
            )
        return self._inner[where]

    def _in(self, folder: str) -> tuple[_Said, ...]:
        where = os.path.abspath(folder)
        if where not in self._folders:
            self._folders[where] = tuple(_statements(folder))
        return self._folders[where]


def pins_here() -> Pins | None:
    """`Pins` for the MuJoCo that is installed here, which is not imported; None: nobody knows which it is."""
    from importlib import metadata

    try:
        found = re.match(r"\d+(?:\.\d+)*", metadata.version("mujoco"))
    except metadata.PackageNotFoundError:
        return None
    return None if found is None else Pins(release(found[0]))


def _is_wrapper(name: str) -> bool:
    """Whether a package is mujoco_py, under one of its names, of whatever version, or gym, which runs it."""
    return re.match(r"(?:free-)?mujoco[-_.]py|gym\.", name, re.IGNORECASE) is not None


def _is_suite(name: str) -> bool:
    return re.match(r"dm[-_]control", name, re.IGNORECASE) is not None


def _statements(folder: str, *, programs: bool = True) -> Iterator[_Said]:
    """What the files of one folder say, requirements before programs."""
    try:
        names = sorted(os.listdir(folder or os.curdir))
    except (OSError, ValueError):
        return
    asking = [name for name in names if _REQUIREMENTS.fullmatch(name)]
    building = [name for name in names if _BUILDING.fullmatch(name)]
    running = [name for name in names if name.lower().endswith(".py") and name not in asking]
    for name in (*asking, *building, *(running if programs else ()))[:_MOST_FILES]:
        path = os.path.normpath(os.path.join(folder, name))
        try:
            # A link leads to another project. pip takes UTF-16 as PowerShell writes it: the letters tell.
            data = b"" if os.path.islink(path) else read_regular(path, _MOST_BYTES).replace(b"\0", b"")
        except FAULTS:
            continue
        if not re.search(rb"mujoco|dm[-_]control", data, re.IGNORECASE):
            continue
        text = _REMARK.sub(b"", data)
        kind = _REQUIRED if name in asking else _BUILT_WITH if name in building else _IMPORT
        for found in kind.finditer(text):
            place, what = Span(path, place_of(text, found.start("name"))[0]), found["name"].decode("ascii")
            if kind is _REQUIRED:
                clauses = _clauses(found)
                if _is_suite(what) and all(one[1][0] in ">!" for one in _CLAUSE.finditer(clauses)):
                    # No release of it in particular.
                    continue
                yield _Said(place, what, clauses, what + clauses, "asks for")
            elif kind is _BUILT_WITH:
                # `210` is 2.1.0.
                version = (found["version"] or b".".join(re.findall(rb"\d", found["digits"]))).decode("ascii")
                yield _Said(place, what, f"=={version}", what, "builds with")
            else:
                yield _Said(place, what, "", what, "imports")


def _clauses(found: re.Match[bytes]) -> str:
    """The versions of a requirement as pip writes them; "" for any."""
    text = (
        (found["clauses"] or found["poetry"] or found["conda"] or b"")
        .decode("ascii", "replace")
        .strip(", \t")
    )
    return f"=={text}" if text[:1].isdigit() else text


def _is_older(clauses: str, installed: Release) -> bool:
    """Whether a requirement leaves the installed release out because it is too new."""
    return any(_excludes(clause[1], clause[2], installed) for clause in _CLAUSE.finditer(clauses))


def _excludes(sign: str, number: str, installed: Release) -> bool:
    limit = tuple(int(part) for part in number.split("."))
    if sign == "<":
        return installed >= limit
    if sign == "~=":
        limit = limit[:-1]
    elif sign == "^":
        limit = limit[:1]
    elif sign == "~":
        limit = limit[:2]
    elif sign not in ("<=", "==", "==="):
        return False
    return installed[: len(limit)] > limit
