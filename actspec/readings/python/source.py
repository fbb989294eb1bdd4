"""Python files as text: decoding, parsing, and which file an import names. Nothing is imported or executed.

An import is followed to files of the named file's own tree only: below the topmost package that it is in, or beside
it when its folder is none. Each folder of that tree above a file may be where its program is started, so that
`from robot import gains` is followed in a folder `robot` without `__init__.py`, too. Files that a symbolic link leads
to from there to elsewhere are not read. Of a fork of Isaac Lab the actuators that it has added are, which stand in a
folder beside that of its robots. For import, a name that is in none of these is that of the one other file that the
user names and that defines it, whatever package it is imported from.
"""

from __future__ import annotations

import ast
import codecs
import os
import re
import sys
import warnings
from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from actspec.diagnostics import Span, one_line
from actspec.files import NotRegular, TooLarge, leads_into, place_of, read_regular

MAX_BYTES = 1 << 20
"""Size of one file [bytes]. Chosen: ten times the largest configuration that we know."""

MAX_TREE_BYTES = 4 << 20
"""Size of all files of one reading [bytes]. Chosen: parsing takes about a hundred times that in memory."""

MAX_FILES = 100
"""Files that one reading opens. Chosen: imports are followed when used, real tasks need about 10."""

MAX_LEVELS = 32
"""Nested packages. Chosen: far above any."""

MAX_GAP = 2
"""Folders without `__init__.py` between a file and the package that it belongs to. Chosen: unitree_rl_lab has two."""

OUTSIDE = "is not beside this file"
"""Why a module is not read whose file is not there."""
FRAMEWORKS = {"mjlab": ("asset_zoo", "tasks"), "isaaclab": (), "omni": ()}
"""Frameworks' own packages, and what of them describes robots: the rest is known here by its names alone."""

_ACTUATORS = ("isaaclab.actuators", "omni.isaac.lab.actuators")
"""Packages of Isaac Lab that a fork adds actuators to."""

_BESIDE = 3
"""Folders above the topmost package in which a fork's is looked for. Source: Isaac Lab 2.x (source/isaaclab beside
source/isaaclab_assets) has one, 1.x (omni.isaac.lab beside omni.isaac.lab_assets/omni/isaac) three."""

_CODECS = re.compile(
    r"utf-?8(-sig)?|us-ascii|ascii|latin-?1|iso-?8859-?\d{1,2}|(cp|windows-?)\d{3,5}|gbk|gb2312|gb18030|big5(-?hkscs)?"
    r"|shift-?jis|euc-?(jp|kr|cn)|koi8-?[ru]|mac-?roman",
    re.IGNORECASE,
)
"""Encodings that are decoded. Chosen: those of texts; others (punycode) take quadratic time."""


class UnreadableError(Exception):
    """A file cannot be read or parsed; the text says why.

    Attributes:
        at: Line and column, from 1; 0 where there is none.
        data: What was read of it.
    """

    def __init__(self, message: str, at: tuple[int, int] = (0, 0)) -> None:
        super().__init__(message)
        self.at = at
        self.data = b""


@dataclass(eq=False, slots=True)
class Source:
    """One parsed file.

    Attributes:
        path: As reached from the user's argument.
        package: Its package, outermost first; () outside packages.
        data: Its bytes.
        tree: Its syntax.
        include: The import that named it; "" for the named file.
        top: Folder that holds its topmost package, where that is not the named file's; None where it is.
    """

    path: str
    package: tuple[str, ...]
    data: bytes
    tree: ast.Module
    include: str
    _lines: list[str]
    _inner: dict[int, list[int]] = field(default_factory=dict)
    top: str | None = None

    def span(self, node: ast.AST) -> Span:
        """Where a node begins; columns count characters, where Python's count bytes."""
        line: int = getattr(node, "lineno", 0)
        column: int = getattr(node, "col_offset", 0)
        if not 0 < line <= len(self._lines):
            return Span(self.path, line)
        if line not in self._inner:
            # Bytes that begin no character, found once: a hostile file is one long line.
            text = self._lines[line - 1]
            data = b"" if text.isascii() else text.encode("utf-8", "surrogatepass")
            self._inner[line] = [at for at, byte in enumerate(data) if byte & 0xC0 == 0x80]
        return Span(self.path, line, column - bisect_left(self._inner[line], column) + 1)


@dataclass(slots=True)
class Library:
    """The files of one reading.

    Attributes:
        top: Folder that holds the topmost package.
        package: Folders from there to the named file; () when it is in no package.
        beside: The named file's folder, when that is no package of its own; None when it is.
        sources: Files read so far by path; None for one that could not be.
        named: Other files that the user names with this one.
    """

    top: str
    package: tuple[str, ...]
    beside: str | None
    sources: dict[str, Source | None] = field(default_factory=dict)
    named: tuple[str, ...] = ()
    _problems: dict[str, str] = field(default_factory=dict)
    _bytes: int = 0

    def open(self, path: str) -> Source:
        """Parse the named file.

        Raises: UnreadableError: it cannot be read or parsed.
        """
        source = parse(path, self.package, "", MAX_BYTES)
        self._bytes = len(source.data)
        self.sources[os.path.join(self.top, *self.package, os.path.basename(path))] = source
        return source

    def find(self, importer: Source, level: int, module: str) -> Source | str:
        """The file of a module, or why it is not read.

        Args:
            importer: File with the import.
            level: Dots before the module's name.
            module: Its name; "" for `from . import x`.
        """
        asked = tuple(module.split(".")) if module else ()
        if not all(part.isidentifier() for part in asked):
            return OUTSIDE
        if importer.top is not None and level:
            own = importer.package[: len(importer.package) - (level - 1)]
            return self._at(importer.top, own + asked, f"{'.' * level}{module}") if own else OUTSIDE
        for top, parts in self._places(importer, level, asked):
            if len(parts) > 1 and parts[0] in FRAMEWORKS and parts[1] not in FRAMEWORKS[parts[0]]:
                return "is the framework's own"
            found = self._at(top, parts, f"{'.' * level}{module}")
            if found is not OUTSIDE:
                return found
        for top, parts in self._namespace(asked) if not level else ():
            found = self._at(top, parts, module, top)
            if found is not OUTSIDE:
                return found
        return OUTSIDE

    def _namespace(self, asked: tuple[str, ...]) -> Iterator[tuple[str, tuple[str, ...]]]:
        """The folder that holds the topmost package, where an import names it: it has no `__init__.py` (PEP 420)."""
        if len(asked) < 2 or asked[0].partition("_")[0] in FRAMEWORKS or asked[0] in sys.stdlib_module_names:
            return
        # The parent of a folder that is no package is no part of what was named.
        if self.package and os.path.basename(os.path.abspath(self.top or os.curdir)) == asked[0]:
            yield self.top, asked[1:]

    def fork(self, module: str) -> Source | str:
        """The file of a module of Isaac Lab's actuators, of a fork that the named file is in; or why it is not read.

        Isaac Lab's repository has its packages in folders beside each other, of which `isaaclab_assets` has the robots.

        Args:
            module: `isaaclab.actuators`, or a module in it.
        """
        parts = tuple(module.split("."))
        name = next((name for name in _ACTUATORS if f"{module}.".startswith(f"{name}.")), None)
        if name is None or not all(part.isidentifier() for part in parts):
            return OUTSIDE
        folder = name.removesuffix(".actuators")
        for above in range(1, _BESIDE + 1):
            top = os.path.normpath(os.path.join(self.top, *[os.pardir] * above, folder))
            if os.path.isdir(os.path.join(top, *name.split("."))):
                return self._at(top, parts, module, top)
        return OUTSIDE

    def defining(self, module: str, name: str) -> Source | None:
        """The one other named file that defines a name, or is the module of that name; None where that is not one.

        Args:
            module: The module that it is imported from, which is not read.
            name: The name.
        """
        root, _, rest = module.partition(".")
        of_framework = root in FRAMEWORKS and not rest.startswith("isaac.lab_")
        if of_framework or root in sys.stdlib_module_names:
            return None
        include = f"{module}.{name}"
        read = [self._of_another_tree(path, include) for path in self.named]
        others = [source for source in read if source is not None]
        found = [source for source in others if name in definitions(source.tree.body)]
        found = found or [one for one in others if os.path.basename(one.path) == f"{name}.py"]
        return found[0] if len(found) == 1 else None

    def _of_another_tree(self, path: str, include: str) -> Source | None:
        """A named file, in its own packages."""
        if path not in self.sources and len(self.sources) < MAX_FILES:
            own = open_library(path)
            try:
                source = parse(path, own.package, include, MAX_TREE_BYTES - self._bytes)
                source.top = own.top
                self._bytes += len(source.data)
                self.sources[path] = source
            except UnreadableError:
                # It is told where that file is read itself.
                self.sources[path] = None
        return self.sources.get(path)

    def _at(self, top: str, parts: tuple[str, ...], include: str, root: str | None = None) -> Source | str:
        """The file of a module below a folder, which is within `root` too where that is given."""
        base = os.path.join(top, *parts)
        for path in (os.path.join(base, "__init__.py"), f"{base}.py" if parts else ""):
            if path and os.path.isfile(path):
                package = parts if path.endswith("__init__.py") else parts[:-1]
                return self._read(path, package, include, top, root)
        return OUTSIDE

    def _places(
        self, importer: Source, level: int, asked: tuple[str, ...]
    ) -> Iterator[tuple[str, tuple[str, ...]]]:
        """Folders and paths below them where a module may be, the likeliest first."""
        own = importer.package
        if level:
            if level - 1 <= max(len(own) - 1, 0):
                yield self.top, own[: len(own) - (level - 1)] + asked
            return
        if asked[:1] == self.package[:1] and asked:
            yield self.top, asked
        elif self.beside is not None:
            yield self.beside, asked
        if not asked or asked[0].partition("_")[0] in FRAMEWORKS or asked[0] in sys.stdlib_module_names:
            return
        # A program may be started in any folder of the tree.
        for count in range(len(own), 0, -1):
            yield importer.top or self.top, own[:count] + asked
        if self.beside is not None:
            # `robot.gains` of a file in `robot`, whose parent is no part of the tree.
            folders = tuple(os.path.abspath(self.beside).split(os.sep))
            for count in range(len(asked) - 1, 0, -1):
                if folders[-count:] == asked[:count]:
                    yield self.beside, asked[count:]

    def _read(
        self, path: str, package: tuple[str, ...], include: str, top: str, root: str | None
    ) -> Source | str:
        if path not in self.sources:
            other = top not in (self.top, self.beside)
            if not self._inside(path, top if other else root):
                return "is a link to outside this folder"
            if len(self.sources) >= MAX_FILES:
                return f"is not read, because {MAX_FILES} files are"
            try:
                own = package if other or top == self.top else ()
                source = parse(path, own, include, MAX_TREE_BYTES - self._bytes)
                source.top = top if other else None
                self._bytes += len(source.data)
                self.sources[path] = source
            except UnreadableError as err:
                self.sources[path] = None
                place = f" ({Span(os.path.basename(path), *err.at)})" if err.at[0] else ""
                self._problems[path] = f"cannot be read: {err}{place}"
        return self.sources[path] or self._problems[path]

    def _inside(self, path: str, other: str | None) -> bool:
        """Whether a file is where its path says: below the topmost package, beside the named file, or in another folder
        that its import names."""
        roots = [os.path.join(self.top, *self.package[:1])] if self.package else []
        roots += [self.beside] if self.beside is not None else []
        try:
            places = list(map(os.path.realpath, roots))
            if other is not None:
                above, name = os.path.split(os.path.abspath(other))
                places.append(os.path.join(os.path.realpath(above), name))
        except OSError:
            return False
        return leads_into(path, places)


def open_library(path: str) -> Library:
    """Find the tree that a file's imports stay in: the packages that it is in.

    Folders without an `__init__.py` at the lower end count too, as in legged_gym, whose robots have none.
    """
    folder = os.path.dirname(path)
    beside = None if _is_package(folder) else folder
    names: list[str] = []
    here = os.path.abspath(folder)
    lower = 0
    while len(names) < MAX_LEVELS:
        if not _is_package(here) and len(names) > lower:
            break
        if not _is_package(here):
            lower += 1
        here, name = os.path.split(here)
        if not name or lower > MAX_GAP:
            return Library(folder, (), folder)
        names.insert(0, name)
    if len(names) == lower:
        return Library(folder, (), folder)
    # As the user wrote it, as far as that goes.
    back = os.path.normpath(os.path.join(folder, *[".."] * len(names)))
    top = back if not os.path.isabs(folder) and os.path.abspath(back) == here else here
    return Library("" if top == "." else top, tuple(names), beside)


def _is_package(folder: str) -> bool:
    return os.path.isfile(os.path.join(folder, "__init__.py"))


def parse(path: str, package: tuple[str, ...], include: str, most: int) -> Source:
    """Read and parse one file.

    Args:
        path: Where.
        package: Its package.
        include: The import that named it.
        most: Bytes that are left for it.

    Raises: UnreadableError: it cannot be read or parsed.
    """
    try:
        data = read_regular(path, min(most, MAX_BYTES))
    except NotRegular as err:
        raise UnreadableError(f"it is {err}") from err
    except TooLarge as err:
        raise UnreadableError(f"{err.size} bytes, more than {min(most, MAX_BYTES)}") from err
    except (OSError, ValueError) as err:
        raise UnreadableError(getattr(err, "strerror", None) or str(err)) from err
    try:
        text = _decode(data)
        tree = _tree(text)
    except UnreadableError as err:
        err.data = data
        raise
    # Python's parser ends lines here, str.splitlines at form feeds too.
    return Source(path, package, data, tree, include, re.split("\r\n|\r|\n", text))


def definitions(body: Sequence[ast.stmt]) -> dict[str, ast.AST]:
    """Where each name of a file is bound at its top level, imports excepted, and of its classes as `Class.name`; the
    last place counts."""
    places: dict[str, ast.AST] = {}
    waiting = list(body)[::-1]
    while waiting:
        node = waiting.pop()
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            places[node.name] = node
        if isinstance(node, ast.ClassDef):
            places.update((f"{node.name}.{name}", place) for name, place in definitions(node.body).items())
        elif isinstance(node, ast.Assign):
            for target in node.targets:
                bound = [one for one in ast.walk(target) if isinstance(one, ast.Name)]
                places.update({one.id: node for one in bound if isinstance(one.ctx, ast.Store)})
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            places[node.target.id] = node
        elif isinstance(node, (ast.If, ast.Try, ast.With)):
            inner = [one for one in ast.iter_child_nodes(node) if isinstance(one, ast.stmt)]
            waiting.extend(inner[::-1])
    return places


def _tree(text: str) -> ast.Module:
    """The syntax of a text."""
    if "\0" in text:
        before = text[: text.index("\0")]
        place = before.count("\n") + 1, len(before) - before.rfind("\n")
        raise UnreadableError("it has a null byte", place)
    try:
        # A stranger's `"\d"` is no reason to warn our user.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return ast.parse(text)
    except SyntaxError as err:
        place = (err.lineno, max(err.offset or 0, 0)) if err.lineno else (0, 0)
        raise UnreadableError(one_line(err.msg or "syntax error"), place) from err
    except (RecursionError, MemoryError) as err:
        raise UnreadableError("its expressions are nested too deep for Python's parser") from err
    except ValueError as err:
        raise UnreadableError(one_line(str(err))) from err


def _decode(data: bytes) -> str:
    """The text of a file, in the encoding that its first two lines declare (PEP 263)."""
    marked = data.startswith(codecs.BOM_UTF8)
    encoding, named_at = "utf-8", (0, 0)
    for line in data.removeprefix(codecs.BOM_UTF8).split(b"\n", 2)[:2]:
        found = re.match(rb"[ \t\f]*#.*?coding[:=][ \t]*([-\w.]+)", line)
        if found:
            encoding = found[1].decode("ascii").replace("_", "-")
            named_at = place_of(data, data.index(line) + found.start(1))
            break
        if line.split(b"#")[0].strip():
            break
    if not _CODECS.fullmatch(encoding) or (
        marked and not re.fullmatch("utf-?8(-sig)?", encoding, re.IGNORECASE)
    ):
        raise UnreadableError(f"its encoding {encoding!r} is not one that is read", named_at)
    try:
        return codecs.decode(data.removeprefix(codecs.BOM_UTF8), encoding)
    except UnicodeDecodeError as err:
        at = err.start + len(codecs.BOM_UTF8) * marked
        message = f"it is not {encoding}, byte 0x{data[at]:02x}"
        raise UnreadableError(message, place_of(data, at)) from err
    except (LookupError, ValueError) as err:
        raise UnreadableError(f"its encoding: {one_line(str(err))}", named_at) from err
