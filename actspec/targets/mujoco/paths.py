"""Paths inside the written files: assets stay where they are, edited includes are written beside.

MuJoCo looks an include up in the main file's folder first, then (with limits before 4.0) in the
including file's. So every file that itself includes something is written too, and all its includes
are named from the output folder.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from actspec.files import FAULTS, leads_into, read_regular
from actspec.robot.assets import DECODED, base_name, decodes, usable_file
from actspec.robot.view import ModelFile
from actspec.robot.xml_edit import AppendChild, Edit, SetAttribute, escape_attribute
from actspec.robot.xml_tree import Element, XmlDocument
from actspec.targets.base import named_path

MESH_TAGS = frozenset({"mesh", "hfield", "skin", "flexcomp"})
TEXTURE_FILES = ("file", "fileright", "fileleft", "fileup", "filedown", "filefront", "fileback")


_PACKAGE = "package://"
_PACKAGE_NAME = re.compile(rb"<name>([^<]*)</name>")
_MOST_BYTES = 1024 * 1024
"""Chosen: a package.xml has a few kilobytes."""


@dataclass(frozen=True, slots=True)
class FileLayout:
    """Which files are written under which name, and the edits of paths in them.

    Attributes:
        names: By file of the document: its name in the output folder, or None when it stays in place.
        includes: By file of the document: the text that names it in its including file.
        edits: Edits of includes and asset folders.
    """

    names: tuple[str | None, ...]
    includes: tuple[str, ...]
    edits: tuple[Edit, ...]


def layout(
    document: XmlDocument, edits: Sequence[Edit], folder: str, main_name: str, packages: Mapping[str, str]
) -> FileLayout:
    """Decide which files are written where.

    Args:
        document: The model's files.
        edits: Edits of the plan; they decide which includes are written.
        folder: Output folder.
        main_name: Name of the main file there.
        packages: Package to its folder, as the spec has them.

    Raises: PathError: a file that stays cannot be named.
    """
    files = document.files
    source = os.path.dirname(os.path.abspath(files[0].path))
    written = {0} | {_file_of(edit) for edit in edits}
    # A file that includes another is written too: its own folder is no longer where MuJoCo looks first.
    written |= {include.element.file for include in document.includes}
    for element in document.walk("model"):
        if element.get("file"):
            written.add(element.file)
    names: list[str | None] = []
    taken: set[str] = set()
    includes: list[str] = []
    for index, file in enumerate(files):
        if index not in written:
            names.append(None)
            includes.append(named_path(os.curdir, file.path, folder))
            continue
        name = main_name if index == 0 else _free(os.path.basename(file.path), taken)
        taken.add(name)
        names.append(name)
        includes.append(name)
    path_edits: list[Edit] = [
        SetAttribute(include.element, "file", includes[include.index])
        for include in document.includes
        if include.name != includes[include.index]
    ]
    path_edits += _asset_folders(document, source, folder)
    path_edits += _packaged(document, source, packages)
    for element in document.walk("model"):
        file_name = element.get("file")
        if file_name and not os.path.isabs(file_name):
            path_edits.append(SetAttribute(element, "file", named_path(source, file_name, folder)))
    return FileLayout(tuple(names), tuple(includes), tuple(path_edits))


def written_files(
    document: XmlDocument, edited: Sequence[ModelFile], plan: FileLayout, folder: str
) -> tuple[ModelFile, ...]:
    """The model's files as they will stand: written ones in the output folder, the others in place."""
    return tuple(
        ModelFile(
            file.path if plan.names[index] is None else os.path.join(folder, str(plan.names[index])),
            "" if index == 0 else plan.includes[index],
            file.data,
        )
        for index, file in enumerate(edited)
    )


def _asset_folders(document: XmlDocument, source: str, folder: str) -> list[Edit]:
    """Point meshdir and texturedir from the output folder to where the assets are."""
    meshes = any(element.get("file") for element in document.walk(*MESH_TAGS))
    textures = any(element.get(name) for element in document.walk("texture") for name in TEXTURE_FILES)
    if not meshes and not textures:
        return []
    mesh_folder = texture_folder = ""
    compilers = document.sections("compiler")
    for element in compilers:
        both = element.get("assetdir")
        if both is not None:
            mesh_folder = texture_folder = both
        mesh_folder = element.get("meshdir", mesh_folder) or ""
        texture_folder = element.get("texturedir", texture_folder) or ""
    wanted = {
        name: named_path(source, current, folder)
        for name, current, used in (
            ("meshdir", mesh_folder, meshes),
            ("texturedir", texture_folder, textures),
        )
        if used and not os.path.isabs(current)
    }
    last: Element | None = compilers[-1] if compilers else None
    if last is not None and last.file == 0:
        return [SetAttribute(last, name, value) for name, value in wanted.items()]
    if not wanted:
        return []
    attributes = "".join(f' {name}="{escape_attribute(value)}"' for name, value in wanted.items())
    return [AppendChild(document.root, f"<compiler{attributes}/>")]


def _packaged(document: XmlDocument, source: str, packages: Mapping[str, str]) -> list[Edit]:
    """Meshes that a URDF names by package, where they are: MuJoCo has no packages."""
    edits: list[Edit] = []
    for element in document.walk("mesh"):
        found = package_file(element.get("file") or "", source, packages)
        if found is not None:
            edits.append(
                SetAttribute(
                    element, "file", named_path("", found, os.path.join(source, _mesh_folder(document)))
                )
            )
    return edits


def unresolved(
    document: XmlDocument, packages: Mapping[str, str]
) -> tuple[tuple[str, ...], Mapping[str, str]]:
    """Mesh files that are named by package and are not found.

    Returns: Those of a package that is neither the spec's nor the one around the model; and those that their package
        does not have, with the folder where they would be.
    """
    source = os.path.dirname(os.path.abspath(document.files[0].path))
    strange: list[str] = []
    absent: dict[str, str] = {}
    for element in document.walk("mesh"):
        name = element.get("file") or ""
        if not name.startswith(_PACKAGE) or package_file(name, source, packages) is not None:
            continue
        root = _package_folder(package_of(name), source, packages)
        if root is None:
            strange.append(name)
        else:
            folder = os.path.dirname(os.path.realpath(os.path.join(root, _parts(name)[1])))
            absent[name] = folder if folder.startswith(root + os.sep) else root
    return tuple(strange), absent


def not_there(document: XmlDocument) -> Mapping[str, str]:
    """Mesh files that a model names by path and that are not there, with the folder where they would be."""
    start = os.path.join(os.path.dirname(os.path.abspath(document.files[0].path)), _mesh_folder(document))
    stripped = any(element.get("strippath") == "true" for element in document.sections("compiler"))
    found: dict[str, str] = {}
    for element in document.walk("mesh"):
        name = element.get("file") or ""
        path = os.path.normpath(os.path.join(start, base_name(name) if stripped else name))
        if name and not name.startswith(_PACKAGE) and not usable_file(path):
            found[name] = os.path.dirname(path)
    return found


def unread(document: XmlDocument, packages: Mapping[str, str]) -> Mapping[str, str]:
    """Mesh files of a model that MuJoCo has no decoder for, there or not.

    Returns: By name, as the model has it, the same with another ending where such a file is there; else "".
    """
    source = os.path.dirname(os.path.abspath(document.files[0].path))
    start = os.path.join(source, _mesh_folder(document))
    found: dict[str, str] = {}
    for element in document.walk("mesh"):
        name = element.get("file") or ""
        if name and not decodes(name, element.get("content_type") or ""):
            others = (os.path.splitext(name)[0] + ending for ending in DECODED)
            there = (
                other
                for other in others
                if package_file(other, source, packages) or usable_file(os.path.join(start, other))
            )
            found[name] = next(there, "")
    return found


def packages_named(document: XmlDocument) -> frozenset[str]:
    """The packages that a model names files by."""
    names = (element.get("filename") or element.get("file") or "" for element in document.walk())
    return frozenset(package_of(name) for name in names if name.startswith(_PACKAGE))


def package_of(name: str) -> str:
    """The package that `package://NAME/path` is of."""
    return _parts(name)[0]


def _parts(name: str) -> tuple[str, str]:
    """Package and path of `package://NAME/path`; with three slashes, as example-robot-data 6.0.0 has it, the same."""
    package, _, inner = name.removeprefix(_PACKAGE).lstrip("/").partition("/")
    return package, inner


def package_file(name: str, source: str, packages: Mapping[str, str]) -> str | None:
    """The file that `package://NAME/path` is in its package; None: it is not there, or outside of it.

    The package is the one of `packages`, else the folder called NAME, or one with a `package.xml` of that name, that
    the URDF is in.

    Args:
        name: As the URDF has it.
        source: Folder of the URDF, absolute.
        packages: Package to its folder, as the spec has them.
    """
    if not name.startswith(_PACKAGE):
        return None
    package, inner = _parts(name)
    root = _package_folder(package, source, packages)
    if root is None:
        return None
    path = os.path.realpath(os.path.join(root, inner))
    return path if leads_into(path, [root]) and os.path.isfile(path) else None


def _package_folder(package: str, source: str, packages: Mapping[str, str]) -> str | None:
    """The folder of a package; None: the spec names none, and none is around the file. See `package_file`."""
    root = os.path.realpath(packages.get(package, source))
    while package not in packages and not _is_package(root, package):
        above = os.path.dirname(root)
        if above == root:
            return None
        root = above
    return root


def _is_package(folder: str, name: str) -> bool:
    if os.path.basename(folder) == name:
        return True
    try:
        text = read_regular(os.path.join(folder, "package.xml"), _MOST_BYTES)
    except FAULTS:
        return False
    found = _PACKAGE_NAME.search(text)
    return found is not None and found[1].decode("utf-8", "replace").strip() == name


def _mesh_folder(document: XmlDocument) -> str:
    folder = ""
    for element in document.sections("compiler"):
        folder = element.get("meshdir", element.get("assetdir", folder)) or ""
    return folder


def _free(name: str, taken: set[str]) -> str:
    """A name for an included file, which no other has, whatever the case, and which is that of a model."""
    stem, extension = os.path.splitext(name)
    if extension.lower() not in (".xml", ".mjcf"):
        stem, extension = name, ".xml"
        name = stem + extension
    count = 2
    while name.casefold() in {other.casefold() for other in taken}:
        name, count = f"{stem}_{count}{extension}", count + 1
    return name


def _file_of(edit: Edit) -> int:
    return edit.element.file
