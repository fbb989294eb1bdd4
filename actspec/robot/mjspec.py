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
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Diagnostic, RobotError, Span, listed, one_line
from actspec.files import note, read_regular
from actspec.guest import at_work
from actspec.robot.assets import (
    MOST_MESH_BYTES,
    STAND_IN,
    MeshDependence,
    base_name,
    decodes,
    give_placeholder_masses,
    mesh_dependence,
    mesh_path,
    stand_in,
    stem,
    usable_file,
    without_shapes,
)
from actspec.robot.attached import key_of, opened_by
from actspec.robot.sizes import check
from actspec.robot.view import ModelFile, ModelFormat
from actspec.robot.xml import parse_document
from actspec.robot.xml_edit import SetAttribute, apply_edits
from actspec.robot.xml_tree import NUMBER, Element, XmlDocument, legible

if TYPE_CHECKING:
    import mujoco


OLDEST_MUJOCO = 3_007_000
"""mj_version() of the oldest bindings that can be read with: dcmotor and polynomial damping begin there.

Before 3.7 the number had another form, 327 for 3.2.7, which is smaller too.
"""

_USE = re.compile(r"use '(\w+)' to fix")
"""Of MuJoCo's messages: an attribute of `<compiler>`, which they do not say."""


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
    files: Sequence[ModelFile],
    *,
    format: ModelFormat,
    real_assets: bool = False,
    document: XmlDocument | None = None,
) -> mujoco.MjSpec:
    """Open a model from its files' bytes, uncompiled.

    Mesh files that MuJoCo has no decoder for (`.dae`) get `STAND_IN` appended to their name in the
    spec, and textures other than PNG the content type of a PNG, as no stand-in could serve them.

    Args:
        files: The main file, then its includes in document order.
        format: MJCF or URDF; MuJoCo tells them apart by the root tag.
        real_assets: Read mesh files from the main file's folder where they exist; other assets,
            which no number of an actuator depends on, are stand-ins in any case.
        document: The same files parsed, if the caller has it.

    Raises: RobotError: the text cannot be parsed, or MuJoCo refuses it.
    """
    import mujoco

    if mujoco.mj_version() < OLDEST_MUJOCO:
        raise RobotError.of(
            "ROBOT116",
            f"MuJoCo {mujoco.__version__} is installed, and actspec reads and checks models with 3.7 or later",
            Span(files[0].path),
            help="pip install 'mujoco>=3.7'; for an older simulator state `version` of the target",
        )
    document = document if document is not None else parse_document(files)
    if format is ModelFormat.URDF:
        document = _named_once(document)
    text = splice(document)
    folder = os.path.dirname(os.path.abspath(files[0].path))
    opened = {}
    for name, found in opened_by(document) if format is ModelFormat.MJCF else ():
        opened[name] = found if isinstance(found, bytes) else splice(found).data
    with quiet(), _engine(text.span), at_work(files[0].path):
        spec = mujoco.MjSpec.from_string(text.data.decode("utf-8"), include=opened)
        # Bytes, because its name need not be UTF-8; see `mesh_path`.
        spec.modelfiledir = os.fsencode(folder)
    spec.assets = {**opened, **_stand_ins(spec, real_assets)}
    return spec


def schema_words() -> list[str]:
    """Elements and attributes of an MJCF that the installed MuJoCo knows."""
    import mujoco

    return list(dict.fromkeys(re.findall(r"\w+", mujoco.mj_printSchema(False, False))))


def _stand_ins(spec: mujoco.MjSpec, real_assets: bool) -> dict[str, bytes]:
    found: dict[str, bytes] = {}
    for mesh in spec.meshes:
        if not mesh.file:
            continue
        path = mesh_path(spec, mesh)
        note([path])
        if not decodes(mesh.file, mesh.content_type):
            # A mesh without a name is called after its file.
            mesh.name = mesh.name or stem(mesh.file)
            mesh.file += STAND_IN
        elif real_assets and usable_file(path):
            if not _takes(path):
                _add_real(found, mesh.file, path)
            continue
        found[key_of(mesh.file)] = stand_in("mesh", mesh.file, content_type=mesh.content_type)
    for texture in spec.textures:
        names = [name for name in (texture.file, *texture.cubefiles) if name]
        grid = (int(texture.gridsize[0]), int(texture.gridsize[1])) if texture.file else (1, 1)
        if any(not name.lower().endswith(".png") for name in names):
            texture.content_type = "image/png"
        found.update((key_of(name), stand_in("texture", name, grid=grid)) for name in names)
    for hfield in spec.hfields:
        if hfield.file:
            found[key_of(hfield.file)] = stand_in("hfield", hfield.file, content_type=hfield.content_type)
    for skin in spec.skins:
        if skin.file:
            found[key_of(skin.file)] = stand_in("skin", skin.file)
    return found


def _takes(path: str) -> bool:
    """Whether MuJoCo finds a file by its path: it takes no name that is not UTF-8, and a backslash for a slash."""
    return os.name != "posix" or (
        "\\" not in path and not any("\ud800" <= letter <= "\udfff" for letter in path)
    )


def _add_real(found: dict[str, bytes], name: str, path: str) -> None:
    """Hand over a mesh file that MuJoCo does not find by its path."""
    data = read_regular(path, MOST_MESH_BYTES)
    if found.setdefault(key_of(name), data) != data:
        raise RobotError.of(
            "ROBOT126",
            f"MuJoCo finds no file in a folder of this name, and of two meshes called '{base_name(name)}' only one",
            Span(path),
            help="rename the folder, or copy the model to another one",
        )


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
        return splice(parse_document(files)).span(line) if files else None

    try:
        with quiet() as warned, _engine(place), at_work(files[0].path if files else ""):
            model = spec.compile()
    except RobotError as err:
        (item,) = err.diagnostics
        document = parse_document(files) if files else None
        if document is None or document.root.tag != "robot":
            raise
        at, help = _place_in_urdf(item, document) or item.span, _flat_inertias(item, document)
        raise RobotError((replace(item, span=at, help=help),)) from err.__cause__
    if said is not None:
        said.extend(warned)
    return model


def _place_in_urdf(item: Diagnostic, document: XmlDocument) -> Span | None:
    """Where a URDF, of which MuJoCo keeps no lines, has what is refused: a link's inertia, or a shape without size."""
    if "must be positive in geom" in item.message:
        wrong = (shape for shape in document.walk("sphere", "box", "cylinder", "capsule") if _is_flat(shape))
        found = next(wrong, None)
    else:
        links = [link for link in document.sections("link") if item.where and link.get("name") == item.where]
        inner = [element for link in links for element in link.children if element.tag == "inertial"]
        found = next(iter(inner or links), None)
    return None if found is None else document.span(found)


def _flat_inertias(item: Diagnostic, document: XmlDocument) -> str | None:
    """Help for a URDF that has inertias of nothing, with all links of which MuJoCo tells only the first."""
    import numpy as np

    if "positive eigenvalues" not in item.message:
        return None
    found = []
    for link in document.sections("link"):
        for inertia in (one for part in link.children if part.tag == "inertial" for one in part.children):
            texts = [inertia.get(name) or "" for name in _TENSOR]
            if inertia.tag == "inertia" and all(map(NUMBER.fullmatch, texts)):
                tensor = np.array(texts, dtype=float)[[[0, 1, 2], [1, 3, 4], [2, 4, 5]]]
                if np.isfinite(tensor).all() and np.linalg.eigvalsh(tensor)[0] < _LEAST_INERTIA:
                    found.append(f"{link.get('name')} (line {inertia.line})")
    every = f"links with one below {_LEAST_INERTIA:g} kg*m^2: {listed(found, 12)}; " if len(found) > 1 else ""
    return f"{every}leave `<inertial>` out of a fixed link without a mass of its own; a moving one needs its inertia"


_TENSOR = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_LEAST_INERTIA = 1e-14
"""Least eigenvalue that MuJoCo takes [kg*m^2]: its mjEPS."""


def _is_flat(shape: Element) -> bool:
    """Whether a size of a URDF's shape is not above 0."""
    texts = [shape.get(name) or "" for name in ("radius", "length", "size")]
    return any(NUMBER.fullmatch(part) and float(part) <= 0.0 for part in " ".join(texts).split())


@dataclass(frozen=True, slots=True)
class CompiledModel:
    """A model with its spec.

    Attributes:
        spec: Compiled.
        model: Of the spec.
        meshes: Bodies whose mass comes from mesh files; where one is missing they weigh 1 kg.
        ratios: Actuators with a positive number in the place of -kv, which MuJoCo takes for a damping ratio in
            a servo, and the number.
        said: MuJoCo's warnings.
    """

    spec: mujoco.MjSpec
    model: mujoco.MjModel
    meshes: MeshDependence | None
    ratios: tuple[tuple[mujoco.MjsActuator, float], ...]
    said: tuple[str, ...]


def compiled_model(document: XmlDocument, format: ModelFormat, *, shapes: bool) -> CompiledModel:
    """Compile a model, with its meshes where its masses come from them and they are there.

    Args:
        document: The model.
        format: MJCF or URDF.
        shapes: Show MuJoCo what no joint depends on, too; what does not compile without is compiled whole,
            which tells why.

    Raises: RobotError: MuJoCo refuses the model.
    """
    files = document.files if shapes else without_shapes(document)
    if files is not document.files:
        with suppress(RobotError):
            return _compiled(files, None, format)
    return _compiled(document.files, document, format)


def _compiled(files: Sequence[ModelFile], document: XmlDocument | None, format: ModelFormat) -> CompiledModel:
    if format is ModelFormat.URDF:
        spec, files = open_urdf(files)
    else:
        spec = open_spec(files, format=format, document=document)
    meshes = mesh_dependence(spec)
    if meshes is not None and not meshes.missing:
        own = document if format is ModelFormat.MJCF else None
        spec = open_spec(files, format=format, real_assets=True, document=own)
    elif meshes is not None:
        give_placeholder_masses(meshes)
    # From 3.16 on compiling may write the gain into the spec.
    ratios = tuple((one, float(one.biasprm[2])) for one in spec.actuators if one.biasprm[2] > 0.0)
    said: list[str] = []
    model = compile_spec(spec, files, said=said)
    return CompiledModel(spec, model, meshes, ratios, tuple(said))


def open_urdf(files: Sequence[ModelFile]) -> tuple[mujoco.MjSpec, Sequence[ModelFile]]:
    """Open a URDF that may give one visual several colours, which only MuJoCo refuses.

    Returns: The spec, uncompiled, and the files that it was opened from; lines stay where they are.

    Raises: RobotError: MuJoCo refuses the text.
    """
    try:
        return open_spec(files, format=ModelFormat.URDF), files
    except RobotError as err:
        if "'material'" not in err.diagnostics[0].message:
            raise
    files = _first_colours(files)
    return open_spec(files, format=ModelFormat.URDF), files


def _first_colours(files: Sequence[ModelFile]) -> tuple[ModelFile, ...]:
    """The text with every `material` but the first of its parent blanked."""
    data = files[0].data
    pieces: list[bytes] = []
    begin = 0
    for parent in parse_document(files).walk():
        for extra in [child for child in parent.children if child.tag == "material"][1:]:
            pieces += [data[begin : extra.start], b"\n" * data.count(b"\n", extra.start, extra.end)]
            begin = extra.end
    return (replace(files[0], data=b"".join((*pieces, data[begin:]))), *files[1:])


def _named_once(document: XmlDocument) -> XmlDocument:
    """A URDF whose shapes have the names that MuJoCo gives them: what it drops it prints to standard error itself.

    3.7 gives a shape without a name that of the shape before it in its link, and drops it, too.
    """
    bare = nameless_shapes(document)
    for link in document.sections("link"):
        shapes = [child for child in link.children if child.tag in _SHAPES]
        if any(shape.get("name") for shape in shapes):
            bare += [shape for shape in shapes if shape.get("name") is None]
    if not bare:
        return document
    return parse_document(apply_edits(document, [SetAttribute(shape, "name", "") for shape in bare]))


_SHAPES = ("visual", "collision")


def nameless_shapes(document: XmlDocument) -> list[Element]:
    """Shapes of a URDF that have the name of one before them: MuJoCo leaves them without one.

    Measured with MuJoCo 3.7.0 and 4.0.0: links count in the order of the text, and visuals where they are kept.
    """
    compilers = (
        part for own in document.sections("mujoco")[:1] for part in own.children if part.tag == "compiler"
    )
    kept = any(compiler.get("discardvisual") == "false" for compiler in compilers)
    seen: set[str] = set()
    found = []
    for shape in (child for link in document.sections("link") for child in link.children):
        name = shape.get("name")
        if name and shape.tag in _SHAPES[not kept :]:
            if name in seen:
                found.append(shape)
            seen.add(name)
    return found


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
    element = re.search(r"^Element '([^']*)'", text, re.MULTILINE)
    if element is not None and message.endswith("unrecognized element"):
        message += f" <{element[1]}>"
    message = _USE.sub(
        r'`<compiler \1="true"/>` mends it, in a URDF `<mujoco><compiler \1="true"/></mujoco>`', message
    )
    return RobotError.of(
        "ROBOT111",
        one_line(f"MuJoCo refuses the model: {re.sub(r'^(Error: )+', '', message) or text}"),
        place(int(found.group(1)) if found else 0),
        where=name.group(1) if name else "",
    )


@dataclass(frozen=True, slots=True)
class SplicedText:
    """One text with every include in its place.

    Attributes:
        data: The text, UTF-8, without a byte order mark.
        starts: First line of each piece in `data`, from 1, ascending.
        origins: File and its line that the piece begins with.
    """

    data: bytes
    starts: tuple[int, ...]
    origins: tuple[tuple[str, int], ...]

    def span(self, line: int) -> Span:
        """The author's line for a line of `data`; the main file for line 0."""
        index = bisect_right(self.starts, line) - 1
        path, first = self.origins[max(index, 0)]
        if line < 1:
            return Span(self.origins[0][0])
        return Span(path, first + line - self.starts[index])


def splice(document: XmlDocument) -> SplicedText:
    """Put the text of every include in the place of its element.

    MuJoCo's own in-memory includes are found by base name alone, so `a/leg.xml` and `b/leg.xml` collide, and it
    reports every error in one as "line 0".

    Args:
        document: The model's files.

    Raises: RobotError: the model states sizes beyond what is read; see `sizes`.
    """
    check(document)
    files = document.files
    pieces: list[bytes] = []
    starts: list[int] = []
    origins: list[tuple[str, int]] = []
    line = 1

    def put(index: int, begin: int, end: int) -> None:
        nonlocal line
        data = files[index].data
        piece = legible(data[begin:end].removeprefix(b"\xef\xbb\xbf")) + b"\n"
        starts.append(line)
        origins.append((files[index].path, 1 + data.count(b"\n", 0, begin)))
        pieces.append(piece)
        line += piece.count(b"\n")

    def put_file(index: int, begin: int, end: int) -> None:
        for include in document.includes:
            if include.element.file == index:
                put(index, begin, include.element.start)
                put_file(include.index, include.root.open_end, include.root.close)
                begin = include.element.end
        put(index, begin, end)

    put_file(0, 0, len(files[0].data))
    return SplicedText(b"".join(pieces), tuple(starts), tuple(origins))
