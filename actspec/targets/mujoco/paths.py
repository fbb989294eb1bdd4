"""Paths inside the written files: assets stay where they are, edited includes are written beside.

MuJoCo looks an include up in the main file's folder first, then (with limits before 4.0) in the
including file's. So every file that itself includes something is written too, and all its includes
are named from the output folder.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

from actspec.robot.view import ModelFile
from actspec.robot.xml_edit import AppendChild, Edit, SetAttribute, escape_attribute
from actspec.robot.xml_tree import Element, XmlDocument
from actspec.targets.base import relative_path

MESH_TAGS = frozenset({"mesh", "hfield", "skin", "flexcomp"})
TEXTURE_FILES = ("file", "fileright", "fileleft", "fileup", "filedown", "filefront", "fileback")


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


def layout(document: XmlDocument, edits: Sequence[Edit], folder: str, main_name: str) -> FileLayout:
    """Decide which files are written where.

    Args:
        document: The model's files.
        edits: Edits of the plan; they decide which includes are written.
        folder: Output folder.
        main_name: Name of the main file there.
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
            includes.append(relative_path(os.path.abspath(file.path), folder))
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
    for element in document.walk("model"):
        file_name = element.get("file")
        if file_name and not os.path.isabs(file_name):
            path_edits.append(
                SetAttribute(element, "file", relative_path(os.path.join(source, file_name), folder))
            )
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
        name: relative_path(os.path.join(source, current), folder)
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


def _free(name: str, taken: set[str]) -> str:
    stem, extension = os.path.splitext(name)
    count = 2
    while name in taken:
        name, count = f"{stem}_{count}{extension}", count + 1
    return name


def _file_of(edit: Edit) -> int:
    return edit.element.file
