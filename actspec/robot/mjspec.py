"""The one place that opens a robot's model with the MuJoCo bindings (3.7 to 4.0).

A model is opened from bytes in memory, never from a path, so that nothing is read twice and no
file that the reader has not checked is reached. Three things are done on the way:

- Includes are spliced into one text, which keeps the author's lines: see `splice`.
- Mesh, texture, height-field and skin files are replaced by tiny stand-ins under their own
  names, so that a model compiles without them. What depends on a mesh is then meaningless:
  see `mesh_dependence`.
- MuJoCo's warnings are collected; it would print them and write MUJOCO_LOG.TXT where it runs.
  The bindings of 3.7 refuse a model that the compiler warns of; those of 3.11 and 4.0 do not.
"""

from __future__ import annotations

import os
import re
from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Diagnostic, RobotError, Severity, Span, one_line
from actspec.robot.assets import (
    MeshDependence,
    base_name,
    mesh_dependence,
    mesh_path,
    stand_in,
    stem,
    usable_file,
)
from actspec.robot.view import ModelFile, ModelFormat

if TYPE_CHECKING:
    import mujoco


__all__ = [
    "MeshDependence",
    "SplicedText",
    "compile_spec",
    "engine_error",
    "mesh_dependence",
    "open_spec",
    "quiet",
    "splice",
]

OLDEST_MUJOCO = 3_007_000
"""mj_version() of the oldest bindings that can be read with: dcmotor and polynomial damping begin there.

Before 3.7 the number had another form, 327 for 3.2.7, which is smaller too.
"""

_MESH_DECODERS = frozenset({".obj", ".stl", ".msh"})


@contextmanager
def quiet() -> Iterator[list[str]]:
    """Collect MuJoCo's warnings instead of printing and logging them.

    Yields: The warnings, in order; filled while the context is open.
    """
    import warnings

    import mujoco

    said: list[str] = []

    def hear(text: Any) -> None:
        said.append(text.decode("utf-8", "replace") if isinstance(text, bytes) else str(text))

    old = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(hear)
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                yield said
            finally:
                said.extend(str(w.message) for w in caught)
    finally:
        mujoco.set_mju_user_warning(old)


def open_spec(
    files: Sequence[ModelFile], *, format: ModelFormat, real_assets: bool = False, parsed: bool = False
) -> mujoco.MjSpec:
    """Open a model from its files' bytes, uncompiled.

    Mesh files that MuJoCo has no decoder for (`.dae`) get `.obj` appended to their name in the
    spec, and textures other than PNG the content type of a PNG, as no stand-in could serve them.

    Args:
        files: The main file, then its includes in document order.
        format: MJCF or URDF; MuJoCo tells them apart by the root tag.
        real_assets: Read mesh files from the main file's folder where they exist; other assets,
            which no number of an actuator depends on, are stand-ins in any case.
        parsed: `parse_document` has taken these very files.

    Raises: RobotError: MuJoCo refuses the text.
    """
    import mujoco

    if mujoco.mj_version() < OLDEST_MUJOCO:
        raise RobotError(
            [
                Diagnostic(
                    "ROBOT116",
                    Severity.ERROR,
                    f"MuJoCo {mujoco.__version__} is installed, and actspec reads and checks models with 3.7 or later",
                    span=Span(files[0].path),
                    help="pip install 'mujoco>=3.7'; for an older simulator state `version` of the target",
                )
            ]
        )
    text = splice(files, parsed=parsed)
    folder = os.path.dirname(os.path.abspath(files[0].path))
    opened = _opened_while_parsing(text, folder, format)
    with quiet(), _engine(text.span):
        spec = mujoco.MjSpec.from_string(text.data.decode("utf-8"), include=opened)
    spec.modelfiledir = folder
    spec.assets = {**opened, **_stand_ins(spec, real_assets)}
    return spec


def _opened_while_parsing(text: SplicedText, folder: str, format: ModelFormat) -> dict[str, bytes]:
    """What MuJoCo opens before it compiles: attached models and meshes of flexible bodies."""
    found: dict[str, bytes] = {}
    for tag, name in text.opened if format is ModelFormat.MJCF else ():
        if tag == "flexcomp":
            found[_key(name)] = stand_in("mesh", name)
            continue
        from actspec.robot.xml import read_model_files

        # An attached model is checked like the main one; MuJoCo finds it by its base name.
        # The output folder that a written path climbs out of may not exist yet.
        path = os.path.normpath(os.path.join(folder, name))
        found[_key(name)] = splice(read_model_files(path)).data
    return found


def _stand_ins(spec: mujoco.MjSpec, real_assets: bool) -> dict[str, bytes]:
    found: dict[str, bytes] = {}
    for mesh in spec.meshes:
        if not mesh.file:
            continue
        if real_assets and usable_file(mesh_path(spec, mesh)):
            continue
        if os.path.splitext(mesh.file)[1].lower() not in _MESH_DECODERS and not mesh.content_type:
            # A mesh without a name is called after its file.
            mesh.name = mesh.name or stem(mesh.file)
            mesh.file += ".obj"
        found[_key(mesh.file)] = stand_in("mesh", mesh.file, content_type=mesh.content_type)
    for texture in spec.textures:
        names = [name for name in (texture.file, *texture.cubefiles) if name]
        grid = (int(texture.gridsize[0]), int(texture.gridsize[1])) if texture.file else (1, 1)
        if any(not name.lower().endswith(".png") for name in names):
            texture.content_type = "image/png"
        found.update((_key(name), stand_in("texture", name, grid=grid)) for name in names)
    for hfield in spec.hfields:
        if hfield.file:
            found[_key(hfield.file)] = stand_in("hfield", hfield.file, content_type=hfield.content_type)
    for skin in spec.skins:
        if skin.file:
            found[_key(skin.file)] = stand_in("skin", skin.file)
    return found


def _key(name: str) -> str:
    """MuJoCo finds an asset by its base name in any case; equal keys have equal stand-ins."""
    return base_name(name).lower()


def compile_spec(
    spec: mujoco.MjSpec, files: Sequence[ModelFile] = (), *, said: list[str] | None = None
) -> mujoco.MjModel:
    """Compile a spec.

    Args:
        spec: From `open_spec`, edited or not.
        files: The files that it was opened from, to place an error in them.
        said: Collects MuJoCo's warnings.

    Raises: RobotError: MuJoCo refuses the model; at the author's line where MuJoCo knows it.
    """

    def place(line: int) -> Span | None:
        return splice(files).span(line) if files else None

    with quiet() as warned, _engine(place):
        model = spec.compile()
    if said is not None:
        said.extend(warned)
    return model


@contextmanager
def _engine(place: Callable[[int], Span | None]) -> Iterator[None]:
    """Turn an exception of the engine into a RobotError at the author's line."""
    import mujoco

    try:
        yield
    except (ValueError, RuntimeError, TypeError, MemoryError, mujoco.FatalError) as err:
        raise engine_error(err, place) from err


def engine_error(err: Exception, place: Callable[[int], Span | None]) -> RobotError:
    """What the engine said, as a diagnostic.

    Args:
        err: Exception of the bindings.
        place: Gives the author's place for a line of the text that the engine read; 0: unknown.
    """
    text = str(err) or type(err).__name__
    found = re.search(r"line (\d{1,9})", text)
    name = re.search(r"Element name '([^']*)'", text)
    lines = [part.strip() for part in re.sub(r"^(XML )?Error:\s*", "", text).splitlines() if part.strip()]
    # The second line only repeats the place, which the diagnostic has; the third is MuJoCo's own business.
    message = "; ".join(part for part in lines if not re.match(r"Element .*|The static bodies of", part))
    return RobotError(
        [
            Diagnostic(
                "ROBOT111",
                Severity.ERROR,
                one_line(f"MuJoCo refuses the model: {re.sub(r'^(Error: )+', '', message) or text}"),
                name.group(1) if name else "",
                place(int(found.group(1)) if found else 0),
            )
        ]
    )


MOST_COPIES = 100_000
"""Chosen: nested `replicate` counts beyond this exhaust the memory before MuJoCo can refuse them."""

_MARKS = (b"<include", b"<replicate", b"<flexcomp", b"<model")
"""What makes more of a file than its text."""


@dataclass(frozen=True, slots=True)
class SplicedText:
    """One text with every include in its place.

    Attributes:
        data: The text, UTF-8, without a byte order mark.
        starts: First line of each piece in `data`, from 1, ascending.
        origins: File and its line that the piece begins with.
        opened: `file` of each element that MuJoCo opens while it parses, with its tag.
    """

    data: bytes
    starts: tuple[int, ...]
    origins: tuple[tuple[str, int], ...]
    opened: tuple[tuple[str, str], ...]

    def span(self, line: int) -> Span:
        """The author's line for a line of `data`; the main file for line 0."""
        index = bisect_right(self.starts, line) - 1
        path, first = self.origins[max(index, 0)]
        if line < 1:
            return Span(self.origins[0][0])
        return Span(path, first + line - self.starts[index])


def splice(files: Sequence[ModelFile], *, parsed: bool = False) -> SplicedText:
    """Put the text of every include in the place of its element.

    MuJoCo's own in-memory includes are found by base name alone, so `a/leg.xml` and `b/leg.xml` collide, and it
    reports every error in one as "line 0".

    Args:
        files: The main file, then its includes in document order, as `read_model_files` gives them.
        parsed: `parse_document` has taken these very files, so that a plain one needs no second look.

    Raises: RobotError: a file is not UTF-8 or not well-formed, holds a DOCTYPE, has an include
        without its file, or replicates beyond `MOST_COPIES`.
    """
    if parsed and len(files) == 1 and not any(mark in files[0].data for mark in _MARKS):
        data = files[0].data.removeprefix(b"\xef\xbb\xbf") + b"\n"
        return SplicedText(data, (1,), ((files[0].path, 1),), ())
    pieces: list[bytes] = []
    starts: list[int] = []
    origins: list[tuple[str, int]] = []
    opened: list[tuple[str, str]] = []
    rest = iter(files[1:])
    line = 1

    def put(piece: bytes, path: str, first: int) -> None:
        nonlocal line
        starts.append(line)
        origins.append((path, first))
        pieces.append(piece)
        line += piece.count(b"\n")

    def put_file(file: ModelFile, whole: bool, depth: int) -> None:
        if depth > 64:
            raise _error(file.path, 0, "includes are nested more than 64 deep")
        data = file.data.removeprefix(b"\xef\xbb\xbf")
        marks = _marks(file.path, data)
        opened.extend(marks.opened)
        begin, end = (0, len(data)) if whole else marks.inner
        for at, to in marks.includes:
            put(data[begin:at] + b"\n", file.path, 1 + data.count(b"\n", 0, begin))
            included = next(rest, None)
            if included is None:
                raise _error(file.path, 1 + data.count(b"\n", 0, at), "an include has no file")
            put_file(included, False, depth + 1)
            begin = to
        put(data[begin:end] + b"\n", file.path, 1 + data.count(b"\n", 0, begin))

    put_file(files[0], True, 0)
    return SplicedText(b"".join(pieces), tuple(starts), tuple(origins), tuple(opened))


@dataclass(slots=True)
class _Marks:
    inner: tuple[int, int]
    includes: list[tuple[int, int]]
    opened: list[tuple[str, str]]


def _marks(path: str, data: bytes) -> _Marks:
    """Byte offsets of a file's root content and of its include elements."""
    from xml.parsers import expat

    parser = expat.ParserCreate("utf-8")
    marks = _Marks((0, 0), [], [])
    depth = 0
    copies = [1]
    include_at = 0
    includes = True

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth, include_at, includes
        at = parser.CurrentByteIndex
        if depth == 0:
            marks.inner = (_tag_end(data, at), 0)
            # A URDF has no includes, whatever its tags are called.
            includes = tag != "robot"
        elif tag == "include" and includes:
            include_at = at
        elif tag == "replicate":
            copies.append(copies[-1] * _count(attributes.get("count", "")))
            if copies[-1] > MOST_COPIES:
                raise _error(path, parser.CurrentLineNumber, f"more than {MOST_COPIES} copies by replicate")
        elif attributes.get("file") and tag in ("flexcomp", "model"):
            marks.opened.append((tag, attributes["file"]))
        depth += 1

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        at = parser.CurrentByteIndex
        if depth == 0:
            # A root `<mujoco/>` ends where it starts: there is nothing inside.
            marks.inner = (marks.inner[0], max(marks.inner[0], at))
        elif tag == "include" and includes:
            # At the end of `<include/>` expat stands behind it already; at that of `</include>` before it.
            closing = data.startswith(b"</include", at)
            marks.includes.append((include_at, _tag_end(data, at) if closing else at))
        elif tag == "replicate":
            copies.pop()

    def doctype(*_: object) -> None:
        raise _error(path, parser.CurrentLineNumber, "a DOCTYPE is refused")

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.StartDoctypeDeclHandler = doctype
    try:
        data.decode("utf-8")
        parser.Parse(data, True)
    except UnicodeDecodeError as err:
        place = data.count(b"\n", 0, err.start) + 1
        raise _error(path, place, "the file is not UTF-8, which is all that MuJoCo reads") from err
    except expat.ExpatError as err:
        raise _error(path, err.lineno, f"not well-formed XML: {err}") from err
    return marks


def _tag_end(data: bytes, at: int) -> int:
    """Offset after the tag that starts at `at`; a quoted `>` does not end it."""
    found = re.compile(rb"""<(?:[^<>"']|"[^"]*"|'[^']*')*>""").match(data, at)
    return found.end() if found else at


def _count(text: str) -> int:
    try:
        return max(int(text), 1)
    except ValueError:
        return 1


def _error(path: str, line: int, message: str, help: str | None = None) -> RobotError:
    return RobotError([Diagnostic("ROBOT110", Severity.ERROR, message, "", Span(path, line), help)])
