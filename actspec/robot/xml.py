"""MJCF and URDF text as elements with byte offsets, includes in their place.

Positions come from expat (`xml_tree.scan`), so that `xml_edit` can change an attribute and leave every
other byte as the author wrote it.

Includes, measured with MuJoCo 3.7.0, 3.11.0, 3.14.0, 3.17.0 and 4.0.0 on files on disk:

- A relative name is looked up in the main file's folder first; if nothing is there, in the folder of
  the file that includes it (the folder where that file was found). Never in the working directory.
  Before 4.0 the second look-up fails when the main file's own path is relative; here it works, as
  in 4.0 and as with an absolute path.
- `..` is taken out of the text of the path, so `link/../b.xml` does not follow `link`, and `link` need
  not exist. A backslash separates folders on every system; case counts; `meshdir` does not.
- The included root's children take the place of the include; its attributes are dropped. An include
  with content, and an included root without children, are errors. Any root tag works in MuJoCo; here
  only `mujoco` and `mujocoinclude` do, so that no other file's content is ever shown.
- The same file twice: 4.0 refuses it everywhere. Until 3.17 it is refused when it is among the files
  that the main file itself includes up to there, or on the way from it; else it is read again. The
  test is by path, so a link to a file already included is another file. Here: as until 3.17, and
  `XmlDocument.is_repeated` tells. A cycle is refused by all.
- A URDF has no includes: MuJoCo does not look for them.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence

from actspec.diagnostics import Collector, RobotError, Span, in_quotes, listed, nearest
from actspec.files import NotRegular, TooLarge, read_regular
from actspec.robot.submodules import NOT_CHECKED_OUT, not_checked_out
from actspec.robot.view import ModelFile
from actspec.robot.xml_tree import Element, Include, Malformed, XmlDocument, scan

MOST_BYTES = 64 * 1024 * 1024
"""Chosen: all files of a model together; the largest real one known is 0.2 MB."""
MOST_ELEMENTS = 200_000
"""Elements of a model, repeated includes counted each time. Chosen: published models have at most some thousands, and
MuJoCo takes 15 s for 100 000 geoms in one body."""
MOST_FILES = 1000
"""Chosen: includes of a model, repeated and faulty ones counted each time."""
MOST_CHAIN = 64
"""Chosen: files on the way from the main file to an include."""

_SECTIONS = (
    "asset actuator body compiler contact custom default equality keyframe sensor tendon visual worldbody"
)
_ROOTS = frozenset(("mujoco", "mujocoinclude", *_SECTIONS.split()))
"""Of an included file. MuJoCo takes any away and keeps what is in it; here the root tells an MJCF from other files, or
that everything in it is of `_IN_ROOTS`."""
_OTHERS = "deformable extension include option size statistic material mesh texture"
_IN_BODIES = "attach camera composite flexcomp frame freejoint geom inertial joint light replicate site"
_IN_SECTIONS = (
    "adhesion connect cylinder damper dcmotor exclude fixed general intvelocity key motor muscle pair plugin position"
    " spatial velocity weld"
)
_IN_ROOTS = frozenset(f"{_SECTIONS} {_OTHERS} {_IN_BODIES} {_IN_SECTIONS}".split())
"""What an included file may begin with: it is put into the whole, its assets, a body or another section."""
_MODELS = frozenset(("mujoco", "robot"))
"""Roots of an attached model."""

NOT_FOLLOWED = frozenset(("ROBOT002", "ROBOT006", "ROBOT007", "ROBOT008", NOT_CHECKED_OUT))
"""Codes of models of which a file is not read; nothing else of them is."""


def open_document(path: str) -> XmlDocument:
    """Read a model's files from disk and parse them, each once.

    Args:
        path: The main file.

    Raises: RobotError: a file cannot be read, is not well-formed, or is not fit to be included.
    """
    main = read_main(path)
    archive = path.lower().endswith(".usdz") and main.data.startswith(b"PK")
    if archive or main.data.startswith((b"#usda ", b"PXR-USDC")):
        help = "name the MJCF or URDF that it was made of; or write `model: none`, and the `joints`"
        raise RobotError.of(
            "ROBOT104", "this is a USD, which is not read as a robot's model", Span(path, 1, 1), help=help
        )
    return _assemble(main, on_disk)


def read_main(path: str) -> ModelFile:
    """Read a model's main file from disk, unparsed.

    Raises: RobotError: it cannot be read.
    """
    try:
        return ModelFile(path, "", read_file(path, MOST_BYTES))
    except Unreadable as err:
        raise RobotError.of("ROBOT001", f"{err}", Span(path)) from err


def attached_document(file: ModelFile, site: Span) -> XmlDocument:
    """Parse a model that another attaches, with what it includes.

    Args:
        file: As `on_disk` finds it.
        site: Where it is attached.

    Raises: RobotError: as `open_document`; nothing of a file that is no model is shown.
    """
    return _assemble(file, on_disk, site)


def on_disk(main: str, including: str, name: str) -> ModelFile:
    """The file that an include, or an attached model, names.

    Raises: Unreadable: it is not there, or cannot be read.
    """
    candidates = candidates_for(main, including, name)
    for candidate in candidates:
        try:
            return ModelFile(candidate, name, read_file(candidate, MOST_BYTES))
        except Missing:
            continue
    for candidate in candidates:
        absent = not_checked_out(including, candidate)
        if absent is not None:
            raise NotCheckedOut(str(absent), absent.help)
    folder = _missing_folder(main, including, name)
    if folder is not None:
        # Of many files in it that is said once.
        raise Missing(
            f"there is no folder {in_quotes(folder)}", tried(folder, candidates_for(main, including, folder))
        )
    raise Missing(f"there is no file {in_quotes(name)}", tried(name, candidates))


def _missing_folder(main: str, including: str, name: str) -> str | None:
    """The outermost folder of a file's name that is in no place where it is looked for; None: all are there."""
    parts = name.replace("\\", "/").split("/")[:-1]
    for count in range(1, len(parts) + 1):
        folder = "/".join(parts[:count])
        places = candidates_for(main, including, folder or "/")
        if not any(map(os.path.isdir, places)):
            # Nobody looks for a drive of another system, or in a file.
            return None if ":" in folder or any(map(os.path.lexists, places)) else folder
    return None


def parse_document(files: Sequence[ModelFile]) -> XmlDocument:
    """Parse a model's files.

    Args:
        files: As `open_document` reads them, or with the same includes and other bytes.

    Raises:
        RobotError: a file is not UTF-8, not well-formed, holds a DOCTYPE that may define, is too large or deep, or is
            not fit to be included.
        ValueError: the files are not those that the includes name.
    """
    rest = iter(files[1:])

    def find(main: str, including: str, name: str) -> ModelFile:
        file = next(rest, None)
        if file is None or file.include != name:
            raise ValueError(f"{including} includes {name!r}, the files have {file and file.include!r}")
        return file

    document = _assemble(files[0], find)
    if next(rest, None) is not None:
        raise ValueError("more files than includes")
    return document


_Find = Callable[[str, str, str], ModelFile]
"""(path of the main file, path of the including file, name) to the included file."""


def _assemble(main: ModelFile, find: _Find, site: Span | None = None) -> XmlDocument:
    """Parse the main file and all that it includes, and put the includes in their places.

    Args:
        main: The file.
        find: Gives what it includes.
        site: Where another model attaches it; None: none does.
    """
    assembly = _Assembly(main.path, find)
    root = assembly.add(main, site, (), 0)
    assembly.out.raise_if_failed(RobotError)
    assert root is not None
    return XmlDocument(tuple(assembly.files), root, tuple(assembly.includes))


class _Assembly:
    """The work of `_assemble`: what has been read so far."""

    def __init__(self, main: str, find: _Find) -> None:
        self.main = main
        self.find = find
        self.out = Collector()
        self.files: list[ModelFile] = []
        self.includes: list[Include] = []
        self._bytes = 0
        self._elements = 0
        self._sites = 0
        self._direct: set[str] = set()
        self._top: Span | None = None

    def add(self, file: ModelFile, site: Span | None, chain: tuple[str, ...], depth: int) -> Element | None:
        """Add a file with its includes.

        Args:
            file: To be parsed.
            site: Where it is included, or attached; None for a main file that the user names.
            chain: Paths from the main file to the including one.
            depth: Elements that its root is inside of.

        Returns: Its root; None after an error, which has been collected.
        """
        index = len(self.files)
        roots = _ROOTS if chain else _MODELS
        self.files.append(file)
        self._bytes += len(file.data)
        if self._bytes > MOST_BYTES:
            limit = f"the model's files are larger than {MOST_BYTES >> 20} MiB together"
            raise RobotError.of("ROBOT002", limit, site or Span(file.path))
        try:
            elements = scan(file, index, depth, self._elements, MOST_ELEMENTS)
        except Malformed as err:
            if site is not None and err.diagnostic.code == "ROBOT004" and err.root not in roots:
                self._no_model(file, site, chain)
            else:
                self.out.add(err.diagnostic)
            return None
        root = elements[0]
        self._elements += len(elements)
        sections = bool(chain and root.children) and all(child.tag in _IN_ROOTS for child in root.children)
        if site is not None and root.tag not in roots and not sections:
            self._no_model(file, site, chain)
            return None
        if chain and len(elements) == 1:
            self.out.error(
                "ROBOT008", f"the included file {in_quotes(file.include)} has no elements", span=site
            )
            return None
        included, chain = bool(chain), (*chain, os.path.normpath(file.path))
        if b"<include" in file.data and (included or root.tag == "mujoco"):
            for parent, element, inside in _includes(root, depth):
                at = parent.children.index(element)
                parent.children[at : at + 1] = self._include(element, index, chain, inside)
        return root

    def _no_model(self, file: ModelFile, site: Span, chain: tuple[str, ...]) -> None:
        # Nothing of the file is shown: it may be any file of this machine.
        message = f"the included file {in_quotes(file.include)} is not an MJCF file"
        help = "an included file is XML with the root <mujocoinclude> or <mujoco>, or with elements of MJCF alone"
        if not chain:
            message = f"the attached model {in_quotes(file.include)} is not an MJCF or URDF file"
            help = "an attached model is XML with the root <mujoco> or <robot>"
        self.out.error("ROBOT008", message, span=site, help=help)

    def _include(self, element: Element, index: int, chain: tuple[str, ...], depth: int) -> list[Element]:
        """Elements that take the place of an include; none after an error."""
        file = self.files[index]
        site = Span(file.path, element.line, element.column)
        if len(chain) == 1:
            self._top = site
        self._sites += 1
        if self._sites > MOST_FILES or len(chain) > MOST_CHAIN:
            raise RobotError.of(
                "ROBOT002", f"more than {MOST_FILES} includes, or {MOST_CHAIN} in a chain", site
            )
        name = element.get("file")
        if not name:
            self.out.error("ROBOT006", "an include without a file", span=site, help='write file="..."')
            return []
        # Of `<include/>` nothing is left here, of `<include></include>` the end tag is taken away.
        if file.data[element.open_end : element.end].rpartition(b"</")[0].strip():
            self.out.error("ROBOT006", "an include cannot have content", span=site)
            return []
        try:
            included = self.find(self.main, file.path, name)
        except Unreadable as err:
            self.out.error(err.code, f"the include cannot be followed: {err}", span=site, help=err.help)
            return []
        path = os.path.normpath(included.path)
        if path in chain:
            names = " -> ".join((*chain[chain.index(path) :], path))
            self.out.error("ROBOT007", f"the includes go in a circle: {names}", span=site)
            return []
        key = candidates_for(self.main, self.main, name)[0]
        if key in self._direct:
            # The file in the way may be whole; the main one includes both.
            again = f", and {in_quotes(file.include)} includes it again" if len(chain) > 1 else ""
            message = f"{in_quotes(name)} is included already{again}, which MuJoCo refuses"
            self.out.error("ROBOT007", message, span=self._top, help="include a file once")
            return []
        if len(chain) == 1:
            self._direct.add(key)
        element.children.clear()
        index = len(self.files)
        before = len(self.includes)
        root = self.add(included, site, chain, depth)
        if root is None:
            return []
        self.includes.insert(before, Include(element, name, index, root))
        return root.children


def _includes(root: Element, depth: int) -> list[tuple[Element, Element, int]]:
    """Includes of a file in document order, each with its parent and the elements round its root's place."""
    found = []
    stack = [(root, depth)]
    while stack:
        element, inside = stack.pop()
        for child in reversed(element.children):
            if child.tag == "include":
                found.append((element, child, inside))
            stack.append((child, inside + 1))
    return sorted(found, key=lambda item: item[1].start)


class Unreadable(Exception):
    """A file cannot be read; the text says why, `help` what to do, and `code` is of what names it."""

    code = "ROBOT006"

    def __init__(self, message: str, help: str | None = None) -> None:
        super().__init__(message)
        self.help = help


class Missing(Unreadable):
    """There is no such file."""


class NotCheckedOut(Missing):
    """It is in a git submodule, or a clone, without its files."""

    code = NOT_CHECKED_OUT


def read_file(path: str, most: int) -> bytes:
    """Read a file of a model.

    Raises:
        Missing: there is no such file.
        Unreadable: it is no regular file, larger than `most` bytes, or cannot be opened.
    """
    try:
        return read_regular(path, most)
    except NotRegular as err:
        raise Unreadable(f"{in_quotes(path)} is {err}") from err
    except TooLarge as err:
        raise Unreadable(f"{in_quotes(path)} is larger than {most >> 20} MiB") from err
    except (FileNotFoundError, NotADirectoryError) as err:
        raise Missing(f"there is no file {in_quotes(path)}") from err
    except (OSError, ValueError) as err:
        reason = getattr(err, "strerror", None) or "bad path"
        raise Unreadable(f"{in_quotes(path)} cannot be read: {reason}") from err


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
        text += "; an absolute path works on one machine only"
    for candidate in candidates:
        folder, last = os.path.split(candidate)
        try:
            near = nearest(last, sorted(os.listdir(folder or ".")))
        except (OSError, ValueError):
            continue
        if near is not None:
            return f"{text}; did you mean {in_quotes(near)}?"
    return text
