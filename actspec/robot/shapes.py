"""A model without the geoms that no inertia comes from, which are most of a compiler's work.

Joints, actuators and masses stay what they were, and so does every line. What MuJoCo would refuse in such
a geom or its mesh is then not noticed.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

from actspec.robot.mesh import stem
from actspec.robot.view import ModelFile
from actspec.robot.xml_tree import Element, XmlDocument

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
