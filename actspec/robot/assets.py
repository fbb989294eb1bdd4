"""Files that a model names: meshes and the inertia that comes from them, stand-ins, shapes that can be left out.

Source of the stand-ins: MuJoCo 3.7, 3.11 and 4.0, measured: file formats by extension (OBJ, STL, MSH, PNG, SKN).
"""

from __future__ import annotations

import os
import re
import struct
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import RobotError, in_quotes, listed, one_line
from actspec.robot.view import ModelFile
from actspec.robot.xml_reasons import LFS_POINTER
from actspec.robot.xml_tree import Element, XmlDocument

if TYPE_CHECKING:
    import mujoco


DECODED = (".obj", ".stl", ".OBJ", ".STL")
"""Endings of mesh files that MuJoCo reads, beside its own; see `decodes`."""
_MSH = "model/vnd.mujoco.msh"
STAND_IN = ".stand-in.obj"
"""Ending that the name of a mesh file which MuJoCo cannot read has in a spec, where an OBJ stands in for it."""

_MOST_POINTER = 1024
"""Bytes of a pointer of Git LFS. Source: its specification."""
MOST_MESH_BYTES = 256 * 1024 * 1024
"""Chosen: a mesh file above this is not opened for the inertia."""


@dataclass(frozen=True, slots=True)
class MeshDependence:
    """Moving bodies whose mass comes from mesh files.

    Attributes:
        body: The first, in words.
        bodies: The bodies, in the model's order; they live as long as their spec.
        missing: Mesh files that they need and that are not there, by their names in the spec; those that MuJoCo
            cannot read never are. Empty: all are there.
        total: Whether the file scales all masses to a total, so that every body depends on them.
        pointers: Whether one of those that are missing is kept by Git LFS, which has left a pointer in its place.
    """

    body: str
    bodies: tuple[mujoco.MjsBody, ...]
    missing: tuple[str, ...]
    total: bool
    pointers: bool = False

    @property
    def reason(self) -> str:
        """Why the inertia is unknown where a mesh file is missing."""
        away = "that are pointers of Git LFS" if self.pointers else "that are not there"
        why = [away] * (len(self._unread) < len(self.missing))
        endings = sorted({os.path.splitext(name)[1] or "no ending" for name in self._unread})
        why += [f"that MuJoCo cannot read ({listed(map(one_line, endings))})"] * bool(endings)
        return f"the mass of {self.body} comes from mesh files {' or '.join(why)}"

    @property
    def remedy(self) -> str:
        """What to do where a mesh file is missing."""
        if self._unread:
            return (
                "state masses and inertias in the model, or name meshes in it that MuJoCo reads (.obj, .stl)"
            )
        if self.pointers:
            return "fetch the meshes: `git lfs pull`"
        return "put the meshes beside the model, or state masses and inertias in it"

    @property
    def _unread(self) -> tuple[str, ...]:
        return tuple(name.removesuffix(STAND_IN) for name in self.missing if name.endswith(STAND_IN))


def mesh_dependence(spec: mujoco.MjSpec, *, written: bool = False) -> MeshDependence | None:
    """Say whether the inertia of a moving body comes from mesh files.

    What only slides, or is a loose object, is known by the masses that its geoms state, whatever shape the meshes have.

    Args:
        spec: From `open_spec`, not yet compiled.
        written: Whether centre and inertia of each body are to be written, so that those count too.

    Returns: Such bodies; None when meshes do not matter.
    """
    import mujoco

    meshes = {mesh.name or stem(mesh.file): mesh for mesh in spec.meshes if mesh.file}
    if not meshes:
        return None
    bodies = []
    missing: dict[str, str] = {}
    shapes = written or spec.compiler.settotalmass > 0.0 or any(tendon.armature for tendon in spec.tendons)
    stack = [(body, False, shapes) for body in reversed(list(spec.worldbody.bodies))]
    while stack:
        body, moving, turning = stack.pop()
        moving = moving or len(body.joints) > 0
        turning = turning or (_turns(body) and not _is_loose(body))
        stack.extend((child, moving, turning) for child in reversed(list(body.bodies)))
        if not moving:
            continue
        mode = int(body.compiler.inertiafromgeom)
        if mode == int(mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE):
            continue
        if mode == int(mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO) and body.explicitinertial:
            continue
        groups = body.compiler.inertiagrouprange
        weighed = False
        for geom in body.geoms:
            mesh = meshes.get(geom.meshname) if geom.meshname else None
            # NaN mass: not given, so the density decides.
            massless = geom.mass == 0 or (geom.mass != geom.mass and geom.density == 0)
            if mesh is None or massless or not groups[0] <= geom.group <= groups[1]:
                continue
            if not turning and geom.mass == geom.mass:
                continue
            weighed = True
            if not usable_file(path := mesh_path(spec, mesh)):
                missing.setdefault(mesh.file, path)
        if weighed:
            bodies.append(body)
    if not bodies:
        return None
    pointers = any(map(_is_pointer, missing.values()))
    return MeshDependence(
        _in_words(bodies[0]), tuple(bodies), tuple(missing), spec.compiler.settotalmass > 0.0, pointers
    )


def _turns(body: mujoco.MjsBody) -> bool:
    import mujoco

    return any(joint.type != mujoco.mjtJoint.mjJNT_SLIDE for joint in body.joints)


def _is_loose(body: mujoco.MjsBody) -> bool:
    """Whether a body has a free joint, and nothing in it has another: no hinge or slide feels its inertia."""
    import mujoco

    joints = [*body.joints, *(joint for child in body.find_all("body") for joint in child.joints)]
    return [joint.type for joint in joints] == [mujoco.mjtJoint.mjJNT_FREE]


def _in_words(body: mujoco.MjsBody) -> str:
    """A body by its name, else by a joint that it has."""
    if body.name:
        return f"body {in_quotes(body.name)}"
    joint = next((joint.name for joint in body.joints if joint.name), None)
    return f"the body of joint {in_quotes(joint)}" if joint else "a body without a name"


def give_placeholder_masses(meshes: MeshDependence) -> None:
    """Give the bodies of a spec that is to be compiled without their meshes 1 kg and 1 kg*m^2.

    The stand-ins weigh tons, and what does not depend on them would lose digits beside them.
    """
    for body in meshes.bodies:
        if not body.explicitinertial:
            body.mass, body.inertia, body.ipos, body.explicitinertial = 1.0, (1.0, 1.0, 1.0), (0, 0, 0), True


def unknown_inertia(model: mujoco.MjModel, meshes: MeshDependence | None) -> frozenset[int]:
    """Degrees of freedom whose inertia, with the others held or free, depends on mesh files that are not there.

    They are in one kinematic tree with a body that takes its mass from a mesh: the mass matrix has no other
    coupling, unless a tendon with armature couples trees.

    Args:
        model: Compiled, with stand-ins.
        meshes: Of its spec; None: no mass comes from meshes.
    """
    if meshes is None or not meshes.missing:
        return frozenset()
    trees = model.dof_treeid.tolist()
    if meshes.total or model.tendon_armature.any():
        return frozenset(range(model.nv))
    shaken = {model.body_treeid[body.id] for body in meshes.bodies}
    return frozenset(dof for dof, tree in enumerate(trees) if tree in shaken)


def need_meshes(spec: mujoco.MjSpec) -> None:
    """Stop where the inertia of a moving body comes from mesh files that are not there.

    Raises: RobotError: it does.
    """
    meshes = mesh_dependence(spec)
    if meshes is not None and meshes.missing:
        raise RobotError.of(
            "SYS001",
            f"link inertia is unknown: {meshes.reason}",
            where="robot.model",
            help=meshes.remedy,
        )


def mesh_path(spec: mujoco.MjSpec, mesh: Any) -> str:
    """Where MuJoCo looks for a mesh file of a spec that `open_spec` opened."""
    name = base_name(mesh.file) if spec.strippath else mesh.file
    try:
        folder = spec.modelfiledir
    except UnicodeDecodeError as err:
        folder = os.fsdecode(err.object)
    return os.path.join(folder, mesh.compiler.meshdir, name)


def decodes(name: str, content_type: str = "") -> bool:
    """Whether MuJoCo reads a mesh file, which its ending decides: no COLLADA (`.dae`), for one.

    Source: MuJoCo 3.7.0, 3.11.0 and 4.0.0, measured: .msh in any case, .obj and .stl where all letters are of one;
    "no decoder found" for all others, but for the content type of an MSH.
    """
    ending = os.path.splitext(name)[1]
    return ending in DECODED or ending.lower() == ".msh" or content_type == _MSH


def usable_file(path: str) -> bool:
    """Whether a path is a regular file (no device, no pipe) of a size that can be read, and no pointer of Git LFS."""
    try:
        readable = os.path.isfile(path) and os.path.getsize(path) <= MOST_MESH_BYTES
    except (OSError, ValueError):
        return False
    return readable and not _is_pointer(path)


def _is_pointer(path: str) -> bool:
    """Whether Git LFS has the file: what is here has its checksum, and no mesh."""
    try:
        if not os.path.isfile(path) or os.path.getsize(path) > _MOST_POINTER:
            return False
        with open(path, "rb") as file:
            return file.read(len(LFS_POINTER)) == LFS_POINTER
    except (OSError, ValueError):
        return False


def base_name(name: str) -> str:
    """The last part of a path, separated by a slash or a backslash."""
    return re.split(r"[/\\]", name)[-1]


def stem(name: str) -> str:
    """The base name without its ending."""
    return os.path.splitext(base_name(name))[0]


_CORNERS = ((0.0, 0.0, 0.0), (10.0, 0.0, 0.0), (0.0, 10.0, 0.0), (0.0, 0.0, 10.0))
"""A tetrahedron [m]; large, so that a small `scale` does not take its mass below MuJoCo's least."""
_FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))


def stand_in(kind: str, name: str, *, content_type: str = "", grid: tuple[int, int] = (1, 1)) -> bytes:
    """The least bytes that MuJoCo takes for an asset file.

    Args:
        kind: `mesh`, `texture`, `hfield` or `skin`.
        name: File name; its extension decides on the format.
        content_type: MIME type of the element, which goes before the extension, but for one that a mesh may have.
        grid: Rows and columns of a texture's grid.
    """
    if kind == "texture":
        return _png(grid[1], grid[0])
    if kind == "skin":
        return _skin()
    ending = os.path.splitext(name)[1].lstrip(".")
    form = ending if kind == "mesh" and decodes(name) else content_type.rpartition("/")[2] or ending
    if kind == "hfield":
        return _png(2, 2) if form.lower() == "png" else struct.pack("<2i4f", 2, 2, 0, 0, 0, 1)
    return _mesh(form.lower())


@lru_cache(maxsize=8)
def _mesh(form: str) -> bytes:
    if form == "stl":
        facets = (
            struct.pack("<12fH", 0, 0, 0, *(c for corner in face for c in _CORNERS[corner]), 0)
            for face in _FACES
        )
        return bytes(80) + struct.pack("<I", len(_FACES)) + b"".join(facets)
    if form in ("msh", "vnd.mujoco.msh"):
        numbers = struct.pack("<4i", len(_CORNERS), 0, 0, len(_FACES))
        corners = b"".join(struct.pack("<3f", *corner) for corner in _CORNERS)
        return numbers + corners + b"".join(struct.pack("<3i", *face) for face in _FACES)
    lines = [f"v {x} {y} {z}" for x, y, z in _CORNERS]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in _FACES]
    return ("\n".join(lines) + "\n").encode("ascii")


@lru_cache(maxsize=8)
def _png(width: int, height: int) -> bytes:
    # Shades differ: MuJoCo refuses a height field without height.
    rows = b"".join(
        b"\0" + bytes(255 * (row == 0) for _ in range(3 * width)) for row in range(max(height, 1))
    )

    def chunk(tag: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + tag + data + struct.pack(">I", zlib.crc32(tag + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    parts = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + parts


def _skin() -> bytes:
    """Three vertices on one bone, the world."""
    bone = b"world".ljust(40, b"\0") + struct.pack("<3f4f", 0, 0, 0, 1, 0, 0, 0)
    return (
        struct.pack("<4i", 3, 0, 1, 1)
        + struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
        + struct.pack("<3i", 0, 1, 2)
        + bone
        + struct.pack("<i3i3f", 3, 0, 1, 2, 1, 1, 1)
    )


_SHAPES = ("geom", "visual", "collision")
_HOLDERS = ("body", "link")
_NAMING = {
    name: re.compile(name.encode() + rb"""[12]?\s*=\s*["']([^"']*)["']""")
    for name in ("geom", "objname", "refname", "mesh", "hfield", "material", "texture")
}
"""Attributes that may name a geom or an asset."""
_BLANKS = bytes(byte if byte in b"\r\n" else 0x20 for byte in range(256))
_OF_GEOMS = ("geom", "objname", "refname")
_ASSETS = (("mesh", "hfield", "material"), ("texture",))
"""Tags of assets, which are also the attributes that name them; materials name textures."""


def without_shapes(document: XmlDocument) -> tuple[ModelFile, ...]:
    """Blank the shapes of bodies that state their inertia, and the assets that nothing else names.

    They are most of a compiler's work. Joints, actuators and masses stay what they were, and so does every line;
    what MuJoCo would refuse in such a geom or its mesh is then not noticed.
    Kept are geoms that something names, and all where the file says whether inertia comes from geoms. A
    shape of a frame or a `replicate` inside a body is kept, too.

    Args:
        document: An MJCF or URDF.

    Returns: The files, in order; one that does not change is the same object.
    """
    if any(b"inertiafromgeom" in file.data for file in document.files):
        return document.files
    named = _named(document.files, _OF_GEOMS)
    shapes = _shapes(document)
    files = _blank(document.files, [e for e in shapes if e.get("name") not in named] if named else shapes)
    if files is document.files:
        return files
    assets = [element for section in document.sections("asset") for element in section.children]
    for tags in _ASSETS:
        named = _named(files, tags)
        files = _blank(files, [e for e in assets if e.tag in tags and (not named or _name(e) not in named)])
    return files


def _shapes(document: XmlDocument) -> list[Element]:
    """Shapes of the world, and of bodies and links that state their inertia."""
    found: list[Element] = []
    stack = [document.root]
    while stack:
        holder = stack.pop()
        tags = {child.tag for child in holder.children}
        if holder.tag == "worldbody" or (holder.tag in _HOLDERS and "inertial" in tags):
            found += [child for child in holder.children if child.tag in _SHAPES]
        stack += [child for child in holder.children if child.children]
    return found


def _named(files: Iterable[ModelFile], attributes: Iterable[str]) -> set[str]:
    """Values of these attributes, wherever they stand."""
    patterns = [_NAMING[attribute] for attribute in attributes]
    return {
        value.decode("utf-8", "replace")
        for file in files
        for pattern in patterns
        for value in pattern.findall(file.data)
    }


def _name(asset: Element) -> str:
    """An asset is called after its file if it has no name."""
    return asset.get("name") or stem(asset.get("file") or "")


def _blank(files: tuple[ModelFile, ...], elements: Sequence[Element]) -> tuple[ModelFile, ...]:
    """The files without these elements, at unchanged offsets and lines."""
    if not elements:
        return files
    spans: dict[int, list[tuple[int, int]]] = {}
    for element in elements:
        spans.setdefault(element.file, []).append((element.start, element.end))
    found = list(files)
    for index, places in spans.items():
        data = bytearray(files[index].data)
        for start, end in places:
            data[start:end] = data[start:end].translate(_BLANKS)
        found[index] = replace(files[index], data=bytes(data))
    return tuple(found)
